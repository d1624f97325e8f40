//! Rung `dynamic`: each ball a mass of its own that moves along its radius between the two races.

use super::force_element::Attachment;
use super::{ForceElement, HasSpeedRatios, SpeedRatios};
use crate::bearing::geometry::{InvalidParameter, check};
use crate::bearing::{ElementPosition, Reaction};
use crate::frame::Wrench;
use crate::kinematic_state::BearingKinematicState;
use crate::math::Math;
use crate::scalar::Scalar;
use crate::status::Status;
use core::marker::PhantomData;
use nalgebra::SMatrix;

/// What an engineer says of a radial bearing whose balls move, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingBallsParams {
    /// K_i and K_o, N/m^1.5.
    pub stiffness: [f64; 2],
    /// d_m/2, m.
    pub pitch_radius: f64,
    /// gamma: half the diametral clearance; negative is preload, m.
    pub radial_play: f64,
    /// m_b, kg.
    pub ball_mass: f64,
    /// Cage speed over the inner ring's where the outer stands still.
    pub cage_ratio: f64,
    /// Along X and Y, m/s^2.
    pub gravity: [f64; 2],
}

/// A radial bearing whose balls are coordinates of the system: `first` and the following are their displacements `x`
/// outward from the pitch circle, m, each with the mass `m_b` in the system's mass matrix.
///
/// With `c` the distance of the ball from the inner ring's centre, the deflections are `d_i = R - g/2 - c` and
/// `d_o = x - g/2`; the ball is pushed by `K_i d_i^1.5 dc/dx - K_o d_o^1.5 + m_b (R + x) w_c^2` and its weight, the ring by
/// `K_i d_i^1.5` along the line of centres. Source: Harsha, Sandeep, Prakash (2003), by Lagrange's equations (`docs/src/models.md#balls-with-mass`). As
/// `m_b` vanishes it becomes the lumped rung with both races in series.
///
/// Motion is in the plane of the bearing: axial and tilting displacement do nothing. Cost: three square roots a ball.
#[derive(Debug, Clone, Copy)]
pub struct MovingBalls<T: Scalar, M, P, const D: usize> {
    attachment: Attachment<T, D>,
    first: usize,
    positions: P,
    inner_stiffness: T,
    outer_stiffness: T,
    pitch_radius: T,
    half_play: T,
    ball_mass: T,
    cage_ratio: T,
    weight: [T; 2],
    speed_ratios: SpeedRatios<T>,
    math: PhantomData<M>,
}

/// One ball at one instant, in its own radial and tangential directions.
struct Ball<T> {
    /// Direction outward in the fixed frame.
    cos: T,
    sin: T,
    /// Direction from the inner ring's centre to the ball's: radial and tangential.
    line: [T; 2],
    distance: T,
    inner: ContactState<T>,
    outer: ContactState<T>,
    /// What else pushes it outward.
    inertia: T,
}

/// Load of a contact and its slope.
struct ContactState<T> {
    load: T,
    slope: T,
}

impl<T: Scalar, M: Math<T>, P: AsRef<[ElementPosition<T>]>, const D: usize> MovingBalls<T, M, P, D> {
    /// From parameters, with the balls at `positions` being the coordinates from `first` on.
    ///
    /// # Errors
    /// The first quantity out of its range; balls that are more than the system has coordinates for.
    pub fn try_new(
        params: &MovingBallsParams,
        (attachment, speed_ratios): (Attachment<T, D>, SpeedRatios<T>),
        (positions, first): (P, usize),
    ) -> Result<Self, InvalidParameter> {
        for k in params.stiffness {
            check(k > 0.0, "stiffness", k, "above 0 N/m^1.5")?;
        }
        check(params.pitch_radius > 0.0, "pitch_radius", params.pitch_radius, "above 0 m")?;
        check(params.radial_play < params.pitch_radius, "radial_play", params.radial_play, "below the pitch radius")?;
        check(params.ball_mass > 0.0, "ball_mass", params.ball_mass, "above 0 kg")?;
        check(params.cage_ratio.abs() < 1.0, "cage_ratio", params.cage_ratio, "between -1 and 1")?;
        let last = first.saturating_add(positions.as_ref().len());
        check(last <= D, "elements", positions.as_ref().len() as f64, "as many as the system has coordinates for")?;
        let [inner_stiffness, outer_stiffness] = params.stiffness.map(T::from_f64);
        Ok(Self {
            attachment,
            first,
            positions,
            inner_stiffness,
            outer_stiffness,
            pitch_radius: T::from_f64(params.pitch_radius),
            half_play: T::from_f64(0.5 * params.radial_play),
            ball_mass: T::from_f64(params.ball_mass),
            cage_ratio: T::from_f64(params.cage_ratio),
            weight: params.gravity.map(|g| T::from_f64(params.ball_mass * g)),
            speed_ratios,
            math: PhantomData,
        })
    }

    /// Force on the inner ring.
    pub fn reaction(&self, q: &[T; D], at: &BearingKinematicState<T>) -> Reaction<T> {
        let mut sum = Reaction::default();
        self.each(q, at, |_, ball| sum = sum + ball.on_ring());
        sum
    }

    /// Load of each ball on the inner race, N, into `loads` as far as both go.
    pub fn element_loads(&self, q: &[T; D], at: &BearingKinematicState<T>, loads: &mut [T]) {
        let mut loads = loads.iter_mut();
        self.each(q, at, |_, ball| {
            if let Some(load) = loads.next() {
                *load = ball.inner.load;
            }
        });
    }

    fn contact_state(&self, stiffness: T, deflection: T) -> ContactState<T> {
        let deflection = T::HALF * deflection.twice_positive_part();
        let root = stiffness * M::sqrt(deflection);
        ContactState { load: deflection * root, slope: T::from_f64(1.5) * root }
    }

    /// Tells `ball` of every ball and its coordinate.
    fn each(&self, q: &[T; D], at: &BearingKinematicState<T>, mut visit: impl FnMut(usize, Ball<T>)) {
        let ring = self.attachment.displacement(q);
        let (sin, cos) = M::sin_cos(at.cage);
        let cage_speed = self.cage_ratio * at.inner_speed + (T::ONE - self.cage_ratio) * at.outer_speed;
        let [gx, gy] = self.weight;
        for ((i, &x), position) in q.iter().enumerate().skip(self.first).zip(self.positions.as_ref()) {
            let (c, s) = (cos * position.cos - sin * position.sin, cos * position.sin + sin * position.cos);
            let (radial, tangential) = (ring.u * c + ring.v * s, ring.v * c - ring.u * s);
            let closer = x - radial;
            let out = self.pitch_radius + closer;
            let distance = M::sqrt(out * out + tangential * tangential);
            // distance - R, not as the difference of two lengths of a pitch radius.
            let further =
                (closer * (out + self.pitch_radius) + tangential * tangential) / (distance + self.pitch_radius);
            visit(
                i,
                Ball {
                    cos: c,
                    sin: s,
                    line: [out / distance, -tangential / distance],
                    distance,
                    inner: self.contact_state(self.inner_stiffness, -self.half_play - further),
                    outer: self.contact_state(self.outer_stiffness, x - self.half_play),
                    inertia: self.ball_mass * (self.pitch_radius + x) * cage_speed * cage_speed + gx * c + gy * s,
                },
            );
        }
    }

    fn add_ball(&self, f: &mut [T; D], i: usize, ball: &Ball<T>) {
        if let Some(entry) = f.get_mut(i) {
            *entry += ball.inner.load * ball.line[0] - ball.outer.load + ball.inertia;
        }
    }
}

impl<T: Scalar> Ball<T> {
    /// From the ball's directions into the fixed frame.
    fn fixed(&self, [r, t]: [T; 2]) -> [T; 2] {
        [self.cos * r - self.sin * t, self.sin * r + self.cos * t]
    }

    fn on_ring(&self) -> Reaction<T> {
        let [fx, fy] = self.fixed(self.line.map(|n| -self.inner.load * n));
        Reaction { wrench: Wrench { fx, fy, ..Wrench::default() }, load: self.inner.load, status: Status::OK }
    }
}

impl<T: Scalar, M, P, const D: usize> HasSpeedRatios<T> for MovingBalls<T, M, P, D> {
    fn speed_ratios(&self) -> &SpeedRatios<T> {
        &self.speed_ratios
    }
}

impl<T: Scalar, M: Math<T>, P: AsRef<[ElementPosition<T>]>, const D: usize> ForceElement<T, D>
    for MovingBalls<T, M, P, D>
{
    fn add_force(&self, q: &[T; D], at: &BearingKinematicState<T>, f: &mut [T; D]) -> (T, Status) {
        let mut ring = Reaction::default();
        self.each(q, at, |i, ball| {
            ring = ring + ball.on_ring();
            self.add_ball(f, i, &ball);
        });
        self.attachment.spread(&ring.wrench.to_array(), f);
        (ring.load, ring.status)
    }

    fn add_force_and_stiffness(
        &self,
        q: &[T; D],
        at: &BearingKinematicState<T>,
        f: &mut [T; D],
        k: &mut SMatrix<T, D, D>,
    ) -> (T, Status) {
        let extended = &self.attachment.0;
        let cage_speed = self.cage_ratio * at.inner_speed + (T::ONE - self.cage_ratio) * at.outer_speed;
        let centrifugal = self.ball_mass * cage_speed * cage_speed;
        let (mut ring, mut on_ring) = (Reaction::default(), SMatrix::<T, 5, 5>::from_element(T::ZERO));
        self.each(q, at, |i, ball| {
            ring = ring + ball.on_ring();
            self.add_ball(f, i, &ball);
            // Second derivative of the contact's energy by the way from the ring's centre to the ball's.
            let [n, t] = ball.line;
            let across = ball.inner.load / ball.distance;
            let s = [
                ball.inner.slope * n * n - across * t * t,
                (ball.inner.slope + across) * n * t,
                ball.inner.slope * t * t - across * n * n,
            ];
            let (x, y) = (ball.fixed([T::ONE, T::ZERO]), ball.fixed([T::ZERO, T::ONE]));
            for a in 0..2 {
                for b in 0..2 {
                    on_ring[(a, b)] += s[0] * x[a] * x[b] + s[1] * (x[a] * y[b] + y[a] * x[b]) + s[2] * y[a] * y[b];
                }
            }
            let [gx, gy] = ball.fixed([s[0], s[1]]);
            for (j, column) in extended.column_iter().enumerate() {
                let coupling = column[0] * gx + column[1] * gy;
                k[(i, j)] -= coupling;
                k[(j, i)] -= coupling;
            }
            k[(i, i)] += s[0] + ball.outer.slope - centrifugal;
        });
        self.attachment.spread_stiffness(&on_ring, k);
        self.attachment.spread(&ring.wrench.to_array(), f);
        (ring.load, ring.status)
    }
}
