//! One time step of a rotor on two ball bearings, each step from the state that the one before left.

use super::{INPUTS, Subject, geometry};
use ballrace::bearing::angular::{Angular, Zero};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::kinematics::orders;
use ballrace::bearing::{Places, even_places};
use ballrace::rotor::{
    Drive, Gear, Integrator, Machine, Mounted, Newmark, RigidRotor, RotorParams, RotorState, RungeKutta4, Unbalance,
};
use ballrace::{Displacement, Exact, Math, Scalar, Turn};
use std::hint::black_box;

const BALLS: usize = 9;
const STEP: f64 = 1e-5;
const SPEED: f64 = 300.0;

type BallBearing<T> = Angular<T, Exact, Places<T, BALLS>>;
type Rotor<T> = Machine<RigidRotor<T, Exact>, Mounted<T, BallBearing<T>>, 2>;

/// Both integrators.
pub fn steps<T: Scalar>(column: &'static str) -> Result<[Subject; 2], InvalidParameter>
where
    Exact: Math<T>,
{
    let step = T::from_f64(STEP);
    let explicit = stepping(machine::<T>()?, RungeKutta4 { step });
    let implicit = stepping(machine::<T>()?, Newmark { step, newton_steps: 3 });
    let subject = |row: &str, run| Subject { row: row.into(), column, calls: INPUTS, run };
    Ok([
        subject("rotor step, two angular bearings, N = 9: RungeKutta4", explicit),
        subject("rotor step, two angular bearings, N = 9: Newmark, 3 Newton steps", implicit),
    ])
}

fn stepping<T: Scalar>(machine: Rotor<T>, integrator: impl Integrator<T> + 'static) -> Box<dyn FnMut()>
where
    Exact: Math<T>,
{
    let mut state = RotorState::at_rest(Displacement::default(), Turn::ZERO, [Turn::ZERO; 2]);
    let mut drive = Drive { angle: Turn::ZERO, speed: T::from_f64(SPEED), acceleration: T::ZERO };
    Box::new(move || {
        for _ in 0..INPUTS {
            black_box(integrator.step(black_box(&machine), &mut state, black_box(&drive)));
            drive = drive.after(T::from_f64(STEP));
        }
        assert_eq!(state.held, 0, "a rotor that has left the numbers takes another time a step");
    })
}

fn machine<T: Scalar>() -> Result<Rotor<T>, InvalidParameter>
where
    Exact: Math<T>,
{
    let geometry = geometry()?;
    let cage = orders(BALLS, geometry.gamma(), geometry.ball_diameter / geometry.pitch_diameter).cage;
    let bearing = BallBearing::try_new(geometry, even_places(Turn::ZERO), Zero::Centred)?;
    let mounted = |station| Mounted { bearing, station: T::from_f64(station), gear: Gear::new(cage) };
    let unbalance = Unbalance { moment: 2e-5, angle: 0.0, station: 0.01 };
    Ok(Machine { rotor: RigidRotor::try_new(&rotor(), &[unbalance])?, bearings: [mounted(-0.08), mounted(0.08)] })
}

fn rotor() -> RotorParams {
    let damping = [200.0, 200.0, 200.0, 0.5, 0.5];
    RotorParams {
        mass: 2.0,
        diametral_inertia: 8e-3,
        polar_inertia: 2e-3,
        damping: std::array::from_fn(|i| std::array::from_fn(|j| if i == j { damping[i] } else { 0.0 })),
        stiffness: [0.0; 5],
        gravity: [0.0, -9.81, 0.0],
        load: [0.0, -200.0, 50.0, 0.0, 0.0],
    }
}
