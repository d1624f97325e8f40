//! The digital twin: the motion of a plant driven by the shaft angle.

use super::MultibodyChecks;
use super::machine::{ReactingElement, SystemTask};
use super::system::{OnHeap, array};
use ballrace::rotor::{
    ComponentAngles, ForceElement, Integrator, Newmark, RotorBearingSystem, RotorState, RungeKuttaNystrom,
    SecondOrderSystem, ShaftMotion, SteadyVerlet, Verlet,
};
use ballrace::twin::WithUnmodelledForce;
use ballrace::{BearingKinematicState, Displacement, Phase, Status, Wrench};
use ballrace_models::simd::SimdDispatch;
use ballrace_multibody::ElementMotion;
use ballrace_scene::Method;

/// A twin with any number of coordinates and bearings.
pub trait Twin: Send {
    /// Advances by one sample period with the shaft motion `drive`.
    fn step(&mut self, drive: &ShaftMotion<f64>) -> Status;
    /// Returns the coordinates.
    fn coordinates(&self) -> &[f64];
    /// Returns the rates of the coordinates.
    fn rates(&self) -> &[f64];
    /// Returns the force of bearing `i` on its inner ring in the kinematic state `at`.
    fn wrench(&self, i: usize, at: &BearingKinematicState<f64>) -> Wrench<f64>;
    /// Sets the first coordinates and rates.
    fn place(&mut self, coordinates: &[f64], rates: &[f64]);
    /// Turns the cage of bearing `i` by an angle.
    fn turn_cage(&mut self, i: usize, by: Phase);
    /// Sets the load on each coordinate besides that of the scene, N and N m; 0 at the start and where `load` is shorter.
    fn set_load(&mut self, load: &[f64]);
    /// Returns a copy that goes on by itself, bit for bit as this twin does.
    fn copy(&self) -> Box<dyn Twin>;
    /// Returns motion and contacts of balls and cage of bearing `i`; `None` where they are no bodies.
    fn element_motion(&self, _i: usize) -> Option<ElementMotion> {
        None
    }
    /// Returns the checks of the integration of bodies; `None` without them.
    fn multibody_checks(&self) -> Option<MultibodyChecks> {
        None
    }
}

/// Returns the displacement of a rigid rotor from its coordinates.
#[must_use]
pub fn first_five(coordinates: &[f64]) -> Displacement<f64> {
    let mut five = [0.0; 5];
    for (entry, &x) in five.iter_mut().zip(coordinates) {
        *entry = x;
    }
    Displacement::from_array(five)
}

/// Integrator of a scene with its step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Integration method.
    pub method: Method,
    /// Length of the step, s.
    pub length: f64,
}

impl Integrator<f64> for Step {
    #[inline(always)]
    fn step<R: SecondOrderSystem<f64, D>, C: ForceElement<f64, D>, const D: usize, const N: usize>(
        &self,
        machine: &RotorBearingSystem<R, C, N>,
        state: &mut RotorState<f64, D, N>,
        drive: &ShaftMotion<f64>,
    ) -> Status {
        let step = self.length;
        match self.method {
            Method::RungeKutta => RungeKuttaNystrom { step }.step(machine, state, drive),
            Method::Newmark { newton_steps } => Newmark { step, newton_steps }.step(machine, state, drive),
            Method::Verlet => Verlet { step }.step(machine, state, drive),
        }
    }
}

/// Starts a twin at rest.
pub(super) struct StartTask {
    pub rest: Vec<f64>,
    pub shaft: Phase,
    pub parts: Vec<ComponentAngles>,
    pub step: Step,
    pub substeps: u32,
}

impl SystemTask<Box<dyn Twin>> for StartTask {
    fn run<S, C, const D: usize, const N: usize>(self, machine: RotorBearingSystem<S, C, N>) -> Box<dyn Twin>
    where
        S: SecondOrderSystem<f64, D> + Clone + Send + 'static,
        C: ReactingElement<D> + Clone + Send + 'static,
    {
        let steady = SteadyVerlet::with_storage(Verlet { step: self.step.length }, &machine.rotor, 0.0);
        Box::new(Moving {
            machine,
            steady,
            state: RotorState::stationary(array::<f64, D>(&self.rest), self.shaft, array::<_, N>(&self.parts)),
            load: [0.0; D],
            coordinates: self.rest.len(),
            step: self.step,
            substeps: self.substeps,
            is_started: false,
            registers: SimdDispatch::detect(),
        })
    }
}

#[derive(Clone)]
struct Moving<S, C, const D: usize, const N: usize> {
    machine: RotorBearingSystem<S, C, N>,
    steady: SteadyVerlet<f64, D, OnHeap<D>>,
    state: RotorState<f64, D, N>,
    /// Load on the coordinates besides that of the scene.
    load: [f64; D],
    /// Number of coordinates that are not idle.
    coordinates: usize,
    step: Step,
    substeps: u32,
    /// False where coordinates or rates were set, and the acceleration does not belong to them.
    is_started: bool,
    registers: SimdDispatch,
}

impl<S, C, const D: usize, const N: usize> Twin for Moving<S, C, D, N>
where
    S: SecondOrderSystem<f64, D> + Clone + Send + 'static,
    C: ReactingElement<D> + Clone + Send + 'static,
{
    fn step(&mut self, drive: &ShaftMotion<f64>) -> Status {
        let (step, substeps) = (self.step, self.substeps);
        let machine = &RotorBearingSystem {
            rotor: WithUnmodelledForce { system: &self.machine.rotor, load: self.load },
            bearings: self.machine.bearings.each_ref(),
        };
        if !self.is_started {
            // The other integrators carry no acceleration from step to step.
            if matches!(step.method, Method::Newmark { .. }) {
                Newmark::start(machine, &mut self.state, drive);
            }
            self.is_started = true;
        }
        let (steady, state) = (&mut self.steady, &mut self.state);
        self.registers.run(
            #[inline(always)]
            || {
                let mut status = Status::OK;
                // A plain loop: the body of `fold` would be a function of its own, compiled for every processor.
                for i in 0..substeps {
                    let now = drive.after(f64::from(i) * step.length);
                    status = status.union(match step.method {
                        Method::Verlet => steady.step(machine, state, &now),
                        _ => step.step(machine, state, &now),
                    });
                }
                status
            },
        )
    }
    fn coordinates(&self) -> &[f64] {
        self.state.q.get(..self.coordinates).unwrap_or_default()
    }
    fn rates(&self) -> &[f64] {
        self.state.velocity.get(..self.coordinates).unwrap_or_default()
    }
    fn wrench(&self, i: usize, at: &BearingKinematicState<f64>) -> Wrench<f64> {
        self.machine.bearings.get(i).map_or_else(Wrench::default, |b| b.reaction(&self.state.q, at).wrench)
    }
    fn place(&mut self, coordinates: &[f64], rates: &[f64]) {
        self.is_started = false;
        for (to, from) in [(&mut self.state.q, coordinates), (&mut self.state.velocity, rates)] {
            for (entry, &x) in to.iter_mut().zip(from) {
                *entry = x;
            }
        }
    }
    fn turn_cage(&mut self, i: usize, by: Phase) {
        self.is_started = false;
        if let Some(parts) = self.state.component_angles.get_mut(i) {
            parts.cage = parts.cage.wrapping_add(by);
        }
    }
    fn set_load(&mut self, load: &[f64]) {
        let load = std::array::from_fn(|i| load.get(i).copied().unwrap_or(0.0));
        if load != self.load {
            self.is_started = false;
            self.load = load;
        }
    }
    fn copy(&self) -> Box<dyn Twin> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ballrace::bearing::geometry::InvalidParameter;
    use ballrace::bearing::linear::Linear;
    use ballrace::bearing::lumped::Radial;
    use ballrace::bearing::{ElementPositions, evenly_spaced};
    use ballrace::contact::law::PointContactLaw;
    use ballrace::rotor::{
        BearingAtStation, RigidRotor, RotorBearingSystem, RotorParams, RotorState, ShaftMotion, SpeedRatios, Unbalance,
    };
    use ballrace::{Displacement, Exact, Phase, Stiffness};
    use ballrace_models::handle::{AnyBearing, BearingHandle as _};

    #[test]
    fn a_rotor_moves_the_same_bits_with_and_without_wide_registers() -> Result<(), InvalidParameter> {
        let params = RotorParams {
            mass: 6.0,
            diametral_inertia: 0.03,
            polar_inertia: 0.006,
            damping: std::array::from_fn(|i| std::array::from_fn(|j| [400.0, 0.4][usize::from(i.max(j) > 2)])),
            stiffness: [0.0; 5],
            gravity: [0.0, -9.81, 0.0],
            load: [0.0, 0.0, 60.0, 0.0, 0.0],
        };
        let unbalance = Unbalance { moment: 120e-6, angle: 0.3, station: 0.02 };
        let rotor = RigidRotor::<f64, Exact>::try_new(&params, &[unbalance])?;
        let (law, places): (_, ElementPositions<f64, 9>) =
            (PointContactLaw { stiffness: 1e10 }, evenly_spaced(Phase::ZERO));
        let bearing = Radial::<f64, Exact, _, _>::try_new(places.to_vec(), law, 5e-6)?;
        let springs = Linear::new(Stiffness::from_diagonal_element(1e4));
        let springs = || -> AnyBearing<f64> { AnyBearing::new(springs) };
        let mounted = |station: f64| (AnyBearing::dispatched(bearing.clone()), springs(), station);
        let [(a, b, at_a), (c, d, at_c)] = [mounted(-0.1), mounted(0.1)];
        let mounted = |bearing, station| BearingAtStation { bearing, station, speed_ratios: SpeedRatios::new(0.4) };
        let bearings = [mounted(a, at_a), mounted(b, at_a), mounted(c, at_c), mounted(d, at_c)];
        let machine = RotorBearingSystem { rotor, bearings };
        let run = |registers: SimdDispatch, method: Method| {
            let length = 39e-6;
            let (step, mut drive) =
                (Step { method, length }, ShaftMotion { angle: Phase::ZERO, speed: 314.0, acceleration: 3.0 });
            let mut state = RotorState::stationary(Displacement::default(), Phase::ZERO, [Phase::ZERO; 4]);
            for _ in 0..500 {
                registers.run(
                    #[inline(always)]
                    || step.step(&machine, &mut state, &drive),
                );
                drive = drive.after(length);
            }
            [state.q, state.velocity].map(|numbers| numbers.map(f64::to_bits))
        };
        for method in [Method::RungeKutta, Method::Newmark { newton_steps: 2 }, Method::Verlet] {
            let moved = run(SimdDispatch::detect(), method);
            assert_eq!(moved, run(SimdDispatch::none(), method), "{method:?}");
            assert_ne!(moved, [[0; 5]; 2], "{method:?}");
        }
        Ok(())
    }
}
