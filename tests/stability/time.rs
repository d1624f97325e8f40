//! A long time, steps of any size, contact that comes and goes, a run taken up again.

use ballrace::bearing::angular::Angular;
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{ElementPositions, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::rotor::{
    BearingAtStation, Integrator, Newmark, RigidRotor, RotorBearingSystem, RotorParams, RotorState, RungeKuttaNystrom,
    ShaftMotion, SpeedRatios, Unbalance, Verlet, equilibrium,
};
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase, Scalar, Status, Stiffness};

const PARAMS: RotorParams = RotorParams {
    mass: 6.0,
    diametral_inertia: 0.030,
    polar_inertia: 0.0,
    damping: [[0.0; 5]; 5],
    stiffness: [0.0; 5],
    gravity: [0.0; 3],
    load: [0.0; 5],
};
/// Stiffness of both springs along X, N/m, and the natural frequency, rad/s.
const SPRING: f64 = 2e8;

fn still() -> ShaftMotion<f64> {
    ShaftMotion { angle: Phase::ZERO, speed: 0.0, acceleration: 0.0 }
}

type OnSprings = RotorBearingSystem<RigidRotor<f64, Exact>, BearingAtStation<f64, Linear<f64>>, 1>;

/// One spring at the centre of mass with the same stiffness in every direction.
fn on_springs(stiffness: f64) -> OnSprings {
    let bearing = Linear::new(Stiffness::from_diagonal_element(stiffness));
    RotorBearingSystem {
        rotor: RigidRotor::try_new(&PARAMS, &[]).unwrap(),
        bearings: [BearingAtStation { bearing, station: 0.0, speed_ratios: SpeedRatios::new(0.0) }],
    }
}

fn swinging() -> RotorState<f64, 5, 1> {
    RotorState::stationary(Displacement { u: 1e-5, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO])
}

/// Amplitude of the swing along X and its phase in turns; Verlet's own frequency is `2/h asin(h w/2)`.
fn swing(state: &RotorState<f64, 5, 1>, w: f64) -> (f64, f64) {
    let (x, v) = (state.q[0], state.velocity[0]);
    (x.hypot(v / w), (-v / w).atan2(x) / std::f64::consts::TAU)
}

/// Many steps of Verlet: the energy keeps within its bound and the phase is that of Verlet's own frequency.
fn many_steps(count: u64) {
    let machine = on_springs(SPRING);
    let w = (SPRING / PARAMS.mass).sqrt();
    let h = 0.1 / w;
    let mut state = swinging();
    for _ in 0..count {
        Verlet { step: h }.step(&machine, &mut state, &still());
    }
    let (amplitude, phase) = swing(&state, w);
    let own = 2.0 / h * (0.5 * h * w).asin();
    // Turns that Verlet's own frequency makes, of which the whole ones are omitted without rounding them.
    let turns = own * h / std::f64::consts::TAU;
    let expected = (0..64)
        .filter(|bit| count >> bit & 1 == 1)
        .map(|bit| (turns * (1_u64 << bit) as f64).fract())
        .sum::<f64>()
        .fract();
    let off = (phase - expected + 1.5).rem_euclid(1.0) - 0.5;
    println!(
        "{count} steps: amplitude {:.1e} off, phase {off:.1e} of a turn off after {:.0} turns",
        amplitude / 1e-5 - 1.0,
        turns * count as f64
    );
    // Within a step the energy swings by (h w)^2/4.
    assert!((amplitude / 1e-5 - 1.0).abs() < 2e-3, "{amplitude:e}");
    // Rounding of each step, added up as a random walk and as a drift.
    assert!(off.abs() < 1e-3 + 1e-14 * count as f64, "{off:e}");
}

#[test]
fn ten_million_steps_keep_energy_and_phase() {
    many_steps(10_000_000);
}

#[test]
#[ignore = "slow: half a minute; tests/run --all runs it"]
fn a_billion_steps_keep_energy_and_phase() {
    many_steps(1_000_000_000);
}

/// From a thousandth of the stable step to five times as much: below the limit the swing stays, above it grows until the
/// numbers end, and a step beyond them is held and flagged. Newmark has no limit.
#[test]
fn steps_from_far_below_to_above_the_limit() {
    let machine = on_springs(SPRING);
    let w = (SPRING / PARAMS.mass).sqrt();
    let run = |step: &dyn Fn(&mut RotorState<f64, 5, 1>) -> Status| {
        let mut state = swinging();
        let mut told = Status::OK;
        for _ in 0..200_000 {
            told = told.union(step(&mut state));
        }
        (swing(&state, w).0, told, state)
    };
    for (part, stable) in
        [(1e-3, true), (0.1, true), (0.9, true), (0.999, true), (1.01, false), (1.5, false), (5.0, false)]
    {
        let h = 2.0 * part / w;
        let (amplitude, told, state) = run(&|s| Verlet { step: h }.step(&machine, s, &still()));
        assert_eq!(told.contains(Status::RESULT_NOT_FINITE), !stable, "Verlet at {part} of its limit: {told:?}");
        assert!(state.q.iter().all(|q| q.is_finite()), "what is held is finite");
        if stable {
            assert!(amplitude < 1e-5 * 30.0, "Verlet at {part}: {amplitude:e}");
        }
        let h = 2.586 * part / w;
        let (_, told, state) = run(&|s| RungeKuttaNystrom { step: h }.step(&machine, s, &still()));
        assert_eq!(told.contains(Status::RESULT_NOT_FINITE), !stable, "Runge-Kutta at {part} of its limit: {told:?}");
        assert!(state.q.iter().all(|q| q.is_finite()));
        let newmark = Newmark { step: h, newton_steps: 1 };
        let (amplitude, told, _) = run(&|s| newmark.step(&machine, s, &still()));
        assert!(!told.is_held() && amplitude < 1e-5 * 30.0, "Newmark at {part}: {amplitude:e}");
    }
}

/// A rotor whose stiffness differs by a factor of 1e12 between two directions: the equilibrium of each direction depends on its own load.
#[test]
fn stiffness_ratios_of_a_million_million() {
    let mut params = RotorParams { load: [1.0, 1.0, 1.0, 0.0, 0.0], ..PARAMS };
    params.stiffness = [1e12, 1.0, 1e3, 1e6, 1e-2];
    params.damping = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 10.0 } else { 0.0 }));
    let nothing = Linear::new(Stiffness::from_diagonal_element(0.0));
    let machine = RotorBearingSystem {
        rotor: RigidRotor::<f64, Exact>::try_new(&params, &[]).unwrap(),
        bearings: [BearingAtStation { bearing: nothing, station: 0.0, speed_ratios: SpeedRatios::new(0.0) }],
    };
    let rest = equilibrium(&machine, &[BearingKinematicState::default()], [0.0; 5]);
    for (i, expected) in [1e-12, 1.0, 1e-3].into_iter().enumerate() {
        assert!((rest.q[i] / expected - 1.0).abs() < 1e-9, "{:?}", rest.q);
    }
    let mut state = RotorState::stationary(Displacement::default(), Phase::ZERO, [Phase::ZERO]);
    let newmark = Newmark { step: 1e-3, newton_steps: 2 };
    for _ in 0..200_000 {
        assert!(!newmark.step(&machine, &mut state, &still()).is_held());
    }
    // The stiff direction oscillates about its equilibrium without numerical damping.
    assert!(state.q[0].abs() < 3e-12 && (state.q[1] - 1.0).abs() < 1e-3, "{:?}", state.q);
}

/// A shaft that falls on one ball and leaves it again, thousands of times: the height that it comes back to stays.
#[test]
fn ball_that_loses_and_regains_contact() {
    let places: ElementPositions<f64, 3> = evenly_spaced(Phase::from_revolutions(-0.25));
    let bearing = Radial::<f64, Exact, _, _>::try_new(places, PointContactLaw { stiffness: 8e9 }, 10e-6).unwrap();
    let params = RotorParams { gravity: [0.0, -9.80665, 0.0], ..PARAMS };
    let machine = RotorBearingSystem {
        rotor: RigidRotor::<f64, Exact>::try_new(&params, &[]).unwrap(),
        bearings: [BearingAtStation { bearing, station: 0.0, speed_ratios: SpeedRatios::new(0.0) }],
    };
    // It touches at -10 um with a speed that is next to nothing, then with more: grazing and hard contact.
    for height in [1e-12, 1e-9, 1e-7, 4e-6] {
        let top = -10e-6 + height;
        let mut state =
            RotorState::stationary(Displacement { v: top, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO]);
        let (mut highest, mut contacts, mut lost) = (f64::MIN, 0_u32, true);
        for i in 0..2_000_000 {
            let status = Verlet { step: 2e-7 }.step(&machine, &mut state, &still());
            assert!(!status.is_held());
            if i > 1_800_000 {
                highest = highest.max(state.q[1]);
            }
            contacts += u32::from(lost && !status.contains(Status::CONTACT_LOST));
            lost = status.contains(Status::CONTACT_LOST);
        }
        let off = (highest - top) / (4e-6_f64.max(height));
        println!(
            "dropped from {height:e} m above contact: {contacts} contacts, comes back to {:.1e} m of it",
            highest - top
        );
        assert!(contacts >= 5 && off.abs() < 0.02, "{contacts} contacts, {off:e}");
        assert!(state.q[0].abs() < 1e-9, "no way sideways: {:?}", state.q);
    }
}

type Running<T> =
    RotorBearingSystem<RigidRotor<T, Exact>, BearingAtStation<T, Angular<T, Exact, ElementPositions<T, 9>>>, 2>;

/// A run taken up from a copied state goes on with the same bits.
#[test]
fn restarting_gives_the_same_bits() {
    same_bits::<f32>();
    same_bits::<f64>();
}

fn same_bits<T: Scalar>()
where
    Exact: Math<T>,
{
    let geometry = ballrace_tests::bearings::deep_groove_geometry(10e-6);
    let zero = ballrace::bearing::angular::DisplacementDatum::Centred;
    let bearing =
        Angular::<T, Exact, ElementPositions<T, 9>>::try_new(geometry, evenly_spaced(Phase::ZERO), zero).unwrap();
    let params = RotorParams {
        gravity: [0.0, -9.80665, 0.0],
        load: [0.0, 0.0, 60.0, 0.0, 0.0],
        damping: std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 10.0 } else { 0.0 })),
        ..PARAMS
    };
    let unbalance = Unbalance { moment: 1e-4, angle: 0.0, station: 0.01 };
    let seat =
        |station: f64| BearingAtStation { bearing, station: T::from_f64(station), speed_ratios: SpeedRatios::new(0.4) };
    let machine: Running<T> = RotorBearingSystem {
        rotor: RigidRotor::try_new(&params, &[unbalance]).unwrap(),
        bearings: [seat(-0.1), seat(0.1)],
    };
    let step = RungeKuttaNystrom { step: T::from_f64(1e-5) };
    let start = Displacement { w: T::from_f64(10e-6), ..Displacement::default() };
    let mut state = RotorState::<T, 5, 2>::stationary(start, Phase::ZERO, [Phase::ZERO; 2]);
    let mut now = ShaftMotion { angle: Phase::ZERO, speed: T::from_f64(314.0), acceleration: T::ZERO };
    let go = |state: &mut RotorState<T, 5, 2>, now: &mut ShaftMotion<T>, count: u32| {
        for _ in 0..count {
            step.step(&machine, state, now);
            *now = now.after(T::from_f64(1e-5));
        }
    };
    go(&mut state, &mut now, 3000);
    let (mut saved, mut saved_now) = (state, now);
    go(&mut state, &mut now, 5000);
    go(&mut saved, &mut saved_now, 2000);
    go(&mut saved, &mut saved_now, 3000);
    assert_eq!(format!("{state:?}"), format!("{saved:?}"));
}
