//! Universal files as recordings: time responses of data set 58, in ASCII or binary (58b). A column is called by node and
//! direction, such as `1X+`, and by the first line of its identification.
//!
//! Format: Structural Dynamics Research Laboratory, University of Cincinnati, Universal File Formats for Modal Analysis Testing:
//! data set 58 "Function at Nodal DOF", between lines of `-1`.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::error::{RecordingError, refuse};
use super::numbers::{Kind, Number};
use super::table::{Cells, Table, equal_lengths};

const EXPECTED: &str = "a universal file with time responses in data sets 58: real numbers at an even spacing";

/// First bytes of a file, and of each data set.
pub(super) const SEPARATOR: &[u8] = b"    -1";
/// Longest line, and largest number of data sets.
const LONGEST_LINE: u64 = 1 << 12;
const MAX_SETS: usize = 1 << 16;
/// Largest number of values of all selected columns, which are held in memory.
const LARGEST: u64 = 1 << 27;
/// Lines of the head of data set 58.
const HEAD: usize = 11;
/// Function type of a time response.
const TIME_RESPONSE: u64 = 1;
/// Largest relative difference between the spacings of columns.
const SPACING_TOLERANCE: f64 = 1e-6;
/// Directions by the magnitude of their number.
const DIRECTIONS: [&str; 7] = ["", "X", "Y", "Z", "RX", "RY", "RZ"];

/// Form of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    /// Text with a fixed number of characters for each value.
    Text(usize),
    Binary(Number),
}

/// A time response.
#[derive(Debug, Clone)]
struct Response {
    /// Node and direction; nothing without a node.
    node: Option<String>,
    /// First line of the identification; nothing where it is blank or `NONE`.
    label: Option<String>,
    unit: Option<String>,
    count: u64,
    /// Sampling interval, s.
    spacing: f64,
    form: Form,
    /// Offset of the values.
    start: u64,
}

/// The time responses of a file.
struct Uff {
    path: PathBuf,
    file: File,
    names: Vec<String>,
    responses: Vec<Response>,
    selected: Vec<Vec<f64>>,
    rate: Option<f64>,
    row: usize,
}

/// Opens a file.
pub(super) fn open(file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let mut lines = Lines { reader: BufReader::new(file), text: String::new() };
    let responses = lines.responses().map_err(|cause| wrong(path, &cause))?;
    let names = names(&responses);
    let file = lines.reader.into_inner();
    let (path, selected) = (path.into(), Vec::new());
    Ok(Box::new(Uff { path, file, names, responses, selected, rate: None, row: 0 }))
}

fn wrong(path: &Path, cause: &io::Error) -> RecordingError {
    RecordingError::unreadable(path, cause, EXPECTED)
}

/// Returns the names of the columns: node and direction, the label, or a number from 0, whichever is unique.
fn names(responses: &[Response]) -> Vec<String> {
    let mut counts = HashMap::<&str, usize>::new();
    for name in responses.iter().flat_map(|response| response.node.iter().chain(&response.label)) {
        *counts.entry(name).or_default() += 1;
    }
    let is_unique = |name: &&String| counts.get(name.as_str()) == Some(&1);
    let name = |(place, response): (usize, &Response)| {
        let own = response.node.as_ref().filter(is_unique).or_else(|| response.label.as_ref().filter(is_unique));
        own.cloned().unwrap_or_else(|| format!("c{place}"))
    };
    responses.iter().enumerate().map(name).collect()
}

/// Reader of lines.
struct Lines {
    reader: BufReader<File>,
    text: String,
}

impl Lines {
    /// Reads the next line without its break; false at the end.
    fn next(&mut self) -> io::Result<bool> {
        let mut bytes = Vec::new();
        let count = self.reader.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut bytes)?;
        if count as u64 == LONGEST_LINE {
            return Err(refuse("a line of more than 4096 characters"));
        }
        // The format has no encoding; Latin-1 accepts every byte.
        self.text = match str::from_utf8(&bytes) {
            Ok(text) => text.trim_end().to_owned(),
            Err(_) => bytes.iter().map(|byte| char::from(*byte)).collect::<String>().trim_end().to_owned(),
        };
        Ok(count > 0)
    }

    fn next_or_end(&mut self) -> io::Result<&str> {
        if self.next()? { Ok(&self.text) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }

    /// Reads all data sets and returns the time responses.
    fn responses(&mut self) -> io::Result<Vec<Response>> {
        let (mut all, mut refused, mut sets) = (Vec::new(), None, 0);
        while self.next()? {
            if self.text.trim().is_empty() {
                continue;
            }
            if self.text.trim() != "-1" {
                return Err(refuse(format!("`{}` between data sets", shown(&self.text))));
            }
            sets += 1;
            if sets > MAX_SETS {
                return Err(refuse(format!("more than {MAX_SETS} data sets")));
            }
            let kind = self.next_or_end()?.to_owned();
            if field(&kind, 0, 6) == "58" {
                match self.response(&kind)? {
                    Ok(response) => all.push(response),
                    Err(reason) => drop(refused.get_or_insert(reason)),
                }
            }
            while self.next_or_end()?.trim() != "-1" {}
        }
        match (all.is_empty(), refused) {
            (true, Some(reason)) => Err(refuse(reason)),
            (true, None) => Err(refuse("no data set 58")),
            _ => Ok(all),
        }
    }

    /// Reads the head of data set 58 and skips binary values; returns the reason where the data set cannot be used.
    fn response(&mut self, kind: &str) -> io::Result<Result<Response, String>> {
        let mut head = Vec::new();
        for _ in 0..HEAD {
            head.push(self.next_or_end()?.to_owned());
        }
        let line = |place: usize| head.get(place).map_or("", String::as_str);
        let start = self.reader.stream_position()?;
        let whole = |text: &str| text.parse::<u64>().map_err(|_| refuse(format!("`{}` in data set 58", shown(text))));
        let (function, degree) = (whole(field(line(5), 0, 5))?, line(5));
        let (kind_of, count) = (whole(field(line(6), 0, 10))?, whole(field(line(6), 10, 10))?);
        let (even, spacing) = (field(line(6), 20, 10), number(field(line(6), 43, 13)));
        let binary = field(kind, 6, 1).eq_ignore_ascii_case("b");
        let bytes = match kind_of {
            2 => 4,
            4 => 8,
            5 | 6 => 0,
            other => return Err(refuse(format!("ordinates of type {other} in data set 58"))),
        };
        let form = if binary {
            let (order, float) = (field(kind, 7, 6), field(kind, 13, 6));
            let length = whole(field(kind, 31, 12))?;
            if float != "2" || !matches!(order, "1" | "2") {
                return Ok(Err(format!("floats of form {float} in byte order {order} in data set 58b")));
            }
            // `SeekFrom::Current` would wrap where the length is invalid.
            let end = start.checked_add(length).ok_or(io::ErrorKind::UnexpectedEof)?;
            if end > self.reader.get_ref().metadata()?.len() {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            self.reader.seek(SeekFrom::Start(end))?;
            if bytes > 0 && count.checked_mul(bytes).is_none_or(|own| own > length) {
                return Err(refuse(format!("{count} values in {length} bytes of data set 58b")));
            }
            Form::Binary(Number::new(Kind::Float, bytes.clamp(4, 8) as u8, order == "2"))
        } else {
            Form::Text(if kind_of == 2 { 13 } else { 20 })
        };
        if function != TIME_RESPONSE {
            return Ok(Err(format!("functions of type {function}, no time response")));
        }
        if bytes == 0 || even != "1" {
            let found = if bytes == 0 { "complex values" } else { "an uneven spacing" };
            return Ok(Err(format!("a time response with {found}")));
        }
        let Some(spacing) = spacing.filter(|spacing| spacing.is_finite() && *spacing > 0.0) else {
            return Ok(Err(format!("a time response with the spacing `{}`", field(line(6), 43, 13))));
        };
        let named = |text: &str| (!text.is_empty() && text != "NONE").then(|| text.to_owned());
        let (label, unit) = (named(line(0).trim()), named(field(line(8), 47, 20)));
        Ok(Ok(Response { node: node(degree), label, unit, count, spacing, form, start }))
    }
}

/// Returns node and direction of the response, such as `1X+`.
fn node(line: &str) -> Option<String> {
    let node = field(line, 41, 10).parse::<u64>().ok().filter(|node| *node > 0)?;
    let direction = field(line, 51, 4).parse::<i64>().ok()?;
    let name = DIRECTIONS.get(usize::try_from(direction.unsigned_abs()).ok()?)?;
    let sign = match direction {
        0 => "",
        1.. => "+",
        _ => "-",
    };
    Some(format!("{node}{name}{sign}"))
}

/// Returns characters of a line, without blanks at their ends.
fn field(line: &str, start: usize, length: usize) -> &str {
    let place = |characters: usize| {
        if line.is_ascii() {
            return characters.min(line.len());
        }
        line.char_indices().nth(characters).map_or(line.len(), |(place, _)| place)
    };
    line.get(place(start)..place(start + length)).unwrap_or_default().trim()
}

fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Reads a number of Fortran, whose exponent may begin with `D`.
fn number(text: &str) -> Option<f64> {
    text.trim().replace(['D', 'd'], "e").parse().ok()
}

impl Uff {
    fn load(&self, response: &Response) -> io::Result<Vec<f64>> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(response.start))?;
        let count = usize::try_from(response.count).map_err(io::Error::other)?;
        let mut values = Vec::new();
        match response.form {
            Form::Binary(number) => {
                let mut bytes = Vec::new();
                file.take(response.count * u64::from(number.bytes)).read_to_end(&mut bytes)?;
                values.extend(bytes.chunks_exact(number.bytes.into()).map(|bytes| number.read(bytes)));
            }
            Form::Text(width) => {
                let mut lines = Lines { reader: BufReader::new(file.try_clone()?), text: String::new() };
                while values.len() < count && lines.next_or_end()?.trim() != "-1" {
                    let found = numbers(&lines.text, width);
                    values.extend(found.ok_or_else(|| refuse(format!("no values in `{}`", shown(&lines.text))))?);
                }
            }
        }
        if values.len() != count {
            return Err(refuse(format!("{} values instead of {count} in data set 58", values.len())));
        }
        Ok(values)
    }
}

/// Reads the values of a line, in columns of a width or with blanks between them.
fn numbers(line: &str, width: usize) -> Option<Vec<f64>> {
    let columns = (0..line.len()).step_by(width).map(|start| number(field(line, start, width)));
    let columns: Option<Vec<f64>> = columns.collect();
    columns.or_else(|| line.split_whitespace().map(number).collect())
}

impl Table for Uff {
    fn columns(&self) -> &[String] {
        &self.names
    }

    /// A column is also found by its label.
    fn is_called(&self, place: usize, name: &str) -> bool {
        let label = self.responses.get(place).and_then(|response| response.label.as_deref());
        self.names.get(place).is_some_and(|own| own == name) || label == Some(name)
    }

    fn unit(&self, place: usize) -> Option<&str> {
        self.responses.get(place)?.unit.as_deref()
    }

    fn rate(&self) -> Option<f64> {
        self.rate
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let chosen: Vec<Response> = places.iter().filter_map(|place| self.responses.get(*place).cloned()).collect();
        let names = places.iter().filter_map(|place| self.names.get(*place));
        let lengths: Vec<_> = names.zip(&chosen).map(|(name, response)| (name.as_str(), response.count)).collect();
        let rows = equal_lengths(&self.path, &lengths)?;
        let error = |found: String| wrong(&self.path, &refuse(found));
        if rows.saturating_mul(chosen.len() as u64) > LARGEST {
            return Err(error(format!(
                "{rows} values in each of {} columns, more than {LARGEST} in all",
                chosen.len()
            )));
        }
        let spacing = chosen.first().map_or(1.0, |response| response.spacing);
        if let Some(other) = chosen.iter().find(|other| (other.spacing / spacing - 1.0).abs() > SPACING_TOLERANCE) {
            return Err(error(format!("spacings of {spacing} s and {} s", other.spacing)));
        }
        let loaded = chosen.iter().map(|response| self.load(response)).collect::<io::Result<_>>();
        self.selected = loaded.map_err(|cause| wrong(&self.path, &cause))?;
        self.rate = Some(1.0 / spacing);
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        let is_row = cells.take_row(&self.selected, self.row, self.names.len());
        self.row += usize::from(is_row);
        Ok(is_row)
    }

    fn bytes_read(&self) -> u64 {
        (self.row * self.responses.len() * size_of::<f64>()) as u64
    }
}
