//! Rollers by laminae: limits, potential, convergence, inertia, surfaces.

use ballrace::bearing::lumped::Radial;
use ballrace::bearing::roller::{
    Lamina, LaminaRoller, QuasiStaticRoller, RollerBearingParams, RollerInertia, RollerProfile, RollerState, laminae,
};
use ballrace::bearing::surface::{BearingComponent, Feature, Spall, SpallShape, SurfaceDeviation};
use ballrace::bearing::{Bearing, Mirrored, OpposedPairs, evenly_spaced, evenly_spaced_pairs};
use ballrace::contact::law::LineContactLaw;
use ballrace::contact::line::roller_stiffness;
use ballrace::{BearingKinematicState, Displacement, Exact, Phase, QuasiStaticRollerBearing, RollerBearing, Status};
use std::f64::consts::TAU;

const LENGTH: f64 = 12e-3;
const DIAMETER: f64 = 11e-3;
const PLAY: f64 = 4e-6;
const PROFILE: RollerProfile<'static> = RollerProfile::Logarithmic { coefficient: 0.000_35 * DIAMETER };
const N: usize = 13;

fn params(contact_angle: f64) -> RollerBearingParams {
    RollerBearingParams { pitch_diameter: 60e-3, contact_angle, radial_play: PLAY, stiffness: roller_stiffness(LENGTH) }
}

fn bearing<const K: usize>(contact_angle: f64, profile: &RollerProfile<'_>) -> RollerBearing<f64, N, K> {
    let positions = evenly_spaced(Phase::from_revolutions(0.03));
    LaminaRoller::try_new(&params(contact_angle), positions, laminae(LENGTH, profile).unwrap()).unwrap()
}

fn massive<const K: usize>(density: f64) -> QuasiStaticRollerBearing<f64, N, K> {
    let inertia = RollerInertia::of_cylinders(DIAMETER, LENGTH, 60e-3, density);
    QuasiStaticRoller::try_new(bearing(0.0, &PROFILE), &inertia).unwrap()
}

const STATES: [[f64; 5]; 4] = [
    [12e-6, 4e-6, 20e-6, 1e-4, -5e-5],
    [2e-6, 11e-6, 10e-6, 1.1e-3, -5e-4],
    [-15e-6, 9e-6, 40e-6, -2e-4, 3e-4],
    [25e-6, 0.0, -30e-6, 4e-4, 1e-3],
];

fn at(speed: f64, cage: f64) -> BearingKinematicState<f64> {
    BearingKinematicState { inner_speed: speed, ..Phase::from_revolutions(cage).into() }
}

/// Largest difference of two stiffnesses over the largest entry, moments by a lever arm of 20 mm; of the derivative and the tangent.
fn tangent_errors(bearing: &dyn Bearing<f64>, state: [f64; 5], at: &BearingKinematicState<f64>) -> [f64; 2] {
    let (reaction, k) = bearing.reaction_and_stiffness(&Displacement::from_array(state), at);
    assert_eq!(reaction, bearing.reaction(&Displacement::from_array(state), at));
    let arm = |i: usize| if i < 3 { 1.0 } else { 0.02 };
    let (mut largest, mut error, mut asymmetry) = (0.0_f64, 0.0_f64, 0.0_f64);
    for j in 0..5 {
        let step = if j < 3 { 1e-10 } else { 1e-8 };
        let moved = |sign: f64| {
            let mut u = state;
            u[j] += sign * step;
            bearing.reaction(&Displacement::from_array(u), at).wrench.to_array()
        };
        let (ahead, behind) = (moved(1.0), moved(-1.0));
        for i in 0..5 {
            let scale = arm(i) * arm(j);
            let difference = (behind[i] - ahead[i]) / (2.0 * step);
            largest = largest.max(k[(i, j)].abs() / scale);
            error = error.max((k[(i, j)] - difference).abs() / scale);
            asymmetry = asymmetry.max((k[(i, j)] - k[(j, i)]).abs() / scale);
        }
    }
    [error / largest, asymmetry / largest]
}

#[test]
fn straight_rollers_without_tilt_are_the_line_contact_of_the_lumped_model() {
    let positions = evenly_spaced::<f64, N>(Phase::from_revolutions(0.03));
    let law = LineContactLaw { stiffness: roller_stiffness(LENGTH) };
    let line = Radial::<f64, Exact, _, _>::try_new(positions, law, PLAY).unwrap();
    let sliced = bearing::<21>(0.0, &RollerProfile::Straight);
    for [u, v, ..] in STATES {
        let u = Displacement { u, v, ..Displacement::default() };
        let (a, ka) = sliced.reaction_and_stiffness(&u, &at(0.0, 0.1));
        let (b, kb) = line.reaction_and_stiffness(&u, &at(0.0, 0.1));
        assert!((a.load / b.load - 1.0).abs() < 1e-14);
        assert!(
            (a.wrench.fx - b.wrench.fx).abs() < 1e-14 * b.load && (a.wrench.fy - b.wrench.fy).abs() < 1e-14 * b.load
        );
        assert!(a.wrench.mx.abs() < 1e-14 * b.load && a.wrench.fz == 0.0);
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((ka[(i, j)] - kb[(i, j)]).abs() < 1e-13 * kb[(0, 0)].max(kb[(1, 1)]));
        }
    }
}

#[test]
fn the_force_has_a_potential() {
    for state in STATES {
        for cage in [0.0, 0.2, 0.6] {
            let [error, asymmetry] = tangent_errors(&bearing::<21>(0.3, &PROFILE), state, &at(0.0, cage));
            assert!(error < 2e-5 && asymmetry < 1e-14, "series: {error:e} {asymmetry:e}");
            let [error, asymmetry] = tangent_errors(&massive::<21>(7800.0), state, &at(900.0, cage));
            assert!(error < 2e-5 && asymmetry < 1e-12, "equilibrium: {error:e} {asymmetry:e}");
        }
    }
}

/// The work round a closed path of displacements is 0.
#[test]
fn no_work_is_done_round_a_closed_path() {
    let bearing = bearing::<15>(0.25, &PROFILE);
    let count = 2000;
    let position = |i: usize| {
        let s = TAU * i as f64 / count as f64;
        [15e-6 * s.cos(), 12e-6 * s.sin(), 10e-6 + 8e-6 * (2.0 * s).sin(), 4e-4 * (s + 0.4).cos(), 5e-4 * s.sin()]
    };
    let force = |i: usize| bearing.reaction(&Displacement::from_array(position(i)), &at(0.0, 0.0)).wrench.to_array();
    let (mut work, mut turnover) = (0.0, 0.0);
    for i in 0..count {
        let [a, b] = [i, i + 1].map(|i| (position(i), force(i)));
        for axis in 0..5 {
            let part = 0.5 * (a.1[axis] + b.1[axis]) * (b.0[axis] - a.0[axis]);
            work += part;
            turnover += part.abs();
        }
    }
    assert!(work.abs() < 1e-6 * turnover, "{work:e} of {turnover:e}");
}

#[test]
fn more_laminae_converge() {
    let force = |bearing: &dyn Bearing<f64>| {
        bearing.reaction(&Displacement::from_array(STATES[3]), &at(0.0, 0.0)).wrench.to_array()
    };
    let exact = force(&bearing::<2001>(0.2, &PROFILE));
    let error = |found: [f64; 5]| {
        let largest = exact.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        found.iter().zip(exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
    };
    let [few, more, many] = [
        error(force(&bearing::<11>(0.2, &PROFILE))),
        error(force(&bearing::<31>(0.2, &PROFILE))),
        error(force(&bearing::<101>(0.2, &PROFILE))),
    ];
    println!("11 laminae {few:e}, 31 {more:e}, 101 {many:e}");
    assert!(few < 1e-2 && more < few / 3.0 && many < more / 3.0, "{few:e} {more:e} {many:e}");
}

#[test]
fn without_speed_rollers_in_equilibrium_are_in_series() {
    let (series, solved) = (bearing::<21>(0.0, &PROFILE), massive::<21>(7800.0));
    for state in STATES {
        let u = Displacement::from_array(state);
        let (a, b) = (series.reaction(&u, &at(0.0, 0.1)), solved.reaction(&u, &at(0.0, 0.1)));
        assert_eq!(b.status, Status::OK);
        for (x, y) in a.wrench.to_array().into_iter().zip(b.wrench.to_array()) {
            assert!((x - y).abs() < 1e-12 * a.load, "{a:?} {b:?}");
        }
    }
}

#[test]
fn an_unloaded_roller_lies_on_the_outer_race_with_its_centrifugal_force() {
    let bearing = massive::<21>(7800.0);
    let mut states = [RollerState::default(); N];
    bearing.roller_states(&Displacement { u: 10e-6, ..Displacement::default() }, &at(900.0, 0.0), &mut states);
    let mass = 7800.0 * std::f64::consts::FRAC_PI_4 * DIAMETER * DIAMETER * LENGTH;
    let cage = 450.0 * (1.0 - DIAMETER / 60e-3);
    let force = mass * 30e-3 * cage * cage;
    let free = states.iter().filter(|state| state.inner.load == 0.0).count();
    assert!((3..N).contains(&free), "{free}");
    for state in states {
        assert!((state.outer.load - state.inner.load - force).abs() < 1e-11 * state.outer.load, "{state:?}");
        assert!(state.inner.load > 0.0 || state.tilt.abs() < 1e-12);
    }
}

#[test]
fn pairs_mirror_and_damage() {
    let slices: [Lamina<f64>; 11] = laminae(LENGTH, &PROFILE).unwrap();
    let pairs: OpposedPairs<f64, 5> = evenly_spaced_pairs(Phase::ZERO);
    let paired = LaminaRoller::<f64, Exact, _, _>::try_new(&params(0.2), pairs, slices).unwrap();
    let positions = evenly_spaced::<f64, 10>(Phase::ZERO);
    let single = LaminaRoller::<f64, Exact, _, _>::try_new(&params(0.2), positions, slices).unwrap();
    let mirrored = LaminaRoller::<f64, Exact, _, _>::try_new(&params(0.2), positions.map(|p| p.mirrored()), slices);
    let mirrored = Mirrored(mirrored.unwrap());
    let spall = Spall::new(BearingComponent::Outer, Phase::ZERO, 0.1, 3e-6, SpallShape::Rectangular);
    let damaged = single.with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Spall(spall)]));
    for state in STATES {
        let u = Displacement::from_array(state);
        let [a, b] = [paired.reaction(&u, &at(0.0, 0.1)), single.reaction(&u, &at(0.0, 0.1))];
        let close = |x: f64, y: f64| (x - y).abs() < 1e-12 * b.load;
        assert!(a.wrench.to_array().into_iter().zip(b.wrench.to_array()).all(|(x, y)| close(x, y)));
        // The mirrored bearing carries thrust to -Z.
        let turned = mirrored.reaction(&u.mirrored(), &at(0.0, 0.1).reversed()).wrench.mirrored();
        assert!(turned.to_array().into_iter().zip(b.wrench.to_array()).all(|(x, y)| close(x, y)));
        // Over the spall the roller at azimuth 0 loses 3 um of approach, elsewhere nothing changes.
        let mut loads = [[0.0; 10]; 2];
        let [with, without] = &mut loads;
        damaged.element_loads(&u, &at(0.0, 0.0), with);
        single.element_loads(&u, &at(0.0, 0.0), without);
        assert_eq!(with[1..], without[1..]);
        assert!(with[0] < without[0] || without[0] == 0.0);
    }
}

#[test]
fn parameters_outside_their_range_are_named() {
    let name = |params: &RollerBearingParams| {
        let slices: [Lamina<f64>; 3] = laminae(LENGTH, &PROFILE).unwrap();
        LaminaRoller::<f64, Exact, _, _>::try_new(params, evenly_spaced::<f64, 3>(Phase::ZERO), slices)
            .map(|_| ())
            .unwrap_err()
            .name
    };
    assert_eq!(name(&RollerBearingParams { stiffness: 0.0, ..params(0.0) }), "stiffness");
    assert_eq!(name(&RollerBearingParams { radial_play: f64::NAN, ..params(0.0) }), "radial_play");
    assert_eq!(name(&params(2.0)), "contact_angle");
    assert_eq!(Lamina::<f64>::try_new(0.0, &PROFILE, 0, 3).unwrap_err().name, "roller_length");
    assert_eq!(Lamina::<f64>::try_new(1.0, &RollerProfile::Drops(&[-1.0]), 0, 3).unwrap_err().name, "profile");
    let tapered = bearing::<3>(0.1, &PROFILE);
    assert!(QuasiStaticRoller::try_new(tapered, &RollerInertia { mass: 0.0, cage_speed: [0.0; 2] }).is_err());
}
