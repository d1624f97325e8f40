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

/// A sum to which values are added one by one: [`CompensatedSum`], or the number itself for a plain sum.
pub trait Accumulator<T>: Copy {
    /// The sum 0.
    const ZERO: Self;

    /// Adds `x`.
    fn accumulate(&mut self, x: T);

    /// Returns the sum.
    fn total(&self) -> T;
}

impl<T: Scalar> Accumulator<T> for CompensatedSum<T> {
    const ZERO: Self = Self::new();

    #[inline]
    fn accumulate(&mut self, x: T) {
        self.add(x);
    }

    #[inline]
    fn total(&self) -> T {
        self.value()
    }
}

impl<T: Scalar> Accumulator<T> for T {
    const ZERO: Self = <T as Scalar>::ZERO;

    #[inline]
    fn accumulate(&mut self, x: T) {
        *self += x;
    }

    #[inline]
    fn total(&self) -> T {
        *self
    }
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
