//! One contact between a rolling element and its races: stiffness from geometry, load from deflection.

pub mod hertz;
pub mod law;
pub mod line;
