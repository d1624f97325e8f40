//! A replay driven row by row: a file reader or a live source delivers the rows.

use super::conclusion::RecordingFacts;
use super::evaluate::Evaluator;
use super::follow::FollowedSample;
use super::limits::{LimitState, LimitStatus};
use super::notices::Notice;
use super::pipeline::Pipeline;
use super::readings::Reading;
use super::running_diagnosis::{DiagnosisState, FaultState};
use super::second::Second;
use super::snapshot::Snapshot;
use super::temperature::TemperatureMonitor;
use ballrace_base::parallel;
use ballrace_diagnosis::vibration;
use ballrace_diagnosis::{CageEstimate, DiagnosisResult};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::options::Options;
use ballrace_outcome::{Calibration, Diagnosis, Event, Implausibility, Learning, Outcome, ProbeReadings};
use ballrace_plant::error::{Error, ReplayError, Result};
use ballrace_plant::observer::CageTracker;
use ballrace_recording::Row;
use ballrace_recording::flaws::FlawSummary;
use ballrace_recording::rotation::{RotationError, Tracker};
use ballrace_recording::run_out::RunOut;
use ballrace_scene::{Recording, Scene};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time without a keyphasor pulse after which a shaft counts as standing still in live operation, s.
const LONGEST_PULSE_WAIT: f64 = 10.0;

/// A replay in progress: rows are added one by one, and the outcome is returned at the end.
pub struct Replay<'a> {
    scene: &'a Scene,
    input: Input<'a>,
    pipeline: Pipeline<'a>,
    evaluator: Evaluator<'a>,
}

/// Rows of a recording, which become samples with a shaft angle.
struct Input<'a> {
    scene: &'a Scene,
    tracker: Tracker,
    run_out: Option<Arc<RunOut>>,
    temperatures: Option<TemperatureMonitor>,
    rows: u64,
    /// Flaws of the shaft angle before its last interruption.
    flaws: Vec<FlawSummary>,
    has_ended: bool,
}

/// Readings and followed sample that [`Replay::run`] passes on together.
#[derive(Default)]
struct Step {
    /// Readings since the last sample, where there are limits.
    readings: Vec<Reading<'static>>,
    followed: FollowedSample,
    /// False at the end of a recording.
    is_followed: bool,
}

/// Results since the last call of [`Replay::take_update`].
#[derive(Default)]
pub struct Update {
    /// Seconds that ended and that the twin has passed.
    pub seconds: Vec<Second>,
    /// Seconds that ended while the twin was starting, without its indicators.
    pub preliminary: Vec<Second>,
    /// Limits crossed (without an end) and crossings that ended.
    pub events: Vec<Event>,
    /// Rejected readings, restarts and other notices.
    pub notices: Vec<Notice>,
}

/// Adds the errors of the readings that a baseline has to those of a recording at slow roll.
pub(super) fn with_baseline(slow_roll: Option<Arc<RunOut>>, calibration: Option<&Calibration>) -> Option<Arc<RunOut>> {
    let readings = calibration.map(|calibration| calibration.readings.as_slice()).unwrap_or_default();
    with_errors(slow_roll, readings, "of the baseline")
}

/// Adds errors of the readings from a source to those of a recording at slow roll.
pub(super) fn with_errors(
    slow_roll: Option<Arc<RunOut>>,
    readings: &[ProbeReadings],
    source: &str,
) -> Option<Arc<RunOut>> {
    if readings.is_empty() {
        return slow_roll;
    }
    let errors = readings.iter().map(|one| (one.column.as_str(), one.gap, one.run_out.as_slice()));
    Some(Arc::new(RunOut::with_errors(slow_roll.as_deref(), errors, source)))
}

impl<'a> Replay<'a> {
    /// Creates a replay of samples at `rate`, Hz.
    ///
    /// # Errors
    /// A scene without rotor or recording, probes that do not determine the motion, a run-out that cannot be determined.
    pub fn try_new(scene: &'a Scene, rate: f64, options: &Options) -> Result<Self> {
        let recording = scene.recording.as_ref();
        let recording = recording.ok_or_else(|| ReplayError::NoRecording { file: scene.path.clone() })?;
        let baseline = options.baseline.map(Baseline::parse).transpose().map_err(Error::setup)?;
        let calibration = baseline.as_ref().and_then(|baseline| baseline.calibration.as_ref());
        let run_out = with_baseline(RunOut::of(scene)?, calibration);
        Self::with_run_out(scene, recording, rate, options, run_out)
    }

    /// Creates a replay with a run-out that is known already.
    pub(super) fn with_run_out(
        scene: &'a Scene,
        recording: &'a Recording,
        rate: f64,
        options: &Options,
        run_out: Option<Arc<RunOut>>,
    ) -> Result<Self> {
        vibration::check_bearings(scene, recording).map_err(Error::setup)?;
        let tracker = tracker(scene, recording, rate, options.live).with_run_out(run_out.clone());
        let rate = rate / f64::from(recording.average);
        let (mut pipeline, evaluator) = Pipeline::try_new(scene, recording, rate, options).map_err(Error::setup)?;
        pipeline.notes.extend(run_out.iter().flat_map(|run_out| run_out.notes().to_vec()));
        let temperatures = TemperatureMonitor::new(scene);
        let input = Input { scene, tracker, run_out, temperatures, rows: 0, flaws: vec![], has_ended: false };
        Ok(Self { scene, input, pipeline, evaluator })
    }

    /// Returns an empty row to read into.
    #[must_use]
    pub fn blank(&mut self) -> Row {
        self.input.tracker.blank()
    }

    /// Adds the next row: evaluates limits and indicators of readings and queues the samples for the twin.
    ///
    /// Samples of a shaft that stands still have no angle; angle, twin and observer restart with the next revolutions.
    ///
    /// # Errors
    /// A search that cannot be started.
    pub fn push(&mut self, row: Row) -> Result<()> {
        let Self { input, pipeline, evaluator, .. } = self;
        evaluator.timing.begin();
        input.push(row, pipeline, &mut |reading| evaluator.read(&reading))
    }

    /// Replays all rows that `next_row` reads: where there is another processor, samples are evaluated there while this one reads and
    /// follows the next ones. `next_row` returns false at the end.
    ///
    /// # Errors
    /// Those of `next_row`, a twin that cannot be started, an output that cannot be written.
    pub(super) fn run(&mut self, mut next_row: impl FnMut(&mut Row) -> Result<bool>) -> Result<()> {
        let Self { input, pipeline, evaluator, .. } = self;
        evaluator.timing.begin();
        let has_limits = !evaluator.limits.is_empty();
        let mut row = input.tracker.blank();
        // Boxed: an item passes through several queues.
        let first = |used: Option<Box<Step>>| {
            let mut step = used.unwrap_or_default();
            if step.is_followed {
                input.tracker.recycle(std::mem::take(&mut step.followed.sample.row));
            }
            let readings = &mut step.readings;
            readings.clear();
            let read = &mut |reading: Reading| {
                if has_limits || matches!(reading, Reading::WithoutAngle) {
                    readings.push(reading.into_owned());
                }
            };
            loop {
                step.is_followed = pipeline.next(None, &mut step.followed)?;
                if step.is_followed {
                    return Ok(Some(step));
                }
                if input.has_ended {
                    return Ok((!readings.is_empty()).then_some(step));
                }
                if next_row(&mut row)? {
                    let next = input.tracker.blank();
                    input.push(std::mem::replace(&mut row, next), pipeline, read)?;
                } else {
                    input.end(pipeline, read)?;
                }
            }
        };
        parallel::chain(first, |step| {
            step.readings.iter().for_each(|reading| evaluator.read(reading));
            if step.is_followed { evaluator.add(&mut step.followed) } else { Ok(()) }
        })
    }

    /// Processes the samples that wait for the twin until `deadline`; without a deadline it waits for the start of the twin and
    /// processes all of them.
    ///
    /// # Errors
    /// A twin that cannot be started, an output that cannot be written.
    pub fn work(&mut self, deadline: Option<Instant>) -> Result<()> {
        let tracker = &mut self.input.tracker;
        self.pipeline.work(&mut self.evaluator, deadline, |row| tracker.recycle(row))
    }

    /// Returns true once the twin has started.
    #[must_use]
    pub const fn has_started(&self) -> bool {
        self.pipeline.follower.startup.is_done() && self.pipeline.follower.twin.has_run()
    }

    /// Returns true during the search for the observer and the run-in of the twin.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        self.pipeline.follower.startup.is_starting()
    }

    /// Returns true where no sample waits for the twin.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.waiting() == 0 && !self.is_searching()
    }

    /// Returns the number of samples that wait for the twin.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.pipeline.follower.startup.waiting()
    }

    /// Cancels the search for the observer and the run-in of the twin: it starts without an observer, at rest.
    pub fn cancel_search(&self) {
        self.pipeline.follower.startup.cancel();
    }

    /// Discards the samples that wait for the twin; their readings have been evaluated.
    pub fn discard_waiting(&mut self) {
        self.pipeline.discard_waiting();
    }

    /// Ends the recording: the samples that wait for the shaft angle are evaluated and queued.
    ///
    /// # Errors
    /// A search that cannot be started.
    pub fn end(&mut self) -> Result<()> {
        let Self { input, pipeline, evaluator, .. } = self;
        input.end(pipeline, &mut |reading| evaluator.read(&reading))
    }

    /// Returns the present state for a live display; empty without [`Options::viewed`].
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        self.pipeline.snapshot(&self.evaluator).unwrap_or_default()
    }

    /// Returns the faults that the last diagnoses found, each once, strongest first.
    #[must_use]
    pub fn diagnoses(&self) -> Vec<Diagnosis> {
        self.pipeline.diagnoses()
    }

    /// Returns the state of the diagnosis.
    #[must_use]
    pub fn diagnosis_state(&self) -> DiagnosisState {
        self.pipeline.diagnosis_state()
    }

    /// Returns the present value of every limited indicator.
    #[must_use]
    pub fn limit_status(&self) -> Vec<LimitStatus> {
        self.evaluator.limits.status()
    }

    /// Returns the faults of the last diagnoses, from which another process can continue.
    #[must_use]
    pub fn fault_state(&self) -> FaultState {
        self.pipeline.faults()
    }

    /// Continues with the faults of an earlier process: a fault that is still found is not reported as a new one.
    pub fn restore_faults(&mut self, faults: &FaultState) {
        self.pipeline.restore_faults(faults);
    }

    /// Returns the results since the last call.
    pub fn take_update(&mut self) -> Update {
        let preliminary = self.pipeline.take_preliminary(&mut self.evaluator);
        Update {
            seconds: self.pipeline.take_ended_seconds(&mut self.evaluator),
            preliminary,
            events: self.evaluator.limits.take_events(),
            notices: self.pipeline.take_notices(&mut self.evaluator),
        }
    }

    /// Continues with the limits in the state of an earlier process.
    pub fn restore_limits(&mut self, state: &LimitState) {
        self.evaluator.limits.restore(state);
    }

    /// Returns the state of the limits after the events that [`Replay::take_update`] returned.
    #[must_use]
    pub fn limit_state(&self) -> Option<LimitState> {
        self.evaluator.limits.state()
    }

    /// Sets the diagnosis of the whole recording, where it is already known; else the last block is diagnosed at the end.
    pub(super) fn set_diagnosis(&mut self, diagnosis: DiagnosisResult) {
        self.pipeline.ahead.diagnosed = Some(diagnosis);
        self.evaluator.block = None;
    }

    /// Follows the cages from the angles of the scene, where a diagnosis has found them: beyond the samples of that diagnosis, whose
    /// estimate is the better one within them.
    pub(super) fn follow_cages(&mut self, cages: &[CageEstimate]) {
        let can_be_followed = |b: usize| self.scene.bearings.get(b).is_some_and(CageTracker::can_follow);
        let observable = cages.iter().enumerate().filter(|(_, cage)| cage.observable);
        for b in observable.map(|(b, _)| b).filter(|b| can_be_followed(*b)).collect::<Vec<_>>() {
            self.pipeline.follower.cages.follow(b);
        }
    }

    /// Adds the time of calibration and diagnosis before the first sample.
    pub(super) fn add_diagnosis_time(&mut self, took: Duration) {
        self.evaluator.timing.diagnosed(took);
    }

    /// Sets the calibration of the scene, for the baseline of the outcome, with a note on its assumptions.
    pub(super) fn set_calibration(&mut self, calibration: Option<Calibration>, note: Option<String>) {
        self.pipeline.ahead.calibration = calibration;
        self.pipeline.notes.extend(note);
    }

    /// Sets the learned parameters of the outcome.
    pub(super) fn set_learning(&mut self, learning: Option<Learning>) {
        self.pipeline.ahead.learning = learning;
    }

    /// Notes the checks of the first samples that failed and that a forced diagnosis overrides.
    pub(super) fn override_checks(&mut self, implausible: Vec<Implausibility>) {
        self.pipeline.ahead.overridden = implausible;
    }

    /// Adds notes to those of the outcome.
    pub(super) fn add_notes(&mut self, notes: Vec<String>) {
        self.pipeline.notes.extend(notes);
    }

    /// Ends the recording and returns the outcome. `flaws` are those that the reader found.
    ///
    /// # Errors
    /// Nothing to compare, an output that cannot be written.
    pub fn finish(mut self, name: &str, mut flaws: Vec<FlawSummary>) -> Result<Outcome> {
        self.end()?;
        self.work(None)?;
        let Self { scene, mut input, mut pipeline, evaluator } = self;
        flaws.append(&mut input.flaws);
        flaws.extend(input.tracker.flaws().summary());
        pipeline.notes.extend(input.temperatures.iter().flat_map(|monitor| monitor.notes(scene)));
        let angle_source = input.tracker.source();
        let is_run_out_subtracted = input.run_out.is_some();
        let facts = RecordingFacts { name, rows: input.rows, angle_source, is_run_out_subtracted, flaws };
        pipeline.conclude(evaluator, scene, facts)
    }
}

impl Input<'_> {
    /// Adds the next row, as [`Replay::push`]; what it reads is passed to `read`.
    fn push(&mut self, row: Row, pipeline: &mut Pipeline, read: &mut dyn FnMut(Reading)) -> Result<()> {
        self.rows += 1;
        let time = row.time;
        pipeline.push_sensors(&row);
        if let Some(temperatures) = &mut self.temperatures {
            temperatures.add(self.scene, &row);
        }
        let pushed = self.tracker.push(row);
        self.drain(pipeline, read)?;
        if let Err(error) = pushed {
            let sentence = || format!("{error}; the twin waits until it turns.");
            pipeline.notices.add("shaft-not-turning", time, sentence);
            self.push_without_angle(error, pipeline, read);
            self.restart(pipeline, read);
        }
        Ok(())
    }

    /// Adds the samples that wait for a shaft angle as samples without one.
    fn push_without_angle(&mut self, reason: RotationError, pipeline: &mut Pipeline, read: &mut dyn FnMut(Reading)) {
        while let Some(mut row) = self.tracker.abandon() {
            pipeline.push_without_angle(&mut row, read);
            self.tracker.recycle(row);
        }
        pipeline.standstill.explain(reason);
    }

    fn drain(&mut self, pipeline: &mut Pipeline, read: &mut dyn FnMut(Reading)) -> Result<()> {
        while let Some(sample) = self.tracker.pop() {
            pipeline.push(sample, read)?;
        }
        Ok(())
    }

    /// Ends the recording, as [`Replay::end`].
    fn end(&mut self, pipeline: &mut Pipeline, read: &mut dyn FnMut(Reading)) -> Result<()> {
        if std::mem::replace(&mut self.has_ended, true) {
            return Ok(());
        }
        let finished = self.tracker.finish();
        self.drain(pipeline, read)?;
        if let Err(error) = finished {
            self.push_without_angle(error, pipeline, read);
        }
        pipeline.end()
    }

    /// Restarts angle, twin and observer.
    fn restart(&mut self, pipeline: &mut Pipeline, read: &mut dyn FnMut(Reading)) {
        if let Some(recording) = &self.scene.recording {
            let rate = pipeline.rate * f64::from(recording.average);
            self.flaws.extend(self.tracker.flaws().summary());
            let tracker = tracker(self.scene, recording, rate, pipeline.live);
            self.tracker = tracker.with_run_out(self.run_out.clone());
        }
        pipeline.restart(read);
    }
}

/// Returns a tracker of the shaft angle. In live operation its memory is bounded while the shaft stands still.
fn tracker(scene: &Scene, recording: &Recording, rate: f64, live: bool) -> Tracker {
    let tracker = Tracker::of(recording, rate, scene.shaft.speed);
    if live { tracker.waiting_at_most((LONGEST_PULSE_WAIT * rate) as usize) } else { tracker }
}
