//! The wrapping turn counter loses nothing.

use ballrace::Phase;
use ballrace::phase::{PhaseDelta, SpeedRatio};

#[test]
fn a_million_revolutions_forward_and_backward_return_to_the_start() {
    let step = PhaseDelta::from_radians(0.1_f64);
    let there = (0..1_000_000).fold(Phase::ZERO, |t, _| t.advanced(step));
    let back = (0..1_000_000).fold(there, |t, _| t.advanced(PhaseDelta(-step.0)));
    assert_eq!(back, Phase::ZERO);
}

#[test]
fn a_cage_keeps_its_ratio_over_a_month_at_full_speed() {
    // 1e8 turns in arcs of a quarter turn: the ratio's rounding is at most 2^-63 of each arc.
    let ratio = SpeedRatio::new(0.398_273);
    let quarter = PhaseDelta(1 << 62);
    let mut cage = Phase::ZERO;
    for _ in 0..4_000_000 {
        cage = cage.advanced(ratio.apply(quarter));
    }
    // The same by whole turns in integers: ratio.value() is a multiple of 2^-63, exactly a double here.
    let expected = Phase(((ratio.value() * (1_u64 << 63) as f64) as u128 * 2 * 1_000_000) as u64);
    let drift = cage.since(expected).0.unsigned_abs();
    assert!(drift <= 4_000_000, "{drift} counts of 2^-64 turn");
}

#[test]
fn angles_round_trip() {
    for degrees in [0.0, 1.0, 90.0, 179.0, 270.0, 359.9] {
        let turn = Phase::from_radians(f64::to_radians(degrees));
        assert!((turn.radians().to_degrees() - degrees).abs() < 1e-12);
        assert_eq!(turn.wrapping_add(turn.reversed()), Phase::ZERO);
    }
    assert_eq!(Phase::from_radians(f64::NAN), Phase::ZERO);
    assert_eq!(Phase::from_radians(f64::INFINITY), Phase::ZERO);
    assert_eq!(Phase::from_revolutions(-1e-30), Phase::ZERO, "rounds up to a whole turn");
    assert_eq!(Phase::from_revolutions(0.25).wrapping_mul(3), Phase::from_revolutions(0.75));
}

/// Samples in an hour at 25.6 kHz.
const HOUR: u64 = 3_600 * 25_600;
const THIRTY_DAYS: u64 = 30 * 24 * HOUR;

/// An hour of samples, one after another, each a shaft increment and what the cage makes of it.
fn an_hour(shaft: (Phase, PhaseDelta), cage: (Phase, SpeedRatio)) -> (Phase, Phase) {
    let ((mut shaft, increment), (mut cage, ratio)) = (shaft, cage);
    for _ in 0..HOUR {
        let increment = std::hint::black_box(increment);
        shaft = shaft.advanced(increment);
        cage = cage.advanced(ratio.apply(increment));
    }
    (shaft, cage)
}

/// 30 000 rpm at 25.6 kHz is 5/256 of a turn a sample, exactly: after thirty days not one count of 2^-64 turn is missing.
///
/// One hour is stepped sample by sample; the counter forms a group, so the 719 others add the same hour again.
#[test]
fn thirty_days_at_full_speed_end_at_the_exact_angle() {
    let increment = PhaseDelta(5 << 56);
    let ratio = SpeedRatio::new(0.398_273);
    let (shaft, cage) = an_hour((Phase::ZERO, increment), (Phase::ZERO, ratio));
    let (again, cage_again) = an_hour((shaft, increment), (cage, ratio));
    assert_eq!((again, cage_again), (shaft.wrapping_mul(2), cage.wrapping_mul(2)), "each hour adds the same");

    let (shaft, cage) = (shaft.wrapping_mul(720), cage.wrapping_mul(720));
    // In turns: 66 355 200 000 samples * 5/256 is a whole number, 1 296 000 000.
    assert_eq!(THIRTY_DAYS * 5 % 256, 0);
    assert_eq!(shaft, Phase::ZERO);
    // The cage by one product in wide integers: it loses less than a count of 2^-64 turn a sample, 3.6e-9 turn in all.
    let numerator = (ratio.value() * (1_u64 << 63) as f64) as u128;
    let turns = THIRTY_DAYS * 5 / 256;
    let expected = Phase((numerator * 2).wrapping_mul(u128::from(turns)) as u64);
    let behind = expected.since(cage).0;
    assert!((0..THIRTY_DAYS as i64).contains(&behind), "{behind} counts behind");
}

/// A speed that no binary fraction is: the increment is rounded once, by at most 2^-65 turn, and that is all the drift.
#[test]
fn thirty_days_at_an_odd_speed_stay_within_the_rounding_of_one_increment() {
    // 29 998.7 rpm in turns a sample: 299 987 / (10 * 60 * 25 600).
    let (numerator, denominator) = (299_987_u128, 15_360_000_u128);
    let increment = PhaseDelta(((numerator << 64) / denominator) as i64);
    let (shaft, _) = an_hour((Phase::ZERO, increment), (Phase::ZERO, SpeedRatio::new(0.4)));
    let shaft = shaft.wrapping_mul(720);
    // The true angle in counts: samples * numerator / denominator turns, what is left of whole turns in 2^-64.
    let left = u128::from(THIRTY_DAYS) * numerator % denominator;
    let expected = Phase(((left << 64) / denominator) as u64);
    let behind = expected.since(shaft).0;
    assert!((0..=THIRTY_DAYS as i64).contains(&behind), "{behind} counts of 2^-64 turn, 3.6e-9 turn at most");
}
