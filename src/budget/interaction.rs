//! What the sources do to each other, seed by seed under common random numbers: to the ties (association), `e_all - e_true`, with `e_true`
//! the error of all sources together when nothing is tied to a face that it did not strike; and otherwise (interaction),
//! `e_true - e_none - sum (e_source - e_none)`.
//!
//! In a linear problem without robust weights the interaction is zero for every seed. Its scatter is therefore free of the noise
//! that the sources' own variances have from a finite number of trials, and shows the interaction even in a few of them.

use std::path::Path;

use super::experiment::{Cell, Experiment, Role};
use super::ledger::LedgerError;
use super::statistics::minus;
use crate::calibrate::tried::Trial;
use crate::stats::Moments;

/// The error of a path in a trial, if it was usable.
fn error_of(trial: &Trial, path: usize) -> Option<&Vec<f64>> {
    Some(&trial.paths.get(path)?.as_ref().ok()?.error)
}

/// Sums of nothing, for every path.
fn empty(experiment: &Experiment<'_>) -> Vec<Moments> {
    let parameters = experiment.tried.parameters().len();
    vec![Moments::new(parameters); experiment.tried.paths().len()]
}

fn cell_of<'e>(experiment: &'e Experiment<'_>, role: &Role) -> Option<&'e Cell> {
    experiment.cells.iter().find(|cell| cell.role == *role)
}

/// What wrong ties add to each path's error, over the seeds in which it is usable with them and without; streamed. `None` where no
/// trials with true ties were run.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn association(
    experiment: &Experiment<'_>,
    folder: &Path,
) -> Result<Option<Vec<Moments>>, LedgerError> {
    let find = |role| cell_of(experiment, &role);
    let (Some(together), Some(true_ties)) = (find(Role::Together), find(Role::TrueTies)) else {
        return Ok(None);
    };
    let mut all = empty(experiment);
    let pairs = experiment.read(folder, together)?;
    for (together, true_ties) in pairs.zip(experiment.read(folder, true_ties)?) {
        let (together, true_ties) = (together?, true_ties?);
        for (path, sums) in all.iter_mut().enumerate() {
            let errors = error_of(&together, path).zip(error_of(&true_ties, path));
            if let Some((found, truly)) = errors {
                sums.add(&minus(found, truly));
            }
        }
    }
    Ok(Some(all))
}

/// The interaction of each path over the seeds that all cells have and in which that path is always usable; streamed. Without trials
/// with true ties it is that of all together as they are.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn interaction(
    experiment: &Experiment<'_>,
    folder: &Path,
) -> Result<Vec<Moments>, LedgerError> {
    let mut all = empty(experiment);
    let find = |role| cell_of(experiment, &role);
    let together = find(Role::TrueTies).or(find(Role::Together));
    let (Some(together), Some(nothing)) = (together, find(Role::Nothing)) else {
        return Ok(all);
    };
    let Some(none) = experiment.read(folder, nothing)?.next().transpose()? else {
        return Ok(all);
    };
    let is_single = |cell: &&Cell| matches!(cell.role, Role::Alone(_));
    let mut singles = experiment
        .cells
        .iter()
        .filter(is_single)
        .map(|cell| experiment.read(folder, cell))
        .collect::<Result<Vec<_>, _>>()?;
    for together in experiment.read(folder, together)? {
        let together = together?;
        let row: Option<Vec<_>> = singles.iter_mut().map(Iterator::next).collect();
        let Some(row) = row.filter(|row| !row.is_empty()) else {
            break;
        };
        let row = row.into_iter().collect::<Result<Vec<Trial>, _>>()?;
        for (path, sums) in all.iter_mut().enumerate() {
            if let Some(rest) = beyond_the_sum(&together, &none, &row, path) {
                sums.add(&rest);
            }
        }
    }
    Ok(all)
}

fn beyond_the_sum(
    together: &Trial,
    none: &Trial,
    singles: &[Trial],
    path: usize,
) -> Option<Vec<f64>> {
    let none = error_of(none, path)?;
    let mut rest = minus(error_of(together, path)?, none);
    for single in singles {
        rest = minus(&rest, &minus(error_of(single, path)?, none));
    }
    Some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::tried::{Reason, Said};

    fn trial(error: f64) -> Trial {
        let said = |error| Said {
            error: vec![error; 3],
            covariance: None,
            variance_factor: None,
        };
        Trial {
            seed: 1,
            paths: vec![
                Err(Reason::new("no_wall", &"")),
                Ok(said(error)),
                Ok(said(2.0 * error)),
            ],
        }
    }

    #[test]
    fn what_is_beyond_the_sum() {
        // the method 1, the sources 2 and 3 beyond it, all together 7: 1 + 2 + 3 and 1 more
        let singles = [trial(3.0), trial(4.0)];
        let rest = |path| beyond_the_sum(&trial(7.0), &trial(1.0), &singles, path);
        assert_eq!(rest(1), Some(vec![1.0; 3]));
        assert_eq!(rest(2), Some(vec![2.0; 3]));
        assert_eq!(rest(0), None);
    }
}
