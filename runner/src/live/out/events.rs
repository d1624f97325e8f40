//! Events as JSON lines.

use super::super::feed::Note;
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_twin::outcome::Event;
use serde::Serialize;
use std::collections::VecDeque;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Record of an event.
#[derive(Debug, Clone, Serialize)]
pub struct EventRecord {
    /// On the clock, RFC 3339 in UTC.
    pub at: String,
    /// In the recording's time.
    pub time_s: f64,
    /// `limit-crossed`, `limit-ended`, or what happened to the source.
    pub kind: &'static str,
    /// For people.
    pub sentence: String,
    /// The limit that was crossed.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub limit: Option<Event>,
}

impl EventRecord {
    /// Event of a limit.
    #[must_use]
    pub fn limit(mut event: Event) -> Self {
        let kind = if event.end_s.is_some() { "limit-ended" } else { "limit-crossed" };
        let time_s = event.end_s.unwrap_or(event.start_s);
        // A line has each key once.
        let sentence = std::mem::take(&mut event.sentence);
        Self { at: now(), time_s, kind, sentence, limit: Some(event) }
    }

    /// Event of a source.
    #[must_use]
    pub fn note(note: Note, time_s: f64) -> Self {
        Self { at: now(), time_s, kind: note.kind, sentence: note.sentence, limit: None }
    }
}

fn now() -> String {
    humantime::format_rfc3339_millis(SystemTime::now()).to_string()
}

/// Most lines that wait for a log that cannot be written.
const MOST_WAITING: usize = 10_000;

/// A file to which events are appended.
///
/// A line waits until it is on disk. A line of a limit is appended only after [`EventLog::release`]: the monitor first
/// writes it into its state, so that a restart can find out whether it was appended.
pub struct EventLog {
    file: File,
    path: PathBuf,
    waiting: VecDeque<Line>,
    /// Bytes of the first waiting line that are in the file already.
    appended: usize,
    /// Lines given up because too many waited.
    lost: u64,
}

struct Line {
    text: String,
    /// May be appended.
    is_released: bool,
    /// Has to be in the monitor's state before it is appended.
    needs_state: bool,
}

impl EventLog {
    /// Opens or creates a log and locks it. The last line is removed where it is the unfinished line of a run that was
    /// killed. Those of the lines `unconfirmed` that the log does not have are appended later.
    ///
    /// # Errors
    /// A file that cannot be read or written, that holds something else, or to which another monitor appends.
    pub fn open(path: &Path, unconfirmed: &[String]) -> Result<Self> {
        let name = || format!("{}: this log cannot be written", path.display());
        let mut missing: Vec<&String> = unconfirmed.iter().collect();
        if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
            // A pipe or a device keeps nothing that could be compared.
            let file = OpenOptions::new().append(true).open(path).with_context(name)?;
            return Ok(Self::new(file, path, &missing));
        }
        let mut file = OpenOptions::new().create(true).read(true).append(true).open(path).with_context(name)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                bail!(
                    "{}: this log is in use by another process, allowed: one running monitor for a log",
                    path.display()
                )
            }
            Err(TryLockError::Error(error)) => return Err(error).with_context(name),
        }
        let mut reader = BufReader::new(&mut file);
        let begins_as_log = {
            let begin = reader.fill_buf().with_context(name)?;
            let begin = begin.get(..BEGIN.len()).unwrap_or(begin);
            BEGIN.starts_with(begin)
        };
        if !begins_as_log {
            bail!(UsageError(format!("{}: found no events, allowed: a log of events, or a new file", path.display())));
        }
        let (mut line, mut length) = (Vec::new(), 0);
        while reader.read_until(b'\n', &mut line).with_context(name)? > 0 && line.ends_with(b"\n") {
            missing.retain(|text| text.as_bytes() != line);
            length += line.len() as u64;
            line.clear();
        }
        if serde_json::from_slice::<serde_json::Value>(&line).is_ok() {
            file.write_all(b"\n").with_context(name)?;
            line.push(b'\n');
            missing.retain(|text| text.as_bytes() != line);
        } else if !line.is_empty() {
            file.set_len(length).with_context(name)?;
        }
        Ok(Self::new(file, path, &missing))
    }

    fn new(file: File, path: &Path, missing: &[&String]) -> Self {
        let line = |text: &&String| Line { text: (*text).clone(), is_released: true, needs_state: true };
        let waiting = missing.iter().map(line).collect();
        Self { file, path: path.to_owned(), waiting, appended: 0, lost: 0 }
    }

    /// Takes in an event, to be appended by [`EventLog::append`].
    ///
    /// # Errors
    /// None in practice.
    pub fn add(&mut self, told: &EventRecord) -> Result<()> {
        if self.waiting.len() >= MOST_WAITING {
            self.lost += 1;
            return Ok(());
        }
        let needs_state = told.limit.is_some();
        let text = serde_json::to_string(told)? + "\n";
        self.waiting.push_back(Line { text, is_released: !needs_state, needs_state });
        Ok(())
    }

    /// Lines of limits that are not known to be on disk, for the monitor's state.
    #[must_use]
    pub fn unconfirmed(&self) -> Vec<String> {
        self.waiting.iter().filter(|line| line.needs_state).map(|line| line.text.clone()).collect()
    }

    /// Allows every waiting line to be appended.
    pub fn release(&mut self) {
        self.waiting.iter_mut().for_each(|line| line.is_released = true);
    }

    /// Events that were given up, and those that still wait.
    #[must_use]
    pub fn lost_and_waiting(&self) -> [u64; 2] {
        [self.lost, self.waiting.len() as u64]
    }

    /// Appends the released lines; they are on disk when this returns. A line that a full disk cuts short is continued by
    /// the next call.
    ///
    /// # Errors
    /// A full disk, a reader of a pipe that has gone.
    pub fn append(&mut self) -> Result<()> {
        let released = self.waiting.iter().take_while(|line| line.is_released).count();
        if released == 0 {
            return Ok(());
        }
        let bytes: String = self.waiting.iter().take(released).map(|line| line.text.as_str()).collect();
        let name = || format!("{}: this log cannot be written", self.path.display());
        while let Some(rest) = bytes.as_bytes().get(self.appended..).filter(|rest| !rest.is_empty()) {
            match self.file.write(rest) {
                Ok(0) => return Err(std::io::Error::from(std::io::ErrorKind::WriteZero)).with_context(name),
                Ok(written) => self.appended += written,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error).with_context(name),
            }
        }
        if self.file.metadata().is_ok_and(|m| m.is_file()) {
            self.file.sync_data().with_context(name)?;
        }
        self.waiting.drain(..released);
        self.appended = 0;
        Ok(())
    }
}

/// Every line of a log begins so.
const BEGIN: &[u8] = b"{\"at\":";

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn told(time_s: f64) -> EventRecord {
        let note = Note { kind: "source-silent", sentence: String::new() };
        EventRecord::note(note, time_s)
    }

    fn crossing(start_s: f64) -> EventRecord {
        EventRecord::limit(Event {
            indicator: "rms",
            probe: "X".to_owned(),
            bearing: None,
            start_s,
            end_s: None,
            worst: 2.0,
            worst_s: start_s,
            limit: 1.0,
            unit: "um",
            sentence: "Limit crossed.".to_owned(),
        })
    }

    fn add(log: &mut EventLog, told: &EventRecord) {
        log.add(told).unwrap();
        log.release();
        log.append().unwrap();
    }

    fn times(path: &Path) -> Vec<f64> {
        let text = std::fs::read_to_string(path).unwrap();
        text.lines()
            .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()["time_s"].as_f64().unwrap())
            .collect()
    }

    #[test]
    fn a_log_only_grows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.jsonl");
        let mut log = EventLog::open(&path, &[]).unwrap();
        for time in [1.0, 2.0, 3.0] {
            add(&mut log, &told(time));
        }
        assert!(EventLog::open(&path, &[]).is_err_and(|e| e.to_string().contains("in use by another process")));
        drop(log);
        // Killed in the middle of a line.
        OpenOptions::new().append(true).open(&path).unwrap().write_all(b"{\"at\":\"20").unwrap();
        add(&mut EventLog::open(&path, &[]).unwrap(), &told(4.0));
        assert_eq!(times(&path), [1.0, 2.0, 3.0, 4.0]);
        // Killed before the end of a line only.
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.trim_end()).unwrap();
        add(&mut EventLog::open(&path, &[]).unwrap(), &told(2.5));
        assert_eq!(times(&path), [1.0, 2.0, 3.0, 4.0, 2.5]);
    }

    #[test]
    fn lines_of_the_state_are_appended_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.jsonl");
        let mut log = EventLog::open(&path, &[]).unwrap();
        log.add(&crossing(1.0)).unwrap();
        let unconfirmed = log.unconfirmed();
        log.append().unwrap();
        assert_eq!(times(&path), [0.0; 0], "appended before it was released");
        drop(log);
        for _ in 0..3 {
            let mut log = EventLog::open(&path, &unconfirmed).unwrap();
            log.append().unwrap();
            assert_eq!(times(&path), [1.0]);
        }
        // Cut short in the middle of its line.
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        let mut log = EventLog::open(&path, &unconfirmed).unwrap();
        assert_eq!(log.unconfirmed(), unconfirmed);
        log.append().unwrap();
        assert_eq!(times(&path), [1.0]);
    }

    #[test]
    fn a_line_has_no_key_twice() {
        let line = serde_json::to_string(&crossing(1.0)).unwrap();
        assert_eq!(line.matches("\"sentence\"").count(), 1, "{line}");
        assert!(line.contains("Limit crossed."), "{line}");
    }

    #[test]
    fn events_beyond_the_bound_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let mut log = EventLog::open(&folder.path().join("log.jsonl"), &[]).unwrap();
        (0..MOST_WAITING + 3).for_each(|_| log.add(&told(1.0)).unwrap());
        assert_eq!(log.lost_and_waiting(), [3, MOST_WAITING as u64]);
    }

    #[test]
    fn another_file_is_refused_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        for text in ["bearing changed in May", "a\nb\n", "{\"limit\": 3}\n"] {
            std::fs::write(&path, text).unwrap();
            assert!(EventLog::open(&path, &[]).is_err_and(|e| e.to_string().contains("no events")), "{text}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
    }
}
