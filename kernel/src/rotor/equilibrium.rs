//! Where the rotor rests: the static equilibrium of its constant load and its bearings.

use super::{Machine, solve};
use crate::bearing::Bearing;
use crate::frame::{Displacement, Stiffness};
use crate::math::Math;
use crate::rotation::Rotation;
use crate::scalar::Scalar;

/// The place found, and how well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equilibrium<T: Scalar> {
    /// Displacement of the centre of mass.
    pub q: Displacement<T>,
    /// Tangent stiffness of rotor springs and bearings there, at the centre of mass.
    pub stiffness: Stiffness<T>,
    /// Largest unbalanced entry (moments over the bearing span) over the load and what the elements carry; 0 is perfect.
    pub residual: T,
}

/// Iterations at most; the usual are 10 to 40. Set-up, not the hot path: it ends when nothing is left to balance.
const ITERATIONS: usize = 150;
/// How far a free rotor may go in the first iteration, m: the order of bearing clearances.
const FIRST_STEP: f64 = 2e-5;

/// Static equilibrium with the bearings turned as `at` says, from `start`.
///
/// Newton's method on `D q' = r(q)` taken implicitly with a step that grows as the residual falls: far off it is
/// a damped fall towards contact, where clearance leaves Newton's matrix singular; close by it is Newton's method.
/// A rotor that nothing holds in some direction keeps a residual: check it.
pub fn equilibrium<T: Scalar, M: Math<T>, B: Bearing<T>, const N: usize>(
    machine: &Machine<T, M, B, N>,
    at: &[Rotation<T>; N],
    start: Displacement<T>,
) -> Equilibrium<T> {
    let load = machine.rotor.constant_load();
    let span = machine.bearings.iter().fold(T::ZERO, |s, b| s + b.station.abs()) + T::from_f64(1e-3);
    let scale = load.to_array().into_iter().fold(T::ZERO, |s, f| s + f.abs()) + T::from_f64(1e-9);
    let weights = [T::ONE, T::ONE, T::ONE, T::ONE / span, T::ONE / span];
    let drag = scale / T::from_f64(FIRST_STEP);
    let size = |r: &[T; 5]| {
        r.iter().zip(weights).fold(T::ZERO, |m, (&x, w)| if (x * w).abs() > m { (x * w).abs() } else { m })
    };

    let mut q = start;
    let mut result = Equilibrium { q, stiffness: Stiffness::from_element(T::ZERO), residual: T::ONE };
    for iteration in 0..ITERATIONS {
        let (bearings, tangent) = machine.bearing_reaction_and_stiffness(&q, at);
        let zero = Displacement::default();
        let residual = load.plus(bearings.wrench).plus(machine.rotor.internal(&q, &zero, T::ZERO)).to_array();
        let stiffness = tangent + machine.rotor.effective((T::ZERO, T::ZERO), T::ZERO);
        let relative = size(&residual) / (scale + bearings.load);
        if relative < result.residual || iteration == 0 {
            result = Equilibrium { q, stiffness, residual: relative };
        }
        if relative < T::SETTLED * T::from_f64(1e-4) {
            break;
        }
        let mut matrix = stiffness;
        for (i, w) in weights.into_iter().enumerate() {
            // A trace of drag stays so that a direction that nothing holds stays where it is.
            matrix[(i, i)] += drag * (relative + T::from_f64(1e-12)) / (w * w);
        }
        let step = solve(matrix, residual);
        let mut next = q.to_array();
        for (x, dx) in next.iter_mut().zip(step) {
            *x += dx;
        }
        let next = Displacement::from_array(next);
        if next.is_finite() {
            q = next;
        }
    }
    result
}
