//! Balls in equilibrium with their internal states.

use crate::handle::Shared;
use ballrace::bearing::quasi_static::film::Film;
use ballrace::bearing::quasi_static::inertia::Inertia;
use ballrace::bearing::quasi_static::{BallPosition, BallState, QuasiStatic};
use ballrace::bearing::surface::Surface;
use ballrace::bearing::{Bearing, ElementLayout, Mirrored, Reaction};
use ballrace::{BearingKinematicState, Displacement, Math, Scalar};

/// A quasi-static bearing with any of its effects, and its internal states.
pub trait Solved<T: Scalar>: Bearing<T> {
    /// Writes the state of each ball, up to the length of `states`.
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]);

    /// Sets the balls to the positions of a cold start.
    fn initial_ball_positions(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, balls: &mut [BallPosition<T>]);

    /// Returns the reaction, with the solution started from the balls' last positions.
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T>;
}

impl<T, M, P, I, F, S> Solved<T> for QuasiStatic<T, M, P, I, F, S>
where
    T: Scalar,
    M: Math<T>,
    P: ElementLayout<T>,
    I: Inertia<T>,
    F: Film<T>,
    S: Surface<T>,
{
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        QuasiStatic::ball_states(self, u, at, states);
    }
    fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        QuasiStatic::initial_ball_positions(self, u, at, balls);
    }
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        QuasiStatic::warm_started_reaction(self, u, at, balls)
    }
}

impl<T: Scalar> Solved<T> for Mirrored<Shared<dyn Solved<T>>> {
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        self.0.0.ball_states(&u.mirrored(), &at.reversed(), states);
        // Angles count towards +Z of the scene.
        for state in states {
            let turned = |[cos, sin]: [T; 2]| [cos, -sin];
            state.inner_direction = turned(state.inner_direction);
            state.outer_direction = turned(state.outer_direction);
            state.orbital_speed = -state.orbital_speed;
        }
    }
    fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        self.0.0.initial_ball_positions(&u.mirrored(), &at.reversed(), balls);
    }
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        let local = self.0.0.warm_started_reaction(&u.mirrored(), &at.reversed(), balls);
        Reaction { wrench: local.wrench.mirrored(), ..local }
    }
}
