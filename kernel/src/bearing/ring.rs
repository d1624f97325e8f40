//! The elements around a ring: where they are, and the transformation `T_j` between ring and element.
//!
//! The elements stand still in the cage's frame, so the displacement is rotated into that frame and the
//! wrench back out of it: one sine and cosine a bearing instead of one an element, and fixed tables.
//!
//! With `p` the azimuth and `R` the lever arm, an element's radial and axial displacement are
//! `u cos p + v sin p` and `w + R (thu sin p - thv cos p)` (de Mul 1989, relabelled to this project's axes).

use crate::frame::{Displacement, Stiffness, Wrench};
use crate::scalar::Scalar;
use crate::turn::Turn;

/// One element's place in the cage's frame: where it is when the cage is at angle 0, ready for the hot path.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Place<T> {
    pub(crate) cos: T,
    pub(crate) sin: T,
    pub(crate) azimuth: Turn,
}

/// The places of `N` elements; the count is a constant of the type.
///
/// The bearings take any `AsRef<[Place<T>]>`: an array here, a heap slice where the count is only known at run time.
pub type Places<T, const N: usize> = [Place<T>; N];

impl<T: Scalar> Place<T> {
    /// At an azimuth. Tables by `libm` in `f64`, rounded once. Set-up time.
    #[must_use]
    pub fn at(azimuth: Turn) -> Self {
        let p = azimuth.radians();
        Self { cos: T::from_f64(libm::cos(p)), sin: T::from_f64(libm::sin(p)), azimuth }
    }

    /// Number `j` of `count` evenly spaced ones, number 0 at `first`.
    #[must_use]
    pub fn even(first: Turn, j: usize, count: usize) -> Self {
        Self::at(first.plus(Turn((((j as u128) << 64) / (count.max(1) as u128)) as u64)))
    }

    /// Seen from the frame turned by pi about X.
    #[must_use]
    pub fn mirrored(self) -> Self {
        Self { cos: self.cos, sin: -self.sin, azimuth: self.azimuth.reversed() }
    }
}

/// `N` evenly spaced places, the first at `first`.
#[must_use]
pub fn even_places<T: Scalar, const N: usize>(first: Turn) -> Places<T, N> {
    core::array::from_fn(|j| Place::even(first, j, N))
}

/// All places and the lever arm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ring<T, P> {
    places: P,
    pub arm: T,
}

/// Force of the ring on one element's contact plane: radial outward and axial, and the load behind it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact<T> {
    pub radial: T,
    pub axial: T,
    pub load: T,
}

/// Stiffness of one element in its contact plane, symmetric.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactStiffness<T> {
    pub radial: T,
    pub cross: T,
    pub axial: T,
}

impl<T: Scalar, P: AsRef<[Place<T>]>> Ring<T, P> {
    pub fn new(places: P, arm: f64) -> Self {
        Self { places, arm: T::from_f64(arm) }
    }

    #[inline(always)]
    pub fn places(&self) -> &[Place<T>] {
        self.places.as_ref()
    }

    /// Radial and axial displacement of the ring at one element.
    #[inline(always)]
    pub fn at(&self, place: &Place<T>, u: &Displacement<T>) -> (T, T) {
        let radial = u.u * place.cos + u.v * place.sin;
        let axial = u.w + self.arm * (u.thu * place.sin - u.thv * place.cos);
        (radial, axial)
    }
}

/// The vector pairs `(u, v)` and `(thu, thv)` turned by minus the cage's angle.
#[inline(always)]
pub(crate) fn into_cage<T: Scalar>(u: &Displacement<T>, (sin, cos): (T, T)) -> Displacement<T> {
    Displacement {
        u: cos * u.u + sin * u.v,
        v: cos * u.v - sin * u.u,
        w: u.w,
        thu: cos * u.thu + sin * u.thv,
        thv: cos * u.thv - sin * u.thu,
    }
}

/// The same pairs of a wrench turned by the cage's angle.
#[inline(always)]
pub(crate) fn out_of_cage<T: Scalar>(f: &Wrench<T>, (sin, cos): (T, T)) -> Wrench<T> {
    Wrench {
        fx: cos * f.fx - sin * f.fy,
        fy: cos * f.fy + sin * f.fx,
        fz: f.fz,
        mx: cos * f.mx - sin * f.my,
        my: cos * f.my + sin * f.mx,
    }
}

/// Sums over the elements in the cage's frame.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct WrenchSum<T> {
    wrench: Wrench<T>,
    pub load: T,
}

impl<T: Scalar> WrenchSum<T> {
    /// Adds `T_j^T` times the contact's force; the moments wait for the lever arm.
    #[inline(always)]
    pub fn add(&mut self, place: &Place<T>, contact: &Contact<T>) {
        self.wrench.fx += contact.radial * place.cos;
        self.wrench.fy += contact.radial * place.sin;
        self.wrench.fz += contact.axial;
        self.wrench.mx += contact.axial * place.sin;
        self.wrench.my -= contact.axial * place.cos;
        self.load += contact.load;
    }

    /// The wrench in the fixed frame.
    #[inline(always)]
    pub fn finish(&self, arm: T, cage: (T, T)) -> Wrench<T> {
        let f = Wrench { mx: arm * self.wrench.mx, my: arm * self.wrench.my, ..self.wrench };
        out_of_cage(&f, cage)
    }
}

/// Sum of `T_j^T K_j T_j` in the cage's frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StiffnessSum<T: Scalar>(Stiffness<T>);

impl<T: Scalar> StiffnessSum<T> {
    pub fn new() -> Self {
        Self(Stiffness::from_element(T::ZERO))
    }

    #[inline(always)]
    pub fn add(&mut self, place: &Place<T>, arm: T, k: &ContactStiffness<T>) {
        let radial = [place.cos, place.sin, T::ZERO, T::ZERO, T::ZERO];
        let axial = [T::ZERO, T::ZERO, T::ONE, arm * place.sin, -(arm * place.cos)];
        for (j, column) in self.0.column_iter_mut().enumerate() {
            let (rj, aj) = (radial.get(j).copied().unwrap_or(T::ZERO), axial.get(j).copied().unwrap_or(T::ZERO));
            let (r, a) = (k.radial * rj + k.cross * aj, k.cross * rj + k.axial * aj);
            for ((entry, ri), ai) in { column }.iter_mut().zip(radial).zip(axial) {
                *entry += ri * r + ai * a;
            }
        }
    }

    /// The stiffness in the fixed frame.
    pub fn finish(&self, (sin, cos): (T, T)) -> Stiffness<T> {
        // The columns hold R^T K; the rows then take R on the left.
        let mut k = self.0;
        for (a, b) in [(0, 1), (3, 4)] {
            for i in 0..5 {
                let (x, y) = (k[(i, a)], k[(i, b)]);
                (k[(i, a)], k[(i, b)]) = (cos * x - sin * y, cos * y + sin * x);
            }
        }
        for (a, b) in [(0, 1), (3, 4)] {
            for j in 0..5 {
                let (x, y) = (k[(a, j)], k[(b, j)]);
                (k[(a, j)], k[(b, j)]) = (cos * x - sin * y, cos * y + sin * x);
            }
        }
        k
    }
}
