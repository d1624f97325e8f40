//! One bearing, one file a rung of the ladder, cheapest first: [`linear`], [`lumped`], [`angular`].

pub mod angular;
pub mod batch;
mod elements;
pub mod flexible;
pub mod geometry;
pub mod held;
pub mod kinematics;
pub mod linear;
pub mod lumped;
mod place;
mod ring;
pub mod surface;

pub use elements::InCage;
pub use held::HeldWrench;
pub use place::{Arrangement, Pairs, Place, Places, even_pairs, even_places};

use crate::frame::{Displacement, Stiffness, Wrench, mirrored_stiffness};
use crate::scalar::Scalar;
use crate::status::Status;
use crate::turn::Turn;

/// What a bearing answers to a displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reaction<T> {
    /// Force and moment on the inner ring.
    pub wrench: Wrench<T>,
    /// Sum of the element loads, N: 0 where contact is lost.
    pub load: T,
}

/// A bearing: force on the inner ring from the inner ring's displacement relative to the outer ring.
///
/// All methods are pure and of fixed cost; inputs are taken as finite ([`Bearing::sample`] checks them).
pub trait Bearing<T: Scalar>: Send + Sync {
    /// Force on the inner ring with the cage at `cage`.
    fn reaction(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T>;

    /// Force and its tangent `-d(wrench)/du`.
    fn reaction_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>);

    /// Load on each element, N, into `loads` as far as both go. A bearing without elements writes nothing.
    fn element_loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]);

    /// One sample of a stream: as [`Bearing::reaction`], but NaN, infinite and overflowing samples are
    /// flagged, counted, and answered with the last good wrench.
    fn sample(&self, held: &mut HeldWrench<T>, u: &Displacement<T>, cage: Turn) -> (Wrench<T>, Status) {
        held.take(u.is_finite(), || self.reaction(u, cage))
    }
}

impl<T: Scalar, B: Bearing<T> + ?Sized> Bearing<T> for &B {
    fn reaction(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T> {
        (**self).reaction(u, cage)
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>) {
        (**self).reaction_and_stiffness(u, cage)
    }
    fn element_loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]) {
        (**self).element_loads(u, cage, loads);
    }
}

/// Implements [`Bearing`] for a type that is [`InCage`]: into the cage's frame, through the elements, and out of it.
macro_rules! bearing_in_cage {
    ($kind:ty, $($generics:tt)*) => {
        impl<$($generics)*> $crate::Bearing<T> for $kind {
            fn reaction(&self, u: &$crate::Displacement<T>, cage: $crate::Turn) -> $crate::bearing::Reaction<T> {
                use $crate::bearing::{InCage, ring};
                let turn = Self::turn(cage);
                let local = self.reaction_in_cage(&ring::into_cage(u, turn), cage);
                $crate::bearing::Reaction { wrench: ring::out_of_cage(&local.wrench, turn), ..local }
            }
            fn reaction_and_stiffness(
                &self,
                u: &$crate::Displacement<T>,
                cage: $crate::Turn,
            ) -> ($crate::bearing::Reaction<T>, $crate::Stiffness<T>) {
                use $crate::bearing::{InCage, ring};
                let turn = Self::turn(cage);
                let (local, k) = self.reaction_in_cage_and_stiffness(&ring::into_cage(u, turn), cage, turn);
                ($crate::bearing::Reaction { wrench: ring::out_of_cage(&local.wrench, turn), ..local }, k)
            }
            fn element_loads(&self, u: &$crate::Displacement<T>, cage: $crate::Turn, loads: &mut [T]) {
                use $crate::bearing::{InCage, ring};
                self.element_loads_in_cage(&ring::into_cage(u, Self::turn(cage)), cage, loads);
            }
        }
    };
}
use bearing_in_cage;

/// A bearing that carries thrust towards -Z: the same kernel turned by pi about X.
///
/// The bearing inside is built from places that are [`Place::mirrored`] (and mirrored surfaces) so that its
/// elements stand where they should.
#[derive(Debug, Clone, Copy)]
pub struct Mirrored<B>(pub B);

impl<T: Scalar, B: Bearing<T>> Bearing<T> for Mirrored<B> {
    fn reaction(&self, u: &Displacement<T>, cage: Turn) -> Reaction<T> {
        let local = self.0.reaction(&u.mirrored(), cage.reversed());
        Reaction { wrench: local.wrench.mirrored(), ..local }
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, cage: Turn) -> (Reaction<T>, Stiffness<T>) {
        let (local, k) = self.0.reaction_and_stiffness(&u.mirrored(), cage.reversed());
        (Reaction { wrench: local.wrench.mirrored(), ..local }, mirrored_stiffness(&k))
    }
    fn element_loads(&self, u: &Displacement<T>, cage: Turn, loads: &mut [T]) {
        self.0.element_loads(&u.mirrored(), cage.reversed(), loads);
    }
}
