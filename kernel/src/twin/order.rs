//! Order tracking: amplitude and phase of components that rotate with the shaft, a cage or a ball.

use super::sum::{Accumulator, CompensatedSum};
use crate::math::Math;
use crate::phase::{Phase, SpeedRatio};
use crate::rotor::ComponentAngles;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Angle of a spectral line as a sum of integer multiples of the angles of the shaft and of bearing components.
///
/// Examples for a bearing of `N` elements: 1X is `shaft: 1`; the outer ball pass is `cage: N`; the inner ball pass is
/// `shaft: N, cage: -N`; a defect on a ball is `ball: 2`. Side bands at shaft speed have `shaft` one more or less.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OrderLine {
    /// Multiple of the shaft angle.
    pub shaft: i32,
    /// Multiple of the cage angle.
    pub cage: i32,
    /// Multiple of the angle of the balls about their own axes.
    pub ball: i32,
}

impl OrderLine {
    /// Returns the angle of the line.
    #[must_use]
    pub const fn angle(&self, shaft: Phase, parts: &ComponentAngles) -> Phase {
        shaft
            .wrapping_mul(self.shaft as i64 as u64)
            .wrapping_add(parts.cage.wrapping_mul(self.cage as i64 as u64))
            .wrapping_add(parts.ball.wrapping_mul(self.ball as i64 as u64))
    }
}

/// Amplitudes `[c, s]` of a line over a block: the signal is `c cos p + s sin p` with the angle `p` of the line.
pub type OrderVector<T> = [T; 2];

/// Progress over blocks of whole revolutions under a Hann window, and the sum of its weights.
///
/// `S` is the accumulator of the sums: compensated in firmware; in `f64`, a plain sum has digits to spare.
#[derive(Debug, Clone, Copy)]
pub struct RevolutionBlock<T, S = CompensatedSum<T>> {
    /// Completed share of the block, as an angle.
    progress: Phase,
    weight: S,
    number: PhantomData<T>,
}

impl<T: Scalar, S: Accumulator<T>> RevolutionBlock<T, S> {
    /// Creates the block at its start.
    #[must_use]
    pub const fn new() -> Self {
        Self { progress: Phase::ZERO, weight: S::ZERO, number: PhantomData }
    }

    /// Advances by a share of the block, below one block as an angle; returns true where that completes the block.
    #[inline]
    pub const fn advance(&mut self, share: Phase) -> bool {
        let before = self.progress;
        self.progress = before.wrapping_add(share);
        self.progress.0 < before.0
    }

    /// Returns the window at the present progress and adds it to the weight.
    #[inline]
    pub fn window<M: Math<T>>(&mut self) -> T {
        let (_, cos) = M::sin_cos(self.progress);
        let window = T::HALF * (T::ONE - cos);
        self.weight.accumulate(window);
        window
    }

    /// Ends the block: returns the factor from sums to amplitudes, 0 without weight.
    pub fn close(&mut self) -> T {
        let weight = self.weight.total();
        self.weight = S::ZERO;
        let is_weighted = weight > T::ZERO;
        T::select(is_weighted, T::from_f64(2.0) / T::select(is_weighted, weight, T::ONE), T::ZERO)
    }
}

impl<T: Scalar, S: Accumulator<T>> Default for RevolutionBlock<T, S> {
    fn default() -> Self {
        Self::new()
    }
}

/// Sums of one signal at one line over the current block.
#[derive(Debug, Clone, Copy)]
pub struct OrderSums<T, S = CompensatedSum<T>> {
    sums: [S; 2],
    number: PhantomData<T>,
}

impl<T: Scalar, S: Accumulator<T>> OrderSums<T, S> {
    /// Creates empty sums.
    #[must_use]
    pub const fn new() -> Self {
        Self { sums: [S::ZERO; 2], number: PhantomData }
    }

    /// Adds a sample times its window, at sine and cosine of the angle of the line.
    #[inline]
    pub fn add(&mut self, windowed: T, (sin, cos): (T, T)) {
        let [along, across] = &mut self.sums;
        along.accumulate(windowed * cos);
        across.accumulate(windowed * sin);
    }

    /// Ends the block with the factor that [`RevolutionBlock::close`] returns; returns the amplitudes over it.
    pub fn close(&mut self, scale: T) -> OrderVector<T> {
        let vector = self.sums.map(|sum| scale * sum.total());
        self.sums = [S::ZERO; 2];
        vector
    }
}

impl<T: Scalar, S: Accumulator<T>> Default for OrderSums<T, S> {
    fn default() -> Self {
        Self::new()
    }
}

/// Demodulates one signal at `L` lines over blocks of whole revolutions of the shaft.
///
/// The phase comes from angles instead of time, so that a run-up does not smear the lines. A Hann window over the angle of
/// the block separates lines that differ by more than two cycles per block; blocks are independent. Cost per sample: a sine
/// and cosine and 20 operations per line, and one sine and cosine for the window.
///
/// [`RevolutionBlock`] and [`OrderSums`] are its parts, for any number of signals and for other lines.
#[derive(Debug, Clone, Copy)]
pub struct OrderTracker<T, const L: usize> {
    lines: [OrderLine; L],
    progress_per_revolution: SpeedRatio,
    shaft: Phase,
    block: RevolutionBlock<T>,
    sums: [OrderSums<T>; L],
    vectors: [OrderVector<T>; L],
}

impl<T: Scalar, const L: usize> OrderTracker<T, L> {
    /// Creates a tracker for blocks of `turns` revolutions, starting at the shaft angle `shaft`. For set-up.
    #[must_use]
    pub fn new(lines: [OrderLine; L], turns: u32, shaft: Phase) -> Self {
        Self {
            lines,
            progress_per_revolution: SpeedRatio::new(1.0 / f64::from(turns.max(1))),
            shaft,
            block: RevolutionBlock::new(),
            sums: [OrderSums::new(); L],
            vectors: [[T::ZERO; 2]; L],
        }
    }

    /// Adds a sample at the angles of shaft and bearing components; returns true at the end of a block.
    pub fn add<M: Math<T>>(&mut self, x: T, shaft: Phase, parts: &ComponentAngles) -> bool {
        let arc = shaft.since(self.shaft);
        // Both senses of rotation complete the block.
        let complete = self.block.advance(Phase(self.progress_per_revolution.apply(arc).0.unsigned_abs()));
        self.shaft = shaft;
        if complete {
            let scale = self.block.close();
            for (vector, sums) in self.vectors.iter_mut().zip(&mut self.sums) {
                *vector = sums.close(scale);
            }
        }
        let x = self.block.window::<M>() * x;
        for (sums, line) in self.sums.iter_mut().zip(&self.lines) {
            sums.add(x, M::sin_cos(line.angle(shaft, parts)));
        }
        complete
    }

    /// Returns the amplitudes over the last complete block.
    #[must_use]
    pub const fn vectors(&self) -> &[OrderVector<T>; L] {
        &self.vectors
    }
}
