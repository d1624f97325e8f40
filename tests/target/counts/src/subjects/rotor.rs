//! One step of a rotor on two bearings.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::rotor::{
    AttachedBearing, Attachment, ForceElement, Integrator, InvalidMatrix, LinearSystem, Newmark, RotorBearingSystem,
    RotorState, RungeKuttaNystrom, SecondOrderSystem, ShaftMotion, SpeedRatios, SteadyVerlet, Support, Verlet,
    supported_rotor,
};
use ballrace::{Exact, Math, Phase, Scalar, Status};
use core::hint::black_box;
use rig::{Ball, CAGE_RATIO, Rig, geometry, machine, params};

pub fn all<T: Scalar>(bench: &Bench, precision: &'static str)
where
    Exact: Math<T>,
{
    let Ok(rig) = black_box(rig::<T>()) else { return };
    let dt = T::from_f64(2e-5);
    let (rigid, newmark) = ("rotor on two angular bearings", Newmark { step: dt, newton_steps: 3 });
    steps(bench, (rigid, precision, "Runge-Kutta-Nystrom step"), &rig, &RungeKuttaNystrom { step: dt });
    steps(bench, (rigid, precision, "Verlet step"), &rig, &Verlet { step: dt });
    steady_steps(bench, (rigid, precision), &rig, Verlet { step: dt });
    steps(bench, (rigid, precision, "Newmark step, 3 Newton steps"), &rig, &newmark);
    let Ok(rig) = black_box(supported_rig::<T>()) else { return };
    let soft = "the same in two supports, nine coordinates";
    steps(bench, (soft, precision, "Verlet step"), &rig, &Verlet { step: dt });
    steady_steps(bench, (soft, precision), &rig, Verlet { step: dt });
    steps(bench, (soft, precision, "Newmark step, 3 Newton steps"), &rig, &newmark);
}

fn rig<T: Scalar>() -> Result<Rig<T>, InvalidParameter>
where
    Exact: Math<T>,
{
    machine(Angular::try_new(geometry()?, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)?)
}

#[inline(never)]
fn step<T: Scalar, I: Integrator<T>, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize>(
    integrator: &I,
    machine: &RotorBearingSystem<R, C, 2>,
    state: &mut RotorState<T, D, 2>,
    drive: &ShaftMotion<T>,
) -> Status {
    integrator.step(machine, state, drive)
}

/// The same rotor with its two bearings in supports: nine coordinates from matrices.
type SupportedRig<T> = RotorBearingSystem<LinearSystem<T, Exact, 9>, AttachedBearing<T, Ball<T>, 9>, 2>;

fn supported_rig<T: Scalar>() -> Result<SupportedRig<T>, InvalidParameter>
where
    Exact: Math<T>,
{
    let bearing = Angular::try_new(geometry()?, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)?;
    let support = Support { mass: 2.0, stiffness: [[3e7, 0.0], [0.0, 2e7]], damping: [[200.0, 0.0], [0.0, 200.0]] };
    let matrices = supported_rotor::<9>(&params(), &[], &[support; 2])?;
    let refused = |e: InvalidMatrix| InvalidParameter { name: e.matrix, found: e.found, expected: e.expected };
    let at = |i: usize, station| AttachedBearing {
        bearing,
        attachment: Attachment::on_rigid_rotor(station, Some(5 + 2 * i)),
        speed_ratios: SpeedRatios::new(CAGE_RATIO),
    };
    Ok(RotorBearingSystem {
        rotor: LinearSystem::try_new(&matrices).map_err(refused)?,
        bearings: [at(0, -0.1), at(1, 0.1)],
    })
}

pub fn steps<T: Scalar, I: Integrator<T>, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize>(
    bench: &Bench,
    (what, precision, function): (&'static str, &'static str, &'static str),
    machine: &RotorBearingSystem<R, C, 2>,
    integrator: &I,
) {
    let name = Name { what, elements: 9, precision, math: "exact", function };
    let entry = step::<T, I, R, C, D> as *const ();
    bench.measure(name, entry, start, |(state, drive)| step(integrator, machine, state, drive));
}

pub fn start<T: Scalar, const D: usize>(i: u32) -> (RotorState<T, D, 2>, ShaftMotion<T>) {
    let (u, angle) = input::<T>(i);
    let mut q = [T::ZERO; D];
    for (entry, x) in q.iter_mut().zip(u.to_array()) {
        *entry = x;
    }
    let state = RotorState::stationary(q, angle.wrapping_mul(3), [angle, angle.wrapping_mul(5)]);
    let speed = if i.is_multiple_of(7) { u.u } else { u.w * T::from_f64(1e7) };
    (state, ShaftMotion { angle, speed, acceleration: T::ZERO })
}

/// Steps at the speed that the integrator is ready for.
pub fn steady_steps<T: Scalar, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize>(
    bench: &Bench,
    (what, precision): (&'static str, &'static str),
    machine: &RotorBearingSystem<R, C, 2>,
    verlet: Verlet<T>,
) {
    let name = Name { what, elements: 9, precision, math: "exact", function: "Verlet step at the speed of the last" };
    let entry = steady_step::<T, R, C, D> as *const ();
    let ready = |i| {
        let (state, drive) = start(i);
        (SteadyVerlet::new(verlet, &machine.rotor, drive.speed), state, drive)
    };
    bench.measure(name, entry, ready, |(steady, state, drive)| steady_step(steady, machine, state, drive));
}

#[inline(never)]
fn steady_step<T: Scalar, R: SecondOrderSystem<T, D>, C: ForceElement<T, D>, const D: usize>(
    steady: &mut SteadyVerlet<T, D>,
    machine: &RotorBearingSystem<R, C, 2>,
    state: &mut RotorState<T, D, 2>,
    drive: &ShaftMotion<T>,
) -> Status {
    steady.step(machine, state, drive)
}
