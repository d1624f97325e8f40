//! What the races are besides round: local damage.

use crate::scalar::Scalar;
use crate::turn::Turn;

/// Shape of the outer race as the elements meet it.
pub trait Surface<T: Scalar>: Copy + Send + Sync + 'static {
    /// Deflection lost by an element at this azimuth of the fixed frame, m.
    fn drop_at(&self, azimuth: Turn) -> T;
}

/// A race without damage; costs no instruction.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Smooth;

impl<T: Scalar> Surface<T> for Smooth {
    #[inline(always)]
    fn drop_at(&self, _azimuth: Turn) -> T {
        T::ZERO
    }
}

/// Section of a spall along the race.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SpallShape {
    /// `depth sin(pi s)`, `s` from 0 to 1 over the width.
    HalfSine,
    /// `depth` all along.
    Rectangular,
}

/// A spall on the outer race.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spall<T> {
    centre: Turn,
    half_width: T,
    depth: T,
    shape: SpallShape,
}

impl<T: Scalar> Spall<T> {
    /// Centre azimuth, half width (rad, above 0, at most pi), depth (m).
    pub fn new(centre: Turn, half_width: T, depth: T, shape: SpallShape) -> Self {
        Self { centre, half_width, depth, shape }
    }

    /// As seen from the frame turned by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { centre: self.centre.reversed(), ..self }
    }
}

impl<T: Scalar> Surface<T> for Spall<T> {
    fn drop_at(&self, azimuth: Turn) -> T {
        let away: T = azimuth.since(self.centre).radians();
        let s = away / self.half_width;
        let inside = s.abs() < T::ONE;
        let height = match self.shape {
            SpallShape::Rectangular => T::ONE,
            SpallShape::HalfSine => cos_half_pi(s),
        };
        if inside { self.depth * height } else { T::ZERO }
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

impl<T: Scalar, S: Surface<T>, const D: usize> Surface<T> for [S; D] {
    fn drop_at(&self, azimuth: Turn) -> T {
        self.iter().fold(T::ZERO, |sum, surface| sum + surface.drop_at(azimuth))
    }
}
