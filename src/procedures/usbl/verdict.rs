//! When a USBL calibration has no usable result, and what the layout of the beacons can and cannot tell, in words.

use std::fmt;

use nalgebra::{Matrix3, Vector3};

use super::UsblOutcome;
use super::config::JointConfig;
use super::joint::{JointOutcome, MOUNTING, SOUGHT, sought};
use super::reference::ReferenceError;
use super::scene::Scene;
use crate::adjust::{AdjustError, Status, Unit};
use crate::calibrate::driver::ABSURD_VARIANCE_FACTOR;
use crate::calibrate::verdict::{Ending, concluded};
use crate::results::{Finding, Verdict};

/// A larger share of gross errors than this leaves nothing to trust.
const MOST_GROSS: f64 = 0.4;
/// Beacons closer to one line (or plane) than this part of their extent are called collinear (coplanar).
const THIN: f64 = 0.05;

/// Why there is no usable result.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// No fix of a common beacon.
    NoBeacon,
    /// Only one common beacon.
    OneBeacon {
        /// Its name.
        beacon: String,
        /// What is left free.
        parameters: Vec<String>,
    },
    /// Parameters that the data do not determine.
    Undetermined {
        /// Their names with the standard deviation and the limit.
        parameters: Vec<String>,
        /// The layout in words, empty when it is not to blame.
        layout: String,
    },
    /// The engine did not end with a solution.
    NotSolved {
        /// How it ended.
        how: String,
    },
    /// Too many fixes far from all others.
    TooManyGross {
        /// Gross errors.
        gross: usize,
        /// Fixes of common beacons.
        fixes: usize,
    },
    /// The model does not fit: a finding of the verdict's tests.
    DoesNotFit(Box<Finding>),
    /// Misfit far beyond the stated noise.
    AbsurdMisfit {
        /// The variance factor.
        variance_factor: f64,
    },
    /// The reference path failed, and no other was asked for.
    Reference {
        /// Its message.
        message: String,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoBeacon => write!(
                f,
                "no beacon with role common has a fix: check the roles and names in the control file"
            ),
            Self::OneBeacon { beacon, parameters } => write!(
                f,
                "only one common beacon ({beacon}) has fixes: the rotation about the line of sight to it is not determined; not \
                 determined: {}",
                parameters.join(", ")
            ),
            Self::Undetermined { parameters, layout } if layout.is_empty() => {
                write!(f, "the data do not determine {}", parameters.join(", "))
            }
            Self::Undetermined { parameters, layout } => write!(
                f,
                "the data do not determine {}: {layout}",
                parameters.join(", ")
            ),
            Self::NotSolved { how } => {
                write!(f, "the joint adjustment ended without a solution: {how}")
            }
            Self::TooManyGross { gross, fixes } => write!(
                f,
                "{gross} of {fixes} fixes are far from what the others say: wrong noise figures, wrong control coordinates, beacons \
                 mixed up, or an another angle convention than the one stated"
            ),
            Self::DoesNotFit(finding) if finding.advice.is_empty() => f.write_str(&finding.seen),
            Self::DoesNotFit(finding) => write!(f, "{}; {}", finding.seen, finding.advice),
            Self::AbsurdMisfit { variance_factor } => write!(
                f,
                "the residuals are {:.1} times the stated noise (variance factor {variance_factor:.1}): wrong noise figures, wrong \
                 control coordinates, or axes other than right, forward, up",
                variance_factor.sqrt()
            ),
            Self::Reference { message } => write!(f, "the reference path failed: {message}"),
        }
    }
}

impl Refusal {
    /// The kind of refusal as one word, for counting.
    #[must_use]
    pub fn code(&self) -> &str {
        match self {
            Self::NoBeacon => "no_beacon",
            Self::OneBeacon { .. } => "one_beacon",
            Self::Undetermined { .. } => "undetermined",
            Self::NotSolved { .. } => "not_solved",
            Self::TooManyGross { .. } => "too_many_gross",
            Self::AbsurdMisfit { .. } => "absurd_misfit",
            Self::DoesNotFit(finding) => &finding.code,
            Self::Reference { .. } => "reference",
        }
    }

    /// Whether the layout leaves parameters open, to whichever path.
    #[must_use]
    pub fn is_of_layout(&self) -> bool {
        matches!(
            self,
            Self::NoBeacon | Self::OneBeacon { .. } | Self::Undetermined { .. }
        )
    }

    /// The engine could not go on.
    #[must_use]
    pub fn failed(error: &AdjustError) -> Self {
        Self::NotSolved {
            how: error.to_string(),
        }
    }

    /// What the reference path's error proves.
    #[must_use]
    pub fn of_reference(error: &ReferenceError) -> Self {
        Self::Reference {
            message: error.to_string(),
        }
    }

    /// What a joint outcome proves wrong.
    #[must_use]
    pub fn of_joint(joint: &JointOutcome, scene: &Scene, config: &JointConfig) -> Option<Self> {
        let layout = Layout::of(scene);
        let free = undetermined(joint, config);
        if let [only] = scene.common_beacons()[..]
            && !free.is_empty()
        {
            return Some(Self::OneBeacon {
                beacon: scene.campaign.beacons[only as usize].point.name.clone(),
                parameters: free,
            });
        }
        if !free.is_empty() {
            return Some(Self::Undetermined {
                parameters: free,
                layout: layout.in_words(),
            });
        }
        let (gross, fixes) = (joint.gross.len(), scene.common.len());
        if gross as f64 > MOST_GROSS * fixes as f64 {
            return Some(Self::TooManyGross { gross, fixes });
        }
        if joint.solution.status == Status::OutOfIterations {
            return Some(Self::NotSolved {
                how: "out of iterations".to_owned(),
            });
        }
        if let Some(finding) = joint.doubted.withdrawn() {
            return Some(Self::DoesNotFit(Box::new(finding.clone())));
        }
        let factor = joint.judgement.as_ref()?.quality.global.variance_factor;
        (factor > ABSURD_VARIANCE_FACTOR).then_some(Self::AbsurdMisfit {
            variance_factor: factor,
        })
    }
}

impl UsblOutcome<'_> {
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
                determined: matches!(
                    refusal,
                    Refusal::TooManyGross { .. } | Refusal::AbsurdMisfit { .. }
                ),
            },
        };
        concluded(ending, joint.map(|joint| &joint.doubted))
    }
}

/// Parameters sought with a standard deviation beyond the limit, or in a singular direction.
fn undetermined(joint: &JointOutcome, config: &JointConfig) -> Vec<String> {
    let mut singular = [false; SOUGHT];
    if let Status::RankDeficient { directions } = &joint.solution.status {
        for (column, flag) in singular.iter_mut().enumerate() {
            *flag = directions.iter().any(|d| d[column].abs() > 1e-6);
        }
    }
    let mut names = vec![];
    for (column, (name, unit)) in sought().into_iter().enumerate() {
        let sigma = joint.covariance[(column, column)].sqrt();
        let (sigma, limit, unit) = match unit {
            Unit::Radian => (sigma.to_degrees(), config.max_sigma_deg, "deg"),
            Unit::Metre => (sigma, config.max_sigma_m, "m"),
            Unit::Second | Unit::One => (sigma, f64::INFINITY, ""),
        };
        if singular[column] {
            names.push(format!(
                "{name} (the normal matrix is singular in its direction)"
            ));
        } else if !(sigma <= limit) {
            names.push(format!(
                "{name} (standard deviation {sigma:.3} {unit}, limit {limit} {unit})"
            ));
        }
    }
    names
}

/// What the places of the common beacons allow.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Common beacons with fixes.
    pub beacons: usize,
    /// Spread of the beacons along their three principal axes, root mean square, metres, largest first.
    pub spread_m: [f64; 3],
    /// Smallest angle that the lines of sight span about their mean direction, radians, root mean square.
    pub sight_rad: f64,
}

impl Layout {
    /// Of the surveyed positions.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let common = scene.common_beacons();
        let place = |b: &u32| scene.campaign.beacons[*b as usize].point.position_m;
        let places: Vec<Vector3<f64>> = common.iter().map(place).collect();
        let n = places.len().max(1) as f64;
        let mean = places.iter().sum::<Vector3<f64>>() / n;
        let moment: Matrix3<f64> = places
            .iter()
            .map(|p| (p - mean) * (p - mean).transpose())
            .sum();
        let mut spread: Vec<f64> = (moment / n)
            .symmetric_eigenvalues()
            .iter()
            .map(|v| v.max(0.0).sqrt())
            .collect();
        spread.sort_by(|a, b| b.total_cmp(a));
        let sights: Matrix3<f64> = places
            .iter()
            .map(Vector3::normalize)
            .map(|d| d * d.transpose())
            .sum();
        let mut values: Vec<f64> = (sights / n)
            .symmetric_eigenvalues()
            .iter()
            .copied()
            .collect();
        values.sort_by(|a, b| b.total_cmp(a));
        Self {
            beacons: places.len(),
            spread_m: [spread[0], spread[1], spread[2]],
            sight_rad: values[1].max(0.0).sqrt(),
        }
    }

    /// Whether the beacons lie on a line, or nearly.
    #[must_use]
    pub fn is_line(&self) -> bool {
        self.beacons > 1 && self.spread_m[1] < THIN * self.spread_m[0]
    }

    /// Whether they lie in a plane, or nearly.
    #[must_use]
    pub fn is_plane(&self) -> bool {
        self.beacons > 2 && !self.is_line() && self.spread_m[2] < THIN * self.spread_m[0]
    }

    /// Whether all common beacons lie in one direction, so that the rotation about it stays free.
    #[must_use]
    pub fn is_one_direction(&self) -> bool {
        self.beacons < 2 || self.sight_rad < THIN * THIN
    }

    /// Whether it determines the three angles of the mounting.
    #[must_use]
    pub fn determines_mounting(&self) -> bool {
        !self.is_one_direction()
    }

    /// The weakness of the layout; empty when it has none.
    #[must_use]
    pub fn in_words(&self) -> String {
        let [first, second, third] = self.spread_m;
        match self.beacons {
            0 => "no common beacon has a fix".to_owned(),
            1 => "one common beacon gives one direction: the rotation about the line of sight to it stays free".to_owned(),
            _ if self.is_one_direction() => format!(
                "all common beacons lie in one direction from the transducer (within {:.2} deg): the rotation about it stays free",
                self.sight_rad.to_degrees()
            ),
            2 => "two common beacons: a turn about the line through them can hide in the transducer's position, which only the \
                  total station fixes"
                .to_owned(),
            _ if self.is_line() => format!(
                "the common beacons lie nearly on one line (spread {first:.2} m along it, {second:.3} m beside it): a turn about that \
                 line can hide in the transducer's position, which only the total station fixes"
            ),
            _ if self.is_plane() => format!(
                "the common beacons lie in one plane (spread {third:.3} m across it): the distance of the transducer from that plane \
                 and the range scale separate only by the angles"
            ),
            _ => String::new(),
        }
    }
}

/// Parameters of the mounting that rest on the total station's position of the transducer, as sentences.
#[must_use]
pub fn rests_on_survey(joint: &JointOutcome, config: &JointConfig) -> Vec<String> {
    let Some(judgement) = &joint.judgement else {
        return vec![];
    };
    let mut found = vec![];
    for (column, name) in MOUNTING.iter().enumerate() {
        let alone = judgement.without_survey[column].to_degrees();
        if alone > config.max_sigma_deg {
            let alone = if alone.is_finite() {
                format!("{alone:.2} deg")
            } else {
                "without bound".to_owned()
            };
            found.push(format!(
                "{name} rests on the surveyed position of the transducer: without it its standard deviation would be {alone}"
            ));
        }
    }
    found
}
