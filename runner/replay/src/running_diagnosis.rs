//! Diagnosis while a recording runs: the last block of samples on a thread of its own, with a bounded share of one core.

use super::background::{Pause, Task, set_priority};
use super::notices::Notices;
use ballrace_base::parallel;
use ballrace_diagnosis::block::Block;
use ballrace_diagnosis::plausibility::implausible_samples;
use ballrace_diagnosis::{self as diagnosis, DiagnosisInput, DiagnosisResult};
use ballrace_models::build::BuildError;
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::options::{BackgroundSchedule, Options};
use ballrace_outcome::{Calibration, Diagnosis, FaultFigures, FaultKind, Implausibility};
use ballrace_plant::Plant;
use ballrace_plant::observer::{CagePosition, CageTracker, found_position};
use ballrace_recording::Sample;
use ballrace_scene::{Probe, Scene};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Number of consecutive diagnoses without a fault after which it has ended; a single one may miss a fault near its threshold.
const MISSED: u32 = 2;

/// Machine and probes of a diagnosis on the thread.
struct Machine {
    scene: Scene,
    plant: Arc<Plant>,
    probes: Vec<Probe>,
    /// Sample period, s.
    period: f64,
    calibration: Option<Calibration>,
    /// Samples that are not plausible are diagnosed too.
    force_diagnosis: bool,
}

impl Machine {
    fn diagnose(&self, samples: &[Sample]) -> Result<Judged, BuildError> {
        let implausible = implausible_samples(&self.scene, samples, self.period);
        if !implausible.is_empty() && !self.force_diagnosis {
            return Ok(Judged::Implausible(implausible));
        }
        let material = DiagnosisInput {
            scene: &self.scene,
            plant: &self.plant,
            probes: &self.probes,
            samples,
            period: self.period,
            calibration: self.calibration.as_ref(),
            is_corrected: true,
        };
        Ok(diagnosis::diagnose(&material, &|_| {})?.map_or(Judged::Undetermined, Judged::Diagnosed))
    }
}

/// Result of a diagnosis on the thread.
enum Judged {
    Diagnosed(DiagnosisResult),
    /// The probes do not determine the motion.
    Undetermined,
    /// The samples cannot be of the scene's machine.
    Implausible(Vec<Implausibility>),
}

/// State of the diagnosis of a running machine.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum DiagnosisState {
    /// No sample has arrived, or the samples are not diagnosed.
    #[default]
    NotMade,
    /// The samples of the first diagnosis are collected.
    Collecting {
        /// Length of the samples in a row that it has, s.
        collected_s: f64,
        /// Length that it requires at the present speed, s.
        required_s: f64,
    },
    /// The first diagnosis is computed, of samples up to this time of the recording, s.
    Computing {
        /// Time of the last sample.
        time_s: f64,
    },
    /// The last diagnosis, of samples up to this time of the recording, s.
    Made {
        /// Time of the last sample.
        time_s: f64,
    },
    /// The last samples were not plausible.
    Implausible {
        /// Reason as a sentence.
        sentence: String,
    },
    /// No further diagnosis is made.
    Ended {
        /// Reason as a sentence.
        sentence: String,
    },
}

/// Faults at the end of the last diagnoses, from which another process can continue.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct FaultState {
    /// Faults found in the motion of the shaft.
    pub shaft_motion: Vec<Diagnosis>,
    /// Faults found in the vibration.
    pub vibration: Vec<Diagnosis>,
}

/// A fault that the last diagnoses found.
struct OpenFault {
    diagnosis: Diagnosis,
    /// Diagnoses since the last one that found it.
    missed: u32,
}

/// A diagnosis in progress.
struct Running {
    task: Task<Result<Judged, BuildError>>,
    end: BlockEnd,
}

/// State of the shaft at the last sample of a block.
struct BlockEnd {
    /// Time in the recording, s.
    time: f64,
    /// Total revolutions of the shaft, and the cages there.
    turns: f64,
    cages: Vec<CagePosition>,
    /// [`CageTracker::interruptions`] then.
    interruptions: u64,
}

impl BlockEnd {
    /// Sets the tracker, which is at `turns`, to the cages that `diagnosis` found in `scene`.
    fn hand_over(&self, diagnosis: &DiagnosisResult, scene: &Scene, turns: f64, tracker: &mut CageTracker) {
        if tracker.interruptions() != self.interruptions {
            return;
        }
        for (b, (found, before)) in diagnosis.cages.iter().zip(&self.cages).enumerate() {
            if found.observable && CageTracker::can_follow(&scene.bearings[b]) {
                let (ratio, azimuth) = found.tangent(self.turns);
                let position = found_position(ratio, azimuth, scene.bearings[b].first_element_azimuth, self.turns);
                tracker.take(b, &position, before, [self.turns, turns]);
            }
        }
    }
}

/// Diagnoses one block after another, and reports faults as notices: their start, their size at every diagnosis, their end.
pub(super) struct RunningDiagnosis {
    machine: Arc<Machine>,
    running: Option<Running>,
    schedule: BackgroundSchedule,
    /// Pause after the last diagnosis.
    pause: Pause,
    state: DiagnosisState,
    /// The last diagnosis, and the time of its last sample, s.
    last: Option<(DiagnosisResult, f64)>,
    baseline: Option<Baseline>,
    faults: OpenFaults,
    /// The last sample.
    at: SamplePosition,
    /// Index of the last sample of the last block that was diagnosed.
    diagnosed: Option<u64>,
}

/// Place of a sample in the recording.
#[derive(Debug, Clone, Copy, Default)]
struct SamplePosition {
    index: u64,
    time: f64,
    turns: f64,
}

impl RunningDiagnosis {
    /// Creates a monitor of samples with `period`, s.
    pub(super) fn new(
        scene: &Scene,
        plant: Arc<Plant>,
        probes: &[Probe],
        period: f64,
        baseline: Option<Baseline>,
        options: &Options,
    ) -> Self {
        let force_diagnosis = options.force_diagnosis;
        let calibration = baseline.as_ref().and_then(|baseline| baseline.calibration.clone());
        let machine =
            Machine { scene: scene.clone(), plant, probes: probes.to_vec(), period, calibration, force_diagnosis };
        Self {
            machine: Arc::new(machine),
            running: None,
            schedule: options.background,
            pause: Pause::default(),
            state: DiagnosisState::default(),
            last: None,
            baseline,
            faults: OpenFaults::default(),
            at: SamplePosition::default(),
            diagnosed: None,
        }
    }

    /// Returns the faults that the last diagnoses found.
    pub(super) fn diagnoses(&self) -> Vec<Diagnosis> {
        self.faults.diagnoses()
    }

    /// Continues with the faults of an earlier process.
    pub(super) fn restore(&mut self, faults: &[Diagnosis]) {
        self.faults = OpenFaults::new(faults);
    }

    /// Returns the state of the diagnosis.
    pub(super) fn state(&self) -> DiagnosisState {
        self.state.clone()
    }

    /// Takes the last diagnosis and the time of its last sample, s.
    pub(super) fn take(&mut self) -> Option<(DiagnosisResult, f64)> {
        self.last.take()
    }

    /// Starts a diagnosis of a full block where none runs and the last one is long enough ago; takes the result of one that ended.
    ///
    /// The block ends with `sample`. The cages are tracked from the positions that a diagnosis finds.
    pub(super) fn poll(&mut self, block: &Block, sample: &Sample, cages: &mut CageTracker, notices: &mut Notices) {
        self.at = SamplePosition { index: sample.row.index, time: sample.row.time, turns: sample.total_revolutions() };
        self.advance(block, cages, notices);
        if self.is_first() {
            self.state = self.first(block, sample);
        }
    }

    /// The same between the samples: a source that sends no more has its last block diagnosed too. `block` ends with the last sample.
    pub(super) fn advance(&mut self, block: &Block, cages: &mut CageTracker, notices: &mut Notices) {
        let SamplePosition { index, time, turns } = self.at;
        let schedule = self.schedule;
        if let Some(Running { task, end }) = self.running.take_if(|run| run.task.is_due(schedule, index)) {
            let (result, pause) = task.join(schedule);
            self.pause = pause;
            match result {
                Ok(Ok(Judged::Diagnosed(diagnosis))) => {
                    end.hand_over(&diagnosis, &self.machine.scene, turns, cages);
                    self.state = DiagnosisState::Made { time_s: end.time };
                    let is_new = |diagnosis: &Diagnosis| {
                        diagnosis.kind != FaultKind::Other
                            && !self.baseline.as_ref().is_some_and(|b| b.contains_fault(diagnosis))
                    };
                    let new = diagnosis.diagnoses.iter().filter(|diagnosis| is_new(diagnosis)).cloned();
                    let new = new.map(|diagnosis| diagnosis.with_station_as_drawn(&self.machine.scene)).collect();
                    self.faults.report(new, end.time, notices);
                    self.last = Some((diagnosis, end.time));
                }
                Ok(Ok(Judged::Implausible(all))) => {
                    let all: Vec<String> = all.iter().map(Implausibility::to_string).collect();
                    let sentence = format!("No diagnosis while the samples are not plausible: {}.", all.join("; "));
                    if !matches!(self.state, DiagnosisState::Implausible { .. }) {
                        notices.add_always("implausible", end.time, sentence.clone());
                    }
                    self.state = DiagnosisState::Implausible { sentence };
                }
                Ok(Ok(Judged::Undetermined)) => self.end("the probes do not determine the motion", end.time, notices),
                Ok(Err(error)) => self.end(&error.to_string(), end.time, notices),
                Err(_) => self.end("its thread ended", end.time, notices),
            }
        }
        let has_ended = matches!(self.state, DiagnosisState::Ended { .. });
        let is_known = self.diagnosed == Some(index);
        if has_ended || is_known || self.running.is_some() || !self.pause.is_over() || !block.is_full() {
            return;
        }
        self.diagnosed = Some(index);
        let (machine, samples) = (self.machine.clone(), block.clone().into_samples());
        if let Some(reason) = diagnosis::not_applicable(&machine.scene, &samples) {
            self.end(&reason, time, notices);
            return;
        }
        let thread = std::thread::Builder::new().name("diagnosis".to_owned());
        let diagnose = move || {
            set_priority(schedule);
            // The samples have the other processors.
            parallel::on_this_thread(|| machine.diagnose(&samples))
        };
        match thread.spawn(diagnose) {
            Ok(thread) => {
                let end = BlockEnd { time, turns, cages: cages.positions(turns), interruptions: cages.interruptions() };
                self.running = Some(Running { task: Task::new(thread, index), end });
            }
            Err(error) => self.end(&error.to_string(), time, notices),
        }
    }

    /// Returns true before the first result.
    fn is_first(&self) -> bool {
        use DiagnosisState::{Collecting, Computing, NotMade};
        matches!(self.state, NotMade | Collecting { .. } | Computing { .. })
    }

    /// Returns the state of the first diagnosis.
    fn first(&self, block: &Block, sample: &Sample) -> DiagnosisState {
        if let Some(Running { end, .. }) = &self.running {
            return DiagnosisState::Computing { time_s: end.time };
        }
        let period = self.machine.period;
        let required = Block::full_length(sample.speed * period / TAU).max(block.length());
        DiagnosisState::Collecting { collected_s: block.length() as f64 * period, required_s: required as f64 * period }
    }

    /// Ends the diagnoses; limits stay in force.
    fn end(&mut self, reason: &str, time: f64, notices: &mut Notices) {
        let sentence = format!("The monitor makes no diagnosis any more: {reason}.");
        self.state = DiagnosisState::Ended { sentence: sentence.clone() };
        notices.add_always("diagnosis-ended", time, sentence);
    }
}

/// Faults that the last diagnoses found.
#[derive(Default)]
pub(super) struct OpenFaults {
    open: Vec<OpenFault>,
}

impl OpenFaults {
    /// Creates the list of faults that an earlier process found.
    pub(super) fn new(faults: &[Diagnosis]) -> Self {
        Self { open: faults.iter().map(|diagnosis| OpenFault { diagnosis: diagnosis.clone(), missed: 0 }).collect() }
    }

    /// Returns the faults that the last diagnoses found.
    pub(super) fn diagnoses(&self) -> Vec<Diagnosis> {
        self.open.iter().map(|open| open.diagnosis.clone()).collect()
    }

    /// Compares the diagnoses of a diagnosis, whose samples end at `time` (s), with those before.
    pub(super) fn report(&mut self, diagnoses: Vec<Diagnosis>, time: f64, notices: &mut Notices) {
        self.open.iter_mut().for_each(|open| open.missed += 1);
        for diagnosis in diagnoses {
            // The figures belong to a report.
            let diagnosis = Diagnosis { figures: FaultFigures::default(), ..diagnosis };
            match self.open.iter_mut().find(|open| open.diagnosis.is_same_fault(&diagnosis)) {
                Some(open) => {
                    notices.add_always("fault-size", time, diagnosis.sentence.clone());
                    *open = OpenFault { diagnosis, missed: 0 };
                }
                None => {
                    notices.add_always("fault-found", time, diagnosis.sentence.clone());
                    self.open.push(OpenFault { diagnosis, missed: 0 });
                }
            }
        }
        for ended in self.open.extract_if(.., |open| open.missed >= MISSED) {
            notices.add_always("fault-ended", time, format!("No longer found: {}", ended.diagnosis.sentence));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace_outcome::FaultParameters;

    fn diagnosis(kind: FaultKind, bearing: &str) -> Diagnosis {
        Diagnosis {
            kind,
            bearing: Some(bearing.to_owned()),
            failure_modes: vec![],
            line_hz: 1.0,
            order: 1.0,
            level_db: 1.0,
            confidence: 1.0,
            evidence: vec![],
            vibration: None,
            parameters: FaultParameters::default(),
            lines: vec![],
            figures: FaultFigures::default(),
            sentence: format!("{kind:?} of {bearing}"),
        }
    }

    #[test]
    fn a_fault_is_found_followed_and_ended() {
        let (mut faults, mut notices) = (OpenFaults::default(), Notices::default());
        let outer = || diagnosis(FaultKind::OuterRace, "DE");
        let seen = [vec![outer()], vec![outer(), diagnosis(FaultKind::Unbalance, "DE")], vec![outer()], vec![], vec![]];
        for (i, diagnoses) in seen.into_iter().enumerate() {
            faults.report(diagnoses, i as f64, &mut notices);
        }
        let events: Vec<(&str, f64)> = notices.take().iter().map(|n| (n.kind, n.time_s)).collect();
        let expected = [
            ("fault-found", 0.0),
            ("fault-size", 1.0),
            ("fault-found", 1.0),
            ("fault-size", 2.0),
            ("fault-ended", 3.0),
            ("fault-ended", 4.0),
        ];
        assert_eq!(events, expected);
        assert!(faults.open.is_empty());
    }
}
