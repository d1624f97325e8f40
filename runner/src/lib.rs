//! The program `ballrace`: command line, live monitor and terminal dashboard.
//!
//! The computations are in the crate `ballrace-twin`, the reports in `ballrace-report`.
#![forbid(unsafe_code)]

pub mod cli;
mod dashboard;
pub mod error;
pub mod live;
