//! Ball bearings whose balls and cage are rigid bodies with six degrees of freedom (`docs/src/models.md#balls-and-cage-as-bodies`).
//!
//! Hertz contact with damping and traction on both races, pockets and lands of the cage, drag of the oil. Nothing is assumed about rolling:
//! the speeds of balls and cage, and the race that controls the spin, are results. [`MultibodyBearing`] has the equations of one bearing between two
//! rings that move; [`Integrator`] advances any system of such bearings and a rotor with an error control.
//!
//! Sources: Gupta, Advanced Dynamics of Rolling Elements, 1984; Hunt and Crossley 1975 for the damping; Harris and Kotzalas for slip along a
//! contact ellipse.
#![forbid(unsafe_code)]

mod bearing;
mod cage;
mod integrator;
mod parameters;
mod race;
mod ring;
mod state;
mod traction;

pub use bearing::{Balance, MultibodyBearing};
pub use integrator::{Integrator, Motion, Steps};
pub use parameters::{CageParams, Params};
pub use race::RaceContact;
pub use ring::{Ring, RingMotion};
pub use state::{BallMotion, CageMotion, ElementMotion};
pub use traction::TractionCurve;

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod checks;
