//! Sixteen balls of Harris' 218 bearing in equilibrium: solved, from where they were, looked up, and in plain C.

use super::yardstick::{self, States};
use super::{INPUTS, Subject, scattered};
use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry, InvalidParameter};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, OuterControlled, RaceControl};
use ballrace::bearing::quasi_static::{BallPosition, QuasiStatic};
use ballrace::bearing::tabulated::{Node, Table, TableDomain, Tabulated, fill_table};
use ballrace::bearing::{Bearing, BlockedPositions, ElementLayout, ElementPositions, evenly_spaced};
use ballrace::contact::hertz::Material;
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase};
use ballrace_twin::simd::{Dispatched, OnWideRegisters};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::hint::black_box;

/// From a cold start.
pub const COLD: &str = "quasi-static, inertia, N = 16: force, cold";
/// Few steps from where the balls were at the last sample.
pub const WARM: &str = "quasi-static, inertia, N = 16: force, 3 steps from the last sample";
/// As [`COLD`] on the registers that the program selects at run time.
pub const COLD_WIDE: &str = "quasi-static, inertia, N = 16: force, cold, widest registers";
/// As [`WARM`] on these registers.
pub const WARM_WIDE: &str = "quasi-static, inertia, N = 16: force, 3 steps from the last sample, widest registers";
/// From the table.
pub const LOOKED_UP: &str = "tabulated, N = 16: force";
/// As [`LOOKED_UP`] in the form of the program: positions in blocks, registers selected at run time.
pub const LOOKED_UP_WIDE: &str = "tabulated, N = 16: force, widest registers";
/// Six plain Newton steps in C.
pub const PLAIN_C: &str = "plain C, 6 Newton steps, N = 16: force, cold";

pub type Massive<M = Exact> = QuasiStatic<f64, M, ElementPositions<f64, 16>, OuterControlled<f64>>;
pub type LookedUp<P = ElementPositions<f64, 16>> = Tabulated<f64, Exact, P, Vec<Node<f64, 2>>, 2>;

pub const SPEED: f64 = 10_000.0 * TAU / 60.0;
const WARM_STEPS: u8 = 3;

pub fn solved<M: Math<f64>>() -> Result<Massive<M>, InvalidParameter> {
    let material = Material { youngs_modulus: 206.91e9, ..BEARING_STEEL };
    let geometry = BallBearingGeometry {
        ball_diameter: 22.23e-3,
        pitch_diameter: 125.26e-3,
        inner_conformity: 11.63 / 22.23,
        outer_conformity: 11.63 / 22.23,
        contact_angle: 40_f64.to_radians(),
        ball: material,
        race: material,
    };
    let inertia = InertiaParams {
        density: 7800.0,
        centrifugal: true,
        gyroscopic: true,
        race_control: RaceControl::Outer,
        friction_sharing: FrictionSharing::Outer,
    };
    QuasiStatic::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Touching)?
        .with_outer_control(&inertia)
}

pub fn looked_up<P: ElementLayout<f64>>(bearing: &Massive, positions: P) -> Result<LookedUp<P>, InvalidParameter> {
    let domain = TableDomain {
        approach: [-60e-6, 100e-6],
        scale: 50e-6,
        angle: [20_f64.to_radians(), 60_f64.to_radians()],
        speed: [0.2 * SPEED, 2.0 * SPEED],
        speed_scale: 10.0 * SPEED,
        speed_ratios: [1.0, 0.0],
        intervals: [32, 16, 32],
    };
    let grid = domain.grid(bearing.table_constants().distance)?;
    let mut nodes = vec![[0.0; 2]; grid.len()];
    fill_table(bearing, &domain, &grid, &mut nodes);
    Ok(Tabulated::new(positions, bearing.table_constants(), Table::new(grid, nodes), false))
}

/// About the equilibrium under 17.8 kN of thrust, with radial load and tilt.
fn poses() -> Vec<Displacement<f64>> {
    let pose = |i| {
        let [u, v] = [0.618, 0.414].map(|stride| 10e-6 * scattered(i, stride));
        let [thu, thv] = [0.236, 0.303].map(|stride| 1e-4 * scattered(i, stride));
        Displacement { u, v, w: 15e-6 + 5e-6 * scattered(i, 0.732), thu, thv }
    };
    (0..INPUTS).map(pose).collect()
}

fn each(row: &str, evaluate: impl Fn(&Displacement<f64>, &BearingKinematicState<f64>) + 'static) -> Subject {
    let (poses, at) = (poses(), BearingKinematicState { inner_speed: SPEED, ..BearingKinematicState::default() });
    let run = Box::new(move || {
        for u in &poses {
            evaluate(black_box(u), black_box(&at));
        }
    });
    Subject::new(row, super::COLUMNS[0], INPUTS, run)
}

/// All of them; without a C compiler the last one is left out.
pub fn all() -> Result<Vec<Subject>, InvalidParameter> {
    let bearing: Massive = solved()?;
    let wide: Massive<OnWideRegisters<Exact>> = solved()?;
    let places: ElementPositions<f64, 16> = evenly_spaced(Phase::ZERO);
    let table = looked_up(&bearing, places)?;
    let wide_table = Dispatched::new(looked_up(&bearing, BlockedPositions::<_, Vec<_>>::new(places))?);
    let mut subjects = vec![
        each(COLD, move |u, at| {
            black_box(bearing.reaction(u, at));
        }),
        each(COLD_WIDE, move |u, at| {
            black_box(wide.reaction(u, at));
        }),
        warm(WARM, bearing),
        warm(WARM_WIDE, wide),
        each(LOOKED_UP, move |u, at| {
            black_box(table.reaction(u, at));
        }),
        each(LOOKED_UP_WIDE, move |u, at| {
            black_box(wide_table.reaction(u, at));
        }),
    ];
    subjects.extend(plain_c());
    Ok(subjects)
}

/// A smooth path through the poses; each ball starts at its last position.
fn warm<M: Math<f64>>(row: &str, bearing: Massive<M>) -> Subject {
    let bearing = bearing.with_newton_steps(WARM_STEPS);
    let at = BearingKinematicState { inner_speed: SPEED, ..BearingKinematicState::default() };
    let mut balls = [BallPosition::default(); 16];
    let pose = |i: u32| {
        let angle = TAU * f64::from(i) / f64::from(INPUTS);
        Displacement { u: 8e-6 * angle.cos(), v: 8e-6 * angle.sin(), w: 15e-6, thu: 5e-5, thv: 0.0 }
    };
    let poses: Vec<_> = (0..INPUTS).map(pose).collect();
    bearing.initial_ball_positions(&pose(0), &at, &mut balls);
    let run = Box::new(move || {
        for u in &poses {
            black_box(bearing.warm_started_reaction(black_box(u), black_box(&at), &mut balls));
        }
    });
    Subject::new(row, super::COLUMNS[0], INPUTS, run)
}

fn plain_c() -> Option<Subject> {
    let mut input = format!("{INPUTS}\n");
    for Displacement { u, v, w, thu, thv } in poses() {
        writeln!(input, "{u:e} {v:e} {w:e} {thu:e} {thv:e}").ok()?;
    }
    yardstick::subject(PLAIN_C, "quasi_static", &[], States { input: &input, count: INPUTS, passes: 8 })
}
