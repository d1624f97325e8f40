//! Arithmetic on `K` elements side by side, lane by lane.
//!
//! The equilibrium of one ball is a long chain of dependent operations; several balls side by side use the parallel units
//! of a desktop processor. With one lane the operations are those of a plain number.
//!
//! The loops use counters: a `for` over zipped arrays compiles to twenty times the code before optimisation, in every
//! program that holds all kinds of ball.

use crate::math::Math;
use crate::scalar::{LatticeIndex, Scalar};
use core::ops::{Add, Div, Mul, Neg, Sub};

/// `K` numbers side by side.
#[derive(Debug, Clone, Copy)]
pub struct Lanes<T, const K: usize>(pub [T; K]);

/// `K` table indices side by side, as integers and as floats.
#[derive(Debug, Clone, Copy)]
pub struct LatticeIndices<T, const K: usize> {
    counts: [u32; K],
    pub numbers: Lanes<T, K>,
}

impl<T: Scalar, const K: usize> LatticeIndices<T, K> {
    #[inline(always)]
    fn lane(&self, i: usize) -> LatticeIndex<T> {
        LatticeIndex { count: self.counts[i], number: self.numbers.0[i] }
    }

    /// Returns the indices `self * length + columns`, with rows in `self`.
    #[inline(always)]
    pub fn entries(&self, length: LatticeIndex<T>, columns: &Self) -> [usize; K] {
        let mut entries = [0; K];
        let mut i = 0;
        while i < K {
            entries[i] = T::row_major_index(self.lane(i), length, columns.lane(i));
            i += 1;
        }
        entries
    }
}

/// A truth value per lane.
#[derive(Debug, Clone, Copy)]
pub struct Mask<const K: usize>(pub [bool; K]);

impl<T: Scalar, const K: usize> Lanes<T, K> {
    #[inline(always)]
    pub fn splat(x: T) -> Self {
        Self([x; K])
    }
    /// Collects one number of each item.
    #[inline(always)]
    pub fn gather<S>(each: &[S; K], number: impl Fn(&S) -> T) -> Self {
        let mut lanes = Self([T::ZERO; K]);
        let mut i = 0;
        while i < K {
            lanes.0[i] = number(&each[i]);
            i += 1;
        }
        lanes
    }
    #[inline(always)]
    pub fn splat_f64(x: f64) -> Self {
        Self([T::from_f64(x); K])
    }
    #[inline(always)]
    fn map(mut self, f: impl Fn(T) -> T) -> Self {
        let mut i = 0;
        while i < K {
            self.0[i] = f(self.0[i]);
            i += 1;
        }
        self
    }
    #[inline(always)]
    fn zip_with(mut self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let mut i = 0;
        while i < K {
            self.0[i] = f(self.0[i], other.0[i]);
            i += 1;
        }
        self
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(T, T) -> bool) -> Mask<K> {
        let mut mask = [false; K];
        let mut i = 0;
        while i < K {
            mask[i] = f(self.0[i], other.0[i]);
            i += 1;
        }
        Mask(mask)
    }
    /// Rounds each lane to `f32`.
    #[inline(always)]
    pub fn single(self) -> Lanes<f32, K> {
        let mut single = Lanes([0.0; K]);
        let mut i = 0;
        while i < K {
            single.0[i] = self.0[i].to_f32();
            i += 1;
        }
        single
    }
    /// Converts each lane from `f32`, exactly.
    #[inline(always)]
    pub fn from_single(single: Lanes<f32, K>) -> Self {
        let mut lanes = Self([T::ZERO; K]);
        let mut i = 0;
        while i < K {
            lanes.0[i] = T::from_f32(single.0[i]);
            i += 1;
        }
        lanes
    }
    #[inline(always)]
    pub fn sqrt<M: Math<T>>(self) -> Self {
        Self(M::sqrt_each(self.0))
    }
    #[inline(always)]
    pub fn powf<M: Math<T>>(self, n: T) -> Self {
        self.map(|x| M::powf(x, n))
    }
    #[inline(always)]
    pub fn approximate_two_thirds_power(self) -> Self {
        self.map(T::approximate_two_thirds_power)
    }
    #[inline(always)]
    pub fn abs(self) -> Self {
        self.map(T::abs)
    }
    /// `x + |x|`
    #[inline(always)]
    pub fn twice_positive_part(self) -> Self {
        self.map(T::twice_positive_part)
    }
    /// `(x + |x|)/2`
    #[inline(always)]
    pub fn positive(self) -> Self {
        self.map(|x| T::HALF * x.twice_positive_part())
    }
    #[inline(always)]
    pub fn xor_sign(self, sign: Self) -> Self {
        self.zip_with(sign, T::xor_sign)
    }
    #[inline(always)]
    pub fn or_sign(self, other: Self) -> Self {
        self.zip_with(other, T::or_sign)
    }
    /// Returns a number whose sign bit is set where that of any lane is.
    #[inline(always)]
    pub fn any_sign(self) -> T {
        self.0.into_iter().fold(T::ZERO, T::or_sign)
    }
    /// Returns the integer part of each lane, clamped to `0..=most`.
    #[inline(always)]
    pub fn clamped_floor(self, most: LatticeIndex<T>) -> LatticeIndices<T, K> {
        let mut wholes = LatticeIndices { counts: [0; K], numbers: self };
        let mut i = 0;
        while i < K {
            let LatticeIndex { count, number } = self.0[i].clamped_floor(most);
            (wholes.counts[i], wholes.numbers.0[i]) = (count, number);
            i += 1;
        }
        wholes
    }
    #[inline(always)]
    pub fn less_than(self, other: Self) -> Mask<K> {
        self.compare(other, |x, y| x < y)
    }
    #[inline(always)]
    pub fn smaller(self, other: Self) -> Self {
        self.zip_with(other, T::smaller)
    }
    #[inline(always)]
    pub fn larger(self, other: Self) -> Self {
        self.zip_with(other, T::larger)
    }
    #[inline(always)]
    pub fn select(first: Mask<K>, a: Self, b: Self) -> Self {
        let mut chosen = a;
        let mut i = 0;
        while i < K {
            // Side by side, this form becomes one instruction of x86-64 for all lanes; a single one could become a branch.
            chosen.0[i] = if K > 1 && cfg!(target_arch = "x86_64") {
                if first.0[i] { a.0[i] } else { b.0[i] }
            } else {
                T::select(first.0[i], a.0[i], b.0[i])
            };
            i += 1;
        }
        chosen
    }
}

impl<const K: usize> Mask<K> {
    #[inline(always)]
    pub fn all(self) -> bool {
        self.0.into_iter().fold(true, |all, one| all & one)
    }
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0.into_iter().fold(false, |any, one| any | one)
    }
    #[inline(always)]
    pub fn and(mut self, other: Self) -> Self {
        let mut i = 0;
        while i < K {
            self.0[i] &= other.0[i];
            i += 1;
        }
        self
    }
    #[inline(always)]
    pub fn or(mut self, other: Self) -> Self {
        let mut i = 0;
        while i < K {
            self.0[i] |= other.0[i];
            i += 1;
        }
        self
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<T: Scalar, const K: usize> $trait for Lanes<T, K> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip_with(other, |x, y| x $op y)
            }
        }
    };
}
operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<T: Scalar, const K: usize> Neg for Lanes<T, K> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
    }
}

/// A vector in the contact plane of a ball: radial (outward) and axial component.
#[derive(Debug, Clone, Copy)]
pub struct Plane<L> {
    pub r: L,
    pub z: L,
}

impl<T: Scalar, const K: usize> Plane<Lanes<T, K>> {
    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes<T, K> {
        self.r * other.r + self.z * other.z
    }
    #[inline(always)]
    pub fn times(self, factor: Lanes<T, K>) -> Self {
        Self { r: self.r * factor, z: self.z * factor }
    }
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self { r: self.r + other.r, z: self.z + other.z }
    }
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self { r: self.r - other.r, z: self.z - other.z }
    }
    /// Returns the vector rotated by a quarter: from the direction of a contact to its tangent.
    #[inline(always)]
    pub fn tangent(self) -> Self {
        Self { r: -self.z, z: self.r }
    }
    #[inline(always)]
    pub fn select(first: Mask<K>, a: Self, b: Self) -> Self {
        Self { r: Lanes::select(first, a.r, b.r), z: Lanes::select(first, a.z, b.z) }
    }
    #[inline(always)]
    pub fn single(self) -> Plane<Lanes<f32, K>> {
        Plane { r: self.r.single(), z: self.z.single() }
    }
    #[inline(always)]
    pub fn from_single(single: Plane<Lanes<f32, K>>) -> Self {
        Self { r: Lanes::from_single(single.r), z: Lanes::from_single(single.z) }
    }
}
