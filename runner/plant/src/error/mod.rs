//! Errors of the layers above scene, recording and plant, and the error of functions that need several layers.
//!
//! They are defined here, below the modules that return them, so that no two modules depend on each other.

mod bake;
mod evaluation;
mod fit;
mod fleet;
mod motion;
mod sweep;
mod thermal;
mod trade;
mod unit;
mod vectors;

pub use bake::{BakeError, VerifyError};
pub use evaluation::{LimitError, ObserverError, ReplayError, VibrationError};
pub use fit::FitError;
pub use fleet::{FleetError, TablePosition};
pub use motion::{LARGEST_SPEED, MotionOverflow, NoLoad};
pub use sweep::SweepError;
pub use thermal::ThermalError;
pub use trade::TradeError;
pub use unit::UnitError;
pub use vectors::VectorError;

use crate::PlantError;
use crate::probes::UnobservableError;
use ballrace_base::output::OutputError;
use ballrace_models::build::BuildError;
use ballrace_outcome::baseline::BaselineError;
use ballrace_recording::clock::RateError;
use ballrace_recording::error::RecordingError;
use ballrace_recording::rotation::RotationError;
use ballrace_recording::slow_roll::RunOutError;
use ballrace_scene::read::SceneError;
use std::path::PathBuf;

/// Result of a function that needs several parts of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Error of any part of this library.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub enum Error {
    /// A scene cannot be read.
    Scene(#[from] SceneError),
    /// The kernel's types cannot be built from the scene.
    Build(#[from] BuildError),
    /// The equations of motion cannot be assembled or solved.
    Plant(#[from] PlantError),
    /// Probes that do not determine the displacement.
    Probes(#[from] UnobservableError),
    /// A recording cannot be read.
    Recording(#[from] RecordingError),
    /// A recording has an implausible sampling rate.
    Rate(#[from] RateError),
    /// A recording has no shaft angle.
    Rotation(#[from] RotationError),
    /// The run-out of the probes cannot be determined.
    RunOut(#[from] RunOutError),
    /// A baseline cannot be used.
    Baseline(#[from] BaselineError),
    /// There is no observer.
    Observer(#[from] ObserverError),
    /// A limit of the scene cannot be monitored.
    Limit(#[from] LimitError),
    /// A recording cannot be replayed.
    Replay(#[from] ReplayError),
    /// A vibration recording cannot be evaluated.
    Vibration(#[from] VibrationError),
    /// A static equilibrium without a load.
    Equilibrium(#[from] NoLoad),
    /// The temperatures of bearings cannot be found.
    Thermal(#[from] ThermalError),
    /// A computed motion overflows.
    Motion(#[from] MotionOverflow),
    /// A sweep cannot be run or continued.
    Sweep(#[from] SweepError),
    /// A table of machines or the outcomes of a fleet cannot be used.
    Fleet(#[from] FleetError),
    /// A scene cannot be fitted.
    Fit(#[from] FitError),
    /// Recordings give no vectors for balancing.
    Vectors(#[from] VectorError),
    /// Models cannot be compared.
    Trade(#[from] TradeError),
    /// A scene cannot be written as constants.
    Bake(#[from] BakeError),
    /// A file of baked constants cannot be verified.
    Verify(#[from] VerifyError),
    /// A co-simulation unit cannot be opened or used.
    Unit(#[from] UnitError),
    /// An output file cannot be written.
    Output(#[from] OutputError),
    /// A text cannot be formatted.
    Text(#[from] std::fmt::Error),
    /// A thread cannot be started.
    Thread(#[from] std::io::Error),
    /// A histogram of compute times cannot be created.
    Histogram(#[from] hdrhistogram::CreationError),
    /// The scene or the options of a command are rejected before its work begins.
    Setup(Box<Self>),
    /// An error in the content of a file.
    #[error("{}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Error in the file.
        source: Box<Self>,
    },
    /// An error at one point of a sweep.
    #[error("{point}")]
    Point {
        /// Values of the axes.
        point: String,
        /// Error at this point.
        source: Box<Self>,
    },
}

impl Error {
    /// Returns `error` as one of the scene or the options of a command.
    pub fn setup(error: impl Into<Self>) -> Self {
        Self::Setup(Box::new(error.into()))
    }

    /// Returns a function that adds the name of a file to an error in it.
    pub fn in_file<E: Into<Self>>(file: impl Into<PathBuf>) -> impl FnOnce(E) -> Self {
        move |error| Self::File { file: file.into(), source: Box::new(error.into()) }
    }

    /// Returns true where the command or the scene is wrong, as opposed to work that could not be done.
    #[must_use]
    pub fn is_usage_error(&self) -> bool {
        match self {
            Self::Scene(_) | Self::Limit(_) | Self::Setup(_) | Self::Verify(_) => true,
            Self::Build(error) => matches!(error, BuildError::NoForces { .. }),
            Self::Plant(error) => error.is_usage_error(),
            Self::Recording(error) => error.is_scene_fault(),
            Self::RunOut(error) => error.is_scene_fault(),
            Self::Rate(error) => matches!(error, RateError::Scene { .. }),
            Self::Baseline(error) => !matches!(error, BaselineError::Read { .. }),
            Self::Replay(error) => matches!(error, ReplayError::NoRecording { .. }),
            Self::Vibration(error) => !matches!(error, VibrationError::TooShort { .. }),
            Self::Thermal(error) => matches!(error, ThermalError::NoCooling { .. } | ThermalError::NoFriction { .. }),
            Self::Sweep(error) => error.is_usage_error(),
            Self::Fleet(error) => error.is_usage_error(),
            Self::Fit(error) => matches!(
                error,
                FitError::NoRecording { .. } | FitError::NoProbes { .. } | FitError::NothingToFit { .. }
            ),
            Self::Vectors(error) => !matches!(error, VectorError::Short { .. }),
            Self::Trade(error) => error.is_usage_error(),
            Self::File { source, .. } | Self::Point { source, .. } => source.is_usage_error(),
            _ => false,
        }
    }

    /// Returns true where the recording is not plausible for the scene.
    #[must_use]
    pub const fn is_implausible(&self) -> bool {
        matches!(self, Self::Rotation(RotationError::ImplausibleSpeed { .. }))
    }
}

/// Returns the message of an error and those of its causes, separated by colons.
#[must_use]
pub fn with_causes(error: &dyn std::error::Error) -> String {
    let mut message = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        message += ": ";
        message += &error.to_string();
        cause = error.source();
    }
    message
}
