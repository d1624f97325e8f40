//! The lines above the rows of a file: delimiter, names and units of the columns.

use std::collections::HashSet;
use std::io::{BufRead, Read};
use std::path::Path;

use super::RecordingError;
use super::decimal::DecimalMark;
use super::source::failed;
use super::time::TimeStamps;
use ballrace_base::output::without_apostrophe;
use ballrace_scene::{FileLayout, units};

/// Largest length of a line that is read ahead, and of all of them.
const LONGEST: usize = 1 << 22;
/// Largest number of lines that are read ahead in search of the first row.
const MOST_LINES: usize = 200;
/// Largest number of lines between the names of the columns and the first row, such as one of units.
const MOST_SUBHEADERS: usize = 8;
/// Marks of lines that are no rows, as loggers write them.
const COMMENTS: [u8; 2] = *b"#%";

/// Delimiters, the most likely first.
const DELIMITERS: [u8; 4] = *b",;\t|";

/// Delimiters in the order in which a row of numbers is tried: a comma may be its decimal mark.
const OF_ROWS: [u8; 4] = *b";\t|,";

/// Content of the lines above the first row.
pub(super) struct Header {
    /// Trimmed names of the columns.
    pub(super) names: Vec<String>,
    /// Units below the names, where the file has a line of them.
    pub(super) units: Vec<String>,
    pub(super) delimiter: u8,
    /// First character of lines that are no rows.
    pub(super) comment: Option<u8>,
    /// Number of lines before the rows.
    pub(super) line: u64,
    /// Number of the line with the names.
    pub(super) names_line: u64,
    /// Bytes before the rows.
    pub(super) bytes: u64,
    /// The rows that are read ahead.
    pub(super) first_rows: Vec<u8>,
    /// Lines that are neither names nor rows, for the report.
    pub(super) notes: Vec<String>,
}

/// A line that is read ahead.
struct Line {
    text: Vec<u8>,
    /// Number of the line.
    number: u64,
}

impl Line {
    fn cells(&self, delimiter: u8) -> Vec<String> {
        names(self.text.trim_ascii_end(), delimiter)
    }

    fn is_blank(&self) -> bool {
        self.text.trim_ascii().is_empty()
    }

    fn begins_with(&self, mark: u8) -> bool {
        self.text.trim_ascii_start().first() == Some(&mark)
    }
}

/// The lines from the first that is not blank to the first row.
struct Lines {
    lines: Vec<Line>,
    /// Index and delimiter of the first row.
    row: Option<(usize, u8)>,
    /// Delimiter of a line `sep=;`.
    delimiter: Option<u8>,
    comment: Option<u8>,
    /// Bytes before the lines.
    bytes: u64,
}

impl Header {
    /// Reads the lines up to the first row.
    ///
    /// The names are those of the first line above the rows that has as many cells as they. Lines above are no rows, nor are
    /// lines of text below, such as one of units. Where no line has as many cells, the names are those of the nearest.
    pub(super) fn read(reader: &mut impl BufRead, file: &Path, layout: FileLayout) -> Result<Self, RecordingError> {
        let lines = Lines::read(reader, file, layout)?;
        let Some(first) = lines.candidates().next() else {
            return Err(RecordingError::Empty { file: file.into() });
        };
        if layout.is_headless {
            return Ok(lines.headless(first));
        }
        let place = match lines.row {
            _ if layout.skip.is_some() => Some((first, None)),
            Some((row, _)) if row == first => lines.commented_names(),
            Some((row, delimiter)) => Some(lines.names_above(row, delimiter)),
            None => Some((first, None)),
        };
        let Some((place, delimiter)) = place.filter(|(place, _)| !lines.has_numbers(*place)) else {
            let line = lines.lines.get(first);
            let (number, text) = line.map_or((0, [].as_slice()), |line| (line.number, line.text.as_slice()));
            return Err(RecordingError::NoHeader { file: file.into(), line: number, found: shortened(text) });
        };
        Ok(lines.split(place, delimiter))
    }
}

impl Lines {
    fn read(reader: &mut impl BufRead, file: &Path, layout: FileLayout) -> Result<Self, RecordingError> {
        let mut found = Self { lines: vec![], row: None, delimiter: None, comment: layout.comment, bytes: 0 };
        let skipped = u64::from(layout.skip.unwrap_or(0));
        let (mut number, mut length) = (0, 0);
        while found.row.is_none() && found.lines.len() < MOST_LINES && length < LONGEST {
            let mut text = Vec::new();
            let read = reader.by_ref().take(LONGEST as u64).read_until(b'\n', &mut text);
            let count = read.map_err(|cause| failed(file, number, cause))?;
            if count == 0 {
                break;
            }
            number += 1;
            if number == 1 && text.starts_with(b"\xEF\xBB\xBF") {
                text.drain(..3);
                found.bytes += 3;
            }
            let has_line = found.lines.iter().any(|line| !line.is_blank());
            if !has_line && text.contains(&0) {
                return Err(RecordingError::NotText { file: file.into(), line: number });
            }
            if !has_line && count == LONGEST {
                return Err(RecordingError::LongLine { file: file.into(), line: number });
            }
            let sep = if layout.skip.is_none() && !has_line { separator(&text) } else { None };
            if number <= skipped || sep.is_some() || (!has_line && text.trim_ascii().is_empty()) {
                found.delimiter = sep.or(found.delimiter);
                found.bytes += text.len() as u64;
                continue;
            }
            length += text.len();
            found.lines.push(Line { text, number });
            found.find_row();
        }
        Ok(found)
    }

    /// Marks the last line as the first row where its first cell that is not empty is a number or a time; a line without
    /// another above has numbers only.
    fn find_row(&mut self) {
        let Some(line) = self.lines.last() else { return };
        if line.is_blank() || self.is_comment(line) {
            return;
        }
        let is_first = self.candidates().count() == 1;
        let delimiters = OF_ROWS.into_iter().filter(|own| self.delimiter.is_none_or(|stated| stated == *own));
        let delimiters = delimiters.chain(self.delimiter).filter(|own| line.text.contains(own));
        let delimiter = delimiters.chain([b',']).find(|delimiter| {
            let cells = line.cells(*delimiter);
            let mut cells = cells.iter().filter(|cell| !cell.is_empty());
            if is_first {
                return cells.all(|cell| is_number(cell, *delimiter));
            }
            cells.next().is_some_and(|cell| is_number(cell, *delimiter) || TimeStamps::is_date(cell.as_bytes()))
        });
        let words = is_first && are_words_numbers(&line.text);
        self.row = delimiter.or(words.then_some(b' ')).map(|delimiter| (self.lines.len() - 1, delimiter));
    }

    /// Indices of the lines that are neither blank nor comments.
    fn candidates(&self) -> impl Iterator<Item = usize> {
        (0..self.lines.len())
            .filter(|place| self.lines.get(*place).is_some_and(|l| !l.is_blank() && !self.is_comment(l)))
    }

    fn is_comment(&self, line: &Line) -> bool {
        match self.comment {
            Some(mark) => line.begins_with(mark),
            None => COMMENTS.iter().any(|mark| line.begins_with(*mark)),
        }
    }

    /// Returns true for a line of numbers only.
    fn has_numbers(&self, place: usize) -> bool {
        let Some(line) = self.lines.get(place).filter(|line| !self.is_comment(line)) else { return false };
        let are_numbers = |delimiter: u8| {
            let cells = line.cells(delimiter);
            cells.iter().any(|cell| !cell.is_empty()) && cells.iter().all(|cell| is_number(cell, delimiter))
        };
        OF_ROWS.into_iter().any(are_numbers) || are_words_numbers(&line.text)
    }

    /// Returns the line of names above the first row, with its delimiter where that is the row's.
    fn names_above(&self, row: usize, delimiter: u8) -> (usize, Option<u8>) {
        let fits =
            |place: &usize| self.fits(*place, row, delimiter) && (delimiter == b';' || !self.begins(*place, b';'));
        let above = || self.candidates().filter(|place| *place < row);
        let of_text = || above().filter(|place| !self.cells(*place, delimiter).iter().any(|c| is_number(c, delimiter)));
        let distinct: Vec<usize> = of_text().filter(fits).filter(|place| self.are_names(*place, delimiter)).collect();
        // The upper ones of lines with a cell or two may be a title or a key with its value.
        let names = if self.width(row, delimiter) > 2 { distinct.first() } else { distinct.last() };
        let found = names.copied().or_else(|| of_text().find(fits)).or_else(|| above().find(fits));
        match found {
            Some(place) => (place, Some(delimiter)),
            None => (of_text().last().or_else(|| above().last()).unwrap_or(0), self.delimiter),
        }
    }

    /// Returns the last comment above the first row if it has as many cells.
    fn commented_names(&self) -> Option<(usize, Option<u8>)> {
        let (row, delimiter) = self.row?;
        let place = (0..row).rfind(|place| self.lines.get(*place).is_some_and(|line| !line.is_blank()))?;
        (delimiter != b' ' && self.fits(place, row, delimiter)).then_some((place, Some(delimiter)))
    }

    fn begins(&self, place: usize, mark: u8) -> bool {
        self.lines.get(place).is_some_and(|line| line.begins_with(mark))
    }

    fn cells(&self, place: usize, delimiter: u8) -> Vec<String> {
        self.lines.get(place).map(|line| line.cells(delimiter)).unwrap_or_default()
    }

    /// Returns the number of cells up to the last that is not empty.
    fn width(&self, place: usize, delimiter: u8) -> usize {
        self.cells(place, delimiter).iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1)
    }

    /// Returns true where the line has as many cells as the row, which may end with empty ones.
    fn fits(&self, place: usize, row: usize, delimiter: u8) -> bool {
        (self.width(row, delimiter)..=self.cells(row, delimiter).len()).contains(&self.width(place, delimiter))
    }

    /// Returns true for cells that are different, not empty and no units.
    fn are_names(&self, place: usize, delimiter: u8) -> bool {
        let mut cells = self.cells(place, delimiter);
        cells.truncate(self.width(place, delimiter));
        let different: HashSet<&String> = cells.iter().collect();
        different.len() == cells.len() && cells.iter().all(|cell| !cell.is_empty()) && !are_units(&cells)
    }

    /// Returns the header with the names of a line, and the rows from the first below it that is not text.
    fn split(self, place: usize, delimiter: Option<u8>) -> Header {
        let line = self.lines.get(place);
        let of_names = || line.map(|line| self.without_mark(line)).unwrap_or_default();
        let delimiter = delimiter.or(self.delimiter).unwrap_or_else(|| self::delimiter(of_names().trim_ascii_end()));
        let names = names(of_names().trim_ascii_end(), delimiter);
        let is_text = |place: &usize| match self.lines.get(*place) {
            Some(line) => {
                let cells = line.cells(delimiter);
                line.is_blank()
                    || self.is_comment(line)
                    || cells.iter().any(|cell| !cell.is_empty()) && !cells.iter().any(|c| is_number(c, delimiter))
            }
            None => false,
        };
        let below = self.row.map_or(0..0, |(row, _)| place + 1..row.max(place + 1));
        let texts = below.clone().take_while(is_text).count();
        let rows = if texts <= MOST_SUBHEADERS || texts == 0 { place + 1 + texts } else { place + 1 };
        let units = below.filter(|line| *line < rows).map(|line| self.cells(line, delimiter));
        let units = units.into_iter().find(|cells| are_units(cells)).unwrap_or_default();
        let is_other =
            |number: &usize| *number != place && self.lines.get(*number).is_some_and(|line| !line.is_blank());
        let others: Vec<&Line> = (0..rows).filter(is_other).filter_map(|other| self.lines.get(other)).collect();
        let notes = note(&others).into_iter().collect();
        let comment = self.mark(rows);
        let (line, names_line) = (self.last_line(rows), line.map_or(0, |line| line.number));
        let bytes = self.bytes + self.lines.iter().take(rows).map(|line| line.text.len() as u64).sum::<u64>();
        let first_rows = self.lines.into_iter().skip(rows).flat_map(|line| line.text).collect();
        Header { names, units, delimiter, comment, line, names_line, bytes, first_rows, notes }
    }

    /// Returns the header of a file whose first line is a row already.
    fn headless(self, first: usize) -> Header {
        let text = self.lines.get(first).map(|line| line.text.clone()).unwrap_or_default();
        let delimiter = self.delimiter.unwrap_or_else(|| numeric_delimiter(&text));
        let squeezed = text.split(|byte| *byte == b' ').filter(|cell| !cell.is_empty()).collect::<Vec<_>>().join(&b' ');
        let row = if delimiter == b' ' { squeezed.as_slice() } else { &text };
        let mut cells = names(row.trim_ascii_end(), delimiter);
        while cells.len() > 1 && cells.last().is_some_and(String::is_empty) {
            cells.pop();
        }
        let names = (0..cells.len()).map(|place| format!("c{place}")).collect();
        let notes = note(&self.lines.iter().take(first).filter(|line| !line.is_blank()).collect::<Vec<_>>());
        let (comment, line) = (self.mark(first), self.last_line(first));
        let bytes = self.bytes + self.lines.iter().take(first).map(|line| line.text.len() as u64).sum::<u64>();
        let first_rows = self.lines.into_iter().skip(first).flat_map(|line| line.text).collect();
        let (units, notes) = (vec![], notes.into_iter().collect());
        Header { names, units, delimiter, comment, line, names_line: line, bytes, first_rows, notes }
    }

    /// Returns the number of lines before this one.
    fn last_line(&self, place: usize) -> u64 {
        let next = self.lines.get(place).map(|line| line.number - 1);
        next.or_else(|| self.lines.last().map(|line| line.number)).unwrap_or(0)
    }

    /// Returns the mark of the comments before this line.
    fn mark(&self, place: usize) -> Option<u8> {
        let begins = |mark: &u8| self.lines.iter().take(place).any(|line| line.begins_with(*mark));
        self.comment.or_else(|| COMMENTS.into_iter().find(begins))
    }

    /// Returns the text of a line without the mark of a comment.
    fn without_mark(&self, line: &Line) -> Vec<u8> {
        let text = line.text.trim_ascii_start();
        let Some((mark, others)) = text.split_first().filter(|_| self.is_comment(line)) else {
            return line.text.clone();
        };
        // In a line such as `#1 DE,#2 NDE` the mark belongs to the names.
        if others.contains(mark) { line.text.clone() } else { others.to_vec() }
    }
}

/// Returns the note on lines that are neither names nor rows.
fn note(lines: &[&Line]) -> Option<String> {
    let first = lines.first()?;
    let text = shortened(&first.text);
    Some(match lines.len() {
        1 => format!("Line {} of the file is no row: `{text}`.", first.number),
        more => format!(
            "{more} lines of the file beside the names of the columns are no rows, the first is line {}: `{text}`.",
            first.number
        ),
    })
}

/// Returns the delimiter of a line such as `sep=;`, which spreadsheets read.
fn separator(line: &[u8]) -> Option<u8> {
    let text = line.trim_ascii();
    let text = text.strip_prefix(b"\"").and_then(|text| text.strip_suffix(b"\"")).unwrap_or(text);
    let (key, value) = text.split_at_checked(4)?;
    match value {
        [delimiter] if key.eq_ignore_ascii_case(b"sep=") && !delimiter.is_ascii_alphanumeric() => Some(*delimiter),
        // The tab is trimmed with the end of the line.
        [] if key.eq_ignore_ascii_case(b"sep=") => Some(b'\t'),
        _ => None,
    }
}

fn is_number(cell: &str, delimiter: u8) -> bool {
    let number = |mark: DecimalMark| mark.number(cell.as_bytes()).is_some();
    !cell.trim().is_empty() && (number(DecimalMark::Point) || delimiter != b',' && number(DecimalMark::Comma))
}

/// Returns true for numbers between blanks.
fn are_words_numbers(text: &[u8]) -> bool {
    let text = String::from_utf8_lossy(text);
    let mut words = text.split_whitespace().peekable();
    words.peek().is_some() && words.all(|word| is_number(word, b','))
}

/// Returns true where most of the cells are units, and the others are short.
fn are_units(cells: &[String]) -> bool {
    const LONGEST_UNIT: usize = 8;
    let known: Vec<&String> = cells.iter().filter(|cell| !cell.is_empty()).collect();
    let units = known.iter().filter(|cell| units::is_unit(cell)).count();
    2 * units > known.len() && known.iter().all(|cell| cell.chars().count() <= LONGEST_UNIT)
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
