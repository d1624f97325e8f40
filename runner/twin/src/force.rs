//! Forces of one bearing for given displacements, in every precision and math of the kernel.

use crate::error::{Error, Result};
use crate::plant::Plant;
use crate::scene::build::{self, AnyBearing};
use crate::scene::{Bearing, Linear, Model, Scene};
use ballrace::bearing::{Bearing as _, LastValidWrench};
use ballrace::{BearingKinematicState, Displacement, Exact, Fast, Math, Scalar, Status, Wrench};

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
        (Precision::F64, MathBackend::Exact) => forces_in::<f64, Exact>(scene, bearing, model, poses),
        (Precision::F64, MathBackend::Fast) => forces_in::<f64, Fast>(scene, bearing, model, poses),
        (Precision::F32, MathBackend::Exact) => forces_in::<f32, Exact>(scene, bearing, model, poses),
        (Precision::F32, MathBackend::Fast) => forces_in::<f32, Fast>(scene, bearing, model, poses),
    }
}

fn forces_in<T: Scalar, M: Math<T>>(
    scene: &Scene,
    bearing: &Bearing,
    model: Model,
    poses: &[Pose],
) -> Result<Vec<(Wrench<f64>, Status)>> {
    let kernel = kernel::<T, M>(scene, bearing, model).map_err(Error::setup)?;
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
fn kernel<T: Scalar, M: Math<T>>(scene: &Scene, bearing: &Bearing, model: Model) -> Result<AnyBearing<T>> {
    if model == Model::Linear && matches!(bearing.linear, Some(Linear::Of(_))) {
        return Ok(build::spring_of(&Plant::try_new(scene)?.mounted(&bearing.name)?.bearing));
    }
    build::bearing::<T, M>(scene, bearing, model).map_err(Error::in_file(&scene.path))
}
