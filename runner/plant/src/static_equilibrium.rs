//! Static equilibrium under the constant load, with its stiffness, its highest frequency and its linearised bearings.

use crate::Plant;
use crate::machine::{ReactingElement, SystemTask};
use crate::mounted::MountedBearing;
use crate::plant_error::{PlantError, Result};
use crate::system::array;
use ballrace::bearing::Bearing as _;
use ballrace::rotor::{Equilibrium, RotorBearingSystem, SecondOrderSystem, ShaftMotion, equilibrium};
use ballrace::{BearingKinematicState, Phase};
use ballrace_base::eigenvalues::eigenvalues;
use ballrace_models::build;
use nalgebra::{Complex, DMatrix};

/// Largest residual of a static equilibrium over the load.
pub const LARGEST_RESIDUAL: f64 = 1e-6;
/// Number of equilibria over one ball pitch whose mean determines a linearised bearing.
const PITCH_SAMPLES: u32 = 16;

impl Plant {
    /// Finds the equilibrium from rest, its stiffness and its highest frequency; adds a note where there is none.
    pub(crate) fn settle(&mut self) -> Result<()> {
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

    /// Returns the kinematic state of a bearing at the nominal speed with the cage angle `cage`.
    #[must_use]
    pub fn resting(&self, mounted: &MountedBearing, cage: Phase) -> BearingKinematicState<f64> {
        mounted.rotation(cage.into(), &ShaftMotion { angle: Phase::ZERO, speed: self.speed, acceleration: 0.0 })
    }

    /// Returns the eigenvalues of M^-1 K, (rad/s)^2.
    pub(crate) fn frequency_squares(&self) -> Result<Vec<Complex<f64>>> {
        let inverse = self.scales()?.mass.try_inverse().ok_or(PlantError::SingularMass)?;
        Ok(eigenvalues(&(inverse * &self.stiffness))?)
    }

    fn find_highest_frequency(&self) -> Result<f64> {
        // The margin is for contacts that stiffen under load: their stiffness is 1.5 times that at rest under 3.4 times the load.
        let square = 1.5 * largest_real(&self.frequency_squares()?);
        if !square.is_finite() {
            return Err(PlantError::Frequency { found: square });
        }
        Ok(square.max(0.0).sqrt())
    }
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

/// Returns the largest real part of all, at least 0.
pub(crate) fn largest_real(all: &[Complex<f64>]) -> f64 {
    all.iter().fold(0.0, |most, value| most.max(value.re))
}
