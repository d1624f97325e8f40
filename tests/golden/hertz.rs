use ballrace::Scalar;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::contact::hertz::{Material, PointContact, Race};
use ballrace_tests::compare::relative;
use serde::Deserialize;

#[derive(Deserialize)]
struct Contact {
    ellipticity: f64,
    curvature_sum: f64,
    curvature_difference: f64,
    first_kind: f64,
    second_kind: f64,
    stiffness: f64,
    #[serde(rename = "semi_major_at_100N")]
    semi_major: f64,
    #[serde(rename = "semi_minor_at_100N")]
    semi_minor: f64,
    #[serde(rename = "peak_pressure_at_100N")]
    peak_pressure: f64,
}

#[derive(Deserialize)]
struct Case {
    ball_diameter: f64,
    pitch_diameter: f64,
    inner_conformity: f64,
    outer_conformity: f64,
    contact_angle: f64,
    ball_youngs_modulus: f64,
    ball_poissons_ratio: f64,
    race_youngs_modulus: f64,
    race_poissons_ratio: f64,
    inner: Contact,
    outer: Contact,
    combined_stiffness: f64,
}

#[derive(Deserialize)]
struct File {
    cases: Vec<Case>,
}

fn cases() -> Vec<Case> {
    serde_json::from_str::<File>(include_str!("hertz.json")).unwrap().cases
}

fn geometry(case: &Case) -> BallBearingGeometry {
    BallBearingGeometry {
        ball_diameter: case.ball_diameter,
        pitch_diameter: case.pitch_diameter,
        inner_conformity: case.inner_conformity,
        outer_conformity: case.outer_conformity,
        contact_angle: case.contact_angle,
        ball: Material { youngs_modulus: case.ball_youngs_modulus, poissons_ratio: case.ball_poissons_ratio },
        race: Material { youngs_modulus: case.race_youngs_modulus, poissons_ratio: case.race_poissons_ratio },
    }
    .checked()
    .unwrap()
}

fn pairs(found: &PointContact, golden: &Contact) -> [(f64, f64); 9] {
    let (a, b, pressure) = found.ellipse(100.0);
    [
        (found.ellipticity, golden.ellipticity),
        (found.curvature_sum, golden.curvature_sum),
        (found.curvature_difference, golden.curvature_difference),
        (found.first_kind, golden.first_kind),
        (found.second_kind, golden.second_kind),
        (found.stiffness, golden.stiffness),
        (a, golden.semi_major),
        (b, golden.semi_minor),
        (pressure, golden.peak_pressure),
    ]
}

/// Largest error over all cases of what `T` holds after rounding once.
fn largest_error<T: Scalar>() -> f64 {
    let round = |x: f64| T::from_f64(x).to_f64();
    cases()
        .iter()
        .flat_map(|case| {
            let geometry = geometry(case);
            let combined = (geometry.stiffness(), case.combined_stiffness);
            let inner = pairs(&geometry.contact(Race::Inner), &case.inner);
            let outer = pairs(&geometry.contact(Race::Outer), &case.outer);
            inner.into_iter().chain(outer).chain([combined])
        })
        .map(|(found, golden)| relative(round(found), golden))
        .fold(0.0, f64::max)
}

#[test]
fn forty_contacts_in_f64() {
    assert_eq!(cases().len(), 40);
    let error = largest_error::<f64>();
    println!("hertz f64: {error:.2e}");
    assert!(error < 1e-12, "{error:e}");
}

#[test]
fn forty_contacts_in_f32() {
    let error = largest_error::<f32>();
    println!("hertz f32: {error:.2e}");
    assert!(error < 1e-6, "{error:e}");
}
