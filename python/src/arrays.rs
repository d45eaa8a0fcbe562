//! Columns from and to numpy. They are copied both ways: another thread may write into an array at any time, and what the library
//! reads must stand still.

use boresight::nalgebra::DMatrix;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Columns and figures by name, as the package's checks leave them: contiguous, of the right type.
pub struct Given<'a, 'py>(pub &'a Bound<'py, PyDict>);

impl<'py> Given<'_, 'py> {
    fn item(&self, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let found = self.0.get_item(name)?;
        found.ok_or_else(|| PyKeyError::new_err(name.to_owned()))
    }

    /// A column of floats.
    pub fn column(&self, name: &str) -> PyResult<Vec<f64>> {
        let array: PyReadonlyArray1<'_, f64> = self.item(name)?.extract()?;
        Ok(array.as_slice()?.to_vec())
    }

    /// A column of numbers.
    pub fn numbers(&self, name: &str) -> PyResult<Vec<u32>> {
        let array: PyReadonlyArray1<'_, u32> = self.item(name)?.extract()?;
        Ok(array.as_slice()?.to_vec())
    }

    /// Rows of three, where there are any.
    pub fn triples(&self, name: &str) -> PyResult<Option<Vec<[f64; 3]>>> {
        let item = self.item(name)?;
        if item.is_none() {
            return Ok(None);
        }
        let array: PyReadonlyArray2<'_, f64> = item.extract()?;
        let rows = array.as_slice()?.chunks_exact(3);
        Ok(Some(rows.map(|r| [r[0], r[1], r[2]]).collect()))
    }

    /// A few figures.
    pub fn figures<const N: usize>(&self, name: &str) -> PyResult<[f64; N]> {
        self.item(name)?.extract()
    }

    /// A text.
    pub fn text(&self, name: &str) -> PyResult<String> {
        self.item(name)?.extract()
    }
}

/// A square matrix.
pub fn square<'py>(py: Python<'py>, of: &DMatrix<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let by_rows = of.transpose().as_slice().to_vec();
    PyArray1::from_vec(py, by_rows).reshape([of.nrows(), of.ncols()])
}

/// Rows of three as an array of shape (n, 3).
pub fn rows<'py>(py: Python<'py>, flat: Vec<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = flat.len() / 3;
    PyArray1::from_vec(py, flat).reshape([count, 3])
}
