//! The models whose balls are in equilibrium: solved, from where the balls were, and looked up.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use baked::bearings::{bearing_de, bearing_nde};
use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::quasi_static::film::Lubricant;
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace::bearing::quasi_static::{BallPosition, QuasiStatic};
use ballrace::bearing::tabulated::{Axis, Grid, Table, Tabulated};
use ballrace::bearing::{ElementPositions, LastValidWrench, evenly_spaced};
use ballrace::{Bearing, BearingKinematicState, Displacement, Exact, Phase, Stiffness, Wrench};
use core::hint::black_box;

type Plain = QuasiStatic<f32, Exact, ElementPositions<f32, 8>>;

/// Steps from where the balls were.
const WARM_STEPS: u8 = 3;

const STEEL: InertiaParams = InertiaParams {
    density: 7800.0,
    centrifugal: true,
    gyroscopic: true,
    race_control: RaceControl::Outer,
    friction_sharing: FrictionSharing::Outer,
};

/// The spindle bearing that the baked scene has too.
fn plain() -> Option<Plain> {
    let geometry = BallBearingGeometry {
        ball_diameter: 7e-3,
        pitch_diameter: 38.5e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 25_f64.to_radians(),
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    QuasiStatic::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Touching).ok()
}

/// The same bearing with centrifugal force and gyroscopic moment.
pub fn massive() -> Option<Massive> {
    plain()?.with_outer_control(&STEEL).ok()
}

fn turning(i: u32) -> (Displacement<f32>, BearingKinematicState<f32>) {
    let (u, cage) = input::<f32>(i);
    (
        u,
        BearingKinematicState {
            cage,
            inner: cage.wrapping_mul(2),
            inner_speed: 1256.0,
            ..BearingKinematicState::default()
        },
    )
}

#[inline(never)]
fn force<B: Bearing<f32>>(bearing: &B, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Wrench<f32> {
    bearing.reaction(u, at).wrench
}

#[inline(never)]
fn tangent<B: Bearing<f32>>(
    bearing: &B,
    u: &Displacement<f32>,
    at: &BearingKinematicState<f32>,
) -> (Wrench<f32>, Stiffness<f32>) {
    let (reaction, k) = bearing.reaction_and_stiffness(u, at);
    (reaction.wrench, k)
}

#[inline(never)]
fn sample<B: Bearing<f32>>(
    bearing: &B,
    held: &mut LastValidWrench<f32>,
    u: &Displacement<f32>,
    at: &BearingKinematicState<f32>,
) -> Wrench<f32> {
    bearing.sample(held, u, at).0
}

fn name(what: &'static str, elements: usize, function: &'static str) -> Name {
    Name { what, elements, precision: "f32", math: "exact", function }
}

fn bearing<B: Bearing<f32>>(bench: &Bench, what: &'static str, n: usize, bearing: B) {
    let bearing = black_box(bearing);
    bench.measure(name(what, n, "force"), force::<B> as *const (), turning, |(u, at)| force(&bearing, u, at));
}

/// Everything.
pub fn all(bench: &Bench) {
    let Some(plain) = plain() else { return };
    bearing(bench, "quasi-static, no effects", 8, plain);
    if let Ok(centrifugal) = plain.with_centrifugal(&STEEL) {
        bearing(bench, "quasi-static, centrifugal", 8, centrifugal);
    }
    if let Ok(general) = plain.with_inertia(&STEEL) {
        bearing(bench, "quasi-static, gyroscopic, any control", 8, general);
    }
    let Some(massive) = massive() else { return };
    bearing(bench, "quasi-static, gyroscopic", 8, massive);
    if let Ok(wet) = massive.with_film(Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 }) {
        bearing(bench, "quasi-static, gyroscopic, film", 8, wet);
    }
    from_where_the_balls_were(bench, massive.with_newton_steps(WARM_STEPS));
    tables(bench);
}

/// The tabulated ones.
pub fn tables(bench: &Bench) {
    let table = black_box(bearing_de::bearing());
    bearing(bench, "tabulated", 8, table);
    let mut held = LastValidWrench::new();
    bench.measure(
        name("tabulated", 8, "force, input checked"),
        sample::<bearing_de::Baked> as *const (),
        turning,
        |(u, at)| sample(&table, &mut held, u, at),
    );
    bench.measure(
        name("tabulated", 8, "force and tangent"),
        tangent::<bearing_de::Baked> as *const (),
        turning,
        |(u, at)| tangent(&table, u, at),
    );
    // By reference: each row follows a function of its own.
    let of_one_speed: &bearing_de::Baked = &of_one_speed(&table);
    bearing(bench, "tabulated, one speed", 8, of_one_speed);
    bearing(bench, "tabulated, friction, wave, spall, mirrored", 9, bearing_nde::bearing());
}

/// The bearing with the first layer of its table alone, as that of a machine at one speed.
fn of_one_speed(of: &bearing_de::Baked) -> bearing_de::Baked {
    let grid = of.table().grid();
    let layer = bearing_de::NODES.get(..grid.approach.count * grid.angle.count).unwrap_or_default();
    let grid = Grid { speed: Axis { count: 1, ..grid.speed }, ..*grid };
    Tabulated::new(bearing_de::POSITIONS, *of.constants(), Table::new(grid, layer), false)
}

pub type Massive =
    QuasiStatic<f32, Exact, ElementPositions<f32, 8>, ballrace::bearing::quasi_static::inertia::OuterControlled<f32>>;

#[inline(never)]
fn warm(
    bearing: &Massive,
    balls: &mut [BallPosition<f32>; 8],
    u: &Displacement<f32>,
    at: &BearingKinematicState<f32>,
) -> Wrench<f32> {
    bearing.warm_started_reaction(u, at, balls).wrench
}

fn from_where_the_balls_were(bench: &Bench, bearing: Massive) {
    let bearing = black_box(bearing);
    let mut balls = [BallPosition::default(); 8];
    bench.measure(
        name("quasi-static, gyroscopic", 8, "force, 3 steps from the last"),
        warm as *const (),
        turning,
        |(u, at)| warm(&bearing, &mut balls, u, at),
    );
}
