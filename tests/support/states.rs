//! Random states of a ball in a bearing, over the whole range of the scene's geometry.

use ballrace::bearing::ElementPosition;
use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::quasi_static::film::Lubricant;
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace::bearing::quasi_static::{BallState, QuasiStatic};
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase, Scalar};
use std::f64::consts::{FRAC_PI_3, TAU};

/// A generator of numbers that are the same everywhere: Marsaglia's xorshift.
pub struct Random(pub u64);

impl Random {
    /// Evenly from 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / 9_007_199_254_740_992.0
    }

    /// Evenly from `a` to `b`.
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// From `a` to `b`, every order of magnitude alike.
    pub fn over_decades(&mut self, a: f64, b: f64) -> f64 {
        a * (b / a).powf(self.unit())
    }

    /// One of `choices`.
    pub fn one_of<C: Copy>(&mut self, choices: &[C]) -> C {
        choices[((self.unit() * choices.len() as f64) as usize).min(choices.len() - 1)]
    }
}

/// One ball, one displacement, one pair of speeds.
#[derive(Debug, Clone, Copy)]
pub struct State {
    /// Shape and material.
    pub geometry: BallBearingGeometry,
    /// Inertia of the ball, where it has any.
    pub inertia: Option<InertiaParams>,
    /// Oil, where there is any.
    pub oil: Option<Lubricant>,
    /// Radial and axial displacement of the inner groove centre, m.
    pub displacement: [f64; 2],
    /// rad/s.
    pub inner_speed: f64,
    /// rad/s.
    pub outer_speed: f64,
}

/// Contact angles 0 to 60 degrees, displacements up to the groove distance in any direction, dmN 0 to 3e6, either ring or
/// both turning, every race control and sharing, no film to a thick one.
pub fn random_state(random: &mut Random) -> State {
    let ball_diameter = random.over_decades(0.5e-3, 100e-3);
    let pitch_diameter = ball_diameter / random.between(0.05, 0.35);
    let geometry = BallBearingGeometry {
        ball_diameter,
        pitch_diameter,
        inner_conformity: random.between(0.505, 0.6),
        outer_conformity: random.between(0.505, 0.6),
        contact_angle: random.between(0.0, FRAC_PI_3),
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    let dmn = if random.unit() < 0.1 { 0.0 } else { random.between(0.0, 3e6) };
    let speed = dmn / (pitch_diameter * 1e3) * TAU / 60.0 * random.one_of(&[1.0, -1.0]);
    let (inner_speed, outer_speed) = match random.one_of(&[0, 1, 2, 2]) {
        0 => (0.0, speed),
        1 => (speed, -speed * random.unit()),
        _ => (speed, 0.0),
    };
    let inertia = InertiaParams {
        density: random.one_of(&[7800.0, 3200.0]),
        centrifugal: random.unit() < 0.8,
        gyroscopic: random.unit() < 0.7,
        race_control: random.one_of(&[RaceControl::Outer, RaceControl::Inner]),
        friction_sharing: random.one_of(&[
            FrictionSharing::Outer,
            FrictionSharing::Equal,
            FrictionSharing::Proportional,
        ]),
    };
    let oil = Lubricant { viscosity: random.over_decades(1e-3, 1.0), pressure_viscosity: random.between(1e-8, 3e-8) };
    let distance = geometry.groove_distance();
    let size = match random.one_of(&[0, 1, 2]) {
        0 => distance * random.unit(),
        1 => distance * random.over_decades(1e-6, 1.0),
        _ => distance * random.over_decades(1e-4, 0.1),
    };
    let direction = random.between(0.0, TAU);
    State {
        geometry,
        inertia: (inertia.centrifugal || inertia.gyroscopic).then_some(inertia),
        oil: (random.unit() < 0.5).then_some(oil),
        displacement: [size * direction.cos(), size * direction.sin()],
        inner_speed,
        outer_speed,
    }
}

/// What the kernel's solver makes of the state in `steps` Newton steps.
pub fn solve<T: Scalar>(state: &State, steps: u8) -> BallState<T>
where
    Exact: Math<T>,
{
    let places = [ElementPosition::<T>::from_azimuth(Phase::ZERO)];
    let bearing = QuasiStatic::<T, Exact, _>::try_new(state.geometry, places, DisplacementDatum::Touching).unwrap();
    let bearing = bearing.with_newton_steps(steps);
    let [u, w] = state.displacement.map(T::from_f64);
    let u = Displacement { u, w, ..Displacement::default() };
    let at = BearingKinematicState {
        inner_speed: T::from_f64(state.inner_speed),
        outer_speed: T::from_f64(state.outer_speed),
        ..BearingKinematicState::default()
    };
    let mut ball = [BallState::default()];
    match (state.inertia, state.oil) {
        (None, None) => bearing.ball_states(&u, &at, &mut ball),
        (None, Some(oil)) => bearing.with_film(oil).unwrap().ball_states(&u, &at, &mut ball),
        (Some(inertia), None) => bearing.with_inertia(&inertia).unwrap().ball_states(&u, &at, &mut ball),
        (Some(inertia), Some(oil)) => {
            bearing.with_inertia(&inertia).unwrap().with_film(oil).unwrap().ball_states(&u, &at, &mut ball);
        }
    }
    ball[0]
}
