#![doc = include_str!("../README.md")]
#![no_std]
#![deny(unsafe_code)]

pub mod bearing;
pub mod blob;
pub mod block;
mod choice;
pub mod contact;
pub mod frame;
pub mod kinematic_state;
pub mod log;
pub mod math;
pub mod phase;
pub mod probe;
pub mod rotor;
pub mod scalar;
pub mod status;
pub mod twin;

/// The library whose matrices are stiffnesses: its version is that of the kernel.
pub use nalgebra;

pub use bearing::{
    AngularContact, Bearing, DeepGroove, HighSpeedBearing, LubricatedBearing, LumpedAxial, LumpedRadial,
    LumpedRadialAxial, LumpedRoller, QuasiStaticBearing, QuasiStaticRollerBearing, RollerBearing, TabulatedBearing,
};
pub use frame::{Displacement, Stiffness, Wrench};
pub use kinematic_state::BearingKinematicState;
pub use math::{Exact, Fast, Math};
pub use phase::Phase;
pub use scalar::Scalar;
pub use status::Status;
