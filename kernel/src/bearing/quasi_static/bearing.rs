//! [`crate::Bearing`] for the quasi-static model, and methods that only this model has.

use super::QuasiStatic;
use super::elements::{BallPosition, BallState, RingReactions};
use super::film::Film;
use super::inertia::Inertia;
use crate::bearing::element_position::ElementLayout;
use crate::bearing::elements::CageFrame;
use crate::bearing::ring::{CageRotation, from_cage_frame, to_cage_frame};
use crate::bearing::surface::Surface;
use crate::bearing::{Reaction, bearing_in_cage};
use crate::frame::{Displacement, Stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, I: Inertia<T>, F: Film<T>, S: Surface<T>> CageFrame<T>
    for QuasiStatic<T, M, P, I, F, S>
{
    #[inline(always)]
    fn cage_rotation(cage: Phase) -> CageRotation<T> {
        M::sin_cos(cage)
    }
    #[inline(always)]
    fn reaction_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.inner_reaction(&self.rims(u, None), at)
    }
    #[inline(always)]
    fn reaction_and_loads_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        loads: &mut [T],
    ) -> Reaction<T> {
        self.inner_reaction_and_loads(&self.rims(u, None), at, loads)
    }
    #[inline]
    fn reaction_and_stiffness_in_cage_frame(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        turn: CageRotation<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        self.reaction_and_tangent(&self.rims(u, None), at, turn)
    }
    /// Writes the loads on the inner race.
    #[inline]
    fn element_loads_in_cage_frame(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        let mut loads = loads.iter_mut();
        self.states(&self.rims(u, None), at, |state| {
            if let Some(load) = loads.next() {
                *load = state.inner_load;
            }
        });
    }
}

bearing_in_cage!(
    QuasiStatic<T, M, P, I, F, S>,
    T: Scalar, M: Math<T>, P: ElementLayout<T>, I: Inertia<T>, F: Film<T>, S: Surface<T>
);

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, I: Inertia<T>, F: Film<T>, S: Surface<T>>
    QuasiStatic<T, M, P, I, F, S>
{
    /// Computes the forces on both rings, each with its own displacement.
    ///
    /// The forces of a ball on the two rings add up to its centrifugal force `F_c e_r`.
    pub fn ring_reactions(
        &self,
        inner: &Displacement<T>,
        outer: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> RingReactions<T> {
        let turn = M::sin_cos(at.cage);
        let (inner, outer) = (to_cage_frame(inner, turn), to_cage_frame(outer, turn));
        let local = self.ring_reactions_in_cage(&inner, &outer, at);
        RingReactions {
            inner: Reaction { wrench: from_cage_frame(&local.inner.wrench, turn), ..local.inner },
            outer: from_cage_frame(&local.outer, turn),
        }
    }

    fn ring_reactions_in_cage(
        &self,
        inner: &Displacement<T>,
        outer: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> RingReactions<T> {
        self.both_reactions(&self.rims(inner, Some(outer)), at)
    }

    /// Writes the state of each ball in order, as many as `states` takes.
    pub fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        let mut states = states.iter_mut();
        self.states(&self.rims(&to_cage_frame(u, M::sin_cos(at.cage)), None), at, |state| {
            if let Some(position) = states.next() {
                *position = state;
            }
        });
    }

    /// Computes [`crate::Bearing::reaction`] starting from the ball positions of the last sample in `balls`, and updates
    /// them.
    ///
    /// A few Newton steps ([`QuasiStatic::with_newton_steps`]) then reach the accuracy of a cold start with many. The first
    /// positions come from [`QuasiStatic::initial_ball_positions`].
    pub fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        let turn = M::sin_cos(at.cage);
        let local = self.inner_reaction_from(&self.rims(&to_cage_frame(u, turn), None), at, balls);
        Reaction { wrench: from_cage_frame(&local.wrench, turn), ..local }
    }

    /// Writes the ball positions of a cold start.
    pub fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        self.initial_positions(&self.rims(&to_cage_frame(u, M::sin_cos(at.cage)), None), at, balls);
    }

    /// Computes the tangent at constant inertia loads: symmetric, with an error of 0.1 to 0.4 % at high speed
    /// (`docs/src/models.md#tangent-stiffness`).
    pub fn condensed_stiffness(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Stiffness<T> {
        let turn = M::sin_cos(at.cage);
        self.condensed_in_cage(&self.rims(&to_cage_frame(u, turn), None), at, turn)
    }
}
