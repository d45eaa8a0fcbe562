//! Checks the derivatives of conditions by central differences over the charts and the chain.

use super::chain::{ChainModel, ChainState, VISIBLE};
use super::condition::{Conditions, Row};
use super::problem::Estimate;

/// A derivative that differs from its central difference.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivativeFault {
    /// Condition.
    pub condition: usize,
    /// Column, or the number of columns plus the visible quantity.
    pub column: usize,
    /// Derivative given.
    pub given: f64,
    /// Central difference.
    pub difference: f64,
}

/// Compares every derivative of conditions `which` with central differences of step `step` (in the columns' own units); lists
/// those off by more than `tolerance` relative to the row's largest derivative.
///
/// In a Gauss-Helmert condition the adjusted observations move with the parameters; differences agree where the residuals are
/// zero, or to the order of the residuals over the range.
pub fn check_derivatives(
    conditions: &dyn Conditions,
    which: &[usize],
    at: &Estimate,
    model: Option<&ChainModel>,
    step: f64,
    tolerance: f64,
) -> Vec<DerivativeFault> {
    let check = Check {
        conditions,
        at,
        model,
        step,
    };
    which
        .iter()
        .flat_map(|condition| check.condition(*condition, tolerance))
        .collect()
}

struct Check<'a> {
    conditions: &'a dyn Conditions,
    at: &'a Estimate,
    model: Option<&'a ChainModel>,
    step: f64,
}

impl Check<'_> {
    fn condition(&self, condition: usize, tolerance: f64) -> Vec<DerivativeFault> {
        let row = self.row(condition, self.at);
        let columns = self.at.parameters.columns();
        let mut given = vec![0.0; columns + VISIBLE];
        for (column, value) in row.columns().iter().zip(row.values()) {
            given[usize::from(*column)] += value;
        }
        if let Some(chain) = &row.chain {
            given[columns..].copy_from_slice(&chain.visible);
        }
        let largest = given
            .iter()
            .fold(0.0f64, |largest, value| largest.max(value.abs()));
        let fault = |column: usize| {
            let difference = self.difference(condition, column, &row)?;
            let off = (difference - given[column]).abs();
            let fine = off <= tolerance * largest;
            (!fine).then(|| DerivativeFault {
                condition,
                column,
                given: given[column],
                difference,
            })
        };
        (0..given.len()).filter_map(fault).collect()
    }

    fn row(&self, condition: usize, at: &Estimate) -> Row {
        let mut row = Row::default();
        self.conditions
            .linearise(condition, &at.parameters, at.chain.as_ref(), &mut row);
        row
    }

    /// Central difference by a column; `None` for a visible quantity that the condition does not see.
    fn difference(&self, condition: usize, column: usize, row: &Row) -> Option<f64> {
        let columns = self.at.parameters.columns();
        let (plus, minus) = match column.checked_sub(columns) {
            None => (
                self.parameter(column, self.step),
                self.parameter(column, -self.step),
            ),
            Some(visible) => (
                self.visible(visible, self.step, row)?,
                self.visible(visible, -self.step, row)?,
            ),
        };
        let misclosure = |at: &Estimate| self.row(condition, at).misclosure;
        Some((misclosure(&plus) - misclosure(&minus)) / (2.0 * self.step))
    }

    fn parameter(&self, column: usize, step: f64) -> Estimate {
        let mut steps = vec![0.0; self.at.parameters.columns()];
        steps[column] = step;
        Estimate {
            parameters: self.at.parameters.retracted(&steps),
            chain: self.at.chain.clone(),
        }
    }

    /// Moves a visible quantity at both epochs of the interval through its first process.
    fn visible(&self, visible: usize, step: f64, row: &Row) -> Option<Estimate> {
        let (model, state, chain) = (self.model?, self.at.chain.as_ref()?, row.chain.as_ref()?);
        let process = model
            .processes()
            .iter()
            .position(|process| process.component == visible)?;
        let mut steps = vec![0.0; model.epochs() * model.state_size()];
        for epoch in [chain.interval as usize, chain.interval as usize + 1] {
            steps[epoch * model.state_size() + process] = step / (chain.weight0 + chain.weight1);
        }
        let moved: ChainState = state.moved(model, &steps);
        Some(Estimate {
            parameters: self.at.parameters.clone(),
            chain: Some(moved),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::toys::Toy;
    use super::super::*;

    struct Wrong<'a>(&'a Toy);

    impl Conditions for Wrong<'_> {
        fn len(&self) -> usize {
            self.0.len()
        }

        fn linearise(&self, k: usize, x: &ParameterSet, chain: Option<&ChainState>, row: &mut Row) {
            self.0.linearise(k, x, chain, row);
            row.push(2, 0.5);
            if let Some(chain) = &mut row.chain {
                chain.visible[4] *= -1.0;
            }
        }
    }

    #[test]
    fn right_derivatives_pass_and_wrong_ones_are_named() {
        let toy = Toy::new(3, 5, 3);
        let at = Estimate {
            parameters: toy.parameters(),
            chain: Some(ChainState::zero(&toy.model)),
        };
        let which = [0, 5, 11];
        let check = |conditions: &dyn Conditions| {
            check_derivatives(conditions, &which, &at, Some(&toy.model), 1e-3, 1e-9)
        };
        assert!(check(&toy).is_empty());
        let faults: Vec<_> = check(&Wrong(&toy))
            .iter()
            .map(|fault| (fault.condition, fault.column))
            .collect();
        assert_eq!(
            faults,
            which
                .iter()
                .flat_map(|k| [(*k, 2), (*k, 8)])
                .collect::<Vec<_>>()
        );
    }
}
