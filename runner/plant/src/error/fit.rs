//! Errors of a fit.

use std::path::PathBuf;

/// Error returned when a scene cannot be fitted to a recording.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// The scene has no recording.
    #[error("{}: missing table [recording], expected the recording to fit to", file.display())]
    NoRecording {
        /// Scene file.
        file: PathBuf,
    },
    /// The recording has no sample.
    #[error("{recording}: no sample, expected some turns of the shaft")]
    NoSample {
        /// Name of the recording.
        recording: String,
    },
    /// The search ended before a minimum.
    #[error(
        "{recording}: {reason}, and probe {probe} leaves {left_um:.3} um rms where its noise is {noise_um:.3} um, expected a recording \
         of this machine; --only or --turns fits less"
    )]
    NotConverged {
        /// Name of the recording.
        recording: String,
        /// Where the search ended: "the fit does not converge ...".
        reason: String,
        /// Column of the probe with the largest residual over its noise.
        probe: String,
        /// Residual of that probe, um rms.
        left_um: f64,
        /// Noise of that probe, um rms.
        noise_um: f64,
    },
    /// The time of the search has ended.
    #[error(
        "{recording}: the fit does not converge because its time has ended: {limit_s} s, over {turns:.1} of {all_turns:.1} \
         revolutions, expected fewer revolutions (--turns), fewer parameters (--only) or more time (--time-limit)"
    )]
    TooLong {
        /// Name of the recording.
        recording: String,
        /// Time of the fit, s.
        limit_s: f64,
        /// Number of revolutions over which the search was under way.
        turns: f64,
        /// Number of revolutions in all samples.
        all_turns: f64,
    },
    /// The recording has no probes.
    #[error("{}: [recording]: no probes, expected probes in fit", file.display())]
    NoProbes {
        /// Scene file.
        file: PathBuf,
    },
    /// The scene has no parameter that can be fitted.
    #[error("{}: nothing to fit, expected a [rotor] on bearings", file.display())]
    NothingToFit {
        /// Scene file.
        file: PathBuf,
    },
    /// The text of the scene is no TOML.
    #[error("{}: invalid TOML", file.display())]
    Syntax {
        /// Scene file.
        file: PathBuf,
        /// First error in the text.
        source: toml_edit::TomlError,
    },
    /// The tables of the scene have another form than the fitted values need.
    #[error("{}: the fitted values cannot be written into this scene, expected {expected}", file.display())]
    Form {
        /// Scene file.
        file: PathBuf,
        /// Form that takes the values.
        expected: &'static str,
    },
}
