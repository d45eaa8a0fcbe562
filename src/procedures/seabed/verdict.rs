//! May the solution be used? Layout, convergence, the field, the relief: each can say no, and says which parameter it means.

use serde::Serialize;

use super::config::{JointSettings, SeabedConfig};
use super::joint::{Joint, SCATTER};
use super::layout::Layout;
use super::parameters::{self, Kind, Parameter};
use super::reml::Bounds;
use crate::calibrate::verdict::bounds::{Correction, share, size};
use crate::calibrate::verdict::{Doubted, VerdictConfig, accepted};
use crate::math;
use crate::results::{Finding, Severity};

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
    pub parameters: Vec<String>,
}

impl Reason {
    /// Whether it says that the model does not fit, rather than that the data do not determine something.
    #[must_use]
    pub fn is_of_the_model(&self) -> bool {
        matches!(
            self.code,
            "not_converged" | "variance_factor" | "field" | "prior" | "size" | "share"
        )
    }
}

/// What may be used of a joint solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Judgement {
    /// Parameter by parameter.
    pub determined: Vec<bool>,
    /// Places of the angles of all heads.
    angles: Vec<usize>,
    /// What speaks against it.
    pub reasons: Vec<Reason>,
    /// What to look at although nothing is taken away.
    pub notes: Vec<Finding>,
    /// What the score tests found, and the bounds of all that was tested.
    pub doubted: Doubted,
}

impl Judgement {
    /// Whether all three angles of every head are determined.
    #[must_use]
    pub fn usable(&self) -> bool {
        self.angles.iter().all(|k| self.determined[*k]) && self.doubted.withdrawn().is_none()
    }

    /// Whether the model does not fit, rather than that the data do not determine something.
    #[must_use]
    pub fn is_of_the_model(&self) -> bool {
        self.reasons.iter().any(Reason::is_of_the_model) || self.doubted.withdrawn().is_some()
    }

    /// All reasons in one text.
    #[must_use]
    pub fn words(&self) -> String {
        let reasons = self.reasons.iter().map(|r| r.words.as_str());
        let withdrawn = self.doubted.withdrawn().map(|f| f.seen.as_str());
        let all: Vec<&str> = reasons.chain(withdrawn).collect();
        all.join("; ")
    }
}

impl Judgement {
    /// What to look at, in words.
    pub fn noted(&self) -> impl Iterator<Item = String> {
        self.notes.iter().map(|note| note.seen.clone())
    }
}

/// Judges a joint solution.
#[must_use]
pub fn judge(joint: &Joint, layout: &Layout, settings: &JointSettings) -> Judgement {
    let config = &settings.seabed;
    let mut judgement = Judgement {
        determined: (joint.sought.iter().zip(&joint.parameters))
            .map(|(sought, p)| *sought && p.kind.is_reported())
            .collect(),
        angles: angles(joint),
        reasons: vec![],
        notes: vec![],
        doubted: Doubted {
            findings: accepted(joint.doubted.findings.clone(), &settings.verdict),
            ..joint.doubted.clone()
        },
    };
    let limits = &settings.verdict;
    for reason in whole(joint, limits)
        .into_iter()
        .chain(by_size(joint, limits))
        .chain(by_share(joint, limits))
        .chain(by_priors(joint, limits))
        .chain(by_layout(joint, layout))
        .chain(by_relief(joint, config))
        .chain(by_sigma(joint, config))
    {
        judgement.take(joint, reason);
    }
    let few = share_of(joint, limits).filter(|f| f.severity == Severity::Finding);
    let ground = few.into_iter().chain(waves(joint)).chain(noise(joint));
    judgement.notes.extend(ground);
    for k in joint.reported().filter(|k| joint.inflation[*k] > 1.0) {
        judgement
            .notes
            .push(scatter(&joint.parameters[k].name(), joint.inflation[k]));
    }
    judgement
}

/// Ground that is no random relief; the sigmas were tried on such ground.
fn waves(joint: &Joint) -> Option<Finding> {
    let words = Bounds::waves(&joint.field, joint.tile_m)?;
    Some(Finding::new(
        "ground_waves",
        Severity::Finding,
        words,
        "a slope of one in twenty that is smooth over two tiles".to_owned(),
        "on simulated sand waves errors were up to 1.15 times what the sigmas say: where that matters, sail another line or other ground",
    ))
}

/// Noise that is not the claimed one. One factor scales the sonar's on all beams, so that a claim of the wrong shape stays wrong, and too
/// much stated of the INS makes it too small.
fn noise(joint: &Joint) -> Option<Finding> {
    let factor = joint.field.noise_factor;
    let assumed = match joint.assumed.is_empty() {
        true => String::new(),
        false => format!(
            " (not in the survey file, taken by what is usual: {})",
            joint.assumed.join(", ")
        ),
    };
    (joint.field.noise_is_as_claimed() == Some(false)).then(|| {
        Finding::new(
            "noise_claim",
            Severity::Finding,
            format!("the soundings have {factor:.2} times the noise that is claimed of them"),
            "0.8 to 1.25 times".to_owned(),
            format!("state range_sigma_m, angle_sigma_deg and angle_sigma_growth under [multibeam] as the sounder's maker does, and position_sigma_m and roll_pitch_sigma_deg under [trajectory] as the INS has them from record to record{assumed}: a wrong share of either lets the score tests name causes that are none"),
        )
    })
}

/// The tiles' scores scatter further than the model says.
fn scatter(parameter: &str, ratio: f64) -> Finding {
    let words = format!(
        "the tiles scatter {ratio:.1} times as far in {parameter} as the model says; its sigma is that of the scatter"
    );
    Finding::new(
        "scatter",
        Severity::Finding,
        words,
        format!("{SCATTER} times"),
        "look for an error that the model does not have: a tide within a line, a heave channel that is wrong by more than a scale or a lag",
    )
}

impl Judgement {
    fn take(&mut self, joint: &Joint, reason: Reason) {
        for (k, parameter) in joint.parameters.iter().enumerate() {
            if reason.parameters.contains(&parameter.name()) {
                self.determined[k] = false;
            }
        }
        self.reasons.push(reason);
    }
}

/// Places of the angles of all heads.
fn angles(joint: &Joint) -> Vec<usize> {
    let places = joint.parameters.iter().enumerate();
    places
        .filter_map(|(k, p)| p.kind.is_angle().then_some(k))
        .collect()
}

fn all(joint: &Joint) -> Vec<String> {
    joint.parameters.iter().map(Parameter::name).collect()
}

/// What takes everything away: no convergence, no fit, an absurd field.
fn whole(joint: &Joint, config: &VerdictConfig) -> Vec<Reason> {
    let mut reasons = vec![];
    let mut refuse = |code: &'static str, words, advice: &str| {
        if accepts(config, code) {
            return;
        }
        reasons.push(Reason {
            code,
            words,
            advice: advice.to_owned(),
            parameters: all(joint),
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
    let (low, high) = (config.least_variance_factor, config.most_variance_factor);
    if !(low..=high).contains(&fit) {
        refuse(
            "variance_factor",
            format!(
                "the sum of squares is {fit:.2} times its degrees of freedom, outside {low} to {high}"
            ),
            "the claimed noise, the water or the lines do not fit together",
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

fn accepts(config: &VerdictConfig, code: &str) -> bool {
    config.accept.iter().any(|accepted| accepted == code)
}

/// A finding of the common verdict that takes everything away, unless the survey file accepts it.
fn of_verdict(
    finding: Option<Finding>,
    code: &'static str,
    (joint, config): (&Joint, &VerdictConfig),
) -> Option<Reason> {
    let counts = |f: &Finding| f.severity > Severity::Finding && !accepts(config, &f.code);
    finding.filter(counts).map(|finding| Reason {
        code,
        words: finding.seen,
        advice: finding.advice,
        parameters: all(joint),
    })
}

/// A correction of a head that is too large to be one.
fn by_size(joint: &Joint, config: &VerdictConfig) -> Vec<Reason> {
    let heads = joint.values.mountings.len();
    let of_head = |head: usize| {
        let (angles, arm) = parameters::own(head);
        let name = match heads {
            1 => "the sounder".to_owned(),
            _ => joint.parameters[angles[0]].head_in_words(),
        };
        let arm_m = arm.map(|k| k.map_or(0.0, |k| joint.off[k]));
        let correction = Correction {
            name,
            turn_rad: joint.turn_rad(head),
            arm_m: math::hypot(math::hypot(arm_m[0], arm_m[1]), arm_m[2]),
        };
        of_verdict(size(&correction, config), "size", (joint, config))
    };
    (0..heads).filter_map(of_head).collect()
}

/// Soundings of which too few lie on the common surface.
fn by_share(joint: &Joint, config: &VerdictConfig) -> Option<Reason> {
    of_verdict(share_of(joint, config), "share", (joint, config))
}

fn share_of(joint: &Joint, config: &VerdictConfig) -> Option<Finding> {
    share(&joint.kept()?, config)
}

/// What takes up errors of its kind within a prior, and took up more than that.
fn by_priors(joint: &Joint, config: &VerdictConfig) -> Vec<Reason> {
    if accepts(config, "prior") {
        return vec![];
    }
    let one = |k: usize| {
        let (off, prior) = (joint.off[k], joint.priors[k]?);
        // the value varies less than its prior, so that this counts too few rather than too many
        let sigmas = off.abs() / prior;
        (joint.sought[k] && sigmas > config.max_prior_sigmas).then(|| Reason {
            code: "prior",
            words: format!(
                "the {} comes out at {off:.4} although it is known to {prior}: {sigmas:.0} sigmas",
                joint.parameters[k].name().replace('_', " ")
            ),
            advice: "something of its kind is wrong: check it, or state that it is known less well"
                .to_owned(),
            parameters: all(joint),
        })
    };
    let held = |k: &usize| !joint.parameters[*k].kind.is_reported();
    (0..joint.off.len()).filter(held).filter_map(one).collect()
}

fn by_layout(joint: &Joint, layout: &Layout) -> Vec<Reason> {
    if layout.pairs.is_empty() {
        return vec![Reason {
            code: "no_overlap",
            words: "no two lines share enough seabed".to_owned(),
            advice: "sail a line back on the same track and one beside it".to_owned(),
            parameters: all(joint),
        }];
    }
    let kinds = [Kind::Pitch, Kind::Roll, Kind::Yaw];
    let missing = layout.missing();
    let one = |k: usize| {
        missing[k].map(|words| Reason {
            code: "layout",
            words: words.to_owned(),
            advice: "sail that line".to_owned(),
            parameters: of_kind(joint, kinds[k]),
        })
    };
    (0..3).filter_map(one).collect()
}

/// Names of a kind's parameters, of every head.
fn of_kind(joint: &Joint, kind: Kind) -> Vec<String> {
    let all = joint.parameters.iter().filter(|p| p.kind == kind);
    all.map(Parameter::name).collect()
}

/// Pitch and yaw that come from the boat's motion alone are as true as the heave channel, which nothing here can check.
fn by_relief(joint: &Joint, config: &SeabedConfig) -> Vec<Reason> {
    let limit_deg = config.max_relief_sigma_deg;
    let relief = |k: usize| joint.relief_sigma.as_ref().map_or(f64::INFINITY, |s| s[k]);
    let one = |k: usize| {
        let sigma_deg = relief(k).to_degrees();
        (!(sigma_deg <= limit_deg)).then(|| Reason {
            code: "relief",
            words: format!(
                "{} comes from the boat's motion only: from the relief its sigma would be {sigma_deg:.2} deg (limit {limit_deg} deg)",
                joint.parameters[k].name()
            ),
            advice: "survey over a slope, a channel or rough ground".to_owned(),
            parameters: vec![joint.parameters[k].name()],
        })
    };
    let is_of_relief = |k: &usize| matches!(joint.parameters[*k].kind, Kind::Pitch | Kind::Yaw);
    let places = angles(joint).into_iter().filter(is_of_relief);
    places.filter_map(one).collect()
}

fn by_sigma(joint: &Joint, config: &SeabedConfig) -> Vec<Reason> {
    let limit_deg = config.max_sigma_deg;
    let one = |k: usize| {
        let sigma_deg = joint.sigma(k).to_degrees();
        (!(sigma_deg <= limit_deg)).then(|| Reason {
            code: "undetermined",
            words: format!(
                "the sigma of {} is {sigma_deg:.2} deg (limit {limit_deg} deg)",
                joint.parameters[k].name()
            ),
            advice: "more lines, more relief, more motion".to_owned(),
            parameters: vec![joint.parameters[k].name()],
        })
    };
    angles(joint).into_iter().filter_map(one).collect()
}
