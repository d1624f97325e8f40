//! A quasi-static bearing whose solution starts from the last sample.

use crate::scene::build::Solved;
use ballrace::bearing::quasi_static::BallPosition;
use ballrace::bearing::{Bearing, Reaction};
use ballrace::{BearingKinematicState, Displacement, Status, Stiffness};
use std::sync::{Arc, Mutex};

/// Newton steps of a warm start, which reach rounding errors from the last sample.
pub const WARM_STEPS: u8 = 3;

/// One model with two numbers of solver steps.
#[derive(Clone)]
pub struct ColdAndFew {
    /// With the steps of a cold start.
    pub cold: Arc<dyn Solved<f64>>,
    /// With [`WARM_STEPS`].
    pub few: Arc<dyn Solved<f64>>,
}

/// A bearing that starts each solution from the last one, for the consecutive samples of one twin. Its result differs from that
/// of a cold start by less than the residual of a converged ball. It makes a cold start where the warm start does not converge.
pub struct Warm {
    solved: ColdAndFew,
    offset: Displacement<f64>,
    balls: Mutex<Vec<BallPosition<f64>>>,
}

impl Warm {
    /// Creates the bearing of one twin; `offset` is the displacement by preload.
    pub fn new(solved: ColdAndFew, offset: Displacement<f64>) -> Self {
        Self { solved, offset, balls: Mutex::default() }
    }

    fn start(
        &self,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
        balls: &mut Vec<BallPosition<f64>>,
    ) -> Reaction<f64> {
        balls.resize(BALLS, BallPosition::default());
        self.solved.cold.initial_ball_positions(u, at, balls);
        self.solved.cold.warm_started_reaction(u, at, balls)
    }
}

/// Largest number of balls of a bearing in a scene.
const BALLS: usize = 64;

impl Bearing<f64> for Warm {
    fn reaction(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Reaction<f64> {
        let u = &(*u + self.offset);
        // A twin belongs to one thread; poisoned ball positions are a valid start.
        let mut balls = self.balls.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if balls.is_empty() {
            return self.start(u, at, &mut balls);
        }
        let found = self.solved.few.warm_started_reaction(u, at, &mut balls);
        if found.status.contains(Status::NOT_CONVERGED) { self.start(u, at, &mut balls) } else { found }
    }

    fn reaction_and_stiffness(
        &self,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
    ) -> (Reaction<f64>, Stiffness<f64>) {
        self.solved.cold.reaction_and_stiffness(&(*u + self.offset), at)
    }

    fn element_loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, loads: &mut [f64]) {
        self.solved.cold.element_loads(&(*u + self.offset), at, loads);
    }
}
