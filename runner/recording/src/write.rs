//! Writer of recordings: columns of numbers as CSV, NPY or Parquet, by the ending of the file.

use crate::parquet_table::{self, Column, Values};
use ballrace_base::output::{AtomicFile, OutputError, quoted};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Largest number of values of a Parquet file, which are held in memory.
const LARGEST: u64 = 1 << 27;

/// Error returned when a recording cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The ending names no format.
    #[error("{}: unknown extension, expected .csv, .npy or .parquet", .file.display())]
    Ending {
        /// File to write.
        file: PathBuf,
    },
    /// More values than memory holds.
    #[error("{}: {found} values, expected at most {LARGEST} in Parquet; CSV and NPY have no limit", .file.display())]
    TooLarge {
        /// File to write.
        file: PathBuf,
        /// Number of values.
        found: u64,
    },
    /// The file cannot be created or finished.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A row cannot be written.
    #[error("{}: this file cannot be written: {cause}", .file.display())]
    Write {
        /// File to write.
        file: PathBuf,
        /// Cause.
        cause: io::Error,
    },
}

/// Column of a written recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenColumn {
    /// Name.
    pub name: String,
    /// Unit, if it has one.
    pub unit: Option<&'static str>,
}

/// A recording in progress; the file appears when it is finished.
pub struct Writer {
    path: PathBuf,
    file: AtomicFile,
    columns: Vec<WrittenColumn>,
    format: Format,
}

enum Format {
    Csv,
    Npy,
    Parquet(Vec<Vec<Option<f64>>>),
}

impl Writer {
    /// Creates a file of `rows` rows.
    ///
    /// # Errors
    /// An unknown ending, a Parquet file that is too large, a file that cannot be created.
    pub fn create(path: &Path, columns: &[WrittenColumn], rows: u64) -> Result<Self, WriteError> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let found = rows.saturating_mul(columns.len() as u64);
        let format = match ending.as_str() {
            "csv" => Format::Csv,
            "npy" => Format::Npy,
            "parquet" if found > LARGEST => return Err(WriteError::TooLarge { file: path.into(), found }),
            "parquet" => Format::Parquet(vec![Vec::new(); columns.len()]),
            _ => return Err(WriteError::Ending { file: path.into() }),
        };
        let mut file = AtomicFile::create(path)?;
        let begun = match &format {
            Format::Csv => {
                let heads: Vec<String> = columns.iter().map(|column| quoted(&column.name)).collect();
                writeln!(file, "{}", heads.join(","))
            }
            Format::Npy => file.write_all(&npy_header(columns, rows)),
            Format::Parquet(_) => Ok(()),
        };
        begun.map_err(|cause| WriteError::Write { file: path.into(), cause })?;
        Ok(Self { path: path.into(), file, columns: columns.to_vec(), format })
    }

    /// Adds a row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn add(&mut self, row: &[f64]) -> Result<(), WriteError> {
        let written = match &mut self.format {
            Format::Csv => {
                let cells: Vec<String> = row.iter().map(|x| cell(*x)).collect();
                writeln!(self.file, "{}", cells.join(","))
            }
            Format::Npy => row.iter().try_for_each(|x| self.file.write_all(&x.to_le_bytes())),
            Format::Parquet(columns) => {
                columns.iter_mut().zip(row).for_each(|(column, x)| column.push(Some(*x)));
                Ok(())
            }
        };
        written.map_err(|cause| WriteError::Write { file: self.path.clone(), cause })
    }

    /// Completes the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(mut self) -> Result<(), WriteError> {
        if let Format::Parquet(columns) = self.format {
            let columns = self.columns.iter().zip(columns);
            let column = |(of, values): (&WrittenColumn, _)| {
                Column::new(&of.name, Values::Number(values)).with_unit(of.unit.unwrap_or_default())
            };
            let columns: Vec<Column> = columns.map(column).collect();
            parquet_table::write(&mut self.file, "recording", &columns)
                .map_err(|e| WriteError::Write { file: self.path, cause: io::Error::other(e) })?;
        }
        Ok(self.file.finish()?)
    }
}

/// Returns a number with twelve significant digits and no trailing zeros.
fn cell(x: f64) -> String {
    format!("{x:.11e}").parse::<f64>().unwrap_or(x).to_string()
}

/// Returns the header of a structured array with a field for each column.
///
/// Format: `numpy.lib.format`, version 3, whose names are UTF-8.
fn npy_header(columns: &[WrittenColumn], rows: u64) -> Vec<u8> {
    let field =
        |column: &WrittenColumn| format!("('{}', '<f8'), ", column.name.replace('\\', "\\\\").replace('\'', "\\'"));
    let fields: String = columns.iter().map(field).collect();
    let mut text = format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({rows},), }}");
    // Magic, version and length take 12 bytes; the data begin at a multiple of 64.
    let length = (12 + text.len() + 1).next_multiple_of(64) - 12;
    text.extend(std::iter::repeat_n(' ', length - text.len() - 1));
    text.push('\n');
    let mut header = b"\x93NUMPY\x03\x00".to_vec();
    header.extend((length as u32).to_le_bytes());
    header.extend(text.into_bytes());
    header
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::Row;
    use crate::harness::{read_file, recording};

    #[test]
    fn written_files_read_back_as_the_same_numbers() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["DE_X", "it's µ"].map(|name| WrittenColumn { name: name.to_owned(), unit: Some("um") });
        let rows: Vec<[f64; 2]> = (0..500).map(|i| [f64::from(i).sin(), 1e-7 * f64::from(i * i)]).collect();
        for ending in ["csv", "npy", "parquet"] {
            let path = folder.path().join(format!("r.{ending}"));
            let mut writer = Writer::create(&path, &names, 500).unwrap();
            rows.iter().for_each(|row| writer.add(row).unwrap());
            writer.finish().unwrap();
            let (read, flaws) = read_file(&path, &recording(&["DE_X", "it's µ"])).unwrap();
            assert!(flaws.is_empty() && read.len() == 500, "{ending}");
            let is_same = |a: &f64, b: &f64| if ending == "csv" { (a - b).abs() <= 1e-11 * b.abs() } else { a == b };
            let equal = |(read, row): (&Row, &[f64; 2])| read.probes.iter().zip(row).all(|(a, b)| is_same(a, b));
            assert!(read.iter().zip(&rows).all(equal), "{ending}");
        }
        let refused = Writer::create(&folder.path().join("r.wav"), &names, 1).err().unwrap().to_string();
        assert!(refused.contains("r.wav: unknown extension, expected .csv, .npy or .parquet"), "{refused}");
    }
}
