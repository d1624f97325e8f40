//! Sequence numbers of frames from a live source, which may lose, repeat and count anew.

use std::time::Instant;

/// Time of acknowledged frames that a source may repeat, in addition to all unacknowledged frames, s.
const REPEAT_WINDOW: f64 = 2.0;
/// Maximum time by which a frame may be ahead of the source's clock, s.
const MAX_LEAD: f64 = 1.0;
/// Minimum time of consecutive repeated frames for a measurement of their rate, s.
const RATE_WINDOW: f64 = 0.25;
/// Minimum number of them: fewer that pause on their way for a moment would have the rate of new samples of a slow machine.
const MIN_REPEATS: u32 = 64;
/// Ratio of arrival time to recorded time from which on repeated sequence numbers are new samples.
const REAL_TIME_RATIO: f64 = 0.8;

/// Position of a frame in the sequence of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FramePosition {
    /// New sample.
    Sample {
        /// Sample number, counted from 0 across all restarts of the monitor.
        index: u64,
        /// Number of frames missing before it.
        lost: u64,
    },
    /// Frame that was received before, or that arrives too late to be used.
    Repeated,
    /// Frame with a number outside the expected range. It is stored until the next frame confirms it or not.
    Suspect,
    /// The source restarted its sequence numbers at the suspect frame; the present frame follows it.
    RestartedAtSuspect {
        /// Sample number of the suspect frame.
        index: u64,
    },
    /// The source restarted its sequence numbers at the present frame.
    Restarted {
        /// Sample number of the present frame.
        index: u64,
    },
}

/// Converts sequence numbers to sample numbers.
///
/// The expected range of sequence numbers reaches from the oldest frame that a source may repeat to the newest frame that
/// the source's clock allows. Two consecutive numbers outside this range are a restart of the sequence; a single one is an
/// error. A restart within the range is detected by the rate at which repeated frames arrive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SequenceTracker {
    /// Frame rate, 1/s.
    rate: f64,
    /// Sequence number of the next frame; `None` before the first frame.
    next_number: Option<u32>,
    /// Sample number of the next frame.
    next_index: u64,
    /// Sample number of the last restart of the sequence.
    restarted_at: u64,
    /// Sample number and arrival time of the first frame.
    origin: Option<(u64, Instant)>,
    /// Largest lead of a frame over the source's clock so far, samples.
    lead: f64,
    /// Sequence number that confirms the suspect frame.
    confirming_number: Option<u32>,
    /// Consecutive repeated frames: arrival time of the first, their count, and the sequence number that continues them.
    repeats: Option<(Instant, u32, u32)>,
}

impl SequenceTracker {
    /// Creates the state for frames at `rate` (1/s), with the sequence number and the sample number of the next frame.
    #[must_use]
    pub const fn new(rate: f64, next_number: Option<u32>, next_index: u64) -> Self {
        Self {
            rate,
            next_number,
            next_index,
            restarted_at: 0,
            origin: None,
            lead: 0.0,
            confirming_number: None,
            repeats: None,
        }
    }

    /// Returns the sample number of the last restart of the sequence.
    #[must_use]
    pub const fn restarted_at(&self) -> u64 {
        self.restarted_at
    }

    /// Returns the position of a frame with sequence number `number` that arrives at `now`, and updates the state. Samples
    /// below `acknowledged` are on disk.
    pub fn locate(&mut self, number: u32, now: Instant, acknowledged: Option<u64>) -> FramePosition {
        let expected = self.next_number.unwrap_or(number);
        let is_confirmed = self.confirming_number.take() == Some(number);
        // Sequence numbers wrap: the difference of smaller magnitude applies.
        let ahead = i64::from(number.wrapping_sub(expected) as i32);
        if let Ok(lost) = u64::try_from(ahead)
            && self.is_plausible(self.next_index + lost, now)
        {
            return FramePosition::Sample { index: self.accept(number, self.next_index + lost, lost, now), lost };
        }
        if self.may_repeat(ahead.unsigned_abs(), acknowledged) && ahead < 0 {
            return self.locate_repeated(number, now);
        }
        if is_confirmed {
            let index = self.next_index;
            self.restarted_at = index;
            self.accept(number, index + 1, 0, now);
            return FramePosition::RestartedAtSuspect { index };
        }
        self.confirming_number = Some(number.wrapping_add(1));
        FramePosition::Suspect
    }

    /// Advances the state to the frame after this one; returns `index`.
    fn accept(&mut self, number: u32, index: u64, lost: u64, now: Instant) -> u64 {
        self.next_number = Some(number.wrapping_add(1));
        self.next_index = index + 1;
        self.repeats = None;
        let lead = self.lead_of(index, now);
        if lost == 0 {
            self.lead = self.lead.max(lead);
        }
        index
    }

    /// Returns the lead of sample `index` over the source's clock, samples. The clock starts with the first frame.
    fn lead_of(&mut self, index: u64, now: Instant) -> f64 {
        let (first, start) = *self.origin.get_or_insert((index, now));
        index as f64 - first as f64 - now.saturating_duration_since(start).as_secs_f64() * self.rate
    }

    fn is_plausible(&mut self, index: u64, now: Instant) -> bool {
        self.lead_of(index, now) <= self.lead + MAX_LEAD * self.rate || index == self.next_index
    }

    fn may_repeat(&self, behind: u64, acknowledged: Option<u64>) -> bool {
        let unacknowledged = acknowledged.map_or(0, |index| self.next_index.saturating_sub(index));
        behind <= self.next_index - self.restarted_at
            && behind as f64 <= unacknowledged as f64 + REPEAT_WINDOW * self.rate
    }

    /// Returns [`FramePosition::Repeated`], or a restart if repeated frames arrive at the rate of new samples.
    fn locate_repeated(&mut self, number: u32, now: Instant) -> FramePosition {
        let (start, count) = match self.repeats {
            Some((start, count, next)) if next == number => (start, count + 1),
            _ => (now, 1),
        };
        self.repeats = Some((start, count, number.wrapping_add(1)));
        let elapsed = now.saturating_duration_since(start).as_secs_f64() * self.rate;
        let is_measured = count >= MIN_REPEATS && f64::from(count) >= RATE_WINDOW * self.rate;
        if !is_measured || elapsed < REAL_TIME_RATIO * f64::from(count) {
            return FramePosition::Repeated;
        }
        self.restarted_at = self.next_index;
        FramePosition::Restarted { index: self.accept(number, self.next_index, 0, now) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    const RATE: f64 = 1000.0;

    fn sample(index: u64, lost: u64) -> FramePosition {
        FramePosition::Sample { index, lost }
    }

    #[test]
    fn numbers_wrap_skip_and_repeat() {
        let (mut tracker, now) = (SequenceTracker::new(RATE, None, 0), Instant::now());
        let mut locate = |number| tracker.locate(number, now, None);
        assert_eq!(locate(u32::MAX - 1), sample(0, 0));
        assert_eq!(locate(u32::MAX), sample(1, 0));
        assert_eq!(locate(0), sample(2, 0));
        assert_eq!(locate(4), sample(6, 3));
        assert_eq!(locate(4), FramePosition::Repeated);
        assert_eq!(locate(u32::MAX), FramePosition::Repeated);
        assert_eq!(locate(5), sample(7, 0));
    }

    #[test]
    fn a_wrong_number_is_ignored_and_two_consecutive_ones_are_a_restart() {
        let (mut tracker, now) = (SequenceTracker::new(RATE, None, 0), Instant::now());
        let mut locate = |number| tracker.locate(number, now, None);
        assert_eq!(locate(0), sample(0, 0));
        for wrong in [3_000_000_000, 5000, 1 << 31] {
            assert_eq!(locate(wrong), FramePosition::Suspect);
        }
        assert_eq!(locate(1), sample(1, 0));
        assert_eq!(locate(3_000_000_000), FramePosition::Suspect);
        assert_eq!(locate(3_000_000_001), FramePosition::RestartedAtSuspect { index: 2 });
        assert_eq!(locate(3_000_000_002), sample(4, 0));
        // Numbers from before the restart are not repeated frames.
        assert_eq!(locate(2_999_999_999), FramePosition::Suspect);
    }

    #[test]
    fn a_gap_as_long_as_the_silence_of_the_source_is_accepted() {
        let (mut tracker, start) = (SequenceTracker::new(RATE, None, 0), Instant::now());
        assert_eq!(tracker.locate(0, start, None), sample(0, 0));
        assert_eq!(tracker.locate(600_000, start, None), FramePosition::Suspect);
        let later = start + Duration::from_secs(600);
        assert_eq!(tracker.locate(600_000, later, None), sample(600_000, 599_999));
    }

    #[test]
    fn unacknowledged_frames_may_be_repeated() {
        let (mut tracker, now) = (SequenceTracker::new(RATE, None, 0), Instant::now());
        (0..9000).for_each(|number| assert_eq!(tracker.locate(number, now, None), sample(u64::from(number), 0)));
        assert_eq!(tracker.locate(3000, now, Some(4000)), FramePosition::Repeated);
        assert_eq!(tracker.locate(3000, now, None), FramePosition::Suspect);
        assert_eq!(tracker.locate(3001, now, None), FramePosition::RestartedAtSuspect { index: 9000 });
    }

    #[test]
    fn repeated_numbers_at_the_rate_of_new_samples_are_a_restart() {
        let start = Instant::now();
        for (speed_ratio, repeated) in [(1.0, 249), (10.0, 1000)] {
            let mut tracker = SequenceTracker::new(RATE, None, 0);
            (0..1000).for_each(|number| assert_eq!(tracker.locate(number, start, None), sample(u64::from(number), 0)));
            let mut locate =
                |i: u32| tracker.locate(i, start + Duration::from_secs_f64(f64::from(i) / RATE / speed_ratio), None);
            let count = (0..1000).take_while(|i| locate(*i) == FramePosition::Repeated).count();
            assert_eq!(count, repeated);
        }
    }

    /// A source at 8 Hz repeats what was not acknowledged; its second frame comes a moment later.
    #[test]
    fn a_pause_between_repeated_frames_of_a_slow_machine_is_no_restart() {
        let (mut tracker, start) = (SequenceTracker::new(8.0, None, 0), Instant::now());
        (0..1000).for_each(|number| assert_eq!(tracker.locate(number, start, None), sample(u64::from(number), 0)));
        for number in 900..1000 {
            let now = start + Duration::from_millis(if number > 900 { 400 } else { 0 });
            assert_eq!(tracker.locate(number, now, Some(900)), FramePosition::Repeated, "{number}");
        }
        assert_eq!(tracker.locate(1000, start, Some(900)), sample(1000, 0));
    }
}
