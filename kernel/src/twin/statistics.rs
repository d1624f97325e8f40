//! Mean, rms, peaks, crest factor and kurtosis of a signal, block by block.

use super::CompensatedSum;
use crate::math::Math;
use crate::scalar::Scalar;

/// BlockStatistics of one block.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BlockStatistics<T> {
    /// The mean: of a plane's two probes, the shaft's centreline.
    pub mean: T,
    /// Root mean square about the mean.
    pub rms: T,
    /// Greatest less least.
    pub peak_to_peak: T,
    /// Greatest distance from the mean over the rms: 1.41 of a sine; 0 where nothing moves.
    pub crest_factor: T,
    /// Fourth moment over the square of the second: 1.5 of a sine, 3 of normal noise; 0 where nothing moves.
    pub kurtosis: T,
}

/// Gathers blocks of `length` samples. Each block starts anew, so nothing drifts over any length.
///
/// Powers are taken about the last block's mean and added without loss: a small swing on a large offset keeps its digits.
/// Cost: 40 additions and multiplications a sample; at the end of a block two roots and a few divisions.
#[derive(Debug, Clone, Copy)]
pub struct Statistics<T> {
    length: u32,
    count: u32,
    about: T,
    powers: [CompensatedSum<T>; 4],
    least: T,
    greatest: T,
}

impl<T: Scalar> Statistics<T> {
    /// For blocks of `length` samples, 1 or more.
    #[must_use]
    pub fn new(length: u32) -> Self {
        let powers = [CompensatedSum::new(); 4];
        Self { length, count: 0, about: T::ZERO, powers, least: T::ZERO, greatest: T::ZERO }
    }

    /// One sample; the figures where it ended a block.
    pub fn add<M: Math<T>>(&mut self, x: T) -> Option<BlockStatistics<T>> {
        let first = self.count == 0;
        self.least = T::select(first, x, x.smaller(self.least));
        self.greatest = T::select(first, x, x.larger(self.greatest));
        let off = x - self.about;
        let mut power = off;
        for sum in &mut self.powers {
            sum.add(power);
            power *= off;
        }
        self.count += 1;
        (self.count >= self.length).then(|| self.close::<M>())
    }

    /// Ends the block where it is.
    pub fn close<M: Math<T>>(&mut self) -> BlockStatistics<T> {
        let part = T::ONE / T::from_f64(f64::from(self.count.max(1)));
        let [m1, m2, m3, m4] = self.powers.map(|sum| part * sum.value());
        let mean = self.about + m1;
        let square = m1 * m1;
        let two = T::from_f64(2.0);
        // Moments about the mean from those about another number.
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
        *self = Self { about, ..Self::new(self.length) };
        figures
    }
}
