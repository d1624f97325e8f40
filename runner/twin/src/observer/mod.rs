//! The observer of a replay: the kernel's, with gains made here, started where the first turns say.

mod consistency;
mod model;
mod riccati;
mod start;
mod tune;

pub use consistency::{Consistency, Verdict, gate};
pub use model::{Uncertainty, memory, weight};
pub use tune::{Cancelled, IdentificationData, TunedObserver, noise, tuned, watch};

use crate::plant::{Plant, RigidSystem, RigidTask, Step, Twin};
use crate::replay::pose::row;
use crate::scene::build::AnyBearing;
use crate::scene::{Probe, Speed};
use anyhow::Result;
use ballrace::rotor::{BearingAtStation, ComponentAngles, RigidRotor, RotorState, ShaftMotion};
use ballrace::twin::{Observer, ObserverState, SpeedGain};
use ballrace::{Displacement, Exact, Phase, Status};

/// Most probes of an observer.
pub const MOST_PROBES: usize = 16;
const D: usize = 5;
/// Speeds for which there are gains where the speed is to change.
const SPEEDS: usize = 5;

/// One gain as the kernel takes it.
pub type Gain = SpeedGain<f64, MOST_PROBES>;

/// Gains of a scene's observer.
#[derive(Clone)]
pub struct Gains {
    /// Evenly over the speeds.
    pub all: Vec<Gain>,
    /// Speed of the first (rad/s), gains per rad/s.
    pub speeds: [f64; 2],
    /// Logarithm of the determinant of the innovations' covariance.
    log_determinant: f64,
}

/// Where an observer starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// Coordinates.
    pub q: [f64; D],
    /// Their rates.
    pub rate: [f64; D],
    /// The unknown load.
    pub load: [f64; D],
    /// The unknown load that turns with the shaft.
    pub turning: [f64; D],
}

impl Start {
    /// Where a twin is.
    #[must_use]
    pub fn of(twin: &dyn Twin) -> Self {
        Self { q: twin.pose().to_array(), rate: twin.rate().to_array(), load: [0.0; D], turning: [0.0; D] }
    }
}

/// Reading of each probe per unit of each coordinate.
#[must_use]
pub fn observed_rows(probes: &[Probe]) -> Vec<[f64; D]> {
    probes.iter().map(row).collect()
}

impl Gains {
    /// That never correct.
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

    /// For probes with these rows and noises (m).
    ///
    /// # Errors
    /// Where there is no steady filter.
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

/// An observer under way, whatever the count of bearings.
pub trait Watch {
    /// One sample further; the shaft moved as `drive` said at the last one. Returns the normalised innovation squared.
    fn sample(&mut self, drive: &ShaftMotion<f64>, readings: &[f64]) -> (f64, Status);
    /// Sets the validation gate; infinity disables it.
    fn set_gate(&mut self, gate: f64);
    /// Restarts the observer at this displacement and rate, with no unknown load.
    fn restart(&mut self, pose: &Displacement<f64>, rate: &Displacement<f64>);
    /// Where the rotor is.
    fn pose(&self) -> Displacement<f64>;
    /// The unknown load.
    fn load(&self) -> [f64; D];
    /// The one that turns with the shaft.
    fn turning(&self) -> [f64; D];
}

/// Starts an observer.
pub struct RunningObserverOf<'a> {
    /// What each probe reads.
    pub rows: &'a [[f64; D]],
    /// How it corrects.
    pub gains: &'a Gains,
    /// The first state.
    pub start: Start,
    /// The shaft there.
    pub shaft: Phase,
    /// The bearings' parts there.
    pub parts: Vec<ComponentAngles>,
    /// From sample to sample, s.
    pub period: f64,
}

type Of<const N: usize> =
    Observer<f64, RigidRotor<f64, Exact>, BearingAtStation<f64, AnyBearing<f64>>, Step, Vec<Gain>, N, MOST_PROBES>;

struct Running<const N: usize> {
    observer: Of<N>,
    state: ObserverState<f64, N>,
    readings: [f64; MOST_PROBES],
    /// Those that are not idle.
    probes: usize,
}

impl RigidTask<Box<dyn Watch>> for RunningObserverOf<'_> {
    fn run<const N: usize>(self, machine: RigidSystem<N>, step: Step, substeps: u32) -> Box<dyn Watch> {
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
        Box::new(Running {
            observer,
            state: ObserverState { motion, load: self.start.load, rotating_load: self.start.turning },
            readings: [0.0; MOST_PROBES],
            probes: self.rows.len(),
        })
    }
}

impl<const N: usize> Watch for Running<N> {
    fn sample(&mut self, drive: &ShaftMotion<f64>, readings: &[f64]) -> (f64, Status) {
        for (to, &reading) in self.readings.iter_mut().zip(readings).take(self.probes) {
            *to = reading;
        }
        let estimate = self.observer.sample::<Exact>(&mut self.state, drive, &self.readings);
        (estimate.nis, estimate.status)
    }
    fn set_gate(&mut self, gate: f64) {
        self.observer.gate = gate;
    }
    fn restart(&mut self, pose: &Displacement<f64>, rate: &Displacement<f64>) {
        self.state.motion.q = pose.to_array();
        self.state.motion.velocity = rate.to_array();
        self.state.load = [0.0; D];
        self.state.rotating_load = [0.0; D];
    }
    fn pose(&self) -> Displacement<f64> {
        self.state.motion.displacement()
    }
    fn load(&self) -> [f64; D] {
        self.state.load
    }
    fn turning(&self) -> [f64; D] {
        self.state.rotating_load
    }
}
