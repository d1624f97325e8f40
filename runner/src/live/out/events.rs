//! Events as JSON lines.

use super::super::feed::Note;
use ballrace_twin::fault::SceneFault;
use ballrace_twin::replay::limits::Event;
use anyhow::{Context, Result, bail};
use serde::Serialize;
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Something that is told.
#[derive(Debug, Clone, Serialize)]
pub struct Told {
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

impl Told {
    /// Of a limit.
    #[must_use]
    pub fn limit(event: Event) -> Self {
        let kind = if event.end_s.is_some() { "limit-ended" } else { "limit-crossed" };
        let time_s = event.end_s.unwrap_or(event.start_s);
        Self { at: now(), time_s, kind, sentence: event.sentence.clone(), limit: Some(event) }
    }

    /// Of a source.
    #[must_use]
    pub fn note(note: Note, time_s: f64) -> Self {
        Self { at: now(), time_s, kind: note.kind, sentence: note.sentence, limit: None }
    }
}

fn now() -> String {
    humantime::format_rfc3339_millis(SystemTime::now()).to_string()
}

/// A file to which events are appended.
pub struct EventLog {
    file: File,
    path: PathBuf,
}

impl EventLog {
    /// Opens or begins a log. What a killed program left of a line is cut off; where a monitor goes on that had come to `done`
    /// (s), so are events of after that, whose samples come again.
    ///
    /// # Errors
    /// A file that cannot be read or written, or holds something else.
    pub fn open(path: &Path, done: Option<f64>) -> Result<Self> {
        let name = || format!("{}: this log cannot be kept", path.display());
        let kept = kept(path, done).with_context(name)?;
        if kept == Some(0) && std::fs::metadata(path).with_context(name)?.len() > 0 && !begins_as_log(path) {
            bail!(SceneFault(format!("{}: found no events, allowed: a log of events, or a new file", path.display())));
        }
        let file = OpenOptions::new().create(true).append(true).open(path).with_context(name)?;
        if let Some(length) = kept {
            file.set_len(length).with_context(name)?;
        }
        Ok(Self { file, path: path.to_owned() })
    }

    /// Appends a line.
    ///
    /// # Errors
    /// A full disk.
    pub fn add(&mut self, told: &Told) -> Result<()> {
        let line = serde_json::to_string(told)? + "\n";
        self.file.write_all(line.as_bytes()).with_context(|| self.path.display().to_string())
    }

    /// What was appended is on disk.
    ///
    /// # Errors
    /// A full disk.
    pub fn sync(&self) -> Result<()> {
        self.file.sync_data().with_context(|| self.path.display().to_string())
    }
}

/// Bytes of the lines to keep; none where there is nothing to cut off.
fn kept(path: &Path, done: Option<f64>) -> std::io::Result<Option<u64>> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error),
    };
    if !file.metadata()?.is_file() {
        return Ok(None);
    }
    let (mut reader, mut line, mut length) = (BufReader::new(file), Vec::new(), 0);
    while reader.read_until(b'\n', &mut line)? > 0 {
        let whole = line.ends_with(b"\n");
        let told = serde_json::from_slice::<serde_json::Value>(&line).ok();
        let time = told.and_then(|told| told["time_s"].as_f64());
        let stays = time.is_some_and(|time| done.is_none_or(|done| time <= done));
        if !whole || !stays {
            break;
        }
        length += line.len() as u64;
        line.clear();
    }
    Ok(Some(length))
}

/// What is about to be cut off are events, whole or in part, and nobody's other file.
fn begins_as_log(path: &Path) -> bool {
    let mut begin = Vec::new();
    let read =
        File::open(path).and_then(|file| std::io::Read::read_to_end(&mut std::io::Read::take(file, 6), &mut begin));
    read.is_ok() && b"{\"at\":".starts_with(&begin)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn told(time_s: f64) -> Told {
        let note = Note { kind: "source-silent", sentence: String::new() };
        Told::note(note, time_s)
    }

    fn times(path: &Path) -> Vec<f64> {
        let text = std::fs::read_to_string(path).unwrap();
        text.lines()
            .map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()["time_s"].as_f64().unwrap())
            .collect()
    }

    #[test]
    fn a_log_goes_on_where_its_monitor_does() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.jsonl");
        let mut log = EventLog::open(&path, None).unwrap();
        for time in [1.0, 2.0, 3.0] {
            log.add(&told(time)).unwrap();
        }
        // Killed in the middle of a line.
        OpenOptions::new().append(true).open(&path).unwrap().write_all(b"{\"at\":\"20").unwrap();
        EventLog::open(&path, None).unwrap().add(&told(4.0)).unwrap();
        assert_eq!(times(&path), [1.0, 2.0, 3.0, 4.0]);
        EventLog::open(&path, Some(2.0)).unwrap().add(&told(2.5)).unwrap();
        assert_eq!(times(&path), [1.0, 2.0, 2.5]);
        EventLog::open(&path, Some(0.0)).unwrap();
        assert_eq!(times(&path), [0.0; 0]);
    }

    #[test]
    fn another_file_is_refused_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        for text in ["bearing changed in May", "a\nb\n", "{\"limit\": 3}\n"] {
            std::fs::write(&path, text).unwrap();
            assert!(EventLog::open(&path, None).is_err_and(|e| e.to_string().contains("no events")), "{text}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
    }
}
