//! What the engine says of an adjustment, as it stands in a result ([`crate::adjust::assess`]).

use std::collections::BTreeMap;

use crate::adjust::{self, ConditionTest, Direction, ParameterSet, Unit};
use crate::math;
use crate::results::{
    GlobalTest, GroupQuality, Observability, Prior, Quality, Reliability, SnoopingTest,
    WeakDirection, WorstObservation,
};

/// Redundancy below which a variance component is held.
pub const ENOUGH: f64 = 30.0;
/// Directions listed as weak have a standard deviation this many times that of a well-conditioned parameter set.
const WEAK: f64 = 3.0;
/// Worst conditions that are listed.
const LISTED: usize = 20;
/// Components of a direction smaller than this are left out.
const SMALL: f64 = 0.2;

/// A judged adjustment and the words of its procedure.
pub struct Judged<'a> {
    /// Tests, groups, worst conditions.
    pub quality: &'a adjust::Quality,
    /// What the data determine.
    pub observability: &'a adjust::Observability,
    /// The estimate; its first columns are the parameters sought.
    pub parameters: &'a ParameterSet,
    /// Names of the parameters sought, as their components are named.
    pub sought: &'a [String],
    /// Every prior that entered.
    pub priors: Vec<Prior>,
    /// Observation groups, in the order of `quality.groups`.
    pub groups: Vec<GroupQuality>,
    /// Name of a worst condition by its place in `quality.worst`.
    pub observation: &'a dyn Fn(usize) -> String,
    /// What separates two correlated parameters, beginning with `; `, or nothing.
    pub advice: &'a dyn Fn(&str, &str) -> &'static str,
}

/// Everything as plain data; `None` when the adjustment did not end with an estimate.
#[must_use]
pub fn quality(judged: Judged<'_>) -> Option<Quality> {
    let global = &judged.quality.global;
    if !global.variance_factor.is_finite() {
        return None;
    }
    let options = adjust::QualityOptions::default();
    Some(Quality {
        variance_factor: global.variance_factor,
        degrees_of_freedom: global.degrees_of_freedom.max(0.0) as u64,
        global_test: GlobalTest {
            statistic: global.variance_factor,
            lower: global.interval.0,
            upper: global.interval.1,
            significance: options.global_alpha,
            passed: global.passed,
            practical_tolerance: Some(options.practical.1 - 1.0),
            void_because: if global.void {
                "variance components were estimated from the same residuals".to_owned()
            } else {
                String::new()
            },
        },
        reliability: reliability(&judged),
        observability: observability(&judged),
        groups: judged.groups,
        priors: judged.priors,
    })
}

/// An observation group with its variance component after one step.
///
/// `about` says what the component covers, such as `for range and angles together: they share each condition`.
#[must_use]
pub fn group(g: &adjust::GroupQuality, name: &str, about: &str) -> GroupQuality {
    let (component, note) = one_step(g, about);
    GroupQuality {
        name: name.to_owned(),
        observations: g.conditions as u64,
        redundancy: g.redundancy,
        variance_component: component.map(|c| c.0),
        standard_deviation: component.map(|c| c.1),
        note,
    }
}

/// Variance component and its standard deviation after one step, and how it came about.
#[must_use]
pub fn one_step(g: &adjust::GroupQuality, about: &str) -> (Option<(f64, f64)>, String) {
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
        "one step: weighted squares by redundancy of the last adjustment, corrected for what the robust kernel takes off normal residuals; {about}"
    );
    (Some((factor, sigma)), note)
}

/// Every prior of a parameter block.
#[must_use]
pub fn block_priors(parameters: &ParameterSet) -> Vec<Prior> {
    let mut all = vec![];
    for block in parameters.blocks() {
        let Some(prior) = &block.prior else { continue };
        for (i, component) in block.components.iter().enumerate() {
            let sigma = prior.covariance[(i, i)].sqrt();
            all.push(named_prior(&component.name, sigma, component.unit));
        }
    }
    all
}

/// A prior in the unit that readers expect: angles in degrees.
#[must_use]
pub fn named_prior(name: &str, sigma: f64, unit: Unit) -> Prior {
    let (standard_deviation, unit) = readable(sigma, unit);
    Prior {
        name: name.to_owned(),
        standard_deviation,
        unit: unit.to_owned(),
    }
}

/// A value in the unit that readers expect, and that unit.
#[must_use]
pub fn readable(value: f64, unit: Unit) -> (f64, &'static str) {
    match unit {
        Unit::Radian => (value.to_degrees(), "deg"),
        Unit::Metre => (value, "m"),
        Unit::Second => (value, "s"),
        Unit::One => (value, "1"),
    }
}

fn reliability(judged: &Judged<'_>) -> Reliability {
    let q = judged.quality;
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
    let listed = q.worst.iter().enumerate().take(LISTED);
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
        worst: listed
            .map(|(place, w)| worst(w, (judged.observation)(place), judged))
            .collect(),
    }
}

fn worst(
    w: &adjust::ConditionQuality,
    observation: String,
    judged: &Judged<'_>,
) -> WorstObservation {
    let delta0 = judged.quality.single.delta0;
    let sought = judged.parameters.sought().zip(&w.effects);
    let effect = sought
        .map(|(component, effect)| {
            let (value, unit) = readable(*effect, component.unit);
            let name = if unit == "1" {
                component.name.clone()
            } else {
                format!("{}_{unit}", component.name)
            };
            (name, finite(value * delta0))
        })
        .collect();
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

fn observability(judged: &Judged<'_>) -> Observability {
    let o = judged.observability;
    let mut weak: Vec<WeakDirection> = o.pairs.iter().filter_map(|p| pair(p, judged)).collect();
    let directions = o.directions.iter().take(3);
    weak.extend(directions.filter_map(|d| direction(d, judged)));
    Observability {
        condition_number: finite(o.condition.powi(2)),
        rank: o.rank as u32,
        unknowns: o.unknowns as u32,
        weak,
    }
}

/// Two correlated parameters; `None` unless one of them is sought.
fn pair(p: &adjust::WeakPair, judged: &Judged<'_>) -> Option<WeakDirection> {
    let name = |column: usize| {
        let mut all = judged.parameters.components();
        all.nth(column).map_or_else(String::new, |c| c.name.clone())
    };
    let (a, b) = (name(p.columns.0), name(p.columns.1));
    if !judged.sought.contains(&a) && !judged.sought.contains(&b) {
        return None;
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let help = (judged.advice)(&a, &b);
    Some(WeakDirection {
        sigma: math::powf((1.0 - p.correlation.abs()).max(1e-12), -0.5),
        combination: BTreeMap::from([(a, half), (b, half * p.correlation.signum())]),
        text: format!("{}{help}", p.words),
    })
}

/// A weak direction that concerns the parameters sought; `None` when it is strong or about others.
fn direction(d: &Direction, judged: &Judged<'_>) -> Option<WeakDirection> {
    let sigma = math::powf(d.eigenvalue.max(1e-300), -0.5);
    let norm = d.error.iter().map(|v| v * v).sum::<f64>().sqrt();
    let parts: BTreeMap<String, f64> = judged
        .parameters
        .components()
        .zip(&d.error)
        .map(|(c, v)| (c.name.clone(), v / norm))
        .filter(|(_, v)| v.abs() > SMALL)
        .collect();
    let sought = parts.keys().any(|k| judged.sought.contains(k));
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

    #[test]
    fn a_group_of_little_redundancy_has_no_component() {
        let g = adjust::GroupQuality {
            redundancy: 200.0,
            omega: 180.0,
            ..adjust::GroupQuality::default()
        };
        let (found, note) = one_step(&g, "of ranges");
        assert!(note.starts_with("one step") && note.ends_with("of ranges"));
        assert_eq!(found, Some((0.9, 0.9 * 0.1)));
        let few = adjust::GroupQuality {
            redundancy: 5.0,
            ..g
        };
        assert_eq!(one_step(&few, "").0, None);
    }
}
