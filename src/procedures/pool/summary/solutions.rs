//! The outcome of one path as it stands in a result.

use nalgebra::{DMatrix, Matrix6, Vector3};

use super::super::joint::JointOutcome;
use super::super::run::{PoolInput, PoolOutcome};
use super::super::verdict::Refusal;
use crate::adjust::{self, BlockId, Limits};
use crate::calibrate::metric;
use crate::observe::Mounting;
use crate::results::{
    Angles, Estimate, ExtraParameter, JointIteration, JointSolution, MountingAngles,
    SequentialSolution, SixSigmas, Status,
};

/// The reference path.
pub fn sequential(outcome: &PoolOutcome, input: &PoolInput) -> SequentialSolution {
    match &outcome.sequential {
        Some(Ok(found)) => found.solution(),
        Some(Err(error)) => no_sequential(input, error.to_string()),
        None => no_sequential(input, not_run(outcome)),
    }
}

fn no_sequential(input: &PoolInput, message: String) -> SequentialSolution {
    let variant = match input.sequential.variant {
        super::super::config::Variant::Literal => "literal",
        super::super::config::Variant::Projected => "projected",
    };
    SequentialSolution {
        variant: variant.to_owned()
            + if input.sequential.repeated {
                ", repeated"
            } else {
                ""
            },
        status: Status::Refused,
        usable: false,
        message,
        estimate: Estimate::default(),
        iterations: vec![],
    }
}

fn not_run(outcome: &PoolOutcome) -> String {
    outcome
        .refusal
        .as_ref()
        .map_or_else(|| "did not run".to_owned(), ToString::to_string)
}

/// A joint path; refused with the run's reason where it did not come to run.
pub fn joint(
    joint: Option<&JointOutcome>,
    outcome: &PoolOutcome,
    input: &PoolInput,
) -> JointSolution {
    let Some(joint) = joint else {
        return no_joint(not_run(outcome));
    };
    let iterations = iterations(joint);
    let quality = super::quality::quality_of(joint, outcome, input);
    if let Some(refusal) = Refusal::of_joint(joint, input) {
        let status = match joint.solution.status {
            adjust::Status::RankDeficient { .. } => Status::RankDeficient,
            _ => Status::Refused,
        };
        return JointSolution {
            status,
            iterations,
            quality,
            ..no_joint(refusal.to_string())
        };
    }
    let (status, message) = ending(joint);
    JointSolution {
        status,
        usable: true,
        message,
        estimate: estimate(joint, &outcome.scene.campaign.sonar),
        standard_deviation: Some(sigmas(&joint.covariance)),
        correlation: Some(correlation(&joint.covariance)),
        extra: extra(joint),
        iterations,
        quality,
    }
}

fn no_joint(message: String) -> JointSolution {
    JointSolution {
        status: Status::Refused,
        usable: false,
        message,
        estimate: Estimate::default(),
        standard_deviation: None,
        correlation: None,
        extra: vec![],
        iterations: vec![],
        quality: None,
    }
}

fn ending(joint: &JointOutcome) -> (Status, String) {
    match (&joint.solution.status, joint.stable) {
        (adjust::Status::Stalled, _) => (
            Status::Stalled,
            "no step lowers the cost any more".to_owned(),
        ),
        (_, false) => (
            Status::Stalled,
            format!(
                "after {} rounds some soundings still change their face",
                joint.rounds.len()
            ),
        ),
        _ => (Status::Converged, String::new()),
    }
}

fn iterations(joint: &JointOutcome) -> Vec<JointIteration> {
    let numbered = joint.rounds.iter().enumerate();
    numbered
        .map(|(k, round)| JointIteration {
            outer: k as u32 + 1,
            inner: round.inner as u32,
            cost: round.cost,
            largest_step_in_sigma: round.largest_step_in_sigma,
            reassigned: round.reassigned as u64,
        })
        .collect()
}

fn estimate(joint: &JointOutcome, nominal: &Mounting) -> Estimate {
    let (roll, pitch, heading) = joint.mounting.angles();
    let r = &joint.mounting.rotation;
    Estimate {
        rotation_matrix: Some([0, 1, 2].map(|i| [0, 1, 2].map(|j| r[(i, j)]))),
        mounting_deg: Some(MountingAngles {
            roll: roll.to_degrees(),
            pitch: pitch.to_degrees(),
            heading: heading.to_degrees(),
        }),
        correction_deg: Some(angles_deg(&joint.mounting.correction_from(nominal))),
        lever_arm_m: Some(joint.mounting.lever_arm_m.into()),
        lever_arm_correction_m: Some((joint.mounting.lever_arm_m - nominal.lever_arm_m).into()),
        covariance: Some(rows(&joint.covariance)),
    }
}

/// A rotation vector (radians, body frame) as angles in degrees.
pub fn angles_deg(vector_rad: &Vector3<f64>) -> Angles {
    Angles {
        pitch: vector_rad.x.to_degrees(),
        roll: vector_rad.y.to_degrees(),
        yaw: vector_rad.z.to_degrees(),
    }
}

fn sigmas(covariance: &Matrix6<f64>) -> SixSigmas {
    let s: Vec<f64> = (0..6).map(|i| covariance[(i, i)].sqrt()).collect();
    SixSigmas {
        pitch_deg: s[0].to_degrees(),
        roll_deg: s[1].to_degrees(),
        yaw_deg: s[2].to_degrees(),
        lx_m: s[3],
        ly_m: s[4],
        lz_m: s[5],
    }
}

fn rows(m: &Matrix6<f64>) -> crate::results::Matrix6 {
    [0, 1, 2, 3, 4, 5].map(|i| [0, 1, 2, 3, 4, 5].map(|j| m[(i, j)]))
}

fn correlation(covariance: &Matrix6<f64>) -> crate::results::Matrix6 {
    let r = metric::correlation(&DMatrix::from_column_slice(6, 6, covariance.as_slice()));
    [0, 1, 2, 3, 4, 5].map(|i| [0, 1, 2, 3, 4, 5].map(|j| r[(i, j)]))
}

/// Latency and range scale, each with its verdict.
fn extra(joint: &JointOutcome) -> Vec<ExtraParameter> {
    let limits = Limits::default();
    let latency = joint
        .blocks
        .latency
        .map(|id| scalar(joint, id, "latency_s", "s", limits.second));
    let scale = joint
        .blocks
        .range_scale
        .map(|id| scalar(joint, id, "range_scale", "1", limits.one));
    latency.into_iter().chain(scale).collect()
}

fn scalar(joint: &JointOutcome, id: BlockId, name: &str, unit: &str, limit: f64) -> ExtraParameter {
    let x = &joint.solution.estimate.parameters;
    let sigma = joint.solution.cofactor[(x.offset(id), x.offset(id))].sqrt();
    let observable = sigma <= limit;
    ExtraParameter {
        name: name.to_owned(),
        value: observable.then(|| x.euclidean(id)[0]),
        standard_deviation: observable.then_some(sigma),
        unit: unit.to_owned(),
        observable,
    }
}
