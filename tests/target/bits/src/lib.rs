//! The kernel's results on a recording as checksums, one a subject.
#![no_std]

mod on_counts;
mod recording;
mod subjects;

pub use on_counts::on_counts;
pub use recording::{BYTES, Sample};
pub use subjects::Subjects;
