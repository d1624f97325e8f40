//! Evaluator of a followed sample: forces, comparison, indicators, limits and figures. Nothing here acts back on twin and observer.

use super::comparison::{Comparison, SampleReadings};
use super::deflection::MeanDeflection;
use super::follow::FollowedSample;
use super::force::{Displacements, ForceStage};
use super::forces_file::ForcesFile;
use super::limits::LimitMonitor;
use super::lines::Angles;
use super::locate::LocationStage;
use super::notices::Notices;
use super::pictures::{FigureCollector, passes_keyphasor};
use super::plausibility::Counts;
use super::readings::{Reading, ReadingsStage};
use super::samples::SampleCollector;
use super::second::{Second, SecondIndicators};
use super::snapshot::RecentSamples;
use super::timing::{Ledger, Stage, WorkClock};
use super::totals::Totals;
use super::twin::TwinStart;
use ballrace::Displacement;
use ballrace_base::output::OutputError;
use ballrace_diagnosis::block::Block;
use ballrace_outcome::options::{Options, Source};
use ballrace_plant::error::Result;
use ballrace_plant::probes::{Plane, reading};
use ballrace_plant::{AXIAL, Plant, Twin};
use ballrace_recording::status::SampleStatus;
use ballrace_scene::{Probe, Scene};
use ballrace_studies::recorded_life::RecordedLife;
use std::error::Error as _;
use std::sync::Arc;

/// The stages behind twin and observer.
pub(super) struct Evaluator<'a> {
    plant: Arc<Plant>,
    probes: &'a [Probe],
    /// Reading of each probe per unit of each coordinate.
    rows: Vec<Vec<f64>>,
    /// Change of the displacement of each bearing per metre of the reading of each probe.
    columns: Vec<Vec<Displacement<f64>>>,
    live: bool,
    /// The rotor on linear springs, which the comparison has beside the twin.
    linear: Option<Box<dyn Twin>>,

    /// Limits and indicators of readings, before a sample waits for the twin.
    pub(super) readings: ReadingsStage,
    location: Arc<LocationStage>,
    /// Displacements of every bearing at the current sample; empty where no forces are due.
    displacements: Vec<Displacements>,
    pub(super) force: ForceStage,
    pub(super) comparison: Comparison,
    /// Samples for a diagnosis; none where the recording is diagnosed already.
    pub(super) block: Option<Block>,
    pub(super) figures: FigureCollector,
    /// Static line of a flexible rotor.
    pub(super) deflection: Option<MeanDeflection>,
    pub(super) limits: LimitMonitor,
    pub(super) seconds: Option<SecondIndicators>,
    pub(super) recent: Option<RecentSamples>,
    pub(super) forces_file: Option<ForcesFile>,
    pub(super) samples: Option<SampleCollector>,
    pub(super) counts: Counts,
    pub(super) totals: Totals,
    pub(super) timing: Ledger,
    pub(super) notices: Notices,
    pub(super) notes: Vec<String>,
    pub(super) ended_seconds: Vec<Second>,
    /// Readings of the current sample, reused.
    sample_readings: SampleReadings,
}

impl<'a> Evaluator<'a> {
    pub(super) fn try_new(
        scene: &Scene,
        plant: Arc<Plant>,
        (probes, planes): (&'a [Probe], &[Plane]),
        location: Arc<LocationStage>,
        limits: LimitMonitor,
        rate: f64,
        options: &Options,
    ) -> Result<Self> {
        let bearings = plant.bearings.as_slice();
        let is_straight = plant.layout.is_given() || plant.layout.is_straight();
        let source = if is_straight { Source::Displacement } else { Source::Observer };
        let forces_file = options.forces.map(|path| ForcesFile::create(path, options.source, bearings)).transpose()?;
        let lives = scene.bearings.iter().map(|of| RecordedLife::try_new(scene, of)).collect::<Result<_>>()?;
        let names = || probes.iter().map(|p| p.column.clone()).collect();
        let column = |bearing: usize| (0..probes.len()).map(|probe| location.column(&plant, bearing, probe)).collect();
        let columns = (0..bearings.len()).map(column).collect();
        Ok(Self {
            rows: probes.iter().map(|probe| plant.layout.probe_row(probe)).collect(),
            columns,
            live: options.live,
            linear: None,
            readings: ReadingsStage::new(names(), options.live),
            location,
            displacements: Vec::with_capacity(bearings.len()),
            force: ForceStage::new(bearings, lives, rate, is_straight, options.live && options.forces.is_none()),
            comparison: Comparison::new(probes.len(), bearings, planes.to_vec()),
            block: Some(Block::default()),
            deflection: MeanDeflection::new(&plant),
            figures: FigureCollector::new(probes, planes.to_vec(), (bearings, source), rate, scene.shaft.speed),
            limits,
            seconds: options
                .live
                .then(|| SecondIndicators::new(names(), bearings.iter().map(|b| b.name.clone()).collect())),
            recent: options.viewed.then(RecentSamples::default),
            forces_file,
            samples: options.samples.then(|| SampleCollector::new(probes, bearings, options.source)),
            counts: Counts::default(),
            totals: Totals::default(),
            timing: Ledger::try_new(1.0 / rate)?,
            notices: Notices::default(),
            notes: Vec::new(),
            ended_seconds: Vec::new(),
            sample_readings: SampleReadings::default(),
            probes,
            plant,
        })
    }

    /// Adds the next event of the recording, before a sample waits for the twin.
    pub(super) fn read(&mut self, reading: &Reading) {
        match reading {
            Reading::Sample(sample) => self.readings.add(sample, &mut self.limits),
            Reading::Restart => self.readings.restart(&mut self.limits),
            Reading::WithoutAngle => self.counts.add_without_angle(),
        }
    }

    /// Evaluates a sample that twin and observer have followed.
    ///
    /// # Errors
    /// A file of forces that cannot be written, outside live operation.
    pub(super) fn add(&mut self, followed: &mut FollowedSample) -> Result<()> {
        let linear_start = followed.linear_start.take();
        let followed = &*followed;
        let FollowedSample { sample, .. } = followed;
        let (index, time) = (sample.row.index, sample.row.time);
        self.timing.sample(time);
        let (work, mut clock) = (WorkClock::of(index), followed.clock.resumed());
        let shaft = sample.shaft_motion();
        self.locate(followed);
        let force = self.force.evaluate(index, &self.plant.bearings, &followed.parts, &shaft, &self.displacements);
        self.timing.worked([followed.took, work.elapsed()]);
        clock.passed(Stage::Forces);
        self.advance_linear(followed, linear_start);
        clock.passed(Stage::Twin);
        if followed.interval.start == Some(TwinStart::Restart) {
            self.comparison.lines.interrupt();
            self.limits.interrupt_residuals();
        }
        let status = followed.status.and(force);
        self.counts.add(status);
        if let (Some(seconds), Some(nis)) = (&mut self.seconds, followed.nis) {
            seconds.add_innovation(nis);
        }
        // Samples with an extrapolated angle are not compared, except in live operation, where limits stay in force.
        let is_judged = self.seconds.is_some() || !status.has(SampleStatus::ANGLE_NOT_MEASURED);
        let readings = is_judged.then_some(sample.row.probes.as_slice());
        let linear = self.linear.as_ref().map_or(&[][..], |linear| linear.coordinates());
        self.sample_readings.evaluate(readings, [&followed.twin, linear], &self.rows);
        self.compare(followed, status);
        clock.passed(Stage::Comparison);
        self.record(followed, status)?;
        clock.passed(Stage::Forces);
        self.timing.add(clock);
        Ok(())
    }

    /// Computes the displacements of every bearing at a sample; none where no forces are due.
    fn locate(&mut self, followed: &FollowedSample) {
        self.displacements.clear();
        let FollowedSample { sample, readings, twin, observer, .. } = followed;
        if !self.force.is_due(sample.row.index) {
            return;
        }
        let plant = &self.plant;
        let position = self.location.position(readings, twin, twin.get(AXIAL).copied().unwrap_or_default());
        let is_error_due = !self.force.is_straight() && ForceStage::is_noise_band_due(sample.row.index);
        let straight = is_error_due.then(|| {
            let readings: Vec<f64> = self.rows.iter().map(|row| reading(row, twin)).collect();
            self.location.position(&readings, twin, twin.get(AXIAL).copied().unwrap_or_default())
        });
        let of = |i: usize| Displacements {
            measured: position.at_bearing(plant, i),
            twin: plant.displacement(i, twin),
            observer: (!observer.is_empty()).then(|| plant.displacement(i, observer)),
            straightened: straight.as_ref().map(|line| line.at_bearing(plant, i)),
        };
        self.displacements.extend((0..plant.bearings.len()).map(of));
    }

    /// Advances the twin on linear springs to the sample, where it starts with `start`.
    fn advance_linear(&mut self, followed: &FollowedSample, start: Option<Box<dyn Twin>>) {
        if start.is_some() {
            self.linear = start;
        }
        let Some(linear) = &mut self.linear else { return };
        let [coordinates, rates] = &followed.placed;
        linear.place(coordinates, rates);
        for shaft in followed.interval.motion() {
            linear.step(&shaft);
        }
    }

    /// Compares a sample with the twin, and evaluates indicators and limits.
    fn compare(&mut self, followed: &FollowedSample, status: SampleStatus) {
        let FollowedSample { sample, interval, .. } = followed;
        let (revolutions, readings) = (interval.revolutions, &self.sample_readings);
        let (index, time) = (sample.row.index, sample.row.time);
        let angles = Angles { shaft: sample.angle, parts: &followed.parts, revolutions };
        if readings.is_complete() {
            self.limits.add_residuals(index, time, &readings.measured, &readings.twin);
        }
        if let Some(seconds) = &mut self.seconds {
            seconds.add_status(status);
            if readings.is_complete() {
                self.ended_seconds.extend(seconds.add(sample, &readings.twin, self.comparison.one_x()));
            }
        }
        // After a restart of the process, blocks begin where those of the limits continue.
        if self.limits.are_residuals_due(index) && self.comparison.add(readings, angles) {
            let comparison = &self.comparison;
            self.limits.close_residuals(index, time, |line, probe| comparison.block_line(line, probe));
        }
        if let Some(block) = &mut self.block {
            block.add(sample);
        }
        self.figures.add(sample, &readings.twin, revolutions);
        if let Some(deflection) = self.deflection.as_mut().filter(|_| readings.is_complete()) {
            deflection.add(&followed.twin);
        }
        if let Some(recent) = &mut self.recent {
            recent.add(&readings.measured, &readings.twin, passes_keyphasor(sample, revolutions));
        }
    }

    /// Adds the forces of a sample to sums, figures and file.
    fn record(&mut self, followed: &FollowedSample, status: SampleStatus) -> Result<()> {
        let FollowedSample { sample, .. } = followed;
        let (index, time) = (sample.row.index, sample.row.time);
        if self.force.is_reported(index) {
            let shaft = sample.shaft_motion();
            let with_noise = ForceStage::is_noise_band_due(index) || self.figures.shows_forces();
            let all = self.plant.bearings.iter().zip(&followed.parts).zip(&self.displacements).zip(&self.columns);
            for (i, (((bearing, &parts), displacements), columns)) in all.enumerate() {
                let at = bearing.rotation(parts, &shaft);
                if ForceStage::is_life_due(index) {
                    self.force.add_life(i, bearing, displacements, &at);
                }
                let noise = with_noise.then_some((self.probes, columns.as_slice()));
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
            && let Err(error) = file.add(time, self.force.evaluated(), status)
        {
            self.drop_forces_file(error, time)?;
        }
        if let Some(samples) = &mut self.samples {
            let bearings = (self.plant.bearings.as_slice(), self.displacements.as_slice(), self.force.evaluated());
            samples.add(followed, &self.sample_readings, bearings, status);
        }
        self.totals.add(time, sample.speed, followed.interval.revolutions);
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
}
