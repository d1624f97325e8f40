//! Where the rotor rests: the static equilibrium of its constant load and its bearings.

use super::vector::{add, all_finite, along};
use super::{ForceElement, RotorBearingSystem, SecondOrderSystem, solve};
use crate::frame::Displacement;
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// The position found, and how well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium<T: Scalar, const D: usize> {
    /// The coordinates: of a rigid rotor, the displacement of its centre of mass.
    pub q: [T; D],
    /// Tangent stiffness of the system and its bearings there.
    pub stiffness: SMatrix<T, D, D>,
    /// Largest unbalanced entry (moments over the radius of gyration) over the load and what the elements carry; 0 is
    /// perfect.
    pub residual: T,
}

impl<T: Scalar> Equilibrium<T, 5> {
    /// Displacement of a rigid rotor's centre of mass.
    pub fn displacement(&self) -> Displacement<T> {
        Displacement::from_array(self.q)
    }
}

/// Iterations at most; the usual are 10 to 40. Set-up, not the hot path: it ends when nothing is left to balance.
const ITERATIONS: usize = 150;
/// Iterations after which the drag fades whatever the residual does: a rotor on springs so soft that it rests far away.
const PATIENCE: usize = 40;
/// By how much it does, an iteration.
const FADING: f64 = 0.8;
/// How far a free rotor may go in the first iteration, m: the order of bearing clearances.
const FIRST_STEP: f64 = 2e-5;

/// Static equilibrium with the bearings turned as `at` says, from `start`.
///
/// Newton's method on `D q' = r(q)` taken implicitly with a step that grows as the residual falls: far off it is
/// a damped fall towards contact, where clearance leaves Newton's matrix singular; close by it is Newton's method. The
/// drag `D` is in proportion to the masses.
/// A rotor that nothing holds in some direction keeps a residual: check it.
pub fn equilibrium<T: Scalar, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize, const N: usize>(
    system: &RotorBearingSystem<R, C, N>,
    at: &[BearingKinematicState<T>; N],
    start: impl Into<[T; D]>,
) -> Equilibrium<T, D> {
    let load = system.rotor.constant_load();
    let mut shares = masses(&system.rotor);
    let heaviest = shares.iter().fold(T::ZERO, |most, &m| m.larger(most));
    shares = shares.map(|m| m / heaviest);
    // A force on a small share counts as the force on the whole mass that moves it as much.
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
            // A trace of drag stays so that a direction that nothing holds stays where it is.
            stiffness[(i, i)] += drag * (relative + T::from_f64(1e-12)) * share;
        }
        let next = along(&q, T::ONE, &solve(stiffness, residual));
        if all_finite(&next) {
            q = next;
        }
    }
    result
}

/// Diagonal of the mass matrix. A function of its own, as the next: the stack holds the whole matrix only while it runs.
#[inline(never)]
fn masses<T: Scalar, R: SecondOrderSystem<T, D>, const D: usize>(rotor: &R) -> [T; D] {
    let mass = rotor.effective_matrix([T::ONE, T::ZERO, T::ZERO], T::ZERO);
    let mut masses = [T::ZERO; D];
    for (i, entry) in masses.iter_mut().enumerate() {
        *entry = mass[(i, i)];
    }
    masses
}

/// Adds the stiffness of the system without its bearings.
#[inline(never)]
fn add_stiffness<T: Scalar, R: SecondOrderSystem<T, D>, const D: usize>(rotor: &R, stiffness: &mut SMatrix<T, D, D>) {
    *stiffness += rotor.effective_matrix([T::ZERO, T::ZERO, T::ONE], T::ZERO);
}
