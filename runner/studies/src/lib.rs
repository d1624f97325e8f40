//! Studies of a machine: one question about a scene each, and its inverse problems.
//!
//! | modules | question |
//! | --- | --- |
//! | [`equilibrium`], [`equilibria`], [`life`], [`force`] | where the rotor rests, how long its bearings last, what a displacement costs |
//! | [`recorded_life`] | how long a bearing lasts under the loads of a recording |
//! | [`friction`], [`heat`], [`thermal`] | what a bearing loses, and how warm it runs |
//! | [`campbell`] | natural frequencies over the speed |
//! | [`effect_significance`] | what an effect changes that the scene omits |
//! | [`sweep`], [`trade`] | motion over a parameter; cost against accuracy |
//! | [`fit`], [`balance`] | parameters from a recording; masses from vibration vectors |
//! | [`bake`] | constants for firmware |
//! | [`fmu`] | a rotor or a bearing as a part of another simulation |
#![forbid(unsafe_code)]

pub mod bake;
pub mod balance;
pub mod campbell;
pub mod effect_significance;
mod elements;
pub mod equilibria;
pub mod equilibrium;
pub mod fit;
pub mod fmu;
pub mod force;
pub mod friction;
pub mod heat;
pub mod life;
mod precision;
pub mod recorded_life;
pub mod sweep;
pub mod thermal;
pub mod trade;
