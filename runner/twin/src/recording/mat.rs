//! MATLAB files (version 5) as recordings: the vectors are the columns. Those that the scene names are held in memory. [`matrix`] reads
//! one matrix of such a file.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::read::ZlibDecoder;
use nalgebra::DMatrix;

use super::bytes::Bytes;
use super::error::RecordingError;
use super::numbers::{Kind, Number};
use super::table::{Cells, Table, equal_lengths};

const EXPECTED: &str = "a MATLAB file of version 5 with vectors of equal length";

/// Bytes of text, version and byte order before the first variable.
const HEADER: u64 = 128;
/// Bytes of a variable within which its name and size are.
const ABOUT: u64 = 4096;
/// Largest number of bytes of all vectors, which are held in memory.
const LARGEST: u64 = 1 << 30;
/// Largest compression ratio of deflate.
const TIGHTEST: u64 = 1032;

/// Class of sparse matrices.
const SPARSE: u32 = 5;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;

/// The vectors of a file.
struct Vectors {
    path: PathBuf,
    file: File,
    names: Vec<String>,
    all: Vec<Vector>,
    selected: Vec<(Number, Vec<u8>)>,
    rows: u64,
    row: u64,
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

/// Location of the numbers of a variable.
struct Vector {
    element: Element,
    /// Bytes of the variable before its numbers.
    before: u64,
    number: Number,
    count: u64,
    rows: u64,
    /// It has one column or one row, and more than one number.
    is_vector: bool,
}

/// A piece of the file with a type of its own.
#[derive(Clone, Copy)]
struct Element {
    kind: u32,
    start: u64,
    length: u64,
}

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let wanted = |bytes: Bytes<'_>, element| Ok(vector(bytes, element)?.filter(|(_, vector)| vector.is_vector));
    let (names, all) = list(&mut file, wanted).map_err(|cause| wrong(path, &cause))?;
    let (path, selected) = (path.into(), Vec::new());
    Ok(Box::new(Vectors { path, file, names, all, selected, rows: 0, row: 0, bytes_read: 0 }))
}

fn wrong(path: &Path, cause: &io::Error) -> RecordingError {
    let found = match cause.kind() {
        io::ErrorKind::UnexpectedEof => "a file that is cut short".into(),
        _ => cause.to_string(),
    };
    RecordingError::Format { file: path.into(), found, expected: EXPECTED }
}

fn refuse(found: impl Into<String>) -> io::Error {
    io::Error::other(found.into())
}

/// Names of the variables that `read` finds in their first bytes, with what it returns.
fn list<V>(
    file: &mut File,
    read: impl Fn(Bytes<'_>, Element) -> io::Result<Option<(String, V)>>,
) -> io::Result<(Vec<String>, Vec<V>)> {
    let size = file.metadata()?.len();
    let mut header = [0; HEADER as usize];
    file.read_exact(&mut header)?;
    if header.starts_with(b"MATLAB 7.3") {
        return Err(refuse("a MATLAB file of version 7.3, which is HDF5 (save it with -v7)"));
    }
    let big_endian = match header.last_chunk() {
        Some([0, 1, b'I', b'M']) => false,
        Some([1, 0, b'M', b'I']) => true,
        _ => return Err(refuse("no MATLAB file of version 5")),
    };
    let (mut start, mut names, mut all) = (HEADER, Vec::new(), Vec::new());
    while start < size {
        let element = next_element(file, start, size, big_endian)?;
        start = element.start + element.length;
        if element.length > 0 && (element.kind == MATRIX || element.kind == COMPRESSED) {
            let mut about = Vec::new();
            element.open(file)?.take(ABOUT).read_to_end(&mut about)?;
            if let Some((name, variable)) = read(Bytes { rest: &about, big_endian }, element)? {
                names.push(name);
                all.push(variable);
            }
        }
    }
    if all.is_empty() {
        return Err(refuse("no vector of numbers"));
    }
    Ok((names, all))
}

fn next_element(file: &mut File, start: u64, size: u64, big_endian: bool) -> io::Result<Element> {
    let mut tag = [0; 8];
    file.seek(SeekFrom::Start(start))?;
    file.read_exact(&mut tag)?;
    let mut tag = Bytes { rest: &tag, big_endian };
    let (kind, length, start) = (tag.u32()?, u64::from(tag.u32()?), start + 8);
    if kind == 0 || kind > 18 {
        return Err(refuse(format!("no variable at byte {}", start - 8)));
    }
    if length > size - start {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(Element { kind, start, length })
}

impl Element {
    /// Its bytes, unpacked.
    fn open<'a>(&self, file: &'a mut File) -> io::Result<Box<dyn Read + 'a>> {
        file.seek(SeekFrom::Start(self.start))?;
        let bytes = file.take(self.length);
        Ok(if self.kind == COMPRESSED { Box::new(ZlibDecoder::new(bytes)) } else { Box::new(bytes) })
    }

    /// Most bytes that can be in it.
    const fn most(&self) -> u64 {
        self.length * if self.kind == COMPRESSED { TIGHTEST } else { 1 }
    }
}

/// Class, lengths and name of an array.
struct Head {
    class: u32,
    is_complex: bool,
    lengths: Vec<u32>,
    name: String,
}

/// Reads the head of a variable; nothing where it is no array.
fn head(bytes: &mut Bytes<'_>, element: Element) -> io::Result<Option<Head>> {
    if element.kind == COMPRESSED {
        let (kind, _length) = (bytes.u32()?, bytes.u32()?);
        if kind != MATRIX {
            return Ok(None);
        }
    }
    let (_, flags) = part(bytes)?;
    let flags = Bytes { rest: flags, ..*bytes }.u32()?;
    let (is_complex, class) = (flags & 0x800 != 0, flags & 0xff);
    if class != SPARSE && !(6..=15).contains(&class) {
        return Ok(None);
    }
    let (_, dimensions) = part(bytes)?;
    let mut dimensions = Bytes { rest: dimensions, ..*bytes };
    let mut lengths = Vec::new();
    while !dimensions.rest.is_empty() {
        lengths.push(dimensions.u32()?);
    }
    let (_, name) = part(bytes)?;
    Ok(Some(Head { class, is_complex, lengths, name: String::from_utf8_lossy(name).into_owned() }))
}

/// Name and numbers of a variable; nothing where it is no full array of real numbers.
fn vector(mut bytes: Bytes<'_>, element: Element) -> io::Result<Option<(String, Vector)>> {
    let all = bytes.rest.len();
    let Some(Head { name, lengths, .. }) =
        head(&mut bytes, element)?.filter(|head| !head.is_complex && head.class != SPARSE)
    else {
        return Ok(None);
    };
    let count = lengths.iter().fold(1_u64, |count, length| count.saturating_mul((*length).into()));
    let (long, rows) = (lengths.iter().filter(|length| **length > 1).count(), lengths.first().copied().map(u64::from));
    let (kind, length) = part_head(&mut bytes)?;
    let number = number(kind, bytes.big_endian).filter(|_| long <= 2 && count > 0 && !name.is_empty());
    let Some(number) = number else { return Ok(None) };
    let before = (all - bytes.rest.len()) as u64;
    if count.checked_mul(number.bytes.into()) != Some(length) || before + length > element.most() {
        return Err(refuse(format!("{count} numbers in {length} bytes for `{name}`")));
    }
    Ok(Some((name, Vector { element, before, number, count, rows: rows.unwrap_or(1), is_vector: long == 1 })))
}

/// Type and length of a part of a variable. In its short form both are in four bytes.
fn part_head(bytes: &mut Bytes<'_>) -> io::Result<(u32, u64)> {
    let kind = bytes.u32()?;
    match kind >> 16 {
        0 => Ok((kind, bytes.u32()?.into())),
        length => Ok((kind & 0xffff, length.into())),
    }
}

/// Type and bytes of a part of a variable, with what fills it up.
fn part<'a>(bytes: &mut Bytes<'a>) -> io::Result<(u32, &'a [u8])> {
    let before = bytes.rest.len();
    let (kind, length) = part_head(bytes)?;
    let own = bytes.take(length)?;
    let used = (before - bytes.rest.len()) as u64;
    bytes.take(used.next_multiple_of(8) - used)?;
    Ok((kind, own))
}

fn number(kind: u32, big_endian: bool) -> Option<Number> {
    let (kind, bytes) = match kind {
        1 => (Kind::Signed, 1),
        2 => (Kind::Unsigned, 1),
        3 => (Kind::Signed, 2),
        4 => (Kind::Unsigned, 2),
        5 => (Kind::Signed, 4),
        6 => (Kind::Unsigned, 4),
        7 => (Kind::Float, 4),
        9 => (Kind::Float, 8),
        12 => (Kind::Signed, 8),
        13 => (Kind::Unsigned, 8),
        _ => return None,
    };
    Some(Number::new(kind, bytes, big_endian))
}

/// Name and place of a sparse matrix of real numbers; nothing where a variable is none.
fn sparse(mut bytes: Bytes<'_>, element: Element) -> io::Result<Option<(String, Sparse)>> {
    let all = bytes.rest.len();
    let found = head(&mut bytes, element)?.filter(|head| !head.is_complex && head.class == SPARSE);
    let Some(Head { name, lengths, .. }) = found else { return Ok(None) };
    let [rows, columns] = lengths.as_slice() else { return Ok(None) };
    let (rows, columns) = (*rows as usize, *columns as usize);
    let before = (all - bytes.rest.len()) as u64;
    Ok(Some((name, Sparse { element, before, big_endian: bytes.big_endian, rows, columns })))
}

/// Reads the first of these variables that a file has, as a matrix with up to `most` rows and columns.
///
/// # Errors
/// No MATLAB file of version 5, none of the variables, a larger matrix; a file that is cut short.
pub fn matrix(path: &Path, variables: &[&str], most: usize) -> io::Result<DMatrix<f64>> {
    let mut file = File::open(path)?;
    let (names, all) = list(&mut file, |bytes, element| {
        Ok(match sparse(bytes, element)? {
            Some((name, found)) => Some((name, Matrix::Sparse(found))),
            None => vector(bytes, element)?.map(|(name, found)| (name, Matrix::Full(found))),
        })
    })?;
    let place = variables.iter().find_map(|name| names.iter().position(|found| found == name));
    let vector = match place.and_then(|place| all.get(place)) {
        Some(Matrix::Full(vector)) => vector,
        Some(Matrix::Sparse(sparse)) => return sparse.load(&mut file, most),
        None => {
            let found = names.join(", ");
            return Err(refuse(format!("no matrix {} among its variables: {found}", variables.join(" or "))));
        }
    };
    let (number, bytes) = vector.load(&mut file)?;
    if vector.count * 8 > LARGEST {
        return Err(refuse(format!("{} numbers, more than fit", vector.count)));
    }
    let size = usize::from(number.bytes);
    let values: Vec<f64> = bytes.chunks_exact(size).map(|bytes| number.read(bytes)).collect();
    let rows = vector.rows as usize;
    let columns = values.len() / rows.max(1);
    if rows.max(columns) > most {
        return Err(too_large(rows, columns, most));
    }
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
        // A row number and a value for each element, columns, and three heads with what fills them up.
        let longest = self.before + 12 * (rows * columns) as u64 + 4 * columns as u64 + 64;
        let mut bytes = Vec::new();
        self.element.open(file)?.take(longest).read_to_end(&mut bytes)?;
        let mut bytes = Bytes { rest: &bytes, big_endian: self.big_endian };
        bytes.take(self.before)?;
        let mut numbers = || -> io::Result<Vec<f64>> {
            let (kind, bytes_of) = part(&mut bytes)?;
            let number = number(kind, self.big_endian).ok_or_else(|| refuse("a sparse matrix of no numbers"))?;
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

impl Vector {
    /// Reads its numbers.
    fn load(&self, file: &mut File) -> io::Result<(Number, Vec<u8>)> {
        let mut source = self.element.open(file)?;
        io::copy(&mut source.by_ref().take(self.before), &mut io::sink())?;
        let length = self.count * u64::from(self.number.bytes);
        let mut bytes = Vec::new();
        source.take(length).read_to_end(&mut bytes)?;
        if bytes.len() as u64 != length {
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

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let named = |place: &usize| Some((self.names.get(*place)?.as_str(), self.all.get(*place)?));
        let lengths: Vec<_> = places.iter().filter_map(named).map(|(name, vector)| (name, vector.count)).collect();
        self.rows = equal_lengths(&self.path, &lengths)?;
        let bytes = places.iter().filter_map(|place| self.all.get(*place));
        let bytes: u64 = bytes.map(|vector| vector.count * u64::from(vector.number.bytes)).sum();
        if bytes > LARGEST {
            return Err(wrong(&self.path, &refuse(format!("{bytes} bytes of vectors, more than {LARGEST}"))));
        }
        let loaded = places.iter().map(|place| self.load(*place)).collect::<io::Result<_>>();
        self.selected = loaded.map_err(|cause| wrong(&self.path, &cause))?;
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        if self.row == self.rows {
            return Ok(false);
        }
        cells.values.clear();
        for (number, bytes) in &self.selected {
            let at = self.row as usize * usize::from(number.bytes);
            cells.values.push(number.read(bytes.get(at..).unwrap_or_default()));
        }
        self.row += 1;
        (cells.line, cells.whole) = (self.row, self.names.len());
        Ok(true)
    }

    fn bytes_read(&self) -> u64 {
        self.bytes_read
    }
}
