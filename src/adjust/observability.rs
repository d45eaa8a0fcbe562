//! What the data determine, and what they do not, in words.

use nalgebra::DMatrix;

use super::parameters::{Component, ParameterSet, Unit};
use super::quality::correlation;
use super::solve::Solution;

/// Largest standard deviation that still counts as determined, per unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Angles (rad).
    pub radian: f64,
    /// Lengths (m).
    pub metre: f64,
    /// Times (s).
    pub second: f64,
    /// Numbers without unit.
    pub one: f64,
    /// Correlation, without sign, from which two parameters are called inseparable.
    pub correlation: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            radian: 1f64.to_radians(),
            metre: 0.5,
            second: 0.1,
            one: 0.1,
            correlation: 0.95,
        }
    }
}

impl Limits {
    fn of(&self, unit: Unit) -> f64 {
        match unit {
            Unit::Radian => self.radian,
            Unit::Metre => self.metre,
            Unit::Second => self.second,
            Unit::One => self.one,
        }
    }
}

/// Two parameters that the data hardly tell apart.
#[derive(Debug, Clone, PartialEq)]
pub struct WeakPair {
    /// Columns.
    pub columns: (usize, usize),
    /// Their correlation.
    pub correlation: f64,
    /// In words.
    pub words: String,
}

/// A parameter that the data do not determine.
#[derive(Debug, Clone, PartialEq)]
pub struct Undetermined {
    /// Column.
    pub column: usize,
    /// Its standard deviation; infinite when the normal matrix is singular in its direction.
    pub sigma: f64,
    /// The limit it exceeds.
    pub limit: f64,
    /// In words.
    pub words: String,
}

/// A direction of the scaled parameter space and how well it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    /// Share of each column in standard deviations of the direction, in the column's own unit: the shape of the error.
    pub error: Vec<f64>,
    /// Its eigenvalue in the scaled normal matrix, whose diagonal is one.
    pub eigenvalue: f64,
}

/// Verdict on the normal matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Observability {
    /// Ratio of the largest to the smallest singular value of the scaled Jacobian (root of the condition of the normal matrix).
    pub condition: f64,
    /// Rank of the scaled normal matrix.
    pub rank: usize,
    /// Free columns.
    pub unknowns: usize,
    /// Directions, weakest first.
    pub directions: Vec<Direction>,
    /// Pairs correlated beyond the limit, most correlated first.
    pub pairs: Vec<WeakPair>,
    /// Parameters beyond their limits.
    pub undetermined: Vec<Undetermined>,
}

/// Judges what a solution's data determine.
pub fn observability(solution: &Solution, limits: &Limits) -> Observability {
    let spectrum = &solution.linearisation.spectrum;
    let parameters = &solution.estimate.parameters;
    let largest = spectrum.singular.iter().copied().fold(0.0, f64::max);
    let smallest = spectrum
        .singular
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    Observability {
        condition: if spectrum.size() == 0 {
            1.0
        } else {
            largest / smallest
        },
        rank: spectrum
            .singular
            .iter()
            .filter(|s| **s > spectrum.threshold)
            .count(),
        unknowns: spectrum.size(),
        directions: directions(solution),
        pairs: pairs(parameters, &solution.cofactor, limits),
        undetermined: undetermined(solution, limits),
    }
}

fn directions(solution: &Solution) -> Vec<Direction> {
    let spectrum = &solution.linearisation.spectrum;
    let parameters = &solution.estimate.parameters;
    let free = parameters.free_columns();
    let mut order: Vec<usize> = (0..spectrum.size()).collect();
    order.sort_by(|a, b| spectrum.singular[*a].total_cmp(&spectrum.singular[*b]));
    let direction = |i: usize| {
        let mut error = vec![0.0; parameters.columns()];
        let singular = spectrum.singular[i].max(spectrum.threshold);
        for (j, column) in free.iter().enumerate() {
            error[*column] = spectrum.axes[(j, i)] / (spectrum.scale[j] * singular);
        }
        Direction {
            error,
            eigenvalue: spectrum.singular[i].powi(2),
        }
    };
    order.into_iter().map(direction).collect()
}

fn pairs(parameters: &ParameterSet, cofactor: &DMatrix<f64>, limits: &Limits) -> Vec<WeakPair> {
    let names: Vec<&Component> = parameters.components().collect();
    let correlation = correlation(cofactor);
    let mut pairs = Vec::new();
    for i in 0..names.len() {
        for j in i + 1..names.len() {
            let value = correlation[(i, j)];
            if value.abs() >= limits.correlation {
                let words = inseparable(names[i], names[j], value);
                pairs.push(WeakPair {
                    columns: (i, j),
                    correlation: value,
                    words,
                });
            }
        }
    }
    pairs.sort_by(|a, b| b.correlation.abs().total_cmp(&a.correlation.abs()));
    pairs
}

fn inseparable(a: &Component, b: &Component, correlation: f64) -> String {
    let degree = if correlation.abs() >= 0.9995 {
        "inseparable"
    } else {
        "nearly inseparable"
    };
    format!(
        "{} and {} are {degree} in this data (correlation {correlation:.3})",
        a.name, b.name
    )
}

fn undetermined(solution: &Solution, limits: &Limits) -> Vec<Undetermined> {
    let parameters = &solution.estimate.parameters;
    let singular = singular_columns(solution);
    let mut found = Vec::new();
    for (column, component) in parameters.components().enumerate() {
        let is_singular = singular.contains(&column);
        let sigma = if is_singular {
            f64::INFINITY
        } else {
            solution.cofactor[(column, column)].sqrt()
        };
        let limit = limits.of(component.unit);
        if sigma > limit || sigma.is_nan() {
            let words = not_determined(component, sigma, limit);
            found.push(Undetermined {
                column,
                sigma,
                limit,
                words,
            });
        }
    }
    found
}

/// Columns with a share in a direction of zero information.
fn singular_columns(solution: &Solution) -> Vec<usize> {
    let spectrum = &solution.linearisation.spectrum;
    let axes = spectrum.undetermined();
    let free = solution.estimate.parameters.free_columns();
    let takes_part = |j: &usize| axes.iter().any(|axis| axis[*j].abs() > 1e-6);
    (0..free.len())
        .filter(takes_part)
        .map(|j| free[j])
        .collect()
}

fn not_determined(component: &Component, sigma: f64, limit: f64) -> String {
    let name = &component.name;
    if sigma.is_infinite() {
        return format!(
            "{name} is not determined by the data: the normal matrix is singular in its direction"
        );
    }
    let (sigma, limit) = (worded(sigma, component.unit), worded(limit, component.unit));
    format!(
        "{name} is not determined by the data: its standard deviation is {sigma}, the limit is {limit}"
    )
}

fn worded(value: f64, unit: Unit) -> String {
    match unit {
        Unit::Radian => format!("{:.2} deg", value.to_degrees()),
        Unit::Metre => format!("{value:.3} m"),
        Unit::Second => format!("{value:.4} s"),
        Unit::One => format!("{value:.4}"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::*;

    /// `x0 + k x1 = 0` with a tiny spread of `k`, and nothing about `x2`.
    struct Line(f64);

    impl Conditions for Line {
        fn len(&self) -> usize {
            50
        }

        fn linearise(&self, k: usize, x: &ParameterSet, _: Option<&ChainState>, row: &mut Row) {
            let slope = 1.0 + self.0 * k as f64;
            let value = &x.blocks()[0].value;
            row.misclosure = value[0] + slope * value[1];
            row.variance = 1e-4;
            row.extend(0, &[1.0, slope, 0.0]);
        }
    }

    fn solved(spread: f64) -> Solution {
        let names = [
            ("yaw", Unit::Radian),
            ("ly", Unit::Metre),
            ("latency", Unit::Second),
        ];
        let components = names
            .map(|(name, unit)| Component::new(name, unit))
            .to_vec();
        let mut parameters = ParameterSet::new();
        parameters
            .push(Block::euclidean("x", components, &[0.1, 0.2, 0.3]))
            .unwrap();
        let line = Line(spread);
        solve(
            &Problem::dense(vec![Source::new(&line)]),
            Estimate::new(parameters),
            &Options::default(),
        )
        .unwrap()
    }

    #[test]
    fn a_missing_parameter_is_refused_by_name() {
        let solution = solved(1.0);
        assert!(matches!(solution.status, Status::RankDeficient { .. }));
        let verdict = observability(&solution, &Limits::default());
        assert_eq!((verdict.rank, verdict.unknowns), (2, 3));
        assert_eq!(verdict.undetermined.len(), 1);
        assert!(
            verdict.undetermined[0]
                .words
                .starts_with("latency is not determined")
        );
    }

    #[test]
    fn inseparable_parameters_are_named() {
        let verdict = observability(&solved(1e-4), &Limits::default());
        assert_eq!(verdict.pairs.len(), 1);
        assert!(
            verdict.pairs[0]
                .words
                .starts_with("yaw and ly are inseparable in this data (correlation -1.000")
        );
        assert!(
            verdict
                .undetermined
                .iter()
                .any(|one| one.words.starts_with("ly") && one.sigma > 0.5)
        );
    }
}
