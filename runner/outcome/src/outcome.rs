//! The outcome as a whole.

use crate::baseline::Baseline;
use crate::bearing::BearingOutcome;
use crate::calibration::Learning;
use crate::diagnosis::Diagnosis;
use crate::diagnosis_outcome::DiagnosisOutcome;
use crate::event::Event;
use crate::file::RecordingFile;
use crate::implausibility::Implausibility;
use crate::observer::{Observation, ObserverOutcome};
use crate::pictures::Pictures;
use crate::plane::PlaneOutcome;
use crate::probe::ProbeOutcome;
use crate::record::Record;
use crate::rotor::RotorOutcome;
use crate::samples::Samples;
use crate::sensor::SensorOutcome;
use crate::snapshots::{SnapshotOutcome, SnapshotTrend};
use crate::timing::Timing;
use crate::twin::ComparedTwin;
use ballrace_recording::flaws::FlawSummary;
use ballrace_scene::Scene;
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
    pub learned: Baseline,
    /// Data of the pictures, not part of the JSON.
    #[serde(skip)]
    pub pictures: Pictures,
    /// Every sample, not part of the JSON; none without [`Options::samples`](crate::options::Options::samples).
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
