//! Start of the replay: a queue of samples, the search for lag and observer in the first revolutions, and the run-in of
//! the twin.
//!
//! The search takes seconds. In live operation it runs on its own thread; limits and indicators of readings do not depend on
//! it.

use super::align::{self, AlignmentStage};
use super::repeat::{Spread, run_in_twice};
use ballrace_diagnosis::plausibility::range::ReadingRange;
use ballrace_plant::error::{Error, ObserverError, ReplayError, Result};
use ballrace_plant::observer::{IdentificationData, InitialState, TunedObserver, identify, noise};
use ballrace_plant::{MAX_OBSERVED, Plant, RunIn, Twin};
use ballrace_recording::Sample;
use ballrace_scene::Speed;
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Items for which an empty queue keeps memory; a monitor that was behind for some seconds frees the rest.
const KEPT_ITEMS: usize = 1 << 12;

/// Samples that wait for the twin, and the state of its start.
pub(super) struct Startup {
    state: State,
    queue: VecDeque<Queued>,
    /// The scene's plant, and the same on linear springs.
    plants: [Arc<Plant>; 2],
    /// Sample period, s.
    period: f64,
    /// Run-in that is not finished.
    run_in: Option<RunInPair>,
    /// Twins that have completed their run-in for the next sample.
    settled: Option<[Box<dyn Twin>; 2]>,
    /// Set to end the search without an observer and the run-in at rest.
    cancelled: Arc<AtomicBool>,
    live: bool,
    /// Time of search and run-in on this thread.
    took: Duration,
}

enum State {
    /// The first revolutions are collected for the search.
    Collecting(Box<Search>),
    /// The search runs on its own thread.
    Searching(JoinHandle<Result<SearchResult>>),
    /// The twin follows the samples.
    Done,
}

/// Item of the queue.
pub(super) enum Queued {
    /// A sample for the twin.
    Sample(Sample),
    /// The shaft angle is interrupted: the twin restarts with the next sample.
    Restart,
}

/// Progress of the run-in before the next sample.
pub(super) enum RunInProgress {
    /// The next sample can be processed.
    Ready,
    /// The run-in was cancelled: the twin starts at rest.
    Cancelled,
    /// The deadline has passed before the end of the run-in.
    Unfinished,
}

impl Startup {
    pub(super) fn new(search: Search, live: bool) -> Self {
        Self {
            plants: [search.plant.clone(), search.linear.clone()],
            period: search.period,
            cancelled: search.cancelled.clone(),
            state: State::Collecting(Box::new(search)),
            queue: VecDeque::new(),
            run_in: None,
            settled: None,
            live,
            took: Duration::ZERO,
        }
    }

    /// Queues a sample and starts the search as soon as there are enough; returns the result of a search that is finished.
    pub(super) fn push(&mut self, sample: Sample, range: &ReadingRange) -> Result<Option<SearchResult>> {
        let is_enough = match (&self.state, self.queue.front()) {
            (State::Collecting(_), Some(Queued::Sample(first))) => is_enough(first, &sample),
            _ => false,
        };
        self.queue.push_back(Queued::Sample(sample));
        if is_enough { self.begin_search(range) } else { Ok(None) }
    }

    /// Ends the recording: the search starts with the samples so far.
    pub(super) fn end(&mut self, range: &ReadingRange) -> Result<Option<SearchResult>> {
        let is_waiting = matches!(self.state, State::Collecting(_)) && !self.queue.is_empty();
        if is_waiting { self.begin_search(range) } else { Ok(None) }
    }

    /// Searches in the queued samples: on its own thread in live operation, else at once.
    fn begin_search(&mut self, range: &ReadingRange) -> Result<Option<SearchResult>> {
        let sample = |queued: &Queued| match queued {
            Queued::Sample(sample) => {
                let mut copy = sample.clone();
                range.within(&sample.row.probes, &mut copy.row.probes);
                Some(copy)
            }
            Queued::Restart => None,
        };
        let samples: Vec<Sample> = self.queue.iter().take(align::MAX_SAMPLES).map_while(sample).collect();
        match std::mem::replace(&mut self.state, State::Done) {
            State::Collecting(search) if self.live => {
                self.state = State::Searching(search.spawn(samples)?);
                Ok(None)
            }
            State::Collecting(search) => {
                let begun = Instant::now();
                let found = search.run(&samples);
                self.took += begun.elapsed();
                found.map(Some)
            }
            other => {
                self.state = other;
                Ok(None)
            }
        }
    }

    /// Returns the result of a search on its own thread: once it is finished, without a deadline after waiting for it.
    pub(super) fn poll(&mut self, deadline: Option<Instant>) -> Result<Option<SearchResult>> {
        match std::mem::replace(&mut self.state, State::Done) {
            State::Searching(search) if deadline.is_none() || search.is_finished() => joined(search).map(Some),
            other => {
                self.state = other;
                Ok(None)
            }
        }
    }

    /// Returns the index of the sample at the front of the queue, where it is a sample.
    pub(super) fn next_index(&self) -> Option<u64> {
        match self.queue.front() {
            Some(Queued::Sample(next)) => Some(next.row.index),
            _ => None,
        }
    }

    /// Runs twins in for the sample at the front of the queue, until `deadline`.
    pub(super) fn advance_run_in(
        &mut self,
        alignment: &AlignmentStage,
        deadline: Option<Instant>,
    ) -> Result<RunInProgress> {
        let Some(Queued::Sample(next)) = self.queue.front() else { return Ok(RunInProgress::Ready) };
        if self.settled.is_some() {
            return Ok(RunInProgress::Ready);
        }
        let begun = Instant::now();
        let mut run_in = match self.run_in.take() {
            Some(run_in) => run_in,
            None => RunInPair::try_new(self.plants.clone(), self.period, &alignment.align(next.clone()))?,
        };
        if self.is_cancelled() {
            self.settled = Some(run_in.at_rest()?);
            return Ok(RunInProgress::Cancelled);
        }
        let is_complete = run_in.advance(deadline);
        self.took += begun.elapsed();
        if !is_complete {
            self.run_in = Some(run_in);
            return Ok(RunInProgress::Unfinished);
        }
        self.settled = Some(run_in.settled());
        Ok(RunInProgress::Ready)
    }

    /// Returns the twins that have completed their run-in.
    pub(super) fn take_settled(&mut self) -> Result<[Box<dyn Twin>; 2]> {
        Ok(self.settled.take().ok_or(ReplayError::NotRunIn)?)
    }

    /// Removes the item at the front of the queue.
    pub(super) fn pop(&mut self) -> Option<Queued> {
        let item = self.queue.pop_front();
        if self.queue.is_empty() && self.queue.capacity() > KEPT_ITEMS {
            self.queue.shrink_to(KEPT_ITEMS);
        }
        item
    }

    /// Removes all items of the queue and returns their number.
    pub(super) fn discard(&mut self) -> usize {
        self.run_in = None;
        let count = self.queue.len();
        self.queue.clear();
        count
    }

    /// Restarts the twin with the next sample.
    pub(super) fn restart(&mut self) {
        match self.state {
            State::Collecting(_) => self.queue.clear(),
            State::Searching(_) | State::Done => self.queue.push_back(Queued::Restart),
        }
    }

    /// Returns the number of items in the queue.
    pub(super) fn waiting(&self) -> usize {
        self.queue.len()
    }

    /// Returns the time of search and run-in on this thread.
    pub(super) const fn took(&self) -> Duration {
        self.took
    }

    /// Returns true where the search is finished.
    pub(super) const fn is_done(&self) -> bool {
        matches!(self.state, State::Done)
    }

    /// Returns true while the twin is run in.
    pub(super) const fn is_running_in(&self) -> bool {
        self.run_in.is_some()
    }

    /// Returns true during the search and the run-in.
    pub(super) const fn is_starting(&self) -> bool {
        matches!(self.state, State::Searching(_)) || self.is_running_in()
    }

    /// Cancels the search and the run-in.
    pub(super) fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns true where search and run-in are cancelled.
    pub(super) fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Result of the search.
pub(super) struct SearchResult {
    /// Lag of the keyphasor behind the motion, s.
    pub(super) lag: f64,
    /// The observer; none where the search was cancelled or where there is no steady filter.
    pub(super) tuned: Option<TunedObserver>,
    /// Difference of two twins where the scene does not determine their motion.
    pub(super) spread: Option<Spread>,
}

/// Inputs of the search.
pub(super) struct Search {
    pub(super) plant: Arc<Plant>,
    pub(super) linear: Arc<Plant>,
    /// Readings of each probe per unit of each coordinate.
    pub(super) rows: Vec<Vec<f64>>,
    /// Noise of each probe where the scene states it, m.
    pub(super) noise: Vec<Option<f64>>,
    /// Sample period, s.
    pub(super) period: f64,
    pub(super) speed: Speed,
    pub(super) process_noise: Option<f64>,
    /// The samples were taken in step with the shaft: there is no lag.
    pub(super) is_synchronous: bool,
    /// Set to end the search without an observer.
    pub(super) cancelled: Arc<AtomicBool>,
}

/// Returns true where the samples from `first` to `last` are enough for the search.
fn is_enough(first: &Sample, last: &Sample) -> bool {
    let turns = last.total_revolutions() - first.total_revolutions();
    turns.abs() >= align::TURNS || last.row.index - first.row.index + 1 >= align::MAX_SAMPLES as u64
}

impl Search {
    /// Finds lag and observer from the first samples.
    ///
    /// # Errors
    /// A machine that cannot be started, probes that no observer takes.
    fn run(&self, samples: &[Sample]) -> Result<SearchResult> {
        let mut found = SearchResult { lag: 0.0, tuned: None, spread: None };
        match self.find(samples, &mut found) {
            Err(Error::Observer(ObserverError::Cancelled)) => Ok(found),
            ended => ended.map(|()| found),
        }
    }

    fn find(&self, samples: &[Sample], found: &mut SearchResult) -> Result<()> {
        let Some(first) = samples.first() else { return Ok(()) };
        // A gap leaves fewer samples, never a longer time to integrate.
        let within = |sample: &&Sample| sample.row.index < first.row.index + align::MAX_SAMPLES as u64;
        let shifted =
            |lag| samples.iter().take_while(within).map(|s| align::shifted(s.clone(), lag)).collect::<Vec<_>>();
        let noise: Vec<f64> = self.noise.iter().enumerate().map(|(p, given)| noise(samples, p, *given)).collect();
        let (mut twin, spread) = run_in_twice(&self.plant, &self.rows, &noise, self.period, first, &self.cancelled)?;
        found.spread = spread;
        let mut guess = InitialState::new(twin.coordinates(), twin.rates());
        // The phase of a motion that does not repeat is no lag of the keyphasor.
        let passes = if self.is_synchronous || found.spread.is_some() { 0 } else { 2 };
        for pass in 0..passes {
            let shifted = shifted(found.lag);
            if pass > 0 {
                twin = self.run_in(&shifted[0])?;
            }
            let more = align::lag(&shifted, twin.as_mut(), &self.rows, self.period, &self.cancelled);
            self.check_cancelled()?;
            found.lag = (found.lag + more).clamp(-0.5 * self.period, 0.5 * self.period);
        }
        let shifted = shifted(found.lag);
        if found.lag != 0.0 {
            let twin = self.run_in(&shifted[0])?;
            guess = InitialState::new(twin.coordinates(), twin.rates());
        }
        found.tuned = self.tune(&shifted, guess, found.spread.is_none())?;
        Ok(())
    }

    /// Finds the observer under which the first samples are the most likely; `guess` is the state of the twin at the first of them.
    fn tune(&self, samples: &[Sample], guess: InitialState, repeats: bool) -> Result<Option<TunedObserver>> {
        if self.plant.layout.order > MAX_OBSERVED {
            return Ok(None);
        }
        let data = IdentificationData {
            samples,
            rows: &self.rows,
            given_noise: &self.noise,
            period: self.period,
            speed: self.speed,
            process_noise: self.process_noise,
            repeats,
            cancelled: &self.cancelled,
        };
        identify(&self.plant, &self.linear, &data, guess)
    }

    /// Runs the twin in up to a sample.
    fn run_in(&self, first: &Sample) -> Result<Box<dyn Twin>> {
        let mut run_in = RunIn::try_new(&self.plant, self.period, first.total_revolutions(), &first.shaft_motion())?;
        while run_in.advance() {
            self.check_cancelled()?;
        }
        Ok(run_in.into_twin())
    }

    fn check_cancelled(&self) -> Result<(), ObserverError> {
        if self.cancelled.load(Ordering::Relaxed) { Err(ObserverError::Cancelled) } else { Ok(()) }
    }

    /// Runs the search on its own thread.
    ///
    /// # Errors
    /// No thread can be started.
    fn spawn(self, samples: Vec<Sample>) -> Result<JoinHandle<Result<SearchResult>>> {
        let thread = std::thread::Builder::new().name("start".to_owned());
        Ok(thread.spawn(move || self.run(&samples))?)
    }
}

/// Returns the result of a finished search.
///
/// # Errors
/// Those of the search.
fn joined(search: JoinHandle<Result<SearchResult>>) -> Result<SearchResult> {
    search.join().unwrap_or_else(|_| Err(ReplayError::SearchPanicked.into()))
}

/// Two twins that are run in up to a sample, some steps at a time, so that a monitor does not wait for them.
struct RunInPair {
    plants: [Arc<Plant>; 2],
    /// On the scene's bearings and on linear springs.
    twins: [RunIn; 2],
    /// Sample period, s.
    period: f64,
    revolutions: f64,
}

impl RunInPair {
    /// Starts twins on both plants for a sample.
    ///
    /// # Errors
    /// A machine that cannot be started.
    fn try_new(plants: [Arc<Plant>; 2], period: f64, sample: &Sample) -> Result<Self> {
        let (revolutions, drive) = (sample.total_revolutions(), sample.shaft_motion());
        let [plant, linear] = plants.each_ref().map(|plant| RunIn::try_new(plant, period, revolutions, &drive));
        Ok(Self { twins: [plant?, linear?], plants, period, revolutions })
    }

    /// Advances the twins until the end of their run-in or until `deadline`; returns true at the end of the run-in.
    fn advance(&mut self, deadline: Option<Instant>) -> bool {
        loop {
            let [twin, linear] = &mut self.twins;
            if !(twin.advance() || linear.advance()) {
                return true;
            }
            if deadline.is_some_and(|deadline| Instant::now() >= deadline) {
                return false;
            }
        }
    }

    /// Returns the twins after their run-in.
    fn settled(self) -> [Box<dyn Twin>; 2] {
        self.twins.map(RunIn::into_twin)
    }

    /// Returns twins in static equilibrium instead of those that have not completed their run-in.
    ///
    /// # Errors
    /// A machine that cannot be started.
    fn at_rest(self) -> Result<[Box<dyn Twin>; 2]> {
        let [twin, linear] = self.plants.map(|plant| plant.start(self.period, self.revolutions));
        Ok([twin?, linear?])
    }
}
