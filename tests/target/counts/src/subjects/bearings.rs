//! Every model, for 4, 8, 9 and 16 elements.

use crate::inputs::input;
use crate::measure::{Bench, Name};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{CageFrame, ElementLayout, LastValidWrench, Reaction, evenly_spaced, evenly_spaced_pairs};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::{Bearing, Displacement, Math, Phase, Scalar, Status, Stiffness, Wrench};
use core::hint::black_box;

/// Forces of all models; the other functions for 8 and 9 elements in the precision and math that firmware takes.
pub fn all<T: Scalar, M: Math<T>>(bench: &Bench, precision: &'static str, math: &'static str) {
    let every = precision == "f32" && math == "exact";
    let models = Models { bench, precision, math, every };
    if math == "exact" {
        models.bearing("linear", 0, Linear::new(Stiffness::from_element(T::from_f64(1e7))));
    }
    models.of::<T, M, _>(4, evenly_spaced::<T, 4>(Phase::ZERO));
    models.of::<T, M, _>(8, evenly_spaced::<T, 8>(Phase::ZERO));
    models.of::<T, M, _>(9, evenly_spaced::<T, 9>(Phase::ZERO));
    models.of::<T, M, _>(16, evenly_spaced::<T, 16>(Phase::ZERO));
    models.of_pairs::<T, M, _>(4, evenly_spaced_pairs::<T, 2>(Phase::ZERO));
    models.of_pairs::<T, M, _>(8, evenly_spaced_pairs::<T, 4>(Phase::ZERO));
    models.of_pairs::<T, M, _>(16, evenly_spaced_pairs::<T, 8>(Phase::ZERO));
}

#[inline(never)]
pub fn force<T: Scalar, B: Bearing<T>>(bearing: &B, u: &Displacement<T>, cage: Phase) -> Wrench<T> {
    bearing.reaction(u, &cage.into()).wrench
}

#[inline(never)]
fn in_cage<T: Scalar, B: CageFrame<T>>(bearing: &B, u: &Displacement<T>, cage: Phase) -> Wrench<T> {
    bearing.reaction_in_cage_frame(u, &cage.into()).wrench
}

/// Result of a radial bearing: two forces.
#[inline(never)]
fn radial_in_cage<T: Scalar, B: CageFrame<T>>(bearing: &B, u: T, v: T, cage: Phase) -> (T, T) {
    let wrench = bearing.reaction_in_cage_frame(&Displacement { u, v, ..Displacement::default() }, &cage.into()).wrench;
    (wrench.fx, wrench.fy)
}

#[inline(never)]
fn tangent<T: Scalar, B: Bearing<T>>(bearing: &B, u: &Displacement<T>, cage: Phase) -> (Reaction<T>, Stiffness<T>) {
    bearing.reaction_and_stiffness(u, &cage.into())
}

#[inline(never)]
fn sample<T: Scalar, B: Bearing<T>>(
    bearing: &B,
    held: &mut LastValidWrench<T>,
    u: &Displacement<T>,
    cage: Phase,
) -> (Wrench<T>, Status) {
    bearing.sample(held, u, &cage.into())
}

struct Models<'a> {
    bench: &'a Bench,
    precision: &'static str,
    math: &'static str,
    every: bool,
}

impl Models<'_> {
    fn name(&self, what: &'static str, elements: usize, function: &'static str) -> Name {
        Name { what, elements, precision: self.precision, math: self.math, function }
    }

    fn bearing<T: Scalar, B: Bearing<T>>(&self, what: &'static str, n: usize, bearing: B) {
        let bearing = black_box(bearing);
        let name = |function| self.name(what, n, function);
        self.bench
            .measure(name("force"), force::<T, B> as *const (), input::<T>, |(u, cage)| force(&bearing, u, *cage));
        if !(self.every && matches!(n, 0 | 8 | 9)) {
            return;
        }
        let mut held = LastValidWrench::new();
        self.bench.measure(name("force, input checked"), sample::<T, B> as *const (), input::<T>, |(u, cage)| {
            sample(&bearing, &mut held, u, *cage)
        });
        self.bench.measure(name("force and tangent"), tangent::<T, B> as *const (), input::<T>, |(u, cage)| {
            tangent(&bearing, u, *cage)
        });
    }

    /// In the cage's frame, the tables of directions ready: what a hand-written evaluation is compared with.
    fn in_cage<T: Scalar, B: CageFrame<T>>(&self, what: &'static str, n: usize, bearing: &B) {
        if self.every && n == 8 {
            let name = self.name(what, n, "force, in the cage's frame");
            self.bench.measure(name, in_cage::<T, B> as *const (), input::<T>, |(u, cage)| in_cage(bearing, u, *cage));
        }
    }

    fn radial_in_cage<T: Scalar, B: CageFrame<T>>(&self, what: &'static str, n: usize, bearing: &B) {
        if self.every && n == 8 {
            let name = self.name(what, n, "FX and FY, in the cage's frame");
            self.bench.measure(name, radial_in_cage::<T, B> as *const (), input::<T>, |(u, cage)| {
                radial_in_cage(bearing, u.u, u.v, *cage)
            });
        }
    }

    fn of<T: Scalar, M: Math<T>, P: ElementLayout<T> + Copy>(&self, n: usize, places: P) {
        let (point, line) =
            (PointContactLaw { stiffness: T::from_f64(8e9) }, LineContactLaw { stiffness: T::from_f64(3e8) });
        let power = PowerLaw { stiffness: T::from_f64(2e9), exponent: T::from_f64(1.4) };
        if let Ok(bearing) = Radial::<T, M, _, _>::try_new(places, point, 5e-6) {
            self.radial_in_cage("radial 3/2", n, &bearing);
            self.bearing("radial 3/2", n, bearing);
            if let Ok(axial) = Axial::<T, M, _, _>::try_new(places, point, 5e-6, 0.02) {
                self.bearing("axial 3/2", n, axial);
                self.bearing("radial and axial 3/2", n, Combined(bearing, axial));
            }
        }
        if let Ok(bearing) = Radial::<T, M, _, _>::try_new(places, line, 5e-6) {
            self.bearing("radial 10/9", n, bearing);
        }
        if let Ok(bearing) = Radial::<T, M, _, _>::try_new(places, power, 5e-6) {
            self.bearing("radial, any power", n, bearing);
        }
        self.angular::<T, M, P>("angular", n, places);
    }

    fn of_pairs<T: Scalar, M: Math<T>, P: ElementLayout<T> + Copy>(&self, n: usize, places: P) {
        let point = PointContactLaw { stiffness: T::from_f64(8e9) };
        if let Ok(bearing) = Radial::<T, M, _, _>::try_new(places, point, 5e-6) {
            self.radial_in_cage("radial 3/2, pairs", n, &bearing);
            self.bearing("radial 3/2, pairs", n, bearing);
        }
        self.angular::<T, M, P>("angular, pairs", n, places);
    }

    fn angular<T: Scalar, M: Math<T>, P: ElementLayout<T>>(&self, what: &'static str, n: usize, places: P) {
        let Ok(geometry) = rig::geometry() else { return };
        if let Ok(bearing) = Angular::<T, M, _>::try_new(geometry, places, DisplacementDatum::Centred) {
            self.in_cage(what, n, &bearing);
            self.bearing(what, n, bearing);
        }
    }
}
