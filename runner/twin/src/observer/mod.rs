//! The observer of a replay: the kernel's steady-state Kalman filter, its gains, its identification from the first
//! revolutions, and its operation from sample to sample.

mod consistency;
mod model;
mod riccati;
mod running;
mod start;
mod tune;

pub use consistency::{Consistency, Verdict, gate};
pub use model::{Uncertainty, memory, weight};
pub use running::{Correction, RunningObserver};
pub use tune::{IdentificationData, TunedObserver, estimator, identify, noise};

use crate::error::Result;
use crate::plant::{Plant, RigidSystem, RigidTask, Step};
use crate::probes::row;
use crate::scene::build::AnyBearing;
use crate::scene::{Probe, Speed};
use ballrace::rotor::{BearingAtStation, ComponentAngles, RigidRotor, RotorState, ShaftMotion};
use ballrace::twin::{Observer, ObserverState, SpeedGain};
use ballrace::{Displacement, Exact, Phase, Status};

/// Largest number of probes of an observer.
pub const MOST_PROBES: usize = 16;
const D: usize = 5;
/// Number of speeds with gains, for a shaft speed that changes.
const SPEEDS: usize = 5;

/// Gains at one speed, in the form of the kernel.
pub type Gain = SpeedGain<f64, MOST_PROBES>;

/// Gains of a scene's observer.
#[derive(Clone)]
pub struct Gains {
    /// Gains at evenly spaced speeds.
    pub all: Vec<Gain>,
    /// Speed of the first gains (rad/s), and number of gains per rad/s.
    pub speeds: [f64; 2],
    /// Logarithm of the determinant of the innovation covariance.
    log_determinant: f64,
}

/// State at which an observer starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InitialState {
    /// Coordinates.
    pub q: [f64; D],
    /// Their rates.
    pub rate: [f64; D],
    /// The unknown load, N and N m.
    pub load: [f64; D],
    /// The unknown load that rotates with the shaft, N and N m.
    pub turning: [f64; D],
}

impl InitialState {
    /// Creates a state without unknown loads.
    #[must_use]
    pub fn new(position: &Displacement<f64>, rate: &Displacement<f64>) -> Self {
        Self { q: position.to_array(), rate: rate.to_array(), load: [0.0; D], turning: [0.0; D] }
    }
}

/// Returns the reading of each probe per unit of each coordinate.
#[must_use]
pub fn observed_rows(probes: &[Probe]) -> Vec<[f64; D]> {
    probes.iter().map(row).collect()
}

impl Gains {
    /// Returns gains of zero: the observer predicts and never corrects.
    #[must_use]
    pub fn none() -> Self {
        let zero = [[0.0; D]; MOST_PROBES];
        let gain = Gain {
            position: zero,
            rate: zero,
            load: zero,
            rotating_load: zero,
            whitening: [[0.0; MOST_PROBES]; MOST_PROBES],
        };
        Self { all: vec![gain], speeds: [0.0; 2], log_determinant: 0.0 }
    }

    /// Computes the gains for probes with these rows.
    ///
    /// # Errors
    /// A system whose filter has no steady state.
    pub fn try_new(plant: &Plant, rows: &[[f64; D]], speed: Speed, period: f64, of: &Uncertainty) -> Result<Self> {
        let (from, to) = match speed {
            Speed::Ramp { from, to, .. } => (from, to),
            other => (other.nominal(), other.nominal()),
        };
        let count = if from == to { 1 } else { SPEEDS };
        let stride = (to - from) / (count.max(2) - 1) as f64;
        let mut log_determinant = 0.0;
        let mut all = Vec::with_capacity(count);
        for i in 0..count {
            let steady = model::steady(plant, rows, from + i as f64 * stride, period, of)?;
            let entry = |p: usize, i: usize| if p < rows.len() { steady.gain[(i, p)] } else { 0.0 };
            let part = |first: usize| std::array::from_fn(|p| std::array::from_fn(|i| entry(p, first + i)));
            let white = |i: usize, j: usize| if i.max(j) < rows.len() { steady.whitening[(i, j)] } else { 0.0 };
            all.push(Gain {
                position: part(0),
                rate: part(D),
                load: part(2 * D),
                rotating_load: part(3 * D),
                whitening: std::array::from_fn(|i| std::array::from_fn(|j| white(i, j))),
            });
            log_determinant = -2.0 * (0..rows.len()).map(|i| steady.whitening[(i, i)].ln()).sum::<f64>();
        }
        if stride < 0.0 {
            all.reverse();
        }
        let density = if count > 1 { 1.0 / stride.abs() } else { 0.0 };
        Ok(Self { all, speeds: [from.min(to), density], log_determinant })
    }
}

/// A Kalman filter in operation, for any number of bearings.
pub trait StateEstimator {
    /// Advances by one sample period with the shaft moving as `drive`, the motion at its start, and corrects with the readings
    /// at its end. Returns the normalised innovation squared and the status flags.
    fn step(&mut self, drive: &ShaftMotion<f64>, readings: &[f64]) -> (f64, Status);
    /// Sets the validation gate; infinity disables it.
    fn set_gate(&mut self, gate: f64);
    /// Restarts at a displacement and its rate, without unknown loads.
    fn restart(&mut self, position: &Displacement<f64>, rate: &Displacement<f64>);
    /// Returns the estimated displacement of the rotor.
    fn position(&self) -> Displacement<f64>;
    /// Returns the estimated unknown load.
    fn load(&self) -> [f64; D];
    /// Returns the estimated unknown load that rotates with the shaft.
    fn turning(&self) -> [f64; D];
}

/// Task that starts an estimator.
pub struct EstimatorTask<'a> {
    /// Reading of each probe per unit of each coordinate.
    pub rows: &'a [[f64; D]],
    /// Gains of the correction.
    pub gains: &'a Gains,
    /// Initial state.
    pub start: InitialState,
    /// Initial shaft angle.
    pub shaft: Phase,
    /// Initial angles of the bearings' parts.
    pub parts: Vec<ComponentAngles>,
    /// Sample period, s.
    pub period: f64,
}

type KernelObserver<const N: usize> =
    Observer<f64, RigidRotor<f64, Exact>, BearingAtStation<f64, AnyBearing<f64>>, Step, Vec<Gain>, N, MOST_PROBES>;

struct Estimator<const N: usize> {
    observer: KernelObserver<N>,
    state: ObserverState<f64, N>,
    readings: [f64; MOST_PROBES],
    /// Number of probes in use.
    probes: usize,
}

impl RigidTask<Box<dyn StateEstimator>> for EstimatorTask<'_> {
    fn run<const N: usize>(self, machine: RigidSystem<N>, step: Step, substeps: u32) -> Box<dyn StateEstimator> {
        let mut probes = [[0.0; D]; MOST_PROBES];
        for (to, row) in probes.iter_mut().zip(self.rows) {
            *to = *row;
        }
        let parts: [ComponentAngles; N] = std::array::from_fn(|i| self.parts.get(i).copied().unwrap_or_default());
        let motion =
            RotorState { velocity: self.start.rate, ..RotorState::stationary(self.start.q, self.shaft, parts) };
        let observer = Observer {
            system: machine,
            integrator: step,
            step: step.length,
            substeps,
            probes,
            gains: self.gains.all.clone(),
            speeds: self.gains.speeds,
            load_retention: memory(self.period),
            gate: f64::INFINITY,
        };
        Box::new(Estimator {
            observer,
            state: ObserverState { motion, load: self.start.load, rotating_load: self.start.turning },
            readings: [0.0; MOST_PROBES],
            probes: self.rows.len(),
        })
    }
}

impl<const N: usize> StateEstimator for Estimator<N> {
    fn step(&mut self, drive: &ShaftMotion<f64>, readings: &[f64]) -> (f64, Status) {
        for (to, &reading) in self.readings.iter_mut().zip(readings).take(self.probes) {
            *to = reading;
        }
        let estimate = self.observer.sample::<Exact>(&mut self.state, drive, &self.readings);
        (estimate.nis, estimate.status)
    }
    fn set_gate(&mut self, gate: f64) {
        self.observer.gate = gate;
    }
    fn restart(&mut self, position: &Displacement<f64>, rate: &Displacement<f64>) {
        self.state.motion.q = position.to_array();
        self.state.motion.velocity = rate.to_array();
        self.state.load = [0.0; D];
        self.state.rotating_load = [0.0; D];
    }
    fn position(&self) -> Displacement<f64> {
        self.state.motion.displacement()
    }
    fn load(&self) -> [f64; D] {
        self.state.load
    }
    fn turning(&self) -> [f64; D] {
        self.state.rotating_load
    }
}
