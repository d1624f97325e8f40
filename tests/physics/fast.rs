//! The fast math backend: how far off it is, in both directions (a bound that became loose is wrong too).

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{Bearing, ElementPositions, evenly_spaced};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::{Displacement, Exact, Fast, Math, Phase};
use ballrace_tests::bearings::acbb_s_geometry;
use ballrace_tests::compare::relative_to_largest;

/// (bound, what) with the error found between half the bound and the bound.
fn within(what: &str, error: f64, bound: f64) {
    assert!(error <= bound, "{what}: {error:e} is above {bound:e}");
    assert!(error >= 0.5 * bound, "{what}: {error:e}: the bound {bound:e} has become loose");
}

#[test]
fn square_root_and_ninth_root() {
    let grid = (0..200_000).map(|i| 10_f64.powf(-12.0 + 1e-4 * f64::from(i) * 0.9));
    let (mut root, mut ninth, mut exact_ninth) = (0.0_f64, 0.0_f64, 0.0_f64);
    for x in grid {
        root = root.max((<Fast as Math<f64>>::sqrt(x) / x.sqrt() - 1.0).abs());
        ninth = ninth.max(
            (f64::from(<Fast as Math<f32>>::ninth_root(x as f32)) / f64::from(x as f32).powf(1.0 / 9.0) - 1.0).abs(),
        );
        exact_ninth = exact_ninth.max((<Exact as Math<f64>>::ninth_root(x) / x.powf(1.0 / 9.0) - 1.0).abs());
    }
    within("fast square root", root, 1.8e-3);
    within("ninth root in f32", ninth, 3.5e-7);
    assert!(exact_ninth < 1e-15, "{exact_ninth:e}");
    assert_eq!(<Fast as Math<f32>>::sqrt(0.0), 0.0);
    // Its ninth power and the rounding of that stay above the subnormal numbers.
    let at_rest = <Exact as Math<f64>>::ninth_root(0.0);
    assert!(at_rest < 1e-30 && (f64::EPSILON * at_rest.powi(9)).is_normal(), "{at_rest:e}");
}

/// Every exponent of use over the whole range of deflections, and what is outside it.
#[test]
fn powers_in_single_precision() {
    let power = <Exact as Math<f32>>::powf;
    let mut largest = 0.0_f64;
    for n in [1.0_f32, 10.0 / 9.0, 1.37, 1.5, 2.2] {
        for i in 0..200_000 {
            let x = 10_f32.powf(-14.0 + 16.0 * i as f32 / 200_000.0);
            largest = largest.max((f64::from(power(x, n)) / f64::from(x).powf(f64::from(n)) - 1.0).abs());
        }
        assert_eq!(power(0.0, n), 0.0);
        assert!(power(f32::from_bits(1), n) < 1e-37, "a subnormal number counts as hardly anything");
        assert!(!power(f32::INFINITY, n).is_finite() && !power(f32::NAN, n).is_finite());
    }
    within("power", largest, 2.6e-7);
    assert_eq!(power(1e30, 1.5), f32::INFINITY);
}

#[test]
fn sine_and_cosine_of_the_turn_counter() {
    let (mut single, mut double) = (0.0_f64, 0.0_f64);
    for i in 0..1_000_000_u64 {
        let turn = Phase(i.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let (sin, cos) = turn.radians().sin_cos();
        let (s, c): (f32, f32) = Exact::sin_cos(turn);
        let (sd, cd): (f64, f64) = Exact::sin_cos(turn);
        single = single.max((f64::from(s) - sin).abs()).max((f64::from(c) - cos).abs());
        double = double.max((sd - sin).abs()).max((cd - cos).abs());
    }
    within("f32", single, 2.5e-7);
    // Most of this is the rounding of the reference's own angle in radians.
    within("f64", double, 1.1e-15);
}

#[test]
fn forces() {
    // The error goes up and down with the size of the deflection: all sizes within a factor of 16.
    let sizes = (0..200).map(|i| 2.0_f64.powf(4.0 * f64::from(i) / 200.0));
    let wrenches = |bearing: &dyn Bearing<f32>| -> Vec<[f64; 5]> {
        let at = |size: f64| {
            let u = [12e-6, 4e-6, 20e-6, 1e-4, -5e-5].map(|x| (x * size) as f32);
            bearing.reaction(&Displacement::from_array(u), &Phase::from_revolutions(0.1).into()).wrench
        };
        sizes.clone().map(|size| at(size).to_array().map(f64::from)).collect()
    };
    macro_rules! compare {
        ($what:literal, $bound:expr, $make:expr) => {{
            let (exact, fast) = (wrenches(&$make(Exact)), wrenches(&$make(Fast)));
            let errors = fast.iter().zip(&exact).map(|(fast, exact)| relative_to_largest(fast, exact));
            within($what, errors.fold(0.0, f64::max), $bound);
        }};
    }
    fn radial<M: Math<f32>, L: ballrace::contact::law::LoadDeflectionLaw<f32, M>>(
        _: M,
        law: L,
    ) -> Radial<f32, M, L, ElementPositions<f32, 9>> {
        Radial::try_new(evenly_spaced(Phase::ZERO), law, 2e-6).unwrap()
    }
    fn angular<M: Math<f32>>(_: M) -> Angular<f32, M, ElementPositions<f32, 14>> {
        Angular::try_new(acbb_s_geometry(), evenly_spaced(Phase::ZERO), DisplacementDatum::Touching).unwrap()
    }
    compare!("lumped, 3/2", 1.8e-3, |m| radial(m, PointContactLaw { stiffness: 8e9 }));
    compare!("angular", 3e-3, angular);
    let (line, power) = (LineContactLaw { stiffness: 3e8 }, PowerLaw { stiffness: 2e9, exponent: 1.37 });
    assert_eq!(wrenches(&radial(Exact, line)), wrenches(&radial(Fast, line)), "no square root in the line law");
    assert_eq!(wrenches(&radial(Exact, power)), wrenches(&radial(Fast, power)), "nor in any other power");
}
