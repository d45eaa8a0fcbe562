//! Quality figures of the joint path as they stand in a result ([`crate::adjust::assess`]).

use super::super::config::Drift;
use super::super::joint::{Components, JointOutcome, RETURNS, SIX, SOUNDINGS};
use super::super::run::{PoolInput, PoolOutcome};
use crate::adjust::{self, Unit};
use crate::calibrate::quality::{Judged, block_priors, group, named_prior, quality};
use crate::results::{GroupQuality, Prior, Quality};

/// What a variance component covers.
const TOGETHER: &str = "for range and angles together: they share each condition";

/// Everything that the engine says of the last adjustment; `None` when it did not end with an estimate.
#[must_use]
pub fn quality_of(
    joint: &JointOutcome,
    outcome: &PoolOutcome,
    input: &PoolInput,
) -> Option<Quality> {
    let judgement = joint.judgement.as_ref()?;
    let groups = judgement.quality.groups.iter();
    quality(Judged {
        quality: &judgement.quality,
        observability: &judgement.observability,
        parameters: &joint.solution.estimate.parameters,
        sought: &SIX.map(str::to_owned),
        priors: priors(joint, outcome, input),
        groups: groups
            .map(|g| group_of(g, judgement.components.as_ref()))
            .collect(),
        observation: &|place| observation(judgement.worst_rows[place], outcome),
        advice: &advice,
    })
}

fn group_of(g: &adjust::GroupQuality, components: Option<&Components>) -> GroupQuality {
    let name = match g.group {
        SOUNDINGS => "multibeam range and angles",
        RETURNS => "laser range and angle",
        _ => "other",
    };
    let one_step = group(g, name, TOGETHER);
    let Some((components, found)) = components.and_then(|c| {
        let found = c
            .groups
            .iter()
            .find(|v| v.group == g.group && v.estimated)?;
        Some((c, found))
    }) else {
        return one_step;
    };
    let how = if components.converged {
        "iterated"
    } else {
        "iterated, still changing by more than 1 % at the last round"
    };
    GroupQuality {
        variance_component: Some(found.factor),
        standard_deviation: Some(found.sigma),
        note: format!("{how}, by least squares without a kernel; {TOGETHER}"),
        ..one_step
    }
}

/// Every prior that entered as an observation, blocks and trajectory.
fn priors(joint: &JointOutcome, outcome: &PoolOutcome, input: &PoolInput) -> Vec<Prior> {
    let mut all = block_priors(&joint.solution.estimate.parameters);
    let noise = &outcome.scene.campaign.trajectory.noise;
    if input.joint.drift == Drift::On {
        let mut add = |name: &str, sigma: f64, unit: Unit| {
            if sigma > 0.0 {
                all.push(named_prior(name, sigma, unit));
            }
        };
        add(
            "trajectory position, white per record and axis",
            noise.position_m,
            Unit::Metre,
        );
        add(
            "trajectory drift per axis",
            noise.position_drift_m,
            Unit::Metre,
        );
        add(
            "roll and pitch, white per record",
            noise.roll_pitch_rad,
            Unit::Radian,
        );
        add("heading, white per record", noise.heading_rad, Unit::Radian);
        add("slow heading error", noise.heading_drift_rad, Unit::Radian);
    }
    all
}

/// A worst condition's observation, by its group and raw row.
fn observation((group, row): (u16, u32), outcome: &PoolOutcome) -> String {
    if group != SOUNDINGS {
        return format!("laser return {row}");
    }
    let (ping, beam) = outcome.scene.campaign.soundings.name(row as usize);
    format!("ping {ping} beam {beam}")
}

fn advice(a: &str, b: &str) -> &'static str {
    let both = |p: &str, q: &str| (a == p && b == q) || (a == q && b == p);
    if both("yaw", "ly") {
        "; a pass at another distance separates them, repeating a pass does not"
    } else if both("pitch", "lz") || both("roll", "lz") {
        "; more horizontal faces, at other heights and distances, separate them"
    } else if both("range_scale", "lx") {
        "; a pass at another distance separates them"
    } else {
        ""
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::VarianceComponent;

    #[test]
    fn an_iterated_component_says_so() {
        let g = adjust::GroupQuality {
            group: SOUNDINGS,
            redundancy: 200.0,
            omega: 180.0,
            ..adjust::GroupQuality::default()
        };
        assert!(group_of(&g, None).note.starts_with("one step"));
        let iterated = Components {
            groups: vec![VarianceComponent {
                group: SOUNDINGS,
                factor: 1.2,
                sigma: 0.12,
                redundancy: 200.0,
                estimated: true,
            }],
            converged: false,
        };
        let found = group_of(&g, Some(&iterated));
        assert!(found.note.contains("still changing"));
        assert_eq!(found.variance_component, Some(1.2));
    }
}
