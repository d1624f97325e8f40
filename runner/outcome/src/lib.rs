//! Outcome of a replay: the figures of the comparison and the data of the report's figures.
//!
//! `--format json` prints [`Outcome`] with these field names. The types are plain data.
#![forbid(unsafe_code)]

pub mod baseline;
mod bearing;
mod calibration;
mod diagnosis;
mod diagnosis_outcome;
mod event;
mod failure_mode;
mod fault;
mod fault_figures;
mod field;
mod file;
mod implausibility;
mod life;
mod motion;
mod observer;
pub mod options;
mod outcome;
mod pictures;
mod plane;
mod predictors;
mod probe;
mod record;
mod rotor;
mod rotor_drawing;
mod samples;
mod sensor;
mod snapshots;
mod timing;
mod twin;
pub mod verdict;

pub use bearing::{BearingOrders, BearingOutcome, ClearanceOutcome, FORCE_COMPONENTS, ForceFigures};
pub use calibration::{CalibratedParameter, Calibration, LearnedParameter, Learning, ParameterName, ProbeReadings};
pub use diagnosis::{Diagnosis, EvidenceSource, Precession, UnexplainedLine, VibrationLine};
pub use diagnosis_outcome::{CageOutcome, DiagnosisOutcome, ReadingOutcome};
pub use event::Event;
pub use failure_mode::FailureMode;
pub use fault::{Estimate, EstimateKind, FaultField, FaultForm, FaultKind, FaultParameters, UnexplainedMotion};
pub use fault_figures::{FaultFigures, FaultMotion, ForceRose, ForceSpectrum, ReferenceFrame};
pub use field::{NumericField, UNIT_OF_SENSOR};
pub use file::RecordingFile;
pub use implausibility::Implausibility;
pub use life::LifeOutcome;
pub use motion::{BallPassLine, Motion, phase_lag_deg};
pub use observer::{Observation, ObserverOutcome};
pub use outcome::Outcome;
pub use pictures::{
    Block, BlockFigures, Cascade, Clearance, DeflectedLine, ElementLoads, EnvelopeSpectrum, Excerpt, FilteredOrbit,
    ForceTrace, FullSpectrum, HalfSpectrum, LimitLine, MarkedLine, Orbit, Pictures, Slice, Stretch, Trace, TrendField,
};
pub use plane::PlaneOutcome;
pub use predictors::{SimplePredictor, SimplePredictors, Standing};
pub use probe::{ProbeOutcome, TabularList};
pub use record::{Record, SpectraSettings};
pub use rotor::{ALLOWED_REDUCTION_ERRORS, RotorOutcome};
pub use rotor_drawing::{DrawnDisk, DrawnProbe, DrawnSection, DrawnUnbalance, RotorDrawing};
pub use samples::Samples;
pub use sensor::{SensorOutcome, VelocityZone};
pub use snapshots::{LineLevel, SnapshotFigures, SnapshotOutcome, SnapshotTrend};
pub use timing::{OutputFigures, Pacing, Quantiles, SourceFigures, StageTimes, Timing};
pub use twin::{ComparedTwin, TwinSpread};
