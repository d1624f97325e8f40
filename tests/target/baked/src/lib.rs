//! The spindle's bearings as `ballrace bake` writes them.
#![no_std]

#[rustfmt::skip]
pub mod bearings;
