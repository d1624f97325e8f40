//! The rotor: integrators against closed forms and each other, gyroscopic splitting, unbalance, statics.

use ballrace::bearing::angular::Angular;
use ballrace::bearing::linear::Linear;
use ballrace::bearing::{Bearing, ElementPositions, Mirrored};
use ballrace::rotor::{
    BearingAtStation, ForceElement, Integrator, Newmark, RigidRotor, RotorBearingSystem, RotorParams, RotorState,
    RungeKuttaNystrom, SecondOrderSystem, ShaftMotion, SpeedRatios, Unbalance, equilibrium,
};
use ballrace::{Displacement, Exact, Phase, Status, Stiffness};
use ballrace_tests::bearings::{angular_contact, deep_groove};
use ballrace_tests::compare::relative;
use std::f64::consts::TAU;

const PARAMS: RotorParams = RotorParams {
    mass: 6.0,
    diametral_inertia: 0.030,
    polar_inertia: 0.006,
    damping: [[0.0; 5]; 5],
    stiffness: [0.0; 5],
    gravity: [0.0; 3],
    load: [0.0; 5],
};

fn damped(mut params: RotorParams) -> RotorParams {
    for (i, c) in [400.0, 400.0, 400.0, 0.4, 0.4].into_iter().enumerate() {
        params.damping[i][i] = c;
    }
    params
}

fn rotor(params: RotorParams, unbalance: &[Unbalance]) -> RigidRotor<f64, Exact> {
    RigidRotor::try_new(&params, unbalance).unwrap()
}

fn drive(speed: f64) -> ShaftMotion<f64> {
    ShaftMotion { angle: Phase::ZERO, speed, acceleration: 0.0 }
}

type Rigid<B> = RotorBearingSystem<RigidRotor<f64, Exact>, BearingAtStation<f64, B>, 2>;
type Springs = Rigid<Linear<f64>>;

/// Two equal isotropic springs, 1e7 N/m, at +-0.1 m.
fn on_springs(params: RotorParams, unbalance: &[Unbalance]) -> Springs {
    let k = Stiffness::from_fn(|i, j| if i == j && i < 3 { 1e7 } else { 0.0 });
    let at = |station| BearingAtStation { bearing: Linear::new(k), station, speed_ratios: SpeedRatios::new(0.0) };
    RotorBearingSystem { rotor: rotor(params, unbalance), bearings: [at(-0.1), at(0.1)] }
}

fn rig(params: RotorParams, unbalance: &[Unbalance]) -> Rigid<Angular<f64, Exact, ElementPositions<f64, 9>>> {
    let at =
        |station| BearingAtStation { bearing: deep_groove::<9>(10e-6), station, speed_ratios: SpeedRatios::new(0.4) };
    RotorBearingSystem { rotor: rotor(params, unbalance), bearings: [at(-0.1), at(0.1)] }
}

/// Runs `turns` of the shaft's time span and returns the state at its end.
fn run<I: Integrator<f64>, R: SecondOrderSystem<f64, D>, C: ForceElement<f64, D>, const D: usize, const N: usize>(
    machine: &RotorBearingSystem<R, C, N>,
    integrator: &I,
    start: RotorState<f64, D, N>,
    drive: ShaftMotion<f64>,
    (step, count): (f64, usize),
) -> RotorState<f64, D, N> {
    let (mut state, mut now) = (start, drive);
    for _ in 0..count {
        assert!(!integrator.step(machine, &mut state, &now).is_held());
        now = now.after(step);
    }
    state
}

/// Free vibration on springs is a cosine; the error falls as h^4 and h^2.
#[test]
fn order_of_the_integrators() {
    let machine = on_springs(PARAMS, &[]);
    let start =
        RotorState::stationary(Displacement { u: 1e-5, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO; 2]);
    let omega = (2e7_f64 / 6.0).sqrt();
    let time = 3.3 * TAU / omega;
    let exact = 1e-5 * (omega * time).cos();
    let error = |count: usize, newmark: bool| {
        let h = time / count as f64;
        let mut begin = start;
        begin.acceleration[0] = -omega * omega * 1e-5;
        let end = if newmark {
            run(&machine, &Newmark { step: h, newton_steps: 2 }, begin, drive(0.0), (h, count))
        } else {
            run(&machine, &RungeKuttaNystrom { step: h }, begin, drive(0.0), (h, count))
        };
        (end.q[0] - exact).abs()
    };
    let order = |newmark: bool| (error(200, newmark) / error(400, newmark)).log2();
    assert!((order(false) - 4.0).abs() < 0.2, "Runge-Kutta {}", order(false));
    assert!((order(true) - 2.0).abs() < 0.1, "Newmark {}", order(true));
}

/// With `x` the product of step and frequency, Runge-Kutta-Nystrom lowers the frequency by `x^4 / 320` of it and damps by `x^6 / 576` a step.
#[test]
fn frequency_and_damping_of_runge_kutta_nystrom() {
    let machine = on_springs(PARAMS, &[]);
    let omega = (2e7_f64 / 6.0).sqrt();
    let start =
        RotorState::stationary(Displacement { u: 1e-5, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO; 2]);
    for (x, count) in [(0.2_f64, 8000_usize), (0.3, 4000)] {
        let h = x / omega;
        let end = run(&machine, &RungeKuttaNystrom { step: h }, start, drive(0.0), (h, count));
        let (cos, sin) = (end.q[0], -end.velocity[0] / omega);
        let steps = count as f64;
        let behind = (x * steps - sin.atan2(cos)).rem_euclid(TAU);
        let lost = -(cos.hypot(sin) / 1e-5).ln();
        assert!(relative(behind, steps * x.powi(5) / 320.0) < 0.03, "phase at {x}: {behind}");
        assert!(relative(lost, steps * x.powi(6) / 576.0) < 0.03, "amplitude at {x}: {lost}");
    }
}

/// Newmark's trapezium rule neither feeds nor damps an undamped linear rotor: energy after 1e5 steps.
#[test]
fn newmark_keeps_the_energy_of_springs() {
    let machine = on_springs(PARAMS, &[]);
    let q = Displacement { u: 1e-5, v: -5e-6, thu: 1e-5, ..Displacement::default() };
    let energy = |s: &RotorState<f64, 5, 2>| {
        let k = [2e7, 2e7, 2e7, 2e5, 2e5];
        let m = [6.0, 6.0, 6.0, 0.03, 0.03];
        let (q, v) = (s.q, s.velocity);
        (0..5).map(|i| 0.5 * k[i] * q[i] * q[i] + 0.5 * m[i] * v[i] * v[i]).sum::<f64>()
    };
    let mut start = RotorState::stationary(q, Phase::ZERO, [Phase::ZERO; 2]);
    start.acceleration = [-2e7 / 6.0 * q.u, -2e7 / 6.0 * q.v, 0.0, -2e5 / 0.03 * q.thu, 0.0];
    let end = run(&machine, &Newmark { step: 5e-5, newton_steps: 2 }, start, drive(300.0), (5e-5, 100_000));
    let drift = relative(energy(&end), energy(&start));
    assert!(drift < 1e-9, "{drift:e}");
}

/// On the nonlinear bearings both integrators run to the same motion.
#[test]
fn both_integrators_agree_on_the_rig() {
    let params = RotorParams { gravity: [0.0, -9.80665, 0.0], load: [0.0, 0.0, 60.0, 0.0, 0.0], ..damped(PARAMS) };
    let unbalance = [Unbalance { moment: 480e-6, angle: 1.2, station: -0.03 }];
    let machine = rig(params, &unbalance);
    let rest = equilibrium(&machine, &[Phase::ZERO.into(); 2], Displacement::default());
    assert!(rest.residual < 1e-9, "{:e}", rest.residual);
    let start = RotorState::stationary(rest.q, Phase::ZERO, [Phase::ZERO; 2]);
    let end = |h: f64, newmark: bool| {
        let count = (0.1 / h).round() as usize;
        let speed = 100.0 * std::f64::consts::PI;
        if newmark {
            run(&machine, &Newmark { step: h, newton_steps: 3 }, start, drive(speed), (h, count)).q
        } else {
            run(&machine, &RungeKuttaNystrom { step: h }, start, drive(speed), (h, count)).q
        }
    };
    let (a, b) = (end(1e-5, false), end(2e-6, true));
    for (x, y) in a.into_iter().zip(b).take(3) {
        assert!((x - y).abs() < 2e-9, "{x} {y}");
    }
}

/// Natural frequencies of a rotor on a preloaded pair, at rest and split by the gyroscopic moment.
#[test]
fn natural_frequencies_of_a_preloaded_pair() {
    let w0 = Displacement { w: 10.000_495e-6, ..Displacement::default() };
    let (reaction, plus) = angular_contact().reaction_and_stiffness(&w0, &Phase::ZERO.into());
    assert!((reaction.wrench.fz + 500.0).abs() < 1e-2, "{}", reaction.wrench.fz);
    let (_, minus) = Mirrored(angular_contact()).reaction_and_stiffness(&w0.mirrored(), &Phase::ZERO.into());
    let whole = |left: &Stiffness<f64>, right: &Stiffness<f64>| {
        ballrace::frame::stiffness_from_station(left, -0.05) + ballrace::frame::stiffness_from_station(right, 0.05)
    };
    // Back to back: contact lines diverge, pairs stiff against tilt.
    let stiffer = whole(&minus, &plus);
    let softer = whole(&plus, &minus);
    let (back, front) = if stiffer[(3, 3)] > softer[(3, 3)] { (stiffer, softer) } else { (softer, stiffer) };
    let hz = |k: f64, m: f64| (k / m).sqrt() / TAU;
    assert!(relative(hz(back[(2, 2)], 2.0), 1428.3188) < 1e-6);
    assert!(relative(hz(back[(0, 0)], 2.0), 1960.8358) < 1e-6);
    assert!(relative(hz(back[(3, 3)], 4e-3), 2618.6353) < 1e-6, "{}", hz(back[(3, 3)], 4e-3));
    assert!(relative(hz(front[(3, 3)], 4e-3), 1771.4210) < 1e-6);
    // I_d s^2 -+ I_p w s - k = 0 at 12 000 rpm.
    let split = |k: f64, rpm: f64| {
        let g = 2e-3 * rpm * TAU / 60.0 / (2.0 * 4e-3);
        let root = (g * g + k / 4e-3).sqrt();
        ((root - g) / TAU, (root + g) / TAU)
    };
    let (low, high) = split(back[(3, 3)], 12_000.0);
    assert!(relative(low, 2569.1126) < 1e-6 && relative(high, 2669.1126) < 1e-6);
}

/// The integrated rotor itself precesses at those frequencies: forward faster, backward slower.
#[test]
fn gyroscopic_moment_has_the_right_sign() {
    let machine = on_springs(PARAMS, &[]);
    let speed = 2_000.0;
    let g = 0.006 * speed / (2.0 * 0.030);
    let k_tilt: f64 = 2.0 * 1e7 * 0.01;
    let forward = g + (g * g + k_tilt / 0.030).sqrt();
    // Started on the forward whirl about +Z: the axis (thv, -thu) turns positively.
    let a = 1e-5;
    let h = 2e-6;
    let mut state =
        RotorState::stationary(Displacement { thv: a, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO; 2]);
    state.velocity[3] = -forward * a;
    let count = 5_000;
    let end = run(&machine, &RungeKuttaNystrom { step: h }, state, drive(speed), (h, count));
    let angle = forward * h * count as f64;
    assert!((end.q[4] - a * angle.cos()).abs() < 1e-4 * a, "{} {}", end.q[4], a * angle.cos());
    assert!((end.q[3] + a * angle.sin()).abs() < 1e-4 * a);
}

/// Steady unbalance response on springs against the closed form, with its couple from a plane off the centre.
#[test]
fn unbalance_and_its_couple() {
    let unbalance = Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 };
    let machine = on_springs(damped(PARAMS), &[unbalance]);
    let speed = 400.0;
    let h = 1e-5;
    let count = 200_000;
    let start = RotorState::stationary(Displacement::default(), Phase::ZERO, [Phase::ZERO; 2]);
    let end = run(&machine, &RungeKuttaNystrom { step: h }, start, drive(speed), (h, count));
    let angle = drive(speed).speed * h * count as f64;
    // (k - m w^2 + i c w) r = m e w^2 e^(i (angle + phase)), forward circular motion.
    let (re, im) = (2e7 - 6.0 * speed * speed, 400.0 * speed);
    let size = 120e-6 * speed * speed / re.hypot(im);
    let phase = angle + 0.3 - im.atan2(re);
    assert!((end.q[0] - size * phase.cos()).abs() < 1e-5 * size, "{} {}", end.q[0], size * phase.cos());
    assert!((end.q[1] - size * phase.sin()).abs() < 1e-5 * size);
    // Tilt: the axis thv - i thu turned by the moment z F; forward whirl sees I_d - I_p.
    let (re, im) = (2e5 - (0.030 - 0.006) * speed * speed, 0.4 * speed);
    let size = 0.02 * 120e-6 * speed * speed / re.hypot(im);
    let phase = angle + 0.3 - im.atan2(re);
    assert!((end.q[4] - size * phase.cos()).abs() < 1e-4 * size);
    assert!((end.q[3] + size * phase.sin()).abs() < 1e-4 * size);
}

/// In a run-up the unbalance also pushes along the tangent: m e times the angular acceleration.
#[test]
fn angular_acceleration_pushes_along_the_tangent() {
    let rotor = rotor(PARAMS, &[Unbalance { moment: 1e-3, angle: 0.0, station: 0.0 }]);
    let quarter = ShaftMotion { angle: Phase::from_revolutions(0.25), speed: 10.0, acceleration: 7.0 };
    let f = rotor.excitation(&quarter);
    assert!((f[1] - 1e-3 * 100.0).abs() < 1e-15 && (f[0] - 1e-3 * 7.0).abs() < 1e-15);
}

/// Static equilibrium: the bearings carry exactly the load.
#[test]
fn equilibrium_carries_the_load() {
    let params = RotorParams { gravity: [0.0, -9.80665, 0.0], load: [10.0, 0.0, 60.0, 0.5, 0.0], ..PARAMS };
    let machine = rig(params, &[]);
    let found = equilibrium(&machine, &[Phase::from_revolutions(0.01).into(); 2], Displacement::default());
    let force = machine.bearing_forces(&found.q, &[Phase::from_revolutions(0.01).into(); 2]).force;
    let load = machine.rotor.constant_load();
    for (f, l) in force.into_iter().zip(load) {
        assert!((f + l).abs() < 1e-7, "{f} {l}");
    }
}

/// A drive that is not a number leaves the motion as it was, flagged and counted.
#[test]
fn invalid_shaft_motion_holds_the_state() {
    let machine = rig(damped(PARAMS), &[]);
    let start =
        RotorState::stationary(Displacement { w: 7e-5, ..Displacement::default() }, Phase::ZERO, [Phase::ZERO; 2]);
    for bad in [f64::NAN, f64::INFINITY] {
        let (mut a, mut b) = (start, start);
        let broken = ShaftMotion { speed: bad, ..drive(0.0) };
        assert!(RungeKuttaNystrom { step: 1e-5 }.step(&machine, &mut a, &broken).contains(Status::INPUT_NOT_FINITE));
        assert!(Newmark { step: 1e-5, newton_steps: 3 }.step(&machine, &mut b, &broken).is_held());
        assert_eq!((a.q, a.held_steps), (start.q, 1));
        assert_eq!((b.q, b.held_steps), (start.q, 1));
    }
    let mut state = start;
    state.q[0] = 1e300;
    let status = RungeKuttaNystrom { step: 1e-5 }.step(&machine, &mut state, &drive(1.0));
    assert!(status.contains(Status::RESULT_NOT_FINITE));
}

#[test]
fn impossible_rotors_are_refused() {
    for params in [
        RotorParams { mass: 0.0, ..PARAMS },
        RotorParams { mass: f64::NAN, ..PARAMS },
        RotorParams { diametral_inertia: -1.0, ..PARAMS },
        RotorParams { polar_inertia: 0.07, ..PARAMS },
        RotorParams { stiffness: [-1.0, 0.0, 0.0, 0.0, 0.0], ..PARAMS },
    ] {
        let error = RigidRotor::<f64, Exact>::try_new(&params, &[]).unwrap_err();
        assert!(error.to_string().contains("expected"), "{error}");
    }
}
