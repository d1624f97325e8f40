//! Forces of one bearing for given displacements, in every precision and math of the kernel.

use crate::precision;
use ballrace::bearing::{LastValidWrench, Reaction};
use ballrace::{BearingKinematicState, Displacement, Exact, Fast, Scalar, Status};
use ballrace_models::build::{self, BuildError};
use ballrace_models::handle::{AnyBearing, BearingHandle, ForceModel};
use ballrace_models::simd::SIDE_BY_SIDE;
use ballrace_plant::Plant;
use ballrace_plant::error::{Error, Result};
use ballrace_scene::{Bearing, Model, Scene};
use std::marker::PhantomData;

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

/// Force of one bearing by one model.
pub struct BearingForce(Box<dyn Evaluate>);

impl BearingForce {
    /// Creates the model `model` of a bearing in one precision and math.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value that the model requires or the kernel rejects a value.
    pub fn try_new(
        scene: &Scene,
        bearing: &Bearing,
        model: Model,
        (precision, math): (Precision, MathBackend),
    ) -> Result<Self> {
        Ok(Self(match (precision, math) {
            // The plants use the same types, which are therefore compiled once.
            (Precision::F64, MathBackend::Exact) => evaluator(scene, bearing, model, build::bearing)?,
            (Precision::F64, MathBackend::Fast) => evaluator(scene, bearing, model, build::force_model::<f64, Fast>)?,
            (Precision::F32, MathBackend::Exact) => evaluator(scene, bearing, model, build::force_model::<f32, Exact>)?,
            (Precision::F32, MathBackend::Fast) => evaluator(scene, bearing, model, build::force_model::<f32, Fast>)?,
        }))
    }

    /// Computes the force on the inner ring `FX FY FZ MX MY` (N, N m) and its status at each displacement `u v w thu thv` (m, rad);
    /// `at` returns the rotation of the bearing by the number of the displacement. A displacement that is not finite repeats the
    /// last valid force. Excess elements of the longer slices are left unchanged.
    pub fn evaluate(
        &self,
        displacements: &[[f64; 5]],
        at: &dyn Fn(usize) -> BearingKinematicState<f64>,
        forces: &mut [[f64; 5]],
        status: &mut [Status],
    ) {
        self.0.evaluate(displacements, at, forces, status);
    }
}

/// A force model behind a pointer, called once for a whole sequence of displacements.
trait Evaluate: Send + Sync {
    fn evaluate(
        &self,
        displacements: &[[f64; 5]],
        at: &dyn Fn(usize) -> BearingKinematicState<f64>,
        forces: &mut [[f64; 5]],
        status: &mut [Status],
    );
}

/// A force model in one precision.
struct InPrecision<T, H>(H, PhantomData<fn() -> T>);

impl<T: Scalar, H: ForceModel<T>> Evaluate for InPrecision<T, H> {
    fn evaluate(
        &self,
        displacements: &[[f64; 5]],
        at: &dyn Fn(usize) -> BearingKinematicState<f64>,
        forces: &mut [[f64; 5]],
        status: &mut [Status],
    ) {
        let mut held = LastValidWrench::new();
        let blocks = displacements.chunks(SIDE_BY_SIDE).zip(forces.chunks_mut(SIDE_BY_SIDE));
        for (block, ((rows, forces), status)) in blocks.zip(status.chunks_mut(SIDE_BY_SIDE)).enumerate() {
            let mut u = [Displacement::default(); SIDE_BY_SIDE];
            let mut states = [BearingKinematicState::default(); SIDE_BY_SIDE];
            let mut reactions = [Reaction::default(); SIDE_BY_SIDE];
            for (i, row) in rows.iter().enumerate() {
                u[i] = Displacement::from_array(row.map(T::from_f64));
                states[i] = precision::kinematic_state(&at(block * SIDE_BY_SIDE + i));
            }
            let u = &u[..rows.len()];
            self.0.reactions(u, &states, &mut reactions);
            for (((force, status), u), reaction) in forces.iter_mut().zip(status).zip(u).zip(reactions) {
                let (wrench, flags) = held.update(u.is_finite(), || reaction);
                *force = wrench.to_array().map(Scalar::to_f64);
                *status = flags;
            }
        }
    }
}

/// Builds the handle of a model of one bearing.
pub type Build<H> = fn(&Scene, &Bearing, Model) -> Result<H, BuildError>;

fn evaluator<T: Scalar, H: BearingHandle<T> + ForceModel<T> + 'static>(
    scene: &Scene,
    bearing: &Bearing,
    model: Model,
    build: Build<H>,
) -> Result<Box<dyn Evaluate>> {
    let handle = handle(scene, bearing, model, build).map_err(Error::setup)?;
    Ok(Box::new(InPrecision(handle, PhantomData)))
}

/// Builds the model of one bearing in double precision with exact math, with its tangent stiffness and element loads.
///
/// # Errors
/// Returns the errors of [`BearingForce::try_new`].
pub fn bearing_model(scene: &Scene, bearing: &Bearing, model: Model) -> Result<AnyBearing<f64>> {
    handle(scene, bearing, model, build::bearing).map_err(Error::setup)
}

/// Builds the model of one bearing; one linearised from another model takes its springs from the rotor's equilibrium.
///
/// # Errors
/// Returns the errors of [`BearingForce::try_new`].
pub fn handle<T: Scalar, H: BearingHandle<T>>(
    scene: &Scene,
    bearing: &Bearing,
    model: Model,
    build: Build<H>,
) -> Result<H> {
    if model == bearing.model && bearing.is_linearised() {
        return Ok(build::spring_of(&Plant::try_new(scene)?.mounted(&bearing.name)?.bearing));
    }
    build(scene, bearing, model).map_err(Error::in_file(&scene.path))
}
