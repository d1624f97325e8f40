//! Balls in equilibrium: 60 cases to dmN 1.5e6, every ball's loads and angles.

use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace::bearing::quasi_static::{BallState, QuasiStatic};
use ballrace::bearing::{Bearing, ElementPosition};
use ballrace::contact::hertz::Material;
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase, Scalar, Status};
use ballrace_tests::compare::relative_to_largest;
use serde::Deserialize;

#[derive(Deserialize)]
struct GoldenBall {
    inner_load: f64,
    outer_load: f64,
    inner_angle: f64,
    outer_angle: f64,
    centrifugal: f64,
    gyroscopic_moment: f64,
    orbital_speed: f64,
}

#[derive(Deserialize)]
struct Case {
    elements: usize,
    ball_diameter: f64,
    pitch_diameter: f64,
    inner_conformity: f64,
    outer_conformity: f64,
    contact_angle: f64,
    density: f64,
    youngs_modulus: f64,
    poissons_ratio: f64,
    race_control: String,
    friction_sharing: String,
    inner_speed: f64,
    outer_speed: f64,
    azimuth_of_first_element: f64,
    displacement: [f64; 5],
    force: [f64; 5],
    balls: Vec<GoldenBall>,
}

fn cases() -> Vec<Case> {
    #[derive(Deserialize)]
    struct File {
        cases: Vec<Case>,
    }
    serde_json::from_str::<File>(include_str!("quasi_static.json")).unwrap().cases
}

struct Found<T> {
    force: Vec<f64>,
    status: Status,
    balls: Vec<BallState<T>>,
}

fn evaluate<T: Scalar>(case: &Case, cage: f64) -> Found<T>
where
    Exact: Math<T>,
{
    let material = Material { youngs_modulus: case.youngs_modulus, poissons_ratio: case.poissons_ratio };
    let geometry = BallBearingGeometry {
        ball_diameter: case.ball_diameter,
        pitch_diameter: case.pitch_diameter,
        inner_conformity: case.inner_conformity,
        outer_conformity: case.outer_conformity,
        contact_angle: case.contact_angle,
        ball: material,
        race: material,
    };
    let inertia = InertiaParams {
        density: case.density,
        centrifugal: true,
        gyroscopic: true,
        race_control: match case.race_control.as_str() {
            "outer" => RaceControl::Outer,
            "inner" => RaceControl::Inner,
            other => panic!("{other}"),
        },
        friction_sharing: match case.friction_sharing.as_str() {
            "outer" => FrictionSharing::Outer,
            "equal" => FrictionSharing::Equal,
            "proportional" => FrictionSharing::Proportional,
            other => panic!("{other}"),
        },
    };
    let first = Phase::from_radians(case.azimuth_of_first_element - cage);
    let places: Vec<ElementPosition<T>> =
        (0..case.elements).map(|j| ElementPosition::evenly_spaced(first, j, case.elements)).collect();
    let bearing = QuasiStatic::<T, Exact, _>::try_new(geometry, places, DisplacementDatum::Touching).unwrap();
    let bearing = bearing.with_inertia(&inertia).unwrap();
    let rotation = BearingKinematicState {
        cage: Phase::from_radians(cage),
        inner_speed: T::from_f64(case.inner_speed),
        outer_speed: T::from_f64(case.outer_speed),
        ..BearingKinematicState::default()
    };
    let u = Displacement::from_array(case.displacement.map(T::from_f64));
    let reaction = bearing.reaction(&u, &rotation);
    let mut balls = vec![BallState::default(); case.elements];
    bearing.ball_states(&u, &rotation, &mut balls);
    Found { force: reaction.wrench.to_array().map(Scalar::to_f64).to_vec(), status: reaction.status, balls }
}

fn largest_error<T: Scalar>(cage: f64) -> f64
where
    Exact: Math<T>,
{
    let error = |case: &Case| {
        let found = evaluate::<T>(case, cage);
        assert!(!found.status.contains(Status::NOT_CONVERGED));
        relative_to_largest(&found.force, &case.force)
    };
    cases().iter().map(error).fold(0.0, f64::max)
}

#[test]
fn forces_in_both_precisions_whatever_the_cage_angle() {
    assert_eq!(cases().len(), 60);
    for cage in [0.0, 0.3, 4.0] {
        let (double, single) = (largest_error::<f64>(cage), largest_error::<f32>(cage));
        println!("quasi-static, cage at {cage} rad: f64 {double:.2e}, f32 {single:.2e}");
        assert!(double < 1e-9, "{double:e}");
        assert!(single < 2e-4, "{single:e}");
    }
}

#[test]
fn every_ball() {
    for case in cases() {
        let found = evaluate::<f64>(&case, 0.0);
        let load = case.balls.iter().map(|b| b.inner_load.max(b.outer_load)).fold(0.0, f64::max);
        for (ball, golden) in found.balls.iter().zip(&case.balls) {
            let close = |found: f64, expected: f64, scale: f64| {
                assert!((found - expected).abs() < 1e-9 * scale, "{found} {expected}, scale {scale}");
            };
            close(ball.inner_load, golden.inner_load, load);
            close(ball.outer_load, golden.outer_load, load);
            close(ball.centrifugal, golden.centrifugal, golden.centrifugal.max(1.0));
            close(ball.orbital_speed, golden.orbital_speed, case.inner_speed.max(1.0));
            let torque = case.ball_diameter * load;
            close(ball.gyroscopic_moment, golden.gyroscopic_moment, torque);
            let angle = |[cos, sin]: [f64; 2]| sin.atan2(cos);
            if golden.inner_load > 1e-9 {
                close(angle(ball.inner_direction), golden.inner_angle, 10.0);
            }
            if golden.outer_load > 1e-9 {
                close(angle(ball.outer_direction), golden.outer_angle, 10.0);
            }
        }
    }
}

/// Harris' 218 bearing under 17.8 kN of thrust: `published.json` has what three independent programs found.
#[test]
fn harris_218_at_speed() {
    let published: serde_json::Value = serde_json::from_str(include_str!("published.json")).unwrap();
    let published = &published["harris_218_computed"];
    let input = |key: &str| published["inputs"][key].as_f64().unwrap();
    let diameter = input("ball_diameter");
    let material = Material { youngs_modulus: input("youngs_modulus"), poissons_ratio: input("poissons_ratio") };
    let geometry = BallBearingGeometry {
        ball_diameter: diameter,
        pitch_diameter: input("pitch_diameter"),
        inner_conformity: input("groove_radius") / diameter,
        outer_conformity: input("groove_radius") / diameter,
        contact_angle: input("contact_angle_deg").to_radians(),
        ball: material,
        race: material,
    };
    let inertia = InertiaParams {
        density: input("density"),
        centrifugal: true,
        gyroscopic: true,
        race_control: RaceControl::Outer,
        friction_sharing: FrictionSharing::Outer,
    };
    let places: Vec<ElementPosition<f64>> =
        (0..16).map(|j| ElementPosition::evenly_spaced(Phase::ZERO, j, 16)).collect();
    let bearing = QuasiStatic::<f64, Exact, _>::try_new(geometry, places, DisplacementDatum::Touching).unwrap();
    let bearing = bearing.with_inertia(&inertia).unwrap();
    let cases = published["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 4);
    for case in cases {
        let figure = |key: &str| case[key].as_f64().unwrap();
        let at = BearingKinematicState {
            inner_speed: figure("rpm") * std::f64::consts::TAU / 60.0,
            ..BearingKinematicState::default()
        };
        let u = Displacement { w: figure("delta_a_um") * 1e-6, ..Displacement::default() };
        let reaction = bearing.reaction(&u, &at);
        assert!((reaction.wrench.fz / -input("axial_load_N") - 1.0).abs() < 5e-5, "{}", reaction.wrench.fz);
        let mut balls = [BallState::default(); 16];
        bearing.ball_states(&u, &at, &mut balls);
        let degrees = |[cos, sin]: [f64; 2]| sin.atan2(cos).to_degrees();
        for (found, expected) in [
            (balls[5].inner_load, figure("inner_load_N")),
            (balls[5].outer_load, figure("outer_load_N")),
            (degrees(balls[5].inner_direction), figure("inner_angle_deg")),
            (degrees(balls[5].outer_direction), figure("outer_angle_deg")),
        ] {
            assert!((found / expected - 1.0).abs() < 5e-5, "{} rpm: {found} {expected}", figure("rpm"));
        }
    }
}
