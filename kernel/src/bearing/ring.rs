//! Transformation `T_j` between the displacement of the ring and that of its elements; sums of forces and stiffnesses.
//!
//! The elements are fixed in the cage frame. The displacement is rotated into that frame and the wrench back: one sine and
//! cosine per bearing instead of one per element, and constant directions.
//!
//! With the azimuth `p` and the lever arm `R`, the radial and axial displacement of an element are `u cos p + v sin p` and
//! `w + R (thu sin p - thv cos p)` (de Mul 1989, in the axes of this crate).

use super::Reaction;
use super::element_position::{ElementBlock, ElementLayout, ElementPosition};
use super::surface::{ElementDeviation, Smooth, Surface};
use crate::frame::{Displacement, Stiffness, Wrench};
use crate::kinematic_state::BearingKinematicState;
use crate::math::lanes::Lanes;
use crate::scalar::Scalar;
use crate::status::Status;

/// Positions of the elements, lever arm, and the scale factor from contact results to newtons.
#[derive(Debug, Clone, Copy)]
pub struct Ring<T, P> {
    pub(super) positions: P,
    pub(super) arm: T,
    pub(super) scale: T,
}

/// Displacement of the ring at one element, and the surface deviations there.
#[derive(Debug, Clone, Copy)]
pub struct Motion<T> {
    pub(super) radial: T,
    pub(super) axial: T,
    pub(super) deviation: ElementDeviation<T>,
}

/// Force of the ring on one element in its contact plane, and the load of the contact. With `Lanes`: of several elements.
#[derive(Debug, Clone, Copy)]
pub struct Contact<T> {
    pub(super) radial: T,
    pub(super) axial: T,
    /// Force that acts at the lever arm: the axial force, and a couple divided by the arm where there is one.
    pub(super) tilting: T,
    pub(super) load: T,
}

impl<T: Scalar> Contact<Lanes<T, 1>> {
    /// Returns the contact of a block of one element.
    #[inline(always)]
    pub(super) fn alone(self) -> Contact<T> {
        let Self { radial: Lanes([radial]), axial: Lanes([axial]), tilting: Lanes([tilting]), load: Lanes([load]) } =
            self;
        Contact { radial, axial, tilting, load }
    }
}

/// Symmetric stiffness of one element in its contact plane.
#[derive(Debug, Clone, Copy)]
pub struct ContactStiffness<T> {
    pub(super) radial: T,
    pub(super) cross: T,
    pub(super) axial: T,
}

/// Symmetric stiffness of one element by radial and axial displacement and by the tilt `thu sin p - thv cos p`.
#[derive(Debug, Clone, Copy)]
pub struct TiltingStiffness<T> {
    pub(super) radial: T,
    pub(super) radial_axial: T,
    pub(super) radial_tilting: T,
    pub(super) axial: T,
    pub(super) axial_tilting: T,
    pub(super) tilting: T,
}

impl<T: Scalar, P: ElementLayout<T>> Ring<T, P> {
    /// Returns the displacement with tilts multiplied by the lever arm.
    #[inline(always)]
    pub(super) fn at_rim(&self, u: &Displacement<T>) -> Displacement<T> {
        Displacement { thu: self.arm * u.thu, thv: self.arm * u.thv, ..*u }
    }
}

#[inline(always)]
pub(super) fn radial<T: Scalar>(position: &ElementPosition<T>, rim: &Displacement<T>) -> T {
    rim.u * position.cos + rim.v * position.sin
}

#[inline(always)]
fn axial_by_tilt<T: Scalar>(position: &ElementPosition<T>, rim: &Displacement<T>) -> T {
    rim.thu * position.sin - rim.thv * position.cos
}

impl<T: Scalar> Motion<T> {
    #[inline(always)]
    pub(super) fn of<S: Surface<T>>(
        position: &ElementPosition<T>,
        rim: &Displacement<T>,
        at: &BearingKinematicState<T>,
        surface: &S,
    ) -> Self {
        let deviation = surface.deviation(position.azimuth.wrapping_add(at.cage), at);
        Self { radial: radial(position, rim), axial: axial_by_tilt(position, rim) + rim.w, deviation }
    }

    /// Returns the motions of an element and of the opposite one.
    #[inline(always)]
    pub(super) fn of_pair<S: Surface<T>>(
        position: &ElementPosition<T>,
        rim: &Displacement<T>,
        at: &BearingKinematicState<T>,
        surface: &S,
    ) -> Motion<Lanes<T, 2>> {
        let (radial, tilt) = (radial(position, rim), axial_by_tilt(position, rim));
        let azimuth = position.azimuth.wrapping_add(at.cage);
        Motion {
            radial: Lanes([radial, -radial]),
            axial: Lanes([rim.w + tilt, rim.w - tilt]),
            deviation: side_by_side(&[surface.deviation(azimuth, at), surface.deviation(azimuth.opposite(), at)]),
        }
    }

    /// Returns the motion as that of a block of one element.
    #[inline(always)]
    pub(super) fn alone(self) -> Motion<Lanes<T, 1>> {
        Motion { radial: Lanes([self.radial]), axial: Lanes([self.axial]), deviation: side_by_side(&[self.deviation]) }
    }
}

impl<T: Copy + core::ops::Add<Output = T>> Motion<T> {
    /// Adds the waviness of the grooves to the displacement.
    #[inline(always)]
    pub(super) fn with_waviness(self) -> Self {
        Self { radial: self.radial + self.deviation.radial, axial: self.axial + self.deviation.axial, ..self }
    }
}

/// Returns the deviations of `K` elements side by side.
#[inline(always)]
fn side_by_side<T: Scalar, const K: usize>(each: &[ElementDeviation<T>; K]) -> ElementDeviation<Lanes<T, K>> {
    ElementDeviation {
        radial: Lanes::gather(each, |deviation| deviation.radial),
        axial: Lanes::gather(each, |deviation| deviation.axial),
        inner: Lanes::gather(each, |deviation| deviation.inner),
        outer: Lanes::gather(each, |deviation| deviation.outer),
    }
}

impl<T: Scalar, const K: usize> Motion<Lanes<T, K>> {
    /// Returns the motions of a block of elements.
    #[inline(always)]
    pub(super) fn of_block<S: Surface<T>>(
        &ElementBlock { cos, sin, azimuths, .. }: &ElementBlock<T, K>,
        rim: &Displacement<T>,
        at: &BearingKinematicState<T>,
        surface: &S,
    ) -> Self {
        let all = Lanes::<T, K>::splat;
        let mut deviations = [Smooth.deviation(at.cage, at); K];
        let mut i = 0;
        while i < K {
            deviations[i] = surface.deviation(azimuths[i].wrapping_add(at.cage), at);
            i += 1;
        }
        Self {
            radial: all(rim.u) * cos + all(rim.v) * sin,
            axial: all(rim.thu) * sin - all(rim.thv) * cos + all(rim.w),
            deviation: side_by_side(&deviations),
        }
    }
}

/// Sine and cosine of the cage angle.
pub type CageRotation<T> = (T, T);

/// Rotates a displacement into the cage frame.
#[inline(always)]
pub(super) fn to_cage_frame<T: Scalar>(u: &Displacement<T>, (sin, cos): CageRotation<T>) -> Displacement<T> {
    Displacement {
        u: cos * u.u + sin * u.v,
        v: cos * u.v - sin * u.u,
        w: u.w,
        thu: cos * u.thu + sin * u.thv,
        thv: cos * u.thv - sin * u.thu,
    }
}

/// Rotates a wrench from the cage frame into the fixed frame.
#[inline(always)]
pub(super) fn from_cage_frame<T: Scalar>(f: &Wrench<T>, (sin, cos): CageRotation<T>) -> Wrench<T> {
    Wrench {
        fx: cos * f.fx - sin * f.fy,
        fy: cos * f.fy + sin * f.fx,
        fz: f.fz,
        mx: cos * f.mx - sin * f.my,
        my: cos * f.my + sin * f.mx,
    }
}

/// Sum of the forces of the elements on the ring, in the cage frame.
#[derive(Debug, Clone, Copy)]
pub struct WrenchSum<T> {
    x: T,
    y: T,
    z_cos: T,
    z_sin: T,
    z: T,
    load: T,
}

impl<T: Scalar> WrenchSum<T> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        // -0 is the neutral element of addition: -0 + x = x for all x, which lets the compiler remove the addition; +0
        // would change -0.
        let nothing = T::NEGATIVE_ZERO;
        Self { x: nothing, y: nothing, z: nothing, z_sin: nothing, z_cos: nothing, load: nothing }
    }

    /// Returns the sum as its six numbers.
    #[inline(always)]
    pub(super) fn to_array(self) -> [T; 6] {
        [self.x, self.y, self.z_cos, self.z_sin, self.z, self.load]
    }

    /// Creates the sum from its six numbers.
    #[inline(always)]
    pub(super) fn from_array([x, y, z_cos, z_sin, z, load]: [T; 6]) -> Self {
        Self { x, y, z_cos, z_sin, z, load }
    }

    /// Adds `T_j^T` times the force of a contact.
    #[inline(always)]
    pub(super) fn add(&mut self, position: &ElementPosition<T>, contact: &Contact<T>) {
        self.add_along(position, contact.radial, contact.tilting);
        self.z += contact.axial;
        self.load += contact.load;
    }

    /// Adds the contacts of a block in order, from index `from` on.
    #[inline(always)]
    pub(super) fn add_each<const K: usize>(
        &mut self,
        positions: &[ElementPosition<T>],
        contacts: &Contact<Lanes<T, K>>,
        from: usize,
    ) {
        let mut i = 0;
        while i < K {
            let Some(position) = positions.get(i) else { break };
            if i >= from {
                let [radial, axial, tilting, load] =
                    [contacts.radial.0[i], contacts.axial.0[i], contacts.tilting.0[i], contacts.load.0[i]];
                self.add(position, &Contact { radial, axial, tilting, load });
            }
            i += 1;
        }
    }

    /// Adds the forces of an element and of the opposite one.
    #[inline(always)]
    pub(super) fn add_pair(&mut self, position: &ElementPosition<T>, pair: &Contact<Lanes<T, 2>>) {
        let Contact { radial: Lanes(radial), axial: Lanes(axial), tilting: Lanes(tilting), load: Lanes(load) } = pair;
        self.add_along(position, radial[0] - radial[1], tilting[0] - tilting[1]);
        self.z += axial[0] + axial[1];
        self.load += load[0] + load[1];
    }

    #[inline(always)]
    fn add_along(&mut self, position: &ElementPosition<T>, radial: T, tilting: T) {
        self.x += radial * position.cos;
        self.y += radial * position.sin;
        self.z_cos += tilting * position.cos;
        self.z_sin += tilting * position.sin;
    }

    /// Returns the radial part.
    #[inline(always)]
    pub(super) fn radial(&self) -> RadialSum<T> {
        RadialSum { x: self.x, y: self.y, load: self.load }
    }

    /// Returns the force on the ring: the negative sum, times `scale`.
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
        Reaction { wrench, load: scale * self.load, status: Status::OK }
    }
}

/// Sum of radial forces, for elements without axial force.
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

    /// Adds a radial force at `position`; a negative one is that of the opposite element.
    #[inline(always)]
    pub(super) fn add(&mut self, position: &ElementPosition<T>, radial: T) {
        self.x += radial * position.cos;
        self.y += radial * position.sin;
        self.load += radial.abs();
    }

    #[inline(always)]
    pub(super) fn finish(&self, scale: T) -> Reaction<T> {
        let wrench = Wrench { fx: -(scale * self.x), fy: -(scale * self.y), ..Wrench::default() };
        Reaction { wrench, load: scale * self.load, status: Status::OK }
    }
}

/// Sum of `T_j^T K_j T_j` in the cage frame, as second moments of the three contact stiffnesses over the ring.
#[derive(Debug, Clone, Copy)]
pub struct StiffnessSum<T> {
    radial: SecondMoment<T>,
    cross: SecondMoment<T>,
    axial: SecondMoment<T>,
    /// First moments of cross and axial stiffness, and the sum of the axial stiffness.
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
    fn add(&mut self, position: &ElementPosition<T>, [k_cos, k_sin]: [T; 2]) {
        self.cc += k_cos * position.cos;
        self.cs += k_cos * position.sin;
        self.ss += k_sin * position.sin;
    }

    /// Returns the moment in the fixed frame, `R S R^T`, times `scale`.
    #[inline(always)]
    fn rotated(&self, (sin, cos): CageRotation<T>, scale: T) -> Self {
        let (a, b) = (cos * self.cc - sin * self.cs, cos * self.cs - sin * self.ss);
        let (c, d) = (cos * self.cs + sin * self.cc, cos * self.ss + sin * self.cs);
        Self { cc: scale * (cos * a - sin * b), cs: scale * (cos * b + sin * a), ss: scale * (cos * d + sin * c) }
    }
}

#[inline(always)]
fn rotated<T: Scalar>([x, y]: [T; 2], (sin, cos): CageRotation<T>, scale: T) -> [T; 2] {
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
    pub(super) fn add(&mut self, position: &ElementPosition<T>, k: &ContactStiffness<T>) {
        let along = |k: T| [k * position.cos, k * position.sin];
        let add = |sum: &mut [T; 2], [x, y]: [T; 2]| {
            let [sx, sy] = sum;
            *sx += x;
            *sy += y;
        };
        let (cross, axial) = (along(k.cross), along(k.axial));
        self.radial.add(position, along(k.radial));
        self.cross.add(position, cross);
        self.axial.add(position, axial);
        add(&mut self.cross_first, cross);
        add(&mut self.axial_first, axial);
        self.axial_sum += k.axial;
    }

    /// Adds an element with a stiffness against tilt of its own; [`StiffnessSum::finish`] then takes the lever arm 1.
    #[inline(always)]
    pub(super) fn add_tilting(&mut self, position: &ElementPosition<T>, k: &TiltingStiffness<T>) {
        let along = |k: T| [k * position.cos, k * position.sin];
        let add = |sum: &mut [T; 2], [x, y]: [T; 2]| {
            let [sx, sy] = sum;
            *sx += x;
            *sy += y;
        };
        self.radial.add(position, along(k.radial));
        self.cross.add(position, along(k.radial_tilting));
        self.axial.add(position, along(k.tilting));
        add(&mut self.cross_first, along(k.radial_axial));
        add(&mut self.axial_first, along(k.axial_tilting));
        self.axial_sum += k.axial;
    }

    /// Returns the stiffness in the fixed frame, times `scale`.
    ///
    /// With `e = (cos p, sin p)`, `t = R (sin p, -cos p)`, the blocks are `k_r e e^T`, `k_c e`, `k_c e t^T`, `k_a`, `k_a
    /// t`, `k_a t t^T`.
    #[inline(always)]
    pub(super) fn finish(&self, arm: T, scale: T, cage: CageRotation<T>) -> Stiffness<T> {
        let tilt = scale * arm;
        let r = self.radial.rotated(cage, scale);
        let c = self.cross.rotated(cage, tilt);
        let a = self.axial.rotated(cage, tilt * arm);
        let [cx, cy] = rotated(self.cross_first, cage, scale);
        let [ax, ay] = rotated(self.axial_first, cage, tilt);
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

/// Derivatives of the force of one element by its radial and axial displacement; not symmetric in general.
#[derive(Debug, Clone, Copy)]
pub struct ContactTangent<T> {
    pub(super) radial: [T; 2],
    pub(super) axial: [T; 2],
    pub(super) tilting: [T; 2],
}

/// Sum of `T_j^T K_j T_j` for elements with an asymmetric stiffness and a friction couple.
#[derive(Debug, Clone, Copy)]
pub struct TangentSum<T> {
    radial_radial: SecondMoment<T>,
    radial_axial: SecondMoment<T>,
    tilting_radial: SecondMoment<T>,
    tilting_axial: SecondMoment<T>,
    /// First moments of the derivatives.
    radial_axial_first: [T; 2],
    axial_radial_first: [T; 2],
    axial_axial_first: [T; 2],
    tilting_axial_first: [T; 2],
    axial_sum: T,
}

impl<T: Scalar> TangentSum<T> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let (none, nothing) = (SecondMoment::new(), [T::NEGATIVE_ZERO; 2]);
        Self {
            radial_radial: none,
            radial_axial: none,
            tilting_radial: none,
            tilting_axial: none,
            radial_axial_first: nothing,
            axial_radial_first: nothing,
            axial_axial_first: nothing,
            tilting_axial_first: nothing,
            axial_sum: T::NEGATIVE_ZERO,
        }
    }

    #[inline(always)]
    pub(super) fn add(&mut self, position: &ElementPosition<T>, k: &ContactTangent<T>) {
        let along = |k: T| [k * position.cos, k * position.sin];
        let add = |sum: &mut [T; 2], [x, y]: [T; 2]| {
            let [sx, sy] = sum;
            *sx += x;
            *sy += y;
        };
        let ([rr, rz], [zr, zz], [lr, lz]) = (k.radial, k.axial, k.tilting);
        self.radial_radial.add(position, along(rr));
        self.radial_axial.add(position, along(rz));
        self.tilting_radial.add(position, along(lr));
        self.tilting_axial.add(position, along(lz));
        add(&mut self.radial_axial_first, along(rz));
        add(&mut self.axial_radial_first, along(zr));
        add(&mut self.axial_axial_first, along(zz));
        add(&mut self.tilting_axial_first, along(lz));
        self.axial_sum += zz;
    }

    /// Returns the stiffness in the fixed frame, with `e`, `t` as in [`StiffnessSum::finish`].
    #[inline(always)]
    pub(super) fn finish(&self, arm: T, cage: CageRotation<T>) -> Stiffness<T> {
        let one = T::ONE;
        let rr = self.radial_radial.rotated(cage, one);
        let rt = self.radial_axial.rotated(cage, arm);
        let tr = self.tilting_radial.rotated(cage, arm);
        let tt = self.tilting_axial.rotated(cage, arm * arm);
        let [rx, ry] = rotated(self.radial_axial_first, cage, one);
        let [xr, yr] = rotated(self.axial_radial_first, cage, one);
        let [xt, yt] = rotated(self.axial_axial_first, cage, arm);
        let [tx, ty] = rotated(self.tilting_axial_first, cage, arm);
        #[rustfmt::skip]
        let stiffness = Stiffness::new(
            rr.cc, rr.cs, rx, rt.cs, -rt.cc,
            rr.cs, rr.ss, ry, rt.ss, -rt.cs,
            xr, yr, self.axial_sum, yt, -xt,
            tr.cs, tr.ss, ty, tt.ss, -tt.cs,
            -tr.cc, -tr.cs, -tx, -tt.cs, tt.cc,
        );
        stiffness
    }
}
