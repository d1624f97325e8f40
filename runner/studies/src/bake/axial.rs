//! Bearings whose force needs the axial displacement, where no probe of the scene measures it.

use super::accuracy::scene_as_written;
use ballrace::{Displacement, Wrench};
use ballrace_models::handle::ForceModel;
use ballrace_plant::Plant;
use ballrace_scene::{Direction, Scene};
use serde::Serialize;

/// Change of the force over the force from which the axial displacement is needed.
const NEEDED: f64 = 0.01;

/// An axial displacement that a bearing needs and no probe measures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct UnmeasuredAxial {
    /// Axial displacement in the static equilibrium, um.
    pub w_um: f64,
    /// Force there, N.
    pub force_n: f64,
    /// Force with an axial displacement of 0, N.
    pub force_without_n: f64,
}

/// Returns for each bearing of the scene whether it needs an axial displacement that no probe measures. None needs it where an axial probe or
/// the observer gives it, and without a rotor there is no equilibrium.
#[must_use]
pub fn unmeasured(scene: &Scene) -> Vec<Option<UnmeasuredAxial>> {
    let is_axial = |direction: &Direction| matches!(direction, Direction::Axial);
    let mut probes = scene.recording.iter().flat_map(|recording| &recording.probes);
    let is_given = scene.observer.process_noise.is_some();
    let none = || vec![None; scene.bearings.len()];
    if is_given || scene.rotor.is_none() || probes.any(|probe| is_axial(&probe.direction)) {
        return none();
    }
    let Ok(plant) = Plant::try_new(&scene_as_written(scene)) else { return none() };
    (0..plant.bearings.len()).map(|i| of(&plant, i)).collect()
}

fn of(plant: &Plant, i: usize) -> Option<UnmeasuredAxial> {
    let mounted = &plant.bearings[i];
    let at = plant.resting(mounted, ballrace::Phase::ZERO);
    let u = plant.displacement(i, &plant.rest);
    let force = |u: &Displacement<f64>| ForceModel::reaction(&mounted.bearing, u, &at).wrench;
    let (with, without) = (force(&u), force(&Displacement { w: 0.0, ..u }));
    let size = |of: &Wrench<f64>| of.fx.hypot(of.fy).hypot(of.fz);
    let change = [without.fx - with.fx, without.fy - with.fy, without.fz - with.fz];
    let change = change.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
    let is_needed = size(&with) > 0.0 && change > NEEDED * size(&with);
    is_needed.then(|| UnmeasuredAxial { w_um: 1e6 * u.w, force_n: size(&with), force_without_n: size(&without) })
}
