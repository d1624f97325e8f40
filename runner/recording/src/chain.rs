//! Files of a continuous recording as one table: the rows of each file follow those of the file before.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::path::{Path, PathBuf};

use super::error::{RecordingError, listed};
use super::files::{Files, shown};
use super::format;
use super::table::{Cells, Table, TimeOrigin};
use ballrace_base::bounded::open_regular;
use ballrace_scene::FileLayout;

/// Largest relative difference between the sampling rates of two files.
const RATE_TOLERANCE: f64 = 1e-3;

const SECONDS_PER_DAY: f64 = 86_400.0;

/// The tables of several files, of which one is open at a time.
pub(super) struct Chain {
    files: Files,
    layout: FileLayout,
    /// Number of the open file.
    at: usize,
    table: Box<dyn Table>,
    columns: Vec<String>,
    selected: Vec<usize>,
    /// Single number of the scene, with its value in the first file.
    number: Option<(String, f64)>,
    time: Option<Time>,
    /// Rows of the open file so far.
    rows: u64,
    /// Bytes of the files before the open one.
    bytes: u64,
    notes: Vec<String>,
}

/// Time stamps over the files.
#[derive(Default)]
struct Time {
    place: usize,
    /// Origin of the first file, once its first row is read.
    origin: Option<Option<TimeOrigin>>,
    /// Added to the stamps of the open file, s.
    offset: f64,
    /// Last time stamp, s.
    last: Option<f64>,
}

/// Opens several files, and returns their size where that is comparable with the bytes read.
pub(super) fn open(files: Files, layout: FileLayout) -> Result<(Chain, Option<u64>), RecordingError> {
    let size = files.paths.iter().map(|path| path.metadata().ok().map(|about| about.len())).sum();
    let first = files.paths.first().map(PathBuf::as_path).unwrap_or(Path::new(""));
    let (table, comparable) = open_table(first, layout)?;
    let (columns, notes) = (table.columns().to_vec(), files.notes.clone());
    let chain = Chain {
        files,
        layout,
        at: 0,
        table,
        columns,
        selected: vec![],
        number: None,
        time: None,
        rows: 0,
        bytes: 0,
        notes,
    };
    Ok((chain, comparable.and(size)))
}

fn open_table(path: &Path, layout: FileLayout) -> Result<(Box<dyn Table>, Option<u64>), RecordingError> {
    let file = open_regular(path).map_err(|cause| RecordingError::Open { file: path.into(), cause })?;
    format::open(file, path, layout)
}

impl Chain {
    fn path(&self, number: usize) -> PathBuf {
        self.files.paths.get(number).cloned().unwrap_or_default()
    }

    /// Adds the notes of the open file that are new.
    fn collect_notes(&mut self) {
        for note in self.table.notes() {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
    }

    /// Opens the next file; returns false after the last.
    fn advance(&mut self) -> Result<bool, RecordingError> {
        let path = self.path(self.at);
        if self.rows == 0 {
            return Err(RecordingError::NoRows { file: path });
        }
        if self.at + 1 >= self.files.paths.len() {
            return Ok(false);
        }
        let (mut next, _) = open_table(&self.path(self.at + 1), self.layout)?;
        self.check(next.as_mut())?;
        if let Some(time) = &self.time {
            next.set_time(time.place);
        }
        next.select(&self.selected)?;
        self.collect_notes();
        self.bytes += self.table.bytes_read();
        self.table = next;
        self.at += 1;
        self.rows = 0;
        Ok(true)
    }

    /// Checks that columns, units and rates of the next file are those of the first.
    fn check(&self, next: &mut dyn Table) -> Result<(), RecordingError> {
        let differs = |subject, found: String, expected: String| RecordingError::Differs {
            file: self.path(self.at + 1),
            first: shown(&self.path(0)).into(),
            subject,
            found: found.into(),
            expected: expected.into(),
        };
        if next.columns() != self.columns {
            return Err(differs("columns", listed(next.columns()), listed(&self.columns)));
        }
        for place in &self.selected {
            let (found, expected) = (next.unit(*place), self.table.unit(*place));
            if found != expected {
                let text = |unit: Option<&str>| {
                    let unit = unit.map_or_else(|| "no unit".to_owned(), |unit| format!("`{unit}`"));
                    format!("{unit} of `{}`", self.columns.get(*place).map_or("", String::as_str))
                };
                return Err(differs("units", text(found), text(expected)));
            }
        }
        let number = match &self.number {
            Some((name, value)) => [next.scalar(name)?, Some(*value)],
            None => [None, None],
        };
        let rates = [
            ("sampling rates", [next.rate(), self.table.rate()]),
            ("samples per revolution", [next.samples_per_revolution(), self.table.samples_per_revolution()]),
            ("numbers for the rate", number),
        ];
        for (subject, [found, expected]) in rates {
            let is_equal = match (found, expected) {
                (Some(found), Some(expected)) => (found / expected - 1.0).abs() <= RATE_TOLERANCE,
                (found, expected) => found.is_none() == expected.is_none(),
            };
            if !is_equal {
                let text = |rate: Option<f64>| rate.map_or_else(|| "none".to_owned(), |rate| rate.to_string());
                return Err(differs(subject, text(found), text(expected)));
            }
        }
        Ok(())
    }

    /// Sets the time stamp of a row from the first row of the first file.
    fn set_stamp(&mut self, cells: &mut Cells) -> Result<(), RecordingError> {
        let (file, first) = (self.path(self.at), shown(&self.path(0)).into());
        let before = self.path(self.at.saturating_sub(1));
        let origin = self.table.time_origin();
        let (Some(time), Some(stamp)) = (&mut self.time, cells.values.first_mut()) else { return Ok(()) };
        if stamp.is_nan() {
            return Ok(());
        }
        if self.rows == 1 {
            let form = |origin: Option<TimeOrigin>| match origin {
                None => "seconds",
                Some(TimeOrigin { has_date: false, .. }) => "times of day",
                Some(TimeOrigin { has_zone: true, .. }) => "dates with a zone",
                Some(_) => "dates without a zone",
            };
            let of_first = *time.origin.get_or_insert(origin);
            if form(origin) != form(of_first) {
                let (found, expected) = (form(origin).into(), form(of_first).into());
                return Err(RecordingError::Differs { file, first, subject: "time stamps", found, expected });
            }
            if let (Some(own), Some(of_first)) = (origin, of_first) {
                time.offset = (own.nanoseconds - of_first.nanoseconds) as f64 / 1e9;
                // A file begins on the day on which its time of day is nearest to the end of the file before.
                if !own.has_date
                    && let Some(end) = time.last
                {
                    time.offset += ((end - time.offset) / SECONDS_PER_DAY).round() * SECONDS_PER_DAY;
                }
            }
        }
        *stamp += time.offset;
        if self.rows == 1
            && let Some(end) = time.last.filter(|end| *stamp <= *end)
        {
            return Err(RecordingError::Order { file, before, found: *stamp, end });
        }
        time.last = Some(time.last.map_or(*stamp, |last| last.max(*stamp)));
        Ok(())
    }
}

impl Table for Chain {
    fn columns(&self) -> &[String] {
        &self.columns
    }

    fn is_called(&self, place: usize, name: &str) -> bool {
        self.table.is_called(place, name)
    }

    fn unit(&self, place: usize) -> Option<&str> {
        self.table.unit(place)
    }

    fn rate(&self) -> Option<f64> {
        self.table.rate()
    }

    fn scalar(&mut self, name: &str) -> Result<Option<f64>, RecordingError> {
        let value = self.table.scalar(name)?;
        self.number = value.map(|value| (name.to_owned(), value));
        Ok(value)
    }

    fn scalar_names(&self) -> Vec<String> {
        self.table.scalar_names()
    }

    fn samples_per_revolution(&self) -> Option<f64> {
        self.table.samples_per_revolution()
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = self.notes.clone();
        notes.extend(self.table.notes().into_iter().filter(|note| !self.notes.contains(note)));
        notes
    }

    fn set_time(&mut self, place: usize) {
        self.time = Some(Time { place, ..Time::default() });
        self.table.set_time(place);
    }

    fn header_line(&self) -> Option<u64> {
        self.table.header_line()
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        self.selected = places.into();
        self.table.select(places)
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        while !self.table.next(cells)? {
            if !self.advance()? {
                return Ok(false);
            }
        }
        self.rows += 1;
        self.set_stamp(cells)?;
        Ok(true)
    }

    fn refusal(&self, name: &str) -> Option<RecordingError> {
        self.table.refusal(name)
    }

    fn unrated(&self) -> Option<&str> {
        self.table.unrated()
    }

    fn bytes_read(&self) -> u64 {
        self.bytes + self.table.bytes_read()
    }
}
