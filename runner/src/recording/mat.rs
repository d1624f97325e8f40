//! MATLAB files (version 5) as recordings: their longest vectors are the columns.
//!
//! They are handed on as text, row by row, so that one reader finds the flaws of every recording.

use super::error::RecordingError;
use matfile::{MatFile, NumericData};
use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

/// How such a file begins.
pub const MAGIC: &[u8] = b"MATLAB 5.0 MAT-file";
/// Larger files are refused: they are held in memory.
const LARGEST: u64 = 1 << 30;

/// Columns of a file, read as the text of a table.
pub struct Rows {
    columns: Vec<Vec<f64>>,
    next: usize,
    text: Vec<u8>,
    read: usize,
}

impl Rows {
    /// From a file.
    ///
    /// # Errors
    /// A file that is no MATLAB file, is too large, or holds no vector of numbers.
    pub fn open(path: &Path) -> Result<Self, RecordingError> {
        let wrong = |found: String| RecordingError::NoMat { file: path.into(), found };
        let unopened = |cause| RecordingError::Open { file: path.into(), cause };
        let file = File::open(path).map_err(unopened)?;
        let size = file.metadata().map_err(unopened)?.len();
        if size > LARGEST {
            return Err(wrong(format!("{size} bytes, more than {LARGEST}")));
        }
        let parsed = MatFile::parse(BufReader::new(file)).map_err(|e| wrong(format!("{e}")))?;
        let vectors = parsed.arrays().iter().filter_map(|array| Some((array.name().to_owned(), vector(array)?)));
        let all: Vec<(String, Vec<f64>)> = vectors.collect();
        let longest = all.iter().map(|(_, v)| v.len()).max().unwrap_or(0);
        if longest < 2 {
            return Err(wrong("no vector of numbers".to_owned()));
        }
        let (names, columns): (Vec<_>, Vec<_>) = all.into_iter().filter(|(_, v)| v.len() == longest).unzip();
        // A table of one column has no delimiter: the row's number stands beside it.
        let text = format!("row,{}\n", names.join(",")).into_bytes();
        Ok(Self { columns, next: 0, text, read: 0 })
    }

    fn fill(&mut self) -> io::Result<()> {
        (self.read, self.next) = (0, self.next + 1);
        self.text.clear();
        let row = self.next - 1;
        if self.columns.first().is_some_and(|c| row < c.len()) {
            write!(self.text, "{row}")?;
            for column in &self.columns {
                write!(self.text, ",{:e}", column.get(row).copied().unwrap_or(f64::NAN))?;
            }
            self.text.push(b'\n');
        }
        Ok(())
    }
}

impl Read for Rows {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.read >= self.text.len() {
            self.fill()?;
        }
        let rest = self.text.get(self.read..).unwrap_or_default();
        let count = rest.len().min(into.len());
        if let (Some(to), Some(from)) = (into.get_mut(..count), rest.get(..count)) {
            to.copy_from_slice(from);
        }
        self.read += count;
        Ok(count)
    }
}

/// A real array of one row or one column.
fn vector(array: &matfile::Array) -> Option<Vec<f64>> {
    let length: usize = array.size().iter().product();
    if array.size().iter().filter(|&&n| n > 1).count() > 1 {
        return None;
    }
    macro_rules! numbers {
        ($($kind:ident),*) => {
            match array.data() {
                $(NumericData::$kind { real, imag: None } => real.iter().map(|x| *x as f64).collect::<Vec<f64>>(),)*
                _ => return None,
            }
        };
    }
    let all = numbers!(Int8, UInt8, Int16, UInt16, Int32, UInt32, Int64, UInt64, Single, Double);
    (all.len() == length).then_some(all)
}
