//! Bearings of the kernel `ballrace`, built from a scene and chosen at run time. This is the only crate that instantiates the kernel's
//! models: with wide registers, in two precisions.
//!
//! [`build`] converts a scene to kernel types, [`handle`] holds a bearing of any model, [`simd`] runs it on the widest registers of the
//! processor.
#![forbid(unsafe_code)]

pub mod build;
pub mod handle;
pub mod simd;
