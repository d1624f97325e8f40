//! One step of a flexible rotor on two bearings, and one sample of its observer.

use super::rotor::{start, steady_steps, steps};
use crate::measure::{Bench, Name};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::rotor::{
    AttachedBearing, Attachment, ForceElement, InvalidMatrix, LinearSystem, RotorBearingSystem, RotorState,
    RungeKuttaNystrom, SecondOrderSystem, ShaftMotion, SpeedRatios, SystemMatrices, Verlet,
};
use ballrace::twin::{Estimate, Observer, ObserverState, SpeedGain};
use ballrace::{Exact, Phase};
use core::hint::black_box;
use rig::{Ball, CAGE_RATIO, geometry, machine};

type FlexibleRig<const D: usize> =
    RotorBearingSystem<LinearSystem<f32, Exact, D>, AttachedBearing<f32, Ball<f32>, D>, 2>;

const STEP: f32 = 2e-5;
/// Number of probes of the observers.
const PROBES: usize = 5;

pub fn all(bench: &Bench) {
    integrators::<6>(bench, "flexible rotor, 6 coordinates, two angular bearings");
    integrators::<9>(bench, "flexible rotor, 9 coordinates, two angular bearings");
    integrators::<12>(bench, "flexible rotor, 12 coordinates, two angular bearings");
    integrators::<16>(bench, "flexible rotor, 16 coordinates, two angular bearings");
    observers(bench);
}

// Functions of their own: together their systems would overflow the stack.
#[inline(never)]
fn integrators<const D: usize>(bench: &Bench, what: &'static str) {
    let Ok(rig) = black_box(flexible_rig::<D>()) else { return };
    steps(bench, (what, "f32", "Runge-Kutta-Nystrom step"), &rig, &RungeKuttaNystrom { step: STEP });
    steps(bench, (what, "f32", "Verlet step"), &rig, &Verlet { step: STEP });
    steady_steps(bench, (what, "f32"), &rig, Verlet { step: STEP });
}

#[inline(never)]
pub fn observers(bench: &Bench) {
    let (Ok(rigid), Ok(flexible)) = (bearing().and_then(machine), flexible_rig::<12>()) else { return };
    observer(bench, "observer of a rigid rotor, two angular bearings, 5 probes", rigid);
    observer(bench, "observer of a flexible rotor, 12 coordinates, two angular bearings, 5 probes", flexible);
}

fn bearing() -> Result<Ball<f32>, InvalidParameter> {
    Angular::try_new(geometry()?, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)
}

/// Returns the rigid rotor of the other subjects with `D - 5` elastic coordinates in pairs along X and Y.
#[inline(never)]
fn flexible_rig<const D: usize>() -> Result<FlexibleRig<D>, InvalidParameter> {
    let mut matrices = SystemMatrices::<D>::unit_mass().with_unbalance((0, 1), 120e-6, 0.3);
    for i in 0..D {
        let is_tilt = i == 3 || i == 4;
        matrices.mass[(i, i)] = if is_tilt { 0.03 } else { 6.0 };
        matrices.damping[(i, i)] = if is_tilt { 0.4 } else { 400.0 };
        if i >= 5 {
            matrices.stiffness[(i, i)] = 6e7 * f64::from(i as u32 - 4);
        }
    }
    (matrices.gyroscopic[(3, 4)], matrices.gyroscopic[(4, 3)]) = (0.006, -0.006);
    let refused = |e: InvalidMatrix| InvalidParameter { name: e.matrix, found: e.found, expected: e.expected };
    let bearing = bearing()?;
    let at = |station: f64| {
        let mut rows = [[0.0; D]; 5];
        for (i, row) in rows.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = match (i, j) {
                    (0, 4) => station,
                    (1, 3) => -station,
                    (0 | 1, 5..) if (i + j) % 2 == 1 => 0.7,
                    (3 | 4, 5..) if (i + j) % 2 == 1 => 20.0 * station,
                    _ => f64::from(u8::from(i == j)),
                };
            }
        }
        AttachedBearing { bearing, attachment: Attachment::new(&rows), speed_ratios: SpeedRatios::new(CAGE_RATIO) }
    };
    Ok(RotorBearingSystem { rotor: LinearSystem::try_new(&matrices).map_err(refused)?, bearings: [at(-0.1), at(0.1)] })
}

type RigObserver<R, C, const D: usize> = Observer<f32, R, C, Verlet<f32>, [SpeedGain<f32, D, PROBES>; 1], D, 2, PROBES>;

#[inline(never)]
fn sample<R: SecondOrderSystem<f32, D>, C: ForceElement<f32, D>, const D: usize>(
    observer: &RigObserver<R, C, D>,
    state: &mut ObserverState<f32, D, 2>,
    drive: &ShaftMotion<f32>,
    readings: &[f32; PROBES],
) -> Estimate<f32, PROBES> {
    observer.sample::<Exact>(state, drive, readings)
}

/// Measures one sample with one Verlet step per sample.
#[inline(never)]
fn observer<R: SecondOrderSystem<f32, D>, C: ForceElement<f32, D>, const D: usize>(
    bench: &Bench,
    what: &'static str,
    system: RotorBearingSystem<R, C, 2>,
) {
    let gains = |size: f32| {
        core::array::from_fn(|p| core::array::from_fn(|i| if (i + p) % 2 == 0 { size } else { 0.1 * size }))
    };
    let whitening = core::array::from_fn(|i| core::array::from_fn(|j| if j <= i { 1e6 } else { 0.0 }));
    let gain =
        SpeedGain { position: gains(0.1), rate: gains(10.0), load: gains(1e5), rotating_load: gains(1e4), whitening };
    let probes = core::array::from_fn(|p| core::array::from_fn(|i| if i % 2 == p % 2 { 1.0 } else { 0.1 }));
    let integrator = Verlet { step: STEP };
    let observer = black_box(Observer {
        system,
        integrator,
        step: STEP,
        substeps: 1,
        probes,
        gains: [gain],
        speeds: [0.0; 2],
        load_retention: 0.99999,
        gate: 51.0,
    });
    let name = Name { what, elements: 9, precision: "f32", math: "exact", function: "sample, one Verlet step" };
    let prepare = |i| {
        let (motion, drive): (RotorState<f32, D, 2>, _) = start(i);
        // Readings near the prediction, with the special values of the input in the state.
        let q = motion.q;
        let readings: [f32; PROBES] = core::array::from_fn(|p| q.get(p).copied().unwrap_or_default() * 1.01);
        (ObserverState::new(motion), drive, readings)
    };
    let entry = sample::<R, C, D> as *const ();
    bench.measure(name, entry, prepare, |(state, drive, readings)| sample(&observer, state, drive, readings));
}
