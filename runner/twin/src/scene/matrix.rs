//! Matrices of a linear system from files: Matrix Market or NPY, detected by content.

use nalgebra::DMatrix;
use nalgebra_sparse::io::load_coo_from_matrix_market_str;
use npyz::{NpyFile, Order};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file that is read; a system of 128 coordinates in text takes less than a megabyte.
const LARGEST_FILE: u64 = 64 << 20;

/// Rows or columns that are taken in: many more than a system may have.
const MOST: usize = 4096;

/// Error returned when a file is no matrix of finite numbers.
#[derive(Debug, thiserror::Error)]
#[error("{}", file.display())]
pub struct MatrixError {
    /// The matrix file.
    pub file: PathBuf,
    /// The reason.
    pub source: MatrixProblem,
}

/// Reason for which a file is no matrix of finite numbers.
#[derive(Debug, thiserror::Error)]
pub enum MatrixProblem {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] std::io::Error),
    /// The file is longer than the limit.
    #[error("matrix file too long, expected at most 64 MiB")]
    TooLong,
    /// The format is unknown.
    #[error("found neither a Matrix Market nor an NPY file, allowed: one of the two")]
    Format,
    /// An element is not finite.
    #[error("row {row}, column {column}: found {found}, allowed: a finite number")]
    NotFinite {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// The element.
        found: f64,
    },
    /// The text is no Matrix Market file of real numbers.
    #[error("found no Matrix Market file of real numbers: {0}")]
    Market(String),
    /// The matrix has more rows or columns than the limit.
    #[error("found {rows} x {columns}, allowed: up to {MOST} rows and columns")]
    TooLarge {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// The NPY file contains more than an array.
    #[error("found an NPY file of something else than a plain array, allowed: float64")]
    NotPlain,
    /// The NPY header is invalid.
    #[error("found no NPY file")]
    Npy(#[source] std::io::Error),
    /// The array is neither a vector nor a matrix.
    #[error("found an array of {0} dimensions, allowed: 1 or 2")]
    Dimensions(usize),
    /// The elements are not of type float64.
    #[error("found an array of another type, allowed: float64")]
    ElementType,
    /// The data end early.
    #[error("found a file that is cut short")]
    Truncated(#[source] std::io::Error),
    /// The count of numbers does not match the shape.
    #[error("found {found} numbers for {rows} x {columns}")]
    Count {
        /// Count of numbers.
        found: usize,
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// The shape exceeds the address space.
    #[error(transparent)]
    Shape(#[from] std::num::TryFromIntError),
}

/// Reads a matrix of real numbers.
///
/// # Errors
/// A file that cannot be read, is neither format, or holds something else than a matrix of finite numbers.
pub fn read(path: &Path) -> Result<DMatrix<f64>, MatrixError> {
    content(path).map_err(|source| MatrixError { file: path.to_owned(), source })
}

fn content(path: &Path) -> Result<DMatrix<f64>, MatrixProblem> {
    // The length of a device or a pipe is not known before it is read.
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes))?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(MatrixProblem::TooLong);
    }
    let matrix = if bytes.starts_with(b"\x93NUMPY") {
        npy(&bytes)?
    } else {
        match std::str::from_utf8(&bytes) {
            Ok(text) if text.starts_with("%%MatrixMarket") => market(text)?,
            _ => return Err(MatrixProblem::Format),
        }
    };
    if let Some(at) = matrix.iter().position(|x| !x.is_finite()) {
        let (row, column) = (at % matrix.nrows() + 1, at / matrix.nrows() + 1);
        return Err(MatrixProblem::NotFinite { row, column, found: matrix[at] });
    }
    Ok(matrix)
}

fn market(text: &str) -> Result<DMatrix<f64>, MatrixProblem> {
    let entries =
        load_coo_from_matrix_market_str::<f64>(text).map_err(|e| MatrixProblem::Market(one_line(&e.to_string())))?;
    let (rows, columns) = (entries.nrows(), entries.ncols());
    if rows.max(columns) > MOST {
        return Err(MatrixProblem::TooLarge { rows, columns });
    }
    let mut matrix = DMatrix::zeros(rows, columns);
    for (i, j, x) in entries.triplet_iter() {
        matrix[(i, j)] += x;
    }
    Ok(matrix)
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn npy(bytes: &[u8]) -> Result<DMatrix<f64>, MatrixProblem> {
    // A plain array's header is one dictionary with one tuple; what nests deeper would keep the parser busy for ages.
    let text = if bytes.get(6) == Some(&1) { 10 } else { 12 };
    let header = bytes.get(text..).unwrap_or_default();
    let header = header.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let count = |bracket: u8| header.iter().filter(|byte| **byte == bracket).count();
    if count(b'{') > 1 || count(b'(') > 1 || count(b'[') > 0 {
        return Err(MatrixProblem::NotPlain);
    }
    let file = NpyFile::new(bytes).map_err(MatrixProblem::Npy)?;
    let (shape, order) = (file.shape().to_vec(), file.order());
    let (rows, columns) = match shape.as_slice() {
        [n] => (*n, 1),
        [rows, columns] => (*rows, *columns),
        other => return Err(MatrixProblem::Dimensions(other.len())),
    };
    let (rows, columns) = (usize::try_from(rows)?, usize::try_from(columns)?);
    let data = file.data::<f64>().map_err(|_| MatrixProblem::ElementType)?;
    let numbers = data.collect::<std::io::Result<Vec<f64>>>().map_err(MatrixProblem::Truncated)?;
    if rows.checked_mul(columns) != Some(numbers.len()) {
        return Err(MatrixProblem::Count { found: numbers.len(), rows, columns });
    }
    Ok(match order {
        Order::C => DMatrix::from_row_slice(rows, columns, &numbers),
        Order::Fortran => DMatrix::from_column_slice(rows, columns, &numbers),
    })
}
