//! Results as text.

use crate::error::wrong_argument;
use pyo3::prelude::*;

/// Returns a result as JSON.
///
/// # Errors
/// A result that is no JSON.
pub fn json_of(py: Python<'_>, value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| wrong_argument(py, &e.to_string()))
}

/// Returns the text of a report.
///
/// # Errors
/// `InputError` for a report that cannot be written.
pub fn page(py: Python<'_>, html: Result<String, impl std::fmt::Display>) -> PyResult<String> {
    html.map_err(|e| wrong_argument(py, &format!("{e:#}")))
}
