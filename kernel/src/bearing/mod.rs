//! Bearing models, one module per model in the order of their cost: [`linear`], [`lumped`], [`angular`], [`tabulated`],
//! [`quasi_static`]; rollers by laminae: [`roller`]. Without a floating-point unit: [`fixed_point`].

pub mod angular;
pub mod batch;
pub mod checksum;
mod common;
mod element_position;
mod elements;
pub mod fixed_point;
pub mod flexible;
pub mod geometry;
pub mod kinematics;
pub mod last_valid;
pub mod linear;
pub mod lumped;
pub mod quasi_static;
mod ring;
pub mod roller;
pub mod surface;
pub mod tabulated;

pub use common::{
    AngularContact, DeepGroove, HighSpeedBearing, LubricatedBearing, LumpedAxial, LumpedRadial, LumpedRadialAxial,
    LumpedRoller, QuasiStaticBearing, QuasiStaticRollerBearing, RollerBearing, TabulatedBearing,
};
pub use element_position::{
    BLOCK_SIZE, BlockedPositions, ElementBlock, ElementLayout, ElementPosition, ElementPositions, OpposedPairs,
    evenly_spaced, evenly_spaced_pairs,
};
pub use elements::CageFrame;
pub use last_valid::LastValidWrench;

use crate::frame::{Displacement, Stiffness, Wrench, mirrored_stiffness};
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use crate::status::Status;
use core::ops::Add;

/// Force of a bearing at one displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reaction<T> {
    /// Force and moment on the inner ring.
    pub wrench: Wrench<T>,
    /// Sum of the element loads, N; 0 without contact.
    pub load: T,
    /// Status flags of the evaluation.
    pub status: Status,
}

impl<T: Scalar> Reaction<T> {
    /// Returns the equivalent reaction at the point 0 of a rigid body, for one that acts at `station` along Z.
    pub(crate) fn moved_from(self, station: T) -> Self {
        Self { wrench: self.wrench.from_station(station), ..self }
    }
}

impl<T: Scalar> Add for Reaction<T> {
    type Output = Self;
    /// Returns the reaction of two bearings, or of two kinds of element, together.
    #[inline]
    fn add(self, other: Self) -> Self {
        Self {
            wrench: self.wrench + other.wrench,
            load: self.load + other.load,
            status: self.status.union(other.status),
        }
    }
}

/// A bearing model: force on the inner ring from its displacement relative to the outer ring.
///
/// All methods are pure and take a constant number of instructions on a core with a floating-point unit of the precision `T`; the routines
/// of software floats branch on their values ([`fixed_point`] is for a core without one). Displacements and speeds must be finite, except in
/// [`Bearing::sample`].
pub trait Bearing<T: Scalar>: Send + Sync {
    /// Computes the force on the inner ring.
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T>;

    /// Computes the force and its tangent stiffness `-d(wrench)/du`.
    fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &BearingKinematicState<T>)
    -> (Reaction<T>, Stiffness<T>);

    /// Writes the load on each element, N, as many as `loads` takes. A bearing without elements writes nothing.
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]);

    /// Computes the force as [`Bearing::reaction`] and writes the loads of [`Bearing::element_loads`]; on a desktop processor at the cost of
    /// the force alone.
    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        self.element_loads(u, at, loads);
        self.reaction(u, at)
    }

    /// Computes [`Bearing::reaction`] at many displacements, with the same bits; a desktop processor computes several side by side. The
    /// shortest slice limits their number.
    fn reactions(&self, u: &[Displacement<T>], at: &[BearingKinematicState<T>], reactions: &mut [Reaction<T>]) {
        for ((u, at), reaction) in u.iter().zip(at).zip(reactions) {
            *reaction = self.reaction(u, at);
        }
    }

    /// Computes the force for one sample of a stream.
    ///
    /// As [`Bearing::reaction`], but samples that are NaN, infinite or overflow are flagged, counted and replaced by the
    /// last valid wrench.
    fn sample(
        &self,
        last_valid: &mut LastValidWrench<T>,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Wrench<T>, Status) {
        last_valid.update(u.is_finite(), || self.reaction(u, at))
    }
}

impl<T: Scalar, B: Bearing<T> + ?Sized> Bearing<T> for &B {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        (**self).reaction(u, at)
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        (**self).reaction_and_stiffness(u, at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        (**self).element_loads(u, at, loads);
    }
    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        (**self).reaction_and_loads(u, at, loads)
    }
}

/// Implements [`Bearing`] for a type that implements [`CageFrame`]: rotation to the cage frame, evaluation, rotation back.
///
/// A blanket implementation would overlap with that for references.
macro_rules! bearing_in_cage {
    ($kind:ty, $($generics:tt)*) => {
        impl<$($generics)*> $crate::Bearing<T> for $kind {
            fn reaction(&self, u: &$crate::Displacement<T>, at: &$crate::BearingKinematicState<T>) -> $crate::bearing::Reaction<T> {
                $crate::bearing::CageFrame::reaction_inlined(self, u, at)
            }
            fn reaction_and_stiffness(
                &self,
                u: &$crate::Displacement<T>,
                at: &$crate::BearingKinematicState<T>,
            ) -> ($crate::bearing::Reaction<T>, $crate::Stiffness<T>) {
                use $crate::bearing::{CageFrame, ring};
                let turn = Self::cage_rotation(at.cage);
                let (local, k) = self.reaction_and_stiffness_in_cage_frame(&ring::to_cage_frame(u, turn), at, turn);
                ($crate::bearing::Reaction { wrench: ring::from_cage_frame(&local.wrench, turn), ..local }, k)
            }
            fn element_loads(&self, u: &$crate::Displacement<T>, at: &$crate::BearingKinematicState<T>, loads: &mut [T]) {
                use $crate::bearing::{CageFrame, ring};
                self.element_loads_in_cage_frame(&ring::to_cage_frame(u, Self::cage_rotation(at.cage)), at, loads);
            }
            fn reaction_and_loads(
                &self,
                u: &$crate::Displacement<T>,
                at: &$crate::BearingKinematicState<T>,
                loads: &mut [T],
            ) -> $crate::bearing::Reaction<T> {
                $crate::bearing::CageFrame::reaction_and_loads_inlined(self, u, at, loads)
            }
        }
    };
}
use bearing_in_cage;

/// A bearing that carries thrust towards -Z: the model in the frame rotated by pi about X.
///
/// The inner bearing takes positions by [`ElementPosition::mirrored`] and features by [`surface::Feature::mirrored`].
#[derive(Debug, Clone, Copy)]
pub struct Mirrored<B>(pub B);

impl<T: Scalar, B: Bearing<T>> Bearing<T> for Mirrored<B> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        let local = self.0.reaction(&u.mirrored(), &at.reversed());
        Reaction { wrench: local.wrench.mirrored(), ..local }
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        let (local, k) = self.0.reaction_and_stiffness(&u.mirrored(), &at.reversed());
        (Reaction { wrench: local.wrench.mirrored(), ..local }, mirrored_stiffness(&k))
    }
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.0.element_loads(&u.mirrored(), &at.reversed(), loads);
    }
    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        let local = self.0.reaction_and_loads(&u.mirrored(), &at.reversed(), loads);
        Reaction { wrench: local.wrench.mirrored(), ..local }
    }
}
