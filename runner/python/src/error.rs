//! Errors of the twin library as exceptions of `ballrace`.

use ballrace_twin::error::{Error, with_causes};
use ballrace_twin::recording::error::RecordingError;
use ballrace_twin::scene::read::SceneError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Fields of an exception: name and value.
type Fields<'py> = Bound<'py, PyDict>;

/// Returns the Python exception of an error.
pub fn exception(py: Python<'_>, error: impl Into<Error>) -> PyErr {
    let error = error.into();
    let message = with_causes(&error);
    raised(py, &error, &message).unwrap_or_else(|_| PyRuntimeError::new_err(message))
}

fn raised(py: Python<'_>, error: &Error, message: &str) -> PyResult<PyErr> {
    let fields = PyDict::new(py);
    let name = match cause(error) {
        Error::Scene(error) => {
            of_scene(&fields, error)?;
            "SceneError"
        }
        Error::Recording(error) => {
            of_recording(&fields, error)?;
            "RecordingError"
        }
        _ if error.is_usage_error() => "InputError",
        _ => "Error",
    };
    named(py, name, message, &fields)
}

/// Returns an exception of the package by its name.
fn named(py: Python<'_>, name: &str, message: &str, fields: &Fields<'_>) -> PyResult<PyErr> {
    let class = py.import("ballrace._errors")?.getattr(name)?;
    Ok(PyErr::from_value(class.call((message,), Some(fields))?))
}

/// Returns the exception of a wrong argument.
pub fn wrong_argument(py: Python<'_>, message: &str) -> PyErr {
    named(py, "InputError", message, &PyDict::new(py)).unwrap_or_else(|error| error)
}

/// Returns the innermost error, below those that add the set-up, a file or a point.
fn cause(error: &Error) -> &Error {
    match error {
        Error::Setup(inner) | Error::File { source: inner, .. } | Error::Point { source: inner, .. } => cause(inner),
        other => other,
    }
}

fn of_scene(fields: &Fields<'_>, error: &SceneError) -> PyResult<()> {
    let SceneError { file, line, key, found, expected, .. } = error;
    fields.set_item("file", file)?;
    fields.set_item("line", line)?;
    fields.set_item("key", (!key.is_empty()).then_some(key))?;
    fields.set_item("found", (!found.is_empty()).then_some(found))?;
    fields.set_item("expected", (!expected.is_empty()).then_some(expected))
}

fn of_recording(fields: &Fields<'_>, error: &RecordingError) -> PyResult<()> {
    use RecordingError as E;
    let set = |key: &str, value: Option<String>| value.map_or(Ok(()), |value| fields.set_item(key, value));
    let (file, line, column, found, expected) = match error {
        E::Open { file, cause } => (file, None, None, Some(cause.to_string()), None),
        E::Folder { file, .. } => (file, None, None, None, Some("files of a recording".to_owned())),
        E::NoFile { file } => (file, None, None, Some("a folder".to_owned()), Some("one of its files".to_owned())),
        E::NoSequence { file, count, .. } => {
            (file, None, None, Some(format!("{count} files")), Some("sequence".to_owned()))
        }
        E::Differs { file, found, expected, .. } => {
            (file, None, None, Some(found.to_string()), Some(expected.to_string()))
        }
        E::Order { file, found, end, .. } => {
            (file, None, None, Some(format!("{found} s")), Some(format!("a time after {end} s")))
        }
        E::Format { file, found, expected } => (file, None, None, Some(found.clone()), Some((*expected).to_owned())),
        E::Unit { file, column, found, expected } => {
            (file, None, Some(column.clone()), Some(found.clone()), Some(expected.clone()))
        }
        E::Rate { file, found, expected } => {
            (file, None, None, Some(format!("{found} Hz")), Some(format!("{expected} Hz")))
        }
        E::Read { file, line, cause } => (file, Some(*line), None, Some(cause.to_string()), None),
        E::Empty { file } | E::NoRows { file } => (file, None, None, None, Some("a row for each sample".to_owned())),
        E::LongLine { file, line } => (file, Some(*line), None, None, Some("a line of at most 4 MiB".to_owned())),
        E::TimeUnit { file, column, found, unit } => {
            (file, None, Some(column.clone()), Some(found.clone()), Some(format!("unit = \"{unit}\"")))
        }
        E::SummerTime { file, line } => {
            (file, Some(*line), None, None, Some("time stamps in UTC or with a zone".to_owned()))
        }
        E::NotText { file, line } => (file, Some(*line), None, None, Some("text in UTF-8".to_owned())),
        E::NoHeader { file, line, found } => (file, Some(*line), None, Some(found.clone()), None),
        E::AbsentColumn { file, line, column, found, .. } => {
            (file, *line, None, Some(found.clone()), Some(column.clone()))
        }
        E::ColumnTwice { file, line, column } => (file, *line, Some(column.clone()), None, None),
        E::Cell { file, line, column, found, expected } => {
            (file, Some(*line), Some(column.clone()), Some(found.clone()), Some((*expected).to_owned()))
        }
        E::RowTooLong { file, line, found, expected, .. } => {
            (file, Some(*line), None, Some(found.to_string()), Some(expected.to_string()))
        }
        E::Misplaced { file, key, expected } => {
            (file, None, None, Some((*key).to_owned()), Some((*expected).to_owned()))
        }
        E::AbsentNumber { file, number, found } => (file, None, None, Some(found.clone()), Some(number.clone())),
        E::StatedRate { file, found, expected } => {
            (file, None, None, Some(found.clone()), Some((*expected).to_owned()))
        }
        E::NotSynchronous { file } => (file, None, None, None, Some("samples in step with the shaft".to_owned())),
        E::Clock { file, column, found } | E::Instants { file, column, found } => {
            (file, None, Some(column.clone()), Some(found.clone()), None)
        }
    };
    fields.set_item("file", file)?;
    line.map_or(Ok(()), |line| fields.set_item("line", line))?;
    set("column", column)?;
    set("found", found)?;
    set("expected", expected)
}
