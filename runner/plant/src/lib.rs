//! The plant: the scene's rotor on its bearings, with its static equilibrium and its natural frequencies.
#![forbid(unsafe_code)]

pub mod error;
mod given;
mod machine;
pub mod matrix;
pub mod motion;
mod mounted;
mod multibody;
pub mod observer;
mod plant_error;
pub mod probes;
mod reduction;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod reduction_tests;
mod run_in;
pub mod spectrum;
mod system;
mod twin;
mod warm;

pub use given::Given;
pub use machine::ReactingElement;
pub use machine::{LARGEST, MAX_BEARINGS, MAX_OBSERVED, SystemTask};
pub use mounted::{Balls, MountedBearing};
pub use multibody::MultibodyChecks;
pub use reduction::{ReductionError, response};
pub use run_in::RunIn;
use system::Body;
pub use system::{Layout, Rows, Scales, only_observable, only_rotor, unbalance_note, unbalance_planes};
pub use twin::{Step, Twin, first_five};

use ballrace::bearing::Bearing as _;
use ballrace::contact::hertz::Race;
use ballrace::rotor::{Equilibrium, RotorBearingSystem, SecondOrderSystem, ShaftMotion, equilibrium};
use ballrace::{BearingKinematicState, Displacement, Phase};
use ballrace_base::eigenvalues::eigenvalues;
use ballrace_models::build::{self, ElementContact};
use ballrace_outcome::{ClearanceOutcome, RotorOutcome};
use ballrace_scene::{
    Bearing, Clock, FromCatalogue, Integration, Method, PreloadAmount, PreloadState, Rotor, Scene, Speed,
};
use nalgebra::{Complex, DMatrix};
pub use plant_error::{PlantError, Result};
pub use system::array;
use twin::StartTask;

/// Largest residual of a static equilibrium over the load.
pub const LARGEST_RESIDUAL: f64 = 1e-6;
/// Largest number of integration steps in one sample period.
pub(crate) const MAX_SUBSTEPS: u32 = 10_000;
const MM: f64 = 1e3;
/// Coordinate of the centre of mass along the axis.
pub const AXIAL: usize = 2;
/// Frequency of the artificial spring on a coordinate without stiffness, over the highest natural frequency.
const UNHELD: f64 = 1e-6;
/// Singular value, over the largest matrix element, below which rows are linearly dependent.
const SAME_ROW: f64 = 1e-10;
/// Number of equilibria over one ball pitch whose mean determines a linearised bearing.
const PITCH_SAMPLES: u32 = 16;

/// Rotor and bearings of a scene, with their static equilibrium.
#[derive(Clone)]
pub struct Plant {
    rotor: Option<Rotor>,
    proportional_damping: f64,
    integration: Integration,
    /// Meaning of the coordinates.
    pub layout: Layout,
    /// The bearings.
    pub bearings: Vec<MountedBearing>,
    /// Coordinates of the static equilibrium under the constant load, cages at angle 0.
    pub rest: Vec<f64>,
    /// Tangent stiffness at the equilibrium.
    pub stiffness: DMatrix<f64>,
    /// Residual of the equilibrium over the load.
    pub residual: f64,
    highest_frequency: f64,
    damping: DMatrix<f64>,
    /// Error of the reduction of a flexible rotor.
    pub reduction: Option<ReductionError>,
    /// Shaft speed of the equilibrium, rad/s.
    speed: f64,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

impl Plant {
    /// Creates the plant of a scene with a rotor.
    ///
    /// # Errors
    /// A bearing without model, no rotor, too many bearings, a parameter that the kernel rejects, an unsupported rotor.
    pub fn try_new(scene: &Scene) -> Result<Self> {
        Self::with_coordinates(scene, None)
    }

    /// Creates the plant of a scene of the same machine with other values: with the coordinates of `like`, whose error is not found again. For
    /// searches, which evaluate many.
    ///
    /// # Errors
    /// As [`Plant::try_new`].
    pub fn alike(scene: &Scene, like: &Self) -> Result<Self> {
        Self::with_coordinates(scene, Some(like))
    }

    fn with_coordinates(scene: &Scene, like: Option<&Self>) -> Result<Self> {
        build::check_forces(scene)?;
        if scene.rotor.is_none() && scene.system.is_none() {
            return Err(PlantError::NoRotor { file: scene.path.clone() });
        }
        if scene.bearings.len() > MAX_BEARINGS {
            return Err(PlantError::Bearings { file: scene.path.clone(), found: scene.bearings.len() });
        }
        let mounted = scene
            .bearings
            .iter()
            .map(|b| MountedBearing::new(scene, &at_one_speed(scene, b)))
            .collect::<Result<Vec<_>>>()?;
        let flexible = scene.rotor.as_ref().and_then(|r| r.flexible.as_ref());
        let body = match (&scene.system, flexible) {
            (Some(system), _) => Body::Given(Given::read(scene, system)?),
            (None, Some(rotor)) => Body::Flexible(match like.and_then(|like| like.layout.flexible()) {
                Some(like) => reduction::alike(scene, rotor, &mounted, like)?,
                None => reduction::first(scene, rotor, &mounted)?,
            }),
            (None, None) => Body::Rigid,
        };
        let layout = Layout::new(body, &scene.bearings, &mounted);
        let by_rotor = scene.rotor.as_ref().map(|r| r.proportional_damping);
        let proportional_damping = by_rotor.or(scene.system.as_ref().map(|s| s.proportional_damping)).unwrap_or(0.0);
        let none = DMatrix::zeros(layout.order, layout.order);
        let mut plant = Self {
            rotor: scene.rotor.clone(),
            proportional_damping,
            integration: scene.integration,
            rest: vec![0.0; layout.order],
            layout,
            bearings: mounted,
            stiffness: none.clone(),
            residual: 0.0,
            highest_frequency: 0.0,
            damping: none,
            reduction: None,
            speed: scene.shaft.speed.nominal(),
            notes: bearing_notes(scene)?,
        };
        plant.settle()?;
        match like {
            Some(like) => plant.reduction = like.reduction,
            None => plant.refine(scene)?,
        }
        let linearised: Vec<bool> = scene.bearings.iter().map(Bearing::is_linearised).collect();
        if linearised.contains(&true) {
            plant = plant.linearised(&linearised)?;
        }
        plant.damping = &plant.stiffness * plant.proportional_damping;
        // The tangent stiffness of a bearing may be slightly unsymmetric at speed; the damping matrix is symmetric.
        plant.damping = 0.5 * (&plant.damping + plant.damping.transpose());
        plant.warn(scene)?;
        Ok(plant)
    }

    /// Adds notes on contact pressures above the static limit and on an unstable integration step.
    fn warn(&mut self, scene: &Scene) -> Result<()> {
        for (i, (of, mounted)) in scene.bearings.iter().zip(&self.bearings).enumerate() {
            let Ok(Some(contact)) = ElementContact::of(of) else { continue };
            let mut loads = vec![0.0; mounted.elements];
            let (u, at) = (self.displacement(i, &self.rest), self.resting(mounted, Phase::ZERO));
            mounted.bearing.element_loads(&u, &at, &mut loads);
            let pressure = contact.pressure(Race::Inner, loads.iter().copied().fold(0.0, f64::max));
            if pressure > contact.limit() {
                self.notes.push(format!(
                    "Bearing {}: the contact pressure in static equilibrium is {:.2} GPa, beyond {:.1} GPa, the static limit of ISO 76.",
                    mounted.name,
                    pressure / 1e9,
                    contact.limit() / 1e9
                ));
            }
        }
        self.notes.extend(self.rotor_outcome(scene).and_then(|rotor| rotor.excess_error()));
        self.notes.extend(self.unstable_in_replay(scene)?);
        Ok(())
    }

    /// Returns the warning about the step as a replay of the scene's recording takes it. A scene without a rate has no steps before it is
    /// simulated.
    fn unstable_in_replay(&self, scene: &Scene) -> Result<Option<String>> {
        let Some(recording) = &scene.recording else { return Ok(None) };
        let Clock::Rate(rate) = recording.clock else { return Ok(None) };
        self.unstable_step(f64::from(recording.average) / rate)
    }

    /// Returns the notes for a simulation with this sample period.
    ///
    /// # Errors
    /// If the stability of a step cannot be determined.
    pub fn simulation_notes(&self, scene: &Scene, sample_period: f64) -> Result<Vec<String>> {
        let of_replay = self.unstable_in_replay(scene)?;
        let others = self.notes.iter().filter(|note| of_replay.as_ref() != Some(note));
        Ok(others.cloned().chain(self.unstable_step(sample_period)?).collect())
    }

    /// Returns the warning about a given step that is not stable at rest, as it is taken in the sample period; `None` for a stable one.
    ///
    /// # Errors
    /// As [`Plant::substeps`] and [`Plant::stable_step`].
    pub(crate) fn unstable_step(&self, sample_period: f64) -> Result<Option<String>> {
        if self.integration.step.is_none() {
            return Ok(None);
        }
        let taken = self.step(sample_period)?.0.length;
        let limit = self.stable_step()?.filter(|limit| taken > *limit);
        Ok(limit.map(|limit| {
            format!(
                "The step of {:.3} us is beyond {:.3} us, up to which the integrator is stable at rest: the motion may overflow.",
                taken * 1e6,
                limit * 1e6
            )
        }))
    }

    /// Returns the largest stable integration step with the stiffness of the equilibrium, s; none where it has no limit.
    ///
    /// # Errors
    /// Mass or stiffness out of the range of numbers.
    pub(crate) fn stable_step(&self) -> Result<Option<f64>> {
        let most = match self.integration.method {
            Method::RungeKutta => 2.5865,
            Method::Verlet => 2.0,
            Method::Newmark { .. } => return Ok(None),
        };
        let highest = largest_real(&self.frequency_squares()?).sqrt();
        Ok((highest > 0.0).then(|| most / highest))
    }

    /// Returns the eigenvalues of M^-1 K, (rad/s)^2.
    fn frequency_squares(&self) -> Result<Vec<Complex<f64>>> {
        let inverse = self.scales()?.mass.try_inverse().ok_or(PlantError::SingularMass)?;
        Ok(eigenvalues(&(inverse * &self.stiffness))?)
    }

    /// Returns the plant with each bearing marked in `which` replaced by a spring: its mean tangent over a ball pitch.
    ///
    /// # Errors
    /// As [`Plant::try_new`].
    pub fn linearised(&self, which: &[bool]) -> Result<Self> {
        let mut states = vec![Vec::new(); self.bearings.len()];
        let mut rest = self.rest.clone();
        for i in 0..PITCH_SAMPLES {
            let part = f64::from(i) / f64::from(PITCH_SAMPLES);
            let cages = |mounted: &MountedBearing| Phase::from_revolutions(part / mounted.elements as f64);
            rest = self.equilibrium(rest, cages)?.coordinates;
            for (i, (states, mounted)) in states.iter_mut().zip(&self.bearings).enumerate() {
                let u = self.displacement(i, &rest);
                let (reaction, k) = mounted.bearing.reaction_and_stiffness(&u, &self.resting(mounted, cages(mounted)));
                states.push((u, reaction.wrench, k));
            }
        }
        let mut plant = Self { notes: vec![], ..self.clone() };
        for ((mounted, states), &linear) in plant.bearings.iter_mut().zip(&states).zip(which) {
            if linear {
                mounted.replace(build::linearised(states));
            }
        }
        plant.settle()?;
        Ok(plant)
    }

    fn settle(&mut self) -> Result<()> {
        let found = self.equilibrium(vec![0.0; self.layout.order], |_| Phase::ZERO)?;
        if found.residual > LARGEST_RESIDUAL {
            self.notes.push(format!(
                "The rotor has no static equilibrium under its constant load ({:.1e} of the load is unbalanced): it is unsupported in some direction.",
                found.residual
            ));
        }
        self.rest = found.coordinates;
        self.stiffness = found.stiffness;
        self.residual = found.residual;
        self.highest_frequency = self.find_highest_frequency()?;
        Ok(())
    }

    fn equilibrium(&self, start: Vec<f64>, cages: impl Fn(&MountedBearing) -> Phase) -> Result<Rest> {
        let at = self.bearings.iter().map(|mounted| self.resting(mounted, cages(mounted))).collect();
        self.with_machine(MountedBearing::resting, RestTask { start, at })
    }

    /// Returns the plant with a flexible rotor as a rigid one, with its damping proportional to the mass; `None` for another rotor.
    ///
    /// # Errors
    /// As [`Plant::try_new`].
    pub fn without_bending(&self, scene: &Scene) -> Result<Option<Self>> {
        let Some(mut rotor) = self.rotor.clone() else { return Ok(None) };
        let Some(drawn) = rotor.flexible.take() else { return Ok(None) };
        let inertia = [rotor.mass, rotor.mass, rotor.mass, rotor.diametral_inertia, rotor.diametral_inertia];
        for (damping, inertia) in rotor.damping.iter_mut().zip(inertia) {
            *damping += drawn.proportional_damping[0] * inertia;
        }
        let layout = Layout::new(Body::Rigid, &scene.bearings, &self.bearings);
        let none = DMatrix::zeros(layout.order, layout.order);
        let mut plant = Self {
            rotor: Some(rotor),
            rest: vec![0.0; layout.order],
            layout,
            stiffness: none.clone(),
            damping: none,
            reduction: None,
            notes: vec![],
            ..self.clone()
        };
        plant.settle()?;
        Ok(Some(plant))
    }

    /// Returns the plant in static equilibrium at another shaft speed, rad/s, without notes.
    ///
    /// # Errors
    /// As [`Plant::try_new`].
    pub fn at_speed(&self, speed: f64) -> Result<Self> {
        let mut plant = Self { speed, notes: vec![], ..self.clone() };
        plant.settle()?;
        Ok(plant)
    }

    /// Returns the shaft speed of the equilibrium, rad/s.
    #[must_use]
    pub const fn speed(&self) -> f64 {
        self.speed
    }

    /// Returns the bearing of this name.
    ///
    /// # Errors
    /// No bearing of this name.
    pub fn mounted(&self, name: &str) -> Result<&MountedBearing> {
        let found = self.bearings.iter().find(|bearing| bearing.name == name);
        found.ok_or_else(|| PlantError::NotMounted { name: name.to_owned() })
    }

    /// Returns the kinematic state of a bearing at the nominal speed with the cage angle `cage`.
    #[must_use]
    pub fn resting(&self, mounted: &MountedBearing, cage: Phase) -> BearingKinematicState<f64> {
        mounted.rotation(cage.into(), &ShaftMotion { angle: Phase::ZERO, speed: self.speed, acceleration: 0.0 })
    }

    /// Returns the displacement of bearing `i`, inner ring against outer ring, at `coordinates`.
    #[must_use]
    pub fn displacement(&self, i: usize, coordinates: &[f64]) -> Displacement<f64> {
        if self.layout.is_rigid() {
            let station = self.bearings.get(i).map_or(0.0, |s| s.station);
            return first_five(coordinates).at_station(station);
        }
        let Some(rows) = self.layout.attached(i) else { return Displacement::default() };
        let product = |row: &Vec<f64>| row.iter().zip(coordinates).map(|(t, q)| t * q).sum();
        Displacement::from_array(rows.each_ref().map(product))
    }

    /// Returns the displacement that represents the rotor: that of the centre of mass of a rigid rotor, that of the first
    /// bearing of a given system.
    #[must_use]
    pub fn pose(&self, coordinates: &[f64]) -> Displacement<f64> {
        if self.layout.is_given() { self.displacement(0, coordinates) } else { first_five(coordinates) }
    }

    /// Returns the displacement along each external force per unit of each coordinate: `u v w thu thv` where the scene's load acts
    /// on its rotor; each coordinate of a given system. The transposed map is that of the forces to the coordinates.
    #[must_use]
    pub fn external_rows(&self) -> Vec<Vec<f64>> {
        match &self.rotor {
            Some(rotor) => self.layout.rows(rotor.local_load().0).into(),
            None => (0..self.layout.order)
                .map(|i| (0..self.layout.order).map(|j| f64::from(u8::from(i == j))).collect())
                .collect(),
        }
    }

    /// Returns mass and inertia of a flexible rotor, and the error of its reduced model; `None` for another rotor.
    #[must_use]
    pub fn rotor_outcome(&self, scene: &Scene) -> Option<RotorOutcome> {
        let (rotor, reduction) = (scene.rotor.as_ref()?, self.reduction?);
        Some(RotorOutcome {
            mass_kg: rotor.mass,
            centre_of_mass_mm: rotor.centre_of_mass * MM,
            diametral_inertia_kg_m2: rotor.diametral_inertia,
            polar_inertia_kg_m2: rotor.polar_inertia,
            coordinates: self.layout.rotor_order(),
            finite_element_coordinates: reduction.full_coordinates,
            highest_line_hz: reduction.highest_line,
            frequency_error_percent: 100.0 * reduction.frequency,
            accurate_to_hz: reduction.accurate_to,
            deflection_error_percent: 100.0 * reduction.deflection,
            response_error_percent: 100.0 * reduction.response,
        })
    }

    /// Returns the scene's rotor, where it has one.
    #[must_use]
    pub fn rotor(&self) -> Option<&Rotor> {
        self.rotor.as_ref()
    }

    /// Returns the coordinates per unit of each row's value: the deflection from the equilibrium with the least strain energy in which
    /// the values of all `rows` are given. Values that exclude each other are met by least squares.
    ///
    /// # Errors
    /// A stiffness matrix without an inverse.
    pub fn deflections(&self, rows: &[Vec<f64>]) -> Result<DMatrix<f64>> {
        let n = self.layout.order;
        let symmetric = 0.5 * (&self.stiffness + self.stiffness.transpose());
        // A weak spring holds the coordinates that have no stiffness.
        let held = symmetric + self.scales()?.mass * (UNHELD * self.highest_frequency).powi(2);
        let compliance = held.try_inverse().ok_or(PlantError::SingularStiffness)?;
        let rows = DMatrix::from_fn(rows.len(), n, |p, i| rows[p].get(i).copied().unwrap_or(0.0));
        let forces = &compliance * rows.transpose();
        let both = &rows * &forces;
        let least = SAME_ROW * both.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let inverse = both.pseudo_inverse(least).map_err(|_| PlantError::SingularStiffness)?;
        Ok(forces * inverse)
    }

    /// Returns the damping proportional to stiffness, without the rotor's own.
    #[must_use]
    pub fn damping(&self) -> &DMatrix<f64> {
        &self.damping
    }

    /// Returns the system's matrices without its bearings.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter.
    pub fn scales(&self) -> Result<Scales> {
        self.layout.scales(self.rotor.as_ref(), &self.bearings, &self.damping)
    }

    /// Returns an upper bound of the highest natural frequency at rest, rad/s.
    #[must_use]
    pub const fn highest_frequency(&self) -> f64 {
        self.highest_frequency
    }

    fn find_highest_frequency(&self) -> Result<f64> {
        // The margin is for contacts that stiffen under load: their stiffness is 1.5 times that at rest under 3.4 times the load.
        let square = 1.5 * largest_real(&self.frequency_squares()?);
        if !square.is_finite() {
            return Err(PlantError::Frequency { found: square });
        }
        Ok(square.max(0.0).sqrt())
    }

    /// Returns the time in which a transient decays to 1e-5, s: from the weakest damping of the rotor, at least 0.2 s, at most
    /// 10 s.
    #[must_use]
    pub fn settling_time(&self) -> f64 {
        let Ok(scales) = self.scales() else { return 0.2 };
        let coordinates = if self.layout.is_given() { self.layout.order } else { self.layout.rotor_order() };
        let rate =
            (0..coordinates).map(|i| 0.5 * scales.damping[(i, i)] / scales.mass[(i, i)]).fold(f64::INFINITY, f64::min);
        (1e5_f64.ln() / rate).clamp(0.2, 10.0)
    }

    /// Returns the plant with another integrator and `part` of its default step.
    #[must_use]
    pub fn with_step(&self, method: Method, part: f64) -> Self {
        let mut plant = Self { integration: Integration { method, step: None }, ..self.clone() };
        plant.integration.step = Some(part * plant.own_step());
        plant
    }

    /// Returns the plant for a simulation, which has no noise of probes that would hide the error of the default step.
    #[must_use]
    pub fn for_simulation(&self) -> Self {
        match self.integration {
            Integration { method: method @ Method::RungeKutta, step: None } => self.with_step(method, 0.5),
            _ => self.clone(),
        }
    }

    /// Returns the default step of the integrator, s.
    #[must_use]
    fn own_step(&self) -> f64 {
        largest_phase(self.integration.method) / self.highest_frequency().max(1e-9)
    }

    /// Returns the number of integration steps in one sample period.
    ///
    /// # Errors
    /// More than 10 000: longer steps would not be stable.
    pub fn substeps(&self, sample_period: f64) -> Result<u32> {
        let step = self.integration.step.unwrap_or_else(|| self.own_step());
        let steps = (sample_period / step * (1.0 - 1e-9)).ceil().max(1.0);
        if steps > f64::from(MAX_SUBSTEPS) {
            return Err(PlantError::Substeps { found: steps, step, is_given: self.integration.step.is_some() });
        }
        Ok(steps as u32)
    }

    /// Runs `task` with the system on moving bearings.
    ///
    /// # Errors
    /// More than [`MAX_OBSERVED`] coordinates, a parameter that the kernel rejects.
    pub fn observed<R>(&self, task: impl SystemTask<R>) -> Result<R> {
        self.with_observed_machine(MountedBearing::moving, task)
    }

    /// Returns the integrator and its number of steps in a sample period.
    ///
    /// # Errors
    /// As [`Plant::substeps`].
    pub fn step(&self, sample_period: f64) -> Result<(Step, u32)> {
        let substeps = self.substeps(sample_period)?;
        Ok((Step { method: self.integration.method, length: sample_period / f64::from(substeps) }, substeps))
    }

    /// Returns a twin at the given revolutions of the shaft, run in at that speed from rest.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter.
    pub fn run_in(&self, sample_period: f64, revolutions: f64, drive: &ShaftMotion<f64>) -> Result<Box<dyn Twin>> {
        let mut run_in = RunIn::try_new(self, sample_period, revolutions, drive)?;
        while run_in.advance() {}
        Ok(run_in.into_twin())
    }

    /// Returns a twin at rest with the shaft at the given revolutions.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter.
    pub fn start(&self, sample_period: f64, revolutions: f64) -> Result<Box<dyn Twin>> {
        if self.has_bodies() {
            return self.start_multibody(sample_period, revolutions);
        }
        let (step, substeps) = self.step(sample_period)?;
        let task = StartTask {
            rest: self.rest.clone(),
            shaft: Phase::from_revolutions(revolutions),
            parts: self.bearings.iter().map(|s| s.kinematics.parts_at(revolutions)).collect(),
            step,
            substeps,
        };
        self.with_machine(MountedBearing::moving, task)
    }
}

/// Returns the largest real part of all, at least 0.
fn largest_real(all: &[Complex<f64>]) -> f64 {
    all.iter().fold(0.0, |most, value| most.max(value.re))
}

/// Returns the product `x` of step and highest natural frequency. The relative frequency error at `x` is `x^4 / 320` = 6e-4 for
/// Runge-Kutta, which also adds a damping ratio of `x^5 / 576` = 2e-4, `x^2 / 12` = 3e-3 for Newmark and `x^2 / 24` = 2e-3 for Verlet;
/// it is far smaller at the rotor's low frequencies.
const fn largest_phase(method: Method) -> f64 {
    match method {
        Method::RungeKutta => 2.0 / 3.0,
        Method::Newmark { .. } | Method::Verlet => 0.2,
    }
}

/// Returns the bearing with a table for the constant speed of a scene without a recording, which costs two thirds of a table
/// over a range of speeds.
fn at_one_speed(scene: &Scene, bearing: &Bearing) -> Bearing {
    let mut bearing = bearing.clone();
    if let (Speed::Constant(inner), None) = (scene.shaft.speed, &scene.recording) {
        let speed = if inner == 0.0 { scene.shaft.outer_speed } else { inner };
        bearing.table.get_or_insert_default().speed.get_or_insert([speed.abs(); 2]);
    }
    bearing
}

/// Static equilibrium.
struct Rest {
    coordinates: Vec<f64>,
    stiffness: DMatrix<f64>,
    residual: f64,
}

struct RestTask {
    start: Vec<f64>,
    at: Vec<BearingKinematicState<f64>>,
}

impl SystemTask<Rest> for RestTask {
    fn run<S, C, const D: usize, const N: usize>(self, machine: RotorBearingSystem<S, C, N>) -> Rest
    where
        S: SecondOrderSystem<f64, D> + 'static,
        C: ReactingElement<D> + 'static,
    {
        let n = self.start.len();
        let found: Equilibrium<f64, D> = equilibrium(&machine, &array::<_, N>(&self.at), array::<_, D>(&self.start));
        Rest {
            coordinates: found.q.get(..n).unwrap_or_default().to_vec(),
            stiffness: DMatrix::from_fn(n, n, |i, j| found.stiffness[(i, j)]),
            residual: found.residual,
        }
    }
}

/// Returns the note on the estimated values of a bearing of the catalogue.
fn estimates(of: &Bearing) -> Option<String> {
    let FromCatalogue { listed, estimated } = of.catalogue.as_ref()?;
    (!estimated.is_empty()).then(|| {
        format!(
            "Bearing {}: {} of the catalogue, with the estimated values {}. Give those in the scene that are known.",
            of.name,
            listed.entry.designation,
            estimated.join(", ")
        )
    })
}

/// Returns the notes on the bearings of a scene: estimated values, operating clearances and preloads.
fn bearing_notes(scene: &Scene) -> Result<Vec<String>> {
    let estimates = scene.bearings.iter().filter_map(estimates);
    Ok(estimates.chain(mounting_notes(scene)?).collect())
}

/// Returns the notes on operating clearance and preload of bearings with fits or temperatures.
///
/// # Errors
/// A preload that a bearing does not carry.
pub fn mounting_notes(scene: &Scene) -> Result<Vec<String>> {
    let mut notes = vec![];
    for bearing in &scene.bearings {
        notes.extend(operating_clearance(bearing));
        notes.extend(operating_preload(scene, bearing)?);
    }
    Ok(notes)
}

/// Returns a note on the preload of a bearing that its fits and temperatures change.
fn operating_preload(scene: &Scene, of: &Bearing) -> Result<Option<String>> {
    let Some(preload) = of.preload.filter(|_| of.mounting.is_some() && !of.has_constant_preload_force()) else {
        return Ok(None);
    };
    let Some(force) = build::preload_force(scene, of)? else { return Ok(None) };
    let amount = match preload.amount {
        PreloadAmount::Force(force) => format!("{force:.0} N"),
        PreloadAmount::Displacement(w) => format!("{:.2} um", w * 1e6),
    };
    let set = match preload.set {
        PreloadState::Unmounted => "before mounting",
        PreloadState::Fitted => "after fitting, at the temperature of assembly",
        PreloadState::Operating => "in operation",
    };
    Ok(Some(format!(
        "Bearing {}: a preload of {amount} {set} is {force:.0} N in operation; the rings are locked axially.",
        of.name
    )))
}

/// Returns a note on the operating clearance of a bearing with fits or temperatures.
fn operating_clearance(of: &Bearing) -> Option<String> {
    let clearance = ClearanceOutcome::from(of.mounting?.operating());
    Some(format!("Bearing {}: operating clearance {clearance}.", of.name))
}
