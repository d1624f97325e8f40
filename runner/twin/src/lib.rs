//! Scenes of rotating machines, recordings of their shafts, and the digital twin that compares the two.
//!
//! # Example
//!
//! The scene below is a rotor on two bearings; the recording is CSV text in memory, of a shaft that whirls by 2 um.
//!
//! ```
//! use ballrace_twin::recording::Reader;
//! use ballrace_twin::replay::{Options, replay};
//! use ballrace_twin::scene::read::read_str;
//! use std::path::Path;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = r#"
//!     [shaft]
//!     speed = "3000 rpm"
//!     [rotor]
//!     mass = "6 kg"
//!     diametral_inertia = 0.030
//!     polar_inertia = 0.006
//!     damping = [400, 400, 400, 0.4, 0.4]
//!     [[bearing]]
//!     name = "DE"
//!     station = "-100 mm"
//!     model = "lumped"
//!     elements = 9
//!     stiffness = 1e10
//!     radial_play = "5 um"
//!     cage_ratio = 0.4
//!     axial = { stiffness = 1e9, exponent = 1.5, play = "0 um", radius = "20 mm" }
//!     [[bearing]]
//!     name = "NDE"
//!     station = "100 mm"
//!     model = "lumped"
//!     elements = 9
//!     stiffness = 1e10
//!     radial_play = "5 um"
//!     cage_ratio = 0.4
//!     axial = { stiffness = 1e9, exponent = 1.5, play = "0 um", radius = "20 mm" }
//!     [recording]
//!     file = "in memory"
//!     rate = "12.8 kHz"
//!     probes = [
//!       { column = "DE_X", unit = "um", station = "-120 mm", angle = "0 deg" },
//!       { column = "DE_Y", unit = "um", station = "-120 mm", angle = "90 deg" },
//!       { column = "NDE_X", unit = "um", station = "120 mm", angle = "0 deg" },
//!       { column = "NDE_Y", unit = "um", station = "120 mm", angle = "90 deg" },
//!     ]
//!     speed = { column = "speed", unit = "rpm" }
//! "#;
//! let scene = read_str(scene, Path::new("scene.toml"))?;
//!
//! let mut recording = String::from("DE_X,DE_Y,NDE_X,NDE_Y,speed\n");
//! for sample in 0..6400 {
//!     let (sin, cos) = (f64::from(sample) / 256.0 * std::f64::consts::TAU).sin_cos();
//!     let (x, y) = (2.0 * cos, -7.0 + 2.0 * sin);
//!     recording += &format!("{x:.4},{y:.4},{x:.4},{y:.4},3000\n");
//! }
//! let source = std::io::Cursor::new(recording.into_bytes());
//! let columns = scene.recording.as_ref().ok_or("no recording")?;
//! let reader = Reader::from_reader(Box::new(source), Path::new("in memory"), None, columns)?;
//!
//! let outcome = replay(&scene, reader, "in memory", &Options::default())?;
//! println!("{}", outcome.verdict);
//! for probe in &outcome.probes {
//!     println!("{}: 1X {:.2} um peak, residual {:.2} um rms", probe.name, probe.measured.one_x_um, probe.residual_rms_um);
//! }
//! assert_eq!(outcome.record.samples, 6400);
//! assert!((outcome.probes[0].measured.one_x_um - 2.0).abs() < 0.01);
//! # Ok(())
//! # }
//! ```
//!
//! # Layers
//!
//! Each layer uses modules of its own and of the layers above it only.
//!
//! | layer | modules | content |
//! | --- | --- | --- |
//! | basis | [`printable`], [`output`], [`folder_lock`], [`parquet_table`], [`parallel`], [`least_squares`], [`eigenvalues`] | safe text, complete or absent files, tables; work on all processors; numerical methods |
//! | kernel | [`simd`], [`handle`], [`flexible_rotor`] | bearings of the kernel chosen at run time; a rotor that bends in a few coordinates |
//! | input | [`catalogue`], [`scene`], [`recording`], [`draft`] | bearings by designation; a scene file with units, checked; recordings in several formats, row by row, with counted flaws; the draft of a scene |
//! | outcome | [`outcome`], [`verdict`], [`options`] | results as plain data, the baseline for later recordings, the verdict as a sentence; options of a replay |
//! | model | [`plant`], [`probes`], [`spectrum`], [`error`] | rotor and bearings as equations of motion, with their equilibrium; readings of probes; amplitudes of lines |
//! | studies | [`campbell`], [`effect_significance`], [`equilibrium`], [`force`], [`motion`], [`sweep`], [`trade`] | one question about a scene each |
//! | estimation | [`observer`], [`plausibility`] | displacement and unmodelled force from noisy probes; whether a recording can be one of the scene's machine |
//! | evaluation | [`vibration`], [`diagnosis`], [`replay`] | measured against computed motion, forces, indicators, limits, diagnosis: an [`Outcome`](outcome::Outcome) |
//! | inverse problems | [`fit`], [`bake`] | parameters from a recording; constants for firmware |
//! | use | [`check`], [`fleet`], [`record`] | check of a scene with its recording; a table of machines; events and seconds of a running monitor |
//!
//! Data flows one way: scene and recording, displacement at each bearing, force, twin, residual, outcome.
//!
//! # Errors
//!
//! Every part of the library has an error of its own, with file, line, key, found and expected value as fields, for example
//! [`scene::read::SceneError`], [`recording::error::RecordingError`], [`plant::PlantError`], [`error::LimitError`].
//! Functions that need several parts return [`error::Error`], which holds any of them;
//! [`is_usage_error`](error::Error::is_usage_error) separates a wrong scene or option from work that could not be done.
//!
//! # Non-goals
//!
//! - No terminal, no HTML, no command line: `ballrace-report` renders outcomes, `ballrace-runner` is the program.
//! - No bearing physics: forces, stiffness and integrators are those of the `no_std` kernel `ballrace`.
//! - No acquisition hardware: samples arrive as files, bytes or rows.
//! - Finite elements of shafts only: everything else of a machine is rigid, on springs, or given by its matrices.
//! - No life or maintenance decision: the outcome reports diagnoses with their evidence.
#![forbid(unsafe_code)]

pub mod bake;
pub mod campbell;
pub mod catalogue;
mod caught;
pub mod check;
pub mod diagnosis;
pub mod draft;
pub mod effect_significance;
pub mod eigenvalues;
pub mod equilibrium;
pub mod error;
pub mod fit;
pub mod fleet;
pub mod flexible_rotor;
pub mod folder_lock;
pub mod force;
pub mod handle;
pub mod least_squares;
mod moments;
pub mod motion;
mod npy_header;
pub mod observer;
pub mod options;
pub mod outcome;
pub mod output;
pub mod parallel;
pub mod parquet_table;
pub mod plant;
pub mod plausibility;
pub mod printable;
mod priority;
pub mod probes;
pub mod record;
pub mod recording;
pub mod replay;
pub mod scene;
mod sha256;
pub mod simd;
pub mod spectrum;
mod statistics;
pub mod sweep;
pub mod trade;
pub mod verdict;
pub mod vibration;
