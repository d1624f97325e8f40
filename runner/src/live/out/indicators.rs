//! Every second's indicators: Parquet files of a fixed length, and between two of them a journal that survives a kill.
//!
//! A second is on disk once it is in the journal. A full journal becomes a Parquet file, and only then a new journal takes
//! its place. A second is identified by the number of the first sample after it; one that is on disk already is ignored.

use super::super::lock::FolderLock;
use anyhow::{Context, Result};
use ballrace_twin::output::{self, AtomicFile};
use ballrace_twin::parquet_table::{self, Column};
use ballrace_twin::replay::second::Second;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::fs::{File, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Seconds of one file unless the user chooses otherwise.
pub const HOUR: usize = 3600;
/// Most seconds that wait while the disk is full.
const MOST_WAITING: usize = 2 * HOUR;
/// Form of the journal.
const FORM: u32 = 2;
const JOURNAL: &str = "indicators.journal";

/// Indicators of a folder, which belongs to this process.
pub struct Indicators {
    folder: PathBuf,
    /// The monitor's state that the journal belongs to; empty without a state.
    owner: String,
    seconds_per_file: usize,
    /// The table of the journal, and those after it.
    tables: VecDeque<Table>,
    journal: Journal,
    /// Number of the first sample after the last second that was taken in.
    last_index: u64,
    lost: u64,
    _lock: FolderLock,
}

/// Seconds of one file.
#[derive(Default)]
struct Table {
    names: Vec<String>,
    rows: Vec<Row>,
}

struct Row {
    /// Number of the first sample after the second.
    next_index: u64,
    values: Vec<f64>,
}

/// The journal on disk.
struct Journal {
    file: File,
    /// Number of the Parquet file that it will become.
    number: u32,
    /// Bytes of its complete rows; whatever follows them is unfinished.
    length: u64,
    /// Rows of its table that it has.
    rows: usize,
}

/// First line of the journal, as JSON; then a row a line: the number of the first sample after the second, and its values.
#[derive(Serialize, Deserialize)]
struct Header {
    form: u32,
    number: u32,
    owner: String,
    /// Number of the first sample after the second before this file.
    after_index: u64,
    columns: Vec<String>,
}

impl Indicators {
    /// Opens and locks a folder. The journal of the state `owner` is continued; any other becomes a file of its own.
    ///
    /// # Errors
    /// A folder that cannot be read or written, or that another monitor owns.
    pub fn open(folder: &Path, owner: &str, seconds_per_file: usize) -> Result<Self> {
        let lock = FolderLock::acquire(folder, "indicators.lock")?;
        let path = folder.join(JOURNAL);
        let name = || path.display().to_string();
        let text = match std::fs::read(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            text => text.with_context(name)?,
        };
        let found = parse(&text);
        let is_own = |header: &Header| !owner.is_empty() && header.owner == owner;
        let is_finished = |header: &Header| file(folder, header.number).exists();
        let (table, journal, last_index) = match found {
            Some((header, table, length)) if is_own(&header) && !is_finished(&header) => {
                let last_index = table.rows.last().map_or(header.after_index, |row| row.next_index);
                let file = OpenOptions::new().write(true).open(&path).with_context(name)?;
                let journal = Journal { file, number: header.number, length: length as u64, rows: table.rows.len() };
                (table, journal, last_index)
            }
            found => {
                let mut last_index = 0;
                if let Some((header, table, _)) = found {
                    if is_own(&header) {
                        last_index = table.rows.last().map_or(header.after_index, |row| row.next_index);
                    }
                    if !is_finished(&header) && !table.rows.is_empty() {
                        write_file(folder, header.number, &table)?;
                    }
                }
                let table = Table::default();
                let journal = begin(folder, next_number(folder)?, owner, last_index, &table)?;
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
            _lock: lock,
        })
    }

    /// Takes in a second, to be written by [`Indicators::save`]; `next_index` is the number of the first sample after it.
    pub fn add(&mut self, second: &Second, next_index: u64) {
        if next_index <= self.last_index {
            return;
        }
        self.last_index = next_index;
        if self.waiting() >= MOST_WAITING as u64 {
            self.lost += 1;
            return;
        }
        let (names, values) = row(second);
        let fits = |table: &&mut Table| {
            table.rows.is_empty() || (table.names == names && table.rows.len() < self.seconds_per_file)
        };
        let row = Row { next_index, values };
        match self.tables.back_mut().filter(fits) {
            // The journal's header has the names.
            Some(table) if table.names == names => table.rows.push(row),
            _ => self.tables.push_back(Table { names, rows: vec![row] }),
        }
    }

    /// Seconds that are not on disk yet.
    #[must_use]
    pub fn waiting(&self) -> u64 {
        (self.tables.iter().map(|table| table.rows.len()).sum::<usize>() - self.journal.rows) as u64
    }

    /// Seconds that were given up because too many waited.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Writes what was taken in; it is on disk when this returns.
    ///
    /// # Errors
    /// A full disk.
    pub fn save(&mut self) -> Result<()> {
        loop {
            self.append()?;
            let is_full = self.tables.front().is_some_and(|table| table.rows.len() >= self.seconds_per_file);
            if !is_full && self.tables.len() == 1 {
                return Ok(());
            }
            self.close()?;
        }
    }

    /// Writes the rest as a file too. With a state, an empty journal stays that has the position.
    ///
    /// # Errors
    /// A full disk.
    pub fn finish(&mut self) -> Result<()> {
        self.save()?;
        if self.journal.rows > 0 {
            self.close()?;
        }
        if self.owner.is_empty() {
            let path = self.folder.join(JOURNAL);
            std::fs::remove_file(&path).with_context(|| path.display().to_string())?;
        }
        Ok(())
    }

    /// Appends the rows that the journal does not have.
    fn append(&mut self) -> Result<()> {
        let Some(table) = self.tables.front() else { return Ok(()) };
        let journal = &mut self.journal;
        let Some(missing) = table.rows.get(journal.rows..).filter(|rows| !rows.is_empty()) else { return Ok(()) };
        let text: String = missing.iter().map(Row::line).collect();
        let mut write = || {
            // Removes a row that an earlier attempt, or a run that was killed, left unfinished.
            journal.file.set_len(journal.length)?;
            journal.file.seek(SeekFrom::Start(journal.length))?;
            journal.file.write_all(text.as_bytes())?;
            journal.file.sync_data()
        };
        write().with_context(|| format!("{}: this file cannot be written", self.folder.join(JOURNAL).display()))?;
        journal.length += text.len() as u64;
        journal.rows = table.rows.len();
        Ok(())
    }

    /// Writes the journal's table as a Parquet file and begins the next journal.
    fn close(&mut self) -> Result<()> {
        let Some(table) = self.tables.front() else { return Ok(()) };
        let path = file(&self.folder, self.journal.number);
        if !table.rows.is_empty() && !path.exists() {
            write_file(&self.folder, self.journal.number, table)?;
        }
        let number = self.journal.number + u32::from(!table.rows.is_empty());
        let after = table.rows.last().map(|row| row.next_index);
        let after = after.unwrap_or_else(|| self.tables.get(1).and_then(Table::before).unwrap_or(self.last_index));
        let empty = Table::default();
        self.journal = begin(&self.folder, number, &self.owner, after, self.tables.get(1).unwrap_or(&empty))?;
        self.tables.pop_front();
        if self.tables.is_empty() {
            self.tables.push_back(Table::default());
        }
        Ok(())
    }
}

impl Table {
    /// A position before its first second.
    fn before(&self) -> Option<u64> {
        self.rows.first().map(|row| row.next_index.saturating_sub(1))
    }
}

impl Row {
    fn line(&self) -> String {
        let cells: String = self.values.iter().map(|x| format!(",{x:e}")).collect();
        format!("{}{cells}\n", self.next_index)
    }
}

fn file(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("indicators-{number:04}.parquet"))
}

/// The number after the highest one that the folder has.
fn next_number(folder: &Path) -> Result<u32> {
    let mut highest = 0;
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let name = entry.with_context(|| folder.display().to_string())?.file_name();
        let number = name.to_str().and_then(|name| name.strip_prefix("indicators-")?.strip_suffix(".parquet"));
        highest = highest.max(number.and_then(|number| number.parse().ok()).unwrap_or(0));
    }
    Ok(highest + 1)
}

/// Puts a journal with the rows of `table` in the place of the present one.
fn begin(folder: &Path, number: u32, owner: &str, after_index: u64, table: &Table) -> Result<Journal> {
    let header = Header { form: FORM, number, owner: owner.to_owned(), after_index, columns: table.names.clone() };
    let mut text = serde_json::to_string(&header)? + "\n";
    text.extend(table.rows.iter().map(Row::line));
    let path = folder.join(JOURNAL);
    let file = output::replace(&path, text.as_bytes())
        .with_context(|| format!("{}: this file cannot be written", path.display()))?;
    Ok(Journal { file, number, length: text.len() as u64, rows: table.rows.len() })
}

fn write_file(folder: &Path, number: u32, table: &Table) -> Result<()> {
    let column = |(i, name): (usize, &String)| {
        let values = table.rows.iter().map(|row| row.values.get(i).copied().filter(|x| x.is_finite()));
        Column::Number(name.clone(), values.collect())
    };
    let columns: Vec<Column> = table.names.iter().enumerate().map(column).collect();
    let mut out = AtomicFile::create(&file(folder, number))?;
    parquet_table::write(&mut out, "indicators", &columns)?;
    Ok(out.finish()?)
}

/// Header, complete rows and their bytes of a journal; none where there is no journal.
fn parse(bytes: &[u8]) -> Option<(Header, Table, usize)> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = text.split_inclusive('\n').take_while(|line| line.ends_with('\n'));
    let first = lines.next()?;
    let (header, has_index) = match serde_json::from_str::<Header>(first) {
        Ok(header) => (header, true),
        Err(_) => (first_form(first)?, false),
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
    let names = header.columns.clone();
    Some((header, Table { names, rows }, length))
}

/// The header of the first form: the file's number and the names of the columns, separated by commas.
fn first_form(line: &str) -> Option<Header> {
    let (number, names) = line.trim_end().split_once(',')?;
    let columns = names.split(',').map(str::to_owned).collect();
    Some(Header { form: 1, number: number.parse().ok()?, owner: String::new(), after_index: 0, columns })
}

/// Names and values of the columns.
fn row(second: &Second) -> (Vec<String>, Vec<f64>) {
    let mut all: Vec<(String, f64)> = vec![
        ("time_s".to_owned(), second.time_s),
        ("samples".to_owned(), second.samples as f64),
        ("speed_rpm".to_owned(), second.speed_rpm),
        ("innovation".to_owned(), second.innovation),
        ("status".to_owned(), f64::from(second.status)),
    ];
    for p in &second.probes {
        let figures = [
            ("mean_um", p.mean_um),
            ("peak_to_peak_um", p.peak_to_peak_um),
            ("rms_um", p.rms_um),
            ("crest_factor", p.crest_factor),
            ("kurtosis", p.kurtosis),
            ("residual_rms_um", p.residual_rms_um),
            ("1x_um", p.one_x_um),
            ("1x_phase_lag_deg", p.one_x_phase_lag_deg),
        ];
        all.extend(figures.map(|(figure, value)| (format!("{}_{figure}", p.name), value)));
    }
    for b in &second.bearings {
        let [x, y, z] = b.force_n;
        let figures = [("fx_n", x), ("fy_n", y), ("fz_n", z), ("largest_radial_n", b.largest_radial_n)];
        all.extend(figures.map(|(figure, value)| (format!("{}_{figure}", b.name), value)));
    }
    all.into_iter().unzip()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};

    /// A second of 100 samples.
    fn second(time_s: f64) -> Second {
        let probe = ballrace_twin::replay::second::ProbeSecond {
            name: "X,Y".to_owned(),
            mean_um: time_s,
            ..Default::default()
        };
        Second { time_s, probes: vec![probe], ..Second::default() }
    }

    fn add(to: &mut Indicators, seconds: impl IntoIterator<Item = u64>) {
        for i in seconds {
            to.add(&second(i as f64), 100 * i);
            to.save().unwrap();
        }
    }

    fn times(folder: &Path, number: u32) -> Vec<f64> {
        let reader = SerializedFileReader::new(File::open(file(folder, number)).unwrap()).unwrap();
        let rows = reader.get_row_iter(None).unwrap();
        rows.map(|row| parquet::record::RowAccessor::get_double(&row.unwrap(), 0).unwrap()).collect()
    }

    fn all(folder: &Path) -> Vec<f64> {
        (1..).take_while(|n| file(folder, *n).exists()).flat_map(|n| times(folder, n)).collect()
    }

    fn seconds(range: std::ops::RangeInclusive<u32>) -> Vec<f64> {
        range.map(f64::from).collect()
    }

    #[test]
    fn hours_become_files() {
        let folder = tempfile::tempdir().unwrap();
        let mut open = Indicators::open(folder.path(), "", 36).unwrap();
        add(&mut open, 1..=41);
        open.finish().unwrap();
        assert_eq!((times(folder.path(), 1), times(folder.path(), 2)), (seconds(1..=36), seconds(37..=41)));
        assert!(!folder.path().join(JOURNAL).exists());
    }

    /// Killed after any step of the writing and given every second again, the folder has each second once.
    #[test]
    fn a_second_that_is_on_disk_is_not_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        for kill in 1..=20 {
            let mut open = Indicators::open(path, "state", 3).unwrap();
            add(&mut open, 1..=kill);
            drop(open);
            if kill % 2 == 0 {
                // In the middle of a row.
                let mut journal = OpenOptions::new().append(true).open(path.join(JOURNAL)).unwrap();
                journal.write_all(b"99900,1.0e0,").unwrap();
            }
        }
        Indicators::open(path, "state", 3).unwrap().finish().unwrap();
        assert_eq!(all(path), seconds(1..=20));
        // The position outlives the end.
        let mut open = Indicators::open(path, "state", 3).unwrap();
        add(&mut open, 15..=22);
        open.finish().unwrap();
        assert_eq!(all(path), seconds(1..=22));
    }

    /// Killed between the Parquet file and the next journal.
    #[test]
    fn a_full_journal_whose_file_is_there_is_not_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let mut open = Indicators::open(path, "state", 3).unwrap();
        add(&mut open, 1..=2);
        open.add(&second(3.0), 300);
        open.append().unwrap();
        let journal = std::fs::read(path.join(JOURNAL)).unwrap();
        open.save().unwrap();
        drop(open);
        std::fs::write(path.join(JOURNAL), journal).unwrap();
        let mut open = Indicators::open(path, "state", 3).unwrap();
        add(&mut open, 1..=5);
        open.finish().unwrap();
        assert_eq!(all(path), seconds(1..=5));
    }

    #[test]
    fn the_journal_of_another_run_becomes_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        for owner in ["", "one", "two", ""] {
            let mut open = Indicators::open(path, owner, HOUR).unwrap();
            add(&mut open, 1..=3);
        }
        Indicators::open(path, "", HOUR).unwrap().finish().unwrap();
        assert_eq!(all(path), [1.0, 2.0, 3.0].repeat(4));
        std::fs::write(path.join(JOURNAL), "0007,time_s,samples\n1e0,100e0\n2e0,1").unwrap();
        Indicators::open(path, "", HOUR).unwrap().finish().unwrap();
        assert_eq!(times(path, 7), [1.0]);
    }

    #[test]
    fn a_folder_that_cannot_be_written_costs_nothing_but_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trend");
        let mut open = Indicators::open(&path, "state", 3).unwrap();
        add(&mut open, 1..=2);
        let away = folder.path().join("away");
        std::fs::rename(&path, &away).unwrap();
        for i in 3..=8_u32 {
            open.add(&second(f64::from(i)), u64::from(100 * i));
            let _ = open.save();
        }
        assert!(open.waiting() >= 5 && open.lost() == 0);
        std::fs::rename(&away, &path).unwrap();
        open.finish().unwrap();
        assert_eq!((all(&path), open.waiting()), (seconds(1..=8), 0));
    }
}
