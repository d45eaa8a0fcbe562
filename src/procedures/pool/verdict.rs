//! When a calibration has no usable result, and why, in words a surveyor can act on.

use std::fmt;

use nalgebra::Matrix6;

use super::joint::{JointOutcome, SIX};
use super::planes::{self, GroupPlanes};
use super::run::{Method, PoolInput, PoolOutcome};
use super::scene::{RoughMounting, Scene};
use super::ties::TieSet;
use crate::adjust::{AdjustError, Status};
use crate::calibrate::driver::ABSURD_VARIANCE_FACTOR;
use crate::calibrate::verdict::{Ending, concluded};
use crate::results::{Finding, Verdict};
use crate::target::Role;

/// Smallest share of the laser points near the target that lies on its faces.
const LEAST_LASER_FIT: f64 = 0.25;
/// Smallest share of the soundings near the target that lies on its faces.
const LEAST_SONAR_FIT: f64 = 0.06;
/// An observation so far on the wrong side of the water is not one of a wave or of noise, metres.
const WATER_MARGIN_M: f64 = 0.2;
/// Largest share of such observations: mirror images in calm water are fewer.
const MOST_ON_WRONG_SIDE: f64 = 0.1;
/// Fewest soundings of a joint adjustment.
const LEAST_TIES: usize = 50;

/// Why there is no usable result.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// No laser return near where the target was said to stand.
    TargetFar {
        /// Laser returns read.
        returns: usize,
    },
    /// Laser returns are there, but they do not look like the target.
    TargetNotFound {
        /// Share of the returns near the target that lies on its faces.
        fit: f64,
    },
    /// The scanner did not see the wall.
    NoWall,
    /// The planes that each pass gives disagree.
    ScannerDisagrees(planes::Disagreement),
    /// Observations on the wrong side of the stated water level.
    WaterLevel {
        /// Which ("laser returns").
        what: &'static str,
        /// Share of those near the target.
        share: f64,
        /// Stated height of the water level, metres, and the height that one in twenty of them lies beyond.
        heights_m: (f64, f64),
    },
    /// No or too few soundings on the target.
    NoSoundings {
        /// Soundings near it.
        near: usize,
        /// Share of them that lies on its faces.
        fit: f64,
    },
    /// The soundings fit when an axis is mirrored.
    Mirrored {
        /// What is mirrored.
        axis: &'static str,
        /// Share that fits as given and mirrored.
        fits: (f64, f64),
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
    /// Misfit far beyond the stated noise.
    AbsurdMisfit {
        /// The variance factor.
        variance_factor: f64,
    },
    /// The model does not fit: a finding of the verdict's tests.
    DoesNotFit(Box<Finding>),
    /// The reference path failed, and no other ran.
    Sequential {
        /// Its message.
        message: String,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TargetFar { returns } => write!(
                f,
                "target not found: none of {returns} laser returns lies within 2 m of the target where [target] origin and \
                 azimuth_deg put it; check origin, azimuth, the clock of the scanner and its mounting"
            ),
            Self::TargetNotFound { fit } => write!(
                f,
                "target not found: only {:.0} % of the laser returns around it lie on its faces (expected at least {:.0} %); check \
                 the target model, the scanner's mounting (mirrored or swapped axes) and its clock",
                100.0 * fit,
                100.0 * LEAST_LASER_FIT
            ),
            Self::NoWall => write!(
                f,
                "the scanner saw no wall (P2) above the water: there is nothing to compare the soundings with"
            ),
            Self::ScannerDisagrees(d) => write!(
                f,
                "the scanner's planes disagree between its {} passes: {} differs by {:.1} mm where trajectory drift and the stated \
                 uncertainty of the scanner explain {:.1} mm (one sigma); either the scanner is not calibrated, or the trajectory is worse than stated",
                d.passes,
                d.group,
                1e3 * d.apart_m,
                1e3 * d.sigma_m
            ),
            Self::WaterLevel {
                what,
                share,
                heights_m: (stated_m, seen_m),
            } => write!(
                f,
                "water level: {:.0} % of the {what} near the target lie on the wrong side of the stated water level of {stated_m:.2} m, \
                 as far as {seen_m:.2} m; check [target] water_level_m",
                100.0 * share
            ),
            Self::NoSoundings { near, fit } => write!(
                f,
                "the target was not found in the soundings: {near} soundings near it, {:.1} % of them on its faces (expected at least \
                 {:.0} %); check the nominal mounting, the beam angles' sign and unit, and the clock of the sounder",
                100.0 * fit,
                100.0 * LEAST_SONAR_FIT
            ),
            Self::Mirrored { axis, fits } => write!(
                f,
                "the soundings look mirrored: with {axis} reversed {:.0} % of them lie on the target, as given {:.0} %; check the \
                 sign convention of the beam angles",
                100.0 * fits.1,
                100.0 * fits.0
            ),
            Self::Undetermined { parameters } => {
                write!(f, "the data do not determine {}", parameters.join(", "))
            }
            Self::NotSolved { how } => {
                write!(f, "the joint adjustment ended without a solution: {how}")
            }
            Self::AbsurdMisfit { variance_factor } => write!(
                f,
                "the residuals are {:.1} times the stated noise (variance factor {variance_factor:.1}): wrong noise figures, a wrong \
                 target model, or sensors that do not belong together",
                variance_factor.sqrt()
            ),
            Self::DoesNotFit(finding) if finding.advice.is_empty() => f.write_str(&finding.seen),
            Self::DoesNotFit(finding) => write!(f, "{}; {}", finding.seen, finding.advice),
            Self::Sequential { message } => write!(f, "the reference path failed: {message}"),
        }
    }
}

impl Refusal {
    /// The engine could not go on: found by solving, so a refusal and not a fault of the input.
    #[must_use]
    pub fn failed(error: &AdjustError) -> Self {
        Self::NotSolved {
            how: error.to_string(),
        }
    }

    /// The kind of refusal as one word, for counting.
    #[must_use]
    pub fn code(&self) -> &str {
        match self {
            Self::TargetFar { .. } => "target_far",
            Self::TargetNotFound { .. } => "target_not_found",
            Self::NoWall => "no_wall",
            Self::ScannerDisagrees(_) => "scanner_disagrees",
            Self::WaterLevel { .. } => "water_level",
            Self::NoSoundings { .. } => "no_soundings",
            Self::Mirrored { .. } => "mirrored",
            Self::Undetermined { .. } => "undetermined",
            Self::NotSolved { .. } => "not_solved",
            Self::AbsurdMisfit { .. } => "absurd_misfit",
            Self::DoesNotFit(finding) => &finding.code,
            Self::Sequential { .. } => "sequential",
        }
    }

    /// What the laser returns alone can prove wrong.
    #[must_use]
    pub fn of_scanner(scene: &Scene, planes: &GroupPlanes, wide: &TieSet) -> Option<Self> {
        if scene.laser_near == 0 {
            return Some(Self::TargetFar {
                returns: scene.campaign.laser.len(),
            });
        }
        if scene.laser_fit < LEAST_LASER_FIT {
            return Some(Self::TargetNotFound {
                fit: scene.laser_fit,
            });
        }
        let wall = scene.target.group_of_role(Role::P2);
        if wall.is_some_and(|g| planes[g].is_none()) || planes.iter().all(Option::is_none) {
            return Some(Self::NoWall);
        }
        Self::of_water(scene, "laser returns", &scene.return_heights_m(), -1.0)
            .or_else(|| planes::disagreement(scene, wide).map(Self::ScannerDisagrees))
    }

    /// Observations that lie on the wrong side of the stated water level; `side` is up for soundings and down for returns.
    #[must_use]
    pub fn of_water(
        scene: &Scene,
        what: &'static str,
        heights_m: &[f64],
        side: f64,
    ) -> Option<Self> {
        let stated_m = scene.campaign.water_level_m;
        let mut beyond_m: Vec<f64> = heights_m.iter().map(|z| side * (z - stated_m)).collect();
        beyond_m.sort_by(|a, b| b.total_cmp(a));
        let wrong = beyond_m.partition_point(|beyond| *beyond > WATER_MARGIN_M);
        let share = wrong as f64 / beyond_m.len().max(1) as f64;
        let far_m = beyond_m.get(beyond_m.len() / 20)?;
        (share > MOST_ON_WRONG_SIDE).then_some(Self::WaterLevel {
            what,
            share,
            heights_m: (stated_m, stated_m + side * far_m),
        })
    }

    /// What the rough registration of the soundings can prove wrong.
    #[must_use]
    pub fn of_soundings(rough: &RoughMounting) -> Option<Self> {
        if let Some((axis, mirrored)) = rough.mirrored
            && mirrored > 1.5 * rough.fit
        {
            return Some(Self::Mirrored {
                axis,
                fits: (rough.fit, mirrored),
            });
        }
        let found = rough.near >= LEAST_TIES && rough.fit >= LEAST_SONAR_FIT;
        (!found).then_some(Self::NoSoundings {
            near: rough.near,
            fit: rough.fit,
        })
    }

    /// What the solutions prove wrong: the joint one decides where it ran.
    #[must_use]
    pub fn of_solution(outcome: &PoolOutcome, input: &PoolInput) -> Option<Self> {
        match (&outcome.joint, &outcome.sequential) {
            (Some(joint), _) => Self::of_joint(joint, input),
            (None, Some(Err(error))) if input.method == Method::Reference => {
                Some(Self::Sequential {
                    message: error.to_string(),
                })
            }
            _ => None,
        }
    }

    /// What a joint outcome proves wrong.
    #[must_use]
    pub fn of_joint(joint: &JointOutcome, input: &PoolInput) -> Option<Self> {
        if joint.soundings.len() < LEAST_TIES {
            return Some(Self::NoSoundings {
                near: joint.soundings.len(),
                fit: 0.0,
            });
        }
        if let Some(parameters) = undetermined(joint, input) {
            return Some(Self::Undetermined { parameters });
        }
        match &joint.solution.status {
            Status::Converged | Status::Stalled => {}
            Status::RankDeficient { .. } => {
                return Some(Self::Undetermined {
                    parameters: joint.undetermined_directions(),
                });
            }
            Status::OutOfIterations => {
                return Some(Self::NotSolved {
                    how: "out of iterations".to_owned(),
                });
            }
        }
        if let Some(finding) = joint.doubted.withdrawn() {
            return Some(Self::DoesNotFit(Box::new(finding.clone())));
        }
        joint
            .variance_factor()
            .filter(|v| *v > ABSURD_VARIANCE_FACTOR)
            .map(|variance_factor| Self::AbsurdMisfit { variance_factor })
    }
}

impl PoolOutcome<'_> {
    /// The verdict: what refused the result first, then what the joint path's tests found.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let joint = self.joint.as_ref();
        let ending = match &self.refusal {
            None => Ending::Usable,
            Some(Refusal::DoesNotFit(first)) => Ending::Withdrawn(first),
            Some(refusal) => Ending::Refused {
                code: refusal.code(),
                seen: refusal.to_string(),
                determined: !matches!(
                    refusal,
                    Refusal::Undetermined { .. } | Refusal::NotSolved { .. }
                ),
            },
        };
        concluded(ending, joint.map(|joint| &joint.doubted))
    }
}

/// Parameters that a joint outcome leaves undetermined.
fn undetermined(joint: &JointOutcome, input: &PoolInput) -> Option<Vec<String>> {
    let uncovered = joint
        .judgement
        .as_ref()
        .map_or([false; 6], |j| j.coverage.uncovered());
    let names = undetermined_by(&joint.covariance, uncovered, input);
    (!names.is_empty()).then_some(names)
}

/// Parameters whose standard deviation exceeds the configured limit, or that only the boat's motion determines (`uncovered`),
/// unless they are held or have a prior of their own.
#[must_use]
pub fn undetermined_by(
    covariance: &Matrix6<f64>,
    uncovered: [bool; 6],
    input: &PoolInput,
) -> Vec<String> {
    let p = &input.joint.prior;
    let priors = [
        p.pitch_sigma_deg,
        p.roll_sigma_deg,
        p.yaw_sigma_deg,
        p.lx_sigma_m,
        p.ly_sigma_m,
        p.lz_sigma_m,
    ];
    let mut names = vec![];
    for (i, name) in SIX.iter().enumerate() {
        if priors[i].is_some() || input.joint.hold.iter().any(|h| h == name) {
            continue;
        }
        let sigma = covariance[(i, i)].sqrt();
        let (sigma, limit, unit) = if i < 3 {
            (sigma.to_degrees(), input.joint.max_sigma_deg, "deg")
        } else {
            (sigma, input.joint.max_sigma_m, "m")
        };
        if !(sigma <= limit) {
            names.push(format!(
                "{name} (standard deviation {sigma:.3} {unit}, limit {limit} {unit})"
            ));
        } else if uncovered[i] {
            names.push(format!(
                "{name} (none of the faces that were hit looks that way: only the boat's motion would determine it)"
            ));
        }
    }
    names
}
