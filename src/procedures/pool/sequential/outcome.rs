//! What the reference path found, and how to write it into a result.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use super::super::config::Variant;
use super::OffsetStep;
use crate::observe::Mounting;
use crate::results::{
    Angles, Estimate, MountingAngles, SequentialIteration, SequentialSolution, Status,
};

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

impl Outcome {
    /// The outcome as it stands in a result file. A stalled end counts as usable, being out of passes does not.
    #[must_use]
    pub fn solution(&self) -> SequentialSolution {
        let status = self.end.status();
        SequentialSolution {
            variant: self.variant_name(),
            status,
            usable: matches!(status, Status::Converged | Status::Stalled),
            message: self.end.message(),
            estimate: self.estimate(),
            iterations: self.passes.iter().map(iteration).collect(),
        }
    }

    fn variant_name(&self) -> String {
        let name = match self.variant {
            Variant::Literal => "literal",
            Variant::Projected => "projected",
        };
        let repeated = if self.repeated { ", repeated" } else { "" };
        format!("{name}{repeated}")
    }

    fn estimate(&self) -> Estimate {
        let (roll, pitch, heading) = self.mounting.angles();
        let r = &self.mounting.rotation;
        Estimate {
            rotation_matrix: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)]))),
            mounting_deg: Some(MountingAngles {
                roll: roll.to_degrees(),
                pitch: pitch.to_degrees(),
                heading: heading.to_degrees(),
            }),
            correction_deg: Some(angles(&self.mounting.correction_from(&self.nominal))),
            lever_arm_m: Some(self.mounting.lever_arm_m.into()),
            lever_arm_correction_m: Some(
                (self.mounting.lever_arm_m - self.nominal.lever_arm_m).into(),
            ),
            covariance: None,
        }
    }
}

fn iteration(pass: &Pass) -> SequentialIteration {
    let names = ["P1", "P2", "P3", "P4"].map(str::to_owned);
    SequentialIteration {
        pass: pass.number,
        angle_deg: names
            .into_iter()
            .zip(pass.angle_rad.map(f64::to_degrees))
            .collect::<BTreeMap<_, _>>(),
        correction_deg: angles(&pass.correction_rad),
    }
}

fn angles(vector_rad: &Vector3<f64>) -> Angles {
    Angles {
        pitch: vector_rad.x.to_degrees(),
        roll: vector_rad.y.to_degrees(),
        yaw: vector_rad.z.to_degrees(),
    }
}
