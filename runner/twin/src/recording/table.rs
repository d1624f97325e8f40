//! The table of a recording in any format: named columns and rows of numbers.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use super::compressed::{self, Compression};
use super::error::RecordingError;
use super::{csv, hdf5, mat, npy, npz, parquet, tdms, uff, wav};
use crate::scene::FileLayout;

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

    /// Announces the column of time stamps, before [`select`](Self::select).
    fn set_time(&mut self, _place: usize) {}

    /// Date of the first row, from which the time stamps count; none where they are seconds.
    fn time_origin(&self) -> Option<TimeOrigin> {
        None
    }

    /// File of the last row, where there are several.
    fn file(&self) -> Option<&Path> {
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
type Open = fn(File, &Path, FileLayout) -> Result<Box<dyn Table>, RecordingError>;

/// Identification of a binary format.
struct Format {
    ending: &'static str,
    begins: &'static [u8],
    /// Bytes at a certain offset. A header of CSV may begin with `PAR1`, but has no control characters.
    goes_on: (usize, &'static [u8]),
    open: Open,
}

/// Returns the format of files with these first bytes.
const fn format(ending: &'static str, begins: &'static [u8], open: Open) -> Format {
    Format { ending, begins, goes_on: (0, b""), open }
}

const FORMATS: [Format; 12] = [
    format("mat", b"MATLAB 5.0 MAT-file", |file, path, _| mat::open(file, path)),
    format("mat", b"MATLAB 7.3 MAT-file", |file, path, _| hdf5::open(file, path)),
    format("h5", hdf5::SIGNATURE, |file, path, _| hdf5::open(file, path)),
    format("hdf5", hdf5::SIGNATURE, |file, path, _| hdf5::open(file, path)),
    format("npy", b"\x93NUMPY", npy::open),
    format("npz", b"PK\x03\x04", npz::open),
    Format { goes_on: (6, b" "), ..format("uff", uff::SEPARATOR, |file, path, _| uff::open(file, path)) },
    Format { goes_on: (6, b"\r"), ..format("unv", uff::SEPARATOR, |file, path, _| uff::open(file, path)) },
    Format { goes_on: (6, b"\n"), ..format("uff", uff::SEPARATOR, |file, path, _| uff::open(file, path)) },
    Format { goes_on: (8, b"WAVE"), ..format("wav", b"RIFF", |file, path, _| wav::open(file, path)) },
    Format { goes_on: (4, b"\x15"), ..format("parquet", b"PAR1", |file, path, _| parquet::open(file, path)) },
    Format { goes_on: (5, b"\0\0\0"), ..format("tdms", b"TDSm", |file, path, _| tdms::open(file, path)) },
];

/// Returns true for the ending of a binary format.
pub(super) fn is_ending(ending: &str) -> bool {
    FORMATS.iter().any(|format| format.ending == ending)
}

/// Number of bytes that identify a format.
const IDENTIFICATION: u64 = 32;
/// Endings of formats whose arrays have an orientation.
const ORIENTED: [&str; 2] = ["npy", "npz"];

/// Opens a file of any format and returns its size, where that is comparable with the bytes read. The format is detected from
/// the content, then from the extension; compressed files are unpacked.
///
/// # Errors
/// A file that cannot be read as a table; a layout that the format does not have.
pub(super) fn open(
    mut file: File,
    path: &Path,
    layout: FileLayout,
) -> Result<(Box<dyn Table>, Option<u64>), RecordingError> {
    let unopened = |cause| RecordingError::Open { file: path.into(), cause };
    let Some(compression) = Compression::of(&mut file).map_err(unopened)? else {
        let size = file.metadata().map_err(unopened)?.len();
        let begin = first_bytes(&mut file).map_err(unopened)?;
        file.seek(SeekFrom::Start(0)).map_err(unopened)?;
        let table = match identified(&begin, path, layout)? {
            Some(format) => (format.open)(file, path, layout)?,
            None => csv::open(Box::new(file), path, layout)?,
        };
        return Ok((table, Some(size)));
    };
    let mut unpacked = compression.unpack(file, path)?;
    let begin = first_bytes(&mut unpacked).map_err(|cause| compressed::failed(path, cause))?;
    // The name without the ending of the compression.
    let inner = path.with_extension("");
    let format = identified(&begin, &inner, layout)?;
    let whole = Cursor::new(begin).chain(unpacked);
    let table = match format {
        Some(format) => (format.open)(compressed::to_file(whole, path)?, path, layout)?,
        None => csv::open(Box::new(whole), path, layout)?,
    };
    Ok((table, None))
}

fn first_bytes(source: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut begin = Vec::new();
    source.take(IDENTIFICATION).read_to_end(&mut begin)?;
    Ok(begin)
}

/// Returns the binary format of a file with these first bytes or this extension; nothing for text.
fn identified(begin: &[u8], path: &Path, layout: FileLayout) -> Result<Option<&'static Format>, RecordingError> {
    let has = |at: usize, bytes: &[u8]| begin.get(at..).unwrap_or_default().starts_with(bytes);
    let by_content = FORMATS.iter().find(|format| has(0, format.begins) && has(format.goes_on.0, format.goes_on.1));
    let ending = path.extension().unwrap_or_default();
    let by_name = || FORMATS.iter().find(|format| ending.eq_ignore_ascii_case(format.ending));
    let format = by_content.or_else(by_name);
    let misplaced = |key, expected| RecordingError::Misplaced { file: path.into(), key, expected };
    if layout.is_headless && format.is_some() {
        return Err(misplaced("header", "`header = false` only for text"));
    }
    if layout.orientation.is_some() && !format.is_some_and(|format| ORIENTED.contains(&format.ending)) {
        return Err(misplaced("orientation", "`orientation` only for NPY and NPZ files"));
    }
    Ok(format)
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
