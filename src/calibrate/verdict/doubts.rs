//! Doubts: unknowns that the model could have and has not, each by its score test.

use std::collections::BTreeMap;

use super::Alternative;
use super::alternatives::{Otherwise, preferred};
use crate::adjust::{
    AdjustError, Component, Jump, Problem, Score, ScoreColumns, ScoreOptions, Scores, Solution,
    Suspect, Unit, score_tests, score_tests_of,
};
use crate::results::{Bound, Finding, Severity, largest};
use crate::units::with_sigma;
use nalgebra::{DMatrix, DVector};

/// Error probability of the score tests of all doubts of a survey together.
const FAMILY_ALPHA: f64 = 3e-3;
/// A doubt whose one sigma moves a parameter by more of its sigmas than this is one that the survey cannot tell from the parameter.
const HANGS_SIGMAS: f64 = 3.0;
/// Two doubts explain a misfit about as well where the logarithms of their p-values differ by less than this.
const RIVAL: f64 = 5.0;
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
    /// What to do where a parameter hangs on it, so that the survey cannot tell an error of it; nothing is said where this is empty.
    pub untold: String,
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
            untold: String::new(),
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

    /// The same, and where a parameter hangs on it that is said, with this advice.
    #[must_use]
    pub fn or_untold(self, advice: &str) -> Self {
        Self {
            untold: advice.to_owned(),
            ..self
        }
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

/// Roll, pitch and heading on another clock than the positions.
#[must_use]
pub fn late_attitude() -> Doubt {
    Doubt::single(
        "attitude_latency",
        "the attitude's time stamps look later than those of the positions",
        Unit::Second,
        "check that positions and attitude are stamped by one clock, and the delay of the motion sensor and of each message; an INS' own log holds both",
    )
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
    let options = options(misfit);
    let scores = score_tests(problem, solution, &suspects(doubts), columns, &options)?;
    let sigma = |column: usize| solution.cofactor[(column, column)].sqrt();
    Ok(worded(&scores, doubts, &sigma, sought))
}

/// Tests doubts of a problem that was linearised elsewhere ([`score_tests_of`]): the information and gradient of its parameters and,
/// behind them, of the doubts' columns. `sigma` gives the standard deviation of each parameter.
#[must_use]
pub fn test_of(
    (information, gradient): (&DMatrix<f64>, &DVector<f64>),
    doubts: &[Doubt],
    sigma: &dyn Fn(usize) -> f64,
    sought: &Sought,
    misfit: (f64, f64),
) -> Doubted {
    let scores = score_tests_of(information, gradient, &suspects(doubts), &options(misfit));
    worded(&scores, doubts, sigma, sought)
}

fn suspects(doubts: &[Doubt]) -> Vec<Suspect> {
    let one = |doubt: &Doubt| Suspect {
        name: doubt.what.clone(),
        components: doubt.components.clone(),
        jumps: doubt.mistakes.iter().map(|m| m.1.clone()).collect(),
    };
    doubts.iter().map(one).collect()
}

fn options(misfit: (f64, f64)) -> ScoreOptions {
    ScoreOptions {
        family_alpha: FAMILY_ALPHA,
        most_guilty: MOST_NAMED,
        misfit,
    }
}

fn worded(
    scores: &Scores,
    doubts: &[Doubt],
    sigma: &dyn Fn(usize) -> f64,
    sought: &Sought,
) -> Doubted {
    let effect = |score: &Score| effect_in_sigmas(&score.effect, sigma, sought);
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
    let otherwise = mistaken(scores, doubts, |e| effect_in_sigmas(e, sigma, sought));
    Doubted {
        findings: (found(scores, doubts, &effect).into_iter())
            .chain(preferred(otherwise))
            .chain(hanging(scores, doubts, &effect))
            .collect(),
        bounds: scores.alone.iter().map(bound).collect(),
    }
}

/// The guilty ones. Where they move nothing, those count too that explain about as well what the most significant one does.
fn found(
    scores: &Scores,
    doubts: &[Doubt],
    effect: &dyn Fn(&Score) -> BTreeMap<String, f64>,
) -> Vec<Finding> {
    let finding =
        |score: &Score| guilty(score, &doubts[score.suspect], effect(score), doubts.len());
    let guilty = scores.guilty.iter();
    // of what a parameter hangs on, only that is said ([`hanging`])
    let heard = guilty.filter(|score| {
        let doubt = &doubts[score.suspect];
        doubt.hears(score) && hangs(score, doubt, &effect(score)).is_none()
    });
    let mut all: Vec<Finding> = heard.map(&finding).collect();
    let Some(first) = scores.guilty.first() else {
        return all;
    };
    let certain = is_certain(first, &doubts[first.suspect], &effect(first));
    if certain && all.iter().all(|f| f.severity == Severity::Finding) {
        let limit = FAMILY_ALPHA / doubts.len() as f64;
        let rival = |score: &&Score| {
            score.suspect != first.suspect
                && score.p_value < limit
                && score.weight() > first.weight() - RIVAL
        };
        let rivals = scores.alone.iter().filter(rival).map(&finding);
        all.extend(rivals.filter(|f| f.severity > Severity::Finding));
    }
    all
}

/// Where a parameter hangs on a doubt: of each code the guilty one, else the most serious, and how many more there are.
fn hanging(
    scores: &Scores,
    doubts: &[Doubt],
    effect: &dyn Fn(&Score) -> BTreeMap<String, f64>,
) -> Vec<Finding> {
    let is_guilty = |score: &Score| scores.guilty.iter().any(|g| g.suspect == score.suspect);
    let one = |score: &Score| {
        let guilty = is_guilty(score);
        let found = untold(score, &doubts[score.suspect], &effect(score), guilty);
        found.map(|finding| (guilty, finding))
    };
    let mut all: Vec<(bool, Finding)> = scores.alone.iter().filter_map(one).collect();
    all.sort_by(|(guilty, a), (other, b)| {
        let grave = b.largest_effect().total_cmp(&a.largest_effect());
        other.cmp(guilty).then(grave)
    });
    let mut first: Vec<(Finding, usize)> = vec![];
    for (_, finding) in all {
        match first.iter_mut().find(|(f, _)| f.code == finding.code) {
            Some((_, more)) => *more += 1,
            None => first.push((finding, 0)),
        }
    }
    first.truncate(MOST_NAMED);
    let with_count = |(mut finding, more): (Finding, usize)| {
        if more > 0 {
            finding
                .seen
                .push_str(&format!("; so it is with {more} more of the kind"));
        }
        finding
    };
    first.into_iter().map(with_count).collect()
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

fn effect_in_sigmas(
    effect: &[f64],
    sigma: &dyn Fn(usize) -> f64,
    sought: &Sought,
) -> BTreeMap<String, f64> {
    let one = |(name, column): &(String, usize)| {
        let sigma = sigma(*column);
        (sigma > 0.0).then(|| (name.clone(), effect[*column] / sigma))
    };
    sought.iter().filter_map(one).collect()
}

fn guilty(score: &Score, doubt: &Doubt, effect: BTreeMap<String, f64>, tests: usize) -> Finding {
    let matters = effect.values().any(|sigmas| sigmas.abs() > MATTERS_SIGMAS);
    let severity = if matters && is_certain(score, doubt, &effect) {
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

/// Whether a guilty doubt may withdraw by itself; one that a parameter hangs on is judged with what hangs on it ([`untold`]).
fn is_certain(score: &Score, doubt: &Doubt, effect: &BTreeMap<String, f64>) -> bool {
    score.statistic > doubt.certain && hangs(score, doubt, effect).is_none()
}

/// By how many of their sigmas one sigma of a doubt moves the parameters, where one of them hangs on it.
fn hangs(
    score: &Score,
    doubt: &Doubt,
    effect: &BTreeMap<String, f64>,
) -> Option<BTreeMap<String, f64>> {
    let (estimate, sigma) = (score.estimate.first()?, score.sigma.first()?);
    if doubt.untold.is_empty() || *estimate == 0.0 {
        return None;
    }
    let of_sigma = |(name, moved): (&String, &f64)| (name.clone(), moved * sigma / estimate.abs());
    let moved: BTreeMap<String, f64> = effect.iter().map(of_sigma).collect();
    let hangs = moved.values().any(|sigmas| sigmas.abs() > HANGS_SIGMAS);
    hangs.then_some(moved)
}

/// A parameter that hangs on a doubt of one component: what one sigma of it would move. Of a guilty one the estimate is stated too, and
/// beyond the doubt's limit it withdraws.
fn untold(
    score: &Score,
    doubt: &Doubt,
    effect: &BTreeMap<String, f64>,
    guilty: bool,
) -> Option<Finding> {
    let (effect, sigma) = (hangs(score, doubt, effect)?, score.sigma.first()?);
    let (scale, unit) = readable(doubt.components[0].unit);
    largest(&effect).map(|(name, most)| {
        let trace = format!(
            "{:.2} {unit} of it would leave no trace and would move {name} by {:.0} sigma",
            scale * sigma,
            most
        );
        let seen = if guilty {
            format!(
                "{}: {} (chi-square {:.0} on {}), or the model lacks something else: the survey cannot tell, as {trace}",
                doubt.what,
                figures(score, doubt),
                score.statistic,
                score.degrees
            )
        } else {
            format!("the survey cannot tell whether {}: {trace}", doubt.what)
        };
        let threshold = format!("{HANGS_SIGMAS} sigma for one sigma of the suspected error");
        let (severity, advice) = if guilty && score.statistic > doubt.certain {
            (Severity::Withdraws, &doubt.advice)
        } else {
            (Severity::Finding, &doubt.untold)
        };
        Finding::new(&doubt.code, severity, seen, threshold, advice.clone())
            .with_effect(effect.clone())
    })
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

    /// A score of one component whose sigma is 1, with its effect on one parameter.
    fn score(suspect: usize, statistic: f64, effect: f64) -> Score {
        Score {
            suspect,
            statistic,
            degrees: 1,
            p_value: crate::stats::ChiSquare::new(1.0).unwrap().above(statistic),
            estimate: vec![statistic.sqrt()],
            sigma: vec![1.0],
            effect: vec![effect],
            jumps: vec![],
        }
    }

    fn said(alone: Vec<Score>, doubts: &[Doubt]) -> Vec<(String, Severity)> {
        let scores = Scores {
            guilty: vec![alone[0].clone()],
            alone,
        };
        let doubted = worded(&scores, doubts, &|_| 1.0, &[("roll".to_owned(), 0)]);
        let one = |f: Finding| (f.code, f.severity);
        doubted.findings.into_iter().map(one).collect()
    }

    /// A line's own roll that moves nothing, and a drift that explains nearly the same and moves roll by 3 sigma: the drift withdraws. Where it
    /// explains much less, or the line's roll counts by itself, or is not certain, it is not heard.
    #[test]
    fn what_explains_as_much_counts_where_the_first_moves_nothing() {
        let doubt = |code| Doubt::single(code, "", Unit::Radian, "").withdrawing_beyond(25.0);
        let doubts = [doubt("line"), doubt("drift")];
        let (light, grave) = (Severity::Finding, Severity::Withdraws);
        let of = |code: &str, severity| (code.to_owned(), severity);
        let near = said(vec![score(0, 46.0, 0.5), score(1, 45.0, 3.0)], &doubts);
        assert_eq!(near, [of("line", light), of("drift", grave)]);
        let far = said(vec![score(0, 60.0, 0.5), score(1, 45.0, 3.0)], &doubts);
        assert_eq!(far, [of("line", light)]);
        let alone = said(vec![score(0, 46.0, 2.0), score(1, 45.0, 3.0)], &doubts);
        assert_eq!(alone, [of("line", grave)]);
        let doubtful = said(vec![score(0, 24.0, 0.5), score(1, 26.0, 3.0)], &doubts);
        assert_eq!(doubtful, [of("line", light)]);
    }

    /// An innocent doubt of which one sigma moves roll by 12 of its own is said, with that figure; one that moves it by 2 is not.
    #[test]
    fn what_a_parameter_hangs_on_is_said() {
        let doubt = |code| Doubt::single(code, "", Unit::Radian, "").or_untold("sail another");
        let doubts = [doubt("guilty"), doubt("hangs"), doubt("told")];
        let alone = vec![score(0, 90.0, 5.0), score(1, 4.0, 24.0), score(2, 4.0, 4.0)];
        let scores = Scores {
            guilty: vec![alone[0].clone()],
            alone,
        };
        let doubted = worded(&scores, &doubts, &|_| 1.0, &[("roll".to_owned(), 0)]);
        let codes: Vec<&str> = doubted.findings.iter().map(|f| f.code.as_str()).collect();
        assert_eq!(codes, ["guilty", "hangs"]);
        assert!(doubted.findings[1].seen.contains("roll by 12 sigma"));
        let severities = |doubted: &Doubted| -> Vec<Severity> {
            doubted.findings.iter().map(|f| f.severity).collect()
        };
        assert_eq!(
            severities(&doubted),
            [Severity::Withdraws, Severity::Finding]
        );
        let unsure = doubts.clone().map(|doubt| doubt.withdrawing_beyond(95.0));
        let doubted = worded(&scores, &unsure, &|_| 1.0, &[("roll".to_owned(), 0)]);
        assert_eq!(severities(&doubted), [Severity::Finding; 2]);
        // a guilty one that hangs is said once, and another of its code, though more hangs on it, is counted
        let doubts = [doubt("line"), doubt("line")];
        let alone = vec![score(0, 100.0, 50.0), score(1, 4.0, 24.0)];
        let guilty_first = Scores {
            guilty: vec![alone[0].clone()],
            alone,
        };
        let doubted = worded(&guilty_first, &doubts, &|_| 1.0, &[("roll".to_owned(), 0)]);
        let seen: Vec<&str> = doubted.findings.iter().map(|f| f.seen.as_str()).collect();
        assert_eq!(seen.len(), 1, "{seen:?}");
        assert!(seen[0].contains("(chi-square 100 on 1), or the model lacks"));
        assert!(seen[0].contains("roll by 5 sigma; so it is with 1 more of the kind"));
        // by itself it withdraws nothing, however large; one that does not hang does
        let moving = |sigmas: f64| {
            let effect = BTreeMap::from([("roll".to_owned(), sigmas * 20.0)]);
            guilty(&score(0, 400.0, 0.0), &doubts[0], effect, 21).severity
        };
        assert_eq!(
            [moving(4.0), moving(2.0)],
            [Severity::Finding, Severity::Withdraws]
        );
    }
}
