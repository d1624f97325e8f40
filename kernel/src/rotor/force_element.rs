//! Forces of bearings on the coordinates of a system.

use super::SpeedRatios;
use crate::bearing::{Bearing, Reaction};
use crate::frame::{Displacement, Stiffness, stiffness_from_station};
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use crate::status::Status;
use nalgebra::SMatrix;

/// An element with components that follow the rotation of the shaft.
pub trait HasSpeedRatios<T> {
    /// Returns the speed ratios of the components.
    fn speed_ratios(&self) -> &SpeedRatios<T>;
}

/// A nonlinear force on the coordinates of a system: a part of `f_B(q, t)` of Hajzman, eq. 6.
pub trait ForceElement<T: Scalar, const D: usize>: HasSpeedRatios<T> {
    /// Adds the force at `q` to `f`; returns the sum of the element loads and the status.
    fn add_force(&self, q: &[T; D], at: &BearingKinematicState<T>, f: &mut [T; D]) -> (T, Status);

    /// Adds the force to `f` and the tangent `-df/dq` to `k`; returns the sum of the element loads and the status.
    fn add_force_and_stiffness(
        &self,
        q: &[T; D],
        at: &BearingKinematicState<T>,
        f: &mut [T; D],
        k: &mut SMatrix<T, D, D>,
    ) -> (T, Status);
}

/// A bearing on a rigid rotor, with its outer ring fixed.
#[derive(Debug, Clone, Copy)]
pub struct BearingAtStation<T, B> {
    /// Bearing model.
    pub bearing: B,
    /// Station along Z from the centre of mass, m.
    pub station: T,
    /// Speed ratios of the bearing components.
    pub speed_ratios: SpeedRatios<T>,
}

impl<T, B> HasSpeedRatios<T> for BearingAtStation<T, B> {
    fn speed_ratios(&self) -> &SpeedRatios<T> {
        &self.speed_ratios
    }
}

impl<T, C: HasSpeedRatios<T>> HasSpeedRatios<T> for &C {
    fn speed_ratios(&self) -> &SpeedRatios<T> {
        (**self).speed_ratios()
    }
}

impl<T: Scalar, C: ForceElement<T, D>, const D: usize> ForceElement<T, D> for &C {
    fn add_force(&self, q: &[T; D], at: &BearingKinematicState<T>, f: &mut [T; D]) -> (T, Status) {
        (**self).add_force(q, at, f)
    }

    fn add_force_and_stiffness(
        &self,
        q: &[T; D],
        at: &BearingKinematicState<T>,
        f: &mut [T; D],
        k: &mut SMatrix<T, D, D>,
    ) -> (T, Status) {
        (**self).add_force_and_stiffness(q, at, f, k)
    }
}

fn add_wrench<T: Scalar>(f: &mut [T; 5], reaction: Reaction<T>, station: T) -> (T, Status) {
    let moved = reaction.moved_from(station);
    super::vector::add(f, &moved.wrench.to_array());
    (moved.load, moved.status)
}

impl<T: Scalar, B: Bearing<T>> ForceElement<T, 5> for BearingAtStation<T, B> {
    #[inline(always)]
    fn add_force(&self, q: &[T; 5], at: &BearingKinematicState<T>, f: &mut [T; 5]) -> (T, Status) {
        let u = Displacement::from_array(*q).at_station(self.station);
        add_wrench(f, self.bearing.reaction(&u, at), self.station)
    }

    fn add_force_and_stiffness(
        &self,
        q: &[T; 5],
        at: &BearingKinematicState<T>,
        f: &mut [T; 5],
        k: &mut SMatrix<T, 5, 5>,
    ) -> (T, Status) {
        let u = Displacement::from_array(*q).at_station(self.station);
        let (reaction, stiffness) = self.bearing.reaction_and_stiffness(&u, at);
        *k += stiffness_from_station(&stiffness, self.station);
        add_wrench(f, reaction, self.station)
    }
}

/// Linear map from the coordinates of a system to the displacement of a bearing, `u = T q`.
///
/// The displacement is that of the inner ring relative to the outer ring. The rows of `T` are the extended vectors of
/// Hajzman in the order of [`Displacement`]; the forces on the coordinates are `T^T f`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Attachment<T: Scalar, const D: usize>(pub(super) SMatrix<T, 5, D>);

impl<T: Scalar, const D: usize> Attachment<T, D> {
    /// Creates the map from the five extended vectors.
    #[must_use]
    pub fn new(extended: &[[f64; D]; 5]) -> Self {
        Self(SMatrix::from_fn(|i, j| T::from_f64(extended.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0))))
    }

    /// Creates the map for a rigid rotor in the first five coordinates, at `station` (m, along Z from its centre of mass).
    /// With `housing`, the outer ring moves along X and Y with that coordinate and the next one.
    #[must_use]
    pub fn on_rigid_rotor(station: f64, housing: Option<usize>) -> Self {
        let one = |hit: bool| f64::from(u8::from(hit));
        Self(SMatrix::from_fn(|i, j| {
            let rotor = match (i, j) {
                (0, 4) => station,
                (1, 3) => -station,
                _ => one(i == j),
            };
            let outer = housing.map_or(0.0, |first| one(i < 2 && j == first + i));
            T::from_f64(rotor - outer)
        }))
    }

    /// Returns `T q`. Cost: `5 D` multiplications.
    #[must_use]
    pub fn displacement(&self, q: &[T; D]) -> Displacement<T> {
        let mut u = [T::ZERO; 5];
        for (&x, column) in q.iter().zip(&self.0.data.0) {
            for (entry, &t) in u.iter_mut().zip(column) {
                *entry += t * x;
            }
        }
        Displacement::from_array(u)
    }

    /// Computes `f += T^T wrench`.
    pub(super) fn spread(&self, wrench: &[T; 5], f: &mut [T; D]) {
        for (entry, column) in f.iter_mut().zip(&self.0.data.0) {
            for (&w, &t) in wrench.iter().zip(column) {
                *entry += t * w;
            }
        }
    }

    /// Computes `k += T^T stiffness T`. Cost: `5 D (5 + D)` multiplications.
    pub(super) fn spread_stiffness(&self, stiffness: &Stiffness<T>, k: &mut SMatrix<T, D, D>) {
        for (mut column, extended) in k.column_iter_mut().zip(self.0.column_iter()) {
            let mut wrench = [T::ZERO; 5];
            for (&t, of) in extended.iter().zip(stiffness.column_iter()) {
                for (entry, &stiffness) in wrench.iter_mut().zip(of.iter()) {
                    *entry += stiffness * t;
                }
            }
            for (entry, extended) in column.iter_mut().zip(self.0.column_iter()) {
                for (&w, &t) in wrench.iter().zip(extended.iter()) {
                    *entry += t * w;
                }
            }
        }
    }
}

/// A bearing on any coordinates of a system.
#[derive(Debug, Clone, Copy)]
pub struct AttachedBearing<T: Scalar, B, const D: usize> {
    /// Bearing model.
    pub bearing: B,
    /// Map from the coordinates to the displacement of the bearing.
    pub attachment: Attachment<T, D>,
    /// Speed ratios of the bearing components.
    pub speed_ratios: SpeedRatios<T>,
}

impl<T: Scalar, B, const D: usize> HasSpeedRatios<T> for AttachedBearing<T, B, D> {
    fn speed_ratios(&self) -> &SpeedRatios<T> {
        &self.speed_ratios
    }
}

impl<T: Scalar, B: Bearing<T>, const D: usize> ForceElement<T, D> for AttachedBearing<T, B, D> {
    fn add_force(&self, q: &[T; D], at: &BearingKinematicState<T>, f: &mut [T; D]) -> (T, Status) {
        let reaction = self.bearing.reaction(&self.attachment.displacement(q), at);
        self.attachment.spread(&reaction.wrench.to_array(), f);
        (reaction.load, reaction.status)
    }

    fn add_force_and_stiffness(
        &self,
        q: &[T; D],
        at: &BearingKinematicState<T>,
        f: &mut [T; D],
        k: &mut SMatrix<T, D, D>,
    ) -> (T, Status) {
        let (reaction, stiffness) = self.bearing.reaction_and_stiffness(&self.attachment.displacement(q), at);
        self.attachment.spread_stiffness(&stiffness, k);
        self.attachment.spread(&reaction.wrench.to_array(), f);
        (reaction.load, reaction.status)
    }
}
