//! Laminae of a roller: slices across its axis, each with the profile drop at its centre.

use crate::bearing::geometry::{InvalidParameter, check};
use crate::scalar::Scalar;

/// Coefficient of the logarithmic profile of cylindrical rollers over their diameter (ISO/TS 16281).
pub const CYLINDRICAL_PROFILE: f64 = 0.000_35;
/// Coefficient of the logarithmic profile of other rollers over their diameter (ISO/TS 16281).
pub const TAPERED_PROFILE: f64 = 0.000_45;

/// One lamina of a roller.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
// The C interface reads laminae from structs of C.
#[repr(C)]
pub struct Lamina<T> {
    /// `x_k`, position of its centre along the axis of the roller, m.
    pub position: T,
    /// `2 P(x_k)`, profile drop at both contacts together, m.
    pub drop: T,
}

/// Profile of a roller: the distance by which its surface is below the straight generator.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum RollerProfile<'a> {
    /// No drop.
    Straight,
    /// `P(x) = c ln(1 / (1 - (2 x / L)^2))` (Lundberg; ISO/TS 16281).
    Logarithmic {
        /// c, m, 0 or more.
        coefficient: f64,
    },
    /// Drop of each lamina in order, m; 0 for laminae beyond the end.
    Drops(&'a [f64]),
}

impl RollerProfile<'_> {
    /// Returns the profile drop at lamina `index` of `count`, m.
    #[must_use]
    pub fn drop(&self, index: usize, count: usize) -> f64 {
        match *self {
            Self::Straight => 0.0,
            Self::Logarithmic { coefficient } => {
                let s = relative_position(index, count);
                -coefficient * libm::log1p(-s * s)
            }
            Self::Drops(drops) => drops.get(index).copied().unwrap_or(0.0),
        }
    }
}

/// Returns `2 x_k / L = (2 k + 1)/n - 1`.
fn relative_position(index: usize, count: usize) -> f64 {
    // The numerator is an exact integer: opposite laminae have opposite positions.
    (2.0 * index as f64 + 1.0 - count as f64) / count.max(1) as f64
}

impl<T: Scalar> Lamina<T> {
    /// Creates lamina `index` of `count` equal ones of a roller of effective length `length` (m). For set-up.
    ///
    /// # Errors
    /// A length that is not above 0; a profile drop that is negative or not finite.
    pub fn try_new(
        length: f64,
        profile: &RollerProfile<'_>,
        index: usize,
        count: usize,
    ) -> Result<Self, InvalidParameter> {
        check(length > 0.0, "roller_length", length, "above 0 m")?;
        let drop = profile.drop(index, count);
        check(drop >= 0.0, "profile", drop, "a drop of 0 m or more")?;
        let position = 0.5 * length * relative_position(index, count);
        Ok(Self { position: T::from_f64(position), drop: T::from_f64(2.0 * drop) })
    }
}

/// Returns the `K` equal laminae of a roller of effective length `length` (m).
///
/// # Errors
/// As [`Lamina::try_new`].
pub fn laminae<T: Scalar, const K: usize>(
    length: f64,
    profile: &RollerProfile<'_>,
) -> Result<[Lamina<T>; K], InvalidParameter> {
    let mut laminae = [Lamina::default(); K];
    for (index, lamina) in laminae.iter_mut().enumerate() {
        *lamina = Lamina::try_new(length, profile, index, K)?;
    }
    Ok(laminae)
}
