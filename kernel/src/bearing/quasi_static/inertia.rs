//! Inertia loads of the balls: centrifugal force and gyroscopic moment (`docs/src/models.md#ball-kinematics`).
//!
//! Under pure rolling at both contacts the speeds of a ball follow from its two contact angles. The race control hypotheses
//! reduce the general equations, with `C = cos(a_i - a_o)`, `dw = w_i - w_o` and `g = D/d_m`, to
//!
//! - orbital speed `w_c = w_o + dw k/(1 + C)`, outer control `k = 1 - g cos a_i`, inner control `k = C - g cos a_o`;
//! - gyroscopic moment `M_g = I_b w_s w_c sin(beta) = -(I_b/g) dw w_c s/(1 + C)`, outer control `s = (1 - g cos a_i) sin
//!   a_o`, inner control `s = (1 + g cos a_o) sin a_i`.
//!
//! This takes no angle, no tangent and one division. `M_g` has the sign of the spin speed; it is negative for an inner ring
//! that rotates forward under a positive contact angle.

use crate::kinematic_state::BearingKinematicState;
use crate::math::lanes::{Lanes, Plane};
use crate::scalar::Scalar;

/// Race at which the ball does not spin (Harris).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum RaceControl {
    /// Outer race: `tan(beta) = sin a_o/(cos a_o + g)`.
    Outer,
    /// Inner race: `tan(beta) = sin a_i/(cos a_i - g)`.
    Inner,
}

/// Shares `lambda_i`, `lambda_o` (sum 2) of the two contacts in the friction that balances the gyroscopic moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FrictionSharing {
    /// 0 and 2.
    Outer,
    /// 1 and 1.
    Equal,
    /// In proportion to the contact loads.
    Proportional,
}

/// Inertia loads that act on a ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InertiaEffects {
    /// The centrifugal force acts.
    pub centrifugal: bool,
    /// The gyroscopic moment acts.
    pub gyroscopic: bool,
    /// The outer race controls the spin and carries all friction, which needs less computation.
    pub outer_race_control: bool,
}

impl InertiaEffects {
    pub(super) const NONE: Self = Self { centrifugal: false, gyroscopic: false, outer_race_control: true };
    pub(super) const CENTRIFUGAL: Self = Self { centrifugal: true, gyroscopic: false, outer_race_control: false };
    pub(super) const OUTER_CONTROLLED: Self = Self { centrifugal: true, gyroscopic: true, outer_race_control: true };
    pub(super) const GYROSCOPIC: Self = Self { centrifugal: true, gyroscopic: true, outer_race_control: false };
}

/// Inertia of a ball, as far as the model includes it.
pub trait Inertia<T: Scalar>: Copy + Send + Sync + 'static {
    /// The same inertia in `f32`.
    type Single: Inertia<f32>;
    /// Returns the loads that act. A constant of the type costs no instruction.
    fn effects(&self) -> InertiaEffects;
    /// Returns the constants of the loads.
    fn constants(&self) -> BallInertia<T>;
    /// Returns the inertia rounded to `f32`.
    fn single(&self) -> Self::Single;
}

/// Balls without mass; cost no instruction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Massless;

/// Centrifugal force only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Centrifugal<T>(pub(super) BallInertia<T>);

/// Centrifugal force and gyroscopic moment under outer race control with all friction at the outer race.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OuterControlled<T>(pub(super) BallInertia<T>);

/// Gyroscopic moment, with or without centrifugal force, under any control and sharing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gyroscopic<T>(pub(super) BallInertia<T>);

/// Inertia loads selected at run time: one compiled type serves all.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectedInertia<T> {
    pub(super) effects: InertiaEffects,
    pub(super) ball: BallInertia<T>,
}

impl<T: Scalar> SelectedInertia<T> {
    pub(super) fn none() -> Self {
        Self { effects: InertiaEffects::NONE, ball: BallInertia::default() }
    }
}

impl<T: Scalar> Inertia<T> for SelectedInertia<T> {
    type Single = SelectedInertia<f32>;
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        self.effects
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.ball
    }
    #[inline(always)]
    fn single(&self) -> Self::Single {
        SelectedInertia { effects: self.effects, ball: self.ball.single() }
    }
}

/// Constants of the inertia loads.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallInertia<T> {
    /// `m_b d_m/2`: times `w_c^2` the centrifugal force.
    pub(super) centrifugal: T,
    /// `-I_b/(g D)`: times `dw w_c s/(1 + C)` it is `M_g/D`.
    pub(super) gyroscopic: T,
    /// 1 for outer race control, 0 for inner.
    pub(super) outer_control: T,
    /// Load-independent parts of `lambda_i` and `lambda_o`, and the weight of the load-dependent part.
    pub(super) inner_share: T,
    pub(super) outer_share: T,
    pub(super) by_load: T,
}

impl<T: Scalar> BallInertia<T> {
    #[inline(always)]
    fn single(&self) -> BallInertia<f32> {
        BallInertia {
            centrifugal: self.centrifugal.to_f32(),
            gyroscopic: self.gyroscopic.to_f32(),
            outer_control: self.outer_control.to_f32(),
            inner_share: self.inner_share.to_f32(),
            outer_share: self.outer_share.to_f32(),
            by_load: self.by_load.to_f32(),
        }
    }
}

impl<T: Scalar> Inertia<T> for Massless {
    type Single = Massless;
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::NONE
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        BallInertia::default()
    }
    #[inline(always)]
    fn single(&self) -> Self::Single {
        Self
    }
}

impl<T: Scalar> Inertia<T> for Centrifugal<T> {
    type Single = Centrifugal<f32>;
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::CENTRIFUGAL
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.0
    }
    #[inline(always)]
    fn single(&self) -> Self::Single {
        Centrifugal(self.0.single())
    }
}

impl<T: Scalar> Inertia<T> for OuterControlled<T> {
    type Single = OuterControlled<f32>;
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::OUTER_CONTROLLED
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.0
    }
    #[inline(always)]
    fn single(&self) -> Self::Single {
        OuterControlled(self.0.single())
    }
}

impl<T: Scalar> Inertia<T> for Gyroscopic<T> {
    type Single = Gyroscopic<f32>;
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::GYROSCOPIC
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.0
    }
    #[inline(always)]
    fn single(&self) -> Self::Single {
        Gyroscopic(self.0.single())
    }
}

/// Parameters of the inertia of the balls.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct InertiaParams {
    /// Density of the balls, kg/m^3.
    pub density: f64,
    /// Includes the centrifugal force.
    pub centrifugal: bool,
    /// Includes the gyroscopic moment.
    pub gyroscopic: bool,
    /// Race that controls the spin.
    pub race_control: RaceControl,
    /// Shares of the contacts in the friction.
    pub friction_sharing: FrictionSharing,
}

impl InertiaParams {
    /// Returns the mass of a ball of diameter `d` (m), kg.
    #[must_use]
    pub fn ball_mass(&self, d: f64) -> f64 {
        self.density * core::f64::consts::PI * d * d * d / 6.0
    }

    pub(super) fn constants<T: Scalar>(&self, d: f64, pitch: f64) -> BallInertia<T> {
        let mass = self.ball_mass(d);
        let (inner, outer, by_load) = match self.friction_sharing {
            FrictionSharing::Outer => (0.0, 2.0, 0.0),
            FrictionSharing::Equal => (1.0, 1.0, 0.0),
            FrictionSharing::Proportional => (0.0, 0.0, 2.0),
        };
        BallInertia {
            centrifugal: T::from_f64(if self.centrifugal { 0.5 * mass * pitch } else { 0.0 }),
            gyroscopic: T::from_f64(if self.gyroscopic { -0.1 * mass * pitch } else { 0.0 }),
            outer_control: T::from_f64(if self.race_control == RaceControl::Outer { 1.0 } else { 0.0 }),
            inner_share: T::from_f64(inner),
            outer_share: T::from_f64(outer),
            by_load: T::from_f64(by_load),
        }
    }
}

/// Inertia loads at two contact angles, with their derivatives by both angles.
#[derive(Clone, Copy)]
pub(super) struct InertiaLoads<L> {
    /// w_c, orbital speed, rad/s.
    pub orbital: L,
    /// F_c, centrifugal force, N.
    pub centrifugal: WithSlopes<L>,
    /// `M_g/D`, friction that balances the gyroscopic moment, N.
    pub friction: WithSlopes<L>,
}

/// A value with its derivatives by `a_o` and `a_i`.
#[derive(Clone, Copy)]
pub(super) struct WithSlopes<L> {
    pub value: L,
    pub outer: L,
    pub inner: L,
}

impl<T: Scalar, const K: usize> WithSlopes<Lanes<T, K>> {
    /// Multiplies by the product rule.
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            outer: self.outer * other.value + self.value * other.outer,
            inner: self.inner * other.value + self.value * other.inner,
        }
    }
    #[inline(always)]
    fn scaled(self, factor: Lanes<T, K>) -> Self {
        Self { value: self.value * factor, outer: self.outer * factor, inner: self.inner * factor }
    }
    #[inline(always)]
    pub fn none() -> Self {
        let zero = Lanes::splat(T::ZERO);
        Self { value: zero, outer: zero, inner: zero }
    }
}

/// Returns `1/(1 + C)`, kept finite for opposed contacts, which no ball between two races has.
#[inline(always)]
pub(super) fn inverse_of_one_plus<T: Scalar, const K: usize>(c: Lanes<T, K>) -> Lanes<T, K> {
    Lanes::splat(T::ONE) / (Lanes::splat(T::ONE) + c).larger(Lanes::splat_f64(1e-3))
}

impl<T: Scalar> BallInertia<T> {
    /// Returns the orbital speed, for the initial value.
    #[inline(always)]
    pub(super) fn orbital_speed<const K: usize>(
        &self,
        ratio: T,
        speeds: &BearingKinematicState<T>,
        outer: Plane<Lanes<T, K>>,
        inner: Plane<Lanes<T, K>>,
    ) -> Lanes<T, K> {
        let one = Lanes::splat(T::ONE);
        let (g, control) = (Lanes::splat(ratio), Lanes::splat(self.outer_control));
        let c = outer.dot(inner);
        let k = control * (one - g * inner.r) + (one - control) * (c - g * outer.r);
        Lanes::splat(speeds.outer_speed)
            + Lanes::splat(speeds.inner_speed - speeds.outer_speed) * k * inverse_of_one_plus(c)
    }

    /// Computes the loads of balls with contacts along `outer` and `inner`; `rolling` is 0 for a ball without contact at
    /// the inner race, which has no gyroscopic moment.
    #[inline(always)]
    pub(super) fn loads<const K: usize>(
        &self,
        effects: InertiaEffects,
        ratio: T,
        speeds: &BearingKinematicState<T>,
        outer: Plane<Lanes<T, K>>,
        inner: Plane<Lanes<T, K>>,
        rolling: Lanes<T, K>,
    ) -> InertiaLoads<Lanes<T, K>> {
        let (one, g) = (Lanes::splat(T::ONE), Lanes::splat(ratio));
        let (by_outer, by_inner) = (Lanes::splat(self.outer_control), Lanes::splat(T::ONE - self.outer_control));
        let relative = Lanes::splat(speeds.inner_speed - speeds.outer_speed);
        let c = outer.dot(inner);
        let s = inner.z * outer.r - inner.r * outer.z; // sin(a_i - a_o)
        let inverse = inverse_of_one_plus(c);
        // 1/(1 + C) and its slopes: dC/da_o = s, dC/da_i = -s.
        let turn = inverse * inverse * s;
        let inverse = WithSlopes { value: inverse, outer: -turn, inner: turn };

        let near = one - g * inner.r;
        let slip = if effects.outer_race_control {
            WithSlopes { value: near, outer: Lanes::splat(T::ZERO), inner: g * inner.z }
        } else {
            WithSlopes {
                value: by_outer * near + by_inner * (c - g * outer.r),
                outer: by_inner * (s + g * outer.z),
                inner: by_outer * g * inner.z - by_inner * s,
            }
        };
        let excess = slip.times(inverse).scaled(relative);
        let orbital = WithSlopes { value: Lanes::splat(speeds.outer_speed) + excess.value, ..excess };
        let centrifugal = orbital.times(orbital).scaled(Lanes::splat(self.centrifugal));
        let friction = if effects.gyroscopic {
            let far = one + g * outer.r;
            let lever = if effects.outer_race_control {
                WithSlopes { value: near * outer.z, outer: near * outer.r, inner: g * inner.z * outer.z }
            } else {
                WithSlopes {
                    value: by_outer * near * outer.z + by_inner * far * inner.z,
                    outer: by_outer * near * outer.r - by_inner * g * outer.z * inner.z,
                    inner: by_outer * g * inner.z * outer.z + by_inner * far * inner.r,
                }
            };
            let factor = Lanes::splat(self.gyroscopic) * relative * rolling;
            lever.times(inverse).times(orbital).scaled(factor)
        } else {
            WithSlopes::none()
        };
        InertiaLoads { orbital: orbital.value, centrifugal, friction }
    }
}
