//! Numbers that lie at even distances in a file, read a block at a time.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::error::RecordingError;
use super::table::{Cells, LONGEST_VECTOR, Table, equal_lengths};

/// Bytes read at once.
const BLOCK: u64 = 1 << 16;

/// Format of a stored number, and its conversion `scale * stored + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Number {
    pub(super) kind: Kind,
    /// Size in bytes: 1 to 8; 2, 4 or 8 for a float.
    pub(super) bytes: u8,
    pub(super) big_endian: bool,
    /// Factor of the stored number.
    pub(super) scale: f64,
    /// Summand after the multiplication.
    pub(super) offset: f64,
}

/// Representation of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Signed,
    Unsigned,
    Float,
    /// Offset binary: unsigned, with zero in the middle of the range.
    Centred,
}

impl Number {
    pub(super) const fn new(kind: Kind, bytes: u8, big_endian: bool) -> Self {
        Self { kind, bytes, big_endian, scale: 1.0, offset: 0.0 }
    }

    /// Reads the number from the first bytes; absent bytes count as zeros.
    pub(super) fn read(self, bytes: &[u8]) -> f64 {
        let size = usize::from(self.bytes.clamp(1, 8));
        let mut own = [0; 8];
        for (to, from) in own.iter_mut().zip(bytes.iter().take(size)) {
            *to = *from;
        }
        let unused = 64 - 8 * size as u32;
        let bits = if self.big_endian { u64::from_be_bytes(own) >> unused } else { u64::from_le_bytes(own) };
        let value = match self.kind {
            Kind::Signed => ((bits << unused) as i64 >> unused) as f64,
            Kind::Unsigned => bits as f64,
            Kind::Float if size == 2 => half(bits as u16),
            Kind::Float if size == 4 => f64::from(f32::from_bits(bits as u32)),
            Kind::Float => f64::from_bits(bits),
            Kind::Centred => bits as f64 - (1_u64 << (8 * size - 1)) as f64,
        };
        value * self.scale + self.offset
    }
}

/// Returns the value of a float of 16 bits (IEEE 754 binary16).
fn half(bits: u16) -> f64 {
    let (exponent, mantissa) = (i32::from(bits >> 10 & 0x1f), f64::from(bits & 0x3ff));
    let size = match exponent {
        0 => mantissa * 2.0_f64.powi(-24),
        31 if mantissa == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + mantissa) * 2.0_f64.powi(exponent - 25),
    };
    if bits >> 15 == 0 { size } else { -size }
}

/// Positions of numbers in a file: `count` numbers `stride` bytes apart, in `repeats` groups `every` bytes apart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    pub(super) number: Number,
    pub(super) start: u64,
    pub(super) stride: u64,
    pub(super) count: u64,
    pub(super) every: u64,
    pub(super) repeats: u64,
}

impl Run {
    /// Creates a run without repetition.
    pub(super) const fn once(number: Number, start: u64, stride: u64, count: u64) -> Self {
        Self { number, start, stride, count, every: 0, repeats: 1 }
    }

    fn length(&self) -> Option<u64> {
        self.count.checked_mul(self.repeats)
    }

    /// Returns the offset of the end of the last number.
    fn end(&self) -> Option<u64> {
        let inner = self.count.checked_sub(1)?.checked_mul(self.stride)?;
        let outer = self.repeats.checked_sub(1)?.checked_mul(self.every)?;
        self.start.checked_add(inner)?.checked_add(outer)?.checked_add(self.number.bytes.into())
    }

    /// Returns an equal run without repetition where that is possible: repeated single numbers would be read one by one.
    const fn straightened(self) -> Self {
        if self.count == 1 && self.repeats > 1 {
            Self { stride: self.every, count: self.repeats, repeats: 1, ..self }
        } else {
            self
        }
    }
}

/// One column of a file: its name and the positions of its numbers.
pub(super) struct Lane {
    pub(super) name: String,
    /// Name of its group, which the name begins with.
    pub(super) group: Option<String>,
    pub(super) unit: Option<String>,
    /// Sampling rate, Hz.
    pub(super) rate: Option<f64>,
    pub(super) runs: Vec<Run>,
    /// Reason for which it cannot be read; reported where the scene names it.
    pub(super) refused: Option<String>,
}

impl Lane {
    /// Creates a column of a single run.
    pub(super) fn even(name: String, run: Run) -> Self {
        Self { name, group: None, unit: None, rate: None, runs: vec![run], refused: None }
    }
}

/// Content of a file, as the reader of its format finds it.
pub(super) struct Layout {
    pub(super) lanes: Vec<Lane>,
    /// The file ends within a row.
    pub(super) torn: bool,
    /// Values that the format allows.
    pub(super) expected: &'static str,
    /// Single numbers of the file, each a run of one.
    pub(super) scalars: Vec<(String, Run)>,
    /// Assumptions about the file.
    pub(super) notes: Vec<String>,
}

impl Layout {
    /// Creates the layout of a complete file that has columns only.
    pub(super) const fn of(lanes: Vec<Lane>, expected: &'static str) -> Self {
        Self { lanes, torn: false, expected, scalars: vec![], notes: vec![] }
    }
}

/// A file whose numbers are not compressed.
pub(super) struct Numbers {
    path: PathBuf,
    file: File,
    names: Vec<String>,
    layout: Layout,
    selected: Vec<Column>,
    rate: Option<f64>,
    /// Name of a selected column without a rate, of which no other column of its group has one.
    unrated: Option<String>,
    rows: u64,
    row: u64,
    /// Bytes of all numbers of a row that is read.
    width: u64,
    bytes: Vec<u8>,
}

/// A column that is read: its runs and the current block.
struct Column {
    runs: Vec<Run>,
    run: usize,
    repeat: u64,
    at: u64,
    block: Vec<f64>,
    next: usize,
}

impl Numbers {
    pub(super) fn new(file: File, path: &Path, layout: Layout) -> Self {
        let names = layout.lanes.iter().map(|lane| lane.name.clone()).collect();
        let (path, selected, bytes) = (path.into(), Vec::new(), Vec::new());
        let (rate, unrated) = (None, None);
        Self { path, file, names, layout, selected, rate, unrated, rows: 0, row: 0, width: 0, bytes }
    }

    fn wrong(&self, found: String) -> RecordingError {
        RecordingError::Format { file: self.path.clone(), found, expected: self.layout.expected }
    }

    /// Returns the runs of a column; an error where one of them is not within the file.
    fn column(&self, lane: &Lane, size: u64) -> Result<Column, RecordingError> {
        if let Some(reason) = &lane.refused {
            return Err(self.wrong(format!("`{}`: {reason}", lane.name)));
        }
        let beyond = |run: &&Run| run.length().is_none() || run.end().is_none_or(|end| end > size);
        if lane.runs.iter().filter(|run| run.count > 0 && run.repeats > 0).any(|run| beyond(&run)) {
            return Err(self.wrong(format!("a truncated file: `{}` extends beyond its {size} bytes", lane.name)));
        }
        let runs = lane.runs.iter().filter(|run| run.count > 0 && run.repeats > 0);
        let runs = runs.map(|run| run.straightened()).collect();
        Ok(Column { runs, run: 0, repeat: 0, at: 0, block: Vec::new(), next: 0 })
    }

    /// Returns the rate of the channels, Hz, which must be the same for all that define one.
    fn common_rate(&self, lanes: &[&Lane]) -> Result<Option<f64>, RecordingError> {
        let mut rates = lanes.iter().filter_map(|lane| Some((&lane.name, lane.rate?)));
        let Some((name, rate)) = rates.next() else { return Ok(None) };
        match rates.find(|(_, other)| (other / rate - 1.0).abs() > 1e-9) {
            Some((other, own)) => Err(self.wrong(format!("{rate} Hz in `{name}` and {own} Hz in `{other}`"))),
            None => Ok(Some(rate)),
        }
    }
}

impl Table for Numbers {
    fn columns(&self) -> &[String] {
        &self.names
    }

    /// A channel in a group is also found by its own name.
    fn is_called(&self, place: usize, name: &str) -> bool {
        let Some(lane) = self.layout.lanes.get(place) else { return false };
        let channel = lane.group.as_ref().and_then(|group| lane.name.strip_prefix(group.as_str())?.strip_prefix('/'));
        lane.name == name || channel == Some(name)
    }

    fn unit(&self, place: usize) -> Option<&str> {
        self.layout.lanes.get(place)?.unit.as_deref()
    }

    fn rate(&self) -> Option<f64> {
        self.rate
    }

    fn unrated(&self) -> Option<&str> {
        self.unrated.as_deref()
    }

    fn notes(&self) -> Vec<String> {
        self.layout.notes.clone()
    }

    fn vector(&mut self, place: usize) -> Result<Option<Vec<f64>>, RecordingError> {
        let Some(lane) = self.layout.lanes.get(place) else { return Ok(None) };
        let size = self.file.metadata().map_err(|cause| RecordingError::Open { file: self.path.clone(), cause })?.len();
        let mut column = self.column(lane, size)?;
        let count = column.length();
        if count > LONGEST_VECTOR {
            return Err(self.wrong(format!("{count} values in `{}`, more than {LONGEST_VECTOR}", lane.name)));
        }
        let values = (0..count).map(|_| column.next(&mut self.file, &mut self.bytes)).collect::<io::Result<Vec<_>>>();
        let failed = |cause| RecordingError::Read { file: self.path.clone(), line: 0, cause };
        values.map(Some).map_err(failed)
    }

    fn scalar(&mut self, name: &str) -> Result<Option<f64>, RecordingError> {
        let Some((_, run)) = self.layout.scalars.iter().find(|(own, _)| own == name) else { return Ok(None) };
        let mut bytes = vec![0; run.number.bytes.into()];
        let read = self.file.seek(SeekFrom::Start(run.start)).and_then(|_| self.file.read_exact(&mut bytes));
        let failed = |cause| RecordingError::Read { file: self.path.clone(), line: 0, cause };
        read.map_err(failed).map(|()| Some(run.number.read(&bytes)))
    }

    fn scalar_names(&self) -> Vec<String> {
        self.layout.scalars.iter().map(|(name, _)| name.clone()).collect()
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let size = self.file.metadata().map_err(|cause| RecordingError::Open { file: self.path.clone(), cause })?.len();
        let lanes: Vec<&Lane> = places.iter().filter_map(|place| self.layout.lanes.get(*place)).collect();
        let columns = lanes.iter().map(|lane| self.column(lane, size)).collect::<Result<Vec<_>, _>>()?;
        let lengths: Vec<_> = lanes.iter().zip(&columns).map(|(lane, c)| (lane.name.as_str(), c.length())).collect();
        let rows = equal_lengths(&self.path, &lengths)?;
        let rate = self.common_rate(&lanes)?;
        let is_rated = |lane: &&Lane| lanes.iter().any(|other| other.group == lane.group && other.rate.is_some());
        self.unrated = lanes.iter().copied().find(|lane| !is_rated(lane)).map(|lane| lane.name.clone());
        let width = columns.iter().filter_map(|c| c.runs.first()).map(|run| u64::from(run.number.bytes)).sum();
        (self.selected, self.rows, self.rate, self.width) = (columns, rows, rate, width);
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        cells.values.clear();
        self.row += 1;
        (cells.line, cells.whole) = (self.row, self.names.len());
        if self.row > self.rows {
            // The incomplete row at the end of a file that is still being written.
            cells.whole = 0;
            cells.values.resize(self.selected.len(), f64::NAN);
            return Ok(core::mem::take(&mut self.layout.torn));
        }
        for column in &mut self.selected {
            let value = column.next(&mut self.file, &mut self.bytes);
            let failed = |cause| RecordingError::Read { file: self.path.clone(), line: self.row - 1, cause };
            cells.values.push(value.map_err(failed)?);
        }
        Ok(true)
    }

    fn bytes_read(&self) -> u64 {
        self.row.saturating_mul(self.width)
    }
}

impl Column {
    fn length(&self) -> u64 {
        self.runs.iter().fold(0, |sum, run| sum.saturating_add(run.length().unwrap_or(0)))
    }

    fn next(&mut self, file: &mut File, bytes: &mut Vec<u8>) -> io::Result<f64> {
        if self.next == self.block.len() {
            self.fetch(file, bytes)?;
        }
        let value = self.block.get(self.next).copied();
        self.next += 1;
        value.ok_or_else(|| io::ErrorKind::UnexpectedEof.into())
    }

    /// Reads the next block; it is empty at the end.
    fn fetch(&mut self, file: &mut File, bytes: &mut Vec<u8>) -> io::Result<()> {
        self.block.clear();
        self.next = 0;
        let Some(run) = self.runs.get(self.run) else { return Ok(()) };
        let rows = (BLOCK / run.stride.max(1)).max(1).min(run.count - self.at);
        let start = run.start + self.repeat * run.every + self.at * run.stride;
        let span = (rows - 1) * run.stride + u64::from(run.number.bytes);
        bytes.resize(span as usize, 0);
        file.seek(SeekFrom::Start(start))?;
        file.read_exact(bytes)?;
        let stride = (run.stride as usize).max(1);
        self.block.extend(bytes.chunks(stride).take(rows as usize).map(|number| run.number.read(number)));
        self.at += rows;
        if self.at == run.count {
            (self.at, self.repeat) = (0, self.repeat + 1);
        }
        if self.repeat == run.repeats {
            (self.repeat, self.run) = (0, self.run + 1);
        }
        Ok(())
    }
}

/// Columns whose values are in memory as bytes of the file.
#[derive(Default)]
pub(super) struct LoadedColumns {
    columns: Vec<(Number, Vec<u8>)>,
    rows: u64,
    row: u64,
}

impl LoadedColumns {
    /// Creates the columns, each with this number of values.
    pub(super) fn new(columns: Vec<(Number, Vec<u8>)>, rows: u64) -> Self {
        Self { columns, rows, row: 0 }
    }

    /// Returns the values of the first column.
    pub(super) fn first(&self) -> Vec<f64> {
        let Some((number, bytes)) = self.columns.first() else { return vec![] };
        bytes.chunks_exact(usize::from(number.bytes).max(1)).map(|bytes| number.read(bytes)).collect()
    }

    /// Reads the next row of a file with `width` columns; false at the end.
    pub(super) fn next(&mut self, width: usize, cells: &mut Cells) -> bool {
        if self.row == self.rows {
            return false;
        }
        cells.values.clear();
        for (number, bytes) in &self.columns {
            let at = self.row as usize * usize::from(number.bytes);
            cells.values.push(number.read(bytes.get(at..).unwrap_or_default()));
        }
        self.row += 1;
        (cells.line, cells.whole) = (self.row, width);
        true
    }
}
