//! Rung `angular`: a ball bearing whose contact angle follows the displacement, in closed form (MODEL A.10).
//!
//! The groove centres stand `(A_r, A_z)` apart in each ball's plane; the deflection is the lengthening of that
//! vector, `delta = |(A_r, A_z)| - A`, the load `Q = K_n delta^(3/2)` acts along it. Both races in series,
//! no inertia, no film: what a ball in quasi-static equilibrium does at rest.

use super::geometry::{BallBearingGeometry, InvalidParameter};
use super::ring::{Contact, ContactStiffness, Place, Ring, StiffnessSum, WrenchSum, into_cage};
use super::surface::{Smooth, Surface};
use super::{Bearing, Reaction};
use crate::contact::law::{Law, Point};
use crate::frame::{Displacement, Stiffness};
use crate::math::Math;
use crate::scalar::Scalar;
use crate::turn::Turn;
use core::marker::PhantomData;

/// Where the rings stand at zero displacement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zero {
    /// Just touching the balls at the contact angle: groove centres A apart, axially `A sin(alpha_0)`.
    Touching,
    /// Concentric and centred axially, groove centres `A cos(alpha_0)` apart radially: a deep groove bearing.
    Centred,
}

/// Variable-contact-angle bearing. Cost per ball: one square root, two divisions, the load law.
#[derive(Debug, Clone, Copy)]
pub struct Angular<T, M, P, S = Smooth> {
    ring: Ring<T, P>,
    law: Point<T>,
    /// A
    distance: T,
    /// (A_r, A_z) at zero displacement
    unloaded: (T, T),
    /// A_r^2 + A_z^2 - A^2 there, exactly 0 for `Touching`
    excess: T,
    surface: S,
    math: PhantomData<M>,
}

/// Deflection and direction at one ball.
struct Groove<T> {
    delta: T,
    length: T,
    cos: T,
    sin: T,
}

impl<T: Scalar, M: Math<T>, P: AsRef<[Place<T>]>> Angular<T, M, P> {
    /// From geometry; stiffness by Hertz at the free contact angle, lever arm R_i. Set-up time.
    ///
    /// # Errors
    /// As [`BallBearingGeometry::checked`].
    pub fn try_new(geometry: BallBearingGeometry, places: P, zero: Zero) -> Result<Self, InvalidParameter> {
        let geometry = geometry.checked()?;
        let a = geometry.groove_distance();
        let (sin, cos) = (libm::sin(geometry.contact_angle), libm::cos(geometry.contact_angle));
        let (axial, excess) = match zero {
            Zero::Touching => (a * sin, 0.0),
            Zero::Centred => (0.0, -(a * sin) * (a * sin)),
        };
        Ok(Self {
            ring: Ring::new(places, geometry.inner_groove_radius()),
            law: Point { stiffness: T::from_f64(geometry.stiffness()) },
            distance: T::from_f64(a),
            unloaded: (T::from_f64(a * cos), T::from_f64(axial)),
            excess: T::from_f64(excess),
            surface: Smooth,
            math: PhantomData,
        })
    }

    /// The same bearing with damage on its outer race.
    pub fn with_surface<S: Surface<T>>(self, surface: S) -> Angular<T, M, P, S> {
        Angular {
            ring: self.ring,
            law: self.law,
            distance: self.distance,
            unloaded: self.unloaded,
            excess: self.excess,
            surface,
            math: PhantomData,
        }
    }
}

impl<T: Scalar, M: Math<T>, P: AsRef<[Place<T>]>, S: Surface<T>> Angular<T, M, P, S> {
    /// `|(A_r, A_z)| - A` as `(A_r^2 + A_z^2 - A^2)/(|.| + A)`: the difference of two nearly equal lengths
    /// would lose three digits of a micrometre in f32, and all of it with an approximate square root.
    #[inline(always)]
    fn groove(&self, place: &Place<T>, u: &Displacement<T>, cage: Turn) -> Groove<T> {
        let (radial, axial) = self.ring.at(place, u);
        let (r, z) = (self.unloaded.0 + radial, self.unloaded.1 + axial);
        let length = M::sqrt(r * r + z * z);
        let excess = (self.unloaded.0 + r) * radial + ((self.unloaded.1 + z) * axial + self.excess);
        let gap = excess / (length + self.distance) - self.surface.drop_at(place.azimuth.plus(cage));
        let inverse = T::ONE / length;
        Groove { delta: gap.positive_part(), length, cos: r * inverse, sin: z * inverse }
    }

    #[inline(always)]
    fn load(&self, delta: T) -> T {
        <Point<T> as Law<T, M>>::load(&self.law, delta)
    }
}

impl<T, M, P, S> Bearing<T> for Angular<T, M, P, S>
where
    T: Scalar,
    M: Math<T>,
    P: AsRef<[Place<T>]> + Send + Sync,
    S: Surface<T>,
{
    fn reaction(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T> {
        let turn = M::sin_cos(cage);
        let local = into_cage(u, turn);
        let mut sum = WrenchSum::default();
        for place in self.ring.places() {
            let g = self.groove(place, &local, cage);
            let load = self.load(g.delta);
            sum.add(place, &Contact { radial: -(load * g.cos), axial: -(load * g.sin), load });
        }
        Reaction { wrench: sum.finish(self.ring.arm, turn), load: sum.load }
    }

    /// Per ball `k e e^T + (Q/l)(1 - e e^T)` with `k = 3/2 K sqrt(delta)`: stretching and turning of the contact line.
    fn reaction_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>) {
        let turn = M::sin_cos(cage);
        let local = into_cage(u, turn);
        let (mut sum, mut k) = (WrenchSum::default(), StiffnessSum::new());
        for place in self.ring.places() {
            let g = self.groove(place, &local, cage);
            let (load, slope) = <Point<T> as Law<T, M>>::load_and_slope(&self.law, g.delta);
            sum.add(place, &Contact { radial: -(load * g.cos), axial: -(load * g.sin), load });
            let across = load / g.length;
            let extra = slope - across;
            let stiffness = ContactStiffness {
                radial: across + extra * g.cos * g.cos,
                cross: extra * g.cos * g.sin,
                axial: across + extra * g.sin * g.sin,
            };
            k.add(place, self.ring.arm, &stiffness);
        }
        (Reaction { wrench: sum.finish(self.ring.arm, turn), load: sum.load }, k.finish(turn))
    }

    fn element_loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]) {
        let local = into_cage(u, M::sin_cos(cage));
        for (place, load) in self.ring.places().iter().zip(loads) {
            *load = self.load(self.groove(place, &local, cage).delta);
        }
    }
}
