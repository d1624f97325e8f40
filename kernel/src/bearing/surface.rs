//! Deviations of raceways and balls from their ideal shape: waviness and local damage, each rotating with its surface
//! (`docs/src/models.md#waviness-and-damage`).
//!
//! Source: Wardle 1988; Jang and Jeong 2003; the symbols of Wang, Han and Zhou 2017.

use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Effect of the surface deviations on one ball, m: displacement of the inner groove centre relative to the outer one, and
/// additional approach of each contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementDeviation<T> {
    /// `p_i - p_o`, radial displacement of the groove centres.
    pub radial: T,
    /// `q_i - q_o`, axial displacement of the groove centres.
    pub axial: T,
    /// `w_i` less the depth of damage at the inner contact.
    pub inner: T,
    /// `w_o` less the depth of damage at the outer contact.
    pub outer: T,
}

/// The surface deviations of a bearing.
pub trait Surface<T: Scalar>: Send + Sync {
    /// True for surfaces without any deviation, which a model may then leave out.
    const IS_SMOOTH: bool = false;

    /// Returns true if no ball has a deviation.
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        Self::IS_SMOOTH
    }
    /// Returns the deviations at the ball at `azimuth` in the fixed frame.
    fn deviation(&self, azimuth: Phase, kinematics: &BearingKinematicState<T>) -> ElementDeviation<T>;
}

/// Ideal surfaces; cost no instruction.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Smooth;

impl<T: Scalar> Surface<T> for Smooth {
    const IS_SMOOTH: bool = true;
    #[inline(always)]
    fn deviation(&self, _azimuth: Phase, _kinematics: &BearingKinematicState<T>) -> ElementDeviation<T> {
        // -0 is the neutral element of addition.
        let nothing = T::NEGATIVE_ZERO;
        ElementDeviation { radial: nothing, axial: nothing, inner: nothing, outer: nothing }
    }
}

/// The surface that carries a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BearingComponent {
    /// Raceway of the inner ring.
    Inner,
    /// Raceway of the outer ring.
    Outer,
    /// Balls: waviness is the same on all; damage is on the ball at this position in the cage.
    Ball(Phase),
}

/// Direction in which waviness displaces the groove centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Direction {
    /// Outward.
    Radial,
    /// Towards +Z.
    Axial,
}

/// One order of waviness: `amplitude cos(order psi + phase)`, with `psi` the azimuth relative to the angle of the surface;
/// on a ball, `psi` is its spin angle, opposite at the two contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave<T> {
    /// Surface.
    pub component: BearingComponent,
    /// Direction; ignored on balls.
    pub direction: Direction,
    /// Waves around the surface.
    pub order: u32,
    /// Amplitude, m.
    pub amplitude: T,
    /// Phase of the wave; one revolution is one wave.
    pub phase: Phase,
}

/// Section of a spall along the rolling direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SpallShape {
    /// `depth sin(pi s)`, `s` from 0 to 1 over the width.
    HalfSine,
    /// `depth` over the whole width.
    Rectangular,
}

/// A spall on a race or on one ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spall<T> {
    /// Damaged surface.
    pub component: BearingComponent,
    /// Centre of the spall, measured from the surface's own zero angle.
    pub centre: Phase,
    /// Half width along the rolling direction, rad, above 0, at most pi.
    pub half_width: T,
    /// Greatest depth, m.
    pub depth: T,
    /// Section along the rolling direction.
    pub shape: SpallShape,
}

impl<T> Spall<T> {
    /// Creates a spall; the arguments are the fields in order.
    pub const fn new(component: BearingComponent, centre: Phase, half_width: T, depth: T, shape: SpallShape) -> Self {
        Self { component, centre, half_width, depth, shape }
    }
}

impl<T: Scalar> Spall<T> {
    /// Returns the depth at `angle` of the surface, m.
    pub fn depth_at(&self, angle: Phase) -> T {
        let away: T = angle.since(self.centre).radians();
        let s = away / self.half_width;
        let inside = s.abs() < T::ONE;
        let height = match self.shape {
            SpallShape::Rectangular => T::ONE,
            SpallShape::HalfSine => cos_half_pi(s),
        };
        if inside { self.depth * height } else { T::ZERO }
    }
}

/// A feature on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feature<T> {
    /// An order of waviness.
    Wave(Wave<T>),
    /// Local damage.
    Spall(Spall<T>),
}

/// Surfaces with any number of features, in an array, a slice or a vector.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceDeviation<M, A> {
    features: A,
    math: PhantomData<M>,
}

impl<M, A> SurfaceDeviation<M, A> {
    /// Creates surfaces with these features.
    pub const fn new(features: A) -> Self {
        Self { features, math: PhantomData }
    }
}

impl BearingComponent {
    /// Returns the component in the frame rotated by pi about X.
    #[must_use]
    fn mirrored(self) -> Self {
        match self {
            Self::Ball(position) => Self::Ball(position.reversed()),
            race => race,
        }
    }
}

impl<T: Scalar> Feature<T> {
    /// Returns the feature in the frame rotated by pi about X, for a bearing that faces -Z.
    #[must_use]
    pub fn mirrored(self) -> Self {
        match self {
            Self::Spall(s) => {
                Self::Spall(Spall { component: s.component.mirrored(), centre: s.centre.reversed(), ..s })
            }
            Self::Wave(w) => {
                let axial = w.direction == Direction::Axial && !matches!(w.component, BearingComponent::Ball(_));
                let amplitude = if axial { -w.amplitude } else { w.amplitude };
                Self::Wave(Wave { component: w.component.mirrored(), phase: w.phase.reversed(), amplitude, ..w })
            }
        }
    }
}

/// Returns the angle on the surface of a ring at `azimuth`.
#[inline(always)]
fn on_ring(azimuth: Phase, ring: Phase) -> Phase {
    azimuth.wrapping_add(ring.reversed())
}

impl<T: Scalar> Wave<T> {
    #[inline(always)]
    fn add<M: Math<T>>(
        &self,
        deviation: &mut ElementDeviation<T>,
        azimuth: Phase,
        kinematics: &BearingKinematicState<T>,
    ) {
        let height = |psi: Phase| {
            let (_, cos) = M::sin_cos(psi.wrapping_mul(u64::from(self.order)).wrapping_add(self.phase));
            self.amplitude * cos
        };
        let (groove, sign) = match self.component {
            BearingComponent::Inner => (on_ring(azimuth, kinematics.inner), T::ONE),
            BearingComponent::Outer => (on_ring(azimuth, kinematics.outer), -T::ONE),
            BearingComponent::Ball(_) => {
                deviation.inner += height(kinematics.ball);
                deviation.outer += height(kinematics.ball.opposite());
                return;
            }
        };
        match self.direction {
            Direction::Radial => deviation.radial += sign * height(groove),
            Direction::Axial => deviation.axial += sign * height(groove),
        }
    }
}

impl<T: Scalar> Spall<T> {
    #[inline(always)]
    fn add(&self, deviation: &mut ElementDeviation<T>, azimuth: Phase, kinematics: &BearingKinematicState<T>) {
        match self.component {
            BearingComponent::Inner => deviation.inner -= self.depth_at(on_ring(azimuth, kinematics.inner)),
            BearingComponent::Outer => deviation.outer -= self.depth_at(on_ring(azimuth, kinematics.outer)),
            BearingComponent::Ball(position) if azimuth == position.wrapping_add(kinematics.cage) => {
                deviation.inner -= self.depth_at(kinematics.ball);
                deviation.outer -= self.depth_at(kinematics.ball.opposite());
            }
            BearingComponent::Ball(_) => {}
        }
    }
}

impl<T: Scalar, M: Math<T>, A: AsRef<[Feature<T>]> + Send + Sync> Surface<T> for SurfaceDeviation<M, A> {
    #[inline(always)]
    fn is_smooth(&self) -> bool {
        self.features.as_ref().is_empty()
    }
    fn deviation(&self, azimuth: Phase, kinematics: &BearingKinematicState<T>) -> ElementDeviation<T> {
        let mut deviation = Smooth.deviation(azimuth, kinematics);
        for feature in self.features.as_ref() {
            match feature {
                Feature::Wave(wave) => wave.add::<M>(&mut deviation, azimuth, kinematics),
                Feature::Spall(spall) => spall.add(&mut deviation, azimuth, kinematics),
            }
        }
        deviation
    }
}

/// Returns `cos(pi s / 2)` for -1 to 1 by its Taylor series (remainder 4e-16 at the ends).
fn cos_half_pi<T: Scalar>(s: T) -> T {
    const TERMS: [f64; 10] = {
        let x2 = core::f64::consts::FRAC_PI_2 * core::f64::consts::FRAC_PI_2;
        let mut terms = [1.0; 10];
        let mut k = 1;
        while k < 10 {
            let n = 2.0 * k as f64;
            terms[k] = -terms[k - 1] * x2 / (n * (n - 1.0));
            k += 1;
        }
        terms
    };
    let ss = s * s;
    TERMS.iter().rev().fold(T::ZERO, |sum, &c| sum * ss + T::from_f64(c))
}
