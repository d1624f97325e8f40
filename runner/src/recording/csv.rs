//! Recordings as text: columns with a header, read row by row in memory that does not grow with the file.

mod header;
mod source;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::collections::VecDeque;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use ::csv::{ByteRecord, ReaderBuilder, Terminator};

use self::header::{Header, shortened};
use self::source::{Source, failed};
use super::clock::{Grid, LEARN, Place};
use super::error::RecordingError;
use super::flaws::{Flaw, FlawLedger, Position};
use super::probe::{ProbeWatch, Verdict};
use super::{Row, mat};
use crate::scene::{Clock, Probe, Recording, Rotation};

/// Whether a file begins so; it stands at its beginning afterwards.
fn begins_with(file: &mut File, magic: &[u8]) -> std::io::Result<bool> {
    let mut found = Vec::new();
    file.by_ref().take(magic.len() as u64).read_to_end(&mut found)?;
    file.seek(SeekFrom::Start(0))?;
    Ok(found == magic)
}

/// Bytes read from the file at once.
const BUFFER: usize = 1 << 16;

/// What a cell that is used may hold.
const ALLOWED: &str = "a number, or NaN or nothing where the reading is missing";

/// The same for someone who writes 0,125.
const ALLOWED_POINT: &str = "a number with a decimal point, or NaN or nothing where the reading is missing";

/// A CSV file, row by row.
///
/// Delimiter (`,` `;` tab `|`) by the header line, which has to be there; blank lines are passed over.
/// What is wrong with single readings, rows and time stamps is entered into [`flaws`](Self::flaws):
///
/// - NaN or nothing in a cell is a missing reading.
/// - In a row that is cut short the last cell that is there counts as cut off too: it may be a part of a number.
/// - A row whose time stamp repeats or goes back is left out. A row whose time stamp is missing is the next sample.
/// - A probe that repeats one reading exactly for 64 samples and 10 ms is stuck: from then until it moves its
///   readings are missing (those before went out as they were, and are counted).
pub struct CsvReader {
    name: PathBuf,
    size: Option<u64>,
    header: Header,
    cells: Cells,
    source: ::csv::Reader<Source>,
    record: ByteRecord,
    /// Line of the row read last.
    line: u64,
    /// Rows read ahead.
    ahead: VecDeque<Parsed>,
    timing: Timing,
    watches: Vec<ProbeWatch>,
    ledger: FlawLedger,
    ended: bool,
}

/// Which cells mean what.
struct Cells {
    probes: Vec<Cell>,
    rotation: Option<Cell>,
    stamp: Option<Cell>,
}

/// A cell that is used, and what one unit of it is in SI.
struct Cell {
    place: usize,
    unit: f64,
    /// Taken off, in SI.
    offset: f64,
}

/// A row before its sample number is known, and how many of its cells are whole.
struct Parsed {
    row: Row,
    whole: usize,
}

/// How rows get their sample number.
enum Timing {
    Rate { rate: f64, next: u64 },
    Stamps(Grid),
}

impl CsvReader {
    /// Opens a file and reads as far as is needed to know its columns and its sampling rate.
    ///
    /// # Errors
    /// No such file, no header, a column of the scene that the file lacks, no row, time stamps without a rate,
    /// a cell that is not a number among the first rows.
    pub fn open(path: &Path, recording: &Recording) -> Result<Self, RecordingError> {
        let unopened = |cause| RecordingError::Open { file: path.into(), cause };
        let mut file = File::open(path).map_err(unopened)?;
        let about = file.metadata().map_err(unopened)?;
        if about.is_dir() {
            return Err(RecordingError::Folder { file: path.into() });
        }
        if about.is_file() && begins_with(&mut file, mat::MAGIC).map_err(unopened)? {
            return Self::from_reader(Box::new(mat::Rows::open(path)?), path, None, recording);
        }
        // A pipe has no size.
        let size = about.is_file().then_some(about.len());
        Self::from_reader(Box::new(file), path, size, recording)
    }

    /// As [`open`](Self::open), from any source of bytes; `name` stands in messages.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_reader(
        reader: Box<dyn Read + Send>,
        name: &Path,
        size: Option<u64>,
        recording: &Recording,
    ) -> Result<Self, RecordingError> {
        let mut reader = BufReader::with_capacity(BUFFER, reader);
        let header = Header::read(&mut reader, name)?;
        let cells = Cells::new(&header, recording, name)?;
        let source = ReaderBuilder::new()
            .delimiter(header.delimiter)
            .has_headers(false)
            .flexible(true)
            // A carriage return before it is trimmed with the cell; left to the parser it upsets the line count.
            .terminator(Terminator::Any(b'\n'))
            .buffer_capacity(BUFFER)
            .from_reader(Source::new(reader));
        let mut reader = Self {
            name: name.into(),
            size,
            line: header.line,
            header,
            cells,
            source,
            record: ByteRecord::new(),
            ahead: VecDeque::new(),
            timing: Timing::Rate { rate: 1.0, next: 0 },
            watches: Vec::new(),
            ledger: FlawLedger::default(),
            ended: false,
        };
        reader.start(recording)?;
        Ok(reader)
    }

    /// Sampling rate, Hz: the scene's, or learned from the first time stamps.
    #[must_use]
    pub fn rate(&self) -> f64 {
        match &self.timing {
            Timing::Rate { rate, .. } => *rate,
            Timing::Stamps(grid) => 1.0 / grid.step(),
        }
    }

    /// Names of all columns of the file.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.header.names
    }

    /// Bytes read, and bytes in all where that is known.
    #[must_use]
    pub fn progress(&self) -> (u64, Option<u64>) {
        (self.header.bytes + self.source.position().byte(), self.size)
    }

    /// What was wrong so far; clipped probes are known at the end only.
    #[must_use]
    pub const fn flaws(&self) -> &FlawLedger {
        &self.ledger
    }

    /// Reads the next sample into `row`, whose memory is used again; false at the end.
    ///
    /// # Errors
    /// A cell that is not a number, a row that is too long, a file that cannot be read further.
    pub fn next_row(&mut self, row: &mut Row) -> Result<bool, RecordingError> {
        while let Some(whole) = self.fetch(row)? {
            if self.place(row)? {
                self.inspect(row, whole);
                return Ok(true);
            }
        }
        self.end();
        Ok(false)
    }

    fn start(&mut self, recording: &Recording) -> Result<(), RecordingError> {
        let rows = if self.cells.stamp.is_some() { LEARN } else { 1 };
        while self.ahead.len() < rows {
            let Some(parsed) = self.parse_new()? else { break };
            self.ahead.push_back(parsed);
        }
        if self.ahead.is_empty() {
            return Err(RecordingError::NoRows { file: self.name.clone() });
        }
        self.timing = match &recording.clock {
            Clock::Rate(rate) => Timing::Rate { rate: *rate, next: 0 },
            Clock::Column(column) => Timing::Stamps(self.learn(column)?),
        };
        self.watches = recording.probes.iter().map(|_| ProbeWatch::new(self.rate())).collect();
        Ok(())
    }

    fn learn(&self, column: &str) -> Result<Grid, RecordingError> {
        let stamps: Vec<f64> = self.ahead.iter().map(|parsed| parsed.row.time).collect();
        Grid::learn(&stamps).map_err(|fault| RecordingError::Clock {
            file: self.name.clone(),
            column: column.into(),
            found: fault.to_string(),
        })
    }

    /// The next row of the file, read ahead or not; gives the number of whole cells.
    fn fetch(&mut self, row: &mut Row) -> Result<Option<usize>, RecordingError> {
        match self.ahead.pop_front() {
            Some(parsed) => {
                *row = parsed.row;
                Ok(Some(parsed.whole))
            }
            None => self.parse(row),
        }
    }

    fn parse_new(&mut self) -> Result<Option<Parsed>, RecordingError> {
        let mut row = Row::default();
        Ok(self.parse(&mut row)?.map(|whole| Parsed { row, whole }))
    }

    fn parse(&mut self, row: &mut Row) -> Result<Option<usize>, RecordingError> {
        if !self.read_record()? {
            return Ok(None);
        }
        let (found, allowed) = (self.record.len(), self.header.names.len());
        if found > allowed {
            return Err(RecordingError::RowTooLong { file: self.name.clone(), line: self.line, found, allowed });
        }
        let mut whole = if found < allowed { found.saturating_sub(1) } else { found };
        let result = match self.cells.parse(&self.record, whole, row) {
            // `-` or `1.2e` right before the end of the file is no wrong cell but half a number.
            Err(place) if place + 1 == allowed && self.source.get_ref().broke_off() => {
                whole = place;
                self.cells.parse(&self.record, whole, row)
            }
            result => result,
        };
        row.line = self.line;
        match result {
            Ok(()) => Ok(Some(whole)),
            Err(place) => Err(self.wrong_cell(place)),
        }
    }

    /// Reads on to the next row that is not blank.
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

    /// Gives the row its sample number and time; false when it is left out.
    fn place(&mut self, row: &mut Row) -> Result<bool, RecordingError> {
        let grid = match &mut self.timing {
            Timing::Rate { rate, next } => {
                row.index = *next;
                row.time = *next as f64 / *rate;
                *next += 1;
                return Ok(true);
            }
            Timing::Stamps(grid) => grid,
        };
        match grid.place(row.time) {
            Place::Next => self.accept(row, 0),
            Place::After(missing) => self.place_after(row, missing)?,
            Place::Repeated => return Ok(self.leave_out(row, Flaw::RepeatedTimeStamp)),
            Place::Backward => return Ok(self.leave_out(row, Flaw::BackwardTimeStamp)),
        }
        Ok(true)
    }

    fn accept(&mut self, row: &mut Row, missing: u64) {
        let Timing::Stamps(grid) = &mut self.timing else { return };
        let due = grid.next_time();
        let unstamped = row.time.is_nan();
        row.index = grid.accept(row.time, missing);
        if unstamped {
            row.time = due;
            self.note_stamp(row, Flaw::MissingValue);
        }
    }

    /// A jump ahead is a gap, unless the row after it goes on as if there had been none.
    fn place_after(&mut self, row: &mut Row, missing: u64) -> Result<(), RecordingError> {
        if self.ahead.is_empty()
            && let Some(parsed) = self.parse_new()?
        {
            self.ahead.push_back(parsed);
        }
        let Timing::Stamps(grid) = &mut self.timing else { return Ok(()) };
        if self.ahead.front().is_some_and(|next| grid.skips_one(next.row.time)) {
            row.time = grid.next_time();
            row.index = grid.accept(f64::NAN, 0);
            self.note_stamp(row, Flaw::StrayTimeStamp);
            return Ok(());
        }
        self.accept(row, missing);
        self.ledger.record(Flaw::Gap, None, Position::from(&*row), missing);
        Ok(())
    }

    fn leave_out(&mut self, row: &mut Row, flaw: Flaw) -> bool {
        if let Timing::Stamps(grid) = &self.timing {
            row.index = grid.next().saturating_sub(1);
        }
        self.note_stamp(row, flaw);
        false
    }

    fn note_stamp(&mut self, row: &Row, flaw: Flaw) {
        let column = self.cells.stamp.as_ref().map(|cell| self.header.names[cell.place].as_str());
        self.ledger.record(flaw, column, Position::from(row), 1);
    }

    /// Enters what the row lacks and takes away what a stuck probe says.
    fn inspect(&mut self, row: &mut Row, whole: usize) {
        let at = Position::from(&*row);
        let ledger = &mut self.ledger;
        if whole < self.header.names.len() {
            ledger.record(Flaw::ShortRow, None, at, 1);
        }
        let name = |cell: &Cell| self.header.names[cell.place].as_str();
        for ((cell, reading), watch) in self.cells.probes.iter().zip(&mut row.probes).zip(&mut self.watches) {
            if reading.is_nan() {
                if cell.place < whole {
                    ledger.record(Flaw::MissingValue, Some(name(cell)), at, 1);
                }
                continue;
            }
            match watch.see(*reading, at) {
                Verdict::Good => continue,
                Verdict::Stuck { since, samples } => {
                    ledger.record_reading(Flaw::StuckProbe, name(cell), since, samples, *reading);
                }
                Verdict::StillStuck => ledger.lengthen(Flaw::StuckProbe, Some(name(cell))),
            }
            *reading = f64::NAN;
        }
        if let Some(cell) = self.cells.rotation.as_ref().filter(|cell| cell.place < whole)
            && row.rotation.is_nan()
        {
            ledger.record(Flaw::MissingValue, Some(name(cell)), at, 1);
        }
    }

    /// At the end, once: which probes were clipped.
    fn end(&mut self) {
        if core::mem::replace(&mut self.ended, true) {
            return;
        }
        for (cell, watch) in self.cells.probes.iter().zip(&self.watches) {
            for clipped in watch.clipped() {
                let name = &self.header.names[cell.place];
                self.ledger.record_reading(Flaw::ClippedProbe, name, clipped.first, clipped.samples, clipped.reading);
            }
        }
    }

    fn wrong_cell(&self, place: usize) -> RecordingError {
        let found = shortened(self.record.get(place).unwrap_or_default());
        let comma = found.contains(',') && found.replace(',', ".").parse::<f64>().is_ok();
        RecordingError::Cell {
            file: self.name.clone(),
            line: self.line,
            column: self.header.names[place].clone(),
            found,
            allowed: if comma { ALLOWED_POINT } else { ALLOWED },
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

impl Cells {
    fn new(header: &Header, recording: &Recording, file: &Path) -> Result<Self, RecordingError> {
        let cell = |column: &str, unit| header.find(column, file).map(|place| Cell { place, unit, offset: 0.0 });
        let rotation = match &recording.rotation {
            Rotation::Keyphasor { column, .. } => Some(cell(column, 1.0)?),
            Rotation::SpeedColumn { column, radians_per_second } => Some(cell(column, *radians_per_second)?),
            Rotation::Scene => None,
        };
        let stamp = match &recording.clock {
            Clock::Rate(_) => None,
            Clock::Column(column) => Some(cell(column, 1.0)?),
        };
        let probe = |of: &Probe| cell(&of.column, of.metres_per_unit).map(|cell| Cell { offset: of.offset, ..cell });
        let probes = recording.probes.iter().map(probe);
        Ok(Self { probes: probes.collect::<Result<_, _>>()?, rotation, stamp })
    }

    /// Numbers of the first `whole` cells, NaN for the rest; the place of a cell that holds none as error.
    fn parse(&self, record: &ByteRecord, whole: usize, row: &mut Row) -> Result<(), usize> {
        let value = |cell: &Cell| match record.get(cell.place) {
            Some(text) if cell.place < whole => {
                number(text).map(|number| number * cell.unit - cell.offset).ok_or(cell.place)
            }
            _ => Ok(f64::NAN),
        };
        row.time = self.stamp.as_ref().map_or(Ok(0.0), value)?;
        row.rotation = self.rotation.as_ref().map_or(Ok(0.0), value)?;
        row.probes.clear();
        for cell in &self.probes {
            row.probes.push(value(cell)?);
        }
        Ok(())
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
