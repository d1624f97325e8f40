//! Angles as wrapping fixed-point fractions of a revolution.

use crate::scalar::Scalar;

/// An angle as a fraction of a revolution: the range of a `u64` is one revolution.
///
/// Addition wraps exactly: an angle that grows for years keeps its resolution of 2^-64 revolution = 3.4e-19 rad, while a
/// float loses one bit with every doubling. An addition takes two instructions on a 32-bit target.
///
/// ```
/// use ballrace::Phase;
/// let quarter = Phase::from_revolutions(0.25);
/// assert_eq!(quarter.wrapping_mul(4), Phase::ZERO);
/// assert_eq!(quarter.opposite(), Phase::from_revolutions(0.75));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(transparent)]
pub struct Phase(pub u64);

/// 2^64, counts per revolution.
const COUNTS_PER_TURN: f64 = 18_446_744_073_709_551_616.0;

impl Phase {
    /// The angle 0.
    pub const ZERO: Self = Self(0);

    /// Converts revolutions; drops whole revolutions. NaN and infinity give 0. For set-up: uses `f64`.
    #[must_use]
    pub const fn from_revolutions(revolutions: f64) -> Self {
        // From here on numbers are whole; the comparison is also false for NaN.
        if revolutions.abs() < 4_503_599_627_370_496.0 {
            let whole = revolutions as i64 as f64;
            let fraction = revolutions - if whole > revolutions { whole - 1.0 } else { whole };
            // A fraction that rounds to 1 is the angle 0.
            if fraction < 1.0 { Self((fraction * COUNTS_PER_TURN) as u64) } else { Self::ZERO }
        } else {
            Self::ZERO
        }
    }

    /// Converts radians. NaN and infinity give 0. For set-up: uses `f64`.
    #[must_use]
    pub const fn from_radians(radians: f64) -> Self {
        Self::from_revolutions(radians / core::f64::consts::TAU)
    }

    /// Returns the angle in revolutions, 0 to 1 (1 only by rounding). For set-up: uses `f64`.
    #[must_use]
    pub fn revolutions(self) -> f64 {
        self.0 as f64 / COUNTS_PER_TURN
    }

    /// Returns the angle in radians, 0 to 2 pi. For set-up: uses `f64`.
    #[must_use]
    pub fn radians(self) -> f64 {
        self.revolutions() * core::f64::consts::TAU
    }

    /// Returns the sum of two angles.
    #[must_use]
    #[inline]
    pub const fn wrapping_add(self, angle: Self) -> Self {
        Self(self.0.wrapping_add(angle.0))
    }

    /// Returns the shorter signed difference from `earlier` to this angle.
    #[must_use]
    #[inline]
    pub const fn since(self, earlier: Self) -> PhaseDelta {
        PhaseDelta(self.0.wrapping_sub(earlier.0) as i64)
    }

    /// Returns the angle advanced by `delta`.
    #[must_use]
    #[inline]
    pub const fn advanced(self, delta: PhaseDelta) -> Self {
        Self(self.0.wrapping_add(delta.0 as u64))
    }

    /// Returns the negative angle.
    #[must_use]
    #[inline]
    pub const fn reversed(self) -> Self {
        Self(self.0.wrapping_neg())
    }

    /// Returns the angle half a revolution away.
    #[must_use]
    #[inline]
    pub const fn opposite(self) -> Self {
        Self(self.0 ^ (1 << 63))
    }

    /// Returns `n` times the angle: the phase of the n-th harmonic, or of n evenly spaced elements.
    #[must_use]
    #[inline]
    pub const fn wrapping_mul(self, n: u64) -> Self {
        Self(self.0.wrapping_mul(n))
    }
}

/// A signed angle difference of at most half a revolution, in counts of 2^-64 revolution.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhaseDelta(pub i64);

impl PhaseDelta {
    /// The difference 0.
    pub const ZERO: Self = Self(0);

    /// Converts radians, saturated at half a revolution; NaN gives 0.
    #[must_use]
    #[inline]
    pub fn from_radians<T: Scalar>(radians: T) -> Self {
        Self(radians.to_phase_counts())
    }

    /// Returns the difference in radians, -pi to pi.
    #[must_use]
    #[inline]
    pub fn radians<T: Scalar>(self) -> T {
        T::radians_from_counts(self.0)
    }
}

/// A constant ratio of two angles, such as cage to shaft, as a fixed-point number below 128 in magnitude.
///
/// A float product drifts by its rounding every revolution; this one loses at most 2^-64 revolution per increment.
///
/// ```
/// use ballrace::Phase;
/// use ballrace::phase::SpeedRatio;
/// // Rotation of the cage during an eighth of a revolution of the shaft.
/// let shaft = Phase::from_revolutions(0.125).since(Phase::ZERO);
/// let cage = Phase::ZERO.advanced(SpeedRatio::new(0.4).apply(shaft));
/// assert!((cage.revolutions() - 0.05).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpeedRatio(i64);

/// Binary digits of a [`SpeedRatio`] after the point: the number that an `f64` just below 8 has.
const RATIO_DIGITS: u32 = 56;

impl SpeedRatio {
    /// Converts a number between -128 and 128, both excluded; saturates outside. For set-up.
    #[must_use]
    pub const fn new(ratio: f64) -> Self {
        Self((ratio * (1_u64 << RATIO_DIGITS) as f64) as i64)
    }

    /// Creates the ratio from the integer that [`SpeedRatio::bits`] returned.
    #[must_use]
    pub const fn from_bits(bits: i64) -> Self {
        Self(bits)
    }

    /// Returns the ratio as an integer, a multiple of 2^-56.
    #[must_use]
    pub const fn bits(self) -> i64 {
        self.0
    }

    /// Returns `ratio * delta`, wrapped beyond half a revolution.
    #[must_use]
    #[inline]
    pub const fn apply(self, delta: PhaseDelta) -> PhaseDelta {
        PhaseDelta(((self.0 as i128 * delta.0 as i128) >> RATIO_DIGITS) as i64)
    }

    /// Returns the ratio as a number.
    #[must_use]
    pub fn value(self) -> f64 {
        self.0 as f64 / (1_u64 << RATIO_DIGITS) as f64
    }
}
