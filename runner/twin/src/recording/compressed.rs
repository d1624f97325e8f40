//! Recordings that are compressed as a whole: gzip and Zstandard, around text or a binary format.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::error::RecordingError;

const EXPECTED: &str = "an intact gzip or Zstandard file of a recording";

/// Largest size of a binary file that is unpacked onto the disk, bytes.
const LARGEST: u64 = 8 << 30;

/// Compression of a whole file.
#[derive(Clone, Copy)]
pub(super) enum Compression {
    Gzip,
    Zstandard,
}

impl Compression {
    /// Returns the compression of a file by its first bytes, and rewinds it.
    pub(super) fn of(file: &mut File) -> io::Result<Option<Self>> {
        let mut begin = Vec::new();
        file.take(4).read_to_end(&mut begin)?;
        file.seek(SeekFrom::Start(0))?;
        Ok(match begin.as_slice() {
            [0x1f, 0x8b, 8, _] => Some(Self::Gzip),
            [0x28, 0xb5, 0x2f, 0xfd] => Some(Self::Zstandard),
            _ => None,
        })
    }

    /// Returns the content of a file.
    pub(super) fn unpack(self, file: File, path: &Path) -> Result<Box<dyn Read + Send>, RecordingError> {
        match self {
            Self::Gzip => Ok(Box::new(MultiGzDecoder::new(io::BufReader::new(file)))),
            #[cfg(feature = "zstd")]
            Self::Zstandard => match zstd::Decoder::new(file) {
                Ok(decoder) => Ok(Box::new(decoder)),
                Err(cause) => Err(failed(path, cause)),
            },
            #[cfg(not(feature = "zstd"))]
            Self::Zstandard => Err(RecordingError::Format {
                file: path.into(),
                found: "a file compressed by Zstandard".into(),
                expected: "a program with the feature `zstd`, or a file compressed by gzip",
            }),
        }
    }
}

/// Copies the content of a compressed file to a temporary file, which disappears when it is closed.
pub(super) fn to_file(mut source: impl Read, path: &Path) -> Result<File, RecordingError> {
    let mut file = tempfile::tempfile().map_err(|cause| RecordingError::Open { file: path.into(), cause })?;
    let count = io::copy(&mut source.by_ref().take(LARGEST), &mut file).map_err(|cause| failed(path, cause))?;
    if count == LARGEST {
        let found = format!("{LARGEST} bytes or more when unpacked");
        return Err(RecordingError::Format { file: path.into(), found, expected: "less, or a file that is unpacked" });
    }
    file.seek(SeekFrom::Start(0)).map_err(|cause| RecordingError::Open { file: path.into(), cause })?;
    Ok(file)
}

/// Returns the error of unpacking.
pub(super) fn failed(path: &Path, cause: io::Error) -> RecordingError {
    let found = match cause.kind() {
        io::ErrorKind::UnexpectedEof => "a compressed file that is truncated".into(),
        _ => cause.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
    };
    RecordingError::Format { file: path.into(), found, expected: EXPECTED }
}
