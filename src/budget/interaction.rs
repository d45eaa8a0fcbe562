//! What the sources do to each other, seed by seed under common random numbers: to the ties (association), `e_all - e_true`, with `e_true`
//! the error of all sources together when nothing is tied to a face that it did not strike; and otherwise (interaction),
//! `e_true - e_none - sum (e_source - e_none)`.
//!
//! In a linear problem without robust weights the interaction is zero for every seed. Its scatter is therefore free of the noise
//! that the sources' own variances have from a finite number of trials, and shows the interaction even in a few of them.

use std::path::Path;

use super::experiment::{Cell, Experiment, Role};
use super::ledger::LedgerError;
use super::statistics::Moments;
use super::trial::{Error6, Trial};
use crate::results::BudgetPath;

/// The error of a path in a trial, if it was usable.
#[must_use]
pub fn error_of(trial: &Trial, path: BudgetPath) -> Option<Error6> {
    match path {
        BudgetPath::Joint => trial.joint.as_ref().ok().map(|j| j.error),
        BudgetPath::Sequential => trial.sequential.as_ref().ok().copied(),
        BudgetPath::SequentialProjected => trial.projected.as_ref().ok().copied(),
    }
}

/// What wrong ties add to each path's error, over the seeds in which it is usable with them and without; streamed.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn association(experiment: &Experiment, folder: &Path) -> Result<[Moments; 3], LedgerError> {
    let mut all = [(); 3].map(|()| Moments::default());
    let find = |role: Role| experiment.cells.iter().find(|cell| cell.role == role);
    let (Some(together), Some(true_ties)) = (find(Role::Together), find(Role::TrueTies)) else {
        return Ok(all);
    };
    let pairs = experiment.read(folder, together)?;
    for (together, true_ties) in pairs.zip(experiment.read(folder, true_ties)?) {
        let (together, true_ties) = (together?, true_ties?);
        for path in BudgetPath::ALL {
            let errors = error_of(&together, path).zip(error_of(&true_ties, path));
            if let Some((found, truly)) = errors {
                all[path as usize].add(&std::array::from_fn(|i| found[i] - truly[i]));
            }
        }
    }
    Ok(all)
}

/// The interaction of each path over the seeds that all cells have and in which that path is always usable; streamed.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn interaction(experiment: &Experiment, folder: &Path) -> Result<[Moments; 3], LedgerError> {
    let mut all = [(); 3].map(|()| Moments::default());
    let cells = &experiment.cells;
    let find = |role: Role| cells.iter().find(|cell| cell.role == role);
    let (Some(together), Some(nothing)) = (find(Role::TrueTies), find(Role::Nothing)) else {
        return Ok(all);
    };
    let Some(none) = experiment.read(folder, nothing)?.next().transpose()? else {
        return Ok(all);
    };
    let is_single = |cell: &&Cell| matches!(cell.role, Role::Alone(_));
    let mut singles = cells
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
        for path in BudgetPath::ALL {
            if let Some(rest) = beyond_the_sum(&together, &none, &row, path) {
                all[path as usize].add(&rest);
            }
        }
    }
    Ok(all)
}

fn beyond_the_sum(
    together: &Trial,
    none: &Trial,
    singles: &[Trial],
    path: BudgetPath,
) -> Option<Error6> {
    let none = error_of(none, path)?;
    let mut rest = error_of(together, path)?;
    for i in 0..6 {
        rest[i] -= none[i];
    }
    for single in singles {
        let single = error_of(single, path)?;
        for i in 0..6 {
            rest[i] -= single[i] - none[i];
        }
    }
    Some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::trial::Reason;

    fn trial(error: f64) -> Trial {
        let reason = Reason {
            code: "no_wall".to_owned(),
            text: String::new(),
        };
        Trial {
            seed: 1,
            joint: Err(reason),
            sequential: Ok([error; 6]),
            projected: Ok([2.0 * error; 6]),
        }
    }

    #[test]
    fn what_is_beyond_the_sum() {
        // the method 1, the sources 2 and 3 beyond it, all together 7: 1 + 2 + 3 and 1 more
        let singles = [trial(3.0), trial(4.0)];
        let rest = |path| beyond_the_sum(&trial(7.0), &trial(1.0), &singles, path);
        assert_eq!(rest(BudgetPath::Sequential), Some([1.0; 6]));
        assert_eq!(rest(BudgetPath::SequentialProjected), Some([2.0; 6]));
        assert_eq!(rest(BudgetPath::Joint), None);
    }
}
