//! Waveforms that Bently Nevada System 1 exports as CSV: records of one measuring point each, which begin with lines of key and
//! value and go on with a line for each sample.
//!
//! A variable such as `Disp Wf(256X/8revs)` was sampled in step with the shaft from a keyphasor pulse: sample k is at k/256
//! revolutions, and the sampling rate follows from `Sample Speed`.

use std::collections::HashMap;
use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};

use super::decimal::DecimalMark;
use super::header::{decoded, shortened};
use super::source::failed;
use crate::error::RecordingError;
use crate::table::{Cells, EXPECTED, Table, equal_lengths};

const EXPECTED_FILE: &str = "a waveform that System 1 exported as CSV";

/// First key of a record.
const FIRST: &str = "Machine Name";
/// First cell of the line above the samples.
const ABOVE_SAMPLES: &str = "X-Axis Value";
/// Number of bytes that identify a file.
pub(super) const BEGIN: u64 = 64;
/// Longest line, and largest number of samples of all records.
const LONGEST_LINE: u64 = 1 << 16;
const MAX_SAMPLES: usize = 1 << 26;
/// Largest number of records.
const MAX_RECORDS: usize = 1 << 16;
/// Largest relative difference between the speeds of records that belong together.
const SPEED_TOLERANCE: f64 = 1e-3;

/// Returns true for the first line of an export.
pub(super) fn begins(line: &[u8]) -> bool {
    let line = line.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(line);
    let rest = line.strip_prefix(FIRST.as_bytes());
    rest.is_some_and(|rest| matches!(rest.first(), Some(b',' | b';' | b'\t')))
}

/// One record of a measuring point.
#[derive(Debug, Default)]
struct Waveform {
    point: String,
    variable: String,
    unit: String,
    x_unit: String,
    timestamp: String,
    status: String,
    /// Revolutions by the key `Number of Revs`.
    revolutions: Option<f64>,
    /// Shaft speed, rpm.
    speed: Option<f64>,
    /// Line of the first sample.
    line: u64,
    /// First and last value of the X axis.
    span: Option<[f64; 2]>,
    samples: Vec<f64>,
    /// The file ends within a line.
    is_torn: bool,
}

/// The records of a file.
pub(super) struct System1 {
    path: PathBuf,
    names: Vec<String>,
    records: Vec<Waveform>,
    selected: Vec<usize>,
    rate: Option<f64>,
    samples_per_revolution: Option<f64>,
    rows: usize,
    row: usize,
    is_torn: bool,
    /// Bytes of the file.
    bytes: u64,
}

/// Reads the records of an export.
pub(super) fn open(reader: impl BufRead, path: &Path) -> Result<System1, RecordingError> {
    let mut lines = Lines { reader, path, line: 0, bytes: 0, text: String::new(), is_whole: true };
    let mut records = Vec::new();
    let mut left = MAX_SAMPLES;
    let mut has_line = lines.next()?;
    while has_line {
        if records.len() == MAX_RECORDS {
            return Err(lines.wrong(format!("more than {MAX_RECORDS} records")));
        }
        let mut record = lines.head()?;
        has_line = lines.samples(&mut record, &mut left)?;
        records.push(record);
    }
    let bytes = lines.bytes;
    let names = names(&records);
    let (path, selected) = (path.into(), Vec::new());
    Ok(System1 {
        path,
        names,
        records,
        selected,
        rate: None,
        samples_per_revolution: None,
        rows: 0,
        row: 0,
        is_torn: false,
        bytes,
    })
}

/// Returns the names of the measuring points; those with several records are numbered from 1.
fn names(records: &[Waveform]) -> Vec<String> {
    let mut counts = HashMap::<&str, [usize; 2]>::new();
    for record in records {
        counts.entry(&record.point).or_default()[0] += 1;
    }
    let mut name = |record: &Waveform| match counts.get_mut(record.point.as_str()) {
        Some([all, number]) if *all > 1 => {
            *number += 1;
            format!("{} #{number}", record.point)
        }
        _ => record.point.clone(),
    };
    records.iter().map(&mut name).collect()
}

/// Reader of lines that are not blank.
struct Lines<'a, R> {
    reader: R,
    path: &'a Path,
    line: u64,
    bytes: u64,
    /// The line at hand, trimmed.
    text: String,
    /// It ends with a line break.
    is_whole: bool,
}

impl<R: BufRead> Lines<'_, R> {
    fn next(&mut self) -> Result<bool, RecordingError> {
        loop {
            let mut text = Vec::new();
            let read = self.reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut text);
            let count = read.map_err(|cause| failed(self.path, self.line, cause))? as u64;
            if count == 0 {
                return Ok(false);
            }
            self.line += 1;
            self.bytes += count;
            if count == LONGEST_LINE || text.contains(&0) {
                return Err(RecordingError::NotText { file: self.path.into(), line: self.line });
            }
            self.is_whole = text.ends_with(b"\n");
            let text = text.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&text);
            self.text = decoded(text).trim().to_owned();
            if !self.text.trim_matches([',', ';', '\t']).is_empty() {
                return Ok(true);
            }
        }
    }

    fn wrong(&self, found: String) -> RecordingError {
        RecordingError::Format { file: self.path.into(), found, expected: EXPECTED_FILE }
    }

    /// Reads the lines of key and value, from the one at hand to the one above the samples.
    fn head(&mut self) -> Result<Waveform, RecordingError> {
        let mut record = Waveform::default();
        loop {
            let (key, value) = self.text.split_once([',', ';', '\t']).unwrap_or((&self.text, ""));
            let (key, value) = (key.trim(), value.trim().trim_end_matches([',', ';', '\t']).trim());
            match key {
                ABOVE_SAMPLES => break,
                "Point Name" => record.point = value.to_owned(),
                "Variable" => record.variable = value.to_owned(),
                "X-Axis Unit" => record.x_unit = value.to_owned(),
                "Y-Axis Unit" => record.unit = value.to_owned(),
                "Timestamp" => record.timestamp = value.to_owned(),
                "Sample Status" => record.status = value.to_owned(),
                "Number of Revs" => record.revolutions = Some(self.number(value, "Number of Revs", "")?),
                "Sample Speed" => record.speed = Some(self.number(value, "Sample Speed", "rpm")?),
                _ => {}
            }
            if !self.next()? {
                return Err(self.wrong("a record without samples".to_owned()));
            }
        }
        if record.point.is_empty() {
            return Err(self.wrong(format!("a record without `Point Name` above line {}", self.line)));
        }
        if !matches!(record.x_unit.as_str(), "ms" | "s") {
            let found = format!("`X-Axis Unit` is `{}` above line {}, no unit of time", record.x_unit, self.line);
            return Err(self.wrong(found));
        }
        record.line = self.line + 1;
        Ok(record)
    }

    /// Reads a number above 0 that a unit follows.
    fn number(&self, value: &str, key: &'static str, unit: &str) -> Result<f64, RecordingError> {
        let (number, own) = value.split_once(char::is_whitespace).unwrap_or((value, ""));
        let number = if own.trim() == unit { read(number.as_bytes()) } else { None };
        let number = number.filter(|number| number.is_finite() && *number > 0.0);
        number.ok_or_else(|| RecordingError::Cell {
            file: self.path.into(),
            line: self.line,
            column: key.to_owned(),
            found: shortened(value.as_bytes()),
            expected: if unit.is_empty() { "a number above 0" } else { "a number above 0 in rpm" },
        })
    }

    /// Reads the samples of a record; returns true where another record follows.
    fn samples(&mut self, record: &mut Waveform, left: &mut usize) -> Result<bool, RecordingError> {
        while self.next()? {
            if begins(format!("{}\n", self.text).as_bytes()) {
                return Ok(true);
            }
            let mut cells = self.text.split(if self.text.contains(';') { [';', '\t'] } else { [',', '\t'] });
            let (x, y) = (cells.next().unwrap_or_default(), cells.next());
            let cell = |column: &str, text: &str| RecordingError::Cell {
                file: self.path.into(),
                line: self.line,
                column: column.to_owned(),
                found: shortened(text.as_bytes()),
                expected: EXPECTED,
            };
            let (Some(x_value), Some(y_value)) = (read(x.as_bytes()), y.and_then(|y| read(y.as_bytes()))) else {
                if self.is_whole {
                    return Err(cell(&record.point, y.unwrap_or(x)));
                }
                record.is_torn = true;
                return Ok(false);
            };
            if *left == 0 {
                return Err(self.wrong(format!("more than {MAX_SAMPLES} samples")));
            }
            *left -= 1;
            record.span = Some([record.span.map_or(x_value, |[first, _]| first), x_value]);
            record.samples.push(y_value);
        }
        // The last number may be a part of one.
        if !self.is_whole && record.expected().is_some_and(|expected| record.samples.len() < expected) {
            record.samples.pop();
            record.is_torn = true;
        }
        Ok(false)
    }
}

/// Reads a number with a decimal point or comma.
fn read(text: &[u8]) -> Option<f64> {
    DecimalMark::Point.number(text).or_else(|| DecimalMark::Comma.number(text))
}

impl Waveform {
    /// Returns samples per revolution and revolutions by a variable such as `Disp Wf(256X/8revs)`.
    fn synchronous(&self) -> Option<[f64; 2]> {
        let inner = self.variable.split_once('(')?.1.split_once(')')?.0;
        let (samples, revolutions) = inner.split_once('/')?;
        let samples = samples.trim().trim_end_matches(['X', 'x']).trim();
        let revolutions = revolutions.trim().trim_end_matches(char::is_alphabetic).trim();
        let count = |text: &str| text.parse::<u32>().ok().filter(|count| *count > 0).map(f64::from);
        Some([count(samples)?, count(revolutions)?])
    }

    fn samples_per_revolution(&self) -> Option<f64> {
        let of_count = || Some(self.samples.len() as f64 / self.revolutions?);
        self.synchronous().map(|[samples, _]| samples).or_else(of_count).filter(|samples| *samples >= 2.0)
    }

    /// Returns the number of samples by the head of the record.
    fn expected(&self) -> Option<usize> {
        self.synchronous().map(|[samples, revolutions]| (samples * revolutions) as usize)
    }

    /// Returns the sampling rate, Hz: samples per revolution times speed, or by the X axis.
    fn rate(&self) -> Option<f64> {
        if let (Some(samples), Some(speed)) = (self.samples_per_revolution(), self.speed) {
            return Some(samples * speed / 60.0);
        }
        let [first, last] = self.span?;
        let seconds = (last - first) * if self.x_unit == "ms" { 1e-3 } else { 1.0 };
        let rate = self.samples.len().saturating_sub(1) as f64 / seconds;
        (rate.is_finite() && rate > 0.0).then_some(rate)
    }
}

impl System1 {
    fn chosen(&self) -> impl Iterator<Item = &Waveform> {
        self.selected.iter().filter_map(|place| self.records.get(*place))
    }

    fn first_chosen(&self) -> Option<&Waveform> {
        self.chosen().next()
    }

    /// Checks that the selected records were sampled together.
    fn check_together(&self) -> Result<(), RecordingError> {
        let mut records = self.chosen();
        let Some(first) = records.next() else { return Ok(()) };
        let near = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => (a / b - 1.0).abs() <= SPEED_TOLERANCE,
            (a, b) => a == b,
        };
        for other in records {
            let different = if other.timestamp != first.timestamp {
                Some(("Timestamp", first.timestamp.clone(), other.timestamp.clone()))
            } else if !near(other.rate(), first.rate()) {
                let shown = |rate: Option<f64>| rate.map_or_else(|| "none".to_owned(), |rate| format!("{rate:.1} Hz"));
                Some(("sampling rate", shown(first.rate()), shown(other.rate())))
            } else {
                None
            };
            if let Some((what, own, its)) = different {
                let found = format!("{what} `{own}` of `{}` and `{its}` of `{}`", first.point, other.point);
                let expected = "records of one time and rate";
                return Err(RecordingError::Format { file: self.path.clone(), found, expected });
            }
        }
        Ok(())
    }
}

impl Table for System1 {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn unit(&self, place: usize) -> Option<&str> {
        self.records.get(place).map(|record| record.unit.as_str()).filter(|unit| !unit.is_empty())
    }

    fn rate(&self) -> Option<f64> {
        self.rate
    }

    fn samples_per_revolution(&self) -> Option<f64> {
        self.samples_per_revolution
    }

    fn notes(&self) -> Vec<String> {
        let invalid = self.chosen().filter(|record| !matches!(record.status.as_str(), "" | "Valid"));
        invalid.map(|r| format!("The record of {} has the status {} in the file.", r.point, r.status)).collect()
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        self.selected = places.to_vec();
        self.check_together()?;
        let lengths: Vec<_> =
            self.chosen().map(|record| (record.point.as_str(), record.samples.len() as u64)).collect();
        self.rows = equal_lengths(&self.path, &lengths)? as usize;
        let torn = |r: &Waveform| r.is_torn || r.expected().is_some_and(|expected| r.samples.len() < expected);
        let is_torn = self.chosen().any(torn);
        let rate = self.first_chosen().and_then(Waveform::rate);
        let samples = self.first_chosen().and_then(Waveform::samples_per_revolution);
        (self.is_torn, self.rate, self.samples_per_revolution) = (is_torn, rate, samples);
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        cells.values.clear();
        let row = self.row;
        self.row += 1;
        cells.line = self.first_chosen().map_or(0, |record| record.line) + row as u64;
        cells.whole = self.names.len();
        if row >= self.rows {
            // The incomplete row at the end of a file that is truncated.
            cells.whole = 0;
            cells.values.resize(self.selected.len(), f64::NAN);
            return Ok(core::mem::take(&mut self.is_torn));
        }
        cells.values.extend(self.chosen().map(|record| record.samples.get(row).copied().unwrap_or(f64::NAN)));
        Ok(true)
    }

    fn bytes_read(&self) -> u64 {
        if self.rows == 0 { 0 } else { self.bytes / self.rows as u64 * self.row as u64 }
    }
}
