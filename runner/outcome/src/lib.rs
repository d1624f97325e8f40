//! Outcome of a replay: the figures of the comparison and the data of the report's figures.
//!
//! `--format json` prints [`Outcome`] with these field names. The types are plain data.
#![forbid(unsafe_code)]

pub mod baseline;
mod calibration;
mod diagnosis;
mod failure_mode;
mod fault_figures;
mod field;
mod file;
mod implausibility;
pub mod options;
mod pictures;
mod rotor;
mod rotor_drawing;
mod samples;
mod sensor;
mod snapshots;
mod timing;
pub mod verdict;

pub use calibration::{CalibratedParameter, Calibration, LearnedParameter, Learning, ParameterName, ProbeReadings};
pub use diagnosis::{
    Diagnosis, Estimate, EstimateKind, EvidenceSource, FaultField, FaultForm, FaultKind, FaultParameters, Precession,
    UnexplainedLine, UnexplainedMotion, VibrationLine,
};
pub use failure_mode::FailureMode;
pub use fault_figures::{FaultFigures, FaultMotion, ForceRose, ForceSpectrum, ReferenceFrame};
pub use field::{NumericField, UNIT_OF_SENSOR};
pub use file::RecordingFile;
pub use implausibility::Implausibility;
pub use pictures::{
    Block, BlockFigures, Cascade, Clearance, DeflectedLine, ElementLoads, EnvelopeSpectrum, Excerpt, FilteredOrbit,
    ForceTrace, FullSpectrum, HalfSpectrum, LimitLine, MarkedLine, Orbit, Pictures, Slice, Stretch, Trace, TrendField,
};
pub use rotor::{ALLOWED_REDUCTION_ERRORS, RotorOutcome};
pub use rotor_drawing::{DrawnDisk, DrawnProbe, DrawnSection, DrawnUnbalance, RotorDrawing};
pub use samples::Samples;
pub use sensor::{SensorOutcome, VelocityZone};
pub use snapshots::{LineLevel, SnapshotFigures, SnapshotOutcome, SnapshotTrend};
pub use timing::{OutputFigures, Pacing, Quantiles, SourceFigures, StageTimes, Timing};

use ballrace_recording::flaws::FlawSummary;
use ballrace_scene::{Indicator, OperatingClearance, Scene};
use serde::Serialize;

/// Result of one replay. The tag is the version of its JSON schema, which rises with every incompatible change.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "schema", rename = "ballrace-outcome-1")]
pub struct Outcome {
    /// Name of the scene.
    pub scene: String,
    /// File name of the recording.
    pub recording: String,
    /// The file of the recording; none of a live source, a folder of files or the built-in recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<RecordingFile>,
    /// Version of this program.
    pub version: String,
    /// Verdict as a sentence.
    pub verdict: String,
    /// Samples, time and speed of the recording.
    pub record: Record,
    /// How the probes determine the shaft's motion.
    pub observation: Observation,
    /// The twin that the readings are compared with.
    pub twin: ComparedTwin,
    /// Probes in the order of the scene.
    pub probes: Vec<ProbeOutcome>,
    /// Planes of two radial probes.
    pub planes: Vec<PlaneOutcome>,
    /// Flexible rotor; none of a rigid one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor: Option<RotorOutcome>,
    /// Bearings in the order of the scene.
    pub bearings: Vec<BearingOutcome>,
    /// Vibration sensors whose velocity is known, in the order of the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<SensorOutcome>,
    /// Compute time and, when paced, lateness.
    pub timing: Timing,
    /// Figures of the observer.
    pub observer: Option<ObserverOutcome>,
    /// Reasons why the recording cannot be one of the scene's machine; where there is one, nothing is diagnosed.
    pub implausible: Vec<Implausibility>,
    /// Reasons why there is no verdict, such as quantities that are not measured.
    pub not_judged: Vec<String>,
    /// Diagnosed faults, strongest first; empty where there is none.
    #[serde(rename = "findings")]
    pub diagnoses: Vec<Diagnosis>,
    /// Figures of the diagnosis; none where the recording was not diagnosed.
    pub diagnosis: Option<DiagnosisOutcome>,
    /// Snapshots in the order of their files; empty without `sequence = "snapshots"`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub snapshots: Vec<SnapshotOutcome>,
    /// Trends over the snapshots.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub snapshot_trends: Vec<SnapshotTrend>,
    /// Limits of the scene that were crossed.
    pub events: Vec<Event>,
    /// Flaws of the recording.
    pub flaws: Vec<FlawSummary>,
    /// Notes on assumptions and restrictions.
    pub notes: Vec<String>,
    /// Parameters learned from the recording; none without `--learn`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learning: Option<Learning>,
    /// This recording as a baseline for later ones, not part of the JSON.
    #[serde(skip)]
    pub learned: baseline::Baseline,
    /// Data of the pictures, not part of the JSON.
    #[serde(skip)]
    pub pictures: Pictures,
    /// Every sample, not part of the JSON; none without [`options::Options::samples`].
    #[serde(skip)]
    pub samples: Option<Samples>,
}

impl Outcome {
    /// Returns true if parameters were to be learned and neither they nor the faults found describe the recording.
    #[must_use]
    pub fn is_refused_as_baseline(&self) -> bool {
        self.learning.as_ref().is_some_and(|learning| !learning.stored)
    }

    /// Returns why this recording is no baseline; `None` where it is one.
    #[must_use]
    pub fn no_baseline(&self) -> Option<String> {
        if !self.implausible.is_empty() || !self.not_judged.is_empty() {
            return Some("nothing in the recording was judged".to_owned());
        }
        let refused = self.learning.as_ref().filter(|learning| !learning.stored);
        refused.map(Learning::misfit)
    }

    /// Returns the outcome with stations from the centre of mass replaced by those of the scene's drawing; a rigid rotor has its origin
    /// at the centre of mass. An axial probe keeps the station of the scene. On a `[system]` no station is a number.
    #[must_use]
    pub fn with_stations_as_drawn(mut self, scene: &Scene) -> Self {
        let has_none = scene.system.is_some();
        let origin_mm = if has_none { f64::NAN } else { scene.drawn_station(0.0) * 1e3 };
        if origin_mm == 0.0 {
            return self;
        }
        let on_shaft = self.probes.iter_mut().filter(|probe| has_none || probe.angle_deg.is_some());
        let probes = on_shaft.map(|probe| &mut probe.station_mm);
        let planes = self.planes.iter_mut().map(|plane| &mut plane.station_mm);
        let bearings = self.bearings.iter_mut().map(|bearing| &mut bearing.station_mm);
        let orbits = self.pictures.orbits.iter_mut().map(|orbit| &mut orbit.station_mm);
        for station_mm in probes.chain(planes).chain(bearings).chain(orbits) {
            *station_mm += origin_mm;
        }
        self.diagnoses = self.diagnoses.into_iter().map(|diagnosis| diagnosis.with_station_as_drawn(scene)).collect();
        self
    }
}

/// The twin that the readings are compared with.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ComparedTwin {
    /// The twin starts each sample period at the state that the observer estimates; otherwise it runs freely from its start.
    pub synchronised: bool,
    /// Difference of two twins of the scene that started a turn apart; none where they end in the same motion.
    pub spread: Option<TwinSpread>,
}

impl ComparedTwin {
    /// Returns true where the residual has a meaning: the scene determines the motion, or the twin is synchronised.
    #[must_use]
    pub(crate) const fn is_comparable(&self) -> bool {
        self.synchronised || self.spread.is_none()
    }
}

/// Difference of two twins that started a turn apart.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TwinSpread {
    /// Probe at which they differ most over its noise.
    pub probe: String,
    /// Their rms difference there over the last turn.
    pub difference_um: f64,
    /// Time from the start of the earlier one.
    pub time_s: f64,
}

/// The recording as a whole.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Record {
    /// Rows delivered by the reader.
    pub samples: u64,
    /// Rows that are averaged into one sample of the probes.
    pub average: u32,
    /// Samples, averaged ones counted once, in which every probe was compared.
    pub compared: u64,
    /// Samples per second.
    pub rate_hz: f64,
    /// From the first to the last sample.
    pub duration_s: f64,
    /// Turns of the shaft.
    pub turns: f64,
    /// Mean shaft speed.
    pub mean_speed_rpm: f64,
    /// Slowest.
    pub min_speed_rpm: f64,
    /// Fastest.
    pub max_speed_rpm: f64,
    /// Source of the shaft angle, in words.
    pub angle_source: String,
    /// A run-out measured at slow roll is subtracted from the readings.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_run_out_subtracted: bool,
    /// The scene's constant load on the rotor: N (three) and N m (two).
    pub load: [f64; 5],
    /// Settings of the spectra.
    pub spectra: SpectraSettings,
}

impl Record {
    /// Returns the number of samples, averaged ones counted once.
    #[must_use]
    pub fn averaged(&self) -> u64 {
        self.samples.div_ceil(u64::from(self.average.max(1)))
    }

    /// Returns true where the speed changes by more than 5 % of its mean, so that trends are shown over speed instead of time.
    #[must_use]
    pub fn speed_changes(&self) -> bool {
        (self.max_speed_rpm - self.min_speed_rpm).abs() > 0.05 * self.mean_speed_rpm.abs()
    }
}

/// Settings of the spectra.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpectraSettings {
    /// Spectral lines from 0 Hz to half the rate.
    pub lines: usize,
    /// Hz between two of them.
    pub bin_hz: f64,
    /// Spectra that were averaged.
    pub averages: u64,
}

/// Least-squares problem from probes to the shaft's pose.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Observation {
    /// Condition number of the probe matrix, tilts scaled by the probe span; 1 is perfect, above 100 the probes are badly placed.
    pub condition_number: f64,
    /// Largest ratio of the noise of a displacement at a bearing to the noise of a probe.
    pub noise_gain: f64,
    /// Coordinates that no probe measures and the twin supplies (`w` without an axial probe).
    pub supplied_by_twin: Vec<String>,
}

/// Motion at one probe. Amplitudes are peak (not peak-to-peak) unless the name states otherwise.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Motion {
    /// Mean position.
    pub mean_um: f64,
    /// Largest less smallest reading.
    pub peak_to_peak_um: f64,
    /// About the mean.
    pub rms_um: f64,
    /// 1X amplitude, zero to peak.
    pub one_x_um: f64,
    /// 1X phase lag behind the keyphasor mark, 0 to 360.
    pub one_x_phase_lag_deg: f64,
}

impl Motion {
    /// No reading.
    pub const NONE: Self = Self {
        mean_um: f64::NAN,
        peak_to_peak_um: f64::NAN,
        rms_um: f64::NAN,
        one_x_um: f64::NAN,
        one_x_phase_lag_deg: f64::NAN,
    };

    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 5] = [
        NumericField::new("mean_um", "Mean", "um", |m| m.mean_um),
        NumericField::new("peak_to_peak_um", "Peak to peak", "um pp", |m: &Self| m.peak_to_peak_um).short("peak-peak"),
        NumericField::new("rms_um", "RMS", "um rms", |m: &Self| m.rms_um).short("rms"),
        NumericField::new("one_x_um", "1X", "um peak", |m| m.one_x_um),
        NumericField::new("one_x_phase_lag_deg", "1X phase", "deg lag", |m: &Self| m.one_x_phase_lag_deg).decimals(1),
    ];
}

/// Returns the phase lag of `cosine cos(angle) + sine sin(angle)` in degrees, 0 to 360: the shaft angle of the peak after the
/// keyphasor mark.
#[must_use]
pub fn phase_lag_deg(cosine: f64, sine: f64) -> f64 {
    sine.atan2(cosine).to_degrees().rem_euclid(360.0)
}

/// Ball-pass line of one bearing at one probe.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BallPassLine {
    /// The bearing.
    pub bearing: String,
    /// Per turn of the shaft.
    pub order: f64,
    /// At the mean speed.
    pub frequency_hz: f64,
    /// Zero to peak, mean over blocks of turns.
    pub measured_um: f64,
    /// The same of the twin.
    pub twin_um: f64,
    /// The same of their difference.
    pub residual_um: f64,
}

impl BallPassLine {
    /// No line.
    pub const NONE: Self = Self {
        bearing: String::new(),
        order: f64::NAN,
        frequency_hz: f64::NAN,
        measured_um: f64::NAN,
        twin_um: f64::NAN,
        residual_um: f64::NAN,
    };

    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 5] = [
        NumericField::new("order", "Order", "X", |line: &Self| line.order).decimals(3),
        NumericField::new("frequency_hz", "Line", "Hz", |line: &Self| line.frequency_hz).decimals(1),
        NumericField::new("measured_um", "Measured", "um peak", |line| line.measured_um),
        NumericField::new("twin_um", "Twin", "um peak", |line| line.twin_um),
        NumericField::new("residual_um", "Residual", "um peak", |line: &Self| line.residual_um).short("difference"),
    ];
}

/// Comparison of the twin with a simpler predictor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// The residual of the twin is more than 2 % smaller.
    Better,
    /// The residuals are within 2 % of each other.
    #[default]
    Same,
    /// The residual of the twin is more than 2 % larger, and more than 0.1 % of the motion.
    Worse,
}

/// One simpler predictor of the same signal.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SimplePredictor {
    /// Rms of its residual.
    pub residual_rms_um: f64,
    /// The twin in comparison.
    pub twin_is: Standing,
}

impl SimplePredictor {
    /// Creates the comparison from the residuals of the predictor and of the twin, and the rms of the signal about its mean.
    #[must_use]
    pub fn new(residual_rms_um: f64, twin_rms_um: f64, signal_rms_um: f64) -> Self {
        const MARGIN: f64 = 0.02;
        // What integration and the digits of a file leave of a motion that is predicted exactly.
        const EXACT: f64 = 1e-3;
        let twin_is = if twin_rms_um < (1.0 - MARGIN) * residual_rms_um {
            Standing::Better
        } else if twin_rms_um > (1.0 + MARGIN) * residual_rms_um && twin_rms_um > EXACT * signal_rms_um {
            Standing::Worse
        } else {
            Standing::Same
        };
        Self { residual_rms_um, twin_is }
    }
}

/// Simpler predictors of the signal at a probe.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SimplePredictors {
    /// Mean of the signal.
    pub mean: SimplePredictor,
    /// Previous sample.
    pub persistence: SimplePredictor,
    /// Mean and 1X fitted to the recording.
    pub one_x: SimplePredictor,
    /// The same rotor on linear springs.
    pub linear: SimplePredictor,
}

impl SimplePredictors {
    /// The predictors, each with its residual.
    pub const FIELDS: [NumericField<Self, SimplePredictor>; 4] = [
        NumericField::new("mean", "Mean", "um rms", |of| of.mean),
        NumericField::new("persistence", "Previous sample", "um rms", |of| of.persistence),
        NumericField::new("one_x", "Mean and 1X", "um rms", |of| of.one_x),
        NumericField::new("linear", "Linear springs", "um rms", |of| of.linear),
    ];

    /// Returns the predictors in the order of the tables.
    #[must_use]
    pub fn all(&self) -> [SimplePredictor; 4] {
        Self::FIELDS.map(|field| (field.value)(self))
    }

    /// Returns the comparison of the twin with the best of them.
    #[must_use]
    pub fn worst(&self) -> Standing {
        self.all().map(|b| b.twin_is).into_iter().max().unwrap_or_default()
    }
}

/// Comparison at one probe.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ProbeOutcome {
    /// The probe's column.
    pub name: String,
    /// Along Z as drawn: from the centre of mass of a rigid rotor, from the origin of a flexible rotor's drawing.
    pub station_mm: f64,
    /// From +X towards +Y; absent for an axial probe.
    pub angle_deg: Option<f64>,
    /// The machine.
    pub measured: Motion,
    /// Its twin.
    pub twin: Motion,
    /// Size of the difference of the two 1X vectors.
    pub one_x_error_um: f64,
    /// One entry a bearing with moving elements.
    pub ball_pass: Vec<BallPassLine>,
    /// Mean of measured - twin.
    pub residual_bias_um: f64,
    /// Rms of measured - twin, bias included.
    pub residual_rms_um: f64,
    /// residual_rms over the normaliser.
    pub nrmse_percent: f64,
    /// Normaliser of the NRMSE, in words.
    pub nrmse_normaliser: String,
    /// Probe noise, rms, when the scene gives it.
    pub noise_um: Option<f64>,
    /// Simpler predictors of the signal at a probe.
    pub baselines: SimplePredictors,
    /// Tabular list; none where no block of revolutions is complete.
    pub list: Option<TabularList>,
}

/// Value of an indicator of a probe.
pub(crate) type ProbeValue = fn(&ProbeOutcome) -> f64;

impl ProbeOutcome {
    /// Place and direction of the probe.
    pub const PLACE: [NumericField<Self>; 2] = [
        NumericField::new("station_mm", "Station", "mm", |p: &Self| p.station_mm).decimals(1),
        NumericField::new("angle_deg", "Angle", "deg", |p: &Self| p.angle_deg.unwrap_or(f64::NAN)).decimals(1),
    ];

    /// Difference of measured and twin.
    pub const RESIDUAL: [NumericField<Self>; 4] = [
        NumericField::new("one_x_error_um", "1X vector", "um peak", |p| p.one_x_error_um),
        NumericField::new("residual_bias_um", "Bias", "um", |p| p.residual_bias_um),
        NumericField::new("residual_rms_um", "RMS", "um rms", |p: &Self| p.residual_rms_um).short("rms"),
        NumericField::new("nrmse_percent", "NRMSE", "%", |p| p.nrmse_percent),
    ];

    /// Noise of the probe.
    pub const NOISE: NumericField<Self> =
        NumericField::new("noise_um", "Probe noise", "um rms", |p| p.noise_um.unwrap_or(f64::NAN));

    /// Indicators with a value of the whole recording, in the unit of [`Indicator::unit`].
    pub const INDICATORS: [(Indicator, ProbeValue); 7] = [
        (Indicator::Residual, |p| p.residual_rms_um),
        (Indicator::OneX, |p| p.measured.one_x_um),
        (Indicator::TwoX, |p| p.list.map_or(f64::NAN, |list| list.two_x_um_pp / 2.0)),
        (Indicator::PeakToPeak, |p| p.measured.peak_to_peak_um),
        (Indicator::Rms, |p| p.measured.rms_um),
        (Indicator::CrestFactor, |p| p.list.map_or(f64::NAN, |list| list.crest_factor)),
        (Indicator::Kurtosis, |p| p.list.map_or(f64::NAN, |list| list.kurtosis)),
    ];

    /// Returns true where the readings were compared with the twin's, which requires a shaft angle.
    #[must_use]
    pub const fn has_twin(&self) -> bool {
        !self.twin.mean_um.is_nan()
    }
}

/// One row of the tabular list: means over blocks of four turns. The name of a length states whether it is a peak or a peak-to-peak value.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct TabularList {
    /// Overall, peak to peak within a block.
    pub direct_um_pp: f64,
    /// The greatest of any block.
    pub greatest_um_pp: f64,
    /// Mean position.
    pub gap_um: f64,
    /// Amplitude of 1X, peak to peak.
    pub one_x_um_pp: f64,
    /// Lag of 1X behind the keyphasor, 0 to 360; none where the speed changes.
    pub one_x_phase_lag_deg: Option<f64>,
    /// Amplitude of 2X, peak to peak.
    pub two_x_um_pp: f64,
    /// Peak to peak of the signal without 1X.
    pub not_one_x_um_pp: f64,
    /// Amplitude about 0.5X (0.3X to 0.7X), peak to peak.
    pub half_x_um_pp: f64,
    /// Greatest distance from the mean over the rms.
    pub crest_factor: f64,
    /// 1.5 of a sine, 3 of noise.
    pub kurtosis: f64,
}

impl TabularList {
    /// No block of revolutions.
    pub const NONE: Self = Self {
        direct_um_pp: f64::NAN,
        greatest_um_pp: f64::NAN,
        gap_um: f64::NAN,
        one_x_um_pp: f64::NAN,
        one_x_phase_lag_deg: None,
        two_x_um_pp: f64::NAN,
        not_one_x_um_pp: f64::NAN,
        half_x_um_pp: f64::NAN,
        crest_factor: f64::NAN,
        kurtosis: f64::NAN,
    };

    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 10] = [
        NumericField::new("direct_um_pp", "Direct", "um pp", |list| list.direct_um_pp),
        NumericField::new("greatest_um_pp", "Greatest", "um pp", |list| list.greatest_um_pp),
        NumericField::new("gap_um", "Gap", "um", |list| list.gap_um),
        NumericField::new("one_x_um_pp", "1X", "um pp", |list| list.one_x_um_pp),
        NumericField::new("one_x_phase_lag_deg", "1X phase", "deg lag", |list: &Self| {
            list.one_x_phase_lag_deg.unwrap_or(f64::NAN)
        })
        .decimals(1),
        NumericField::new("two_x_um_pp", "2X", "um pp", |list| list.two_x_um_pp),
        NumericField::new("not_one_x_um_pp", "Not 1X", "um pp", |list| list.not_one_x_um_pp),
        NumericField::new("half_x_um_pp", "0.5X band", "um pp", |list| list.half_x_um_pp),
        NumericField::new("crest_factor", "Crest factor", "", |list: &Self| list.crest_factor).decimals(2),
        NumericField::new("kurtosis", "Kurtosis", "", |list: &Self| list.kurtosis).decimals(2),
    ];
}

/// Motion in a plane of two radial probes: means over blocks of four turns.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlaneOutcome {
    /// Names of its probes.
    pub name: String,
    /// Along Z as drawn.
    pub station_mm: f64,
    /// Farthest from the mean place, zero to peak.
    pub smax_um_peak: f64,
    /// Long axis of the 1X ellipse.
    pub one_x_major_um_pp: f64,
    /// Its short axis.
    pub one_x_minor_um_pp: f64,
    /// The 1X orbit is run through in the sense of rotation.
    pub one_x_forward: bool,
}

impl PlaneOutcome {
    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("station_mm", "Station", "mm", |plane: &Self| plane.station_mm).decimals(1),
        NumericField::new("smax_um_peak", "Smax", "um peak", |plane| plane.smax_um_peak),
        NumericField::new("one_x_major_um_pp", "1X long axis", "um pp", |plane| plane.one_x_major_um_pp),
        NumericField::new("one_x_minor_um_pp", "1X short axis", "um pp", |plane| plane.one_x_minor_um_pp),
    ];
}

/// One force component over the recording.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ForceFigures {
    /// Mean.
    pub mean: f64,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// One standard deviation that probe noise alone puts on a sample (rms over the recording), when known.
    pub noise_sigma: Option<f64>,
}

/// Components of a force, with their units.
pub const FORCE_COMPONENTS: [(&str, &str); 5] = [("FX", "N"), ("FY", "N"), ("FZ", "N"), ("MX", "N m"), ("MY", "N m")];

impl ForceFigures {
    /// Numeric fields, in the unit of their component.
    pub const FIELDS: [NumericField<Self>; 3] = [
        NumericField::new("mean", "Mean", "", |force| force.mean),
        NumericField::new("min", "Smallest", "", |force: &Self| force.min).short("least"),
        NumericField::new("max", "Largest", "", |force| force.max),
    ];
}

/// Figures of the observer.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ObserverOutcome {
    /// Mean of the innovations' normalised squares.
    pub nis_mean: f64,
    /// Expected value where model and noise are true: the number of probes.
    pub nis_expected: f64,
    /// 99 % confidence limits of the mean.
    pub nis_bounds: [f64; 2],
    /// The mean is between them and no sample is distrusted.
    pub consistent: bool,
    /// Largest normalised square that corrects the observer.
    pub gate: f64,
    /// Samples beyond it.
    pub rejected_samples: u64,
    /// Restarts after repeated rejection.
    pub restarts: u64,
    /// Samples in which the force comes from the displacement because the observer is not consistent.
    pub distrusted_samples: u64,
    /// Process noise of the unknown force, N per root second.
    pub process_noise_n_per_root_s: f64,
    /// Noise of each probe in the filter, rms.
    pub noise_um: Vec<f64>,
    /// The unknown load on the rotor: mean and rms about it, N (three) and N m (two); not numbers on a `[system]`.
    pub unknown_load_mean: [f64; 5],
    /// rms about the mean
    pub unknown_load_rms: [f64; 5],
}

/// Results of one bearing.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BearingOutcome {
    /// Its name.
    pub name: String,
    /// Model in words, e.g. "angular, 9 balls".
    pub model: String,
    /// Along Z as drawn.
    pub station_mm: f64,
    /// Orders per turn: cage, outer race, inner race, ball spin; 0 when unknown.
    pub orders: BearingOrders,
    /// FX, FY, FZ (N), MX, MY (N m) on the inner ring, from the measured displacement: of a straight line between the planes of the probes,
    /// unless the scene has a `[system]`.
    pub force_measured: [ForceFigures; 5],
    /// The same at the position that the observer takes to be behind the probes' noise.
    pub force_estimated: [ForceFigures; 5],
    /// The same of the twin.
    pub force_twin: [ForceFigures; 5],
    /// Rms error of the forces from the straight line, computed in the twin; none where the rotor does not bend and no outer ring moves, so that
    /// the line has no error. Where present, the report shows `force_estimated` in place of `force_measured`.
    pub straight_line_error: Option<[f64; 5]>,
    /// Largest load on one element, N, at the displacement of the forces that the report shows.
    pub largest_element_load_n: f64,
    /// Samples in which no element carried load.
    pub contact_lost_samples: u64,
    /// Number of samples with the last valid force because a reading was missing.
    pub held_samples: u64,
}

/// Operating clearance of a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClearanceOutcome {
    /// Diametral clearance in operation.
    pub operating_um: f64,
    /// Diametral clearance before mounting.
    pub unmounted_um: f64,
    /// Reduction by the fits.
    pub by_fits_um: f64,
    /// Reduction by temperature.
    pub by_temperature_um: f64,
}

impl From<OperatingClearance> for ClearanceOutcome {
    fn from(of: OperatingClearance) -> Self {
        let [operating_um, unmounted_um, by_fits_um, by_temperature_um] =
            [of.value(), of.unmounted, of.by_fits, of.by_temperature].map(|x| x * 1e6);
        Self { operating_um, unmounted_um, by_fits_um, by_temperature_um }
    }
}

impl std::fmt::Display for ClearanceOutcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{:.2} um: {:.2} um before mounting, less {:.2} um by the fits and {:.2} um by temperature",
            self.operating_um, self.unmounted_um, self.by_fits_um, self.by_temperature_um
        )
    }
}

/// Orders of one bearing per turn of the shaft.
#[derive(Debug, Clone, Copy, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BearingOrders {
    /// Cage.
    pub cage: f64,
    /// Outer ball pass.
    pub outer_race: f64,
    /// Inner ball pass.
    pub inner_race: f64,
    /// Ball spin, when the geometry is known.
    pub ball_spin: Option<f64>,
}

impl BearingOrders {
    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("cage", "Cage", "X", |orders: &Self| orders.cage).decimals(3),
        NumericField::new("outer_race", "Outer race", "X", |orders: &Self| orders.outer_race).decimals(3),
        NumericField::new("inner_race", "Inner race", "X", |orders: &Self| orders.inner_race).decimals(3),
        NumericField::new("ball_spin", "Ball spin", "X", |orders: &Self| orders.ball_spin.unwrap_or(f64::NAN))
            .decimals(3),
    ];
}

/// Event: a limit that was crossed.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Event {
    /// The indicator, as the scene names it.
    pub indicator: &'static str,
    /// The probe's column.
    pub probe: String,
    /// The bearing, for the line of a race.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Start of the first block beyond the limit, s.
    pub start_s: f64,
    /// End of the last one; none where it was still beyond at the end of the recording.
    pub end_s: Option<f64>,
    /// Largest value.
    pub worst: f64,
    /// End of the block with the largest value, s.
    pub worst_s: f64,
    /// The limit.
    pub limit: f64,
    /// Unit of `worst` and `limit`: um or empty.
    pub unit: &'static str,
    /// The event as a sentence; empty where a line of the event log has it.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub sentence: String,
}

/// Figures of a diagnosis.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnosisOutcome {
    /// Samples that were used, the last ones of the recording in a row.
    pub samples: usize,
    /// Revolutions of the shaft in them.
    pub revolutions: f64,
    /// Mean square of the residual in units of its noise, by the machine in good order: about 1 where that describes the recording.
    pub chi_square_before: f64,
    /// The same with the faults found.
    pub chi_square_after: f64,
    /// Cages in the order of the bearings.
    pub cages: Vec<CageOutcome>,
    /// Errors of the readings of a site beyond those of its baseline, in the order of the probes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<ReadingOutcome>,
}

/// What the readings of a probe have besides the motion of the shaft, as far as the recording shows it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReadingOutcome {
    /// Column of the probe.
    pub probe: String,
    /// Constant part.
    pub gap_um: f64,
    /// Drift over the samples used.
    pub drift_um: f64,
    /// Multiples of the shaft angle, root of the mean square.
    pub run_out_um: f64,
    /// Largest amplitude at a multiple of the frequency of the mains.
    pub hum_um: f64,
    /// Its frequency.
    pub hum_hz: f64,
}

/// Estimate of one cage.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CageOutcome {
    /// Bearing.
    pub bearing: String,
    /// True where the passing of the elements is observable. Otherwise no figure depends on the angle of the cage.
    pub observable: bool,
    /// Cage speed below that of pure rolling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_percent: Option<Estimate>,
    /// Lowest and highest slip while the observer followed the cage through a recording longer than the samples used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub followed_slip_percent: Option<[f64; 2]>,
    /// Cage speed over shaft speed.
    pub cage_ratio: f64,
    /// Azimuth of the first element with the shaft at its angle 0, between 0 and one pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_element_azimuth_deg: Option<Estimate>,
}
