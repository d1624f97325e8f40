//! Twin, observer and cages follow a sample. What they need of each other from sample to sample is here.

use super::align::AlignmentStage;
use super::locate::LocationStage;
use super::notices::Notices;
use super::observe::ObserverStage;
use super::repeat::Spread;
use super::startup::{Queued, RunInProgress, SearchResult, Startup};
use super::timing::{Stage, StageClock, WorkClock};
use super::twin::{SampleInterval, TwinStage, TwinStart};
use ballrace::rotor::ComponentAngles;
use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_plant::error::Result;
use ballrace_plant::observer::CageTracker;
use ballrace_plant::{MAX_OBSERVED, Plant, Twin};
use ballrace_recording::status::SampleStatus;
use ballrace_recording::{Row, Sample};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Twin, observer and what starts them.
pub(super) struct Follower {
    plant: Arc<Plant>,
    /// Samples per second.
    rate: f64,
    /// The baseline was learned with a twin that starts each sample period at the state of the observer.
    is_baseline_synchronised: bool,
    pub(super) range: ReadingRange,
    pub(super) startup: Startup,
    pub(super) alignment: AlignmentStage,
    pub(super) twin: TwinStage,
    /// Difference of two twins where the scene does not determine their motion.
    pub(super) spread: Option<Spread>,
    pub(super) location: Arc<LocationStage>,
    pub(super) observer: ObserverStage,
    /// Angle and speed of the cages.
    pub(super) cages: CageTracker,
    /// Total revolutions at the last sample; none at first and after an interruption of the angle.
    last_turns: Option<f64>,
}

/// A sample that twin and observer have followed, and their motion there. Its memory is used again for later samples.
#[derive(Default)]
pub(super) struct FollowedSample {
    pub(super) sample: Sample,
    /// Interval since the last sample.
    pub(super) interval: SampleInterval,
    /// The twin on linear springs, where both twins start at this sample.
    pub(super) linear_start: Option<Box<dyn Twin>>,
    /// Flags of readings, angle, twin and observer.
    pub(super) status: SampleStatus,
    /// Normalised innovation squared; none where a reading is missing.
    pub(super) nis: Option<f64>,
    /// Time of twin and observer; none where the sample is not timed.
    pub(super) took: Option<Duration>,
    pub(super) clock: StageClock,
    /// Readings of the probes, NaN where missing or out of range.
    pub(super) readings: Vec<f64>,
    /// Coordinates of the twin.
    pub(super) twin: Vec<f64>,
    /// Coordinates of the observer; empty where it is not trusted.
    pub(super) observer: Vec<f64>,
    /// Coordinates and rates at the start of the interval where both twins were placed there, else empty.
    pub(super) placed: [Vec<f64>; 2],
    /// Angles of the parts of every bearing.
    pub(super) parts: Vec<ComponentAngles>,
}

impl Follower {
    pub(super) fn new(
        plant: Arc<Plant>,
        rate: f64,
        is_baseline_synchronised: bool,
        (range, startup): (ReadingRange, Startup),
        (location, rows): (Arc<LocationStage>, Vec<Vec<f64>>),
    ) -> Self {
        Self {
            twin: TwinStage::new(plant.clone(), rate),
            observer: ObserverStage::new(rows, !plant.layout.is_given()),
            cages: CageTracker::new(&plant),
            alignment: AlignmentStage::default(),
            spread: None,
            last_turns: None,
            rate,
            is_baseline_synchronised,
            range,
            startup,
            location,
            plant,
        }
    }

    /// Applies the result of the search.
    pub(super) fn start(&mut self, found: SearchResult, notes: &mut Vec<String>) {
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
            notes.push(note);
        }
        self.alignment = AlignmentStage::new(found.lag);
        self.spread = found.spread;
        self.observer.set_tuned(found.tuned);
    }

    /// Returns true where the twin starts each sample period at the state of the observer.
    pub(super) fn is_synchronised(&self) -> bool {
        (self.spread.is_some() || self.is_baseline_synchronised) && self.observer.is_tuned()
    }

    /// Runs the twin in where the next sample starts it; returns true where that sample can be processed.
    fn is_run_in(&mut self, deadline: Option<Instant>, notes: &mut Vec<String>) -> Result<bool> {
        if !self.startup.next_index().is_some_and(|index| self.twin.starts_at(index)) {
            return Ok(true);
        }
        let progress = self.startup.advance_run_in(&self.alignment, deadline)?;
        if matches!(progress, RunInProgress::Cancelled) {
            notes.push(
                "Stopped before the twin was run in: its motion begins at rest, so residuals hold its transient."
                    .to_owned(),
            );
        }
        Ok(!matches!(progress, RunInProgress::Unfinished))
    }

    /// Follows the next sample of the queue; returns false where no sample waits, or where the run-in before it is not finished at
    /// `deadline`.
    ///
    /// # Errors
    /// A twin or an observer that cannot be started.
    pub(super) fn next(
        &mut self,
        deadline: Option<Instant>,
        followed: &mut FollowedSample,
        (notices, notes): (&mut Notices, &mut Vec<String>),
    ) -> Result<bool> {
        loop {
            if !self.is_run_in(deadline, notes)? {
                return Ok(false);
            }
            match self.startup.pop() {
                None => return Ok(false),
                Some(Queued::Restart) => {
                    self.twin.stop();
                    self.cages.interrupt();
                    self.last_turns = None;
                }
                Some(Queued::Sample(sample)) => {
                    followed.sample = self.alignment.align(sample);
                    return self.follow(followed, notices, notes).map(|()| true);
                }
            }
        }
    }

    /// Advances twin, observer and cages to an aligned sample.
    fn follow(&mut self, followed: &mut FollowedSample, notices: &mut Notices, notes: &mut Vec<String>) -> Result<()> {
        let sample = &followed.sample;
        let interval = self.twin.interval(sample, || {
            let [twin, linear] = self.startup.take_settled()?;
            followed.linear_start = Some(linear);
            Ok(twin)
        })?;
        let turns = sample.total_revolutions();
        let last_turns = self.last_turns.replace(turns);
        if let Some(start) = interval.start {
            self.cages.advance(turns - last_turns.unwrap_or(turns), 0.0);
            self.twin.set_cage_offsets(self.cages.offsets());
            self.observer.start(&self.plant, &self.twin, start, sample, 1.0 / self.rate, &self.cages)?;
        }
        let mut clock = StageClock::of(sample.row.index);
        self.range.within(&sample.row.probes, &mut followed.readings);
        followed.placed.iter_mut().for_each(Vec::clear);
        if self.is_synchronised()
            && let Some((coordinates, rates)) = self.observer.state()
        {
            self.twin.place(coordinates, rates);
            followed.placed[0].extend_from_slice(coordinates);
            followed.placed[1].extend_from_slice(rates);
        }
        let work = WorkClock::of(sample.row.index);
        self.twin.advance(sample, &interval);
        clock.passed(Stage::Twin);
        let observed = self.observer.advance(
            (sample, &followed.readings, &interval),
            &self.twin,
            &self.range,
            &self.location,
            notices,
            &mut self.cages,
        );
        self.twin.set_cage_offsets(self.cages.offsets());
        clock.passed(Stage::Observer);
        let is_restart = interval.start == Some(TwinStart::Restart);
        followed.status = sample
            .status
            .and(SampleStatus::RESTARTED.when(is_restart))
            .and(SampleStatus::TWIN_HELD.when(self.twin.is_held()))
            .and(observed.status);
        (followed.interval, followed.nis) = (interval, observed.nis);
        self.store(followed);
        followed.took = work.elapsed();
        clock.passed(Stage::Forces);
        followed.clock = clock;
        let Row { time, line, .. } = followed.sample.row;
        if self.twin.stop_if_stuck(time) {
            notes.push(format!("The twin's motion overflowed; it restarted after line {line}."));
            notices.add("twin-restarted", time, || "The motion of the twin overflowed; it restarted.".to_owned());
        }
        Ok(())
    }

    /// Stores the motion at the current sample.
    fn store(&self, followed: &mut FollowedSample) {
        followed.twin.clear();
        followed.twin.extend_from_slice(self.twin.coordinates());
        followed.observer.clear();
        followed.observer.extend_from_slice(self.observer.coordinates().unwrap_or_default());
        followed.parts.clear();
        followed.parts.extend_from_slice(self.twin.parts());
    }
}
