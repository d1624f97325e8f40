//! Static equilibrium of one bearing under a load, its preload and the tilt of its outer ring.

use crate::construction::{BuildError, rotation_at};
use crate::handle::{AnyBearing, Shared};
use crate::{bearing_model, construct};
use ballrace::bearing::{Bearing, Reaction};
use ballrace::rotor::{
    BearingAtStation, Equilibrium, RigidRotor, RotorBearingSystem, RotorParams, SpeedRatios, equilibrium, solve,
};
use ballrace::{BearingKinematicState, Displacement, Exact, Scalar, Stiffness};
use ballrace_scene::{Bearing as BearingScene, Facing, Preload, PreloadAmount, PreloadState, Scene};
use std::sync::Arc;

/// A bearing with a constant displacement by its preload and the tilt of its outer ring.
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

/// Returns the displacement of the inner ring against the outer one by the scene's preload and the tilt of the outer ring; `None` without both. The bearing's
/// thrust direction is that of `facing`; its preload is that of aligned rings.
///
/// A preload that is set before fits or temperatures act is set at standstill and locks the rings axially: the axial distance of their groove
/// centres stays as it was set, while the displacement counts from the first contact of the mounted, warm bearing:
/// `w = w_set + A (sin(alpha_set) - sin(alpha))` with the free contact angles `alpha_set` before and `alpha` after.
///
/// # Errors
/// A preload that the bearing does not carry, or a bearing without thrust capacity.
pub fn mounted_offset(
    scene: &Scene,
    bearing: &BearingScene,
    built: &AnyBearing<f64>,
) -> Result<Option<Displacement<f64>>, BuildError> {
    let [about_x, about_y] = bearing.outer_ring_tilt;
    let tilt = Displacement { thu: -about_x, thv: -about_y, ..Displacement::default() };
    let Some(preload) = bearing.preload else { return Ok(has_tilt(bearing).then_some(tilt)) };
    Ok(Some(by_preload(scene, bearing, preload, built)? + tilt))
}

fn has_tilt(bearing: &BearingScene) -> bool {
    bearing.outer_ring_tilt != [0.0; 2]
}

/// Returns the displacement of the inner ring by a preload.
fn by_preload(
    scene: &Scene,
    bearing: &BearingScene,
    preload: Preload,
    built: &AnyBearing<f64>,
) -> Result<Displacement<f64>, BuildError> {
    let at = BearingKinematicState { inner_speed: scene.shaft.speed.nominal(), ..rotation_at(scene, bearing, 0.0)? };
    let Some(set) = as_set(bearing) else { return displaced(scene, bearing, preload, built, &at) };
    let built = construct::<f64, Exact, AnyBearing<f64>>(scene, &set, bearing_model(set.model).preload_model())?;
    let axial = |of: &BearingScene| match of.facing {
        // Without a displacement the grooves of a deep groove bearing are opposite each other.
        Facing::Both => 0.0,
        Facing::PlusZ | Facing::MinusZ => of.geometry.map_or(0.0, |geometry| geometry.axial_groove_distance()),
    };
    let shift = thrust_sign(bearing) * (axial(&set) - axial(bearing));
    let standing = BearingKinematicState { inner_speed: 0.0, outer_speed: 0.0, ..at };
    let offset = displaced(scene, &set, preload, &built, &standing)?;
    Ok(Displacement { w: offset.w + shift, ..offset })
}

/// Returns the direction of the thrust that a bearing carries.
fn thrust_sign(bearing: &BearingScene) -> f64 {
    if bearing.facing == Facing::MinusZ { -1.0 } else { 1.0 }
}

/// Returns the displacement by a preload as the bearing is, in the kinematic state `at`.
fn displaced(
    scene: &Scene,
    bearing: &BearingScene,
    preload: Preload,
    built: &AnyBearing<f64>,
    at: &BearingKinematicState<f64>,
) -> Result<Displacement<f64>, BuildError> {
    let sign = thrust_sign(bearing);
    match preload.amount {
        PreloadAmount::Displacement(w) => Ok(Displacement { w: sign * w, ..Displacement::default() }),
        PreloadAmount::Force(force) => {
            let rest = loaded(built, [0.0, 0.0, sign * force, 0.0, 0.0], at)?;
            if rest.residual > LARGEST_RESIDUAL {
                return Err(BuildError::Preload {
                    file: scene.path.clone(),
                    bearing: bearing.name.clone(),
                    found: force,
                });
            }
            Ok(rest.displacement())
        }
    }
}

/// Returns the displacement of the inner ring by preload and tilt of the outer ring; 0 without both.
///
/// # Errors
/// As [`mounted_offset`].
pub fn offset_as_mounted(scene: &Scene, of: &BearingScene) -> Result<Displacement<f64>, BuildError> {
    if of.preload.is_none() && !has_tilt(of) {
        return Ok(Displacement::default());
    }
    let built = construct::<f64, Exact, AnyBearing<f64>>(scene, of, bearing_model(of.model).preload_model())?;
    Ok(mounted_offset(scene, of, &built)?.unwrap_or_default())
}

/// Returns the bearing as its preload is set, without mounting; `None` where it is set in operation or nothing changes it.
fn as_set(bearing: &BearingScene) -> Option<BearingScene> {
    let (preload, mounting, clearance) = (bearing.preload?, bearing.mounting?, bearing.clearance()?);
    let reduction = |temperatures| mounting.at(temperatures).reduction();
    let at_setting = match preload.set {
        PreloadState::Unmounted => 0.0,
        PreloadState::Fitted => reduction(None),
        PreloadState::Operating => return None,
    };
    let mut set = bearing.clone();
    // A fit may have changed the operating clearance.
    set.set_clearance(clearance + reduction(mounting.temperatures) - at_setting);
    set.mounting = None;
    Some(set)
}

/// Returns the axial force of a bearing by its preload alone, at the scene's speed, with fits and temperatures, N; `None` without preload.
///
/// # Errors
/// As [`mounted_offset`].
pub fn preload_force(scene: &Scene, bearing: &BearingScene) -> Result<Option<f64>, BuildError> {
    if let Some(PreloadAmount::Force(force)) = bearing.preload.map(|preload| preload.amount)
        && bearing.has_constant_preload_force()
    {
        return Ok(Some(force));
    }
    let aligned = BearingScene { outer_ring_tilt: [0.0; 2], ..bearing.clone() };
    let built = construct::<f64, Exact, AnyBearing<f64>>(scene, bearing, bearing.model)?;
    let Some(offset) = mounted_offset(scene, &aligned, &built)? else { return Ok(None) };
    let at = rotation_at(scene, bearing, 0.0)?;
    let at = BearingKinematicState { inner_speed: scene.shaft.speed.nominal(), ..at };
    Ok(Some(built.reaction(&offset, &at).wrench.fz.abs()))
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
    let rotor = RigidRotor::<f64, Exact>::try_new(&params, &[])?;
    let mounted = BearingAtStation { bearing: bearing.clone(), station: 0.0, speed_ratios: SpeedRatios::new(0.0) };
    let machine = RotorBearingSystem { rotor, bearings: [mounted] };
    // From a displacement at which the bearing carries thrust, Newton's method needs a few steps. At a high speed, where the balls lie at the bottom of
    // the outer groove, it needs the displacement at which the bearing carries just this thrust. The damped motion from zero displacement
    // converges where both fail.
    let from = |start: Displacement<f64>| {
        let settled = (0..NEWTON_STEPS).try_fold(start, |u, _| newton_step(bearing, load, at, u));
        equilibrium(&machine, &[*at], settled.unwrap_or_default())
    };
    let carrying = thrust_interval(bearing, load, at);
    let mut found = from(along_axis(carrying[1], load));
    if found.residual > LARGEST_RESIDUAL {
        found = from(along_axis(halved(bearing, load, at, carrying), load));
    }
    if found.residual > LARGEST_RESIDUAL {
        found = equilibrium(&machine, &[*at], Displacement::default());
    }
    Ok(found)
}

/// Largest residual of an equilibrium over its load.
const LARGEST_RESIDUAL: f64 = 1e-6;
/// Largest number of Newton steps.
const NEWTON_STEPS: usize = 12;
/// Halvings of the interval in which the bearing carries the axial load: to a millionth of it.
const HALVINGS: usize = 20;
/// Axial displacements for the start, m.
const THRUST_STARTS: [f64; 6] = [3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3];

/// Returns an axial displacement along the axial load.
fn along_axis(w: f64, load: [f64; 5]) -> Displacement<f64> {
    Displacement { w: w * load[2].signum(), ..Displacement::default() }
}

/// Returns true where the bearing carries the axial load at an axial displacement.
fn carries(bearing: &AnyBearing<f64>, load: [f64; 5], at: &BearingKinematicState<f64>, w: f64) -> bool {
    bearing.reaction(&along_axis(w, load), at).wrench.fz.abs() >= load[2].abs()
}

/// Returns an axial displacement at which the bearing does not carry the axial load and the next at which it does; 0 where there is none.
fn thrust_interval(bearing: &AnyBearing<f64>, load: [f64; 5], at: &BearingKinematicState<f64>) -> [f64; 2] {
    let mut below = 0.0;
    for w in THRUST_STARTS {
        if carries(bearing, load, at, w) {
            return [below, w];
        }
        below = w;
    }
    [0.0; 2]
}

/// Returns the axial displacement within an interval at which the bearing carries the axial load.
fn halved(
    bearing: &AnyBearing<f64>,
    load: [f64; 5],
    at: &BearingKinematicState<f64>,
    [mut low, mut high]: [f64; 2],
) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if carries(bearing, load, at, middle) { high = middle } else { low = middle }
    }
    high
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
