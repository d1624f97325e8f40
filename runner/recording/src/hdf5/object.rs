//! Object headers: the messages of a group or dataset.

use std::io;

use super::{Source, UNDEFINED, little, refuse};
use crate::bytes::Bytes;
use crate::numbers::{Kind, Number};

/// Largest number of blocks and of bytes of an object header.
const MAX_BLOCKS: usize = 1024;
const MAX_BYTES: u64 = 1 << 20;
/// Largest number of dimensions.
const MAX_DIMENSIONS: u8 = 32;

/// Types of messages.
const DATASPACE: u16 = 0x01;
const LINK_INFO: u16 = 0x02;
const DATATYPE: u16 = 0x03;
const LINK: u16 = 0x06;
const LAYOUT: u16 = 0x08;
const FILTERS: u16 = 0x0b;
const ATTRIBUTE: u16 = 0x0c;
const CONTINUATION: u16 = 0x10;
const SYMBOL_TABLE: u16 = 0x11;
/// Flag of a message that is stored elsewhere.
const SHARED: u8 = 2;

/// Identifiers of filters.
const DEFLATE: u16 = 1;
const SHUFFLE: u16 = 2;
const FLETCHER32: u16 = 3;

/// Filters that cannot be reversed here, with their names.
const FILTER_NAMES: [(u16, &str); 10] = [
    (4, "szip"),
    (5, "n-bit"),
    (6, "scale-offset"),
    (307, "bzip2"),
    (32000, "LZF"),
    (32001, "Blosc"),
    (32004, "LZ4"),
    (32008, "bitshuffle"),
    (32015, "Zstandard"),
    (32026, "Blosc2"),
];
/// Largest nesting of types.
const DEEPEST_TYPE: usize = 8;

/// Filter of chunks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Filter {
    Deflate,
    Shuffle,
    /// Checksum of four bytes at the end.
    Fletcher32,
}

/// Index of the chunks of a dataset with its address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ChunkIndex {
    /// B-tree of version 1.
    Tree,
    /// One chunk without an index; with filters its length and the mask of filters that are left out.
    Single(Option<(u64, u32)>),
    /// All chunks one after the other.
    Implicit,
    FixedArray,
    ExtensibleArray,
    /// B-tree of version 2.
    SecondTree,
}

/// Chunks of a dataset.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chunking {
    pub(super) index: ChunkIndex,
    /// Address of the index, or of the first chunk.
    pub(super) address: u64,
    /// Lengths of a chunk.
    pub(super) lengths: Vec<u64>,
    /// Chunks beyond the end of a dimension have no filters.
    pub(super) has_plain_edges: bool,
}

/// Place of the numbers of a dataset.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Layout {
    Compact(Vec<u8>),
    Contiguous { address: u64 },
    Chunked(Chunking),
}

/// Type of the elements.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Type {
    Number(Number),
    /// Fields with name, offset and number, or the reason for which it cannot be read.
    Compound(Vec<(String, u64, Result<Number, String>)>),
    /// Address of another object.
    Reference,
}

/// A dataset of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dataset {
    pub(super) number: Number,
    /// Bytes of an element, and those before its number.
    pub(super) width: u64,
    pub(super) offset: u64,
    pub(super) lengths: Vec<u64>,
    /// Lengths up to which the dimensions may grow; `u64::MAX` without a limit.
    pub(super) largest: Vec<u64>,
    pub(super) layout: Layout,
    pub(super) filters: Vec<Filter>,
}

impl Dataset {
    /// Returns the length of a dimension.
    pub(super) fn length(&self, along: usize) -> u64 {
        self.lengths.get(along).copied().unwrap_or(1)
    }
}

/// Content of an object header, as far as it is used.
#[derive(Debug, Default)]
pub(super) struct Object {
    pub(super) kind: Option<Type>,
    /// Bytes of an element.
    width: u64,
    pub(super) lengths: Option<Vec<u64>>,
    /// Lengths up to which the dimensions may grow.
    largest: Vec<u64>,
    pub(super) layout: Option<Layout>,
    pub(super) filters: Vec<Filter>,
    /// Names and addresses.
    pub(super) links: Vec<(String, u64)>,
    /// Addresses of B-tree and local heap of a group.
    pub(super) symbols: Option<[u64; 2]>,
    /// Addresses of fractal heap and B-tree of a group.
    pub(super) dense: Option<[u64; 2]>,
    /// Names of attributes with their text.
    pub(super) texts: Vec<(String, String)>,
    /// Names of attributes with their number.
    pub(super) numbers: Vec<(String, f64)>,
    /// Reason for which its numbers cannot be read.
    refused: Option<String>,
}

impl Object {
    /// Reads the messages of an object.
    pub(super) fn read(source: &mut Source, address: u64) -> io::Result<Self> {
        let mut object = Self::default();
        let begin = source.read(address, 16)?;
        let mut blocks = Vec::new();
        let mut head = little(&begin);
        let modern = begin.starts_with(b"OHDR");
        let mut has_order = false;
        if modern {
            head.take(5)?;
            let flags = head.u8()?;
            has_order = flags & 0x04 != 0;
            let times = if flags & 0x20 == 0 { 0 } else { 16 };
            let phases = if flags & 0x10 == 0 { 0 } else { 4 };
            let width = 1 << (flags & 3);
            let before = 6 + times + phases;
            let length = little(&source.read(address + before, width)?).little(width)?;
            blocks.push((address.saturating_add(before + width), length));
        } else {
            let version = head.u8()?;
            if version != 1 {
                return Err(refuse(format!("no object header at address {address}")));
            }
            head.take(7)?;
            blocks.push((address.saturating_add(16), head.u32()?.into()));
        }
        let (mut next, mut total) = (0, 0_u64);
        while let Some(&(start, length)) = blocks.get(next) {
            next += 1;
            total = total.saturating_add(length);
            if next > MAX_BLOCKS || total > MAX_BYTES {
                return Err(refuse(format!("an object header of more than {MAX_BYTES} bytes")));
            }
            let bytes = source.read(start, length)?;
            object.block(&bytes, modern.then_some(has_order), &mut blocks)?;
        }
        Ok(object)
    }

    /// Reads a block of messages; `modern` is the second form, with or without orders of creation.
    fn block(&mut self, bytes: &[u8], modern: Option<bool>, blocks: &mut Vec<(u64, u64)>) -> io::Result<()> {
        let mut rest = little(bytes);
        let (least, with_order) = match modern {
            None => (8, false),
            Some(order) => (if order { 6 } else { 4 }, order),
        };
        while rest.rest.len() >= least {
            let kind = if modern.is_some() { rest.u8()?.into() } else { rest.u16()? };
            let length = rest.u16()?;
            let flags = rest.u8()?;
            rest.take(if modern.is_none() {
                3
            } else if with_order {
                2
            } else {
                0
            })?;
            // The end of a block may be less than a message.
            if u64::from(length) > rest.rest.len() as u64 {
                break;
            }
            let own = little(rest.take(length.into())?);
            if kind == CONTINUATION {
                let mut own = own;
                let (start, length) = (own.u64()?, own.u64()?);
                // A block of the second form has four letters before and a checksum behind.
                blocks.push(match modern {
                    None => (start, length),
                    Some(_) => (start.saturating_add(4), length.saturating_sub(8)),
                });
            } else if flags & SHARED == 0 {
                self.message(kind, own)?;
            } else if kind == DATATYPE {
                self.refused = Some("a type of its own name".to_owned());
            }
        }
        Ok(())
    }

    fn message(&mut self, kind: u16, mut bytes: Bytes<'_>) -> io::Result<()> {
        match kind {
            DATASPACE => {
                let (lengths, largest) = dataspace(bytes)?.unzip();
                (self.lengths, self.largest) = (lengths, largest.unwrap_or_default());
            }
            DATATYPE => {
                self.width = little(bytes.rest.get(4..).unwrap_or_default()).u32()?.into();
                match datatype(&mut bytes, 0)? {
                    Ok(kind) => self.kind = Some(kind),
                    Err(reason) => self.refused = Some(reason),
                }
            }
            LAYOUT => match layout(bytes)? {
                Ok(layout) => self.layout = Some(layout),
                Err(reason) => self.refused = Some(reason),
            },
            FILTERS => match filters(bytes)? {
                Ok(filters) => self.filters = filters,
                Err(reason) => self.refused = Some(reason),
            },
            LINK => self.links.extend(link(bytes)?),
            SYMBOL_TABLE => self.symbols = Some([bytes.u64()?, bytes.u64()?]),
            LINK_INFO => {
                let (_version, flags) = (bytes.u8()?, bytes.u8()?);
                bytes.take(if flags & 1 == 0 { 0 } else { 8 })?;
                let (heap, tree) = (bytes.u64()?, bytes.u64()?);
                self.dense = (heap != UNDEFINED && tree != UNDEFINED).then_some([heap, tree]);
            }
            // An attribute that cannot be read has no effect on the numbers.
            ATTRIBUTE => drop(self.attribute(bytes)),
            _ => {}
        }
        Ok(())
    }

    fn attribute(&mut self, mut bytes: Bytes<'_>) -> io::Result<()> {
        let version = bytes.u8()?;
        bytes.take(1)?;
        let lengths = [bytes.u16()?, bytes.u16()?, bytes.u16()?].map(u64::from);
        bytes.take(if version == 3 { 1 } else { 0 })?;
        let mut part = |length: u64| {
            let own = bytes.take(length)?;
            if version == 1 {
                bytes.take(length.next_multiple_of(8) - length)?;
            }
            io::Result::Ok(own)
        };
        let [name, kind, space] = [part(lengths[0])?, part(lengths[1])?, part(lengths[2])?];
        let name = text(name);
        let single = dataspace(little(space))?.is_some_and(|(lengths, _)| lengths.iter().all(|length| *length == 1));
        const STRING: u8 = 3;
        match (datatype(&mut little(kind), 0)?, kind.first().map(|class| class & 0x0f)) {
            (Ok(Type::Number(number)), _) if single && bytes.rest.len() >= usize::from(number.bytes) => {
                self.numbers.push((name, number.read(bytes.rest)));
            }
            (_, Some(STRING)) => self.texts.push((name, text(bytes.rest))),
            _ => {}
        }
        Ok(())
    }

    /// Returns the reason for which it is a dataset that cannot be read.
    pub(super) fn refusal(&self) -> Option<String> {
        self.refused.clone()
    }

    /// Returns the dataset that it is; nothing for groups and empty datasets.
    pub(super) fn dataset(&self) -> Option<(Type, Dataset)> {
        let (kind, lengths, layout) = (self.kind.clone()?, self.lengths.clone()?, self.layout.clone()?);
        let number = match kind {
            Type::Number(number) => number,
            Type::Reference | Type::Compound(_) => Number::new(Kind::Unsigned, 8, false),
        };
        if let Layout::Chunked(Chunking { lengths: chunk, .. }) = &layout
            && (chunk.len() != lengths.len() || chunk.contains(&0))
        {
            return None;
        }
        let (width, largest, filters) = (self.width, self.largest.clone(), self.filters.clone());
        Some((kind, Dataset { number, width, offset: 0, lengths, largest, layout, filters }))
    }
}

/// Returns a text up to its first zero.
fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned()
}

/// Returns the lengths of the dimensions and those up to which they may grow; `None` for a space without elements or with too many
/// dimensions.
fn dataspace(mut bytes: Bytes<'_>) -> io::Result<Option<(Vec<u64>, Vec<u64>)>> {
    let (version, dimensions) = (bytes.u8()?, bytes.u8()?);
    let (flags, kind) = (bytes.u8()?, bytes.u8()?);
    bytes.take(if version == 1 { 4 } else { 0 })?;
    const NULL: u8 = 2;
    if dimensions > MAX_DIMENSIONS || (version != 1 && kind == NULL) {
        return Ok(None);
    }
    let mut all = || (0..dimensions).map(|_| bytes.u64()).collect::<io::Result<Vec<_>>>();
    let lengths = all()?;
    let largest = if flags & 1 == 0 { lengths.clone() } else { all()? };
    Ok(Some((lengths, largest)))
}

/// Reads a type up to its end; returns the reason where it is no number, reference or compound type.
fn datatype(bytes: &mut Bytes<'_>, depth: usize) -> io::Result<Result<Type, String>> {
    if depth > DEEPEST_TYPE {
        return Err(refuse("types within each other"));
    }
    let (class, bits) = (bytes.u8()?, bytes.u8()?);
    let (version, class, further) = (class >> 4, class & 0x0f, bytes.u16()?);
    let size = bytes.u32()?;
    let big_endian = bits & 1 != 0;
    let number = |kind, is_plain: bool, offset: u16, precision: u16| {
        if is_plain && offset == 0 && u32::from(precision) == 8 * size {
            return Ok(Type::Number(Number::new(kind, size as u8, big_endian)));
        }
        let name = if kind == Kind::Float { "floats" } else { "integers" };
        Err(format!("{name} of {precision} bits in {size} bytes"))
    };
    let of = |text: &str| Ok(Err(text.to_owned()));
    match class {
        0 => {
            let kind = if bits & 8 == 0 { Kind::Unsigned } else { Kind::Signed };
            let (offset, precision) = (bytes.u16()?, bytes.u16()?);
            Ok(number(kind, matches!(size, 1 | 2 | 4 | 8), offset, precision))
        }
        1 => {
            let (offset, precision, _at, exponent) = (bytes.u16()?, bytes.u16()?, bytes.u8()?, bytes.u8()?);
            bytes.take(6)?;
            // A second bit of the order is set for machines of VAX.
            let is_plain = bits & 0x40 == 0 && matches!((size, exponent), (2, 5) | (4, 8) | (8, 11));
            Ok(number(Kind::Float, is_plain, offset, precision))
        }
        2 => bytes.take(2).and(of("times")),
        3 => of("text"),
        4 => bytes.take(4).and(of("bit fields")),
        5 => bytes.take(bits.into()).and(of("opaque bytes")),
        6 => compound(bytes, version, u64::from(bits) | u64::from(further & 0xff) << 8, size, depth),
        7 if bits & 0x0f == 0 && size == 8 => Ok(Ok(Type::Reference)),
        7 => of("references to regions"),
        // An enumeration, such as a boolean, has its type within.
        8 => {
            let base = datatype(bytes, depth + 1)?;
            let count = u64::from(bits) | u64::from(further & 0xff) << 8;
            for _ in 0..count {
                member_name(bytes, version)?;
            }
            bytes.take(count.saturating_mul(size.into()))?;
            Ok(base)
        }
        9 => datatype(bytes, depth + 1)?.map_or_else(|_| of("vectors of any length"), |_| of("vectors of any length")),
        10 => {
            let dimensions = u64::from(bytes.u8()?);
            bytes.take(if version < 3 { 3 + 8 * dimensions } else { 4 * dimensions })?;
            let _base = datatype(bytes, depth + 1)?;
            of("arrays as elements")
        }
        class => Ok(Err(format!("a type of class {class}"))),
    }
}

/// Reads the name of a member of a type.
fn member_name(bytes: &mut Bytes<'_>, version: u8) -> io::Result<String> {
    let end = bytes.rest.iter().position(|byte| *byte == 0).ok_or(io::ErrorKind::UnexpectedEof)? as u64 + 1;
    Ok(text(bytes.take(if version < 3 { end.next_multiple_of(8) } else { end })?))
}

/// Reads the fields of a compound type.
fn compound(
    bytes: &mut Bytes<'_>,
    version: u8,
    count: u64,
    size: u32,
    depth: usize,
) -> io::Result<Result<Type, String>> {
    let mut fields = Vec::new();
    for _ in 0..count {
        let name = member_name(bytes, version)?;
        let offset = match version {
            3.. => bytes.little((32 - u64::from(size.leading_zeros())).div_ceil(8))?,
            _ => bytes.u32()?.into(),
        };
        // The first version has the dimensions of an array here.
        let dimensions = if version == 1 { bytes.u8()? } else { 0 };
        bytes.take(if version == 1 { 27 } else { 0 })?;
        let field = match datatype(bytes, depth + 1)? {
            Ok(_) if dimensions > 0 => Err("arrays as elements".to_owned()),
            Ok(Type::Number(number)) if offset + u64::from(number.bytes) <= size.into() => Ok(number),
            Ok(Type::Number(_)) => Err("a field beyond its element".to_owned()),
            Ok(Type::Reference) => Err("references".to_owned()),
            Ok(Type::Compound(_)) => Err("a compound type within another".to_owned()),
            Err(reason) => Err(reason),
        };
        // A type of a class that is not known has an unknown length.
        let is_lost = field.as_ref().is_err_and(|reason| reason.starts_with("a type of class"));
        fields.push((name, offset, field));
        if is_lost {
            break;
        }
    }
    Ok(Ok(Type::Compound(fields)))
}

/// Returns the location of the numbers, or the reason for which they cannot be read.
fn layout(mut bytes: Bytes<'_>) -> io::Result<Result<Layout, String>> {
    let (version, class) = (bytes.u8()?, bytes.u8()?);
    Ok(match (version, class) {
        (3..=5, 0) => {
            let length = bytes.u16()?;
            Ok(Layout::Compact(bytes.take(length.into())?.to_vec()))
        }
        (3..=5, 1) => Ok(Layout::Contiguous { address: bytes.u64()? }),
        (3, 2) => {
            let dimensions = bytes.u8()?.saturating_sub(1).min(MAX_DIMENSIONS);
            let address = bytes.u64()?;
            let chunk = (0..dimensions).map(|_| bytes.u32().map(u64::from)).collect::<io::Result<_>>()?;
            Ok(Layout::Chunked(Chunking { index: ChunkIndex::Tree, address, lengths: chunk, has_plain_edges: false }))
        }
        (4 | 5, 2) => return chunks(bytes),
        (version, class) => Err(format!("a data layout of version {version} and class {class}")),
    })
}

/// Returns the chunks of a data layout of version 4 or 5, or the reason for which they cannot be read.
fn chunks(mut bytes: Bytes<'_>) -> io::Result<Result<Layout, String>> {
    const PLAIN_EDGES: u8 = 1;
    const FILTERED: u8 = 2;
    let (flags, dimensions, width) = (bytes.u8()?, bytes.u8()?, u64::from(bytes.u8()?));
    let dimensions = dimensions.saturating_sub(1).min(MAX_DIMENSIONS);
    let lengths = (0..dimensions).map(|_| bytes.little(width)).collect::<io::Result<_>>()?;
    // The size of an element.
    bytes.take(width)?;
    let (index, parameters) = match bytes.u8()? {
        1 if flags & FILTERED != 0 => (ChunkIndex::Single(Some((bytes.u64()?, bytes.u32()?))), 0),
        1 => (ChunkIndex::Single(None), 0),
        2 => (ChunkIndex::Implicit, 0),
        3 => (ChunkIndex::FixedArray, 1),
        4 => (ChunkIndex::ExtensibleArray, 5),
        5 => (ChunkIndex::SecondTree, 6),
        kind => return Ok(Err(format!("a chunk index of kind {kind}"))),
    };
    bytes.take(parameters)?;
    let (address, has_plain_edges) = (bytes.u64()?, flags & PLAIN_EDGES != 0);
    Ok(Ok(Layout::Chunked(Chunking { index, address, lengths, has_plain_edges })))
}

/// Returns the filters in the order of writing, or the reason for which they cannot be reversed.
fn filters(mut bytes: Bytes<'_>) -> io::Result<Result<Vec<Filter>, String>> {
    let (version, count) = (bytes.u8()?, bytes.u8()?);
    bytes.take(if version == 1 { 6 } else { 0 })?;
    let mut all = Vec::new();
    for _ in 0..count {
        let id = bytes.u16()?;
        let name = if version == 1 || id >= 256 { bytes.u16()? } else { 0 };
        let (_flags, values) = (bytes.u16()?, u64::from(bytes.u16()?));
        bytes.take(if version == 1 { u64::from(name).next_multiple_of(8) } else { name.into() })?;
        bytes.take(4 * if version == 1 { values.next_multiple_of(2) } else { values })?;
        all.push(match id {
            DEFLATE => Filter::Deflate,
            SHUFFLE => Filter::Shuffle,
            FLETCHER32 => Filter::Fletcher32,
            id => {
                let known = FILTER_NAMES.iter().find(|(own, _)| *own == id);
                return Ok(Err(match known {
                    Some((_, name)) => format!("compressed by the filter {name}"),
                    None => format!("compressed by the filter {id} of HDF5"),
                }));
            }
        });
    }
    Ok(Ok(all))
}

/// Returns name and address of a hard link; `None` for other links.
pub(super) fn link(mut bytes: Bytes<'_>) -> io::Result<Option<(String, u64)>> {
    let (_version, flags) = (bytes.u8()?, bytes.u8()?);
    let kind = if flags & 0x08 == 0 { 0 } else { bytes.u8()? };
    bytes.take(if flags & 0x04 == 0 { 0 } else { 8 })?;
    bytes.take(if flags & 0x10 == 0 { 0 } else { 1 })?;
    let length = bytes.little(1 << (flags & 3))?;
    let name = String::from_utf8_lossy(bytes.take(length)?).into_owned();
    Ok(if kind == 0 { Some((name, bytes.u64()?)) } else { None })
}
