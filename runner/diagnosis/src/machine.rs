//! The machine under a hypothesis: the parameters that a diagnosis varies, and the forces that follow from them.

use super::Result;
use super::decimation::Decimation;
use super::dynamics::{CouplingForce, Tangent};
use super::measurement::{COEFFICIENTS, ReadingError};
use super::motion::{D, Motion};
use ballrace::bearing::Bearing as _;
use ballrace::bearing::Reaction;
use ballrace::{BearingKinematicState, Displacement, Phase};
use ballrace_base::parallel;
use ballrace_models::bearing_model;
use ballrace_models::build::{self, AnyBearing};
use ballrace_plant::{Plant, unbalance_planes};
use ballrace_scene::{Bearing as BearingScene, Defect, Scene, Surface, Unbalance};
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

/// Angle and speed of a cage, and of the balls about their own axes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Cage {
    /// Angle at total revolution 0, revolutions, beyond the scene's.
    pub phase: f64,
    /// Cage speed below pure rolling, as a share of it, in the middle of the record.
    pub slip: f64,
    /// Change of the cage speed, revolutions per square of a shaft revolution.
    pub drift: f64,
    /// Spin angle of the balls at total revolution 0, revolutions.
    pub spin_phase: f64,
    /// Ball spin below pure rolling, as a share of it.
    pub spin_slip: f64,
}

impl Cage {
    /// Returns the revolutions of the cage at a total revolution of the shaft; `rolling` is its speed over the shaft speed by the scene.
    pub fn revolutions(&self, rolling: f64, turns: f64, motion: &Motion) -> f64 {
        let from_middle = turns - motion.middle;
        self.phase + rolling * (1.0 - self.slip) * turns + 0.5 * self.drift * from_middle * from_middle
    }
}

/// One bearing of the machine.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MachineBearing {
    pub scene: BearingScene,
    pub cage: Cage,
    /// Tilt of the outer ring about X and Y, rad.
    pub tilt: [f64; 2],
    /// Diametral play of a ring in its seat, m.
    pub seat_play: f64,
    /// Compliance of the support along X and Y beyond the scene's, m/N.
    pub compliance: [f64; 2],
}

/// A machine under a hypothesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    pub bearings: Vec<MachineBearing>,
    /// Load on the rotor, N and N m, without weight.
    pub load: [f64; D],
    /// Rotor damping, N s/m and N m s/rad.
    pub damping: [f64; D],
    /// Static unbalance (kg m) and couple (kg m^2), each along X and Y at shaft angle 0.
    pub unbalance: [f64; 4],
    /// Force of a coupling.
    pub coupling: CouplingForce,
    /// Errors of the probes' readings beyond those that are expected.
    pub readings: Vec<ReadingError>,
    /// Position of the rotor beyond that of the readings, m and rad: gaps of the probes that are unknown.
    pub position: [f64; D],
}

impl Machine {
    /// Returns the machine of the scene.
    pub fn new(scene: &Scene) -> Option<Self> {
        let rotor = scene.rotor.as_ref()?;
        let mut unbalance = [0.0; 4];
        for one in &rotor.unbalance {
            let (s, c) = one.angle.sin_cos();
            for (sum, part) in unbalance.iter_mut().zip([c, s, one.station * c, one.station * s]) {
                *sum += one.moment * part;
            }
        }
        let bearings = scene
            .bearings
            .iter()
            .map(|b| MachineBearing {
                scene: b.clone(),
                cage: Cage::default(),
                tilt: [0.0; 2],
                seat_play: 0.0,
                compliance: [0.0; 2],
            })
            .collect();
        // The damping of a flexible or supported rotor is part of its equations of motion.
        let damping = if is_rigid(scene) { rotor.damping } else { [0.0; D] };
        let probes = scene.recording.as_ref().map_or(0, |recording| recording.probes.len());
        let readings = vec![[0.0; COEFFICIENTS]; probes];
        Some(Self {
            bearings,
            load: rotor.load,
            damping,
            unbalance,
            coupling: CouplingForce::default(),
            readings,
            position: [0.0; D],
        })
    }
}

impl Machine {
    /// Returns the scene with this machine's bearings, damping and unbalance.
    pub fn scene(&self, scene: &Scene) -> Scene {
        /// Planes that carry the unbalance of a rigid rotor, m.
        const PLANES: [f64; 2] = [0.05, -0.05];
        let is_rigid = is_rigid(scene);
        let mut scene = scene.clone();
        for (to, from) in scene.bearings.iter_mut().zip(&self.bearings) {
            to.geometry = from.scene.geometry;
            to.law = from.scene.law;
        }
        if let Some(rotor) = &mut scene.rotor {
            let [a, b] = match self.bearings.as_slice() {
                [first, second] if !is_rigid => unbalance_planes(rotor, [first.scene.station, second.scene.station]),
                _ => PLANES,
            };
            if is_rigid {
                rotor.damping = self.damping;
            }
            let [ex, ey, cx, cy] = self.unbalance;
            let plane = |station: f64, other: f64| {
                let span = station - other;
                let (x, y) = ((cx - other * ex) / span, (cy - other * ey) / span);
                Unbalance { moment: x.hypot(y), angle: y.atan2(x), station }
            };
            rotor.unbalance = vec![plane(a, b), plane(b, a)];
        }
        scene
    }
}

/// Returns true for a rigid rotor on fixed bearings.
fn is_rigid(scene: &Scene) -> bool {
    scene.rotor.as_ref().is_some_and(|rotor| rotor.flexible.is_none())
        && scene.bearings.iter().all(|b| b.support.is_none())
}

/// Least ratio of the squared radial resultant of the loads to their squared sum at which the contact angle is computed from the radial
/// force; below it, the axial force is used.
const MIN_RADIAL: f64 = 0.01;

/// Samples at which the force is evaluated together: much more work than the start of a thread.
const TOGETHER: usize = 2048;
/// Most steps in which the displacement of a support is found, the step at which it is, m, and the share of the step before from which the
/// stiffness is computed anew.
const SUPPORT_STEPS: usize = 12;
const SUPPORT_CLOSE: f64 = 1e-11;
const SUPPORT_SLOW: f64 = 0.25;
/// Instants in a sample period at which a pulse of a spall is evaluated.
const PARTS: usize = 4;

/// A bearing ready to be evaluated along a motion.
pub struct Evaluated {
    /// The bearing without its spalls.
    bearing: AnyBearing<f64>,
    /// Its balls with and without the spalls.
    passing: Vec<PassingBalls>,
    spalls: Vec<Defect>,
    /// Azimuth of each element with the cage at angle 0, rad.
    azimuths: Vec<f64>,
    /// Displacement of the rotor at the bearing, sample by sample.
    displaced: Arc<Vec<Displacement<f64>>>,
    /// Displacement by preload.
    offset: Displacement<f64>,
    tilt: [f64; 2],
    /// Radial play of a ring in its seat, m.
    seat_play: f64,
    /// Compliance of the support along X and Y, m/N.
    compliance: [f64; 2],
    cage: Cage,
    /// Cage speed over shaft speed by the scene.
    cage_ratio: f64,
    ball_ratio: f64,
}

/// Displacement of a support at a sample.
#[derive(Default)]
struct Support {
    /// Along X and Y, m, and its change since the sample before.
    at: [f64; 2],
    change: [f64; 2],
    /// Inverse of the derivatives of what is left by the displacement.
    inverse: Option<[[f64; 2]; 2]>,
}

impl Support {
    /// Returns Newton's step for what is left; `None` without a stiffness.
    fn step(&self, left: [f64; 2]) -> Option<[f64; 2]> {
        self.inverse.map(|inverse| inverse.map(|row| row[0] * left[0] + row[1] * left[1]))
    }

    /// Sets the derivatives of what is left by the displacement.
    fn stiffen(&mut self, [[a, b], [c, d]]: [[f64; 2]; 2]) {
        let determinant = a * d - b * c;
        self.inverse = Some([[d / determinant, -b / determinant], [-c / determinant, a / determinant]]);
    }
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}

/// Balls whose force is evaluated while one of them is on a spall: the force of the other balls is the same with and without it.
struct PassingBalls {
    balls: Range<usize>,
    sound: AnyBearing<f64>,
    damaged: AnyBearing<f64>,
}

/// Returns a bearing with ball `j` alone and the spalls that it can pass; `None` if there are none.
fn alone(of: &BearingScene, j: usize) -> Option<BearingScene> {
    let on_ball = |spall: &Defect| match spall.surface {
        Surface::Ball(other) => (other == j).then_some(Defect { surface: Surface::Ball(0), ..*spall }),
        Surface::Inner | Surface::Outer => Some(*spall),
    };
    let defect: Vec<Defect> = of.defect.iter().filter_map(on_ball).collect();
    let azimuth = build::element_azimuth(of, j).radians() - of.first_element_azimuth;
    (!defect.is_empty()).then(|| BearingScene {
        elements: 1,
        element_azimuths: vec![azimuth],
        cage_runout: None,
        defect,
        ..of.clone()
    })
}

impl PassingBalls {
    /// Returns the balls of a bearing with spalls, each alone. The points of a displaced housing belong to all balls, and a table is
    /// expensive: such a bearing is evaluated as a whole.
    fn of(bearing: &BearingScene, built: impl Fn(&BearingScene) -> Result<AnyBearing<f64>>) -> Result<Vec<Self>> {
        let pair = |balls: Range<usize>, with: &BearingScene| {
            let sound = built(&BearingScene { defect: vec![], ..with.clone() })?;
            Ok(Self { balls, sound, damaged: built(with)? })
        };
        if bearing.defect.is_empty() {
            return Ok(vec![]);
        }
        if !bearing_model(bearing.evaluated_model()).has_cheap_elements() || !bearing.has_rigid_outer_ring() {
            return Ok(vec![pair(0..bearing.elements, bearing)?]);
        }
        let single = |j: usize| Some(pair(j..j + 1, &alone(bearing, j)?));
        (0..bearing.elements).filter_map(single).collect()
    }
}

impl Evaluated {
    /// Creates the bearing with the displacement of the rotor there, sample by sample.
    pub fn new(
        scene: &Scene,
        plant: &Plant,
        i: usize,
        of: &MachineBearing,
        displaced: Arc<Vec<Displacement<f64>>>,
    ) -> Result<Self> {
        let built = |of: &BearingScene| build::bearing(scene, of, of.evaluated_model());
        let sound = BearingScene { defect: vec![], ..of.scene.clone() };
        let kinematics = &plant.bearings[i].kinematics;
        Ok(Self {
            bearing: built(&sound)?,
            passing: PassingBalls::of(&of.scene, built)?,
            spalls: of.scene.defect.clone(),
            azimuths: plant.bearings[i].element_azimuths.iter().map(|a| a.radians()).collect(),
            offset: plant.bearings[i].offset,
            tilt: of.tilt,
            seat_play: 0.5 * of.seat_play,
            compliance: of.compliance,
            displaced,
            cage: of.cage,
            cage_ratio: kinematics.cage_ratio,
            ball_ratio: kinematics.ball_ratio() * (1.0 - of.cage.spin_slip),
        })
    }

    /// Returns the kinematic state at sample `t`.
    pub fn state(&self, motion: &Motion, t: usize) -> BearingKinematicState<f64> {
        self.state_at(motion, motion.turns[t], motion.speed[t])
    }

    fn state_at(&self, motion: &Motion, turns: f64, speed: f64) -> BearingKinematicState<f64> {
        BearingKinematicState {
            cage: Phase::from_revolutions(self.cage.revolutions(self.cage_ratio, turns, motion)),
            inner: Phase::from_revolutions(turns),
            outer: Phase::ZERO,
            ball: Phase::from_revolutions(self.cage.spin_phase + self.ball_ratio * turns),
            inner_speed: speed,
            outer_speed: 0.0,
        }
    }

    /// Returns the displacement of the inner ring against the outer ring, from that of the rotor.
    fn displacement(&self, of_rotor: &Displacement<f64>, state: &BearingKinematicState<f64>) -> Displacement<f64> {
        self.displacement_after(of_rotor, &mut Support::default(), state)
    }

    /// Returns the same with the support of a sample before, and moves it on.
    fn displacement_after(
        &self,
        of_rotor: &Displacement<f64>,
        support: &mut Support,
        state: &BearingKinematicState<f64>,
    ) -> Displacement<f64> {
        let u = *of_rotor + self.offset;
        let ([x, y], _) = left_by_play([u.u, u.v], self.seat_play);
        let u = Displacement { u: x, v: y, thu: u.thu - self.tilt[0], thv: u.thv - self.tilt[1], ..u };
        if self.is_supported() { self.on_support(u, support, state) } else { u }
    }

    fn is_supported(&self) -> bool {
        self.compliance != [0.0; 2]
    }

    /// Returns the displacement of the inner ring against an outer ring whose support yields to the force, from that of the inner ring.
    ///
    /// The force grows with the displacement, so that Newton's method converges. The stiffness is that of a sample before as long as it does.
    fn on_support(
        &self,
        of_inner: Displacement<f64>,
        support: &mut Support,
        state: &BearingKinematicState<f64>,
    ) -> Displacement<f64> {
        let [cx, cy] = self.compliance;
        let from = support.at;
        let [x, y] = std::array::from_fn(|i| from[i] + support.change[i]);
        let mut u = Displacement { u: of_inner.u - x, v: of_inner.v - y, ..of_inner };
        let mut before = f64::INFINITY;
        for _ in 0..SUPPORT_STEPS {
            let wrench = self.bearing.reaction(&u, state).wrench;
            let left = [u.u - of_inner.u - cx * wrench.fx, u.v - of_inner.v - cy * wrench.fy];
            let mut step = support.step(left);
            if step.is_none_or(|step| length(step) > SUPPORT_SLOW * before) {
                let (_, k) = self.bearing.reaction_and_stiffness(&u, state);
                support.stiffen([[1.0 + cx * k[(0, 0)], cx * k[(0, 1)]], [cy * k[(1, 0)], 1.0 + cy * k[(1, 1)]]]);
                step = support.step(left);
            }
            let Some([dx, dy]) = step else { break };
            u = Displacement { u: u.u - dx, v: u.v - dy, ..u };
            before = length([dx, dy]);
            if before < SUPPORT_CLOSE {
                break;
            }
        }
        support.at = [of_inner.u - u.u, of_inner.v - u.v];
        support.change = std::array::from_fn(|i| support.at[i] - from[i]);
        u
    }

    /// Returns the force on the rotor of the bearing with its spalls, at its own station, at every sample.
    pub fn all_forces(&self, motion: &Motion) -> Vec<[f64; D]> {
        let mut forces = self.forces(motion);
        for (force, pulse) in forces.iter_mut().zip(self.pulses(motion).into_iter().flatten()) {
            force.iter_mut().zip(pulse).for_each(|(force, x)| *force += x);
        }
        forces
    }

    /// Returns the same without its spalls.
    pub fn forces(&self, motion: &Motion) -> Vec<[f64; D]> {
        self.forces_in(&|t| self.displaced[t], &|t| self.state(motion, t))
    }

    /// Returns the same with the cage at one angle.
    pub(crate) fn forces_at(&self, motion: &Motion, cage: Phase) -> Vec<[f64; D]> {
        self.forces_in(&|t| self.displaced[t], &|t| BearingKinematicState { cage, ..self.state(motion, t) })
    }

    /// Returns the same with errors of the displacement of the rotor.
    pub(crate) fn forces_with(
        &self,
        motion: &Motion,
        error: &(dyn Fn(usize) -> Displacement<f64> + Sync),
    ) -> Vec<[f64; D]> {
        self.forces_in(&|t| self.displaced[t] + error(t), &|t| self.state(motion, t))
    }

    /// Returns the forces at displacements of the rotor in kinematic states, sample by sample.
    fn forces_in(
        &self,
        of_rotor: &(dyn Fn(usize) -> Displacement<f64> + Sync),
        state: &(dyn Fn(usize) -> BearingKinematicState<f64> + Sync),
    ) -> Vec<[f64; D]> {
        let starts: Vec<usize> = (0..self.displaced.len()).step_by(TOGETHER).collect();
        let piece = |from: &usize| {
            let piece = *from..self.displaced.len().min(from + TOGETHER);
            let at: Vec<_> = piece.clone().map(state).collect();
            let mut support = Support::default();
            let u: Vec<_> =
                piece.zip(&at).map(|(t, at)| self.displacement_after(&of_rotor(t), &mut support, at)).collect();
            let mut reactions = vec![Reaction::default(); u.len()];
            self.bearing.reactions(&u, &at, &mut reactions);
            reactions.iter().map(|reaction| reaction.wrench.to_array()).collect::<Vec<_>>()
        };
        parallel::map(&starts, piece).into_iter().flatten().collect()
    }

    /// Returns the change of the force by the spalls at every sample; `None` without a spall.
    ///
    /// A ball passes a spall within a few samples, and the pulse would be aliased: it is evaluated at several instants of a sample period,
    /// and lines beyond those in use are removed.
    pub fn pulses(&self, motion: &Motion) -> Option<Vec<[f64; D]>> {
        if self.passing.is_empty() {
            return None;
        }
        let low_pass = Decimation::new(PARTS);
        let mut sums = vec![[0.0; D]; motion.len()];
        for one in &self.passing {
            let is_passing = |t: &usize| self.passes(&one.balls, motion, motion.turns[*t], motion.turns[t + 1]);
            let passing: Vec<usize> = (0..motion.len() - 1).filter(is_passing).collect();
            let pieces: Vec<&[usize]> = passing.chunks(TOGETHER).collect();
            let changes = parallel::map(&pieces, |piece| self.changes(one, motion, piece));
            for (t, changes) in passing.iter().zip(changes.iter().flatten()) {
                for (part, change) in changes.iter().enumerate() {
                    low_pass.add(PARTS * t + part, change, &mut sums);
                }
            }
        }
        Some(sums)
    }

    /// Returns the changes of the force of some balls by the spalls at the instants of some sample periods.
    fn changes(&self, of: &PassingBalls, motion: &Motion, samples: &[usize]) -> Vec<[[f64; D]; PARTS]> {
        let mut support = Support::default();
        let instants = samples.iter().flat_map(|&t| (0..PARTS).map(move |part| (t, part as f64 / PARTS as f64)));
        let (u, at): (Vec<_>, Vec<_>) = instants
            .map(|(t, share)| {
                let turns = motion.turns[t] + share * (motion.turns[t + 1] - motion.turns[t]);
                let [from, to] = [t, t + 1].map(|t| self.displaced[t].to_array());
                let q = Displacement::from_array(std::array::from_fn(|i| from[i] + share * (to[i] - from[i])));
                let state = self.state_at(motion, turns, motion.speed[t]);
                (self.displacement_after(&q, &mut support, &state), state)
            })
            .unzip();
        let [with, without] = [&of.damaged, &of.sound].map(|of| {
            let mut reactions = vec![Reaction::default(); u.len()];
            of.reactions(&u, &at, &mut reactions);
            reactions
        });
        let change = |(with, without): (&Reaction<f64>, &Reaction<f64>)| -> [f64; D] {
            let (with, without) = (with.wrench.to_array(), without.wrench.to_array());
            std::array::from_fn(|i| with[i] - without[i])
        };
        let changes: Vec<[f64; D]> = with.iter().zip(&without).map(change).collect();
        changes.chunks_exact(PARTS).map(|parts| std::array::from_fn(|part| parts[part])).collect()
    }

    /// Returns true where one of `balls` is on a spall between two positions of the shaft.
    fn passes(&self, balls: &Range<usize>, motion: &Motion, from: f64, to: f64) -> bool {
        let middle = 0.5 * (from + to);
        let cage = TAU * self.cage.revolutions(self.cage_ratio, middle, motion);
        let ball = TAU * (self.cage.spin_phase + self.ball_ratio * middle);
        let near = |angle: f64, reach: f64| (angle - TAU * (angle / TAU).round()).abs() < reach;
        let azimuths = &self.azimuths[balls.clone()];
        self.spalls.iter().any(|spall| {
            let moved = |ratio: f64| 0.5 * (TAU * ratio * (to - from)).abs() + spall.half_width;
            let cage_ratio = self.cage_ratio * (1.0 - self.cage.slip);
            match spall.surface {
                Surface::Outer => azimuths.iter().any(|a| near(cage + a - spall.azimuth, moved(cage_ratio))),
                Surface::Inner => {
                    let inner = TAU * middle + spall.azimuth;
                    azimuths.iter().any(|a| near(cage + a - inner, moved(1.0 - cage_ratio)))
                }
                Surface::Ball(j) => {
                    let reach = moved(self.ball_ratio);
                    balls.contains(&j)
                        && (near(ball - spall.azimuth, reach) || near(ball + 0.5 * TAU - spall.azimuth, reach))
                }
            }
        })
    }

    /// Returns the force at sample `t` with an error of the displacement of the rotor.
    pub(crate) fn force_with(&self, motion: &Motion, t: usize, error: &Displacement<f64>) -> [f64; D] {
        self.wrench(&self.bearing, &(self.displaced[t] + *error), &self.state(motion, t))
    }

    /// Returns the change of the force by the spalls at sample `t` with the cage at another angle, at which only the first ball is on
    /// a spall.
    pub(crate) fn change_at_first_ball(&self, motion: &Motion, t: usize, cage: Phase) -> [f64; D] {
        let state = BearingKinematicState { cage, ..self.state(motion, t) };
        let Some(one) = self.passing.first() else { return [0.0; D] };
        let [with, without] = [&one.damaged, &one.sound].map(|of| self.wrench(of, &self.displaced[t], &state));
        std::array::from_fn(|i| with[i] - without[i])
    }

    fn wrench(&self, of: &AnyBearing<f64>, at: &Displacement<f64>, state: &BearingKinematicState<f64>) -> [f64; D] {
        of.reaction(&self.displacement(at, state), state).wrench.to_array()
    }

    /// Returns the cosine of the contact angle, weighted by the loads along the motion: the component of a radial deviation of a groove
    /// normal to its surface.
    pub fn contact_cosine(&self, motion: &Motion) -> f64 {
        let (mut radial, mut axial, mut projected, mut total) = (0.0, 0.0, 0.0, 0.0);
        let mut loads = vec![0.0; self.azimuths.len()];
        for t in (0..motion.len()).step_by((motion.len() / 500).max(1)) {
            let state = self.state(motion, t);
            let u = self.displacement(&self.displaced[t], &state);
            self.bearing.element_loads(&u, &state, &mut loads);
            let force = self.bearing.reaction(&u, &state).wrench;
            let (mut x, mut y) = (0.0, 0.0);
            for (load, azimuth) in loads.iter().zip(&self.azimuths) {
                let (s, c) = (azimuth + state.cage.radians()).sin_cos();
                (x, y) = (x + load * c, y + load * s);
                total += load;
            }
            // The radial force is the sum of the loads by their azimuth, times the cosine.
            projected -= force.fx * x + force.fy * y;
            radial += x * x + y * y;
            axial += force.fz;
        }
        if radial > MIN_RADIAL * total * total / 500.0 {
            (projected / radial).clamp(0.0, 1.0)
        } else {
            (1.0 - (axial / total.max(f64::MIN_POSITIVE)).powi(2)).max(0.0).sqrt()
        }
    }

    /// Returns the tangent stiffness at sample `t`, at the bearing's own station.
    pub fn tangent(&self, motion: &Motion, t: usize) -> Tangent {
        let of_rotor = self.displaced[t] + self.offset;
        let state = self.state(motion, t);
        let u = self.displacement(&self.displaced[t], &state);
        let (_, k) = self.bearing.reaction_and_stiffness(&u, &state);
        let (_, by_rotor) = left_by_play([of_rotor.u, of_rotor.v], self.seat_play);
        let mut moved = Tangent::identity();
        for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            moved[(i, j)] = by_rotor[i][j];
        }
        let k = Tangent::from_fn(|i, j| k[(i, j)]);
        let on_support = || {
            let mut yielding = Tangent::identity();
            for (i, compliance) in self.compliance.into_iter().enumerate() {
                (0..D).for_each(|j| yielding[(i, j)] += compliance * k[(i, j)]);
            }
            yielding.try_inverse().unwrap_or_else(Tangent::identity)
        };
        if self.is_supported() { k * on_support() * moved } else { k * moved }
    }
}

/// Returns the part of a radial displacement that the elements have where a ring is free to move by `play` in its seat, and its derivatives: the
/// force presses the ring against its seat along the displacement, and across it the ring rolls.
fn left_by_play(displacement: [f64; 2], play: f64) -> ([f64; 2], [[f64; 2]; 2]) {
    if play == 0.0 {
        return (displacement, [[1.0, 0.0], [0.0, 1.0]]);
    }
    let radius = displacement[0].hypot(displacement[1]);
    if radius <= play {
        return ([0.0; 2], [[0.0; 2]; 2]);
    }
    let share = 1.0 - play / radius;
    let along = displacement.map(|x| x / radius);
    let derivative = |i: usize, j: usize| share * f64::from(u8::from(i == j)) + (1.0 - share) * along[i] * along[j];
    (displacement.map(|x| share * x), [0, 1].map(|i| [0, 1].map(|j| derivative(i, j))))
}

/// Returns the diametral clearance of a bearing, m.
pub fn clearance(of: &BearingScene) -> f64 {
    of.clearance().unwrap_or(0.0)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::faults::{CLEARANCE, UNBALANCE};
    use super::super::parameter::DAMPING;
    use super::*;
    use ballrace_plant::probes::PoseSolver;
    use ballrace_recording::Row;
    use ballrace_recording::Sample;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    const SCENE: &str = r#"
        [shaft]
        speed = "3000 rpm"
        [rotor]
        mass = "6 kg"
        diametral_inertia = 0.030
        polar_inertia = 0.006
        damping = [400, 400, 400, 0.4, 0.4]
        unbalance = [{ moment = "120 g mm", angle = "17 deg", station = "20 mm" }]
        [[bearing]]
        name = "DE"
        station = "-100 mm"
        facing = "both"
        model = "angular"
        elements = 9
        ball_diameter = "7.94 mm"
        pitch_diameter = "39.04 mm"
        inner_conformity = 0.52
        outer_conformity = 0.52
        diametral_clearance = "10 um"
    "#;

    /// Shorter by the play along the displacement, with the derivatives of difference quotients.
    #[test]
    fn a_loose_ring_gives_way_by_its_play() {
        let (play, step) = (3e-6, 1e-10);
        let at = [4e-6, -6e-6];
        let ([x, y], derivative) = left_by_play(at, play);
        assert!((x.hypot(y) - (at[0].hypot(at[1]) - play)).abs() < 1e-18);
        assert!((x * at[1] - y * at[0]).abs() < 1e-24, "not along the displacement");
        for (j, unit) in [[step, 0.0], [0.0, step]].into_iter().enumerate() {
            let side = |sign: f64| left_by_play([at[0] + sign * unit[0], at[1] + sign * unit[1]], play).0;
            for (i, row) in derivative.iter().enumerate() {
                let quotient = (side(1.0)[i] - side(-1.0)[i]) / (2.0 * step);
                assert!((row[j] - quotient).abs() < 1e-6, "{i} {j}: {} and {quotient}", row[j]);
            }
        }
        assert_eq!(left_by_play([1e-6, 2e-6], play), ([0.0; 2], [[0.0; 2]; 2]));
        assert_eq!(left_by_play(at, 0.0).0, at);
    }

    /// The force moves the outer ring by the compliance, and the stiffness of both is the derivative of the force.
    #[test]
    fn a_support_yields_to_the_force() {
        let probe = |name: &str, station: &str, angle: u32| {
            format!("{{ column = \"{name}\", unit = \"um\", station = \"{station}\", angle = \"{angle} deg\" }}, ")
        };
        let probes = [("a", "-100 mm", 0), ("b", "-100 mm", 90), ("c", "100 mm", 0), ("d", "100 mm", 90)];
        let probes: String = probes.iter().map(|(name, station, angle)| probe(name, station, *angle)).collect();
        let text = format!("{SCENE}\n[recording]\nfile = \"a.csv\"\nrate = \"1 kHz\"\nprobes = [{probes}]\n");
        let scene = read_str(&text, Path::new("scene.toml")).unwrap();
        let plant = Plant::try_new(&scene).unwrap();
        let stations: Vec<f64> = scene.bearings.iter().map(|bearing| bearing.station).collect();
        let solver = PoseSolver::try_new(&scene.recording.as_ref().unwrap().probes, &stations).unwrap();
        let samples = vec![Sample { row: Row { probes: vec![0.0; 4], ..Row::default() }, ..Sample::default() }; 2];
        let motion = Motion::new(&samples, 1e-3, &solver, 0.0);
        let compliance = [2e-8, 5e-8];
        let bearing = MachineBearing { compliance, ..Machine::new(&scene).unwrap().bearings[0].clone() };
        let at = |x: f64, y: f64| {
            let displaced = vec![Displacement { u: x, v: y, w: 2e-6, ..Displacement::default() }; 2];
            Evaluated::new(&scene, &plant, 0, &bearing, Arc::new(displaced)).unwrap()
        };
        let [x, y] = [7e-6, -16e-6];
        let yielding = at(x, y);
        let (state, force) = (yielding.state(&motion, 0), yielding.forces(&motion)[0]);
        let left = yielding.displacement(&yielding.displaced[0], &state);
        assert!(force[0].abs() > 10.0 && force[1].abs() > 10.0, "{force:?}");
        let close = SUPPORT_SLOW * SUPPORT_CLOSE;
        assert!((left.u - x - compliance[0] * force[0]).abs() < close);
        assert!((left.v - y - compliance[1] * force[1]).abs() < close);
        let k = yielding.tangent(&motion, 0);
        let step = 1e-10;
        for (j, [dx, dy]) in [[step, 0.0], [0.0, step]].into_iter().enumerate() {
            let [with, against] = [1.0, -1.0].map(|sign| at(x + sign * dx, y + sign * dy).forces(&motion)[0]);
            for i in 0..D {
                let quotient = -(with[i] - against[i]) / (2.0 * step);
                assert!((k[(i, j)] - quotient).abs() < 1e-4 * k[(1, 1)].abs(), "{i} {j}: {} and {quotient}", k[(i, j)]);
            }
        }
    }

    #[test]
    fn unbalance_and_clearance_of_a_machine_make_a_scene() {
        let scene = read_str(SCENE, Path::new("scene.toml")).unwrap();
        let mut machine = Machine::new(&scene).unwrap();
        CLEARANCE.of_bearing(0).set(&mut machine, 14e-6);
        UNBALANCE.of_rotor(1).set(&mut machine, 2e-4);
        DAMPING.of_rotor(0).set(&mut machine, 300.0);
        let again = Machine::new(&machine.scene(&scene)).unwrap();
        assert!((clearance(&again.bearings[0].scene) - 14e-6).abs() < 1e-15);
        for (a, b) in machine.unbalance.iter().zip(again.unbalance) {
            assert!((a - b).abs() < 1e-15, "{a} {b}");
        }
        assert_eq!(again.damping, [300.0, 300.0, 300.0, 0.4, 0.4]);
    }
}
