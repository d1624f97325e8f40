//! Model `angular`: a ball bearing whose contact angles follow the displacement, in closed form
//! (`docs/src/models.md#angular-contact-bearing`).
//!
//! The groove centres have the distance vector `(A_r, A_z)` in the plane of each ball; the deflection is `delta = |(A_r,
//! A_z)| - A`, and the load `Q = K_n delta^(3/2)` acts along that vector. Both contacts are in series, without inertia and
//! film: the quasi-static equilibrium of a ball without rotation.
//!
//! Source: the displacement-coordinate model with which Wang, Han and Zhou, Mechanical Systems and Signal Processing 85 (2017),
//! compare.

use super::bearing_in_cage;
use super::element_position::ElementLayout;
use super::elements::Elements;
use super::geometry::{BallBearingGeometry, InvalidParameter};
use super::ring::{Contact, ContactStiffness, Motion, Ring, to_cage_frame};
use super::surface::{Smooth, Surface};
use crate::contact::law::{LoadDeflectionLaw, PointContactLaw};
use crate::frame::Displacement;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::Lanes;
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Relative position of the rings at zero displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum DisplacementDatum {
    /// The rings just touch the balls at the contact angle: groove centres A apart, axially `A sin(alpha_0)`.
    Touching,
    /// The rings are concentric and centred axially: groove centres `A cos(alpha_0)` apart radially. For deep-groove
    /// bearings.
    Centred,
}

/// A ball bearing with variable contact angle. Cost per ball: two square roots, two divisions.
#[derive(Debug, Clone, Copy)]
pub struct Angular<T, M, P, S = Smooth> {
    ring: Ring<T, P>,
    law: PointContactLaw<T>,
    /// A, m.
    distance: T,
    /// A^2, m^2.
    distance_squared: T,
    /// (A_r, A_z) at zero displacement, m.
    unloaded: (T, T),
    /// A_r^2 + A_z^2 - A^2 at zero displacement; exactly 0 for `Touching`.
    excess: T,
    surface: S,
    math: PhantomData<M>,
}

/// Precomputed constants of an [`Angular`] bearing, without the element positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AngularConstants<T> {
    /// K_n, stiffness of both contacts in series, N/m^1.5.
    pub stiffness: T,
    /// A (m) and A^2 (m^2).
    pub distance: [T; 2],
    /// A_r and A_z at zero displacement, m.
    pub unloaded: [T; 2],
    /// A_r^2 + A_z^2 - A^2 at zero displacement, m^2.
    pub excess: T,
    /// R_i, lever arm, m.
    pub arm: T,
}

impl AngularConstants<f64> {
    /// Computes the constants: Hertz stiffness at the free contact angle, lever arm R_i. For set-up.
    ///
    /// # Errors
    /// As [`BallBearingGeometry::checked`].
    pub fn try_new(geometry: BallBearingGeometry, datum: DisplacementDatum) -> Result<Self, InvalidParameter> {
        let geometry = geometry.checked()?;
        let a = geometry.groove_distance();
        let (sin, cos) = (libm::sin(geometry.contact_angle), libm::cos(geometry.contact_angle));
        let (axial, excess) = match datum {
            DisplacementDatum::Touching => (a * sin, 0.0),
            DisplacementDatum::Centred => (0.0, -(a * sin) * (a * sin)),
        };
        Ok(Self {
            stiffness: geometry.stiffness(),
            distance: [a, a * a],
            unloaded: [a * cos, axial],
            excess,
            arm: geometry.inner_groove_radius(),
        })
    }

    /// Returns the constants in another precision.
    #[must_use]
    pub fn rounded<T: Scalar>(&self) -> AngularConstants<T> {
        AngularConstants {
            stiffness: T::from_f64(self.stiffness),
            distance: self.distance.map(T::from_f64),
            unloaded: self.unloaded.map(T::from_f64),
            excess: T::from_f64(self.excess),
            arm: T::from_f64(self.arm),
        }
    }
}

/// Distance of the groove centres in the plane of one ball, and the deflection. With `Lanes`: of several balls.
#[derive(Clone, Copy)]
struct Grooves<T> {
    radial: T,
    axial: T,
    length: T,
    /// Deflection of both contacts together; negative in a gap.
    gap: T,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>> Angular<T, M, P> {
    /// From geometry; stiffness by Hertz at the free contact angle, lever arm R_i. Set-up time.
    ///
    /// # Errors
    /// As [`BallBearingGeometry::checked`].
    pub fn try_new(
        geometry: BallBearingGeometry,
        positions: P,
        datum: DisplacementDatum,
    ) -> Result<Self, InvalidParameter> {
        Ok(Self::from_constants(positions, AngularConstants::try_new(geometry, datum)?.rounded()))
    }

    /// Creates the bearing from precomputed constants without checks.
    pub fn from_constants(positions: P, seat: AngularConstants<T>) -> Self {
        let law = PointContactLaw { stiffness: seat.stiffness };
        let [distance, distance_squared] = seat.distance;
        let [radial, axial] = seat.unloaded;
        Self {
            ring: Ring {
                positions,
                arm: seat.arm,
                scale: <PointContactLaw<T> as LoadDeflectionLaw<T, M>>::scale(&law),
            },
            law,
            distance,
            distance_squared,
            unloaded: (radial, axial),
            excess: seat.excess,
            surface: Smooth,
            math: PhantomData,
        }
    }

    /// Returns the bearing with surface deviations.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Angular<T, M, P, S> {
        Angular {
            ring: self.ring,
            law: self.law,
            distance: self.distance,
            distance_squared: self.distance_squared,
            unloaded: self.unloaded,
            excess: self.excess,
            surface,
            math: PhantomData,
        }
    }
}

/// Relative position of the groove centres in the plane of one ball.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GrooveCentres<T> {
    /// A_r and A_z, radial and axial distance, m.
    pub distance: [T; 2],
    /// Deflection of both contacts together, m; negative in a gap.
    pub deflection: T,
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, S: Surface<T>> Angular<T, M, P, S> {
    /// Computes the relative position of the groove centres at each ball, in the order of the elements, for the displacement
    /// `u` of the inner ring.
    pub fn groove_centres(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, balls: &mut [GrooveCentres<T>]) {
        let rim = self.ring.at_rim(&to_cage_frame(u, M::sin_cos(at.cage)));
        for (position, ball) in self.ring.positions.all().zip(balls) {
            let motion = Motion::of(&position, &rim, at, &self.surface);
            let Grooves { radial: Lanes([r]), axial: Lanes([z]), gap: Lanes([gap]), .. } = self.grooves(motion.alone());
            *ball = GrooveCentres { distance: [r, z], deflection: gap };
        }
    }

    /// Computes the distance of the groove centres and `|(A_r, A_z)| - A` as `(A_r^2 + A_z^2 - A^2)/(|.| + A)`, with the
    /// numerator from the displacements.
    ///
    /// The difference of two nearly equal lengths would lose three digits of a micrometre in `f32`, and all digits with an
    /// approximate square root.
    #[inline(always)]
    fn grooves<const K: usize>(&self, at: Motion<Lanes<T, K>>) -> Grooves<Lanes<T, K>> {
        let all = Lanes::<T, K>::splat;
        let m = at.with_waviness();
        let (r0, z0) = (all(self.unloaded.0), all(self.unloaded.1));
        let (radial, axial) = (r0 + m.radial, z0 + m.axial);
        // A_r^2 + A_z^2 - A^2
        let excess = ((r0 + radial) * m.radial + (z0 + axial) * m.axial) + all(self.excess);
        let length = (all(self.distance_squared) + excess).sqrt::<M>();
        let gap = excess / (length + all(self.distance)) + (m.deviation.inner + m.deviation.outer);
        Grooves { radial, axial, length, gap }
    }
}

impl<T: Scalar, const K: usize> Grooves<Lanes<T, K>> {
    /// Returns the contacts with `load` along the line of groove centres.
    #[inline(always)]
    fn contacts(&self, load: Lanes<T, K>) -> Contact<Lanes<T, K>> {
        let by_length = load / self.length;
        let axial = by_length * self.axial;
        Contact { radial: by_length * self.radial, axial, tilting: axial, load }
    }
}

impl<T: Scalar, M: Math<T>, P: ElementLayout<T>, S: Surface<T>> Elements for Angular<T, M, P, S> {
    type Scalar = T;
    type Math = M;
    type ElementPositions = P;
    type Surface = S;
    #[inline(always)]
    fn surface(&self) -> &S {
        &self.surface
    }
    #[inline(always)]
    fn ring(&self) -> &Ring<T, P> {
        &self.ring
    }
    #[inline(always)]
    fn contacts<const K: usize>(&self, at: Motion<Lanes<T, K>>) -> Contact<Lanes<T, K>> {
        let grooves = self.grooves(at);
        let twice_deflection = grooves.gap.twice_positive_part();
        grooves.contacts(Lanes(<PointContactLaw<T> as LoadDeflectionLaw<T, M>>::unscaled_load(
            &self.law,
            twice_deflection.0,
        )))
    }

    /// Stiffness `k e e^T + (Q/l)(1 - e e^T)` with `k = dQ/d(delta)`: elongation and rotation of the contact line.
    #[inline(always)]
    fn contact_and_stiffness(&self, at: Motion<T>) -> (Contact<T>, ContactStiffness<T>) {
        let grooves = self.grooves(at.alone());
        let Grooves { radial: Lanes([r]), axial: Lanes([z]), length: Lanes([length]), gap: Lanes([gap]) } = grooves;
        let (load, slope) = <PointContactLaw<T> as LoadDeflectionLaw<T, M>>::unscaled_load_and_slope(
            &self.law,
            gap.twice_positive_part(),
        );
        let (cos, sin) = (r / length, z / length);
        let across = load / length;
        let extra = slope - across;
        let stiffness = ContactStiffness {
            radial: across + extra * cos * cos,
            cross: extra * cos * sin,
            axial: across + extra * sin * sin,
        };
        (grooves.contacts(Lanes([load])).alone(), stiffness)
    }
}

bearing_in_cage!(Angular<T, M, P, S>, T: Scalar, M: Math<T>, P: ElementLayout<T>, S: Surface<T>);
