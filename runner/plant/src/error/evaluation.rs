//! Errors of the evaluation of a recording.

use std::path::PathBuf;

/// Error returned when a scene has no observer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ObserverError {
    /// There are too many probes.
    #[error("recording.probes: too many probes: {found}, expected at most {most}")]
    Probes {
        /// Number of probes.
        found: usize,
        /// Largest number of probes.
        most: usize,
    },
    /// The noise covariance of the probes has no inverse.
    #[error("probes without noise")]
    NoNoise,
    /// The filter has no steady state.
    #[error("filter that does not settle")]
    NotSteady,
    /// The search is cancelled.
    #[error("the search for the observer was cancelled")]
    Cancelled,
}

/// Error returned when a recording cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// The scene has no recording.
    #[error("{}: missing table [recording], expected the recording to replay", file.display())]
    NoRecording {
        /// Scene file.
        file: PathBuf,
    },
    /// The recording has no sample.
    #[error("{recording}: no sample, expected at least one revolution of the shaft")]
    NoSample {
        /// Name of the recording.
        recording: String,
    },
    /// A temperature has no reading at the start of the recording.
    #[error("{recording}: {column}: no temperature in the first second, expected a reading for the clearance")]
    NoTemperature {
        /// Name of the recording.
        recording: String,
        /// Column of the temperature.
        column: String,
    },
    /// A sample is processed before the end of the run-in of the twin.
    #[error("the twin is not run in")]
    NotRunIn,
    /// A sample is processed before the twin has started.
    #[error("the twin has not started")]
    NotStarted,
    /// The thread of the search has ended without a result.
    #[error("the search for the twin's start panicked")]
    SearchPanicked,
}

/// Error returned when a limit of the scene cannot be monitored.
#[derive(Debug, thiserror::Error)]
pub enum LimitError {
    /// The recording does not have the probe.
    #[error("limit: no such probe: {found:?}, expected a probe of [recording]")]
    Probe {
        /// Name of the probe.
        found: String,
    },
    /// The scene does not have the bearing.
    #[error("limit: no such bearing: {found:?}, expected the name of a [[bearing]]")]
    Bearing {
        /// Name of the bearing.
        found: String,
    },
    /// A growth without a baseline.
    #[error("limit: growth_db: no baseline, expected replay with --baseline, or max")]
    NoBaseline,
    /// A growth of an indicator that the baseline does not have.
    #[error("limit: growth_db: baseline without {indicator}, expected one learned by this version")]
    Indicator {
        /// Name of the indicator.
        indicator: &'static str,
    },
}

/// Error returned when a vibration recording cannot be evaluated.
#[derive(Debug, thiserror::Error)]
pub enum VibrationError {
    /// The scene has limits.
    #[error("{}: [[limit]]: limits without probes, expected none; damage is diagnosed without", file.display())]
    Limits {
        /// Scene file.
        file: PathBuf,
    },
    /// A sensor measures a bearing that the scene does not have.
    #[error(
        "{}: [recording] sensors: {sensor}: no such bearing: {found:?}, expected the name of a [[bearing]]", file.display()
    )]
    Bearing {
        /// Scene file.
        file: PathBuf,
        /// Column of the sensor.
        sensor: String,
        /// Name of the bearing.
        found: String,
    },
    /// Snapshots at a speed that changes.
    #[error("{}: [shaft] speed: speed that changes, expected one speed for sequence = \"snapshots\"", file.display())]
    SnapshotSpeed {
        /// Scene file.
        file: PathBuf,
    },
    /// The recording is too short.
    #[error("{recording}: too short: {found:.1} turns of the shaft, expected {least} or more")]
    TooShort {
        /// Name of the recording.
        recording: String,
        /// Number of revolutions.
        found: f64,
        /// Smallest number of revolutions.
        least: f64,
    },
}
