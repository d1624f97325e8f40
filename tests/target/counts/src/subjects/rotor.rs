//! One step of a rotor on two bearings.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::bearing::angular::{Angular, Zero};
use ballrace::bearing::even_places;
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::rotor::{Drive, Integrator, Newmark, RotorState, RungeKutta4};
use ballrace::{Exact, Math, Scalar, Status, Turn};
use core::hint::black_box;
use rig::{Rig, geometry, machine};

pub fn all<T: Scalar>(bench: &Bench, precision: &'static str)
where
    Exact: Math<T>,
{
    let Ok(rig) = black_box(rig::<T>()) else { return };
    let dt = T::from_f64(2e-5);
    steps(bench, precision, "Runge-Kutta 4 step", &rig, &RungeKutta4 { step: dt });
    steps(bench, precision, "Newmark step, 3 Newton steps", &rig, &Newmark { step: dt, newton_steps: 3 });
}

fn rig<T: Scalar>() -> Result<Rig<T>, InvalidParameter>
where
    Exact: Math<T>,
{
    machine(Angular::try_new(geometry()?, even_places(Turn::ZERO), Zero::Centred)?)
}

#[inline(never)]
fn step<T: Scalar, I: Integrator<T>>(
    integrator: &I,
    machine: &Rig<T>,
    state: &mut RotorState<T, 2>,
    drive: &Drive<T>,
) -> Status
where
    Exact: Math<T>,
{
    integrator.step(machine, state, drive)
}

fn steps<T: Scalar, I: Integrator<T>>(
    bench: &Bench,
    precision: &'static str,
    function: &'static str,
    machine: &Rig<T>,
    integrator: &I,
) where
    Exact: Math<T>,
{
    let what = "rotor on two angular bearings";
    let name = Name { what, elements: 9, precision, math: "exact", function };
    let prepare = |i| {
        let (u, angle) = input::<T>(i);
        let state = RotorState::at_rest(u, angle.times(3), [angle, angle.times(5)]);
        let speed = if i.is_multiple_of(7) { u.u } else { u.w * T::from_f64(1e7) };
        (state, Drive { angle, speed, acceleration: T::ZERO })
    };
    bench.measure(name, step::<T, I> as *const (), prepare, |(state, drive)| step(integrator, machine, state, drive));
}
