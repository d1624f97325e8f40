//! Central film thickness of point contacts.

use ballrace::bearing::quasi_static::film::{Lubricant, central_film};
use ballrace_tests::compare::relative;
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    radius_along_rolling: f64,
    ellipticity: f64,
    effective_modulus: f64,
    viscosity: f64,
    pressure_viscosity: f64,
    entrainment_speed: f64,
    load: f64,
    central_film: f64,
}

#[test]
fn forty_films() {
    #[derive(Deserialize)]
    struct File {
        cases: Vec<Case>,
    }
    let cases = serde_json::from_str::<File>(include_str!("film.json")).unwrap().cases;
    assert_eq!(cases.len(), 40);
    let error = |case: &Case| {
        let oil = Lubricant { viscosity: case.viscosity, pressure_viscosity: case.pressure_viscosity };
        let along = case.radius_along_rolling;
        let (modulus, kappa) = (case.effective_modulus, case.ellipticity);
        relative(central_film(oil, modulus, along, kappa, case.entrainment_speed, case.load), case.central_film)
    };
    let largest = cases.iter().map(error).fold(0.0, f64::max);
    println!("film: f64 {largest:.1e}");
    assert!(largest < 1e-12, "{largest:e}");
}
