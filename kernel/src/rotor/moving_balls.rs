//! Model `dynamic`: each ball is a mass that moves radially between the two races.

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

/// Parameters of a radial bearing with moving balls, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MovingBallsParams {
    /// K_i and K_o, Hertz stiffness of the contacts, N/m^1.5.
    pub stiffness: [f64; 2],
    /// d_m/2, pitch radius, m.
    pub pitch_radius: f64,
    /// gamma, half the diametral clearance, m; negative is preload.
    pub radial_play: f64,
    /// m_b, mass of a ball, kg.
    pub ball_mass: f64,
    /// Cage speed divided by the speed of the inner ring, with the outer ring fixed.
    pub cage_ratio: f64,
    /// Gravity along X and Y, m/s^2.
    pub gravity: [f64; 2],
}

/// A radial bearing whose balls are coordinates of the system.
///
/// The coordinate `first` and the following ones are the displacements `x` of the balls outward from the pitch circle, m,
/// each with the mass `m_b` in the mass matrix of the system. With `c` the distance of a ball from the centre of the inner
/// ring, the deflections are `d_i = R - g/2 - c` and `d_o = x - g/2`. The force on the ball is `K_i d_i^1.5 dc/dx - K_o
/// d_o^1.5 + m_b (R + x) w_c^2` and its weight; the force on the ring is `K_i d_i^1.5` along the line of centres.
///
/// As `m_b` vanishes the model becomes the lumped model with both contacts in series. Axial and tilting displacements have
/// no effect. Cost: three square roots per ball. Source: Harsha, Sandeep, Prakash (2003), by the equations of Lagrange
/// (`docs/src/models.md#balls-with-mass`).
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

/// One ball at one instant, in its radial and tangential directions.
struct Ball<T> {
    /// Outward direction in the fixed frame.
    cos: T,
    sin: T,
    /// Direction from the centre of the inner ring to the ball: radial and tangential.
    line: [T; 2],
    distance: T,
    inner: ContactState<T>,
    outer: ContactState<T>,
    /// Centrifugal force and weight, outward, N.
    inertia: T,
}

/// Load of a contact and its derivative by the deflection.
struct ContactState<T> {
    load: T,
    slope: T,
}

impl<T: Scalar, M: Math<T>, P: AsRef<[ElementPosition<T>]>, const D: usize> MovingBalls<T, M, P, D> {
    /// Creates the bearing; the balls at `positions` are the coordinates from `first` on.
    ///
    /// # Errors
    /// The first parameter outside its range; more balls than the system has coordinates.
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

    /// Computes the force on the inner ring.
    pub fn reaction(&self, q: &[T; D], at: &BearingKinematicState<T>) -> Reaction<T> {
        let mut sum = Reaction::default();
        self.each(q, at, |_, ball| sum = sum + ball.on_ring());
        sum
    }

    /// Writes the load of each ball on the inner race, N, as many as `loads` takes.
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

    /// Calls `visit` with every ball and its coordinate.
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
            // Avoids the cancellation in distance - R.
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
    /// Rotates from the directions of the ball to the fixed frame.
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
            // Second derivative of the contact energy by the vector from the centre of the ring to the ball.
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
