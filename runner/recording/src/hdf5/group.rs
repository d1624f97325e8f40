//! Members of groups: symbol tables, links in the object header, links in a fractal heap.

use std::io;

use super::object::{Object, link};
use super::{Source, UNDEFINED, little, refuse};

/// Largest number of members of a group, and of nodes of a tree.
const MAX_MEMBERS: usize = 1 << 16;
const MAX_NODES: usize = 1 << 16;
/// Largest level of a node.
const HIGHEST: u8 = 16;
/// Largest size of a local heap, bytes.
const LARGEST_HEAP: u64 = 1 << 26;

/// Returns names and addresses of the members of a group, in alphabetical order.
pub(super) fn members(source: &mut Source, group: &Object) -> io::Result<Vec<(String, u64)>> {
    let mut all = group.links.clone();
    if let Some([tree, heap]) = group.symbols {
        all.extend(symbols(source, tree, heap)?);
    }
    if let Some([heap, tree]) = group.dense {
        all.extend(Heap::read(source, heap)?.links(source, tree)?);
    }
    all.sort();
    Ok(all)
}

/// Node of a B-tree of version 1.
pub(super) struct Node {
    pub(super) level: u8,
    pub(super) entries: usize,
    /// Keys and addresses in turn.
    pub(super) body: Vec<u8>,
}

impl Node {
    /// Reads a node whose keys have `size` bytes.
    pub(super) fn read(source: &mut Source, address: u64, kind: u8, key: u64) -> io::Result<Self> {
        let head = source.structure(address, b"TREE", 24)?;
        let mut head = little(&head);
        head.take(4)?;
        let (own, level, entries) = (head.u8()?, head.u8()?, head.u16()?);
        if own != kind || level > HIGHEST {
            return Err(refuse(format!("no index of kind {kind} at address {address}")));
        }
        let body = source.read(address.saturating_add(24), u64::from(entries) * (key + 8))?;
        Ok(Self { level, entries: entries.into(), body })
    }
}

fn symbols(source: &mut Source, tree: u64, heap: u64) -> io::Result<Vec<(String, u64)>> {
    let head = source.structure(heap, b"HEAP", 32)?;
    let mut head = little(&head);
    head.take(8)?;
    let (size, _free, address) = (head.u64()?, head.u64()?, head.u64()?);
    if size > LARGEST_HEAP {
        return Err(refuse(format!("a heap of {size} bytes")));
    }
    let names = source.read(address, size)?;
    let (mut nodes, mut leaves, mut next) = (vec![tree], Vec::new(), 0);
    while let Some(&address) = nodes.get(next) {
        next += 1;
        let node = Node::read(source, address, 0, 8)?;
        let mut body = little(&node.body);
        for _ in 0..node.entries {
            let (_key, child) = (body.u64()?, body.u64()?);
            if node.level == 0 { leaves.push(child) } else { nodes.push(child) }
        }
        if nodes.len() + leaves.len() > MAX_NODES {
            return Err(refuse(format!("a group of more than {MAX_NODES} nodes")));
        }
    }
    let mut all = Vec::new();
    for leaf in leaves {
        let head = source.structure(leaf, b"SNOD", 8)?;
        let count = little(head.get(6..).unwrap_or_default()).u16()?;
        let entries = source.read(leaf.saturating_add(8), 40 * u64::from(count))?;
        for entry in entries.chunks_exact(40) {
            let mut entry = little(entry);
            let (name, address) = (entry.u64()?, entry.u64()?);
            let name = usize::try_from(name).ok().and_then(|at| names.get(at..)).unwrap_or_default();
            let name = name.split(|byte| *byte == 0).next().unwrap_or_default();
            all.push((String::from_utf8_lossy(name).into_owned(), address));
        }
        if all.len() > MAX_MEMBERS {
            return Err(refuse(format!("a group of more than {MAX_MEMBERS} members")));
        }
    }
    Ok(all)
}

/// A fractal heap: objects by an offset in blocks whose sizes double from row to row.
struct Heap {
    id_length: u64,
    /// Bytes of an offset within the heap, and of a length.
    offset_bytes: u64,
    length_bytes: u64,
    width: u64,
    first_block: u64,
    largest_block: u64,
    root: u64,
    /// Rows of the root, if it is an indirect block.
    rows: u64,
}

/// Returns the number of bytes that store a number.
const fn bytes_for(number: u64) -> u64 {
    (64 - number.leading_zeros() as u64).div_ceil(8)
}

impl Heap {
    fn read(source: &mut Source, address: u64) -> io::Result<Self> {
        let head = source.structure(address, b"FRHP", 144)?;
        let mut head = little(&head);
        head.take(5)?;
        let (id_length, filters, _flags, managed) = (head.u16()?, head.u16()?, head.u8()?, head.u32()?);
        // Huge and tiny objects, free space and statistics.
        head.take(96)?;
        let (width, first_block, largest_block) = (head.u16()?, head.u64()?, head.u64()?);
        let (bits, _starting_rows) = (head.u16()?, head.u16()?);
        let (root, rows) = (head.u64()?, head.u16()?);
        let sound = width > 0 && first_block.is_power_of_two() && largest_block.is_power_of_two();
        if filters > 0 || !sound || first_block > largest_block || rows > 64 {
            return Err(refuse("a group in a heap of an unknown form"));
        }
        let offset_bytes = u64::from(bits).div_ceil(8);
        let length_bytes = bytes_for(largest_block.min(managed.into()));
        let (id_length, width, rows) = (id_length.into(), width.into(), rows.into());
        Ok(Self { id_length, offset_bytes, length_bytes, width, first_block, largest_block, root, rows })
    }

    /// Reads all links by the records of a B-tree of version 2.
    fn links(&self, source: &mut Source, tree: u64) -> io::Result<Vec<(String, u64)>> {
        let head = source.structure(tree, b"BTHD", 38)?;
        let mut head = little(&head);
        head.take(6)?;
        let (node, record, depth) = (u64::from(head.u32()?), u64::from(head.u16()?), head.u16()?);
        head.take(2)?;
        let (root, count, total) = (head.u64()?, head.u16()?, head.u64()?);
        if record != 4 + self.id_length || node < 10 + record || depth > 1 || total > MAX_MEMBERS as u64 {
            return Err(refuse(format!("a group of {total} members in an index of depth {depth}")));
        }
        let mut records = Vec::new();
        if total > 0 && depth == 0 {
            records.extend(self.records(source, root, b"BTLF", count.into(), record)?);
        } else if total > 0 {
            records.extend(self.records(source, root, b"BTIN", count.into(), record)?);
            let width = bytes_for((node - 10) / record);
            let start = root.saturating_add(6 + u64::from(count) * record);
            let children = source.read(start, (u64::from(count) + 1) * (8 + width))?;
            let mut children = little(&children);
            for _ in 0..=count {
                let (leaf, own) = (children.u64()?, children.little(width)?);
                records.extend(self.records(source, leaf, b"BTLF", own, record)?);
                if records.len() > MAX_MEMBERS {
                    return Err(refuse(format!("a group of more than {MAX_MEMBERS} members")));
                }
            }
        }
        let mut all = Vec::new();
        for id in records {
            let bytes = self.object(source, &id)?;
            all.extend(link(little(&bytes))?);
        }
        Ok(all)
    }

    /// Returns the identifiers of the objects in a node; each one follows a hash of its name.
    fn records(
        &self,
        source: &mut Source,
        node: u64,
        letters: &[u8; 4],
        count: u64,
        record: u64,
    ) -> io::Result<Vec<Vec<u8>>> {
        let bytes = source.structure(node, letters, 6 + count.min(u64::from(u16::MAX)) * record)?;
        let records = bytes.get(6..).unwrap_or_default().chunks_exact(record as usize);
        Ok(records.map(|record| record.get(4..).unwrap_or_default().to_vec()).collect())
    }

    fn object(&self, source: &mut Source, id: &[u8]) -> io::Result<Vec<u8>> {
        let mut id = little(id);
        // The other types are objects larger than a block, and those within the identifier.
        if id.u8()? & 0x30 != 0 {
            return Err(refuse("a link of an unknown form"));
        }
        let (offset, length) = (id.little(self.offset_bytes)?, id.little(self.length_bytes)?);
        let (block, start) = if self.rows == 0 { (self.root, 0) } else { self.block(source, offset)? };
        source.read(block.saturating_add(offset.saturating_sub(start)), length.min(self.largest_block))
    }

    /// Returns address and first offset of the direct block with this offset.
    fn block(&self, source: &mut Source, offset: u64) -> io::Result<(u64, u64)> {
        let mut start = 0_u64;
        for row in 0..self.rows {
            let size = self.first_block.saturating_mul(1_u64.checked_shl(row.saturating_sub(1) as u32).unwrap_or(0));
            if size > self.largest_block || size == 0 {
                break;
            }
            let end = start.saturating_add(size.saturating_mul(self.width));
            if offset < end {
                let column = (offset - start) / size;
                // Letters, version, address of the heap and the block's own offset come first.
                let at = 4 + 1 + 8 + self.offset_bytes + 8 * (row * self.width + column);
                let child = source.structure(self.root, b"FHIB", at + 8)?;
                let child = little(child.get(at as usize..).unwrap_or_default()).u64()?;
                if child == UNDEFINED {
                    break;
                }
                return Ok((child, start + column * size));
            }
            start = end;
        }
        Err(refuse("a link in an indirect block of an unknown form"))
    }
}
