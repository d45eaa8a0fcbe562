//! Doubts: unknowns that the model could have and has not, each by its score test.

use std::collections::BTreeMap;

use super::Alternative;
use super::alternatives::{Otherwise, preferred};
use crate::adjust::{
    AdjustError, Component, Jump, Problem, Score, ScoreColumns, ScoreOptions, Scores, Solution,
    Suspect, Unit, score_tests,
};
use crate::results::{Bound, Finding, Severity};
use crate::units::with_sigma;

/// Error probability of the score tests of all doubts of a survey together.
const FAMILY_ALPHA: f64 = 3e-3;
/// Doubts that are named at the most.
const MOST_NAMED: usize = 3;
/// A doubt whose effect on every parameter stays below this many sigmas withdraws nothing.
const MATTERS_SIGMAS: f64 = 1.0;

/// An unknown that the model could have.
#[derive(Clone, Debug, PartialEq)]
pub struct Doubt {
    /// Code of its finding, as `[verdict] accept` takes it.
    pub code: String,
    /// What would be estimated, in words ("the sounder's stamps are late").
    pub what: String,
    /// Its components, in the order of its columns.
    pub components: Vec<Component>,
    /// What to do.
    pub advice: String,
    /// Estimates up to this size say nothing: noise of the column itself makes them ([`Self::beyond`]).
    pub least: f64,
    /// Chi-square up to which a significant estimate withdraws nothing ([`Self::withdrawing_beyond`]).
    pub certain: f64,
    /// Mistakes that would give its components values known beforehand, such as a sign reversed.
    pub mistakes: Vec<(Alternative, Vec<f64>)>,
}

impl Doubt {
    /// A doubt of one component.
    #[must_use]
    pub fn single(code: &str, what: &str, unit: Unit, advice: &str) -> Self {
        Self::several(code, what, vec![Component::new(code, unit)], advice)
    }

    /// A doubt of several components.
    #[must_use]
    pub fn several(code: &str, what: &str, components: Vec<Component>, advice: &str) -> Self {
        Doubt {
            code: code.to_owned(),
            what: what.to_owned(),
            components,
            advice: advice.to_owned(),
            least: 0.0,
            certain: 0.0,
            mistakes: vec![],
        }
    }

    /// The same, a finding only up to this chi-square: ties of gross errors, walkers and buoys make its tail longer than chance.
    #[must_use]
    pub fn withdrawing_beyond(self, certain: f64) -> Self {
        Self { certain, ..self }
    }

    /// The same with mistakes of a known size.
    #[must_use]
    pub fn or(self, mistakes: Vec<(Alternative, Vec<f64>)>) -> Self {
        Self { mistakes, ..self }
    }

    /// The same, heard only where an estimate is beyond this size.
    #[must_use]
    pub fn beyond(self, least: f64) -> Self {
        Self { least, ..self }
    }

    fn hears(&self, score: &Score) -> bool {
        score.estimate.iter().any(|value| value.abs() > self.least)
    }
}

/// Appends a doubt to a list; its first column among all of the list.
pub fn append(list: &mut Vec<Doubt>, doubt: Doubt) -> usize {
    let first = list.iter().map(|doubt| doubt.components.len()).sum();
    list.push(doubt);
    first
}

/// Doubts tested: those that are significant as findings, all of them as bounds.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Doubted {
    /// Significant ones, most significant first.
    pub findings: Vec<Finding>,
    /// All that could be tested.
    pub bounds: Vec<Bound>,
}

impl Doubted {
    /// The gravest finding, if one withdraws "usable".
    #[must_use]
    pub fn withdrawn(&self) -> Option<&Finding> {
        self.findings.iter().find(|finding| finding.withdraws())
    }

    /// Takes up what a survey cannot tell of its mistakes ([`preferred`]); returns the one without which it clearly fits better.
    pub fn hear(&mut self, mistakes: Vec<Finding>) -> Option<Finding> {
        let (clear, undecided): (Vec<_>, Vec<_>) = mistakes
            .into_iter()
            .partition(|finding| finding.severity == Severity::Refuses);
        self.findings.extend(undecided);
        clear.into_iter().next()
    }
}

/// The parameters sought: name and column.
pub type Sought = [(String, usize)];

/// Tests doubts at a solution. `columns` gives their derivatives per set of conditions, `misfit` the weighted squares and redundancy.
///
/// # Errors
/// Those of [`score_tests`].
pub fn test(
    (problem, solution): (&Problem, &Solution),
    doubts: &[Doubt],
    columns: &[Option<&dyn ScoreColumns>],
    sought: &Sought,
    misfit: (f64, f64),
) -> Result<Doubted, AdjustError> {
    let suspects: Vec<Suspect> = doubts
        .iter()
        .map(|doubt| Suspect {
            name: doubt.what.clone(),
            components: doubt.components.clone(),
            jumps: doubt.mistakes.iter().map(|m| m.1.clone()).collect(),
        })
        .collect();
    let options = ScoreOptions {
        family_alpha: FAMILY_ALPHA,
        most_guilty: MOST_NAMED,
        misfit,
    };
    let scores = score_tests(problem, solution, &suspects, columns, &options)?;
    Ok(worded(&scores, doubts, solution, sought))
}

fn worded(scores: &Scores, doubts: &[Doubt], solution: &Solution, sought: &Sought) -> Doubted {
    let effect = |score: &Score| effect_in_sigmas(&score.effect, solution, sought);
    let finding =
        |score: &Score| guilty(score, &doubts[score.suspect], effect(score), doubts.len());
    let bound = |score: &Score| Bound {
        code: doubts[score.suspect].code.clone(),
        estimate: figures(score, &doubts[score.suspect]),
        values: score.estimate.clone(),
        sigmas: score.sigma.clone(),
        chi_square: score.statistic,
        degrees_of_freedom: score.degrees,
        p_value: score.p_value,
        largest_effect_in_sigmas: effect(score)
            .values()
            .fold(0.0, |most, e| most.max(e.abs())),
    };
    let guilty = scores.guilty.iter();
    let heard = guilty.filter(|score| doubts[score.suspect].hears(score));
    let otherwise = mistaken(scores, doubts, |e| effect_in_sigmas(e, solution, sought));
    Doubted {
        findings: heard.map(finding).chain(preferred(otherwise)).collect(),
        bounds: scores.alone.iter().map(bound).collect(),
    }
}

/// The mistakes of a known size that these doubts have, each with what it would come to.
fn mistaken(
    scores: &Scores,
    doubts: &[Doubt],
    effect: impl Fn(&[f64]) -> BTreeMap<String, f64>,
) -> Vec<Otherwise> {
    let each = scores.alone.iter().flat_map(|score| {
        let mistakes = doubts[score.suspect].mistakes.iter();
        mistakes.zip(&score.jumps)
    });
    let one = |((alternative, _), jump): (&(Alternative, Vec<f64>), &Jump)| Otherwise {
        alternative: alternative.clone(),
        gain: jump.gain,
        moved: effect(&jump.effect),
    };
    each.map(one).collect()
}

fn effect_in_sigmas(effect: &[f64], solution: &Solution, sought: &Sought) -> BTreeMap<String, f64> {
    let one = |(name, column): &(String, usize)| {
        let sigma = solution.cofactor[(*column, *column)].sqrt();
        (sigma > 0.0).then(|| (name.clone(), effect[*column] / sigma))
    };
    sought.iter().filter_map(one).collect()
}

fn guilty(score: &Score, doubt: &Doubt, effect: BTreeMap<String, f64>, tests: usize) -> Finding {
    let matters = effect.values().any(|sigmas| sigmas.abs() > MATTERS_SIGMAS);
    let severity = if matters && score.statistic > doubt.certain {
        Severity::Withdraws
    } else {
        Severity::Finding
    };
    let seen = format!(
        "{}: {} (chi-square {:.0} on {})",
        doubt.what,
        figures(score, doubt),
        score.statistic,
        score.degrees
    );
    let threshold = format!(
        "{} % error probability for all {tests} such tests together, and an effect of {MATTERS_SIGMAS} sigma",
        100.0 * FAMILY_ALPHA
    );
    Finding::new(&doubt.code, severity, seen, threshold, doubt.advice.clone()).with_effect(effect)
}

/// One-step estimates with their sigmas in units that readers expect.
fn figures(score: &Score, doubt: &Doubt) -> String {
    let several = doubt.components.len() > 1;
    let pairs = score
        .estimate
        .iter()
        .zip(&score.sigma)
        .zip(&doubt.components);
    let parts: Vec<String> = pairs
        .filter(|((_, sigma), _)| **sigma > 0.0)
        .map(|((estimate, sigma), component)| {
            let (scale, unit) = readable(component.unit);
            let figure = format!("{} {unit}", with_sigma(scale * estimate, scale * sigma));
            if several {
                format!("{} {figure}", component.name)
            } else {
                figure
            }
        })
        .collect();
    parts.join(", ")
}

/// Factor into the unit in which findings state a quantity, and that unit.
pub(super) fn readable(unit: Unit) -> (f64, &'static str) {
    match unit {
        Unit::Radian => (180.0 / std::f64::consts::PI, "deg"),
        Unit::Metre => (1e3, "mm"),
        Unit::Second => (1e3, "ms"),
        Unit::One => (100.0, "%"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_stand_in_the_units_of_the_boat() {
        let doubt = Doubt::single(
            "latency",
            "the sounder's stamps are late",
            Unit::Second,
            "set latency = true",
        );
        let score = Score {
            suspect: 0,
            statistic: 1031.0,
            degrees: 1,
            p_value: 0.0,
            estimate: vec![0.0193],
            sigma: vec![0.0006],
            effect: vec![],
            jumps: vec![],
        };
        assert_eq!(figures(&score, &doubt), "19.30 ± 0.60 ms");
        let effect = BTreeMap::from([("yaw".to_owned(), -4.0)]);
        let finding = guilty(&score, &doubt, effect, 12);
        assert_eq!(finding.severity, Severity::Withdraws);
        assert!(
            finding.seen.contains("chi-square 1031 on 1"),
            "{}",
            finding.seen
        );
        let small = BTreeMap::from([("yaw".to_owned(), 0.4)]);
        assert_eq!(
            guilty(&score, &doubt, small, 12).severity,
            Severity::Finding
        );
        let effect = BTreeMap::from([("yaw".to_owned(), -4.0)]);
        let cautious = doubt.withdrawing_beyond(1031.0);
        let finding = guilty(&score, &cautious, effect, 12);
        assert_eq!(finding.severity, Severity::Finding);
    }
}
