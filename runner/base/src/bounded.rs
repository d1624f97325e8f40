//! Reading from files of unbounded length.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Opens a regular file. A pipe, which waits for its writer, or a device is refused before it is opened.
///
/// # Errors
/// A file that cannot be read, a folder, a pipe or a device.
pub fn open_regular(path: &Path) -> io::Result<File> {
    let about = std::fs::metadata(path)?;
    if about.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if !about.is_file() {
        return Err(io::Error::other("a pipe or a device, expected a regular file"));
    }
    File::open(path)
}

/// Returns the content of a file of at most `limit` bytes; the memory is bounded.
///
/// # Errors
/// As [`open_regular`], and a file that is larger.
pub fn read_bytes(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open_regular(path)?.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(io::Error::other(format!("more than {limit} bytes, expected a smaller file")));
    }
    Ok(bytes)
}

/// Returns the content of such a file as text.
///
/// # Errors
/// As [`read_bytes`], and a file that is not UTF-8 text.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    String::from_utf8(read_bytes(path, limit)?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
}

/// A reader that fails once a line is longer than a limit, so that no line has to fit into memory whatever its length.
pub struct BoundedLines<R> {
    inner: R,
    limit: usize,
    /// Bytes since the last line feed.
    length: usize,
}

impl<R: Read> BoundedLines<R> {
    /// Reads from `inner` lines of at most `limit` bytes.
    pub const fn new(inner: R, limit: usize) -> Self {
        Self { inner, limit, length: 0 }
    }
}

impl<R: Read> Read for BoundedLines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        for part in buffer.get(..count).unwrap_or_default().split_inclusive(|byte| *byte == b'\n') {
            self.length += part.len();
            if self.length > self.limit {
                let limit = self.limit;
                return Err(io::Error::other(format!("a line of more than {limit} bytes, expected shorter lines")));
            }
            if part.last() == Some(&b'\n') {
                self.length = 0;
            }
        }
        Ok(count)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    fn read(text: &[u8], limit: usize) -> io::Result<Vec<u8>> {
        let mut all = Vec::new();
        BoundedLines::new(text, limit).read_to_end(&mut all).map(|_| all)
    }

    #[test]
    fn a_text_up_to_the_limit() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "12345").unwrap();
        assert_eq!(read_text(file.path(), 5).unwrap(), "12345");
        assert!(read_text(file.path(), 4).unwrap_err().to_string().contains("more than 4 bytes"));
    }

    #[test]
    fn lines_up_to_the_limit() {
        for text in [&b""[..], b"\n", b"1234\n1234\n\n1234", b"1234"] {
            assert_eq!(read(text, 5).unwrap(), text);
        }
        for text in [&b"123456"[..], b"1\n12345\n", b"1\n\n123456\n1"] {
            assert!(read(text, 5).unwrap_err().to_string().contains("more than 5 bytes"));
        }
    }

    #[test]
    fn a_line_without_end() {
        let error = io::copy(&mut BoundedLines::new(io::repeat(0), 1 << 20), &mut io::sink()).unwrap_err();
        assert!(error.to_string().contains("more than 1048576 bytes"));
    }
}
