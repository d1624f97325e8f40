//! WAV files as recordings: the channels are the columns `c0`, `c1`, ...
//!
//! `RIFX` is the form in big-endian order; `RF64` (EBU Tech 3306) and `BW64` (ITU-R BS.2088) state lengths beyond 4 GiB in
//! the chunk `ds64`.
//!
//! Integers are parts of full scale, which is 1: 16 bits reach from -1 to 32767/32768.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use super::error::{RecordingError, refuse};
use super::numbers::{Kind, Lane, Layout, Number, Numbers, Run};
use super::table::Table;

const EXPECTED: &str = "a WAV file of PCM with 8, 16, 24 or 32 bits or float with 32 or 64";

/// First bytes of files in big-endian order, and of all.
const RIFX: &[u8; 4] = b"RIFX";
pub(super) const BEGINNINGS: [&[u8; 4]; 4] = [b"RIFF", RIFX, b"RF64", b"BW64"];

/// Format tags.
const PCM: u16 = 1;
const FLOAT: u16 = 3;
/// The tag follows later.
const EXTENSIBLE: u16 = 0xfffe;

/// Length of a chunk that the chunk `ds64` states instead.
const IN_DS64: u32 = u32::MAX;

/// The chunk `fmt `.
struct Format {
    number: Number,
    channels: u16,
    rate: u32,
}

/// Opens a file.
pub(super) fn open(file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let wrong = |found: String| RecordingError::Format { file: path.into(), found, expected: EXPECTED };
    let layout = read(&file).map_err(|cause| match cause.kind() {
        io::ErrorKind::UnexpectedEof => wrong("a file that ends before its samples".into()),
        _ => wrong(cause.to_string()),
    })?;
    Ok(Box::new(Numbers::new(file, path, layout)))
}

/// Reads chunk by chunk up to the samples.
fn read(file: &File) -> io::Result<Layout> {
    let size = file.metadata()?.len();
    let mut file = BufReader::new(file);
    let mut head = [0; 12];
    file.read_exact(&mut head)?;
    let is_known = BEGINNINGS.iter().any(|begin| head.starts_with(*begin));
    if !is_known || !head.ends_with(b"WAVE") {
        return Err(refuse("no WAV file"));
    }
    let big_endian = head.starts_with(RIFX);
    let (mut format, mut length_of_data) = (None, None);
    loop {
        let mut head = [0; 8];
        file.read_exact(&mut head)?;
        let [a, b, c, d, length @ ..] = head;
        let stated = if big_endian { u32::from_be_bytes(length) } else { u32::from_le_bytes(length) };
        let length = u64::from(stated);
        let start = file.stream_position()?;
        match [a, b, c, d] {
            [b'f', b'm', b't', b' '] => format = Some(read_format(&mut file, length, big_endian)?),
            [b'd', b's', b'6', b'4'] => {
                let mut bytes = [0; 16];
                file.read_exact(&mut bytes)?;
                // The length of the file comes first.
                length_of_data = bytes.last_chunk().map(|length| u64::from_le_bytes(*length));
            }
            [b'd', b'a', b't', b'a'] => {
                let format = format.ok_or_else(|| refuse("samples before their format"))?;
                let length = length_of_data.filter(|_| stated == IN_DS64).unwrap_or(length);
                return Ok(layout(&format, start, length, size));
            }
            _ => {}
        }
        // Chunks begin at even offsets.
        file.seek(SeekFrom::Start(start + length.next_multiple_of(2)))?;
    }
}

fn read_format(file: &mut impl Read, length: u64, big_endian: bool) -> io::Result<Format> {
    let mut bytes = [0; 26];
    let there = length.min(26) as usize;
    file.read_exact(bytes.get_mut(..there).unwrap_or_default())?;
    let word = |at: usize| {
        let pair = [bytes[at], bytes[at + 1]];
        if big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    };
    let (tag, channels, frame, bits) = (word(0), word(2), word(12), word(14));
    let rate = [bytes[4], bytes[5], bytes[6], bytes[7]];
    let rate = if big_endian { u32::from_be_bytes(rate) } else { u32::from_le_bytes(rate) };
    let kind = match (if tag == EXTENSIBLE { word(24) } else { tag }, bits) {
        (PCM, 8) => Kind::Centred,
        (PCM, 16 | 24 | 32) => Kind::Signed,
        (FLOAT, 32 | 64) => Kind::Float,
        (tag, _) => return Err(refuse(format!("format {tag} with {bits} bits"))),
    };
    let size = bits / 8;
    if channels == 0 || Some(frame) != channels.checked_mul(size) || rate == 0 {
        return Err(refuse(format!("{channels} channels of {bits} bits in {frame} bytes at {rate} Hz")));
    }
    let scale = if kind == Kind::Float { 1.0 } else { 2.0_f64.powi(1 - i32::from(bits)) };
    let number = Number { scale, ..Number::new(kind, size as u8, big_endian) };
    Ok(Format { number, channels, rate })
}

fn layout(format: &Format, start: u64, length: u64, size: u64) -> Layout {
    let number = u64::from(format.number.bytes);
    let frame = number * u64::from(format.channels);
    // A recorder that was switched off may not have written the length, or all of the samples.
    let there = length.min(size.saturating_sub(start));
    let lane = |channel: u16| {
        let run = Run::once(format.number, start + u64::from(channel) * number, frame, there / frame);
        Lane { rate: Some(format.rate.into()), ..Lane::even(format!("c{channel}"), run) }
    };
    let torn = there < length || !there.is_multiple_of(frame);
    Layout { torn, ..Layout::of((0..format.channels).map(lane).collect(), EXPECTED) }
}
