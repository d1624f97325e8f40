//! Forces of one bearing for given displacements, in every precision and math of the kernel.

use crate::error::{Error, Result};
use crate::handle::{BearingHandle, ForceModel};
use crate::plant::Plant;
use crate::scene::build::{self, BuildError};
use crate::scene::{Bearing, Linear, Model, Scene};
use ballrace::bearing::LastValidWrench;
use ballrace::{BearingKinematicState, Displacement, Exact, Fast, Scalar, Status, Wrench};

/// Floating-point precision of the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Precision {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// Square roots and powers of the kernel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum MathBackend {
    /// Correctly rounded square roots, powers by libm.
    Exact,
    /// Approximations by micromath.
    Fast,
}

/// A displacement of the inner ring against the outer ring, and how the bearing is turned with it.
#[derive(Debug, Clone, Copy)]
pub struct Pose {
    /// u, v, w (m), thu, thv (rad).
    pub u: [f64; 5],
    /// Angles and speeds of the bearing's parts.
    pub at: BearingKinematicState<f64>,
}

/// Returns the force on the inner ring and its status at each of `poses`, as `model` computes it. A pose that is not finite
/// repeats the last valid force.
///
/// # Errors
/// A scene that lacks what the model needs, values that the kernel refuses.
pub fn forces(
    scene: &Scene,
    bearing: &Bearing,
    model: Model,
    (precision, math): (Precision, MathBackend),
    poses: &[Pose],
) -> Result<Vec<(Wrench<f64>, Status)>> {
    match (precision, math) {
        // The bearings of the plants, so that these are compiled once.
        (Precision::F64, MathBackend::Exact) => forces_of(scene, bearing, model, build::bearing, poses),
        (Precision::F64, MathBackend::Fast) => forces_of(scene, bearing, model, build::force_model::<f64, Fast>, poses),
        (Precision::F32, MathBackend::Exact) => {
            forces_of(scene, bearing, model, build::force_model::<f32, Exact>, poses)
        }
        (Precision::F32, MathBackend::Fast) => forces_of(scene, bearing, model, build::force_model::<f32, Fast>, poses),
    }
}

/// Builds the handle of a model of one bearing.
type Build<H> = fn(&Scene, &Bearing, Model) -> Result<H, BuildError>;

fn forces_of<T: Scalar, H: BearingHandle<T> + ForceModel<T>>(
    scene: &Scene,
    bearing: &Bearing,
    model: Model,
    build: Build<H>,
    poses: &[Pose],
) -> Result<Vec<(Wrench<f64>, Status)>> {
    let kernel = handle(scene, bearing, model, build).map_err(Error::setup)?;
    let mut held = LastValidWrench::new();
    let evaluate = |pose: &Pose| {
        let u = Displacement::from_array(pose.u.map(T::from_f64));
        let at = BearingKinematicState {
            cage: pose.at.cage,
            inner: pose.at.inner,
            outer: pose.at.outer,
            ball: pose.at.ball,
            inner_speed: T::from_f64(pose.at.inner_speed),
            outer_speed: T::from_f64(pose.at.outer_speed),
        };
        let (wrench, status) = kernel.sample(&mut held, &u, &at);
        let [fx, fy, fz, mx, my] = wrench.to_array().map(Scalar::to_f64);
        (Wrench { fx, fy, fz, mx, my }, status)
    };
    Ok(poses.iter().map(evaluate).collect())
}

/// The bearing; one linearised from another model takes its springs from the rotor's equilibrium.
fn handle<T: Scalar, H: BearingHandle<T>>(
    scene: &Scene,
    bearing: &Bearing,
    model: Model,
    build: Build<H>,
) -> Result<H> {
    if model == Model::Linear && matches!(bearing.linear, Some(Linear::Of(_))) {
        return Ok(build::spring_of(&Plant::try_new(scene)?.mounted(&bearing.name)?.bearing));
    }
    build(scene, bearing, model).map_err(Error::in_file(&scene.path))
}
