//! Bearings that several tests use.

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace::bearing::surface::{BearingComponent, Feature, Spall, SpallShape, SurfaceDeviation};
use ballrace::bearing::{Bearing, ElementPositions};
use ballrace::contact::hertz::Material;
use ballrace::{Exact, Phase};

/// Balls and races of a 6205 with a diametral clearance.
pub fn deep_groove_geometry(clearance: f64) -> BallBearingGeometry {
    let geometry = BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    geometry.with_clearance(clearance).expect("a possible clearance")
}

/// A 6205-size ball bearing with `N` balls and a diametral clearance.
pub fn deep_groove<const N: usize>(clearance: f64) -> Angular<f64, Exact, ElementPositions<f64, N>> {
    Angular::try_new(deep_groove_geometry(clearance), evenly_spaced(Phase::ZERO), DisplacementDatum::Centred)
        .expect("a possible bearing")
}

/// The geometry of the bearing "ACBB-S": 14 balls of 7 mm on 38.5 mm at 25 degrees, conformity 0.52.
pub fn acbb_s_geometry() -> BallBearingGeometry {
    BallBearingGeometry {
        ball_diameter: 7e-3,
        pitch_diameter: 38.5e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 25.0_f64.to_radians(),
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    }
}

/// Harris' 218 bearing.
pub fn harris_218_geometry() -> BallBearingGeometry {
    let material = Material { youngs_modulus: 206.91e9, ..BEARING_STEEL };
    BallBearingGeometry {
        ball_diameter: 22.23e-3,
        pitch_diameter: 125.26e-3,
        inner_conformity: 11.63 / 22.23,
        outer_conformity: 11.63 / 22.23,
        contact_angle: 40_f64.to_radians(),
        ball: material,
        race: material,
    }
}

/// Steel balls with centrifugal force and gyroscopic moment, outer race control.
pub const STEEL_BALLS: InertiaParams = InertiaParams {
    density: 7800.0,
    centrifugal: true,
    gyroscopic: true,
    race_control: RaceControl::Outer,
    friction_sharing: FrictionSharing::Outer,
};

/// The bearing "ACBB-S".
pub fn angular_contact() -> Angular<f64, Exact, ElementPositions<f64, 14>> {
    Angular::try_new(acbb_s_geometry(), evenly_spaced(Phase::ZERO), DisplacementDatum::Touching)
        .expect("a possible bearing")
}

/// The deep groove bearing with a spall under the load.
pub fn spalled() -> impl Bearing<f64> {
    let spall = Spall::new(BearingComponent::Outer, Phase::from_revolutions(0.01), 0.3, 2e-6, SpallShape::HalfSine);
    deep_groove::<9>(10e-6).with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Spall(spall)]))
}
