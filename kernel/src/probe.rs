//! A displacement probe behind an analogue-to-digital converter: counts to metres, and whether the transducer is OK.
//!
//! A transducer whose cable is broken, whose gap is outside its linear range or whose converter hangs delivers counts at a rail, or the same
//! count for ever: numbers from which a bearing would have a large force. API 670 asks of a monitor that such a channel is *not OK*. Here it
//! then holds its last valid displacement and says so.

use crate::bearing::geometry::{InvalidParameter, check};
use crate::scalar::Scalar;
use crate::status::Status;

/// Scale and limits of a probe.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ProbeParams<T> {
    /// Displacement at the count 0, m.
    pub at_zero: T,
    /// Displacement per count, m; its sign is the direction in which the count rises.
    pub per_count: T,
    /// Smallest and largest count of the linear range of the transducer, both inside the rails of the converter.
    pub linear_range: [u32; 2],
    /// Samples without any change of the count after which the channel is stuck; 0: it may stand still. A converter whose noise is below one
    /// count stands still on a shaft that does not turn.
    pub stuck_after: u32,
}

/// A probe: its parameters and the state of its channel.
///
/// ```
/// use ballrace::Status;
/// use ballrace::probe::{Probe, ProbeParams};
///
/// // 8 mV/um at 12 bits over 3.3 V through a divider of 8: 0.80566 mV a count, 0.8057 um. Linear from 400 to 3700 counts, zero at 2048.
/// let params = ProbeParams { at_zero: -1.65e-3, per_count: 0.805_66e-6, linear_range: [400, 3700], stuck_after: 1000 };
/// let mut probe = Probe::<f32>::try_new(params)?;
/// let (there, status) = probe.sample(2060);
/// assert!((there - 9.66e-6).abs() < 1e-7 && status == Status::OK);
/// let (held, status) = probe.sample(4095);
/// assert_eq!((held, status, probe.held_in_a_row()), (there, Status::INPUT_NOT_OK, 1));
/// # Ok::<(), ballrace::bearing::geometry::InvalidParameter>(())
/// ```
///
/// Cost: a conversion, a product, a sum and 20 integer operations, without a branch.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Probe<T> {
    params: ProbeParams<T>,
    last: T,
    counts: u32,
    unchanged: u32,
    held_in_a_row: u32,
    held_count: u32,
}

impl<T: Scalar> Probe<T> {
    /// Creates the channel before its first sample. For set-up.
    ///
    /// # Errors
    /// A scale that is not finite or 0, a range without width.
    pub fn try_new(params: ProbeParams<T>) -> Result<Self, InvalidParameter> {
        let [at_zero, per_count] = [params.at_zero, params.per_count].map(T::to_f64);
        let [low, high] = params.linear_range;
        check(true, "at_zero", at_zero, "a finite length")?;
        check(per_count != 0.0, "per_count", per_count, "a length other than 0 m")?;
        check(low < high, "linear_range", f64::from(high), "above the smallest count of the range")?;
        Ok(Self::from_constants(params))
    }

    /// Creates the channel from parameters that were checked before, such as those in a `static`.
    #[must_use]
    pub const fn from_constants(params: ProbeParams<T>) -> Self {
        Self { params, last: T::ZERO, counts: u32::MAX, unchanged: 0, held_in_a_row: 0, held_count: 0 }
    }

    /// Returns the displacement at this count, or the last valid one with [`Status::INPUT_NOT_OK`] where the channel is not OK. Before a first
    /// valid sample the displacement is 0.
    #[inline]
    pub fn sample(&mut self, counts: u32) -> (T, Status) {
        let ProbeParams { at_zero, per_count, linear_range: [low, high], stuck_after } = self.params;
        let unchanged = self.unchanged.saturating_add(1) * u32::from(counts == self.counts);
        let is_stuck = (stuck_after > 0) & (unchanged >= stuck_after);
        let is_ok = (counts >= low) & (counts <= high) & !is_stuck;
        let not_ok = u32::from(!is_ok);
        self.last = T::select(is_ok, at_zero + per_count * T::from_u32(counts), self.last);
        self.counts = counts;
        self.unchanged = unchanged;
        self.held_in_a_row = self.held_in_a_row.saturating_add(1) * not_ok;
        self.held_count = self.held_count.saturating_add(not_ok);
        (self.last, Status::INPUT_NOT_OK.when(!is_ok))
    }

    /// Returns the age of the displacement in samples: 0 where the last one was valid (saturating).
    #[must_use]
    pub const fn held_in_a_row(&self) -> u32 {
        self.held_in_a_row
    }

    /// Returns the number of samples since the start or the last [`Probe::reset`] that were not OK (saturating).
    #[must_use]
    pub const fn held_count(&self) -> u32 {
        self.held_count
    }

    /// Forgets samples and counters, after a repair of the channel.
    pub fn reset(&mut self) {
        *self = Self::from_constants(self.params);
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    const PARAMS: ProbeParams<f32> =
        ProbeParams { at_zero: -1e-3, per_count: 1e-6, linear_range: [100, 4000], stuck_after: 3 };

    #[test]
    fn counts_are_metres_within_the_linear_range() {
        let mut probe = Probe::try_new(PARAMS).unwrap();
        for (counts, expected) in [(100, -9e-4), (1000, 0.0), (4000, 3e-3)] {
            let (found, status) = probe.sample(counts);
            assert!((found - expected).abs() < 1e-9 && status == Status::OK, "{counts}: {found}");
        }
    }

    /// A railed or broken channel holds; its age counts until it recovers, all of its bad samples until a reset.
    #[test]
    fn a_channel_that_is_not_ok_holds() {
        let mut probe = Probe::try_new(PARAMS).unwrap();
        let (there, _) = probe.sample(1500);
        for (age, counts) in [(1, 4095), (2, 0), (3, u32::MAX), (4, 99), (5, 4001)] {
            assert_eq!(probe.sample(counts), (there, Status::INPUT_NOT_OK), "{counts}");
            assert_eq!(probe.held_in_a_row(), age);
        }
        assert_eq!(probe.sample(1501).1, Status::OK);
        assert_eq!((probe.held_in_a_row(), probe.held_count()), (0, 5));
        probe.reset();
        assert_eq!(probe, Probe::try_new(PARAMS).unwrap());
    }

    /// A count that does not change for three samples is stuck until it changes; without a limit it never is.
    #[test]
    fn a_count_that_stands_still_is_stuck() {
        let mut probe = Probe::try_new(PARAMS).unwrap();
        let not_ok: [bool; 7] = [7, 7, 7, 7, 7, 8, 8].map(|part| probe.sample(1000 + part).1 == Status::INPUT_NOT_OK);
        assert_eq!(not_ok, [false, false, false, true, true, false, false]);
        let mut still = Probe::try_new(ProbeParams { stuck_after: 0, ..PARAMS }).unwrap();
        assert!((0..100).all(|_| still.sample(1000).1 == Status::OK));
    }

    #[test]
    fn impossible_parameters_are_rejected() {
        for (params, name) in [
            (ProbeParams { at_zero: f32::NAN, ..PARAMS }, "at_zero"),
            (ProbeParams { per_count: 0.0, ..PARAMS }, "per_count"),
            (ProbeParams { per_count: f32::INFINITY, ..PARAMS }, "per_count"),
            (ProbeParams { linear_range: [4000, 100], ..PARAMS }, "linear_range"),
        ] {
            assert_eq!(Probe::try_new(params).unwrap_err().name, name);
        }
    }
}
