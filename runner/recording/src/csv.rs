//! Recordings as text: columns with a header, read row by row in bounded memory.

mod decimal;
mod header;
mod source;
mod system1;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
mod time;
mod utf16;

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use ::csv::{ByteRecord, ReaderBuilder, Terminator};

use self::decimal::{Ambiguity, DecimalMark};
use self::header::{Header, shortened};
use self::source::{Source, SqueezedBlanks, failed};
use self::time::TimeStamps;
use super::error::RecordingError;
use super::table::{Cells, EXPECTED, Table, TimeOrigin};
use ballrace_scene::FileLayout;

/// Bytes read from the file at once.
const BUFFER: usize = 1 << 16;

/// Values expected in a cell, with a hint about the decimal comma.
const EXPECTED_POINT: &str = "a number with a decimal point, or NaN or nothing where the reading is missing";

/// Opens a text of either form: one table with a header, or an export of System 1.
pub(super) fn open(
    reader: Box<dyn Read + Send>,
    name: &Path,
    layout: FileLayout,
) -> Result<Box<dyn Table>, RecordingError> {
    let (reader, is_utf16) = utf16::decoded(reader).map_err(|cause| failed(name, 0, cause))?;
    let mut reader = BufReader::with_capacity(BUFFER, reader);
    let mut first = Vec::new();
    let read = reader.by_ref().take(system1::BEGIN).read_until(b'\n', &mut first);
    read.map_err(|cause| failed(name, 0, cause))?;
    let is_system1 = system1::begins(&first);
    let whole = BufReader::with_capacity(BUFFER, Box::new(Cursor::new(first).chain(reader)) as Box<dyn Read + Send>);
    if !is_system1 {
        return Ok(Box::new(CsvTable { is_utf16, ..CsvTable::new(whole, name, layout)? }));
    }
    let keys = [("header", layout.is_headless), ("skip", layout.skip.is_some()), ("comment", layout.comment.is_some())];
    if let Some((key, _)) = keys.into_iter().find(|(_, given)| *given) {
        let expected = "only `file` and the columns for an export of System 1";
        return Err(RecordingError::Misplaced { file: name.into(), key, expected });
    }
    Ok(Box::new(system1::open(whole, name)?))
}

/// A CSV file, row by row.
///
/// The delimiter (`,` `;` tab `|`, or blanks without a header), the names and comments are detected from the lines up to the
/// first row. Blank lines are skipped.
struct CsvTable {
    name: PathBuf,
    header: Header,
    /// Number of names up to the last one that is not empty: a header may end with delimiters.
    least: usize,
    /// Indices of the cells that are used.
    selected: Vec<usize>,
    source: ::csv::Reader<Source>,
    record: ByteRecord,
    /// Line of the row read last.
    line: u64,
    /// Rows read ahead in search of the decimal mark, with their lines.
    ahead: VecDeque<(ByteRecord, u64)>,
    mark: DecimalMark,
    time: Option<TimeStamps>,
    /// The file has two bytes for each character.
    is_utf16: bool,
}

impl CsvTable {
    fn new(
        mut reader: BufReader<Box<dyn Read + Send>>,
        name: &Path,
        layout: FileLayout,
    ) -> Result<Self, RecordingError> {
        let mut header = Header::read(&mut reader, name, layout)?;
        let first = Cursor::new(core::mem::take(&mut header.first_rows));
        let whole = first.chain(reader);
        let whole: Box<dyn Read + Send> =
            if header.delimiter == b' ' { Box::new(SqueezedBlanks::new(whole)) } else { Box::new(whole) };
        let reader = BufReader::with_capacity(BUFFER, whole);
        let source = ReaderBuilder::new()
            .delimiter(header.delimiter)
            .has_headers(false)
            .flexible(true)
            .comment(header.comment)
            // A carriage return before it is trimmed with the cell; the parser would count it as a line.
            .terminator(Terminator::Any(b'\n'))
            .buffer_capacity(BUFFER)
            .from_reader(Source::new(reader));
        let least = header.names.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1);
        let (line, selected, record) = (header.line, Vec::new(), ByteRecord::new());
        let mark = if header.delimiter == b',' { DecimalMark::Point } else { DecimalMark::Unknown };
        let (name, ahead) = (name.into(), VecDeque::new());
        Ok(Self { name, header, least, selected, source, record, line, ahead, mark, time: None, is_utf16: false })
    }

    /// Reads the next row that is not blank.
    fn read_record(&mut self) -> Result<bool, RecordingError> {
        if let Some((record, line)) = self.ahead.pop_front() {
            (self.record, self.line) = (record, line);
            return Ok(true);
        }
        self.read_new_record()
    }

    fn read_new_record(&mut self) -> Result<bool, RecordingError> {
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

    /// Determines the decimal mark from the row at hand, and from those after it where that is ambiguous.
    fn find_mark(&mut self) -> Result<(), RecordingError> {
        let cells = |record: &ByteRecord, selected: &[usize]| {
            DecimalMark::of(selected.iter().filter_map(|place| record.get(*place)))
        };
        let mut found = cells(&self.record, &self.selected);
        if found == Err(Ambiguity) {
            let (record, line) = (self.record.clone(), self.line);
            while found == Err(Ambiguity) && self.ahead.len() < decimal::ROWS && self.read_new_record()? {
                self.ahead.push_back((self.record.clone(), self.line));
                match cells(&self.record, &self.selected) {
                    Ok(DecimalMark::Unknown) => {}
                    mark => found = mark,
                }
            }
            (self.record, self.line) = (record, line);
        }
        match found {
            Ok(mark) => self.mark = mark,
            Err(Ambiguity) => {
                let is_ambiguous = |place: &&usize| self.record.get(**place).is_some_and(decimal::is_ambiguous);
                let place = self.selected.iter().find(is_ambiguous).copied().unwrap_or(0);
                return Err(self.wrong_cell(place, decimal::EXPECTED));
            }
        }
        Ok(())
    }

    /// Returns the numbers of the first `whole` cells, NaN for the rest; the error is the index of a cell without a number.
    fn parse(&mut self, whole: usize, values: &mut Vec<f64>) -> Result<(), usize> {
        values.clear();
        for (column, place) in self.selected.iter().enumerate() {
            let value = match (self.record.get(*place), &mut self.time) {
                (Some(text), Some(time)) if *place < whole && column == 0 => time.read(text, self.mark),
                (Some(text), _) if *place < whole => self.mark.number(text),
                _ => Some(f64::NAN),
            };
            values.push(value.ok_or(*place)?);
        }
        Ok(())
    }

    fn wrong_cell(&self, place: usize, expected: &'static str) -> RecordingError {
        let found = shortened(self.record.get(place).unwrap_or_default());
        let (file, line) = (self.name.clone(), self.line);
        let column = self.header.names.get(place).cloned().unwrap_or_default();
        RecordingError::Cell { file, line, column, found, expected }
    }

    /// Returns the values expected in a cell that has none of them.
    fn expected(&self, place: usize) -> &'static str {
        let found = self.record.get(place).unwrap_or_default();
        if self.time.is_some() && self.selected.first() == Some(&place) {
            return TimeStamps::expected(found);
        }
        match self.mark {
            DecimalMark::Comma if found.contains(&b'.') => decimal::EXPECTED_COMMA,
            _ if DecimalMark::Comma.number(found).is_some() => EXPECTED_POINT,
            _ => EXPECTED,
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

    /// Returns the number of cells without blank ones beyond the header: a row may end with delimiters.
    fn cells(&self) -> usize {
        let (found, expected) = (self.record.len(), self.header.names.len());
        let is_blank = |place: usize| self.record.get(place).is_none_or(|cell| cell.trim_ascii().is_empty());
        if (expected..found).all(is_blank) { found.min(expected) } else { found }
    }
}

impl Table for CsvTable {
    fn columns(&self) -> &[String] {
        &self.header.names
    }

    fn header_line(&self) -> Option<u64> {
        Some(self.header.names_line)
    }

    fn unit(&self, place: usize) -> Option<&str> {
        let unit = self.header.units.get(place)?.trim_matches(['(', ')', '[', ']']).trim();
        (!unit.is_empty()).then_some(unit)
    }

    fn notes(&self) -> Vec<String> {
        self.header.notes.clone()
    }

    fn set_time(&mut self, _place: usize) {
        self.time = Some(TimeStamps::default());
    }

    fn time_origin(&self) -> Option<TimeOrigin> {
        self.time.as_ref()?.origin()
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        self.selected = places.into();
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        if !self.read_record()? {
            return Ok(false);
        }
        if self.mark == DecimalMark::Unknown {
            self.find_mark()?;
        }
        let (found, expected) = (self.cells(), self.header.names.len());
        if found > expected {
            let (file, line, names) = (self.name.clone(), self.line, self.header.names_line);
            let is_first = line == self.header.line + 1;
            return Err(RecordingError::RowTooLong { file, line, found, expected, names: is_first.then_some(names) });
        }
        let mut whole = if found < self.least { found.saturating_sub(1) } else { expected };
        let broke_off = self.ahead.is_empty() && self.source.get_ref().broke_off();
        let result = match self.parse(whole, &mut cells.values) {
            // `-` or `1.2e` at the end of the file is an incomplete number, not a wrong cell.
            Err(place) if place + 1 >= self.least && broke_off => {
                whole = place;
                self.parse(whole, &mut cells.values)
            }
            result => result,
        };
        (cells.line, cells.whole) = (self.line, whole);
        result.map_err(|place| self.wrong_cell(place, self.expected(place)))?;
        Ok(true)
    }

    fn bytes_read(&self) -> u64 {
        (self.header.bytes + self.source.position().byte()) * if self.is_utf16 { 2 } else { 1 }
    }
}
