//! Matrices of a linear system from files: Matrix Market, NPY or MATLAB, detected by content.

use ballrace_base::bounded::open_regular;
use ballrace_base::npy_header::{self, ElementType, NpyHeader};
use ballrace_recording::mat;
use nalgebra::DMatrix;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest file that is read; a system of 128 coordinates in text takes less than a megabyte.
const LARGEST_FILE: u64 = 64 << 20;

/// Largest number of rows or columns that are read; a system has far fewer.
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
    #[error("unknown format of a matrix, expected a Matrix Market, NPY or MATLAB file")]
    Format,
    /// The MATLAB file has no such matrix.
    #[error("no matrix in a MATLAB file")]
    Matlab(#[source] std::io::Error),
    /// An element is not finite.
    #[error("row {row}, column {column}: invalid value: {found}, expected a finite number")]
    NotFinite {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
        /// The element.
        found: f64,
    },
    /// The text is no Matrix Market file of real numbers.
    #[error("invalid Matrix Market file: {0}, expected a matrix of real numbers")]
    Market(&'static str),
    /// The matrix has more rows or columns than the limit.
    #[error("too many rows or columns: {rows} x {columns}, expected at most {MOST} of each")]
    TooLarge {
        /// Number of rows.
        rows: usize,
        /// Number of columns.
        columns: usize,
    },
    /// The NPY file contains more than an array.
    #[error("unsupported NPY file: not a plain array, expected float64")]
    NotPlain,
    /// The NPY header is invalid.
    #[error("no NPY file of float64")]
    Npy(#[source] std::io::Error),
    /// The array is neither a vector nor a matrix.
    #[error("wrong number of dimensions: {0}, expected 1 or 2")]
    Dimensions(usize),
    /// The elements are not of type float64.
    #[error("unsupported type of the elements, expected float64")]
    ElementType,
    /// The data end early.
    #[error("truncated file")]
    Truncated,
    /// The shape exceeds the address space.
    #[error(transparent)]
    Shape(#[from] std::num::TryFromIntError),
}

/// Reads a matrix of real numbers; from a MATLAB file, the first of `variables` that it contains.
///
/// # Errors
/// A file that cannot be read, is of another format, or holds something else than a matrix of finite numbers.
pub fn read(path: &Path, variables: &[&str]) -> Result<DMatrix<f64>, MatrixError> {
    content(path, variables).map_err(|source| MatrixError { file: path.to_owned(), source })
}

fn content(path: &Path, variables: &[&str]) -> Result<DMatrix<f64>, MatrixProblem> {
    let mut bytes = Vec::new();
    open_regular(path).and_then(|file| file.take(LARGEST_FILE + 1).read_to_end(&mut bytes))?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(MatrixProblem::TooLong);
    }
    let matrix = if bytes.starts_with(npy_header::MAGIC) {
        npy(&bytes)?
    } else if bytes.get(124..128).is_some_and(|end| matches!(end, [_, _, b'I', b'M'] | [_, _, b'M', b'I'])) {
        mat::matrix(path, variables, MOST).map_err(MatrixProblem::Matlab)?
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

/// Reads a Matrix Market file (Boisvert, Pozo, Remington 1996, NISTIR 5935) of real or integer numbers.
fn market(text: &str) -> Result<DMatrix<f64>, MatrixProblem> {
    let mut lines = text.lines();
    let head = lines.next().unwrap_or_default().to_ascii_lowercase();
    let words: Vec<&str> = head.split_ascii_whitespace().collect();
    let ["%%matrixmarket", "matrix", format, "real" | "integer", symmetry] = words.as_slice() else {
        return Err(MatrixProblem::Market("another header"));
    };
    // Ratio of the element (j, i) to the stored element (i, j).
    let opposite = match *symmetry {
        "general" => None,
        "symmetric" => Some(1.0),
        "skew-symmetric" => Some(-1.0),
        _ => return Err(MatrixProblem::Market("another symmetry")),
    };
    let mut lines = lines.skip_while(|line| line.starts_with('%')).filter(|line| !line.trim().is_empty());
    let size = numbers::<usize>(lines.next().unwrap_or_default()).unwrap_or_default();
    let is_list = match *format {
        "coordinate" => true,
        "array" => false,
        _ => return Err(MatrixProblem::Market("another format")),
    };
    let (rows, columns) = match (is_list, size.as_slice()) {
        (true, [rows, columns, _]) | (false, [rows, columns]) => (*rows, *columns),
        _ => return Err(MatrixProblem::Market("no size")),
    };
    if rows.max(columns) > MOST {
        return Err(MatrixProblem::TooLarge { rows, columns });
    }
    if opposite.is_some() && rows != columns {
        return Err(MatrixProblem::Market("a symmetric matrix that is not square"));
    }
    let mut matrix = DMatrix::zeros(rows, columns);
    let mut add = |i: usize, j: usize, x: f64| {
        let is_stored = match opposite {
            None => true,
            Some(sign) => i > j || (i == j && sign > 0.0),
        };
        if i >= rows || j >= columns || !is_stored {
            return Err(MatrixProblem::Market("an element outside the matrix or its lower triangle"));
        }
        matrix[(i, j)] += x;
        if let Some(sign) = opposite
            && i != j
        {
            matrix[(j, i)] += sign * x;
        }
        Ok(())
    };
    let mut found = 0;
    let expected = if is_list {
        for line in lines {
            let mut words = line.split_ascii_whitespace();
            let mut index = || words.next()?.parse::<usize>().ok()?.checked_sub(1);
            let (i, j) = (index(), index());
            match (i, j, words.next().and_then(|word| word.parse().ok()), words.next()) {
                (Some(i), Some(j), Some(x), None) => add(i, j, x)?,
                _ => return Err(MatrixProblem::Market("a line that is no row, column and value")),
            }
            found += 1;
        }
        size.get(2).copied().unwrap_or_default()
    } else {
        let first = |j: usize| opposite.map_or(0, |sign| if sign > 0.0 { j } else { j + 1 });
        let places: Vec<_> = (0..columns).flat_map(|j| (first(j)..rows).map(move |i| (i, j))).collect();
        for line in lines {
            let (Some(&(i, j)), Ok(x)) = (places.get(found), line.trim().parse()) else {
                return Err(MatrixProblem::Market("a line that is no value, or one too many"));
            };
            add(i, j, x)?;
            found += 1;
        }
        places.len()
    };
    if found == expected { Ok(matrix) } else { Err(MatrixProblem::Market("another number of lines than stated")) }
}

fn numbers<X: std::str::FromStr>(line: &str) -> Option<Vec<X>> {
    line.split_ascii_whitespace().map(|word| word.parse().ok()).collect()
}

fn npy(mut bytes: &[u8]) -> Result<DMatrix<f64>, MatrixProblem> {
    let header = NpyHeader::read(&mut bytes).map_err(MatrixProblem::Npy)?;
    let ElementType::Plain(element) = header.element else { return Err(MatrixProblem::NotPlain) };
    let (rows, columns) = match header.shape.as_slice() {
        [n] => (*n, 1),
        [rows, columns] => (*rows, *columns),
        other => return Err(MatrixProblem::Dimensions(other.len())),
    };
    let (rows, columns) = (usize::try_from(rows)?, usize::try_from(columns)?);
    if (element.kind, element.bytes) != ('f', Some(8)) {
        return Err(MatrixProblem::ElementType);
    }
    if rows.max(columns) > MOST {
        return Err(MatrixProblem::TooLarge { rows, columns });
    }
    let number = if element.is_big_endian { f64::from_be_bytes } else { f64::from_le_bytes };
    let (whole, _) = bytes.as_chunks::<8>();
    let Some(whole) = whole.get(..rows * columns) else { return Err(MatrixProblem::Truncated) };
    let numbers: Vec<f64> = whole.iter().map(|bytes| number(*bytes)).collect();
    Ok(if header.is_fortran {
        DMatrix::from_column_slice(rows, columns, &numbers)
    } else {
        DMatrix::from_row_slice(rows, columns, &numbers)
    })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn matrix_market_files_of_every_kind() {
        let rows = |text: &str| {
            let matrix = market(text).unwrap();
            matrix.row_iter().map(|row| row.iter().copied().collect()).collect::<Vec<Vec<f64>>>()
        };
        let general =
            "%%MatrixMarket Matrix Coordinate Real General\n% of a test\n%\n\n2 3 3\n1 1 1.5\n2 3 -2e-1\n\n2 3 1\n";
        assert_eq!(rows(general), [[1.5, 0.0, 0.0], [0.0, 0.0, 0.8]]);
        let symmetric = "%%MatrixMarket matrix coordinate integer symmetric\n2 2 2\n1 1 3\n2 1 -1\n";
        assert_eq!(rows(symmetric), [[3.0, -1.0], [-1.0, 0.0]]);
        let skew = "%%MatrixMarket matrix coordinate real skew-symmetric\n2 2 1\n2 1 4\n";
        assert_eq!(rows(skew), [[0.0, -4.0], [4.0, 0.0]]);
        let array = "%%MatrixMarket matrix array real general\n2 2\n1\n2\n3\n4\n";
        assert_eq!(rows(array), [[1.0, 3.0], [2.0, 4.0]]);
        let half = "%%MatrixMarket matrix array real symmetric\r\n2 2\r\n1\r\n2\r\n3\r\n";
        assert_eq!(rows(half), [[1.0, 2.0], [2.0, 3.0]]);
        let below = "%%MatrixMarket matrix array real skew-symmetric\n2 2\n5\n";
        assert_eq!(rows(below), [[0.0, -5.0], [5.0, 0.0]]);
    }

    #[test]
    fn other_matrix_market_files_are_refused() {
        let good = "%%MatrixMarket matrix coordinate real symmetric\n2 2 1\n2 1 4\n";
        assert!(market(good).is_ok());
        for (from, to) in [
            ("real", "complex"),
            ("real", "pattern"),
            ("symmetric", "hermitian"),
            ("symmetric", "skew"),
            ("coordinate", "dense"),
            ("matrix", "vector"),
            ("2 2 1", "2 2"),
            ("2 2 1", "2 3 1"),
            ("2 2 1", "2 2 2"),
            ("2 2 1", "2 2 -1"),
            ("2 2 1", "5000 5000 1"),
            ("2 1 4", "1 2 4"),
            ("2 1 4", "3 1 4"),
            ("2 1 4", "0 1 4"),
            ("2 1 4", "2 1"),
            ("2 1 4", "2 1 4 5"),
            ("2 1 4", "2 1 four"),
            ("2 1 4", "% 2 1 4"),
        ] {
            assert!(market(&good.replacen(from, to, 1)).is_err(), "{to}");
        }
    }
}
