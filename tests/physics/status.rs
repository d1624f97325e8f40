//! Bad samples are flagged, counted and replaced by the last valid value.

use ballrace::bearing::{Bearing, LastValidWrench};
use ballrace::{Displacement, Phase, Status};
use ballrace_tests::bearings::deep_groove;

const GOOD: Displacement<f64> = Displacement { u: 12e-6, v: 4e-6, w: 20e-6, thu: 1e-4, thv: -5e-5 };

#[test]
fn not_a_number_and_infinities_are_held_and_counted() {
    let bearing = deep_groove::<9>(10e-6);
    let mut held = LastValidWrench::new();
    let (first, status) = bearing.sample(&mut held, &Displacement { v: f64::NAN, ..GOOD }, &Phase::ZERO.into());
    assert!(status.contains(Status::INPUT_NOT_FINITE));
    assert_eq!(first.to_array(), [0.0; 5], "nothing seen yet");
    let (good, status) = bearing.sample(&mut held, &GOOD, &Phase::ZERO.into());
    assert_eq!(status, Status::OK);
    assert!(good.fx < 0.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for k in 0..5 {
            let mut u = GOOD.to_array();
            u[k] = bad;
            let (answer, status) = bearing.sample(&mut held, &Displacement::from_array(u), &Phase::ZERO.into());
            assert_eq!(answer, good);
            assert!(status.is_held() && status.contains(Status::INPUT_NOT_FINITE));
        }
    }
    assert_eq!(held.held_count(), 16);
}

#[test]
fn overflow_is_flagged_as_such() {
    let bearing = deep_groove::<9>(10e-6);
    let mut held = LastValidWrench::new();
    let (good, _) = bearing.sample(&mut held, &GOOD, &Phase::ZERO.into());
    let (answer, status) = bearing.sample(&mut held, &Displacement { u: 1e300, ..GOOD }, &Phase::ZERO.into());
    assert!(status.contains(Status::RESULT_NOT_FINITE) && !status.contains(Status::INPUT_NOT_FINITE));
    assert_eq!(answer, good);
}

#[test]
fn lost_contact_is_a_status_and_no_error() {
    let bearing = deep_groove::<9>(10e-6);
    let mut held = LastValidWrench::new();
    let (wrench, status) = bearing.sample(&mut held, &Displacement::default(), &Phase::ZERO.into());
    assert_eq!(status, Status::CONTACT_LOST);
    assert!(!status.is_held());
    assert_eq!(wrench.to_array(), [0.0; 5]);
    assert_eq!(held.held_count(), 0);
}
