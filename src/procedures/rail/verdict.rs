//! When the joint path has no usable result, and why.

use std::fmt;

use super::alternatives;
use super::config::RailJointConfig;
use super::joint::RailJoint;
use super::model::{SOUGHT, SOUGHT_NAMES};
use super::run::{RailInput, RailOutcome};
use super::scene::RailScene;
use crate::adjust::{AdjustError, Status};
use crate::calibrate::driver::ABSURD_VARIANCE_FACTOR;
use crate::calibrate::verdict::{Ending, concluded};
use crate::results::{Finding, Verdict};

/// Fewest points of a profiler.
const LEAST_TIES: usize = 50;

/// Why there is no usable result.
#[derive(Clone, Debug, PartialEq)]
pub enum RailRefusal {
    /// The table did not turn about an axis, so that the sign of an angle is not determined.
    NotTurned {
        /// `the vertical` or `the lateral axis`.
        axis: &'static str,
        /// What it leaves undetermined: `yaw` or `pitch`.
        angle: &'static str,
        /// Range of the turns, degrees.
        found_deg: f64,
        /// Range needed, degrees.
        needed_deg: f64,
    },
    /// A profiler did not see the rail.
    NotSeen {
        /// Its name.
        profiler: String,
        /// Points on the rail.
        points: usize,
    },
    /// Parameters that the data do not determine.
    Undetermined {
        /// Their names with the standard deviation and the limit.
        parameters: Vec<String>,
    },
    /// The engine did not end with a solution.
    NotSolved {
        /// How it ended.
        how: String,
    },
    /// The model does not fit: a finding of the verdict's tests.
    DoesNotFit(Box<Finding>),
    /// Misfit far beyond the stated noise.
    AbsurdMisfit {
        /// The variance factor.
        variance_factor: f64,
    },
}

impl fmt::Display for RailRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotTurned {
                axis,
                angle,
                found_deg,
                needed_deg,
            } => write!(
                f,
                "the sign of every profiler's {angle} is not determined: the table turned by {found_deg:.2} deg about {axis}, at least {needed_deg:.2} deg are needed"
            ),
            Self::NotSeen { profiler, points } => write!(
                f,
                "profiler {profiler} did not see the rail: {points} of its points lie on the standard profile, at least {LEAST_TIES} are needed"
            ),
            Self::Undetermined { parameters } => {
                write!(f, "not determined by the data: {}", parameters.join("; "))
            }
            Self::NotSolved { how } => write!(f, "the adjustment found no solution: {how}"),
            Self::DoesNotFit(finding) if finding.advice.is_empty() => f.write_str(&finding.seen),
            Self::DoesNotFit(finding) => write!(f, "{}; {}", finding.seen, finding.advice),
            Self::AbsurdMisfit { variance_factor } => write!(
                f,
                "the misfit is far beyond the stated noise: variance factor {variance_factor:.1}; is this the rail of the model file, and are the sigmas right?"
            ),
        }
    }
}

/// What can be told before anything is solved: turns of the table.
#[must_use]
pub fn before(scene: &RailScene, config: &RailJointConfig) -> Vec<RailRefusal> {
    let (heading, pitch) = scene.turned_rad();
    let needed_deg = config.least_turn_deg;
    let axes = [
        ("the vertical", "yaw", heading),
        ("the lateral axis", "pitch", pitch),
    ];
    let short = axes.into_iter().filter(|a| a.2.to_degrees() < needed_deg);
    short
        .map(|(axis, angle, range)| RailRefusal::NotTurned {
            axis,
            angle,
            found_deg: range.to_degrees(),
            needed_deg,
        })
        .collect()
}

/// The joint path's verdict; `None` when its result may be used.
#[must_use]
pub fn after(
    scene: &RailScene,
    config: &RailJointConfig,
    joint: &Result<RailJoint, AdjustError>,
) -> Option<RailRefusal> {
    let joint = match joint {
        Ok(joint) => joint,
        Err(error) => {
            return Some(RailRefusal::NotSolved {
                how: error.to_string(),
            });
        }
    };
    let unseen = not_seen(scene, joint);
    unseen
        .or_else(|| undetermined(scene, config, joint))
        .or_else(|| before(scene, config).into_iter().next())
        .or_else(|| not_solved(joint))
        .or_else(|| {
            let finding = joint.doubted.withdrawn()?;
            Some(RailRefusal::DoesNotFit(Box::new(finding.clone())))
        })
        .or_else(|| absurd(joint))
}

impl RailOutcome<'_> {
    /// The verdict: what refused the result first, then what the joint path's tests found.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let joint = self.joint.as_ref().and_then(|joint| joint.as_ref().ok());
        let ending = match &self.refusal {
            None => Ending::Usable,
            Some(RailRefusal::DoesNotFit(first)) => Ending::Withdrawn(first),
            Some(refusal) => Ending::Refused {
                code: refusal.code(),
                seen: refusal.to_string(),
                determined: matches!(
                    refusal,
                    RailRefusal::AbsurdMisfit { .. } | RailRefusal::NotSeen { .. }
                ),
            },
        };
        concluded(ending, joint.map(|joint| &joint.doubted))
    }
}

impl RailRefusal {
    /// The kind of refusal as one word.
    #[must_use]
    pub fn code(&self) -> &str {
        match self {
            Self::NotTurned { .. } => "not_turned",
            Self::NotSeen { .. } => "not_seen",
            Self::Undetermined { .. } => "undetermined",
            Self::NotSolved { .. } => "not_solved",
            Self::DoesNotFit(finding) => &finding.code,
            Self::AbsurdMisfit { .. } => "absurd_misfit",
        }
    }
}

/// What a survey will determine, by one round of the adjustment from the coarse fit; its result is not shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Preview {
    /// Points of each profiler on the rail after the coarse fit.
    pub near: Vec<usize>,
    /// Expected standard deviation of pitch, roll, yaw (degrees), lx, lz (millimetres) of each profiler; `None` where there is none.
    pub expected: Vec<Option<f64>>,
    /// What cannot be determined; empty when everything can.
    pub words: Vec<String>,
    /// The mistake without which far more would fit, where little does.
    pub mistake: Option<Finding>,
}

/// Looks at a survey without solving it.
#[must_use]
pub fn preview(scene: &RailScene, input: &RailInput) -> Preview {
    let (config, reference) = (input.joint, input.reference);
    let profilers = scene.campaign.profilers.len();
    let first = RailJointConfig {
        max_rounds: 1,
        ..config.clone()
    };
    let joint = super::run::start(scene, reference).map_or_else(
        |error| Err(error.to_string()),
        |start| super::joint::joint(scene, &first, &start).map_err(|error| error.to_string()),
    );
    let near = |p: usize| {
        let of = |t: &&super::conditions::Tie| {
            scene.campaign.points.profiler[t.row as usize] as usize == p
        };
        joint
            .as_ref()
            .map_or(0, |j| j.ties.iter().filter(of).count())
    };
    let sigma = |column: usize| {
        let sigma = joint.as_ref().ok()?.covariance[(column, column)]
            .max(0.0)
            .sqrt();
        let shown = if column % SOUGHT < 3 {
            sigma.to_degrees()
        } else {
            sigma * 1e3
        };
        (shown < 1e3).then_some(shown)
    };
    let untold = before(scene, config);
    let mut words: Vec<String> = untold.iter().map(ToString::to_string).collect();
    let refusal = match &joint {
        Ok(joint) => not_seen(scene, joint).or_else(|| undetermined(scene, config, joint)),
        Err(error) => Some(RailRefusal::NotSolved { how: error.clone() }),
    };
    words.extend(refusal.iter().map(ToString::to_string));
    // a table that was not turned explains by itself what does not fit
    let first = joint.as_ref().ok().filter(|_| untold.is_empty());
    let mistake = first.and_then(|joint| alternatives::suspected(input, scene, joint));
    Preview {
        mistake,
        near: (0..profilers).map(near).collect(),
        expected: (0..SOUGHT * profilers).map(sigma).collect(),
        words,
    }
}

fn not_seen(scene: &RailScene, joint: &RailJoint) -> Option<RailRefusal> {
    let profilers = scene.campaign.profilers.iter().enumerate();
    let count = |p: usize| {
        let of = |t: &&super::conditions::Tie| {
            scene.campaign.points.profiler[t.row as usize] as usize == p
        };
        joint.ties.iter().filter(of).count()
    };
    let mut few = profilers
        .map(|(p, profiler)| (profiler, count(p)))
        .filter(|(_, n)| *n < LEAST_TIES);
    few.next().map(|(profiler, points)| RailRefusal::NotSeen {
        profiler: profiler.name.clone(),
        points,
    })
}

/// Parameters sought whose standard deviation exceeds its limit.
fn undetermined(
    scene: &RailScene,
    config: &RailJointConfig,
    joint: &RailJoint,
) -> Option<RailRefusal> {
    let singular = matches!(joint.solution.status, Status::RankDeficient { .. });
    let mut parameters = vec![];
    for column in 0..joint.blocks.sought() {
        let (profiler, part) = (
            &scene.campaign.profilers[column / SOUGHT].name,
            column % SOUGHT,
        );
        let sigma = joint.covariance[(column, column)].max(0.0).sqrt();
        let (shown, limit, unit) = if part < 3 {
            (sigma.to_degrees(), config.max_sigma_deg, "deg")
        } else {
            (sigma, config.max_sigma_m, "m")
        };
        if !(shown <= limit) {
            let name = SOUGHT_NAMES[part];
            let shown = if shown < 1e3 {
                format!("sigma {shown:.3} {unit}")
            } else {
                "no information".to_owned()
            };
            parameters.push(format!(
                "{name} of {profiler} ({shown}, limit {limit} {unit})"
            ));
        }
    }
    (singular || !parameters.is_empty()).then_some(RailRefusal::Undetermined { parameters })
}

fn not_solved(joint: &RailJoint) -> Option<RailRefusal> {
    let how = match &joint.solution.status {
        Status::Converged if joint.stable => return None,
        Status::Converged => "the association of points with elements did not come to rest",
        Status::Stalled => "no step lowers the misfit any more",
        Status::RankDeficient { .. } => "the data leave directions undetermined",
        Status::OutOfIterations => "the iterations were used up",
    };
    Some(RailRefusal::NotSolved {
        how: how.to_owned(),
    })
}

fn absurd(joint: &RailJoint) -> Option<RailRefusal> {
    let variance_factor = joint.quality.global.variance_factor;
    (!(variance_factor <= ABSURD_VARIANCE_FACTOR))
        .then_some(RailRefusal::AbsurdMisfit { variance_factor })
}
