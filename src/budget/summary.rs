//! The trials as `result.json`: streamed from the ledgers cell by cell in the order of seeds, so that an interrupted run that was
//! continued gives the same bytes as one that was not, on any number of threads.

use std::collections::BTreeMap;
use std::path::Path;

use super::experiment::{Cell, Experiment, Role};
use super::interaction::{association, interaction};
use super::ledger::LedgerError;
use super::statistics::{
    CONFIDENCE, Statistics, deviation_interval, known, minus, of_mean, ratios, roots,
};
use crate::calibrate::quality::readable;
use crate::calibrate::tried::{SoughtParameter, Tried, TriedPath};
use crate::formats::digest::sha256_of;
use crate::results::{
    BUDGET_FORMAT_VERSION, BudgetParameter, BudgetResult, Figures, Origin, PathBudget,
    PathStatistics, Software, SourceDescription, SourceShare, Sweep, SweepPoint,
};
use crate::stats::Moments;

/// The sums of every cell, in the experiment's order.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn statistics(
    experiment: &Experiment<'_>,
    folder: &Path,
) -> Result<Vec<Statistics>, LedgerError> {
    let of = |cell: &Cell| {
        let mut all = Statistics::new(experiment.tried);
        for trial in experiment.read(folder, cell)? {
            all.add(&trial?);
        }
        Ok(all)
    };
    experiment.cells.iter().map(of).collect()
}

/// A budget without figures: what was asked for, and the sources in words. Without trials the first seed is 0.
#[must_use]
pub fn frame(tried: &dyn Tried) -> BudgetResult {
    let path = |path: TriedPath| PathBudget {
        path: path.name.to_owned(),
        variant: path.variant,
        together: None,
        predicted: None,
        shares: vec![],
        agreement: vec![],
        claimed: None,
        bound: None,
        efficiency: None,
    };
    let parameter = |p: SoughtParameter| BudgetParameter {
        name: p.name,
        unit: readable(0.0, p.unit).1.to_owned(),
    };
    BudgetResult {
        format_version: BUDGET_FORMAT_VERSION,
        procedure: tried.procedure().to_owned(),
        scenario: tried.scenario().to_owned(),
        scenario_sha256: sha256_of(&tried.content()),
        software: Software::this(),
        first_seed: 0,
        trials: 0,
        single_trials: 0,
        confidence: CONFIDENCE,
        configuration: tried.configuration(),
        parameters: tried.parameters().into_iter().map(parameter).collect(),
        wanted: BTreeMap::new(),
        sources: tried.sources(),
        paths: tried.paths().into_iter().map(path).collect(),
        refusals: vec![],
        sweep: None,
        swath: None,
        command: String::new(),
        notes: tried.notes(),
    }
}

/// Puts the trials' figures into a [`frame`].
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn fill(
    result: &mut BudgetResult,
    experiment: &Experiment<'_>,
    folder: &Path,
) -> Result<(), LedgerError> {
    let all = statistics(experiment, folder)?;
    let cells = Cells {
        all: experiment.cells.iter().zip(&all).collect(),
        sources: experiment
            .tried
            .sources()
            .into_iter()
            .map(|s| s.source)
            .collect(),
        association: association(experiment, folder)?,
        interaction: interaction(experiment, folder)?,
    };
    result.first_seed = experiment.first_seed;
    for (cell, statistics) in &cells.all {
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
    for (place, path) in result.paths.iter_mut().enumerate() {
        path.together = cells.of(&Role::Together).map(|s| s.of(place));
        path.claimed = cells.of(&Role::Nothing).and_then(|s| s.claimed(place));
        path.shares.extend(cells.shares(place));
    }
    result.sweep = sweep(experiment, &cells);
    Ok(())
}

/// What the ledgers hold, summed up.
struct Cells<'a> {
    all: Vec<(&'a Cell, &'a Statistics)>,
    /// Names of the sources in order.
    sources: Vec<String>,
    association: Option<Vec<Moments>>,
    interaction: Vec<Moments>,
}

/// Name of the association errors among the sources.
const ASSOCIATION: &str = "association";

fn association_described() -> SourceDescription {
    SourceDescription {
        source: ASSOCIATION.to_owned(),
        title: "association errors".to_owned(),
        description: "points tied to a face that they did not hit: what the other sources together do to the ties"
            .to_owned(),
        size: [].into(),
        default: [].into(),
        reference: "the simulation, which knows what each point hit".to_owned(),
    }
}

impl Cells<'_> {
    fn of(&self, role: &Role) -> Option<&Statistics> {
        let mut all = self.all.iter();
        all.find(|(cell, _)| cell.role == *role).map(|(_, s)| *s)
    }

    /// The method's own error, each source alone, the association, the remainder and the interaction.
    fn shares(&self, path: usize) -> Vec<SourceShare> {
        let (Some(together), Some(nothing)) = (self.of(&Role::Together), self.of(&Role::Nothing))
        else {
            return vec![];
        };
        let own = nothing.errors(path).mean();
        let total = together.errors(path).variance();
        let of_ties = self.association.as_ref().map(|all| &all[path]);
        let mut shares = vec![method(path, nothing)];
        for (cell, statistics) in &self.all {
            if let Role::Alone(place) = cell.role {
                let name = &self.sources[place];
                shares.push(alone(
                    path,
                    name,
                    statistics,
                    own.as_deref(),
                    total.as_deref(),
                ));
            }
        }
        let beyond = |name, of, note| differing(name, of, together, total.as_deref(), note);
        shares.extend(of_ties.map(|ties| beyond(ASSOCIATION, ties, BY_TIES)));
        shares.push(self.remainder(path, together, own.as_deref(), of_ties));
        let note = if of_ties.is_some() {
            WITH_TRUE_TIES
        } else {
            AS_THEY_ARE
        };
        shares.push(beyond("interaction", &self.interaction[path], note));
        shares
    }

    /// All together minus the sum, association included in it: what the sources do to each other (robust weights, non-linearity), and
    /// chance.
    fn remainder(
        &self,
        path: usize,
        together: &Statistics,
        own: Option<&[f64]>,
        of_ties: Option<&Moments>,
    ) -> SourceShare {
        let errors = together.errors(path);
        let less = |a: Option<Vec<f64>>, b: Option<Vec<f64>>| Some(minus(&a?, &b?));
        let mut variance = errors.variance();
        let mut bias = less(errors.mean(), own.map(<[f64]>::to_vec));
        let singles = self
            .all
            .iter()
            .filter(|(c, _)| matches!(c.role, Role::Alone(_)));
        for (_, single) in singles {
            let single = single.errors(path);
            variance = less(variance, single.variance());
            bias = less(bias, less(single.mean(), own.map(<[f64]>::to_vec)));
        }
        if let Some((wrong, shift)) = of_ties.and_then(|t| t.variance().zip(t.mean())) {
            variance = less(variance, Some(wrong));
            bias = less(bias, Some(shift));
        }
        SourceShare {
            source: "remainder".to_owned(),
            origin: Origin::MonteCarlo,
            usable: errors.count(),
            trials: together.trials(),
            bias: bias.and_then(|b| together.shown(&b)),
            bias_standard_error: None,
            standard_deviation: None,
            standard_deviation_interval: None,
            share: share_of(variance, errors.variance().as_deref()),
            note: "all together minus the sum: robust weights, non-linearity, and chance"
                .to_owned(),
        }
    }
}

const BY_TIES: &str = "error of all together minus the error with every point only on the face that it struck, seed by seed";
const WITH_TRUE_TIES: &str = "error of all together with true ties minus the sum of the sources' errors, seed by seed: robust weights, non-linearity";
const AS_THEY_ARE: &str = "error of all together minus the sum of the sources' errors, seed by seed: robust weights, non-linearity";

fn share_of(variance: Option<Vec<f64>>, total: Option<&[f64]>) -> Option<Figures> {
    known(ratios(&variance?, total?))
}

fn method(path: usize, nothing: &Statistics) -> SourceShare {
    let errors = nothing.errors(path);
    SourceShare {
        source: "nothing".to_owned(),
        origin: Origin::MonteCarlo,
        usable: errors.count(),
        trials: nothing.trials(),
        bias: errors.mean().and_then(|mean| nothing.shown(&mean)),
        bias_standard_error: None,
        standard_deviation: None,
        standard_deviation_interval: None,
        share: None,
        note: note(nothing, path, "the method's own error, without any source"),
    }
}

fn alone(
    path: usize,
    source: &str,
    statistics: &Statistics,
    own: Option<&[f64]>,
    total: Option<&[f64]>,
) -> SourceShare {
    let of: PathStatistics = statistics.of(path);
    let errors = statistics.errors(path);
    let (variance, mean) = (errors.variance(), errors.mean());
    let beyond = mean.zip(own).map(|(mean, own)| minus(&mean, own));
    SourceShare {
        source: source.to_owned(),
        origin: Origin::MonteCarlo,
        usable: of.usable,
        trials: of.trials,
        bias: beyond.and_then(|bias| statistics.shown(&bias)),
        bias_standard_error: of.bias_standard_error,
        standard_deviation: of.standard_deviation,
        standard_deviation_interval: variance
            .as_ref()
            .and_then(|_| deviation_interval(of.usable)),
        share: share_of(variance, total),
        note: note(statistics, path, ""),
    }
}

/// A share that is a difference of errors, seed by seed.
fn differing(
    name: &str,
    of: &Moments,
    together: &Statistics,
    total: Option<&[f64]>,
    note: &str,
) -> SourceShare {
    let (n, variance) = (of.count(), of.variance());
    let shown = |figures: Option<Vec<f64>>| figures.and_then(|f| together.shown(&f));
    SourceShare {
        source: name.to_owned(),
        origin: Origin::MonteCarlo,
        usable: n,
        trials: n,
        bias: shown(of.mean()),
        bias_standard_error: shown(variance.as_deref().map(|v| of_mean(v, n))),
        standard_deviation: shown(variance.as_deref().map(roots)),
        standard_deviation_interval: variance.as_ref().and_then(|_| deviation_interval(n)),
        share: share_of(variance, total),
        note: note.to_owned(),
    }
}

/// Says of trials without a usable result what they ended with.
fn note(statistics: &Statistics, path: usize, text: &str) -> String {
    let (refusals, path) = (statistics.refusals(), statistics.of(path).path);
    let mut parts = vec![];
    if !text.is_empty() {
        parts.push(text.to_owned());
    }
    for r in refusals.iter().filter(|r| r.path == path) {
        parts.push(format!("{} not usable: {}", r.count, r.example));
    }
    parts.join("; ")
}

fn sweep(experiment: &Experiment<'_>, cells: &Cells<'_>) -> Option<Sweep> {
    let of_sweep = |(cell, statistics): &(&Cell, &Statistics)| match cell.role {
        Role::Sweep(place) => Some(SweepPoint {
            values: experiment.points[place]
                .0
                .0
                .iter()
                .map(|(_, v)| v.plain())
                .collect(),
            paths: (0..experiment.tried.paths().len())
                .map(|path| statistics.of(path))
                .collect(),
            refusals: statistics.refusals(),
        }),
        _ => None,
    };
    let (first, _) = experiment.points.first()?;
    let is_point = |cell: &&Cell| matches!(cell.role, Role::Sweep(_));
    Some(Sweep {
        keys: first.0.iter().map(|(key, _)| key.clone()).collect(),
        trials: experiment.cells.iter().find(is_point)?.trials,
        points: cells.all.iter().filter_map(of_sweep).collect(),
    })
}
