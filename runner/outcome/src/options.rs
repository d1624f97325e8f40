//! Options of a replay.

use std::path::Path;
use std::time::Duration;

/// Options of a replay.
#[derive(Default)]
pub struct Options<'a> {
    /// File for the forces of every sample.
    pub forces: Option<&'a Path>,
    /// Every sample is kept for the outcome; not for live operation, which has no end.
    pub samples: bool,
    /// Source of these forces, and of positions and forces of the samples.
    pub source: Source,
    /// Tolerated error of the force: the effect significance reports neglected effects beyond it.
    pub error: Option<f64>,
    /// File with a baseline for comparison.
    pub baseline: Option<&'a Path>,
    /// Live operation: indicators of every second are kept for `Replay::take_update`, the start of
    /// the twin does not block, and forces that are not written to a file are computed for a limited number of samples per second.
    pub live: bool,
    /// When diagnoses and envelope spectra of live operation start and when their results are taken.
    pub background: BackgroundSchedule,
    /// A display is in use: `Replay::snapshot` returns the last samples.
    pub viewed: bool,
    /// The machine is healthy: its parameters are calibrated for the baseline of the outcome.
    pub learn: bool,
    /// Time after which the calibration is given up; none without a limit.
    pub learning_time: Option<Duration>,
    /// A recording that is not plausible for the scene is diagnosed nevertheless; the implausibilities are notes of the outcome.
    pub force_diagnosis: bool,
    /// Function that is called with the progress at intervals.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

/// Schedule of the work on threads of its own in live operation: diagnoses and envelope spectra.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum BackgroundSchedule {
    /// By the wall clock: a result is taken once the thread has finished, and the work uses a fifth of one core at most.
    #[default]
    WallClock,
    /// By the samples: a result is taken this number of samples after the end of its block, where the samples wait for the
    /// thread if necessary, and the next block is due at once. Results do not depend on the speed of the machine.
    Samples(u64),
}

/// Displacement of the forces in the forces file and in the figures.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Source {
    /// Bearing model at the displacement estimated by the observer, free of probe noise.
    #[default]
    Observer,
    /// Bearing model at the displacement measured by the probes: on the straight line between their planes.
    Displacement,
}

/// Progress of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Progress {
    /// Bytes read and, where known, their total.
    Read(u64, Option<u64>),
    /// Round of the calibration that begins, from 1.
    Learning(usize),
    /// Share of the diagnosis that is done.
    Diagnosis(f64),
}
