//! A calibration's result.

use std::path::PathBuf;

use boresight::Finished as Found;
use boresight::report::{self, Export, html, json, text};
use boresight::results::Page;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use super::errors::{Failure, input};

/// A result and what its report shows beside it.
#[pyclass(frozen, module = "boresight._core")]
pub struct Finished(pub Found);

#[pymethods]
impl Finished {
    /// From the bytes of `result.json`; its report then has no pictures of the observations.
    #[staticmethod]
    fn from_json(py: Python<'_>, bytes: &[u8]) -> PyResult<Self> {
        match json::from_slice(bytes) {
            Ok(result) => {
                let name = result.provenance.configuration.get("name");
                let title = name.and_then(|name| name.as_str()).unwrap_or_default();
                let page = Page {
                    title: title.to_owned(),
                    ..Page::default()
                };
                Ok(Self(Found { result, page }))
            }
            Err(error) => Err(input(py, error.to_string(), vec![])),
        }
    }

    /// The bytes of `result.json`.
    fn to_json<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = json::to_bytes(&self.0.result).map_err(|e| Failure::from(e).raise(py))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// The page of `report.html`.
    fn html(&self, py: Python<'_>) -> PyResult<String> {
        let page = py.detach(|| html::render(&self.0.result, &self.0.page));
        page.map_err(|e| Failure::from(e).raise(py))
    }

    /// What the command prints.
    fn text(&self) -> String {
        text::summary(&self.0.result, &self.0.page)
    }

    /// Writes `result.json`, `report.html`, `parameters.csv` and other forms of the values to enter into a folder.
    fn write(&self, py: Python<'_>, folder: PathBuf, exports: Vec<String>) -> PyResult<()> {
        let forms: Result<Vec<Export>, String> = exports.iter().map(|name| form(name)).collect();
        let forms = forms.map_err(|message| input(py, message, vec![]))?;
        let Found { result, page } = &self.0;
        let written = py.detach(|| report::write_all(&folder, result, page, &forms));
        written.map(drop).map_err(|e| Failure::from(e).raise(py))
    }
}

/// A form by the name of its file or of the command's option.
fn form(name: &str) -> Result<Export, String> {
    let known = [
        ("latex", Export::Latex),
        ("csv", Export::Csv),
        ("hvf-card", Export::Hvf),
        ("qimera", Export::Qimera),
        ("sis", Export::Sis),
        ("applanix", Export::Applanix),
        ("novatel", Export::Novatel),
    ];
    let found = known.iter().find(|(known, _)| *known == name);
    found.map(|(_, form)| *form).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|(name, _)| *name).collect();
        format!(
            "exports: found \"{name}\", expected any of {}",
            names.join(", ")
        )
    })
}
