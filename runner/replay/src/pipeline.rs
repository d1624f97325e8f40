//! The stages of a replay in the order in which a sample passes through them.

use super::evaluate::Evaluator;
use super::follow::{FollowedSample, Follower};
use super::force::element_loads;
use super::limits::LimitMonitor;
use super::lines::followed_orders;
use super::locate::LocationStage;
use super::notices::{Notice, Notices, check_sample};
use super::pictures::marked_lines;
use super::readings::Reading;
use super::running_diagnosis::{DiagnosisState, FaultState, RunningDiagnosis};
use super::running_vibration::RunningVibration;
use super::second::Second;
use super::snapshot::Snapshot;
use super::standstill::Standstill;
use super::startup::{Search, Startup};
use ballrace_diagnosis::DiagnosisResult;
use ballrace_diagnosis::plausibility::Collector;
use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_diagnosis::vibration::join::join;
use ballrace_diagnosis::vibration::signals::Signals;
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::options::Options;
use ballrace_outcome::{Calibration, Diagnosis, Implausibility, Learning};
use ballrace_plant::error::Result;
use ballrace_plant::probes::{self, Plane};
use ballrace_plant::{Plant, only_observable, unbalance_note};
use ballrace_recording::{Row, Sample};
use ballrace_scene::{Probe, Recording, RotationSource, Scene};
use ballrace_studies::effect_significance;
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Results of the look-ahead, made before the first sample.
#[derive(Default)]
pub(super) struct LookAhead {
    /// Diagnosis of the whole recording.
    pub(super) diagnosed: Option<DiagnosisResult>,
    /// Calibration of the scene by this recording.
    pub(super) calibration: Option<Calibration>,
    /// Learned parameters, compared with the scene.
    pub(super) learning: Option<Learning>,
    /// Failed checks of the first samples that a forced diagnosis overrides.
    pub(super) overridden: Vec<Implausibility>,
}

/// The stages of a replay up to the observer.
pub(super) struct Pipeline<'a> {
    pub(super) plant: Arc<Plant>,
    pub(super) probes: &'a [Probe],
    pub(super) planes: Vec<Plane>,
    /// Samples per second.
    pub(super) rate: f64,
    pub(super) live: bool,

    /// Twin and observer.
    pub(super) follower: Follower,
    pub(super) ahead: LookAhead,
    /// Diagnosis in live operation.
    pub(super) running_diagnosis: Option<RunningDiagnosis>,
    /// Baseline for comparison.
    pub(super) baseline: Option<Baseline>,
    /// Signals of the vibration sensors; none without sensors, and in live operation.
    pub(super) signals: Option<Signals>,
    /// Vibration sensors in live operation.
    pub(super) vibration: Option<RunningVibration>,

    pub(super) standstill: Standstill,
    /// Figures for the checks of plausibility.
    pub(super) collected: Collector,
    /// An implausible recording is diagnosed too.
    pub(super) force_diagnosis: bool,
    pub(super) notices: Notices,
    pub(super) notes: Vec<String>,
}

impl<'a> Pipeline<'a> {
    pub(super) fn try_new(
        scene: &Scene,
        recording: &'a Recording,
        rate: f64,
        options: &Options,
    ) -> Result<(Self, Evaluator<'a>)> {
        let probes = recording.probes.as_slice();
        only_observable(scene, "replay")?;
        let plant = Plant::try_new(scene)?;
        let mut notes = plant.notes.clone();
        notes.extend(unbalance_note(scene));
        notes.extend(effect_significance::describe(
            &effect_significance::at_rest(scene, &plant)?,
            options.error.unwrap_or(effect_significance::DEFAULT_FORCE_ERROR),
        ));
        let linear = Arc::new(plant.linearised(&vec![true; plant.bearings.len()])?);
        let plant = Arc::new(plant);
        let bearings = plant.bearings.as_slice();
        let rows: Vec<Vec<f64>> = probes.iter().map(|probe| plant.layout.probe_row(probe)).collect();
        let search = Search {
            plant: plant.clone(),
            linear,
            rows: rows.clone(),
            noise: probes.iter().map(|p| p.noise).collect(),
            period: 1.0 / rate,
            speed: scene.shaft.speed,
            process_noise: scene.observer.process_noise,
            is_synchronous: recording.rotation == RotationSource::Synchronous,
            cancelled: Arc::new(AtomicBool::new(false)),
        };
        let planes = probes::planes(probes);
        let baseline = options
            .baseline
            .map(|path| Baseline::read(path, probes, &recording.sensors, &followed_orders(bearings)))
            .transpose()?;
        let limits = LimitMonitor::try_new(&scene.limits, probes, bearings, baseline.as_ref())?;
        let location = Arc::new(LocationStage::try_new(scene, &plant, probes, rows.clone())?);
        let range = ReadingRange::try_new(scene, &plant, probes)?;
        let is_baseline_synchronised = baseline.as_ref().is_some_and(|baseline| baseline.synchronised);
        let evaluator =
            Evaluator::try_new(scene, plant.clone(), (probes, &planes), location.clone(), limits, rate, options)?;
        let pipeline = Self {
            ahead: LookAhead::default(),
            running_diagnosis: options
                .live
                .then(|| RunningDiagnosis::new(scene, plant.clone(), probes, 1.0 / rate, baseline.clone(), options)),
            // Sensors keep the rate of the recording.
            vibration: if options.live {
                RunningVibration::new(scene, rate * f64::from(recording.average), baseline.as_ref(), options.background)
            } else {
                None
            },
            signals: if options.live { None } else { Signals::new(recording, rate * f64::from(recording.average)) },
            baseline,
            standstill: Standstill::default(),
            collected: Collector::new(recording, scene.shaft.speed),
            force_diagnosis: options.force_diagnosis,
            notices: Notices::default(),
            notes,
            follower: Follower::new(
                plant.clone(),
                rate,
                is_baseline_synchronised,
                (range, Startup::new(search, options.live)),
                (location, rows),
            ),
            probes,
            planes,
            rate,
            live: options.live,
            plant,
        };
        Ok((pipeline, evaluator))
    }

    /// Adds the readings of the vibration sensors.
    pub(super) fn push_sensors(&mut self, row: &Row) {
        if let Some(signals) = &mut self.signals {
            signals.add(row);
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.add(row, &mut self.notices);
        }
    }

    /// Checks a sample, passes it to `read`, and queues it for the twin.
    pub(super) fn push(&mut self, mut sample: Sample, read: &mut dyn FnMut(Reading)) -> Result<()> {
        self.collected.add_row(&sample.row);
        if let Some(signals) = &mut self.signals {
            signals.add_angle(&sample);
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.add_angle(&sample, &mut self.notices);
        }
        check_sample(&mut self.follower.range, &mut sample, &mut self.notices);
        self.collected.add_sample(&sample);
        read(Reading::Sample(Cow::Borrowed(&sample)));
        if let Some(found) = self.follower.startup.push(sample, &self.follower.range)? {
            self.follower.start(found, &mut self.notes);
        }
        Ok(())
    }

    /// Adds a sample that has no shaft angle.
    pub(super) fn push_without_angle(&mut self, row: &mut Row, read: &mut dyn FnMut(Reading)) {
        self.collected.add_row(row);
        self.follower.range.check(row);
        self.standstill.add(row);
        if !self.live {
            // A monitored shaft may stand still for hours; in a file, the keyphasor may have failed instead.
            read(Reading::WithoutAngle);
        }
    }

    /// Restarts the twin with the next sample, because the shaft angle is interrupted.
    pub(super) fn restart(&mut self, read: &mut dyn FnMut(Reading)) {
        if let Some(signals) = &mut self.signals {
            signals.interrupt();
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.interrupt();
        }
        read(Reading::Restart);
        self.follower.startup.restart();
    }

    /// Ends the recording: the start is searched in the samples so far.
    pub(super) fn end(&mut self) -> Result<()> {
        if let Some(found) = self.follower.startup.end(&self.follower.range)? {
            self.follower.start(found, &mut self.notes);
        }
        Ok(())
    }

    /// Discards the samples that wait for the twin.
    pub(super) fn discard_waiting(&mut self) {
        let count = self.follower.startup.discard();
        if count > 0 {
            let seconds = count as f64 / self.rate;
            self.notes.push(format!(
                "Stopped before the twin had processed the last {count} samples ({seconds:.1} s): they are not compared."
            ));
        }
    }

    /// Follows the next sample of the queue as [`Follower::next`]; returns false before the search for the observer has ended.
    pub(super) fn next(&mut self, deadline: Option<Instant>, followed: &mut FollowedSample) -> Result<bool> {
        if !self.follower.startup.is_done() {
            return Ok(false);
        }
        self.follower.next(deadline, followed, (&mut self.notices, &mut self.notes))
    }

    /// Processes queued samples until `deadline`, or all of them; `recycle` takes back their rows.
    pub(super) fn work(
        &mut self,
        evaluator: &mut Evaluator,
        deadline: Option<Instant>,
        mut recycle: impl FnMut(Row),
    ) -> Result<()> {
        if let Some(found) = self.follower.startup.poll(deadline)? {
            self.follower.start(found, &mut self.notes);
        }
        let mut followed = FollowedSample::default();
        while self.next(deadline, &mut followed)? {
            evaluator.add(&mut followed)?;
            if let (Some(running), Some(block)) = (&mut self.running_diagnosis, &evaluator.block) {
                running.poll(block, &followed.sample, &mut self.follower.cages, &mut self.notices);
            }
            recycle(std::mem::take(&mut followed.sample.row));
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(());
            }
        }
        if let (Some(running), Some(block)) = (&mut self.running_diagnosis, &evaluator.block) {
            running.advance(block, &mut self.follower.cages, &mut self.notices);
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.advance(&mut self.notices);
        }
        if self.follower.startup.is_done() && !self.follower.startup.is_running_in() {
            evaluator.readings.stop_seconds();
        }
        Ok(())
    }

    /// Returns the notices since the last call.
    pub(super) fn take_notices(&mut self, evaluator: &mut Evaluator) -> Vec<Notice> {
        let mut notices = self.notices.take();
        notices.append(&mut evaluator.notices.take());
        notices
    }

    /// Returns the seconds that ended since the last call.
    pub(super) fn take_ended_seconds(&mut self, evaluator: &mut Evaluator) -> Vec<Second> {
        let mut seconds = std::mem::take(&mut evaluator.ended_seconds);
        if let Some(vibration) = &mut self.vibration {
            for second in &mut seconds {
                second.sensors = vibration.second(second.time_s);
                vibration.drop_seconds(second.time_s);
            }
        }
        seconds
    }

    /// Returns the seconds that ended since the last call while the twin was starting.
    pub(super) fn take_preliminary(&mut self, evaluator: &mut Evaluator) -> Vec<Second> {
        let mut seconds = evaluator.readings.take_ended();
        if let Some(vibration) = &self.vibration {
            seconds.iter_mut().for_each(|second| second.sensors = vibration.second(second.time_s));
        }
        seconds
    }

    /// Returns the present state for a live display; none where no display is in use or the twin does not run.
    pub(super) fn snapshot(&self, evaluator: &Evaluator) -> Option<Snapshot> {
        let (recent, shaft) = (evaluator.recent.as_ref()?, self.follower.twin.shaft()?);
        let coordinates = self.follower.observer.coordinates().unwrap_or_else(|| self.follower.twin.coordinates());
        let loads =
            self.plant.bearings.iter().zip(self.follower.twin.parts()).enumerate().map(|(i, (bearing, &parts))| {
                let displacement = self.plant.displacement(i, coordinates);
                (bearing.name.clone(), element_loads(bearing, &displacement, &bearing.rotation(parts, &shaft)))
            });
        let name = |plane: &Plane| plane.probes.map(|i| self.probes[i].column.as_str()).join(" / ");
        Some(Snapshot {
            time_s: evaluator.totals.last_time,
            speed_rpm: shaft.speed * 60.0 / TAU,
            rate_hz: self.rate,
            samples: recent.samples.iter().cloned().collect(),
            planes: self.planes.iter().map(|plane| (name(plane), plane.clone())).collect(),
            loads: loads.collect(),
            lines: marked_lines(&self.plant.bearings, shaft.speed.abs() / TAU),
        })
    }

    /// Returns the faults that the last diagnoses found, of shaft motion and of vibration.
    pub(super) fn faults(&self) -> FaultState {
        FaultState {
            shaft_motion: self.running_diagnosis.as_ref().map(RunningDiagnosis::diagnoses).unwrap_or_default(),
            vibration: self.vibration.as_ref().map(RunningVibration::diagnoses).unwrap_or_default(),
        }
    }

    /// Returns these faults as diagnoses, each fault once.
    pub(super) fn diagnoses(&self) -> Vec<Diagnosis> {
        let FaultState { shaft_motion, vibration } = self.faults();
        join(shaft_motion, vibration, self.running_diagnosis.is_some())
    }

    /// Continues with the faults of an earlier process.
    pub(super) fn restore_faults(&mut self, faults: &FaultState) {
        if let Some(diagnosis) = &mut self.running_diagnosis {
            diagnosis.restore(&faults.shaft_motion);
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.restore(&faults.vibration);
        }
    }

    /// Returns the state of the diagnosis of shaft motion; [`DiagnosisState::NotMade`] outside live operation.
    pub(super) fn diagnosis_state(&self) -> DiagnosisState {
        self.running_diagnosis.as_ref().map(RunningDiagnosis::state).unwrap_or_default()
    }
}
