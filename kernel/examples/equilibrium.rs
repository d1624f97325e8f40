//! Static equilibrium of one deep-groove ball bearing under a radial and an axial load.
//!
//! Run it with `cargo run --release -p ballrace --example equilibrium`. It prints the displacement of the inner ring, the
//! stiffness there and the load on every ball.

use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::rotor::{BearingAtStation, RigidRotor, RotorBearingSystem, RotorParams, SpeedRatios, equilibrium};
use ballrace::{Bearing, DeepGroove, Displacement, Phase};

const BALLS: usize = 9;

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
    let bearing = DeepGroove::<f64, BALLS>::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)?;

    // The load acts on a rotor of one bearing; its mass does not matter without gravity.
    let params = RotorParams {
        mass: 1.0,
        diametral_inertia: 1e-3,
        polar_inertia: 1e-3,
        damping: [[0.0; 5]; 5],
        stiffness: [0.0; 5],
        gravity: [0.0; 3],
        load: [1000.0, 0.0, 200.0, 0.0, 0.0],
    };
    let rotor = RigidRotor::<f64>::try_new(&params, &[])?;
    let mounted = BearingAtStation { bearing, station: 0.0, speed_ratios: SpeedRatios::new(0.4) };
    let system = RotorBearingSystem { rotor, bearings: [mounted] };
    let kinematics = Phase::ZERO.into();

    let found = equilibrium(&system, &[kinematics], Displacement::default());
    let u = found.displacement();
    println!("residual,{:e}", found.residual);
    println!("displacement_um,{},{},{}", u.u * 1e6, u.v * 1e6, u.w * 1e6);
    println!("stiffness_N_per_um,{},{}", found.stiffness[(0, 0)] * 1e-6, found.stiffness[(2, 2)] * 1e-6);
    let force = bearing.reaction(&u, &kinematics).wrench;
    println!("force_N,{},{},{}", force.fx, force.fy, force.fz);
    let mut loads = [0.0; BALLS];
    bearing.element_loads(&u, &kinematics, &mut loads);
    for (ball, load) in loads.iter().enumerate() {
        println!("ball,{ball},{load}");
    }
    Ok(())
}
