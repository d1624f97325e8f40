//! Linear systems from matrices: a reduced finite-element rotor, a rotor with its supports.

use super::{SecondOrderSystem, ShaftMotion};
use crate::math::Math;
use crate::scalar::Scalar;
use core::borrow::Borrow;
use core::fmt;
use core::marker::PhantomData;
use nalgebra::SMatrix;

/// Matrices of a linear system of `D` coordinates, SI units. Unused coordinates have the entries of
/// [`SystemMatrices::unit_mass`].
///
/// `A` stores one matrix: in place, or behind a pointer such as `Box` for a `D` so large that four matrices in one value
/// would overflow a stack (128 KiB each for 128 coordinates).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SystemMatrices<const D: usize, A = SMatrix<f64, D, D>> {
    /// M, symmetric and positive definite.
    pub mass: A,
    /// B, symmetric.
    pub damping: A,
    /// G, skew-symmetric; multiplied by the shaft speed.
    pub gyroscopic: A,
    /// K, symmetric.
    pub stiffness: A,
    /// Weight and constant load on each coordinate, N or N m.
    pub load: [f64; D],
    /// Unbalance on each coordinate: `w^2 (c cos(theta) + s sin(theta))` for `[c, s]`, kg m.
    pub unbalance: [[f64; 2]; D],
}

impl<const D: usize> SystemMatrices<D> {
    /// Returns matrices with a mass of 1 on each coordinate and 0 elsewhere.
    #[must_use]
    pub fn unit_mass() -> Self {
        let none = SMatrix::from_element(0.0);
        Self {
            mass: SMatrix::from_fn(|i, j| f64::from(u8::from(i == j))),
            damping: none,
            gyroscopic: none,
            stiffness: none,
            load: [0.0; D],
            unbalance: [[0.0; 2]; D],
        }
    }
}

impl<const D: usize, A> SystemMatrices<D, A> {
    /// Adds an unbalance `moment` (kg m) at `angle` (rad) from the keyphasor mark, in a plane that moves along X with the
    /// coordinate `x` and along Y with the coordinate `y`. Ignores coordinates beyond the system.
    #[must_use]
    pub fn with_unbalance(mut self, (x, y): (usize, usize), moment: f64, angle: f64) -> Self {
        let (c, s) = (moment * libm::cos(angle), moment * libm::sin(angle));
        for (at, [a, b]) in [(x, [c, -s]), (y, [s, c])] {
            if let Some([cos, sin]) = self.unbalance.get_mut(at) {
                *cos += a;
                *sin += b;
            }
        }
        self
    }
}

/// Error returned for a matrix without the required symmetry or definiteness. Rows and columns count from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvalidMatrix {
    /// Name of the matrix: `M`, `B`, `G` or `K`.
    pub matrix: &'static str,
    /// Row of the entry.
    pub row: usize,
    /// Column of the entry.
    pub column: usize,
    /// Value of the entry.
    pub found: f64,
    /// Value of the mirrored entry.
    pub mirrored: f64,
    /// Requirement, in words.
    pub expected: &'static str,
}

impl fmt::Display for InvalidMatrix {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { matrix, row, column, found, mirrored, expected } = self;
        write!(
            f,
            "{matrix}: invalid matrix: {found} at row {row}, column {column} and {mirrored} at row {column}, column {row}, expected {expected}"
        )
    }
}

impl core::error::Error for InvalidMatrix {}

/// Largest relative difference of two mirrored entries.
const SAME: f64 = 1e-6;
/// Entries below this share of the largest are rounding errors.
const NOTHING: f64 = 1e-14;

/// Checks symmetry (`sign` 1) or skew-symmetry (`sign` -1).
fn check_mirror<const D: usize>(
    matrix: &'static str,
    entries: &SMatrix<f64, D, D>,
    sign: f64,
) -> Result<(), InvalidMatrix> {
    let largest = entries.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let expected =
        if sign > 0.0 { "a symmetric matrix of finite numbers" } else { "a skew-symmetric matrix of finite numbers" };
    for i in 0..D {
        for j in 0..=i {
            let (found, mirrored) = (entries[(i, j)], entries[(j, i)]);
            let off = (found - sign * mirrored).abs();
            let near = off <= (SAME * found.abs().max(mirrored.abs())).max(NOTHING * largest);
            if !(near && found.is_finite() && mirrored.is_finite()) {
                return Err(InvalidMatrix { matrix, row: i + 1, column: j + 1, found, mirrored, expected });
            }
        }
    }
    Ok(())
}

/// A linear system of any fixed order. Cost of its forces: three products of matrix and vector.
///
/// `A` stores one matrix, as in [`SystemMatrices`].
#[derive(Debug, Clone, Copy)]
pub struct LinearSystem<T: Scalar, M, const D: usize, A = SMatrix<T, D, D>> {
    mass: A,
    inverse_mass: A,
    damping: A,
    gyroscopic: A,
    stiffness: A,
    constant: [T; D],
    unbalance: [[T; 2]; D],
    math: PhantomData<M>,
}

impl<T: Scalar, M: Math<T>, const D: usize> LinearSystem<T, M, D> {
    /// Creates the system from its matrices.
    ///
    /// # Errors
    /// The first entry that violates a symmetry or is not finite; a mass matrix that is not positive definite.
    pub fn try_new(matrices: &SystemMatrices<D>) -> Result<Self, InvalidMatrix> {
        Self::try_with_storage(matrices)
    }
}

impl<T: Scalar, M: Math<T>, const D: usize, A: From<SMatrix<T, D, D>>> LinearSystem<T, M, D, A> {
    /// Creates the system from its matrices, each stored in an `A` such as `Box<SMatrix<T, D, D>>`.
    ///
    /// Cost: up to four matrices on the stack at a time.
    ///
    /// # Errors
    /// As [`LinearSystem::try_new`].
    pub fn try_with_storage<B: Borrow<SMatrix<f64, D, D>>>(
        matrices: &SystemMatrices<D, B>,
    ) -> Result<Self, InvalidMatrix> {
        let (mass, damping) = (matrices.mass.borrow(), matrices.damping.borrow());
        let (gyroscopic, stiffness) = (matrices.gyroscopic.borrow(), matrices.stiffness.borrow());
        check_mirror("M", mass, 1.0)?;
        check_mirror("B", damping, 1.0)?;
        check_mirror("G", gyroscopic, -1.0)?;
        check_mirror("K", stiffness, 1.0)?;
        let round = |x: f64| T::from_f64(x);
        Ok(Self {
            mass: stored(mass),
            inverse_mass: inverse(mass)?,
            damping: stored(damping),
            gyroscopic: stored(gyroscopic),
            stiffness: stored(stiffness),
            constant: matrices.load.map(round),
            unbalance: matrices.unbalance.map(|both| both.map(round)),
            math: PhantomData,
        })
    }
}

/// Rounds a matrix to `T` and stores it. Never inlined: the stack of the caller then does not hold all copies at once.
#[inline(never)]
fn stored<T: Scalar, A: From<SMatrix<T, D, D>>, const D: usize>(matrix: &SMatrix<f64, D, D>) -> A {
    matrix.map(|x| T::from_f64(x)).into()
}

/// Inverts a symmetric matrix by elimination in the given order: the pivots of a definite matrix are positive.
#[inline(never)]
fn inverse<T: Scalar, A: From<SMatrix<T, D, D>>, const D: usize>(
    mass: &SMatrix<f64, D, D>,
) -> Result<A, InvalidMatrix> {
    let mut left = *mass;
    let mut right = SMatrix::<f64, D, D>::from_fn(|i, j| f64::from(u8::from(i == j)));
    for k in 0..D {
        let pivot = left[(k, k)];
        if pivot.is_nan() || pivot <= 0.0 {
            let (row, found) = (k + 1, mass[(k, k)]);
            let expected = "a positive definite matrix, which this one is not with that coordinate";
            return Err(InvalidMatrix { matrix: "M", row, column: row, found, mirrored: found, expected });
        }
        for j in 0..D {
            left[(k, j)] /= pivot;
            right[(k, j)] /= pivot;
        }
        for i in (0..D).filter(|&i| i != k) {
            let factor = left[(i, k)];
            for j in 0..D {
                let (above, beside) = (left[(k, j)], right[(k, j)]);
                left[(i, j)] -= factor * above;
                right[(i, j)] -= factor * beside;
            }
        }
    }
    Ok(stored(&right))
}

/// Computes `f += scale A x`.
fn add_product<T: Scalar, const D: usize>(f: &mut [T; D], scale: T, a: &SMatrix<T, D, D>, x: &[T; D]) {
    // Arrays: the compiler does not unroll the column iterators of large matrices, which then cost 14 instructions per entry.
    for (&x, column) in x.iter().zip(&a.data.0) {
        let x = scale * x;
        for (entry, &a) in f.iter_mut().zip(column) {
            *entry += a * x;
        }
    }
}

impl<T: Scalar, M: Math<T>, const D: usize, A: Borrow<SMatrix<T, D, D>>> SecondOrderSystem<T, D>
    for LinearSystem<T, M, D, A>
{
    fn constant_load(&self) -> [T; D] {
        self.constant
    }

    fn excitation(&self, shaft: &ShaftMotion<T>) -> [T; D] {
        let (sin, cos) = M::sin_cos(shaft.angle);
        let (w2, a) = (shaft.speed * shaft.speed, shaft.acceleration);
        // An angular acceleration a adds the tangential force m e a, opposite to the rotation.
        let (by_cos, by_sin) = (w2 * cos + a * sin, w2 * sin - a * cos);
        let mut f = self.constant;
        for (entry, &[c, s]) in f.iter_mut().zip(&self.unbalance) {
            *entry += by_cos * c + by_sin * s;
        }
        f
    }

    fn internal_force(&self, q: &[T; D], rate: &[T; D], speed: T) -> [T; D] {
        let mut f = [T::ZERO; D];
        add_product(&mut f, -T::ONE, self.damping.borrow(), rate);
        add_product(&mut f, -speed, self.gyroscopic.borrow(), rate);
        add_product(&mut f, -T::ONE, self.stiffness.borrow(), q);
        f
    }

    fn acceleration(&self, f: &[T; D]) -> [T; D] {
        let mut a = [T::ZERO; D];
        add_product(&mut a, T::ONE, self.inverse_mass.borrow(), f);
        a
    }

    fn inertia_force(&self, a: &[T; D]) -> [T; D] {
        let mut f = [T::ZERO; D];
        add_product(&mut f, T::ONE, self.mass.borrow(), a);
        f
    }

    fn effective_matrix(&self, [m, c, k]: [T; 3], speed: T) -> SMatrix<T, D, D> {
        // Entry by entry: sums of whole matrices would put each of them on the stack.
        let turning = c * speed;
        let mut sum = self.mass.borrow() * m;
        sum.zip_apply(self.damping.borrow(), |sum, b| *sum += b * c);
        sum.zip_apply(self.gyroscopic.borrow(), |sum, g| *sum += g * turning);
        sum.zip_apply(self.stiffness.borrow(), |sum, entry| *sum += entry * k);
        sum
    }
}
