//! Counts against the table in `f64`.

use super::*;
use crate::bearing::angular::DisplacementDatum;
use crate::bearing::fixed_point::arithmetic::numbers;
use crate::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use crate::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use crate::bearing::quasi_static::{QuasiStatic, TableConstants};
use crate::bearing::tabulated::{self, Axis, Grid, Node, Table, TableDomain, fill_table};
use crate::bearing::{Bearing, ElementPositions, Mirrored, evenly_spaced};
use crate::frame::Displacement;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Exact;

const BALLS: usize = 9;
const INTERVALS: [usize; 3] = [16, 8, 2];
const LAYER: usize = (INTERVALS[0] + 3) * (INTERVALS[1] + 3);
const NODES: usize = LAYER * (INTERVALS[2] + 1);
const FIRST: f64 = 0.1;

type Float<const F: usize> = tabulated::Tabulated<f64, Exact, ElementPositions<f64, BALLS>, [Node<f64, F>; NODES], F>;
type Fixed<const F: usize> = Tabulated<BALLS, [[i32; F]; LAYER], F>;

fn geometry() -> BallBearingGeometry {
    BallBearingGeometry {
        ball_diameter: 7e-3,
        pitch_diameter: 38.5e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 25_f64.to_radians(),
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    }
}

/// A spindle bearing; with friction at both contacts where `F` is 3.
fn float<const F: usize>(mirrored: bool) -> Float<F> {
    let params = InertiaParams {
        density: 7800.0,
        centrifugal: true,
        gyroscopic: true,
        race_control: RaceControl::Outer,
        friction_sharing: if F > 2 { FrictionSharing::Proportional } else { FrictionSharing::Outer },
    };
    let domain = TableDomain {
        approach: [-30e-6, 30e-6],
        scale: 5e-6,
        angle: [0.02, 0.85],
        speed: [1000.0, 1500.0],
        speed_scale: 0.0,
        speed_ratios: [1.0, 0.0],
        intervals: INTERVALS,
    };
    let positions = evenly_spaced::<f64, BALLS>(Phase::from_revolutions(FIRST));
    let positions = if mirrored { positions.map(|position| position.mirrored()) } else { positions };
    let solved = QuasiStatic::<f64, Exact, _>::try_new(geometry(), positions, DisplacementDatum::Touching).unwrap();
    let solved = solved.with_inertia(&params).unwrap();
    let constants = solved.table_constants();
    let grid = domain.grid(constants.distance).unwrap();
    let mut nodes = [[0.0; F]; NODES];
    assert_eq!(fill_table(&solved, &domain, &grid, &mut nodes), 0);
    tabulated::Tabulated::new(positions, constants, Table::new(grid, nodes), false)
}

const PARAMS: TabulatedParams = TabulatedParams { speed: 1256.0, range: 1e-3, mirrored: false };

fn fixed<const F: usize>(of: &Float<F>, params: &TabulatedParams) -> Fixed<F> {
    Fixed::try_new(of, params, [[0; F]; LAYER]).unwrap()
}

/// Counts of a motion of `size` m at random, with all balls in contact, some or none.
fn motion(number: &mut impl FnMut() -> f64, size: f64, metres_per_count: f64) -> [i32; 5] {
    [1.0, 1.0, 3.0, 1.0, 1.0].map(|share| (share * size * (2.0 * number() - 1.0) / metres_per_count) as i32)
}

fn displacement(counts: [i32; 5], metres_per_count: f64, arm: f64) -> Displacement<f64> {
    let [u, v, w, x, y] = counts.map(|x| f64::from(x) * metres_per_count);
    Displacement { u, v, w, thu: x / arm, thv: y / arm }
}

/// Forces and moments over the lever arm, N.
fn numbers_of(found: &TabulatedReaction, newtons_per_count: f64) -> [f64; 5] {
    let TabulatedReaction { fx, fy, fz, mx, my, .. } = *found;
    [fx, fy, fz, mx, my].map(|x| f64::from(x) * newtons_per_count)
}

/// The force is that of the table in `f64` within 20 counts and a displacement by two units of 2^-29 of the range; both are outside the table at the
/// same displacements.
fn holds_the_table<const F: usize>(mirrored: bool, range: f64) {
    let params = TabulatedParams { mirrored, range, ..PARAMS };
    let of = float::<F>(mirrored);
    let fixed = fixed(&of, &params);
    let (mut number, newtons, metres, arm) =
        (numbers(), fixed.newtons_per_count(), fixed.metres_per_count(), fixed.arm());
    let (mut inside, mut lost) = (0, 0);
    for i in 0..10_000 {
        let size = 30e-6 * libm::pow(10.0, -3.0 * number());
        let counts = motion(&mut number, size, metres);
        let cage = Phase::from_revolutions(number());
        let u = displacement(counts, metres, arm);
        let at = BearingKinematicState { cage, inner_speed: params.speed, ..BearingKinematicState::default() };
        let (expected, k) =
            if mirrored { Mirrored(&of).reaction_and_stiffness(&u, &at) } else { of.reaction_and_stiffness(&u, &at) };
        let [u, v, w, x, y] = counts;
        let found = fixed.reaction(u, v, w, x, y, cage);
        let is_outside = expected.status.contains(Status::OUT_OF_TABLE);
        assert_eq!(found.status.contains(Status::OUT_OF_TABLE), is_outside, "{i}: {counts:?}");
        if is_outside {
            continue;
        }
        inside += 1;
        if found.status.contains(Status::CONTACT_LOST) {
            lost += 1;
            assert!(expected.load < 20.0 * newtons, "{i}: {counts:?}: {}", expected.load);
        }
        let stiffness = (0..3).map(|i| k[(i, i)]).fold(0.0, f64::max);
        let allowed = 20.0 * newtons + 2.0 * stiffness * 4.0 * metres;
        let wrench = &expected.wrench;
        let expected = [wrench.fx, wrench.fy, wrench.fz, wrench.mx / arm, wrench.my / arm];
        for (found, expected) in numbers_of(&found, newtons).into_iter().zip(expected) {
            assert!((found - expected).abs() < allowed, "{i}: {counts:?}: {found} {expected} +-{allowed}");
        }
    }
    assert!(inside > 3000 && lost > 10, "{inside} {lost}");
}

#[test]
fn the_force_is_that_of_the_table() {
    for range in [0.6e-3, 1e-3, 5e-3] {
        holds_the_table::<2>(false, range);
    }
    holds_the_table::<2>(true, 1e-3);
}

#[test]
fn friction_is_that_of_the_table() {
    holds_the_table::<3>(false, 1e-3);
    holds_the_table::<3>(true, 1e-3);
}

/// A count is below 4e-7 of the largest load of a ball in the table, for 16 balls or fewer.
#[test]
fn a_count_is_small() {
    let (of, mut ball) = (float::<2>(false), 0.0_f64);
    let at = BearingKinematicState { inner_speed: PARAMS.speed, ..BearingKinematicState::default() };
    for i in 0..200 {
        let u = Displacement { w: f64::from(i) * 0.5e-6, ..Displacement::default() };
        let found = of.reaction(&u, &at);
        if found.status == Status::OK {
            ball = ball.max(found.load / BALLS as f64);
        }
    }
    let count = fixed(&of, &PARAMS).newtons_per_count();
    assert!(count < 4e-7 * ball, "{count} {ball}");
}

/// No counts overflow; what is far outside is flagged, and no force is beyond that of all balls at the edge.
#[test]
fn any_counts_have_a_force() {
    let edges = [i32::MIN, i32::MIN + 1, -(1 << 27), -1, 0, 1, 1 << 24, i32::MAX];
    for (mirrored, range) in [(false, 1e-3), (true, 0.57e-3), (false, 28e-3)] {
        let of = float::<3>(mirrored);
        let fixed = fixed(&of, &TabulatedParams { mirrored, range, ..PARAMS });
        for (i, u) in edges.into_iter().enumerate() {
            for (j, v) in edges.into_iter().enumerate() {
                for w in edges {
                    for (x, y) in [(0, 0), (w, v), (i32::MAX, i32::MIN), (i32::MIN, i32::MIN)] {
                        let cage = Phase(((i + 3 * j) as u64) << 60);
                        let found = fixed.reaction(u, v, w, x, y, cage);
                        let all = [found.fx, found.fy, found.fz, found.mx, found.my].map(i32::unsigned_abs);
                        assert!(all.into_iter().max().unwrap() < 1_550_000_000, "{u} {v} {w} {x} {y}: {found:?}");
                        let far = [u, v, w].into_iter().any(|x| x.unsigned_abs() > 1 << 30);
                        assert!(!far || found.status.contains(Status::OUT_OF_TABLE), "{u} {v} {w} {x} {y}: {found:?}");
                    }
                }
            }
        }
    }
}

/// Nodes of a baked table in `f32` give the same force but for their rounding.
#[test]
fn a_table_in_f32_is_taken() {
    let of = float::<2>(false);
    let rounded = |node: Node<f64, 2>| node.map(|x| x as f32);
    let nodes: [Node<f32, 2>; NODES] = core::array::from_fn(|i| rounded(of.table().nodes()[i]));
    let positions = evenly_spaced::<f32, BALLS>(Phase::from_revolutions(FIRST));
    let table = Table::new(of.table().grid().rounded(), nodes);
    let baked = tabulated::Tabulated::<f32, Exact, _, _, 2>::new(positions, of.constants().rounded(), table, false);
    let (from_f32, from_f64) = (Fixed::<2>::try_new(&baked, &PARAMS, [[0; 2]; LAYER]).unwrap(), fixed(&of, &PARAMS));
    let mut number = numbers();
    for _ in 0..1000 {
        let [u, v, w, x, y] = motion(&mut number, 10e-6, from_f64.metres_per_count());
        let [found, expected] = [
            numbers_of(&from_f32.reaction(u, v, w, x, y, Phase::ZERO), from_f32.newtons_per_count()),
            numbers_of(&from_f64.reaction(u, v, w, x, y, Phase::ZERO), from_f64.newtons_per_count()),
        ];
        let size = expected.into_iter().map(f64::abs).fold(1.0, f64::max);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-5 * size + 2.0 * from_f64.newtons_per_count(), "{found} {expected}");
        }
    }
}

#[test]
fn impossible_parameters_are_rejected() {
    let of = float::<2>(false);
    for (params, name) in [
        (TabulatedParams { speed: 900.0, ..PARAMS }, "speed"),
        (TabulatedParams { speed: f64::NAN, ..PARAMS }, "speed"),
        (TabulatedParams { range: 0.5e-3, ..PARAMS }, "range"),
        (TabulatedParams { range: f64::INFINITY, ..PARAMS }, "range"),
    ] {
        assert_eq!(Fixed::<2>::try_new(&of, &params, [[0; 2]; LAYER]).unwrap_err().name, name);
    }
    let short = Tabulated::<BALLS, _, 2>::try_new(&of, &PARAMS, [[0; 2]; LAYER - 1]);
    assert_eq!(short.unwrap_err().name, "nodes");
    let fewer = Tabulated::<8, _, 2>::try_new(&of, &PARAMS, [[0; 2]; LAYER]);
    assert_eq!(fewer.unwrap_err().name, "elements");
    let constants = *of.constants();
    for (changed, name) in [
        (TableConstants { axis: [f64::NAN, 0.0], ..constants }, "axis"),
        (TableConstants { offset: 1e-3, ..constants }, "offset"),
        (TableConstants { arm: -1.0, ..constants }, "arm"),
        (TableConstants { distance: f64::NAN, ..constants }, "range"),
    ] {
        let changed = Float::<2>::new(evenly_spaced(Phase::ZERO), changed, *of.table(), false);
        assert_eq!(Fixed::<2>::try_new(&changed, &PARAMS, [[0; 2]; LAYER]).unwrap_err().name, name);
    }
    let (grid, nodes) = (*of.table().grid(), [[f64::NAN, 0.0]; NODES]);
    for (grid, nodes, name) in [
        (grid, nodes, "load"),
        (grid, [[1e9, 200.0]; NODES], "tangent"),
        (Grid { scale: f64::NAN, ..grid }, nodes, "approach"),
        (Grid { approach: Axis { count: usize::MAX, ..grid.approach }, ..grid }, nodes, "nodes"),
        (Grid { angle: Axis { range: [0.0, f64::INFINITY], ..grid.angle }, ..grid }, nodes, "angle"),
    ] {
        let changed = Float::<2>::new(evenly_spaced(Phase::ZERO), constants, Table::new(grid, nodes), false);
        assert_eq!(Fixed::<2>::try_new(&changed, &PARAMS, [[0; 2]; LAYER]).unwrap_err().name, name);
    }
}
