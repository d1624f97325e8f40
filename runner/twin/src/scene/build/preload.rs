//! Static equilibrium of one bearing under a load, and its preload.

use super::{AnyBearing, BuildError, Shared, rotation_at};
use crate::scene::{Bearing as BearingScene, Facing, Preload, Scene};
use ballrace::bearing::{Bearing, Reaction};
use ballrace::rotor::{
    BearingAtStation, Equilibrium, RigidRotor, RotorBearingSystem, RotorParams, SpeedRatios, equilibrium, solve,
};
use ballrace::{BearingKinematicState, Displacement, Scalar, Stiffness};
use std::sync::Arc;

/// A bearing with a constant displacement by its preload.
struct Preloaded<T> {
    bearing: AnyBearing<T>,
    offset: Displacement<T>,
}

impl<T: Scalar> Preloaded<T> {
    fn with(&self, u: &Displacement<T>) -> Displacement<T> {
        *u + self.offset
    }
}

impl<T: Scalar> Bearing<T> for Preloaded<T> {
    fn reaction(&self, u: &Displacement<T>, at: &BearingKinematicState<T>) -> Reaction<T> {
        self.bearing.reaction(&self.with(u), at)
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
    ) -> (Reaction<T>, Stiffness<T>) {
        self.bearing.reaction_and_stiffness(&self.with(u), at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) {
        self.bearing.element_loads(&self.with(u), at, loads);
    }
    fn reaction_and_loads(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, loads: &mut [T]) -> Reaction<T> {
        self.bearing.reaction_and_loads(&self.with(u), at, loads)
    }
}

/// Returns the displacement of the inner ring by the scene's preload; the bearing's thrust direction is that of `facing`.
///
/// # Errors
/// A preload that the bearing does not carry, or a bearing without thrust capacity.
pub fn preload_offset(
    scene: &Scene,
    bearing: &BearingScene,
    built: &AnyBearing<f64>,
) -> Result<Option<Displacement<f64>>, BuildError> {
    let Some(preload) = bearing.preload else { return Ok(None) };
    let sign = if bearing.facing == Facing::MinusZ { -1.0 } else { 1.0 };
    match preload {
        Preload::Displacement(w) => Ok(Some(Displacement { w: sign * w, ..Displacement::default() })),
        Preload::Force(force) => {
            let at = rotation_at(scene, bearing, 0.0)?;
            let at = BearingKinematicState { inner_speed: scene.shaft.speed.nominal(), ..at };
            let rest = loaded(built, [0.0, 0.0, sign * force, 0.0, 0.0], &at)?;
            if rest.residual > 1e-6 {
                return Err(BuildError::Preload {
                    file: scene.path.clone(),
                    bearing: bearing.name.clone(),
                    found: force,
                });
            }
            Ok(Some(rest.displacement()))
        }
    }
}

/// Returns the static equilibrium of the inner ring under `load` (N, N m), with the outer ring fixed.
///
/// # Errors
/// None with a finite load.
pub fn loaded(
    bearing: &AnyBearing<f64>,
    load: [f64; 5],
    at: &BearingKinematicState<f64>,
) -> Result<Equilibrium<f64, 5>, BuildError> {
    let params = RotorParams {
        // The equilibrium does not depend on these.
        mass: 1.0,
        diametral_inertia: 1e-4,
        polar_inertia: 0.0,
        damping: [[0.0; 5]; 5],
        stiffness: [0.0; 5],
        gravity: [0.0; 3],
        load,
    };
    let rotor = RigidRotor::<f64, ballrace::Exact>::try_new(&params, &[])?;
    let mounted = BearingAtStation { bearing: bearing.clone(), station: 0.0, speed_ratios: SpeedRatios::new(0.0) };
    let machine = RotorBearingSystem { rotor, bearings: [mounted] };
    // From a displacement at which the bearing carries thrust, Newton's method needs a few steps; where it fails, the damped
    // motion from zero displacement converges.
    let start = thrust_start(bearing, load, at);
    let settled = (0..NEWTON_STEPS).try_fold(start, |u, _| newton_step(bearing, load, at, u));
    let start = settled.unwrap_or_default();
    let found = equilibrium(&machine, &[*at], start);
    Ok(if found.residual > 1e-6 { equilibrium(&machine, &[*at], Displacement::default()) } else { found })
}

/// Largest number of Newton steps.
const NEWTON_STEPS: usize = 12;
/// Axial displacements for the start, m.
const THRUST_STARTS: [f64; 6] = [3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3];

/// Returns the first axial displacement at which the bearing carries the axial load; none where there is none.
fn thrust_start(bearing: &AnyBearing<f64>, load: [f64; 5], at: &BearingKinematicState<f64>) -> Displacement<f64> {
    let along = |w: f64| Displacement { w: w * load[2].signum(), ..Displacement::default() };
    let carries = |u: &Displacement<f64>| bearing.reaction(u, at).wrench.fz.abs() >= load[2].abs();
    THRUST_STARTS.map(along).into_iter().find(carries).unwrap_or_default()
}

/// Returns one step of Newton's method; none where the stiffness is singular.
fn newton_step(
    bearing: &AnyBearing<f64>,
    load: [f64; 5],
    at: &BearingKinematicState<f64>,
    u: Displacement<f64>,
) -> Option<Displacement<f64>> {
    let (reaction, k) = bearing.reaction_and_stiffness(&u, at);
    let mut residual = reaction.wrench.to_array();
    for (r, f) in residual.iter_mut().zip(load) {
        *r += f;
    }
    let next = u + Displacement::from_array(solve(k, residual));
    next.is_finite().then_some(next)
}

/// Returns `bearing` with the constant displacement `offset`.
pub fn preloaded<T: Scalar>(bearing: AnyBearing<T>, offset: Displacement<T>) -> AnyBearing<T> {
    Shared(Arc::new(Preloaded { bearing, offset }))
}
