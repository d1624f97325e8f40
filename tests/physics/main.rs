//! Laws that hold whatever the numbers: tangents, symmetry, work, mirrors, invariance, time stepping.

mod batch;
mod bearings;
mod checksum;
mod damage;
mod element_loads;
mod examples;
mod fast;
mod general;
mod indicators;
mod pairs;
mod quasi_static;
mod rollers;
mod rotor;
mod solver;
mod status;
mod tabulated;
mod tangent;
mod turn;
