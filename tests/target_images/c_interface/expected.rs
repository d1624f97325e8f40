//! Results of the kernel, called directly, that the images of C print as checksums.

use super::super::counts_inputs::{COUNT, counts, input};
use super::tables::{de, nde};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::fixed_point::{self, AxialParams, RadialParams, TabulatedParams};
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{ElementPosition, LastValidWrench, Mirrored, evenly_spaced};
use ballrace::block::{Metres, ProbedBearing};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::phase::{PhaseDelta, SpeedRatio};
use ballrace::probe::{Probe, ProbeParams};
use ballrace::rotor::{
    BearingAtStation, ComponentAngles, Integrator, RigidRotor, RotorBearingSystem, RotorParams, RotorState,
    ShaftMotion, SpeedRatios, Unbalance, Verlet,
};
use ballrace::twin::{
    Envelope, ForceLine, ForceOrderTracker, Observer, ObserverState, OrderLine, OrderTracker, SpeedGain, Statistics,
};
use ballrace::{
    Bearing, BearingKinematicState, Displacement, Exact, Phase, Status, Stiffness, TabulatedBearing, Wrench,
};
use std::fmt::Write;

/// FNV-1a over the bits of results.
struct Checksum(u64);

impl Checksum {
    fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bits(&mut self, bits: u32) {
        for byte in bits.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn phase(&mut self, phase: u64) {
        self.bits(phase as u32);
        self.bits((phase >> 32) as u32);
    }

    fn add(&mut self, results: impl IntoIterator<Item = f32>) {
        for x in results {
            self.bits(x.to_bits());
        }
    }
}

const OK: u32 = 0;
const STATE_INVALID: u32 = 256;
const INVALID_ARGUMENT: u32 = 512;
const BLOCK_COMPLETE: u32 = 1024;

/// Input number `i` without special values, as `finite_input` of the image.
fn finite_input(i: u32) -> (Displacement<f32>, Phase) {
    let mut seed = u64::from(i).wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x1234_5678_9abc_def1);
    let u = [60e-6, 60e-6, 120e-6, 1e-3, 1e-3].map(|range: f32| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        ((seed >> 40) as f32 / 16_777_216.0 - 0.5) * range
    });
    (Displacement::from_array(u), input::<f32>(i).1)
}

const FIRST: Phase = Phase(0x0123_4567_89ab_cdef);

fn spaced(count: usize) -> Vec<ElementPosition<f32>> {
    (0..count).map(|j| ElementPosition::evenly_spaced(FIRST, j, count)).collect()
}

fn geometry() -> BallBearingGeometry {
    BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    }
    .with_clearance(10e-6)
    .expect("a geometry")
}

fn angular(positions: Vec<ElementPosition<f32>>) -> Angular<f32, Exact, Vec<ElementPosition<f32>>> {
    Angular::try_new(geometry(), positions, DisplacementDatum::Centred).expect("a bearing")
}

type Lumped<L> = Radial<f32, Exact, L, Vec<ElementPosition<f32>>>;

fn point(count: usize) -> Lumped<PointContactLaw<f32>> {
    Radial::from_constants(spaced(count), PointContactLaw { stiffness: 8e9 }, 5e-6)
}

fn line(count: usize) -> Lumped<LineContactLaw<f32>> {
    Radial::from_constants(spaced(count), LineContactLaw { stiffness: 3e8 }, 5e-6)
}

fn power(count: usize, play: f32) -> Lumped<PowerLaw<f32>> {
    Radial::from_constants(spaced(count), PowerLaw { stiffness: 2e9, exponent: 1.4 }, play)
}

fn both(count: usize) -> impl Bearing<f32> {
    let law = PointContactLaw { stiffness: 8e9 };
    Combined(point(count), Axial::<_, Exact, _, _>::from_constants(spaced(count), law, 5e-6, 0.02))
}

fn linear() -> Linear<f32> {
    let number = |i: usize| i as f32;
    Linear::about(
        Stiffness::from_fn(|i, j| (number(5 * i + j) + 1.0) * 1e6),
        Displacement::from_array([0, 1, 2, 3, 4].map(|i| number(i) / 1_048_576.0)),
        Wrench::from_array([-2.0, -1.0, 0.0, 1.0, 2.0]),
    )
}

/// A bearing with its name and its number of elements.
struct Subject(&'static str, usize, Box<dyn Bearing<f32>>);

fn subjects() -> Vec<Subject> {
    let subject = |name, count, bearing: Box<dyn Bearing<f32>>| Subject(name, count, bearing);
    let mirrored = |count| spaced(count).into_iter().map(ElementPosition::mirrored).collect();
    vec![
        subject("linear", 0, Box::new(linear())),
        subject("radial 3/2, 3", 3, Box::new(point(3))),
        subject("radial 3/2, 4", 4, Box::new(point(4))),
        subject("radial 3/2, 8", 8, Box::new(point(8))),
        subject("radial 3/2, 9", 9, Box::new(point(9))),
        subject("radial 3/2, 16", 16, Box::new(point(16))),
        subject("radial 3/2, 32", 32, Box::new(point(32))),
        subject("radial 10/9, 8", 8, Box::new(line(8))),
        subject("radial 10/9, 9", 9, Box::new(line(9))),
        subject("radial, any power, 8", 8, Box::new(power(8, 5e-6))),
        subject("radial, any power, 9", 9, Box::new(power(9, 5e-6))),
        subject("radial and axial 3/2, 8", 8, Box::new(both(8))),
        subject("radial and axial 3/2, 9", 9, Box::new(both(9))),
        subject("radial and axial 3/2, mirrored, 9", 9, Box::new(Mirrored(both(9)))),
        subject(
            "radial and axial 10/9, 9",
            9,
            Box::new(Combined(
                line(9),
                Axial::<_, Exact, _, _>::from_constants(spaced(9), LineContactLaw { stiffness: 2e8 }, -1e-6, 0.02),
            )),
        ),
        subject(
            "radial and axial, any power, 9",
            9,
            Box::new(Combined(
                power(9, -1e-6),
                Axial::<_, Exact, _, _>::from_constants(
                    spaced(9),
                    PowerLaw { stiffness: 1e9, exponent: 1.2 },
                    5e-6,
                    0.02,
                ),
            )),
        ),
        subject("angular, 4", 4, Box::new(angular(spaced(4)))),
        subject("angular, 8", 8, Box::new(angular(spaced(8)))),
        subject("angular, 9", 9, Box::new(angular(spaced(9)))),
        subject("angular, 16", 16, Box::new(angular(spaced(16)))),
        subject("angular, mirrored, 9", 9, Box::new(Mirrored(angular(mirrored(9))))),
        subject("tabulated, 8", 8, Box::new(de())),
        subject("tabulated, friction, 9", 9, Box::new(nde())),
        subject("tabulated, friction, mirrored, 9", 9, Box::new(Mirrored(nde()))),
    ]
}

fn at_speed(cage: Phase) -> BearingKinematicState<f32> {
    BearingKinematicState { cage, inner: cage.wrapping_mul(2), inner_speed: 1256.0, ..cage.into() }
}

fn of_bearing(Subject(_, count, bearing): &Subject) -> u64 {
    let mut sum = Checksum::new();
    let (mut held, mut held_at) = (LastValidWrench::new(), LastValidWrench::new());
    sum.bits(OK);
    for i in 1..=COUNT {
        let (u, cage) = finite_input(i);
        let (standing, at) = (BearingKinematicState::from(cage), at_speed(cage));
        let add = |reaction: ballrace::bearing::Reaction<f32>, stiffness: Option<Stiffness<f32>>| {
            let mut each = stiffness.map(|k| k.transpose().iter().copied().collect::<Vec<_>>()).unwrap_or_default();
            each.splice(0..0, reaction.wrench.to_array());
            (u32::from(reaction.status.bits()), each)
        };
        let (tangent, stiffness) = bearing.reaction_and_stiffness(&u, &at);
        for (bits, results) in [
            add(bearing.reaction(&u, &standing), None),
            add(bearing.reaction(&u, &at), None),
            add(tangent, Some(stiffness)),
        ] {
            sum.bits(bits);
            sum.add(results);
        }
        let mut loads = vec![0.0; *count];
        bearing.element_loads(&u, &at, &mut loads);
        sum.bits(OK);
        sum.add(loads);
        let (u, cage) = input::<f32>(i);
        for (wrench, status) in
            [bearing.sample(&mut held, &u, &cage.into()), bearing.sample(&mut held_at, &u, &at_speed(cage))]
        {
            sum.bits(u32::from(status.bits()));
            sum.add(wrench.to_array());
        }
    }
    assert!(held.held_count() > 0, "some samples are not finite");
    sum.bits(held.held_count());
    sum.bits(held_at.held_count());
    sum.0
}

/// Buffers of all kinds, one after the other through the same probes.
fn blocks() -> u64 {
    const SAMPLES: usize = 16;
    const STILL: Displacement<f32> = Displacement { u: 0.0, v: 0.0, w: 0.0, thu: 0.0, thv: 0.0 };
    let params = ProbeParams { at_zero: -32.768e-3, per_count: 1e-6, linear_range: [400, 65_000], stuck_after: 2 };
    let (turned, speed) = (PhaseDelta(0x0123_4567_89ab_cdef), 1256.0);
    let mut sum = Checksum::new();
    let mut seen = Status::OK;
    for Subject(_, _, bearing) in subjects() {
        let mut end = ProbedBearing {
            bearing: &*bearing,
            channels: [Probe::try_new(params).expect("a probe"); 2],
            directions: [Displacement { u: 1.0, ..STILL }, Displacement { v: 1.0, ..STILL }],
            offset: Displacement { w: 20e-6, ..STILL },
            cage_ratio: SpeedRatio::new(0.3983),
            shaft: Phase(1 << 48),
            cage: Phase(1 << 40),
            last_valid: LastValidWrench::new(),
        };
        sum.bits(OK);
        for i in 1..=12 {
            let counts: [u16; 2 * SAMPLES] = std::array::from_fn(|k| counts(i, k as u32));
            let mut results = [(Wrench::ZERO, Status::OK); SAMPLES];
            match i % 3 {
                0 => {
                    end.samples(&counts, turned, speed, &mut results);
                }
                1 => {
                    let signed = counts.map(|x| (i32::from(x) - 0x8000) as i16);
                    end.samples(&signed, turned, speed, &mut results);
                }
                _ => {
                    let metres: [f32; 2 * SAMPLES] =
                        std::array::from_fn(|k| input::<f32>(16 * i + k as u32).0.to_array()[k % 2]);
                    let ProbedBearing { bearing, channels, directions, offset, cage_ratio, shaft, cage, last_valid } =
                        end;
                    let mut of_metres = ProbedBearing {
                        bearing,
                        channels: [Metres; 2],
                        directions,
                        offset,
                        cage_ratio,
                        shaft,
                        cage,
                        last_valid,
                    };
                    of_metres.samples(&metres, turned, speed, &mut results);
                    let ProbedBearing { shaft, cage, last_valid, .. } = of_metres;
                    end = ProbedBearing { bearing, channels, directions, offset, cage_ratio, shaft, cage, last_valid };
                }
            }
            let all = results.iter().fold(Status::OK, |all, (_, status)| all | *status);
            seen |= all;
            sum.bits(u32::from(all.bits()));
            sum.add(results.iter().flat_map(|(wrench, _)| wrench.to_array()));
            for (_, status) in results {
                sum.bits(u32::from(status.bits()));
            }
        }
        sum.phase(end.shaft.0);
        sum.phase(end.cage.0);
        sum.bits(end.last_valid.held_count());
        for probe in &mut end.channels {
            sum.bits(probe.held_in_a_row());
            sum.bits(probe.held_count());
            let (there, status) = probe.sample(40_000);
            sum.bits(u32::from(status.bits()));
            sum.add([there]);
        }
    }
    assert!(seen.contains(Status::INPUT_NOT_OK | Status::INPUT_NOT_FINITE), "{seen:?}");
    for i in 1..=COUNT {
        let (u, cage) = finite_input(i);
        sum.bits(OK);
        let frame: [u8; 24] = ballrace::log::frame(cage.0 as u32, &[u.u, u.v, u.w, u.thu]);
        frame.into_iter().for_each(|byte| sum.bits(u32::from(byte)));
    }
    // After a reset.
    sum.bits(OK);
    sum.bits(0);
    sum.0
}

fn fixed_point() -> u64 {
    const SPECIAL: [i32; 4] = [0, i32::MAX, i32::MIN, -1];
    const RANGE: f64 = 100e-6;
    let counts = |i: u32, every: u32, factor: u32, modulus: u32| {
        let special = i.is_multiple_of(every).then(|| SPECIAL[(i / every) as usize % 4]);
        special.unwrap_or_else(|| i.wrapping_mul(factor).cast_signed() >> (i % modulus))
    };
    let [u, v, w] = [(7, 2_654_435_761, 13), (11, 2_246_822_519, 17), (5, 3_266_489_917, 19)]
        .map(|(every, factor, modulus)| move |i: u32| counts(i, every, factor, modulus));
    let cage = |i: u32| Phase(u64::from(i).wrapping_mul(0x0123_4567_89ab_cdef));
    let first = Phase(1 << 60);
    let params = |exponent| RadialParams { stiffness: 8e9, exponent, radial_play: 5e-6, range: RANGE };
    let seven = fixed_point::Radial::<7>::try_new(first, &params(1.5)).expect("parameters");
    let nine = fixed_point::Radial::<9>::try_new(first, &params(1.1)).expect("parameters");
    let params = AxialParams { stiffness: 1e9, exponent: 1.5, axial_play: 5e-6, radius: 20e-3, range: RANGE };
    let axial = fixed_point::Axial::<9>::try_new(first, &params).expect("parameters");
    let radial = |found: fixed_point::Reaction| (found.status, [found.fx, found.fy, found.load]);
    let of_seven = |i| radial(seven.reaction(u(i), v(i), cage(i)));
    let of_nine = |i| radial(nine.reaction(u(i), v(i), cage(i)));
    let of_axial = |i| {
        let found = axial.reaction(w(i), u(i), v(i), cage(i));
        (found.status, [found.fz, found.mx, found.my])
    };
    let mut sum = Checksum::new();
    sum.bits(STATE_INVALID);
    let forces: [&dyn Fn(u32) -> (Status, [i32; 3]); 3] = [&of_seven, &of_nine, &of_axial];
    for force in forces {
        sum.bits(OK);
        for i in 1..=COUNT {
            let (status, numbers) = force(i);
            sum.bits(u32::from(status.bits()));
            for x in numbers {
                sum.bits(x.cast_unsigned());
            }
        }
    }
    fixed_table(&mut sum, &de(), false);
    fixed_table(&mut sum, &nde(), false);
    fixed_table(&mut sum, &nde(), true);
    sum.0
}

fn fixed_table<const N: usize, const F: usize>(sum: &mut Checksum, of: &TabulatedBearing<f32, N, F>, mirrored: bool) {
    const SPECIAL: [i32; 4] = [0, i32::MAX, i32::MIN, -1];
    const FACTORS: [u32; 5] = [2_654_435_761, 2_246_822_519, 3_266_489_917, 668_265_263, 374_761_393];
    let params = TabulatedParams { speed: 1256.0, range: 1e-3, mirrored };
    let fixed = fixed_point::Tabulated::<N, _, F>::try_new(of, &params, [[0; F]; 19 * 11]).expect("parameters");
    sum.bits(OK);
    for i in 1..=COUNT {
        let [u, v, w, x, y] = [0, 1, 2, 3, 4].map(|k| match (i + k).is_multiple_of(9) {
            true => SPECIAL[(i / 9) as usize % 4],
            false => i.wrapping_mul(FACTORS[k as usize]).cast_signed() >> (5 + i % 11),
        });
        let found = fixed.reaction(u, v, w, x, y, Phase(u64::from(i).wrapping_mul(0x0123_4567_89ab_cdef)));
        sum.bits(u32::from(found.status.bits()));
        for x in [found.fx, found.fy, found.fz, found.mx, found.my] {
            sum.bits(x.cast_unsigned());
        }
    }
}

fn phases() -> u64 {
    let mut sum = Checksum::new();
    sum.phase(Phase::from_revolutions(-3.3).0);
    let per_count = ((1_u128 << 64) / 1000) as i64;
    sum.phase(per_count as u64);
    sum.phase(0);
    let ratio = SpeedRatio::new(0.3983);
    sum.phase((0.3983 * (1_u64 << 56) as f64) as u64);
    let (mut shaft, mut cage) = (Phase::ZERO, Phase::ZERO);
    for i in -50..200_i64 {
        let next = shaft.advanced(PhaseDelta(i * per_count));
        cage = cage.advanced(ratio.apply(next.since(shaft)));
        shaft = next;
        sum.phase(shaft.0);
        sum.phase(cage.0);
        sum.phase(cage.wrapping_mul((-i) as u64).0);
    }
    sum.add([cage.revolutions() as f32]);
    sum.0
}

const STEP: f32 = 2e-5;

fn start() -> Displacement<f32> {
    Displacement { w: 60e-6, ..Displacement::default() }
}

type Mounted = BearingAtStation<f32, Angular<f32, Exact, [ElementPosition<f32>; 9]>>;

fn system<const N: usize>() -> RotorBearingSystem<RigidRotor<f32>, Mounted, N> {
    let mut damping = [[0.0; 5]; 5];
    for (i, row) in damping.iter_mut().enumerate() {
        row[i] = if i < 3 { 400.0 } else { 0.4 };
    }
    let params = RotorParams {
        mass: 6.0,
        diametral_inertia: 0.030,
        polar_inertia: 0.006,
        damping,
        stiffness: [0.0; 5],
        gravity: [0.0, -9.80665, 0.0],
        load: [0.0, 0.0, 60.0, 0.0, 0.0],
    };
    let unbalance = Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 };
    let rotor = RigidRotor::try_new(&params, &[unbalance]).expect("a rotor");
    let bearing = Angular::try_new(geometry(), evenly_spaced(FIRST), DisplacementDatum::Centred).expect("a bearing");
    let at = |station, speed_ratios| BearingAtStation { bearing, station, speed_ratios };
    let all = [
        at(-0.1, SpeedRatios::new(0.3983)),
        at(0.1, SpeedRatios::new(0.3983)),
        at(-0.05, SpeedRatios::new(0.41).with_ball(-2.3).with_outer(0.1)),
        at(0.05, SpeedRatios::new(0.39)),
    ];
    RotorBearingSystem { rotor, bearings: std::array::from_fn(|i| all[i]) }
}

fn shaft_at(i: u32) -> ShaftMotion<f32> {
    ShaftMotion { angle: Phase(u64::from(i) << 55), speed: 613.5923, acceleration: 1000.0 }
}

fn rotor<const N: usize>(cages: [u64; N]) -> u64 {
    let mut sum = Checksum::new();
    let (system, integrator) = (system::<N>(), Verlet { step: STEP });
    let mut state = RotorState::stationary(start(), Phase::ZERO, cages.map(Phase));
    sum.bits(OK);
    for i in 0..400 {
        let mut shaft = shaft_at(i);
        if i % 50 == 17 {
            shaft.speed = f32::NAN;
        }
        sum.bits(u32::from(integrator.step(&system, &mut state, &shaft).bits()));
        sum.bits(OK);
        sum.add(state.q);
        sum.add(state.velocity);
    }
    assert_eq!(state.held_steps, 8);
    assert!(state.q.iter().all(|x| x.abs() < 1e-3), "{state:?}");
    sum.0
}

const PROBES: usize = 4;

fn observer() -> u64 {
    const PART: usize = 5 * PROBES;
    const COUNT: usize = 4 * PART + PROBES * PROBES;
    let exact = |i: usize, n: usize| (i * 37 % n) as f32 - (n / 2) as f32;
    let gain = |speed: usize| {
        let entry = |i: usize| {
            let scale = [1.0 / 4096.0, 0.25, 256.0, 128.0, 1024.0][i / PART];
            exact(speed * COUNT + i, 101) * scale
        };
        let part = |k: usize| std::array::from_fn(|p| std::array::from_fn(|i| entry(k * PART + 5 * p + i)));
        SpeedGain {
            position: part(0),
            rate: part(1),
            load: part(2),
            rotating_load: part(3),
            whitening: std::array::from_fn(|p| std::array::from_fn(|i| entry(4 * PART + PROBES * p + i))),
        }
    };
    let observer = Observer::<_, _, _, _, _, 5, 2, PROBES> {
        system: system::<2>(),
        integrator: Verlet { step: STEP },
        step: STEP,
        substeps: 2,
        probes: std::array::from_fn(|p| std::array::from_fn(|i| exact(5 * p + i, 19) / 16.0)),
        gains: [gain(0), gain(1)],
        speeds: [100.0, 1.0 / 128.0],
        load_retention: 0.875,
        gate: 50.0,
    };
    let mut state = ObserverState::new(RotorState::stationary(start(), Phase::ZERO, [Phase(0), Phase(1 << 62)]));
    let mut sum = Checksum::new();
    let mut seen = Status::OK;
    let mut corrected = 0;
    sum.bits(OK);
    for i in 1..=200_u32 {
        let mut readings = finite_input(i).0.to_array();
        if i % 20 == 7 {
            readings[(i / 20) as usize % PROBES] = f32::NAN;
        }
        let readings = std::array::from_fn(|k| readings[k] / 16.0);
        let estimate = observer.sample::<Exact>(&mut state, &shaft_at(2 * i), &readings);
        seen = seen.union(estimate.status);
        corrected += u32::from(!estimate.status.contains(Status::INNOVATION_REJECTED));
        sum.bits(u32::from(estimate.status.bits()));
        sum.bits(OK);
        sum.add(estimate.innovation);
        sum.add([estimate.nis]);
        for part in [state.motion.q, state.motion.velocity, state.load, state.rotating_load] {
            sum.add(part);
        }
    }
    assert!(seen.contains(Status::INPUT_NOT_FINITE), "{seen:?}");
    assert!((1..=200).contains(&corrected), "{corrected} corrected");
    sum.0
}

fn indicators() -> u64 {
    let line = |shaft, cage, ball| OrderLine { shaft, cage, ball };
    let lines = [line(1, 0, 0), line(0, 9, 0), line(9, -9, 0), line(0, 0, 2)];
    let mut tracker = OrderTracker::<f32, 4>::new(lines, 2, Phase::ZERO);
    let mut statistics = Statistics::<f32>::new(64);
    let mut envelope = Envelope::new(3000.0, 500.0, 12_800.0);
    let mut force = ForceOrderTracker::<f32, 4>::new(9, 2, &BearingKinematicState::default());
    let (mut sum, mut blocks) = (Checksum::new(), 0);
    for status in [OK, OK, OK, INVALID_ARGUMENT, OK] {
        sum.bits(status);
    }
    let complete = |ended: bool| if ended { BLOCK_COMPLETE } else { OK };
    for i in 1..=COUNT {
        let (u, _) = finite_input(i);
        let times = |n: u64| Phase(u64::from(i).wrapping_mul(n));
        let (shaft, ball) = (Phase(u64::from(i) << 57), times(0x0123_4567_89ab_cdef));
        let cage = Phase(times(0x3333_3333_3333_3333).0 >> 5);
        let (x, y) = (u.u * 65536.0, u.v * 65536.0);
        let ended = tracker.add::<Exact>(x, shaft, &ComponentAngles { cage, ball, outer: Phase::ZERO });
        sum.bits(complete(ended));
        if ended {
            sum.add(tracker.vectors().iter().flatten().copied());
        }
        let block = statistics.add::<Exact>(x);
        sum.bits(complete(block.is_some()));
        if let Some(b) = block {
            sum.add([b.mean, b.rms, b.peak_to_peak, b.crest_factor, b.kurtosis]);
        }
        sum.bits(OK);
        sum.add([envelope.add::<Exact>(x)]);
        let at = BearingKinematicState { inner: shaft, ball, ..cage.into() };
        let ended = force.add::<Exact>([x, y], &at);
        sum.bits(complete(ended));
        if ended {
            blocks += 1;
            sum.bits(OK);
            let orders = force.close();
            for ForceLine { forward, backward } in [orders.outer, orders.inner, orders.element].into_iter().flatten() {
                sum.add(forward);
                sum.add(backward);
            }
        }
    }
    assert!(blocks >= 2, "{blocks} blocks");
    sum.0
}

/// Status bits of rejected calls, with the name of the rejected parameter.
fn misuse() -> u64 {
    let mut sum = Checksum::new();
    for status in [STATE_INVALID, 0, STATE_INVALID, STATE_INVALID, OK, STATE_INVALID, INVALID_ARGUMENT] {
        sum.bits(status);
    }
    for letter in "pitch_diameter".bytes() {
        sum.bits(u32::from(letter));
    }
    for status in [STATE_INVALID, INVALID_ARGUMENT] {
        sum.bits(status);
    }
    for letter in "linear_range".bytes() {
        sum.bits(u32::from(letter));
    }
    sum.bits(STATE_INVALID);
    sum.bits(INVALID_ARGUMENT);
    sum.0
}

/// Lines `name;checksum` as the image prints them.
pub fn lines() -> String {
    let mut text = String::new();
    let mut line = |name: &str, sum: u64| writeln!(text, "{name};{sum:016x}").expect("a text grows");
    for subject in subjects() {
        line(subject.0, of_bearing(&subject));
    }
    line("blocks", blocks());
    line("fixed point", fixed_point());
    line("phases", phases());
    line("rotor on 2 bearings", rotor([0, 1 << 62]));
    line("rotor on 4 bearings", rotor([0, 1 << 62, 1 << 61, 3]));
    line("observer", observer());
    line("indicators", indicators());
    line("misuse", misuse());
    text
}
