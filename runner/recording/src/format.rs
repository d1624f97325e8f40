//! Formats of recordings: identification and opening of a file.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use super::compressed::{self, Compression};
use super::error::RecordingError;
use super::table::Table;
use super::{csv, frames, hdf5, mat, npy, npz, parquet, tdms, uff, wav};
use ballrace_scene::{FileLayout, Recording};

/// Function that opens a file of one format.
type Open = fn(File, &Path, FileLayout) -> Result<Box<dyn Table>, RecordingError>;

/// Identification of a binary format.
struct Format {
    ending: &'static str,
    begins: &'static [u8],
    /// Bytes at a certain offset. A header of CSV may begin with `PAR1`, but has no control characters.
    goes_on: (usize, &'static [u8]),
    open: Open,
}

/// Returns the format of files with these first bytes.
const fn format(ending: &'static str, begins: &'static [u8], open: Open) -> Format {
    Format { ending, begins, goes_on: (0, b""), open }
}

const fn wav(begins: &'static [u8]) -> Format {
    Format { goes_on: (8, b"WAVE"), ..format("wav", begins, |file, path, _| wav::open(file, path)) }
}

const FORMATS: [Format; 16] = [
    format("mat", b"MATLAB 5.0 MAT-file", |file, path, _| mat::open(file, path)),
    format("mat", b"MATLAB 7.3 MAT-file", |file, path, _| hdf5::open(file, path)),
    format("h5", hdf5::SIGNATURE, |file, path, _| hdf5::open(file, path)),
    format("hdf5", hdf5::SIGNATURE, |file, path, _| hdf5::open(file, path)),
    format("npy", b"\x93NUMPY", npy::open),
    format("npz", b"PK\x03\x04", npz::open),
    Format { goes_on: (6, b" "), ..format("uff", uff::SEPARATOR, |file, path, _| uff::open(file, path)) },
    Format { goes_on: (6, b"\r"), ..format("unv", uff::SEPARATOR, |file, path, _| uff::open(file, path)) },
    Format { goes_on: (6, b"\n"), ..format("uff", uff::SEPARATOR, |file, path, _| uff::open(file, path)) },
    wav(wav::BEGINNINGS[0]),
    wav(wav::BEGINNINGS[1]),
    wav(wav::BEGINNINGS[2]),
    wav(wav::BEGINNINGS[3]),
    Format { goes_on: (4, b"\x15"), ..format("parquet", b"PAR1", |file, path, _| parquet::open(file, path)) },
    Format { goes_on: (5, b"\0\0\0"), ..format("tdms", b"TDSm", |file, path, _| tdms::open(file, path)) },
    // Without a beginning of its own: by the extension.
    format(frames::ENDING, b"", |_, path, _| Err(frames::without_scene(path))),
];

/// Returns true for the extension of a binary format.
pub(super) fn is_ending(ending: &str) -> bool {
    FORMATS.iter().any(|format| format.ending == ending)
}

/// Number of bytes that identify a format.
const IDENTIFICATION: u64 = 128;
/// Place of the version in a MATLAB file of version 5, which any text of its maker may precede, and its forms.
const MAT_VERSION: usize = 124;
const MAT_VERSIONS: [&[u8]; 2] = [b"\0\x01IM", b"\x01\0MI"];
/// Extensions of formats whose arrays have an orientation.
const ORIENTED: [&str; 2] = ["npy", "npz"];

/// Opens the file of a scene as [`open`] does; the columns of frames are those of the scene.
///
/// # Errors
/// As [`open`].
pub(super) fn open_of_scene(
    mut file: File,
    path: &Path,
    recording: &Recording,
) -> Result<(Box<dyn Table>, Option<u64>), RecordingError> {
    let unopened = |cause| RecordingError::Open { file: path.into(), cause };
    let compression = Compression::of(&mut file).map_err(unopened)?;
    // The extension of the compression hides that of the format.
    let inner = if compression.is_some() { path.with_extension("") } else { path.to_owned() };
    let of_frames = |format: &Format| format.ending == frames::ENDING;
    if !identified(&[], &inner, recording.layout).is_ok_and(|format| format.is_some_and(of_frames)) {
        return open(file, path, recording.layout);
    }
    match compression {
        Some(compression) => Ok((frames::open(compression.unpack(file, path)?, path, recording)?, None)),
        None => {
            let size = file.metadata().map_err(unopened)?.len();
            Ok((frames::open(Box::new(file), path, recording)?, Some(size)))
        }
    }
}

/// Opens a file of any format and returns its size, where that is comparable with the bytes read. The format is detected from
/// the content, then from the extension; compressed files are unpacked.
///
/// # Errors
/// A file that cannot be read as a table; a layout that the format does not have.
pub(super) fn open(
    mut file: File,
    path: &Path,
    layout: FileLayout,
) -> Result<(Box<dyn Table>, Option<u64>), RecordingError> {
    let unopened = |cause| RecordingError::Open { file: path.into(), cause };
    let Some(compression) = Compression::of(&mut file).map_err(unopened)? else {
        let size = file.metadata().map_err(unopened)?.len();
        let begin = first_bytes(&mut file).map_err(unopened)?;
        file.seek(SeekFrom::Start(0)).map_err(unopened)?;
        let table = match identified(&begin, path, layout)? {
            Some(format) => (format.open)(file, path, layout)?,
            None => csv::open(Box::new(file), path, layout)?,
        };
        return Ok((table, Some(size)));
    };
    let packed = file.metadata().map_err(unopened)?.len();
    let mut unpacked = compression.unpack(file, path)?;
    let begin = first_bytes(&mut unpacked).map_err(|cause| compressed::failed(path, cause))?;
    // The extension of the compression hides that of the format.
    let inner = path.with_extension("");
    let format = identified(&begin, &inner, layout)?;
    let whole = Cursor::new(begin).chain(unpacked);
    let table = match format {
        Some(format) => (format.open)(compressed::to_file(whole, path, packed)?, path, layout)?,
        None => csv::open(Box::new(whole), path, layout)?,
    };
    Ok((table, None))
}

fn first_bytes(source: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut begin = Vec::new();
    source.take(IDENTIFICATION).read_to_end(&mut begin)?;
    Ok(begin)
}

/// Returns the binary format of a file with these first bytes or this extension; nothing for text.
fn identified(begin: &[u8], path: &Path, layout: FileLayout) -> Result<Option<&'static Format>, RecordingError> {
    let has = |at: usize, bytes: &[u8]| begin.get(at..).unwrap_or_default().starts_with(bytes);
    let has_beginning = |format: &&Format| !format.begins.is_empty();
    let mut formats = FORMATS.iter().filter(has_beginning);
    let by_content = formats.find(|format| has(0, format.begins) && has(format.goes_on.0, format.goes_on.1));
    let is_mat = MAT_VERSIONS.iter().any(|version| has(MAT_VERSION, version));
    let by_content = by_content.or_else(|| FORMATS.iter().find(|format| is_mat && format.ending == "mat"));
    let ending = path.extension().unwrap_or_default();
    let by_name = || FORMATS.iter().find(|format| ending.eq_ignore_ascii_case(format.ending));
    let format = by_content.or_else(by_name);
    let misplaced = |key, expected| RecordingError::Misplaced { file: path.into(), key, expected };
    let of_text = [
        ("header", layout.is_headless, "`header = false` only for text"),
        ("skip", layout.skip.is_some(), "`skip` only for text"),
        ("comment", layout.comment.is_some(), "`comment` only for text"),
    ];
    if let Some((key, _, expected)) = of_text.into_iter().find(|(_, given, _)| *given && format.is_some()) {
        return Err(misplaced(key, expected));
    }
    if layout.orientation.is_some() && !format.is_some_and(|format| ORIENTED.contains(&format.ending)) {
        return Err(misplaced("orientation", "`orientation` only for NPY and NPZ files"));
    }
    Ok(format)
}
