//! Places of the chunks of a dataset: B-trees of versions 1 and 2, single chunks, implicit indices, fixed and extensible arrays.

use std::io;

use super::group::Node;
use super::object::{ChunkIndex, Chunking, Dataset};
use super::{Source, UNDEFINED, little, refuse};

/// Largest number of chunks of a dataset.
const MAX_CHUNKS: u64 = 1 << 22;
/// Bytes before the entries of an array block: letters, version, client, address of the header.
const PREFIX: u64 = 14;
/// Largest binary logarithm of the number of entries on a page of an array.
const LARGEST_PAGE: u8 = 32;
/// Largest depth of a B-tree of version 2.
const DEEPEST: u16 = 16;
/// Largest number of bytes of an index that are read, over the size of the file: every block is read once or twice.
const MOST_READ: u64 = 4;

/// A chunk in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) address: u64,
    pub(super) length: u64,
    /// Filters that are left out.
    pub(super) mask: u32,
}

/// Receives a chunk and the indices of its first element.
type Visit<'v> = &'v mut dyn FnMut(&mut Source, Place, &[u64]) -> io::Result<()>;

/// Visits the chunks whose first element passes `is_wanted`; `size` is the number of bytes of a chunk without filters.
pub(super) fn visit(
    source: &mut Source,
    (dataset, chunking): (&Dataset, &Chunking),
    size: u64,
    is_wanted: &dyn Fn(&[u64]) -> bool,
    visit: Visit<'_>,
) -> io::Result<()> {
    let tiles: Vec<u64> = divided(&dataset.lengths, &chunking.lengths);
    let expected = tiles.iter().copied().fold(1_u64, u64::saturating_mul);
    let address = chunking.address;
    let place = match chunking.index {
        ChunkIndex::Tree => return first_tree(source, (address, tiles.len()), expected, is_wanted, visit),
        ChunkIndex::SecondTree => return second_tree(source, chunking, (size, expected), is_wanted, visit),
        ChunkIndex::Single(filtered) => {
            let (length, mask) = filtered.unwrap_or((size, 0));
            if expected != 1 {
                return Err(refuse(format!("a single chunk in place of {expected}")));
            }
            return visit(source, Place { address, length, mask }, &vec![0; tiles.len()]);
        }
        ChunkIndex::Implicit => Lookup::Implicit { address, size },
        ChunkIndex::FixedArray => Lookup::Fixed(FixedArray::read(source, address, size)?),
        ChunkIndex::ExtensibleArray => Lookup::Extensible(ExtensibleArray::read(source, address, size)?),
    };
    each_tile(source, (dataset, chunking), (&tiles, expected), place, is_wanted, visit)
}

/// Returns the number of chunks along each dimension.
fn divided(lengths: &[u64], chunk: &[u64]) -> Vec<u64> {
    let count = |(length, chunk): (&u64, &u64)| if *length == UNDEFINED { UNDEFINED } else { length.div_ceil(*chunk) };
    lengths.iter().zip(chunk).map(count).collect()
}

/// Visits the chunks by their number in an index that has no coordinates.
fn each_tile(
    source: &mut Source,
    (dataset, chunking): (&Dataset, &Chunking),
    (tiles, expected): (&[u64], u64),
    mut lookup: Lookup,
    is_wanted: &dyn Fn(&[u64]) -> bool,
    visit: Visit<'_>,
) -> io::Result<()> {
    if expected > MAX_CHUNKS {
        return Err(refuse(format!("more chunks than {MAX_CHUNKS}")));
    }
    let largest = divided(&dataset.largest, &chunking.lengths);
    // The dimension without a limit is the slowest one of an extensible array.
    let unlimited: Vec<usize> = (0..largest.len()).filter(|place| largest[*place] == UNDEFINED).collect();
    let is_extensible = chunking.index == ChunkIndex::ExtensibleArray;
    let order: Vec<usize> = match (unlimited.as_slice(), is_extensible) {
        ([], false) => (0..tiles.len()).collect(),
        ([first], true) => [*first].into_iter().chain((0..tiles.len()).filter(|place| place != first)).collect(),
        _ => return Err(refuse(format!("{} dimensions without a limit in this chunk index", unlimited.len()))),
    };
    let mut at = vec![0_u64; tiles.len()];
    for _ in 0..expected {
        let first: Vec<u64> = at.iter().zip(&chunking.lengths).map(|(at, chunk)| at.saturating_mul(*chunk)).collect();
        if is_wanted(&first) {
            let number = order.iter().fold(0_u64, |number, place| {
                let count = if largest[*place] == UNDEFINED { 0 } else { largest[*place] };
                number.saturating_mul(count).saturating_add(at[*place])
            });
            if let Some(place) = lookup.place(source, number)? {
                visit(source, place, &first)?;
            }
        }
        for place in order.iter().rev() {
            at[*place] += 1;
            if at[*place] < tiles[*place] {
                break;
            }
            at[*place] = 0;
        }
    }
    Ok(())
}

/// Visits the chunks of a B-tree of version 1.
fn first_tree(
    source: &mut Source,
    (address, dimensions): (u64, usize),
    expected: u64,
    is_wanted: &dyn Fn(&[u64]) -> bool,
    visit: Visit<'_>,
) -> io::Result<()> {
    let expected = expected.min(MAX_CHUNKS);
    let (mut nodes, mut next, mut count) = (vec![address], 0, 0);
    while let Some(&address) = nodes.get(next) {
        next += 1;
        let node = Node::read(source, address, 1, 8 + 8 * (dimensions as u64 + 1))?;
        let mut body = little(&node.body);
        for _ in 0..node.entries {
            let (length, mask) = (body.u32()?, body.u32()?);
            let first = (0..dimensions).map(|_| body.u64()).collect::<io::Result<Vec<_>>>()?;
            let (_element, child) = (body.u64()?, body.u64()?);
            if node.level > 0 {
                nodes.push(child);
            } else {
                count += 1;
            }
            if count > expected || nodes.len() as u64 > MAX_CHUNKS {
                return Err(refuse(format!("more chunks than {expected}")));
            }
            if node.level == 0 && is_wanted(&first) {
                visit(source, Place { address: child, length: length.into(), mask }, &first)?;
            }
        }
    }
    Ok(())
}

/// Visits the chunks of a B-tree of version 2.
fn second_tree(
    source: &mut Source,
    chunking: &Chunking,
    (size, expected): (u64, u64),
    is_wanted: &dyn Fn(&[u64]) -> bool,
    visit: Visit<'_>,
) -> io::Result<()> {
    const PLAIN: u8 = 10;
    const FILTERED: u8 = 11;
    let head = source.structure(chunking.address, b"BTHD", 38)?;
    let mut head = little(&head);
    head.take(5)?;
    let (kind, node, record, depth) = (head.u8()?, u64::from(head.u32()?), u64::from(head.u16()?), head.u16()?);
    head.take(2)?;
    let (root, count, total) = (head.u64()?, u64::from(head.u16()?), head.u64()?);
    let offsets = 8 * chunking.lengths.len() as u64;
    let filtered = match kind {
        PLAIN if record == 8 + offsets => None,
        FILTERED if (13..=20).contains(&record.saturating_sub(offsets)) => Some(record - offsets - 12),
        _ => return Err(refuse(format!("no index of chunks at address {}", chunking.address))),
    };
    if depth > DEEPEST || node < 10 + record || total > expected.min(MAX_CHUNKS) {
        return Err(refuse(format!("{total} chunks in an index of depth {depth}, more than {expected}")));
    }
    // Width of the number of records of a child, and of all records below it, by the level of the child.
    let most = (node - 10) / record;
    let own_width = bytes_for(most);
    let (mut widths, mut below) = (vec![0], most);
    for _ in 1..=depth {
        let pointer = 8 + own_width + widths.last().copied().unwrap_or(0);
        let records = node.saturating_sub(10 + pointer) / (record + pointer);
        below = (records.saturating_add(1)).saturating_mul(below).saturating_add(records);
        widths.push(bytes_for(below));
    }
    let mut left = total;
    let mut nodes = if total > 0 { vec![(root, count, depth)] } else { vec![] };
    while let Some((address, count, level)) = nodes.pop() {
        left = left.checked_sub(count).ok_or_else(|| refuse(format!("more chunks than {total}")))?;
        let letters = if level == 0 { b"BTLF" } else { b"BTIN" };
        let below = usize::from(level).checked_sub(1).and_then(|below| widths.get(below)).copied().unwrap_or(0);
        let children = if level == 0 { 0 } else { (count + 1) * (8 + own_width + below) };
        let bytes = source.structure(address, letters, 6 + count * record + children)?;
        let mut body = little(bytes.get(6..).unwrap_or_default());
        for _ in 0..count {
            let address = body.u64()?;
            let (length, mask) = match filtered {
                Some(width) => (body.little(width)?, body.u32()?),
                None => (size, 0),
            };
            let first = chunking.lengths.iter().map(|chunk| Ok(body.u64()?.saturating_mul(*chunk)));
            let first = first.collect::<io::Result<Vec<_>>>()?;
            if address != UNDEFINED && is_wanted(&first) {
                visit(source, Place { address, length, mask }, &first)?;
            }
        }
        for _ in 0..if level == 0 { 0 } else { count + 1 } {
            let (address, own, _all) = (body.u64()?, body.little(own_width)?, body.little(below)?);
            nodes.push((address, own, level - 1));
        }
        // A node without records has a child that may be itself.
        if nodes.len() as u64 > left.saturating_add(u64::from(DEEPEST) + 1) {
            return Err(refuse(format!("more chunks than {total}")));
        }
    }
    Ok(())
}

/// Returns the number of bytes that store a number.
const fn bytes_for(number: u64) -> u64 {
    (64 - number.leading_zeros() as u64).div_ceil(8)
}

/// Index of the places of chunks by their numbers.
enum Lookup {
    Implicit { address: u64, size: u64 },
    Fixed(FixedArray),
    Extensible(ExtensibleArray),
}

impl Lookup {
    /// Returns the place of a chunk; none where nothing was written.
    fn place(&mut self, source: &mut Source, number: u64) -> io::Result<Option<Place>> {
        match self {
            Self::Implicit { address, size } => {
                let address = address.saturating_add(number.saturating_mul(*size));
                Ok(Some(Place { address, length: *size, mask: 0 }))
            }
            Self::Fixed(array) => array.place(source, number),
            Self::Extensible(array) => array.place(source, number),
        }
    }
}

/// Form of the entries of an array.
#[derive(Clone, Copy)]
struct Entry {
    /// Bytes of an entry.
    width: u64,
    /// Bytes of the length of a chunk with filters.
    filtered: Option<u64>,
    /// Bytes of a chunk without filters.
    size: u64,
}

impl Entry {
    fn of(client: u8, width: u8, size: u64) -> io::Result<Self> {
        let width = u64::from(width);
        let filtered = match (client, width) {
            (0, 8) => None,
            (1, 13..=20) => Some(width - 12),
            _ => return Err(refuse(format!("an index of chunks with entries of {width} bytes"))),
        };
        Ok(Self { width, filtered, size })
    }

    /// Returns the place in the entry with this number among `entries`.
    fn place(self, entries: &[u8], number: u64) -> io::Result<Option<Place>> {
        let start = usize::try_from(number.saturating_mul(self.width)).unwrap_or(usize::MAX);
        let mut entry = little(entries.get(start..).unwrap_or_default());
        let address = entry.u64()?;
        let (length, mask) = match self.filtered {
            Some(width) => (entry.little(width)?, entry.u32()?),
            None => (self.size, 0),
        };
        Ok((address != UNDEFINED).then_some(Place { address, length, mask }))
    }
}

/// Blocks of an index, the last one of each kind in memory.
#[derive(Default)]
struct Blocks {
    entries: Option<(u64, Vec<u8>)>,
    pointers: Option<(u64, Vec<u8>)>,
    bytes_read: u64,
}

impl Blocks {
    /// Returns `length` bytes of entries.
    fn entries(&mut self, source: &mut Source, address: u64, length: u64) -> io::Result<&[u8]> {
        Self::read(source, &mut self.entries, &mut self.bytes_read, (address, length))
    }

    /// Returns `length` bytes of pointers.
    fn pointers(&mut self, source: &mut Source, address: u64, length: u64) -> io::Result<&[u8]> {
        Self::read(source, &mut self.pointers, &mut self.bytes_read, (address, length))
    }

    fn read<'b>(
        source: &mut Source,
        known: &'b mut Option<(u64, Vec<u8>)>,
        bytes_read: &mut u64,
        (address, length): (u64, u64),
    ) -> io::Result<&'b [u8]> {
        if known.as_ref().is_none_or(|(own, _)| *own != address) {
            *bytes_read = bytes_read.saturating_add(length);
            if *bytes_read > source.size.saturating_mul(MOST_READ) {
                return Err(refuse("an index of chunks whose blocks contain each other"));
            }
            *known = Some((address, source.read(address, length)?));
        }
        Ok(known.as_ref().map_or(&[], |(_, bytes)| bytes.as_slice()))
    }
}

/// Returns true where the bit of a page is set, the highest bit of a byte first.
fn is_written(pages: &[u8], page: u64) -> bool {
    let byte = usize::try_from(page / 8).ok().and_then(|at| pages.get(at)).copied().unwrap_or(0);
    byte & (0x80 >> (page % 8)) != 0
}

/// A fixed array: one block of entries, in pages where it is large.
struct FixedArray {
    entry: Entry,
    count: u64,
    /// Entries of a page.
    page: u64,
    /// Address of the first entry.
    first: u64,
    /// One bit for each page; none without pages.
    written: Option<Vec<u8>>,
    blocks: Blocks,
}

impl FixedArray {
    fn read(source: &mut Source, address: u64, size: u64) -> io::Result<Self> {
        let head = source.structure(address, b"FAHD", 28)?;
        let mut head = little(&head);
        head.take(5)?;
        let (client, width, bits) = (head.u8()?, head.u8()?, head.u8()?);
        let (count, block) = (head.u64()?, head.u64()?);
        let entry = Entry::of(client, width, size)?;
        if bits > LARGEST_PAGE || count > source.size {
            return Err(refuse(format!("an index of {count} chunks")));
        }
        let page = 1 << bits;
        let mut array =
            Self { entry, count, page, first: block.saturating_add(PREFIX), written: None, blocks: Blocks::default() };
        if block == UNDEFINED {
            array.count = 0;
            return Ok(array);
        }
        source.structure(block, b"FADB", PREFIX)?;
        if count > page {
            let bytes = count.div_ceil(page).div_ceil(8);
            array.written = Some(source.read(array.first, bytes)?);
            // A checksum follows.
            array.first = array.first.saturating_add(bytes + 4);
        }
        Ok(array)
    }

    fn place(&mut self, source: &mut Source, number: u64) -> io::Result<Option<Place>> {
        if self.count == 0 {
            return Ok(None);
        }
        if number >= self.count {
            return Err(refuse(format!("an index of {} chunks without chunk {number}", self.count)));
        }
        let Entry { width, .. } = self.entry;
        let (page, within) = (number / self.page, number % self.page);
        if self.written.as_ref().is_some_and(|written| !is_written(written, page)) {
            return Ok(None);
        }
        let address = self.first.saturating_add(page.saturating_mul(self.page * width + 4));
        let length = self.page.min(self.count - page * self.page) * width;
        self.entry.place(self.blocks.entries(source, address, length)?, within)
    }
}

/// An extensible array: entries in an index block, then in data blocks, first below the index block, then below super blocks of which
/// every second one has twice as many data blocks, and the others data blocks of twice as many entries.
struct ExtensibleArray {
    entry: Entry,
    /// Entries of the index block.
    direct: u64,
    /// Entries of the smallest data block.
    smallest: u64,
    /// Entries of a page of a data block.
    page: u64,
    /// Bytes of an offset in the array.
    offset_width: u64,
    /// Number of super blocks, and of those whose data blocks are below the index block.
    super_blocks: u32,
    flat_super_blocks: u32,
    /// Entries and addresses of the index block; empty where nothing was written.
    index: Vec<u8>,
    blocks: Blocks,
}

impl ExtensibleArray {
    fn read(source: &mut Source, address: u64, size: u64) -> io::Result<Self> {
        let head = source.structure(address, b"EAHD", 72)?;
        let mut head = little(&head);
        head.take(5)?;
        let (client, width, bits, direct) = (head.u8()?, head.u8()?, head.u8()?, u64::from(head.u8()?));
        let (smallest, pointers, page_bits) = (u64::from(head.u8()?), u64::from(head.u8()?), head.u8()?);
        // Numbers and sizes of blocks, of entries.
        head.take(48)?;
        let block = head.u64()?;
        let entry = Entry::of(client, width, size)?;
        let is_sound =
            bits <= 64 && smallest.is_power_of_two() && pointers.is_power_of_two() && page_bits <= LARGEST_PAGE;
        if !is_sound || u32::from(bits) < smallest.trailing_zeros() {
            return Err(refuse("an index of chunks of an unknown form"));
        }
        let super_blocks = 1 + u32::from(bits) - smallest.trailing_zeros();
        let flat_super_blocks = (2 * pointers.trailing_zeros()).min(super_blocks);
        let mut array = Self {
            entry,
            direct,
            smallest,
            page: 1 << page_bits,
            offset_width: u64::from(bits).div_ceil(8),
            super_blocks,
            flat_super_blocks,
            index: vec![],
            blocks: Blocks::default(),
        };
        if block != UNDEFINED {
            let addresses = 2 * (pointers - 1) + u64::from(super_blocks - flat_super_blocks);
            let bytes = source.structure(block, b"EAIB", PREFIX + direct * entry.width + 8 * addresses)?;
            array.index = bytes.get(PREFIX as usize..).unwrap_or_default().to_vec();
        }
        Ok(array)
    }

    /// Returns the address with this number in the index block, after its entries.
    fn address(&self, number: u64) -> io::Result<u64> {
        let start = self.direct.saturating_mul(self.entry.width).saturating_add(number.saturating_mul(8));
        let start = usize::try_from(start).unwrap_or(usize::MAX);
        little(self.index.get(start..).unwrap_or_default()).u64()
    }

    fn place(&mut self, source: &mut Source, number: u64) -> io::Result<Option<Place>> {
        if self.index.is_empty() {
            return Ok(None);
        }
        let Some(mut rest) = number.checked_sub(self.direct) else { return self.entry.place(&self.index, number) };
        // Number of data blocks before a super block.
        let mut before = 0_u64;
        for super_block in 0..self.super_blocks {
            let blocks = 1_u64 << (super_block / 2);
            let entries = self.smallest.saturating_mul(1_u64 << super_block.div_ceil(2));
            let all = blocks.saturating_mul(entries);
            if rest >= all {
                rest -= all;
                before = before.saturating_add(blocks);
                continue;
            }
            let (block, within) = (rest / entries, rest % entries);
            if super_block < self.flat_super_blocks {
                let address = self.address(before.saturating_add(block))?;
                return self.in_block(source, address, (entries, false), within);
            }
            let flat = (0..self.flat_super_blocks).fold(0_u64, |sum, flat| sum.saturating_add(1 << (flat / 2)));
            let address = self.address(flat + u64::from(super_block - self.flat_super_blocks))?;
            if address == UNDEFINED {
                return Ok(None);
            }
            let pages = if entries > self.page { entries / self.page } else { 0 };
            // Room for whole bytes of each block, although the bits follow each other.
            let bitmap = pages.div_ceil(8).saturating_mul(blocks);
            let pointers = PREFIX.saturating_add(self.offset_width).saturating_add(bitmap);
            let length = pointers.saturating_add(blocks.saturating_mul(8));
            let bytes = self.blocks.pointers(source, address, length)?;
            if !bytes.starts_with(b"EASB") {
                return Err(refuse(format!("no `EASB` at address {address}")));
            }
            let part = |start: u64, length: u64| {
                let start = usize::try_from(start).ok()?;
                bytes.get(start..start.checked_add(usize::try_from(length).ok()?)?)
            };
            let address = part(pointers + 8 * block, 8).map_or(Ok(UNDEFINED), |bytes| little(bytes).u64())?;
            let written = part(PREFIX + self.offset_width, bitmap).unwrap_or_default();
            if pages > 0 && !is_written(written, block * pages + within / self.page) {
                return Ok(None);
            }
            return self.in_block(source, address, (entries, pages > 0), within);
        }
        Err(refuse(format!("an index of chunks without chunk {number}")))
    }

    /// Returns the place in a data block of `entries`, in pages or not.
    fn in_block(
        &mut self,
        source: &mut Source,
        address: u64,
        (entries, is_paged): (u64, bool),
        within: u64,
    ) -> io::Result<Option<Place>> {
        if address == UNDEFINED {
            return Ok(None);
        }
        let Entry { width, .. } = self.entry;
        let first = address.saturating_add(PREFIX + self.offset_width);
        if !is_paged {
            let bytes = self.blocks.entries(source, first, entries.saturating_mul(width))?;
            return self.entry.place(bytes, within);
        }
        let (page, within) = (within / self.page, within % self.page);
        // Checksums follow the prefix and each page.
        let first = first.saturating_add(4).saturating_add(page.saturating_mul(self.page * width + 4));
        let bytes = self.blocks.entries(source, first, self.page * width)?;
        self.entry.place(bytes, within)
    }
}
