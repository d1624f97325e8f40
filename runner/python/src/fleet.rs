//! Fleets. Machines and rows are passed as JSON, so that processes can exchange them.

use crate::error::{exception, wrong_argument};
use ballrace_report::fleet::{Folder, page_of};
use ballrace_twin::error::{Error, FleetError, TablePosition};
use ballrace_twin::fleet::{self, Cells, Key, Machine, Row, Store};
use ballrace_twin::folder_lock::FolderLock;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

fn parsed<T: DeserializeOwned>(py: Python<'_>, json: &str) -> PyResult<T> {
    serde_json::from_str(json).map_err(|e| wrong_argument(py, &e.to_string()))
}

fn json<T: Serialize>(py: Python<'_>, value: &T) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| wrong_argument(py, &e.to_string()))
}

fn all_json<T: Serialize>(py: Python<'_>, values: &[T]) -> PyResult<Vec<String>> {
    values.iter().map(|value| json(py, value)).collect()
}

/// Reads a table of machines; returns each machine as JSON.
#[pyfunction]
pub fn read_machines(py: Python<'_>, path: PathBuf) -> PyResult<Vec<String>> {
    let machines = py.detach(|| fleet::read_table(&path)).map_err(|e| exception(py, e))?;
    all_json(py, &machines)
}

/// Checks a table of machines in memory; relative paths start from the folder of `file`.
#[pyfunction]
pub fn machines(py: Python<'_>, file: PathBuf, columns: Vec<String>, rows: Vec<Vec<String>>) -> PyResult<Vec<String>> {
    let rows = rows.into_iter().zip(1..).map(|(cells, row)| Cells { position: TablePosition::Row(row), cells });
    let machines = fleet::machines(&file, TablePosition::Columns, &columns, rows).map_err(|e| exception(py, e))?;
    all_json(py, &machines)
}

/// Evaluates a machine; returns its row as JSON and, with `with_report`, its report.
#[pyfunction]
#[pyo3(signature = (machine, with_report, force_error=None))]
pub fn evaluate(
    py: Python<'_>,
    machine: &str,
    with_report: bool,
    force_error: Option<f64>,
) -> PyResult<(String, Option<String>)> {
    let machine: Machine = parsed(py, machine)?;
    let (row, page) = py.detach(|| {
        let mut evaluation = fleet::evaluate_with(&machine, force_error);
        let page = if with_report { page_of(&mut evaluation) } else { None };
        (evaluation.row, page)
    });
    Ok((json(py, &row)?, page))
}

/// Returns the row of a machine that could not be evaluated.
#[pyfunction]
pub fn failed(py: Python<'_>, machine: &str, error: String) -> PyResult<String> {
    let machine: Machine = parsed(py, machine)?;
    json(py, &fleet::failed(&machine, error))
}

/// Returns the trends of rows as JSON.
#[pyfunction]
pub fn trends(py: Python<'_>, rows: Vec<String>) -> PyResult<String> {
    let rows = rows.iter().map(|row| parsed(py, row)).collect::<PyResult<Vec<Row>>>()?;
    json(py, &fleet::trends(&rows))
}

/// Returns rows as a Parquet file.
#[pyfunction]
pub fn rows_as_parquet<'py>(py: Python<'py>, rows: Vec<String>) -> PyResult<Bound<'py, PyBytes>> {
    let rows = rows.iter().map(|row| parsed(py, row)).collect::<PyResult<Vec<Row>>>()?;
    let mut bytes = Vec::new();
    py.detach(|| fleet::parquet(&mut bytes, &rows)).map_err(|e| exception(py, e))?;
    Ok(PyBytes::new(py, &bytes))
}

/// The results of a fleet in a folder.
#[pyclass(frozen, module = "ballrace._native")]
pub struct Fleet {
    name: String,
    machines: Vec<Machine>,
    folder: Folder,
    store: Mutex<Store>,
    /// `None` after [`Fleet::close`].
    lock: Mutex<Option<FolderLock>>,
}

impl Fleet {
    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn order(&self) -> Vec<Key> {
        self.machines.iter().map(Machine::key).collect()
    }
}

#[pymethods]
impl Fleet {
    /// Opens the folder of the results; rows of an earlier run are kept.
    #[new]
    fn new(py: Python<'_>, name: String, machines: Vec<String>, output: PathBuf) -> PyResult<Self> {
        let machines = machines.iter().map(|machine| parsed(py, machine)).collect::<PyResult<Vec<Machine>>>()?;
        let open = || {
            let lock = fleet::lock(&output)?;
            let folder = Folder::create(&output, &machines)?;
            let store = Store::open(&folder.outcomes())?;
            Ok::<_, FleetError>((folder, Mutex::new(store), Mutex::new(Some(lock))))
        };
        let (folder, store, lock) = py.detach(open).map_err(|e| exception(py, e))?;
        Ok(Self { name, machines, folder, store, lock })
    }

    /// Returns the indices of the machines that are not evaluated yet, or whose files have changed.
    fn missing(&self, py: Python<'_>, with_report: bool) -> Vec<usize> {
        py.detach(|| {
            let store = self.store();
            let is_done = |machine: &Machine| {
                store.get(&machine.key()).is_some_and(|row| self.folder.is_done(machine, row, with_report))
            };
            (0..self.machines.len()).filter(|&i| self.machines.get(i).is_some_and(|one| !is_done(one))).collect()
        })
    }

    /// Adds a row and its report.
    fn add(&self, py: Python<'_>, row: &str, page: Option<&str>) -> PyResult<()> {
        let row: Row = parsed(py, row)?;
        let add = || {
            self.folder.write_page(&row.key(), page)?;
            self.store().add(row)
        };
        py.detach(add).map_err(|e| exception(py, e))
    }

    /// Writes all pending rows and unlocks the folder.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let flush = || {
            let flushed = self.store().flush();
            *self.lock.lock().unwrap_or_else(PoisonError::into_inner) = None;
            flushed
        };
        py.detach(flush).map_err(|e| exception(py, e))
    }

    /// Writes all rows as one part, and the overview.
    fn finish(&self, py: Python<'_>) -> PyResult<()> {
        let rows = self.present();
        let finish = || {
            self.store().compact(&self.order()).map_err(|e| Error::from(e).to_string())?;
            self.folder.write_overview(&self.name, &rows, &fleet::trends(&rows)).map_err(|e| format!("{e:#}"))
        };
        py.detach(finish).map_err(|message| wrong_argument(py, &message))
    }

    /// Returns the rows in the order of the machines.
    fn rows(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        all_json(py, &self.present())
    }

    /// Path of the overview.
    #[getter]
    fn index(&self) -> PathBuf {
        self.folder.index()
    }
}

impl Fleet {
    fn present(&self) -> Vec<Row> {
        let store = self.store();
        self.order().iter().filter_map(|key| store.get(key).cloned()).collect()
    }
}
