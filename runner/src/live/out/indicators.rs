//! Indicators of every second in Parquet files of a fixed length, with a journal of the seconds since the last file.
//!
//! A second is on disk once it is in the journal. A full journal is first converted to a Parquet file and then replaced by a
//! new journal, so that a killed process loses nothing. A second is identified by the number of the first sample after it; a
//! second that is already on disk is ignored.

use super::events::is_file_of;
use anyhow::{Context, Result, bail};
use ballrace_twin::folder_lock::FolderLock;
use ballrace_twin::output::{self, AtomicFile};
use ballrace_twin::parquet_table::{self, Column, Values};
use ballrace_twin::record::{ColumnName, SecondRecord, TIME_OF_DAY};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Default length of a file, s.
pub const HOUR: usize = 3600;
/// Maximum number of pending seconds, for example while the disk is full.
const MAX_PENDING: usize = 2 * HOUR;
/// Version of the journal's format.
const FORMAT_VERSION: u32 = 2;
/// Name of the journal.
pub(super) const JOURNAL: &str = "indicators.journal";

/// Indicator files in a folder that is locked by this process.
pub struct Indicators {
    folder: PathBuf,
    /// Identifier of the monitor's state, stored in the journal; empty without a state.
    owner: String,
    seconds_per_file: usize,
    /// Table of the journal, and the tables after it.
    tables: VecDeque<Table>,
    journal: Journal,
    /// Number of the first sample after the last added second.
    last_index: u64,
    /// Seconds dropped because too many were pending.
    lost: u64,
    /// Sentence about a journal that was damaged.
    damage: Option<String>,
    _lock: FolderLock,
}

/// Seconds of one file.
#[derive(Default)]
pub(super) struct Table {
    pub(super) names: Vec<ColumnName>,
    pub(super) rows: Vec<Row>,
}

/// Indicators of one second.
pub(super) struct Row {
    /// Number of the first sample after the second.
    next_index: u64,
    pub(super) values: Vec<f64>,
}

/// Journal on disk.
struct Journal {
    file: File,
    /// Number of the Parquet file to which it will be converted.
    number: u32,
    /// Length of the header and the complete rows, bytes; an incomplete row may follow.
    length: u64,
    /// Number of complete rows.
    rows: usize,
}

/// First line of the journal, in JSON. Each further line has the number of the first sample after a second, and its values.
#[derive(Serialize, Deserialize)]
pub(super) struct Header {
    #[serde(rename = "form")]
    format_version: u32,
    pub(super) number: u32,
    owner: String,
    /// Number of the first sample after the last second of the previous file.
    after_index: u64,
    columns: Vec<String>,
    /// Units of the columns, where they are not the ends of the names.
    #[serde(default)]
    units: Vec<Option<String>>,
}

impl Indicators {
    /// Opens and locks a folder. A journal of the state `owner` is continued; any other journal is converted to a file.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be read or written, or is locked by another monitor.
    pub fn open(folder: &Path, owner: &str, seconds_per_file: usize) -> Result<Self> {
        let lock = FolderLock::acquire(folder, "indicators.lock")?;
        let path = folder.join(JOURNAL);
        let name = || path.display().to_string();
        let text = match std::fs::metadata(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Ok(metadata) if !metadata.is_file() => bail!("{}: no regular file, expected a journal or no file", name()),
            _ => std::fs::read(&path).with_context(name)?,
        };
        let previous = parse_journal(&text);
        let damage = keep_damaged(&path, &text, previous.as_ref().map_or(0, |(.., length)| *length))?;
        let is_own = |header: &Header| !owner.is_empty() && header.owner == owner;
        let is_converted = |header: &Header| parquet_path(folder, header.number).exists();
        let (table, journal, last_index) = match previous {
            Some((header, table, length)) if is_own(&header) && !is_converted(&header) => {
                let last_index = table.rows.last().map_or(header.after_index, |row| row.next_index);
                let file = OpenOptions::new().write(true).open(&path).with_context(name)?;
                let journal = Journal { file, number: header.number, length: length as u64, rows: table.rows.len() };
                (table, journal, last_index)
            }
            previous => {
                let mut last_index = 0;
                if let Some((header, table, _)) = previous {
                    if is_own(&header) {
                        last_index = table.rows.last().map_or(header.after_index, |row| row.next_index);
                    }
                    if !is_converted(&header) && !table.rows.is_empty() {
                        write_parquet(folder, header.number, &table)?;
                    }
                }
                let table = Table::default();
                let journal = create_journal(folder, next_number(folder)?, owner, last_index, &table)?;
                (table, journal, last_index)
            }
        };
        Ok(Self {
            folder: folder.to_owned(),
            owner: owner.to_owned(),
            seconds_per_file,
            tables: VecDeque::from([table]),
            journal,
            last_index,
            lost: 0,
            damage,
            _lock: lock,
        })
    }

    /// Removes and returns the sentence about a journal that was damaged.
    pub const fn take_damage(&mut self) -> Option<String> {
        self.damage.take()
    }

    /// Adds a second, which [`Indicators::save`] writes; `next_index` is the number of the first sample after it.
    pub fn add(&mut self, second: &SecondRecord, next_index: u64) {
        if next_index <= self.last_index {
            return;
        }
        self.last_index = next_index;
        if self.pending() >= MAX_PENDING as u64 {
            self.lost += 1;
            return;
        }
        let (names, values) = second.columns();
        let fits = |table: &&mut Table| {
            table.rows.is_empty() || (table.names == names && table.rows.len() < self.seconds_per_file)
        };
        let row = Row { next_index, values };
        match self.tables.back_mut().filter(fits) {
            // The header of the journal already has the column names: other columns require a new table.
            Some(table) if table.names == names => table.rows.push(row),
            _ => self.tables.push_back(Table { names, rows: vec![row] }),
        }
    }

    /// Returns the number of seconds that are not on disk yet.
    #[must_use]
    pub fn pending(&self) -> u64 {
        (self.tables.iter().map(|table| table.rows.len()).sum::<usize>() - self.journal.rows) as u64
    }

    /// Returns the number of seconds dropped because too many were pending.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Writes the pending seconds; they are on disk when this returns.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn save(&mut self) -> Result<()> {
        loop {
            self.append_rows()?;
            let is_full = self.tables.front().is_some_and(|table| table.rows.len() >= self.seconds_per_file);
            if !is_full && self.tables.len() == 1 {
                return Ok(());
            }
            self.close_journal()?;
        }
    }

    /// Writes the pending seconds and converts the journal to a file. With a state, an empty journal with the position remains.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn finish(&mut self) -> Result<()> {
        self.save()?;
        if self.journal.rows > 0 {
            self.close_journal()?;
        }
        if self.owner.is_empty() {
            let path = self.folder.join(JOURNAL);
            std::fs::remove_file(&path).with_context(|| path.display().to_string())?;
        }
        Ok(())
    }

    /// Appends the missing rows to the journal.
    fn append_rows(&mut self) -> Result<()> {
        let Some(table) = self.tables.front() else { return Ok(()) };
        let journal = &mut self.journal;
        let Some(missing) = table.rows.get(journal.rows..).filter(|rows| !rows.is_empty()) else { return Ok(()) };
        let path = self.folder.join(JOURNAL);
        let name = || format!("{}: this file cannot be written", path.display());
        if !is_file_of(&journal.file, &path).with_context(name)? {
            // Renamed or deleted: the seconds of its file are in memory.
            let after_index = table.index_before().unwrap_or(self.last_index);
            *journal = create_journal(&self.folder, journal.number, &self.owner, after_index, table)?;
            return Ok(());
        }
        let text: String = missing.iter().map(Row::line).collect();
        let mut write = || {
            // An earlier attempt or a killed run may have left an incomplete row.
            journal.file.set_len(journal.length)?;
            journal.file.seek(SeekFrom::Start(journal.length))?;
            journal.file.write_all(text.as_bytes())?;
            journal.file.sync_data()
        };
        write().with_context(name)?;
        journal.length += text.len() as u64;
        journal.rows = table.rows.len();
        Ok(())
    }

    /// Writes the journal's table to a Parquet file and creates the next journal.
    fn close_journal(&mut self) -> Result<()> {
        let Some(table) = self.tables.front() else { return Ok(()) };
        let path = parquet_path(&self.folder, self.journal.number);
        if !table.rows.is_empty() && !path.exists() {
            write_parquet(&self.folder, self.journal.number, table)?;
        }
        let number = self.journal.number + u32::from(!table.rows.is_empty());
        let after_index = table.rows.last().map(|row| row.next_index);
        let after_index =
            after_index.unwrap_or_else(|| self.tables.get(1).and_then(Table::index_before).unwrap_or(self.last_index));
        let empty = Table::default();
        self.journal =
            create_journal(&self.folder, number, &self.owner, after_index, self.tables.get(1).unwrap_or(&empty))?;
        self.tables.pop_front();
        if self.tables.is_empty() {
            self.tables.push_back(Table::default());
        }
        Ok(())
    }
}

impl Table {
    /// Returns a sample number below that of the first second.
    fn index_before(&self) -> Option<u64> {
        self.rows.first().map(|row| row.next_index.saturating_sub(1))
    }
}

impl Row {
    /// Returns the row as a line of the journal.
    fn line(&self) -> String {
        let cells: String = self.values.iter().map(|x| format!(",{x:e}")).collect();
        format!("{}{cells}\n", self.next_index)
    }
}

/// Keeps a copy of a journal with lines that cannot be read after its first `length` bytes; returns a sentence about it. A
/// killed run leaves an incomplete last line, which is no damage.
///
/// # Errors
/// Returns an error if the copy cannot be written.
fn keep_damaged(path: &Path, content: &[u8], length: usize) -> Result<Option<String>> {
    let rest = content.get(length..).unwrap_or_default();
    if !rest.contains(&b'\n') && (length > 0 || content.is_empty()) {
        return Ok(None);
    }
    let mut name = path.as_os_str().to_owned();
    name.push(".damaged");
    let copy = PathBuf::from(name);
    std::fs::copy(path, &copy).with_context(|| format!("{}: this file cannot be written", copy.display()))?;
    let lines = content.get(..length).unwrap_or_default().iter().filter(|byte| **byte == b'\n').count();
    Ok(Some(format!(
        "The journal {} is damaged after line {lines}: the seconds after it are lost. It is kept as {}.",
        path.display(),
        copy.display()
    )))
}

fn parquet_path(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("indicators-{number:04}.parquet"))
}

/// Returns the number after the highest one of the folder's Parquet files.
fn next_number(folder: &Path) -> Result<u32> {
    let mut highest = 0;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry.with_context(|| folder.display().to_string())?.file_name();
        let number = name.to_str().and_then(|name| name.strip_prefix("indicators-")?.strip_suffix(".parquet"));
        highest = highest.max(number.and_then(|number| number.parse().ok()).unwrap_or(0));
    }
    Ok(highest + 1)
}

/// Replaces the journal with a new one that has the rows of `table`.
fn create_journal(folder: &Path, number: u32, owner: &str, after_index: u64, table: &Table) -> Result<Journal> {
    let header = Header {
        format_version: FORMAT_VERSION,
        number,
        owner: owner.to_owned(),
        after_index,
        columns: table.names.iter().map(|column| column.name.clone()).collect(),
        units: table.names.iter().map(|column| column.unit.clone()).collect(),
    };
    let mut text = serde_json::to_string(&header)? + "\n";
    text.extend(table.rows.iter().map(Row::line));
    let path = folder.join(JOURNAL);
    let file = output::replace(&path, text.as_bytes())
        .with_context(|| format!("{}: this file cannot be written", path.display()))?;
    Ok(Journal { file, number, length: text.len() as u64, rows: table.rows.len() })
}

fn write_parquet(folder: &Path, number: u32, table: &Table) -> Result<()> {
    let column = |(i, of): (usize, &ColumnName)| {
        let values = table.rows.iter().map(|row| row.values.get(i).copied().filter(|x| x.is_finite()));
        if of.name == TIME_OF_DAY {
            return Column::new(&of.name, Values::Time(values.map(|at| at.map(|ms| ms as i64)).collect()));
        }
        let column = Column::new(&of.name, Values::Number(values.collect()));
        match &of.unit {
            Some(unit) => column.with_unit(unit),
            None => column,
        }
    };
    let columns: Vec<Column> = table.names.iter().enumerate().map(column).collect();
    let mut out = AtomicFile::create(&parquet_path(folder, number))?;
    parquet_table::write(&mut out, "indicators", &columns)?;
    Ok(out.finish()?)
}

/// Returns the header of a journal, its complete rows, and the length of both in bytes; `None` without a valid header.
pub(super) fn parse_journal(bytes: &[u8]) -> Option<(Header, Table, usize)> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.split_inclusive('\n').take_while(|line| line.ends_with('\n'));
    let first = lines.next()?;
    let (header, has_index) = match serde_json::from_str::<Header>(first) {
        Ok(header) => (header, true),
        Err(_) => (parse_header_version_1(first)?, false),
    };
    let mut length = first.len();
    let mut rows = vec![];
    for line in lines {
        let (index, cells) = if has_index { line.split_once(',').unwrap_or((line, "")) } else { ("0", line) };
        let values: Result<Vec<f64>, _> = cells.trim_end().split(',').map(str::parse).collect();
        let (Ok(next_index), Ok(values)) = (index.parse(), values) else { break };
        if values.len() != header.columns.len() {
            break;
        }
        rows.push(Row { next_index, values });
        length += line.len();
    }
    let unit = |i: usize| header.units.get(i).cloned().flatten();
    let names = header.columns.iter().enumerate().map(|(i, name)| ColumnName { name: name.clone(), unit: unit(i) });
    let names = names.collect();
    Some((header, Table { names, rows }, length))
}

/// Parses a header of version 1: the file's number and the names of the columns, separated by commas.
fn parse_header_version_1(line: &str) -> Option<Header> {
    let (number, names) = line.trim_end().split_once(',')?;
    let columns = names.split(',').map(str::to_owned).collect();
    Some(Header {
        format_version: 1,
        number: number.parse().ok()?,
        owner: String::new(),
        after_index: 0,
        columns,
        units: vec![],
    })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_twin::replay::second::Second;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use std::time::SystemTime;

    /// A second of 100 samples.
    fn second(time_s: f64) -> Second {
        let probe = ballrace_twin::replay::second::ProbeSecond {
            name: "X,Y".to_owned(),
            mean_um: time_s,
            ..Default::default()
        };
        Second { time_s, probes: vec![probe], ..Second::default() }
    }

    fn add(indicators: &mut Indicators, seconds: impl IntoIterator<Item = u64>) {
        for i in seconds {
            add_second(indicators, i);
            indicators.save().unwrap();
        }
    }

    fn add_second(indicators: &mut Indicators, i: u64) {
        let record = SecondRecord { at: SystemTime::now(), second: &second(i as f64) };
        indicators.add(&record, 100 * i);
    }

    fn times(folder: &Path, number: u32) -> Vec<f64> {
        let reader = SerializedFileReader::new(File::open(parquet_path(folder, number)).unwrap()).unwrap();
        let rows = reader.get_row_iter(None).unwrap();
        rows.map(|row| parquet::record::RowAccessor::get_double(&row.unwrap(), 0).unwrap()).collect()
    }

    fn all_times(folder: &Path) -> Vec<f64> {
        (1..).take_while(|n| parquet_path(folder, *n).exists()).flat_map(|n| times(folder, n)).collect()
    }

    fn seconds(range: std::ops::RangeInclusive<u32>) -> Vec<f64> {
        range.map(f64::from).collect()
    }

    #[test]
    fn full_journals_are_converted_to_files() {
        let folder = tempfile::tempdir().unwrap();
        let mut indicators = Indicators::open(folder.path(), "", 36).unwrap();
        add(&mut indicators, 1..=41);
        indicators.finish().unwrap();
        assert_eq!((times(folder.path(), 1), times(folder.path(), 2)), (seconds(1..=36), seconds(37..=41)));
        assert!(!folder.path().join(JOURNAL).exists());
    }

    #[test]
    #[cfg(unix)]
    fn a_journal_that_is_deleted_is_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(JOURNAL);
        let mut indicators = Indicators::open(folder.path(), "state", 36).unwrap();
        add(&mut indicators, 1..=3);
        std::fs::remove_file(&path).unwrap();
        add(&mut indicators, 4..=5);
        drop(indicators);
        let mut indicators = Indicators::open(folder.path(), "state", 36).unwrap();
        assert!(indicators.take_damage().is_none());
        add(&mut indicators, 1..=6);
        drop(indicators);
        // Lines that cannot be read are kept and reported.
        let whole = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, whole.replacen("400,", "4x0,", 1)).unwrap();
        let mut indicators = Indicators::open(folder.path(), "state", 36).unwrap();
        assert!(indicators.take_damage().is_some_and(|text| text.contains("after line 4")));
        assert!(std::fs::read_to_string(folder.path().join("indicators.journal.damaged")).unwrap().contains("4x0,"));
        add(&mut indicators, 1..=6);
        indicators.finish().unwrap();
        assert_eq!(all_times(folder.path()), seconds(1..=6));
    }

    /// The monitor is killed after every second and gets all seconds again; the folder contains each second once.
    #[test]
    fn a_second_that_is_on_disk_is_not_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        for kill in 1..=20 {
            let mut indicators = Indicators::open(path, "state", 3).unwrap();
            add(&mut indicators, 1..=kill);
            drop(indicators);
            if kill % 2 == 0 {
                // The process was killed while it wrote a row.
                let mut journal = OpenOptions::new().append(true).open(path.join(JOURNAL)).unwrap();
                journal.write_all(b"99900,1.0e0,").unwrap();
            }
        }
        Indicators::open(path, "state", 3).unwrap().finish().unwrap();
        assert_eq!(all_times(path), seconds(1..=20));
        // The position is kept after the end.
        let mut indicators = Indicators::open(path, "state", 3).unwrap();
        add(&mut indicators, 15..=22);
        indicators.finish().unwrap();
        assert_eq!(all_times(path), seconds(1..=22));
    }

    /// The monitor is killed after the Parquet file is written and before the next journal is created.
    #[test]
    fn a_converted_journal_is_not_converted_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let mut indicators = Indicators::open(path, "state", 3).unwrap();
        add(&mut indicators, 1..=2);
        add_second(&mut indicators, 3);
        indicators.append_rows().unwrap();
        let journal = std::fs::read(path.join(JOURNAL)).unwrap();
        indicators.save().unwrap();
        drop(indicators);
        std::fs::write(path.join(JOURNAL), journal).unwrap();
        let mut indicators = Indicators::open(path, "state", 3).unwrap();
        add(&mut indicators, 1..=5);
        indicators.finish().unwrap();
        assert_eq!(all_times(path), seconds(1..=5));
    }

    #[test]
    fn the_journal_of_another_run_is_converted_to_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        for owner in ["", "one", "two", ""] {
            let mut indicators = Indicators::open(path, owner, HOUR).unwrap();
            add(&mut indicators, 1..=3);
        }
        Indicators::open(path, "", HOUR).unwrap().finish().unwrap();
        assert_eq!(all_times(path), [1.0, 2.0, 3.0].repeat(4));
        std::fs::write(path.join(JOURNAL), "0007,time_s,samples\n1e0,100e0\n2e0,1").unwrap();
        Indicators::open(path, "", HOUR).unwrap().finish().unwrap();
        assert_eq!(times(path, 7), [1.0]);
    }

    #[test]
    fn a_folder_that_is_unavailable_for_some_time_loses_no_second() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trend");
        let mut indicators = Indicators::open(&path, "state", 3).unwrap();
        add(&mut indicators, 1..=2);
        let moved = folder.path().join("moved");
        std::fs::rename(&path, &moved).unwrap();
        for i in 3..=8 {
            add_second(&mut indicators, i);
            let _ = indicators.save();
        }
        assert!(indicators.pending() >= 5 && indicators.lost() == 0);
        std::fs::rename(&moved, &path).unwrap();
        indicators.finish().unwrap();
        assert_eq!((all_times(&path), indicators.pending()), (seconds(1..=8), 0));
    }
}
