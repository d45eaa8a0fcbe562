//! The report's own section of a USBL calibration.

use serde::{Deserialize, Serialize};

use super::super::UsblOutcome;
use super::super::joint::{SCALE, TRANSDUCER};
use super::super::simulate::Truth;
use super::super::verify::BeaconResiduals;
use super::words;
use crate::calibrate::truth::{TrueMounting, TrueValues};
use crate::results::{Calibration, Page};

/// Fixes of a beacon that the pictures show at the most.
const SHOWN: usize = 400;

/// What the pictures are drawn from; `result.json` does not hold it.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct UsblSamples {
    /// Some of the fixes of every beacon, evenly thinned.
    pub fixes: Vec<UsblFixSample>,
}

/// One fix of the pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UsblFixSample {
    /// Index into [`UsblDetails::beacons`](super::UsblDetails::beacons).
    pub beacon: u32,
    /// Time from the first fix, seconds.
    pub time_s: f64,
    /// Predicted minus surveyed beacon with the reference path, east, north, up, metres.
    pub reference_m: Option<[f64; 3]>,
    /// The same with the joint path.
    pub joint_m: Option<[f64; 3]>,
    /// Range, first and second component of the direction by the path that is shown (the joint one where it ran): predicted minus
    /// surveyed over its stated sigma.
    pub in_sigmas: Option<[f64; 3]>,
    /// Whether it is an outlier (under the joint path where it ran).
    pub outlier: bool,
}

/// What the report of an outcome shows beside its result; `title` names the survey, `truth` is known of a simulated one.
///
/// # Errors
/// None for samples made here; `serde_json` does not promise it.
pub fn page(
    outcome: &UsblOutcome,
    result: &Calibration,
    title: &str,
    truth: Option<&Truth>,
) -> serde_json::Result<Page> {
    Ok(Page {
        tables: words::tables(outcome, result),
        title: title.to_owned(),
        kind: "calibration of an ultra-short baseline",
        data: serde_json::to_value(samples(outcome))?,
        scripts: &[
            include_str!("../page/page.js"),
            include_str!("../page/residuals.js"),
        ],
        against_truth: truth.map(|t| true_values(t).against(&result.solutions)),
    })
}

/// The truth by the names of the parameters.
#[must_use]
pub fn true_values(truth: &Truth) -> TrueValues {
    let mounting = TrueMounting {
        prefix: String::new(),
        rotation: truth.rotation(),
        lever_arm_m: None,
    };
    let mut others: Vec<_> = TRANSDUCER.into_iter().zip(truth.transducer_m).collect();
    others.push((SCALE, truth.range_scale));
    TrueValues {
        mountings: vec![mounting],
        others,
    }
}

/// Residuals for the pictures.
fn samples(outcome: &UsblOutcome) -> UsblSamples {
    let fixes = &outcome.scene.campaign.fixes;
    let begin_s = fixes.time_s.first().copied().unwrap_or(0.0);
    let mut all = vec![];
    for beacon in 0..outcome.scene.campaign.beacons.len() as u32 {
        let find = |list: &[BeaconResiduals], fix: u32| {
            let own = list.iter().find(|r| r.beacon == beacon)?;
            own.residuals.iter().find(|r| r.fix == fix).copied()
        };
        let rows: Vec<u32> = (0..fixes.len() as u32)
            .filter(|fix| fixes.beacon[*fix as usize] == beacon)
            .collect();
        for &fix in rows.iter().step_by(rows.len().div_ceil(SHOWN).max(1)) {
            let reference = find(&outcome.reference_residuals, fix);
            let joint = find(&outcome.joint_residuals, fix);
            all.push(UsblFixSample {
                beacon,
                time_s: fixes.time_s[fix as usize] - begin_s,
                reference_m: reference.map(|r| r.enu_m.into()),
                joint_m: joint.map(|r| r.enu_m.into()),
                in_sigmas: joint.or(reference).map(|r| r.in_sigmas),
                outlier: joint.or(reference).is_some_and(|r| r.outlier),
            });
        }
    }
    UsblSamples { fixes: all }
}
