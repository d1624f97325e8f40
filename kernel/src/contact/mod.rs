//! Contact of a rolling element with its races: stiffness from geometry, load from deflection.

pub mod hertz;
pub mod law;
pub mod line;
