//! MATLAB files (version 5) as recordings: vectors, and columns of matrices, by their paths, such as `N09.Y(7).Data` or `x(:,2)`.
//! Those that the scene names are held in memory. [`matrix`] reads one matrix of such a file.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
mod walk;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use nalgebra::DMatrix;

use super::bytes::Bytes;
use super::error::{RecordingError, refuse};
use super::numbers::{LoadedColumns, Number};
use super::table::{Cells, LONGEST_VECTOR, Table, equal_lengths};
use ballrace_base::bounded::open_regular;
use walk::Element;

const EXPECTED: &str = "a MATLAB file of version 5 with vectors of equal length";

/// Largest number of bytes of all vectors, which are held in memory.
const LARGEST: u64 = 1 << 30;
/// Largest number of columns of a matrix that are listed, or of rows where the rows are longer.
const MAX_COLUMNS: u64 = 4096;

/// The vectors of a file.
struct Vectors {
    path: PathBuf,
    file: File,
    names: Vec<String>,
    all: Vec<Vector>,
    /// Single numbers.
    scalars: Vec<(String, Vector)>,
    selected: LoadedColumns,
    bytes_read: u64,
}

/// Location of a sparse matrix.
struct Sparse {
    element: Element,
    /// Bytes of the variable before its row numbers.
    before: u64,
    big_endian: bool,
    rows: usize,
    columns: usize,
}

/// A matrix of a file.
enum Matrix {
    Full(Vector),
    Sparse(Sparse),
}

/// Location of numbers: a matrix, or one of its columns or rows.
#[derive(Clone, Copy)]
struct Vector {
    element: Element,
    /// Bytes of the variable before the numbers of the matrix.
    before: u64,
    number: Number,
    rows: u64,
    columns: u64,
    /// Place of the first number in the matrix, distance to the next, and number of numbers.
    first: u64,
    stride: u64,
    count: u64,
}

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let arrays = walk::arrays(&mut file).map_err(|cause| wrong(path, &cause))?;
    let (mut names, mut all, mut scalars) = (Vec::new(), Vec::new(), Vec::new());
    for (name, matrix) in arrays {
        let Matrix::Full(matrix) = matrix else { continue };
        if matrix.count == 1 {
            scalars.push((name, matrix));
        } else {
            let (own, vectors): (Vec<_>, Vec<_>) = matrix.vectors(&name).into_iter().unzip();
            names.extend(own);
            all.extend(vectors);
        }
    }
    if all.is_empty() {
        return Err(wrong(path, &refuse("no vector of numbers")));
    }
    let (path, selected) = (path.into(), LoadedColumns::default());
    Ok(Box::new(Vectors { path, file, names, all, scalars, selected, bytes_read: 0 }))
}

fn wrong(path: &Path, cause: &io::Error) -> RecordingError {
    RecordingError::unreadable(path, cause, EXPECTED)
}

/// Reads the first of these variables that a file has, as a matrix with up to `most` rows and columns.
///
/// # Errors
/// No MATLAB file of version 5, none of the variables, a larger matrix; a file that is truncated.
pub fn matrix(path: &Path, variables: &[&str], most: usize) -> io::Result<DMatrix<f64>> {
    let mut file = open_regular(path)?;
    let arrays = walk::arrays(&mut file)?;
    let named = variables.iter().find_map(|name| arrays.iter().find(|(found, _)| is_same(found, name)));
    let vector = match named {
        Some((_, Matrix::Full(vector))) => vector,
        Some((_, Matrix::Sparse(sparse))) => return sparse.load(&mut file, most),
        None => {
            let found = arrays.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(refuse(format!("no matrix {} among its variables: {found}", variables.join(" or "))));
        }
    };
    let (rows, columns) = (vector.rows as usize, vector.columns as usize);
    if rows.max(columns) > most {
        return Err(too_large(rows, columns, most));
    }
    let (number, bytes) = vector.load(&mut file)?;
    let values = bytes.chunks_exact(usize::from(number.bytes)).map(|bytes| number.read(bytes));
    let values: Vec<f64> = values.collect();
    Ok(DMatrix::from_column_slice(rows, columns, &values))
}

fn too_large(rows: usize, columns: usize, most: usize) -> io::Error {
    refuse(format!("a matrix of {rows} x {columns}, more than {most} rows or columns"))
}

impl Sparse {
    /// Reads the matrix: the row of each element, the first element of each column, the elements.
    fn load(&self, file: &mut File, most: usize) -> io::Result<DMatrix<f64>> {
        let (rows, columns) = (self.rows, self.columns);
        if rows.max(columns) > most {
            return Err(too_large(rows, columns, most));
        }
        // A row number and a value for each element, the columns, and three headers with their padding.
        let longest = self.before + 12 * (rows * columns) as u64 + 4 * columns as u64 + 64;
        let mut bytes = Vec::new();
        self.element.open(file)?.take(longest).read_to_end(&mut bytes)?;
        let mut bytes = Bytes { rest: &bytes, big_endian: self.big_endian };
        bytes.take(self.before)?;
        let mut numbers = || -> io::Result<Vec<f64>> {
            let (kind, bytes_of) = part(&mut bytes)?;
            let number = walk::number(kind, self.big_endian).ok_or_else(|| refuse("a sparse matrix of no numbers"))?;
            Ok(bytes_of.chunks_exact(number.bytes.into()).map(|bytes| number.read(bytes)).collect())
        };
        let (row_of, first_of, values) = (numbers()?, numbers()?, numbers()?);
        let mut matrix = DMatrix::zeros(rows, columns);
        let wrong = || refuse(format!("a sparse matrix of {rows} x {columns} with an element outside"));
        if first_of.len() != columns + 1 {
            return Err(wrong());
        }
        let index = |number: f64| (number >= 0.0).then_some(number as usize);
        for (column, ends) in first_of.windows(2).enumerate() {
            let range = index(ends[0]).zip(index(ends[1])).map(|(from, to)| from..to);
            let elements = range.and_then(|range| row_of.get(range.clone()).zip(values.get(range)));
            let (row_of, values) = elements.ok_or_else(wrong)?;
            for (row, value) in row_of.iter().zip(values) {
                let entry = index(*row).and_then(|row| matrix.get_mut((row, column)));
                *entry.ok_or_else(wrong)? += value;
            }
        }
        Ok(matrix)
    }
}

/// Returns type and bytes of the next part of a variable in memory, and skips its padding.
fn part<'a>(bytes: &mut Bytes<'a>) -> io::Result<(u32, &'a [u8])> {
    let before = bytes.rest.len();
    let kind = bytes.u32()?;
    let (kind, length) = match kind >> 16 {
        0 => (kind, bytes.u32()?.into()),
        length => (kind & 0xffff, length.into()),
    };
    let own = bytes.take(length)?;
    let used = (before - bytes.rest.len()) as u64;
    bytes.take(used.next_multiple_of(8) - used)?;
    Ok((kind, own))
}

/// Returns true for two paths of one array: a single structure may have the index 1.
fn is_same(own: &str, name: &str) -> bool {
    own == name || (name.contains("(1).") && own == name.replace("(1).", "."))
}

impl Vector {
    /// Returns the columns of a matrix with their names, or its rows where those are longer; a vector has the name of the matrix.
    fn vectors(self, name: &str) -> Vec<(String, Self)> {
        let Self { rows, columns, .. } = self;
        if rows == 1 || columns == 1 {
            return vec![(name.to_owned(), self)];
        }
        if rows.min(columns) > MAX_COLUMNS {
            return vec![];
        }
        let column = |j: u64| Self { first: j * rows, stride: 1, count: rows, ..self };
        let row = |i: u64| Self { first: i, stride: rows, count: columns, ..self };
        if rows >= columns {
            (0..columns).map(|j| (format!("{name}(:,{})", j + 1), column(j))).collect()
        } else {
            (0..rows).map(|i| (format!("{name}({},:)", i + 1), row(i))).collect()
        }
    }

    /// Reads the numbers as bytes of the file.
    fn load(&self, file: &mut File) -> io::Result<(Number, Vec<u8>)> {
        let size = u64::from(self.number.bytes);
        let mut source = self.element.open(file)?;
        io::copy(&mut source.by_ref().take(self.before + self.first * size), &mut io::sink())?;
        let mut bytes = Vec::new();
        if self.stride == 1 {
            source.take(self.count * size).read_to_end(&mut bytes)?;
        } else {
            let mut number = [0; 8];
            let number = &mut number[..usize::from(self.number.bytes.min(8))];
            for place in 0..self.count {
                if place > 0 {
                    io::copy(&mut source.by_ref().take((self.stride - 1) * size), &mut io::sink())?;
                }
                source.read_exact(number)?;
                bytes.extend_from_slice(number);
            }
        }
        if bytes.len() as u64 != self.count * size {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok((self.number, bytes))
    }
}

impl Vectors {
    fn load(&mut self, place: usize) -> io::Result<(Number, Vec<u8>)> {
        let Some(vector) = self.all.get(place) else { return Err(io::ErrorKind::UnexpectedEof.into()) };
        let loaded = vector.load(&mut self.file)?;
        self.bytes_read += vector.element.length;
        Ok(loaded)
    }
}

impl Table for Vectors {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn is_called(&self, place: usize, name: &str) -> bool {
        self.names.get(place).is_some_and(|own| is_same(own, name))
    }

    fn vector(&mut self, place: usize) -> Result<Option<Vec<f64>>, RecordingError> {
        let count = self.all.get(place).map(|vector| vector.count).unwrap_or(0);
        if count > LONGEST_VECTOR {
            return Err(wrong(&self.path, &refuse(format!("a vector of {count} values, more than {LONGEST_VECTOR}"))));
        }
        let loaded = self.load(place).map(|loaded| vec![loaded]).map_err(|cause| wrong(&self.path, &cause))?;
        Ok(Some(LoadedColumns::new(loaded, count).first()))
    }

    fn scalar(&mut self, name: &str) -> Result<Option<f64>, RecordingError> {
        let Some((_, scalar)) = self.scalars.iter().find(|(own, _)| is_same(own, name)) else { return Ok(None) };
        let (number, bytes) = scalar.load(&mut self.file).map_err(|cause| wrong(&self.path, &cause))?;
        Ok(Some(number.read(&bytes)))
    }

    fn scalar_names(&self) -> Vec<String> {
        self.scalars.iter().map(|(name, _)| name.clone()).collect()
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let named = |place: &usize| Some((self.names.get(*place)?.as_str(), self.all.get(*place)?));
        let lengths: Vec<_> = places.iter().filter_map(named).map(|(name, vector)| (name, vector.count)).collect();
        let rows = equal_lengths(&self.path, &lengths)?;
        let bytes = places.iter().filter_map(|place| self.all.get(*place));
        let bytes: u64 = bytes.map(|vector| vector.count * u64::from(vector.number.bytes)).sum();
        if bytes > LARGEST {
            return Err(wrong(&self.path, &refuse(format!("{bytes} bytes of vectors, more than {LARGEST}"))));
        }
        let loaded = places.iter().map(|place| self.load(*place)).collect::<io::Result<_>>();
        self.selected = LoadedColumns::new(loaded.map_err(|cause| wrong(&self.path, &cause))?, rows);
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        Ok(self.selected.next(self.names.len(), cells))
    }

    fn bytes_read(&self) -> u64 {
        self.bytes_read
    }
}
