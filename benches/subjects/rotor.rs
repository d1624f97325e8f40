//! One time step of a rotor on ball bearings, each step from the state that the one before left.

use super::{INPUTS, Subject, geometry};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::kinematics::orders;
use ballrace::bearing::{ElementPositions, evenly_spaced};
use ballrace::rotor::{
    BearingAtStation, Integrator, Newmark, RigidRotor, RotorBearingSystem, RotorParams, RotorState, RungeKuttaNystrom,
    ShaftMotion, SpeedRatios, Unbalance, Verlet,
};
use ballrace::{Displacement, Exact, Math, Phase, Scalar};
use std::hint::black_box;

/// Balls of the bearings under which the integrators are compared.
const BALLS: usize = 9;
const STEP: f64 = 1e-5;
const SPEED: f64 = 300.0;

type BallBearing<T, const N: usize> = Angular<T, Exact, ElementPositions<T, N>>;
type Rotor<T, const N: usize, const B: usize> =
    RotorBearingSystem<RigidRotor<T, Exact>, BearingAtStation<T, BallBearing<T, N>>, B>;

/// How the cost grows with the elements and with the bearings.
pub fn lines(column: &'static str) -> Result<Vec<Subject>, InvalidParameter> {
    Ok(vec![
        verlet::<8, 2>(column)?,
        verlet::<16, 2>(column)?,
        verlet::<32, 2>(column)?,
        verlet::<64, 2>(column)?,
        verlet::<16, 1>(column)?,
        verlet::<16, 4>(column)?,
        verlet::<16, 8>(column)?,
    ])
}

fn verlet<const N: usize, const B: usize>(column: &'static str) -> Result<Subject, InvalidParameter> {
    let run = stepping(machine::<f64, N, B>()?, Verlet { step: STEP });
    let row = format!("rotor step, Verlet: {B} angular bearing{}, N = {N}", if B == 1 { "" } else { "s" });
    Ok(Subject::new(row, column, INPUTS, run))
}

/// Two of the integrators.
pub fn steps<T: Scalar>(column: &'static str) -> Result<[Subject; 2], InvalidParameter>
where
    Exact: Math<T>,
{
    let step = T::from_f64(STEP);
    let explicit = stepping(machine::<T, BALLS, 2>()?, RungeKuttaNystrom { step });
    let implicit = stepping(machine::<T, BALLS, 2>()?, Newmark { step, newton_steps: 3 });
    let subject = |row: &str, run| Subject::new(row, column, INPUTS, run);
    Ok([
        subject("rotor step, two angular bearings, N = 9: RungeKuttaNystrom", explicit),
        subject("rotor step, two angular bearings, N = 9: Newmark, 3 Newton steps", implicit),
    ])
}

fn stepping<T: Scalar, const N: usize, const B: usize>(
    machine: Rotor<T, N, B>,
    integrator: impl Integrator<T> + 'static,
) -> Box<dyn FnMut()>
where
    Exact: Math<T>,
{
    let mut state = RotorState::stationary(Displacement::default(), Phase::ZERO, [Phase::ZERO; B]);
    let mut drive = ShaftMotion { angle: Phase::ZERO, speed: T::from_f64(SPEED), acceleration: T::ZERO };
    Box::new(move || {
        for _ in 0..INPUTS {
            black_box(integrator.step(black_box(&machine), &mut state, black_box(&drive)));
            drive = drive.after(T::from_f64(STEP));
        }
        assert_eq!(state.held_steps, 0, "a rotor that has left the numbers takes another time a step");
    })
}

fn machine<T: Scalar, const N: usize, const B: usize>() -> Result<Rotor<T, N, B>, InvalidParameter>
where
    Exact: Math<T>,
{
    let geometry = geometry()?;
    let cage = orders(N, geometry.gamma(), geometry.ball_diameter / geometry.pitch_diameter).cage;
    let bearing = BallBearing::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)?;
    let mounted =
        |station| BearingAtStation { bearing, station: T::from_f64(station), speed_ratios: SpeedRatios::new(cage) };
    let unbalance = Unbalance { moment: 2e-5, angle: 0.0, station: 0.01 };
    // Evenly along 320 mm.
    let station = |i| 0.32 * ((i as f64 + 0.5) / B as f64 - 0.5);
    let bearings = std::array::from_fn(|i| mounted(station(i)));
    Ok(RotorBearingSystem { rotor: RigidRotor::try_new(&rotor(), &[unbalance])?, bearings })
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
