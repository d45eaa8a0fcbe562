//! The analytic budget in the form of `result.json`, beside the trials' figures and compared with them.

use std::collections::BTreeMap;

use super::statistics::{known, ratios as quotients, roots, shown, variance_ratio_interval};
use crate::adjust::Unit;
use crate::calibrate::tried::{Moved, Propagated, PropagatedPath, Tried};
use crate::results::{Agreement, BudgetResult, Origin, PathBudget, PathStatistics, SourceShare};

/// Parts of a path's variance below this are not compared: what decides there is one tie more or less.
const COMPARED: f64 = 1e-3;

/// Usable trials below which their variance says less of a path than its derivatives do: one sigma of it is above a fifth.
const TELLING: u64 = 50;

/// Adds the analytic figures to a result that already has those of the trials, if there are any.
pub fn add(result: &mut BudgetResult, tried: &dyn Tried, propagated: &Propagated) {
    let units: Vec<Unit> = tried.parameters().iter().map(|p| p.unit).collect();
    for path in &mut result.paths {
        let Some(budget) = propagated.paths.iter().find(|p| p.name == path.path) else {
            continue;
        };
        let of = Of {
            units: &units,
            total: diagonal(budget),
        };
        let mut shares = of.shares(budget);
        shares.append(&mut path.shares);
        path.shares = shares;
        path.predicted = Some(of.together(budget));
        let bound = propagated.bound.as_deref();
        path.bound = bound.and_then(|bound| shown(&units, &deviations(bound)));
        path.efficiency = bound.and_then(|bound| {
            let variance = trials_variance(path, &units).unwrap_or(of.total);
            known(quotients(bound, &variance))
        });
    }
    result.notes.extend(propagated.notes.iter().cloned());
    compare(result);
}

/// What propagation says of each path as figures of no trial: bias, standard deviation and RMS error.
///
/// # Errors
/// Why there are none, in words.
pub fn statistics(tried: &dyn Tried) -> Result<Vec<PathStatistics>, String> {
    let units: Vec<Unit> = tried.parameters().iter().map(|p| p.unit).collect();
    let propagated = match tried.propagated() {
        Some(propagated) => propagated?,
        None => return Err("this procedure has no propagation; give --trials".to_owned()),
    };
    let of_path = |path: &PropagatedPath| {
        let variance = diagonal(path);
        let squares = variance.iter().zip(&path.bias);
        let rms: Vec<f64> = squares.map(|(v, b)| (v.max(0.0) + b * b).sqrt()).collect();
        PathStatistics {
            path: path.name.to_owned(),
            trials: 0,
            usable: 0,
            bias: shown(&units, &path.bias),
            bias_standard_error: None,
            standard_deviation: shown(&units, &deviations(&variance)),
            standard_deviation_interval: None,
            rms: shown(&units, &rms),
            reported: None,
        }
    };
    Ok(propagated.paths.iter().map(of_path).collect())
}

/// What every figure of a path refers to.
struct Of<'a> {
    units: &'a [Unit],
    /// Variance of everything together.
    total: Vec<f64>,
}

impl Of<'_> {
    fn shares(&self, budget: &PropagatedPath) -> Vec<SourceShare> {
        let own = Moved {
            bias: budget.method_bias.clone(),
            variance: vec![0.0; self.units.len()],
        };
        let note = "the method's own error, without any source";
        let mut shares = vec![self.share("nothing", Some(&own), note)];
        for (name, moved) in &budget.sources {
            shares.push(match moved {
                Ok(moved) => self.share(name, Some(moved), ""),
                Err(reason) => self.share(name, None, reason),
            });
        }
        shares
    }

    fn together(&self, budget: &PropagatedPath) -> SourceShare {
        let all = Moved {
            bias: budget.bias.clone(),
            variance: self.total.clone(),
        };
        self.share("together", Some(&all), "all sources that have a derivative")
    }

    fn share(&self, source: &str, moved: Option<&Moved>, note: &str) -> SourceShare {
        let part = |moved: &Moved| known(quotients(&moved.variance, &self.total));
        let sigmas = |moved: &Moved| shown(self.units, &deviations(&moved.variance));
        SourceShare {
            source: source.to_owned(),
            origin: Origin::Analytic,
            usable: 0,
            trials: 0,
            bias: moved.and_then(|moved| shown(self.units, &moved.bias)),
            bias_standard_error: None,
            standard_deviation: moved.and_then(sigmas),
            standard_deviation_interval: None,
            share: moved.and_then(part),
            note: note.to_owned(),
        }
    }
}

fn deviations(variance: &[f64]) -> Vec<f64> {
    let positive: Vec<f64> = variance.iter().map(|v| v.max(0.0)).collect();
    roots(&positive)
}

fn diagonal(budget: &PropagatedPath) -> Vec<f64> {
    budget.covariance.diagonal().iter().copied().collect()
}

/// In SI units and radians; `None` of too few trials.
fn trials_variance(path: &PathBudget, units: &[Unit]) -> Option<Vec<f64>> {
    let together = path.together.as_ref().filter(|t| t.usable >= TELLING)?;
    let deviation = together.standard_deviation.as_ref()?;
    let variance = |(sigma, unit): (&Option<f64>, &Unit)| match (sigma.unwrap_or(f64::NAN), unit) {
        (sigma, Unit::Radian) => sigma.to_radians() * sigma.to_radians(),
        (sigma, Unit::Metre | Unit::Second | Unit::One) => sigma * sigma,
    };
    Some(deviation.iter().zip(units).map(variance).collect())
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
    let names: Vec<String> = result.parameters.iter().map(|p| p.name.clone()).collect();
    let pairs: Vec<Pair> = result
        .paths
        .iter()
        .enumerate()
        .flat_map(|(k, path)| pairs(k, path, &names))
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

fn pairs(k: usize, path: &PathBudget, names: &[String]) -> Vec<Pair> {
    let Some(predicted) = &path.predicted else {
        return vec![];
    };
    let by = |origin: Origin, source: &str| {
        path.shares
            .iter()
            .find(|s| s.origin == origin && s.source == source)
    };
    let total = predicted.standard_deviation.as_deref();
    let mut pairs = vec![];
    for analytic in path.shares.iter().filter(|s| s.origin == Origin::Analytic) {
        let Some(found) = by(Origin::MonteCarlo, &analytic.source) else {
            continue;
        };
        let (of_trials, of_analysis) = (&found.standard_deviation, &analytic.standard_deviation);
        pairs.push(Pair {
            path: k,
            source: analytic.source.clone(),
            trials: found.usable,
            ratio: ratios(names, of_trials.as_deref(), of_analysis.as_deref(), total),
            note: "so small a source moves the result by single ties at the edges of faces, or by a bias of second order: \
                   docs/error-budget-theory.md"
                .to_owned(),
        });
    }
    if let Some(together) = &path.together {
        pairs.push(all(k, path, together, predicted, names));
    }
    pairs.retain(|p| !p.ratio.is_empty());
    pairs
}

fn all(
    k: usize,
    path: &PathBudget,
    together: &PathStatistics,
    predicted: &SourceShare,
    names: &[String],
) -> Pair {
    let (found, total) = (
        &together.standard_deviation,
        predicted.standard_deviation.as_deref(),
    );
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
        ratio: ratios(names, found.as_deref(), total, total),
        note,
    }
}

/// Ratios of variances where they matter to the total.
fn ratios(
    names: &[String],
    found: Option<&[Option<f64>]>,
    analytic: Option<&[Option<f64>]>,
    total: Option<&[Option<f64>]>,
) -> BTreeMap<String, f64> {
    let (Some(found), Some(analytic), Some(total)) = (found, analytic, total) else {
        return BTreeMap::new();
    };
    let ratio = |i: usize| {
        let (found, analytic, total) = (found[i]?, analytic[i]?, total[i]?);
        let matters = analytic > 0.0 && (analytic / total).powi(2) >= COMPARED;
        matters.then(|| (names[i].clone(), (found / analytic).powi(2)))
    };
    (0..names.len()).filter_map(ratio).collect()
}
