//! Binary frames of a log or of a live source: a sequence number and one reading of each column, little-endian.
//!
//! A frame consists of the `u32` sequence number, one `f32` for each probe in the order of the scene, then for each sensor, and one `f32` for the
//! keyphasor or speed column if the scene has one, in the units of the scene. The sequence number counts samples and wraps. A
//! reading that is not finite is missing. Frames with a checksum end with the `u32` CRC-32 (IEEE 802.3, as in zlib) of the
//! bytes before it.
//!
//! A file of frames with a checksum (extension `.frames`) is a recording: `ballrace::log::frame` and `ballrace_log_frame` write its frames.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use super::Row;
use super::error::RecordingError;
use super::table::{Cells, Omitted, Table};
use ballrace_scene::{KeyphasorSignal, Recording, RotationSource};
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

/// Length of a CRC-32, bytes.
const CHECKSUM_LENGTH: usize = 4;

/// Decoder of frames.
#[derive(Debug, Clone)]
pub struct FrameLayout {
    /// Metres per unit, and offset in metres, of each probe.
    probes: Vec<[f64; 2]>,
    /// Number of vibration sensors.
    sensors: usize,
    /// Factor of the keyphasor column (1, or volts per unit) or of the speed column (rad/s per unit); `None` without such a column.
    rotation: Option<f64>,
    /// Frames end with their CRC-32.
    has_checksum: bool,
}

impl FrameLayout {
    /// Creates the decoder for the columns of a recording.
    #[must_use]
    pub fn new(recording: &Recording, has_checksum: bool) -> Self {
        Self {
            probes: recording.probes.iter().map(|p| [p.metres_per_unit, p.offset]).collect(),
            sensors: recording.sensors.len(),
            rotation: recording.rotation.factor(),
            has_checksum,
        }
    }

    /// Returns the length of a frame, bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        4 * (1 + self.probes.len() + self.sensors + usize::from(self.rotation.is_some()))
            + if self.has_checksum { CHECKSUM_LENGTH } else { 0 }
    }

    /// Returns `true` if the frame has the right length and, for frames with a checksum, the right CRC-32.
    #[must_use]
    pub fn is_valid(&self, frame: &[u8]) -> bool {
        if frame.len() != self.size() {
            return false;
        }
        match frame.split_last_chunk::<CHECKSUM_LENGTH>() {
            Some((content, crc)) if self.has_checksum => crc32fast::hash(content) == u32::from_le_bytes(*crc),
            _ => true,
        }
    }

    /// Returns the sequence number and the readings in the units of the scene; `None` if the frame is invalid. A checksum may follow the
    /// readings.
    fn words<'a>(&self, frame: &'a [u8]) -> Option<(u32, impl Iterator<Item = f64> + use<'a>)> {
        let (words, _) = frame.as_chunks::<4>();
        let (number, readings) = words.split_first().filter(|_| self.is_valid(frame))?;
        Some((u32::from_le_bytes(*number), readings.iter().map(|word| f64::from(f32::from_le_bytes(*word)))))
    }

    /// Stores the readings of a frame in `row` and returns its sequence number; `None` if the frame is invalid.
    pub fn read(&self, frame: &[u8], row: &mut Row) -> Option<u32> {
        let (number, mut values) = self.words(frame)?;
        row.probes.clear();
        for ([unit, offset], value) in self.probes.iter().zip(values.by_ref()) {
            row.probes.push(if value.is_finite() { value * unit - offset } else { f64::NAN });
        }
        row.sensors.clear();
        row.sensors.extend(values.by_ref().take(self.sensors).map(|x| if x.is_finite() { x } else { f64::NAN }));
        row.temperatures.clear();
        row.rotation = match self.rotation.map(|unit| (unit, values.next())) {
            Some((unit, Some(value))) if value.is_finite() => value * unit,
            Some(_) => f64::NAN,
            None => 0.0,
        };
        Some(number)
    }
}

const EXPECTED: &str = "a file of frames: u32 sequence number, f32 for each probe, sensor and the keyphasor or speed column of the scene, \
                        u32 CRC-32 of the bytes before it";

/// Extension of a file of frames with a checksum.
pub(super) const ENDING: &str = "frames";

/// Returns the error of frames that are opened without the columns of a scene.
pub(super) fn without_scene(path: &Path) -> RecordingError {
    let found = "frames, which have no names of columns".to_owned();
    let expected = "a single file, whose columns [recording] of a scene names in their order";
    RecordingError::Format { file: path.into(), found, expected }
}

/// A file of frames with a checksum.
struct Frames {
    path: PathBuf,
    file: BufReader<Box<dyn Read + Send>>,
    layout: FrameLayout,
    names: Vec<String>,
    selected: Vec<usize>,
    /// Bytes of the frame that is read, and how many of them are there.
    frame: Vec<u8>,
    length: usize,
    /// Place of these bytes in the file.
    at: u64,
    /// Sequence number of the next frame; none before the first.
    next_number: Option<u32>,
    row: u64,
}

/// Opens a file. The columns have the names of the scene.
pub(super) fn open(
    file: Box<dyn Read + Send>,
    path: &Path,
    recording: &Recording,
) -> Result<Box<dyn Table>, RecordingError> {
    let channels = recording.probes.iter().map(|probe| &probe.column);
    let mut names: Vec<String> =
        channels.chain(recording.sensors.iter().map(|sensor| &sensor.column)).cloned().collect();
    match &recording.rotation {
        RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. } => {
            let found = "keyphasor.kind = \"instants\" in the scene, and frames have no instants".to_owned();
            return Err(RecordingError::Format { file: path.into(), found, expected: "\"pulses\" or \"count\"" });
        }
        RotationSource::Keyphasor { column, .. } | RotationSource::SpeedColumn { column, .. } => {
            names.push(column.clone());
        }
        RotationSource::Scene | RotationSource::Synchronous => {}
    }
    let layout = FrameLayout::new(recording, true);
    let frame = vec![0; layout.size()];
    let (path, file) = (path.into(), BufReader::new(file));
    let (selected, next_number) = (Vec::new(), None);
    Ok(Box::new(Frames { path, file, layout, names, selected, frame, length: 0, at: 0, next_number, row: 0 }))
}

impl Frames {
    /// Reads until the bytes are a valid frame, and adds what has to be omitted before it; false at the end. Frames have no start mark: after
    /// a damaged one the next is searched byte by byte.
    fn find(&mut self, omitted: &mut Omitted) -> io::Result<bool> {
        let mut is_aligned = true;
        loop {
            while let Some(rest) = self.frame.get_mut(self.length..).filter(|rest| !rest.is_empty()) {
                match self.file.read(rest)? {
                    0 => {
                        omitted.damaged += u64::from(self.length > 0 && is_aligned);
                        self.at += std::mem::take(&mut self.length) as u64;
                        return Ok(false);
                    }
                    read => self.length += read,
                }
            }
            if self.layout.is_valid(&self.frame) {
                return Ok(true);
            }
            omitted.damaged += u64::from(std::mem::replace(&mut is_aligned, false));
            self.frame.copy_within(1.., 0);
            self.length -= 1;
            self.at += 1;
        }
    }

    fn wrong(&self, found: String) -> RecordingError {
        RecordingError::Format { file: self.path.clone(), found, expected: EXPECTED }
    }

    /// Returns the number of samples that are missing before the frame `number`.
    fn missing(&mut self, number: u32) -> Result<u64, RecordingError> {
        let expected = self.next_number.replace(number.wrapping_add(1)).unwrap_or(number);
        // Sequence numbers wrap: the difference of smaller magnitude applies.
        u64::try_from(number.wrapping_sub(expected).cast_signed()).map_err(|_| {
            self.wrong(format!(
                "the sequence number {number} after {} in the frame at byte {}: a log that began anew, or frames that repeat",
                expected.wrapping_sub(1),
                self.at
            ))
        })
    }
}

impl Table for Frames {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        self.selected = places.to_vec();
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        cells.omitted = Omitted::default();
        let failed = |path: &Path, line, cause| RecordingError::Read { file: path.into(), line, cause };
        let found = self.find(&mut cells.omitted).map_err(|cause| failed(&self.path, self.row, cause))?;
        if !found && self.row == 0 {
            let (size, bytes) = (self.layout.size(), self.at);
            return Err(self.wrong(format!("no frame of {size} bytes with the right checksum in {bytes} bytes")));
        }
        let read = self.layout.words(&self.frame).filter(|_| found);
        let Some((number, values)) = read.map(|(number, values)| (number, values.collect::<Vec<_>>())) else {
            return Ok(false);
        };
        cells.omitted.missing = self.missing(number)?;
        self.row += 1;
        (cells.line, cells.whole) = (self.row, self.names.len());
        cells.values.clear();
        cells.values.extend(self.selected.iter().map(|place| values.get(*place).copied().unwrap_or(f64::NAN)));
        self.length = 0;
        self.at += self.frame.len() as u64;
        Ok(true)
    }

    fn bytes_read(&self) -> u64 {
        self.at
    }
}
