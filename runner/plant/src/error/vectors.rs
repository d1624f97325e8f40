//! Errors of vectors for balancing.

use std::path::PathBuf;

/// Error returned when recordings of a scene give no vectors for balancing.
#[derive(Debug, thiserror::Error)]
pub enum VectorError {
    /// The scene has no recording.
    #[error("{}: missing table [recording], expected probes and keyphasor of the recordings", file.display())]
    NoRecording {
        /// Scene.
        file: PathBuf,
    },
    /// The scene has no radial probe.
    #[error("{}: recording.probes: no radial probe, expected at least one displacement probe with an angle", file.display())]
    NoProbe {
        /// Scene.
        file: PathBuf,
    },
    /// The recordings have no mark on the shaft.
    #[error("{}: recording: no mark on the shaft, by which angles of runs compare, expected a keyphasor with one pulse per turn, or one on a wheel with a gap", file.display())]
    NoMark {
        /// Scene.
        file: PathBuf,
    },
    /// A recording is shorter than a block.
    #[error("{}: no 1X vector, expected at least {turns} turns with a reading of every probe", file.display())]
    Short {
        /// Recording.
        file: PathBuf,
        /// Least number of turns.
        turns: i64,
    },
    /// The speed of a recording changes too fast.
    #[error("{}: speed changes by {found:.0} % within {turns} turns, expected at most {most} %, a slower run-up", file.display())]
    FastChange {
        /// Recording.
        file: PathBuf,
        /// Turns of a block.
        turns: i64,
        /// Largest change between two blocks, %.
        found: f64,
        /// Largest allowed change, %.
        most: f64,
    },
    /// Recordings of changing speed have no speed in common.
    #[error("{}: no speed in common with the other run-ups, which begin at {low:.1} rpm and end at {high:.1} rpm, expected ranges that overlap", file.display())]
    NoCommonSpeed {
        /// Recording.
        file: PathBuf,
        /// Largest of the lowest speeds, rpm.
        low: f64,
        /// Least of the highest speeds, rpm.
        high: f64,
    },
    /// A trial has another speed than the runs without masses.
    #[error("{}: {found:.1} rpm, expected a speed of the runs without masses: {}", file.display(), list(expected))]
    OtherSpeed {
        /// Recording of the trial.
        file: PathBuf,
        /// Its speed, rpm.
        found: f64,
        /// Speeds of the runs without masses, rpm.
        expected: Vec<f64>,
    },
}

fn list(speeds: &[f64]) -> String {
    let speeds: Vec<String> = speeds.iter().map(|speed| format!("{speed:.1} rpm")).collect();
    speeds.join(", ")
}
