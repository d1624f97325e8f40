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
/// Size up to which a file may have any ratio of compression, bytes, and the largest ratio of a larger one: measured noise
/// compresses less.
const SMALL: u64 = 1 << 30;
const TIGHTEST: u64 = 100;
/// Bytes that are written between two checks of the free space.
const STEP: u64 = 16 << 20;

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
///
/// # Errors
/// A content of more than [`largest`] bytes of `packed` ones, or of more than half of the free space.
pub(super) fn to_file(source: impl Read, path: &Path, packed: u64) -> Result<File, RecordingError> {
    let mut file = tempfile::tempfile().map_err(|cause| RecordingError::Open { file: path.into(), cause })?;
    if let Some(found) = copied(source, &mut file, largest(packed)).map_err(|cause| failed(path, cause))? {
        return Err(RecordingError::Format { file: path.into(), found, expected: "less, or a file that is unpacked" });
    }
    file.seek(SeekFrom::Start(0)).map_err(|cause| RecordingError::Open { file: path.into(), cause })?;
    Ok(file)
}

/// Returns the largest size to which a file of `packed` bytes is unpacked.
pub(super) fn largest(packed: u64) -> u64 {
    LARGEST.min(SMALL.max(packed.saturating_mul(TIGHTEST)))
}

/// Copies a source; returns what is wrong with a source of more than `most` bytes, or of more than half of the free space.
fn copied(mut source: impl Read, file: &mut File, most: u64) -> io::Result<Option<String>> {
    let mut count = 0;
    loop {
        let step = STEP.min(most - count + 1);
        let copied = io::copy(&mut source.by_ref().take(step), file)?;
        count += copied;
        if count > most {
            return Ok(Some(format!("more than {most} bytes when unpacked")));
        }
        if copied < step {
            return Ok(None);
        }
        if let Some(found) = lacks_space(file, 0, count)? {
            return Ok(Some(found));
        }
    }
}

/// Returns what is wrong with a temporary file that has `written` bytes and gets `size` more: less than half of the space that
/// was free is left.
pub(super) fn lacks_space(file: &File, size: u64, written: u64) -> io::Result<Option<String>> {
    let free = free_space(file)?;
    let lacks = size.saturating_mul(2).saturating_add(written) > free;
    Ok(lacks.then(|| {
        let (least, folder) = (size.saturating_add(written), std::env::temp_dir());
        format!("at least {least} bytes when unpacked, more than half of the free space of {}", folder.display())
    }))
}

/// Returns the free space of the disk of a file, bytes.
#[cfg(unix)]
fn free_space(file: &File) -> io::Result<u64> {
    let about = rustix::fs::fstatvfs(file)?;
    Ok(about.f_bavail.saturating_mul(about.f_frsize))
}

/// Returns the largest size: the free space is not known.
#[cfg(not(unix))]
const fn free_space(_: &File) -> io::Result<u64> {
    Ok(u64::MAX)
}

/// Returns the error of unpacking.
pub(super) fn failed(path: &Path, cause: io::Error) -> RecordingError {
    let found = match cause.kind() {
        io::ErrorKind::UnexpectedEof => "a compressed file that is truncated".into(),
        _ => cause.to_string().split_whitespace().collect::<Vec<_>>().join(" "),
    };
    RecordingError::Format { file: path.into(), found, expected: EXPECTED }
}
