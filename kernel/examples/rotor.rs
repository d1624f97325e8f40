//! A rigid rotor with unbalance on two deep-groove ball bearings, integrated in time.
//!
//! Run it with `cargo run --release -p ballrace --example rotor`. It prints the mean force of both bearings on the rotor and
//! the peak-to-peak orbit of the centre of mass over the last 20 revolutions.

use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::rotor::{
    BearingAtStation, Integrator, RigidRotor, RotorBearingSystem, RotorParams, RotorState, ShaftMotion, SpeedRatios,
    Unbalance, Verlet,
};
use ballrace::{DeepGroove, Displacement, Phase};

/// Steps of the integrator per revolution.
const STEPS: u32 = 1000;
const REVOLUTIONS: u32 = 60;
/// Revolutions at the end that count.
const COUNTED: u32 = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let geometry = BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    }
    .with_clearance(10e-6)?;
    let bearing = DeepGroove::<f64, 9>::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)?;

    let mut damping = [[0.0; 5]; 5];
    for (i, row) in damping.iter_mut().enumerate() {
        row[i] = if i < 3 { 2000.0 } else { 2.0 };
    }
    let params = RotorParams {
        mass: 6.0,
        diametral_inertia: 0.030,
        polar_inertia: 0.006,
        damping,
        stiffness: [0.0; 5],
        gravity: [0.0, -9.806_65, 0.0],
        load: [0.0, 0.0, 100.0, 0.0, 0.0],
    };
    let unbalance = Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 };
    let rotor = RigidRotor::<f64>::try_new(&params, &[unbalance])?;
    let at = |station| BearingAtStation { bearing, station, speed_ratios: SpeedRatios::new(0.3983) };
    let system = RotorBearingSystem { rotor, bearings: [at(-0.1), at(0.1)] };

    // Constant speed of 3000 rpm; the state starts at rest in the middle of the clearance.
    let speed = 3000.0 * std::f64::consts::TAU / 60.0;
    let integrator = Verlet { step: std::f64::consts::TAU / speed / f64::from(STEPS) };
    let mut shaft = ShaftMotion { angle: Phase::ZERO, speed, acceleration: 0.0 };
    let mut state = RotorState::stationary(Displacement::default(), Phase::ZERO, [Phase::ZERO; 2]);

    let (mut sum, mut least, mut greatest) = ([0.0; 3], [f64::MAX; 2], [f64::MIN; 2]);
    for step in 0..STEPS * REVOLUTIONS {
        integrator.step(&system, &mut state, &shaft);
        shaft = shaft.after(integrator.step);
        if step >= STEPS * (REVOLUTIONS - COUNTED) {
            let kinematics = system.kinematic_states(&state.component_angles, &shaft);
            let [fx, fy, fz, ..] = system.bearing_forces(&state.q, &kinematics).force;
            for (sum, force) in sum.iter_mut().zip([fx, fy, fz]) {
                *sum += force / f64::from(STEPS * COUNTED);
            }
            let Displacement { u, v, .. } = state.displacement();
            for (i, x) in [u, v].into_iter().enumerate() {
                (least[i], greatest[i]) = (least[i].min(x), greatest[i].max(x));
            }
        }
    }
    println!("held_steps,{}", state.held_steps);
    println!("mean_force_N,{},{},{}", sum[0], sum[1], sum[2]);
    println!("peak_to_peak_um,{},{}", (greatest[0] - least[0]) * 1e6, (greatest[1] - least[1]) * 1e6);
    Ok(())
}
