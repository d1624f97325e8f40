//! The stages of a replay in the order in which a sample passes through them.

use super::align::AlignmentStage;
use super::comparison::{Comparison, SampleReadings};
use super::deflection::MeanDeflection;
use super::force::{Displacements, ForceStage, element_loads};
use super::forces_file::ForcesFile;
use super::limits::LimitMonitor;
use super::lines::{Angles, followed_orders};
use super::locate::LocationStage;
use super::notices::Notices;
use super::observe::ObserverStage;
use super::pictures::{FigureCollector, marked_lines, passes_keyphasor};
use super::plausibility::Counts;
use super::range::ReadingRange;
use super::readings::ReadingsStage;
use super::repeat::Spread;
use super::running_diagnosis::{DiagnosisState, FaultState, RunningDiagnosis};
use super::running_vibration::RunningVibration;
use super::second::{Second, SecondIndicators};
use super::snapshot::{RecentSamples, Snapshot};
use super::standstill::Standstill;
use super::startup::{Queued, RunInProgress, Search, SearchResult, Startup};
use super::timing::{Ledger, Stage};
use super::totals::Totals;
use super::twin::TwinStage;
use crate::diagnosis::DiagnosisResult;
use crate::diagnosis::block::Block;
use crate::effect_significance;
use crate::error::Result;
use crate::observer::CageTracker;
use crate::options::Options;
use crate::outcome::baseline::Baseline;
use crate::outcome::{Calibration, Diagnosis, Implausibility};
use crate::output::OutputError;
use crate::plant::{AXIAL, MAX_OBSERVED, Plant, only_observable, unbalance_note};
use crate::plausibility::Collector;
use crate::probes::{self, Plane};
use crate::recording::status::SampleStatus;
use crate::recording::{Row, Sample};
use crate::scene::{Probe, Recording, RotationSource, Scene};
use crate::vibration::join::join;
use crate::vibration::signals::Signals;
use std::error::Error as _;
use std::f64::consts::TAU;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// The stages of a replay.
pub(super) struct Pipeline<'a> {
    pub(super) plant: Arc<Plant>,
    pub(super) probes: &'a [Probe],
    pub(super) planes: Vec<Plane>,
    /// Reading of each probe per unit of each coordinate.
    rows: Vec<Vec<f64>>,
    /// Samples per second.
    pub(super) rate: f64,
    pub(super) live: bool,

    pub(super) range: ReadingRange,
    pub(super) readings: ReadingsStage,
    pub(super) startup: Startup,
    pub(super) alignment: AlignmentStage,
    pub(super) twin: TwinStage,
    /// Difference of two twins where the scene does not determine their motion.
    pub(super) spread: Option<Spread>,
    pub(super) location: LocationStage,
    pub(super) observer: ObserverStage,
    /// Angle and speed of the cages.
    pub(super) cages: CageTracker,
    /// Total revolutions at the last sample; none at first and after an interruption of the angle.
    last_turns: Option<f64>,
    pub(super) force: ForceStage,
    pub(super) comparison: Comparison,
    /// Samples for a diagnosis.
    pub(super) block: Block,
    /// Diagnosis of the whole recording, where it was made before.
    pub(super) diagnosed: Option<DiagnosisResult>,
    /// Diagnosis in live operation.
    pub(super) running_diagnosis: Option<RunningDiagnosis>,
    /// Calibration of the scene by this recording.
    pub(super) calibration: Option<Calibration>,
    /// Baseline for comparison.
    pub(super) baseline: Option<Baseline>,
    /// Signals of the vibration sensors; none without sensors, and in live operation.
    pub(super) signals: Option<Signals>,
    /// Vibration sensors in live operation.
    pub(super) vibration: Option<RunningVibration>,
    pub(super) figures: FigureCollector,
    /// Static line of a flexible rotor.
    pub(super) deflection: Option<MeanDeflection>,
    pub(super) limits: LimitMonitor,
    pub(super) seconds: Option<SecondIndicators>,
    recent: Option<RecentSamples>,
    pub(super) forces_file: Option<ForcesFile>,

    pub(super) standstill: Standstill,
    pub(super) counts: Counts,
    /// Figures for the checks of plausibility.
    pub(super) collected: Collector,
    /// An implausible recording is diagnosed too.
    pub(super) force_diagnosis: bool,
    /// Failed checks of the first samples that a forced diagnosis overrides.
    pub(super) overridden: Vec<Implausibility>,
    pub(super) totals: Totals,
    pub(super) timing: Ledger,
    pub(super) notices: Notices,
    pub(super) notes: Vec<String>,
    ended_seconds: Vec<Second>,
    /// Displacements of the bearings at the current sample, reused.
    displacements: Vec<Displacements>,
    /// Readings of the current sample, reused.
    sample_readings: SampleReadings,
}

/// A sample with the results of the stages up to the force.
struct ProcessedSample<'a> {
    sample: &'a Sample,
    status: SampleStatus,
    /// Revolutions since the last sample.
    revolutions: f64,
    displacements: Vec<Displacements>,
}

impl<'a> Pipeline<'a> {
    pub(super) fn try_new(scene: &Scene, recording: &'a Recording, rate: f64, options: &Options) -> Result<Self> {
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
        let names: Vec<String> = probes.iter().map(|p| p.column.clone()).collect();
        let planes = probes::planes(probes);
        let baseline = options
            .baseline
            .map(|path| Baseline::read(path, probes, &recording.sensors, &followed_orders(bearings)))
            .transpose()?;
        let limits = LimitMonitor::try_new(&scene.limits, probes, bearings, baseline.as_ref())?;
        let forces_file = options.forces.map(|path| ForcesFile::create(path, options.source, bearings)).transpose()?;
        let seconds = options
            .live
            .then(|| SecondIndicators::new(names.clone(), bearings.iter().map(|b| b.name.clone()).collect()));
        Ok(Self {
            range: ReadingRange::try_new(scene, &plant, probes)?,
            readings: ReadingsStage::new(names, options.live),
            startup: Startup::new(search, options.live),
            alignment: AlignmentStage::default(),
            twin: TwinStage::new(plant.clone(), rate),
            spread: None,
            location: LocationStage::try_new(scene, &plant, probes, rows.clone())?,
            observer: ObserverStage::new(rows.clone(), !plant.layout.is_given()),
            cages: CageTracker::new(&plant),
            last_turns: None,
            force: ForceStage::new(bearings, rate, options.live && options.forces.is_none()),
            comparison: Comparison::new(probes.len(), bearings, planes.clone()),
            block: Block::default(),
            diagnosed: None,
            running_diagnosis: options.live.then(|| {
                let (plant, force) = (plant.clone(), options.force_diagnosis);
                RunningDiagnosis::new(scene, plant, probes, 1.0 / rate, baseline.clone(), force)
            }),
            calibration: None,
            // Sensors keep the rate of the recording.
            vibration: if options.live {
                RunningVibration::new(scene, rate * f64::from(recording.average), baseline.as_ref())
            } else {
                None
            },
            signals: if options.live { None } else { Signals::new(recording, rate * f64::from(recording.average)) },
            baseline,
            deflection: MeanDeflection::new(&plant),
            figures: FigureCollector::new(probes, planes.clone(), bearings, rate, scene.shaft.speed),
            limits,
            seconds,
            recent: options.viewed.then(RecentSamples::default),
            forces_file,
            standstill: Standstill::default(),
            counts: Counts::default(),
            collected: Collector::new(recording, scene.shaft.speed),
            force_diagnosis: options.force_diagnosis,
            overridden: vec![],
            totals: Totals::default(),
            timing: Ledger::try_new(1.0 / rate)?,
            notices: Notices::default(),
            notes,
            ended_seconds: Vec::new(),
            displacements: Vec::new(),
            sample_readings: SampleReadings::default(),
            probes,
            planes,
            rows,
            rate,
            live: options.live,
            plant,
        })
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

    /// Checks a sample, evaluates its readings, and queues it for the twin.
    pub(super) fn push(&mut self, mut sample: Sample) -> Result<()> {
        self.collected.add_row(&sample.row);
        if let Some(signals) = &mut self.signals {
            signals.add_angle(&sample);
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.add_angle(&sample, &mut self.notices);
        }
        self.range.check_sample(&mut sample, &mut self.notices);
        self.collected.add_sample(&sample);
        self.readings.add(&sample, &mut self.limits);
        if let Some(found) = self.startup.push(sample, &self.range)? {
            self.start(found);
        }
        Ok(())
    }

    /// Adds a sample that has no shaft angle.
    pub(super) fn push_without_angle(&mut self, row: &mut Row) {
        self.collected.add_row(row);
        self.range.check(row);
        self.standstill.add(row);
        if !self.live {
            // A monitored shaft may stand still for hours; in a file, the keyphasor may have failed instead.
            self.counts.add_without_angle();
        }
    }

    /// Restarts the twin with the next sample, because the shaft angle is interrupted.
    pub(super) fn restart(&mut self) {
        if let Some(signals) = &mut self.signals {
            signals.interrupt();
        }
        if let Some(vibration) = &mut self.vibration {
            vibration.interrupt();
        }
        self.readings.restart(&mut self.limits);
        self.startup.restart();
    }

    /// Ends the recording: the start is searched in the samples so far.
    pub(super) fn end(&mut self) -> Result<()> {
        if let Some(found) = self.startup.end(&self.range)? {
            self.start(found);
        }
        Ok(())
    }

    /// Discards the samples that wait for the twin.
    pub(super) fn discard_waiting(&mut self) {
        let count = self.startup.discard();
        if count > 0 {
            let seconds = count as f64 / self.rate;
            self.notes.push(format!(
                "Stopped before the twin had processed the last {count} samples ({seconds:.1} s): they are not compared."
            ));
        }
    }

    /// Processes queued samples until `deadline`, or all of them; `recycle` takes back their rows.
    pub(super) fn work(&mut self, deadline: Option<Instant>, mut recycle: impl FnMut(Row)) -> Result<()> {
        if let Some(found) = self.startup.poll(deadline)? {
            self.start(found);
        }
        if !self.startup.is_done() {
            return Ok(());
        }
        while self.is_run_in(deadline)?
            && let Some(queued) = self.startup.pop()
        {
            match queued {
                Queued::Restart => {
                    self.twin.stop();
                    self.cages.interrupt();
                    self.last_turns = None;
                }
                Queued::Sample(sample) => {
                    let sample = self.alignment.align(sample);
                    self.process(&sample)?;
                    recycle(sample.row);
                }
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(());
            }
        }
        if !self.startup.is_running_in() {
            self.readings.stop_seconds();
        }
        Ok(())
    }

    /// Applies the result of the search.
    fn start(&mut self, found: SearchResult) {
        if found.tuned.is_none() {
            let order = self.plant.layout.order;
            let note = if self.startup.is_cancelled() {
                "Stopped before the observer was found: forces at the observer's position are those at the twin's."
                    .to_owned()
            } else if order > MAX_OBSERVED {
                format!(
                    "No observer: the system has {order} coordinates, more than {MAX_OBSERVED}. Forces come from the displacement that the probes show."
                )
            } else {
                "No observer: probes and bearings do not hold every coordinate of the rotor, so there is no steady Kalman filter. Forces come from the displacement that the probes show.".to_owned()
            };
            self.notes.push(note);
        }
        self.alignment = AlignmentStage::new(found.lag);
        self.spread = found.spread;
        self.observer.set_tuned(found.tuned);
    }

    /// Returns true where the twin starts each sample period at the state of the observer.
    pub(super) fn is_synchronised(&self) -> bool {
        let is_of_baseline = self.baseline.as_ref().is_some_and(|baseline| baseline.synchronised);
        (self.spread.is_some() || is_of_baseline) && self.observer.is_tuned()
    }

    /// Runs the twin in where the next sample starts it; returns true where that sample can be processed.
    fn is_run_in(&mut self, deadline: Option<Instant>) -> Result<bool> {
        if !self.startup.next_index().is_some_and(|index| self.twin.starts_at(index)) {
            return Ok(true);
        }
        let progress = self.startup.advance_run_in(&self.alignment, deadline)?;
        if matches!(progress, RunInProgress::Cancelled) {
            self.notes.push(
                "Stopped before the twin was run in: its motion begins at rest, so residuals hold its transient."
                    .to_owned(),
            );
        }
        Ok(!matches!(progress, RunInProgress::Unfinished))
    }

    /// Passes an aligned sample through the stages.
    fn process(&mut self, sample: &Sample) -> Result<()> {
        let (index, time) = (sample.row.index, sample.row.time);
        let interval = self.twin.interval(sample, || self.startup.take_settled())?;
        let turns = sample.total_revolutions();
        let last_turns = self.last_turns.replace(turns);
        if let Some(start) = interval.start {
            self.cages.advance(turns - last_turns.unwrap_or(turns), 0.0);
            self.twin.set_cage_offsets(self.cages.offsets());
            self.observer.start(&self.plant, &self.twin, start, sample, 1.0 / self.rate, &self.cages)?;
        }
        self.timing.sample(time);
        let begun = Instant::now();
        let mut clock = self.timing.stages_of(index);
        self.location.set_sample(&self.range, sample);
        if self.is_synchronised()
            && let Some((coordinates, rates)) = self.observer.state()
        {
            self.twin.place(coordinates, rates);
        }
        self.twin.advance(sample, &interval);
        self.timing.passed(Stage::Twin, &mut clock);
        let observed = self.observer.advance(
            (sample, &interval),
            &self.twin,
            &self.range,
            &self.location,
            &mut self.notices,
            &mut self.cages,
        );
        self.twin.set_cage_offsets(self.cages.offsets());
        self.timing.passed(Stage::Observer, &mut clock);
        let displacements = self.displaced();
        let shaft = sample.shaft_motion();
        let force = self.force.evaluate(index, &self.plant.bearings, self.twin.parts(), &shaft, &displacements);
        self.timing.worked(begun);
        self.timing.passed(Stage::Forces, &mut clock);
        self.twin.advance_linear(&interval);
        self.timing.passed(Stage::Twin, &mut clock);
        let is_restart = interval.start == Some(super::twin::TwinStart::Restart);
        if is_restart {
            self.comparison.lines.interrupt();
            self.limits.interrupt_residuals();
        }
        let status = sample
            .status
            .and(SampleStatus::RESTARTED.when(is_restart))
            .and(SampleStatus::TWIN_HELD.when(self.twin.is_held()))
            .and(observed.status)
            .and(force);
        self.counts.add(status);
        if let (Some(seconds), Some(nis)) = (&mut self.seconds, observed.nis) {
            seconds.add_innovation(nis);
        }
        // Samples with an extrapolated angle are not compared, except in live operation, where limits stay in force.
        let is_judged = self.seconds.is_some() || !status.has(SampleStatus::ANGLE_NOT_MEASURED);
        let readings = is_judged.then_some(sample.row.probes.as_slice());
        let twins = [self.twin.coordinates(), self.twin.linear_coordinates()];
        self.sample_readings.evaluate(readings, twins, &self.rows);
        let processed = ProcessedSample { sample, status, revolutions: interval.revolutions, displacements };
        self.compare(&processed);
        self.timing.passed(Stage::Comparison, &mut clock);
        self.record(&processed)?;
        self.timing.passed(Stage::Forces, &mut clock);
        self.displacements = processed.displacements;
        if self.twin.stop_if_stuck(time) {
            self.notes.push(format!("The twin's motion overflowed; it restarted after line {}.", sample.row.line));
            self.notices.add("twin-restarted", time, || "The motion of the twin overflowed; it restarted.".to_owned());
        }
        Ok(())
    }

    /// Returns the displacements of every bearing at the current sample.
    fn displaced(&mut self) -> Vec<Displacements> {
        let mut all = std::mem::take(&mut self.displacements);
        all.clear();
        let (twin, observer) = (self.twin.coordinates(), self.observer.coordinates());
        let axial = twin.get(AXIAL).copied().unwrap_or_default();
        let position = self.location.position(twin, axial);
        let of = |i: usize| Displacements {
            measured: position.at_bearing(&self.plant, i),
            twin: self.plant.displacement(i, twin),
            observer: observer.map(|q| self.plant.displacement(i, q)),
        };
        all.extend((0..self.plant.bearings.len()).map(of));
        all
    }

    /// Compares a sample with the twin, and evaluates indicators and limits.
    fn compare(&mut self, processed: &ProcessedSample) {
        let (sample, revolutions) = (processed.sample, processed.revolutions);
        let readings = &self.sample_readings;
        let (index, time) = (sample.row.index, sample.row.time);
        let angles = Angles { shaft: sample.angle, parts: self.twin.parts(), revolutions };
        if readings.is_complete() {
            self.limits.add_residuals(index, time, &readings.measured, &readings.twin);
        }
        if let Some(seconds) = &mut self.seconds {
            seconds.add_status(processed.status);
            if readings.is_complete() {
                self.ended_seconds.extend(seconds.add(sample, &readings.twin, self.comparison.one_x()));
            }
        }
        // After a restart of the process, blocks begin where those of the limits continue.
        if self.limits.are_residuals_due(index) && self.comparison.add(readings, angles) {
            let comparison = &self.comparison;
            self.limits.close_residuals(index, time, |line, probe| comparison.block_line(line, probe));
        }
        if self.diagnosed.is_none() {
            self.block.add(sample);
            if let Some(running) = &mut self.running_diagnosis {
                running.poll(&self.block, (time, sample.total_revolutions()), &mut self.cages, &mut self.notices);
            }
        }
        self.figures.add(sample, &readings.twin, revolutions);
        if let Some(deflection) = self.deflection.as_mut().filter(|_| readings.is_complete()) {
            deflection.add(self.twin.coordinates());
        }
        if let Some(recent) = &mut self.recent {
            recent.add(&readings.measured, &readings.twin, passes_keyphasor(sample, revolutions));
        }
    }

    /// Adds the forces of a sample to sums, figures and file.
    fn record(&mut self, processed: &ProcessedSample) -> Result<()> {
        let ProcessedSample { sample, displacements, .. } = processed;
        let (index, time) = (sample.row.index, sample.row.time);
        if self.force.is_reported(index) {
            let shaft = sample.shaft_motion();
            let with_noise = ForceStage::is_noise_band_due(index) || self.figures.shows_forces();
            let all = self.plant.bearings.iter().zip(self.twin.parts()).zip(displacements);
            for (i, ((bearing, &parts), displacements)) in all.enumerate() {
                let at = bearing.rotation(parts, &shaft);
                let noise =
                    with_noise.then_some((self.probes, |probe: usize| self.location.column(&self.plant, i, probe)));
                let Some((force, first_load)) = self.force.accumulate(i, bearing, displacements, &at, noise) else {
                    continue;
                };
                self.figures.add_force(i, time, force, bearing, parts.cage, first_load);
                if let Some(seconds) = &mut self.seconds {
                    seconds.add_force(i, force);
                }
            }
        }
        if let Some(file) = &mut self.forces_file
            && let Err(error) = file.add(time, self.force.evaluated(), processed.status)
        {
            self.drop_forces_file(error, time)?;
        }
        self.totals.add(time, sample.speed, processed.revolutions);
        Ok(())
    }

    /// Continues without the file of forces, which cannot be written, in live operation.
    ///
    /// # Errors
    /// `error` outside live operation.
    pub(super) fn drop_forces_file(&mut self, error: OutputError, time: f64) -> Result<()> {
        if !self.live {
            return Err(error.into());
        }
        self.forces_file = None;
        let reason = error.source().map_or_else(String::new, |source| format!(" ({source})"));
        let sentence = format!("{error}{reason}; the monitor continues without it.");
        self.notes.push(sentence.clone());
        self.notices.add_always("output-failing", time, sentence);
        Ok(())
    }

    /// Returns the seconds that ended since the last call.
    pub(super) fn take_ended_seconds(&mut self) -> Vec<Second> {
        let mut seconds = std::mem::take(&mut self.ended_seconds);
        if let Some(vibration) = &mut self.vibration {
            for second in &mut seconds {
                second.sensors = vibration.second(second.time_s);
                vibration.drop_seconds(second.time_s);
            }
        }
        seconds
    }

    /// Returns the seconds that ended since the last call while the twin was starting.
    pub(super) fn take_preliminary(&mut self) -> Vec<Second> {
        let mut seconds = self.readings.take_ended();
        if let Some(vibration) = &self.vibration {
            seconds.iter_mut().for_each(|second| second.sensors = vibration.second(second.time_s));
        }
        seconds
    }

    /// Returns the present state for a live display; none where no display is in use or the twin does not run.
    pub(super) fn snapshot(&self) -> Option<Snapshot> {
        let (recent, shaft) = (self.recent.as_ref()?, self.twin.shaft()?);
        let coordinates = self.observer.coordinates().unwrap_or_else(|| self.twin.coordinates());
        let loads = self.plant.bearings.iter().zip(self.twin.parts()).enumerate().map(|(i, (bearing, &parts))| {
            let displacement = self.plant.displacement(i, coordinates);
            (bearing.name.clone(), element_loads(bearing, &displacement, &bearing.rotation(parts, &shaft)))
        });
        let name = |plane: &Plane| plane.probes.map(|i| self.probes[i].column.as_str()).join(" / ");
        Some(Snapshot {
            time_s: self.totals.last_time,
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
