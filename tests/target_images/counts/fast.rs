//! What the micromath backend costs in error.

use ballrace::bearing::Bearing;
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::lumped::Radial;
use ballrace::contact::law::PointContactLaw;
use ballrace::{Displacement, Exact, Fast, Math, Phase};
use ballrace_tests::bearings::deep_groove_geometry;
use ballrace_tests::compare::relative_to_largest;

/// Largest relative errors of `Fast` against `Exact` in f32.
pub struct Errors {
    pub root: f64,
    pub radial: f64,
    pub angular: f64,
}

/// The root over two octaves, which is all there is to it; the forces over deflections within a factor of 16.
pub fn errors() -> Errors {
    let root = (0..100_000)
        .map(|i| 1.0 + 3.0 * i as f32 / 100_000.0)
        .map(|x| f64::from(<Fast as Math<f32>>::sqrt(x)) / f64::from(x).sqrt() - 1.0)
        .fold(0.0, |largest: f64, error| largest.max(error.abs()));
    Errors {
        root,
        radial: force_error(&radial::<Exact>(), &radial::<Fast>()),
        angular: force_error(&angular::<Exact>(), &angular::<Fast>()),
    }
}

fn radial<M: Math<f32>>() -> impl Bearing<f32> {
    let places = evenly_spaced::<f32, 9>(Phase::ZERO);
    Radial::<f32, M, _, _>::try_new(places, PointContactLaw { stiffness: 8e9 }, 5e-6).expect("a bearing")
}

fn angular<M: Math<f32>>() -> impl Bearing<f32> {
    let places = evenly_spaced::<f32, 9>(Phase::ZERO);
    Angular::<f32, M, _>::try_new(deep_groove_geometry(10e-6), places, DisplacementDatum::Centred).expect("a bearing")
}

fn force_error(exact: &impl Bearing<f32>, fast: &impl Bearing<f32>) -> f64 {
    let error = |i: i32| {
        let size = 2.0_f64.powf(4.0 * f64::from(i) / 200.0);
        let u = Displacement::from_array([8e-6, 3e-6, 20e-6, 1e-4, -5e-5].map(|x| (x * size) as f32));
        let wrench = |bearing: &dyn Bearing<f32>| {
            bearing.reaction(&u, &Phase::from_revolutions(0.1).into()).wrench.to_array().map(f64::from)
        };
        relative_to_largest(&wrench(fast), &wrench(exact))
    };
    (0..200).map(error).fold(0.0, f64::max)
}
