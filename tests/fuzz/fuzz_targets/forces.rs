//! Any bits as displacement and rotation: finite forces or a status flag, in every model.
#![no_main]

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::quasi_static::QuasiStatic;
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace::bearing::{Bearing, ElementPositions, LastValidWrench, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::{BearingKinematicState, Displacement, Exact, Phase};
use libfuzzer_sys::fuzz_target;

fn judge(bearing: &impl Bearing<f32>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) {
    let (wrench, status) = bearing.sample(&mut LastValidWrench::new(), u, at);
    assert!(wrench.is_finite(), "{wrench:?}");
    let fresh = bearing.reaction(u, at).wrench;
    assert!(fresh.is_finite() || status.is_held(), "{fresh:?} {status:?}");
}

fuzz_target!(|bits: ([u32; 7], u64)| {
    let [u, v, w, thu, thv, inner_speed, outer_speed] = bits.0.map(f32::from_bits);
    let u = Displacement { u, v, w, thu, thv };
    let at = BearingKinematicState { inner_speed, outer_speed, ..BearingKinematicState::from(Phase(bits.1)) };
    let places: ElementPositions<f32, 9> = evenly_spaced(Phase::ZERO);
    let point = PointContactLaw { stiffness: 8e9 };
    let geometry = BallBearingGeometry {
        ball_diameter: 7e-3,
        pitch_diameter: 38.5e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.4,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    let inertia = InertiaParams {
        density: 7800.0,
        centrifugal: true,
        gyroscopic: true,
        race_control: RaceControl::Outer,
        friction_sharing: FrictionSharing::Outer,
    };
    let radial = Radial::<f32, Exact, _, _>::try_new(places, point, 5e-6).expect("a bearing");
    let axial = Axial::<f32, Exact, _, _>::try_new(places, point, 5e-6, 0.02).expect("a bearing");
    judge(&Combined(radial, axial), &u, &at);
    judge(
        &Angular::<f32, Exact, _>::try_new(geometry, places, DisplacementDatum::Touching).expect("a bearing"),
        &u,
        &at,
    );
    let solved =
        QuasiStatic::<f32, Exact, _>::try_new(geometry, places, DisplacementDatum::Touching).expect("a bearing");
    judge(&solved.with_outer_control(&inertia).expect("a bearing"), &u, &at);
});
