//! The first line of a file: delimiter and names of the columns.

use std::io::{BufRead, Read};
use std::path::Path;

use super::RecordingError;
use super::decimal::DecimalMark;
use super::source::failed;
use crate::output::without_apostrophe;

/// Largest length of the first line; a longer one is a binary file.
const LONGEST: u64 = 1 << 20;

/// Delimiters, the most likely first.
const DELIMITERS: [u8; 4] = *b",;\t|";

/// Content of the first line.
pub(super) struct Header {
    /// Trimmed names of the columns.
    pub(super) names: Vec<String>,
    pub(super) delimiter: u8,
    /// Line number of the header, which is the number of lines read.
    pub(super) line: u64,
    /// Bytes read.
    pub(super) bytes: u64,
    /// The first line, where it is a row.
    pub(super) first_row: Vec<u8>,
}

impl Header {
    /// Reads the first line that is not blank.
    pub(super) fn read(reader: &mut impl BufRead, file: &Path, is_headless: bool) -> Result<Self, RecordingError> {
        let (mut text, mut line, mut bytes) = (Vec::new(), 0, 0);
        while text.trim_ascii().is_empty() {
            text.clear();
            let count = reader.by_ref().take(LONGEST).read_until(b'\n', &mut text);
            let count = count.map_err(|cause| failed(file, line, cause))? as u64;
            if count == 0 {
                return Err(RecordingError::Empty { file: file.into() });
            }
            bytes += count;
            line += 1;
            if line == 1 && text.starts_with(b"\xEF\xBB\xBF") {
                text.drain(..3);
            }
            if count == LONGEST || text.contains(&0) {
                return Err(RecordingError::NotText { file: file.into(), line });
            }
        }
        if is_headless { Ok(Self::headless(text, line)) } else { Self::parse(text.trim_ascii_end(), line, bytes, file) }
    }

    /// Returns the header of a file whose first line is a row already.
    fn headless(first_row: Vec<u8>, line: u64) -> Self {
        let delimiter = numeric_delimiter(&first_row);
        let squeezed =
            first_row.split(|byte| *byte == b' ').filter(|cell| !cell.is_empty()).collect::<Vec<_>>().join(&b' ');
        let row = if delimiter == b' ' { squeezed.as_slice() } else { &first_row };
        let mut cells = names(row.trim_ascii_end(), delimiter);
        while cells.len() > 1 && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        let names = (0..cells.len()).map(|place| format!("c{place}")).collect();
        Self { names, delimiter, line: line - 1, bytes: 0, first_row }
    }

    fn parse(text: &[u8], line: u64, bytes: u64, file: &Path) -> Result<Self, RecordingError> {
        let delimiter = delimiter(text);
        let names = names(text, delimiter);
        let are_numbers = |names: &[String], mark: DecimalMark| {
            names.iter().all(|name| mark.number(name.as_bytes()).is_some()) && names.iter().any(|name| !name.is_empty())
        };
        let other = numeric_delimiter(text);
        let is_comma = other != b',' && are_numbers(&self::names(text, other), DecimalMark::Comma);
        let row = String::from_utf8_lossy(text);
        let words: Vec<String> = row.split_whitespace().map(str::to_owned).collect();
        if is_comma || are_numbers(&names, DecimalMark::Point) || are_numbers(&words, DecimalMark::Point) {
            let found = shortened(text);
            return Err(RecordingError::NoHeader { file: file.into(), line, found });
        }
        Ok(Self { names, delimiter, line, bytes, first_row: Vec::new() })
    }
}

/// Returns the delimiter of a row of numbers: a comma beside another delimiter is a decimal comma, and blanks count where there
/// is no other.
fn numeric_delimiter(row: &[u8]) -> u8 {
    let others = DELIMITERS.into_iter().skip(1).chain([b',', b' ']);
    others.into_iter().find(|delimiter| row.trim_ascii().contains(delimiter)).unwrap_or(b',')
}

/// Returns the delimiter that gives the most cells; of equal ones the more likely.
fn delimiter(text: &[u8]) -> u8 {
    let mut counts = [0_usize; DELIMITERS.len()];
    let mut quoted = false;
    for byte in text {
        quoted ^= *byte == b'"';
        if let Some(place) = DELIMITERS.iter().position(|delimiter| !quoted && delimiter == byte) {
            counts[place] += 1;
        }
    }
    let most = counts.iter().max().copied().unwrap_or(0);
    counts.iter().position(|count| *count == most).map_or(b',', |place| DELIMITERS[place])
}

fn names(text: &[u8], delimiter: u8) -> Vec<String> {
    let mut reader = ::csv::ReaderBuilder::new().delimiter(delimiter).has_headers(false).from_reader(text);
    let mut record = ::csv::ByteRecord::new();
    // Reading from memory cannot fail, and a line that is not blank has a record.
    let _ = reader.read_byte_record(&mut record);
    record.iter().map(|name| without_apostrophe(decoded(name).trim()).to_owned()).collect()
}

/// Decodes UTF-8, or else Latin-1, in which loggers on Windows write their micro and degree signs.
pub(super) fn decoded(text: &[u8]) -> String {
    match str::from_utf8(text) {
        Ok(text) => text.to_owned(),
        Err(_) => text.iter().map(|byte| char::from(*byte)).collect(),
    }
}

/// Returns text of the file for a message, shortened and escaped.
pub(super) fn shortened(text: &[u8]) -> String {
    const SHOWN: usize = 40;
    let text = String::from_utf8_lossy(text.trim_ascii());
    if text.chars().count() <= SHOWN {
        return text.escape_debug().to_string();
    }
    format!("{}...", text.chars().take(SHOWN).collect::<String>().escape_debug())
}
