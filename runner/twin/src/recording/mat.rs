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

const ALLOWED: &str = "a MATLAB file of version 5 with vectors of equal length";

/// Bytes of text, version and byte order before the first variable.
const HEADER: u64 = 128;
/// Bytes of a variable within which its name and size are.
const ABOUT: u64 = 4096;
/// Largest number of bytes of all vectors, which are held in memory.
const LARGEST: u64 = 1 << 30;
/// Largest compression ratio of deflate.
const TIGHTEST: u64 = 1032;

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
    let (names, all) = list(&mut file, |vector| vector.is_vector).map_err(|cause| wrong(path, &cause))?;
    let (path, selected) = (path.into(), Vec::new());
    Ok(Box::new(Vectors { path, file, names, all, selected, rows: 0, row: 0, bytes_read: 0 }))
}

fn wrong(path: &Path, cause: &io::Error) -> RecordingError {
    let found = match cause.kind() {
        io::ErrorKind::UnexpectedEof => "a file that is cut short".into(),
        _ => cause.to_string(),
    };
    RecordingError::Format { file: path.into(), found, allowed: ALLOWED }
}

fn refuse(found: impl Into<String>) -> io::Error {
    io::Error::other(found.into())
}

/// Names and places of all arrays of numbers that are wanted.
fn list(file: &mut File, is_wanted: impl Fn(&Vector) -> bool) -> io::Result<(Vec<String>, Vec<Vector>)> {
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
            let found = vector(Bytes { rest: &about, big_endian }, element)?;
            if let Some((name, vector)) = found.filter(|(_, vector)| is_wanted(vector)) {
                names.push(name);
                all.push(vector);
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

/// Name and numbers of a variable; nothing where it is no array of real numbers.
fn vector(mut bytes: Bytes<'_>, element: Element) -> io::Result<Option<(String, Vector)>> {
    let all = bytes.rest.len();
    if element.kind == COMPRESSED {
        let (kind, _length) = (bytes.u32()?, bytes.u32()?);
        if kind != MATRIX {
            return Ok(None);
        }
    }
    let (_, flags) = part(&mut bytes)?;
    let flags = Bytes { rest: flags, ..bytes }.u32()?;
    let (complex, class) = (flags & 0x800 != 0, flags & 0xff);
    if complex || !(6..=15).contains(&class) {
        return Ok(None);
    }
    let (_, dimensions) = part(&mut bytes)?;
    let mut dimensions = Bytes { rest: dimensions, ..bytes };
    let (mut count, mut long, mut rows) = (1_u64, 0, None);
    while !dimensions.rest.is_empty() {
        let length = dimensions.u32()?;
        count = count.saturating_mul(length.into());
        long += u32::from(length > 1);
        rows.get_or_insert(u64::from(length));
    }
    let (_, name) = part(&mut bytes)?;
    let name = String::from_utf8_lossy(name).into_owned();
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

/// Reads the first of these variables that a file has, as a matrix.
///
/// # Errors
/// No MATLAB file of version 5, none of the variables; a file that is cut short.
pub fn matrix(path: &Path, variables: &[&str]) -> io::Result<DMatrix<f64>> {
    let mut file = File::open(path)?;
    let (names, all) = list(&mut file, |_| true)?;
    let place = variables.iter().find_map(|name| names.iter().position(|found| found == name));
    let Some(vector) = place.and_then(|place| all.get(place)) else {
        let found = names.join(", ");
        return Err(refuse(format!("no full matrix {} among its variables: {found}", variables.join(" or "))));
    };
    let (number, bytes) = vector.load(&mut file)?;
    if vector.count * 8 > LARGEST {
        return Err(refuse(format!("{} numbers, more than fit", vector.count)));
    }
    let size = usize::from(number.bytes);
    let values: Vec<f64> = bytes.chunks_exact(size).map(|bytes| number.read(bytes)).collect();
    let rows = vector.rows as usize;
    Ok(DMatrix::from_column_slice(rows, values.len() / rows.max(1), &values))
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
