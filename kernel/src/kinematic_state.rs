//! Angles and speeds of the components of a bearing.

use crate::phase::Phase;
use crate::scalar::Scalar;

/// Angles and speeds of the components of a bearing at one instant.
///
/// All models with rolling elements use the cage angle, which determines the azimuths of the elements. Surface deviations
/// also use the angles of the rings and balls; inertia and film use the speeds. A [`Phase`] converts to the state of a
/// bearing without rotation and with its cage at that angle.
///
/// ```
/// use ballrace::{BearingKinematicState, Phase};
/// let quarter = Phase::from_revolutions(0.25);
/// let standing = BearingKinematicState::<f64>::from(quarter);
/// assert_eq!(standing.cage, quarter);
/// let turning = BearingKinematicState { inner_speed: 100.0, inner: quarter, ..standing };
/// assert_eq!(turning.reversed().inner_speed, -100.0);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
// The C interface passes it by pointer.
#[repr(C)]
pub struct BearingKinematicState<T> {
    /// Angle of the cage.
    pub cage: Phase,
    /// Angle of the inner ring.
    pub inner: Phase,
    /// Angle of the outer ring.
    pub outer: Phase,
    /// Angle of the balls about their own axes: 0 where their angle 0 is at the inner race.
    pub ball: Phase,
    /// w_i, speed of the inner ring about +Z, rad/s.
    pub inner_speed: T,
    /// w_o, speed of the outer ring about +Z, rad/s.
    pub outer_speed: T,
}

impl<T: Scalar> From<Phase> for BearingKinematicState<T> {
    #[inline(always)]
    fn from(cage: Phase) -> Self {
        Self { cage, ..Self::default() }
    }
}

impl<T: Scalar> BearingKinematicState<T> {
    /// Returns the state with speeds rounded to `f32`.
    #[inline(always)]
    pub(crate) fn single(self) -> BearingKinematicState<f32> {
        let (inner_speed, outer_speed) = (self.inner_speed.to_f32(), self.outer_speed.to_f32());
        let Self { cage, inner, outer, ball, .. } = self;
        BearingKinematicState { cage, inner, outer, ball, inner_speed, outer_speed }
    }

    /// Returns the state in the frame rotated by pi about X, in which all rotations reverse.
    #[must_use]
    #[inline(always)]
    pub fn reversed(self) -> Self {
        Self {
            cage: self.cage.reversed(),
            inner: self.inner.reversed(),
            outer: self.outer.reversed(),
            ball: self.ball.reversed(),
            inner_speed: -self.inner_speed,
            outer_speed: -self.outer_speed,
        }
    }
}
