//! The wrapping turn counter loses nothing.

use ballrace::Turn;
use ballrace::turn::{Arc, Ratio};

#[test]
fn a_million_turns_forth_and_back_end_where_they_began() {
    let step = Arc::from_radians(0.1_f64);
    let there = (0..1_000_000).fold(Turn::ZERO, |t, _| t.advanced(step));
    let back = (0..1_000_000).fold(there, |t, _| t.advanced(Arc(-step.0)));
    assert_eq!(back, Turn::ZERO);
}

#[test]
fn a_cage_keeps_its_ratio_over_a_month_at_full_speed() {
    // 1e8 turns in arcs of a quarter turn: the ratio's rounding is at most 2^-63 of each arc.
    let ratio = Ratio::new(0.398_273);
    let quarter = Arc(1 << 62);
    let mut cage = Turn::ZERO;
    for _ in 0..4_000_000 {
        cage = cage.advanced(ratio.of(quarter));
    }
    // The same by whole turns in integers: ratio.value() is a multiple of 2^-63, exactly a double here.
    let expected = Turn(((ratio.value() * (1_u64 << 63) as f64) as u128 * 2 * 1_000_000) as u64);
    let drift = cage.since(expected).0.unsigned_abs();
    assert!(drift <= 4_000_000, "{drift} counts of 2^-64 turn");
}

#[test]
fn angles_come_back() {
    for degrees in [0.0, 1.0, 90.0, 179.0, 270.0, 359.9] {
        let turn = Turn::from_radians(f64::to_radians(degrees));
        assert!((turn.radians().to_degrees() - degrees).abs() < 1e-12);
        assert_eq!(turn.plus(turn.reversed()), Turn::ZERO);
    }
    assert_eq!(Turn::from_radians(f64::NAN), Turn::ZERO);
    assert_eq!(Turn::from_radians(f64::INFINITY), Turn::ZERO);
    assert_eq!(Turn::from_revolutions(-1e-30), Turn::ZERO, "rounds up to a whole turn");
    assert_eq!(Turn::from_revolutions(0.25).times(3), Turn::from_revolutions(0.75));
}
