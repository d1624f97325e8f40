//! The plant: the scene's rotor on its bearings, with its static equilibrium and its natural frequencies.
#![forbid(unsafe_code)]

pub mod error;
mod given;
mod machine;
pub mod matrix;
pub mod motion;
mod mounted;
mod multibody;
mod notes;
pub mod observer;
mod plant_error;
pub mod probes;
mod reduction;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod reduction_tests;
mod run_in;
pub mod spectrum;
mod static_equilibrium;
mod step;
mod system;
mod twin;
mod warm;

pub use given::Given;
pub use machine::ReactingElement;
pub use machine::{LARGEST, MAX_BEARINGS, MAX_OBSERVED, SystemTask};
pub use mounted::{Balls, MountedBearing};
pub use multibody::MultibodyChecks;
pub use notes::mounting_notes;
pub use reduction::{ReductionError, response};
pub use run_in::RunIn;
pub use static_equilibrium::LARGEST_RESIDUAL;
use system::Body;
pub use system::{Layout, Rows, Scales, only_observable, only_rotor, unbalance_note, unbalance_planes};
pub use twin::{Step, Twin, first_five};

use ballrace::rotor::ShaftMotion;
use ballrace::{Displacement, Phase};
use ballrace_models::build;
use ballrace_outcome::RotorOutcome;
use ballrace_scene::{Bearing, Integration, Rotor, Scene, Speed};
use nalgebra::DMatrix;
use notes::bearing_notes;
pub use plant_error::{PlantError, Result};
pub use system::array;
use twin::StartTask;

/// Largest number of integration steps in one sample period.
pub(crate) const MAX_SUBSTEPS: u32 = 10_000;
const MM: f64 = 1e3;
/// Coordinate of the centre of mass along the axis.
pub const AXIAL: usize = 2;
/// Frequency of the artificial spring on a coordinate without stiffness, over the highest natural frequency.
const UNHELD: f64 = 1e-6;
/// Singular value, over the largest matrix element, below which rows are linearly dependent.
const SAME_ROW: f64 = 1e-10;

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

    /// Runs `task` with the system on moving bearings.
    ///
    /// # Errors
    /// More than [`MAX_OBSERVED`] coordinates, a parameter that the kernel rejects.
    pub fn observed<R>(&self, task: impl SystemTask<R>) -> Result<R> {
        self.with_observed_machine(MountedBearing::moving, task)
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
