//! Errors of a comparison of models.

use std::path::PathBuf;

/// Error returned when the models of a scene cannot be compared.
#[derive(Debug, thiserror::Error)]
pub enum TradeError {
    /// No model can be built from the scene.
    #[error("no model that this scene allows")]
    NoModel,
    /// The scene has no level of this name.
    #[error("no such model: {found:?}, expected one of this scene")]
    UnknownLevel {
        /// Name of the level.
        found: String,
    },
    /// The text of the scene is no TOML.
    #[error("{}: invalid TOML", file.display())]
    Syntax {
        /// Scene file.
        file: PathBuf,
        /// First error in the text.
        source: toml_edit::TomlError,
    },
    /// The text of the scene has no bearing.
    #[error("{}: missing table [[bearing]]", file.display())]
    NoBearing {
        /// Scene file.
        file: PathBuf,
    },
    /// The recording has no complete sample.
    #[error("{}: no sample with all probes, expected at least one turn of the shaft", file.display())]
    NoSample {
        /// The recording.
        file: PathBuf,
    },
    /// No bearing carries a load.
    #[error("{}: bearings without load over the whole motion, expected a motion under load", file.display())]
    NoLoad {
        /// Scene file.
        file: PathBuf,
    },
    /// No candidate has a cost on the target.
    #[error(
        "--error, --deadline: no model of this scene is among those counted on the Cortex-M4F (waviness, damage and a \
         displaced housing are not counted), expected --error with --on desktop"
    )]
    NotCounted,
    /// The motion of the reference overflows.
    #[error("no motion to compare with: the most accurate model at a fine step: {reason}")]
    Reference {
        /// Its error.
        reason: String,
    },
    /// The motion of every candidate with a cost overflows.
    #[error("no model to recommend: the motion overflows with every model that has a cost. {reason}")]
    Overflow {
        /// Error of the first.
        reason: String,
    },
    /// No candidate is accurate enough.
    #[error(
        "--error: no model is so accurate: {:.3e} %, expected {:.3e} % or more, the least error of a model with a cost", found * 100.0, least * 100.0
    )]
    Error {
        /// Error that is required, relative.
        found: f64,
        /// Error of the most accurate candidate with a cost.
        least: f64,
    },
    /// No candidate is fast enough.
    #[error(
        "--deadline: no model is so fast: {:.3} us at {:.0} MHz, expected {:.3} us or more, the cheapest model with a count",
        found * 1e6, clock / 1e6, least * 1e6
    )]
    Deadline {
        /// Deadline that is required, s.
        found: f64,
        /// Clock of the target, Hz.
        clock: f64,
        /// Time of the cheapest candidate with a cost, s.
        least: f64,
    },
}

impl TradeError {
    /// Returns true where the command or the scene is wrong.
    #[must_use]
    pub const fn is_usage_error(&self) -> bool {
        matches!(self, Self::NotCounted | Self::Error { .. } | Self::Deadline { .. })
    }
}
