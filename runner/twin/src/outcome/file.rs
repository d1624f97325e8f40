//! Identity of the file of a recording.

use serde::Serialize;
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Bytes that are read at a time.
const BLOCK: usize = 1 << 16;

/// Identity of the file of a recording, from which a report is traced back to its data.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RecordingFile {
    /// SHA-256 of its content, hexadecimal.
    pub sha256: String,
    /// Size, bytes.
    pub bytes: u64,
    /// Time of its last change, UTC, as `2026-11-27T14:03:22Z`: for most recorders the end of the measurement.
    pub modified: String,
}

impl RecordingFile {
    /// Returns the identity of the file at `path`; none where that is no file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn of(path: &Path) -> io::Result<Option<Self>> {
        if !path.is_file() {
            return Ok(None);
        }
        let mut file = File::open(path)?;
        let modified = humantime::format_rfc3339_seconds(file.metadata()?.modified()?).to_string();
        let (mut hash, mut bytes, mut block) = (Sha256::new(), 0, vec![0; BLOCK]);
        loop {
            let read = file.read(&mut block)?;
            if read == 0 {
                break;
            }
            hash.update(&block[..read]);
            bytes += read as u64;
        }
        let mut sha256 = String::new();
        for byte in hash.finalize() {
            // Writing to a string cannot fail.
            let _ = write!(sha256, "{byte:02x}");
        }
        Ok(Some(Self { sha256, bytes, modified }))
    }
}
