//! How the shaft turns during one step.

use crate::phase::{Phase, PhaseDelta};
use crate::scalar::Scalar;

/// Shaft angle, speed and angular acceleration at the start of a step; the acceleration holds through it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ShaftMotion<T> {
    /// Angle of the keyphasor mark.
    pub angle: Phase,
    /// rad/s, positive about +Z.
    pub speed: T,
    /// rad/s^2.
    pub acceleration: T,
}

impl<T: Scalar> ShaftMotion<T> {
    /// Turned in the time `dt`: `w dt + a dt^2/2` (at most half a turn).
    pub fn delta_after(&self, dt: T) -> PhaseDelta {
        PhaseDelta::from_radians(dt * (self.speed + T::HALF * self.acceleration * dt))
    }

    /// The shaft `dt` later.
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
