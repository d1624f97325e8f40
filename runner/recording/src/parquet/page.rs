//! Checks of page headers before the library allocates memory for their sizes.

use ballrace_base::bounded::open_regular;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use ::parquet::basic::Type as Physical;
use ::parquet::errors::{ParquetError, Result as Decoded};
use ::parquet::file::metadata::ColumnChunkMetaData;

/// Largest page when unpacked; writers make them of a megabyte.
const LARGEST: i64 = 1 << 28;
/// Deepest nesting of structures; a page header has three levels.
const DEEPEST: u8 = 8;

/// Fields of a page header, `[parent, own]`: 0 is the page header itself.
const UNPACKED: [i64; 2] = [0, 2];
const PACKED: [i64; 2] = [0, 3];
const DICTIONARY_VALUES: [i64; 2] = [7, 1];

/// Checks the pages of a column in a row group; returns their size in bytes.
pub(super) fn check(path: &Path, chunk: &ColumnChunkMetaData) -> Decoded<u64> {
    let start = chunk.dictionary_page_offset().unwrap_or(chunk.data_page_offset());
    let declared = (u64::try_from(start).ok(), u64::try_from(chunk.compressed_size()).ok());
    let (Some(start), Some(length)) = declared else { return Err(implausible("a column before its beginning")) };
    let mut file = open_regular(path)?;
    if start.checked_add(length).is_none_or(|end| file.metadata().is_ok_and(|about| about.len() < end)) {
        return Err(implausible("a column that extends beyond the file"));
    }
    file.seek(SeekFrom::Start(start))?;
    let width = if matches!(chunk.column_type(), Physical::INT32 | Physical::FLOAT) { 4 } else { 8 };
    let mut pages = BufReader::new(file).take(length);
    while pages.limit() > 0 {
        let mut fields = Vec::new();
        structure(&mut pages, 0, 0, &mut fields)?;
        let field = |wanted: [i64; 2]| fields.iter().find(|(place, _)| *place == wanted).map_or(0, |(_, value)| *value);
        let (packed, unpacked) = (field(PACKED), field(UNPACKED));
        if !(0..=LARGEST).contains(&unpacked) || field(DICTIONARY_VALUES) > unpacked / width {
            return Err(implausible(&format!("a page of {unpacked} bytes")));
        }
        match u64::try_from(packed) {
            Ok(packed) if packed <= pages.limit() => {
                let inner = pages.get_mut();
                inner.seek_relative(packed.cast_signed())?;
                let left = pages.limit() - packed;
                pages.set_limit(left);
            }
            _ => return Err(implausible(&format!("a page of {packed} bytes"))),
        }
    }
    Ok(length)
}

fn implausible(found: &str) -> ParquetError {
    ParquetError::General(found.into())
}

fn byte(from: &mut impl Read) -> io::Result<u8> {
    let mut byte = [0];
    from.read_exact(&mut byte)?;
    Ok(byte[0])
}

/// Reads a whole number in groups of seven bits, the lowest first.
fn varint(from: &mut impl Read) -> io::Result<u64> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let group = byte(from)?;
        value |= u64::from(group & 0x7f) << shift;
        if group & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err(io::Error::other("a number without an end"))
}

/// Reads a whole number with its sign in the lowest bit.
fn zigzag(from: &mut impl Read) -> io::Result<i64> {
    let value = varint(from)?;
    Ok((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
}

/// Reads a structure in Thrift's compact protocol and adds its whole numbers to `fields` with their place, `[parent, own]`.
fn structure(from: &mut impl Read, depth: u8, parent: i64, fields: &mut Vec<([i64; 2], i64)>) -> io::Result<()> {
    let mut id = 0_i64;
    loop {
        let head = byte(from)?;
        if head == 0 {
            return Ok(());
        }
        id = if head >> 4 == 0 { zigzag(from)? } else { id + i64::from(head >> 4) };
        match head & 0xf {
            // Whole numbers.
            4..=6 => {
                let value = zigzag(from)?;
                if depth <= 1 {
                    fields.push(([parent, id], value));
                }
            }
            // The value of a boolean is its type.
            1 | 2 => {}
            12 if depth == 0 => structure(from, depth + 1, id, fields)?,
            kind => skip(from, kind, depth)?,
        }
    }
}

fn skip(from: &mut impl Read, kind: u8, depth: u8) -> io::Result<()> {
    if depth > DEEPEST {
        return Err(io::Error::other("a page's head within a page's head"));
    }
    let mut pass = |count: u64| io::copy(&mut from.by_ref().take(count), &mut io::sink()).map(|_| ());
    match kind {
        1..=3 => pass(1),
        4..=6 => varint(from).map(|_| ()),
        7 => pass(8),
        8 => {
            let length = varint(from)?;
            io::copy(&mut from.by_ref().take(length), &mut io::sink()).map(|_| ())
        }
        9 | 10 => {
            let head = byte(from)?;
            let count = if head >> 4 == 15 { varint(from)? } else { u64::from(head >> 4) };
            (0..count).try_for_each(|_| skip(from, head & 0xf, depth + 1))
        }
        12 => structure(from, depth + 2, 0, &mut Vec::new()),
        other => Err(io::Error::other(format!("a page's head with a field of type {other}"))),
    }
}
