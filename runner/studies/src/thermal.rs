//! Steady temperatures of the rings: friction heats them, shaft, housing and oil cool them, and the clearance that they leave sets the
//! friction.

use crate::equilibrium::{StaticEquilibrium, settled, static_equilibrium};
use crate::heat::BearingTemperatures;
use ballrace_models::build;
use ballrace_plant::error::{Result, ThermalError};
use ballrace_scene::{Scene, Temperatures};

/// Temperature at which the search gives up, K: bearing steel loses its hardness from 150 to 250 degrees Celsius, by its tempering.
const HOTTEST: f64 = 523.15;
/// Largest difference of a temperature to the one that its heat keeps, K.
const TOLERANCE: f64 = 1e-3;
/// Largest number of equilibria.
const MOST_ROUNDS: usize = 400;

/// Computes the static equilibrium at the temperatures that friction and cooling keep, of the bearings that have `cooling`; the others keep
/// theirs. The search starts at the temperatures of the scene.
///
/// # Errors
/// As [`static_equilibrium`]; no bearing with cooling, or no steady temperatures below 250 degrees Celsius.
pub fn thermal_equilibrium(scene: &Scene, bearing: Option<&str>, load: Option<[f64; 5]>) -> Result<StaticEquilibrium> {
    let mut warm = scene.clone();
    // A single bearing is picked as the equilibrium picks it.
    let only = if bearing.is_some() || load.is_some() || (scene.rotor.is_none() && scene.system.is_none()) {
        Some(build::pick(scene, bearing)?.name.clone())
    } else {
        None
    };
    let takes_part = |name: &str| only.as_ref().is_none_or(|only| only == name);
    let mut searches = vec![Search::START; scene.bearings.len()];
    for _ in 0..MOST_ROUNDS {
        let now = settled(&warm, bearing, load)?;
        let mut kept = Vec::new();
        let mut largest = 0.0_f64;
        for (of, search) in warm.bearings.iter_mut().zip(&mut searches).filter(|(of, _)| takes_part(&of.name)) {
            let Some(cooling) = of.cooling else { continue };
            let no_friction = || ThermalError::NoFriction { file: scene.path.clone(), bearing: of.name.clone() };
            let friction = now.bearings.iter().find(|one| one.name == of.name).and_then(|one| one.friction);
            let power = friction.map(|friction| friction.power).ok_or_else(no_friction)?;
            let found = BearingTemperatures::steady(&cooling, power).ok_or_else(no_friction)?;
            let before = of.mounting.and_then(|mounting| mounting.temperatures).ok_or_else(no_friction)?;
            let (next, distance) = search.next(before, &found);
            let hottest = next.inner.max(next.outer);
            if hottest > HOTTEST {
                let (file, bearing) = (scene.path.clone(), of.name.clone());
                let celsius = hottest - 273.15;
                return Err(ThermalError::TooHot { file, bearing, celsius, watts: power }.into());
            }
            largest = largest.max(distance);
            kept.push((of.name.clone(), found));
            of.set_temperatures(next);
            let clearance = of.mounting.map_or(0.0, |mounting| mounting.operating().value());
            if clearance < 0.0 && of.model.has_contact_angle() {
                return Err(ThermalError::NoClearance {
                    file: scene.path.clone(),
                    bearing: of.name.clone(),
                    rings: [next.inner, next.outer].map(|kelvin| kelvin - 273.15),
                    micrometres: clearance * 1e6,
                }
                .into());
            }
        }
        if kept.is_empty() {
            return Err(ThermalError::NoCooling { file: scene.path.clone() }.into());
        }
        if largest <= TOLERANCE {
            let mut found = static_equilibrium(&warm, bearing, load)?;
            for one in &mut found.bearings {
                one.temperatures = kept.iter().find(|(name, _)| *name == one.name).map(|(_, kept)| *kept);
            }
            return Ok(found);
        }
    }
    Err(ThermalError::NotSteady { file: scene.path.clone(), rounds: MOST_ROUNDS }.into())
}

/// Damped search of the temperatures of one bearing.
#[derive(Debug, Clone, Copy)]
struct Search {
    /// Share of the way to the temperatures that the heat keeps.
    share: f64,
    /// Distance to them in the last round, K.
    distance: f64,
}

impl Search {
    const START: Self = Self { share: 0.1, distance: f64::INFINITY };

    /// Returns the temperatures of the next round and the distance, K, of those `before` to those that their heat keeps. Where the distance has grown,
    /// the step before was too long.
    fn next(&mut self, before: Temperatures, kept: &BearingTemperatures) -> (Temperatures, f64) {
        let change = [kept.inner - before.inner, kept.outer - before.outer];
        let distance = change[0].abs().max(change[1].abs());
        self.share = if distance > self.distance { (0.5 * self.share).max(0.01) } else { (1.05 * self.share).min(0.3) };
        self.distance = distance;
        let [inner, outer] = change.map(|kelvin| self.share * kelvin);
        (Temperatures { inner: before.inner + inner, outer: before.outer + outer, ..before }, distance)
    }
}
