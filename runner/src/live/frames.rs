//! Binary frames: a sequence number and one reading of each column, little-endian.
//!
//! `u32` sequence, then `f32` for each probe in the scene's order and for its keyphasor or speed column where it names
//! one, in the scene's units. The sequence number counts samples and wraps. A reading that is not a finite number is missing.

use ballrace_twin::recording::Row;
use ballrace_twin::scene::{Recording, Rotation};

/// Behind by up to so many frames is a repeated or late one; farther behind, a source that began to count anew.
const LATE: i64 = 1 << 20;

/// One frame's place among all.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The sample's number, and how many before it did not come.
    Sample {
        /// Counted from 0 over the whole life of the monitor.
        index: u64,
        /// Frames that did not come.
        lost: u64,
    },
    /// It was there already, or comes too late to be used.
    Repeated,
    /// The source began to count anew; the frame follows the last one.
    Anew {
        /// As above.
        index: u64,
    },
}

/// Follows sequence numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Sequence {
    /// Number of the frame that is due; none before the first.
    pub due: Option<u32>,
    /// The sample number that it has.
    pub index: u64,
}

impl Sequence {
    /// Takes in a frame's number.
    pub fn place(&mut self, number: u32) -> Place {
        let due = self.due.unwrap_or(number);
        // Across the wrap, the shorter way round.
        let ahead = i64::from(number.wrapping_sub(due) as i32);
        if (-LATE..0).contains(&ahead) {
            return Place::Repeated;
        }
        let lost = u64::try_from(ahead).unwrap_or(0);
        let index = self.index + lost;
        *self = Self { due: Some(number.wrapping_add(1)), index: index + 1 };
        if ahead < 0 { Place::Anew { index } } else { Place::Sample { index, lost } }
    }
}

/// How frames become rows.
#[derive(Debug, Clone)]
pub struct Layout {
    probes: Vec<[f64; 2]>,
    /// rad/s for one unit of a speed column; 1 of a keyphasor
    rotation: Option<f64>,
}

impl Layout {
    /// Of a scene's recording.
    #[must_use]
    pub fn new(recording: &Recording) -> Self {
        let rotation = match &recording.rotation {
            Rotation::Keyphasor { .. } => Some(1.0),
            Rotation::SpeedColumn { radians_per_second, .. } => Some(*radians_per_second),
            Rotation::Scene => None,
        };
        Self { probes: recording.probes.iter().map(|p| [p.metres_per_unit, p.offset]).collect(), rotation }
    }

    /// Bytes of a frame.
    #[must_use]
    pub fn size(&self) -> usize {
        4 * (1 + self.probes.len() + usize::from(self.rotation.is_some()))
    }

    /// Sequence number of a frame, and its readings into `row`; none where it has the wrong size.
    pub fn read(&self, frame: &[u8], row: &mut Row) -> Option<u32> {
        if frame.len() != self.size() {
            return None;
        }
        let mut words = frame.chunks_exact(4).filter_map(|word| <[u8; 4]>::try_from(word).ok());
        let number = u32::from_le_bytes(words.next()?);
        let mut values = words.map(|word| f64::from(f32::from_le_bytes(word)));
        row.probes.clear();
        for ([unit, offset], value) in self.probes.iter().zip(values.by_ref()) {
            row.probes.push(if value.is_finite() { value * unit - offset } else { f64::NAN });
        }
        row.rotation = match (self.rotation, values.next()) {
            (Some(unit), Some(value)) if value.is_finite() => value * unit,
            (Some(_), _) => f64::NAN,
            (None, _) => 0.0,
        };
        Some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_wrap_skip_repeat_and_begin_anew() {
        let mut sequence = Sequence::default();
        assert_eq!(sequence.place(u32::MAX - 1), Place::Sample { index: 0, lost: 0 });
        assert_eq!(sequence.place(u32::MAX), Place::Sample { index: 1, lost: 0 });
        assert_eq!(sequence.place(0), Place::Sample { index: 2, lost: 0 });
        assert_eq!(sequence.place(4), Place::Sample { index: 6, lost: 3 });
        assert_eq!(sequence.place(4), Place::Repeated);
        assert_eq!(sequence.place(u32::MAX), Place::Repeated);
        assert_eq!(sequence.place(5), Place::Sample { index: 7, lost: 0 });
        assert_eq!(sequence.place(3_000_000_000), Place::Anew { index: 8 });
        assert_eq!(sequence.place(3_000_000_001), Place::Sample { index: 9, lost: 0 });
    }

    #[test]
    fn frames_of_any_size_are_read_or_refused() {
        let layout = Layout { probes: vec![[1e-6, 0.0], [1e-6, 2e-6]], rotation: Some(1.0) };
        let mut frame = 7_u32.to_le_bytes().to_vec();
        for value in [1.5_f32, f32::INFINITY, 1.0] {
            frame.extend(value.to_le_bytes());
        }
        let mut row = Row::default();
        assert_eq!(layout.read(&frame, &mut row), Some(7));
        assert_eq!((row.probes[0], row.rotation), (1.5e-6, 1.0));
        assert!(row.probes[1].is_nan());
        for size in 0..frame.len() {
            assert_eq!(layout.read(&frame[..size], &mut row), None);
        }
    }
}
