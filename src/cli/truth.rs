//! A result against the truth of a simulated survey.

use comfy_table::CellAlignment;
use nalgebra::{Matrix3, Vector3, Vector6};

use crate::geometry::rotation;
use crate::report::text::ruled_table;
use crate::results::{self, Angles, Estimate, PoolResult};
use crate::simulate::Truth;

const ROWS: [(&str, &str, f64); 6] = [
    ("pitch", "deg", 1.0),
    ("roll", "deg", 1.0),
    ("yaw", "deg", 1.0),
    ("lx right", "mm", 1e3),
    ("ly forward", "mm", 1e3),
    ("lz up", "mm", 1e3),
];

/// The truth as the report shows it.
pub fn for_report(truth: &Truth) -> results::Truth {
    let c = truth.correction_deg;
    let arm = truth.lever_arm() - Vector3::from(truth.nominal_lever_arm_m);
    results::Truth {
        correction_deg: Angles {
            pitch: c.pitch,
            roll: c.roll,
            yaw: c.yaw,
        },
        lever_arm_correction_m: arm.into(),
    }
}

/// A table of each path's errors, the joint one's also in its own standard deviations; empty when nothing was found.
pub fn table(result: &PoolResult, truth: &Truth) -> String {
    let solutions = &result.solutions;
    let sequential = solutions
        .sequential
        .as_ref()
        .and_then(|s| errors(&s.estimate, truth));
    let simple = solutions
        .joint_simple
        .as_ref()
        .and_then(|s| errors(&s.estimate, truth));
    let joint = solutions
        .joint
        .as_ref()
        .and_then(|s| Some((errors(&s.estimate, truth)?, s.standard_deviation?)));
    let mut table = ruled_table();
    table.set_header([
        "error against the truth",
        "sequential",
        "joint",
        "joint, in sigmas",
        "joint, simple model",
    ]);
    for (i, (name, unit, scale)) in ROWS.iter().enumerate() {
        let number =
            |v: Option<Vector6<f64>>| v.map_or(String::new(), |v| format!("{:+.4}", v[i] * scale));
        let sigmas = joint.map_or(String::new(), |(e, s)| {
            let sigma = [s.pitch_deg, s.roll_deg, s.yaw_deg, s.lx_m, s.ly_m, s.lz_m][i];
            format!("{:+.1}", e[i] / sigma)
        });
        table.add_row([
            format!("{name}, {unit}"),
            number(sequential),
            number(joint.map(|j| j.0)),
            sigmas,
            number(simple),
        ]);
    }
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    if joint.is_none() && sequential.is_none() {
        String::new()
    } else {
        format!("{}\n", table.trim_fmt())
    }
}

/// Rotation vector (degrees, body frame) and lever arm (metres) from the truth to the estimate.
fn errors(estimate: &Estimate, truth: &Truth) -> Option<Vector6<f64>> {
    let found = Matrix3::from_row_iterator(estimate.rotation_matrix?.into_iter().flatten());
    let turn = rotation::log(&(found * truth.rotation().transpose())).map(f64::to_degrees);
    let arm = Vector3::from(estimate.lever_arm_m?) - truth.lever_arm();
    Some(Vector6::new(turn.x, turn.y, turn.z, arm.x, arm.y, arm.z))
}
