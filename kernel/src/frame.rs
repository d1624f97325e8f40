//! Displacement, wrench and stiffness of a ring, and their transformations.
//!
//! Fixed frame: X, Y radial, Z along the shaft, right-handed.

use crate::scalar::Scalar;
use core::ops::{Add, Sub};
use nalgebra::SMatrix;

/// Displacement of a ring, or of the inner ring relative to the outer ring.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Displacement<T> {
    /// Along X, m.
    pub u: T,
    /// Along Y, m.
    pub v: T,
    /// Along Z, m.
    pub w: T,
    /// Tilt about X, rad.
    pub thu: T,
    /// Tilt about Y, rad.
    pub thv: T,
}

/// Force and moment on the inner ring.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Wrench<T> {
    /// Along X, N.
    pub fx: T,
    /// Along Y, N.
    pub fy: T,
    /// Along Z, N.
    pub fz: T,
    /// About X, N m.
    pub mx: T,
    /// About Y, N m.
    pub my: T,
}

/// Tangent stiffness `-d(wrench)/d(displacement)`: rows `FX, FY, FZ, MX, MY`, columns `u, v, w, thu, thv`.
pub type Stiffness<T> = SMatrix<T, 5, 5>;

impl<T: Scalar> Displacement<T> {
    /// Returns the five entries in order.
    pub fn to_array(self) -> [T; 5] {
        [self.u, self.v, self.w, self.thu, self.thv]
    }

    /// Creates the vector from its five entries in order.
    pub fn from_array([u, v, w, thu, thv]: [T; 5]) -> Self {
        Self { u, v, w, thu, thv }
    }

    /// Converts the vector `q = [u v w phi psi theta]` of Hajzman, eq. 2, with X axial and Y, Z radial. The torsion `phi`
    /// has no effect on a bearing.
    pub fn from_hajzman([u, v, w, _phi, psi, theta]: [T; 6]) -> Self {
        Self { u: v, v: w, w: u, thu: psi, thv: theta }
    }

    /// Returns the displacement in the frame rotated by pi about X, in which a bearing that faces -Z is one that faces +Z.
    pub fn mirrored(self) -> Self {
        Self { u: self.u, v: -self.v, w: -self.w, thu: self.thu, thv: -self.thv }
    }

    /// Returns true if no entry is NaN or infinite.
    pub fn is_finite(self) -> bool {
        all_finite(self.to_array())
    }

    /// Returns `a` if `first`, else `b`, with the same instructions in both cases.
    pub fn select(first: bool, a: Self, b: Self) -> Self {
        Self::from_array(select(first, a.to_array(), b.to_array()))
    }

    /// Returns the displacement of the point at `station` (m, along Z) of a rigid body whose point at 0 has this
    /// displacement.
    pub fn at_station(self, station: T) -> Self {
        Self { u: self.u + station * self.thv, v: self.v - station * self.thu, ..self }
    }
}

impl<T: Scalar> Add for Displacement<T> {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self { u: self.u + b.u, v: self.v + b.v, w: self.w + b.w, thu: self.thu + b.thu, thv: self.thv + b.thv }
    }
}

impl<T: Scalar> Sub for Displacement<T> {
    type Output = Self;
    #[inline]
    fn sub(self, b: Self) -> Self {
        Self { u: self.u - b.u, v: self.v - b.v, w: self.w - b.w, thu: self.thu - b.thu, thv: self.thv - b.thv }
    }
}

impl<T: Scalar> Add for Wrench<T> {
    type Output = Self;
    #[inline]
    fn add(self, b: Self) -> Self {
        Self { fx: self.fx + b.fx, fy: self.fy + b.fy, fz: self.fz + b.fz, mx: self.mx + b.mx, my: self.my + b.my }
    }
}

impl<T> From<Displacement<T>> for [T; 5] {
    fn from(d: Displacement<T>) -> Self {
        [d.u, d.v, d.w, d.thu, d.thv]
    }
}

impl<T: Scalar> Wrench<T> {
    /// No force and no moment.
    pub const ZERO: Self = Self { fx: T::ZERO, fy: T::ZERO, fz: T::ZERO, mx: T::ZERO, my: T::ZERO };

    /// Returns the five entries in order.
    pub fn to_array(self) -> [T; 5] {
        [self.fx, self.fy, self.fz, self.mx, self.my]
    }

    /// Creates the vector from its five entries in order.
    pub fn from_array([fx, fy, fz, mx, my]: [T; 5]) -> Self {
        Self { fx, fy, fz, mx, my }
    }

    /// Returns the six entries `[F_x F_y F_z 0 M_y M_z]` of `f_B` in the axes of Hajzman, eq. 5 and 6: X axial, Y and Z
    /// radial. `f_B` is the force on the shaft, as here.
    pub fn to_hajzman(self) -> [T; 6] {
        [self.fz, self.fx, self.fy, T::ZERO, self.mx, self.my]
    }

    /// Returns the wrench in the frame of [`Displacement::mirrored`].
    pub fn mirrored(self) -> Self {
        Self { fx: self.fx, fy: -self.fy, fz: -self.fz, mx: self.mx, my: -self.my }
    }

    /// Returns true if no entry is NaN or infinite.
    pub fn is_finite(self) -> bool {
        all_finite(self.to_array())
    }

    /// Returns `a` if `first`, else `b`, with the same instructions in both cases.
    pub fn select(first: bool, a: Self, b: Self) -> Self {
        Self::from_array(select(first, a.to_array(), b.to_array()))
    }

    /// Returns the equivalent wrench at the point 0 of a rigid body, for a wrench that acts at `station` (m, along Z).
    pub fn from_station(self, station: T) -> Self {
        Self { mx: self.mx - station * self.fy, my: self.my + station * self.fx, ..self }
    }
}

/// Returns `D K D` with `D = diag(1, -1, -1, 1, -1)`: the stiffness in the frame of [`Displacement::mirrored`].
pub fn mirrored_stiffness<T: Scalar>(k: &Stiffness<T>) -> Stiffness<T> {
    const FLIPPED: [bool; 5] = [false, true, true, false, true];
    Stiffness::from_fn(|i, j| {
        let flip = FLIPPED.get(i).copied().unwrap_or(false) != FLIPPED.get(j).copied().unwrap_or(false);
        if flip { -k[(i, j)] } else { k[(i, j)] }
    })
}

/// Returns `S^T K S` with `S` of [`Displacement::at_station`]: the stiffness at the point 0 of a rigid body.
pub fn stiffness_from_station<T: Scalar>(k: &Stiffness<T>, station: T) -> Stiffness<T> {
    let mut moved = *k;
    for i in 0..5 {
        moved[(i, 3)] -= station * k[(i, 1)];
        moved[(i, 4)] += station * k[(i, 0)];
    }
    let columns = moved;
    for j in 0..5 {
        moved[(3, j)] -= station * columns[(1, j)];
        moved[(4, j)] += station * columns[(0, j)];
    }
    moved
}

fn select<T: Scalar>(first: bool, mut a: [T; 5], b: [T; 5]) -> [T; 5] {
    for (x, y) in a.iter_mut().zip(b) {
        *x = T::select(first, *x, y);
    }
    a
}

fn all_finite<T: Scalar>(entries: [T; 5]) -> bool {
    // Tests every entry: the number of instructions does not depend on the data.
    entries.into_iter().fold(true, |ok, x| ok & x.is_finite())
}
