//! The last valid wrench of a stream of samples.

use super::Reaction;
use crate::frame::Wrench;
use crate::scalar::Scalar;
use crate::status::Status;

/// The last valid wrench, and the number of samples that it replaced.
///
/// ```
/// use ballrace::bearing::linear::Linear;
/// use ballrace::bearing::{Bearing, LastValidWrench};
/// use ballrace::{Displacement, Status, Stiffness, Phase};
///
/// let bearing = Linear::new(Stiffness::from_diagonal_element(1e8_f32));
/// let mut held = LastValidWrench::new();
/// let good = Displacement { u: 1e-6, ..Displacement::default() };
/// let bad = Displacement { u: f32::NAN, ..Displacement::default() };
/// let (before, _) = bearing.sample(&mut held, &good, &Phase::ZERO.into());
/// let (after, status) = bearing.sample(&mut held, &bad, &Phase::ZERO.into());
/// assert_eq!(before, after);
/// assert!(status.contains(Status::INPUT_NOT_FINITE) && held.held_count() == 1);
/// ```
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct LastValidWrench<T> {
    last: Wrench<T>,
    held_count: u32,
}

impl<T: Scalar> LastValidWrench<T> {
    /// Creates the state before the first sample; an invalid first sample gives the zero wrench.
    #[must_use]
    pub const fn new() -> Self {
        Self { last: Wrench::ZERO, held_count: 0 }
    }

    /// Returns the number of samples replaced by an earlier wrench (saturating).
    #[must_use]
    pub fn held_count(&self) -> u32 {
        self.held_count
    }

    /// Returns the wrench that `evaluate` computes, or the last valid one where the input is invalid (`input_ok` is false) or
    /// the result is not finite.
    pub fn update(&mut self, input_ok: bool, evaluate: impl FnOnce() -> Reaction<T>) -> (Wrench<T>, Status) {
        let fresh = evaluate();
        let result_ok = fresh.wrench.is_finite();
        let is_valid = input_ok & result_ok;
        // No branch: an invalid sample costs as much as a valid one. The flags of an invalid result depend on the sign of NaN,
        // in which processors differ.
        let status = Status::INPUT_NOT_FINITE
            .when(!input_ok)
            .union(Status::RESULT_NOT_FINITE.when(input_ok & !result_ok))
            .union(Status::CONTACT_LOST.when(fresh.load.is_zero()).union(fresh.status).when(is_valid));
        self.held_count = self.held_count.saturating_add(u32::from(!is_valid));
        self.last = Wrench::select(is_valid, fresh.wrench, self.last);
        (self.last, status)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// States and angles of firmware are statics, without code at start-up.
    #[test]
    fn states_are_constants() {
        static HELD: LastValidWrench<f32> = LastValidWrench::new();
        static STATISTICS: crate::twin::Statistics<f32> = crate::twin::Statistics::new(64);
        const RATIO: crate::phase::SpeedRatio = crate::phase::SpeedRatio::new(0.4);
        const QUARTER: crate::Phase = crate::Phase::from_revolutions(-1.75);
        let (held, mut statistics) = (HELD, STATISTICS);
        assert_eq!((held.held_count(), RATIO.bits(), QUARTER), (0, 0x0066_6666_6666_6668, crate::Phase(1 << 62)));
        assert!(statistics.add::<crate::Exact>(1.0).is_none());
    }
}
