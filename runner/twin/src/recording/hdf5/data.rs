//! Numbers of datasets: compact, contiguous, or in chunks under a B-tree of version 1.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use super::group::Node;
use super::object::{Dataset, Filter, Layout};
use super::{LARGEST, Source, TIGHTEST, UNDEFINED, Vector, little, refuse};

/// Bytes of a contiguous dataset that are read at once.
const BLOCK: u64 = 1 << 20;
/// Largest number of chunks of a dataset.
const MAX_CHUNKS: u64 = 1 << 22;

/// A part of a dataset in memory: all elements from `offset` on, over `lengths`.
struct Part<'a> {
    offset: &'a [u64],
    lengths: &'a [u64],
    bytes: &'a [u8],
}

/// Reads the bytes of vectors of one dataset.
pub(super) fn load(source: &mut Source, dataset: &Dataset, vectors: &[Vector]) -> io::Result<Vec<Vec<u8>>> {
    let size = u64::from(dataset.number.bytes);
    let bytes = |vector: &Vector| dataset.length(vector.along).saturating_mul(size);
    let total = vectors.iter().fold(0_u64, |sum, vector| sum.saturating_add(bytes(vector)));
    if total > LARGEST || total > source.size.saturating_mul(TIGHTEST) {
        return Err(refuse(format!("{total} bytes of vectors in a file of {} bytes", source.size)));
    }
    let mut loaded: Vec<Vec<u8>> = vectors.iter().map(|vector| vec![0; bytes(vector) as usize]).collect();
    let mut copy = |part: &Part<'_>| {
        for (vector, to) in vectors.iter().zip(&mut loaded) {
            copy_vector(part, dataset, vector, to);
        }
    };
    let zeros = vec![0; dataset.lengths.len()];
    match &dataset.layout {
        Layout::Compact(bytes) => {
            if (bytes.len() as u64) < whole(dataset)? {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            copy(&Part { offset: &zeros, lengths: &dataset.lengths, bytes });
        }
        // Nothing was written: every element has the default of 0.
        Layout::Contiguous { address: UNDEFINED } | Layout::Chunked { address: UNDEFINED, .. } => {}
        Layout::Contiguous { address } => contiguous(source, dataset, *address, &mut copy)?,
        Layout::Chunked { address, chunk } => chunked(source, dataset, *address, chunk, &mut copy)?,
    }
    Ok(loaded)
}

/// Reads all bytes of a dataset of one dimension.
pub(super) fn all(source: &mut Source, dataset: &Dataset) -> io::Result<Vec<u8>> {
    match &dataset.layout {
        Layout::Compact(bytes) => Ok(bytes.clone()),
        Layout::Contiguous { address } => source.read(*address, whole(dataset)?),
        Layout::Chunked { .. } => Err(refuse("references in chunks")),
    }
}

/// Returns the number of bytes of a dataset.
fn whole(dataset: &Dataset) -> io::Result<u64> {
    let bytes = dataset.lengths.iter().try_fold(dataset.width, |bytes, length| bytes.checked_mul(*length));
    bytes.ok_or_else(|| refuse("a dataset that is too large"))
}

/// Copies those elements of a vector that a part of its dataset has.
fn copy_vector(part: &Part<'_>, dataset: &Dataset, vector: &Vector, to: &mut [u8]) {
    let size = usize::from(dataset.number.bytes);
    let (mut stride, mut at, mut step) = (1_u64, 0_u64, 1_u64);
    for (place, (offset, length)) in part.offset.iter().zip(part.lengths).enumerate().rev() {
        let index = vector.cut.filter(|(across, _)| *across == place).map_or(0, |(_, index)| index);
        if place == vector.along {
            step = stride;
        } else {
            let Some(within) = index.checked_sub(*offset).filter(|within| within < length) else { return };
            at = at.saturating_add(within.saturating_mul(stride));
        }
        stride = stride.saturating_mul(*length);
    }
    let (first, length) = match (part.offset.get(vector.along), part.lengths.get(vector.along)) {
        (Some(first), Some(length)) => (*first, *length),
        // A single number without dimensions.
        _ => (0, 1),
    };
    let count = length.min(dataset.length(vector.along).saturating_sub(first));
    for element in 0..count {
        let from = at.saturating_add(element.saturating_mul(step)).saturating_mul(dataset.width);
        let from = from.saturating_add(dataset.offset) as usize;
        let place = first.saturating_add(element).saturating_mul(size as u64) as usize;
        let from = part.bytes.get(from..from.saturating_add(size));
        if let (Some(from), Some(to)) = (from, to.get_mut(place..place.saturating_add(size))) {
            to.copy_from_slice(from);
        }
    }
}

/// Reads a contiguous dataset in blocks of its first dimension.
fn contiguous(
    source: &mut Source,
    dataset: &Dataset,
    address: u64,
    copy: &mut impl FnMut(&Part<'_>),
) -> io::Result<()> {
    let total = whole(dataset)?;
    let rows = dataset.length(0).max(1);
    let row = total / rows;
    if address.saturating_add(source.base).checked_add(total).is_none_or(|end| end > source.size) {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    let at_once = (BLOCK / row.max(1)).max(1);
    let (mut offset, mut lengths) = (vec![0; dataset.lengths.len()], dataset.lengths.clone());
    let mut first = 0;
    while first < rows {
        let count = at_once.min(rows - first);
        let bytes = source.read(address + first * row, count * row)?;
        if let (Some(offset), Some(length)) = (offset.first_mut(), lengths.first_mut()) {
            (*offset, *length) = (first, count);
        }
        copy(&Part { offset: &offset, lengths: &lengths, bytes: &bytes });
        first += count;
    }
    Ok(())
}

/// Reads the chunks of a dataset, one after the other.
fn chunked(
    source: &mut Source,
    dataset: &Dataset,
    address: u64,
    chunk: &[u64],
    copy: &mut impl FnMut(&Part<'_>),
) -> io::Result<()> {
    let unpacked = chunk.iter().try_fold(dataset.width, |bytes, length| bytes.checked_mul(*length));
    let most = source.size.saturating_mul(TIGHTEST).min(LARGEST);
    let unpacked = unpacked.filter(|bytes| *bytes <= most).ok_or_else(|| refuse("a chunk that is too large"))?;
    let dimensions = chunk.len();
    let tiles = dataset.lengths.iter().zip(chunk).map(|(length, chunk)| length.div_ceil(*chunk));
    let expected = tiles.fold(1_u64, u64::saturating_mul).min(MAX_CHUNKS);
    let (mut nodes, mut next, mut count) = (vec![address], 0, 0);
    while let Some(&address) = nodes.get(next) {
        next += 1;
        let node = Node::read(source, address, 1, 8 + 8 * (dimensions as u64 + 1))?;
        let mut body = little(&node.body);
        for _ in 0..node.entries {
            let (length, mask) = (body.u32()?, body.u32()?);
            let offset = (0..dimensions).map(|_| body.u64()).collect::<io::Result<Vec<_>>>()?;
            let (_element, child) = (body.u64()?, body.u64()?);
            if node.level > 0 {
                nodes.push(child);
            } else {
                count += 1;
            }
            if count > expected || nodes.len() as u64 > MAX_CHUNKS {
                return Err(refuse(format!("more chunks than {expected}")));
            }
            if node.level > 0 {
                continue;
            }
            let bytes = source.read(child, length.into())?;
            let bytes = unfiltered(bytes, dataset, mask, unpacked)?;
            copy(&Part { offset: &offset, lengths: chunk, bytes: &bytes });
        }
    }
    Ok(())
}

/// Undoes the filters of a chunk, the last of them first.
fn unfiltered(mut bytes: Vec<u8>, dataset: &Dataset, mask: u32, unpacked: u64) -> io::Result<Vec<u8>> {
    for (place, filter) in dataset.filters.iter().enumerate().rev() {
        if mask.checked_shr(place as u32).unwrap_or(0) & 1 != 0 {
            continue;
        }
        bytes = match filter {
            Filter::Fletcher32 => bytes.get(..bytes.len().saturating_sub(4)).unwrap_or_default().to_vec(),
            Filter::Deflate => {
                let mut plain = Vec::new();
                ZlibDecoder::new(bytes.as_slice()).take(unpacked.saturating_add(4)).read_to_end(&mut plain)?;
                plain
            }
            Filter::Shuffle => unshuffled(&bytes, dataset.width as usize),
        };
    }
    if (bytes.len() as u64) < unpacked {
        return Err(refuse(format!("a chunk of {} bytes, shorter than {unpacked}", bytes.len())));
    }
    Ok(bytes)
}

/// Reverses the shuffle filter, which stores the first bytes of all elements, then the second ones.
fn unshuffled(bytes: &[u8], size: usize) -> Vec<u8> {
    let count = bytes.len() / size.max(1);
    let mut plain = bytes.to_vec();
    for (place, of_all) in bytes.chunks_exact(count.max(1)).take(size).enumerate() {
        for (element, byte) in plain.chunks_exact_mut(size).zip(of_all) {
            element[place] = *byte;
        }
    }
    plain
}
