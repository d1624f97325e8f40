//! Motion of the shaft during one step.

use crate::phase::{Phase, PhaseDelta};
use crate::scalar::Scalar;

/// Angle, speed and angular acceleration of the shaft at the start of a step; the acceleration is constant during it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftMotion<T> {
    /// Angle of the keyphasor mark.
    pub angle: Phase,
    /// Speed about +Z, rad/s.
    pub speed: T,
    /// Angular acceleration, rad/s^2.
    pub acceleration: T,
}

impl<T: Scalar> ShaftMotion<T> {
    /// Returns the rotation in the time `dt`, `w dt + a dt^2/2` (at most half a revolution).
    pub fn delta_after(&self, dt: T) -> PhaseDelta {
        PhaseDelta::from_radians(dt * (self.speed + T::HALF * self.acceleration * dt))
    }

    /// Returns the motion after the time `dt`, s.
    #[must_use]
    pub fn after(&self, dt: T) -> Self {
        Self {
            angle: self.angle.advanced(self.delta_after(dt)),
            speed: self.speed + self.acceleration * dt,
            acceleration: self.acceleration,
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.speed.is_finite() & self.acceleration.is_finite()
    }
}
