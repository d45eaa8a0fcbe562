//! May the solution be used? Layout, convergence, the field, the relief: each can say no, and says which parameter it means.

use serde::Serialize;

use super::config::SeabedConfig;
use super::joint::Joint;
use super::layout::Layout;
use super::model::{COUNT, PARAMETERS};
use super::reml::Bounds;

/// Why parameters are not determined.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reason {
    /// Short name.
    pub code: &'static str,
    /// In words.
    pub words: String,
    /// What to do about it.
    pub advice: String,
    /// The parameters it takes away.
    pub parameters: Vec<&'static str>,
}

impl Reason {
    /// Whether it says that the model does not fit, rather than that the data do not determine something.
    #[must_use]
    pub fn is_of_the_model(&self) -> bool {
        matches!(self.code, "not_converged" | "misfit" | "field" | "prior")
    }
}

/// What may be used of a joint solution.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// Parameter by parameter.
    pub determined: [bool; COUNT],
    /// What speaks against it.
    pub reasons: Vec<Reason>,
    /// What to look at although nothing is taken away.
    pub notes: Vec<String>,
}

impl Judgement {
    /// Whether all three angles are determined.
    #[must_use]
    pub fn usable(&self) -> bool {
        self.determined[..3].iter().all(|d| *d)
    }

    /// All reasons in one text.
    #[must_use]
    pub fn words(&self) -> String {
        let all: Vec<&str> = self.reasons.iter().map(|r| r.words.as_str()).collect();
        all.join("; ")
    }
}

/// Sums of squares over degrees of freedom that a sound solution has.
const FIT: [f64; 2] = [0.8, 1.2];
/// A range scale, heave scale, heave lag, lever arm or profile error is one of the things that are held: estimated, never reported as determined.
const REPORTED: usize = 4;

/// Judges a joint solution.
#[must_use]
pub fn judge(joint: &Joint, layout: &Layout, config: &SeabedConfig) -> Judgement {
    let mut judgement = Judgement {
        determined: std::array::from_fn(|k| joint.sought[k] && k < REPORTED),
        reasons: vec![],
        notes: vec![],
    };
    for reason in whole(joint)
        .into_iter()
        .chain(by_priors(joint))
        .chain(by_layout(layout))
        .chain(by_relief(joint, config))
        .chain(by_sigma(joint, config))
    {
        judgement.take(reason);
    }
    for k in (0..REPORTED).filter(|k| joint.inflation[*k] > 1.0) {
        judgement.notes.push(format!(
            "the tiles scatter {:.1} times as far in {} as the model says; its sigma is that of the scatter",
            joint.inflation[k], PARAMETERS[k].0
        ));
    }
    judgement
}

impl Judgement {
    fn take(&mut self, reason: Reason) {
        for (k, (name, _)) in PARAMETERS.iter().enumerate() {
            if reason.parameters.contains(name) {
                self.determined[k] = false;
            }
        }
        self.reasons.push(reason);
    }
}

fn all() -> Vec<&'static str> {
    PARAMETERS.iter().map(|(name, _)| *name).collect()
}

/// What takes everything away: no convergence, no fit, an absurd field.
fn whole(joint: &Joint) -> Vec<Reason> {
    let mut reasons = vec![];
    let mut refuse = |code, words, advice: &str| {
        reasons.push(Reason {
            code,
            words,
            advice: advice.to_owned(),
            parameters: all(),
        });
    };
    if !joint.converged {
        refuse(
            "not_converged",
            format!(
                "the steps are still large after {} passes",
                joint.passes.len()
            ),
            "look for gross errors and for a start far from the truth, or allow more passes ([seabed] max_passes)",
        );
    }
    let fit = joint.omega_over_freedom;
    if !(FIT[0]..=FIT[1]).contains(&fit) {
        refuse(
            "misfit",
            format!(
                "the sum of squares is {fit:.2} times its degrees of freedom, outside {} to {}",
                FIT[0], FIT[1]
            ),
            "the claimed noise, the water or the lines do not belong together",
        );
    }
    if let Some(words) = Bounds::default().reached(&joint.field, joint.tile_m) {
        refuse(
            "field",
            words,
            "look for gross errors and at the claimed noise of range and angle",
        );
    }
    reasons
}

/// A prior that is contradicted by more of its sigmas than this is wrong.
const CONTRADICTION: f64 = 5.0;

/// What takes up errors of its kind within a prior, and took up more than that.
fn by_priors(joint: &Joint) -> Vec<Reason> {
    let one = |k: usize| {
        let (off, prior) = (joint.off[k], joint.priors[k]?);
        // the value varies less than its prior, so that this counts too few rather than too many
        let sigmas = off.abs() / prior;
        (joint.sought[k] && sigmas > CONTRADICTION).then(|| Reason {
            code: "prior",
            words: format!(
                "the {} comes out at {off:.4} although it is known to {prior}: {sigmas:.0} sigmas",
                PARAMETERS[k].0.replace('_', " ")
            ),
            advice: "something of its kind is wrong: look at it, or say that it is known less well"
                .to_owned(),
            parameters: all(),
        })
    };
    (REPORTED..COUNT).filter_map(one).collect()
}

fn by_layout(layout: &Layout) -> Vec<Reason> {
    if layout.pairs.is_empty() {
        return vec![Reason {
            code: "no_overlap",
            words: "no two lines share enough seabed".to_owned(),
            advice: "sail a line back on the same track and one beside it".to_owned(),
            parameters: all(),
        }];
    }
    let names = ["pitch", "roll", "yaw"];
    let missing = layout.missing();
    let one = |k: usize| {
        missing[k].map(|words| Reason {
            code: "layout",
            words: words.to_owned(),
            advice: "sail that line".to_owned(),
            parameters: vec![names[k]],
        })
    };
    (0..3).filter_map(one).collect()
}

/// Pitch and yaw that come from the boat's motion alone are as true as the heave channel, which nothing here can check.
fn by_relief(joint: &Joint, config: &SeabedConfig) -> Vec<Reason> {
    let limit_deg = config.max_relief_sigma_deg;
    let relief = joint.relief_sigma.unwrap_or([f64::INFINITY; COUNT]);
    let one = |k: usize| {
        let sigma_deg = relief[k].to_degrees();
        (!(sigma_deg <= limit_deg)).then(|| Reason {
            code: "relief",
            words: format!(
                "{} comes from the boat's motion only: from the relief its sigma would be {sigma_deg:.2} deg (limit {limit_deg} deg)",
                PARAMETERS[k].0
            ),
            advice: "survey over a slope, a channel or rough ground".to_owned(),
            parameters: vec![PARAMETERS[k].0],
        })
    };
    [0, 2].into_iter().filter_map(one).collect()
}

fn by_sigma(joint: &Joint, config: &SeabedConfig) -> Vec<Reason> {
    let limit_deg = config.max_sigma_deg;
    let one = |k: usize| {
        let sigma_deg = joint.sigma(k).to_degrees();
        (!(sigma_deg <= limit_deg)).then(|| Reason {
            code: "undetermined",
            words: format!(
                "the sigma of {} is {sigma_deg:.2} deg (limit {limit_deg} deg)",
                PARAMETERS[k].0
            ),
            advice: "more lines, more relief, more motion".to_owned(),
            parameters: vec![PARAMETERS[k].0],
        })
    };
    (0..3).filter_map(one).collect()
}
