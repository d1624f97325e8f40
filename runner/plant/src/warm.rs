//! Bearings in one machine: those without memory, and quasi-static ones whose solution starts from the last sample.

use ballrace::bearing::quasi_static::BallPosition;
use ballrace::bearing::{Bearing, Reaction};
use ballrace::{BearingKinematicState, Displacement, Status, Stiffness};
use ballrace_models::build::{AnyBearing, Solved};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most Newton steps of a warm start, which reach rounding errors from the last sample.
pub const WARM_STEPS: u8 = 3;

/// One model with two numbers of solver steps.
#[derive(Clone)]
pub(crate) struct ColdAndFew {
    /// With the steps of a cold start.
    pub cold: Arc<dyn Solved<f64>>,
    /// With [`WARM_STEPS`].
    pub few: Arc<dyn Solved<f64>>,
}

/// A bearing that starts each solution from the last three, for the consecutive samples of one twin. Its result differs from that
/// of a cold start by less than the residual of a converged ball. It makes a cold start where the warm start does not converge.
pub(crate) struct Warm {
    solved: ColdAndFew,
    offset: Displacement<f64>,
    /// Number of balls.
    elements: usize,
    balls: Mutex<BallHistory>,
}

/// A bearing in one machine. A copy goes on by itself from the same memory of earlier samples.
#[derive(Clone)]
pub(crate) enum Held {
    /// Without memory.
    Plain(AnyBearing<f64>),
    /// With its last solutions.
    Warm(Box<Warm>),
}

impl Bearing<f64> for Held {
    fn reaction(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Reaction<f64> {
        match self {
            Self::Plain(bearing) => bearing.reaction(u, at),
            Self::Warm(bearing) => bearing.reaction(u, at),
        }
    }

    fn reaction_and_stiffness(
        &self,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
    ) -> (Reaction<f64>, Stiffness<f64>) {
        match self {
            Self::Plain(bearing) => bearing.reaction_and_stiffness(u, at),
            Self::Warm(bearing) => bearing.reaction_and_stiffness(u, at),
        }
    }

    fn element_loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, loads: &mut [f64]) {
        match self {
            Self::Plain(bearing) => bearing.element_loads(u, at, loads),
            Self::Warm(bearing) => bearing.element_loads(u, at, loads),
        }
    }
}

/// Positions of the balls at the last sample, none before the first, and at the two samples before it.
#[derive(Clone, Default)]
struct BallHistory {
    last: Vec<BallPosition<f64>>,
    before: Vec<[BallPosition<f64>; 2]>,
}

impl Clone for Warm {
    fn clone(&self) -> Self {
        let Self { solved, offset, elements, .. } = self;
        let balls = Mutex::new(self.history().clone());
        Self { solved: solved.clone(), offset: *offset, elements: *elements, balls }
    }
}

impl Warm {
    /// Creates the bearing of one twin; `offset` is the displacement by preload.
    pub fn new(solved: ColdAndFew, offset: Displacement<f64>, elements: usize) -> Self {
        Self { solved, offset, elements, balls: Mutex::default() }
    }

    fn history(&self) -> MutexGuard<'_, BallHistory> {
        // A twin belongs to one thread; poisoned ball positions are a valid start.
        self.balls.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn start(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, balls: &mut BallHistory) -> Reaction<f64> {
        balls.last.resize(self.elements, BallPosition::default());
        self.solved.cold.initial_ball_positions(u, at, &mut balls.last);
        let found = self.solved.cold.warm_started_reaction(u, at, &mut balls.last);
        balls.before = balls.last.iter().map(|&last| [last; 2]).collect();
        found
    }
}

impl Bearing<f64> for Warm {
    fn reaction(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Reaction<f64> {
        let u = &(*u + self.offset);
        let mut balls = self.history();
        if balls.last.is_empty() {
            return self.start(u, at, &mut balls);
        }
        let BallHistory { last, before } = &mut *balls;
        for (last, before) in last.iter_mut().zip(before) {
            let [latest, earlier] = *before;
            (*last, *before) = (last.extrapolated([&latest, &earlier]), [*last, latest]);
        }
        let found = self.solved.few.warm_started_reaction(u, at, last);
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
