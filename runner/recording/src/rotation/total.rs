//! Revolutions since the first pulse: whole ones and the angle in one number.

use ballrace::Phase;

/// 2^64
const COUNTS_PER_TURN: f64 = 18_446_744_073_709_551_616.0;

/// Revolutions in counts of 2^-64: sums and products are exact, however long the shaft turns.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Total(i128);

impl Total {
    /// Converts revolutions; the scaling by a power of 2 keeps every digit. NaN gives 0.
    pub(super) fn of(revolutions: f64) -> Self {
        Self((revolutions * COUNTS_PER_TURN) as i128)
    }

    /// Returns the sum of whole revolutions and `revolutions`.
    pub(super) fn beyond(whole: i64, revolutions: f64) -> Self {
        Self(i128::from(whole) << 64).plus(Self::of(revolutions))
    }

    pub(super) const fn plus(self, other: Self) -> Self {
        Self(self.0.wrapping_add(other.0))
    }

    pub(super) const fn times(self, count: u64) -> Self {
        Self(self.0.wrapping_mul(count as i128))
    }

    /// Returns the revolutions with the opposite sign.
    pub(super) const fn reversed(self) -> Self {
        Self(self.0.wrapping_neg())
    }

    /// Returns the number of complete revolutions (floor).
    pub(super) const fn revolution(self) -> i64 {
        (self.0 >> 64) as i64
    }

    /// Returns the fraction of a revolution above that.
    pub(super) const fn angle(self) -> Phase {
        Phase(self.0 as u64)
    }
}
