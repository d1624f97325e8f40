//! Conversion of a scene to kernel types: what programs call.

pub use crate::construction::*;
pub use crate::dynamic::{Balls, moving_balls};
pub use crate::handle::{AnyBearing, AnyForceModel, Shared};
pub use crate::linear::{linearised, spring_of};
pub use crate::lumped::{Exponent, law};
pub use crate::preload::{loaded, offset_by_preload, preload_force, preload_offset, preloaded};
pub use crate::quasi_static::{quasi_static, solved_in};
pub use crate::registry::{bearing, force_model};
pub use crate::solved::Solved;
pub use crate::tabulated::{DESKTOP_TABLE, FIRMWARE_TABLE, TableSize, of_table, table};
