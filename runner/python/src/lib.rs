//! The extension module `ballrace._native`: the twin library for the Python package `ballrace`.
//!
//! Displacements and forces of a bearing are passed as NumPy arrays without a copy; results of the studies are passed as JSON, which the
//! Python package converts to objects. Every computation releases the interpreter.

mod array;
mod balance;
mod bearing;
mod error;
mod fleet;
mod interrupt;
mod outcome;
mod quantity;
mod recording;
mod scene;
mod text;

use pyo3::prelude::*;

/// The extension module.
#[pymodule(gil_used = false)]
mod _native {
    #[pymodule_export]
    use super::balance::balance;
    #[pymodule_export]
    use super::bearing::Bearing;
    #[pymodule_export]
    use super::fleet::{Fleet, evaluate, failed, machines, read_machines, rows_as_parquet, trends};
    #[pymodule_export]
    use super::outcome::Outcome;
    #[pymodule_export]
    use super::scene::{Scene, Trade};
    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("VERSION", env!("CARGO_PKG_VERSION"))
    }
}
