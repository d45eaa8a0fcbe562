//! Whether an error budget reaches what is wanted: yes or no, and at which values of a sweep.

use std::collections::BTreeMap;

use super::budget::{good_to_percent, in_words};
use super::format::{finer, three_digits as digits};
use crate::math;
use crate::results::{BudgetResult, Figures, JOINT, PathBudget, SweepPoint};

/// What is wanted, from figures in the units that tables show, by parameter in its own unit.
///
/// # Errors
/// The name that no parameter has, with those there are.
pub fn goals(
    result: &BudgetResult,
    figures: &[(String, f64)],
) -> Result<BTreeMap<String, f64>, String> {
    let names = || {
        let names: Vec<&str> = result.parameters.iter().map(|p| p.name.as_str()).collect();
        names.join(", ")
    };
    let goal = |(name, figure): &(String, f64)| {
        let parameter = result.parameters.iter().find(|p| p.name == *name);
        let parameter =
            parameter.ok_or_else(|| format!("found \"{name}\", expected one of {}", names()))?;
        Ok::<_, String>((name.clone(), figure / finer(&parameter.unit).1))
    };
    let mut goals = BTreeMap::new();
    for figure in figures {
        let (name, value) = goal(figure)?;
        if goals.insert(name, value).is_some() {
            return Err(format!("found \"{}\" twice, expected it once", figure.0));
        }
    }
    Ok(goals)
}

/// The answer for the joint path in a sentence or two; nothing where nothing was wanted.
#[must_use]
pub fn answer(result: &BudgetResult) -> Option<String> {
    if result.wanted.is_empty() {
        return None;
    }
    let goal = format!("Wanted: {}.", wanted(result));
    let rest = match &result.sweep {
        Some(sweep) => {
            let keys: Vec<String> = sweep.keys.iter().map(|key| in_words(key)).collect();
            of_values(result, &sweep.points, &keys.join(" and "))
        }
        None => of_scenario(result),
    };
    Some(format!("{goal} {rest}{}", basis(result)))
}

/// "yaw 0.01 deg, lx 1 mm".
fn wanted(result: &BudgetResult) -> String {
    let of = result.parameters.iter().enumerate();
    let parts = of.filter_map(|(i, p)| Some(figure(result, i, *result.wanted.get(&p.name)?)));
    parts.collect::<Vec<_>>().join(", ")
}

/// "yaw 0.01 deg".
fn figure(result: &BudgetResult, i: usize, value: f64) -> String {
    let parameter = &result.parameters[i];
    let (unit, factor) = finer(&parameter.unit);
    format!("{} {} {unit}", parameter.name, digits(value * factor))
}

/// What of the wanted is not reached, in words; nothing where all is.
fn missed(result: &BudgetResult, rms: &Figures) -> Vec<String> {
    let of = |(i, p): (usize, &crate::results::BudgetParameter)| {
        let goal = *result.wanted.get(&p.name)?;
        match rms.get(i).copied().flatten() {
            Some(found) if found <= goal => None,
            Some(found) => Some(figure(result, i, found)),
            None => Some(format!("{} unknown", p.name)),
        }
    };
    result
        .parameters
        .iter()
        .enumerate()
        .filter_map(of)
        .collect()
}

/// Root mean square errors by trials where there are any, else by propagation.
fn rms(path: &PathBudget) -> Option<Figures> {
    if let Some(rms) = path.together.as_ref().and_then(|t| t.rms.clone()) {
        return Some(rms);
    }
    let predicted = path.predicted.as_ref()?;
    let (bias, sigma) = (
        predicted.bias.as_ref()?,
        predicted.standard_deviation.as_ref()?,
    );
    let both = bias.iter().zip(sigma);
    Some(both.map(|(b, s)| Some(math::hypot((*b)?, (*s)?))).collect())
}

/// On how many trials the answer stands; nothing where it is propagation's.
fn basis(result: &BudgetResult) -> String {
    let trials = result
        .sweep
        .as_ref()
        .map_or(result.trials, |sweep| sweep.trials);
    let joint = result.paths.iter().find(|p| p.path == JOINT);
    let usable = joint.and_then(|p| p.together.as_ref()).map(|t| t.usable);
    let of = |usable: u64| match (trials, usable) {
        (0, _) => String::new(),
        (_, 0..=1) => format!(" By {usable} usable of {trials} trials, too few to decide."),
        _ => {
            let one = good_to_percent(usable);
            format!(" By {usable} usable of {trials} trials: a figure is good to {one:.0} %.")
        }
    };
    usable.map_or_else(String::new, of)
}

fn of_scenario(result: &BudgetResult) -> String {
    let joint = result.paths.iter().find(|p| p.path == JOINT);
    let Some(rms) = joint.and_then(rms) else {
        return "There is no figure to answer by.".to_owned();
    };
    match missed(result, &rms) {
        none if none.is_empty() => "The joint path reaches it.".to_owned(),
        some => format!("The joint path does not reach it: {}.", some.join(", ")),
    }
}

/// Which values of a sweep are enough and which are not.
fn of_values(result: &BudgetResult, points: &[SweepPoint], keys: &str) -> String {
    let (mut enough, mut short) = (vec![], vec![]);
    for point in points {
        let values: Vec<String> = point.values.iter().map(ToString::to_string).collect();
        let values = values.join(" and ");
        let joint = point.paths.iter().find(|p| p.path == JOINT);
        match joint.and_then(|p| p.rms.as_ref()) {
            None => short.push(format!("{values} (no result)")),
            Some(rms) => match missed(result, rms) {
                none if none.is_empty() => enough.push(values),
                some => short.push(format!("{values} ({})", some.join(", "))),
            },
        }
    }
    match (enough.is_empty(), short.is_empty()) {
        (_, true) => format!(
            "The joint path reaches it at every value of {keys}: {}.",
            enough.join(", ")
        ),
        (true, _) => format!(
            "The joint path reaches it at no value of {keys}: {}.",
            short.join(", ")
        ),
        _ => format!(
            "The joint path reaches it at {} and does not at {} ({keys}).",
            enough.join(", "),
            short.join(", ")
        ),
    }
}
