//! The quasi-static solver over a million states: every ball balanced or flagged, none without a number.

use ballrace::bearing::quasi_static::BallState;
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, RaceControl};
use ballrace::{Exact, Math, Scalar};
use ballrace_tests::states::{Random, State, random_state, solve};

/// Unbalanced force (over the 1e-12 N that count as nothing) over the largest load by the equations of `docs/src/models.md#quasi-static-bearing`, from what the solver says of the ball.
fn imbalance(state: &State, ball: &BallState<f64>) -> f64 {
    let friction = ball.gyroscopic_moment / state.geometry.ball_diameter;
    let (q_i, q_o) = (ball.inner_load, ball.outer_load);
    let [c_i, s_i] = ball.inner_direction;
    let [c_o, s_o] = ball.outer_direction;
    let sharing = state.inertia.map_or(FrictionSharing::Outer, |i| i.friction_sharing);
    let (inner, outer) = match sharing {
        FrictionSharing::Outer => (0.0, 2.0),
        FrictionSharing::Equal => (1.0, 1.0),
        FrictionSharing::Proportional => (2.0 * q_i / (q_i + q_o + 1e-12), 2.0 * q_o / (q_i + q_o + 1e-12)),
    };
    let radial = q_i * c_i - q_o * c_o + friction * (inner * s_i - outer * s_o) + ball.centrifugal;
    let axial = q_i * s_i - q_o * s_o - friction * (inner * c_i - outer * c_o);
    let largest = q_i.max(q_o).max(ball.centrifugal).max(friction.abs());
    (radial.hypot(axial) - 2e-12).max(0.0) / (largest + 1e-300)
}

fn to_f64<T: Scalar>(ball: &BallState<T>) -> BallState<f64> {
    BallState {
        inner_load: ball.inner_load.to_f64(),
        outer_load: ball.outer_load.to_f64(),
        inner_direction: ball.inner_direction.map(Scalar::to_f64),
        outer_direction: ball.outer_direction.map(Scalar::to_f64),
        inner_film: ball.inner_film.to_f64(),
        outer_film: ball.outer_film.to_f64(),
        centrifugal: ball.centrifugal.to_f64(),
        gyroscopic_moment: ball.gyroscopic_moment.to_f64(),
        orbital_speed: ball.orbital_speed.to_f64(),
        converged: ball.converged,
    }
}

/// Why a ball may be left without an equilibrium.
#[derive(Debug, Default)]
struct Flagged {
    /// The inner groove centre is (almost) on the wrong side of the outer one: no bearing stands like that.
    turned_over: u32,
    /// The friction of the gyroscopic moment is more than a third of the loads: no contact holds that.
    sliding: u32,
    /// Inner race control with a ball at the edge of the inner contact: the moment vanishes at once with the contact, and
    /// no state in between is balanced.
    edge: u32,
    /// Not converged in the steps given.
    slow: u32,
}

impl Flagged {
    fn count(&mut self, state: &State, ball: &BallState<f64>) {
        let distance = state.geometry.groove_distance();
        let radial = distance * state.geometry.contact_angle.cos() + state.displacement[0];
        let friction = 2.0 * ball.gyroscopic_moment.abs() / state.geometry.ball_diameter;
        let inner = state.inertia.is_some_and(|i| i.gyroscopic && i.race_control == RaceControl::Inner);
        if radial < 0.1 * distance || ball.inner_direction[0] < 0.1 || ball.outer_direction[0] < 0.1 {
            self.turned_over += 1;
        } else if friction > 0.3 * (ball.inner_load + ball.outer_load) {
            self.sliding += 1;
        } else if inner && ball.inner_load < 0.3 * ball.outer_load {
            self.edge += 1;
        } else {
            self.slow += 1;
        }
    }

    fn total(&self) -> u32 {
        self.turned_over + self.sliding + self.edge + self.slow
    }
}

fn run<T: Scalar>(states: u32, steps: u8, tolerance: f64) -> Flagged
where
    Exact: Math<T>,
{
    let mut random = Random(0x0123_4567_89ab_cdef);
    let mut flagged = Flagged::default();
    let mut residuals = Vec::with_capacity(states as usize);
    for i in 0..states {
        let state = random_state(&mut random);
        let ball = to_f64(&solve::<T>(&state, steps));
        let numbers = [ball.inner_load, ball.outer_load, ball.centrifugal, ball.gyroscopic_moment, ball.orbital_speed];
        let numbers = numbers.into_iter().chain(ball.inner_direction).chain(ball.outer_direction);
        assert!(numbers.clone().all(f64::is_finite), "state {i}: {state:?} {ball:?}");
        let residual = imbalance(&state, &ball);
        residuals.push(residual);
        if ball.converged {
            assert!(residual < tolerance, "state {i}: {residual:e} {state:?} {ball:?}");
        } else {
            flagged.count(&state, &ball);
        }
    }
    residuals.sort_by(f64::total_cmp);
    let part = |share: f64| residuals[(share * f64::from(states - 1)) as usize];
    let quantiles = [0.5, 0.75, 0.9].map(part);
    println!("{states} states, {steps} steps: {} flagged, {flagged:?}", flagged.total());
    println!(
        "  residual over largest load: median {:.1e}, 75 % {:.1e}, 90 % {:.1e}",
        quantiles[0], quantiles[1], quantiles[2]
    );
    flagged
}

/// Default number of cold steps of the kernel.
const STEPS: u8 = ballrace::bearing::quasi_static::DEFAULT_NEWTON_STEPS;
/// As many as the tests say.
const STATES: u32 = 1_000_000;

#[test]
fn a_million_balls_are_balanced_or_flagged_in_f64() {
    let flagged = run::<f64>(STATES, STEPS, 1.1e-9);
    assert!(flagged.total() < STATES / 100 * 8 && flagged.slow < STATES / 100 * 3, "{flagged:?}");
}

#[test]
fn a_million_balls_are_balanced_or_flagged_in_f32() {
    let flagged = run::<f32>(STATES, STEPS, 3e-4);
    assert!(flagged.total() < STATES / 100 * 8 && flagged.slow < STATES / 100 * 3, "{flagged:?}");
}

#[test]
fn more_steps_converge_more_balls() {
    let counts = [2, 4, 6, 8, 12, 24].map(|steps| run::<f64>(30_000, steps, 1.1e-9).total());
    assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
}
