//! The kernel's results on a recording as checksums, one a subject.
#![no_std]

mod recording;
mod subjects;

pub use recording::{BYTES, Sample};
pub use subjects::Subjects;
