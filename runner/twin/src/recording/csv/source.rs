//! The bytes below the header, with a limit for each row.

use std::io::{self, BufReader, Read};
use std::path::Path;

use super::RecordingError;

/// No row is longer; without a limit, one quotation mark left open would draw the whole file into memory.
const LONGEST_ROW: usize = 1 << 22;

/// Where the rows come from.
pub(super) struct Source {
    inner: BufReader<Box<dyn Read + Send>>,
    /// Bytes that may still be drawn for the row at hand.
    allowance: usize,
    ended: bool,
    last: u8,
}

impl Source {
    pub(super) fn new(inner: BufReader<Box<dyn Read + Send>>) -> Self {
        Self { inner, allowance: LONGEST_ROW, ended: false, last: b'\n' }
    }

    /// A new row begins.
    pub(super) fn allow_row(&mut self) {
        self.allowance = LONGEST_ROW;
    }

    /// The end is reached, and the last line has no line break: whoever wrote it may have been cut off.
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

/// A failure to read on after `line`.
pub(super) fn failed(file: &Path, line: u64, cause: io::Error) -> RecordingError {
    RecordingError::Read { file: file.into(), line, cause }
}
