//! Fixed-point arithmetic: a constant number of instructions on cores without a floating-point unit.
//!
//! The routines of software floats branch on their values; here are sums, products, shifts and tables that no value is too large or too small
//! for, on counts as a converter delivers them: radial and axial elements of the lumped model, and balls whose force is interpolated in a table.

mod arithmetic;
mod lumped;
mod root;
mod tabulated;

pub use arithmetic::{Direction, direction};
pub use lumped::{Axial, AxialElements, AxialParams, AxialReaction, Radial, RadialElements, RadialParams, Reaction};
pub use tabulated::{Tabulated, TabulatedElements, TabulatedParams, TabulatedReaction, directions};
