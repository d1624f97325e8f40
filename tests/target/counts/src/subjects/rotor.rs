//! One step of a rotor on two bearings.

use super::bearings::geometry;
use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::bearing::angular::{Angular, Zero};
use ballrace::bearing::{Places, even_places};
use ballrace::rotor::{
    Drive, Integrator, Machine, Mounted, Newmark, RigidRotor, RotorParams, RotorState, RungeKutta4, Unbalance,
};
use ballrace::turn::Ratio;
use ballrace::{Exact, Math, Scalar, Status, Turn};
use core::hint::black_box;

type Ball<T> = Angular<T, Exact, Places<T, 9>>;
type Rig<T> = Machine<T, Exact, Ball<T>, 2>;

pub fn all<T: Scalar>(bench: &Bench, precision: &'static str)
where
    Exact: Math<T>,
{
    let Some(rig) = black_box(rig::<T>()) else { return };
    let dt = T::from_f64(2e-5);
    steps(bench, precision, "Runge-Kutta 4 step", &rig, &RungeKutta4 { step: dt });
    steps(bench, precision, "Newmark step, 3 Newton steps", &rig, &Newmark { step: dt, newton_steps: 3 });
}

fn rig<T: Scalar>() -> Option<Rig<T>>
where
    Exact: Math<T>,
{
    let mut damping = [[0.0; 5]; 5];
    for (i, row) in damping.iter_mut().enumerate() {
        if let Some(entry) = row.get_mut(i) {
            *entry = if i < 3 { 400.0 } else { 0.4 };
        }
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
    let rotor = RigidRotor::try_new(&params, &[Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 }]).ok()?;
    let angular = Angular::try_new(geometry()?, even_places(Turn::ZERO), Zero::Centred).ok()?;
    let at = |station| Mounted { bearing: angular, station: T::from_f64(station), cage_ratio: Ratio::new(0.4) };
    Some(Machine { rotor, bearings: [at(-0.1), at(0.1)] })
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
