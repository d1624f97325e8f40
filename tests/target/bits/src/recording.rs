//! The recording as every machine reads it: little-endian numbers, one record a sample.

use ballrace::{Displacement, Phase};

/// Bytes of a record: five `f32` and a `u64`.
pub const BYTES: usize = 28;

/// One sample.
#[derive(Clone, Copy)]
pub struct Sample {
    pub displacement: Displacement<f32>,
    pub shaft: Phase,
}

impl Sample {
    /// From its record.
    pub fn from_bytes(record: &[u8; BYTES]) -> Self {
        let (words, _) = record.as_chunks::<4>();
        let mut u = [0.0; 5];
        for (x, word) in u.iter_mut().zip(words) {
            *x = f32::from_le_bytes(*word);
        }
        let shaft = record.last_chunk::<8>().copied().map_or(0, u64::from_le_bytes);
        Self { displacement: Displacement::from_array(u), shaft: Phase(shaft) }
    }
}
