//! Laws that hold whatever the numbers: tangents, symmetry, work, mirrors, invariance, time stepping.

mod angular;
mod rotor;
