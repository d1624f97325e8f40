//! What the balls' motion adds to their balance: centrifugal force and gyroscopic moment (`docs/src/models.md#ball-kinematics`).
//!
//! With pure rolling at both contacts the speeds of a ball follow from its two contact angles. Putting the race control
//! hypotheses into the general formulas leaves, with `C = cos(a_i - a_o)` and `dw = w_i - w_o`,
//!
//! - orbital speed `w_c = w_o + dw k/(1 + C)`, outer control `k = 1 - g cos a_i`, inner control `k = C - g cos a_o`;
//! - gyroscopic moment `M_g = I_b w_s w_c sin(beta) = -(I_b/g) dw w_c s/(1 + C)`,
//!   outer control `s = (1 - g cos a_i) sin a_o`, inner control `s = (1 + g cos a_o) sin a_i`
//!
//! (`g = D/d_m`): no angle, no tangent, one division. `M_g` keeps the sign of the spin speed; it is below 0 for an inner
//! ring that turns forward under a positive contact angle.

use crate::kinematic_state::BearingKinematicState;
use crate::lanes::{Lanes, Plane};
use crate::scalar::Scalar;

/// Which race the ball does not spin on (Harris).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RaceControl {
    /// `tan(beta) = sin a_o/(cos a_o + g)`.
    Outer,
    /// `tan(beta) = sin a_i/(cos a_i - g)`.
    Inner,
}

/// How the two contacts share the friction that balances the gyroscopic moment: `lambda_i`, `lambda_o` of sum 2.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrictionSharing {
    /// 0 and 2.
    Outer,
    /// 1 and 1.
    Equal,
    /// In proportion to the loads.
    Proportional,
}

/// Inertia loads that act on a ball.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct InertiaEffects {
    /// The centrifugal force acts.
    pub centrifugal: bool,
    /// The gyroscopic moment acts.
    pub gyroscopic: bool,
    /// The outer race controls the spin and carries all friction: less to compute.
    pub outer_race_control: bool,
}

impl InertiaEffects {
    pub(super) const NONE: Self = Self { centrifugal: false, gyroscopic: false, outer_race_control: true };
    pub(super) const CENTRIFUGAL: Self = Self { centrifugal: true, gyroscopic: false, outer_race_control: false };
    pub(super) const OUTER_CONTROLLED: Self = Self { centrifugal: true, gyroscopic: true, outer_race_control: true };
    pub(super) const GYROSCOPIC: Self = Self { centrifugal: true, gyroscopic: true, outer_race_control: false };
}

/// A ball's inertia, as much of it as the bearing takes into account.
pub trait Inertia<T: Scalar>: Copy + Send + Sync + 'static {
    /// Returns the loads that act. A constant of the type costs no instruction.
    fn effects(&self) -> InertiaEffects;
    /// Returns the constants of the loads.
    fn constants(&self) -> BallInertia<T>;
}

/// Massless balls: costs no instruction.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Massless;

/// Centrifugal force alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Centrifugal<T>(pub(super) BallInertia<T>);

/// Both under outer race control with all friction at the outer race, the usual choice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OuterControlled<T>(pub(super) BallInertia<T>);

/// Gyroscopic moment, with or without the centrifugal force, under any control and sharing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gyroscopic<T>(pub(super) BallInertia<T>);

/// Inertia loads chosen at run time: one compiled bearing serves every choice.
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
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        self.effects
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.ball
    }
}

/// Constants of the inertia loads.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct BallInertia<T> {
    /// `m_b d_m/2`: times `w_c^2` it is the centrifugal force.
    pub(super) centrifugal: T,
    /// `-I_b/(g D)`: times `dw w_c s/(1 + C)` it is `M_g/D`.
    pub(super) gyroscopic: T,
    /// 1 for outer race control, 0 for inner.
    pub(super) outer_control: T,
    /// `lambda_i`, `lambda_o` but for what goes by the loads, and the weight of that.
    pub(super) inner_share: T,
    pub(super) outer_share: T,
    pub(super) by_load: T,
}

impl<T: Scalar> Inertia<T> for Massless {
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::NONE
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        BallInertia::default()
    }
}

impl<T: Scalar> Inertia<T> for Centrifugal<T> {
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::CENTRIFUGAL
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.0
    }
}

impl<T: Scalar> Inertia<T> for OuterControlled<T> {
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::OUTER_CONTROLLED
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.0
    }
}

impl<T: Scalar> Inertia<T> for Gyroscopic<T> {
    #[inline(always)]
    fn effects(&self) -> InertiaEffects {
        InertiaEffects::GYROSCOPIC
    }
    #[inline(always)]
    fn constants(&self) -> BallInertia<T> {
        self.0
    }
}

/// What an engineer says of the balls' inertia, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertiaParams {
    /// Of the balls, kg/m^3.
    pub density: f64,
    /// Whether the centrifugal force acts.
    pub centrifugal: bool,
    /// Whether the gyroscopic moment acts.
    pub gyroscopic: bool,
    /// Which race controls the spin.
    pub race_control: RaceControl,
    /// Who carries the friction.
    pub friction_sharing: FrictionSharing,
}

impl InertiaParams {
    /// Mass of a ball `d` across, kg.
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

/// Inertia loads at two contact angles, and their slopes along the outer and the inner angle.
#[derive(Clone, Copy)]
pub(super) struct InertiaLoads<L> {
    /// w_c, rad/s.
    pub orbital: L,
    /// F_c, N.
    pub centrifugal: WithSlopes<L>,
    /// `M_g/D`, N.
    pub friction: WithSlopes<L>,
}

/// A value and its derivatives with respect to `a_o` and `a_i`.
#[derive(Clone, Copy)]
pub(super) struct WithSlopes<L> {
    pub value: L,
    pub outer: L,
    pub inner: L,
}

impl<T: Scalar, const K: usize> WithSlopes<Lanes<T, K>> {
    /// Product rule.
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

/// `1/(1 + C)`, kept finite where the contacts point against each other, which no ball between two races does.
#[inline(always)]
pub(super) fn inverse_of_one_plus<T: Scalar, const K: usize>(c: Lanes<T, K>) -> Lanes<T, K> {
    Lanes::splat(T::ONE) / (Lanes::splat(T::ONE) + c).larger(Lanes::splat_f64(1e-3))
}

impl<T: Scalar> BallInertia<T> {
    /// Orbital speed alone, for the first guess.
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

    /// Loads of balls whose contacts point along `outer` and `inner`; `rolling` is 0 for a ball off the inner race, which
    /// has no gyroscopic moment.
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
