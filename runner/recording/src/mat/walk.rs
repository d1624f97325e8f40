//! Arrays of numbers in a MATLAB file (version 5): variables, fields of structures, elements of cell arrays.
//!
//! Format: MathWorks, MAT-File Format (level 5). A structure holds its field names and one array for each field of each
//! element; a cell array holds one array for each element. Elements are in column-major order.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};

use flate2::read::ZlibDecoder;

use super::{Matrix, Sparse, Vector, refuse};
use crate::bytes::Bytes;
use crate::numbers::{Kind, Number};
use ballrace_base::printable::name;

/// Bytes of text, version and byte order before the first variable.
const HEADER: u64 = 128;
/// Bytes before the name of the first variable of version 4.
const VERSION_4_HEADER: u64 = 20;
/// Largest compression ratio of deflate.
const TIGHTEST: u64 = 1032;
/// Largest number of dimensions of an array.
const MAX_DIMENSIONS: u64 = 32;
/// Longest path of an array, and longest list of field names, bytes.
const LONGEST_PATH: usize = 1024;
const LONGEST_FIELDS: u64 = 1 << 20;
/// Maximum nesting depth of structures and cell arrays.
const DEEPEST: usize = 16;
/// Largest number of arrays of numbers, and of arrays of any class, in a file.
const MAX_FOUND: usize = 1 << 16;
const MAX_ARRAYS: u64 = 1 << 20;

/// Classes of arrays.
const CELL: u32 = 1;
const STRUCTURE: u32 = 2;
const SPARSE: u32 = 5;
const NUMBERS: core::ops::RangeInclusive<u32> = 6..=15;
/// Flag of complex numbers.
const COMPLEX: u32 = 0x800;

/// Types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
const LAST_TYPE: u32 = 18;

/// A piece of the file with a type of its own.
#[derive(Clone, Copy)]
pub(super) struct Element {
    kind: u32,
    start: u64,
    pub(super) length: u64,
}

impl Element {
    /// Returns its bytes, unpacked.
    pub(super) fn open<'a>(&self, file: &'a mut File) -> io::Result<Box<dyn Read + 'a>> {
        file.seek(SeekFrom::Start(self.start))?;
        let bytes = BufReader::new(file.take(self.length));
        Ok(if self.kind == COMPRESSED { Box::new(BufReader::new(ZlibDecoder::new(bytes))) } else { Box::new(bytes) })
    }

    /// Returns the largest number of bytes that can be in it.
    const fn most(&self) -> u64 {
        self.length.saturating_mul(if self.kind == COMPRESSED { TIGHTEST } else { 1 })
    }
}

/// Returns the arrays of real numbers of a file with their paths, such as `bearing.gs` or `N09.Y(7).Data`.
///
/// # Errors
/// Another format, a file that is truncated, an array whose size contradicts its dimensions.
pub(super) fn arrays(file: &mut File) -> io::Result<Vec<(String, Matrix)>> {
    let size = file.metadata()?.len();
    let mut header = [0; HEADER as usize];
    if size >= VERSION_4_HEADER {
        file.read_exact(header.get_mut(..VERSION_4_HEADER as usize).unwrap_or_default())?;
        if is_version_4(&header) {
            return Err(refuse("a MATLAB file of version 4 (save it with -v7)"));
        }
    }
    file.seek(SeekFrom::Start(0))?;
    file.read_exact(&mut header)?;
    if header.starts_with(b"MATLAB 7.3") {
        return Err(refuse("a MATLAB file of version 7.3, which is HDF5 (save it with -v7)"));
    }
    let big_endian = match header.last_chunk() {
        Some([0, 1, b'I', b'M']) => false,
        Some([1, 0, b'M', b'I']) => true,
        _ => {
            let text: String = header.iter().take(40).map(|byte| char::from(*byte)).collect();
            return Err(refuse(format!("no MATLAB file of version 5, but a file that begins with `{}`", name(&text))));
        }
    };
    let (mut start, mut found, mut arrays) = (HEADER, Vec::new(), 0);
    while start < size {
        let element = next_element(file, start, size, big_endian)?;
        start = element.start + element.length;
        if element.length > 0 && (element.kind == MATRIX || element.kind == COMPRESSED) {
            let source = element.open(file)?;
            let mut walk = Walk { source, at: 0, big_endian, element, found, arrays };
            walk.variable()?;
            (found, arrays) = (walk.found, walk.arrays);
        }
    }
    Ok(found)
}

/// Returns true for the first variable of version 4: machine and type, rows, columns, imaginary part, length of the name.
fn is_version_4(header: &[u8]) -> bool {
    let word = |place: usize, big_endian: bool| {
        let bytes = header.get(4 * place..).and_then(|rest| rest.first_chunk()).copied().unwrap_or_default();
        if big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
    };
    [false, true].into_iter().any(|order| {
        let kind = word(0, order);
        // Thousands: byte order; tens: type of the numbers; ones: full, text or sparse.
        let is_kind = kind / 1000 == u32::from(order) && kind / 100 % 10 == 0 && kind / 10 % 10 <= 5 && kind % 10 <= 2;
        is_kind && word(3, order) <= 1 && (2..=64).contains(&word(4, order)) && word(1, order).max(word(2, order)) > 0
    })
}

fn next_element(file: &mut File, start: u64, size: u64, big_endian: bool) -> io::Result<Element> {
    let mut tag = [0; 8];
    file.seek(SeekFrom::Start(start))?;
    file.read_exact(&mut tag)?;
    let mut tag = Bytes { rest: &tag, big_endian };
    let (kind, length, start) = (tag.u32()?, u64::from(tag.u32()?), start + 8);
    if kind == 0 || kind > LAST_TYPE {
        return Err(refuse(format!("no variable at byte {}", start - 8)));
    }
    if length > size - start {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(Element { kind, start, length })
}

/// Class, lengths and name of an array.
struct Head {
    class: u32,
    is_complex: bool,
    lengths: Vec<u64>,
    name: String,
}

/// Reader of one variable.
struct Walk<'a> {
    source: Box<dyn Read + 'a>,
    /// Number of bytes read.
    at: u64,
    big_endian: bool,
    element: Element,
    found: Vec<(String, Matrix)>,
    /// Number of arrays of any class.
    arrays: u64,
}

impl Walk<'_> {
    fn variable(&mut self) -> io::Result<()> {
        if self.element.kind == COMPRESSED {
            let (kind, _length) = (self.u32()?, self.u32()?);
            if kind != MATRIX {
                return Ok(());
            }
        }
        let Some(head) = self.head()? else { return Ok(()) };
        let name = head.name.clone();
        if name.is_empty() { Ok(()) } else { self.content(&head, name, 0) }
    }

    /// Reads an array within another; nothing where it is empty.
    fn nested(&mut self, path: String, depth: usize) -> io::Result<()> {
        let (kind, length) = (self.u32()?, u64::from(self.u32()?));
        self.arrays += 1;
        if kind != MATRIX || depth > DEEPEST || path.len() > LONGEST_PATH || self.arrays > MAX_ARRAYS {
            let path: String = path.chars().take(80).collect();
            return Err(refuse(format!("no readable array at `{path}`")));
        }
        let end = self.at.saturating_add(length);
        if length > 0
            && let Some(head) = self.head()?
        {
            self.content(&head, path, depth)?;
        }
        match end.checked_sub(self.at) {
            Some(rest) => self.skip(rest),
            None => Err(refuse(format!("an array that is longer than its {length} bytes"))),
        }
    }

    fn content(&mut self, head: &Head, path: String, depth: usize) -> io::Result<()> {
        let count = head.lengths.iter().fold(1_u64, |count, length| count.saturating_mul(*length));
        match head.class {
            CELL => (1..=count).try_for_each(|index| self.nested(format!("{path}{{{index}}}"), depth + 1)),
            STRUCTURE => self.structure(&path, count, depth),
            SPARSE if !head.is_complex => {
                if let [rows, columns] = *head.lengths {
                    let (rows, columns) = (rows as usize, columns as usize);
                    let (element, before, big_endian) = (self.element, self.at, self.big_endian);
                    self.add(path, Matrix::Sparse(Sparse { element, before, big_endian, rows, columns }))?;
                }
                Ok(())
            }
            class if NUMBERS.contains(&class) && !head.is_complex && count > 0 => self.numbers(head, path, count),
            _ => Ok(()),
        }
    }

    /// Reads the fields of each element of a structure array.
    fn structure(&mut self, path: &str, count: u64, depth: usize) -> io::Result<()> {
        let length = self.part(8)?;
        let length = u64::from(Bytes { rest: &length, big_endian: self.big_endian }.u32()?);
        let names = self.part(LONGEST_FIELDS)?;
        if length == 0 {
            return Err(refuse(format!("field names of no length in `{path}`")));
        }
        let names: Vec<String> = names
            .chunks(usize::try_from(length).unwrap_or(usize::MAX))
            .map(|name| String::from_utf8_lossy(name.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned())
            .collect();
        if names.is_empty() {
            return Ok(());
        }
        for index in 1..=count {
            for name in &names {
                let own = if count == 1 { format!("{path}.{name}") } else { format!("{path}({index}).{name}") };
                self.nested(own, depth + 1)?;
            }
        }
        Ok(())
    }

    fn numbers(&mut self, head: &Head, path: String, count: u64) -> io::Result<()> {
        let shape = match head.lengths.as_slice() {
            [rows, columns] => Some([*rows, *columns]),
            lengths => {
                let mut long = lengths.iter().filter(|length| **length > 1);
                match (long.next(), long.next(), long.next()) {
                    (rows, columns, None) => Some([rows, columns].map(|length| length.copied().unwrap_or(1))),
                    _ => None,
                }
            }
        };
        let (kind, length) = self.part_head()?;
        let Some((number, [rows, columns])) = number(kind, self.big_endian).zip(shape) else { return Ok(()) };
        let (element, before) = (self.element, self.at);
        if count.checked_mul(number.bytes.into()) != Some(length) || before.saturating_add(length) > element.most() {
            return Err(refuse(format!("{count} numbers in {length} bytes for `{path}`")));
        }
        self.add(path, Matrix::Full(Vector { element, before, number, rows, columns, first: 0, stride: 1, count }))
    }

    fn add(&mut self, path: String, matrix: Matrix) -> io::Result<()> {
        if self.found.len() == MAX_FOUND {
            return Err(refuse(format!("more than {MAX_FOUND} arrays")));
        }
        self.found.push((path, matrix));
        Ok(())
    }

    /// Reads the head of an array; nothing where its class has another form.
    fn head(&mut self) -> io::Result<Option<Head>> {
        let flags = self.part(64)?;
        let flags = Bytes { rest: &flags, big_endian: self.big_endian }.u32()?;
        let (is_complex, class) = (flags & COMPLEX != 0, flags & 0xff);
        if ![CELL, STRUCTURE, SPARSE].contains(&class) && !NUMBERS.contains(&class) {
            return Ok(None);
        }
        let dimensions = self.part(4 * MAX_DIMENSIONS)?;
        let mut dimensions = Bytes { rest: &dimensions, big_endian: self.big_endian };
        let mut lengths = Vec::new();
        while !dimensions.rest.is_empty() {
            lengths.push(dimensions.u32()?.into());
        }
        let name = self.part(LONGEST_PATH as u64)?;
        Ok(Some(Head { class, is_complex, lengths, name: String::from_utf8_lossy(&name).into_owned() }))
    }

    /// Returns the bytes of a part of an array and skips its padding.
    fn part(&mut self, most: u64) -> io::Result<Vec<u8>> {
        let start = self.at;
        let (_, length) = self.part_head()?;
        if length > most {
            return Err(refuse(format!("a part of {length} bytes in the head of an array")));
        }
        let mut own = Vec::new();
        self.source.by_ref().take(length).read_to_end(&mut own)?;
        if own.len() as u64 != length {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.at += length;
        let used = self.at - start;
        self.skip(used.next_multiple_of(8) - used)?;
        Ok(own)
    }

    /// Returns type and length of a part of an array. In its short form both are in four bytes.
    fn part_head(&mut self) -> io::Result<(u32, u64)> {
        let kind = self.u32()?;
        match kind >> 16 {
            0 => Ok((kind, self.u32()?.into())),
            length => Ok((kind & 0xffff, length.into())),
        }
    }

    fn u32(&mut self) -> io::Result<u32> {
        let mut bytes = [0; 4];
        self.source.read_exact(&mut bytes)?;
        self.at += 4;
        Ok(if self.big_endian { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    fn skip(&mut self, count: u64) -> io::Result<()> {
        let skipped = io::copy(&mut self.source.by_ref().take(count), &mut io::sink())?;
        self.at += skipped;
        if skipped == count { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }
}

/// Returns the form of numbers of this type of element.
pub(super) fn number(kind: u32, big_endian: bool) -> Option<Number> {
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
