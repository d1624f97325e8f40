use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{Bearing, ElementPositions, evenly_spaced};
use ballrace::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw, PowerLaw};
use ballrace::{Displacement, Exact, Math, Phase, Scalar};
use ballrace_tests::compare::relative_to_largest;
use ballrace_tests::lumped::{Case, cases};
use ballrace_tests::with_elements;

struct Evaluated {
    force: [f64; 5],
    radial_loads: Vec<f64>,
    axial_loads: Vec<f64>,
    /// Sum of the reactions on the housing points, along X, Y, Z.
    housing: [f64; 3],
}

/// The case with the cage turned by `cage` and the elements turned back by as much: the force may not change.
fn evaluate<T, L, A, const N: usize>(case: &Case, radial: L, axial: Option<A>, cage: Phase) -> Evaluated
where
    T: Scalar,
    Exact: Math<T>,
    L: LoadDeflectionLaw<T, Exact>,
    A: LoadDeflectionLaw<T, Exact>,
{
    let first = Phase::from_radians(case.azimuth_of_first_element).wrapping_add(cage.reversed());
    let places: ElementPositions<T, N> = evenly_spaced(first);
    let radial = Radial::<T, Exact, L, _>::try_new(places, radial, case.radial_play).unwrap();
    let u = Displacement::from_array(case.displacement.map(T::from_f64));
    let mut housing = [HousingPoint::default(); N];
    if let Some(given) = &case.housing_displacement {
        for (point, given) in housing.iter_mut().zip(given) {
            point.displacement = given.map(T::from_f64);
        }
    }
    let (mut radial_loads, mut axial_loads) = ([T::ZERO; N], [T::ZERO; N]);
    let rigid = case.housing_displacement.is_none();
    let wrench = match (case.axial, axial) {
        (Some(given), Some(law)) => {
            let axial = Axial::<T, Exact, A, _>::try_new(places, law, given.play, given.radius).unwrap();
            axial.element_loads(&u, &cage.into(), &mut axial_loads);
            radial.element_loads(&u, &cage.into(), &mut radial_loads);
            let both = Combined(radial, axial);
            let flexible = both.reaction_flexible(&u, &cage.into(), &mut housing).wrench;
            if rigid {
                assert_eq!(flexible, both.reaction(&u, &cage.into()).wrench, "a rigid ring is a flexible one at rest");
            }
            flexible
        }
        _ => {
            radial.element_loads(&u, &cage.into(), &mut radial_loads);
            radial.reaction_flexible(&u, &cage.into(), &mut housing).wrench
        }
    };
    let sum = housing.iter().fold([0.0; 3], |s, p| [0, 1, 2].map(|i| s[i] + p.reaction[i].to_f64()));
    let to_f64 = |loads: [T; N]| loads.iter().map(|x| x.to_f64()).collect();
    Evaluated {
        force: wrench.to_array().map(Scalar::to_f64),
        radial_loads: to_f64(radial_loads),
        axial_loads: to_f64(axial_loads),
        housing: sum,
    }
}

fn evaluate_with_law<T>(case: &Case, cage: Phase) -> Evaluated
where
    T: Scalar,
    Exact: Math<T>,
{
    let k = T::from_f64(case.stiffness);
    let ka = case.axial.map(|a| T::from_f64(a.stiffness));
    assert!(case.axial.is_none_or(|a| a.exponent == case.exponent));
    with_elements!(
        case.elements,
        N,
        if case.exponent == 1.5 {
            evaluate::<T, _, _, N>(
                case,
                PointContactLaw { stiffness: k },
                ka.map(|stiffness| PointContactLaw { stiffness }),
                cage,
            )
        } else {
            evaluate::<T, _, _, N>(
                case,
                LineContactLaw { stiffness: k },
                ka.map(|stiffness| LineContactLaw { stiffness }),
                cage,
            )
        }
    )
}

fn largest_error<T>(cage: Phase) -> f64
where
    T: Scalar,
    Exact: Math<T>,
{
    cases()
        .iter()
        .map(|case| {
            let found = evaluate_with_law::<T>(case, cage);
            relative_to_largest(&found.force, &case.force)
        })
        .fold(0.0, f64::max)
}

#[test]
fn forces_in_both_precisions_whatever_the_cage_angle() {
    assert_eq!(cases().len(), 120);
    for degrees in [0.0, 17.0, 133.0, 211.0, 359.0] {
        let cage = Phase::from_revolutions(degrees / 360.0);
        let (double, single) = (largest_error::<f64>(cage), largest_error::<f32>(cage));
        println!("lumped at {degrees} deg: f64 {double:.2e}, f32 {single:.2e}");
        assert!(double < 1e-12, "{double:e}");
        assert!(single < 5e-6, "{single:e}");
    }
}

#[test]
fn element_loads_of_rigid_cases() {
    for case in cases().iter().filter(|c| c.housing_displacement.is_none()) {
        let found = evaluate_with_law::<f64>(case, Phase::ZERO);
        let golden = |i: usize| case.element_loads.iter().map(|l| l[i]).collect::<Vec<_>>();
        assert!(relative_to_largest(&found.radial_loads, &golden(0)) < 1e-12);
        if case.axial.is_some() {
            assert!(relative_to_largest(&found.axial_loads, &golden(1)) < 1e-12);
        }
    }
}

#[test]
fn action_equals_reaction_on_the_housing() {
    for case in cases() {
        let found = evaluate_with_law::<f64>(&case, Phase::ZERO);
        let scale = found.radial_loads.iter().chain(&found.axial_loads).sum::<f64>().max(1.0);
        for (ring, housing) in found.force.iter().zip(found.housing) {
            assert!((ring + housing).abs() < 1e-12 * scale, "{ring} {housing}");
        }
    }
}

#[test]
fn the_general_exponent_agrees_with_the_special_ones() {
    for case in cases() {
        let k = case.stiffness;
        let axial = case.axial.map(|a| PowerLaw { stiffness: a.stiffness, exponent: a.exponent });
        let general = with_elements!(
            case.elements,
            N,
            evaluate::<f64, _, _, N>(&case, PowerLaw { stiffness: k, exponent: case.exponent }, axial, Phase::ZERO)
        );
        assert!(relative_to_largest(&general.force, &case.force) < 1e-12);
    }
}
