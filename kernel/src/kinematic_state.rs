//! How far the parts of a bearing have turned, and how fast its rings turn.

use crate::phase::Phase;
use crate::scalar::Scalar;

/// Angles and speeds of a bearing's parts at one instant.
///
/// Every rung needs the cage's angle, which says where the elements stand; waviness and local damage also need the
/// angles of the surfaces they sit on, inertia and film the speeds. From a [`Phase`] it is a bearing at rest with its cage
/// at that angle.
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
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct BearingKinematicState<T> {
    /// Cage, and so the elements' positions.
    pub cage: Phase,
    /// Inner ring.
    pub inner: Phase,
    /// Outer ring.
    pub outer: Phase,
    /// Balls about their own axes: 0 where their angle 0 touches the inner race.
    pub ball: Phase,
    /// w_i, inner ring about +Z, rad/s.
    pub inner_speed: T,
    /// w_o, outer ring about +Z, rad/s.
    pub outer_speed: T,
}

impl<T: Scalar> From<Phase> for BearingKinematicState<T> {
    #[inline(always)]
    fn from(cage: Phase) -> Self {
        Self { cage, ..Self::default() }
    }
}

impl<T: Scalar> BearingKinematicState<T> {
    /// Seen from the frame turned by pi about X, in which everything turns the other way.
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
