//! Quality figures of the joint path as they stand in a result (mathematics section 6).

use std::collections::BTreeMap;

use super::super::config::{Drift, KernelName};
use super::super::joint::{Components, JointOutcome, Judgement, RETURNS, SIX, SOUNDINGS};
use super::super::run::{PoolInput, PoolOutcome};
use crate::adjust::{self, ConditionTest, Direction, ParameterSet, Unit};
use crate::results::{
    GlobalTest, GroupQuality, Observability, Prior, Quality, Reliability, SnoopingTest,
    WeakDirection, WorstObservation,
};

/// Redundancy below which a variance component is held.
const ENOUGH: f64 = 30.0;
/// Directions listed as weak have a standard deviation this many times that of a well-conditioned parameter set.
const WEAK: f64 = 3.0;
/// Worst conditions that are listed.
const LISTED: usize = 20;
/// Components of a direction smaller than this are left out.
const SMALL: f64 = 0.2;

/// Everything that the engine says of the last adjustment; `None` when it did not end with an estimate.
#[must_use]
pub fn quality_of(
    joint: &JointOutcome,
    outcome: &PoolOutcome,
    input: &PoolInput,
) -> Option<Quality> {
    let judgement = joint.judgement.as_ref()?;
    let global = &judgement.quality.global;
    if !global.variance_factor.is_finite() {
        return None;
    }
    Some(Quality {
        variance_factor: global.variance_factor,
        degrees_of_freedom: global.degrees_of_freedom.max(0.0) as u64,
        global_test: GlobalTest {
            statistic: global.variance_factor,
            lower: global.interval.0,
            upper: global.interval.1,
            significance: adjust::QualityOptions::default().global_alpha,
            passed: global.passed,
            practical_tolerance: Some(adjust::QualityOptions::default().practical.1 - 1.0),
            void_because: if input.joint.kernel == KernelName::LeastSquares {
                String::new()
            } else {
                "a robust kernel reweights the residuals, so the chi-square interval does not hold exactly".to_owned()
            },
        },
        groups: judgement
            .quality
            .groups
            .iter()
            .map(|g| group(g, judgement.components.as_ref()))
            .collect(),
        priors: priors(joint, outcome, input),
        reliability: reliability(judgement, outcome),
        observability: observability(judgement, joint),
    })
}

fn group(g: &adjust::GroupQuality, components: Option<&Components>) -> GroupQuality {
    let name = match g.group {
        SOUNDINGS => "multibeam range and angles",
        RETURNS => "laser range and angle",
        _ => "other",
    };
    let (component, note) = component(g, components);
    GroupQuality {
        name: name.to_owned(),
        observations: g.conditions as u64,
        redundancy: g.redundancy,
        variance_component: component.map(|c| c.0),
        standard_deviation: component.map(|c| c.1),
        note,
    }
}

/// A group's variance component with its standard deviation, and how it came about.
fn component(
    g: &adjust::GroupQuality,
    components: Option<&Components>,
) -> (Option<(f64, f64)>, String) {
    const TOGETHER: &str = "for range and angles together: they share each condition";
    let iterated = components.and_then(|c| {
        let found = c
            .groups
            .iter()
            .find(|v| v.group == g.group && v.estimated)?;
        let how = if c.converged {
            "iterated"
        } else {
            "iterated, still changing by more than 1 % at the last round"
        };
        let note = format!("{how}, by least squares without a kernel; {TOGETHER}");
        Some((Some((found.factor, found.sigma)), note))
    });
    let one_step = || {
        if g.redundancy < ENOUGH {
            let note = format!(
                "held at 1: redundancy {:.0} is below {ENOUGH}",
                g.redundancy
            );
            return (None, note);
        }
        let factor = g.omega / g.redundancy;
        let sigma = factor * (2.0 / g.redundancy).sqrt();
        let note = format!(
            "one step: weighted squares by redundancy of the last adjustment, kernel included; {TOGETHER}"
        );
        (Some((factor, sigma)), note)
    };
    iterated.unwrap_or_else(one_step)
}

/// Every prior that entered as an observation, blocks and trajectory.
fn priors(joint: &JointOutcome, outcome: &PoolOutcome, input: &PoolInput) -> Vec<Prior> {
    let mut all = vec![];
    for block in joint.solution.estimate.parameters.blocks() {
        let Some(prior) = &block.prior else { continue };
        for (i, component) in block.components.iter().enumerate() {
            let sigma = prior.covariance[(i, i)].sqrt();
            let (standard_deviation, unit) = readable(sigma, component.unit);
            all.push(Prior {
                name: component.name.clone(),
                standard_deviation,
                unit: unit.to_owned(),
            });
        }
    }
    let noise = &outcome.scene.campaign.trajectory.noise;
    if input.joint.drift == Drift::On {
        let mut add = |name: &str, sigma: f64, unit: Unit| {
            if sigma > 0.0 {
                let (standard_deviation, unit) = readable(sigma, unit);
                all.push(Prior {
                    name: name.to_owned(),
                    standard_deviation,
                    unit: unit.to_owned(),
                });
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

fn readable(sigma: f64, unit: Unit) -> (f64, &'static str) {
    match unit {
        Unit::Radian => (sigma.to_degrees(), "deg"),
        Unit::Metre => (sigma, "m"),
        Unit::Second => (sigma, "s"),
        Unit::One => (sigma, "1"),
    }
}

fn reliability(judgement: &Judgement, outcome: &PoolOutcome) -> Reliability {
    let q = &judgement.quality;
    let conditions: usize = q.groups.iter().map(|g| g.conditions).sum();
    let redundancy: f64 = q.groups.iter().map(|g| g.redundancy).sum();
    let options = adjust::QualityOptions::default();
    let test = |name: &str, significance: f64, t: &ConditionTest| SnoopingTest {
        name: name.to_owned(),
        significance,
        critical_value: t.critical,
        non_centrality: t.delta0,
        flagged: q
            .worst
            .iter()
            .filter(|w| w.normalised.abs() > t.critical)
            .count() as u64,
    };
    Reliability {
        mean_redundancy_number: redundancy / conditions.max(1) as f64,
        smallest_redundancy_number: q
            .groups
            .iter()
            .map(|g| g.smallest_redundancy)
            .fold(1.0, f64::min),
        power: options.power,
        significance: options.condition_alpha,
        tests: vec![
            test("single test", q.single.alpha, &q.single),
            test("family-wise", options.family_alpha, &q.family),
        ],
        worst: q
            .worst
            .iter()
            .zip(&judgement.worst_rows)
            .take(LISTED)
            .map(|(w, row)| worst(w, *row, q.single.delta0, outcome))
            .collect(),
    }
}

fn worst(
    w: &adjust::ConditionQuality,
    (group, row): (u16, u32),
    delta0: f64,
    outcome: &PoolOutcome,
) -> WorstObservation {
    let campaign = outcome.scene.campaign;
    let observation = if group == SOUNDINGS {
        let s = &campaign.soundings;
        format!(
            "ping {} beam {}",
            s.ping[row as usize], s.beam[row as usize]
        )
    } else {
        format!("laser return {row}")
    };
    let mut effect = BTreeMap::new();
    for (i, name) in SIX.iter().enumerate() {
        let (key, value) = if i < 3 {
            (format!("{name}_deg"), w.effects[i].to_degrees())
        } else {
            (format!("{name}_m"), w.effects[i])
        };
        effect.insert(key, finite(value * delta0));
    }
    WorstObservation {
        observation,
        w: w.normalised,
        minimal_detectable_bias_m: finite(w.detectable_bias(delta0)),
        effect,
    }
}

/// JSON knows no infinity.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::MAX }
}

fn observability(judgement: &Judgement, joint: &JointOutcome) -> Observability {
    let o = &judgement.observability;
    let x = &joint.solution.estimate.parameters;
    let mut weak: Vec<WeakDirection> = o
        .pairs
        .iter()
        .filter(|p| seeks(p.columns, x))
        .map(|p| pair(p, x))
        .collect();
    weak.extend(o.directions.iter().take(3).filter_map(|d| direction(d, x)));
    Observability {
        condition_number: finite(o.condition.powi(2)),
        rank: o.rank as u32,
        weak,
    }
}

/// Whether a pair concerns one of the parameters sought.
fn seeks(columns: (usize, usize), x: &ParameterSet) -> bool {
    let name = |column: usize| x.components().nth(column).map_or("", |c| c.name.as_str());
    SIX.contains(&name(columns.0)) || SIX.contains(&name(columns.1))
}

fn pair(p: &adjust::WeakPair, x: &ParameterSet) -> WeakDirection {
    let name = |column: usize| {
        x.components()
            .nth(column)
            .map_or_else(String::new, |c| c.name.clone())
    };
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let combination = BTreeMap::from([
        (name(p.columns.0), half),
        (name(p.columns.1), half * p.correlation.signum()),
    ]);
    let help = advice(&name(p.columns.0), &name(p.columns.1));
    WeakDirection {
        sigma: (1.0 - p.correlation.abs()).max(1e-12).powf(-0.5),
        combination,
        text: format!("{}{help}", p.words),
    }
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

/// A weak direction that concerns the parameters sought; `None` when it is strong or about others.
fn direction(d: &Direction, x: &ParameterSet) -> Option<WeakDirection> {
    let sigma = d.eigenvalue.max(1e-300).powf(-0.5);
    let norm = d.error.iter().map(|v| v * v).sum::<f64>().sqrt();
    let parts: BTreeMap<String, f64> = x
        .components()
        .zip(&d.error)
        .map(|(c, v)| (c.name.clone(), v / norm))
        .filter(|(_, v)| v.abs() > SMALL)
        .collect();
    let sought = parts.keys().any(|k| SIX.contains(&k.as_str()));
    let mut listed: Vec<(&String, &f64)> = parts.iter().collect();
    listed.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let words = listed
        .iter()
        .map(|(k, v)| format!("{v:+.2} {k}"))
        .collect::<Vec<_>>()
        .join(" ");
    (sought && sigma > WEAK).then(|| WeakDirection {
        sigma,
        text: format!(
            "the combination {words} is {sigma:.0} times weaker than each parameter by itself"
        ),
        combination: parts.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::VarianceComponent;

    #[test]
    fn a_component_says_how_it_came_about() {
        let g = adjust::GroupQuality {
            group: SOUNDINGS,
            redundancy: 200.0,
            omega: 180.0,
            ..adjust::GroupQuality::default()
        };
        let (one_step, note) = component(&g, None);
        assert!(note.starts_with("one step") && one_step == Some((0.9, 0.9 * 0.1)));
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
        let (found, note) = component(&g, Some(&iterated));
        assert!(note.contains("still changing") && found == Some((1.2, 0.12)));
        let few = adjust::GroupQuality {
            redundancy: 5.0,
            ..g
        };
        assert_eq!(component(&few, None).0, None);
    }
}
