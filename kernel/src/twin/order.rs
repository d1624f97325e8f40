//! Order tracking: amplitude and phase of components that rotate with the shaft, a cage or a ball.

use super::CompensatedSum;
use crate::math::Math;
use crate::phase::{Phase, SpeedRatio};
use crate::rotor::ComponentAngles;
use crate::scalar::Scalar;

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

/// Demodulates one signal at `L` lines over blocks of whole revolutions of the shaft.
///
/// The phase comes from angles instead of time, so that a run-up does not smear the lines. A Hann window over the angle of
/// the block separates lines that differ by more than two cycles per block; blocks are independent. Cost per sample: a sine
/// and cosine and 20 operations per line, and one sine and cosine for the window.
#[derive(Debug, Clone, Copy)]
pub struct OrderTracker<T, const L: usize> {
    lines: [OrderLine; L],
    progress_per_revolution: SpeedRatio,
    shaft: Phase,
    /// Completed share of the block, as an angle.
    progress: Phase,
    sums: [[CompensatedSum<T>; 2]; L],
    weight: CompensatedSum<T>,
    vectors: [OrderVector<T>; L],
}

impl<T: Scalar, const L: usize> OrderTracker<T, L> {
    /// Creates a tracker for blocks of `turns` revolutions, starting at the shaft angle `shaft`. For set-up.
    #[must_use]
    pub fn new(lines: [OrderLine; L], turns: u32, shaft: Phase) -> Self {
        let none = [CompensatedSum::new(); 2];
        Self {
            lines,
            progress_per_revolution: SpeedRatio::new(1.0 / f64::from(turns.max(1))),
            shaft,
            progress: Phase::ZERO,
            sums: [none; L],
            weight: CompensatedSum::new(),
            vectors: [[T::ZERO; 2]; L],
        }
    }

    /// Adds a sample at the angles of shaft and bearing components; returns true at the end of a block.
    pub fn add<M: Math<T>>(&mut self, x: T, shaft: Phase, parts: &ComponentAngles) -> bool {
        let arc = shaft.since(self.shaft);
        let before = self.progress;
        // Both senses of rotation complete the block.
        let advance = self.progress_per_revolution.apply(arc).0.unsigned_abs();
        self.progress = Phase(before.0.wrapping_add(advance));
        self.shaft = shaft;
        let complete = self.progress.0 < before.0;
        if complete {
            self.close();
        }
        let (_, cos) = M::sin_cos(self.progress);
        let window = T::HALF * (T::ONE - cos);
        self.weight.add(window);
        let x = window * x;
        for (sums, line) in self.sums.iter_mut().zip(&self.lines) {
            let (sin, cos) = M::sin_cos(line.angle(shaft, parts));
            let [along, across] = sums;
            along.add(x * cos);
            across.add(x * sin);
        }
        complete
    }

    fn close(&mut self) {
        let weight = self.weight.value();
        let is_weighted = weight > T::ZERO;
        let scale = T::select(is_weighted, T::from_f64(2.0) / T::select(is_weighted, weight, T::ONE), T::ZERO);
        for (vector, sums) in self.vectors.iter_mut().zip(&mut self.sums) {
            *vector = sums.map(|sum| scale * sum.value());
            *sums = [CompensatedSum::new(); 2];
        }
        self.weight = CompensatedSum::new();
    }

    /// Returns the amplitudes over the last complete block.
    #[must_use]
    pub const fn vectors(&self) -> &[OrderVector<T>; L] {
        &self.vectors
    }
}
