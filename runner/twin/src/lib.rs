//! Scenes of rotating machines, recordings of their shafts, and the digital twin that joins the two.
//!
//! Data flows one way: scene and recording -> displacement at each bearing -> force -> twin -> residual -> outcome. The
//! crate has no terminal, no HTML and no command line: `ballrace-report` renders its outcomes, `ballrace-runner` is the
//! program.
#![forbid(unsafe_code)]

pub mod bake;
pub mod baseline;
pub mod campbell;
pub mod effect_significance;
pub mod equilibrium;
pub mod error;
pub mod fit;
pub mod force;
pub mod least_squares;
pub mod motion;
pub mod observer;
pub mod outcome;
pub mod output;
pub mod parquet_table;
pub mod plant;
pub mod printable;
pub mod probes;
pub mod recording;
pub mod replay;
pub mod scene;
pub mod simd;
pub mod sweep;
pub mod trade;
pub mod vibration;
