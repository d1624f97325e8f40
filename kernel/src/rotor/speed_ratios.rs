//! Speed ratios of the components of a bearing.

use super::ShaftMotion;
use crate::choice::Choice;
use crate::kinematic_state::BearingKinematicState;
use crate::phase::{Phase, PhaseDelta, SpeedRatio};
use crate::scalar::Scalar;

/// Speeds of the components of a bearing relative to the shaft, which rotates with the inner ring.
#[derive(Debug, Clone, Copy)]
pub struct SpeedRatios<T> {
    cage: SpeedRatio,
    ball: Option<SpeedRatio>,
    outer: Option<(SpeedRatio, T)>,
}

/// Angles of the components of a bearing that do not rotate with the shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ComponentAngles {
    /// Angle of the cage.
    pub cage: Phase,
    /// Angle of the balls about their own axes; constant without [`SpeedRatios::with_ball`].
    pub ball: Phase,
    /// Angle of the outer ring.
    pub outer: Phase,
}

impl From<Phase> for ComponentAngles {
    fn from(cage: Phase) -> Self {
        Self { cage, ..Self::default() }
    }
}

impl<T: Scalar> SpeedRatios<T> {
    /// Creates ratios with the cage at `cage` times the shaft speed and the outer ring fixed.
    #[must_use]
    pub fn new(cage: f64) -> Self {
        Self { cage: SpeedRatio::new(cage), ball: None, outer: None }
    }

    /// Returns the ratios with the ball spin at `ball` times the shaft speed, for waviness and damage of balls.
    #[must_use]
    pub fn with_ball(self, ball: f64) -> Self {
        Self { ball: Some(SpeedRatio::new(ball)), ..self }
    }

    /// Returns the ratios with the outer ring at `outer` times the shaft speed.
    #[must_use]
    pub fn with_outer(self, outer: f64) -> Self {
        Self { outer: Some((SpeedRatio::new(outer), T::from_f64(outer))), ..self }
    }

    /// Returns the angles after a rotation `delta` of the shaft.
    #[must_use]
    pub fn advance(&self, angles: ComponentAngles, delta: PhaseDelta) -> ComponentAngles {
        ComponentAngles {
            cage: angles.cage.advanced(self.cage.apply(delta)),
            ball: self.ball.map_or(angles.ball, |ball| angles.ball.advanced(ball.apply(delta))),
            outer: self.outer.map_or(angles.outer, |(outer, _)| angles.outer.advanced(outer.apply(delta))),
        }
    }

    /// Returns the kinematic state of the bearing with its components at `angles`.
    #[must_use]
    pub fn kinematic_state(&self, angles: ComponentAngles, shaft: &ShaftMotion<T>) -> BearingKinematicState<T> {
        BearingKinematicState {
            cage: angles.cage,
            inner: shaft.angle,
            outer: angles.outer,
            ball: angles.ball,
            inner_speed: shaft.speed,
            outer_speed: self.outer.map_or(T::ZERO, |(_, ratio)| ratio * shaft.speed),
        }
    }
}

impl ComponentAngles {
    pub(super) fn select(choice: Choice, a: Self, b: Self) -> Self {
        Self {
            cage: choice.select_phase(a.cage, b.cage),
            ball: choice.select_phase(a.ball, b.ball),
            outer: choice.select_phase(a.outer, b.outer),
        }
    }
}
