//! Tangent stiffness of the bearing: elimination of the balls by implicit differentiation, or in condensed form
//! (`docs/src/models.md#tangent-stiffness`).
//!
//! The balls follow the inner groove centre: with `J_o`, `J_i` the derivatives of the force on a ball through the two
//! contacts, `d(centre) = (J_o + J_i)^-1 J_i d(groove)`. The force on the ring is a function of the loads and angles of
//! both contacts; the chain rule gives its derivatives. Without inertia loads the result is the symmetric `S_i (S_i +
//! S_o)^-1 S_o`; race control makes it slightly asymmetric. The dependence of the film on the speed is neglected.

use super::QuasiStatic;
use super::ball::{Balance, Ball, Matrix};
use super::elements::{InnerSum, Rims};
use super::film::Film;
use super::inertia::Inertia;
use crate::bearing::Reaction;
use crate::bearing::element_position::{BLOCK_SIZE, ElementLayout};
use crate::bearing::ring::{CageRotation, Contact, ContactStiffness, ContactTangent, StiffnessSum, TangentSum};
use crate::bearing::surface::Surface;
use crate::frame::Stiffness;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Plane};
use crate::scalar::Scalar;

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, I: Inertia<T>, F: Film<T>, S: Surface<T>>
    QuasiStatic<T, M, P, I, F, S>
{
    /// Computes the reaction in the cage frame and its tangent in the fixed frame.
    #[inline(always)]
    pub(super) fn reaction_and_tangent(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let (mut sum, mut tangent) = (InnerSum::new(), TangentSum::new());
        self.solve_each(rims, at, |positions, solution| {
            sum.add(positions, &self.ball.inner_forces(solution));
            for (position, k) in positions.iter().zip(self.ball.tangents(&solution.balance)) {
                tangent.add(position, &k);
            }
        });
        (sum.finish(self.inner_arm), tangent.finish(self.inner_arm, turn))
    }

    /// Computes the condensed tangent `sum T_j^T S_i (S_i + S_o)^-1 S_o T_j` in the fixed frame, at constant inertia loads.
    #[inline(always)]
    pub(super) fn condensed_in_cage(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> Stiffness<T> {
        let mut sum = StiffnessSum::new();
        self.solve_each(rims, at, |positions, solution| {
            for (position, k) in positions.iter().zip(condensed(&solution.balance)) {
                sum.add(position, &k);
            }
        });
        sum.finish(self.inner_arm, T::ONE, turn)
    }
}

/// Returns `a^-1`, finite also for a singular matrix.
#[inline(always)]
fn inverse<T: Scalar, const K: usize>(a: Matrix<Lanes<T, K>>) -> Matrix<Lanes<T, K>> {
    let (determinant, trace) = (a.determinant(), a.trace());
    let smallest = Lanes::splat_f64(1e-12) * trace * trace;
    let size = determinant.abs().larger(smallest).xor_sign(determinant);
    a.adjugate().scaled(Lanes::splat(T::ONE) / size)
}

fn condensed<T: Scalar>(balance: &Balance<Lanes<T, BLOCK_SIZE>>) -> [ContactStiffness<T>; BLOCK_SIZE] {
    let s = balance.loaded_stiffnesses();
    let whole = balance.contact_stiffnesses();
    let k = s.inner.product(inverse(whole.outer.plus(whole.inner))).product(s.outer);
    let lane = |lanes: &Lanes<T, BLOCK_SIZE>, j: usize| lanes.0.get(j).copied().unwrap_or(T::ZERO);
    core::array::from_fn(|j| ContactStiffness {
        radial: lane(&k.rr, j),
        cross: T::HALF * (lane(&k.rz, j) + lane(&k.zr, j)),
        axial: lane(&k.zz, j),
    })
}

/// Derivatives of the force on the inner groove: `by_inner` by the displacement of the groove less that of the ball centre,
/// `by_outer` by that of the ball centre.
pub(super) struct GrooveForceSlopes<L> {
    by_inner: Matrix<L>,
    by_outer: Matrix<L>,
    /// The same of the couple, divided by the lever arm.
    couple_inner: Plane<L>,
    couple_outer: Plane<L>,
    /// Derivative of the load by the displacement of the groove less that of the ball centre.
    load_inner: Plane<L>,
}

impl<T: Scalar, const K: usize> GrooveForceSlopes<Lanes<T, K>> {
    pub(super) fn zero() -> Self {
        let (matrix, zero) = (Matrix::zero(), Lanes::splat(T::ZERO));
        let plane = Plane { r: zero, z: zero };
        Self { by_inner: matrix, by_outer: matrix, couple_inner: plane, couple_outer: plane, load_inner: plane }
    }
    /// Returns the change of the forces with a small displacement of the ball centres.
    #[inline(always)]
    pub(super) fn with_centre(&self, moved: Plane<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let force = self.by_outer.minus(self.by_inner).times(moved);
        let couple = self.couple_outer.minus(self.couple_inner).dot(moved);
        Contact { radial: force.r, axial: force.z, tilting: force.z + couple, load: -self.load_inner.dot(moved) }
    }
}

impl<T: Scalar, M: Math<T>, I: Inertia<T>, F: Film<T>> Ball<T, M, I, F> {
    /// Computes the derivatives of the force on the inner groove.
    #[inline(always)]
    pub(super) fn groove_force_slopes<const K: usize>(
        &self,
        balance: &Balance<Lanes<T, K>>,
    ) -> GrooveForceSlopes<Lanes<T, K>> {
        let (e_i, t_i) = (balance.inner.direction, balance.inner.direction.tangent());
        let (e_o, t_o) = (balance.outer.direction, balance.outer.direction.tangent());
        let loaded = balance.loaded_slopes();
        // Derivatives of loads and angles by the displacement of the ball centre (outer) and by groove less centre (inner).
        let load_i = e_i.times(loaded.1);
        let angle_i = t_i.times(balance.inner.inverse_length);
        let load_o = e_o.times(loaded.0);
        let angle_o = t_o.times(balance.outer.inverse_length);

        let mut by_inner = Matrix::outer(e_i, load_i).plus(Matrix::outer(t_i.times(balance.inner.load), angle_i));
        let zero = Lanes::splat(T::ZERO);
        let nothing = Plane { r: zero, z: zero };
        let mut by_outer = Matrix::outer(nothing, nothing);
        let (mut couple_inner, mut couple_outer) = (nothing, nothing);
        if self.inertia.effects().gyroscopic {
            let g = balance.inertia.friction;
            // Derivatives of the friction lambda_i M_g/D.
            let friction_inner =
                load_i.times(g.value * balance.share_by_inner).plus(angle_i.times(g.inner * balance.inner_share));
            let friction_outer =
                angle_o.times(g.outer * balance.inner_share).minus(load_o.times(g.value * balance.share_by_outer));
            let friction = g.value * balance.inner_share;
            by_inner =
                by_inner.minus(Matrix::outer(t_i, friction_inner)).plus(Matrix::outer(e_i.times(friction), angle_i));
            by_outer = by_outer.minus(Matrix::outer(t_i, friction_outer));
            let lever = Lanes::splat(self.constants.inner_couple);
            couple_inner = friction_inner.times(lever);
            couple_outer = friction_outer.times(lever);
        }
        GrooveForceSlopes { by_inner, by_outer, couple_inner, couple_outer, load_inner: load_i }
    }

    /// Computes the derivatives of the force on the inner groove (radial, axial, tilting) by its radial and axial
    /// displacement.
    fn tangents(&self, balance: &Balance<Lanes<T, BLOCK_SIZE>>) -> [ContactTangent<T>; BLOCK_SIZE] {
        let slopes = balance.slopes(self.inertia.effects());
        // d(centre)/d(groove)
        let follow = inverse(slopes.outer.plus(slopes.inner)).product(slopes.inner);
        let GrooveForceSlopes { by_inner, by_outer, couple_inner, couple_outer, .. } =
            self.groove_force_slopes(balance);
        // d/d(groove) = by_inner (1 - follow) + by_outer follow
        let force = by_inner.plus(by_outer.minus(by_inner).product(follow));
        let between = couple_outer.minus(couple_inner);
        let couple = couple_inner.plus(Plane {
            r: between.r * follow.rr + between.z * follow.zr,
            z: between.r * follow.rz + between.z * follow.zz,
        });
        contact_tangents(force, couple)
    }
}

/// Returns the derivatives of a force and of its couple, ball by ball.
#[inline(always)]
pub fn contact_tangents<T: Scalar, const K: usize>(
    force: Matrix<Lanes<T, K>>,
    couple: Plane<Lanes<T, K>>,
) -> [ContactTangent<T>; K] {
    let lane = |lanes: &Lanes<T, K>, j: usize| lanes.0.get(j).copied().unwrap_or(T::ZERO);
    core::array::from_fn(|j| ContactTangent {
        radial: [lane(&force.rr, j), lane(&force.rz, j)],
        axial: [lane(&force.zr, j), lane(&force.zz, j)],
        tilting: [lane(&force.zr, j) + lane(&couple.r, j), lane(&force.zz, j) + lane(&couple.z, j)],
    })
}
