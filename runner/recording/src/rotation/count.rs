//! Detection of pulses in a column that counts them.

use super::RotationError;
use super::edges::Instant;
use crate::flaws::Position;

/// Widths of counters, bits.
const BITS: [u32; 2] = [16, 32];

/// Smallest number of instants used per revolution of a wheel with as many pulses. The angle is fitted through 11 of them, as with a
/// keyphasor; more instants only add noise to the speed.
const PER_TURN: u64 = 16;

/// Longest time in samples in which the last pulse may have come for its instant to be used.
const MAX_UNCERTAIN: f64 = 2.0;

/// A count of pulses.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Counter {
    /// Pulses between two instants.
    spacing: u64,
    /// Sample and count of the last reading.
    last: Option<(u64, f64)>,
    /// Pulses since the last instant.
    pending: u64,
    has_begun: bool,
    /// Width at which the count was found to wrap.
    bits: Option<u32>,
}

impl Counter {
    pub(super) const fn new(pulses_per_turn: u32) -> Self {
        let spacing = pulses_per_turn as u64 / PER_TURN;
        let spacing = if spacing == 0 { 1 } else { spacing };
        Self { spacing, last: None, pending: 0, has_begun: false, bits: None }
    }

    /// Returns the number of pulses between two instants.
    pub(super) const fn spacing(&self) -> u64 {
        self.spacing
    }

    /// Returns the width at which the count was found to wrap, bits.
    pub(super) const fn bits(&self) -> Option<u32> {
        self.bits
    }

    /// Adds a reading; returns the instant of its last pulse, with the pulses since the last instant, once those are enough.
    /// Samples between two readings may be missing: no pulse is lost by that.
    ///
    /// # Errors
    /// A reading that is no whole number, a count that falls other than by wrapping.
    pub(super) fn see(
        &mut self,
        at: Position,
        reading: f64,
        column: &str,
    ) -> Result<Option<(Instant, u64)>, RotationError> {
        if reading.fract() != 0.0 {
            return Err(RotationError::NotACount { column: column.to_owned(), line: at.line, found: reading });
        }
        let Some((last_index, last)) = self.last.replace((at.index, reading)) else { return Ok(None) };
        let step = if reading >= last { reading - last } else { self.wrapped(last, reading, at.line, column)? };
        if step == 0.0 {
            return Ok(None);
        }
        self.pending = self.pending.saturating_add(step as u64);
        // The last of several pulses came in the last part of the time between the readings.
        let uncertain = at.index.saturating_sub(last_index) as f64 / step;
        if uncertain > MAX_UNCERTAIN || (self.has_begun && self.pending < self.spacing) {
            return Ok(None);
        }
        self.has_begun = true;
        let steps = std::mem::take(&mut self.pending);
        Ok(Some((Instant { index: at.index, fraction: -0.5 * uncertain }, steps)))
    }

    /// Returns the step of a count that falls.
    fn wrapped(&mut self, last: f64, reading: f64, line: u64, column: &str) -> Result<f64, RotationError> {
        let step = |bits: u32| {
            let turns_over = 2_f64.powi(bits as i32);
            let step = reading - last + turns_over;
            let is_held = last.abs() < turns_over && reading.abs() < turns_over;
            (is_held && step > 0.0 && step < 0.5 * turns_over).then_some((bits, step))
        };
        let known = self.bits.map_or(BITS.as_slice(), |bits| if bits == 16 { &BITS[..1] } else { &BITS[1..] });
        let Some((bits, step)) = known.iter().copied().find_map(step) else {
            return Err(RotationError::CountFalls { column: column.to_owned(), line, from: last, to: reading });
        };
        self.bits = Some(bits);
        Ok(step)
    }
}
