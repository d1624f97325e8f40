//! Event log in JSON lines.

use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_twin::record::EventRecord;
use std::collections::VecDeque;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};

/// Maximum number of pending lines while the log cannot be written.
const MAX_PENDING: usize = 10_000;

/// File to which events are appended.
///
/// The path names the log: where the file is renamed or deleted, as a rotation of logs does, the next lines go to a new file of
/// this path.
///
/// A line is pending until it is on disk. A line that changes the monitor's state is appended only after [`EventLog::release`]: the
/// monitor first writes it to its state, so that a restart can check whether it was appended.
pub struct EventLog {
    file: File,
    path: PathBuf,
    pending: VecDeque<Line>,
    /// Bytes of the pending lines that are already in the file.
    appended: usize,
    /// Lines dropped because too many were pending.
    lost: u64,
}

struct Line {
    text: String,
    /// The line may be appended.
    is_released: bool,
    /// The line has to be written to the monitor's state before it is appended.
    requires_state: bool,
}

impl EventLog {
    /// Opens or creates a log and locks it. An incomplete last line of a killed run is removed. The `unconfirmed` lines that
    /// are missing in the log become pending.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or written, is not an event log, or is locked by another monitor.
    pub fn open(path: &Path, unconfirmed: &[String]) -> Result<Self> {
        let mut missing: Vec<&String> = unconfirmed.iter().collect();
        let file = Self::open_file(path, &mut missing)?;
        let line = |text: &&String| Line { text: (*text).clone(), is_released: true, requires_state: true };
        let pending = missing.iter().map(line).collect();
        Ok(Self { file, path: path.to_owned(), pending, appended: 0, lost: 0 })
    }

    /// Opens the file, and removes the lines that it has from those that are `missing`.
    fn open_file(path: &Path, missing: &mut Vec<&String>) -> Result<File> {
        let name = || format!("{}: this log cannot be written", path.display());
        if std::fs::metadata(path).is_ok_and(|m| !m.is_file()) {
            // The content of a pipe or a device cannot be read for comparison.
            return open_special(path).with_context(name);
        }
        let mut file = OpenOptions::new().create(true).read(true).append(true).open(path).with_context(name)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                bail!(
                    "{}: this log is in use by another process, expected a log without a running monitor",
                    path.display()
                )
            }
            Err(TryLockError::Error(error)) => return Err(error).with_context(name),
        }
        let mut reader = BufReader::new(&mut file);
        let is_log = {
            let content = reader.fill_buf().with_context(name)?;
            LINE_STARTS.iter().any(|start| content.starts_with(start) || start.starts_with(content))
        };
        if !is_log {
            bail!(UsageError(format!("{}: not an event log, expected an event log or a new file", path.display())));
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
        Ok(file)
    }

    /// Reopens the log if its path names another file or none, as after a rotation of logs.
    ///
    /// # Errors
    /// Returns an error if the log cannot be opened, as [`EventLog::open`].
    pub fn reopen(&mut self) -> Result<()> {
        let name = || format!("{}: this log cannot be written", self.path.display());
        if !is_file_of(&self.file, &self.path).with_context(name)? {
            self.file = Self::open_file(&self.path, &mut vec![])?;
            // The new file has no part of the line that the former one lacks.
            self.appended = 0;
        }
        Ok(())
    }

    /// Adds an event to the pending lines.
    ///
    /// # Errors
    /// Returns an error if the event cannot be serialised.
    pub fn add(&mut self, event: &EventRecord) -> Result<()> {
        if self.pending.len() >= MAX_PENDING {
            self.lost += 1;
            return Ok(());
        }
        let requires_state = event.changes_state();
        let text = serde_json::to_string(event)? + "\n";
        self.pending.push_back(Line { text, is_released: !requires_state, requires_state });
        Ok(())
    }

    /// Returns the pending lines that change the state, for the monitor's state.
    #[must_use]
    pub fn unconfirmed(&self) -> Vec<String> {
        self.pending.iter().filter(|line| line.requires_state).map(|line| line.text.clone()).collect()
    }

    /// Allows all pending lines to be appended.
    pub fn release(&mut self) {
        self.pending.iter_mut().for_each(|line| line.is_released = true);
    }

    /// Returns the number of dropped lines and the number of pending lines.
    #[must_use]
    pub fn lost_and_pending(&self) -> [u64; 2] {
        [self.lost, self.pending.len() as u64]
    }

    /// Appends the released lines; they are on disk when this returns. After an error, the next call continues an incomplete
    /// line.
    ///
    /// # Errors
    /// Returns an error if the log cannot be written.
    pub fn append(&mut self) -> Result<()> {
        let released = self.pending.iter().take_while(|line| line.is_released).count();
        if released == 0 {
            return Ok(());
        }
        self.reopen()?;
        let bytes: String = self.pending.iter().take(released).map(|line| line.text.as_str()).collect();
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
        self.pending.drain(..released);
        self.appended = 0;
        Ok(())
    }
}

/// Returns `true` if `path` still names the open `file`.
///
/// # Errors
/// Returns an error if the file or its folder cannot be read.
pub(super) fn is_file_of(file: &File, path: &Path) -> std::io::Result<bool> {
    let named = match std::fs::metadata(path) {
        Ok(named) => named,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(false),
        Err(error) => return Err(error),
    };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let open = file.metadata()?;
        Ok((open.dev(), open.ino()) == (named.dev(), named.ino()))
    }
    // Other systems do not rename or delete a file that is open.
    #[cfg(not(unix))]
    {
        let _ = (file, named);
        Ok(true)
    }
}

/// Opens a pipe or a device. A pipe without a reader, or with one that does not read, never blocks the monitor.
#[cfg(unix)]
fn open_special(path: &Path) -> std::io::Result<File> {
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    let is_pipe = std::fs::metadata(path)?.file_type().is_fifo();
    let flags = rustix::fs::OFlags::NONBLOCK.bits();
    // A pipe that is also open for reading stores the events until a reader opens it.
    OpenOptions::new().append(true).read(is_pipe).custom_flags(flags.cast_signed()).open(path)
}

/// Opens a device.
#[cfg(not(unix))]
fn open_special(path: &Path) -> std::io::Result<File> {
    OpenOptions::new().append(true).open(path)
}

/// Starts of the lines of a log, with and without the version of the schema.
const LINE_STARTS: [&[u8]; 2] = [b"{\"schema\":\"ballrace-event-", b"{\"at\":"];

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_twin::outcome::Event;
    use ballrace_twin::record::EventMessage;

    fn event(time_s: f64) -> EventRecord {
        let message = EventMessage { kind: "source-silent", sentence: String::new() };
        EventRecord::new(message, time_s)
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

    fn add(log: &mut EventLog, event: &EventRecord) {
        log.add(event).unwrap();
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
    fn lines_are_only_appended() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.jsonl");
        let mut log = EventLog::open(&path, &[]).unwrap();
        for time in [1.0, 2.0, 3.0] {
            add(&mut log, &event(time));
        }
        assert!(EventLog::open(&path, &[]).is_err_and(|e| e.to_string().contains("in use by another process")));
        drop(log);
        // The process was killed while it wrote a line.
        OpenOptions::new().append(true).open(&path).unwrap().write_all(b"{\"at\":\"20").unwrap();
        add(&mut EventLog::open(&path, &[]).unwrap(), &event(4.0));
        assert_eq!(times(&path), [1.0, 2.0, 3.0, 4.0]);
        // Only the line break is missing.
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.trim_end()).unwrap();
        add(&mut EventLog::open(&path, &[]).unwrap(), &event(2.5));
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
        // The line is incomplete.
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, &text[..text.len() / 2]).unwrap();
        let mut log = EventLog::open(&path, &unconfirmed).unwrap();
        assert_eq!(log.unconfirmed(), unconfirmed);
        log.append().unwrap();
        assert_eq!(times(&path), [1.0]);
    }

    #[test]
    #[cfg(unix)]
    fn a_log_that_is_renamed_or_deleted_is_reopened() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let mut log = EventLog::open(&path("log.jsonl"), &[]).unwrap();
        add(&mut log, &event(1.0));
        std::fs::rename(path("log.jsonl"), path("log.jsonl.1")).unwrap();
        add(&mut log, &event(2.0));
        assert_eq!((times(&path("log.jsonl.1")), times(&path("log.jsonl"))), (vec![1.0], vec![2.0]));
        // The new file is locked, the former one is free.
        assert!(EventLog::open(&path("log.jsonl"), &[]).is_err());
        drop(EventLog::open(&path("log.jsonl.1"), &[]).unwrap());
        std::fs::remove_file(path("log.jsonl")).unwrap();
        log.reopen().unwrap();
        assert_eq!(times(&path("log.jsonl")), [0.0; 0]);
        add(&mut log, &event(3.0));
        assert_eq!(times(&path("log.jsonl")), [3.0]);
        // Copied and truncated, as logrotate does with `copytruncate`.
        std::fs::write(path("log.jsonl"), "").unwrap();
        add(&mut log, &event(4.0));
        assert_eq!(times(&path("log.jsonl")), [4.0]);
        // A file of something else is not written: the line waits.
        std::fs::remove_file(path("log.jsonl")).unwrap();
        std::fs::write(path("log.jsonl"), "notes\n").unwrap();
        log.add(&event(5.0)).unwrap();
        log.release();
        assert!(log.append().is_err_and(|e| e.to_string().contains("not an event log")));
        std::fs::remove_file(path("log.jsonl")).unwrap();
        log.append().unwrap();
        assert_eq!(times(&path("log.jsonl")), [5.0]);
    }

    #[test]
    fn a_line_has_each_key_once() {
        let line = serde_json::to_string(&crossing(1.0)).unwrap();
        assert_eq!(line.matches("\"sentence\"").count(), 1, "{line}");
        assert!(line.contains("Limit crossed."), "{line}");
    }

    #[test]
    fn events_beyond_the_limit_are_counted() {
        let folder = tempfile::tempdir().unwrap();
        let mut log = EventLog::open(&folder.path().join("log.jsonl"), &[]).unwrap();
        (0..MAX_PENDING + 3).for_each(|_| log.add(&event(1.0)).unwrap());
        assert_eq!(log.lost_and_pending(), [3, MAX_PENDING as u64]);
    }

    #[test]
    fn a_file_without_events_is_rejected_and_not_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        for text in ["bearing changed in May", "a\nb\n", "{\"limit\": 3}\n"] {
            std::fs::write(&path, text).unwrap();
            assert!(EventLog::open(&path, &[]).is_err_and(|e| e.to_string().contains("not an event log")), "{text}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
    }
}
