//! The table of a recording in any format: named columns and rows of numbers.

use super::error::RecordingError;
use std::path::Path;

/// Values expected in a used cell.
pub(super) const EXPECTED: &str = "a number, or NaN or nothing where the reading is missing";

/// Largest number of values of a vector with a length of its own.
pub(super) const LONGEST_VECTOR: u64 = 1 << 26;

/// Columns of a file and its rows, one after another.
pub(super) trait Table: Send {
    /// Returns the names of all columns.
    fn columns(&self) -> &[String];

    /// Returns true where this column has the scene's name.
    fn is_called(&self, place: usize, name: &str) -> bool {
        self.columns().get(place).is_some_and(|own| own == name)
    }

    /// Unit of a column in the file, as written there.
    fn unit(&self, _place: usize) -> Option<&str> {
        None
    }

    /// Sampling rate of the selected columns in the file, Hz.
    fn rate(&self) -> Option<f64> {
        None
    }

    /// Name of a selected column whose rate the file does not state, where it states that of another.
    fn unrated(&self) -> Option<&str> {
        None
    }

    /// Reads all values of a column, of which the file may have another number than of rows; none where its columns have equal lengths.
    fn vector(&mut self, _place: usize) -> Result<Option<Vec<f64>>, RecordingError> {
        Ok(None)
    }

    /// Reads a single number of the file by its name.
    fn scalar(&mut self, _name: &str) -> Result<Option<f64>, RecordingError> {
        Ok(None)
    }

    /// Names of all single numbers.
    fn scalar_names(&self) -> Vec<String> {
        Vec::new()
    }

    /// Samples per revolution of the shaft, where the file was sampled in step with it from angle 0.
    fn samples_per_revolution(&self) -> Option<f64> {
        None
    }

    /// Assumptions about the file, for the report.
    fn notes(&self) -> Vec<String> {
        Vec::new()
    }

    /// Sets the column of time stamps; called before [`select`](Self::select).
    fn set_time(&mut self, _place: usize) {}

    /// Date of the first row, from which the time stamps count; none where they are seconds.
    fn time_origin(&self) -> Option<TimeOrigin> {
        None
    }

    /// Error for data that the file has by this name but that cannot be a column.
    fn refusal(&self, _name: &str) -> Option<RecordingError> {
        None
    }

    /// Line with the names of the columns, where the file has lines.
    fn header_line(&self) -> Option<u64> {
        None
    }

    /// Selects the columns whose values [`next`](Self::next) returns, in order; called once.
    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError>;

    /// Reads the next row; false at the end.
    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError>;

    /// Bytes of the file that are read.
    fn bytes_read(&self) -> u64;
}

/// Date and time from which time stamps count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TimeOrigin {
    /// From 1970-01-01, in UTC where there is a zone.
    pub(super) nanoseconds: i128,
    /// True where the file states the zone.
    pub(super) has_zone: bool,
    /// False for a time of day, which counts from midnight.
    pub(super) has_date: bool,
}

/// What a format that counts its samples lacks before a row.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Omitted {
    /// Number of samples that are missing.
    pub(super) missing: u64,
    /// Number of damaged places.
    pub(super) damaged: u64,
}

/// The cells of one row that are used.
#[derive(Default)]
pub(super) struct Cells {
    /// Line of the file; in a file without lines the number of the row, from 1.
    pub(super) line: u64,
    /// Values of the columns selected; NaN where one is missing.
    pub(super) values: Vec<f64>,
    /// Number of cells in the row of the file, from its first column.
    pub(super) whole: usize,
    /// Omitted before the row, or before the end of the file.
    pub(super) omitted: Omitted,
}

impl Cells {
    /// Takes the row after the first `row` ones of columns of equal length; returns false after their end. `whole` is the number of columns
    /// of the file.
    pub(super) fn take_row(&mut self, columns: &[impl AsRef<[f64]>], row: usize, whole: usize) -> bool {
        self.values.clear();
        self.values.extend(columns.iter().filter_map(|column| column.as_ref().get(row)));
        let is_row = !self.values.is_empty();
        if is_row {
            (self.line, self.whole) = (row as u64 + 1, whole);
        }
        is_row
    }
}

/// Checks that the columns of the scene have the same number of values, at least one; returns that number.
pub(super) fn equal_lengths(file: &Path, columns: &[(&str, u64)]) -> Result<u64, RecordingError> {
    let first = columns.first().map_or(0, |(_, length)| *length);
    if first > 0 && columns.iter().all(|(_, length)| *length == first) {
        return Ok(first);
    }
    let each = columns.iter().map(|(name, length)| format!("{length} in `{name}`"));
    let found = format!("numbers of values {}", each.collect::<Vec<_>>().join(", "));
    Err(RecordingError::Format {
        file: file.into(),
        found,
        expected: "columns of equal length with at least one value; instants of pulses in place of samples need keyphasor.kind = \"instants\"",
    })
}
