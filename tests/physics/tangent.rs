//! The analytic 5 x 5 tangent of each model against central differences of its force.

use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{Bearing, ElementPositions, Mirrored, Reaction, evenly_spaced};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::{BearingKinematicState, Displacement, Exact, Phase, Stiffness};
use ballrace_tests::bearings::{angular_contact, deep_groove, spalled};

/// Loaded states: some elements deep, some off, tilts included.
const STATES: [[f64; 5]; 5] = [
    [12e-6, 4e-6, 20e-6, 1e-4, -5e-5],
    [2e-6, 1e-6, 10e-6, 1e-4, -5e-5],
    [-15e-6, 9e-6, 40e-6, -2e-4, 3e-4],
    [0.0, -18e-6, 65e-6, 0.0, 0.0],
    [25e-6, 0.0, -30e-6, 4e-4, 1e-4],
];

fn difference(bearing: &dyn Bearing<f64>, u: [f64; 5], cage: Phase) -> Stiffness<f64> {
    let mut k = Stiffness::zeros();
    for j in 0..5 {
        let step = if j < 3 { 1e-10 } else { 1e-9 };
        let at = |sign: f64| {
            let mut moved = u;
            moved[j] += sign * step;
            bearing.reaction(&Displacement::from_array(moved), &cage.into()).wrench.to_array()
        };
        let (ahead, behind) = (at(1.0), at(-1.0));
        for i in 0..5 {
            k[(i, j)] = (behind[i] - ahead[i]) / (2.0 * step);
        }
    }
    k
}

/// Largest difference, forces and moments made comparable by the lever arm of 20 mm.
fn mismatch(a: &Stiffness<f64>, b: &Stiffness<f64>) -> f64 {
    let arm = |i: usize| if i < 3 { 1.0 } else { 0.02 };
    let size = |m: &Stiffness<f64>| {
        let entries = (0..5).flat_map(|i| (0..5).map(move |j| (i, j)));
        entries.map(|(i, j)| m[(i, j)].abs() / arm(i) / arm(j)).fold(0.0, f64::max)
    };
    size(&(a - b)) / size(a).max(f64::MIN_POSITIVE)
}

fn check(name: &str, bearing: &dyn Bearing<f64>) {
    for (i, state) in STATES.into_iter().enumerate() {
        for degrees in [0.0, 13.0, 200.0] {
            let cage = Phase::from_revolutions(degrees / 360.0);
            let (reaction, analytic) = bearing.reaction_and_stiffness(&Displacement::from_array(state), &cage.into());
            let plain = bearing.reaction(&Displacement::from_array(state), &cage.into());
            assert_eq!(reaction, plain, "{name}: both ways give the same force");
            let error = mismatch(&analytic, &difference(bearing, state, cage));
            assert!(error < 2e-6, "{name}, state {i}, {degrees} deg: {error:e}");
            let asymmetry = mismatch(&analytic, &analytic.transpose());
            assert!(asymmetry < 1e-13, "{name}: {asymmetry:e}");
        }
    }
}

#[test]
fn angular() {
    check("deep groove", &deep_groove::<9>(10e-6));
    check("angular contact", &angular_contact());
    check("with a spall", &spalled());
    check("mirrored", &Mirrored(angular_contact()));
}

#[test]
fn lumped() {
    let places: ElementPositions<f64, 9> = evenly_spaced(Phase::from_revolutions(0.03));
    let point = PointContactLaw { stiffness: 8e9 };
    let line = LineContactLaw { stiffness: 3e8 };
    let power = PowerLaw { stiffness: 2e9, exponent: 1.37 };
    check("radial, 3/2, play", &Radial::<f64, Exact, _, _>::try_new(places, point, 5e-6).unwrap());
    check("radial, 3/2, preload", &Radial::<f64, Exact, _, _>::try_new(places, point, -5e-6).unwrap());
    check("radial, 10/9", &Radial::<f64, Exact, _, _>::try_new(places, line, 2e-6).unwrap());
    check("radial, 1.37", &Radial::<f64, Exact, _, _>::try_new(places, power, 2e-6).unwrap());
    let axial = Axial::<f64, Exact, _, _>::try_new(places, point, 1e-6, 0.02).unwrap();
    check("axial", &axial);
    let radial = Radial::<f64, Exact, _, _>::try_new(places, line, 2e-6).unwrap();
    check("combined", &Combined(radial, axial));
    check("combined, mirrored", &Mirrored(Combined(radial, axial)));
}

/// A bearing with a separate displacement of each housing point.
struct Displaced<B>(B, [HousingPoint<f64>; 9]);

impl<B: FlexibleRing<f64> + Send + Sync> Bearing<f64> for Displaced<B> {
    fn reaction(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Reaction<f64> {
        self.0.reaction_flexible(u, at, &mut self.1.clone())
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
    ) -> (Reaction<f64>, Stiffness<f64>) {
        self.0.reaction_and_stiffness_flexible(u, at, &mut self.1.clone())
    }
    fn element_loads(&self, _u: &Displacement<f64>, _at: &BearingKinematicState<f64>, _loads: &mut [f64]) {}
}

#[test]
fn flexible_outer_ring() {
    let places: ElementPositions<f64, 9> = evenly_spaced(Phase::from_revolutions(0.03));
    let radial = Radial::<f64, Exact, _, _>::try_new(places, LineContactLaw { stiffness: 3e8 }, 2e-6).unwrap();
    let axial = Axial::<f64, Exact, _, _>::try_new(places, PointContactLaw { stiffness: 8e9 }, 1e-6, 0.02).unwrap();
    let points = std::array::from_fn(|j| {
        let j = j as f64;
        HousingPoint {
            displacement: [(3.0 * j).sin() * 3e-6, (5.0 * j).cos() * 3e-6, j * 1e-6],
            ..HousingPoint::default()
        }
    });
    check("flexible", &Displaced(Combined(radial, axial), points));
}

#[test]
fn unloaded_elements_add_no_stiffness() {
    let places: ElementPositions<f64, 8> = evenly_spaced(Phase::ZERO);
    let far = Displacement { u: 1e-6, ..Displacement::default() };
    for exponent in [1.0, 1.0 + 1e-9, 2.0] {
        let law = PowerLaw { stiffness: 1e9, exponent };
        let bearing = Radial::<f64, Exact, _, _>::try_new(places, law, 5e-6).unwrap();
        let (reaction, k) = bearing.reaction_and_stiffness(&far, &Phase::ZERO.into());
        assert_eq!(reaction.load, 0.0);
        assert_eq!(k, Stiffness::zeros(), "exponent {exponent}");
    }
    let line = Radial::<f64, Exact, _, _>::try_new(places, LineContactLaw { stiffness: 1e9 }, 5e-6).unwrap();
    assert_eq!(line.reaction_and_stiffness(&far, &Phase::ZERO.into()).1, Stiffness::zeros());
}

#[test]
fn linear() {
    let (_, k) =
        deep_groove::<9>(10e-6).reaction_and_stiffness(&Displacement::from_array(STATES[0]), &Phase::ZERO.into());
    check("springs", &Linear::new(k));
}
