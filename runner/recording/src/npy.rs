//! NPY files as recordings: the columns of an array, `c0`, `c1`, ..., or the fields of its structure by their names.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::fs::File;
use std::io::{self, Seek};
use std::path::Path;

use super::error::RecordingError;
use super::numbers::{Kind, Lane, Layout, Number, Numbers, Run};
use super::table::Table;
use ballrace_base::npy_header::{ElementType, Field, NpyHeader, PlainType};
use ballrace_scene::{FileLayout, Orientation};

const EXPECTED: &str = "an NPY file of one row for each sample, of integers or of floats with 32 or 64 bits";

/// Largest number of columns.
const MOST: u64 = 1 << 16;

/// Smallest number of samples of an array whose rows are read as channels, and smallest number of rows that are not.
const MIN_SAMPLES: u64 = 1001;
const MAX_CHANNELS: u64 = 64;

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path, layout: FileLayout) -> Result<Box<dyn Table>, RecordingError> {
    let layout = read(&mut file, layout).map_err(|cause| wrong(path, &cause, EXPECTED))?;
    Ok(Box::new(Numbers::new(file, path, layout)))
}

/// Returns the error of a file that is no array.
pub(super) fn wrong(path: &Path, cause: &io::Error, expected: &'static str) -> RecordingError {
    let found = match cause.kind() {
        io::ErrorKind::UnexpectedEof => "a header that is truncated".into(),
        _ => cause.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
    };
    RecordingError::Format { file: path.into(), found, expected }
}

fn read(file: &mut File, layout: FileLayout) -> io::Result<Layout> {
    let header = NpyHeader::read(file)?;
    let start = file.stream_position()?;
    let array = Array::new(header, start, layout.orientation)?;
    let notes = array.note("The array").into_iter().collect();
    let name = |column: usize| format!("c{column}");
    let mut lanes = array.lanes()?;
    lanes.iter_mut().enumerate().filter(|(_, lane)| lane.name.is_empty()).for_each(|(i, lane)| lane.name = name(i));
    Ok(Layout { notes, ..Layout::of(lanes, EXPECTED) })
}

/// An array with the place of its elements in a file.
pub(super) struct Array {
    element: ElementType,
    start: u64,
    /// Rows and columns as they are stored.
    shape: [u64; 2],
    /// Number of dimensions.
    pub(super) dimensions: usize,
    is_fortran: bool,
    /// Each row is a channel.
    pub(super) is_channels_first: bool,
    /// The orientation follows from the shape.
    is_assumed: bool,
}

impl Array {
    /// Creates the array whose elements begin at `start`.
    pub(super) fn new(header: NpyHeader, start: u64, orientation: Option<Orientation>) -> io::Result<Self> {
        let (shape, dimensions) = match header.shape.as_slice() {
            [] => ([1, 1], 0),
            [rows] => ([*rows, 1], 1),
            [rows, columns] => ([*rows, *columns], 2),
            other => return Err(io::Error::other(format!("an array of {} dimensions", other.len()))),
        };
        let [rows, columns] = shape;
        let is_assumed = dimensions == 2 && orientation.is_none() && rows < MAX_CHANNELS && columns >= MIN_SAMPLES;
        let is_channels_first = dimensions == 2 && (is_assumed || orientation == Some(Orientation::ChannelsFirst));
        let (element, is_fortran) = (header.element, header.is_fortran);
        Ok(Self { element, start, shape, dimensions, is_fortran, is_channels_first, is_assumed })
    }

    /// Returns a note where the orientation is assumed; `name` begins it.
    pub(super) fn note(&self, name: &str) -> Option<String> {
        let [rows, columns] = self.shape;
        self.is_assumed.then(|| {
            format!(
                "{name} of {rows} x {columns} is read as {rows} channels, as it has fewer than {MAX_CHANNELS} rows and more \
                 than {} columns; `orientation` in [recording] states it.",
                MIN_SAMPLES - 1
            )
        })
    }

    /// Returns the only number of an array of one element.
    pub(super) fn scalar(&self) -> Option<Run> {
        let ElementType::Plain(kind) = &self.element else { return None };
        (self.shape == [1, 1]).then(|| number(kind).map(|number| Run::once(number, self.start, 0, 1)))?
    }

    /// Returns the columns: fields with their names, or columns of numbers without.
    pub(super) fn lanes(self) -> io::Result<Vec<Lane>> {
        let Self { start, is_fortran, is_channels_first, shape, .. } = self;
        let [samples, channels] = if is_channels_first { [shape[1], shape[0]] } else { shape };
        match self.element {
            ElementType::Structure(fields) if self.dimensions == 1 => structure(fields, start, samples),
            ElementType::Structure(fields) => {
                Err(io::Error::other(format!("{channels} columns of structures of {} fields", fields.len())))
            }
            ElementType::Plain(kind) if channels > MOST => Err(io::Error::other(format!(
                "{channels} columns of type {}, expected at most {MOST}, or orientation = \"channels-first\" in [recording]",
                kind.text
            ))),
            ElementType::Plain(kind) => {
                let number = number(&kind).ok_or_else(|| io::Error::other(format!("numbers of type {}", kind.text)))?;
                Ok(array(number, start, [samples, channels], is_fortran != is_channels_first))
            }
        }
    }
}

fn number(kind: &PlainType) -> Option<Number> {
    let bytes = u8::try_from(kind.bytes?).ok()?;
    let kind_of = match (kind.kind, bytes) {
        ('f', 2 | 4 | 8) => Kind::Float,
        ('i', 1 | 2 | 4 | 8) => Kind::Signed,
        ('u', 1 | 2 | 4 | 8) | ('b', 1) => Kind::Unsigned,
        _ => return None,
    };
    Some(Number::new(kind_of, bytes, kind.is_big_endian))
}

/// Returns columns without names; `is_apart` for columns that are stored one after the other.
fn array(number: Number, start: u64, [rows, columns]: [u64; 2], is_apart: bool) -> Vec<Lane> {
    let size = u64::from(number.bytes);
    // The product of an invalid shape saturates, and the comparison with the length of the file rejects it.
    let [first, stride] =
        if is_apart { [rows.saturating_mul(size), size] } else { [size, columns.saturating_mul(size)] };
    let run = |column: u64| Run::once(number, start.saturating_add(column.saturating_mul(first)), stride, rows);
    (0..columns).map(|column| Lane::even(String::new(), run(column))).collect()
}

fn structure(fields: Vec<Field>, start: u64, rows: u64) -> io::Result<Vec<Lane>> {
    let size = |field: &Field| field.shape.iter().try_fold(field.plain.bytes?, |size, n| size.checked_mul(*n));
    let sizes: Option<Vec<u64>> = fields.iter().map(size).collect();
    let width = sizes.as_ref().and_then(|sizes| sizes.iter().try_fold(0_u64, |sum, size| sum.checked_add(*size)));
    let (Some(sizes), Some(width)) = (sizes, width) else {
        return Err(io::Error::other("fields without a size"));
    };
    let mut at = start;
    let mut lanes = Vec::new();
    for (Field { name, plain, shape }, size) in fields.into_iter().zip(sizes) {
        let own = if shape.is_empty() { number(&plain) } else { None };
        let kind = if shape.is_empty() { format!("type {}", plain.text) } else { "arrays".to_owned() };
        let refused = own.is_none().then(|| format!("is of {kind}"));
        let runs = own.map(|number| Run::once(number, at, width, rows)).into_iter().collect();
        lanes.push(Lane { name, group: None, unit: None, rate: None, runs, refused });
        at = at.saturating_add(size);
    }
    Ok(lanes)
}
