//! Quantities as arguments.

use crate::error::wrong_argument;
use ballrace_twin::scene::units::{Dimension, parse};
use pyo3::prelude::*;

/// A quantity: a number in SI, or text with a unit.
#[derive(FromPyObject)]
pub enum Quantity {
    Number(f64),
    Text(String),
}

impl Quantity {
    pub fn si(&self, py: Python<'_>, name: &str, dimension: Dimension) -> PyResult<f64> {
        let value = match self {
            Self::Number(si) => *si,
            Self::Text(text) => parse(text, dimension).map_err(|e| wrong_argument(py, &format!("{name}: {e}")))?,
        };
        if value.is_finite() {
            return Ok(value);
        }
        Err(wrong_argument(py, &format!("{name}: not finite, expected {}", dimension.expected("in SI or with a unit"))))
    }
}
