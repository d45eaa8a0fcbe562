//! The analytic budget in the form of `result.json`, beside the trials' figures and compared with them.

use std::collections::BTreeMap;

use nalgebra::{Matrix6, Vector6};

use super::analytic::{Analytic, PathBudget, Prediction};
use super::sources::{about, acting};
use super::statistics::{efficiency, six_values, variance_ratio_interval};
use crate::procedures::pool::joint::SIX;
use crate::results::{
    self, Agreement, BudgetPath, BudgetResult, Origin, PathStatistics, SixFigures, SourceShare,
};
use crate::simulate::{Scenario, Source};

/// Parts of a path's variance below this are not compared: what decides there is one tie more or less.
const COMPARED: f64 = 1e-3;

/// Adds the analytic figures to a result that already has those of the trials, if there are any.
pub fn add(result: &mut BudgetResult, scenario: &Scenario, analytic: &Analytic) {
    let acting = acting(scenario);
    for path in &mut result.paths {
        let Some(budget) = of(path, analytic) else {
            continue;
        };
        let mut shares = shares(budget, &acting);
        shares.append(&mut path.shares);
        path.shares = shares;
        path.predicted = Some(together(budget));
        path.bound = analytic
            .bound
            .and_then(|bound| SixFigures::from_si(sigmas(&bound)));
        path.efficiency = analytic.bound.and_then(|bound| {
            let variance = trials_variance(path).unwrap_or_else(|| diagonal(&budget.covariance));
            efficiency(&diagonal(&bound), &variance)
        });
    }
    if let Err(reason) = &analytic.sequential {
        result
            .notes
            .push(format!("the reference path is not predicted: {reason}"));
    }
    compare(result);
}

/// The literal variant has no derivative; where the reference path is configured as projected, both columns are the same path.
fn of<'a>(path: &results::PathBudget, analytic: &'a Analytic) -> Option<&'a PathBudget> {
    match path.path {
        BudgetPath::Joint => Some(&analytic.joint),
        BudgetPath::SequentialProjected => analytic.sequential.as_ref().ok(),
        BudgetPath::Sequential => analytic
            .sequential
            .as_ref()
            .ok()
            .filter(|_| path.variant == "projected"),
    }
}

fn shares(budget: &PathBudget, acting: &[Source]) -> Vec<SourceShare> {
    let total = budget.covariance.diagonal();
    let mut shares = vec![share(
        "nothing",
        Some((budget.method_bias, Matrix6::zeros())),
        &total,
        "the method's own error, without any source",
    )];
    for (source, prediction) in &budget.sources {
        if !acting.contains(source) {
            continue;
        }
        let name = about(*source).name;
        shares.push(match prediction {
            Prediction::Linear { bias, covariance } => {
                share(name, Some((*bias, *covariance)), &total, "")
            }
            Prediction::NotPredicted { reason } => share(name, None, &total, reason),
        });
    }
    shares
}

fn together(budget: &PathBudget) -> SourceShare {
    let total = budget.covariance.diagonal();
    share(
        "together",
        Some((budget.bias, budget.covariance)),
        &total,
        "all sources that have a derivative",
    )
}

fn share(
    source: &str,
    found: Option<(Vector6<f64>, Matrix6<f64>)>,
    total: &Vector6<f64>,
    note: &str,
) -> SourceShare {
    let part = |(_, covariance): &(Vector6<f64>, Matrix6<f64>)| {
        let part: [f64; 6] = covariance.diagonal().component_div(total).into();
        part.iter().all(|p| p.is_finite()).then(|| six_values(part))
    };
    SourceShare {
        source: source.to_owned(),
        origin: Origin::Analytic,
        usable: 0,
        trials: 0,
        bias: found.and_then(|(bias, _)| SixFigures::from_si(bias.into())),
        bias_standard_error: None,
        standard_deviation: found.and_then(|(_, c)| SixFigures::from_si(sigmas(&c))),
        standard_deviation_interval: None,
        share: found.as_ref().and_then(part),
        note: note.to_owned(),
    }
}

fn sigmas(covariance: &Matrix6<f64>) -> [f64; 6] {
    diagonal(covariance).map(|v| v.max(0.0).sqrt())
}

fn diagonal(covariance: &Matrix6<f64>) -> [f64; 6] {
    covariance.diagonal().into()
}

fn trials_variance(path: &results::PathBudget) -> Option<[f64; 6]> {
    let deviation = path.together.as_ref()?.standard_deviation?;
    let [pitch, roll, yaw, lx, ly, lz] = deviation.in_order();
    let rad = f64::to_radians;
    Some([rad(pitch), rad(roll), rad(yaw), lx, ly, lz].map(|s| s * s))
}

/// A pair of variances that are to be the same.
struct Pair {
    path: usize,
    source: String,
    /// Usable trials.
    trials: u64,
    /// By parameter: trials' by analytic variance.
    ratio: BTreeMap<String, f64>,
    note: String,
}

/// Compares every source alone and all together, with one interval for all comparisons at once.
fn compare(result: &mut BudgetResult) {
    let pairs: Vec<Pair> = result
        .paths
        .iter()
        .enumerate()
        .flat_map(|(k, path)| pairs(k, path))
        .collect();
    let comparisons = pairs.iter().map(|p| p.ratio.len() as u64).sum();
    for pair in pairs {
        let Some(interval) = variance_ratio_interval(pair.trials, comparisons) else {
            continue;
        };
        let outside: Vec<String> = pair
            .ratio
            .iter()
            .filter(|(_, ratio)| !interval.contains(**ratio))
            .map(|(name, _)| name.clone())
            .collect();
        let note = if outside.is_empty() {
            String::new()
        } else {
            pair.note
        };
        result.paths[pair.path].agreement.push(Agreement {
            source: pair.source,
            variance_ratio: pair.ratio,
            interval,
            comparisons,
            outside,
            note,
        });
    }
}

fn pairs(k: usize, path: &results::PathBudget) -> Vec<Pair> {
    let Some(predicted) = &path.predicted else {
        return vec![];
    };
    let by = |origin: Origin, source: &str| {
        path.shares
            .iter()
            .find(|s| s.origin == origin && s.source == source)
    };
    let total = predicted.standard_deviation;
    let mut pairs = vec![];
    for analytic in path.shares.iter().filter(|s| s.origin == Origin::Analytic) {
        let Some(found) = by(Origin::MonteCarlo, &analytic.source) else {
            continue;
        };
        let deviations = (found.standard_deviation, analytic.standard_deviation);
        pairs.push(Pair {
            path: k,
            source: analytic.source.clone(),
            trials: found.usable,
            ratio: ratios(deviations, total),
            note: "a source that small moves the result by single ties at the edges of faces, or by a bias of second order: \
                   docs/error-budget-theory.md"
                .to_owned(),
        });
    }
    if let Some(together) = &path.together {
        pairs.push(all(k, path, together, predicted));
    }
    pairs.retain(|p| !p.ratio.is_empty());
    pairs
}

fn all(
    k: usize,
    path: &results::PathBudget,
    together: &PathStatistics,
    predicted: &SourceShare,
) -> Pair {
    let deviations = (together.standard_deviation, predicted.standard_deviation);
    let unpredicted: Vec<&str> = path
        .shares
        .iter()
        .filter(|s| {
            s.origin == Origin::Analytic && s.source != "nothing" && s.standard_deviation.is_none()
        })
        .map(|s| s.source.as_str())
        .collect();
    let note = if unpredicted.is_empty() {
        "what the sources do to each other: see the row \"interaction\" (--single) and docs/error-budget-theory.md".to_owned()
    } else {
        format!("not predicted: {}", unpredicted.join(", "))
    };
    Pair {
        path: k,
        source: "together".to_owned(),
        trials: together.usable,
        ratio: ratios(deviations, predicted.standard_deviation),
        note,
    }
}

/// Ratios of variances where they matter to the total.
fn ratios(
    (found, analytic): (Option<SixFigures>, Option<SixFigures>),
    total: Option<SixFigures>,
) -> BTreeMap<String, f64> {
    let (Some(found), Some(analytic), Some(total)) = (found, analytic, total) else {
        return BTreeMap::new();
    };
    let (found, analytic, total) = (found.in_order(), analytic.in_order(), total.in_order());
    (0..6)
        .filter(|&i| analytic[i] > 0.0 && (analytic[i] / total[i]).powi(2) >= COMPARED)
        .map(|i| (SIX[i].to_owned(), (found[i] / analytic[i]).powi(2)))
        .collect()
}
