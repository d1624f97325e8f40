//! Angles as 2^-64 revolutions: they wrap exactly and do not drift.

use ballrace::Phase;
use ballrace::phase::{PhaseDelta, SpeedRatio};

/// Converts revolutions; drops whole revolutions. NaN and infinity give 0. For set-up: uses `double`.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_from_revolutions(revolutions: f64) -> u64 {
    Phase::from_revolutions(revolutions).0
}

/// Returns the angle in revolutions, 0 to 1. For set-up: uses `double`.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_to_revolutions(phase: u64) -> f64 {
    Phase(phase).revolutions()
}

/// Returns the shorter signed difference from `earlier` to `phase`, 2^-64 revolutions.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_since(phase: u64, earlier: u64) -> i64 {
    Phase(phase).since(Phase(earlier)).0
}

/// Returns the angle advanced by `delta`.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_advance(phase: u64, delta: i64) -> u64 {
    Phase(phase).advanced(PhaseDelta(delta)).0
}

/// Returns `n` times the angle: the angle of the n-th harmonic.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_multiple(phase: u64, n: i32) -> u64 {
    Phase(phase).wrapping_mul(i64::from(n).cast_unsigned()).0
}

/// Returns the angle of one count of an encoder with `counts_per_revolution`, for `ballrace_phase_advance_counts`. For
/// set-up: one division. It is rounded down by less than 2^-64 revolution. 0 counts give 0.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_per_count(counts_per_revolution: u32) -> u64 {
    let turn = 1_u128 << 64;
    turn.checked_div(u128::from(counts_per_revolution)).unwrap_or(0) as u64
}

/// Returns the angle advanced by `counts` of an encoder, negative counts backwards. `phase_per_count` is the result of
/// `ballrace_phase_per_count`.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_phase_advance_counts(phase: u64, counts: i32, phase_per_count: u64) -> u64 {
    let delta = i64::from(counts).wrapping_mul(phase_per_count.cast_signed());
    Phase(phase).advanced(PhaseDelta(delta)).0
}

/// Converts the ratio of two speeds, between -128 and 128, for `ballrace_speed_ratio_apply`; saturates outside. For set-up:
/// uses `double`.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_speed_ratio(ratio: f64) -> i64 {
    SpeedRatio::new(ratio).bits()
}

/// Returns `ratio * delta`: the rotation of the cage for a rotation `delta` of the shaft, wrapped beyond half a revolution.
#[unsafe(no_mangle)]
pub extern "C" fn ballrace_speed_ratio_apply(ratio: i64, delta: i64) -> i64 {
    SpeedRatio::from_bits(ratio).apply(PhaseDelta(delta)).0
}
