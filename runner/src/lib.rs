//! The program `ballrace`: command line, live monitor and terminal dashboard.
//!
//! Everything that it computes is in `ballrace-twin`, every report that it writes in `ballrace-report`.
#![forbid(unsafe_code)]

pub mod cli;
mod dashboard;
pub mod error;
pub mod live;
