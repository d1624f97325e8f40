//! Recordings as text: columns with a header, read row by row in bounded memory.

mod header;
mod source;

use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

use ::csv::{ByteRecord, ReaderBuilder, Terminator};

use self::header::{Header, shortened};
use self::source::{Source, failed};
use super::error::RecordingError;
use super::table::{Cells, EXPECTED, Table};

/// Bytes read from the file at once.
const BUFFER: usize = 1 << 16;

/// Values expected in a cell, with a hint about the decimal comma.
const EXPECTED_POINT: &str = "a number with a decimal point, or NaN or nothing where the reading is missing";

/// A CSV file, row by row.
///
/// The delimiter (`,` `;` tab `|`) is detected from the header line, which is required. Blank lines are skipped.
pub(super) struct CsvTable {
    name: PathBuf,
    header: Header,
    /// Indices of the cells that are used.
    selected: Vec<usize>,
    source: ::csv::Reader<Source>,
    record: ByteRecord,
    /// Line of the row read last.
    line: u64,
}

impl CsvTable {
    pub(super) fn new(reader: Box<dyn Read + Send>, name: &Path) -> Result<Self, RecordingError> {
        let mut reader = BufReader::with_capacity(BUFFER, reader);
        let header = Header::read(&mut reader, name)?;
        let source = ReaderBuilder::new()
            .delimiter(header.delimiter)
            .has_headers(false)
            .flexible(true)
            // A carriage return before it is trimmed with the cell; the parser would count it as a line.
            .terminator(Terminator::Any(b'\n'))
            .buffer_capacity(BUFFER)
            .from_reader(Source::new(reader));
        let (line, selected, record) = (header.line, Vec::new(), ByteRecord::new());
        Ok(Self { name: name.into(), header, selected, source, record, line })
    }

    /// Reads the next row that is not blank.
    fn read_record(&mut self) -> Result<bool, RecordingError> {
        loop {
            self.source.get_mut().allow_row();
            match self.source.read_byte_record(&mut self.record) {
                Ok(true) => {}
                Ok(false) => return Ok(false),
                Err(error) => return Err(self.unread(error)),
            }
            // The parser's line is the next one already, except after a last line without a break.
            let next = self.header.line + self.source.position().line();
            self.line = if self.source.get_ref().broke_off() { next } else { next - 1 };
            if self.record.len() > 1 || self.record.iter().any(|cell| !cell.trim_ascii().is_empty()) {
                return Ok(true);
            }
        }
    }

    /// Returns the numbers of the first `whole` cells, NaN for the rest; the error is the index of a cell without a number.
    fn parse(&self, whole: usize, values: &mut Vec<f64>) -> Result<(), usize> {
        values.clear();
        for place in &self.selected {
            values.push(match self.record.get(*place) {
                Some(text) if *place < whole => number(text).ok_or(*place)?,
                _ => f64::NAN,
            });
        }
        Ok(())
    }

    fn wrong_cell(&self, place: usize) -> RecordingError {
        let found = shortened(self.record.get(place).unwrap_or_default());
        let comma = found.contains(',') && found.replace(',', ".").parse::<f64>().is_ok();
        RecordingError::Cell {
            file: self.name.clone(),
            line: self.line,
            column: self.header.names[place].clone(),
            found,
            expected: if comma { EXPECTED_POINT } else { EXPECTED },
        }
    }

    fn unread(&self, error: ::csv::Error) -> RecordingError {
        let text = error.to_string();
        let source = match error.into_kind() {
            ::csv::ErrorKind::Io(source) => source,
            _ => std::io::Error::other(text),
        };
        failed(&self.name, self.line, source)
    }
}

impl Table for CsvTable {
    fn columns(&self) -> &[String] {
        &self.header.names
    }

    fn header_line(&self) -> Option<u64> {
        Some(self.header.line)
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        self.selected = places.into();
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        if !self.read_record()? {
            return Ok(false);
        }
        let (found, expected) = (self.record.len(), self.header.names.len());
        if found > expected {
            return Err(RecordingError::RowTooLong { file: self.name.clone(), line: self.line, found, expected });
        }
        let mut whole = if found < expected { found.saturating_sub(1) } else { found };
        let result = match self.parse(whole, &mut cells.values) {
            // `-` or `1.2e` at the end of the file is an incomplete number, not a wrong cell.
            Err(place) if place + 1 == expected && self.source.get_ref().broke_off() => {
                whole = place;
                self.parse(whole, &mut cells.values)
            }
            result => result,
        };
        (cells.line, cells.whole) = (self.line, whole);
        result.map_err(|place| self.wrong_cell(place))?;
        Ok(true)
    }

    fn bytes_read(&self) -> u64 {
        self.header.bytes + self.source.position().byte()
    }
}

/// A finite number, or NaN for `NaN` and for nothing.
fn number(text: &[u8]) -> Option<f64> {
    let text = text.trim_ascii();
    if text.is_empty() {
        return Some(f64::NAN);
    }
    let number = str::from_utf8(text).ok()?.parse::<f64>().ok()?;
    (!number.is_infinite()).then_some(number)
}
