//! The trials as `result.json`: streamed from the ledgers cell by cell in the order of seeds, so that an interrupted run that was gone
//! on with gives the same bytes as one that was not, on any number of threads.

use std::path::Path;

use super::experiment::{Cell, Experiment, Role};
use super::interaction::{association, interaction};
use super::ledger::{Header, LedgerError};
use super::sources::{about, acting, size};
use super::statistics::{CONFIDENCE, Moments, Statistics, deviation_interval, six_values};
use super::sweep::Setting;
use super::trial::Configuration;
use crate::procedures::pool::SequentialConfig;
use crate::procedures::pool::config::Variant;
use crate::results::{
    BUDGET_FORMAT_VERSION, BudgetPath, BudgetResult, Origin, PathBudget, PathStatistics,
    SixFigures, SixValues, Software, SourceDescription, SourceShare, Sweep, SweepPoint, SweepValue,
};
use crate::simulate::{Scenario, Source};

/// The sums of every cell, in the experiment's order.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn statistics(experiment: &Experiment, folder: &Path) -> Result<Vec<Statistics>, LedgerError> {
    let of = |cell: &Cell| {
        let mut all = Statistics::default();
        for trial in experiment.read(folder, cell)? {
            all.add(&trial?);
        }
        Ok(all)
    };
    experiment.cells.iter().map(of).collect()
}

/// A budget without figures: what was asked for, and the sources in words. Without trials the first seed is 0.
#[must_use]
pub fn frame(scenario: &Scenario, configuration: &Configuration) -> BudgetResult {
    let header = Header::new(scenario, configuration, 0);
    let variant = |path| match path {
        BudgetPath::Joint => String::new(),
        BudgetPath::Sequential => variant_name(&configuration.sequential),
        BudgetPath::SequentialProjected => variant_name(&configuration.projected()),
    };
    let path = |path| PathBudget {
        path,
        variant: variant(path),
        together: None,
        predicted: None,
        shares: vec![],
        agreement: vec![],
        bound: None,
        efficiency: None,
    };
    BudgetResult {
        format_version: BUDGET_FORMAT_VERSION,
        scenario: scenario.name.clone(),
        scenario_sha256: header.scenario_sha256,
        software: Software::this(),
        first_seed: 0,
        trials: 0,
        single_trials: 0,
        confidence: CONFIDENCE,
        configuration: serde_json::json!({
            "sequential": configuration.sequential,
            "joint": configuration.joint,
        }),
        sources: acting(scenario)
            .into_iter()
            .map(|s| described(scenario, s))
            .collect(),
        paths: BudgetPath::ALL.map(path).into(),
        refusals: vec![],
        sweep: None,
        swath: None,
        command: String::new(),
        notes: vec![],
    }
}

/// Puts the trials' figures into a [`frame`].
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn fill(
    result: &mut BudgetResult,
    experiment: &Experiment,
    folder: &Path,
) -> Result<(), LedgerError> {
    let all = statistics(experiment, folder)?;
    let cells: Vec<(&Cell, &Statistics)> = experiment.cells.iter().zip(&all).collect();
    let apart = Apart {
        association: association(experiment, folder)?,
        interaction: interaction(experiment, folder)?,
    };
    result.first_seed = experiment.first_seed;
    for (cell, statistics) in &cells {
        match cell.role {
            Role::Together => {
                result.trials = cell.trials;
                result.refusals = statistics.refusals();
            }
            Role::Alone(_) => result.single_trials = cell.trials,
            Role::TrueTies => result.sources.push(association_described()),
            Role::Nothing | Role::Sweep(_) => {}
        }
    }
    for path in &mut result.paths {
        let found = cells.iter().find(|(c, _)| c.role == Role::Together);
        path.together = found.map(|(_, statistics)| statistics.of(path.path));
        path.shares.extend(shares(path.path, &cells, &apart));
    }
    result.sweep = sweep(&cells);
    Ok(())
}

/// What the sources do to each other, by path.
struct Apart {
    association: [Moments; 3],
    interaction: [Moments; 3],
}

/// Name of the association errors among the sources.
const ASSOCIATION: &str = "association";

fn association_described() -> SourceDescription {
    SourceDescription {
        source: ASSOCIATION.to_owned(),
        title: "association errors".to_owned(),
        description: "points on a face that they did not strike: what the other sources together do to the ties"
            .to_owned(),
        size: [].into(),
        default: [].into(),
        reference: "the simulation, which knows what each point struck".to_owned(),
    }
}

fn variant_name(config: &SequentialConfig) -> String {
    let name = match config.variant {
        Variant::Literal => "literal",
        Variant::Projected => "projected",
    };
    let repeated = if config.repeated { ", repeated" } else { "" };
    format!("{name}{repeated}")
}

fn described(scenario: &Scenario, source: Source) -> SourceDescription {
    let about = about(source);
    let owned = |(key, value): (&str, String)| (key.to_owned(), value);
    SourceDescription {
        source: about.name.to_owned(),
        title: about.title.to_owned(),
        description: about.description.to_owned(),
        size: size(scenario, source).into_iter().map(owned).collect(),
        default: about
            .default
            .iter()
            .map(|(key, value)| ((*key).to_owned(), *value))
            .collect(),
        reference: about.reference.to_owned(),
    }
}

/// The method's own error, each source alone, the association, the remainder and the interaction.
fn shares(path: BudgetPath, cells: &[(&Cell, &Statistics)], apart: &Apart) -> Vec<SourceShare> {
    let of = |role: &Role| cells.iter().find(|(c, _)| c.role == *role).map(|(_, s)| *s);
    let (Some(together), Some(nothing)) = (of(&Role::Together), of(&Role::Nothing)) else {
        return vec![];
    };
    let own = nothing.errors(path).mean();
    let total = together.errors(path).variance();
    let mut shares = vec![method(path, nothing)];
    for (cell, statistics) in cells {
        if let Role::Alone(source) = cell.role {
            shares.push(alone(path, source, statistics, own, total));
        }
    }
    let of_ties = &apart.association[path as usize];
    shares.push(differing(
        ASSOCIATION,
        of_ties,
        total,
        "error of all together minus the error with every point only on the face that it struck, seed by seed",
    ));
    shares.push(remainder(path, together, own, cells, of_ties));
    shares.push(differing(
        "interaction",
        &apart.interaction[path as usize],
        total,
        "error of all together with true ties minus the sum of the sources' errors, seed by seed: robust weights, non-linearity",
    ));
    shares
}

fn method(path: BudgetPath, nothing: &Statistics) -> SourceShare {
    let errors = nothing.errors(path);
    SourceShare {
        source: "nothing".to_owned(),
        origin: Origin::MonteCarlo,
        usable: errors.count(),
        trials: nothing.trials(),
        bias: errors.mean().and_then(SixFigures::from_si),
        bias_standard_error: None,
        standard_deviation: None,
        standard_deviation_interval: None,
        share: None,
        note: note(nothing, path, "the method's own error, without any source"),
    }
}

fn alone(
    path: BudgetPath,
    source: Source,
    statistics: &Statistics,
    own: Option<[f64; 6]>,
    total: Option<[f64; 6]>,
) -> SourceShare {
    let of: PathStatistics = statistics.of(path);
    let errors = statistics.errors(path);
    let (variance, mean) = (errors.variance(), errors.mean());
    SourceShare {
        source: about(source).name.to_owned(),
        origin: Origin::MonteCarlo,
        usable: of.usable,
        trials: of.trials,
        bias: mean
            .zip(own)
            .and_then(|(mean, own)| SixFigures::from_si(minus(mean, own))),
        bias_standard_error: of.bias_standard_error,
        standard_deviation: of.standard_deviation,
        standard_deviation_interval: variance.and_then(|_| deviation_interval(of.usable)),
        share: variance.zip(total).and_then(|(v, t)| ratio(v, t)),
        note: note(statistics, path, ""),
    }
}

/// A share that is a difference of errors, seed by seed.
fn differing(name: &str, of: &Moments, total: Option<[f64; 6]>, note: &str) -> SourceShare {
    let (n, variance) = (of.count(), of.variance());
    let si = |six: Option<[f64; 6]>| six.and_then(SixFigures::from_si);
    SourceShare {
        source: name.to_owned(),
        origin: Origin::MonteCarlo,
        usable: n,
        trials: n,
        bias: si(of.mean()),
        bias_standard_error: si(variance.map(|v| v.map(|v| (v / n as f64).sqrt()))),
        standard_deviation: si(variance.map(|v| v.map(f64::sqrt))),
        standard_deviation_interval: variance.and_then(|_| deviation_interval(n)),
        share: variance.zip(total).and_then(|(v, t)| ratio(v, t)),
        note: note.to_owned(),
    }
}

/// All together minus the sum, association included in it: what the sources do to each other (robust weights, non-linearity), and chance.
fn remainder(
    path: BudgetPath,
    together: &Statistics,
    own: Option<[f64; 6]>,
    cells: &[(&Cell, &Statistics)],
    of_ties: &Moments,
) -> SourceShare {
    let errors = together.errors(path);
    let mut variance = errors.variance();
    let mut bias = errors.mean().zip(own).map(|(m, own)| minus(m, own));
    for (_, single) in cells
        .iter()
        .filter(|(c, _)| matches!(c.role, Role::Alone(_)))
    {
        let single = single.errors(path);
        variance = variance.zip(single.variance()).map(|(v, s)| minus(v, s));
        let beyond = single.mean().zip(own).map(|(m, own)| minus(m, own));
        bias = bias.zip(beyond).map(|(b, s)| minus(b, s));
    }
    let ties = of_ties.variance().zip(of_ties.mean());
    if let Some((wrong, shift)) = ties {
        variance = variance.map(|v| minus(v, wrong));
        bias = bias.map(|b| minus(b, shift));
    }
    SourceShare {
        source: "remainder".to_owned(),
        origin: Origin::MonteCarlo,
        usable: errors.count(),
        trials: together.trials(),
        bias: bias.and_then(SixFigures::from_si),
        bias_standard_error: None,
        standard_deviation: None,
        standard_deviation_interval: None,
        share: variance
            .zip(errors.variance())
            .and_then(|(v, t)| ratio(v, t)),
        note: "all together minus the sum: robust weights, non-linearity, and chance".to_owned(),
    }
}

fn minus(a: [f64; 6], b: [f64; 6]) -> [f64; 6] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn ratio(part: [f64; 6], of: [f64; 6]) -> Option<SixValues> {
    let ratio: [f64; 6] = std::array::from_fn(|i| part[i] / of[i]);
    ratio
        .iter()
        .all(|r| r.is_finite())
        .then(|| six_values(ratio))
}

/// Says of trials without a usable result what they ended with.
fn note(statistics: &Statistics, path: BudgetPath, text: &str) -> String {
    let refusals = statistics.refusals();
    let mut parts = vec![];
    if !text.is_empty() {
        parts.push(text.to_owned());
    }
    for r in refusals.iter().filter(|r| r.path == path) {
        parts.push(format!("{} not usable: {}", r.count, r.example));
    }
    parts.join("; ")
}

fn sweep(cells: &[(&Cell, &Statistics)]) -> Option<Sweep> {
    let points: Vec<_> = cells
        .iter()
        .filter_map(|(cell, statistics)| match &cell.role {
            Role::Sweep(point) => Some((point, cell.trials, statistics)),
            _ => None,
        })
        .collect();
    let (first, trials, _) = points.first()?;
    Some(Sweep {
        keys: first.0.iter().map(|(key, _)| key.clone()).collect(),
        trials: *trials,
        points: points
            .iter()
            .map(|(point, _, statistics)| SweepPoint {
                values: point.0.iter().map(|(_, value)| plain(value)).collect(),
                paths: BudgetPath::ALL.map(|path| statistics.of(path)).into(),
                refusals: statistics.refusals(),
            })
            .collect(),
    })
}

/// A setting for `result.json`.
pub(super) fn plain(value: &Setting) -> SweepValue {
    match value {
        Setting::Number(number) => SweepValue::Number(*number),
        Setting::Flag(flag) => SweepValue::Flag(*flag),
        Setting::Text(text) => SweepValue::Text(text.clone()),
    }
}
