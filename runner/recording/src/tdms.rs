//! TDMS files (National Instruments) as recordings: the channels are the columns, `Group/Channel` or, where only one group
//! has it, `Channel`.
//!
//! A file is a sequence of segments. Each has a lead-in, then the changes of its objects, then the numbers: channel after
//! channel in chunks of equal size, or interleaved. Properties that a segment omits are those of the previous one. Raw counts
//! of the DAQmx driver are stored row by row, with linear scales.

mod scale;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::bytes::Bytes;
use super::error::{RecordingError, refuse};
use super::numbers::{Kind, Lane, Layout, Number, Numbers, Run};
use super::table::Table;
use scale::Scales;

const EXPECTED: &str = "a TDMS file of numbers, or of DAQmx raw data with linear scales";

/// Bytes before the metadata of a segment.
const LEAD_IN: u64 = 28;
/// Longest description of the objects of a segment.
const LONGEST: u64 = 1 << 26;
/// Largest number of objects.
const MOST: usize = 1 << 14;

/// Bits of the lead-in's table of contents.
const METADATA: u32 = 1 << 1;
const NEW_LIST: u32 = 1 << 2;
const RAW_DATA: u32 = 1 << 3;
const INTERLEAVED: u32 = 1 << 5;
const BIG_ENDIAN: u32 = 1 << 6;
const DAQMX: u32 = 1 << 7;

/// In place of the length of an object's index: no data, the same as before, DAQmx data.
const NO_DATA: u32 = u32::MAX;
const AS_BEFORE: u32 = 0;
const SCALER: u32 = 0x1269;
const DIGITAL_SCALER: u32 = 0x126a;

/// Opens a file.
pub(super) fn open(mut file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let layout = read(&mut file).map_err(|cause| {
        let found = match cause.kind() {
            io::ErrorKind::UnexpectedEof => "a description of channels that is truncated".into(),
            _ => cause.to_string(),
        };
        RecordingError::Format { file: path.into(), found, expected: EXPECTED }
    })?;
    Ok(Box::new(Numbers::new(file, path, layout)))
}

fn read(file: &mut File) -> io::Result<Layout> {
    let size = file.metadata()?.len();
    let (mut objects, mut start, mut torn) = (Objects::default(), 0, false);
    while start < size {
        match segment(file, start, size, &mut objects) {
            Ok((end, broken)) => (start, torn) = (end, torn || broken),
            // The logger was stopped while it wrote the lead-in of another segment.
            Err(cause) if cause.kind() == io::ErrorKind::UnexpectedEof && start > 0 => {
                torn = true;
                break;
            }
            Err(cause) => return Err(cause),
        }
    }
    let lanes = objects.all.into_iter().filter_map(Object::lane).collect();
    Ok(Layout { torn, ..Layout::of(lanes, EXPECTED) })
}

/// Lead-in of a segment.
struct LeadIn {
    contents: u32,
    /// Offsets of its metadata, its numbers and the next segment.
    head: u64,
    numbers: u64,
    end: u64,
    /// The file ends within the segment.
    torn: bool,
}

impl LeadIn {
    fn read(file: &mut File, start: u64, size: u64) -> io::Result<Self> {
        file.seek(SeekFrom::Start(start))?;
        let mut bytes = [0; LEAD_IN as usize];
        file.read_exact(&mut bytes)?;
        let mut bytes = Bytes { rest: &bytes, big_endian: false };
        if bytes.take(4)? != b"TDSm" {
            return Err(refuse(format!("no segment at byte {start}")));
        }
        let contents = bytes.u32()?;
        bytes.big_endian = contents & BIG_ENDIAN != 0;
        let (_version, next, raw) = (bytes.u32()?, bytes.u64()?, bytes.u64()?);
        let head = start + LEAD_IN;
        // The length of a segment that is still being written is all ones.
        let declared = head.checked_add(next).filter(|_| next != u64::MAX);
        let numbers = head.checked_add(raw).filter(|numbers| declared.is_none_or(|declared| *numbers <= declared));
        let numbers =
            numbers.ok_or_else(|| refuse(format!("numbers behind the end of the segment at byte {start}")))?;
        if numbers > size {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        let end = declared.unwrap_or(size).min(size);
        Ok(Self { contents, head, numbers, end, torn: declared.is_some_and(|declared| declared > size) })
    }

    const fn has(&self, bit: u32) -> bool {
        self.contents & bit != 0
    }
}

/// Reads a segment; returns its end, and true where numbers are missing there.
fn segment(file: &mut File, start: u64, size: u64, objects: &mut Objects) -> io::Result<(u64, bool)> {
    let lead = LeadIn::read(file, start, size)?;
    let big_endian = lead.has(BIG_ENDIAN);
    if lead.has(METADATA) {
        let length = lead.numbers - lead.head;
        if length > LONGEST {
            return Err(refuse(format!("{length} bytes about the channels")));
        }
        let mut about = Vec::new();
        file.take(length).read_to_end(&mut about)?;
        objects.describe(Bytes { rest: &about, big_endian }, lead.has(NEW_LIST))?;
    }
    if !lead.has(RAW_DATA) {
        return Ok((lead.end, lead.torn));
    }
    let bytes = lead.end - lead.numbers;
    let broken = if lead.has(DAQMX) {
        objects.place_raw(lead.numbers, bytes, big_endian)
    } else {
        objects.place(lead.numbers, bytes, lead.has(INTERLEAVED), big_endian)?
    };
    Ok((lead.end, lead.torn || broken))
}

/// All objects so far, and those that the numbers of a segment belong to, in their order.
#[derive(Default)]
struct Objects {
    all: Vec<Object>,
    places: HashMap<String, usize>,
    active: Vec<usize>,
}

/// A file, a group or a channel.
#[derive(Default)]
struct Object {
    path: String,
    index: Option<Index>,
    runs: Vec<Run>,
    unit: Option<String>,
    /// Sampling interval, s.
    increment: Option<f64>,
    scales: Scales,
}

/// Data of an object in each chunk.
#[derive(Clone, Copy)]
struct Index {
    kind: u32,
    values: u64,
    bytes: u64,
    raw: Option<Raw>,
}

/// Location of a channel's count in each row of DAQmx raw data.
#[derive(Clone, Copy)]
struct Raw {
    offset: u64,
    /// Data of a row.
    width: u64,
    /// Number by which scales refer to the count.
    scale: u32,
}

impl Objects {
    /// Reads the changes of the objects of a segment.
    fn describe(&mut self, mut bytes: Bytes<'_>, new_list: bool) -> io::Result<()> {
        if new_list {
            self.active.clear();
        }
        for _ in 0..bytes.u32()? {
            let path = bytes.text()?;
            let place = *self.places.entry(path.clone()).or_insert(self.all.len());
            if place == self.all.len() {
                self.all.push(Object { path, ..Object::default() });
            }
            if self.all.len() > MOST {
                return Err(refuse(format!("more than {MOST} channels")));
            }
            let Some(object) = self.all.get_mut(place) else { continue };
            let has_data = object.read_index(&mut bytes)?;
            object.read_properties(&mut bytes)?;
            match (has_data, self.active.contains(&place)) {
                (true, false) => self.active.push(place),
                (false, true) => self.active.retain(|active| *active != place),
                _ => {}
            }
        }
        Ok(())
    }

    /// Assigns the numbers of a segment to its channels; returns true where it ends within a chunk.
    fn place(&mut self, start: u64, bytes: u64, interleaved: bool, big_endian: bool) -> io::Result<bool> {
        let index = |place: &usize| Some((*place, self.all.get(*place)?.index?));
        let plain = |(_, index): &(usize, Index)| index.bytes > 0 && index.raw.is_none();
        let indices: Vec<_> = self.active.iter().filter_map(index).filter(plain).collect();
        let width = |index: &Index| if interleaved { element(index.kind) } else { Some(index.bytes) };
        let chunk = indices.iter().try_fold(0_u64, |sum, (_, index)| sum.checked_add(width(index)?));
        let chunk = chunk.ok_or_else(|| refuse("values of unknown length among the numbers"))?;
        if chunk == 0 || bytes < chunk {
            return Ok(bytes > 0);
        }
        let (chunks, mut at) = (bytes / chunk, start);
        for (place, index) in indices {
            if let (Some(object), Some(number)) = (self.all.get_mut(place), number(index.kind, big_endian)) {
                let own = Run::once(number, at, number.bytes.into(), index.values);
                let run = if interleaved {
                    Run { stride: chunk, count: chunks, ..own }
                } else {
                    Run { every: chunk, repeats: chunks, ..own }
                };
                append(&mut object.runs, run);
            }
            at += width(&index).unwrap_or(0);
        }
        Ok(!bytes.is_multiple_of(chunk))
    }
}

impl Objects {
    /// Assigns the rows of DAQmx raw data to the channels; returns true where they end within a row.
    fn place_raw(&mut self, start: u64, bytes: u64, big_endian: bool) -> bool {
        let mut broken = false;
        for place in &self.active {
            let Some(object) = self.all.get_mut(*place) else { continue };
            let Some((index, raw)) = object.index.and_then(|index| Some((index, index.raw?))) else { continue };
            broken |= !bytes.is_multiple_of(raw.width);
            if let Some(number) = number(index.kind, big_endian).filter(|_| bytes >= raw.width) {
                let run = Run::once(number, start + raw.offset, raw.width, bytes / raw.width);
                append(&mut object.runs, run);
            }
        }
        broken
    }
}

/// Joins segments of equal layout to one run, so that memory does not grow with the file.
fn append(runs: &mut Vec<Run>, run: Run) {
    if let Some(last) = runs.last_mut()
        && (last.number, last.stride, last.count, 1) == (run.number, run.stride, run.count, run.repeats)
    {
        if last.repeats == 1 {
            (last.every, last.repeats) = (run.start - last.start, 2);
            return;
        }
        if last.start + last.every * last.repeats == run.start {
            last.repeats += 1;
            return;
        }
    }
    runs.push(run);
}

impl Object {
    /// Reads the index of the object; returns true where it has data in the segment.
    fn read_index(&mut self, bytes: &mut Bytes<'_>) -> io::Result<bool> {
        match bytes.u32()? {
            NO_DATA => return Ok(false),
            AS_BEFORE if self.index.is_some() => return Ok(true),
            AS_BEFORE => return Err(refuse(format!("`{}` as before, without a before", self.path))),
            SCALER => {
                self.index = Some(self.read_scaler(bytes)?);
                return Ok(true);
            }
            DIGITAL_SCALER => return Err(refuse("DAQmx raw data of digital lines")),
            _ => {}
        }
        let (kind, dimension, values) = (bytes.u32()?, bytes.u32()?, bytes.u64()?);
        let size = if kind == STRING { Some(bytes.u64()?) } else { element(kind).and_then(|n| n.checked_mul(values)) };
        let Some(size) = size.filter(|_| dimension == 1) else {
            return Err(refuse(format!("`{}` with {values} values of type {kind:#x}", self.path)));
        };
        self.index = Some(Index { kind, values, bytes: size, raw: None });
        Ok(true)
    }

    /// Reads the index of an analogue channel: one count a row, in one buffer.
    fn read_scaler(&self, bytes: &mut Bytes<'_>) -> io::Result<Index> {
        let (_kind, _dimension, values) = (bytes.u32()?, bytes.u32()?, bytes.u64()?);
        let scalers = bytes.u32()?;
        let (kind, buffer, offset) = (bytes.u32()?, bytes.u32()?, u64::from(bytes.u32()?));
        let (_bitmap, scale, widths) = (bytes.u32()?, bytes.u32()?, bytes.u32()?);
        let width = u64::from(bytes.u32()?);
        // The driver's own numbers of the types.
        let kind = [5, 1, 6, 2, 7, 3].get(kind as usize).copied();
        let fits = kind.and_then(element).is_some_and(|size| offset + size <= width);
        match kind.filter(|_| (scalers, buffer, widths) == (1, 0, 1) && fits) {
            Some(kind) => Ok(Index { kind, values, bytes: 0, raw: Some(Raw { offset, width, scale }) }),
            None => Err(refuse(format!("DAQmx raw data of `{}` in several buffers or of another type", self.path))),
        }
    }

    fn read_properties(&mut self, bytes: &mut Bytes<'_>) -> io::Result<()> {
        for _ in 0..bytes.u32()? {
            let (name, kind) = (bytes.text()?, bytes.u32()?);
            if kind == STRING {
                let text = bytes.text()?;
                match name.as_str() {
                    "unit_string" => self.unit = Some(text),
                    "NI_UnitDescription" if self.unit.is_none() => self.unit = Some(text),
                    _ => self.scales.text(&name, &text),
                }
                continue;
            }
            let size = element(kind).ok_or_else(|| refuse(format!("property `{name}` of type {kind:#x}")))?;
            let value = bytes.take(size)?;
            let value = number(kind, bytes.big_endian).map(|number| number.read(value));
            match name.as_str() {
                "wf_increment" => self.increment = value,
                _ => self.scales.number(&name, value.unwrap_or(f64::NAN)),
            }
        }
        Ok(())
    }

    /// Returns the column of a channel; `None` for a file or a group.
    fn lane(mut self) -> Option<Lane> {
        let (group, name) = channel(&self.path)?;
        let raw = self.index.and_then(|index| index.raw);
        let refused = match (self.index, self.scales.line(raw.map(|raw| raw.scale))) {
            // Unscaled values would be read as volts or metres.
            (_, Err(why)) => Some(why),
            (Some(index), _) if number(index.kind, false).is_none() => Some("contains no numbers".to_owned()),
            (_, Ok([slope, intercept])) => {
                for run in &mut self.runs {
                    (run.number.scale, run.number.offset) = (slope, intercept);
                }
                None
            }
        };
        let rate = self.increment.map(f64::recip).filter(|rate| rate.is_finite() && *rate > 0.0);
        Some(Lane { name, group: Some(group), unit: self.unit, rate, runs: self.runs, refused })
    }
}

/// Returns `Group` and `Group/Channel` of the path `/'Group'/'Channel'`, in which a quotation mark is doubled.
fn channel(path: &str) -> Option<(String, String)> {
    let (group, channel) = path.strip_prefix("/'")?.strip_suffix('\'')?.split_once("'/'")?;
    let group = group.replace("''", "'");
    let name = format!("{group}/{}", channel.replace("''", "'"));
    Some((group, name))
}

const STRING: u32 = 0x20;

/// Returns the number of bytes of one value; `None` for a type without a fixed number.
const fn element(kind: u32) -> Option<u64> {
    Some(match kind {
        0 => 0,
        1 | 5 | 0x21 => 1,
        2 | 6 => 2,
        3 | 7 | 9 | 0x19 => 4,
        4 | 8 | 10 | 0x1a | 0x08_000c => 8,
        // Time stamps and complex numbers.
        0x44 | 0x10_000d => 16,
        _ => return None,
    })
}

fn number(kind: u32, big_endian: bool) -> Option<Number> {
    let meaning = match kind {
        1..=4 => Kind::Signed,
        5..=8 | 0x21 => Kind::Unsigned,
        9 | 10 | 0x19 | 0x1a => Kind::Float,
        _ => return None,
    };
    let bytes = u8::try_from(element(kind)?).ok()?;
    Some(Number::new(meaning, bytes, big_endian))
}
