//! Angles that grow without end: the wrapping turn counter.

use crate::scalar::Scalar;

/// An angle as a fraction of one turn: the whole range of a `u64` is one revolution.
///
/// Adding wraps exactly, so a shaft that turns for years loses nothing, where a growing float would
/// lose a bit with every doubling. Resolution 2^-64 turn = 3.4e-19 rad. Cost of an addition: two
/// instructions on a 32-bit target.
///
/// ```
/// use ballrace::Phase;
/// let quarter = Phase::from_revolutions(0.25);
/// assert_eq!(quarter.wrapping_mul(4), Phase::ZERO);
/// assert_eq!(quarter.opposite(), Phase::from_revolutions(0.75));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Phase(pub u64);

/// 2^64, the number of counts in a turn.
const COUNTS_PER_TURN: f64 = 18_446_744_073_709_551_616.0;

impl Phase {
    /// The angle 0.
    pub const ZERO: Self = Self(0);

    /// From revolutions; whole turns are dropped. Set-up time (uses `f64`); not finite gives 0.
    #[must_use]
    pub fn from_revolutions(revolutions: f64) -> Self {
        let fraction = revolutions - libm::floor(revolutions);
        // A float-to-int cast saturates and maps NaN to 0; a fraction rounded up to 1.0 is angle 0 again.
        if fraction >= 1.0 { Self::ZERO } else { Self((fraction * COUNTS_PER_TURN) as u64) }
    }

    /// From radians. Set-up time (uses `f64`); not finite gives 0.
    #[must_use]
    pub fn from_radians(radians: f64) -> Self {
        Self::from_revolutions(radians / core::f64::consts::TAU)
    }

    /// Revolutions, 0 to 1 (1 excluded but for rounding). Set-up time (uses `f64`).
    #[must_use]
    pub fn revolutions(self) -> f64 {
        self.0 as f64 / COUNTS_PER_TURN
    }

    /// Radians, 0 to 2 pi. Set-up time (uses `f64`).
    #[must_use]
    pub fn radians(self) -> f64 {
        self.revolutions() * core::f64::consts::TAU
    }

    /// The angle further by `angle`.
    #[must_use]
    #[inline]
    pub const fn wrapping_add(self, angle: Self) -> Self {
        Self(self.0.wrapping_add(angle.0))
    }

    /// The shorter way from `earlier` to here.
    #[must_use]
    #[inline]
    pub const fn since(self, earlier: Self) -> PhaseDelta {
        PhaseDelta(self.0.wrapping_sub(earlier.0) as i64)
    }

    /// The angle further by `arc`.
    #[must_use]
    #[inline]
    pub const fn advanced(self, delta: PhaseDelta) -> Self {
        Self(self.0.wrapping_add(delta.0 as u64))
    }

    /// The same angle turned the other way: -angle.
    #[must_use]
    #[inline]
    pub const fn reversed(self) -> Self {
        Self(self.0.wrapping_neg())
    }

    /// Half a turn further.
    #[must_use]
    #[inline]
    pub const fn opposite(self) -> Self {
        Self(self.0 ^ (1 << 63))
    }

    /// `n` times the angle, for the phase of the n-th harmonic or of n equally spaced elements.
    #[must_use]
    #[inline]
    pub const fn wrapping_mul(self, n: u64) -> Self {
        Self(self.0.wrapping_mul(n))
    }
}

/// A signed way of at most half a turn, in counts of 2^-64 turn.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhaseDelta(pub i64);

impl PhaseDelta {
    /// No way at all.
    pub const ZERO: Self = Self(0);

    /// From radians; beyond half a turn it saturates there, NaN gives 0.
    #[must_use]
    #[inline]
    pub fn from_radians<T: Scalar>(radians: T) -> Self {
        Self(radians.to_phase_counts())
    }

    /// Radians, -pi to pi.
    #[must_use]
    #[inline]
    pub fn radians<T: Scalar>(self) -> T {
        T::radians_from_counts(self.0)
    }
}

/// A constant ratio of two angles, such as cage or ball over shaft, as a fixed-point number below 128 in size.
///
/// A float product would drift by its rounding every turn; this loses at most 2^-64 turn an increment.
///
/// ```
/// use ballrace::Phase;
/// use ballrace::phase::SpeedRatio;
/// // The cage turns while the shaft makes an eighth of a turn.
/// let shaft = Phase::from_revolutions(0.125).since(Phase::ZERO);
/// let cage = Phase::ZERO.advanced(SpeedRatio::new(0.4).apply(shaft));
/// assert!((cage.revolutions() - 0.05).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SpeedRatio(i64);

/// Binary digits of a [`SpeedRatio`] after the point: as many as an `f64` just below 8 has.
const RATIO_DIGITS: u32 = 56;

impl SpeedRatio {
    /// From a number strictly between -128 and 128 (the caller's duty: outside, it saturates). Set-up time.
    #[must_use]
    pub fn new(ratio: f64) -> Self {
        Self((ratio * (1_u64 << RATIO_DIGITS) as f64) as i64)
    }

    /// `ratio * arc`; beyond half a turn it wraps, as angles do.
    #[must_use]
    #[inline]
    pub const fn apply(self, delta: PhaseDelta) -> PhaseDelta {
        PhaseDelta(((self.0 as i128 * delta.0 as i128) >> RATIO_DIGITS) as i64)
    }

    /// The ratio as a number.
    #[must_use]
    pub fn value(self) -> f64 {
        self.0 as f64 / (1_u64 << RATIO_DIGITS) as f64
    }
}
