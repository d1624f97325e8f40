//! Bearings of the kernel `ballrace`, built from a scene and chosen at run time. This is the only crate that instantiates the kernel's
//! models: with wide registers, in two precisions.
//!
//! Each model is one file with all that depends on it beyond the keys of a scene: its construction, its levels of fidelity, its cost and its
//! constants in firmware. [`bearing_model`] returns it. [`build`] converts a scene to kernel types, [`handle`] holds a bearing of any
//! model, [`simd`] runs it on the widest registers of the processor, [`model`] has the interface of a model and the part of the firmware constants that models have in common.
#![forbid(unsafe_code)]

mod angular;
pub mod build;
mod construction;
mod dynamic;
pub mod handle;
mod linear;
mod lumped;
pub mod model;
mod preload;
mod quasi_static;
mod registry;
pub mod simd;
mod solved;
mod tabulated;

pub use model::{BearingModel, LevelOptions};
pub use registry::bearing_model;
