//! Covariances of the paths' calibrations, from whichever of trials and propagation tells of them.

use std::path::Path;

use nalgebra::{DMatrix, DVector};

use super::experiment::{Experiment, Role};
use super::ledger::LedgerError;
use crate::calibrate::tried::{PathCovariance, Propagated, Said, Tried};
use crate::results::CovarianceOrigin;

/// Of the trials with all sources together: the mean reported covariance of a path that reports one, of any other the mean squared
/// error about zero; a path without a usable trial is left out.
///
/// # Errors
/// [`LedgerError`]: a ledger cannot be read.
pub fn of_trials(
    experiment: &Experiment<'_>,
    folder: &Path,
) -> Result<Vec<PathCovariance>, LedgerError> {
    let paths = experiment.tried.paths();
    let mut sums: Vec<Option<(DMatrix<f64>, u32)>> = vec![None; paths.len()];
    let together = experiment.cells.iter().find(|c| c.role == Role::Together);
    if let Some(cell) = together {
        for trial in experiment.read(folder, cell)? {
            for (sum, outcome) in sums.iter_mut().zip(trial?.paths) {
                if let Ok(said) = outcome {
                    let (before, count) = sum.take().unwrap_or_else(|| (zeros(&said), 0));
                    *sum = Some((before + covariance_of(&said), count + 1));
                }
            }
        }
    }
    let mean = |(place, (sum, count)): (usize, (DMatrix<f64>, u32))| PathCovariance {
        name: paths[place].name.to_owned(),
        origin: if place == 0 {
            CovarianceOrigin::Reported
        } else {
            CovarianceOrigin::Errors
        },
        covariance: sum / f64::from(count),
    };
    let usable = sums.into_iter().enumerate();
    Ok(usable
        .filter_map(|(place, sum)| Some(mean((place, sum?))))
        .collect())
}

fn zeros(said: &Said) -> DMatrix<f64> {
    DMatrix::zeros(said.error.len(), said.error.len())
}

fn covariance_of(said: &Said) -> DMatrix<f64> {
    let error = DVector::from_column_slice(&said.error);
    let squared = || &error * error.transpose();
    said.covariance.clone().unwrap_or_else(squared)
}

/// By propagation, for paths that no trial tells of: covariance of the error and its bias squared.
#[must_use]
pub fn or_propagated(
    mut found: Vec<PathCovariance>,
    tried: &dyn Tried,
    propagated: &Propagated,
) -> Vec<PathCovariance> {
    for path in &propagated.paths {
        if found.iter().any(|c| c.name == path.name) {
            continue;
        }
        let bias = DVector::from_column_slice(&path.bias);
        found.push(PathCovariance {
            name: path.name.to_owned(),
            origin: CovarianceOrigin::Propagated,
            covariance: &path.covariance + &bias * bias.transpose(),
        });
    }
    let paths = tried.paths();
    found.sort_by_key(|c| paths.iter().position(|path| path.name == c.name));
    found
}
