//! Does the model fit? The whole, every part by itself, and every prior.

use super::VerdictConfig;
use super::doubts::readable;
use crate::adjust::{AdjustError, FitTest, PriorTest, Solution, beside_conditions};
use crate::results::{Finding, Severity};
use crate::units::with_sigma;

/// Error probability of the tests of all parts together, as the deviation of a standard normal that one of `tests` may reach.
fn critical(tests: usize) -> f64 {
    const FAMILY_ALPHA: f64 = 1e-3;
    let alpha = FAMILY_ALPHA / tests.max(1) as f64;
    crate::adjust::condition_test(alpha, 0.5).map_or(f64::INFINITY, |test| test.critical)
}

/// Redundancy below which a variance factor means nothing.
const ENOUGH: f64 = 30.0;
/// A part withdraws "usable" only beyond this many times the upper limit: a part of the residuals has more ways to be odd.
const PART: f64 = 1.6;

/// A part of the observations with its name in words ("the soundings", "pass 2", "face P3").
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Code of its finding (`noise`, `pass`, `face`).
    pub code: &'static str,
    /// Its name.
    pub name: String,
    /// Its residuals.
    pub test: FitTest,
    /// What to look at.
    pub advice: String,
    /// Whether it is judged as strictly as the whole.
    pub strict: bool,
}

/// The test of everything, and that of the chain: these sets of conditions, the priors and the chain's innovations together.
///
/// # Errors
/// Those of [`beside_conditions`].
pub fn together(
    conditions: impl Iterator<Item = FitTest> + Clone,
    solution: &Solution,
    degrees_of_freedom: f64,
) -> Result<(FitTest, FitTest), AdjustError> {
    let known: f64 = conditions.clone().map(|test| test.redundancy).sum();
    let (priors, chain) = beside_conditions(solution, degrees_of_freedom - known)?;
    let whole = conditions.fold(priors.with(chain), FitTest::with);
    Ok((whole, chain))
}

/// The whole against the limits of its variance factor.
#[must_use]
pub fn whole(test: &FitTest, config: &VerdictConfig) -> Option<Finding> {
    let (low, high) = (config.least_variance_factor, config.most_variance_factor);
    if test.redundancy < ENOUGH || test.deviation().abs() < critical(1) {
        return None;
    }
    let factor = test.factor();
    let threshold = format!("variance factor from {low} to {high}");
    let seen = |words: &str| {
        format!(
            "the residuals are {:.2} times {words} the stated noise (variance factor {factor:.2})",
            factor.sqrt()
        )
    };
    if factor > high {
        let advice = "wrong noise figures, a wrong target model, a sign or unit, or sensors that do not belong together";
        return Some(
            Finding::new(
                "variance_factor",
                Severity::Withdraws,
                seen(""),
                threshold,
                advice,
            )
            .tidied(),
        );
    }
    if factor < low {
        let severity = Severity::Finding; // sigmas that are too large mislead nobody about the mounting
        let advice = "the noise is stated larger than it is: standard deviations in the wrong unit, or merely cautious ones";
        return Some(
            Finding::new("variance_factor", severity, seen("only"), threshold, advice).tidied(),
        );
    }
    None
}

/// Parts whose residuals are beyond the limit and beyond chance, worst first.
#[must_use]
pub fn parts(parts: &[Part], config: &VerdictConfig) -> Vec<Finding> {
    let limit = critical(parts.len());
    let high = config.most_variance_factor;
    let mut odd: Vec<&Part> = parts
        .iter()
        .filter(|part| {
            part.test.redundancy >= ENOUGH
                && part.test.deviation() > limit
                && part.test.factor() > high
        })
        .collect();
    odd.sort_by(|a, b| b.test.deviation().total_cmp(&a.test.deviation()));
    odd.iter().map(|part| odd_part(part, high)).collect()
}

fn odd_part(part: &Part, high: f64) -> Finding {
    let factor = part.test.factor();
    let withdraws = part.strict || factor > PART * high;
    let severity = if withdraws {
        Severity::Withdraws
    } else {
        Severity::Finding
    };
    Finding::new(
        part.code,
        severity,
        format!(
            "{} scatter by {:.2} times the stated noise (variance factor {factor:.2}, {:.0} sigma from 1)",
            part.name,
            factor.sqrt(),
            part.test.deviation()
        ),
        format!(
            "variance factor up to {high}, {:.1} % error probability for all parts together",
            0.1
        ),
        part.advice.clone(),
    )
}

/// Priors that the data contradict, worst first.
#[must_use]
pub fn priors(tests: &[PriorTest], config: &VerdictConfig) -> Vec<Finding> {
    let mut odd: Vec<&PriorTest> = tests
        .iter()
        .filter(|test| test.normalised.abs() > config.max_prior_sigmas)
        .collect();
    odd.sort_by(|a, b| b.normalised.abs().total_cmp(&a.normalised.abs()));
    let one = |test: &&PriorTest| {
        let (scale, unit) = readable(test.unit);
        Finding::new(
            "prior",
            Severity::Withdraws,
            format!(
                "{}: the data move it by {} {unit}, {:.0} sigma from what was stated beforehand",
                test.name,
                with_sigma(scale * test.residual, scale * test.sigma),
                test.normalised.abs()
            ),
            format!("{} sigma", config.max_prior_sigmas),
            "check the stated value and its standard deviation, and what else could push it there",
        )
    };
    odd.iter().map(one).collect()
}

impl Finding {
    /// Without doubled blanks, where a word was left out.
    fn tidied(mut self) -> Self {
        self.seen = self.seen.replace("  ", " ");
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::Unit;

    fn test(factor: f64, redundancy: f64) -> FitTest {
        FitTest::plain(1000, factor * redundancy, redundancy)
    }

    #[test]
    fn the_whole_is_judged_by_size_and_by_chance() {
        let config = VerdictConfig::default();
        assert_eq!(
            whole(&test(1.1, 1e5), &config),
            None,
            "significant, and too small to matter"
        );
        assert_eq!(
            whole(&test(1.4, 25.0), &config),
            None,
            "large, and nothing but chance"
        );
        let found = whole(&test(1.4, 1e4), &config).unwrap();
        assert_eq!(found.severity, Severity::Withdraws);
        let cautious = whole(&test(0.5, 1e4), &config).unwrap();
        assert_eq!(cautious.severity, Severity::Finding);
        let without_errors = whole(&test(1e-4, 1e4), &config).unwrap();
        assert_eq!(without_errors.severity, Severity::Finding);
    }

    #[test]
    fn the_odd_part_is_named() {
        let part = |name: &str, factor| Part {
            code: "face",
            name: name.to_owned(),
            test: test(factor, 500.0),
            advice: String::new(),
            strict: false,
        };
        let found = parts(
            &[part("P1", 1.0), part("P3", 2.5), part("P2", 1.7)],
            &VerdictConfig::default(),
        );
        assert_eq!(found.len(), 2);
        assert!(found[0].seen.starts_with("P3") && found[0].severity == Severity::Withdraws);
        assert_eq!(found[1].severity, Severity::Finding);
    }

    #[test]
    fn a_contradicted_prior_is_named_with_its_sigmas() {
        let prior = PriorTest {
            name: "seat heading".to_owned(),
            unit: Unit::Radian,
            residual: -4.7_f64.to_radians(),
            sigma: 0.1_f64.to_radians(),
            normalised: -47.0,
        };
        let found = priors(&[prior], &VerdictConfig::default());
        assert!(found[0].seen.contains("seat heading") && found[0].seen.contains("47 sigma"));
        assert!(
            found[0].seen.contains("-4.70 ± 0.10 deg"),
            "{}",
            found[0].seen
        );
    }
}
