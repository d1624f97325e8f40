//! Events as JSON lines.

use super::super::feed::Note;
use crate::replay::limits::Event;
use anyhow::{Context, Result};
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
    /// Opens or begins a log. What a killed program left of a line is cut off, and events of after `done` (s), whose samples
    /// come again, are too.
    ///
    /// # Errors
    /// A file that cannot be read or written.
    pub fn open(path: &Path, done: f64) -> Result<Self> {
        let name = || format!("{}: this log cannot be kept", path.display());
        let kept = kept(path, done).with_context(name)?;
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
fn kept(path: &Path, done: f64) -> std::io::Result<Option<u64>> {
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
        let late = serde_json::from_slice::<serde_json::Value>(&line)
            .ok()
            .and_then(|told| told["time_s"].as_f64())
            .is_some_and(|time| done > 0.0 && time > done);
        if !whole || late {
            break;
        }
        length += line.len() as u64;
        line.clear();
    }
    Ok(Some(length))
}
