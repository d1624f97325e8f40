//! The spindle's bearings, a log of their forces, a flexible rotor and its observer as `ballrace bake` writes them.
#![no_std]

#[rustfmt::skip]
pub mod bearings;
#[rustfmt::skip]
pub mod flexible;
pub mod blob;
pub mod framed;
pub mod log;
pub mod motion;
