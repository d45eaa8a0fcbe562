//! What the reference path found, and how to write it into a result.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::Serialize;

use super::super::config::Variant;
use super::super::summary::SENSOR;
use super::OffsetStep;
use crate::calibrate::solution::{Mounted, angles_deg};
use crate::observe::{ArrayMountings, Mounting};
use crate::results::{Angles, Solution, Status};

/// How the path ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// Every pair of normals below the threshold, or all three updates below tolerance.
    Converged {
        /// Largest angle between normals that remains, radians.
        largest_rad: f64,
    },
    /// The passes repeat themselves; the best is kept.
    Cycle {
        /// Passes after which they repeat.
        period: usize,
        /// Number of the pass kept.
        kept_pass: u32,
        /// Its largest angle between normals, radians.
        largest_rad: f64,
    },
    /// Many passes without a smaller largest angle; the best is kept.
    NoProgress {
        /// Number of the pass kept.
        kept_pass: u32,
        /// Its largest angle between normals, radians.
        largest_rad: f64,
    },
    /// Out of passes; the best is kept.
    OutOfPasses {
        /// Number of the pass kept.
        kept_pass: u32,
        /// Its largest angle between normals, radians.
        largest_rad: f64,
    },
    /// Angles and offsets, repeated in turn, did not become stable.
    OutOfRounds {
        /// Rounds done.
        rounds: u32,
    },
}

impl End {
    /// The end as a result's status.
    #[must_use]
    pub fn status(&self) -> Status {
        match self {
            Self::Converged { .. } => Status::Converged,
            Self::Cycle { .. } | Self::NoProgress { .. } => Status::Stalled,
            Self::OutOfPasses { .. } | Self::OutOfRounds { .. } => Status::OutOfIterations,
        }
    }

    /// The end in words.
    #[must_use]
    pub fn message(&self) -> String {
        let kept = |pass: u32, angle: f64| {
            format!(
                "pass {pass} kept, largest angle between normals {:.3} deg",
                angle.to_degrees()
            )
        };
        match *self {
            Self::Converged { largest_rad } => {
                format!(
                    "largest angle between normals {:.3} deg",
                    largest_rad.to_degrees()
                )
            }
            Self::Cycle {
                period,
                kept_pass,
                largest_rad,
            } => format!("{period}-step cycle; {}", kept(kept_pass, largest_rad)),
            Self::NoProgress {
                kept_pass,
                largest_rad,
            } => format!("no progress; {}", kept(kept_pass, largest_rad)),
            Self::OutOfPasses {
                kept_pass,
                largest_rad,
            } => format!("out of passes; {}", kept(kept_pass, largest_rad)),
            Self::OutOfRounds { rounds } => {
                format!("angles and offsets not stable after {rounds} rounds")
            }
        }
    }
}

/// One pass of the angle iteration: a mounting and the angles between the normals under it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pass {
    /// From 0, the mounting as given.
    pub number: u32,
    /// Angles between the scanner's and the multibeam's normals of P1 to P4, radians.
    pub angle_rad: [f64; 4],
    /// Correction so far, `log(R R_nominal^T)`, body frame, radians.
    pub correction_rad: Vector3<f64>,
}

/// The path's result.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Which angles were taken.
    pub variant: Variant,
    /// Whether angles and offsets were repeated in turn.
    pub repeated: bool,
    /// How it ended (the last round's end where repeated).
    pub end: End,
    /// The mounting as given.
    pub nominal: Mounting,
    /// The mounting found.
    pub mounting: Mounting,
    /// Every pass, the mounting as given first.
    pub passes: Vec<Pass>,
    /// Every offset, in the order found.
    pub offsets: Vec<OffsetStep>,
    /// Rounds of angles and offsets.
    pub rounds: u32,
}

/// What only this path has, as it stands in a result.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Details {
    /// Which variant ran: `literal` or `projected`, with `, repeated` where angles and offsets were repeated in turn.
    variant: String,
    /// Every pass.
    passes: Vec<PassDetails>,
}

/// One pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct PassDetails {
    /// From 0, the mounting as given; pass k is the mounting after k corrections.
    pass: u32,
    /// Angle between the scanner's and the multibeam's normal under this mounting, by plane (`P1` to `P4`), degrees.
    angle_deg: BTreeMap<&'static str, f64>,
    /// Correction of this mounting, body frame.
    correction_deg: Angles,
}

impl Outcome {
    /// The outcome as it stands in a result file. A stalled end counts as usable, being out of passes does not. `arrays`: the two
    /// arrays before the calibration, where the mounting stands for both.
    #[must_use]
    pub fn solution(&self, arrays: Option<&ArrayMountings>) -> Solution {
        let status = self.end.status();
        let mounted = Mounted {
            name: SENSOR,
            rotation: (&self.mounting.rotation, &self.nominal.rotation),
            lever_arm_m: Some((self.mounting.lever_arm_m, self.nominal.lever_arm_m)),
            covariance: None,
            arrays,
        };
        Solution {
            usable: matches!(status, Status::Converged | Status::Stalled),
            parameters: mounted.parameters(""),
            mountings: vec![mounted.result()],
            details: self.details(),
            ..Solution::without_result(status, self.end.message())
        }
    }

    fn details(&self) -> serde_json::Value {
        let details = Details {
            variant: self.variant.in_words(self.repeated),
            passes: self.passes.iter().map(pass_details).collect(),
        };
        serde_json::to_value(details).unwrap_or_default()
    }
}

fn pass_details(pass: &Pass) -> PassDetails {
    let angles = pass.angle_rad.map(f64::to_degrees);
    PassDetails {
        pass: pass.number,
        angle_deg: ["P1", "P2", "P3", "P4"].into_iter().zip(angles).collect(),
        correction_deg: angles_deg(&pass.correction_rad),
    }
}
