//! Bearings of the kernel `ballrace`, built from a scene and chosen at run time. This is the only crate that instantiates the kernel's
//! models: with wide registers, in two precisions.
//!
//! Each model is one file with all that depends on it beyond the keys of a scene: its construction, its levels of fidelity, its cost and its
//! constants in firmware. [`bearing_model`] returns it. [`construction`] converts a scene to kernel types, [`handle`] holds a bearing of any
//! model, [`simd`] runs it on the widest registers of the processor, [`firmware`] has the part of the constants that models have in common.
#![forbid(unsafe_code)]

mod angular;
pub mod construction;
mod dynamic;
pub mod firmware;
pub mod handle;
mod linear;
mod lumped;
mod quasi_static;
mod registry;
pub mod simd;
mod tabulated;

/// The name that programs use.
pub use construction as build;
pub use registry::{BearingModel, LevelOptions, bearing_model};
