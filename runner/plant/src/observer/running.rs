//! An observer in operation: its step from sample to sample, the consistency test, and the restart.

use super::{CageTracker, Consistency, ConsistencyState, MAX_PROBES, StateEstimator};
use ballrace::Status;
use ballrace::rotor::ShaftMotion;
use std::f64::consts::TAU;

/// An observer that follows the samples of a recording.
pub struct RunningObserver {
    estimator: Box<dyn StateEstimator>,
    consistency: Consistency,
    /// Sample period, s.
    period: f64,
}

/// Result of a correction by a sample with a reading of every probe.
#[derive(Debug, Clone, Copy)]
pub struct Correction {
    /// Normalised innovation squared, at most the gate.
    pub nis: f64,
    /// Flags of the correction.
    pub status: Status,
    /// Result of the consistency test.
    pub verdict: ConsistencyState,
    /// Mean normalised innovation squared over its expected value.
    pub ratio: f64,
}

impl RunningObserver {
    /// Creates a running observer from its estimator, the initial state of the consistency test and the sample period, s.
    #[must_use]
    pub const fn new(estimator: Box<dyn StateEstimator>, consistency: Consistency, period: f64) -> Self {
        Self { estimator, consistency, period }
    }

    /// Sets the angle of each cage beyond that of the scene, revolutions.
    pub fn set_cage_offsets(&mut self, offsets: &[f64]) {
        self.estimator.set_cage_offsets(offsets);
    }

    /// Advances over the sample periods `motion` (the shaft at the start of each) and corrects with the readings at the end
    /// of the last period. Readings are NaN where missing.
    ///
    /// `cages` are states of the observer: they advance over the periods and are corrected where the observer is trusted.
    /// `is_possible` tests the estimated coordinates; `restart_state` returns coordinates and rates for a restart. Returns the flags of all
    /// periods, and the correction where every probe has a reading.
    pub fn step(
        &mut self,
        motion: impl Iterator<Item = ShaftMotion<f64>>,
        readings: &[f64],
        is_possible: impl Fn(&[f64]) -> bool,
        restart_state: impl FnOnce() -> (Vec<f64>, Vec<f64>),
        cages: &mut CageTracker,
    ) -> (Status, Option<Correction>) {
        let missing = [f64::NAN; MAX_PROBES];
        let mut motion = motion.peekable();
        let (mut all, mut last) = (Status::OK, None);
        while let Some(now) = motion.next() {
            let is_last = motion.peek().is_none();
            cages.advance(now.delta_after(self.period).radians::<f64>() / TAU, self.period);
            self.estimator.set_cage_offsets(cages.offsets());
            self.estimator.follow_cages(cages.followed());
            self.estimator.set_gate(self.consistency.gate());
            let (nis, status) = self.estimator.step(&now, if is_last { readings } else { &missing });
            all = all.union(status);
            last = is_last.then_some((nis, status));
        }
        let Some((nis, status)) = last.filter(|_| !readings.iter().any(|y| y.is_nan())) else { return (all, None) };
        let is_possible = !status.contains(Status::INPUT_NOT_FINITE) && is_possible(self.estimator.coordinates());
        let verdict = self.consistency.test(nis, is_possible);
        if verdict == ConsistencyState::Restart {
            let (position, rate) = restart_state();
            // The rejected samples did not change the loads; those behind an impossible displacement may be wrong.
            self.estimator.restart(&position, &rate, is_possible);
        }
        if let Some(evidence) = self.estimator.cage_evidence().filter(|_| verdict == ConsistencyState::Trusted) {
            cages.correct(evidence, self.consistency.ratio().max(1.0));
        }
        (all, Some(Correction { nis: self.consistency.bounded(nis), status, verdict, ratio: self.consistency.ratio() }))
    }

    /// Returns the estimated coordinates; `None` if the observer is not trusted.
    #[must_use]
    pub fn coordinates(&self) -> Option<&[f64]> {
        self.consistency.is_trusted().then(|| self.estimator.coordinates())
    }

    /// Returns the estimated coordinates and their rates, also while the observer is not trusted: then they are those of its restart, or
    /// far from it by some noise.
    #[must_use]
    pub fn state(&self) -> (&[f64], &[f64]) {
        (self.estimator.coordinates(), self.estimator.rates())
    }

    /// Returns the estimated unknown load, N and N m; `None` if the observer is not trusted.
    #[must_use]
    pub fn load(&self) -> Option<[f64; 5]> {
        self.consistency.is_trusted().then(|| self.estimator.load())
    }
}
