//! Kernel against golden values of an independent computation with 40 digits (see README.md here).

mod film;
mod hertz;
mod lumped;
mod published;
mod quasi_static;
mod rollers;
