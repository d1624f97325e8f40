//! The rigid rotor: inertia, gyroscopic moment, damping, gravity, load, unbalance.

use super::{SecondOrderSystem, ShaftMotion};
use crate::bearing::geometry::{InvalidParameter, check};
use crate::frame::Stiffness;
use crate::math::{Exact, Math};
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// An unbalance in one plane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
// The C interface reads an array of them in place.
#[repr(C)]
pub struct Unbalance {
    /// Mass times eccentricity, kg m.
    pub moment: f64,
    /// Angle from the keyphasor mark in the direction of positive rotation, rad.
    pub angle: f64,
    /// Station of the plane along Z from the centre of mass, m.
    pub station: f64,
}

/// Parameters of a rigid rotor, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RotorParams {
    /// Mass, kg.
    pub mass: f64,
    /// I_d, moment of inertia about X and Y, kg m^2.
    pub diametral_inertia: f64,
    /// I_p, moment of inertia about Z, kg m^2.
    pub polar_inertia: f64,
    /// B, symmetric damping matrix: N s/m, N s, N m s.
    pub damping: [[f64; 5]; 5],
    /// Stiffness of springs on the rotor: N/m (three), N m/rad (two).
    pub stiffness: [f64; 5],
    /// Gravity, m/s^2.
    pub gravity: [f64; 3],
    /// Constant force and moment, N and N m.
    pub load: [f64; 5],
}

impl RotorParams {
    /// Validates all parameters.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub(super) fn check(&self) -> Result<(), InvalidParameter> {
        let RotorParams { mass, diametral_inertia: diametral, polar_inertia: polar, .. } = *self;
        check(mass > 0.0, "mass", mass, "above 0 kg")?;
        check(diametral > 0.0, "diametral_inertia", diametral, "above 0 kg m^2")?;
        check((0.0..=2.0 * diametral).contains(&polar), "polar_inertia", polar, "0 to twice the diametral inertia")?;
        for &value in self.damping.iter().flatten() {
            check(true, "damping", value, "a finite number")?;
        }
        for &value in &self.stiffness {
            check(value >= 0.0, "stiffness", value, "0 or more")?;
        }
        for &value in self.gravity.iter().chain(&self.load) {
            check(true, "gravity and load", value, "a finite number")?;
        }
        Ok(())
    }
}

/// A rigid rotor.
#[derive(Debug, Clone, Copy)]
pub struct RigidRotor<T: Scalar, M = Exact> {
    mass: [T; 5],
    inverse_mass: [T; 5],
    polar_inertia: T,
    damping: Stiffness<T>,
    stiffness: [T; 5],
    constant: [T; 5],
    /// Sums over the unbalances of moment (cos, sin), and of station times that.
    unbalance: [T; 2],
    couple: [T; 2],
    math: PhantomData<M>,
}

impl<T: Scalar, M: Math<T>> RigidRotor<T, M> {
    /// Creates the rotor from parameters and any number of unbalances, which add up to one force and one couple.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn try_new(params: &RotorParams, unbalances: &[Unbalance]) -> Result<Self, InvalidParameter> {
        params.check()?;
        let RotorParams { mass, diametral_inertia: diametral, polar_inertia: polar, .. } = *params;
        let (force, couple) = sum_unbalances(unbalances)?;
        let masses = [mass, mass, mass, diametral, diametral];
        let [gx, gy, gz] = params.gravity.map(|g| g * mass);
        let [fx, fy, fz, mx, my] = params.load;
        Ok(Self {
            mass: masses.map(T::from_f64),
            inverse_mass: masses.map(|m| T::from_f64(1.0 / m)),
            polar_inertia: T::from_f64(polar),
            damping: Stiffness::from_fn(|i, j| {
                T::from_f64(params.damping.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0))
            }),
            stiffness: params.stiffness.map(T::from_f64),
            constant: [fx + gx, fy + gy, fz + gz, mx, my].map(T::from_f64),
            unbalance: force.map(T::from_f64),
            couple: couple.map(T::from_f64),
            math: PhantomData,
        })
    }
}

impl<T: Scalar, M: Math<T>> SecondOrderSystem<T, 5> for RigidRotor<T, M> {
    fn constant_load(&self) -> [T; 5] {
        self.constant
    }

    /// Constant load and unbalance, `m e (w^2 e_r - a e_t)` with its couple.
    #[inline(always)]
    fn excitation(&self, shaft: &ShaftMotion<T>) -> [T; 5] {
        let turn = M::sin_cos(shaft.angle);
        let (w2, a) = (shaft.speed * shaft.speed, shaft.acceleration);
        let rotating = |[x, y]: [T; 2]| {
            let (sin, cos) = turn;
            let (rx, ry) = (cos * x - sin * y, sin * x + cos * y);
            (w2 * rx + a * ry, w2 * ry - a * rx)
        };
        let ((fx, fy), (cx, cy)) = (rotating(self.unbalance), rotating(self.couple));
        let [x, y, z, mx, my] = self.constant;
        [x + fx, y + fy, z, mx - cy, my + cx]
    }

    /// With `G[thu, thv] = I_p = -G[thv, thu]` for a spin about +Z.
    #[inline(always)]
    fn internal_force(&self, q: &[T; 5], rate: &[T; 5], speed: T) -> [T; 5] {
        let mut f = [T::ZERO; 5];
        for (&x, column) in rate.iter().zip(self.damping.column_iter()) {
            for (entry, &b) in f.iter_mut().zip(column.iter()) {
                *entry -= b * x;
            }
        }
        for ((entry, k), &x) in f.iter_mut().zip(self.stiffness).zip(q) {
            *entry -= k * x;
        }
        let spin = self.polar_inertia * speed;
        let ([fx, fy, fz, mx, my], [.., thu, thv]) = (f, *rate);
        [fx, fy, fz, mx - spin * thv, my + spin * thu]
    }

    fn acceleration(&self, f: &[T; 5]) -> [T; 5] {
        let mut a = *f;
        for (entry, inverse) in a.iter_mut().zip(self.inverse_mass) {
            *entry *= inverse;
        }
        a
    }

    fn inertia_force(&self, a: &[T; 5]) -> [T; 5] {
        let mut f = *a;
        for (entry, m) in f.iter_mut().zip(self.mass) {
            *entry *= m;
        }
        f
    }

    #[inline(always)]
    fn effective_matrix(&self, [m, c, k]: [T; 3], speed: T) -> Stiffness<T> {
        let mut j = self.damping * c;
        for (i, (mass, stiffness)) in self.mass.into_iter().zip(self.stiffness).enumerate() {
            j[(i, i)] += m * mass + k * stiffness;
        }
        let spin = c * self.polar_inertia * speed;
        j[(3, 4)] += spin;
        j[(4, 3)] -= spin;
        j
    }
}

pub(super) fn sum_unbalances(unbalances: &[Unbalance]) -> Result<([f64; 2], [f64; 2]), InvalidParameter> {
    let (mut force, mut couple) = ([0.0; 2], [0.0; 2]);
    for one in unbalances {
        check(one.moment >= 0.0, "unbalance moment", one.moment, "0 kg m or more")?;
        check(true, "unbalance angle", one.angle, "a finite angle")?;
        check(true, "unbalance station", one.station, "a finite length")?;
        for (i, part) in [libm::cos(one.angle), libm::sin(one.angle)].into_iter().enumerate() {
            force[i] += one.moment * part;
            couple[i] += one.station * one.moment * part;
        }
    }
    Ok((force, couple))
}
