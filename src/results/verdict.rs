//! The verdict: whether a result may be used, and what speaks against it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// How a calibration ended, as one word for the surveyor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum VerdictState {
    /// The data determine the parameters and the model fits them.
    #[default]
    #[serde(rename = "usable")]
    Usable,
    /// The same, with something to look at.
    #[serde(rename = "usable with findings")]
    UsableWithFindings,
    /// The model does not fit: the numbers, and their sigmas above all, are not to be trusted.
    #[serde(rename = "does not fit")]
    DoesNotFit,
    /// The data do not determine what is sought, or nothing came of them.
    #[serde(rename = "not determined")]
    NotDetermined,
}

impl VerdictState {
    /// Whether the numbers may be used.
    #[must_use]
    pub fn is_usable(self) -> bool {
        self <= Self::UsableWithFindings
    }

    /// As it stands in `result.json`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Usable => "usable",
            Self::UsableWithFindings => "usable with findings",
            Self::DoesNotFit => "does not fit",
            Self::NotDetermined => "not determined",
        }
    }
}

/// What a finding does to the verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// Worth a look; the result stays usable.
    Finding,
    /// Takes "usable" away, unless the survey file accepts it.
    Withdraws,
    /// As [`Severity::Withdraws`], and no setting brings it back: there is no result to use.
    Refuses,
}

/// One thing that speaks against a result.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// Short name, the same in every procedure (`latency`, `variance_factor`): what `[verdict] accept` lists.
    pub code: String,
    /// What it does to the verdict.
    pub severity: Severity,
    /// What was seen, with its figures.
    pub seen: String,
    /// What it was held against, in words.
    pub threshold: String,
    /// What it would do to each sought parameter, in its sigmas; empty where that cannot be said.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub effect_in_sigmas: BTreeMap<String, f64>,
    /// What to try.
    pub advice: String,
    /// The survey file accepts it: `severity` no longer counts.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub accepted: bool,
}

impl Finding {
    /// A finding without figures of its effect.
    #[must_use]
    pub fn new(
        code: &str,
        severity: Severity,
        seen: impl Into<String>,
        threshold: impl Into<String>,
        advice: impl Into<String>,
    ) -> Self {
        Finding {
            code: code.to_owned(),
            severity,
            seen: seen.into(),
            threshold: threshold.into(),
            effect_in_sigmas: BTreeMap::new(),
            advice: advice.into(),
            accepted: false,
        }
    }

    /// The same with what it would do to the parameters, in their sigmas.
    #[must_use]
    pub fn with_effect(mut self, effect_in_sigmas: BTreeMap<String, f64>) -> Self {
        self.effect_in_sigmas = effect_in_sigmas;
        self
    }

    /// Whether it takes "usable" away.
    #[must_use]
    pub fn withdraws(&self) -> bool {
        match self.severity {
            Severity::Finding => false,
            Severity::Withdraws => !self.accepted,
            Severity::Refuses => true,
        }
    }

    /// What was seen and what to try, in one sentence.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self.advice.as_str() {
            "" => self.seen.clone(),
            advice => format!("{}; {advice}", self.seen),
        }
    }

    /// Largest effect on a parameter, in its sigmas; zero where none is stated.
    #[must_use]
    pub fn largest_effect(&self) -> f64 {
        self.effect_in_sigmas
            .values()
            .fold(0.0, |largest, sigmas| largest.max(sigmas.abs()))
    }
}

/// The parameter that moves by the most of its sigmas, and by how many.
#[must_use]
pub fn largest(effect: &BTreeMap<String, f64>) -> Option<(&str, f64)> {
    let each = effect
        .iter()
        .map(|(name, moved)| (name.as_str(), moved.abs()));
    each.max_by(|a, b| a.1.total_cmp(&b.1))
}

/// What a score test says of an unknown that the model has not, significant or not: how large it could be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bound {
    /// Code of its finding.
    pub code: String,
    /// Estimates of one step with their standard deviations, in words.
    pub estimate: String,
    /// The same as numbers (rad, m, s or 1).
    pub values: Vec<f64>,
    /// Their standard deviations; zero where one cannot be told from the parameters.
    pub sigmas: Vec<f64>,
    /// Chi-square of the score test.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Probability of a larger value by chance.
    pub p_value: f64,
    /// Largest change of a sought parameter, in its sigmas, if it were estimated.
    pub largest_effect_in_sigmas: f64,
}

/// Whether a result may be used, with everything that speaks against it, gravest first.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Verdict {
    /// The verdict.
    pub state: VerdictState,
    /// What speaks against the result, gravest first.
    pub findings: Vec<Finding>,
    /// What could be wrong unseen: every unknown that was tested for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bounds: Vec<Bound>,
}

impl Verdict {
    /// The verdict on findings in their order of importance: usable unless one of them withdraws it.
    #[must_use]
    pub fn of(mut findings: Vec<Finding>) -> Self {
        findings.sort_by_key(|finding| !finding.withdraws());
        let state = match findings.first() {
            None => VerdictState::Usable,
            Some(first) if !first.withdraws() => VerdictState::UsableWithFindings,
            Some(_) => VerdictState::DoesNotFit,
        };
        Verdict {
            state,
            findings,
            bounds: vec![],
        }
    }

    /// A result that the data do not determine, with what was found all the same.
    #[must_use]
    pub fn not_determined(findings: Vec<Finding>) -> Self {
        Verdict {
            state: VerdictState::NotDetermined,
            ..Self::of(findings)
        }
    }

    /// Why the result is not usable: what the first finding saw, and what to try. `None` when it is usable.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        let first = self.findings.first()?;
        (!self.state.is_usable()).then(|| first.in_words())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn finding(severity: Severity) -> Finding {
        Finding::new(
            "latency",
            severity,
            "19 ms late",
            "1 sigma",
            "set latency = true",
        )
    }

    #[test]
    fn only_what_withdraws_takes_usable_away() {
        assert_eq!(Verdict::of(vec![]).state, VerdictState::Usable);
        let light = Verdict::of(vec![finding(Severity::Finding)]);
        assert_eq!(light.state, VerdictState::UsableWithFindings);
        assert!(light.state.is_usable() && light.reason().is_none());
        let both = vec![finding(Severity::Finding), finding(Severity::Withdraws)];
        let grave = Verdict::of(both);
        assert_eq!(grave.state, VerdictState::DoesNotFit);
        assert_eq!(grave.findings[0].severity, Severity::Withdraws);
        assert_eq!(grave.reason().unwrap(), "19 ms late; set latency = true");
    }

    #[test]
    fn an_accepted_finding_is_listed_and_no_longer_counts() {
        let mut accepted = finding(Severity::Withdraws);
        accepted.accepted = true;
        let verdict = Verdict::of(vec![accepted]);
        assert_eq!(verdict.state, VerdictState::UsableWithFindings);
        let mut refused = finding(Severity::Refuses);
        refused.accepted = true;
        assert_eq!(Verdict::of(vec![refused]).state, VerdictState::DoesNotFit);
    }

    #[test]
    fn states_are_read_as_they_are_written() {
        let verdict = Verdict::not_determined(vec![finding(Severity::Refuses)]);
        let text = serde_json::to_string(&verdict).unwrap();
        assert!(text.contains("\"not determined\"") && text.contains("\"refuses\""));
        assert_eq!(serde_json::from_str::<Verdict>(&text).unwrap(), verdict);
    }
}
