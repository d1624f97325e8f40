//! Recordings from Python: a path, or columns in memory.

use crate::array::{checked, read};
use crate::error::exception;
use ballrace_twin::error::ReplayError;
use ballrace_twin::recording::Reader;
use ballrace_twin::replay;
use ballrace_twin::scene::Scene;
use numpy::PyReadonlyArray1;
use numpy::ndarray::Ix1;
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// Name of a recording in memory.
const IN_MEMORY: &str = "in memory";

/// A recording from Python.
pub enum Source<'py> {
    /// A file; `None` for the scene's own.
    File(Option<PathBuf>),
    /// Columns. Only those that the scene names have values.
    Columns(Vec<(String, PyReadonlyArray1<'py, f64>)>),
}

impl<'py> Source<'py> {
    /// Converts a path, `None`, or pairs of name and array.
    ///
    /// # Errors
    /// `InputError` for other objects.
    pub fn new(given: &Bound<'py, PyAny>) -> PyResult<Self> {
        if given.is_none() {
            return Ok(Self::File(None));
        }
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self::File(Some(path)));
        }
        let mut columns = Vec::new();
        for pair in given.try_iter()? {
            let (name, values): (String, Bound<'py, PyAny>) = pair?.extract()?;
            let array = checked::<f64, Ix1>(&format!("column {name}"), &values, "of shape (samples,)")?;
            columns.push((name.clone(), read(&name, &array)?));
        }
        Ok(Self::Columns(columns))
    }

    /// Returns the input of the reader, which can be opened with the interpreter detached.
    ///
    /// # Errors
    /// `InputError` for a scene without a recording.
    pub fn opening(&self, py: Python<'_>, scene: &Scene) -> PyResult<Opening<'_>> {
        if scene.recording.is_none() {
            return Err(exception(py, ReplayError::NoRecording { file: scene.path.clone() }));
        }
        Ok(match self {
            Self::File(path) => Opening::File(path.clone()),
            Self::Columns(columns) => {
                let slices = columns.iter().map(|(name, values)| Ok((name.clone(), values.as_slice()?)));
                Opening::Columns(slices.collect::<PyResult<_>>()?)
            }
        })
    }
}

/// A file, or borrowed columns.
pub enum Opening<'a> {
    /// A file, or the scene's own without a path.
    File(Option<PathBuf>),
    /// Columns.
    Columns(Vec<(String, &'a [f64])>),
}

impl<'a> Opening<'a> {
    /// Opens the reader; returns it with the name of the recording.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn reader(self, scene: &Scene) -> ballrace_twin::error::Result<(Reader<'a>, String)> {
        let Some(recording) = &scene.recording else {
            return Err(ReplayError::NoRecording { file: scene.path.clone() }.into());
        };
        Ok(match self {
            Self::File(path) => {
                let (reader, path) = replay::open(scene, path.as_deref())?;
                (reader, path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()))
            }
            Self::Columns(columns) => {
                (Reader::from_columns(columns, Path::new(IN_MEMORY), recording)?, IN_MEMORY.to_owned())
            }
        })
    }
}
