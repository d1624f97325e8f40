//! Errors of a sweep.

use ballrace_scene::edit::UnknownKey;
use std::path::PathBuf;

/// Error returned when a sweep cannot be run or continued.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A range that cannot be read.
    #[error("--over: invalid range: {found:?}, expected {expected}")]
    Axis {
        /// Text of the option.
        found: String,
        /// Form expected.
        expected: String,
    },
    /// Numbers without a unit of a quantity whose usual unit is not that of SI.
    #[error("--over: no unit: {found:?}, expected {expected}")]
    NoUnit {
        /// Text of the option.
        found: String,
        /// The two likely readings.
        expected: String,
    },
    /// A key that the scene does not have.
    #[error("--over: {0}")]
    Key(UnknownKey),
    /// There are too many points.
    #[error("--over: too many points: {found}, expected at most {most} with {periods} section periods at each")]
    Points {
        /// Number of values of each axis.
        found: String,
        /// Largest number of points.
        most: usize,
        /// Number of section periods of each point.
        periods: usize,
    },
    /// There are too many equilibria.
    #[error("--over: too many points: {found}, expected at most {most}")]
    Equilibria {
        /// Number of values of each axis.
        found: String,
        /// Largest number of points.
        most: usize,
    },
    /// The transient at a point has too many samples.
    #[error("--settle: too many samples: {found:.3e} at {rate:.3e} Hz, expected at most {most:.0e}")]
    Samples {
        /// Number of samples.
        found: f64,
        /// Sampling rate, Hz.
        rate: f64,
        /// Largest number of samples.
        most: f64,
    },
    /// The shaft is at standstill.
    #[error("{}: shaft.speed: shaft at standstill, expected a rotating shaft in a sweep", file.display())]
    Standstill {
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
    /// A journal cannot be read.
    #[error("{}: this file cannot be read", file.display())]
    Read {
        /// The journal.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A file is no journal.
    #[error("{}: no results of a sweep, expected a file that sweep has written", file.display())]
    NoJournal {
        /// The file.
        file: PathBuf,
    },
    /// A journal belongs to another sweep.
    #[error(
        "{}: results of another scene, range or measure, expected those of this sweep; remove the file or choose another -o",
        file.display()
    )]
    OtherSweep {
        /// The journal.
        file: PathBuf,
    },
    /// A line of a journal is invalid.
    #[error("{}:{line}: no result of a sweep", file.display())]
    Line {
        /// The journal.
        file: PathBuf,
        /// Number of the line, from 1.
        line: usize,
        /// First error in the line.
        source: serde_json::Error,
    },
    /// A journal cannot be written.
    #[error("{}: this file cannot be written", file.display())]
    Write {
        /// The journal.
        file: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A result is not a finite number.
    #[error("result of a point that is not finite")]
    NotFinite(#[source] serde_json::Error),
    /// Options or results cannot be written as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

impl SweepError {
    /// Returns true where the options of the command are wrong.
    #[must_use]
    pub const fn is_usage_error(&self) -> bool {
        matches!(
            self,
            Self::Axis { .. } | Self::NoUnit { .. } | Self::Key(_) | Self::Points { .. } | Self::Samples { .. }
        )
    }
}
