#![doc = include_str!("../README.md")]
#![cfg_attr(not(feature = "std"), no_std)]
// The functions take pointers from C.
#![allow(unsafe_code)]
// The statics have the names of the C header.
#![allow(non_upper_case_globals)]

mod angular;
mod bearing;
mod blob;
mod block;
mod checksum;
mod fixed_point;
mod fixed_tabulated;
mod force_tracker;
mod geometry;
mod indicators;
mod last_valid;
mod linear;
mod log;
mod lumped;
mod model;
mod observer;
mod observer_models;
mod order;
#[cfg(not(feature = "std"))]
mod panic;
mod phase;
mod pointer;
mod probe;
mod roller;
mod rotor;
mod size;
mod state;
mod status;
mod tabulated;

pub use angular::*;
pub use bearing::*;
pub use blob::*;
pub use block::*;
pub use checksum::*;
pub use fixed_point::*;
pub use fixed_tabulated::*;
pub use force_tracker::*;
pub use geometry::*;
pub use indicators::*;
pub use last_valid::*;
pub use linear::*;
pub use log::*;
pub use lumped::*;
pub use observer::*;
pub use observer_models::*;
pub use order::*;
pub use phase::*;
pub use probe::*;
pub use roller::*;
pub use rotor::*;
pub use size::*;
pub use status::*;
pub use tabulated::*;

/// Version of the structs in the header.
///
/// The states of the library store it: a state of another version is rejected with `BALLRACE_STATE_INVALID`.
pub const ABI_VERSION: u32 = 1;
