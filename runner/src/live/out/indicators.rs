//! Every second's indicators: a Parquet file an hour, and between two of them a journal that survives a kill.

use ballrace_twin::output::AtomicFile;
use ballrace_twin::parquet_table::{self, Column};
use ballrace_twin::replay::second::Second;
use anyhow::{Context, Result};
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Seconds of one file.
const HOUR: usize = 3600;

/// The tables under way.
pub struct Indicators {
    folder: PathBuf,
    journal: File,
    /// Number of the file that the journal will become.
    number: u32,
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Indicators {
    /// Opens a folder. Where a monitor goes on that had come to `done` (s) its journal is taken up, without the seconds of after
    /// that, which come again; else the journal that a killed one left becomes a file of its own.
    ///
    /// # Errors
    /// A folder that cannot be read or written.
    pub fn open(folder: &Path, done: Option<f64>) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let path = folder.join("indicators.journal");
        let text = match std::fs::read_to_string(&path) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => String::new(),
            text => text.with_context(|| path.display().to_string())?,
        };
        let number = (1..).find(|n| !file(folder, *n).exists()).unwrap_or(u32::MAX);
        let (names, rows) = journal(&text, number, done);
        let journal =
            OpenOptions::new().create(true).append(true).open(&path).with_context(|| path.display().to_string())?;
        let mut open = Self { folder: folder.to_owned(), journal, number, names, rows };
        if done.is_none() {
            open.close()?;
        }
        open.begin()?;
        Ok(open)
    }

    /// One second more.
    ///
    /// # Errors
    /// A full disk.
    pub fn add(&mut self, second: &Second) -> Result<()> {
        let (names, values) = row(second);
        if names != self.names {
            // Another scene, or the first second.
            self.close()?;
            self.names = names;
            self.begin()?;
        }
        self.append(&values)?;
        self.rows.push(values);
        if self.rows.len() >= HOUR { self.close() } else { Ok(()) }
    }

    /// What was added is on disk.
    ///
    /// # Errors
    /// A full disk.
    pub fn sync(&self) -> Result<()> {
        self.journal.sync_data().with_context(|| self.folder.display().to_string())
    }

    /// The part of an hour that is left becomes a file too.
    ///
    /// # Errors
    /// A full disk.
    pub fn finish(mut self) -> Result<()> {
        self.close()?;
        std::fs::remove_file(self.folder.join("indicators.journal")).with_context(|| self.folder.display().to_string())
    }

    fn close(&mut self) -> Result<()> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let column = |(i, name): (usize, &String)| {
            let values = self.rows.iter().map(|row| row.get(i).copied().filter(|x| x.is_finite()));
            Column::Number(name.clone(), values.collect())
        };
        let columns: Vec<Column> = self.names.iter().enumerate().map(column).collect();
        let mut out = AtomicFile::create(&file(&self.folder, self.number))?;
        parquet_table::write(&mut out, "indicators", &columns)?;
        out.finish()?;
        self.number += 1;
        self.rows.clear();
        self.begin()
    }

    /// Writes the journal anew from what is held.
    fn begin(&mut self) -> Result<()> {
        self.journal.set_len(0).with_context(|| self.folder.display().to_string())?;
        let head = format!("{:04},{}\n", self.number, self.names.join(","));
        self.journal.write_all(head.as_bytes())?;
        for row in std::mem::take(&mut self.rows) {
            self.append(&row)?;
            self.rows.push(row);
        }
        Ok(())
    }

    fn append(&mut self, row: &[f64]) -> Result<()> {
        let cells: Vec<String> = row.iter().map(|x| format!("{x:e}")).collect();
        let line = cells.join(",") + "\n";
        self.journal.write_all(line.as_bytes()).with_context(|| self.folder.display().to_string())
    }
}

fn file(folder: &Path, number: u32) -> PathBuf {
    folder.join(format!("indicators-{number:04}.parquet"))
}

/// Names and whole rows of a journal of file `number`; none of one whose file was finished.
fn journal(text: &str, number: u32, done: Option<f64>) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.split_inclusive('\n').filter(|line| line.ends_with('\n')).map(str::trim_end);
    let Some((of, names)) = lines.next().and_then(|head| head.split_once(',')) else { return (vec![], vec![]) };
    let names: Vec<String> = names.split(',').map(str::to_owned).collect();
    if of.parse() != Ok(number) {
        return (vec![], vec![]);
    }
    let cells = |line: &str| line.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>().ok();
    let whole = |row: &Vec<f64>| {
        row.len() == names.len() && row.first().is_some_and(|time| done.is_none_or(|done| *time <= done))
    };
    let rows = lines.map_while(cells).take_while(whole).collect();
    (names, rows)
}

/// Names without commas, as the journal's are parted by them.
fn row(second: &Second) -> (Vec<String>, Vec<f64>) {
    let mut all: Vec<(String, f64)> = vec![
        ("time_s".to_owned(), second.time_s),
        ("samples".to_owned(), second.samples as f64),
        ("speed_rpm".to_owned(), second.speed_rpm),
        ("innovation".to_owned(), second.innovation),
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
        all.extend(figures.map(|(figure, value)| (format!("{}_{figure}", p.name.replace(',', ";")), value)));
    }
    for b in &second.bearings {
        let [x, y, z] = b.force_n;
        let figures = [("fx_n", x), ("fy_n", y), ("fz_n", z), ("largest_radial_n", b.largest_radial_n)];
        all.extend(figures.map(|(figure, value)| (format!("{}_{figure}", b.name.replace(',', ";")), value)));
    }
    all.into_iter().unzip()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};

    fn second(time_s: f64) -> Second {
        let probe = ballrace_twin::replay::second::ProbeSecond { name: "X".to_owned(), mean_um: time_s, ..Default::default() };
        Second { time_s, probes: vec![probe], ..Second::default() }
    }

    fn times(folder: &Path, number: u32) -> Vec<f64> {
        let reader = SerializedFileReader::new(File::open(file(folder, number)).unwrap()).unwrap();
        let rows = reader.get_row_iter(None).unwrap();
        rows.map(|row| parquet::record::RowAccessor::get_double(&row.unwrap(), 0).unwrap()).collect()
    }

    #[test]
    fn hours_become_files() {
        let folder = tempfile::tempdir().unwrap();
        let mut open = Indicators::open(folder.path(), None).unwrap();
        (1..=HOUR + 5).for_each(|i| open.add(&second(i as f64)).unwrap());
        open.finish().unwrap();
        assert_eq!(
            (times(folder.path(), 1).len(), times(folder.path(), 2)),
            (HOUR, vec![3601., 3602., 3603., 3604., 3605.])
        );
        assert!(!folder.path().join("indicators.journal").exists());
    }

    #[test]
    fn a_killed_monitor_loses_only_what_was_not_done() {
        let folder = tempfile::tempdir().unwrap();
        let mut open = Indicators::open(folder.path(), None).unwrap();
        (1..=9).for_each(|i| open.add(&second(f64::from(i))).unwrap());
        // Killed in the middle of a line, its state says 7 s.
        drop(open);
        let journal = folder.path().join("indicators.journal");
        let text = std::fs::read_to_string(&journal).unwrap();
        std::fs::write(&journal, &text[..text.len() - 9]).unwrap();
        let mut open = Indicators::open(folder.path(), Some(7.0)).unwrap();
        (8..=10).for_each(|i| open.add(&second(f64::from(i))).unwrap());
        open.finish().unwrap();
        assert_eq!(times(folder.path(), 1), (1..=10).map(f64::from).collect::<Vec<_>>());
    }

    #[test]
    fn one_without_a_state_leaves_its_seconds_too() {
        let folder = tempfile::tempdir().unwrap();
        let mut open = Indicators::open(folder.path(), None).unwrap();
        (1..=3).for_each(|i| open.add(&second(f64::from(i))).unwrap());
        drop(open);
        let mut open = Indicators::open(folder.path(), None).unwrap();
        open.add(&second(1.0)).unwrap();
        open.finish().unwrap();
        assert_eq!((times(folder.path(), 1), times(folder.path(), 2)), (vec![1.0, 2.0, 3.0], vec![1.0]));
    }
}
