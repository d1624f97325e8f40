//! From the ring's displacement to the elements and back: the transformation `T_j`, sums of forces and stiffnesses.
//!
//! The elements stand still in the cage's frame, so the displacement is rotated into that frame and the
//! wrench back out of it: one sine and cosine a bearing instead of one an element, and fixed tables.
//!
//! With `p` the azimuth and `R` the lever arm, an element's radial and axial displacement are
//! `u cos p + v sin p` and `w + R (thu sin p - thv cos p)` (de Mul 1989, relabelled to this project's axes).

use super::Reaction;
use super::place::{Arrangement, Place};
use crate::frame::{Displacement, Stiffness, Wrench};
use crate::scalar::Scalar;
use crate::turn::Turn;

/// The elements' places, the lever arm, and what all contacts are multiplied with to give newtons.
#[derive(Debug, Clone, Copy)]
pub struct Ring<T, P> {
    pub(super) places: P,
    pub(super) arm: T,
    pub(super) scale: T,
}

/// Displacement of the ring at one element, and where that element stands in the fixed frame.
#[derive(Debug, Clone, Copy)]
pub struct Motion<T> {
    pub(super) radial: T,
    pub(super) axial: T,
    pub(super) azimuth: Turn,
}

/// Force of the ring on one element's contact plane: radial outward and axial, and the load behind it.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    pub(super) radial: T,
    pub(super) axial: T,
    pub(super) load: T,
}

/// Stiffness of one element in its contact plane, symmetric.
#[derive(Debug, Clone, Copy)]
pub struct ContactStiffness<T> {
    pub(super) radial: T,
    pub(super) cross: T,
    pub(super) axial: T,
}

impl<T: Scalar, P: Arrangement<T>> Ring<T, P> {
    pub(super) fn new(places: P, arm: f64, scale: T) -> Self {
        Self { places, arm: T::from_f64(arm), scale }
    }

    /// The displacement with its tilt as axial displacement at the radius of the lever arm.
    #[inline(always)]
    pub(super) fn at_rim(&self, u: &Displacement<T>) -> Displacement<T> {
        Displacement { thu: self.arm * u.thu, thv: self.arm * u.thv, ..*u }
    }
}

#[inline(always)]
pub(super) fn radial<T: Scalar>(place: &Place<T>, rim: &Displacement<T>) -> T {
    rim.u * place.cos + rim.v * place.sin
}

#[inline(always)]
fn axial_by_tilt<T: Scalar>(place: &Place<T>, rim: &Displacement<T>) -> T {
    rim.thu * place.sin - rim.thv * place.cos
}

impl<T: Scalar> Motion<T> {
    #[inline(always)]
    pub(super) fn of(place: &Place<T>, rim: &Displacement<T>, cage: Turn) -> Self {
        let azimuth = place.azimuth.plus(cage);
        Self { radial: radial(place, rim), axial: axial_by_tilt(place, rim) + rim.w, azimuth }
    }

    /// Of an element and of the one opposite to it.
    #[inline(always)]
    pub(super) fn of_pair(place: &Place<T>, rim: &Displacement<T>, cage: Turn) -> [Self; 2] {
        let (radial, tilt) = (radial(place, rim), axial_by_tilt(place, rim));
        let azimuth = place.azimuth.plus(cage);
        [
            Self { radial, axial: rim.w + tilt, azimuth },
            Self { radial: -radial, axial: rim.w - tilt, azimuth: azimuth.opposite() },
        ]
    }
}

/// Sine and cosine of the cage's angle: the way into its frame and out of it.
pub type CageTurn<T> = (T, T);

/// The vector pairs `(u, v)` and `(thu, thv)` turned by minus the cage's angle.
#[inline(always)]
pub(super) fn into_cage<T: Scalar>(u: &Displacement<T>, (sin, cos): CageTurn<T>) -> Displacement<T> {
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
pub(super) fn out_of_cage<T: Scalar>(f: &Wrench<T>, (sin, cos): CageTurn<T>) -> Wrench<T> {
    Wrench {
        fx: cos * f.fx - sin * f.fy,
        fy: cos * f.fy + sin * f.fx,
        fz: f.fz,
        mx: cos * f.mx - sin * f.my,
        my: cos * f.my + sin * f.mx,
    }
}

/// Sums of the forces of the elements on the ring, in the cage's frame.
#[derive(Debug, Clone, Copy)]
pub struct WrenchSum<T> {
    x: T,
    y: T,
    z: T,
    z_sin: T,
    z_cos: T,
    load: T,
}

impl<T: Scalar> WrenchSum<T> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        // Adding to -0 is free: it leaves every number as it is, 0 does not (it would make 0 of -0).
        let nothing = T::NEGATIVE_ZERO;
        Self { x: nothing, y: nothing, z: nothing, z_sin: nothing, z_cos: nothing, load: nothing }
    }

    /// Adds `T_j^T` times the contact's force.
    #[inline(always)]
    pub(super) fn add(&mut self, place: &Place<T>, contact: &Contact<T>) {
        self.add_along(place, contact.radial, contact.axial);
        self.z += contact.axial;
        self.load += contact.load;
    }

    /// The forces of an element and of the one opposite to it.
    #[inline(always)]
    pub(super) fn add_pair(&mut self, place: &Place<T>, [here, there]: &[Contact<T>; 2]) {
        self.add_along(place, here.radial - there.radial, here.axial - there.axial);
        self.z += here.axial + there.axial;
        self.load += here.load + there.load;
    }

    #[inline(always)]
    fn add_along(&mut self, place: &Place<T>, radial: T, axial: T) {
        self.x += radial * place.cos;
        self.y += radial * place.sin;
        self.z_sin += axial * place.sin;
        self.z_cos += axial * place.cos;
    }

    /// Times `scale`, with the moments by the lever arm: the force on the ring is against that on the elements.
    #[inline(always)]
    pub(super) fn finish(&self, arm: T, scale: T) -> Reaction<T> {
        let tilt = scale * arm;
        let wrench = Wrench {
            fx: -(scale * self.x),
            fy: -(scale * self.y),
            fz: -(scale * self.z),
            mx: -(tilt * self.z_sin),
            my: tilt * self.z_cos,
        };
        Reaction { wrench, load: scale * self.load }
    }
}

/// The same where no element has an axial force.
#[derive(Debug, Clone, Copy)]
pub struct RadialSum<T> {
    x: T,
    y: T,
    load: T,
}

impl<T: Scalar> RadialSum<T> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self { x: T::NEGATIVE_ZERO, y: T::NEGATIVE_ZERO, load: T::NEGATIVE_ZERO }
    }

    /// A force outward at `place`; below 0 it is that of the opposite element.
    #[inline(always)]
    pub(super) fn add(&mut self, place: &Place<T>, radial: T) {
        self.x += radial * place.cos;
        self.y += radial * place.sin;
        self.load += radial.abs();
    }

    #[inline(always)]
    pub(super) fn finish(&self, scale: T) -> Reaction<T> {
        let wrench = Wrench { fx: -(scale * self.x), fy: -(scale * self.y), ..Wrench::default() };
        Reaction { wrench, load: scale * self.load }
    }
}

/// Sum of `T_j^T K_j T_j` in the cage's frame, as the moments of the three contact stiffnesses over the ring.
#[derive(Debug, Clone, Copy)]
pub struct StiffnessSum<T> {
    radial: SecondMoment<T>,
    cross: SecondMoment<T>,
    axial: SecondMoment<T>,
    /// Sums of cross and axial stiffness times the direction, and of the axial stiffness.
    cross_first: [T; 2],
    axial_first: [T; 2],
    axial_sum: T,
}

/// Sums of a stiffness times `cos^2`, `cos sin`, `sin^2` of the azimuth.
#[derive(Debug, Clone, Copy)]
struct SecondMoment<T> {
    cc: T,
    cs: T,
    ss: T,
}

impl<T: Scalar> SecondMoment<T> {
    #[inline(always)]
    fn new() -> Self {
        Self { cc: T::NEGATIVE_ZERO, cs: T::NEGATIVE_ZERO, ss: T::NEGATIVE_ZERO }
    }

    #[inline(always)]
    fn add(&mut self, place: &Place<T>, [k_cos, k_sin]: [T; 2]) {
        self.cc += k_cos * place.cos;
        self.cs += k_cos * place.sin;
        self.ss += k_sin * place.sin;
    }

    /// Seen from the fixed frame: `R S R^T`, times `scale`.
    #[inline(always)]
    fn turned(&self, (sin, cos): CageTurn<T>, scale: T) -> Self {
        let (a, b) = (cos * self.cc - sin * self.cs, cos * self.cs - sin * self.ss);
        let (c, d) = (cos * self.cs + sin * self.cc, cos * self.ss + sin * self.cs);
        Self { cc: scale * (cos * a - sin * b), cs: scale * (cos * b + sin * a), ss: scale * (cos * d + sin * c) }
    }
}

#[inline(always)]
fn turned<T: Scalar>([x, y]: [T; 2], (sin, cos): CageTurn<T>, scale: T) -> [T; 2] {
    [scale * (cos * x - sin * y), scale * (cos * y + sin * x)]
}

impl<T: Scalar> StiffnessSum<T> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let (none, nothing) = (SecondMoment::new(), T::NEGATIVE_ZERO);
        Self {
            radial: none,
            cross: none,
            axial: none,
            cross_first: [nothing; 2],
            axial_first: [nothing; 2],
            axial_sum: nothing,
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, place: &Place<T>, k: &ContactStiffness<T>) {
        let along = |k: T| [k * place.cos, k * place.sin];
        let add = |sum: &mut [T; 2], [x, y]: [T; 2]| {
            let [sx, sy] = sum;
            *sx += x;
            *sy += y;
        };
        let (cross, axial) = (along(k.cross), along(k.axial));
        self.radial.add(place, along(k.radial));
        self.cross.add(place, cross);
        self.axial.add(place, axial);
        add(&mut self.cross_first, cross);
        add(&mut self.axial_first, axial);
        self.axial_sum += k.axial;
    }

    /// The stiffness in the fixed frame, times `scale`.
    ///
    /// With `e = (cos p, sin p)`, `t = R (sin p, -cos p)`: the blocks are `k_r e e^T`, `k_c e`, `k_c e t^T`, `k_a`,
    /// `k_a t`, `k_a t t^T`.
    #[inline(always)]
    pub(super) fn finish(&self, arm: T, scale: T, cage: CageTurn<T>) -> Stiffness<T> {
        let tilt = scale * arm;
        let r = self.radial.turned(cage, scale);
        let c = self.cross.turned(cage, tilt);
        let a = self.axial.turned(cage, tilt * arm);
        let [cx, cy] = turned(self.cross_first, cage, scale);
        let [ax, ay] = turned(self.axial_first, cage, tilt);
        #[rustfmt::skip]
        let stiffness = Stiffness::new(
            r.cc, r.cs, cx, c.cs, -c.cc,
            r.cs, r.ss, cy, c.ss, -c.cs,
            cx, cy, scale * self.axial_sum, ay, -ax,
            c.cs, c.ss, ay, a.ss, -a.cs,
            -c.cc, -c.cs, -ax, -a.cs, a.cc,
        );
        stiffness
    }
}
