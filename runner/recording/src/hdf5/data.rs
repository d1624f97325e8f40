//! Numbers of datasets: compact, contiguous, or in chunks.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use super::chunk_index;
use super::object::{Chunking, Dataset, Filter, Layout};
use super::{LARGEST, Source, TIGHTEST, UNDEFINED, Vector, refuse};

/// Bytes of a contiguous dataset that are read at once.
const BLOCK: u64 = 1 << 20;

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
        Layout::Contiguous { address: UNDEFINED } | Layout::Chunked(Chunking { address: UNDEFINED, .. }) => {}
        Layout::Contiguous { address } => contiguous(source, dataset, *address, &mut copy)?,
        Layout::Chunked(chunking) => chunked(source, (dataset, chunking), vectors, &mut copy)?,
    }
    Ok(loaded)
}

/// Reads all bytes of a dataset of one dimension.
pub(super) fn all(source: &mut Source, dataset: &Dataset) -> io::Result<Vec<u8>> {
    match &dataset.layout {
        Layout::Compact(bytes) => Ok(bytes.clone()),
        Layout::Contiguous { address } => source.read(*address, whole(dataset)?),
        Layout::Chunked(_) => Err(refuse("references in chunks")),
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

/// Reads those chunks of a dataset that `vectors` cross, one after the other.
fn chunked(
    source: &mut Source,
    (dataset, chunking): (&Dataset, &Chunking),
    vectors: &[Vector],
    copy: &mut impl FnMut(&Part<'_>),
) -> io::Result<()> {
    let chunk = chunking.lengths.as_slice();
    let unpacked = chunk.iter().try_fold(dataset.width, |bytes, length| bytes.checked_mul(*length));
    let most = source.size.saturating_mul(TIGHTEST).min(LARGEST);
    let unpacked = unpacked.filter(|bytes| *bytes <= most).ok_or_else(|| refuse("a chunk that is too large"))?;
    let crosses = |first: &[u64], vector: &Vector| {
        let mut dimensions = first.iter().zip(chunk).enumerate().filter(|(place, _)| *place != vector.along);
        dimensions.all(|(place, (first, length))| {
            let index = vector.cut.filter(|(across, _)| *across == place).map_or(0, |(_, index)| index);
            index.checked_sub(*first).is_some_and(|within| within < *length)
        })
    };
    let is_wanted = |first: &[u64]| vectors.iter().any(|vector| crosses(first, vector));
    let mut visit = |source: &mut Source, place: chunk_index::Place, first: &[u64]| {
        let is_edge = || {
            let mut ends = first.iter().zip(chunk).map(|(first, length)| first.saturating_add(*length));
            dataset.lengths.iter().any(|length| ends.next().is_some_and(|end| end > *length))
        };
        let mask = if chunking.has_plain_edges && is_edge() { u32::MAX } else { place.mask };
        let bytes = unfiltered(source.read(place.address, place.length)?, dataset, mask, unpacked)?;
        copy(&Part { offset: first, lengths: chunk, bytes: &bytes });
        Ok(())
    };
    chunk_index::visit(source, (dataset, chunking), unpacked, &is_wanted, &mut visit)
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
