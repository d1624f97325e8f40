//! Order tracking: amplitude and phase of what turns with the shaft, a cage or a ball.

use super::ExactSum;
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
            .times(self.shaft as i64 as u64)
            .plus(parts.cage.times(self.cage as i64 as u64))
            .plus(parts.ball.times(self.ball as i64 as u64))
    }
}

/// Amplitudes of cosine and sine of a line over a block: the signal is `c cos p + s sin p` with the line's angle `p`.
pub type Vector<T> = [T; 2];

/// Demodulates one signal at `L` lines over blocks of whole turns of the shaft.
///
/// The phase comes from the turn counters, not from time: a run-up smears nothing, and a month of turning loses nothing. A
/// Hann window over the block's angle keeps lines apart that are more than two blocks' turns from each other; each block
/// starts anew. Cost a sample: a sine and cosine and 20 operations for each line, and one more for the window.
#[derive(Debug, Clone, Copy)]
pub struct OrderTracker<T, const L: usize> {
    lines: [OrderLine; L],
    share: SpeedRatio,
    shaft: Phase,
    /// Of the block that is gone, as an angle.
    gone: Phase,
    sums: [[ExactSum<T>; 2]; L],
    weight: ExactSum<T>,
    vectors: [Vector<T>; L],
}

impl<T: Scalar, const L: usize> OrderTracker<T, L> {
    /// For blocks of `turns` turns, starting with the shaft at `shaft`. Set-up time.
    #[must_use]
    pub fn new(lines: [OrderLine; L], turns: u32, shaft: Phase) -> Self {
        let none = [ExactSum::new(); 2];
        Self {
            lines,
            share: SpeedRatio::new(1.0 / f64::from(turns.max(1))),
            shaft,
            gone: Phase::ZERO,
            sums: [none; L],
            weight: ExactSum::new(),
            vectors: [[T::ZERO; 2]; L],
        }
    }

    /// One sample with the shaft and the bearing's parts where they are; true where a block is complete.
    pub fn add<M: Math<T>>(&mut self, x: T, shaft: Phase, parts: &ComponentAngles) -> bool {
        let arc = shaft.since(self.shaft);
        let before = self.gone;
        // Either sense of rotation fills the block.
        let ahead = self.share.of(arc).0.unsigned_abs();
        self.gone = Phase(before.0.wrapping_add(ahead));
        self.shaft = shaft;
        let complete = self.gone.0 < before.0;
        if complete {
            self.close();
        }
        let (_, cos) = M::sin_cos(self.gone);
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
        let some = weight > T::ZERO;
        let scale = T::choose(some, T::from_f64(2.0) / T::choose(some, weight, T::ONE), T::ZERO);
        for (vector, sums) in self.vectors.iter_mut().zip(&mut self.sums) {
            *vector = sums.map(|sum| scale * sum.value());
            *sums = [ExactSum::new(); 2];
        }
        self.weight = ExactSum::new();
    }

    /// The lines over the last complete block.
    #[must_use]
    pub const fn vectors(&self) -> &[Vector<T>; L] {
        &self.vectors
    }
}
