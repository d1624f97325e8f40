//! Reader of recordings in any format: the columns that the scene names, with the sample number and the flaws of each row.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::Row;
use super::chain;
use super::clock::{Grid, LEARN, StampPosition};
use super::csv;
use super::error::{RecordingError, listed, nearest};
use super::files::Files;
use super::flaws::{Flaw, FlawLedger, Position};
use super::format;
use super::instants::Instants;
use super::memory::Memory;
use super::probe::{ProbeWatch, ReadingState};
use super::table::{Cells, Omitted, Table};
use ballrace_base::bounded::open_regular;
use ballrace_base::printable::name;
use ballrace_scene::units;
use ballrace_scene::{Clock, KeyphasorSignal, Probe, Recording, RotationSource, Sequence, TemperatureChannel};

/// Largest relative difference between the sampling rates of file and scene.
const RATE_TOLERANCE: f64 = 1e-3;

/// Least time stamp that counts another unit from 1970, with the unit: more than 3000 years of seconds, milliseconds and so on.
const SINCE_1970: [(f64, &str, &str); 3] =
    [(1e11, "ms", "milliseconds"), (1e14, "us", "microseconds"), (1e17, "ns", "nanoseconds")];

/// Days since 1900 of the years 1970 to 2100, and the largest step of such time stamps: 1 s. Of seconds it is a rate above 80 kHz,
/// hours after the start.
const EXCEL_DAYS: (f64, f64) = (25_569.0, 73_051.0);
const EXCEL_STEP: f64 = 1.0 / 86_400.0;

/// Seconds by which clocks go back at the end of summer time.
const SUMMER_TIME: f64 = 3600.0;

/// A recording of any format, read row by row.
///
/// Flaws of single readings, rows and time stamps are counted in [`flaws`](Self::flaws):
///
/// - A cell that is NaN, infinite, empty or a word such as `OVL` is a missing reading.
/// - In a short row the last cell is missing too: it may be a part of a number.
/// - A row whose time stamp repeats or goes back is omitted. A row whose time stamp is missing is the next sample.
/// - A probe that repeats one reading exactly for 64 samples and 10 ms is stuck: from then until they change, its
///   readings are missing. The equal readings before are returned unchanged and are counted.
pub struct Reader<'a> {
    name: PathBuf,
    size: Option<u64>,
    table: Box<dyn Table + 'a>,
    wanted: Wanted,
    cells: Cells,
    /// Rows read ahead.
    ahead: VecDeque<Parsed>,
    timing: Timing,
    /// Instants of the pulses, where the recording has them in place of a column.
    instants: Option<Instants>,
    /// Detection of stuck and clipped channels: probes, then sensors.
    watches: Vec<ProbeWatch>,
    ledger: FlawLedger,
    ended: bool,
    /// Files of the recording; without paths where that is not a file.
    files: Files,
}

/// Meaning of the columns, in the order of the table's values.
struct Wanted {
    stamp: Option<Column>,
    rotation: Option<Column>,
    /// Speed of every row without a column of it, rad/s.
    speed: Option<f64>,
    probes: Vec<Column>,
    sensors: Vec<Column>,
    temperatures: Vec<Column>,
}

/// A column that is used, with the factor to SI.
struct Column {
    place: usize,
    unit: f64,
    /// Subtracted after the conversion, in SI.
    offset: f64,
}

/// A row before its sample number is known.
struct Parsed {
    row: Row,
    extent: Extent,
}

/// What the file has of a row.
#[derive(Clone, Copy)]
struct Extent {
    /// Number of complete cells.
    whole: usize,
    /// Omitted before the row.
    omitted: Omitted,
}

/// Source of the sample numbers.
enum Timing {
    Rate { rate: f64, next: u64 },
    Stamps(Grid),
}

impl<'a> Reader<'a> {
    /// Opens a file, detects its format from its content, then from its extension, and reads until it has determined the columns
    /// and its sampling rate.
    ///
    /// # Errors
    /// No such file, no header, a column of the scene that the file lacks, no row, time stamps without a rate,
    /// a cell that is not a number among the first rows, a unit or a rate that is not the scene's.
    pub fn open(path: &Path, recording: &Recording) -> Result<Self, RecordingError> {
        let mut files = Files::of(path, recording)?;
        match (files.paths.as_slice(), files.sequence) {
            ([_, _, ..], Some(Sequence::Continuous)) => {
                let (table, size) = chain::open(files, recording.layout)?;
                Self::new(Box::new(table), path, size, recording)
            }
            (_, Some(Sequence::Snapshots)) => Self::open_first(files, recording),
            ([file, ..], _) => {
                let mut reader = Self::open_file(&file.clone(), recording)?;
                reader.files.notes.append(&mut files.notes);
                Ok(reader)
            }
            ([], _) => Err(RecordingError::Folder { file: path.into(), files: 0 }),
        }
    }

    /// Opens the first readable one of several snapshots.
    fn open_first(files: Files, recording: &Recording) -> Result<Self, RecordingError> {
        let mut first_error = None;
        for path in &files.paths {
            match Self::open_file(path, recording) {
                Ok(reader) => return Ok(Self { files, ..reader }),
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        Err(first_error.unwrap_or_else(|| RecordingError::Folder { file: recording.file.clone(), files: 0 }))
    }

    /// Opens one file.
    pub fn open_file(path: &Path, recording: &Recording) -> Result<Self, RecordingError> {
        let unopened = |cause| RecordingError::Open { file: path.into(), cause };
        let file = open_regular(path).map_err(unopened)?;
        let (table, size) = format::open_of_scene(file, path, recording)?;
        Self::new(table, path, size, recording)
    }

    /// Opens any source of CSV text as [`open`](Self::open) does; `name` is its name in messages.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn from_reader(
        reader: Box<dyn Read + Send>,
        name: &Path,
        size: Option<u64>,
        recording: &Recording,
    ) -> Result<Self, RecordingError> {
        Self::new(csv::open(reader, name, recording.layout)?, name, size, recording)
    }

    /// Opens columns in memory as [`open`](Self::open) does, without copying them; `name` is their name in messages.
    ///
    /// # Errors
    /// As [`open`](Self::open); columns of the scene that differ in length.
    pub fn from_columns(
        columns: Vec<(String, &'a [f64])>,
        name: &Path,
        recording: &Recording,
    ) -> Result<Self, RecordingError> {
        let size = columns.iter().map(|(_, values)| size_of_val(*values) as u64).sum();
        Self::new(Box::new(Memory::new(columns, name)), name, Some(size), recording)
    }

    fn new(
        mut table: Box<dyn Table + 'a>,
        name: &Path,
        size: Option<u64>,
        recording: &Recording,
    ) -> Result<Self, RecordingError> {
        let mut wanted = Wanted::new(table.as_ref(), recording, name)?;
        wanted.check_units(table.as_ref(), recording, name)?;
        if let (Some(stamp), Clock::Column { seconds: None, .. }) = (&wanted.stamp, &recording.clock) {
            table.set_time(stamp.place);
        }
        table.select(&wanted.places())?;
        let instants = match &recording.rotation {
            rotation @ RotationSource::Keyphasor { column, signal: KeyphasorSignal::Instants { .. }, .. } => {
                let place = find(table.as_ref(), column, name)?;
                Instants::read(table.as_mut(), place, rotation, name)?
            }
            _ => None,
        };
        let rate = rate(table.as_mut(), recording, name)?;
        if recording.rotation == RotationSource::Synchronous {
            let samples = table.samples_per_revolution();
            let samples = samples.ok_or_else(|| RecordingError::NotSynchronous { file: name.into() })?;
            wanted.speed = rate.map(|rate| TAU * rate / samples);
        }
        let mut reader = Self {
            name: name.into(),
            size,
            table,
            wanted,
            cells: Cells::default(),
            ahead: VecDeque::new(),
            timing: Timing::Rate { rate: rate.unwrap_or(1.0), next: 0 },
            instants,
            watches: Vec::new(),
            ledger: FlawLedger::default(),
            ended: false,
            files: Files::default(),
        };
        reader.start(recording)?;
        Ok(reader)
    }

    /// Returns the sampling rate, Hz: the scene's, or that of the first time stamps.
    #[must_use]
    pub fn rate(&self) -> f64 {
        match &self.timing {
            Timing::Rate { rate, .. } => *rate,
            Timing::Stamps(grid) => 1.0 / grid.step(),
        }
    }

    /// Returns assumptions about the file, for the report.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        [self.files.notes.clone(), self.table.notes()].concat()
    }

    /// Returns the files of a recording of snapshots, of which this reader reads the first readable one.
    #[must_use]
    pub const fn files(&self) -> &Files {
        &self.files
    }

    /// Returns the names of all columns of the file.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        self.table.columns()
    }

    /// Returns the number of bytes read, and the total number where it is known.
    #[must_use]
    pub fn progress(&self) -> (u64, Option<u64>) {
        (self.table.bytes_read(), self.size)
    }

    /// Returns the flaws so far; clipped probes are detected at the end.
    #[must_use]
    pub const fn flaws(&self) -> &FlawLedger {
        &self.ledger
    }

    /// Reads the next sample into `row`, whose memory is used again; false at the end.
    ///
    /// # Errors
    /// A cell that is not a number, a row that is too long, a file that cannot be read further.
    pub fn next_row(&mut self, row: &mut Row) -> Result<bool, RecordingError> {
        while let Some(Extent { whole, omitted }) = self.fetch(row)? {
            if self.place(row, omitted)? {
                let rate = self.rate();
                if let Some(instants) = &mut self.instants {
                    row.rotation = instants.next(row.time, rate);
                }
                self.inspect(row, whole);
                return Ok(true);
            }
        }
        self.end();
        Ok(false)
    }

    fn start(&mut self, recording: &Recording) -> Result<(), RecordingError> {
        let rows = if self.wanted.stamp.is_some() { LEARN } else { 1 };
        while self.ahead.len() < rows {
            let Some(parsed) = self.parse_new()? else { break };
            self.ahead.push_back(parsed);
        }
        if self.ahead.is_empty() {
            return Err(RecordingError::NoRows { file: self.name.clone() });
        }
        self.check_rate(recording)?;
        if let Clock::Column { name: column, .. } = &recording.clock {
            if matches!(recording.clock, Clock::Column { seconds: None, .. }) {
                self.check_seconds(column)?;
            }
            self.timing = Timing::Stamps(self.learn(column)?);
        }
        if let Some(instants) = &self.instants {
            instants.check(self.rate(), &self.name)?;
        }
        self.watches = self.wanted.channels().map(|_| ProbeWatch::new(self.rate())).collect();
        Ok(())
    }

    /// Checks that a rate in the file is the scene's.
    fn check_rate(&self, recording: &Recording) -> Result<(), RecordingError> {
        let (Some(found), Timing::Rate { rate: expected, .. }) = (self.table.rate(), &self.timing) else {
            return Ok(());
        };
        let is_time = matches!(recording.clock, Clock::Column { .. });
        if is_time || (found / expected - 1.0).abs() <= RATE_TOLERANCE {
            return Ok(());
        }
        Err(RecordingError::Rate { file: self.name.clone(), found, expected: *expected })
    }

    /// Checks that stamps which the scene has in seconds are not in another unit.
    fn check_seconds(&self, column: &str) -> Result<(), RecordingError> {
        let stamps = || self.ahead.iter().map(|parsed| parsed.row.time).filter(|time| time.is_finite());
        if self.table.time_origin().is_some() {
            return Ok(());
        }
        let unit = units::unit_in_name(column).filter(|unit| *unit != "s");
        let of_name = unit.map(|unit| (unit, format!("time stamps in {unit} by the name of the column")));
        let since_1970 = || {
            let first = stamps().next()?;
            let (_, unit, name) = SINCE_1970.into_iter().rfind(|(least, _, _)| first >= *least)?;
            Some((unit, format!("time stamps of {first}, {name} since 1970")))
        };
        let days = || {
            let (first, second) = (stamps().next()?, stamps().nth(1)?);
            let is_date = (EXCEL_DAYS.0..EXCEL_DAYS.1).contains(&first) && second - first < EXCEL_STEP;
            is_date.then(|| ("d", format!("time stamps of {first}, days since 1900 as Excel counts them")))
        };
        let Some((unit, found)) = of_name.or_else(since_1970).or_else(days) else { return Ok(()) };
        Err(RecordingError::TimeUnit { file: self.name.clone(), column: column.into(), found, unit: unit.into() })
    }

    fn learn(&self, column: &str) -> Result<Grid, RecordingError> {
        let stamps: Vec<f64> = self.ahead.iter().map(|parsed| parsed.row.time).collect();
        Grid::learn(&stamps).map_err(|fault| RecordingError::Clock {
            file: self.name.clone(),
            column: column.into(),
            found: fault.to_string(),
        })
    }

    /// Sets `row` to the next row of the file, read ahead or not; returns its extent.
    fn fetch(&mut self, row: &mut Row) -> Result<Option<Extent>, RecordingError> {
        match self.ahead.pop_front() {
            Some(parsed) => {
                *row = parsed.row;
                Ok(Some(parsed.extent))
            }
            None => self.parse(row),
        }
    }

    fn parse_new(&mut self) -> Result<Option<Parsed>, RecordingError> {
        let mut row = Row::default();
        Ok(self.parse(&mut row)?.map(|extent| Parsed { row, extent }))
    }

    fn parse(&mut self, row: &mut Row) -> Result<Option<Extent>, RecordingError> {
        if !self.table.next(&mut self.cells)? {
            if let Timing::Rate { rate, next } = self.timing {
                let end = Position { index: next, line: self.cells.line + 1, time: next as f64 / rate };
                let omitted = std::mem::take(&mut self.cells.omitted);
                self.note_omitted(omitted, end);
            }
            return Ok(None);
        }
        // Infinity stands for an overload or for a division by zero, not for a reading.
        for value in self.cells.values.iter_mut().filter(|value| value.is_infinite()) {
            *value = f64::NAN;
        }
        row.line = self.cells.line;
        self.wanted.fill(&self.cells.values, row);
        Ok(Some(Extent { whole: self.cells.whole, omitted: self.cells.omitted }))
    }

    /// Sets sample number and time of the row; returns false where it is omitted.
    fn place(&mut self, row: &mut Row, omitted: Omitted) -> Result<bool, RecordingError> {
        let grid = match &mut self.timing {
            Timing::Rate { rate, next } => {
                row.index = *next + omitted.missing;
                row.time = row.index as f64 / *rate;
                *next = row.index + 1;
                self.note_omitted(omitted, Position::from(&*row));
                return Ok(true);
            }
            Timing::Stamps(grid) => grid,
        };
        match grid.place(row.time) {
            StampPosition::Next => self.accept(row, 0),
            StampPosition::After(missing) => self.place_after(row, missing)?,
            StampPosition::Repeated => return Ok(self.leave_out(row, Flaw::RepeatedTimeStamp)),
            StampPosition::Backward => {
                self.check_summer_time(row)?;
                return Ok(self.leave_out(row, Flaw::BackwardTimeStamp));
            }
        }
        Ok(true)
    }

    fn note_omitted(&mut self, Omitted { missing, damaged }: Omitted, before: Position) {
        if damaged > 0 {
            self.ledger.record(Flaw::DamagedFrame, None, before, damaged);
        }
        if missing > 0 {
            self.ledger.record(Flaw::Gap, None, before, missing);
        }
    }

    /// Checks that stamps without a zone do not go back by one hour and go on from there.
    fn check_summer_time(&mut self, row: &Row) -> Result<(), RecordingError> {
        if self.table.time_origin().is_none_or(|origin| origin.has_zone) {
            return Ok(());
        }
        let Timing::Stamps(grid) = &self.timing else { return Ok(()) };
        let (due, step) = (grid.next_time(), grid.step());
        if (due - row.time - SUMMER_TIME).abs() > 1.5 * step {
            return Ok(());
        }
        if self.ahead.is_empty()
            && let Some(parsed) = self.parse_new()?
        {
            self.ahead.push_back(parsed);
        }
        let rise = self.ahead.front().map(|next| next.row.time - row.time);
        if rise.is_some_and(|rise| rise > 0.0 && rise < 1.5 * step) {
            return Err(RecordingError::SummerTime { file: self.name.clone(), line: row.line });
        }
        Ok(())
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

    /// Adds a row after a jump of the time stamp: a gap, unless the next row continues regularly.
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
        let column = self.wanted.stamp.as_ref().map(|cell| self.table.columns()[cell.place].as_str());
        self.ledger.record(flaw, column, Position::from(row), 1);
    }

    /// Counts missing readings of a row and removes those of a stuck probe.
    fn inspect(&mut self, row: &mut Row, whole: usize) {
        let at = Position::from(&*row);
        let ledger = &mut self.ledger;
        if whole < self.table.columns().len() {
            ledger.record(Flaw::ShortRow, None, at, 1);
        }
        let name = |cell: &Column| self.table.columns()[cell.place].as_str();
        let readings = row.probes.iter_mut().chain(&mut row.sensors);
        for ((cell, reading), watch) in self.wanted.channels().zip(readings).zip(&mut self.watches) {
            if reading.is_nan() {
                if cell.place < whole {
                    ledger.record(Flaw::MissingValue, Some(name(cell)), at, 1);
                }
                continue;
            }
            match watch.see(*reading, at) {
                ReadingState::Good => continue,
                ReadingState::Stuck { since, samples } => {
                    ledger.record_reading(Flaw::StuckProbe, name(cell), since, samples, *reading);
                }
                ReadingState::StillStuck => ledger.lengthen(Flaw::StuckProbe, Some(name(cell))),
            }
            *reading = f64::NAN;
        }
        if let Some(cell) = self.wanted.rotation.as_ref().filter(|cell| cell.place < whole)
            && row.rotation.is_nan()
        {
            ledger.record(Flaw::MissingValue, Some(name(cell)), at, 1);
        }
    }

    /// Records the clipped probes, once, at the end.
    fn end(&mut self) {
        if core::mem::replace(&mut self.ended, true) {
            return;
        }
        for (cell, watch) in self.wanted.channels().zip(&self.watches) {
            for clipped in watch.clipped() {
                let name = self.table.columns()[cell.place].as_str();
                self.ledger.record_reading(Flaw::ClippedProbe, name, clipped.first, clipped.samples, clipped.reading);
            }
        }
    }
}

impl Wanted {
    fn new(table: &dyn Table, recording: &Recording, file: &Path) -> Result<Self, RecordingError> {
        let column = |name: &str, unit| find(table, name, file).map(|place| Column { place, unit, offset: 0.0 });
        let rotation = match &recording.rotation {
            RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. } => None,
            RotationSource::Keyphasor { column: name, .. } | RotationSource::SpeedColumn { column: name, .. } => {
                Some(column(name, recording.rotation.factor().unwrap_or(1.0))?)
            }
            RotationSource::Scene | RotationSource::Synchronous => None,
        };
        let stamp = match &recording.clock {
            Clock::Rate(_) | Clock::Stated | Clock::Number { .. } => None,
            Clock::Column { name, seconds } => Some(column(name, seconds.unwrap_or(1.0))?),
        };
        let probe = |of: &Probe| column(&of.column, of.metres_per_unit).map(|c| Column { offset: of.offset, ..c });
        let probes = recording.probes.iter().map(probe).collect::<Result<_, _>>()?;
        let sensors = recording.sensors.iter().map(|sensor| column(&sensor.column, 1.0)).collect::<Result<_, _>>()?;
        let temperature =
            |of: &TemperatureChannel| column(&of.column, of.kelvins_per_unit).map(|c| Column { offset: -of.zero, ..c });
        let temperatures = recording.temperatures.iter().map(temperature).collect::<Result<_, _>>()?;
        Ok(Self { stamp, rotation, speed: None, probes, sensors, temperatures })
    }

    fn columns(&self) -> impl Iterator<Item = &Column> + Clone {
        self.stamp.iter().chain(&self.rotation).chain(self.channels()).chain(&self.temperatures)
    }

    /// Columns of probes, then of sensors.
    fn channels(&self) -> impl Iterator<Item = &Column> + Clone {
        self.probes.iter().chain(&self.sensors)
    }

    fn places(&self) -> Vec<usize> {
        self.columns().map(|column| column.place).collect()
    }

    /// Checks that a unit in the file is the scene's.
    fn check_units(&self, table: &dyn Table, recording: &Recording, file: &Path) -> Result<(), RecordingError> {
        let check = |column: &Column, meant: &str| match table.unit(column.place) {
            Some(said) if units::contradict(said, meant) => Err(RecordingError::Unit {
                file: file.into(),
                column: table.columns()[column.place].clone(),
                found: said.into(),
                expected: meant.into(),
            }),
            _ => Ok(()),
        };
        if let (Some(stamp), Clock::Column { seconds, .. }) = (&self.stamp, &recording.clock) {
            check(stamp, units::time_name(seconds.unwrap_or(1.0)).unwrap_or("s"))?;
        }
        if let (Some(column), Some(meant)) = (&self.rotation, recording.rotation.unit()) {
            check(column, meant)?;
        }
        for (column, probe) in self.probes.iter().zip(&recording.probes) {
            if let Some(meant) = probe.unit() {
                check(column, meant)?;
            }
        }
        for (column, sensor) in self.sensors.iter().zip(&recording.sensors) {
            check(column, &sensor.unit)?;
        }
        Ok(())
    }

    /// Sets the values of a row: in SI, those of sensors in the unit of the column.
    fn fill(&self, values: &[f64], row: &mut Row) {
        let mut values = values.iter();
        let mut next = |column: &Column| values.next().map_or(f64::NAN, |value| value * column.unit - column.offset);
        row.time = self.stamp.as_ref().map_or(0.0, &mut next);
        row.rotation = self.rotation.as_ref().map_or(self.speed.unwrap_or(0.0), &mut next);
        row.probes.clear();
        row.probes.extend(self.probes.iter().map(&mut next));
        row.sensors.clear();
        row.sensors.extend(self.sensors.iter().map(&mut next));
        row.temperatures.clear();
        row.temperatures.extend(self.temperatures.iter().map(next));
    }
}

/// Returns the sampling rate, Hz, unless it follows from time stamps.
fn rate(table: &mut dyn Table, recording: &Recording, file: &Path) -> Result<Option<f64>, RecordingError> {
    let stated = |found, expected| RecordingError::StatedRate { file: file.into(), found, expected };
    let rate = match &recording.clock {
        Clock::Column { .. } => return Ok(None),
        Clock::Rate(rate) => return Ok(Some(*rate)),
        Clock::Stated => {
            let expected = "rate = \"12.8 kHz\" or `time` in the scene";
            let rate = table.rate().ok_or_else(|| stated("none".into(), expected))?;
            if let Some(column) = table.unrated() {
                return Err(stated(format!("none for `{}`", name(column)), expected));
            }
            rate
        }
        Clock::Number { name, hertz } => {
            let number = table.scalar(name)?.ok_or_else(|| {
                let names = table.scalar_names();
                let found = match names.as_slice() {
                    [] => "rate = \"12.8 kHz\": the file has no single number".to_owned(),
                    names => format!("one of {}", listed(names)),
                };
                RecordingError::AbsentNumber { file: file.into(), number: name.clone(), found }
            })?;
            number * hertz
        }
    };
    if rate.is_finite() && rate > 0.0 {
        return Ok(Some(rate));
    }
    Err(stated(format!("{rate} Hz"), "a rate above 0"))
}

/// Returns the index of a column that the scene names.
fn find(table: &dyn Table, column: &str, file: &Path) -> Result<usize, RecordingError> {
    let names = table.columns();
    let mut places = (0..names.len()).filter(|place| table.is_called(*place, column.trim()));
    match (places.next(), places.next()) {
        (Some(place), None) => Ok(place),
        (Some(_), Some(_)) => {
            Err(RecordingError::ColumnTwice { file: file.into(), line: table.header_line(), column: column.into() })
        }
        (None, _) => Err(table.refusal(column.trim()).unwrap_or_else(|| RecordingError::AbsentColumn {
            file: file.into(),
            line: table.header_line(),
            column: column.into(),
            found: listed(names),
            nearest: nearest(column, names),
        })),
    }
}
