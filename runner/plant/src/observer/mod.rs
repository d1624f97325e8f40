//! The observer of a replay: the kernel's steady-state Kalman filter, its gains, its identification from the first
//! revolutions, and its operation from sample to sample.

mod cages;
mod consistency;
mod model;
mod riccati;
mod running;
mod start;
mod tune;

pub use cages::{CageEvidence, CagePosition, CageTracker, found_position};
pub use consistency::{Consistency, ConsistencyState, gate, wide_gate};
pub use model::{Uncertainty, memory, weight};
pub use running::{Correction, RunningObserver};
pub use tune::{IdentificationData, TunedObserver, identify, noise};

use crate::error::Result;
use crate::{AXIAL, MountedBearing, Plant, ReactingElement, Step, SystemTask, array};
use ballrace::rotor::{ComponentAngles, RotorBearingSystem, RotorState, SecondOrderSystem, ShaftMotion};
use ballrace::twin::{Estimate, Observer, ObserverState, SpeedGain};
use ballrace::{Exact, Phase, Status};
use ballrace_models::simd::SimdDispatch;
use ballrace_recording::Sample;
use ballrace_scene::Speed;
use nalgebra::DMatrix;

/// Largest number of probes of an observer.
pub(crate) const MAX_PROBES: usize = 16;
/// Number of speeds with gains, for a shaft speed that changes.
const SPEEDS: usize = 5;

/// Gains at one speed: change of the state per unit of innovation of each probe, one probe per column.
#[derive(Clone)]
pub struct Gain {
    /// Change of the coordinates.
    pub position: DMatrix<f64>,
    /// Change of their rates.
    pub rate: DMatrix<f64>,
    /// Change of the unknown load on each coordinate.
    pub load: DMatrix<f64>,
    /// Change of the unknown load that rotates with the shaft.
    pub rotating_load: DMatrix<f64>,
    /// `W`, a lower triangular matrix with `W^T W = S^-1`, the inverse covariance of the innovations.
    pub whitening: DMatrix<f64>,
}

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

/// State at which an observer starts; all by coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialState {
    /// Coordinates.
    pub q: Vec<f64>,
    /// Their rates.
    pub rate: Vec<f64>,
    /// The unknown load, N and N m.
    pub load: Vec<f64>,
    /// The unknown load that rotates with the shaft, N and N m.
    pub turning: Vec<f64>,
}

impl InitialState {
    /// Creates a state without unknown loads.
    #[must_use]
    pub fn new(coordinates: &[f64], rates: &[f64]) -> Self {
        let none = vec![0.0; coordinates.len()];
        Self { q: coordinates.to_vec(), rate: rates.to_vec(), load: none.clone(), turning: none }
    }
}

impl Gain {
    /// Returns the gains of zero for `order` coordinates.
    fn none(order: usize) -> Self {
        let zero = DMatrix::zeros(order, 0);
        Self {
            position: zero.clone(),
            rate: zero.clone(),
            load: zero.clone(),
            rotating_load: zero,
            whitening: DMatrix::zeros(0, 0),
        }
    }

    /// Returns the gains in the form of the kernel, with zeros for coordinates and probes beyond the scene's.
    fn of_kernel<const D: usize>(&self) -> SpeedGain<f64, D, MAX_PROBES> {
        let entry = |of: &DMatrix<f64>, i: usize, j: usize| of.get((i, j)).copied().unwrap_or(0.0);
        let part = |of: &DMatrix<f64>| std::array::from_fn(|p| std::array::from_fn(|i| entry(of, i, p)));
        SpeedGain {
            position: part(&self.position),
            rate: part(&self.rate),
            load: part(&self.load),
            rotating_load: part(&self.rotating_load),
            whitening: std::array::from_fn(|i| std::array::from_fn(|j| entry(&self.whitening, i, j))),
        }
    }
}

impl Gains {
    /// Returns gains of zero: the observer predicts and never corrects.
    #[must_use]
    pub fn none(order: usize) -> Self {
        Self { all: vec![Gain::none(order)], speeds: [0.0; 2], log_determinant: 0.0 }
    }

    /// Computes the gains for probes with these rows.
    ///
    /// # Errors
    /// Returns an error if the filter of the system has no steady state.
    pub fn try_new(plant: &Plant, rows: &[Vec<f64>], speed: Speed, period: f64, of: &Uncertainty) -> Result<Self> {
        let (from, to) = match speed {
            Speed::Ramp { from, to, .. } => (from, to),
            other => (other.nominal(), other.nominal()),
        };
        let count = if from == to { 1 } else { SPEEDS };
        let stride = (to - from) / (count.max(2) - 1) as f64;
        let n = plant.layout.order;
        let (loads, rotating) = (model::loads(plant), model::rotating_loads(plant));
        let mut log_determinant = 0.0;
        let mut all = Vec::with_capacity(count);
        for i in 0..count {
            let steady = model::steady(plant, rows, from + i as f64 * stride, period, of)?;
            log_determinant = -2.0 * (0..rows.len()).map(|i| steady.whitening[(i, i)].ln()).sum::<f64>();
            let part = |first: usize, rows: usize| steady.gain.rows(first, rows).into_owned();
            all.push(Gain {
                position: part(0, n),
                rate: part(n, n),
                load: &loads * part(2 * n, model::LOADS),
                rotating_load: &rotating * part(2 * n + model::LOADS, model::LOADS),
                whitening: steady.whitening,
            });
        }
        if stride < 0.0 {
            all.reverse();
        }
        let density = if count > 1 { 1.0 / stride.abs() } else { 0.0 };
        Ok(Self { all, speeds: [from.min(to), density], log_determinant })
    }
}

impl Gains {
    /// Leaves the axial coordinate to the model. Where no probe measures it and the bearings lose contact, the mean stiffness between the radial and
    /// the axial motion, by which the gains correct it, is not that of the moment.
    pub(crate) fn leave_axial(&mut self) {
        for gain in &mut self.all {
            for part in [&mut gain.position, &mut gain.rate, &mut gain.load, &mut gain.rotating_load] {
                part.row_mut(AXIAL).fill(0.0);
            }
        }
    }
}

/// A Kalman filter in operation, for any number of bearings.
pub trait StateEstimator {
    /// Advances by one sample period with the shaft moving as `drive`, the motion at its start, and corrects with the readings
    /// at its end. Returns the normalised innovation squared and the status flags.
    fn step(&mut self, drive: &ShaftMotion<f64>, readings: &[f64]) -> (f64, Status);
    /// Sets the validation gate; infinity disables it.
    fn set_gate(&mut self, gate: f64);
    /// Restarts at coordinates and their rates, with or without the unknown loads so far.
    fn restart(&mut self, coordinates: &[f64], rates: &[f64], keeps_loads: bool);
    /// Returns the estimated coordinates.
    fn coordinates(&self) -> &[f64];
    /// Returns the rates of the estimated coordinates.
    fn rates(&self) -> &[f64];
    /// Returns the estimated unknown force and moment on the rotor, about its centre of mass.
    fn load(&self) -> [f64; 5];
    /// Sets the angle of each cage beyond that of the scene, revolutions.
    fn set_cage_offsets(&mut self, offsets: &[f64]);
    /// Sets the bearings of which the innovations are also computed with another cage angle.
    fn follow_cages(&mut self, followed: &[bool]);
    /// Returns the innovations of the last step and their changes by the cages; `None` if the step corrected nothing.
    fn cage_evidence(&self) -> Option<&CageEvidence>;
}

/// Starts an estimator at `sample`.
///
/// # Errors
/// Returns an error if the kernel rejects the plant.
pub fn estimator(
    plant: &Plant,
    rows: &[Vec<f64>],
    gains: &Gains,
    start: InitialState,
    sample: &Sample,
    period: f64,
) -> Result<Box<dyn StateEstimator>> {
    let revolutions = sample.total_revolutions();
    let parts =
        plant.bearings.iter().map(|bearing: &MountedBearing| bearing.kinematics.parts_at(revolutions)).collect();
    let step = plant.step(period)?;
    let task = EstimatorTask { rows, gains, start, shaft: sample.angle, parts, period, step };
    Ok(plant.observed(task)?)
}

/// Task that starts an estimator.
pub(crate) struct EstimatorTask<'a> {
    /// Reading of each probe per unit of each coordinate.
    pub rows: &'a [Vec<f64>],
    /// Gains of the correction.
    pub gains: &'a Gains,
    /// Initial state.
    pub start: InitialState,
    /// Initial shaft angle.
    pub shaft: Phase,
    /// Initial angles of the components of each bearing.
    pub parts: Vec<ComponentAngles>,
    /// Sample period, s.
    pub period: f64,
    /// Integrator with its step, and number of steps in a sample period.
    pub step: (Step, u32),
}

type KernelObserver<S, C, const D: usize, const N: usize> =
    Observer<f64, S, C, Step, Vec<SpeedGain<f64, D, MAX_PROBES>>, D, N, MAX_PROBES, Vec<[f64; D]>>;

struct Estimator<S, C, const D: usize, const N: usize> {
    observer: KernelObserver<S, C, D, N>,
    registers: SimdDispatch,
    state: ObserverState<f64, D, N>,
    readings: [f64; MAX_PROBES],
    /// Number of probes in use.
    probes: usize,
    /// Number of coordinates in use.
    order: usize,
    /// The same observer with the cage of one bearing [`cages::DISPLACEMENT`] ahead; `None` for a cage that is not followed.
    displaced: Vec<Option<ObserverState<f64, D, N>>>,
    /// Angle of each cage beyond that of the scene, revolutions.
    cage_offsets: [f64; N],
    evidence: CageEvidence,
    has_evidence: bool,
}

impl<S, C, const D: usize, const N: usize> Estimator<S, C, D, N>
where
    S: SecondOrderSystem<f64, D>,
    C: ReactingElement<D>,
{
    /// Returns the state with the cage of bearing `b` displaced.
    fn displaced(&self, b: usize) -> ObserverState<f64, D, N> {
        let mut state = self.state;
        turn(&mut state, b, cages::DISPLACEMENT);
        state
    }

    /// Advances the observers with displaced cages, and computes the changes of the innovations.
    fn step_displaced(&mut self, drive: &ShaftMotion<f64>, innovation: &[f64; MAX_PROBES], is_rejected: bool) {
        let [first, density] = self.observer.speeds;
        let nearest = ((drive.speed - first) * density).round().clamp(0.0, (self.observer.gains.len() - 1) as f64);
        let whitening = self.observer.gains[nearest as usize].whitening;
        let white = |e: &[f64; MAX_PROBES], white: &mut Vec<f64>| {
            white.clear();
            white.extend(whitening.iter().take(self.probes).map(|row| dot(row, e)));
        };
        white(innovation, &mut self.evidence.white);
        // A sample that corrected one observer corrects the others too.
        let gate = std::mem::replace(&mut self.observer.gate, f64::INFINITY);
        let readings = if is_rejected { [f64::NAN; MAX_PROBES] } else { self.readings };
        self.evidence.slopes.resize(self.displaced.len(), vec![]);
        for (state, slopes) in self.displaced.iter_mut().zip(&mut self.evidence.slopes) {
            let Some(state) = state else {
                slopes.clear();
                continue;
            };
            let other = sample(&self.observer, self.registers, state, drive, &readings).innovation;
            let slope = std::array::from_fn(|p| (other[p] - innovation[p]) / cages::DISPLACEMENT);
            white(&slope, slopes);
        }
        self.observer.gate = gate;
    }
}

/// Advances an observer by one sample, with the instruction sets of the processor. Not inlined: it is compiled once for all its callers.
#[inline(never)]
fn sample<S: SecondOrderSystem<f64, D>, C: ReactingElement<D>, const D: usize, const N: usize>(
    observer: &KernelObserver<S, C, D, N>,
    registers: SimdDispatch,
    state: &mut ObserverState<f64, D, N>,
    drive: &ShaftMotion<f64>,
    readings: &[f64; MAX_PROBES],
) -> Estimate<f64, MAX_PROBES> {
    registers.run(
        #[inline(always)]
        || observer.sample::<Exact>(state, drive, readings),
    )
}

fn dot(a: &[f64; MAX_PROBES], b: &[f64; MAX_PROBES]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Turns the cage of a bearing by a number of revolutions.
fn turn<const D: usize, const N: usize>(state: &mut ObserverState<f64, D, N>, b: usize, revolutions: f64) {
    if let Some(parts) = state.motion.component_angles.get_mut(b) {
        parts.cage = parts.cage.wrapping_add(Phase::from_revolutions(revolutions));
    }
}

impl SystemTask<Box<dyn StateEstimator>> for EstimatorTask<'_> {
    fn run<S, C, const D: usize, const N: usize>(self, machine: RotorBearingSystem<S, C, N>) -> Box<dyn StateEstimator>
    where
        S: SecondOrderSystem<f64, D> + 'static,
        C: ReactingElement<D> + 'static,
    {
        let probes = self.rows.iter().map(|row| array(row)).collect();
        let parts: [ComponentAngles; N] = array(&self.parts);
        let motion = RotorState {
            velocity: array(&self.start.rate),
            ..RotorState::stationary(array::<_, D>(&self.start.q), self.shaft, parts)
        };
        let (step, substeps) = self.step;
        let observer = Observer {
            system: machine,
            integrator: step,
            step: step.length,
            substeps,
            probes,
            gains: self.gains.all.iter().map(Gain::of_kernel).collect(),
            speeds: self.gains.speeds,
            load_retention: memory(self.period),
            gate: f64::INFINITY,
        };
        Box::new(Estimator {
            observer,
            registers: SimdDispatch::detect(),
            state: ObserverState { motion, load: array(&self.start.load), rotating_load: array(&self.start.turning) },
            readings: [0.0; MAX_PROBES],
            probes: self.rows.len(),
            order: self.start.q.len(),
            displaced: vec![],
            cage_offsets: [0.0; N],
            evidence: CageEvidence::default(),
            has_evidence: false,
        })
    }
}

impl<S, C, const D: usize, const N: usize> StateEstimator for Estimator<S, C, D, N>
where
    S: SecondOrderSystem<f64, D>,
    C: ReactingElement<D>,
{
    fn step(&mut self, drive: &ShaftMotion<f64>, readings: &[f64]) -> (f64, Status) {
        for (to, &reading) in self.readings.iter_mut().zip(readings).take(self.probes) {
            *to = reading;
        }
        let estimate = sample(&self.observer, self.registers, &mut self.state, drive, &self.readings);
        self.has_evidence = false;
        if self.displaced.iter().any(Option::is_some) {
            let is_rejected = estimate.status.contains(Status::INNOVATION_REJECTED);
            self.step_displaced(drive, &estimate.innovation, is_rejected);
            self.has_evidence = !is_rejected && !estimate.status.contains(Status::INPUT_NOT_FINITE);
        }
        (estimate.nis, estimate.status)
    }
    fn set_gate(&mut self, gate: f64) {
        self.observer.gate = gate;
    }
    fn restart(&mut self, coordinates: &[f64], rates: &[f64], keeps_loads: bool) {
        self.state.motion.q = array(coordinates);
        self.state.motion.velocity = array(rates);
        if !keeps_loads {
            self.state.load = [0.0; D];
            self.state.rotating_load = [0.0; D];
        }
        for b in 0..self.displaced.len() {
            self.displaced[b] = self.displaced[b].map(|_| self.displaced(b));
        }
    }
    fn coordinates(&self) -> &[f64] {
        self.state.motion.q.get(..self.order).unwrap_or_default()
    }
    fn rates(&self) -> &[f64] {
        self.state.motion.velocity.get(..self.order).unwrap_or_default()
    }
    fn load(&self) -> [f64; 5] {
        array(&self.state.load)
    }
    fn set_cage_offsets(&mut self, offsets: &[f64]) {
        for (b, (offset, before)) in offsets.iter().zip(&mut self.cage_offsets).enumerate() {
            let by = offset - std::mem::replace(before, *offset);
            if by == 0.0 {
                continue;
            }
            turn(&mut self.state, b, by);
            for state in self.displaced.iter_mut().flatten() {
                turn(state, b, by);
            }
        }
    }
    fn follow_cages(&mut self, followed: &[bool]) {
        self.displaced.resize(followed.len(), None);
        for (b, &is_followed) in followed.iter().enumerate() {
            if is_followed != self.displaced[b].is_some() {
                self.displaced[b] = is_followed.then(|| self.displaced(b));
            }
        }
    }
    fn cage_evidence(&self) -> Option<&CageEvidence> {
        self.has_evidence.then_some(&self.evidence)
    }
}
