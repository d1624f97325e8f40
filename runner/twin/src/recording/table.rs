//! The table of a recording in any format: named columns and rows of numbers.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::error::RecordingError;
use super::{mat, npy, parquet, tdms, wav};

/// Values expected in a used cell.
pub(super) const EXPECTED: &str = "a number, or NaN or nothing where the reading is missing";

/// Columns of a file and its rows, one after another.
pub(super) trait Table: Send {
    /// Names of all columns.
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

/// The cells of one row that are used.
#[derive(Default)]
pub(super) struct Cells {
    /// Line of the file; in a file without lines the number of the row, from 1.
    pub(super) line: u64,
    /// Values of the columns selected; NaN where one is missing.
    pub(super) values: Vec<f64>,
    /// Number of cells in the row of the file, from its first column.
    pub(super) whole: usize,
}

/// Opens a file of one format.
pub(super) type Open = fn(File, &Path) -> Result<Box<dyn Table>, RecordingError>;

/// Identification of a binary format.
struct Format {
    ending: &'static str,
    begins: &'static [u8],
    /// Bytes at a certain offset. A header of CSV may begin with `PAR1`, but has no control characters.
    goes_on: (usize, &'static [u8]),
    open: Open,
}

const FORMATS: [Format; 6] = [
    Format { ending: "mat", begins: b"MATLAB 5.0 MAT-file", goes_on: (0, b""), open: mat::open },
    Format { ending: "mat", begins: b"MATLAB 7.3 MAT-file", goes_on: (0, b""), open: mat::open },
    Format { ending: "npy", begins: b"\x93NUMPY", goes_on: (0, b""), open: npy::open },
    Format { ending: "wav", begins: b"RIFF", goes_on: (8, b"WAVE"), open: wav::open },
    Format { ending: "parquet", begins: b"PAR1", goes_on: (4, b"\x15"), open: parquet::open },
    Format { ending: "tdms", begins: b"TDSm", goes_on: (5, b"\0\0\0"), open: tdms::open },
];

/// Detects the binary format of a file from its content, then from its extension; rewinds the file.
pub(super) fn binary(file: &mut File, path: &Path) -> io::Result<Option<Open>> {
    let mut begin = Vec::new();
    file.by_ref().take(32).read_to_end(&mut begin)?;
    file.seek(SeekFrom::Start(0))?;
    let has = |at: usize, bytes: &[u8]| begin.get(at..).unwrap_or_default().starts_with(bytes);
    let by_content = FORMATS.iter().find(|format| has(0, format.begins) && has(format.goes_on.0, format.goes_on.1));
    let ending = path.extension().unwrap_or_default();
    let by_name = || FORMATS.iter().find(|format| ending.eq_ignore_ascii_case(format.ending));
    Ok(by_content.or_else(by_name).map(|format| format.open))
}

/// Checks that the columns which the scene names have as many values as each other, and some.
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
        expected: "columns of equal length with at least one value",
    })
}
