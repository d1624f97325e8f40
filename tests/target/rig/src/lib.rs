//! The bearing and the rotor that several images measure or compare.
#![no_std]

use ballrace::bearing::ElementPositions;
use ballrace::bearing::angular::Angular;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry, InvalidParameter};
use ballrace::rotor::{BearingAtStation, RigidRotor, RotorBearingSystem, RotorParams, SpeedRatios, Unbalance};
use ballrace::{Exact, Math, Scalar};

/// Nine balls with variable contact angle.
pub type Ball<T> = Angular<T, Exact, ElementPositions<T, 9>>;
/// A rigid rotor on two of them.
pub type Rig<T> = RotorBearingSystem<RigidRotor<T, Exact>, BearingAtStation<T, Ball<T>>, 2>;

/// Cage speed over shaft speed of the bearing below.
pub const CAGE_RATIO: f64 = 0.398_3;

/// 6205 with 10 um of clearance.
///
/// # Errors
/// None with these numbers; constructors can always fail.
pub fn geometry() -> Result<BallBearingGeometry, InvalidParameter> {
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
}

/// 6 kg with an axial load.
#[must_use]
pub fn params() -> RotorParams {
    let mut damping = [[0.0; 5]; 5];
    for (i, row) in damping.iter_mut().enumerate() {
        if let Some(entry) = row.get_mut(i) {
            *entry = if i < 3 { 400.0 } else { 0.4 };
        }
    }
    RotorParams {
        mass: 6.0,
        diametral_inertia: 0.030,
        polar_inertia: 0.006,
        damping,
        stiffness: [0.0; 5],
        gravity: [0.0, -9.80665, 0.0],
        load: [0.0, 0.0, 60.0, 0.0, 0.0],
    }
}

/// The rotor on two bearings 0.2 m apart, with an unbalance.
///
/// # Errors
/// As [`geometry`].
pub fn machine<T: Scalar>(bearing: Ball<T>) -> Result<Rig<T>, InvalidParameter>
where
    Exact: Math<T>,
{
    let rotor = RigidRotor::try_new(&params(), &[Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 }])?;
    let at = |station| BearingAtStation {
        bearing,
        station: T::from_f64(station),
        speed_ratios: SpeedRatios::new(CAGE_RATIO),
    };
    Ok(RotorBearingSystem { rotor, bearings: [at(-0.1), at(0.1)] })
}
