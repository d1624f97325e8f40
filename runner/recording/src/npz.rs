//! NPZ files as recordings: arrays of NumPy in a ZIP archive. A vector is the column `name`, a matrix the columns `name[:,0]`,
//! `name[:,1]`, ..., or `name[0,:]`, ... where its rows are channels; a structure has the columns `name.field`.
//!
//! Format: PKWARE, APPNOTE.TXT: the central directory at the end of the file lists the entries, which are stored or deflated.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use flate2::read::DeflateDecoder;

use super::bytes::Bytes;
use super::compressed;
use super::error::{RecordingError, refuse};
use super::npy::{self, Array};
use super::numbers::{Lane, Layout, Numbers};
use super::table::Table;
use ballrace_base::npy_header::NpyHeader;
use ballrace_scene::FileLayout;

const EXPECTED: &str = "an NPZ file of arrays of numbers with one or two dimensions";

/// Length of the record at the end of an archive, and of the longest comment behind it.
const END: u64 = 22;
const LONGEST_COMMENT: u64 = 1 << 16;
/// Length of the head of an entry, and of its record in the directory.
const ENTRY_HEAD: u64 = 30;
const DIRECTORY_HEAD: u64 = 46;
/// Largest directory, bytes.
const LARGEST_DIRECTORY: u64 = 1 << 24;
/// Value of a field that is stored in 64 bits elsewhere.
const LONG: u64 = 0xffff_ffff;
/// Identifier of the extra field with 64 bits.
const ZIP64: u16 = 1;
/// Largest ratio of deflate.
const TIGHTEST: u64 = 1032;
/// Methods of compression.
const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// Array in an archive.
struct Entry {
    name: String,
    method: u16,
    /// Bytes in the archive, and unpacked.
    packed: u64,
    size: u64,
    /// Offset of its head.
    start: u64,
}

/// Opens a file.
pub(super) fn open(file: File, path: &Path, layout: FileLayout) -> Result<Box<dyn Table>, RecordingError> {
    let wrong = |cause: io::Error| npy::wrong(path, &cause, EXPECTED);
    let (file, layout) = read(file, layout).map_err(wrong)?;
    Ok(Box::new(Numbers::new(file, path, layout)))
}

/// Returns the file that has the numbers: the archive where all entries are stored, else a temporary file.
fn read(mut file: File, given: FileLayout) -> io::Result<(File, Layout)> {
    let size = file.metadata()?.len();
    let mut entries = entries(&mut file, size)?;
    for entry in &mut entries {
        entry.start = content(&mut file, entry, size)?;
    }
    if entries.iter().any(|entry| entry.method != STORED) {
        file = unpacked(file, &mut entries, size)?;
    }
    let mut layout = Layout::of(Vec::new(), EXPECTED);
    for Entry { name, start, .. } in entries {
        file.seek(SeekFrom::Start(start))?;
        let header = NpyHeader::read(&mut file)?;
        let array = Array::new(header, file.stream_position()?, given.orientation);
        // An array of other dimensions or types does not prevent reading the others.
        let Ok(array) = array else { continue };
        let (dimensions, is_channels_first) = (array.dimensions, array.is_channels_first);
        if let Some(run) = array.scalar() {
            layout.scalars.push((name, run));
            continue;
        }
        layout.notes.extend(array.note(&format!("Array {name}")));
        let Ok(lanes) = array.lanes() else { continue };
        layout.lanes.extend(lanes.into_iter().enumerate().map(|(place, lane)| {
            let name = match (dimensions, lane.name.as_str()) {
                (_, field) if !field.is_empty() => format!("{name}.{field}"),
                (2, _) if is_channels_first => format!("{name}[{place},:]"),
                (2, _) => format!("{name}[:,{place}]"),
                _ => name.clone(),
            };
            Lane { name, ..lane }
        }));
    }
    if layout.lanes.is_empty() {
        return Err(refuse("no array of numbers"));
    }
    Ok((file, layout))
}

const fn little(bytes: &[u8]) -> Bytes<'_> {
    Bytes { rest: bytes, big_endian: false }
}

fn read_at(file: &mut File, start: u64, length: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(start))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

/// Reads the central directory; entries that are no arrays are omitted.
fn entries(file: &mut File, size: u64) -> io::Result<Vec<Entry>> {
    let tail = size.min(END + LONGEST_COMMENT);
    let bytes = read_at(file, size - tail, tail)?;
    let end = bytes.windows(4).rposition(|letters| letters == b"PK\x05\x06");
    let end = end.and_then(|at| bytes.get(at..)).ok_or_else(|| refuse("an archive without its directory"))?;
    let mut end = little(end);
    end.take(12)?;
    let (length, start, comment) = (u64::from(end.u32()?), u64::from(end.u32()?), end.u16()?);
    end.take(comment.into())?;
    if start == LONG || length > LARGEST_DIRECTORY || start.saturating_add(length) > size {
        return Err(refuse(format!("an archive with a directory of {length} bytes at {start}")));
    }
    let directory = read_at(file, start, length)?;
    let mut rest = little(&directory);
    let mut all = Vec::new();
    while rest.rest.len() as u64 >= DIRECTORY_HEAD {
        if rest.take(4)? != b"PK\x01\x02" {
            return Err(refuse("an archive with a malformed directory"));
        }
        rest.take(4)?;
        let (flags, method) = (rest.u16()?, rest.u16()?);
        rest.take(8)?;
        let (mut packed, mut size) = (u64::from(rest.u32()?), u64::from(rest.u32()?));
        let [name, extra, comment] = [rest.u16()?, rest.u16()?, rest.u16()?].map(u64::from);
        rest.take(8)?;
        let mut start = u64::from(rest.u32()?);
        let name = String::from_utf8_lossy(rest.take(name)?).into_owned();
        let mut extra = little(rest.take(extra)?);
        rest.take(comment)?;
        while extra.rest.len() >= 4 {
            let (kind, length) = (extra.u16()?, extra.u16()?);
            let mut own = little(extra.take(length.into())?);
            for field in [&mut size, &mut packed, &mut start] {
                if kind == ZIP64 && *field == LONG {
                    *field = own.u64()?;
                }
            }
        }
        const ENCRYPTED: u16 = 1;
        let Some(name) = name.strip_suffix(".npy") else { continue };
        if flags & ENCRYPTED != 0 || ![STORED, DEFLATED].contains(&method) {
            return Err(refuse(format!("`{name}` compressed by method {method}, or encrypted")));
        }
        all.push(Entry { name: name.to_owned(), method, packed, size, start });
    }
    Ok(all)
}

/// Returns the offset of the content of an entry, which lies within the file.
fn content(file: &mut File, entry: &Entry, size: u64) -> io::Result<u64> {
    let head = read_at(file, entry.start, ENTRY_HEAD)?;
    let mut head = little(&head);
    if head.take(4)? != b"PK\x03\x04" {
        return Err(refuse(format!("no entry `{}` at byte {}", entry.name, entry.start)));
    }
    head.take(22)?;
    let start = entry.start + ENTRY_HEAD + u64::from(head.u16()?) + u64::from(head.u16()?);
    if start.checked_add(entry.packed).is_none_or(|end| end > size) {
        return Err(refuse(format!("an archive that is truncated within `{}`", entry.name)));
    }
    Ok(start)
}

/// Unpacks all entries of an archive of `packed` bytes into a temporary file, and sets their offsets there.
fn unpacked(mut file: File, entries: &mut [Entry], packed: u64) -> io::Result<File> {
    // Before anything is written. An entry that is longer than its size is refused.
    let total = entries.iter().fold(0, |total: u64, entry| total.saturating_add(entry.size));
    let most = compressed::largest(packed);
    if total > most {
        return Err(refuse(format!("{total} bytes when unpacked, more than {most}")));
    }
    let mut to = tempfile::tempfile()?;
    if let Some(found) = compressed::lacks_space(&to, total, 0)? {
        return Err(refuse(found));
    }
    for entry in entries {
        let start = to.stream_position()?;
        file.seek(SeekFrom::Start(entry.start))?;
        let source = (&mut file).take(entry.packed);
        let most = entry.size.min(entry.packed.saturating_mul(TIGHTEST).saturating_add(TIGHTEST));
        let mut source: Box<dyn Read> = match entry.method {
            DEFLATED => Box::new(DeflateDecoder::new(io::BufReader::new(source))),
            _ => Box::new(source),
        };
        let count = io::copy(&mut source.by_ref().take(most), &mut to)?;
        if count != entry.size {
            return Err(refuse(format!("`{}` of {} bytes instead of {}", entry.name, count, entry.size)));
        }
        entry.start = start;
    }
    to.flush()?;
    Ok(to)
}
