//! The bytes after the header, with a limit for each row.

use std::io::{self, BufReader, Read};
use std::path::Path;

use super::RecordingError;

/// Largest length of a row. Without a limit, one open quotation mark would read the whole file into memory.
const LONGEST_ROW: usize = 1 << 22;

/// Source of the rows.
pub(super) struct Source {
    inner: BufReader<Box<dyn Read + Send>>,
    /// Number of bytes that the current row may still take.
    allowance: usize,
    ended: bool,
    last: u8,
}

impl Source {
    pub(super) fn new(inner: BufReader<Box<dyn Read + Send>>) -> Self {
        Self { inner, allowance: LONGEST_ROW, ended: false, last: b'\n' }
    }

    /// Begins a new row.
    pub(super) fn allow_row(&mut self) {
        self.allowance = LONGEST_ROW;
    }

    /// Returns true at an end without a line break, where the last line may be incomplete.
    pub(super) fn broke_off(&self) -> bool {
        self.ended && self.last != b'\n'
    }
}

impl Read for Source {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.allowance == 0 {
            let text = "the row is longer than 4 MiB, or a quotation mark is left open";
            return Err(io::Error::new(io::ErrorKind::InvalidData, text));
        }
        let count = loop {
            match self.inner.read(buffer) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                result => break result?,
            }
        };
        self.allowance = self.allowance.saturating_sub(count);
        self.ended = count == 0 && !buffer.is_empty();
        if let Some(last) = count.checked_sub(1).and_then(|last| buffer.get(last)) {
            self.last = *last;
        }
        Ok(count)
    }
}

/// Text with one blank where the inner text has several, and none at the beginning of a line.
pub(super) struct SqueezedBlanks<R> {
    inner: R,
    /// The last byte was a blank or the end of a line.
    is_separated: bool,
}

impl<R: Read> SqueezedBlanks<R> {
    pub(super) const fn new(inner: R) -> Self {
        Self { inner, is_separated: true }
    }
}

impl<R: Read> Read for SqueezedBlanks<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let count = self.inner.read(buffer)?;
            let mut kept = 0;
            for place in 0..count {
                let byte = buffer[place];
                if byte == b' ' && self.is_separated {
                    continue;
                }
                self.is_separated = matches!(byte, b' ' | b'\n');
                buffer[kept] = byte;
                kept += 1;
            }
            // No bytes would be the end of the text.
            if kept > 0 || count == 0 {
                return Ok(kept);
            }
        }
    }
}

/// Returns the error of reading after `line`.
pub(super) fn failed(file: &Path, line: u64, cause: io::Error) -> RecordingError {
    RecordingError::Read { file: file.into(), line, cause }
}
