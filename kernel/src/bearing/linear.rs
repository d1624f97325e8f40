//! Rung `linear`: a constant 5 x 5 stiffness, no clearance, no moving elements.

use super::geometry::{InvalidParameter, check};
use super::{Bearing, Reaction};
use crate::frame::{Displacement, Stiffness, Wrench};
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use crate::status::Status;

/// `f = f_0 - K (u - u_0)`: springs about a reference state. Cost: 25 multiplications and additions.
///
/// ```
/// use ballrace::bearing::Bearing;
/// use ballrace::bearing::linear::Linear;
/// use ballrace::{Displacement, Stiffness, Phase};
///
/// let springs = Linear::new(Stiffness::from_diagonal_element(1e8));
/// let u = Displacement { v: 1e-6, ..Displacement::default() };
/// assert_eq!(springs.reaction(&u, &Phase::ZERO.into()).wrench.fy, -100.0);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Linear<T: Scalar> {
    stiffness: Stiffness<T>,
    reference: Displacement<T>,
    force: Wrench<T>,
}

impl<T: Scalar> Linear<T> {
    /// Springs that push nowhere at zero displacement: `f = -K u`.
    pub fn new(stiffness: Stiffness<T>) -> Self {
        Self::about(stiffness, Displacement::default(), Wrench::default())
    }

    /// The tangent of another rung at `reference`, where that gave `force` ("linear by linearising").
    pub fn about(stiffness: Stiffness<T>, reference: Displacement<T>, force: Wrench<T>) -> Self {
        Self { stiffness, reference, force }
    }
}

impl<T: Scalar> Bearing<T> for Linear<T> {
    fn reaction(&self, u: &Displacement<T>, _at: &BearingKinematicState<T>) -> Reaction<T> {
        let mut f = self.force.to_array();
        let away = u.to_array().into_iter().zip(self.reference.to_array()).map(|(x, x0)| x - x0);
        for (x, column) in away.zip(self.stiffness.column_iter()) {
            for (entry, &k) in f.iter_mut().zip(column.iter()) {
                *entry -= k * x;
            }
        }
        // Springs never lose contact: the load is a mark, not a sum.
        Reaction { wrench: Wrench::from_array(f), load: T::ONE, status: Status::OK }
    }

    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        (self.reaction(u, at), self.stiffness)
    }

    fn element_loads(&self, _u: &Displacement<T>, _at: &BearingKinematicState<T>, _loads: &mut [T]) {}
}

/// Two springs of a radial bearing: along the static load and across it, N/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoSpring {
    /// In the direction of the static load.
    pub along: f64,
    /// Across it.
    pub across: f64,
}

/// `k = 13e6 N^(2/3) d^(1/3) F^(1/3) cos^(5/3)(alpha)` along the static load, SI units.
///
/// Source: Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (2010), as implemented in ROSS.
///
/// # Errors
/// The ratio across/along is tabulated for 8, 12 and 16 elements; outside 8 to 16 there is none.
pub fn two_spring_ball(
    elements: usize,
    ball_diameter: f64,
    static_load: f64,
    contact_angle: f64,
) -> Result<TwoSpring, InvalidParameter> {
    let n = elements as f64;
    let along = 13e6
        * libm::pow(n, 2.0 / 3.0)
        * libm::cbrt(ball_diameter * static_load)
        * libm::pow(libm::cos(contact_angle), 5.0 / 3.0);
    two_spring(n, along, [0.46, 0.64, 0.73])
}

/// `k = 1.0e9 N^0.9 l^0.8 F^0.1 cos^1.9(alpha)` along the static load; source and errors as [`two_spring_ball`].
///
/// # Errors
/// Element counts outside 8 to 16.
pub fn two_spring_roller(
    elements: usize,
    roller_length: f64,
    static_load: f64,
    contact_angle: f64,
) -> Result<TwoSpring, InvalidParameter> {
    let n = elements as f64;
    let along = 1.0e9
        * libm::pow(n, 0.9)
        * libm::pow(roller_length, 0.8)
        * libm::pow(static_load, 0.1)
        * libm::pow(libm::cos(contact_angle), 1.9);
    two_spring(n, along, [0.49, 0.66, 0.74])
}

/// The parabola through the three tabulated ratios, refused where it would be an extrapolation.
fn two_spring(n: f64, along: f64, [r8, r12, r16]: [f64; 3]) -> Result<TwoSpring, InvalidParameter> {
    check((8.0..=16.0).contains(&n), "elements", n, "8 to 16, where the two-spring formula has its ratios")?;
    check(along > 0.0, "static_load", along, "above 0 N")?;
    let s = (n - 12.0) / 4.0;
    let ratio = r12 + s * (r16 - r8) / 2.0 + s * s * (r16 - 2.0 * r12 + r8) / 2.0;
    Ok(TwoSpring { along, across: ratio * along })
}

impl TwoSpring {
    /// As a 5 x 5 stiffness, the static load along the azimuth `direction`, rad.
    #[must_use]
    pub fn stiffness<T: Scalar>(&self, direction: f64) -> Stiffness<T> {
        let (s, c) = (libm::sin(direction), libm::cos(direction));
        let mut k = Stiffness::from_element(T::ZERO);
        k[(0, 0)] = T::from_f64(self.along * c * c + self.across * s * s);
        k[(1, 1)] = T::from_f64(self.along * s * s + self.across * c * c);
        let cross = T::from_f64((self.along - self.across) * s * c);
        k[(0, 1)] = cross;
        k[(1, 0)] = cross;
        k
    }
}
