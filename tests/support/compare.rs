//! Relative errors as the golden files define them.

/// Largest difference of two vectors over the largest size in `expected`.
pub fn relative_to_largest(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(f64::MIN_POSITIVE);
    found.iter().zip(expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / scale
}

/// |found - expected| / |expected|.
pub fn relative(found: f64, expected: f64) -> f64 {
    (found - expected).abs() / expected.abs()
}
