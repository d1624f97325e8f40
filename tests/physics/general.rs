//! Systems of any order: from matrices, on supports, with balls that move; and the integrators on them.

use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{Bearing, ElementPositions, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::rotor::{
    AttachedBearing, Attachment, BearingAtStation, ForceElement, Integrator, LinearSystem, MovingBalls,
    MovingBallsParams, Newmark, RigidRotor, RotorBearingSystem, RotorParams, RotorState, RungeKuttaNystrom,
    SecondOrderSystem, ShaftMotion, SpeedRatios, SteadyVerlet, Support, SystemMatrices, Unbalance, Verlet, equilibrium,
    supported_rotor,
};
use ballrace::{BearingKinematicState, Displacement, Exact, Phase, Status, Stiffness};
use ballrace_tests::bearings::deep_groove;
use ballrace_tests::compare::relative;
use nalgebra::SMatrix;

const PARAMS: RotorParams = RotorParams {
    mass: 6.0,
    diametral_inertia: 0.030,
    polar_inertia: 0.006,
    damping: [[0.0; 5]; 5],
    stiffness: [0.0; 5],
    gravity: [0.0, -9.80665, 0.0],
    load: [0.0, 0.0, 60.0, 0.0, 0.0],
};
const UNBALANCE: Unbalance = Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 };
const SOFT: Support = Support { mass: 2.0, stiffness: [[3e7, 4e6], [4e6, 2e7]], damping: [[300.0, 0.0], [0.0, 200.0]] };

fn drive(speed: f64) -> ShaftMotion<f64> {
    ShaftMotion { angle: Phase::ZERO, speed, acceleration: 0.0 }
}

fn damped() -> RotorParams {
    let mut params = PARAMS;
    for (i, c) in [400.0, 400.0, 400.0, 0.4, 0.4].into_iter().enumerate() {
        params.damping[i][i] = c;
    }
    params
}

fn run<I: Integrator<f64>, R: SecondOrderSystem<f64, D>, C: ForceElement<f64, D>, const D: usize, const N: usize>(
    machine: &RotorBearingSystem<R, C, N>,
    integrator: &I,
    mut state: RotorState<f64, D, N>,
    mut now: ShaftMotion<f64>,
    (step, count): (f64, usize),
) -> RotorState<f64, D, N> {
    for _ in 0..count {
        assert!(!integrator.step(machine, &mut state, &now).is_held());
        now = now.after(step);
    }
    state
}

type Ball = ballrace::bearing::angular::Angular<f64, Exact, ElementPositions<f64, 9>>;

fn on_supports(
    supports: &[Support],
) -> RotorBearingSystem<LinearSystem<f64, Exact, 9>, AttachedBearing<f64, Ball, 9>, 2> {
    let matrices = supported_rotor::<9>(&damped(), &[UNBALANCE], supports).unwrap();
    let housing = |i: usize| (i < supports.len()).then_some(5 + 2 * i);
    let at = |i: usize, station: f64| AttachedBearing {
        bearing: deep_groove::<9>(10e-6),
        attachment: Attachment::on_rigid_rotor(station, housing(i)),
        speed_ratios: SpeedRatios::new(0.4),
    };
    RotorBearingSystem { rotor: LinearSystem::try_new(&matrices).unwrap(), bearings: [at(0, -0.1), at(1, 0.1)] }
}

fn rigid() -> RotorBearingSystem<RigidRotor<f64, Exact>, BearingAtStation<f64, Ball>, 2> {
    let at =
        |station| BearingAtStation { bearing: deep_groove::<9>(10e-6), station, speed_ratios: SpeedRatios::new(0.4) };
    RotorBearingSystem { rotor: RigidRotor::try_new(&damped(), &[UNBALANCE]).unwrap(), bearings: [at(-0.1), at(0.1)] }
}

/// The same rotor as a general system runs the same motion to rounding, in a run-up and by every integrator.
#[test]
fn a_general_system_without_supports_is_the_rigid_rotor() {
    let (rigid, general) = (rigid(), on_supports(&[]));
    let rest = equilibrium(&rigid, &[Phase::ZERO.into(); 2], [0.0; 5]);
    let same = equilibrium(&general, &[Phase::ZERO.into(); 2], [0.0; 9]);
    assert!((0..5).all(|i| (rest.q[i] - same.q[i]).abs() < 1e-12), "{:?} {:?}", rest.q, same.q);
    let mut start = [0.0; 9];
    start[..5].copy_from_slice(&rest.q);
    let (a, b) = (
        RotorState::stationary(rest.q, Phase::ZERO, [Phase::ZERO; 2]),
        RotorState::stationary(start, Phase::ZERO, [Phase::ZERO; 2]),
    );
    let up = ShaftMotion { acceleration: 500.0, ..drive(100.0) };
    let h = 1e-5;
    let ends = [
        (
            run(&rigid, &RungeKuttaNystrom { step: h }, a, up, (h, 5000)).q,
            run(&general, &RungeKuttaNystrom { step: h }, b, up, (h, 5000)).q,
        ),
        (run(&rigid, &Verlet { step: h }, a, up, (h, 5000)).q, run(&general, &Verlet { step: h }, b, up, (h, 5000)).q),
        (
            run(&rigid, &Newmark { step: h, newton_steps: 2 }, a, up, (h, 5000)).q,
            run(&general, &Newmark { step: h, newton_steps: 2 }, b, up, (h, 5000)).q,
        ),
    ];
    for (five, nine) in ends {
        for i in 0..5 {
            assert!((five[i] - nine[i]).abs() < 1e-12, "{i}: {} {}", five[i], nine[i]);
        }
    }
}

/// A steady Verlet steps as Verlet: to the bit where the speed changes, and to rounding at a speed that stays; a speed that is
/// no number is held and forgotten.
#[test]
fn steady_verlet_equals_verlet() {
    let (machine, verlet) = (on_supports(&[SOFT, SOFT]), Verlet { step: 2e-5 });
    let mut steady = SteadyVerlet::new(verlet, &machine.rotor, 0.0);
    let mut state = RotorState::stationary([0.0; 9], Phase::ZERO, [Phase::ZERO; 2]);
    let (mut now, mut speed_before, mut to_the_bit) = (drive(300.0), 0.0, 0);
    for i in 0..3000 {
        let (mut plain, mut kept) = (state, state);
        assert!(!verlet.step(&machine, &mut plain, &now).is_held());
        assert!(!steady.step(&machine, &mut kept, &now).is_held());
        if now.acceleration != 0.0 || now.speed != speed_before {
            assert_eq!(plain, kept, "step {i}");
            to_the_bit += 1;
        }
        for (a, b) in plain.acceleration.into_iter().zip(kept.acceleration) {
            assert!((a - b).abs() <= 1e-12 * a.abs().max(1.0), "step {i}: {a:e} {b:e}");
        }
        (state, speed_before) = (kept, now.speed);
        let mut held = kept;
        assert!(steady.step(&machine, &mut held, &ShaftMotion { speed: f64::NAN, ..now }).is_held());
        assert_eq!((held.q, held.velocity, held.held_steps), (kept.q, kept.velocity, kept.held_steps + 1));
        now = now.after(verlet.step);
        now.acceleration = if (1000..2000).contains(&i) { 400.0 } else { 0.0 };
        now.speed = if i == 2500 { -100.0 } else { now.speed };
    }
    assert!((1000..1010).contains(&to_the_bit), "{to_the_bit}");
    assert!(state.velocity.iter().any(|rate| rate.abs() > 1e-5), "{state:?}");
}

/// At rest the supports carry what the bearings press on them, their own weight besides: action and reaction.
#[test]
fn supports_carry_the_rotor() {
    let machine = on_supports(&[SOFT, SOFT]);
    let rest = equilibrium(&machine, &[Phase::ZERO.into(); 2], [0.0; 9]);
    assert!(rest.residual < 1e-9, "{:e}", rest.residual);
    let mut carried = [0.0; 2];
    for first in [5, 7] {
        for (i, sum) in carried.iter_mut().enumerate() {
            *sum += (0..2).map(|j| SOFT.stiffness[i][j] * rest.q[first + j]).sum::<f64>();
        }
    }
    assert!(carried[0].abs() < 1e-5, "{carried:?}");
    assert!((carried[1] + (6.0 + 2.0 + 2.0) * 9.80665).abs() < 1e-5, "{carried:?}");
}

/// Supports a thousand times stiffer bring the rotor a thousand times closer to the one whose outer rings stand still.
#[test]
fn stiff_supports_recover_the_rigid_ones() {
    let rigid = equilibrium(&rigid(), &[Phase::ZERO.into(); 2], [0.0; 5]).q;
    let off = |factor: f64| {
        let k = SOFT.stiffness.map(|row| row.map(|k| k * factor));
        let machine = on_supports(&[Support { stiffness: k, ..SOFT }, Support { stiffness: k, ..SOFT }]);
        (equilibrium(&machine, &[Phase::ZERO.into(); 2], [0.0; 9]).q[1] - rigid[1]).abs()
    };
    assert!(relative(off(1e3) * 1e3, off(1.0)) < 0.01, "{:e} {:e}", off(1.0), off(1e3));
}

/// An undamped rotor on springs in springs: its frequencies are those of the nine-coordinate matrices, its energy stays.
type Elastic = RotorBearingSystem<LinearSystem<f64, Exact, 9>, AttachedBearing<f64, Linear<f64>, 9>, 2>;

const SPRING: f64 = 1e8;

fn elastic() -> (Elastic, SystemMatrices<9>) {
    let free = Support { damping: [[0.0; 2]; 2], ..SOFT };
    let still = RotorParams { gravity: [0.0; 3], load: [0.0; 5], ..PARAMS };
    let matrices = supported_rotor::<9>(&still, &[], &[free, free]).unwrap();
    let k = Stiffness::from_fn(|i, j| if i == j && i < 3 { SPRING } else { 0.0 });
    let at = |i: usize, station: f64| AttachedBearing {
        bearing: Linear::new(k),
        attachment: Attachment::on_rigid_rotor(station, Some(5 + 2 * i)),
        speed_ratios: SpeedRatios::new(0.0),
    };
    (
        RotorBearingSystem { rotor: LinearSystem::try_new(&matrices).unwrap(), bearings: [at(0, -0.1), at(1, 0.1)] },
        matrices,
    )
}

fn whole_stiffness(machine: &Elastic) -> SMatrix<f64, 9, 9> {
    let (_, tangent) = machine.bearing_forces_and_stiffness(&[0.0; 9], &[BearingKinematicState::default(); 2]);
    tangent + machine.rotor.effective_matrix([0.0, 0.0, 1.0], 0.0)
}

fn energy(matrices: &SystemMatrices<9>, k: &SMatrix<f64, 9, 9>, state: &RotorState<f64, 9, 2>) -> f64 {
    let (q, v) = (nalgebra::SVector::from(state.q), nalgebra::SVector::from(state.velocity));
    0.5 * (v.dot(&(matrices.mass * v)) + q.dot(&(k * q)))
}

fn plucked() -> RotorState<f64, 9, 2> {
    let mut q = [0.0; 9];
    (q[0], q[1], q[3], q[5]) = (1e-5, -5e-6, 1e-5, 3e-6);
    RotorState::stationary(q, Phase::ZERO, [Phase::ZERO; 2])
}

/// A million steps of the undamped rotor with gyroscopic moments at a tenth of the stability limit: Verlet's energy
/// swings and does not drift, Newmark's stands still, Runge-Kutta's falls at the theoretical rate.
#[test]
fn energy_over_a_million_steps() {
    let (machine, matrices) = elastic();
    let k = whole_stiffness(&machine);
    let h = 2.0 / highest(&matrices, &k) / 10.0;
    let steps = 1_000_000;
    let start = plucked();
    let first = energy(&matrices, &k, &start);
    // Mean over a window, so that the swing does not pass for a drift.
    let mean = |state: &mut RotorState<f64, 9, 2>, now: &mut ShaftMotion<f64>| {
        let window = 2_000;
        let mut sum = 0.0;
        for _ in 0..window {
            Verlet { step: h }.step(&machine, state, now);
            *now = now.after(h);
            sum += energy(&matrices, &k, state);
        }
        sum / f64::from(window) / first
    };
    let (mut state, mut now) = (start, drive(300.0));
    let before = mean(&mut state, &mut now);
    for _ in 0..steps {
        Verlet { step: h }.step(&machine, &mut state, &now);
        now = now.after(h);
    }
    let drift = mean(&mut state, &mut now) - before;
    println!("Verlet: mean energy {:.3e} off at the start, drift over {steps} steps {drift:.1e}", before - 1.0);
    assert!(drift.abs() < 2e-4, "{drift:e}");
    let mut start = plucked();
    start.acceleration = accelerated(&machine, &start);
    let end = run(&machine, &Newmark { step: h, newton_steps: 1 }, start, drive(300.0), (h, steps / 10));
    let drift = energy(&matrices, &k, &end) / first - 1.0;
    println!("Newmark: energy {drift:.1e} off after {} steps", steps / 10);
    assert!(drift.abs() < 1e-8, "{drift:e}");
    let end = run(&machine, &RungeKuttaNystrom { step: h }, plucked(), drive(300.0), (h, steps / 10));
    let fallen = energy(&matrices, &k, &end) / first - 1.0;
    println!("Runge-Kutta: energy {fallen:.1e} off after {} steps", steps / 10);
    assert!(fallen < -1e-3, "{fallen:e}");
}

fn accelerated(machine: &Elastic, state: &RotorState<f64, 9, 2>) -> [f64; 9] {
    let mut f = machine.bearing_forces(&state.q, &[BearingKinematicState::default(); 2]).force;
    for (f, g) in f.iter_mut().zip(machine.rotor.internal_force(&state.q, &state.velocity, 0.0)) {
        *f += g;
    }
    machine.rotor.acceleration(&f)
}

fn highest(matrices: &SystemMatrices<9>, k: &SMatrix<f64, 9, 9>) -> f64 {
    let root = matrices.mass.map(|m: f64| if m > 0.0 { 1.0 / m.sqrt() } else { 0.0 });
    (root * k * root).symmetric_eigenvalues().max().sqrt()
}

/// The error of one mode falls with the step at the theoretical rates: h^4, h^2, h^2.
#[test]
fn observed_orders() {
    let (machine, _) = elastic();
    let mut start = plucked();
    start.acceleration = accelerated(&machine, &start);
    let time = 2e-3;
    let fine = run(&machine, &RungeKuttaNystrom { step: time / 8000.0 }, start, drive(300.0), (time / 8000.0, 8000)).q;
    let order = |count: usize, step: &dyn Fn(usize) -> [f64; 9]| {
        let error = |n| step(n).iter().zip(fine).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        (error(count) / error(2 * count)).log2()
    };
    let h = |n: usize| time / n as f64;
    let rk = order(1000, &|n| run(&machine, &RungeKuttaNystrom { step: h(n) }, start, drive(300.0), (h(n), n)).q);
    let newmark =
        order(800, &|n| run(&machine, &Newmark { step: h(n), newton_steps: 1 }, start, drive(300.0), (h(n), n)).q);
    let verlet = order(800, &|n| run(&machine, &Verlet { step: h(n) }, start, drive(300.0), (h(n), n)).q);
    println!("observed orders: Runge-Kutta {rk:.3}, Newmark {newmark:.3}, Verlet {verlet:.3}");
    assert!((rk - 4.0).abs() < 0.1 && (newmark - 2.0).abs() < 0.05 && (verlet - 2.0).abs() < 0.05);
}

/// The largest stable step is w h = 2 for Verlet and 2.5865 for Runge-Kutta-Nystrom; Newmark has none.
#[test]
fn largest_stable_steps() {
    // Where an eigenvalue of the step's matrix reaches -1.
    const RUNGE_KUTTA_NYSTROM: f64 = 2.5865;
    let (machine, matrices) = elastic();
    let w = highest(&matrices, &whole_stiffness(&machine));
    let stays = |step: &dyn Fn(&mut RotorState<f64, 9, 2>) -> Status| {
        let mut state = plucked();
        for _ in 0..20_000 {
            step(&mut state);
        }
        state.q.iter().all(|x| x.abs() < 1e-3)
    };
    let still = drive(0.0);
    let verlet = |phase: f64| stays(&|s| Verlet { step: phase / w }.step(&machine, s, &still));
    let rk = |phase: f64| stays(&|s| RungeKuttaNystrom { step: phase / w }.step(&machine, s, &still));
    let newmark = |phase: f64| stays(&|s| Newmark { step: phase / w, newton_steps: 1 }.step(&machine, s, &still));
    let limit = |stays: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.5, 4.0);
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if stays(middle) { low = middle } else { high = middle }
        }
        low
    };
    let (v, r) = (limit(&verlet), limit(&rk));
    println!("largest stable w h: Verlet {v:.3} (theory 2), Runge-Kutta-Nystrom {r:.3} (theory {RUNGE_KUTTA_NYSTROM})");
    assert!((v - 2.0).abs() < 0.01 && (r - RUNGE_KUTTA_NYSTROM).abs() < 0.02);
    assert!(newmark(1.0) && newmark(100.0));
}

/// An invalid matrix is rejected with the position of the entry.
#[test]
fn crooked_matrices_are_refused() {
    let good = SystemMatrices::<3>::unit_mass();
    let says = |change: &dyn Fn(&mut SystemMatrices<3>)| {
        let mut bad = good;
        change(&mut bad);
        LinearSystem::<f64, Exact, 3>::try_new(&bad).map(|_| ()).unwrap_err().to_string()
    };
    assert_eq!(
        says(&|m| m.stiffness[(2, 0)] = 5.0),
        "K: invalid matrix: 5 at row 3, column 1 and 0 at row 1, column 3, expected a symmetric matrix of finite numbers"
    );
    assert!(
        says(&|m| m.gyroscopic[(1, 0)] = 2.0)
            .starts_with("G: invalid matrix: 2 at row 2, column 1 and 0 at row 1, column 2")
    );
    assert!(says(&|m| m.gyroscopic[(1, 1)] = 2.0).contains("row 2, column 2"));
    assert!(says(&|m| m.damping[(1, 1)] = f64::NAN).starts_with("B: invalid matrix: NaN at row 2"));
    let thin = says(&|m| (m.mass[(1, 2)], m.mass[(2, 1)]) = (1.0, 1.0));
    assert!(thin.contains("M: invalid matrix: 1 at row 3") && thin.contains("positive definite"), "{thin}");
}

/// The extended vectors in any order and sign: a rotor whose coordinates are renamed moves the same.
#[test]
fn attached_to_any_coordinates() {
    let shuffled = [4_usize, 2, 0, 3, 1];
    let sign = [1.0, -1.0, 1.0, -1.0, 1.0];
    let straight = supported_rotor::<5>(&damped(), &[UNBALANCE], &[]).unwrap();
    let mut renamed = SystemMatrices::<5>::unit_mass();
    for i in 0..5 {
        for j in 0..5 {
            let (a, b) = (shuffled[i], shuffled[j]);
            let s = sign[i] * sign[j];
            renamed.mass[(a, b)] = s * straight.mass[(i, j)];
            renamed.damping[(a, b)] = s * straight.damping[(i, j)];
            renamed.gyroscopic[(a, b)] = s * straight.gyroscopic[(i, j)];
        }
        renamed.load[shuffled[i]] = sign[i] * straight.load[i];
        renamed.unbalance[shuffled[i]] = straight.unbalance[i].map(|x| sign[i] * x);
    }
    let extended = |station: f64| {
        let mut rows = [[0.0; 5]; 5];
        for i in 0..5 {
            rows[i][shuffled[i]] = sign[i];
        }
        rows[0][shuffled[4]] = station * sign[4];
        rows[1][shuffled[3]] = -station * sign[3];
        rows
    };
    let at = |station: f64| AttachedBearing {
        bearing: deep_groove::<9>(10e-6),
        attachment: Attachment::new(&extended(station)),
        speed_ratios: SpeedRatios::new(0.4),
    };
    let machine = RotorBearingSystem {
        rotor: LinearSystem::<f64, Exact, 5>::try_new(&renamed).unwrap(),
        bearings: [at(-0.1), at(0.1)],
    };
    let h = 1e-5;
    let ends = |a: [f64; 5], b: [f64; 5]| {
        let start = RotorState::stationary(a, Phase::ZERO, [Phase::ZERO; 2]);
        let mine = run(&machine, &RungeKuttaNystrom { step: h }, start, drive(300.0), (h, 3000)).q;
        let start = RotorState::stationary(b, Phase::ZERO, [Phase::ZERO; 2]);
        (mine, run(&rigid(), &RungeKuttaNystrom { step: h }, start, drive(300.0), (h, 3000)).q)
    };
    let (mine, other) = ends([0.0; 5], [0.0; 5]);
    for i in 0..5 {
        assert!((sign[i] * mine[shuffled[i]] - other[i]).abs() < 1e-12, "{i}");
    }
}

const MOVING: MovingBallsParams = MovingBallsParams {
    stiffness: [1.4e10, 1.6e10],
    pitch_radius: 0.02,
    radial_play: 5e-6,
    ball_mass: 2e-3,
    cage_ratio: 0.4,
    gravity: [0.0; 2],
};

/// A rotor that only moves radially on one bearing of nine moving balls: coordinates 5 to 13.
fn on_moving_balls(
    params: &MovingBallsParams,
) -> RotorBearingSystem<LinearSystem<f64, Exact, 14>, MovingBalls<f64, Exact, ElementPositions<f64, 9>, 14>, 1> {
    let held = RotorParams {
        stiffness: [0.0, 0.0, 1e6, 1e4, 1e4],
        load: [50.0, -120.0, 0.0, 0.0, 0.0],
        gravity: [0.0; 3],
        ..damped()
    };
    let mut matrices = supported_rotor::<14>(&held, &[], &[]).unwrap();
    for i in 5..14 {
        matrices.mass[(i, i)] = params.ball_mass;
        matrices.damping[(i, i)] = 20.0;
    }
    let place = (Attachment::on_rigid_rotor(0.0, None), SpeedRatios::new(params.cage_ratio));
    let balls = MovingBalls::try_new(params, place, (evenly_spaced(Phase::ZERO), 5)).unwrap();
    RotorBearingSystem { rotor: LinearSystem::try_new(&matrices).unwrap(), bearings: [balls] }
}

/// The limit of `docs/src/models.md#balls-with-mass`: without mass the balls rest between the races, and the bearing is the lumped one with both races in
/// series; what is left is the second order of the displacement over the pitch radius.
#[test]
fn moving_balls_without_mass_are_the_lumped_bearing() {
    let series = MOVING.stiffness.map(|k| k.powf(-2.0 / 3.0)).iter().sum::<f64>().powf(-1.5);
    let lumped = Radial::<f64, Exact, _, ElementPositions<f64, 9>>::try_new(
        evenly_spaced(Phase::ZERO),
        PointContactLaw { stiffness: series },
        MOVING.radial_play,
    )
    .unwrap();
    for mass in [1e-6, 1e-9] {
        let machine = on_moving_balls(&MovingBallsParams { ball_mass: mass, ..MOVING });
        let at = BearingKinematicState {
            cage: Phase::from_revolutions(0.03),
            inner_speed: 300.0,
            ..BearingKinematicState::default()
        };
        let rest = equilibrium(&machine, &[at], [0.0; 14]);
        assert!(rest.residual < 1e-9, "{:e}", rest.residual);
        let u = Displacement { u: rest.q[0], v: rest.q[1], ..Displacement::default() };
        let (a, b) = (machine.bearings[0].reaction(&rest.q, &at).wrench, lumped.reaction(&u, &at).wrench);
        let size = a.fx.hypot(a.fy);
        assert!(size > 100.0, "the ring is pressed: {size}");
        let off = (a.fx - b.fx).hypot(a.fy - b.fy) / size;
        println!("ball of {mass:e} kg: {off:.1e} of the force off the lumped model");
        assert!(off < 2e-3, "{off:e}");
    }
}

/// Forces follow from one potential: the tangent is their derivative, and it is symmetric.
#[test]
fn tangent_of_moving_balls() {
    let machine = on_moving_balls(&MOVING);
    let mut q = [0.0; 14];
    (q[0], q[1]) = (12e-6, -7e-6);
    for (j, x) in q.iter_mut().skip(5).enumerate() {
        *x = 3e-6 * (j as f64 * 1.7).sin();
    }
    let at = [BearingKinematicState {
        cage: Phase::from_revolutions(0.11),
        inner_speed: 900.0,
        ..BearingKinematicState::default()
    }];
    let (_, k) = machine.bearing_forces_and_stiffness(&q, &at);
    let largest = k.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    for j in 0..14 {
        let h = 1e-10;
        let moved = |s: f64| {
            let mut q = q;
            q[j] += s * h;
            machine.bearing_forces(&q, &at).force
        };
        let (plus, minus) = (moved(1.0), moved(-1.0));
        for i in 0..14 {
            let difference = -(plus[i] - minus[i]) / (2.0 * h);
            assert!((k[(i, j)] - difference).abs() < 2e-5 * largest, "{i} {j}: {} {difference}", k[(i, j)]);
            assert!((k[(i, j)] - k[(j, i)]).abs() < 1e-12 * largest);
        }
    }
}

/// A spinning bearing throws its balls outward: each presses the outer race with its centrifugal force.
#[test]
fn centrifugal_force_moves_balls_outward() {
    let machine = on_moving_balls(&MOVING);
    let at = BearingKinematicState { inner_speed: 3000.0, ..BearingKinematicState::default() };
    let rest = equilibrium(&machine, &[at], [0.0; 14]);
    let mut free = 0;
    let mut loads = [0.0; 9];
    machine.bearings[0].element_loads(&rest.q, &at, &mut loads);
    for (x, load) in rest.q.iter().skip(5).zip(loads) {
        let outer = MOVING.stiffness[1] * (x - 0.5 * MOVING.radial_play).max(0.0).powf(1.5);
        let thrown = MOVING.ball_mass * (MOVING.pitch_radius + x) * (0.4_f64 * 3000.0).powi(2);
        if load == 0.0 {
            free += 1;
            assert!(relative(outer, thrown) < 1e-9, "{outer} {thrown}");
        } else {
            assert!(outer > thrown);
        }
    }
    assert!(free > 0);
}

/// A rotor on moving balls comes to rest where the static solution is.
#[test]
fn moving_balls_reach_static_equilibrium() {
    let machine = on_moving_balls(&MOVING);
    let rest = equilibrium(&machine, &[BearingKinematicState::default()], [0.0; 14]);
    let mut state = RotorState::stationary(rest.q, Phase::ZERO, [Phase::ZERO]);
    state.q[0] += 1e-7;
    let h = 2e-6;
    let mut status = Status::OK;
    for _ in 0..200_000 {
        status = Verlet { step: h }.step(&machine, &mut state, &drive(0.0));
    }
    assert!(!status.is_held());
    for (a, b) in state.q.iter().zip(rest.q) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}
