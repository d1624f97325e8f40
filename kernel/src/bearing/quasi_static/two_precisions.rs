//! Forces by a solution in `f32` and one evaluation in `f64`, on processors that compute twice as many balls side by side in
//! `f32`.
//!
//! Newton's method in `f32` ends within the rounding errors of that precision. There the unbalanced force is computed in `f64`; the
//! matrix of the last step, in `f32`, gives the displacement that balances it and the change of the forces with it. Both are so
//! small that the errors of first order and of the matrix are below those of a solution in `f64`. Where a ball is not that
//! close to its equilibrium, its group is solved in `f64` from the beginning.

use super::QuasiStatic;
use super::ball::{Ball, BallConstants, BallInput, Position};
use super::elements::{BallPosition, InnerForces, InnerSum, Rims, gather, scatter, scatter_finite};
use super::film::{Dry, Film};
use super::inertia::Inertia;
use super::solver::{Iteration, NewtonMatrix, Solution};
use super::tangent::GrooveForceSlopes;
use crate::bearing::Reaction;
use crate::bearing::element_position::{ElementLayout, padded_groups};
use crate::bearing::surface::Surface;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Plane};
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Ratio of unbalanced force to largest load in `f32` after which the next step is the last.
const NEAR_IN_SINGLE: f64 = 3e-5;
/// Ratio of unbalanced force to largest load in `f64` below which the correction of first order is enough: its error is about the
/// product of both ratios, 1e-10 of the load of the ball.
const FIRST_ORDER: f64 = 3e-6;
/// Most evaluations in `f64`: each reduces the unbalanced force by the ratio of the one in `f32`.
const MAX_EVALUATIONS: usize = 2;
/// Gap to the inner race, over the distance of the groove centres, that `f32` does not resolve.
const UNRESOLVED_GAP: f64 = 2e-6;

/// Solution of `K` balls in `f32`.
struct Approximation<const K: usize> {
    at: Position<Lanes<f32, K>>,
    rolling: Lanes<f32, K>,
    matrix: NewtonMatrix<f32, K>,
    slopes: GrooveForceSlopes<Lanes<f32, K>>,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, I: Inertia<T>, F: Film<T>, S: Surface<T>>
    QuasiStatic<T, M, P, I, F, S>
{
    /// True where two precisions are faster than one.
    pub(super) fn has_two_precisions(&self) -> bool {
        M::STOPS_EARLY && size_of::<T>() > size_of::<f32>() && !self.ball.film.is_present()
    }

    /// Computes the reaction on the inner ring in the cage frame, see [`Self::reaction_of_groups`].
    ///
    /// A chain of dependent operations determines the time of a group: 16 balls take hardly longer than 8.
    #[inline(always)]
    pub(super) fn reaction_by_two_precisions(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        balls: Option<&mut [BallPosition<T>]>,
        loads: &mut [T],
    ) -> Reaction<T> {
        if self.positions.all().nth(8).is_some() {
            self.reaction_of_groups::<16>(rims, at, balls, loads)
        } else {
            self.reaction_of_groups::<8>(rims, at, balls, loads)
        }
    }

    /// Computes the reaction on the inner ring in the cage frame: `K` balls side by side, from their last positions where there
    /// are any, which are updated. Also writes the loads on the inner race, as many as `loads` takes.
    #[inline(always)]
    fn reaction_of_groups<const K: usize>(
        &self,
        rims: &Rims<T>,
        at: &BearingKinematicState<T>,
        balls: Option<&mut [BallPosition<T>]>,
        loads: &mut [T],
    ) -> Reaction<T> {
        let (mut sum, mut loads) = (InnerSum::new(), loads.iter_mut());
        let single = self.ball.single();
        let zero = Lanes::splat(T::ZERO);
        let mut input = BallInput {
            grooves: Plane { r: zero, z: zero },
            inner_deviation: zero,
            outer_deviation: zero,
            speeds: *at,
            rolling: zero,
        };
        let at_start =
            Position { centre: input.grooves, outer_deflection: zero, inner_deflection: zero, inner_closing: zero };
        let is_warm = balls.is_some();
        let mut groups = balls.map(|balls| balls.chunks_mut(K));
        let mut approximation = Approximation::new();
        let mut found = Found { forces: InnerForces::new(), at: at_start };
        for group in padded_groups::<T, P, K>(&self.positions) {
            let balls = groups.as_mut().and_then(Iterator::next).unwrap_or_default();
            M::on_registers(
                #[inline(always)]
                || {
                    input = self.ball_input(&group.positions, rims, at);
                    if is_warm {
                        found.at = gather(balls);
                    }
                },
            );
            let start = is_warm.then_some(&found.at);
            let is_near = single.approximate(&input, start, self.newton_steps, &mut approximation)
                && self.ball.correct(&input, &approximation, &mut found);
            if is_near {
                scatter_finite(&found.at, balls);
            } else {
                let start = is_warm.then(|| gather(balls));
                self.ball.solve_in_one_precision(&mut input, start.as_ref(), self.newton_steps, &mut found);
                scatter(&found.at, balls);
            }
            let positions = group.without_padding();
            sum.add(positions, &found.forces);
            found.forces.write_loads(positions, &mut loads);
        }
        sum.finish(self.inner_arm)
    }
}

/// Forces and positions of `K` balls.
struct Found<T, const K: usize> {
    forces: InnerForces<T, K>,
    at: Position<Lanes<T, K>>,
}

impl<const K: usize> Approximation<K> {
    fn new() -> Self {
        let zero = Lanes::splat(0.0);
        let centre = Plane { r: zero, z: zero };
        Self {
            at: Position { centre, outer_deflection: zero, inner_deflection: zero, inner_closing: zero },
            rolling: zero,
            matrix: NewtonMatrix::zero(),
            slopes: GrooveForceSlopes::zero(),
        }
    }
}

impl<T: Scalar, M: Math<T>, I: Inertia<T>, F: Film<T>> Ball<T, M, I, F> {
    /// Returns the balls without film in `f32`.
    #[inline(always)]
    fn single(&self) -> Ball<f32, M::Single, I::Single, Dry> {
        let c = &self.constants;
        let constants = BallConstants {
            inner_stiffness: c.inner_stiffness.to_f32(),
            outer_stiffness: c.outer_stiffness.to_f32(),
            inner_length: c.inner_length.to_f32(),
            outer_length: c.outer_length.to_f32(),
            axis: Plane { r: c.axis.r.to_f32(), z: c.axis.z.to_f32() },
            ratio: c.ratio.to_f32(),
            inner_couple: c.inner_couple.to_f32(),
            outer_couple: c.outer_couple.to_f32(),
            distance: c.distance.to_f32(),
            series: c.series.to_f32(),
            outer_share: c.outer_share.to_f32(),
            max_step: c.max_step.to_f32(),
            min_length: c.min_length.to_f32(),
        };
        Ball { constants, inertia: self.inertia.single(), film: Dry, math: PhantomData }
    }

    /// Evaluates the forces near the equilibrium and corrects them to it; returns false if a ball is not close enough.
    #[inline(never)]
    fn correct<const K: usize>(
        &self,
        input: &BallInput<T, K>,
        near: &Approximation<K>,
        found: &mut Found<T, K>,
    ) -> bool {
        M::on_registers(
            #[inline(always)]
            || {
                let input = BallInput { rolling: Lanes::from_single(near.rolling), ..*input };
                found.at = Position {
                    centre: Plane::from_single(near.at.centre),
                    outer_deflection: Lanes::from_single(near.at.outer_deflection),
                    inner_deflection: Lanes::from_single(near.at.inner_deflection),
                    inner_closing: Lanes::from_single(near.at.inner_closing),
                };
                for _ in 0..MAX_EVALUATIONS {
                    let at = found.at;
                    let balance = self.balance(&input, &at);
                    let balanced = balance.is_converged(T::EQUILIBRIUM_TOLERANCE);
                    let converged =
                        balance.is_converged(T::from_f64(FIRST_ORDER)).and(near.matrix.is_derivative.or(balanced));
                    let moved = near.matrix.solve(balance.residual.single());
                    let solution = Solution {
                        at: Position { centre: at.centre.plus(Plane::from_single(moved)), ..at },
                        balance,
                        converged,
                    };
                    found.at = solution.position();
                    if converged.all() {
                        found.forces = self.inner_forces(&solution);
                        let change = near.slopes.with_centre(moved);
                        let contact = &mut found.forces.contact;
                        contact.radial = contact.radial + Lanes::from_single(change.radial);
                        contact.axial = contact.axial + Lanes::from_single(change.axial);
                        contact.tilting = contact.tilting + Lanes::from_single(change.tilting);
                        contact.load = (contact.load + Lanes::from_single(change.load)).larger(Lanes::splat(T::ZERO));
                        return true;
                    }
                }
                false
            },
        )
    }

    /// Solves in `T`.
    #[cold]
    #[inline(never)]
    fn solve_in_one_precision<const K: usize>(
        &self,
        input: &mut BallInput<T, K>,
        start: Option<&Position<Lanes<T, K>>>,
        steps: u8,
        found: &mut Found<T, K>,
    ) {
        let solution = if let Some(start) = start {
            self.iterate(&input.with_rolling(self.inner_approach(input, start)), start, steps)
        } else {
            self.solve(input, steps)
        };
        *found = Found { forces: self.inner_forces(&solution), at: solution.position() };
    }
}

impl<M: Math<f32>, I: Inertia<f32>> Ball<f32, M, I, Dry> {
    /// Solves in `f32`; returns false if a ball does not come near its equilibrium or if it is not certain that it touches the inner race.
    #[inline(never)]
    fn approximate<T: Scalar, const K: usize>(
        &self,
        input: &BallInput<T, K>,
        start: Option<&Position<Lanes<T, K>>>,
        steps: u8,
        near: &mut Approximation<K>,
    ) -> bool {
        let mut input = BallInput {
            grooves: input.grooves.single(),
            inner_deviation: input.inner_deviation.single(),
            outer_deviation: input.outer_deviation.single(),
            speeds: input.speeds.single(),
            rolling: Lanes::splat(1.0),
        };
        let mut state = Iteration::from(near.at);
        let is_certain = M::on_registers(
            #[inline(always)]
            || {
                let gap;
                if let Some(start) = start {
                    state.at = Position {
                        centre: start.centre.single(),
                        outer_deflection: start.outer_deflection.single(),
                        inner_deflection: start.inner_deflection.single(),
                        inner_closing: input.rolling,
                    };
                    gap = self.inner_approach(&input, &state.at);
                    input = input.with_rolling(gap);
                    state.at.inner_closing = input.rolling;
                } else {
                    let guess = self.initial_guess(&mut input);
                    (state.at, gap) = (guess.at, guess.gap);
                }
                let unresolved = Lanes::splat_f64(UNRESOLVED_GAP) * Lanes::splat(self.constants.distance);
                unresolved.less_than(gap.abs()).all()
            },
        );
        if !is_certain {
            return false;
        }
        near.rolling = input.rolling;
        for _ in 0..steps {
            let is_near = M::on_registers(
                #[inline(always)]
                || {
                    let balance = self.balance(&input, &state.at);
                    let matrix = self.advance(&input, &mut state, &balance);
                    let is_near = balance.is_converged(NEAR_IN_SINGLE as f32).all();
                    if is_near {
                        (near.matrix, near.slopes) = (matrix, self.groove_force_slopes(&balance));
                    }
                    is_near
                },
            );
            if is_near {
                near.at = state.at;
                return true;
            }
        }
        false
    }
}
