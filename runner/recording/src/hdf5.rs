//! HDF5 files as recordings, MATLAB files of version 7.3 among them: vectors, and columns of matrices, by their paths, such as
//! `/rig/x` and `/rig/m[:,1]`, or `bearing.gs` and `m(:,2)` of MATLAB. Those that the scene names are held in memory.
//!
//! Format: The HDF Group, HDF5 File Format Specification, version 3.0. The reader supports superblocks 0 to 3, both forms of
//! object headers, groups by symbol tables, links and fractal heaps, and datasets that are compact, contiguous or in chunks under any index,
//! with the filters deflate, shuffle and Fletcher-32. The fields of a compound type are vectors, such as `/table.x`.

mod chunk_index;
mod data;
mod group;
mod object;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
mod walk;

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use self::object::Dataset;
use super::bytes::Bytes;
use super::error::{RecordingError, refuse};
use super::numbers::{LoadedColumns, Number};
use super::table::{Cells, LONGEST_VECTOR, Table, equal_lengths};
use ballrace_base::printable::name;

const EXPECTED: &str = "an HDF5 file with vectors of integers or floats, uncompressed or by deflate";

/// First bytes of the superblock.
pub(super) const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Largest number of bytes of all vectors, which are held in memory.
const LARGEST: u64 = 1 << 30;
/// Largest compression ratio of deflate.
const TIGHTEST: u64 = 1032;
/// Address of an absent object.
const UNDEFINED: u64 = u64::MAX;

/// A file, read at addresses from its superblock.
struct Source {
    file: File,
    /// Offset of the superblock, from which addresses count.
    base: u64,
    size: u64,
    bytes_read: u64,
}

impl Source {
    /// Reads bytes within the file.
    fn read(&mut self, address: u64, length: u64) -> io::Result<Vec<u8>> {
        let start = self.base.checked_add(address).ok_or(io::ErrorKind::UnexpectedEof)?;
        if start.checked_add(length).is_none_or(|end| end > self.size) {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        self.file.seek(SeekFrom::Start(start))?;
        let mut bytes = Vec::new();
        (&mut self.file).take(length).read_to_end(&mut bytes)?;
        self.bytes_read += length;
        if bytes.len() as u64 == length { Ok(bytes) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
    }

    /// Reads a structure that begins with four letters.
    fn structure(&mut self, address: u64, letters: &[u8; 4], length: u64) -> io::Result<Vec<u8>> {
        let bytes = self.read(address, length)?;
        if bytes.starts_with(letters) {
            return Ok(bytes);
        }
        Err(refuse(format!("no `{}` at address {address}", String::from_utf8_lossy(letters))))
    }

    /// Finds the superblock at 0, 512, 1024, 2048, ... and returns the address of the root group.
    fn open(mut file: File) -> io::Result<(Self, u64)> {
        let size = file.metadata()?.len();
        let mut base = 0;
        loop {
            let mut begin = Vec::new();
            file.seek(SeekFrom::Start(base))?;
            (&mut file).take(SIGNATURE.len() as u64).read_to_end(&mut begin)?;
            if begin == SIGNATURE {
                break;
            }
            base = if base == 0 { 512 } else { base * 2 };
            if base >= size {
                return Err(refuse("no HDF5 file"));
            }
        }
        let mut source = Self { file, base, size, bytes_read: 0 };
        let version = source.read(8, 1)?.first().copied().unwrap_or_default();
        // Sizes of addresses and lengths, and the place of the address of the root group.
        let (sizes, root) = match version {
            0 => (13, 64),
            1 => (13, 68),
            2 | 3 => (9, 36),
            version => return Err(refuse(format!("a superblock of version {version}"))),
        };
        let sizes = source.read(sizes, 2)?;
        if sizes != [8, 8] {
            return Err(refuse(format!("addresses and lengths of {sizes:?} bytes")));
        }
        let root = little(&source.read(root, 8)?).u64()?;
        Ok((source, root))
    }
}

/// Returns a reader of bytes in little-endian order, the order of all metadata.
const fn little(bytes: &[u8]) -> Bytes<'_> {
    Bytes { rest: bytes, big_endian: false }
}

fn wrong(path: &Path, cause: &io::Error) -> RecordingError {
    RecordingError::unreadable(path, cause, EXPECTED)
}

/// A vector of a dataset: all of it, or a column or row.
#[derive(Debug, Clone, Copy)]
struct Vector {
    /// Place in the list of datasets.
    dataset: usize,
    /// Dimension along which it lies.
    along: usize,
    /// Dimension and index at which a matrix is cut.
    cut: Option<(usize, u64)>,
}

/// The vectors of a file.
struct Hdf5 {
    path: PathBuf,
    source: Source,
    names: Vec<String>,
    vectors: Vec<Vector>,
    datasets: Vec<Dataset>,
    scalars: Vec<(String, walk::Scalar)>,
    /// Paths of data that cannot be columns, with the reason.
    refused: Vec<(String, String)>,
    is_matlab: bool,
    selected: LoadedColumns,
}

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let contents = |file: &mut File| {
        let mut begin = Vec::new();
        file.take(6).read_to_end(&mut begin)?;
        let is_matlab = begin == b"MATLAB";
        let (mut source, root) = Source::open(file.try_clone()?)?;
        let found = walk::content(&mut source, root, is_matlab)?;
        Ok((source, found, is_matlab))
    };
    let (source, found, is_matlab) = contents(&mut file).map_err(|cause: io::Error| wrong(path, &cause))?;
    if found.vectors.is_empty() {
        let reason = found.refused.first().map(|(path, reason)| format!("`{}`: {reason}", name(path)));
        return Err(wrong(path, &refuse(reason.unwrap_or_else(|| "no vector of numbers".to_owned()))));
    }
    let (names, vectors) = found.vectors.into_iter().unzip();
    let (datasets, scalars, refused, path) = (found.datasets, found.scalars, found.refused, path.into());
    Ok(Box::new(Hdf5 {
        path,
        source,
        names,
        vectors,
        datasets,
        scalars,
        refused,
        is_matlab,
        selected: LoadedColumns::default(),
    }))
}

impl Hdf5 {
    fn is_same(&self, own: &str, name: &str) -> bool {
        if self.is_matlab {
            return own == name || (name.contains("(1).") && own == name.replace("(1).", "."));
        }
        own == name || own.strip_prefix('/') == Some(name)
    }

    /// Reads the selected vectors, those of one dataset together.
    fn load(&mut self, places: &[usize]) -> io::Result<Vec<(Number, Vec<u8>)>> {
        let chosen: Vec<Vector> = places.iter().filter_map(|place| self.vectors.get(*place).copied()).collect();
        let mut loaded = vec![None; chosen.len()];
        for first in 0..chosen.len() {
            if loaded[first].is_some() {
                continue;
            }
            let of = chosen[first].dataset;
            let Some(dataset) = self.datasets.get(of) else { continue };
            let (own, vectors): (Vec<usize>, Vec<Vector>) =
                chosen.iter().copied().enumerate().filter(|(_, vector)| vector.dataset == of).unzip();
            let bytes = data::load(&mut self.source, dataset, &vectors)?;
            for (place, bytes) in own.into_iter().zip(bytes) {
                loaded[place] = Some((dataset.number, bytes));
            }
        }
        Ok(loaded.into_iter().flatten().collect())
    }
}

impl Table for Hdf5 {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn is_called(&self, place: usize, name: &str) -> bool {
        self.names.get(place).is_some_and(|own| self.is_same(own, name))
    }

    fn refusal(&self, wanted: &str) -> Option<RecordingError> {
        let is_within = |own: &str| {
            let longer = wanted.strip_prefix(own).or_else(|| wanted.strip_prefix(own.strip_prefix('/')?));
            longer.is_some_and(|rest| rest.is_empty() || rest.starts_with(['[', '(', '.']))
        };
        let (path, reason) = self.refused.iter().find(|(own, _)| is_within(own))?;
        Some(wrong(&self.path, &refuse(format!("`{}`: {reason}", name(path)))))
    }

    fn vector(&mut self, place: usize) -> Result<Option<Vec<f64>>, RecordingError> {
        let count = self
            .vectors
            .get(place)
            .and_then(|vector| Some(self.datasets.get(vector.dataset)?.length(vector.along)))
            .unwrap_or(0);
        if count > LONGEST_VECTOR {
            return Err(wrong(&self.path, &refuse(format!("a vector of {count} values, more than {LONGEST_VECTOR}"))));
        }
        let loaded = self.load(&[place]).map_err(|cause| wrong(&self.path, &cause))?;
        Ok(Some(LoadedColumns::new(loaded, count).first()))
    }

    fn scalar(&mut self, name: &str) -> Result<Option<f64>, RecordingError> {
        let found = self.scalars.iter().find(|(own, _)| self.is_same(own, name));
        match found.map(|(_, scalar)| *scalar) {
            None => Ok(None),
            Some(walk::Scalar::Value(value)) => Ok(Some(value)),
            Some(walk::Scalar::Dataset(place)) => {
                let Some(dataset) = self.datasets.get(place) else { return Ok(None) };
                let vector = Vector { dataset: place, along: 0, cut: None };
                let bytes = data::load(&mut self.source, dataset, &[vector]).map_err(|e| wrong(&self.path, &e))?;
                Ok(bytes.first().map(|bytes| dataset.number.read(bytes)))
            }
        }
    }

    fn scalar_names(&self) -> Vec<String> {
        self.scalars.iter().map(|(name, _)| name.clone()).collect()
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let length = |vector: &Vector| Some((self.datasets.get(vector.dataset)?, vector.along));
        let chosen: Vec<(&str, u64, u64)> = places
            .iter()
            .filter_map(|place| {
                let (dataset, along) = length(self.vectors.get(*place)?)?;
                let count = dataset.length(along);
                Some((self.names.get(*place)?.as_str(), count, count.saturating_mul(dataset.number.bytes.into())))
            })
            .collect();
        let lengths: Vec<_> = chosen.iter().map(|(name, count, _)| (*name, *count)).collect();
        let rows = equal_lengths(&self.path, &lengths)?;
        let bytes = chosen.iter().fold(0_u64, |sum, (_, _, bytes)| sum.saturating_add(*bytes));
        if bytes > LARGEST {
            return Err(wrong(&self.path, &refuse(format!("{bytes} bytes of vectors, more than {LARGEST}"))));
        }
        let loaded = self.load(places).map_err(|cause| wrong(&self.path, &cause))?;
        self.selected = LoadedColumns::new(loaded, rows);
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        Ok(self.selected.next(self.names.len(), cells))
    }

    fn bytes_read(&self) -> u64 {
        self.source.bytes_read.min(self.source.size)
    }
}
