//! The runner of ballrace: scenes, recordings, the replay with its twin, reports.
//!
//! Data flows one way: recording -> displacement at each bearing -> force -> twin -> residual -> report.
#![forbid(unsafe_code)]

pub mod bake;
pub mod campbell;
pub mod cli;
mod dashboard;
pub mod equilibrium;
pub mod fault;
pub mod fit;
pub mod live;
pub mod motion;
pub mod needs;
pub mod observer;
pub mod output;
mod parquet_table;
pub mod plant;
pub mod recording;
pub mod replay;
pub mod report;
pub mod scene;
pub mod sweep;
pub mod trade;
pub mod vibration;
pub mod wide;
