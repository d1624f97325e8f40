//! The main job: a recording through the kernel and the twin, sample by sample, and what comes of it.

pub mod align;
pub mod baseline;
pub mod cascade;
pub mod comparison;
pub mod findings;
pub mod forces;
pub mod history;
pub mod innovation;
pub mod limits;
pub mod lines;
pub mod list;
pub mod locate;
pub mod notices;
pub mod outcome;
pub mod pictures;
pub mod plausibility;
pub mod pose;
pub mod range;
mod readings;
pub mod recent;
pub mod second;
mod session;
pub mod spectrum;
mod standstill;
mod startup;
pub mod statistics;
pub mod timing;
pub mod trend;

use crate::effect_significance;
use crate::error::UsageError;
use crate::observer::{Consistency, MOST_PROBES, Start, TunedObserver, Verdict, Watch, watch};
use crate::output::AtomicFile;
use crate::output::quoted;
use crate::plant::{MountedBearing, Plant, Twin, only_rigid};
use crate::recording::clock::check_rate;
use crate::recording::flaws::FlawSummary;
use crate::recording::rotation::Tracker;
use crate::recording::status::SampleStatus;
use crate::recording::{Reader, Row, Sample};
use crate::scene::{Probe, RotationSource, Scene, Speed};
use crate::vibration;
use anyhow::{Context, Result, bail};
use ballrace::rotor::{ComponentAngles, ShaftMotion};
use ballrace::{Displacement, Phase, Status};
use baseline::Baseline;
use comparison::{Angles, Comparison, SampleReadings};
use forces::{BearingSums, Evaluated, noise_band};
use innovation::Innovation;
use limits::LimitMonitor;
use locate::Locator;
use notices::Notices;
use outcome::{Outcome, Record};
use pictures::{Collector, Plane};
use plausibility::Counts;
use pose::PoseSolver;
use range::ReadingRange;
use readings::Readings;
use recent::Recent;
pub use recent::Snapshot;
use second::{Second, Seconds};
pub use session::{Replay, Update};
use standstill::{Measured, Standstill};
use startup::{Beginning, Search, Startup};
use statistics::Running;
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;
use timing::Ledger;

/// What the user asked of a replay.
#[derive(Default)]
pub struct Options<'a> {
    /// Where every sample's forces go.
    pub forces: Option<&'a Path>,
    /// Which forces those are.
    pub source: Source,
    /// Error of force that is good enough: an effect left out that matters more is warned of.
    pub error: Option<f64>,
    /// A baseline to judge against.
    pub baseline: Option<&'a Path>,
    /// For a machine that is watched while it runs: indicators of every second are kept for [`Replay::news`], and forces
    /// that no one asked for sample by sample are computed for [`LIVE_FORCE_RATE`] samples a second at most.
    pub watched: bool,
    /// Someone looks on: [`Replay::glance`] has something to show.
    pub viewed: bool,
    /// Called now and then with the bytes read and, when known, their total.
    pub progress: Option<&'a (dyn Fn(u64, Option<u64>) + Sync)>,
}

/// Where a force comes from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Source {
    /// Bearing model at the displacement estimated by the observer, free of probe noise.
    #[default]
    Observer,
    /// Bearing model at the displacement measured by the probes.
    Displacement,
}

/// Samples a second whose readings are weighed on a machine that is watched; a quarter of them enters the figures.
pub const LIVE_FORCE_RATE: f64 = 3200.0;
/// Of so many samples one has its noise band computed, after the first turns, which the pictures show.
const BANDED: u64 = 8;
/// Rows between two calls of the progress function.
const PROGRESS_ROWS: u64 = 4096;
/// Samples one after the other with a held twin after which it starts anew.
const TWIN_HELD_IN_A_ROW: u32 = 64;
/// Gaps longer than this many revolutions restart the twin.
const LONGEST_COAST_TURNS: f64 = 200.0;
/// Gaps longer than this many seconds restart the twin, where it does not take longer to settle.
const LONGEST_COAST: f64 = 2.0;

/// Replays `reader` through the scene's kernel and twin.
///
/// # Errors
/// A scene without rotor or recording, probes that do not determine the motion, a recording that cannot be used.
pub fn replay(scene: &Scene, mut reader: Reader, recording_name: &str, options: &Options) -> Result<Outcome> {
    let Some(recording) = &scene.recording else {
        bail!(UsageError(format!(
            "{}: [recording]: found none, allowed: the recording to replay",
            scene.path.display()
        )));
    };
    if !recording.sensors.is_empty() {
        return vibration::replay(scene, reader, recording_name, options);
    }
    check_rate(reader.rate(), recording, scene.shaft.speed).map_err(|e| e.of(scene, recording_name))?;
    let mut replay = Replay::try_new(scene, reader.rate(), options)?;
    let mut row = replay.blank();
    while reader.next_row(&mut row)? {
        replay.push(row)?;
        replay.work(None)?;
        row = replay.blank();
        if replay.rows % PROGRESS_ROWS == 0
            && let Some(progress) = options.progress
        {
            let (read, total) = reader.progress();
            progress(read, total);
        }
    }
    replay.finish(recording_name, reader.flaws().summary())
}

/// Everything that a replay carries from sample to sample.
struct Run<'a> {
    /// Speed that the scene states.
    scene_speed: Speed,
    probes: &'a [Probe],
    rows: Vec<[f64; 5]>,
    planes: Vec<Plane>,
    solver: PoseSolver,
    plant: Arc<Plant>,
    linear: Arc<Plant>,
    moving: Option<Moving>,
    tuned: Option<TunedObserver>,
    innovation: Innovation,
    guards: LimitMonitor,
    readings: Readings,
    standstill: Standstill,
    startup: Startup,
    /// The search for the start, until it runs.
    search: Option<Search>,
    /// Set to end the search without an observer, and the run-in of twins.
    cancelled: Arc<AtomicBool>,
    /// Twins that are run in for the next sample.
    beginning: Option<Beginning>,
    /// Those that are run in.
    begun: Option<[Box<dyn Twin>; 2]>,
    /// Samples that wait for the twin.
    queue: VecDeque<Queued>,
    watched: bool,
    /// s, removed from every sample's shaft angle.
    lag: f64,
    comparison: Comparison,
    bearings: Vec<BearingSums>,
    collector: Collector,
    locator: Option<Locator>,
    ledger: Ledger,
    forces: Option<ForcesFile>,
    baseline: Option<Baseline>,
    speed: Running,
    first_time: f64,
    last_time: f64,
    turns: f64,
    rate: f64,
    notes: Vec<String>,
    twin_held: u64,
    /// Gaps that restarted the twin, and the line after the first.
    restarts: (u64, u64),
    /// Time of the last restart of a held twin, s.
    twin_restarted: f64,
    range: ReadingRange,
    counts: Counts,
    notices: Notices,
    seconds: Option<Seconds>,
    recent: Option<Recent>,
    ended_seconds: Vec<Second>,
    /// Of so many samples one has the forces of its readings computed ...
    weighed: u64,
    /// ... and of so many, a multiple of that, all its forces.
    thorough: u64,
    buffers: Buffers,
}

/// Reused every sample.
#[derive(Default)]
struct Buffers {
    /// Readings, NaN where missing or out of range.
    readings: Vec<f64>,
    /// NaN for every probe.
    nothing: Vec<f64>,
    twin: Vec<f64>,
    linear: Vec<f64>,
    planes: Vec<f64>,
    evaluated: Vec<Evaluated>,
}

/// What waits for the twin.
enum Queued {
    Sample(Sample),
    /// The shaft angle begins anew: the twin restarts with the next sample.
    Restart,
}

/// What the first sample starts.
struct Moving {
    twin: Box<dyn Twin>,
    linear: Box<dyn Twin>,
    watch: Option<(Box<dyn Watch>, Consistency)>,
    /// Samples one after the other in which the twin was held.
    held: u32,
    cages: Vec<Phase>,
    /// Angles of all parts of each bearing.
    parts: Vec<ComponentAngles>,
    drive: ShaftMotion<f64>,
    index: u64,
}

/// From one sample to the next.
struct SampleInterval {
    /// The shaft at the earlier one.
    from: ShaftMotion<f64>,
    /// Sample periods between them; more than 1 over a gap.
    steps: u64,
    /// Revolutions between them.
    arc: f64,
    /// Twin and observer start anew at the later one.
    restarted: bool,
}

impl SampleInterval {
    /// The drive at the start of each period.
    fn drives(&self, period: f64) -> impl Iterator<Item = ShaftMotion<f64>> {
        let from = self.from;
        (0..self.steps).map(move |i| from.after(i as f64 * period))
    }

    /// A bearing's parts after the way, which ends at the shaft angle `end`.
    fn parts(&self, parts: ComponentAngles, seat: &MountedBearing, end: Phase) -> ComponentAngles {
        if self.steps > 1 {
            let gone = seat.kinematics.parts_at(self.arc);
            return ComponentAngles {
                cage: parts.cage.wrapping_add(gone.cage),
                ball: parts.ball.wrapping_add(gone.ball),
                outer: parts.outer.wrapping_add(gone.outer),
            };
        }
        seat.kinematics.speed_ratios().advance(parts, end.since(self.from.angle))
    }
}

struct ForcesFile {
    file: AtomicFile,
    path: String,
    source: Source,
}

impl ForcesFile {
    fn create(path: &Path, source: Source, seats: &[MountedBearing]) -> Result<Self> {
        let mut file = Self { file: AtomicFile::create(path)?, path: path.display().to_string(), source };
        let mut head = "time_s".to_owned();
        for seat in seats {
            for entry in ["FX_N", "FY_N", "FZ_N", "MX_Nm", "MY_Nm"] {
                head += ",";
                head += &quoted(&format!("{}_{entry}", seat.name));
            }
        }
        file.line(format_args!("{head},status\n"))?;
        Ok(file)
    }

    fn line(&mut self, text: std::fmt::Arguments) -> Result<()> {
        self.file.write_fmt(text).with_context(|| format!("{}: this file cannot be written", self.path))
    }

    fn add(&mut self, time: f64, forces: &[Evaluated], status: SampleStatus) -> Result<()> {
        self.line(format_args!("{time:.9}"))?;
        let observed = self.source == Source::Observer;
        let status = if observed { status } else { status.without(SampleStatus::FROM_DISPLACEMENT) };
        let force = |f: &Evaluated| if observed { f.estimated } else { f.measured };
        for entry in forces.iter().flat_map(force) {
            self.line(format_args!(",{entry:.9e}"))?;
        }
        self.line(format_args!(",{}\n", status.bits()))
    }
}

impl<'a> Run<'a> {
    fn try_new(scene: &Scene, probes: &'a [Probe], rate: f64, options: &Options) -> Result<Self> {
        only_rigid(scene, "replay")?;
        let plant = Plant::try_new(scene)?;
        let mut notes = plant.notes.clone();
        notes.extend(effect_significance::describe(
            &effect_significance::at_rest(scene, &plant)?,
            options.error.unwrap_or(effect_significance::GOOD_ENOUGH),
        ));
        let linear = Arc::new(plant.linearised(&vec![true; plant.bearings.len()])?);
        let plant = Arc::new(plant);
        let rows: Vec<[f64; 5]> = probes.iter().map(pose::row).collect();
        let cancelled = Arc::new(AtomicBool::new(false));
        let search = Search {
            plant: plant.clone(),
            linear: linear.clone(),
            rows: rows.clone(),
            noise: probes.iter().map(|p| p.noise).collect(),
            period: 1.0 / rate,
            speed: scene.shaft.speed,
            process_noise: scene.observer.process_noise,
            cancelled: cancelled.clone(),
        };
        let names: Vec<String> = probes.iter().map(|p| p.column.clone()).collect();
        let stations: Vec<f64> = plant.bearings.iter().map(|s| s.station).collect();
        let solver = PoseSolver::try_new(probes, &stations).with_context(|| scene.path.display().to_string())?;
        let planes = pictures::planes(probes);
        let sparing = options.watched && options.forces.is_none();
        let weighed = if sparing { (rate / LIVE_FORCE_RATE).ceil() as u64 } else { 1 };
        let baseline = options.baseline.map(|path| Baseline::read(path, probes, &plant.bearings)).transpose()?;
        let guards = LimitMonitor::try_new(&scene.limits, probes, &plant.bearings, baseline.as_ref())?;
        let forces =
            options.forces.map(|path| ForcesFile::create(path, options.source, &plant.bearings)).transpose()?;
        let range = ReadingRange::try_new(scene, &plant, probes)?;
        Ok(Self {
            scene_speed: scene.shaft.speed,
            range,
            counts: Counts::default(),
            notices: Notices::default(),
            twin_restarted: f64::NEG_INFINITY,
            probes,
            rows,
            comparison: Comparison::new(probes.len(), &plant.bearings, planes.len()),
            collector: Collector::new(probes, planes.clone(), &plant.bearings, rate, scene.shaft.speed),
            bearings: plant.bearings.iter().map(|s| BearingSums::new(s.elements)).collect(),
            locator: Locator::new(&plant),
            planes,
            solver,
            notes,
            linear,
            moving: None,
            tuned: None,
            innovation: Innovation::default(),
            guards,
            readings: Readings::new(names.clone(), options.watched),
            standstill: Standstill::default(),
            startup: Startup::Collecting,
            search: Some(search),
            cancelled,
            beginning: None,
            begun: None,
            queue: VecDeque::new(),
            watched: options.watched,
            lag: 0.0,
            ledger: Ledger::try_new(1.0 / rate)?,
            forces,
            baseline,
            speed: Running::default(),
            first_time: 0.0,
            last_time: 0.0,
            turns: 0.0,
            rate,
            twin_held: 0,
            restarts: (0, 0),
            recent: options.viewed.then(Recent::default),
            seconds: options.watched.then(|| {
                let bearings = plant.bearings.iter().map(|s| s.name.clone()).collect();
                Seconds::new(names, bearings)
            }),
            plant,
            ended_seconds: Vec::new(),
            weighed,
            thorough: weighed * if sparing { 4 } else { 1 },
            buffers: Buffers::default(),
        })
    }

    /// Evaluates the readings of a sample, queues it for the twin, and starts the search for the start as soon as it can.
    fn take(&mut self, mut sample: Sample) -> Result<()> {
        self.check(&mut sample);
        self.readings.add(&sample, &mut self.guards);
        let enough = match (&self.startup, self.queue.front()) {
            (Startup::Collecting, Some(Queued::Sample(first))) => startup::is_enough(first, &sample),
            _ => false,
        };
        self.queue.push_back(Queued::Sample(sample));
        if enough { self.begin_search() } else { Ok(()) }
    }

    /// Checks the readings against their range.
    fn check(&mut self, sample: &mut Sample) {
        let status = self.range.check(&mut sample.row);
        if status != SampleStatus::default() {
            let count = self.range.count();
            self.notices.add("reading-out-of-range", sample.row.time, || {
                format!("A reading is farther from zero than the bearings allow; {count} so far. It is left out.")
            });
        }
        if sample.status.has(SampleStatus::ANGLE_NOT_MEASURED) {
            self.notices.add("angle-not-measured", sample.row.time, || {
                "The shaft speed is out of range; the speed before it is held.".to_owned()
            });
        }
        sample.status = sample.status.and(status);
    }

    /// Copies a sample without the readings out of range, for the start of twin and observer.
    fn without_outliers(&self, sample: &Sample) -> Sample {
        let mut copy = sample.clone();
        self.range.within(&sample.row.probes, &mut copy.row.probes);
        copy
    }

    /// Searches the start from the queued samples: on its own thread where the machine is watched, else at once.
    fn begin_search(&mut self) -> Result<()> {
        let Some(search) = self.search.take() else { return Ok(()) };
        let sample = |queued: &Queued| match queued {
            Queued::Sample(sample) => Some(self.without_outliers(sample)),
            Queued::Restart => None,
        };
        let samples: Vec<Sample> = self.queue.iter().take(align::MOST_SAMPLES).map_while(sample).collect();
        if self.watched {
            self.startup = Startup::Searching(search.spawn(samples)?);
        } else {
            let started = search.run(&samples)?;
            self.started(started);
        }
        Ok(())
    }

    fn started(&mut self, started: startup::Started) {
        self.lag = started.lag;
        self.tuned = started.tuned;
        self.startup = Startup::Done;
        if self.cancelled.load(Ordering::Relaxed) && self.tuned.is_none() {
            self.notes.push(
                "Stopped before the observer was found: forces at the observer's position are those at the twin's."
                    .to_owned(),
            );
        } else if self.tuned.is_none() {
            self.notes.push(
                "No observer: probes and bearings do not hold every coordinate of the rotor, so there is no steady Kalman filter (an axial probe or an axial stiffness is missing). Forces come from the displacement that the probes show.".to_owned(),
            );
        }
    }

    /// No sample follows: the samples so far have to do for the start.
    fn end(&mut self) -> Result<()> {
        if matches!(self.startup, Startup::Collecting) && !self.queue.is_empty() { self.begin_search() } else { Ok(()) }
    }

    /// Passes queued samples to the twin until `deadline`, or all of them; `recycle` takes back their rows.
    fn work(&mut self, deadline: Option<Instant>, mut recycle: impl FnMut(Row)) -> Result<()> {
        let search = match std::mem::replace(&mut self.startup, Startup::Collecting) {
            Startup::Searching(search) if deadline.is_none() || search.is_finished() => Some(search),
            other => {
                self.startup = other;
                None
            }
        };
        if let Some(search) = search {
            let started = startup::joined(search)?;
            self.started(started);
        }
        if !matches!(self.startup, Startup::Done) {
            return Ok(());
        }
        while self.is_run_in(deadline)?
            && let Some(queued) = self.queue.pop_front()
        {
            match queued {
                Queued::Restart => self.moving = None,
                Queued::Sample(sample) => {
                    let sample = align::shifted(sample, self.lag);
                    self.sample(&sample)?;
                    recycle(sample.row);
                }
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return Ok(());
            }
        }
        if self.beginning.is_none() {
            self.readings.hand_over();
        }
        Ok(())
    }

    /// Runs twins in where the next sample starts them; returns true where nothing is left to do before that sample.
    fn is_run_in(&mut self, deadline: Option<Instant>) -> Result<bool> {
        let Some(Queued::Sample(next)) = self.queue.front() else { return Ok(true) };
        if self.begun.is_some() || !self.starts_at(next.row.index) {
            return Ok(true);
        }
        let mut beginning = match self.beginning.take() {
            Some(beginning) => beginning,
            None => {
                let sample = align::shifted(next.clone(), self.lag);
                Beginning::try_new([self.plant.clone(), self.linear.clone()], 1.0 / self.rate, &sample)?
            }
        };
        if self.cancelled.load(Ordering::Relaxed) {
            self.begun = Some(beginning.at_rest()?);
            self.notes.push(
                "Stopped before the twin was run in: its motion begins at rest, so residuals hold its transient."
                    .to_owned(),
            );
            return Ok(true);
        }
        if !beginning.advance(deadline) {
            self.beginning = Some(beginning);
            return Ok(false);
        }
        self.begun = Some(beginning.settled());
        Ok(true)
    }

    /// Twins start at this sample: there are none, or the gap before it is too long.
    fn starts_at(&self, index: u64) -> bool {
        let Some(moving) = &self.moving else { return true };
        let steps = index.saturating_sub(moving.index) as f64;
        let coasted = moving.drive.speed * steps / self.rate / TAU;
        let longest = self.plant.settling_time().max(LONGEST_COAST) * self.rate;
        coasted.abs() > LONGEST_COAST_TURNS || steps > longest
    }

    /// The shaft angle begins anew with the next sample.
    fn restart(&mut self) {
        self.readings.restart();
        match self.startup {
            Startup::Collecting => self.queue.clear(),
            Startup::Searching(_) | Startup::Done => self.queue.push_back(Queued::Restart),
        }
    }

    /// The start is searched for, or the twin is run in.
    const fn is_starting(&self) -> bool {
        matches!(self.startup, Startup::Searching(_)) || self.beginning.is_some()
    }

    /// No sample waits for the twin.
    fn is_idle(&self) -> bool {
        self.queue.is_empty() && !self.is_starting()
    }

    fn sample(&mut self, sample: &Sample) -> Result<()> {
        let drive = drive(sample);
        let way = self.way(sample, &drive)?;
        self.ledger.sample(sample.row.time);
        let begun = Instant::now();
        let Some(moving) = &mut self.moving else { return Ok(()) };
        let mut status = sample.status.and(SampleStatus::RESTARTED.when(way.restarted));
        self.range.within(&sample.row.probes, &mut self.buffers.readings);
        let readings = self.buffers.readings.as_slice();
        let mut left = way.steps;
        for now in way.drives(1.0 / self.rate) {
            let held = moving.twin.step(&now).is_held();
            self.twin_held += u64::from(held);
            moving.held = if held { moving.held + 1 } else { 0 };
            left -= 1;
            let Some((watch, consistency)) = &mut moving.watch else { continue };
            let missing = [f64::NAN; MOST_PROBES];
            let heard = if left == 0 { readings } else { &missing };
            watch.set_gate(consistency.gate());
            let (nis, flags) = watch.sample(&now, heard);
            status = status.and(flags.into());
            if left > 0 || readings.iter().any(|y| y.is_nan()) {
                continue;
            }
            let estimate = watch.pose();
            let possible = !flags.contains(Status::INPUT_NOT_FINITE)
                && self.range.allows(self.rows.iter().map(|row| pose::reading(row, &estimate)), estimate.w);
            let was_trusted = consistency.is_trusted();
            let verdict = consistency.sample(nis, possible);
            let bounded = consistency.bounded(nis);
            self.innovation.add(bounded, flags, verdict);
            if let Some(seconds) = &mut self.seconds {
                seconds.add_innovation(bounded);
            }
            if verdict == Verdict::Restart {
                let twin = moving.twin.pose();
                watch.restart(&self.solver.pose(readings, twin.w), &moving.twin.rate());
                status = status.and(SampleStatus::RESTARTED);
            }
            if was_trusted && verdict != Verdict::Trusted {
                let (ratio, restarts) = (consistency.ratio(), self.innovation.restarts());
                self.notices.add("observer-not-consistent", sample.row.time, || {
                    format!("The observer does not describe the motion: normalised innovation squared {ratio:.1} times what is expected, {restarts} restarts so far. Forces come from the displacement.")
                });
            }
        }
        let trusted = moving.watch.as_ref().filter(|(_, consistency)| consistency.is_trusted());
        if let Some((watch, _)) = trusted {
            self.innovation.add_load(watch.load());
        }
        status = status
            .and(SampleStatus::FROM_DISPLACEMENT.when(trusted.is_none()))
            .and(SampleStatus::TWIN_HELD.when(moving.held > 0));
        for ((parts, cage), seat) in moving.parts.iter_mut().zip(&mut moving.cages).zip(&self.plant.bearings) {
            *parts = way.parts(*parts, seat, sample.angle);
            *cage = parts.cage;
        }
        let twin_pose = moving.twin.pose();
        let likely = trusted.map(|(watch, _)| watch.pose());
        // Not a number where any reading is missing: the kernel then holds its last force and says so.
        let pose = self.solver.pose(&self.buffers.readings, twin_pose.w);
        self.buffers.evaluated.clear();
        let others = (sample.row.index.is_multiple_of(self.thorough)).then_some((&twin_pose, likely.as_ref()));
        let seats = if sample.row.index.is_multiple_of(self.weighed) { self.plant.bearings.as_slice() } else { &[] };
        for ((seat, sums), &parts) in seats.iter().zip(&mut self.bearings).zip(&moving.parts) {
            let at = seat.rotation(parts, &drive);
            let evaluated = sums.evaluate(seat, &pose, others, &at);
            status = status.and(evaluated.status.into());
            self.buffers.evaluated.push(evaluated);
        }
        self.ledger.worked(begun);
        for now in way.drives(1.0 / self.rate) {
            moving.linear.step(&now);
        }
        (moving.drive, moving.index) = (drive, sample.row.index);
        let stuck = moving.held >= TWIN_HELD_IN_A_ROW;
        self.counts.add(status, sample.speed, self.scene_speed);
        self.compare(sample, &pose, &twin_pose, way.arc, status)?;
        // As long as its run-in takes, the twin is not restarted again: work stays bounded where it overflows at once.
        if stuck && sample.row.time - self.twin_restarted > 1.0 + self.plant.settling_time() {
            self.twin_restarted = sample.row.time;
            self.moving = None;
            self.notes.push(format!("The twin's motion overflowed; it started anew after line {}.", sample.row.line));
            self.notices.add("twin-restarted", sample.row.time, || {
                "The motion of the twin overflowed; it started anew.".to_owned()
            });
        }
        Ok(())
    }

    /// The way from the last sample to this one. Starts the twin where there is none, or after too long a gap.
    fn way(&mut self, sample: &Sample, drive: &ShaftMotion<f64>) -> Result<SampleInterval> {
        if self.starts_at(sample.row.index) {
            let here = SampleInterval { from: *drive, steps: 0, arc: 0.0, restarted: self.has_begun() };
            let restarts = self.moving.is_some();
            self.moving = Some(self.begin(sample, drive)?);
            if restarts {
                let (count, line) = self.restarts;
                self.restarts = (count + 1, if count == 0 { sample.row.line } else { line });
            }
            return Ok(here);
        }
        let Some(moving) = &self.moving else { bail!("the twin has not started") };
        let steps = sample.row.index.saturating_sub(moving.index);
        let coasted = moving.drive.speed * steps as f64 / self.rate / TAU;
        // Over one period the angle's own difference; over a gap the whole turns between come from the speed.
        let fraction = drive.angle.since(moving.drive.angle).radians::<f64>() / TAU;
        Ok(SampleInterval { from: moving.drive, steps, arc: fraction + (coasted - fraction).round(), restarted: false })
    }

    /// A sample was worked on.
    fn has_begun(&self) -> bool {
        self.speed.count() > 0.0
    }

    /// Twin and cages at a sample with nothing before it.
    fn begin(&mut self, sample: &Sample, drive: &ShaftMotion<f64>) -> Result<Moving> {
        let revolutions = total_turns(sample);
        let period = 1.0 / self.rate;
        let [twin, linear] = self.begun.take().context("the twin is not run in")?;
        let watch = |tuned: &TunedObserver| {
            let probes = self.probes.len();
            let (start, consistency) = match self.has_begun() {
                false => (tuned.start, Consistency::new(probes)),
                true => (Start::of(twin.as_ref()), Consistency::restarted(probes)),
            };
            watch(&self.plant, &self.rows, &tuned.gains, start, sample, period).map(|watch| (watch, consistency))
        };
        Ok(Moving {
            watch: self.tuned.as_ref().map(watch).transpose()?,
            twin,
            linear,
            cages: self.plant.bearings.iter().map(|s| s.kinematics.parts_at(revolutions).cage).collect(),
            parts: self.plant.bearings.iter().map(|s| s.kinematics.parts_at(revolutions)).collect(),
            drive: *drive,
            index: sample.row.index,
            held: 0,
        })
    }

    fn compare(
        &mut self,
        sample: &Sample,
        pose: &Displacement<f64>,
        twin_pose: &Displacement<f64>,
        arc: f64,
        status: SampleStatus,
    ) -> Result<()> {
        let Some(moving) = &self.moving else { return Ok(()) };
        let buffers = &mut self.buffers;
        // Nothing is judged at an extrapolated angle, except on a machine that is watched, whose limits stay in force.
        let judged = self.seconds.is_some() || !status.has(SampleStatus::ANGLE_NOT_MEASURED);
        buffers.nothing.resize(sample.row.probes.len(), f64::NAN);
        let measured = if judged { &sample.row.probes } else { &buffers.nothing };
        let readings = |q: &Displacement<f64>, into: &mut Vec<f64>| {
            into.clear();
            into.extend(self.rows.iter().map(|row| pose::reading(row, q)));
        };
        readings(twin_pose, &mut buffers.twin);
        readings(&moving.linear.pose(), &mut buffers.linear);
        buffers.planes.clear();
        for values in [measured, &buffers.twin] {
            buffers.planes.extend(self.planes.iter().flat_map(|p| <[f64; 2]>::from(p.xy(values))));
        }
        let seen = SampleReadings { measured, twin: &buffers.twin, linear: &buffers.linear, planes: &buffers.planes };
        let angles = Angles { shaft: sample.angle, cages: &moving.cages, arc };
        if !seen.measured.iter().any(|y| y.is_nan()) {
            self.guards.add_residuals(sample.row.index, sample.row.time, seen.measured, seen.twin);
        }
        if let Some(seconds) = &mut self.seconds {
            seconds.add_status(status);
        }
        if let Some(seconds) = self.seconds.as_mut().filter(|_| !seen.measured.iter().any(|y| y.is_nan())) {
            self.ended_seconds.extend(seconds.add(sample, seen.twin, self.comparison.lines.block(0)));
        }
        // After a restart, blocks begin where those of the limits go on.
        let (index, time) = (sample.row.index, sample.row.time);
        if self.guards.are_residuals_due(index) && self.comparison.add(&seen, angles) {
            let comparison = &self.comparison;
            self.guards.close_residuals(index, time, |line, probe| comparison.block_line(line, probe));
        }
        let is_held = buffers.evaluated.iter().any(|e| e.status.is_held());
        if let Some(locator) = self.locator.as_mut().filter(|_| !is_held) {
            locator.add(&self.plant, pose, &buffers.evaluated, angles, sample.speed);
        }
        self.collector.add(sample, &buffers.twin, arc);
        if let Some(recent) = &mut self.recent {
            let passed = arc != 0.0 && sample.angle.revolutions() < arc.abs();
            recent.add(seen.measured, seen.twin, passed);
        }
        if sample.row.index.is_multiple_of(self.thorough) {
            self.weigh(sample, [pose, twin_pose]);
        }
        if let Some(file) = &mut self.forces {
            file.add(sample.row.time, &self.buffers.evaluated, status)?;
        }
        if self.speed.count() == 0.0 {
            self.first_time = sample.row.time;
        }
        self.last_time = sample.row.time;
        self.turns += arc;
        self.speed.add(sample.speed);
        Ok(())
    }

    fn glance(&self) -> Option<Snapshot> {
        let (recent, moving) = (self.recent.as_ref()?, self.moving.as_ref()?);
        let trusted = moving.watch.as_ref().filter(|(_, consistency)| consistency.is_trusted());
        let pose = trusted.map_or_else(|| moving.twin.pose(), |(watch, _)| watch.pose());
        let loads = self.plant.bearings.iter().zip(&moving.parts).map(|(seat, &parts)| {
            let at = seat.rotation(parts, &moving.drive);
            (seat.name.clone(), forces::loads(seat, &pose, &at))
        });
        let name = |plane: &Plane| plane.probes.map(|i| self.probes[i].column.as_str()).join(" / ");
        Some(Snapshot {
            time_s: self.last_time,
            speed_rpm: moving.drive.speed * 60.0 / TAU,
            rate_hz: self.rate,
            samples: recent.samples.iter().cloned().collect(),
            planes: self.planes.iter().map(|plane| (name(plane), plane.clone())).collect(),
            loads: loads.collect(),
            lines: pictures::marked_lines(&self.plant.bearings, moving.drive.speed.abs() / TAU),
        })
    }

    /// The bearings' forces into sums and pictures.
    fn weigh(&mut self, sample: &Sample, [pose, twin_pose]: [&Displacement<f64>; 2]) {
        let Some(moving) = &self.moving else { return };
        let banded = sample.row.index.is_multiple_of(BANDED) || self.collector.shows_forces();
        for (i, (seat, sums)) in self.plant.bearings.iter().zip(&mut self.bearings).enumerate() {
            let (force, cage) = (&mut self.buffers.evaluated[i], moving.cages[i]);
            let at = seat.rotation(moving.parts[i], &moving.drive);
            if banded
                && !force.status.is_held()
                && let Some(sigma) = noise_band(seat, &self.solver, self.probes, pose, &at)
            {
                force.sigma = sigma;
            }
            let first_load = sums.add(seat, force, [pose, twin_pose], &at);
            self.collector.add_force(i, sample.row.time, force, seat, cage, first_load);
            if let Some(seconds) = &mut self.seconds {
                seconds.add_force(i, force);
            }
        }
    }

    fn finish(
        mut self,
        scene: &Scene,
        recording: &str,
        rows: u64,
        angle_source: String,
        mut flaws: Vec<FlawSummary>,
    ) -> Result<Outcome> {
        flaws.extend(self.range.flaws().summary());
        if let Some(forces) = self.forces.take() {
            forces.file.finish()?;
        }
        if self.speed.count() == 0.0 {
            return self.finish_at_standstill(scene, recording, rows, angle_source, flaws);
        }
        self.comparison.finish();
        let speed_hz = self.speed.mean().abs() / TAU;
        let mut probes = self.comparison.outcomes(self.probes, &self.plant.bearings, speed_hz);
        let evidence = findings::Evidence {
            probes: self.probes,
            seats: &self.plant.bearings,
            comparison: &self.comparison,
            locator: self.locator.as_ref(),
            baseline: self.baseline.as_ref(),
            speed_hz,
            rate: self.rate,
        };
        let implausible = plausibility::implausible(&plausibility::Evidence {
            counts: &self.counts,
            rotation: scene.recording.as_ref().map_or(&RotationSource::Scene, |r| &r.rotation),
            scene_speed: scene.shaft.speed,
            mean_speed: self.speed.mean(),
            range: &self.range,
            probes: &probes,
            bearings: &self.bearings,
            seats: &self.plant.bearings,
        });
        let not_judged = self.counts.not_judged(self.comparison.compared);
        let is_judged = implausible.is_empty() && not_judged.is_empty();
        let findings = if is_judged { findings::findings(&evidence) } else { vec![] };
        let learned = Baseline::learn(&scene.name, recording, &self.comparison, self.probes, &self.plant.bearings);
        self.explain();
        let observer = self.tuned.as_ref().and_then(|tuned| self.innovation.outcome(tuned));
        self.notes.extend(observer.as_ref().map(innovation::words));
        let limits = self.guards.lines();
        let events = self.guards.finish();
        self.notes.extend(events.iter().map(|event| event.sentence.clone()));
        let mut pictures =
            self.collector.finish(&self.comparison, &self.bearings, &self.plant.bearings, self.rate, speed_hz);
        pictures.clearances = list::clearances(scene, &self.planes);
        pictures.limits = limits;
        let record = Record {
            load: scene.rotor.as_ref().map_or([0.0; 5], |rotor| rotor.load),
            spectra: self.comparison.spectra.settings(self.rate),
            ..record(
                &self.speed,
                rows,
                self.comparison.compared,
                self.rate,
                self.last_time - self.first_time,
                self.turns,
                angle_source,
            )
        };
        list::fill(&mut probes, &pictures.blocks, record.speed_changes());
        Ok(Outcome {
            scene: scene.name.clone(),
            recording: recording.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            verdict: findings::verdict(&findings, &probes, &implausible, &not_judged, self.counts.out_of_range()),
            implausible,
            not_judged,
            record,
            planes: list::planes(&self.planes, &pictures, self.speed.mean().signum()),
            observation: self.solver.observation.clone(),
            probes,
            bearings: self.bearings.iter().zip(&self.plant.bearings).map(|(b, s)| b.outcome(s)).collect(),
            timing: self.ledger.finish(),
            observer,
            findings,
            events,
            flaws,
            notes: self.notes,
            learned,
            pictures,
        })
    }

    /// The report of a recording in which no sample has a shaft angle.
    ///
    /// # Errors
    /// A recording without a sample.
    fn finish_at_standstill(
        self,
        scene: &Scene,
        recording: &str,
        rows: u64,
        angle_source: String,
        flaws: Vec<FlawSummary>,
    ) -> Result<Outcome> {
        if self.standstill.samples() == 0 {
            bail!("{recording}: no sample, expected at least one revolution of the shaft");
        }
        let outcome = self.standstill.outcome(Measured {
            probes: self.probes,
            bearings: self.bearings.iter().zip(&self.plant.bearings).map(|(b, s)| b.outcome(s)).collect(),
            observation: self.solver.observation.clone(),
            rows,
            rate: self.rate,
            angle_source,
            load: scene.rotor.as_ref().map_or([0.0; 5], |rotor| rotor.load),
            timing: self.ledger.finish(),
        });
        let events = self.guards.finish();
        let (implausible, not_judged) = (&outcome.implausible, &outcome.not_judged);
        let mut notes = outcome.notes;
        notes.extend(self.notes);
        notes.extend(events.iter().map(|event| event.sentence.clone()));
        Ok(Outcome {
            scene: scene.name.clone(),
            recording: recording.to_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            verdict: findings::verdict(&[], &[], implausible, not_judged, 0),
            events,
            flaws,
            notes,
            ..outcome
        })
    }

    /// Adds a sample that has no shaft angle.
    fn set_aside(&mut self, row: &mut Row) {
        self.range.check(row);
        self.standstill.add(row);
        if !self.watched {
            // A monitor may stand still for hours; in a file, the keyphasor may as well be dead.
            self.counts.add_without_angle();
        }
    }

    /// What the reader of the report should know besides.
    fn explain(&mut self) {
        self.notes.extend(self.standstill.note());
        let (slow, fast) = self.speed.extremes();
        if (fast - slow).abs() > 0.05 * self.speed.mean().abs() {
            self.notes.push(
                "The speed changes by more than 5 %: spectra in Hz smear; 1X and ball-pass figures follow the shaft and do not.".to_owned(),
            );
        }
        if self.lag != 0.0 {
            self.notes.push(format!(
                "Lag removed: {:.1} us ({:.2} samples), within the keyphasor's resolution; found from the first turns.",
                self.lag * 1e6,
                self.lag * self.rate
            ));
        }
        if !self.solver.observation.supplied_by_twin.is_empty() {
            self.notes.push("No axial probe: the axial position behind the measured forces is the twin's.".to_owned());
        }
        if self.probes.iter().any(|p| p.noise.is_none()) {
            self.notes.push(
                "Not every probe has its noise in the scene (noise = \"0.03 um\"): forces come without a noise band."
                    .to_owned(),
            );
        }
        match self.restarts {
            (0, _) => {}
            (1, line) => self.notes.push(format!("The twin restarted after the gap before line {line}.")),
            (count, line) => {
                self.notes.push(format!("The twin restarted after {count} gaps, the first before line {line}."));
            }
        }
        if self.twin_held > 0 {
            self.notes.push(format!("The twin's motion overflowed and was held for {} samples.", self.twin_held));
        }
        if self.comparison.compared == 0 {
            self.notes
                .push("No sample has a reading of every probe: no force and no spectrum could be computed.".to_owned());
        }
    }
}

fn drive(sample: &Sample) -> ShaftMotion<f64> {
    ShaftMotion { angle: sample.angle, speed: sample.speed, acceleration: sample.acceleration }
}

fn total_turns(sample: &Sample) -> f64 {
    sample.revolution as f64 + sample.angle.revolutions()
}

fn record(
    speed: &Running,
    samples: u64,
    compared: u64,
    rate_hz: f64,
    duration_s: f64,
    turns: f64,
    angle_source: String,
) -> Record {
    let rpm = |w: f64| w * 60.0 / TAU;
    let (slow, fast) = speed.extremes();
    Record {
        samples,
        compared,
        rate_hz,
        duration_s,
        turns,
        mean_speed_rpm: rpm(speed.mean()),
        min_speed_rpm: rpm(slow),
        max_speed_rpm: rpm(fast),
        angle_source,
        ..Record::default()
    }
}

fn angle_source(rotation: &RotationSource, tracker: &Tracker) -> String {
    match rotation {
        RotationSource::Keyphasor { column, pulses_per_turn } => {
            format!("keyphasor in column {column}, {} pulses, {pulses_per_turn} per revolution", tracker.pulses())
        }
        RotationSource::SpeedColumn { column, .. } => format!("speed in column {column}, angle 0 at the first sample"),
        RotationSource::Scene => "the scene's shaft speed, angle 0 at the first sample".to_owned(),
    }
}
