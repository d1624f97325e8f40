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
//! This crate is the front of those below, each of which uses only crates above it in the table; it re-exports their modules.
//!
//! | crate | modules here | content |
//! | --- | --- | --- |
//! | `ballrace-base` | [`printable`], [`output`], [`parallel`], [`least_squares`], [`eigenvalues`], ... | safe text, complete or absent files; work on all processors; numerical methods |
//! | `ballrace-scene` | [`scene`], [`catalogue`], [`flexible_rotor`] | a scene file with units, checked; bearings by designation; a rotor that bends in a few coordinates |
//! | `ballrace-recording` | [`recording`], [`parquet_table`] | recordings in several formats, row by row, with counted flaws |
//! | `ballrace-models` | [`scene::build`], [`handle`], [`simd`] | bearings of the kernel, built from a scene and chosen at run time |
//! | `ballrace-multibody` | [`multibody`] | bearings whose balls and cage are bodies, integrated with error control |
//! | `ballrace-outcome` | [`outcome`], [`verdict`], [`options`] | results as plain data, the baseline for later recordings, the verdict as a sentence; options of a replay |
//! | `ballrace-plant` | [`plant`], [`probes`], [`spectrum`], [`error`], [`observer`], [`motion`] | rotor and bearings as equations of motion, with their equilibrium; readings of probes; displacement and unmodelled force from noisy probes |
//! | `ballrace-diagnosis` | [`diagnosis`], [`vibration`], [`plausibility`] | kind, place and size of faults; whether a recording can be one of the scene's machine |
//! | `ballrace-studies` | [`campbell`], [`effect_significance`], [`equilibrium`], [`equilibria`], [`life`], [`friction`], [`heat`], [`thermal`], [`force`], [`sweep`], [`trade`], [`fit`], [`balance`], [`bake`], [`fmu`] | one question about a scene each; parameters from a recording, constants for firmware, units for co-simulation |
//! | `ballrace-replay` | [`replay`], [`check`], [`draft`], [`fleet`], [`record`], [`vectors`] | measured against computed motion: an [`Outcome`](outcome::Outcome); check and draft of a scene; a table of machines; records of a monitor; 1X vectors for balancing |
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
//! - No maintenance decision: the outcome reports diagnoses with their evidence, and the rating life under the recorded loads.
#![forbid(unsafe_code)]

pub use ballrace_base::{eigenvalues, folder_lock, least_squares, output, parallel, printable};
pub use ballrace_diagnosis::{self as diagnosis, plausibility, vibration};
pub use ballrace_models::{handle, simd};
pub use ballrace_multibody as multibody;
pub use ballrace_outcome::{self as outcome, options, verdict};
pub use ballrace_plant::{self as plant, error, motion, observer, probes, spectrum};
pub use ballrace_recording::{self as recording, parquet_table};
pub use ballrace_replay::{self as replay, check, draft, fleet, record, vectors};
pub use ballrace_scene::{catalogue, flexible_rotor};
pub use ballrace_studies::{
    bake, balance, campbell, effect_significance, equilibria, equilibrium, fit, fmu, force, friction, heat, life,
    sweep, thermal, trade,
};

/// Scenes: the description of a machine (TOML with units), and the kernel's parameters from it.
pub mod scene {
    pub use ballrace_base::bounded;
    pub use ballrace_models::build;
    pub use ballrace_scene::*;
}
