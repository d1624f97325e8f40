//! Place of the gap in a toothed wheel with absent teeth: the first pulse after it is angle 0.

use super::RotationError;

/// Largest difference of an interval from that of the gap, in intervals between teeth.
const NEAR: f64 = 0.4;

/// Turns without a gap after which there is none.
const TURNS_WITHOUT: u64 = 2;

/// Number of intervals as far as the wheel determines it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Interval {
    /// Number of intervals between teeth over the gap.
    Gap(u64),
    /// An interval between teeth, or over missed pulses.
    Plain,
    /// An interval between teeth where the gap is expected.
    Unexpected,
}

/// The gap of a wheel. Numbers of pulses count absent teeth.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Gap {
    per_turn: u64,
    missing: u64,
    /// Number of a pulse at angle 0; none before the first gap.
    origin: Option<u64>,
    /// Number of the pulse after the last gap.
    last_end: u64,
    /// Distance of the last two gaps where that is no whole number of turns.
    wrong: Option<u64>,
    /// A pulse came where the gap is expected.
    has_slipped: bool,
    /// Intervals in another gap, where there is one.
    other: Option<u64>,
}

impl Gap {
    /// Creates the gap of `missing` teeth among `per_turn`, absent ones counted.
    pub(super) const fn new(per_turn: u32, missing: u32) -> Self {
        let (per_turn, missing) = (per_turn as u64, missing as u64);
        Self { per_turn, missing, origin: None, last_end: 0, wrong: None, has_slipped: false, other: None }
    }

    /// Returns the number of a pulse at angle 0; none before the first gap.
    pub(super) const fn origin(&self) -> Option<u64> {
        self.origin
    }

    /// Returns the number of intervals in the gap.
    pub(super) const fn intervals(&self) -> u64 {
        self.missing + 1
    }

    /// Allows the next gap at any place, because the count of pulses rests on a guess.
    pub(super) const fn doubt(&mut self) {
        self.has_slipped = true;
    }

    /// Sets the gap before the second pulse of all, which shows by the third.
    pub(super) const fn begins_at_once(&mut self) {
        self.origin = Some(self.intervals());
        self.last_end = self.intervals();
    }

    /// Classifies an interval after pulse `last` that takes the time of `passed` intervals between teeth.
    ///
    /// # Errors
    /// Turns without a gap, gaps at another distance than the wheel of the scene has.
    pub(super) fn judge(&mut self, last: u64, passed: f64, column: &str) -> Result<Interval, RotationError> {
        let gap = self.intervals();
        let is_gap = (passed - gap as f64).abs() < NEAR;
        let end = last.saturating_add(gap);
        let Some(origin) = self.origin else {
            if is_gap {
                (self.origin, self.last_end) = (Some(end), end);
                return Ok(Interval::Gap(gap));
            }
            if passed > 1.5 {
                self.other = Some(passed.round() as u64);
            }
            return if last > TURNS_WITHOUT * self.per_turn {
                Err(self.absent(column, last + 1))
            } else {
                Ok(Interval::Plain)
            };
        };
        let is_expected = end.wrapping_sub(origin).is_multiple_of(self.per_turn);
        match (is_expected, is_gap) {
            (true, true) => {
                (self.last_end, self.wrong, self.has_slipped) = (end, None, false);
                Ok(Interval::Gap(gap))
            }
            (true, false) => {
                self.has_slipped = true;
                Ok(if passed < gap as f64 { Interval::Unexpected } else { Interval::Plain })
            }
            (false, true) => {
                let distance = end.saturating_sub(self.last_end);
                let is_whole = distance.is_multiple_of(self.per_turn);
                if self.wrong.replace(distance) == Some(distance) && !is_whole {
                    return Err(self.misplaced(column, distance));
                }
                self.last_end = end;
                if !std::mem::take(&mut self.has_slipped) && !is_whole {
                    // As many pulses may have been missed elsewhere.
                    return Ok(Interval::Plain);
                }
                self.origin = Some(end);
                Ok(Interval::Gap(gap))
            }
            (false, false) => Ok(Interval::Plain),
        }
    }

    /// Returns the error of a wheel whose gap is not found in `pulses` pulses.
    pub(super) fn absent(&self, column: &str, pulses: u64) -> RotationError {
        let (gap, other) = (self.intervals(), self.other);
        RotationError::NoGap { column: column.to_owned(), pulses, gap, other }
    }

    fn misplaced(&self, column: &str, distance: u64) -> RotationError {
        let (missing, expected) = (self.missing, self.per_turn - self.missing);
        RotationError::GapSpacing {
            column: column.to_owned(),
            found: distance.saturating_sub(missing),
            expected,
            pulses_per_turn: distance,
        }
    }
}
