//! Model `linear`: a constant 5 x 5 stiffness without clearance.

use super::geometry::{InvalidParameter, check};
use super::{Bearing, Reaction};
use crate::frame::{Displacement, Stiffness, Wrench};
use crate::kinematic_state::BearingKinematicState;
use crate::scalar::Scalar;
use crate::status::Status;

/// Springs about a reference state: `f = f_0 - K (u - u_0)`. Cost: 25 multiplications and additions.
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
    /// Creates springs without force at zero displacement: `f = -K u`.
    pub fn new(stiffness: Stiffness<T>) -> Self {
        Self::about(stiffness, Displacement::default(), Wrench::default())
    }

    /// Creates the linearisation of another model at `reference`, with its `force` there.
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
        // A linear bearing is always in contact: any load above 0 reports that.
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

/// Stiffnesses of a radial bearing along and across the static load, N/m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoSpring {
    /// Along the static load.
    pub along: f64,
    /// Across the static load.
    pub across: f64,
}

/// Computes `k = 13e6 N^(2/3) d^(1/3) F^(1/3) cos^(5/3)(alpha)` along the static load of a ball bearing, SI units.
///
/// Source: Friswell, Penny, Garvey, Lees, Dynamics of Rotating Machines (2010), as implemented in ROSS.
///
/// # Errors
/// Element counts outside 8 to 16: the ratio across/along is tabulated for 8, 12 and 16.
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

/// Computes `k = 1.0e9 N^0.9 l^0.8 F^0.1 cos^1.9(alpha)` along the static load of a roller bearing; source as
/// [`two_spring_ball`].
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

/// Interpolates the three tabulated ratios by a parabola; returns an error outside their range.
fn two_spring(n: f64, along: f64, [r8, r12, r16]: [f64; 3]) -> Result<TwoSpring, InvalidParameter> {
    check((8.0..=16.0).contains(&n), "elements", n, "8 to 16, where the two-spring formula has its ratios")?;
    check(along > 0.0, "static_load", along, "above 0 N")?;
    let s = (n - 12.0) / 4.0;
    let ratio = r12 + s * (r16 - r8) / 2.0 + s * s * (r16 - 2.0 * r12 + r8) / 2.0;
    Ok(TwoSpring { along, across: ratio * along })
}

impl TwoSpring {
    /// Returns the 5 x 5 stiffness with the static load at the azimuth `direction`, rad.
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
