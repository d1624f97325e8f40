//! Mean, rms, peaks, crest factor and kurtosis of a signal, block by block.

use super::sum::{Accumulator, CompensatedSum};
use crate::math::Math;
use crate::scalar::Scalar;

/// Statistics of one block.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BlockStatistics<T> {
    /// Mean.
    pub mean: T,
    /// Root mean square about the mean.
    pub rms: T,
    /// Greatest less least value.
    pub peak_to_peak: T,
    /// Greatest distance from the mean divided by the rms: 1.41 for a sine; 0 for a constant signal.
    pub crest_factor: T,
    /// Fourth moment divided by the squared second: 1.5 for a sine, 3 for normal noise; 0 for a constant signal.
    pub kurtosis: T,
}

/// Statistics of blocks of `length` samples. Blocks are independent, so that the results do not drift.
///
/// Powers are taken about the mean of the last block and added with compensation: a small oscillation on a large offset
/// keeps its digits. `S` is the accumulator of the sums: in `f64`, about a value near the mean, a plain sum has digits to spare. Cost: 40
/// additions and multiplications per sample, 12 with plain sums; two square roots and a few divisions per block.
#[derive(Debug, Clone, Copy)]
pub struct Statistics<T, S = CompensatedSum<T>> {
    length: u32,
    count: u32,
    about: T,
    powers: [S; 4],
    least: T,
    greatest: T,
}

impl<T: Scalar, S: Accumulator<T>> Statistics<T, S> {
    /// Creates the state for blocks of `length` samples, 1 or more.
    #[must_use]
    pub const fn new(length: u32) -> Self {
        Self::about(T::ZERO, length)
    }

    /// Creates the state with a value near the mean of the first block, about which its powers are taken.
    #[must_use]
    pub const fn about(about: T, length: u32) -> Self {
        Self { length, count: 0, about, powers: [S::ZERO; 4], least: T::ZERO, greatest: T::ZERO }
    }

    /// Adds a sample; returns the statistics at the end of a block.
    pub fn add<M: Math<T>>(&mut self, x: T) -> Option<BlockStatistics<T>> {
        let first = self.count == 0;
        self.least = T::select(first, x, x.smaller(self.least));
        self.greatest = T::select(first, x, x.larger(self.greatest));
        let off = x - self.about;
        let mut power = off;
        for sum in &mut self.powers {
            sum.accumulate(power);
            power *= off;
        }
        self.count += 1;
        (self.count >= self.length).then(|| self.close::<M>())
    }

    /// Ends the block and returns its statistics.
    pub fn close<M: Math<T>>(&mut self) -> BlockStatistics<T> {
        let part = T::ONE / T::from_f64(f64::from(self.count.max(1)));
        let [m1, m2, m3, m4] = self.powers.map(|sum| part * sum.total());
        let mean = self.about + m1;
        let square = m1 * m1;
        let two = T::from_f64(2.0);
        // Shifts the moments to the mean.
        let second = (m2 - square).larger(T::ZERO);
        let fourth =
            m4 - two * two * m1 * m3 + two * T::from_f64(3.0) * square * m2 - T::from_f64(3.0) * square * square;
        let rms = M::sqrt(second);
        let peak = (self.greatest - mean).larger(mean - self.least);
        let moves = second > T::ZERO;
        let over = |x: T, by: T| T::select(moves, x / T::select(moves, by, T::ONE), T::ZERO);
        let figures = BlockStatistics {
            mean,
            rms,
            peak_to_peak: self.greatest - self.least,
            crest_factor: over(peak, rms),
            kurtosis: over(fourth, second * second),
        };
        let about = T::select(mean.is_finite(), mean, T::ZERO);
        *self = Self::about(about, self.length);
        figures
    }
}
