use ballrace::bearing::Bearing;
use ballrace::bearing::roller::{QuasiStaticRoller, RollerState};
use ballrace::{Exact, Fast, Math, Scalar, Status};
use ballrace_tests::compare::relative_to_largest;
use ballrace_tests::rollers::{Case, cases};

fn relative(found: f64, expected: f64, largest: f64) -> f64 {
    (found - expected).abs() / largest.max(f64::MIN_POSITIVE)
}

/// Largest relative error of force, tangent's force and largest lamina load.
fn series<T: Scalar, M: Math<T>>(case: &Case) -> f64 {
    let (u, at) = case.motion::<T>();
    let bearing = case.bearing::<T, M>();
    let reaction = bearing.reaction(&u, &at);
    assert_eq!(reaction.status, Status::OK);
    assert_eq!(bearing.reaction_and_stiffness(&u, &at).0, reaction);
    let mut states = vec![RollerState::default(); case.elements];
    bearing.roller_states(&u, &at, &mut states);
    let largest = states.iter().map(|state| state.inner.largest_lamina_load.to_f64()).fold(0.0, f64::max);
    let mut laminae = vec![T::ZERO; case.laminae];
    let mut most = T::ZERO;
    let mut loads = vec![T::ZERO; case.elements];
    bearing.element_loads(&u, &at, &mut loads);
    for (j, (state, load)) in states.iter().zip(&loads).enumerate() {
        bearing.lamina_loads(&u, &at, j, &mut laminae);
        most = laminae.iter().fold(most, |most, load| most.larger(*load));
        assert_eq!(state.inner.load, *load);
    }
    assert_eq!(most.to_f64(), largest);
    relative_to_largest(&reaction.wrench.to_array().map(Scalar::to_f64), &case.force).max(relative(
        largest,
        case.largest_lamina_load,
        case.largest_lamina_load,
    ))
}

/// Largest relative error of the force and of the loads of the rollers at both races.
fn equilibrium<T: Scalar, M: Math<T>>(case: &Case) -> f64 {
    let (u, at) = case.motion::<T>();
    let bearing = QuasiStaticRoller::try_new(case.bearing::<T, M>(), &case.inertia()).unwrap();
    let reaction = bearing.reaction(&u, &at);
    assert_eq!(reaction.status, Status::OK);
    assert_eq!(bearing.reaction_and_stiffness(&u, &at).0, reaction);
    let mut states = vec![RollerState::default(); case.elements];
    bearing.roller_states(&u, &at, &mut states);
    let largest = case.rollers.iter().fold(0.0, |most: f64, [_, outer, _]| most.max(*outer));
    let of_loads = states.iter().zip(&case.rollers).map(|(state, [inner, outer, _])| {
        relative(state.inner.load.to_f64(), *inner, largest).max(relative(state.outer.load.to_f64(), *outer, largest))
    });
    of_loads.fold(relative_to_largest(&reaction.wrench.to_array().map(Scalar::to_f64), &case.force), f64::max)
}

fn check(evaluate: fn(&Case) -> f64, in_equilibrium: bool, count: usize, tolerance: f64) {
    let cases: Vec<Case> = cases().into_iter().filter(|case| case.is_in_equilibrium() == in_equilibrium).collect();
    assert_eq!(cases.len(), count);
    let worst = cases.iter().map(evaluate).fold(0.0, f64::max);
    println!("{worst:e}");
    assert!(worst <= tolerance, "{worst:e}");
}

#[test]
fn series_of_both_contacts() {
    check(series::<f64, Exact>, false, 30, 1e-12);
    check(series::<f32, Exact>, false, 30, 5e-6);
    check(series::<f32, Fast>, false, 30, 5e-6);
}

#[test]
fn rollers_in_equilibrium() {
    check(equilibrium::<f64, Exact>, true, 12, 1e-9);
    check(equilibrium::<f32, Exact>, true, 12, 2e-4);
    check(equilibrium::<f32, Fast>, true, 12, 2e-4);
}
