//! What a survey will determine, before anything is solved: what lies on the target, from where, and what would help.

use nalgebra::Matrix6;
use serde::Serialize;

use super::alternatives;
use super::config::JointConfig;
use super::coverage::Coverage;
use super::joint::{self, JointStart, SIX};
use super::planes::PASS_GAP_S;
use super::run::{PoolError, PoolInput, Scanned, Sounded};
use super::scene::Scene;
use super::ties::TieSet;
use super::verdict::{Refusal, undetermined_by};
use crate::observe::Campaign;
use crate::results::Finding;
use crate::target::{Role, Target};
use crate::watch::Watch;

/// Distances whose quotient is below this count as one distance.
const ONE_DISTANCE: f64 = 1.3;
/// Share of the soundings near the target that lie on its faces at the rough mounting; with less, mistakes are tried.
const FITS: f64 = 0.7;
/// Fewest observations on a kind of face that count as seen.
const SEEN: usize = 50;

/// Observations on the faces of one role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// Laser returns.
    pub returns: usize,
    /// Soundings.
    pub soundings: usize,
}

/// The soundings between two pauses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PassSpan {
    /// First and last tied sounding, seconds.
    pub time_s: (f64, f64),
    /// Tied soundings.
    pub soundings: usize,
    /// Smallest, mean and largest distance of the sonar from the wall's plane, metres.
    pub distance_m: (f64, f64, f64),
}

/// What is known before the solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    /// What lies on P1, P2, P3, the horizontal faces and others, in this order.
    pub seen: [(&'static str, Seen); 5],
    /// The passes, in order of time.
    pub passes: Vec<PassSpan>,
    /// What stops a calibration already.
    pub refusal: Option<Refusal>,
    /// The mistake without which far more would fit, where little does.
    pub mistake: Option<Finding>,
    /// Standard deviations to expect; `None` when a calibration would be refused before it is solved.
    pub predicted: Option<Predicted>,
    /// Sentences of advice.
    pub advice: Vec<String>,
}

/// What the joint path promises, from one linearisation at the rough mounting.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// One sigma of each of the six; a held one has 0.
    pub sigmas: ExpectedSigmas,
    /// Those beyond the configured limits, with their sigma: not determined.
    pub undetermined: Vec<String>,
    /// Correlation of yaw and the along-track lever arm.
    pub yaw_ly: f64,
    /// Pairs correlated beyond 0.95, with the correlation.
    pub inseparable: Vec<(&'static str, &'static str, f64)>,
}

/// Standard deviations that a survey promises, one sigma.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ExpectedSigmas {
    /// About x, degrees.
    pub pitch_deg: f64,
    /// About y, degrees.
    pub roll_deg: f64,
    /// About z, degrees.
    pub yaw_deg: f64,
    /// Along x, metres.
    pub lx_m: f64,
    /// Along y, metres.
    pub ly_m: f64,
    /// Along z, metres.
    pub lz_m: f64,
}

impl Predicted {
    fn of(covariance: &Matrix6<f64>, coverage: &Coverage, input: &PoolInput) -> Self {
        let sigma = |i: usize| covariance[(i, i)].sqrt();
        let correlation = |i: usize, j: usize| covariance[(i, j)] / (sigma(i) * sigma(j));
        let pairs = (0..6).flat_map(|i| (i + 1..6).map(move |j| (i, j)));
        let correlated = pairs.filter_map(|(i, j)| {
            let r = correlation(i, j);
            (r.abs() > 0.95).then_some((SIX[i], SIX[j], r))
        });
        Self {
            sigmas: ExpectedSigmas {
                pitch_deg: sigma(0).to_degrees(),
                roll_deg: sigma(1).to_degrees(),
                yaw_deg: sigma(2).to_degrees(),
                lx_m: sigma(3),
                ly_m: sigma(4),
                lz_m: sigma(5),
            },
            yaw_ly: correlation(2, 4),
            undetermined: undetermined_by(covariance, coverage.uncovered(), input),
            inseparable: correlated.collect(),
        }
    }
}

const ROLES: [(Role, &str); 5] = [
    (Role::P1, "P1"),
    (Role::P2, "P2"),
    (Role::P3, "P3"),
    (Role::Horizontal, "horizontal"),
    (Role::Other, "other"),
];

/// Looks at a survey: refines the target's pose, registers the soundings roughly, ties both sensors' points to the faces.
///
/// # Errors
/// [`PoolError`] when the input cannot be worked with at all.
pub fn preview(input: &PoolInput, progress: &dyn Watch) -> Result<Preview, PoolError> {
    let (campaign, target) = (input.campaign, input.target);
    let scene = Scene::prepare(campaign, target, input.prior)?;
    let Scanned {
        wide,
        planes: found,
        fitted,
        returns,
        ..
    } = Scanned::by(&scene, input);
    let mut refusal = Refusal::of_scanner(&scene, &found, &wide);
    let mut soundings = TieSet::default();
    let mut passes = vec![];
    let mut predicted = None;
    let mut fits = 1.0;
    if refusal.is_none() {
        let rough = scene.rough_mounting();
        refusal = Refusal::of_soundings(&rough);
        let sounded = Sounded::by(&scene, input, &rough.mounting, &fitted);
        let near = sounded.candidates;
        soundings = sounded.ties;
        fits = soundings.len() as f64 / near.len().max(1) as f64;
        let start = JointStart {
            mounting: rough.mounting,
            planes: &found,
            returns: &returns,
            candidates: &near,
            soundings: &soundings,
        };
        if refusal.is_none() {
            match joint::predict(&scene, &start, input.joint) {
                Ok((covariance, _)) => {
                    let coverage = Coverage::of(&scene, &soundings, &rough.mounting);
                    predicted = Some(Predicted::of(&covariance, &coverage, input));
                }
                Err(error) => refusal = Some(Refusal::failed(&error)),
            }
        }
        passes = split(&scene, &soundings);
    }
    let seen = ROLES.map(|(role, name)| {
        (
            name,
            Seen {
                returns: count(target, &returns, role),
                soundings: count(target, &soundings, role),
            },
        )
    });
    let advice = if refusal.is_some() {
        vec![]
    } else {
        advice(&seen, &passes, predicted.as_ref(), campaign, input.joint)
    };
    let suspicious = refusal.is_some() || fits < FITS;
    let mistake = suspicious
        .then(|| alternatives::named(input, progress))
        .flatten();
    Ok(Preview {
        seen,
        passes,
        refusal,
        mistake,
        predicted,
        advice,
    })
}

fn count(target: &Target, ties: &TieSet, role: Role) -> usize {
    ties.count(|face| target.faces[face].role == role)
}

/// The tied soundings split at pauses, with their distances from the wall (x = 0 of the target frame).
fn split(scene: &Scene, ties: &TieSet) -> Vec<PassSpan> {
    let mut passes: Vec<PassSpan> = vec![];
    let mut last_s = f64::NEG_INFINITY;
    for tie in ties {
        let time_s = scene.campaign.soundings.at_s(tie.row as usize);
        let Some(pose) = scene.sounding_pose(tie.row as usize, 0.0) else {
            continue;
        };
        let away_m = -(pose.position_m + pose.rotation * scene.campaign.sonar.lever_arm_m).x;
        match passes.last_mut() {
            Some(pass) if time_s - last_s <= PASS_GAP_S => pass.add(time_s, away_m),
            _ => passes.push(PassSpan {
                time_s: (time_s, time_s),
                soundings: 1,
                distance_m: (away_m, away_m, away_m),
            }),
        }
        last_s = time_s;
    }
    passes.retain(|pass| pass.soundings >= SEEN);
    passes
}

impl PassSpan {
    fn add(&mut self, time_s: f64, away_m: f64) {
        let (low, mean, high) = self.distance_m;
        let n = self.soundings as f64;
        self.time_s.1 = time_s;
        self.soundings += 1;
        self.distance_m = (
            low.min(away_m),
            (mean * n + away_m) / (n + 1.0),
            high.max(away_m),
        );
    }
}

/// What would help; figures are those of this survey.
fn advice(
    seen: &[(&str, Seen); 5],
    passes: &[PassSpan],
    predicted: Option<&Predicted>,
    campaign: &Campaign,
    joint: &JointConfig,
) -> Vec<String> {
    let by_both = |name: &str| {
        seen.iter()
            .any(|(n, s)| *n == name && s.returns >= SEEN && s.soundings >= SEEN)
    };
    let held = |name: &str| joint.hold.iter().any(|h| h == name);
    let mut advice = distance_advice(passes, predicted, joint);
    let inclined = (by_both("P1"), by_both("P3"));
    let level = by_both("horizontal");
    if let Some(sentence) = inclined_advice(inclined, level, predicted) {
        advice.push(sentence);
    }
    if !level && !held("lz") && joint.prior.lz_sigma_m.is_none() {
        advice.push("no horizontal face is seen by both sensors: the vertical lever arm is not determined; measure it and give [joint] hold = [\"lz\"] or \
            prior = { lz_sigma_m = ... }".to_owned());
    }
    if campaign.scanner_sigma.is_none() {
        advice.push("[lidar] gives no mounting_sigma_deg and lever_arm_sigma_m: the standard deviations hold only if the scanner has no error".to_owned());
    }
    if joint.latency {
        advice.push("latency is to be estimated: only the boat's motion determines it; pass at different speeds or with some swell".to_owned());
    }
    advice
}

/// What is missing without inclined faces.
fn inclined_advice(
    inclined: (bool, bool),
    level: bool,
    predicted: Option<&Predicted>,
) -> Option<String> {
    let figures = predicted.map_or_else(String::new, |p| {
        format!(
            " (here only the boat's motion holds pitch to {:.2} deg, yaw to {:.2} deg and the along-track lever arm to {:.2} m)",
            p.sigmas.pitch_deg, p.sigmas.yaw_deg, p.sigmas.ly_m
        )
    });
    match (inclined, level) {
        ((true, true), _) => None,
        ((false, false), false) => Some(format!(
            "only the wall is seen by both sensors: it determines roll and the off-wall lever arm, neither pitch and yaw nor the \
             along-track and the vertical lever arm{figures}; such a survey is refused. Blocks with inclined and horizontal faces are needed"
        )),
        ((false, false), true) => Some(
            "no inclined face (P1, P3) is seen by both sensors: no face looks along the track, so yaw and the along-track lever arm are not determined"
                .to_owned(),
        ),
        ((found, _), _) => {
            let missing = if found { "P3" } else { "P1" };
            Some(format!(
                "{missing} is not seen by both sensors: yaw is weaker, and the reference path cannot run"
            ))
        }
    }
}

/// Passes at one distance hold yaw and along-track arm together, and range scale and off-wall arm.
fn distance_advice(
    passes: &[PassSpan],
    predicted: Option<&Predicted>,
    joint: &JointConfig,
) -> Vec<String> {
    let means = || passes.iter().map(|p| p.distance_m.1);
    let (low, high) = (
        means().fold(f64::INFINITY, f64::min),
        means().fold(0.0, f64::max),
    );
    let mut advice = vec![];
    if passes.is_empty() || high > ONE_DISTANCE * low {
        return advice;
    }
    let correlation = predicted
        .filter(|p| p.yaw_ly.is_finite())
        .map_or_else(String::new, |p| {
            format!(" (correlation {:+.3} here)", p.yaw_ly)
        });
    advice.push(format!(
        "all passes run at about {low:.1} m from the wall: yaw and the along-track lever arm are hard to separate{correlation}; a pass at \
         another distance, such as {:.0} m, separates them, while repeating a pass gains no more than the square root of two",
        1.8 * low
    ));
    if joint.range_scale {
        advice.push(
            "range_scale is to be estimated: at one distance it cannot be separated from the off-wall lever arm"
                .to_owned(),
        );
    }
    advice
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(distance_m: f64) -> PassSpan {
        PassSpan {
            time_s: (0.0, 1.0),
            soundings: 1000,
            distance_m: (distance_m, distance_m, distance_m),
        }
    }

    #[test]
    fn one_distance_is_warned_of_and_two_are_not() {
        let joint = JointConfig {
            range_scale: true,
            ..JointConfig::default()
        };
        let one = distance_advice(&[pass(5.0), pass(5.3)], None, &joint);
        assert!(
            one.len() == 2 && one[0].contains("hard to separate") && one[1].contains("range_scale"),
            "{one:?}"
        );
        assert!(distance_advice(&[pass(5.0), pass(9.0)], None, &joint).is_empty());
    }
}
