//! Identity of the file of a recording.

use ballrace_base::bounded::open_regular;
use ballrace_base::sha256;
use serde::Serialize;
use std::path::Path;

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
    /// Returns the identity of the file at `path`; none where that is a folder, no regular file, or cannot be read any more.
    #[must_use]
    pub fn of(path: &Path) -> Option<Self> {
        let file = open_regular(path).ok()?;
        let modified = humantime::format_rfc3339_seconds(file.metadata().ok()?.modified().ok()?).to_string();
        let (sha256, bytes) = sha256::of(file).ok()?;
        Some(Self { sha256, bytes, modified })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A recording may be gone at the end of its replay: its result stays.
    #[test]
    fn a_file_that_is_gone_has_no_identity() {
        assert_eq!(RecordingFile::of(Path::new("no such recording.csv")), None);
        assert_eq!(RecordingFile::of(Path::new(".")), None);
    }
}
