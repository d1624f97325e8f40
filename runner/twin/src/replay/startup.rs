//! Start of the twin: the keyphasor's lag and the observer, found from the first turns.
//!
//! The search takes seconds. On a machine that is watched it runs on its own thread; limits and indicators of readings do
//! not depend on it.

use super::{align, drive, total_turns};
use crate::observer::{Cancelled, IdentificationData, Start, TunedObserver, tuned};
use crate::plant::{Plant, RunIn, Twin};
use crate::recording::Sample;
use crate::scene::Speed;
use anyhow::{Result, bail};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Instant;

/// How far the start has come.
pub(super) enum Startup {
    /// The first turns are collected.
    Collecting,
    /// The search runs on its own thread.
    Searching(JoinHandle<Result<Started>>),
    /// The twin follows the samples.
    Done,
}

/// Result of the search.
pub(super) struct Started {
    /// Lag of the keyphasor behind the motion, s.
    pub(super) lag: f64,
    /// The observer; none where the search was cancelled or where there is no steady filter.
    pub(super) tuned: Option<TunedObserver>,
}

/// Inputs of the search.
pub(super) struct Search {
    pub(super) plant: Arc<Plant>,
    pub(super) linear: Arc<Plant>,
    /// Readings of each probe per unit of each coordinate.
    pub(super) rows: Vec<[f64; 5]>,
    /// Noise of each probe where the scene states it, m.
    pub(super) noise: Vec<Option<f64>>,
    /// Sample period, s.
    pub(super) period: f64,
    pub(super) speed: Speed,
    pub(super) process_noise: Option<f64>,
    /// Set to end the search without an observer.
    pub(super) cancelled: Arc<AtomicBool>,
}

/// Returns true where `first` to `last` are enough for the search.
pub(super) fn is_enough(first: &Sample, last: &Sample) -> bool {
    let turns = total_turns(last) - total_turns(first);
    turns.abs() >= align::TURNS || last.row.index - first.row.index + 1 >= align::MOST_SAMPLES as u64
}

impl Search {
    /// Finds lag and observer from the first samples.
    ///
    /// # Errors
    /// A machine that cannot be started, probes that no observer takes.
    pub(super) fn run(&self, samples: &[Sample]) -> Result<Started> {
        let mut lag = 0.0;
        match self.find(samples, &mut lag) {
            Err(error) if error.is::<Cancelled>() => Ok(Started { lag, tuned: None }),
            tuned => Ok(Started { lag, tuned: tuned? }),
        }
    }

    fn find(&self, samples: &[Sample], lag: &mut f64) -> Result<Option<TunedObserver>> {
        // A gap leaves fewer samples, never a longer time to integrate.
        let within = |sample: &&Sample| sample.row.index < samples[0].row.index + align::MOST_SAMPLES as u64;
        let shifted =
            |lag| samples.iter().take_while(within).map(|s| align::shifted(s.clone(), lag)).collect::<Vec<_>>();
        for _ in 0..2 {
            let shifted = shifted(*lag);
            let Some(first) = shifted.first() else { return Ok(None) };
            let mut twin = self.run_in(first)?;
            let more = align::lag(&shifted, twin.as_mut(), &self.rows, self.period, &self.cancelled);
            self.check_cancelled()?;
            *lag = (*lag + more).clamp(-0.5 * self.period, 0.5 * self.period);
        }
        self.tune(&shifted(*lag))
    }

    /// Finds the observer under which the first samples are the most likely.
    fn tune(&self, samples: &[Sample]) -> Result<Option<TunedObserver>> {
        let Some(first) = samples.first() else { return Ok(None) };
        let twin = self.run_in(first)?;
        let heard = IdentificationData {
            samples,
            rows: &self.rows,
            given_noise: &self.noise,
            period: self.period,
            speed: self.speed,
            wander: self.process_noise,
            cancelled: &self.cancelled,
        };
        tuned(&self.plant, &self.linear, &heard, Start::of(twin.as_ref()))
    }

    /// Runs the twin in up to a sample.
    fn run_in(&self, first: &Sample) -> Result<Box<dyn Twin>> {
        let mut run_in = RunIn::try_new(&self.plant, self.period, total_turns(first), &drive(first))?;
        while run_in.advance() {
            self.check_cancelled()?;
        }
        Ok(run_in.into_twin())
    }

    fn check_cancelled(&self) -> Result<(), Cancelled> {
        if self.cancelled.load(Ordering::Relaxed) { Err(Cancelled) } else { Ok(()) }
    }

    /// Runs the search on its own thread.
    ///
    /// # Errors
    /// No thread can be started.
    pub(super) fn spawn(self, samples: Vec<Sample>) -> Result<JoinHandle<Result<Started>>> {
        let thread = std::thread::Builder::new().name("start".to_owned());
        Ok(thread.spawn(move || self.run(&samples))?)
    }
}

/// Returns what a finished search found.
///
/// # Errors
/// Those of the search.
pub(super) fn joined(search: JoinHandle<Result<Started>>) -> Result<Started> {
    search.join().unwrap_or_else(|_| bail!("the search for the twin's start panicked"))
}

/// Twins that are run in up to a sample, some steps at a time: a monitor does not wait for them.
pub(super) struct Beginning {
    plants: [Arc<Plant>; 2],
    /// On the scene's bearings and on linear springs.
    twins: [RunIn; 2],
    /// s
    period: f64,
    revolutions: f64,
}

impl Beginning {
    /// Starts twins on both plants for a sample.
    ///
    /// # Errors
    /// A machine that cannot be started.
    pub(super) fn try_new(plants: [Arc<Plant>; 2], period: f64, sample: &Sample) -> Result<Self> {
        let (revolutions, drive) = (total_turns(sample), drive(sample));
        let [plant, linear] = plants.each_ref().map(|plant| RunIn::try_new(plant, period, revolutions, &drive));
        Ok(Self { twins: [plant?, linear?], plants, period, revolutions })
    }

    /// Advances the twins until they have settled or `deadline` has passed; returns true where they have settled.
    pub(super) fn advance(&mut self, deadline: Option<Instant>) -> bool {
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

    /// Returns the settled twins.
    pub(super) fn settled(self) -> [Box<dyn Twin>; 2] {
        self.twins.map(RunIn::into_twin)
    }

    /// Returns twins at rest in the place of those that have not settled.
    ///
    /// # Errors
    /// A machine that cannot be started.
    pub(super) fn at_rest(self) -> Result<[Box<dyn Twin>; 2]> {
        let [twin, linear] = self.plants.map(|plant| plant.start(self.period, self.revolutions));
        Ok([twin?, linear?])
    }
}
