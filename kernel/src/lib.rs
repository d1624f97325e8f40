#![doc = include_str!("../README.md")]
#![no_std]
#![deny(unsafe_code)]

pub mod bearing;
mod choice;
pub mod contact;
pub mod frame;
mod lanes;
pub mod math;
pub mod rotation;
pub mod rotor;
pub mod scalar;
pub mod status;
pub mod turn;
pub mod twin;

pub use bearing::Bearing;
pub use frame::{Displacement, Stiffness, Wrench};
pub use math::{Exact, Fast, Math};
pub use rotation::Rotation;
pub use scalar::Scalar;
pub use status::Status;
pub use turn::Turn;
