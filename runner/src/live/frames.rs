//! Binary frames: a sequence number and one reading of each column, little-endian.
//!
//! `u32` sequence, then `f32` for each probe in the scene's order and for its keyphasor or speed column where it names
//! one, in the scene's units. The sequence number counts samples and wraps. A reading that is not a finite number is missing.
//! The second version ends with a `u32` CRC-32 (IEEE 802.3, as of zlib) of the bytes before it.

use ballrace_twin::recording::Row;
use ballrace_twin::scene::{Recording, RotationSource};
use std::time::Instant;

/// Seconds of frames that a source may repeat beyond what is not acknowledged.
const REPEATED: f64 = 2.0;
/// Seconds by which a frame may be ahead of the source's clock.
const AHEAD: f64 = 1.0;
/// Seconds of repeated frames after which their pace is judged.
const JUDGED: f64 = 0.25;
/// Repeated frames that take this share of their own time to arrive are new samples.
const REAL_TIME: f64 = 0.8;

/// Position of a frame among all samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The sample's number, and how many before it did not come.
    Sample {
        /// Counted from 0 over the whole life of the monitor.
        index: u64,
        /// Frames that did not come.
        lost: u64,
    },
    /// A frame that came before, or that comes too late to be used.
    Repeated,
    /// A number that does not fit the source's clock. The frame is kept until the next one shows whether the source counts
    /// on from it.
    Suspect,
    /// The source counts anew from the suspect frame, which has this number; the present frame has the next.
    AnewFromSuspect {
        /// As above.
        index: u64,
    },
    /// The source counts anew from the present frame.
    Anew {
        /// As above.
        index: u64,
    },
}

/// Follows sequence numbers.
///
/// A number may lie behind by as much as a source may repeat, and ahead by what the source's clock allows. Any other number
/// is wrong, or the source counts anew: two consecutive such numbers show the latter. A source that counts anew within what it
/// may repeat is recognised by its pace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sequence {
    /// Frames a second.
    rate: f64,
    /// Number of the frame that is due; none before the first.
    due: Option<u32>,
    /// The sample number that it has.
    index: u64,
    /// Sample number from which the source counts without a break.
    since: u64,
    /// Sample number and arrival of the first frame.
    origin: Option<(u64, Instant)>,
    /// Most samples by which frames were ahead of that clock.
    lead: f64,
    /// Number that confirms the suspect frame.
    confirms: Option<u32>,
    /// Arrival of the first of consecutive repeated frames, their count, and the number that continues them.
    repeats: Option<(Instant, u32, u32)>,
}

impl Sequence {
    /// Frames at `rate` (1/s) of which number `due` is sample `index`.
    #[must_use]
    pub const fn new(rate: f64, due: Option<u32>, index: u64) -> Self {
        Self { rate, due, index, since: 0, origin: None, lead: 0.0, confirms: None, repeats: None }
    }

    /// Sample number from which the source counts without a break.
    #[must_use]
    pub const fn since(&self) -> u64 {
        self.since
    }

    /// Takes in the number of a frame that arrives `now`; samples below `acknowledged` will not be repeated by the source.
    pub fn place(&mut self, number: u32, now: Instant, acknowledged: Option<u64>) -> Place {
        let due = self.due.unwrap_or(number);
        let confirmed = self.confirms.take() == Some(number);
        // Across the wrap, the shorter way round.
        let ahead = i64::from(number.wrapping_sub(due) as i32);
        if let Ok(lost) = u64::try_from(ahead)
            && self.is_due(self.index + lost, now)
        {
            return Place::Sample { index: self.accept(number, self.index + lost, lost, now), lost };
        }
        if self.may_repeat(ahead.unsigned_abs(), acknowledged) && ahead < 0 {
            return self.repeated(number, now);
        }
        if confirmed {
            let index = self.index;
            self.since = index;
            self.accept(number, index + 1, 0, now);
            return Place::AnewFromSuspect { index };
        }
        self.confirms = Some(number.wrapping_add(1));
        Place::Suspect
    }

    fn accept(&mut self, number: u32, index: u64, lost: u64, now: Instant) -> u64 {
        self.due = Some(number.wrapping_add(1));
        self.index = index + 1;
        self.repeats = None;
        let ahead = self.ahead(index, now);
        if lost == 0 {
            self.lead = self.lead.max(ahead);
        }
        index
    }

    /// Samples by which `index` is ahead of the source's clock, which starts with its first frame.
    fn ahead(&mut self, index: u64, now: Instant) -> f64 {
        let (first, begun) = *self.origin.get_or_insert((index, now));
        index as f64 - first as f64 - now.saturating_duration_since(begun).as_secs_f64() * self.rate
    }

    fn is_due(&mut self, index: u64, now: Instant) -> bool {
        self.ahead(index, now) <= self.lead + AHEAD * self.rate || index == self.index
    }

    fn may_repeat(&self, behind: u64, acknowledged: Option<u64>) -> bool {
        let open = acknowledged.map_or(0, |index| self.index.saturating_sub(index));
        behind <= self.index - self.since && behind as f64 <= open as f64 + REPEATED * self.rate
    }

    /// A frame that was there, unless frames like it come at the pace of new ones.
    fn repeated(&mut self, number: u32, now: Instant) -> Place {
        let (begun, count) = match self.repeats {
            Some((begun, count, next)) if next == number => (begun, count + 1),
            _ => (now, 1),
        };
        self.repeats = Some((begun, count, number.wrapping_add(1)));
        let elapsed = now.saturating_duration_since(begun).as_secs_f64() * self.rate;
        if f64::from(count) < JUDGED * self.rate || elapsed < REAL_TIME * f64::from(count) {
            return Place::Repeated;
        }
        self.since = self.index;
        Place::Anew { index: self.accept(number, self.index, 0, now) }
    }
}

/// How frames become rows.
#[derive(Debug, Clone)]
pub struct Layout {
    probes: Vec<[f64; 2]>,
    /// rad/s for one unit of a speed column; 1 of a keyphasor
    rotation: Option<f64>,
    /// Frames end with their CRC-32.
    checked: bool,
}

/// Bytes of a CRC-32.
const CHECKSUM: usize = 4;

impl Layout {
    /// Creates the decoder of a scene's recording; `checked` frames end with their CRC-32.
    #[must_use]
    pub fn new(recording: &Recording, checked: bool) -> Self {
        let rotation = match &recording.rotation {
            RotationSource::Keyphasor { .. } => Some(1.0),
            RotationSource::SpeedColumn { radians_per_second, .. } => Some(*radians_per_second),
            RotationSource::Scene => None,
        };
        Self { probes: recording.probes.iter().map(|p| [p.metres_per_unit, p.offset]).collect(), rotation, checked }
    }

    /// Bytes of a frame.
    #[must_use]
    pub fn size(&self) -> usize {
        4 * (1 + self.probes.len() + usize::from(self.rotation.is_some())) + if self.checked { CHECKSUM } else { 0 }
    }

    /// Returns true for a frame of the right size and, where frames have one, with the right CRC-32.
    #[must_use]
    pub fn is_whole(&self, frame: &[u8]) -> bool {
        if frame.len() != self.size() {
            return false;
        }
        match frame.split_last_chunk::<CHECKSUM>() {
            Some((content, crc)) if self.checked => crc32fast::hash(content) == u32::from_le_bytes(*crc),
            _ => true,
        }
    }

    /// Returns the sequence number of a frame and stores its readings in `row`; none where the frame is not whole.
    pub fn read(&self, frame: &[u8], row: &mut Row) -> Option<u32> {
        if !self.is_whole(frame) {
            return None;
        }
        let mut words = frame.chunks_exact(4).filter_map(|word| <[u8; 4]>::try_from(word).ok());
        let number = u32::from_le_bytes(words.next()?);
        let mut values = words.map(|word| f64::from(f32::from_le_bytes(word)));
        row.probes.clear();
        for ([unit, offset], value) in self.probes.iter().zip(values.by_ref()) {
            row.probes.push(if value.is_finite() { value * unit - offset } else { f64::NAN });
        }
        row.rotation = match self.rotation.map(|unit| (unit, values.next())) {
            Some((unit, Some(value))) if value.is_finite() => value * unit,
            Some(_) => f64::NAN,
            None => 0.0,
        };
        Some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const RATE: f64 = 1000.0;

    fn sample(index: u64, lost: u64) -> Place {
        Place::Sample { index, lost }
    }

    #[test]
    fn numbers_wrap_skip_and_repeat() {
        let (mut sequence, now) = (Sequence::new(RATE, None, 0), Instant::now());
        let mut place = |number| sequence.place(number, now, None);
        assert_eq!(place(u32::MAX - 1), sample(0, 0));
        assert_eq!(place(u32::MAX), sample(1, 0));
        assert_eq!(place(0), sample(2, 0));
        assert_eq!(place(4), sample(6, 3));
        assert_eq!(place(4), Place::Repeated);
        assert_eq!(place(u32::MAX), Place::Repeated);
        assert_eq!(place(5), sample(7, 0));
    }

    #[test]
    fn a_wrong_number_moves_nothing_and_two_in_a_row_are_a_new_count() {
        let (mut sequence, now) = (Sequence::new(RATE, None, 0), Instant::now());
        let mut place = |number| sequence.place(number, now, None);
        assert_eq!(place(0), sample(0, 0));
        for wrong in [3_000_000_000, 5000, 1 << 31] {
            assert_eq!(place(wrong), Place::Suspect);
        }
        assert_eq!(place(1), sample(1, 0));
        assert_eq!(place(3_000_000_000), Place::Suspect);
        assert_eq!(place(3_000_000_001), Place::AnewFromSuspect { index: 2 });
        assert_eq!(place(3_000_000_002), sample(4, 0));
        // Numbers from before the new count are not repeats.
        assert_eq!(place(2_999_999_999), Place::Suspect);
    }

    #[test]
    fn a_gap_as_long_as_the_silence_is_a_gap() {
        let (mut sequence, begun) = (Sequence::new(RATE, None, 0), Instant::now());
        assert_eq!(sequence.place(0, begun, None), sample(0, 0));
        assert_eq!(sequence.place(600_000, begun, None), Place::Suspect);
        let later = begun + Duration::from_secs(600);
        assert_eq!(sequence.place(600_000, later, None), sample(600_000, 599_999));
    }

    #[test]
    fn what_is_not_acknowledged_may_be_repeated() {
        let (mut sequence, now) = (Sequence::new(RATE, None, 0), Instant::now());
        (0..9000).for_each(|number| assert_eq!(sequence.place(number, now, None), sample(u64::from(number), 0)));
        assert_eq!(sequence.place(3000, now, Some(4000)), Place::Repeated);
        assert_eq!(sequence.place(3000, now, None), Place::Suspect);
        assert_eq!(sequence.place(3001, now, None), Place::AnewFromSuspect { index: 9000 });
    }

    #[test]
    fn the_pace_of_repeated_frames_tells_new_samples() {
        let begun = Instant::now();
        for (pace, repeated) in [(1.0, 249), (10.0, 1000)] {
            let mut sequence = Sequence::new(RATE, None, 0);
            (0..1000).for_each(|number| assert_eq!(sequence.place(number, begun, None), sample(u64::from(number), 0)));
            let mut place =
                |i: u32| sequence.place(i, begun + Duration::from_secs_f64(f64::from(i) / RATE / pace), None);
            let count = (0..1000).take_while(|i| place(*i) == Place::Repeated).count();
            assert_eq!(count, repeated);
        }
    }

    #[test]
    fn frames_of_any_size_are_read_or_refused() {
        for checked in [false, true] {
            let layout = Layout { probes: vec![[1e-6, 0.0], [1e-6, 2e-6]], rotation: Some(1.0), checked };
            let mut frame = 7_u32.to_le_bytes().to_vec();
            for value in [1.5_f32, f32::INFINITY, 1.0] {
                frame.extend(value.to_le_bytes());
            }
            if checked {
                frame.extend(crc32fast::hash(&frame).to_le_bytes());
            }
            let mut row = Row::default();
            assert_eq!(layout.read(&frame, &mut row), Some(7));
            assert_eq!((row.probes[0], row.rotation), (1.5e-6, 1.0));
            assert!(row.probes[1].is_nan());
            for size in 0..frame.len() {
                assert_eq!(layout.read(&frame[..size], &mut row), None);
            }
            for byte in 0..if checked { frame.len() } else { 0 } {
                let mut wrong = frame.clone();
                wrong[byte] ^= 1;
                assert_eq!(layout.read(&wrong, &mut row), None);
            }
        }
    }
}
