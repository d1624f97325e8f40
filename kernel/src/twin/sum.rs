//! Sums that lose nothing over any length.

use crate::scalar::Scalar;

/// A sum with what its rounding lost kept beside it: twice the digits of `T`, whatever is added.
///
/// Source: Knuth, The Art of Computer Programming 2, 4.2.2 (two-sum), as Kahan and Babuska use it. Cost of an addition:
/// ten additions, no branch.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CompensatedSum<T> {
    sum: T,
    lost: T,
}

impl<T: Scalar> CompensatedSum<T> {
    /// 0.
    #[must_use]
    pub const fn new() -> Self {
        Self { sum: T::ZERO, lost: T::ZERO }
    }

    /// Adds `x`.
    #[inline]
    pub fn add(&mut self, x: T) {
        let next = self.sum + x;
        let had = next - x;
        let got = next - had;
        let lost = self.lost + ((self.sum - had) + (x - got));
        // What was lost is carried over as soon as it counts, so that it stays small and keeps its own digits.
        self.sum = next + lost;
        self.lost = lost - (self.sum - next);
    }

    /// The sum, rounded once.
    #[must_use]
    #[inline]
    pub fn value(&self) -> T {
        self.sum + self.lost
    }
}
