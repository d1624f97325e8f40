//! Kernel against golden values that were computed apart from it with 40 digits (see README.md here).

mod hertz;
mod lumped;
mod published;
mod quasi_static;
