//! Order tracking of the radial force at a bearing in the frames of its components.

use super::order::{OrderSums, OrderVector, RevolutionBlock};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::phase::{Phase, SpeedRatio};
use crate::scalar::Scalar;

/// One line of the full spectrum of a force: its forward and its backward amplitude, N.
///
/// In the frame of the component, at the angle `p` of its fundamental, the line of order `k` is
/// `F e^(i k p) + B e^(-i k p)`. Both amplitudes are complex numbers `[real, imaginary]`. Forward is the sense in which `p`
/// rotates, that of the shaft. A force of fixed direction has equal magnitudes (linear polarisation); a rotating force has
/// one amplitude only (circular polarisation).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ForceLine<T> {
    /// F, amplitude of forward precession, N.
    pub forward: [T; 2],
    /// B, amplitude of backward precession, N.
    pub backward: [T; 2],
}

impl<T: Scalar> ForceLine<T> {
    /// Splits the amplitudes along both axes of the frame into forward and backward ones.
    fn from_axes([[cx, sx], [cy, sy]]: [OrderVector<T>; 2]) -> Self {
        let half = |a: T, b: T| T::HALF * (a + b);
        Self { forward: [half(cx, sy), half(cy, -sx)], backward: [half(cx, -sy), half(cy, sx)] }
    }

    /// Returns the polarisation `(|F|^2 - |B|^2)/(|F|^2 + |B|^2)`: 0 linear, 1 circular forward, -1 circular backward; 0
    /// for a line without amplitude.
    #[must_use]
    pub fn polarisation(&self) -> T {
        let square = |[re, im]: [T; 2]| re * re + im * im;
        let (forward, backward) = (square(self.forward), square(self.backward));
        let sum = forward + backward;
        let acts = sum > T::ZERO;
        T::select(acts, (forward - backward) / T::select(acts, sum, T::ONE), T::ZERO)
    }

    /// Returns `2 F B = 2 |F| |B| (cos 2a, sin 2a)`, N^2, with the direction `a` of the force in the frame of the component.
    ///
    /// `a` is half the angle of this vector, except for half a turn: an alternating force has two directions. The lines of
    /// a local defect have one direction, so their vectors add up to the direction of the defect.
    #[must_use]
    pub fn double_direction(&self) -> [T; 2] {
        let ([fr, fi], [br, bi]) = (self.forward, self.backward);
        let two = T::ONE + T::ONE;
        [two * (fr * br - fi * bi), two * (fr * bi + fi * br)]
    }
}

/// Lines of a force in the frame of each component, orders 1 to `H` of the component's fundamental.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ForceOrders<T, const H: usize> {
    /// Outer ring: orders of the ball pass `N (cage - outer)`, directions from +X of the ring.
    pub outer: [ForceLine<T>; H],
    /// Inner ring: orders of the ball pass `N (inner - cage)`, directions from the mark of the ring (the keyphasor mark
    /// where the shaft carries it).
    pub inner: [ForceLine<T>; H],
    /// Rolling elements: orders of `-2 ball`, directions from the first element.
    pub element: [ForceLine<T>; H],
}

/// Sums of both components of a force at orders 1 to `H` of one fundamental.
#[derive(Debug, Clone, Copy)]
struct FrameSums<T, const H: usize>([[OrderSums<T>; 2]; H]);

impl<T: Scalar, const H: usize> FrameSums<T, H> {
    const fn new() -> Self {
        Self([[OrderSums::new(); 2]; H])
    }

    /// Adds a windowed force in the fixed frame, at the angles of the frame and of the fundamental.
    #[inline]
    fn add<M: Math<T>>(&mut self, [x, y]: [T; 2], frame: Phase, fundamental: Phase) {
        let (sin, cos) = M::sin_cos(frame);
        let (along, across) = (x * cos + y * sin, y * cos - x * sin);
        let (sin, cos) = M::sin_cos(fundamental);
        let mut line = (sin, cos);
        for [of_x, of_y] in &mut self.0 {
            of_x.add(along, line);
            of_y.add(across, line);
            line = (line.0 * cos + line.1 * sin, line.1 * cos - line.0 * sin);
        }
    }

    fn close(&mut self, scale: T) -> [ForceLine<T>; H] {
        let mut lines = [ForceLine::default(); H];
        for (line, sums) in lines.iter_mut().zip(&mut self.0) {
            *line = ForceLine::from_axes(sums.each_mut().map(|sums| sums.close(scale)));
        }
        lines
    }
}

/// Order tracking of the radial force `z = F_X + i F_Y` at a bearing, in the frame of each component.
///
/// A local defect is a force of fixed direction in the frame of the component that carries it. Each sample is turned into
/// the three frames, `z e^(-i frame)`, and demodulated at orders 1 to `H` of the fundamental of each:
///
/// | component | frame | fundamental `p` |
/// | --- | --- | --- |
/// | outer ring | `outer` | `N (cage - outer)` |
/// | inner ring | `inner` | `N (inner - cage)` |
/// | rolling elements | `cage` | `-2 ball`: balls roll against the shaft |
///
/// ```text
/// F_k = sum(w z e^(-i frame) e^(-i k p))/sum(w),   B_k = sum(w z e^(-i frame) e^(i k p))/sum(w)
/// ```
///
/// `w` is a Hann window over whole revolutions of the inner relative to the outer ring. It separates lines that differ by
/// more than two cycles per block; blocks are independent. The angles of cage and balls decide which line is found: where
/// the cage slips, they have to slip too.
///
/// Cost per sample: seven sines and cosines, and 54 operations for each of the `3 H` lines; the number of instructions is
/// constant in `f32`. [`close`](Self::close) takes one division and 10 operations per line, once per block.
///
/// ```
/// use ballrace::twin::ForceOrderTracker;
/// use ballrace::{BearingKinematicState, Exact, Phase};
///
/// // An outer-race defect at 90 degrees of a bearing with 9 balls: a force along Y, once for each ball that passes.
/// let mut tracker = ForceOrderTracker::<f32, 3>::new(9, 8, &BearingKinematicState::default());
/// for i in 1..=2048_u32 {
///     let turns = f64::from(i) / 256.0;
///     let [inner, cage] = [1.0, 0.4].map(|ratio| Phase::from_revolutions(ratio * turns));
///     let at = BearingKinematicState { inner, cage, ..BearingKinematicState::default() };
///     let force = [0.0, 5.0 * cage.wrapping_mul(9).radians().cos() as f32];
///     if tracker.add::<Exact>(force, &at) {
///         let [line, ..] = tracker.close().outer;
///         assert!((line.forward[1] - 2.5).abs() < 1e-3 && (line.backward[1] - 2.5).abs() < 1e-3);
///         assert!(line.polarisation().abs() < 1e-3);
///         let [cos, sin] = line.double_direction();
///         assert!((0.5 * sin.atan2(cos).to_degrees().abs() - 90.0).abs() < 0.1);
///     }
/// }
/// ```
#[derive(Debug, Clone, Copy)]
pub struct ForceOrderTracker<T, const H: usize> {
    elements: u64,
    progress_per_revolution: SpeedRatio,
    /// Angle of the inner relative to the outer ring at the last sample.
    rotation: Phase,
    block: RevolutionBlock<T>,
    outer: FrameSums<T, H>,
    inner: FrameSums<T, H>,
    element: FrameSums<T, H>,
}

impl<T: Scalar, const H: usize> ForceOrderTracker<T, H> {
    /// Creates a tracker for a bearing of `elements` rolling elements and blocks of `turns` revolutions, starting at `at`.
    /// For set-up.
    #[must_use]
    pub fn new(elements: u32, turns: u32, at: &BearingKinematicState<T>) -> Self {
        Self {
            elements: u64::from(elements),
            progress_per_revolution: SpeedRatio::new(1.0 / f64::from(turns.max(1))),
            rotation: rotation(at),
            block: RevolutionBlock::new(),
            outer: FrameSums::new(),
            inner: FrameSums::new(),
            element: FrameSums::new(),
        }
    }

    /// Adds a force `[F_X, F_Y]`, N, in the fixed frame; returns true where a block ends and [`close`](Self::close) has its
    /// amplitudes.
    ///
    /// A force that is not finite spoils its block, not the next one.
    pub fn add<M: Math<T>>(&mut self, force: [T; 2], at: &BearingKinematicState<T>) -> bool {
        let rotation = rotation(at);
        let arc = rotation.since(self.rotation);
        self.rotation = rotation;
        // Both senses of rotation complete the block.
        let complete = self.block.advance(Phase(self.progress_per_revolution.apply(arc).0.unsigned_abs()));
        let window = self.block.window::<M>();
        let force = force.map(|component| window * component);
        let pass = |to: Phase, from: Phase| to.wrapping_add(from.reversed()).wrapping_mul(self.elements);
        self.outer.add::<M>(force, at.outer, pass(at.cage, at.outer));
        self.inner.add::<M>(force, at.inner, pass(at.inner, at.cage));
        self.element.add::<M>(force, at.cage, at.ball.reversed().wrapping_mul(2));
        complete
    }

    /// Ends the block; returns the amplitudes over it, 0 without samples.
    pub fn close(&mut self) -> ForceOrders<T, H> {
        let scale = self.block.close();
        ForceOrders {
            outer: self.outer.close(scale),
            inner: self.inner.close(scale),
            element: self.element.close(scale),
        }
    }
}

/// Returns the angle of the inner relative to the outer ring.
fn rotation<T>(at: &BearingKinematicState<T>) -> Phase {
    at.inner.wrapping_add(at.outer.reversed())
}
