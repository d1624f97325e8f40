//! The digital twin: the scene's rotor on the scene's bearings, driven by the shaft angle alone.

use crate::scene::build::{self, AnyBearing, Kinematics};
use crate::scene::{Linear, Model, Rotor, Scene};
use anyhow::{Context, Result, bail};
use ballrace::bearing::Bearing;
use ballrace::rotor::{
    Drive, Integrator, Machine, Mounted, PartAngles, RigidRotor, RotorState, RungeKutta4, equilibrium,
};
use ballrace::{Displacement, Exact, Rotation, Status, Stiffness, Turn};
use std::f64::consts::TAU;

/// Most bearings on one rotor.
pub const MOST_BEARINGS: usize = 8;
/// Product of step and highest natural frequency: Runge-Kutta's relative frequency error is its 4th power over 120,
/// 5e-4 at the top of the spectrum and far less where the rotor moves; the stability limit is 2.8.
const LARGEST_PHASE_STEP: f64 = 0.5;
/// Rest positions over one ball pitch that a linearised bearing is the mean of.
const PITCH_SAMPLES: u32 = 16;

/// A bearing on the rotor, ready to be evaluated.
#[derive(Clone)]
pub struct Seat {
    /// The scene's name.
    pub name: String,
    /// Along Z from the centre of mass, m.
    pub station: f64,
    /// Rolling elements.
    pub elements: usize,
    /// Azimuth of element 1 with the cage at angle 0, rad.
    pub first_azimuth: f64,
    /// How the elements go round.
    pub kinematics: Kinematics,
    /// Displacement by preload, before anything moves.
    pub offset: Displacement<f64>,
    /// The scene's model.
    pub bearing: AnyBearing<f64>,
    /// The model in words.
    pub description: String,
}

impl Seat {
    /// What the bearing sees with its parts at `parts` and the shaft as `drive` says.
    #[must_use]
    pub fn rotation(&self, parts: PartAngles, drive: &Drive<f64>) -> Rotation<f64> {
        self.kinematics.gear().rotation(parts, drive)
    }
}

/// Rotor and bearings of a scene, and where they rest.
pub struct Plant {
    rotor: Rotor,
    /// The bearings, with linearised ones made.
    pub seats: Vec<Seat>,
    /// Rest position under the constant load, cages at angle 0.
    pub rest: Displacement<f64>,
    /// Tangent stiffness there, at the centre of mass.
    pub stiffness: Stiffness<f64>,
    /// Part of the load that rest leaves unbalanced.
    pub residual: f64,
    damping: Stiffness<f64>,
    /// Speed at which the rotor rests, rad/s.
    speed: f64,
    /// What the user should know of the making.
    pub notes: Vec<String>,
}

/// One twin, whatever its number of bearings.
pub trait Twin {
    /// One sample period further, the shaft moving as `drive` says.
    fn step(&mut self, drive: &Drive<f64>) -> Status;
    /// Displacement of the centre of mass now.
    fn pose(&self) -> Displacement<f64>;
    /// Its rate.
    fn rate(&self) -> Displacement<f64>;
}

impl Plant {
    /// From a scene with a rotor.
    ///
    /// # Errors
    /// No rotor, too many bearings, what the kernel refuses, a rotor that nothing holds.
    pub fn try_new(scene: &Scene) -> Result<Self> {
        let Some(rotor) = scene.rotor.clone() else {
            bail!(
                "{}: [rotor]: found none, allowed: a rotor, without which there is no motion to compute",
                scene.path.display()
            );
        };
        if scene.bearings.len() > MOST_BEARINGS {
            bail!("{}: bearing: found {}, allowed: up to {MOST_BEARINGS}", scene.path.display(), scene.bearings.len());
        }
        let seats = scene.bearings.iter().map(|b| seat(scene, b)).collect::<Result<Vec<_>>>()?;
        let none = Stiffness::from_element(0.0);
        let speed = scene.shaft.speed.nominal();
        let rest = Displacement::default();
        let mut plant =
            Self { rotor, seats, rest, stiffness: none, residual: 0.0, damping: none, speed, notes: vec![] };
        plant.settle()?;
        let linearised: Vec<bool> = scene
            .bearings
            .iter()
            .map(|b| b.model == Model::Linear && matches!(b.linear, Some(Linear::Of(_))))
            .collect();
        if linearised.contains(&true) {
            plant = plant.linearised(&linearised)?;
        }
        plant.damping = plant.stiffness * plant.rotor.proportional_damping;
        Ok(plant)
    }

    /// The same plant on springs: each bearing marked in `which` replaced by its mean tangent over a ball pitch.
    ///
    /// # Errors
    /// As [`Plant::try_new`].
    pub fn linearised(&self, which: &[bool]) -> Result<Self> {
        let mut states = vec![Vec::new(); self.seats.len()];
        let mut rest = self.rest;
        for i in 0..PITCH_SAMPLES {
            let part = f64::from(i) / f64::from(PITCH_SAMPLES);
            let cages = |seat: &Seat| Turn::from_revolutions(part / seat.elements as f64);
            rest = self.equilibrium(rest, cages)?.q;
            for (states, seat) in states.iter_mut().zip(&self.seats) {
                let u = rest.at_station(seat.station);
                let (reaction, k) = seat.bearing.reaction_and_stiffness(&u, &self.resting(seat, cages(seat)));
                states.push((u, reaction.wrench, k));
            }
        }
        let mut plant = Self { seats: self.seats.clone(), rotor: self.rotor.clone(), notes: vec![], ..*self };
        for ((seat, states), &linear) in plant.seats.iter_mut().zip(&states).zip(which) {
            if linear {
                seat.bearing = build::linearised(states);
            }
        }
        plant.settle()?;
        Ok(plant)
    }

    fn settle(&mut self) -> Result<()> {
        let found = self.equilibrium(Displacement::default(), |_| Turn::ZERO)?;
        if found.residual > 1e-6 {
            self.notes.push(format!(
                "The rotor finds no rest under its constant load ({:.1e} of the load is left unbalanced): nothing holds it in some direction.",
                found.residual
            ));
        }
        self.rest = found.q;
        self.stiffness = found.stiffness;
        self.residual = found.residual;
        Ok(())
    }

    fn equilibrium(
        &self,
        start: Displacement<f64>,
        cages: impl Fn(&Seat) -> Turn,
    ) -> Result<ballrace::rotor::Equilibrium<f64>> {
        let at = self.seats.iter().map(|seat| self.resting(seat, cages(seat))).collect();
        self.with_machine(RestTask { start, at })
    }

    /// What a bearing sees at the speed of rest with its cage at `cage`.
    #[must_use]
    pub fn resting(&self, seat: &Seat, cage: Turn) -> Rotation<f64> {
        seat.rotation(cage.into(), &Drive { angle: Turn::ZERO, speed: self.speed, acceleration: 0.0 })
    }

    fn rigid(&self) -> Result<RigidRotor<f64, Exact>> {
        let params = build::rotor_params(&self.rotor, &self.damping);
        RigidRotor::try_new(&params, &build::unbalances(&self.rotor)).context("[rotor]")
    }

    /// Runs `task` with the machine of as many bearings as the scene has.
    fn with_machine<R>(&self, task: impl MachineTask<R>) -> Result<R> {
        match self.seats.len() {
            1 => self.with_bearings::<R, 1>(task),
            2 => self.with_bearings::<R, 2>(task),
            3 => self.with_bearings::<R, 3>(task),
            4 => self.with_bearings::<R, 4>(task),
            5 => self.with_bearings::<R, 5>(task),
            6 => self.with_bearings::<R, 6>(task),
            7 => self.with_bearings::<R, 7>(task),
            MOST_BEARINGS => self.with_bearings::<R, MOST_BEARINGS>(task),
            n => bail!("bearing: found {n}, allowed: 1 to {MOST_BEARINGS}"),
        }
    }

    fn with_bearings<R, const N: usize>(&self, task: impl MachineTask<R>) -> Result<R> {
        let mounted: Vec<_> = self.seats.iter().map(mounted).collect();
        let Ok(bearings) = <[_; N]>::try_from(mounted) else { bail!("bearing: found another count than {N}") };
        Ok(task.run(Machine { rotor: self.rigid()?, bearings }))
    }

    /// The scene's rotor.
    #[must_use]
    pub fn rotor(&self) -> &Rotor {
        &self.rotor
    }

    /// Damping that is proportional to stiffness, besides the rotor's own.
    #[must_use]
    pub fn damping(&self) -> &Stiffness<f64> {
        &self.damping
    }

    /// Highest natural frequency of the rotor at rest, rad/s (an upper bound: the trace of M^-1 K).
    #[must_use]
    pub fn highest_frequency(&self) -> f64 {
        let r = &self.rotor;
        let masses = [r.mass, r.mass, r.mass, r.diametral_inertia, r.diametral_inertia];
        masses.iter().enumerate().map(|(i, m)| self.stiffness[(i, i)] / m).sum::<f64>().sqrt()
    }

    /// Time in which a start from rest dies down to 1e-5, s: from the weakest damping, at least 0.2 s, at most 10 s.
    #[must_use]
    pub fn settling_time(&self) -> f64 {
        let r = &self.rotor;
        let masses = [r.mass, r.mass, r.mass, r.diametral_inertia, r.diametral_inertia];
        let rate = masses
            .iter()
            .enumerate()
            .map(|(i, m)| 0.5 * (r.damping[i] + self.damping[(i, i)]) / m)
            .fold(f64::INFINITY, f64::min);
        (1e5_f64.ln() / rate).clamp(0.2, 10.0)
    }

    /// Integration steps that one sample period needs.
    #[must_use]
    pub fn substeps(&self, sample_period: f64) -> u32 {
        // The trace overestimates the highest frequency, which leaves room for contact that stiffens under load.
        (self.highest_frequency() * sample_period / LARGEST_PHASE_STEP).ceil().clamp(1.0, 10_000.0) as u32
    }

    /// A twin at the given revolutions of the shaft, already run in at that speed from rest.
    ///
    /// # Errors
    /// What the kernel refuses.
    pub fn run_in(&self, sample_period: f64, revolutions: f64, drive: &Drive<f64>) -> Result<Box<dyn Twin>> {
        let samples = (self.settling_time() / sample_period).ceil();
        let before = samples * sample_period * drive.speed / TAU;
        let mut twin = self.start(sample_period, revolutions - before)?;
        let steady = Drive { acceleration: 0.0, ..*drive };
        for i in 0..samples as u64 {
            let left = (samples - i as f64) * sample_period * drive.speed / TAU;
            twin.step(&Drive { angle: drive.angle.plus(Turn::from_revolutions(-left)), ..steady });
        }
        Ok(twin)
    }

    /// A twin at rest with the shaft at the given revolutions.
    ///
    /// # Errors
    /// What the kernel refuses.
    pub fn start(&self, sample_period: f64, revolutions: f64) -> Result<Box<dyn Twin>> {
        let substeps = self.substeps(sample_period);
        self.with_machine(StartTask {
            rest: self.rest,
            shaft: Turn::from_revolutions(revolutions),
            parts: self.seats.iter().map(|s| s.kinematics.parts_at(revolutions)).collect(),
            step: sample_period / f64::from(substeps),
            substeps,
        })
    }
}

fn mounted(seat: &Seat) -> Mounted<f64, AnyBearing<f64>> {
    Mounted { bearing: seat.bearing.clone(), station: seat.station, gear: seat.kinematics.gear() }
}

fn seat(scene: &Scene, bearing: &crate::scene::Bearing) -> Result<Seat> {
    let model = match (bearing.model, &bearing.linear) {
        // Made from the other model first, replaced once the rotor's rest is known.
        (Model::Linear, Some(Linear::Of(source))) => *source,
        (model, _) => model,
    };
    let moving = bearing.model != Model::Linear || matches!(bearing.linear, Some(Linear::Of(_)));
    let mut kinematics = build::kinematics(scene, bearing)?;
    if !moving {
        kinematics.cage_ratio = 0.0;
    }
    let (seated, offset) = seated(scene, bearing, model)?;
    Ok(Seat {
        name: bearing.name.clone(),
        station: bearing.station,
        elements: bearing.elements,
        first_azimuth: bearing.first_element_azimuth,
        kinematics,
        offset,
        bearing: seated,
        description: describe(bearing),
    })
}

/// The bearing with its preload: displaced as given, or until it answers with the force given.
fn seated(
    scene: &Scene,
    bearing: &crate::scene::Bearing,
    model: Model,
) -> Result<(AnyBearing<f64>, Displacement<f64>)> {
    let plain = build::bearing::<f64, Exact>(scene, bearing, model)?;
    match build::preload_offset(scene, bearing, &plain)? {
        Some(offset) => Ok((build::preloaded(plain, offset), offset)),
        None => Ok((plain, Displacement::default())),
    }
}

fn describe(bearing: &crate::scene::Bearing) -> String {
    let model = match bearing.model {
        Model::Linear => "linear",
        Model::Lumped => "lumped",
        Model::Angular => "angular",
        Model::QuasiStatic => "quasi-static",
        Model::Tabulated => "tabulated",
    };
    let damage = if bearing.defect.is_empty() { "" } else { ", damaged" };
    format!("{model}, {} elements{damage}", bearing.elements)
}

/// Something to do with a machine of any number of bearings.
trait MachineTask<R> {
    fn run<const N: usize>(self, machine: Machine<f64, Exact, AnyBearing<f64>, N>) -> R;
}

fn array<A: Copy + Default, const N: usize>(all: &[A]) -> [A; N] {
    std::array::from_fn(|i| all.get(i).copied().unwrap_or_default())
}

struct RestTask {
    start: Displacement<f64>,
    at: Vec<Rotation<f64>>,
}

impl MachineTask<ballrace::rotor::Equilibrium<f64>> for RestTask {
    fn run<const N: usize>(
        self,
        machine: Machine<f64, Exact, AnyBearing<f64>, N>,
    ) -> ballrace::rotor::Equilibrium<f64> {
        equilibrium(&machine, &array(&self.at), self.start)
    }
}

struct StartTask {
    rest: Displacement<f64>,
    shaft: Turn,
    parts: Vec<PartAngles>,
    step: f64,
    substeps: u32,
}

impl MachineTask<Box<dyn Twin>> for StartTask {
    fn run<const N: usize>(self, machine: Machine<f64, Exact, AnyBearing<f64>, N>) -> Box<dyn Twin> {
        Box::new(RigidTwin {
            machine,
            state: RotorState::at_rest(self.rest, self.shaft, array::<_, N>(&self.parts)),
            integrator: RungeKutta4 { step: self.step },
            substeps: self.substeps,
        })
    }
}

struct RigidTwin<const N: usize> {
    machine: Machine<f64, Exact, AnyBearing<f64>, N>,
    state: RotorState<f64, N>,
    integrator: RungeKutta4<f64>,
    substeps: u32,
}

impl<const N: usize> Twin for RigidTwin<N> {
    fn step(&mut self, drive: &Drive<f64>) -> Status {
        (0..self.substeps).fold(Status::OK, |status, i| {
            let now = drive.after(f64::from(i) * self.integrator.step);
            status.and(self.integrator.step(&self.machine, &mut self.state, &now))
        })
    }
    fn pose(&self) -> Displacement<f64> {
        self.state.q
    }
    fn rate(&self) -> Displacement<f64> {
        self.state.rate
    }
}
