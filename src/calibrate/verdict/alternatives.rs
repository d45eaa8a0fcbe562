//! Discrete mistakes: which one turns a misfit into a fit?
//!
//! Tried on a thinned set when the fit or the association fails. The best one is named with its figures; nothing is ever applied.
//! A sign that the parameters could take up altogether is tried on surveys that fit as well ([`preferred`]).

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use nalgebra::Vector3;

use crate::math;
use crate::results::{Finding, Severity, largest};

/// A beam's angle from straight below, of one that was counted from the horizontal, radians, to the same side.
#[must_use]
pub fn from_below(angle_rad: f64) -> f64 {
    (FRAC_PI_2 - angle_rad.abs()).copysign(angle_rad)
}

/// What a depth below the sounder is along a beam at this angle from straight below, radians.
#[must_use]
pub fn along_the_beam(depth: f64, angle_rad: f64) -> f64 {
    depth / math::cos(angle_rad).max(0.05)
}

/// A lever arm (right, forward, up) of one given as forward, right, down.
#[must_use]
pub fn from_forward_right_down(arm_m: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(arm_m.y, arm_m.x, -arm_m.z)
}

/// How well a survey fits under an assumption.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tried {
    /// Share of the observations that fit, 0 to 1.
    pub share: f64,
    /// Variance factor of those that fit, where it was found.
    pub variance_factor: Option<f64>,
    /// Whether the correction that comes of it is too large to be one.
    pub oversize: bool,
}

/// What an oversize correction leaves of a merit.
const OVERSIZE: f64 = 0.5;

impl Tried {
    /// What alternatives are ranked by: the share, less where those that fit scatter otherwise than stated.
    #[must_use]
    pub fn merit(&self) -> f64 {
        let factor = self.variance_factor.unwrap_or(1.0);
        let plausible = if self.oversize { OVERSIZE } else { 1.0 };
        let merit = plausible * self.share / factor.max(1.0 / factor).sqrt();
        if merit.is_finite() { merit } else { 0.0 } // nothing was left to judge
    }

    fn words(&self, what: &str) -> String {
        let factor = self
            .variance_factor
            .map_or_else(String::new, |v| format!(" (variance factor {v:.1})"));
        let oversize = if self.oversize {
            ", with a correction that is too large"
        } else {
            ""
        };
        format!(
            "{:.0} % of {what} fit{factor}{oversize}",
            100.0 * self.share
        )
    }
}

/// A mistake that is often made.
#[derive(Clone, Debug, PartialEq)]
pub struct Alternative {
    /// Code of the finding (`sign_of_roll`).
    pub code: &'static str,
    /// The mistake in words ("with the sign of roll reversed").
    pub words: String,
    /// What to do about it.
    pub advice: &'static str,
}

impl Alternative {
    /// From its parts.
    #[must_use]
    pub fn new(code: &'static str, words: impl Into<String>, advice: &'static str) -> Self {
        Self {
            code,
            words: words.into(),
            advice,
        }
    }
}

/// Merit that an alternative must gain on the survey as given, as a factor.
const BETTER: f64 = 1.3;
/// Share that must fit under an alternative for it to be named.
const FITS: f64 = 0.6;

/// Variance factor of a survey as given that an alternative can mend, and the largest one that it may leave.
const BROKEN: f64 = 1.15;
const MENDED: f64 = 1.1;
/// Share that an alternative that mends the variance factor may lose.
const LOST: f64 = 0.02;

impl Tried {
    /// Whether this takes the misfit out of a survey as given: many more fit, or as many and their scatter is as stated at last.
    fn mends(&self, as_given: &Tried) -> bool {
        let by_share = self.merit() > BETTER * as_given.merit();
        let scatter = |tried: &Tried| tried.variance_factor.unwrap_or(1.0);
        let by_scatter = scatter(as_given) > BROKEN
            && scatter(self) < MENDED
            && self.share > as_given.share - LOST;
        self.share > FITS && (by_share || by_scatter)
    }
}

/// The finding that names the best of several alternatives, if it mends what is broken: it must fit, and clearly better than the survey
/// as given.
#[must_use]
pub fn best(as_given: &Tried, tried: &[(Alternative, Tried)], what: &str) -> Option<Finding> {
    let by_merit =
        |a: &&(Alternative, Tried), b: &&(Alternative, Tried)| a.1.merit().total_cmp(&b.1.merit());
    let (alternative, found) = tried.iter().max_by(by_merit)?;
    found.mends(as_given).then(|| {
        Finding::new(
            alternative.code,
            Severity::Refuses,
            format!(
                "{} {}, as given {}",
                alternative.words,
                found.words(what),
                as_given.words("them")
            ),
            format!(
                "{BETTER} times better than as given or a variance factor from {BROKEN} to {MENDED}, and {:.0} % that fit",
                100.0 * FITS
            ),
            alternative.advice,
        )
    })
}

/// A survey that fits, solved again without a mistake that its parameters could have taken up.
#[derive(Clone, Debug, PartialEq)]
pub struct Otherwise {
    /// The mistake.
    pub alternative: Alternative,
    /// By how much the weighted squares are smaller without it.
    pub gain: f64,
    /// By how many of its sigmas each parameter would be another.
    pub moved: BTreeMap<String, f64>,
}

/// Weighted squares by which a survey must fit better without a mistake for that to be named. Of 200 right surveys (`usbl-thin`) two were
/// better by 13 with pitch reversed, of 24 with pitch really reversed 21 by 17 to 57.
const CLEARLY: f64 = 16.0;
/// A sign that is not decided matters where it would move a parameter by more sigmas than this.
const UNDECIDED_SIGMAS: f64 = 2.0;

impl Otherwise {
    fn matters(&self) -> bool {
        self.moved
            .values()
            .any(|sigmas| sigmas.abs() > UNDECIDED_SIGMAS)
    }

    fn finding(&self, severity: Severity, seen: String) -> Finding {
        let threshold = format!("{CLEARLY} in the weighted squares");
        let (code, advice) = (self.alternative.code, self.alternative.advice);
        Finding::new(code, severity, seen, threshold, advice)
    }

    fn clear(&self) -> Finding {
        let (words, gain) = (&self.alternative.words, self.gain);
        let seen = format!("{words} the survey fits better, by {gain:.0} in the weighted squares");
        self.finding(Severity::Refuses, seen)
    }

    /// How the fit would change, where a whole number says anything.
    fn squares(&self) -> String {
        let than = if self.gain > 0.0 { "less" } else { "more" };
        match self.gain.abs() {
            gain if gain < 0.5 => String::new(),
            gain => format!(" (weighted squares {gain:.0} {than})"),
        }
    }

    fn undecided(self) -> Finding {
        let elsewhere = largest(&self.moved).map_or(String::new(), |(name, sigmas)| {
            let name = name.replace('_', " ");
            format!(", and {name} would be {sigmas:.0} sigmas away")
        });
        let seen = format!(
            "the survey cannot tell, so make sure: {} it fits as well{}{elsewhere}",
            self.alternative.words,
            self.squares(),
        );
        self.finding(Severity::Finding, seen)
            .with_effect(self.moved)
    }
}

/// The mistake without which a survey fits clearly better; else all those that it cannot tell, where they matter, likeliest first.
#[must_use]
pub fn preferred(tried: impl IntoIterator<Item = Otherwise>) -> Vec<Finding> {
    let mut tried: Vec<Otherwise> = tried.into_iter().collect();
    tried.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    if let Some(best) = tried.first().filter(|best| best.gain > CLEARLY) {
        return vec![best.clear()];
    }
    let undecided = tried
        .into_iter()
        .filter(|other| other.gain > -CLEARLY && other.matters());
    undecided.map(Otherwise::undecided).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn alternative(code: &'static str) -> Alternative {
        Alternative {
            code,
            words: format!("with {code}"),
            advice: "check it",
        }
    }

    fn tried(share: f64, factor: f64) -> Tried {
        Tried {
            share,
            variance_factor: Some(factor),
            oversize: false,
        }
    }

    #[test]
    fn a_sign_that_a_survey_does_not_decide_is_a_finding_where_it_matters() {
        let otherwise = |gain, sigmas| Otherwise {
            alternative: alternative("sign_of_pitch"),
            gain,
            moved: BTreeMap::from([("pitch".to_owned(), sigmas)]),
        };
        assert_eq!(preferred([otherwise(-17.0, 20.0)]), [], "decided");
        assert_eq!(preferred([otherwise(-3.0, 1.9)]), [], "no matter");
        let tried = [-9.0, -17.0, 3.0].map(|gain| otherwise(gain, -2.1));
        let undecided = preferred(tried);
        assert_eq!(undecided.len(), 2);
        let said = "with sign_of_pitch it fits as well (weighted squares 3 less), and pitch would be 2 sigmas away";
        assert!(undecided[0].seen.ends_with(said), "{}", undecided[0].seen);
        assert!(undecided[0].seen.contains("weighted squares 3 less"));
        assert!(undecided[1].seen.contains("weighted squares 9 more"));
        assert!(undecided.iter().all(|f| f.severity == Severity::Finding));
        let wrong = preferred([otherwise(9.0, 5.0), otherwise(17.0, 0.0)]);
        assert_eq!((wrong.len(), wrong[0].severity), (1, Severity::Refuses));
    }

    /// An alternative that leaves nothing has no variance factor; as a number that is none it would come before all others.
    #[test]
    fn an_alternative_that_leaves_nothing_is_the_last() {
        let nothing = (alternative("axes"), tried(0.0, f64::NAN));
        let right = (alternative("noise"), tried(1.0, 1.0));
        let found = best(&tried(0.2, 1.3), &[right, nothing], "the fixes");
        assert_eq!(found.expect("a finding").code, "noise");
    }

    /// Attitude in radians turns a resting boat by a constant, which the mounting takes up: all fixes fit, 34 deg off.
    #[test]
    fn a_mistake_that_only_mends_the_size_is_named() {
        let all = [(alternative("attitude_in_radians"), tried(1.0, 1.0))];
        let oversize = Tried {
            oversize: true,
            ..tried(1.0, 1.0)
        };
        let found = best(&oversize, &all, "the fixes").unwrap();
        assert!(found.seen.contains("too large"), "{}", found.seen);
        assert_eq!(best(&tried(1.0, 1.0), &all, "the fixes"), None);
    }

    #[test]
    fn the_mistake_that_mends_the_fit_is_named() {
        let all = [
            (alternative("sign_of_roll"), tried(0.96, 1.0)),
            (alternative("sign_of_pitch"), tried(0.4, 2.0)),
        ];
        let found = best(&tried(0.44, 3.7), &all, "the returns").unwrap();
        assert_eq!(found.code, "sign_of_roll");
        assert!(
            found.seen.contains("96 % of the returns fit") && found.seen.contains("as given 44 %")
        );
    }

    /// A reversed pitch leaves nearly all observations on the target and shows in their scatter alone.
    #[test]
    fn a_mistake_that_only_mends_the_scatter_is_named() {
        let all = [(alternative("sign_of_pitch"), tried(0.93, 1.0))];
        let found = best(&tried(0.93, 1.24), &all, "the returns").unwrap();
        assert_eq!(found.code, "sign_of_pitch");
        let fewer = [(alternative("sign_of_pitch"), tried(0.88, 1.0))];
        assert_eq!(best(&tried(0.93, 1.24), &fewer, "the returns"), None);
        assert_eq!(best(&tried(0.93, 1.1), &all, "the returns"), None);
    }

    #[test]
    fn nothing_is_named_where_nothing_mends() {
        let all = [(alternative("sign_of_pitch"), tried(0.97, 1.0))];
        assert_eq!(
            best(&tried(0.96, 1.0), &all, "the returns"),
            None,
            "as good as given"
        );
        assert_eq!(
            best(
                &tried(0.1, 3.0),
                &[(alternative("x"), tried(0.3, 1.0))],
                "the returns"
            ),
            None,
            "does not fit"
        );
    }
}
