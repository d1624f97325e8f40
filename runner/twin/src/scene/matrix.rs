//! Matrices of a linear system from files: Matrix Market or NPY, told apart by their content.

use anyhow::{Context, Result, bail};
use nalgebra::DMatrix;
use nalgebra_sparse::io::load_coo_from_matrix_market_str;
use npyz::{NpyFile, Order};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest file that is read; a system of 128 coordinates in text takes less than a megabyte.
const LARGEST_FILE: u64 = 64 << 20;

/// Rows or columns that are taken in: many more than a system may have.
const MOST: usize = 4096;

/// A matrix of real numbers.
///
/// # Errors
/// A file that cannot be read, is neither format, or holds something else than a matrix of finite numbers.
pub fn read(path: &Path) -> Result<DMatrix<f64>> {
    let name = || path.display().to_string();
    // The length of a device or a pipe is not known before it is read.
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes)).with_context(name)?;
    if bytes.len() as u64 > LARGEST_FILE {
        bail!("{}: matrix file too long, expected at most 64 MiB", path.display());
    }
    let matrix = if bytes.starts_with(b"\x93NUMPY") {
        npy(&bytes).with_context(name)?
    } else {
        match std::str::from_utf8(&bytes) {
            Ok(text) if text.starts_with("%%MatrixMarket") => market(text).with_context(name)?,
            _ => bail!("{}: found neither a Matrix Market nor an NPY file, allowed: one of the two", path.display()),
        }
    };
    if let Some(at) = matrix.iter().position(|x| !x.is_finite()) {
        let (row, column) = (at % matrix.nrows() + 1, at / matrix.nrows() + 1);
        bail!("{}: row {row}, column {column}: found {}, allowed: a finite number", path.display(), matrix[at]);
    }
    Ok(matrix)
}

fn market(text: &str) -> Result<DMatrix<f64>> {
    let entries = load_coo_from_matrix_market_str::<f64>(text)
        .map_err(|e| anyhow::anyhow!("found no Matrix Market file of real numbers: {}", one_line(&e.to_string())))?;
    let (rows, columns) = (entries.nrows(), entries.ncols());
    if rows.max(columns) > MOST {
        bail!("found {rows} x {columns}, allowed: up to {MOST} rows and columns");
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

fn npy(bytes: &[u8]) -> Result<DMatrix<f64>> {
    // A plain array's header is one dictionary with one tuple; what nests deeper would keep the parser busy for ages.
    let text = if bytes.get(6) == Some(&1) { 10 } else { 12 };
    let header = bytes.get(text..).unwrap_or_default();
    let header = header.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let count = |bracket: u8| header.iter().filter(|byte| **byte == bracket).count();
    if count(b'{') > 1 || count(b'(') > 1 || count(b'[') > 0 {
        bail!("found an NPY file of something else than a plain array, allowed: float64");
    }
    let file = NpyFile::new(bytes).context("found no NPY file")?;
    let (shape, order) = (file.shape().to_vec(), file.order());
    let (rows, columns) = match shape.as_slice() {
        [n] => (*n, 1),
        [rows, columns] => (*rows, *columns),
        other => bail!("found an array of {} dimensions, allowed: 1 or 2", other.len()),
    };
    let (rows, columns) = (usize::try_from(rows)?, usize::try_from(columns)?);
    let found = || "found an array of another type, allowed: float64";
    let data = file.data::<f64>().map_err(|_| anyhow::anyhow!(found()))?;
    let numbers = data.collect::<std::io::Result<Vec<f64>>>().context("found a file that is cut short")?;
    if rows.checked_mul(columns) != Some(numbers.len()) {
        bail!("found {} numbers for {rows} x {columns}", numbers.len());
    }
    Ok(match order {
        Order::C => DMatrix::from_row_slice(rows, columns, &numbers),
        Order::Fortran => DMatrix::from_column_slice(rows, columns, &numbers),
    })
}
