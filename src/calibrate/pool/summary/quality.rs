//! What the engine says of a joint adjustment, with the names of observations and parameters, and in words.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, Matrix6, SymmetricEigen};

use super::super::config::{Drift, JointConfig};
use super::super::joint::{JointOutcome, Judgement, RETURNS, SIX, SOUNDINGS};
use super::super::scene::Scene;
use crate::adjust::{self, QualityOptions};
use crate::results::{
    GlobalTest, GroupQuality, Observability, Prior, Quality, Reliability, SnoopingTest,
    WeakDirection, WorstObservation,
};

/// Worst conditions that are listed.
const LISTED: usize = 20;
/// A group's variance component needs this redundancy (mathematics page, section 6).
const LEAST_REDUNDANCY: f64 = 30.0;
/// A direction is weak when its share of the information is below this: its sigma is then over four times that of uncoupled parameters.
const WEAK: f64 = 0.05;
/// Components of a direction, or effects in their largest, below this share are left out.
const SMALL: f64 = 0.1;
/// Names of the six standard deviations in a result.
const FIELDS: [&str; 6] = ["pitch_deg", "roll_deg", "yaw_deg", "lx_m", "ly_m", "lz_m"];

/// The quality figures; `None` when nothing was judged or there is no redundancy.
pub fn of(joint: &JointOutcome, scene: &Scene, config: &JointConfig) -> Option<Quality> {
    let judgement = joint.judgement.as_ref()?;
    let global = &judgement.quality.global;
    if !global.variance_factor.is_finite() {
        return None;
    }
    Some(Quality {
        variance_factor: global.variance_factor,
        degrees_of_freedom: global.degrees_of_freedom.max(0.0).round() as u64,
        global_test: global_test(global),
        groups: judgement
            .quality
            .groups
            .iter()
            .filter(|g| g.conditions > 0)
            .map(group)
            .collect(),
        priors: priors(joint, scene, config),
        reliability: reliability(joint, judgement, scene),
        observability: observability(&joint.covariance),
    })
}

fn global_test(test: &adjust::GlobalTest) -> GlobalTest {
    let options = QualityOptions::default();
    GlobalTest {
        statistic: test.variance_factor,
        lower: test.interval.0,
        upper: test.interval.1,
        significance: options.global_alpha,
        passed: test.passed,
        practical_tolerance: Some(options.practical.1 - 1.0),
        void_because: if test.void {
            "robust weights".to_owned()
        } else {
            String::new()
        },
    }
}

/// A group with one step of its variance component, which is reported but not applied.
fn group(group: &adjust::GroupQuality) -> GroupQuality {
    let name = match group.group {
        SOUNDINGS => "multibeam sounding (range and angles)",
        RETURNS => "laser return (range and angle)",
        _ => "other",
    };
    let estimated = group.redundancy >= LEAST_REDUNDANCY;
    let component = group.omega / group.redundancy;
    let note = if estimated {
        "estimated at the solution, not applied; range and angles share a condition and are not separated"
    } else {
        "held: too little redundancy"
    };
    GroupQuality {
        name: name.to_owned(),
        observations: group.conditions as u64,
        redundancy: group.redundancy,
        variance_component: estimated.then_some(component),
        standard_deviation: estimated.then(|| component * (2.0 / group.redundancy).sqrt()),
        note: note.to_owned(),
    }
}

/// Every prior that entered as an observation.
fn priors(joint: &JointOutcome, scene: &Scene, config: &JointConfig) -> Vec<Prior> {
    let mut all: Vec<Prior> = vec![];
    let mut push = |name: &str, sigma: f64, unit: &str| {
        if sigma > 0.0 {
            all.push(Prior {
                name: name.to_owned(),
                standard_deviation: sigma,
                unit: unit.to_owned(),
            });
        }
    };
    let noise = &scene.campaign.trajectory.noise;
    if config.drift == Drift::On {
        push(
            "trajectory position, white per record",
            noise.position_m,
            "m",
        );
        push(
            "trajectory roll and pitch, white per record",
            noise.roll_pitch_rad.to_degrees(),
            "deg",
        );
        push(
            "trajectory heading, white per record",
            noise.heading_rad.to_degrees(),
            "deg",
        );
        push("trajectory position drift", noise.position_drift_m, "m");
        push(
            "trajectory heading drift",
            noise.heading_drift_rad.to_degrees(),
            "deg",
        );
    }
    if let (Some(_), Some(sigma)) = (&joint.blocks.scanner, &scene.campaign.scanner_sigma) {
        for (i, axis) in ["pitch", "roll", "yaw"].iter().enumerate() {
            push(
                &format!("scanner {axis}"),
                sigma.rotation_rad[i].to_degrees(),
                "deg",
            );
        }
        for (i, axis) in ["x", "y", "z"].iter().enumerate() {
            push(
                &format!("scanner lever arm {axis}"),
                sigma.lever_arm_m[i],
                "m",
            );
        }
    }
    let p = &config.prior;
    for (name, sigma) in SIX
        .iter()
        .zip([p.pitch_sigma_deg, p.roll_sigma_deg, p.yaw_sigma_deg])
    {
        push(name, sigma.unwrap_or(0.0), "deg");
    }
    for (name, sigma) in SIX[3..]
        .iter()
        .zip([p.lx_sigma_m, p.ly_sigma_m, p.lz_sigma_m])
    {
        push(name, sigma.unwrap_or(0.0), "m");
    }
    for (sigma_m, count) in tolerances(scene) {
        push(&format!("design offset, each of {count}"), sigma_m, "m");
    }
    all
}

/// The target's tolerances and how many offsets have each, smallest first.
fn tolerances(scene: &Scene) -> Vec<(f64, usize)> {
    let mut sigmas: Vec<f64> = scene
        .target
        .offsets
        .iter()
        .map(|o| o.sigma_m)
        .filter(|s| *s > 0.0)
        .collect();
    sigmas.sort_by(f64::total_cmp);
    sigmas
        .chunk_by(|a, b| a == b)
        .map(|same| (same[0], same.len()))
        .collect()
}

fn reliability(joint: &JointOutcome, judgement: &Judgement, scene: &Scene) -> Reliability {
    let quality = &judgement.quality;
    let conditions: usize = quality.groups.iter().map(|g| g.conditions).sum();
    let redundancy: f64 = quality.groups.iter().map(|g| g.redundancy).sum();
    let seen = quality.groups.iter().filter(|g| g.conditions > 0);
    let delta0 = quality.single.delta0;
    let worst = quality.worst.iter().zip(&judgement.worst_rows).take(LISTED);
    Reliability {
        mean_redundancy_number: redundancy / conditions.max(1) as f64,
        smallest_redundancy_number: seen.map(|g| g.smallest_redundancy).fold(1.0, f64::min),
        power: QualityOptions::default().power,
        significance: quality.single.alpha,
        tests: vec![
            test(
                "single test",
                quality.single.alpha,
                &quality.single,
                quality,
            ),
            test(
                "family-wise",
                QualityOptions::default().family_alpha,
                &quality.family,
                quality,
            ),
        ],
        largest_effect: effects(joint, quality, delta0),
        worst: worst
            .map(|(one, row)| WorstObservation {
                observation: name_of(scene, *row),
                w: one.normalised,
                minimal_detectable_bias_m: finite(one.detectable_bias(delta0)),
                effect: BTreeMap::new(),
            })
            .collect(),
    }
}

fn test(
    name: &str,
    significance: f64,
    test: &adjust::ConditionTest,
    quality: &adjust::Quality,
) -> SnoopingTest {
    let flagged = quality
        .worst
        .iter()
        .filter(|one| one.normalised.abs() > test.critical)
        .count();
    SnoopingTest {
        name: name.to_owned(),
        significance,
        critical_value: test.critical,
        non_centrality: test.delta0,
        flagged: flagged as u64,
    }
}

fn name_of(scene: &Scene, (group, row): (u16, u32)) -> String {
    let soundings = &scene.campaign.soundings;
    match group {
        SOUNDINGS => format!(
            "ping {} beam {}",
            soundings.ping[row as usize], soundings.beam[row as usize]
        ),
        _ => format!("return {}", row + 1),
    }
}

/// Largest effect of an undetected bias on each of the six, degrees and metres.
fn effects(joint: &JointOutcome, quality: &adjust::Quality, delta0: f64) -> BTreeMap<String, f64> {
    let x = &joint.solution.estimate.parameters;
    let (turn, arm) = (
        x.offset(joint.blocks.mounting.rotation),
        x.offset(joint.blocks.mounting.lever_arm),
    );
    let size = |i: usize| {
        let column = if i < 3 { turn + i } else { arm + i - 3 };
        let effect = quality.effects.get(column).map_or(0.0, |e| e.size * delta0);
        if i < 3 { effect.to_degrees() } else { effect }
    };
    (0..6)
        .map(|i| (FIELDS[i].to_owned(), finite(size(i))))
        .filter(|(_, v)| *v != 0.0)
        .collect()
}

/// JSON knows no infinity.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::MAX }
}

/// Condition, rank and weak directions of the scaled normal matrix of the six, the others eliminated; held ones are left out.
fn observability(covariance: &Matrix6<f64>) -> Observability {
    let free: Vec<usize> = (0..6).filter(|&i| covariance[(i, i)] > 0.0).collect();
    let n = free.len();
    let sigma = |i: usize| covariance[(free[i], free[i])].sqrt();
    let correlation = DMatrix::from_fn(n, n, |i, j| {
        covariance[(free[i], free[j])] / (sigma(i) * sigma(j))
    });
    let Some(normal) = correlation.clone().cholesky().map(|c| c.inverse()) else {
        return Observability {
            condition_number: f64::MAX,
            rank: 0,
            weak: vec![],
        };
    };
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        normal[(i, j)] / (normal[(i, i)] * normal[(j, j)]).sqrt()
    });
    let eigen = SymmetricEigen::new(scaled);
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let value = |k: usize| eigen.eigenvalues[k].max(0.0);
    let (low, high) = (
        order.first().map_or(1.0, |&k| value(k)),
        order.last().map_or(1.0, |&k| value(k)),
    );
    let weak = order.iter().filter(|&&k| value(k) < WEAK);
    Observability {
        condition_number: finite(high / low),
        rank: order.iter().filter(|&&k| value(k) > 1e-12 * high).count() as u32,
        weak: weak
            .map(|&k| {
                direction(
                    &free,
                    &eigen.eigenvectors.column(k).into_owned(),
                    value(k),
                    &correlation,
                )
            })
            .collect(),
    }
}

fn direction(
    free: &[usize],
    axis: &nalgebra::DVector<f64>,
    value: f64,
    correlation: &DMatrix<f64>,
) -> WeakDirection {
    let largest = axis.amax();
    let kept = (0..free.len()).filter(|&i| axis[i].abs() >= SMALL * largest);
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by(|a, b| axis[*b].abs().total_cmp(&axis[*a].abs()));
    let text = match order[..] {
        [a, b, ..] => words(free[a], free[b], correlation[(a, b)]),
        _ => String::new(),
    };
    WeakDirection {
        sigma: finite(1.0 / value.sqrt()),
        combination: kept.map(|i| (SIX[free[i]].to_owned(), axis[i])).collect(),
        text,
    }
}

/// Two parameters that the data hardly tell apart, and what would.
fn words(a: usize, b: usize, correlation: f64) -> String {
    const NAMES: [&str; 6] = [
        "pitch",
        "roll",
        "yaw",
        "the off-centre (right) lever arm",
        "the forward lever arm",
        "the vertical lever arm",
    ];
    let help = match (a.min(b), a.max(b)) {
        (2, 3 | 4) => "a pass at another distance separates them",
        (0 | 1, 5) | (1, 3) => "horizontal faces at other distances and heights separate them",
        (0, 2 | 4) => "inclined and horizontal faces seen from another distance separate them",
        _ => "passes at other distances and headings help",
    };
    format!(
        "{} and {} are nearly inseparable (correlation {correlation:.2}); {help}",
        NAMES[a], NAMES[b]
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two parameters with correlation r: the scaled normal matrix has eigenvalues 1 - |r| and 1 + |r|.
    #[test]
    fn a_correlated_pair_is_named_with_its_remedy() {
        let mut covariance = Matrix6::from_diagonal(&[1e-6, 1e-6, 4e-6, 1e-6, 9e-6, 0.0].into());
        (covariance[(2, 4)], covariance[(4, 2)]) = (-0.99 * 6e-6, -0.99 * 6e-6);
        let found = observability(&covariance);
        assert_eq!(found.rank, 5);
        assert!(
            (found.condition_number - 1.99 / 0.01).abs() < 1e-6,
            "{}",
            found.condition_number
        );
        assert_eq!(found.weak.len(), 1);
        let weak = &found.weak[0];
        assert!((weak.sigma - 10.0).abs() < 1e-9 && weak.combination.len() == 2);
        assert!(
            weak.text.contains("yaw")
                && weak.text.contains("correlation -0.99")
                && weak.text.contains("another distance"),
            "{}",
            weak.text
        );
    }
}
