//! Results of a sweep on disk, line by line: a stopped sweep continues from them, and shards are merged
//! from there.

use super::Chain;
use ballrace_base::output;
use ballrace_plant::error::SweepError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

/// First line of a journal.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    /// Identity of scene, axes and options.
    sweep: String,
}

/// A journal in progress.
pub struct Journal {
    file: File,
    path: PathBuf,
    /// Stored chains by their number.
    pub done: BTreeMap<usize, Chain>,
}

/// Returns the stored chains of a journal.
///
/// # Errors
/// A file that cannot be read, is no journal, or belongs to another sweep.
pub fn read(path: &Path, sweep: &str) -> Result<BTreeMap<usize, Chain>, SweepError> {
    let file = || path.to_owned();
    let text = std::fs::read_to_string(path).map_err(|source| SweepError::Read { file: file(), source })?;
    let mut lines = whole_lines(&text);
    let head: Option<Head> = lines.next().and_then(|line| serde_json::from_str(line).ok());
    let head = head.ok_or_else(|| SweepError::NoJournal { file: file() })?;
    if head.sweep != sweep {
        return Err(SweepError::OtherSweep { file: file() });
    }
    let mut done = BTreeMap::new();
    for (i, line) in lines.enumerate() {
        let chain: Chain =
            serde_json::from_str(line).map_err(|source| SweepError::Line { file: file(), line: i + 2, source })?;
        done.insert(chain.number, chain);
    }
    Ok(done)
}

/// Returns the complete lines: a program that is stopped may leave an incomplete line at the end.
fn whole_lines(text: &str) -> impl Iterator<Item = &str> {
    text.get(..text.rfind('\n').map_or(0, |end| end + 1)).unwrap_or_default().lines()
}

impl Journal {
    /// Opens the journal of `sweep`, an existing or a new one.
    ///
    /// # Errors
    /// As [`read`], or a file that cannot be written.
    pub fn open(path: &Path, sweep: String) -> Result<Self, SweepError> {
        let failed = |source| SweepError::Write { file: path.to_owned(), source };
        let done = if path.exists() { read(path, &sweep)? } else { BTreeMap::new() };
        let mut text = serde_json::to_string(&Head { sweep })? + "\n";
        for chain in done.values() {
            text += &serde_json::to_string(chain)?;
            text.push('\n');
        }
        // Without an incomplete line at the end; stopped at any moment, the finished chains stay on disk.
        let file = output::replace(path, text.as_bytes()).map_err(failed)?;
        Ok(Self { file, path: path.to_owned(), done })
    }

    /// Adds a chain; it is on disk when this returns.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add(&mut self, chain: Chain) -> Result<(), SweepError> {
        let line = serde_json::to_string(&chain)? + "\n";
        // The chain as a reader parses it, so that results do not depend on whether the sweep was stopped in between.
        // A result that cannot be read again, such as NaN, is not written.
        let chain: Chain = serde_json::from_str(line.trim_end()).map_err(SweepError::NotFinite)?;
        let failed = |source| SweepError::Write { file: self.path.clone(), source };
        self.file.write_all(line.as_bytes()).map_err(failed)?;
        self.file.sync_data().map_err(failed)?;
        self.done.insert(chain.number, chain);
        Ok(())
    }
}
