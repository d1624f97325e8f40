//! State estimation from noisy probes: a steady-state Kalman filter with the nonlinear bearing forces.

use super::WithUnmodelledForce;
use crate::math::Math;
use crate::phase::Phase;
use crate::rotor::{ForceElement, Integrator, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion};
use crate::scalar::{LatticeIndex, Scalar};
use crate::status::Status;

/// Kalman gains at one shaft speed: change of the state per unit innovation of each probe.
#[derive(Debug, Clone, Copy, PartialEq)]
// The C interface reads gains from arrays of C.
#[repr(C)]
pub struct SpeedGain<T, const D: usize, const P: usize> {
    /// Gains of the coordinates, per metre.
    pub position: [[T; D]; P],
    /// Gains of the velocities, 1/s.
    pub rate: [[T; D]; P],
    /// Gains of the unmodelled load, N/m.
    pub load: [[T; D]; P],
    /// Gains of the rotating unmodelled load, N/m.
    pub rotating_load: [[T; D]; P],
    /// `W`, a lower triangular matrix with `W^T W = S^-1`, the inverse covariance of the innovations, 1/m.
    pub whitening: [[T; P]; P],
}

/// Parameters of the observer: system, probes and gains.
///
/// The state is `x = [q, q', d, r]`: coordinates, velocities, an unmodelled constant load `d`, and an unmodelled load `r`
/// that rotates with the shaft, such as an unbalance and its couple. The `D` coordinates are the five of a rigid rotor,
/// `[u v w thu thv]`, and in a flexible one pairs of elastic coordinates along X and Y; coordinates without a partner, along the
/// axis or of a support, have no rotating load. The prediction is a step of the integrator with the
/// nonlinear bearing forces and `d + r`; the correction is `x += L (y - C q)` with the steady-state Kalman gain `L` of the
/// model linearised at static equilibrium. Gains may be given at several evenly spaced speeds; between them they are
/// interpolated, outside the nearest ones apply.
///
/// Source: Kalman 1960; disturbances as states: Johnson 1971. Cost: the steps of the integrator, a sine and cosine, and `P
/// (5 D + P)` multiplications, twice that with gains at several speeds.
#[derive(Debug, Clone, Copy)]
pub struct Observer<T, R, C, I, A, const D: usize, const N: usize, const P: usize, B = [[T; D]; P]> {
    /// Model of the rotor on its bearings.
    pub system: RotorBearingSystem<R, C, N>,
    /// Integrator; its time step must be `step`.
    pub integrator: I,
    /// Time step, s.
    pub step: T,
    /// Time steps per sample.
    pub substeps: u32,
    /// `C`: reading of each probe per unit of each coordinate. An array, or a slice of at most `P` rows where the number of probes is known
    /// only at run time: readings and gains beyond it are not used.
    pub probes: B,
    /// Gains by speed: a slice of at least one.
    pub gains: A,
    /// Speed of the first gain, rad/s, and gains per rad/s.
    pub speeds: [T; 2],
    /// Factor of the unmodelled load from sample to sample without correction, at most 1.
    pub load_retention: T,
    /// Validation gate: a sample whose normalised innovation squared is above it corrects nothing.
    ///
    /// Range: above 0. With a true model and true noise the quantity is chi-square distributed with `P` degrees of freedom,
    /// so its quantile at `1 - alpha` rejects a sound sample with probability `alpha`; 51 for five probes at 1e-9.
    /// Infinity disables the gate.
    ///
    /// Source: Bar-Shalom, Li, Kirubarajan 2001, Estimation with Applications to Tracking and Navigation, section 5.4.
    pub gate: T,
}

/// State of the observer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObserverState<T, const D: usize, const N: usize> {
    /// Motion of the rotor.
    pub motion: RotorState<T, D, N>,
    /// Unmodelled constant load on the coordinates, N and N m.
    pub load: [T; D],
    /// Unmodelled rotating load at the present shaft angle: `FX FY`, 0, `MX MY`, then pairs along X and Y.
    pub rotating_load: [T; D],
}

/// Result of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate<T, const P: usize> {
    /// Readings less predictions, m; 0 for a missing reading.
    pub innovation: [T; P],
    /// Normalised innovation squared, `e^T S^-1 e`: with a true model and true noise, chi-square distributed with `P`
    /// degrees of freedom and the mean `P`.
    pub nis: T,
    /// [`Status::INPUT_NOT_FINITE`] if a reading is missing, [`Status::INNOVATION_REJECTED`] if `nis` is above the gate,
    /// and the flags of the integrator.
    pub status: Status,
}

impl<T: Scalar, const D: usize, const N: usize> ObserverState<T, D, N> {
    /// Creates a state without unmodelled loads.
    pub fn new(motion: RotorState<T, D, N>) -> Self {
        Self { motion, load: [T::ZERO; D], rotating_load: [T::ZERO; D] }
    }
}

impl<T, R, C, I, A, const D: usize, const N: usize, const P: usize, B> Observer<T, R, C, I, A, D, N, P, B>
where
    T: Scalar,
    R: SecondOrderSystem<T, D>,
    C: ForceElement<T, D>,
    I: Integrator<T>,
    A: AsRef<[SpeedGain<T, D, P>]>,
    B: AsRef<[[T; D]]>,
{
    /// Processes one sample: `shaft` is the motion of the shaft at the last sample, `readings` are the present probe
    /// readings (m).
    ///
    /// A reading that is not finite corrects nothing; the others do. A sample above the gate corrects nothing at all: the
    /// state is then the prediction. The number of instructions is constant.
    // Always inlined: the caller may be compiled for wider SIMD registers than the rest of the program.
    #[inline(always)]
    pub fn sample<M: Math<T>>(
        &self,
        state: &mut ObserverState<T, D, N>,
        shaft: &ShaftMotion<T>,
        readings: &[T; P],
    ) -> Estimate<T, P> {
        let mut status = self.predict::<M>(state, shaft);
        let mut innovation = [T::ZERO; P];
        let probes = self.probes.as_ref();
        for ((e, reading), row) in innovation.iter_mut().zip(readings).zip(probes) {
            let expected = row.iter().zip(&state.motion.q).fold(T::ZERO, |sum, (&c, &q)| sum + c * q);
            let found = *reading - expected;
            let usable = found.is_finite();
            *e = T::select(usable, found, T::ZERO);
            status = status.union(Status::INPUT_NOT_FINITE.when(!usable));
        }
        let weights = self.weights(shaft.speed);
        let gains = || self.gains.as_ref().iter().skip(weights.below as usize).zip(weights.of_each);
        let mut nis = T::ZERO;
        for (gain, weight) in gains() {
            nis += weight * gain.normalised_square(&innovation, probes.len());
        }
        let accepted = nis <= self.gate;
        let correction = innovation.map(|e| T::select(accepted, e, T::ZERO));
        for (gain, weight) in gains() {
            gain.apply(state, weight, &correction, probes.len());
        }
        Estimate { innovation, nis, status: status.union(Status::INNOVATION_REJECTED.when(!accepted)) }
    }

    #[inline(always)]
    fn predict<M: Math<T>>(&self, state: &mut ObserverState<T, D, N>, shaft: &ShaftMotion<T>) -> Status {
        let (mut status, mut now) = (Status::OK, *shaft);
        let (sin, cos) = M::sin_cos(Phase::ZERO.advanced(shaft.delta_after(self.step)));
        for _ in 0..self.substeps {
            // Value in the middle of the step: the mean of before and after.
            let before = state.rotating_load;
            state.rotating_load = rotated(&before, sin, cos);
            let mut load = state.load;
            for (sum, (&a, &b)) in load.iter_mut().zip(before.iter().zip(&state.rotating_load)) {
                *sum += T::HALF * (a + b);
            }
            let system = RotorBearingSystem {
                rotor: WithUnmodelledForce { system: &self.system.rotor, load },
                bearings: self.system.bearings.each_ref(),
            };
            status = status.union(self.integrator.step(&system, &mut state.motion, &now));
            now = now.after(self.step);
        }
        for load in &mut state.load {
            *load *= self.load_retention;
        }
        status
    }

    /// Returns the interpolation weights of the gains at `speed`.
    #[inline(always)]
    fn weights(&self, speed: T) -> Weights<T> {
        let gains = self.gains.as_ref();
        let [first, density] = self.speeds;
        let position = (speed - first) * density;
        let below = position.clamped_floor(LatticeIndex::new((gains.len() as u32).saturating_sub(2)));
        let part = (position - below.number).larger(T::ZERO).smaller(T::ONE);
        // A single gain needs no interpolation.
        let part = if gains.len() > 1 { part } else { T::ZERO };
        Weights { below: below.count, of_each: [T::ONE - part, part] }
    }
}

/// Linear interpolation between two neighbouring gains.
struct Weights<T> {
    /// Index of the first of them.
    below: u32,
    /// Weight of the first and of the second.
    of_each: [T; 2],
}

impl<T: Scalar, const D: usize, const P: usize> SpeedGain<T, D, P> {
    /// Adds `weight` times the correction of this innovation of `probes` probes to the state.
    #[inline(always)]
    fn apply<const N: usize>(&self, state: &mut ObserverState<T, D, N>, weight: T, innovation: &[T; P], probes: usize) {
        let motion = &mut state.motion;
        let states = [&mut motion.q, &mut motion.velocity, &mut state.load, &mut state.rotating_load];
        for (to, gains) in states.into_iter().zip([&self.position, &self.rate, &self.load, &self.rotating_load]) {
            for (&e, gain) in innovation.iter().zip(gains).take(probes) {
                let e = weight * e;
                for (entry, &by) in to.iter_mut().zip(gain) {
                    *entry += by * e;
                }
            }
        }
    }

    /// Returns the normalised square `e^T S^-1 e` of an innovation of `probes` probes.
    #[inline(always)]
    fn normalised_square(&self, innovation: &[T; P], probes: usize) -> T {
        let mut square = T::ZERO;
        for row in self.whitening.iter().take(probes) {
            let white = row.iter().zip(innovation).take(probes).fold(T::ZERO, |sum, (&w, &e)| sum + w * e);
            square += white * white;
        }
        square
    }
}

/// Rotates the pairs `FX FY` and `MX MY`, and those of the elastic coordinates, by the angle with this sine and cosine.
#[inline(always)]
fn rotated<T: Scalar, const D: usize>(load: &[T; D], sin: T, cos: T) -> [T; D] {
    let mut out = *load;
    let rotate = |x: &mut T, y: &mut T| (*x, *y) = (cos * *x - sin * *y, cos * *y + sin * *x);
    if let [x, y, _, mx, my, elastic @ ..] = out.as_mut_slice() {
        rotate(x, y);
        rotate(mx, my);
        for pair in elastic.as_chunks_mut::<2>().0 {
            let [x, y] = pair;
            rotate(x, y);
        }
    }
    out
}
