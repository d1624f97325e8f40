//! Compensated summation.

use crate::scalar::Scalar;

/// A sum with its rounding error stored separately: twice the digits of `T`.
///
/// Source: Knuth, The Art of Computer Programming 2, 4.2.2 (two-sum), as used by Kahan and Babuska. Cost of an addition:
/// ten additions, no branch.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CompensatedSum<T> {
    sum: T,
    lost: T,
}

impl<T: Scalar> CompensatedSum<T> {
    /// Creates the sum 0.
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
        // Transfers the error as soon as it counts, so that it stays small and keeps its own digits.
        self.sum = next + lost;
        self.lost = lost - (self.sum - next);
    }

    /// Returns the sum, rounded once.
    #[must_use]
    #[inline]
    pub fn value(&self) -> T {
        self.sum + self.lost
    }
}
