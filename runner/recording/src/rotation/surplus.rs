//! Pulses that are omitted because they follow the last one too soon.

use super::edges::Instant;

/// Number of consecutive intervals with a pulse omitted in the middle after which the shaft is taken to turn twice as fast, as it
/// may after a standstill.
const TWICE_AS_FAST: u32 = 2;

/// Pulses omitted since the last counted one.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SurplusPulses {
    count: u32,
    /// The last omitted one.
    last: Instant,
    /// Intervals in a row with one pulse omitted in the middle.
    halved: u32,
}

impl SurplusPulses {
    /// Returns true where none is omitted since the last counted pulse.
    pub(super) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns true where the shaft is taken to turn twice as fast: no pulse is surplus then.
    pub(super) const fn is_twice_as_fast(&self) -> bool {
        self.halved >= TWICE_AS_FAST
    }

    /// Omits a pulse.
    pub(super) const fn omit(&mut self, at: Instant) {
        self.count += 1;
        self.last = at;
    }

    /// Ends the interval that began at `from` and is `interval` samples long.
    pub(super) fn end_interval(&mut self, from: Instant, interval: f64) {
        let half = (0.4..0.6).contains(&(self.last.since(from) / interval));
        self.halved = if self.count == 1 && half { self.halved + 1 } else { 0 };
        self.count = 0;
    }
}
