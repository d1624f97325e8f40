//! The twin of a plant with bearings whose balls and cage are bodies: one system, integrated with error control.

use super::machine::{ReactingElement, SystemTask};
use super::plant_error::Result;
use super::system::{Rows, array};
use super::{Plant, Twin};
use ballrace::contact::hertz::Race;
use ballrace::rotor::{RotorBearingSystem, SecondOrderSystem, ShaftMotion};
use ballrace::{BearingKinematicState, Phase, Status, Wrench};
use ballrace_models::build::{Kinematics, point_contact_approach};
use ballrace_multibody::{Balance, ElementMotion, Integrator, Motion, MultibodyBearing, RingMotion, Steps};
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// Checks of the integration of bearings with bodies.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MultibodyChecks {
    /// Numbers of steps.
    pub steps: Steps,
    /// Balances of each bearing with bodies, by its number in the scene.
    pub balances: Vec<(usize, Balance)>,
}

/// Bearing with bodies in a plant.
#[derive(Clone)]
struct BearingWithBodies {
    /// Number of the bearing in the scene.
    index: usize,
    bearing: Arc<MultibodyBearing>,
    /// Displacement of the inner and the outer ring per unit of each coordinate.
    rows: Arc<[Rows; 2]>,
    /// Displacement of the inner ring by preload.
    offset: [f64; 5],
    /// Its numbers in the state, and in the approaches of contacts.
    state: Range<usize>,
    contacts: Range<usize>,
    /// State and rings at the start, for the balances.
    first: Arc<(Vec<f64>, [RingMotion; 2])>,
}

impl Plant {
    /// Returns true where a bearing has balls and cage as bodies.
    #[must_use]
    pub fn has_bodies(&self) -> bool {
        self.bearings.iter().any(|mounted| mounted.multibody.is_some())
    }

    /// Returns the twin at rest with the shaft at the given revolutions, where a bearing has bodies.
    pub(super) fn start_multibody(&self, sample_period: f64, revolutions: f64) -> Result<Box<dyn Twin>> {
        self.with_machine(
            super::MountedBearing::beside_bodies,
            StartMultibody { plant: self, sample_period, revolutions },
        )
    }

    fn rows_of_rings(&self, i: usize) -> [Rows; 2] {
        let relative = self.layout.attached(i).cloned().unwrap_or_default();
        let mut outer: Rows = std::array::from_fn(|_| vec![0.0; self.layout.order]);
        if let Some(first) = self.layout.housing(i) {
            (outer[0][first], outer[1][first + 1]) = (1.0, 1.0);
        }
        let inner = std::array::from_fn(|k| relative[k].iter().zip(&outer[k]).map(|(a, b)| a + b).collect());
        [inner, outer]
    }
}

struct StartMultibody<'a> {
    plant: &'a Plant,
    sample_period: f64,
    revolutions: f64,
}

impl SystemTask<Box<dyn Twin>> for StartMultibody<'_> {
    fn run<S, C, const D: usize, const N: usize>(self, machine: RotorBearingSystem<S, C, N>) -> Box<dyn Twin>
    where
        S: SecondOrderSystem<f64, D> + Clone + Send + 'static,
        C: ReactingElement<D> + Clone + Send + 'static,
    {
        let Self { plant, sample_period, revolutions } = self;
        let coordinates = plant.layout.order;
        let shaft =
            ShaftMotion { angle: Phase::from_revolutions(revolutions), speed: plant.speed(), acceleration: 0.0 };
        let mut state = plant.rest.clone();
        state.resize(2 * coordinates, 0.0);
        let mut tolerances = vec![f64::INFINITY; state.len()];
        let (mut bodies, mut contacts) = (vec![], 0);
        let mut system = RotorWithBodies {
            machine,
            kinematics: plant.bearings.iter().map(|mounted| mounted.kinematics).collect(),
            bodies: vec![],
            load: [0.0; D],
            coordinates,
            turned: revolutions,
            shaft,
        };
        let mut position = f64::INFINITY;
        for (index, mounted) in plant.bearings.iter().enumerate() {
            let Some(bearing) = &mounted.multibody else { continue };
            let start = state.len();
            state.resize(start + bearing.order(), 0.0);
            let range = start..state.len();
            let mut attached = BearingWithBodies {
                index,
                bearing: bearing.clone(),
                rows: Arc::new(plant.rows_of_rings(index)),
                offset: mounted.offset.to_array(),
                state: range.clone(),
                contacts: contacts..contacts + bearing.contacts(),
                first: Arc::default(),
            };
            contacts += bearing.contacts();
            let (at, rings) = (system.kinematic_state(index, 0.0), system.rings(&attached, &state, 0.0));
            let balls = mounted.ball_states(plant.displacement(index, &plant.rest), &at);
            let stiffness = bearing.params().geometry.contact(Race::Outer).stiffness;
            let place = |j: usize| {
                let Some(ball) = balls.get(j) else { return [bearing.params().geometry.contact_angle, 0.0] };
                let [cos, sin] = ball.outer_direction;
                [sin.atan2(cos), point_contact_approach(stiffness, ball.outer_load.max(0.0))]
            };
            bearing.start(&rings, at.cage.since(Phase::ZERO).radians(), place, &mut state[range.clone()]);
            tolerances.resize(state.len(), 0.0);
            position = position.min(bearing.params().step_error);
            bearing.tolerances(&mut tolerances[range.clone()]);
            attached.first = Arc::new((state[range].to_vec(), rings));
            bodies.push(attached);
        }
        let velocity = position * plant.highest_frequency().max(1e3);
        for (i, tolerance) in tolerances.iter_mut().take(2 * coordinates).enumerate() {
            *tolerance = if i < coordinates { position } else { velocity };
        }
        system.bodies = bodies;
        let mut twin = MultibodyTwin {
            integrator: Integrator::new(tolerances, contacts),
            system,
            state,
            wrenches: vec![],
            sample_period,
        };
        twin.update_wrenches();
        Box::new(twin)
    }
}

/// Rotor and bearings during one sample period.
#[derive(Clone)]
struct RotorWithBodies<S, C, const D: usize, const N: usize> {
    machine: RotorBearingSystem<S, C, N>,
    kinematics: Vec<Kinematics>,
    bodies: Vec<BearingWithBodies>,
    /// Load on the coordinates besides that of the scene.
    load: [f64; D],
    coordinates: usize,
    /// Revolutions and motion of the shaft at time 0 of the sample period.
    turned: f64,
    shaft: ShaftMotion<f64>,
}

impl<S, C, const D: usize, const N: usize> RotorWithBodies<S, C, D, N>
where
    S: SecondOrderSystem<f64, D>,
    C: ReactingElement<D>,
{
    fn turned_at(&self, time: f64) -> f64 {
        self.turned + time * (self.shaft.speed + 0.5 * self.shaft.acceleration * time) / TAU
    }

    fn kinematic_state(&self, i: usize, time: f64) -> BearingKinematicState<f64> {
        self.kinematics.get(i).map_or_else(BearingKinematicState::default, |kinematics| {
            let parts = kinematics.parts_at(self.turned_at(time));
            kinematics.speed_ratios().kinematic_state(parts, &self.shaft.after(time))
        })
    }

    fn rings(&self, attached: &BearingWithBodies, state: &[f64], time: f64) -> [RingMotion; 2] {
        let (q, v) = state.split_at(self.coordinates);
        let product = |rows: &Rows, x: &[f64]| rows.each_ref().map(|row| row.iter().zip(x).map(|(t, x)| t * x).sum());
        let at = self.kinematic_state(attached.index, time);
        let [mut inner, outer] = [0, 1].map(|i| RingMotion {
            displacement: product(&attached.rows[i], q),
            rate: product(&attached.rows[i], v),
            angle: [at.inner, at.outer][i],
            speed: [at.inner_speed, at.outer_speed][i],
        });
        inner.displacement.iter_mut().zip(attached.offset).for_each(|(x, offset)| *x += offset);
        [inner, outer]
    }
}

impl<S, C, const D: usize, const N: usize> Motion for RotorWithBodies<S, C, D, N>
where
    S: SecondOrderSystem<f64, D>,
    C: ReactingElement<D>,
{
    fn rates(&mut self, time: f64, state: &[f64], rates: &mut [f64], approaches: &mut [f64]) {
        let n = self.coordinates;
        let shaft = self.shaft.after(time);
        let (q, v): ([f64; D], [f64; D]) = (array(&state[..n]), array(&state[n..2 * n]));
        let mut force = self.machine.rotor.excitation(&shaft);
        let inside = self.machine.rotor.internal_force(&q, &v, shaft.speed);
        force.iter_mut().zip(inside).zip(self.load).for_each(|((f, inside), load)| *f += inside + load);
        for (i, bearing) in self.machine.bearings.iter().enumerate() {
            bearing.add_force(&q, &self.kinematic_state(i, time), &mut force);
        }
        for attached in &self.bodies {
            let range = attached.state.clone();
            let wrenches = attached.bearing.rates(
                &state[range.clone()],
                &self.rings(attached, state, time),
                &mut rates[range],
                &mut approaches[attached.contacts.clone()],
            );
            for (rows, wrench) in attached.rows.iter().zip(wrenches) {
                for (row, component) in rows.iter().zip(wrench) {
                    force.iter_mut().zip(row).for_each(|(f, t)| *f += t * component);
                }
            }
        }
        let acceleration = self.machine.rotor.acceleration(&force);
        rates[..n].copy_from_slice(&v[..n]);
        rates[n..2 * n].copy_from_slice(&acceleration[..n]);
    }

    fn normalise(&self, state: &mut [f64]) {
        for attached in &self.bodies {
            attached.bearing.normalise(&mut state[attached.state.clone()]);
        }
    }
}

#[derive(Clone)]
struct MultibodyTwin<S, C, const D: usize, const N: usize> {
    system: RotorWithBodies<S, C, D, N>,
    integrator: Integrator,
    state: Vec<f64>,
    /// Force of each bearing with bodies on its inner ring.
    wrenches: Vec<(usize, Wrench<f64>)>,
    sample_period: f64,
}

impl<S, C, const D: usize, const N: usize> MultibodyTwin<S, C, D, N>
where
    S: SecondOrderSystem<f64, D>,
    C: ReactingElement<D>,
{
    /// Begins the balances with the present state.
    fn begin_balances(&mut self) {
        for i in 0..self.system.bodies.len() {
            let attached = &self.system.bodies[i];
            let first = (self.state[attached.state.clone()].to_vec(), self.system.rings(attached, &self.state, 0.0));
            self.system.bodies[i].first = Arc::new(first);
        }
    }

    fn update_wrenches(&mut self) {
        let (mut rates, mut approaches) = (vec![0.0; self.state.len()], vec![]);
        let system = &self.system;
        let wrench = |attached: &BearingWithBodies| {
            let (range, rings) = (attached.state.clone(), system.rings(attached, &self.state, 0.0));
            let [inner, _] =
                attached.bearing.rates(&self.state[range.clone()], &rings, &mut rates[range], &mut approaches);
            (attached.index, Wrench::from_array(inner))
        };
        self.wrenches = system.bodies.iter().map(wrench).collect();
    }
}

impl<S, C, const D: usize, const N: usize> Twin for MultibodyTwin<S, C, D, N>
where
    S: SecondOrderSystem<f64, D> + Clone + Send + 'static,
    C: ReactingElement<D> + Clone + Send + 'static,
{
    fn step(&mut self, drive: &ShaftMotion<f64>) -> Status {
        self.system.shaft = *drive;
        if !self.integrator.advance(&mut self.system, &mut self.state, self.sample_period) {
            return Status::RESULT_NOT_FINITE;
        }
        self.system.turned = self.system.turned_at(self.sample_period);
        self.system.shaft = drive.after(self.sample_period);
        self.update_wrenches();
        Status::OK
    }
    fn coordinates(&self) -> &[f64] {
        &self.state[..self.system.coordinates]
    }
    fn rates(&self) -> &[f64] {
        &self.state[self.system.coordinates..2 * self.system.coordinates]
    }
    fn wrench(&self, i: usize, at: &BearingKinematicState<f64>) -> Wrench<f64> {
        if let Some((_, wrench)) = self.wrenches.iter().find(|(index, _)| *index == i) {
            return *wrench;
        }
        let q: [f64; D] = array(self.coordinates());
        self.system.machine.bearings.get(i).map_or_else(Wrench::default, |b| b.reaction(&q, at).wrench)
    }
    fn place(&mut self, coordinates: &[f64], rates: &[f64]) {
        let (q, rest) = self.state.split_at_mut(self.system.coordinates);
        for (to, from) in [(q, coordinates), (&mut rest[..self.system.coordinates], rates)] {
            to.iter_mut().zip(from).for_each(|(entry, x)| *entry = *x);
        }
        self.begin_balances();
        self.update_wrenches();
    }
    fn turn_cage(&mut self, i: usize, by: Phase) {
        for attached in self.system.bodies.iter().filter(|attached| attached.index == i) {
            attached.bearing.turn(&mut self.state[attached.state.clone()], by.since(Phase::ZERO).radians());
        }
        self.begin_balances();
    }
    fn set_load(&mut self, load: &[f64]) {
        self.system.load = array(load);
    }
    fn copy(&self) -> Box<dyn Twin> {
        Box::new(self.clone())
    }
    fn element_motion(&self, i: usize) -> Option<ElementMotion> {
        let attached = self.system.bodies.iter().find(|attached| attached.index == i)?;
        let rings = self.system.rings(attached, &self.state, 0.0);
        Some(attached.bearing.motion(&self.state[attached.state.clone()], &rings))
    }
    fn multibody_checks(&self) -> Option<MultibodyChecks> {
        let balance = |attached: &BearingWithBodies| {
            let rings = self.system.rings(attached, &self.state, 0.0);
            let (first, last) = (&attached.first, &self.state[attached.state.clone()]);
            (attached.index, attached.bearing.balance((&first.0, &first.1), (last, &rings)))
        };
        Some(MultibodyChecks {
            steps: self.integrator.steps(),
            balances: self.system.bodies.iter().map(balance).collect(),
        })
    }
}
