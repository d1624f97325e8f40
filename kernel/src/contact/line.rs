//! Line contact of a roller between two races.

/// Returns the stiffness of a steel roller of effective length `length` (m) between both races, N/m^(10/9): `Q = 35948
/// L^(8/9) delta^(10/9)` in N and mm.
///
/// Source: ISO/TS 16281 (lamina method), after Palmgren, Grundlagen der Waelzlagertechnik.
#[must_use]
pub fn roller_stiffness(length: f64) -> f64 {
    // mm^(10/9 + 8/9) = 1e6 per m^2: the powers of ten join.
    35_948.0e6 * libm::pow(length, 8.0 / 9.0)
}
