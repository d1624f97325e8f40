//! Static equilibrium of a rotor under its constant load on its bearings.

use super::vector::{add, all_finite, along};
use super::{ForceElement, RotorBearingSystem, SecondOrderSystem, solve};
use crate::frame::Displacement;
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// Result of [`equilibrium`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium<T: Scalar, const D: usize> {
    /// Coordinates: for a rigid rotor, the displacement of its centre of mass.
    pub q: [T; D],
    /// Tangent stiffness of rotor and bearings at `q`.
    pub stiffness: SMatrix<T, D, D>,
    /// Largest unbalanced entry (moments divided by the radius of gyration) relative to the load and the element loads; 0
    /// is exact.
    pub residual: T,
}

impl<T: Scalar> Equilibrium<T, 5> {
    /// Returns the displacement of the centre of mass of a rigid rotor.
    pub fn displacement(&self) -> Displacement<T> {
        Displacement::from_array(self.q)
    }
}

/// Largest number of iterations; 10 to 40 are usual.
const ITERATIONS: usize = 150;
/// Iterations after which the drag decreases independently of the residual, for rotors on soft springs with a distant
/// equilibrium.
const PATIENCE: usize = 40;
/// Factor of this decrease per iteration.
const FADING: f64 = 0.8;
/// Largest first step of a free rotor, m: the order of bearing clearances.
const FIRST_STEP: f64 = 2e-5;

/// Computes the static equilibrium with the bearings in the kinematic states `at`, from `start`.
///
/// Implicit pseudo-transient continuation: Newton's method on `D q' = r(q)` with a step that grows as the residual
/// decreases. Far from equilibrium it is a damped motion towards contact, where clearance makes the matrix of Newton's
/// method singular; near it, it is Newton's method. The drag `D` is proportional to the masses. A rotor without stiffness
/// in some direction keeps a residual, which the caller must check.
pub fn equilibrium<T: Scalar, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
    system: &RotorBearingSystem<R, C, N>,
    at: &[BearingKinematicState<T>; N],
    start: impl Into<[T; D]>,
) -> Equilibrium<T, D> {
    let load = system.rotor.constant_load();
    let mut shares = masses(&system.rotor);
    let heaviest = shares.iter().fold(T::ZERO, |most, &m| m.larger(most));
    shares = shares.map(|m| m / heaviest);
    // Weights by mass make forces that cause the same motion equal.
    let size = |r: &[T; D]| {
        r.iter().zip(&shares).fold(T::ZERO, |most, (&x, &share)| {
            let weight = T::ONE / T::from_f64(libm::sqrt(share.to_f64()));
            (x * weight).abs().larger(most)
        })
    };
    let scale = load.iter().fold(T::ZERO, |s, f| s + f.abs()) + T::from_f64(1e-9);
    let mut drag = scale / T::from_f64(FIRST_STEP);
    let mut q = start.into();
    let mut result = Equilibrium { q, stiffness: SMatrix::from_element(T::ZERO), residual: T::ONE };
    for iteration in 0..ITERATIONS {
        let mut stiffness = SMatrix::from_element(T::ZERO);
        let bearings = system.bearing_forces_adding_stiffness(&q, at, &mut stiffness);
        let mut residual = load;
        add(&mut residual, &bearings.force);
        add(&mut residual, &system.rotor.internal_force(&q, &[T::ZERO; D], T::ZERO));
        add_stiffness(&system.rotor, &mut stiffness);
        let relative = size(&residual) / (scale + bearings.load);
        if relative < result.residual || iteration == 0 {
            (result.q, result.residual) = (q, relative);
            result.stiffness.copy_from(&stiffness);
        }
        if relative < T::EQUILIBRIUM_TOLERANCE * T::from_f64(1e-4) {
            break;
        }
        if iteration > PATIENCE {
            drag *= T::from_f64(FADING);
        }
        for (i, &share) in shares.iter().enumerate() {
            // A minimum of drag fixes the rotor in directions without stiffness.
            stiffness[(i, i)] += drag * (relative + T::from_f64(1e-12)) * share;
        }
        let next = along(&q, T::ONE, &solve(stiffness, residual));
        if all_finite(&next) {
            q = next;
        }
    }
    result
}

/// Returns the diagonal of the mass matrix. Never inlined: the stack holds the matrix only during the call.
#[inline(never)]
fn masses<T: Scalar, R: SecondOrderSystem<T, D>, const D: usize>(rotor: &R) -> [T; D] {
    let mass = rotor.effective_matrix([T::ONE, T::ZERO, T::ZERO], T::ZERO);
    let mut masses = [T::ZERO; D];
    for (i, entry) in masses.iter_mut().enumerate() {
        *entry = mass[(i, i)];
    }
    masses
}

/// Adds the stiffness of the rotor without its bearings. Never inlined, as [`masses`].
#[inline(never)]
fn add_stiffness<T: Scalar, R: SecondOrderSystem<T, D>, const D: usize>(rotor: &R, stiffness: &mut SMatrix<T, D, D>) {
    *stiffness += rotor.effective_matrix([T::ZERO, T::ZERO, T::ONE], T::ZERO);
}
