#![doc = include_str!("../README.md")]
#![cfg_attr(not(feature = "std"), no_std)]
// The functions take pointers from C.
#![allow(unsafe_code)]
// A header of C needs names of C.
#![allow(non_upper_case_globals)]

mod angular;
mod bearing;
mod checksum;
mod geometry;
mod last_valid;
mod linear;
mod lumped;
mod model;
#[cfg(not(feature = "std"))]
mod panic;
mod phase;
mod pointer;
mod state;
mod status;
mod tabulated;

pub use angular::{
    Angular, DATUM_CENTRED, DATUM_TOUCHING, ballrace_angular_init, ballrace_angular_mirrored_model,
    ballrace_angular_model,
};
pub use bearing::{
    Bearing, Element, KinematicState, Model, ballrace_element_loads, ballrace_elements_evenly_spaced,
    ballrace_elements_mirror, ballrace_force, ballrace_force_and_stiffness, ballrace_force_at,
};
pub use checksum::{ChecksumRange, ballrace_checksum};
pub use geometry::{Geometry, InvalidParameter, Material, ballrace_geometry_set_clearance};
pub use last_valid::{LastValid, ballrace_held_count, ballrace_last_valid_init, ballrace_sample, ballrace_sample_at};
pub use linear::{Linear, ballrace_linear_model};
pub use lumped::{
    LumpedRadial, LumpedRadialAxial, ballrace_lumped_radial_axial_line_mirrored_model,
    ballrace_lumped_radial_axial_line_model, ballrace_lumped_radial_axial_mirrored_model,
    ballrace_lumped_radial_axial_model, ballrace_lumped_radial_axial_power_mirrored_model,
    ballrace_lumped_radial_axial_power_model, ballrace_lumped_radial_init, ballrace_lumped_radial_line_model,
    ballrace_lumped_radial_model, ballrace_lumped_radial_power_model,
};
pub use phase::{
    ballrace_phase_advance, ballrace_phase_advance_counts, ballrace_phase_from_revolutions, ballrace_phase_multiple,
    ballrace_phase_per_count, ballrace_phase_since, ballrace_phase_to_revolutions, ballrace_speed_ratio,
    ballrace_speed_ratio_apply,
};
pub use status::{
    CONTACT_LOST, GYROSCOPIC_SLIP, INNOVATION_REJECTED, INPUT_NOT_FINITE, INVALID_ARGUMENT, NOT_CONVERGED, OK,
    OUT_OF_TABLE, RESULT_NOT_FINITE, STATE_INVALID,
};
pub use tabulated::{
    Axis, Tabulated, ballrace_tabulated_friction_mirrored_model, ballrace_tabulated_friction_model,
    ballrace_tabulated_mirrored_model, ballrace_tabulated_model,
};

/// Version of the structs in the header.
///
/// The states of the library store it: a state of another version is rejected with `BALLRACE_STATE_INVALID`.
pub const ABI_VERSION: u32 = 1;
