//! Order tracking: amplitude and phase of what turns with the shaft, a cage or a ball.

use super::CompensatedSum;
use crate::math::Math;
use crate::phase::{Phase, SpeedRatio};
use crate::rotor::ComponentAngles;
use crate::scalar::Scalar;

/// What a line's phase follows: whole multiples of the angles of the shaft and of a bearing's parts.
///
/// 1X is `shaft: 1`; of a bearing of `N` elements the outer ball pass is `cage: N`, the inner one `shaft: N, cage: -N`, a
/// spot on a ball strikes at `ball: 2`, and the shaft's side bands of a line are the same with `shaft` one more or less.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OrderLine {
    /// Of the shaft's angle.
    pub shaft: i32,
    /// Of the cage's.
    pub cage: i32,
    /// Of the ball's about its own axis.
    pub ball: i32,
}

impl OrderLine {
    /// The line's angle.
    #[must_use]
    pub const fn angle(&self, shaft: Phase, parts: &ComponentAngles) -> Phase {
        shaft
            .wrapping_mul(self.shaft as i64 as u64)
            .wrapping_add(parts.cage.wrapping_mul(self.cage as i64 as u64))
            .wrapping_add(parts.ball.wrapping_mul(self.ball as i64 as u64))
    }
}

/// Amplitudes of cosine and sine of a line over a block: the signal is `c cos p + s sin p` with the line's angle `p`.
pub type OrderVector<T> = [T; 2];

/// Demodulates one signal at `L` lines over blocks of whole turns of the shaft.
///
/// The phase comes from the turn counters, not from time: a run-up smears nothing, and a month of turning loses nothing. A
/// Hann window over the block's angle keeps lines apart that are more than two blocks' turns from each other; each block
/// starts anew. Cost a sample: a sine and cosine and 20 operations for each line, and one more for the window.
#[derive(Debug, Clone, Copy)]
pub struct OrderTracker<T, const L: usize> {
    lines: [OrderLine; L],
    progress_per_revolution: SpeedRatio,
    shaft: Phase,
    /// Of the block that is progress, as an angle.
    progress: Phase,
    sums: [[CompensatedSum<T>; 2]; L],
    weight: CompensatedSum<T>,
    vectors: [OrderVector<T>; L],
}

impl<T: Scalar, const L: usize> OrderTracker<T, L> {
    /// For blocks of `turns` turns, starting with the shaft at `shaft`. Set-up time.
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

    /// One sample with the shaft and the bearing's parts where they are; true where a block is complete.
    pub fn add<M: Math<T>>(&mut self, x: T, shaft: Phase, parts: &ComponentAngles) -> bool {
        let arc = shaft.since(self.shaft);
        let before = self.progress;
        // Either sense of rotation fills the block.
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

    /// The lines over the last complete block.
    #[must_use]
    pub const fn vectors(&self) -> &[OrderVector<T>; L] {
        &self.vectors
    }
}
