//! A trial as a line of CSV and back.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use crate::adjust::Unit;
use crate::calibrate::tried::{Reason, Said, SoughtParameter, Trial, Tried};

/// What a line holds: names of the parameters with their units, and of the paths, the first of which reports a covariance.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Columns {
    parameters: Vec<String>,
    paths: Vec<String>,
}

impl Columns {
    /// Of what is tried.
    #[must_use]
    pub fn of(tried: &dyn Tried) -> Self {
        let name = |p: &SoughtParameter| format!("{}{}", p.name.replace(' ', "_"), suffix(p.unit));
        Self {
            parameters: tried.parameters().iter().map(name).collect(),
            paths: tried.paths().iter().map(|p| p.name.to_owned()).collect(),
        }
    }

    /// Their names.
    fn names(&self) -> Vec<String> {
        let mut all = vec!["seed".to_owned()];
        for (place, path) in self.paths.iter().enumerate() {
            let of_path = |name: &dyn std::fmt::Display| format!("{path}_{name}");
            all.extend(
                self.parameters
                    .iter()
                    .map(|p| of_path(&format!("error_{p}"))),
            );
            if place == 0 {
                let pair = |(i, j): (usize, usize)| {
                    format!("covariance_{}_{}", self.parameters[i], self.parameters[j])
                };
                all.extend(self.lower().map(|ij| of_path(&pair(ij))));
                all.push(of_path(&"variance_factor"));
            }
            all.extend([of_path(&"refusal"), of_path(&"reason")]);
        }
        all
    }

    /// The line of their names.
    pub(super) fn text(&self) -> String {
        self.names().join(",")
    }

    /// Places of the lower triangle by rows.
    fn lower(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let n = self.parameters.len();
        (0..n).flat_map(|i| (0..=i).map(move |j| (i, j)))
    }

    /// Fields of a path's figures, without the two of its refusal.
    fn figures(&self, path: usize) -> usize {
        let n = self.parameters.len();
        if path == 0 {
            n + n * (n + 1) / 2 + 1
        } else {
            n
        }
    }

    /// A record with its line end.
    pub(in crate::budget) fn line(&self, trial: &Trial) -> Vec<u8> {
        let mut fields = vec![trial.seed.to_string()];
        for (path, outcome) in trial.paths.iter().enumerate() {
            match outcome {
                Ok(said) => {
                    self.write(&mut fields, path, said);
                    fields.extend([String::new(), String::new()]);
                }
                Err(reason) => {
                    fields.extend(std::iter::repeat_n(String::new(), self.figures(path)));
                    fields.extend([reason.code.clone(), reason.text.clone()]);
                }
            }
        }
        let mut line = csv::WriterBuilder::new().from_writer(vec![]);
        // writing to memory does not fail
        let _ = line.write_record(&fields);
        line.into_inner().unwrap_or_default()
    }

    fn write(&self, fields: &mut Vec<String>, path: usize, said: &Said) {
        fields.extend(said.error.iter().copied().map(exact));
        if path > 0 {
            return;
        }
        let entry = |(i, j): (usize, usize)| said.covariance.as_ref().map(|c| exact(c[(i, j)]));
        fields.extend(self.lower().map(|ij| entry(ij).unwrap_or_default()));
        fields.push(said.variance_factor.map_or_else(String::new, exact));
    }

    pub(super) fn parse_line(&self, line: &[u8]) -> Option<Trial> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(line);
        let record = reader.records().next()?.ok()?;
        let fields: Vec<&str> = record.iter().collect();
        let (seed, mut rest) = fields.split_first()?;
        let mut paths = vec![];
        for path in 0..self.paths.len() {
            let (own, others) = rest.split_at_checked(self.figures(path) + 2)?;
            paths.push(self.outcome(path, own)?);
            rest = others;
        }
        let seed = seed.parse().ok()?;
        rest.is_empty().then_some(Trial { seed, paths })
    }

    fn outcome(&self, path: usize, fields: &[&str]) -> Option<Result<Said, Reason>> {
        let (figures, reason) = fields.split_at(self.figures(path));
        if !reason[0].is_empty() {
            return Some(Err(Reason {
                code: reason[0].to_owned(),
                text: reason[1].to_owned(),
            }));
        }
        let (error, more) = figures.split_at(self.parameters.len());
        let mut said = Said {
            error: numbers(error)?,
            covariance: None,
            variance_factor: None,
        };
        if let Some((factor, lower)) = more.split_last() {
            said.variance_factor = match *factor {
                "" => None,
                factor => Some(factor.parse().ok()?),
            };
            said.covariance = Some(self.covariance(&numbers(lower)?));
        }
        Some(Ok(said))
    }

    fn covariance(&self, lower: &[f64]) -> DMatrix<f64> {
        let n = self.parameters.len();
        let mut covariance = DMatrix::zeros(n, n);
        for ((i, j), value) in self.lower().zip(lower) {
            (covariance[(i, j)], covariance[(j, i)]) = (*value, *value);
        }
        covariance
    }
}

/// Unit at the end of a column's name.
fn suffix(unit: Unit) -> &'static str {
    match unit {
        Unit::Radian => "_rad",
        Unit::Metre => "_m",
        Unit::Second => "_s",
        Unit::One => "",
    }
}

/// The shortest digits that bring the number back.
fn exact(value: f64) -> String {
    format!("{value:e}")
}

fn numbers(fields: &[&str]) -> Option<Vec<f64>> {
    fields.iter().map(|field| field.parse().ok()).collect()
}
