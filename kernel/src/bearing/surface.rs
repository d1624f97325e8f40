//! What races and balls are besides round: waviness and local damage, each turning with its own surface (`docs/src/models.md#waviness-and-damage`).

use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// What the surfaces do to one ball, m: the inner groove centre displaced against the outer one, and what each contact is
/// pressed the more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElementDeviation<T> {
    /// `p_i - p_o`
    pub radial: T,
    /// `q_i - q_o`
    pub axial: T,
    /// `w_i` less the depth of damage met at the inner contact.
    pub inner: T,
    /// `w_o` less the depth of damage met at the outer contact.
    pub outer: T,
}

/// The surfaces of a bearing as its balls meet them.
pub trait Surface<T: Scalar>: Send + Sync {
    /// At the ball that stands at `azimuth` of the fixed frame.
    fn at(&self, azimuth: Phase, rotation: &BearingKinematicState<T>) -> ElementDeviation<T>;
}

/// Round surfaces without damage; cost no instruction.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Smooth;

impl<T: Scalar> Surface<T> for Smooth {
    #[inline(always)]
    fn at(&self, _azimuth: Phase, _rotation: &BearingKinematicState<T>) -> ElementDeviation<T> {
        // Adding -0 is free: it leaves every number as it is.
        let nothing = T::NEGATIVE_ZERO;
        ElementDeviation { radial: nothing, axial: nothing, inner: nothing, outer: nothing }
    }
}

/// Which surface a feature is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BearingComponent {
    /// Groove of the inner ring.
    Inner,
    /// Groove of the outer ring.
    Outer,
    /// The balls: waviness is the same on all, damage is on the one whose place in the cage is given.
    Ball(Phase),
}

/// Along what a groove's waviness moves its centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Outward.
    Radial,
    /// Towards +Z.
    Axial,
}

/// One order of waviness: `amplitude cos(order psi + phase)`, `psi` the azimuth less the surface's own angle; on a ball
/// its spin angle, opposite at the two contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave<T> {
    /// Whose.
    pub part: BearingComponent,
    /// Ignored on balls.
    pub direction: Direction,
    /// Waves around the surface.
    pub order: u32,
    /// m.
    pub amplitude: T,
    /// Of the wave, a whole turn being one wave.
    pub phase: Phase,
}

/// Section of a spall along the race.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpallShape {
    /// `depth sin(pi s)`, `s` from 0 to 1 over the width.
    HalfSine,
    /// `depth` all along.
    Rectangular,
}

/// A spall on a race or on one ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spall<T> {
    part: BearingComponent,
    centre: Phase,
    half_width: T,
    depth: T,
    shape: SpallShape,
}

impl<T: Copy> Spall<T> {
    /// Centre (rad from the surface's own zero), half width (rad, above 0, at most pi), depth (m).
    pub const fn new(part: BearingComponent, centre: Phase, half_width: T, depth: T, shape: SpallShape) -> Self {
        Self { part, centre, half_width, depth, shape }
    }

    /// Surface, centre, half width, depth and section, as [`Spall::new`] takes them.
    pub fn parts(&self) -> (BearingComponent, Phase, T, T, SpallShape) {
        (self.part, self.centre, self.half_width, self.depth, self.shape)
    }
}

impl<T: Scalar> Spall<T> {
    /// Depth at `angle` of the surface, m.
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

/// One thing on a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Feature<T> {
    /// An order of waviness.
    Wave(Wave<T>),
    /// Local damage.
    Spall(Spall<T>),
}

/// Surfaces with any number of features: an array, a slice or a vector of them.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceDeviation<M, A> {
    features: A,
    math: PhantomData<M>,
}

impl<M, A> SurfaceDeviation<M, A> {
    /// From the features.
    pub const fn new(features: A) -> Self {
        Self { features, math: PhantomData }
    }
}

impl BearingComponent {
    /// Seen from the frame turned by pi about X.
    #[must_use]
    fn mirrored(self) -> Self {
        match self {
            Self::Ball(place) => Self::Ball(place.reversed()),
            race => race,
        }
    }
}

impl<T: Scalar> Feature<T> {
    /// Seen from the frame turned by pi about X, for a bearing that faces -Z.
    #[must_use]
    pub fn mirrored(self) -> Self {
        match self {
            Self::Spall(s) => Self::Spall(Spall { part: s.part.mirrored(), centre: s.centre.reversed(), ..s }),
            Self::Wave(w) => {
                let axial = w.direction == Direction::Axial && !matches!(w.part, BearingComponent::Ball(_));
                let amplitude = if axial { -w.amplitude } else { w.amplitude };
                Self::Wave(Wave { part: w.part.mirrored(), phase: w.phase.reversed(), amplitude, ..w })
            }
        }
    }
}

/// The angle on a ring's surface of what stands at `azimuth`.
#[inline(always)]
fn on_ring(azimuth: Phase, ring: Phase) -> Phase {
    azimuth.plus(ring.reversed())
}

impl<T: Scalar> Wave<T> {
    #[inline(always)]
    fn add<M: Math<T>>(&self, shape: &mut ElementDeviation<T>, azimuth: Phase, rotation: &BearingKinematicState<T>) {
        let height = |psi: Phase| {
            let (_, cos) = M::sin_cos(psi.times(u64::from(self.order)).plus(self.phase));
            self.amplitude * cos
        };
        let (groove, sign) = match self.part {
            BearingComponent::Inner => (on_ring(azimuth, rotation.inner), T::ONE),
            BearingComponent::Outer => (on_ring(azimuth, rotation.outer), -T::ONE),
            BearingComponent::Ball(_) => {
                shape.inner += height(rotation.ball);
                shape.outer += height(rotation.ball.opposite());
                return;
            }
        };
        match self.direction {
            Direction::Radial => shape.radial += sign * height(groove),
            Direction::Axial => shape.axial += sign * height(groove),
        }
    }
}

impl<T: Scalar> Spall<T> {
    #[inline(always)]
    fn add(&self, shape: &mut ElementDeviation<T>, azimuth: Phase, rotation: &BearingKinematicState<T>) {
        match self.part {
            BearingComponent::Inner => shape.inner -= self.depth_at(on_ring(azimuth, rotation.inner)),
            BearingComponent::Outer => shape.outer -= self.depth_at(on_ring(azimuth, rotation.outer)),
            BearingComponent::Ball(place) if azimuth == place.plus(rotation.cage) => {
                shape.inner -= self.depth_at(rotation.ball);
                shape.outer -= self.depth_at(rotation.ball.opposite());
            }
            BearingComponent::Ball(_) => {}
        }
    }
}

impl<T: Scalar, M: Math<T>, A: AsRef<[Feature<T>]> + Send + Sync> Surface<T> for SurfaceDeviation<M, A> {
    fn at(&self, azimuth: Phase, rotation: &BearingKinematicState<T>) -> ElementDeviation<T> {
        let mut shape = Smooth.at(azimuth, rotation);
        for feature in self.features.as_ref() {
            match feature {
                Feature::Wave(wave) => wave.add::<M>(&mut shape, azimuth, rotation),
                Feature::Spall(spall) => spall.add(&mut shape, azimuth, rotation),
            }
        }
        shape
    }
}

/// `cos(pi s / 2)` on -1..1 by its Taylor series (remainder 4e-16 at the end, where it counts least).
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
