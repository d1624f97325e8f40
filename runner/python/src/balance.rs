//! Balancing from a table of vectors, and the options that it shares with that of recordings.

use crate::error::wrong_argument;
use crate::quantity::Quantity;
use crate::text::{json_of, page};
use ballrace_report as report;
use ballrace_twin::balance::table::VectorTable;
use ballrace_twin::balance::{
    Balance, HoleOptions, MOST_WEIGHTS, OptionError, Placement, Requirement, TolerancePlane, balance as of_vectors,
};
use ballrace_twin::scene::units::Dimension;
use pyo3::prelude::*;
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Options of a correction: holes, weights and quality.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct BalanceOptions {
    holes: Vec<String>,
    radius: Vec<String>,
    stock: Vec<String>,
    weights: usize,
    hole_limit: Vec<String>,
    taken: Vec<String>,
    remove: bool,
    replace: bool,
    grade: Option<f64>,
    mass: Option<Quantity>,
    service_speed: Option<Quantity>,
}

/// Returns a quantity above 0 in SI.
fn positive(py: Python<'_>, name: &str, of: &Quantity, dimension: Dimension) -> PyResult<f64> {
    let value = of.si(py, name, dimension)?;
    if value > 0.0 {
        return Ok(value);
    }
    Err(wrong_argument(py, &format!("{name}: out of range: {value}, expected {}", dimension.expected("above 0"))))
}

/// Returns the argument of an option.
fn argument(option: &'static str) -> &'static str {
    if option == "hole-limit" { "hole_limit" } else { option }
}

impl BalanceOptions {
    /// Returns how masses are placed in these planes.
    pub fn placement(&self, py: Python<'_>, planes: &[String]) -> PyResult<Placement> {
        let wrong = |message: String| wrong_argument(py, &message);
        if !(1..=MOST_WEIGHTS).contains(&self.weights) {
            return Err(wrong(format!("weights: {}, expected 1 to {MOST_WEIGHTS}", self.weights)));
        }
        let options = HoleOptions {
            holes: self.holes.clone(),
            radius: self.radius.clone(),
            hole_limit: self.hole_limit.clone(),
            stock: self.stock.clone(),
            taken: self.taken.clone(),
            weights: self.weights,
        };
        let of_argument =
            |error: OptionError| wrong(OptionError { option: argument(error.option), ..error }.to_string());
        let holes = options.read(planes).map_err(of_argument)?;
        if self.remove && !self.stock.is_empty() {
            return Err(wrong("remove: masses of a stock, expected one of remove and stock".to_owned()));
        }
        Ok(Placement { holes, removes: self.remove, replaces: self.replace })
    }

    /// Returns the balance quality that is asked for; `mass` is that of the rotor of a scene, kg, `highest` the highest speed of the runs, rpm.
    pub fn requirement(
        &self,
        py: Python<'_>,
        mass: Option<f64>,
        highest: f64,
        planes: Vec<TolerancePlane>,
    ) -> PyResult<Option<Requirement>> {
        let wrong = |message: String| wrong_argument(py, &message);
        let Some(grade) = self.grade else { return Ok(None) };
        if !(grade > 0.0 && grade.is_finite()) {
            return Err(wrong(format!("grade: out of range: {grade}, expected a grade above 0, such as 2.5")));
        }
        let given = self.mass.as_ref().map(|mass| positive(py, "mass", mass, Dimension::Mass)).transpose()?;
        let mass =
            given.or(mass).ok_or_else(|| wrong("mass: none, expected that of the rotor for grade".to_owned()))?;
        let speed = self.service_speed.as_ref().map(|speed| positive(py, "service_speed", speed, Dimension::Speed));
        let speed_rpm = speed.transpose()?.map_or(highest, |speed| speed * 60.0 / TAU);
        Ok(Some(Requirement { grade, mass, speed_rpm, planes }))
    }

    /// Returns a balance as JSON and HTML.
    pub fn written(&self, py: Python<'_>, name: &str, of: &Balance) -> PyResult<(String, String)> {
        Ok((json_of(py, of)?, page(py, report::balance::html(name, of))?))
    }
}

/// Returns the highest speed of a table, rpm.
pub fn highest_speed(table: &VectorTable) -> f64 {
    table.speeds().1.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// Balances from a table of vectors, a file or the text of one; returns JSON and HTML.
#[pyfunction]
#[pyo3(signature = (path, text, times, options))]
pub fn balance(
    py: Python<'_>,
    path: PathBuf,
    text: Option<String>,
    times: Option<PathBuf>,
    options: BalanceOptions,
) -> PyResult<(String, String)> {
    let table = match &text {
        Some(text) => VectorTable::parse(text.as_bytes(), &path, times.as_deref()),
        None => VectorTable::read(&path, times.as_deref()).map(|(table, _)| table),
    };
    let table = table.map_err(|e| wrong_argument(py, &e.to_string()))?;
    let placement = options.placement(py, &table.planes)?;
    let planes = TolerancePlane::of_correction(&table.planes);
    let required = options.requirement(py, None, highest_speed(&table), planes)?;
    let found = py.detach(|| of_vectors(&table, None, &placement));
    let mut found = found.map_err(|e| wrong_argument(py, &format!("{}: {e}", path.display())))?;
    found.quality = required.map(|required| required.quality(&found.correction));
    options.written(py, &path.display().to_string(), &found)
}
