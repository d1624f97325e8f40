//! Forces on one ball between its two races at a given position, and their derivatives.
//!
//! The centre of the ball is displaced by `xi` from its position where both rings just touch it; the inner groove centre is
//! displaced by `a` relative to the outer one. The approaches of the two contacts are `|L_o n_0 + xi| - L_o` and
//! `|L_i n_0 + a - xi| - L_i`, computed as `(2 L n_0.xi + xi^2)/(l + L)`: a deflection of a nanometre is then not the
//! difference of two lengths of a millimetre.

use super::film::{Film, FilmConstants, UnitFilm, film_newton_step};
use super::inertia::{BallInertia, Inertia, InertiaEffects, InertiaLoads, WithSlopes};
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::math::lanes::{Lanes, Plane};
use crate::scalar::Scalar;
use core::marker::PhantomData;

/// Load that is added to a divisor to keep it above 0, N.
pub const NO_LOAD: f64 = 1e-12;

/// Constants of the balls of a bearing.
#[derive(Debug, Clone, Copy)]
pub struct BallConstants<T> {
    /// K_i, Hertz stiffness of the inner contact, N/m^1.5.
    pub inner_stiffness: T,
    /// K_o, Hertz stiffness of the outer contact, N/m^1.5.
    pub outer_stiffness: T,
    /// L_i, inner groove radius less ball radius, m.
    pub inner_length: T,
    /// L_o, outer groove radius less ball radius, m.
    pub outer_length: T,
    /// Direction from the outer to the inner groove centre with the rings just touching the ball.
    pub axis: Plane<T>,
    /// g = D/d_m.
    pub ratio: T,
    /// Lever of the inner friction couple: groove radius divided by the radius of the circle of groove centres.
    pub inner_couple: T,
    /// Lever of the outer friction couple.
    pub outer_couple: T,
    /// A, m.
    pub distance: T,
    /// K_n, stiffness of both contacts in series, N/m^1.5.
    pub series: T,
    /// Share of the outer contact in the approach of both rings without rotation.
    pub outer_share: T,
    /// Largest component of a Newton step, m.
    pub max_step: T,
    /// Length that is added to avoid a division by 0 where a gap is exactly 0, m.
    pub min_length: T,
}

/// Inputs of `K` balls: groove displacements, surface deviations, speeds.
#[derive(Clone, Copy)]
pub struct BallInput<T, const K: usize> {
    pub grooves: Plane<Lanes<T, K>>,
    pub inner_deviation: Lanes<T, K>,
    pub outer_deviation: Lanes<T, K>,
    pub speeds: BearingKinematicState<T>,
    /// 0 for a ball without contact at the inner race, else 1.
    pub rolling: Lanes<T, K>,
}

impl<T: Scalar, const K: usize> BallInput<T, K> {
    /// Returns the input with balls in contact with the inner race where their approach is above 0.
    #[inline(always)]
    pub fn with_rolling(self, approach: Lanes<T, K>) -> Self {
        let zero = Lanes::splat(T::ZERO);
        Self { rolling: Lanes::select(zero.less_than(approach), Lanes::splat(T::ONE), zero), ..self }
    }
}

/// State of one contact of `K` balls.
#[derive(Clone, Copy)]
pub struct ContactState<L> {
    /// Direction from the inner contact through the ball to the outer contact.
    pub direction: Plane<L>,
    /// `1/l`.
    pub inverse_length: L,
    /// Elastic deflection, m; negative in a gap.
    pub deflection: L,
    /// Q, N.
    pub load: L,
    /// dQ/d(approach), N/m; in a gap, that of a deflection of the same size.
    pub slope: L,
    /// h, film thickness, m.
    pub film: L,
}

/// Contacts and inertia loads of `K` balls, and the unbalanced force.
#[derive(Clone, Copy)]
pub struct Balance<L> {
    pub outer: ContactState<L>,
    pub inner: ContactState<L>,
    pub inertia: InertiaLoads<L>,
    /// lambda_o, share of the outer contact in the friction.
    pub outer_share: L,
    /// lambda_i, share of the inner contact in the friction.
    pub inner_share: L,
    /// d(lambda_o)/dQ_o = -d(lambda_i)/dQ_o, 1/N.
    pub share_by_outer: L,
    /// d(lambda_i)/dQ_i = -d(lambda_o)/dQ_i, 1/N.
    pub share_by_inner: L,
    /// Unbalanced force, N.
    pub residual: Plane<L>,
}

/// A 2 x 2 matrix.
#[derive(Clone, Copy)]
pub struct Matrix<L> {
    pub rr: L,
    pub rz: L,
    pub zr: L,
    pub zz: L,
}

impl<T: Scalar, const K: usize> Matrix<Lanes<T, K>> {
    pub fn zero() -> Self {
        let zero = Lanes::splat(T::ZERO);
        Self { rr: zero, rz: zero, zr: zero, zz: zero }
    }
    /// `a b^T`
    #[inline(always)]
    pub fn outer(a: Plane<Lanes<T, K>>, b: Plane<Lanes<T, K>>) -> Self {
        Self { rr: a.r * b.r, rz: a.r * b.z, zr: a.z * b.r, zz: a.z * b.z }
    }
    #[inline(always)]
    pub fn plus(self, o: Self) -> Self {
        Self { rr: self.rr + o.rr, rz: self.rz + o.rz, zr: self.zr + o.zr, zz: self.zz + o.zz }
    }
    #[inline(always)]
    pub fn minus(self, o: Self) -> Self {
        Self { rr: self.rr - o.rr, rz: self.rz - o.rz, zr: self.zr - o.zr, zz: self.zz - o.zz }
    }
    #[inline(always)]
    pub fn determinant(self) -> Lanes<T, K> {
        self.rr * self.zz - self.rz * self.zr
    }
    #[inline(always)]
    pub fn trace(self) -> Lanes<T, K> {
        self.rr + self.zz
    }
    #[inline(always)]
    pub fn times(self, v: Plane<Lanes<T, K>>) -> Plane<Lanes<T, K>> {
        Plane { r: self.rr * v.r + self.rz * v.z, z: self.zr * v.r + self.zz * v.z }
    }
    #[inline(always)]
    pub fn product(self, o: Self) -> Self {
        Self {
            rr: self.rr * o.rr + self.rz * o.zr,
            rz: self.rr * o.rz + self.rz * o.zz,
            zr: self.zr * o.rr + self.zz * o.zr,
            zz: self.zr * o.rz + self.zz * o.zz,
        }
    }
    /// Returns the adjugate: the inverse times the determinant.
    #[inline(always)]
    pub fn adjugate(self) -> Self {
        Self { rr: self.zz, rz: -self.rz, zr: -self.zr, zz: self.rr }
    }
    #[inline(always)]
    pub fn scaled(self, f: Lanes<T, K>) -> Self {
        Self { rr: self.rr * f, rz: self.rz * f, zr: self.zr * f, zz: self.zz * f }
    }
    #[inline(always)]
    pub fn select(first: crate::math::lanes::Mask<K>, a: Self, b: Self) -> Self {
        Self {
            rr: Lanes::select(first, a.rr, b.rr),
            rz: Lanes::select(first, a.rz, b.rz),
            zr: Lanes::select(first, a.zr, b.zr),
            zz: Lanes::select(first, a.zz, b.zz),
        }
    }
}

/// Mechanics of a ball with the effects of the type parameters.
#[derive(Debug, Clone, Copy)]
pub struct Ball<T, M, I, F> {
    pub constants: BallConstants<T>,
    pub inertia: I,
    pub film: F,
    pub math: PhantomData<M>,
}

/// Position of `K` balls: centre, and the deflections of the last iteration (used with a film only).
#[derive(Clone, Copy)]
pub struct Position<L> {
    pub centre: Plane<L>,
    pub outer_deflection: L,
    pub inner_deflection: L,
    /// 1 where a gap at the inner contact may close in this step, else 0.
    pub inner_closing: L,
}

impl<T: Scalar, M: Math<T>, I: Inertia<T>, F: Film<T>> Ball<T, M, I, F> {
    /// Returns |v| plus `min_length`: a divisor that is never 0.
    #[inline(always)]
    pub fn length<const K: usize>(&self, v: Plane<Lanes<T, K>>) -> Lanes<T, K> {
        v.dot(v).sqrt::<M>() + Lanes::splat(self.constants.min_length)
    }

    /// Returns the direction, the inverse length and the elongation of the vector `length n_0 + displacement`.
    #[inline(always)]
    pub fn stretched<const K: usize>(
        &self,
        length: T,
        displacement: Plane<Lanes<T, K>>,
    ) -> (Plane<Lanes<T, K>>, Lanes<T, K>, Lanes<T, K>) {
        let rest =
            Plane { r: Lanes::splat(length * self.constants.axis.r), z: Lanes::splat(length * self.constants.axis.z) };
        let reach = rest.plus(displacement);
        let l = self.length(reach);
        let both = l + Lanes::splat(length);
        let inverse = Lanes::splat(T::ONE) / (l * both);
        let longer = (displacement.dot(rest.plus(reach))) * (inverse * l);
        let inverse_length = inverse * both;
        (reach.times(inverse_length), inverse_length, longer)
    }

    #[inline(always)]
    fn contact_state<const K: usize>(
        &self,
        (stiffness, floor): (T, T),
        (direction, inverse_length, approach): (Plane<Lanes<T, K>>, Lanes<T, K>, Lanes<T, K>),
        (films, unit_film, before): (&FilmConstants<T>, UnitFilm<Lanes<T, K>>, Lanes<T, K>),
    ) -> ContactState<Lanes<T, K>> {
        let k = Lanes::splat(stiffness);
        let (deflection, by_approach, film) = if self.film.is_present() {
            let unit = (unit_film, self.film.heating().is_some());
            let wetted = film_newton_step::<T, M, K>(films, unit, (k, Lanes::splat(floor)), approach, before);
            (wetted.deflection, wetted.slope, wetted.film)
        } else {
            (approach, Lanes::splat(T::ONE), Lanes::splat(T::ZERO))
        };
        let size = deflection.abs() + Lanes::splat(self.constants.min_length);
        let per_metre = k * size.sqrt::<M>();
        let load = per_metre * deflection.positive();
        let slope = Lanes::splat_f64(1.5) * per_metre;
        let slope = if self.film.is_present() { slope * by_approach } else { slope };
        ContactState { direction, inverse_length, deflection, load, slope, film }
    }

    /// Computes contacts, inertia loads and unbalanced force at one position.
    #[inline(always)]
    pub fn balance<const K: usize>(&self, input: &BallInput<T, K>, at: &Position<Lanes<T, K>>) -> Balance<Lanes<T, K>> {
        let constants = &self.constants;
        let outer = self.stretched(constants.outer_length, at.centre);
        let inner = self.stretched(constants.inner_length, input.grooves.minus(at.centre));
        let zero = Lanes::splat(T::ZERO);
        let ball: BallInertia<T> = self.inertia.constants();
        let inertia = if self.inertia.effects().centrifugal {
            ball.loads(self.inertia.effects(), constants.ratio, &input.speeds, outer.0, inner.0, input.rolling)
        } else {
            InertiaLoads { orbital: zero, centrifugal: WithSlopes::none(), friction: WithSlopes::none() }
        };
        let films = self.film.constants();
        let (outer_film, inner_film) = if self.film.is_present() {
            let orbital = if self.inertia.effects().centrifugal {
                inertia.orbital
            } else {
                self.orbital(&input.speeds, outer.0, inner.0)
            };
            self.unit_films(&input.speeds, orbital, outer.0, inner.0)
        } else {
            (UnitFilm { thickness: zero, loss: zero }, UnitFilm { thickness: zero, loss: zero })
        };
        let outer = (outer.0, outer.1, outer.2 + input.outer_deviation);
        let inner = (inner.0, inner.1, inner.2 + input.inner_deviation);
        let outer = self.contact_state(
            (constants.outer_stiffness, films.outer_floor),
            outer,
            (&films, outer_film, at.outer_deflection),
        );
        let mut inner = self.contact_state(
            (constants.inner_stiffness, films.inner_floor),
            inner,
            (&films, inner_film, at.inner_deflection),
        );
        if self.inertia.effects().centrifugal {
            // Without contact at the inner race in this or the last iteration, a step must not move towards it.
            let zero = Lanes::splat(T::ZERO);
            inner.slope = Lanes::select(inner.deflection.less_than(zero), inner.slope * at.inner_closing, inner.slope);
        }

        let (mut outer_share, mut inner_share) = (zero, zero);
        let (mut share_by_outer, mut share_by_inner) = (zero, zero);
        let mut residual = inner.direction.times(inner.load).minus(outer.direction.times(outer.load));
        if self.inertia.effects().centrifugal {
            residual.r = residual.r + inertia.centrifugal.value;
        }
        if self.inertia.effects().gyroscopic && self.inertia.effects().outer_race_control {
            outer_share = Lanes::splat_f64(2.0);
            let friction = outer.direction.tangent().times(outer_share * inertia.friction.value);
            residual = residual.plus(friction);
        } else if self.inertia.effects().gyroscopic {
            let inverse = Lanes::splat(T::ONE) / (inner.load + outer.load + Lanes::splat_f64(NO_LOAD));
            let by_load = Lanes::splat(ball.by_load) * inverse;
            outer_share = Lanes::splat(ball.outer_share) + by_load * outer.load;
            inner_share = Lanes::splat(ball.inner_share) + by_load * inner.load;
            share_by_outer = by_load * inverse * inner.load;
            share_by_inner = by_load * inverse * outer.load;
            let friction = outer.direction.tangent().times(outer_share);
            let friction = friction.minus(inner.direction.tangent().times(inner_share));
            residual = residual.plus(friction.times(inertia.friction.value));
        }
        Balance { outer, inner, inertia, outer_share, inner_share, share_by_outer, share_by_inner, residual }
    }

    /// Returns the orbital speed with the contacts along `outer` and `inner`; for massless balls that of outer race
    /// control.
    #[inline(always)]
    pub fn orbital<const K: usize>(
        &self,
        speeds: &BearingKinematicState<T>,
        outer: Plane<Lanes<T, K>>,
        inner: Plane<Lanes<T, K>>,
    ) -> Lanes<T, K> {
        let rolling = BallInertia { outer_control: T::ONE, ..BallInertia::default() };
        let ball = if self.inertia.effects().centrifugal { self.inertia.constants() } else { rolling };
        ball.orbital_speed(self.constants.ratio, speeds, outer, inner)
    }

    /// Returns the films, outer and inner, at the rolling speeds.
    #[inline(always)]
    pub fn unit_films<const K: usize>(
        &self,
        speeds: &BearingKinematicState<T>,
        orbital: Lanes<T, K>,
        outer: Plane<Lanes<T, K>>,
        inner: Plane<Lanes<T, K>>,
    ) -> (UnitFilm<Lanes<T, K>>, UnitFilm<Lanes<T, K>>) {
        let (one, g) = (Lanes::splat(T::ONE), Lanes::splat(self.constants.ratio));
        let far = (orbital - Lanes::splat(speeds.outer_speed)) * (one + g * outer.r);
        let near = (Lanes::splat(speeds.inner_speed) - orbital) * (one - g * inner.r);
        let (outer, inner) = self.film.constants().at_speed::<M, K>(far, near);
        match self.film.heating() {
            Some(heating) => heating.heated::<M, K>((outer, far), (inner, near)),
            None => (outer, inner),
        }
    }
}

/// Derivatives of the force on the ball: `outer` by the displacement of its centre through the outer contact, `inner` by
/// that of the inner groove centre less the ball centre through the inner contact.
#[derive(Clone, Copy)]
pub struct Slopes<L> {
    pub outer: Matrix<L>,
    pub inner: Matrix<L>,
}

impl<T: Scalar, const K: usize> Balance<Lanes<T, K>> {
    /// Returns `k e e^T + (Q/l)(1 - e e^T)` of one contact.
    #[inline(always)]
    fn contact_stiffness(contact: &ContactState<Lanes<T, K>>) -> Matrix<Lanes<T, K>> {
        let across = contact.load * contact.inverse_length;
        let tangent = contact.direction.tangent();
        Matrix::outer(contact.direction.times(contact.slope), contact.direction)
            .plus(Matrix::outer(tangent.times(across), tangent))
    }

    /// Returns `S_o` and `S_i`, the stiffness of the contacts without inertia loads.
    #[inline(always)]
    pub fn contact_stiffnesses(&self) -> Slopes<Lanes<T, K>> {
        Slopes { outer: Self::contact_stiffness(&self.outer), inner: Self::contact_stiffness(&self.inner) }
    }

    /// Returns the derivatives of the loads by the approach, outer and inner; 0 in a gap.
    #[inline(always)]
    pub fn loaded_slopes(&self) -> (Lanes<T, K>, Lanes<T, K>) {
        let zero = Lanes::splat(T::ZERO);
        let of = |contact: &ContactState<Lanes<T, K>>| {
            Lanes::select(zero.less_than(contact.deflection), contact.slope, zero)
        };
        (of(&self.outer), of(&self.inner))
    }

    /// Returns [`Self::contact_stiffnesses`] with 0 in a gap.
    #[inline(always)]
    pub fn loaded_stiffnesses(&self) -> Slopes<Lanes<T, K>> {
        let (outer, inner) = self.loaded_slopes();
        Slopes {
            outer: Self::contact_stiffness(&ContactState { slope: outer, ..self.outer }),
            inner: Self::contact_stiffness(&ContactState { slope: inner, ..self.inner }),
        }
    }

    /// Returns the derivatives with inertia loads: minus d(residual)/d(centre) through the outer contact,
    /// d(residual)/d(groove) through the inner one. Their sum is the matrix of Newton's method.
    #[inline(always)]
    pub fn slopes(&self, effects: InertiaEffects) -> Slopes<Lanes<T, K>> {
        let mut slopes = self.contact_stiffnesses();
        if effects.centrifugal {
            let out = |x: Lanes<T, K>| Plane { r: x, z: Lanes::splat(T::ZERO) };
            let mut by_outer = out(self.inertia.centrifugal.outer);
            let mut by_inner = out(self.inertia.centrifugal.inner);
            let turn_outer = self.outer.direction.tangent().times(self.outer.inverse_length);
            let turn_inner = self.inner.direction.tangent().times(self.inner.inverse_length);
            if effects.gyroscopic {
                let (e_o, e_i) = (self.outer.direction, self.inner.direction);
                let (t_o, t_i) = (e_o.tangent(), e_i.tangent());
                let g = self.inertia.friction;
                by_outer = by_outer.minus(e_o.times(g.value * self.outer_share));
                let mut along = t_o.times(self.outer_share);
                if !effects.outer_race_control {
                    along = along.minus(t_i.times(self.inner_share));
                    by_inner = by_inner.plus(e_i.times(g.value * self.inner_share));
                    let shift = t_o.plus(t_i).times(g.value);
                    let load_outer = e_o.times(self.outer.slope * self.share_by_outer);
                    let load_inner = e_i.times(self.inner.slope * self.share_by_inner);
                    slopes.outer = slopes.outer.minus(Matrix::outer(shift, load_outer));
                    slopes.inner = slopes.inner.minus(Matrix::outer(shift, load_inner));
                }
                by_outer = by_outer.plus(along.times(g.outer));
                by_inner = by_inner.plus(along.times(g.inner));
            }
            slopes.outer = slopes.outer.minus(Matrix::outer(by_outer, turn_outer));
            slopes.inner = slopes.inner.plus(Matrix::outer(by_inner, turn_inner));
        }
        slopes
    }

    /// Returns the largest load on the ball, N.
    #[inline(always)]
    pub fn largest_load(&self) -> Lanes<T, K> {
        self.outer.load.larger(self.inner.load).larger(self.inertia.centrifugal.value)
    }
}
