//! Forces of a candidate at the poses of the scene's motion: their errors and their computing time.

use super::poses::{Pose, Poses};
use super::timing::spread;
use crate::precision;
use ballrace::bearing::{Bearing, Reaction};
use ballrace::{BearingKinematicState, Displacement, Exact, Fast, Scalar, Stiffness, Wrench};
use ballrace_models::build::{self, AnyBearing, BuildError};
use ballrace_models::handle::{AnyForceModel, BearingHandle, ForceModel};
use ballrace_plant::Plant;
use ballrace_scene::{Model, Scene};
use serde::Serialize;
use std::hint::black_box;
use std::time::Instant;

/// Precision and math functions of a force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Arithmetic {
    /// `f32` or `f64`
    pub precision: &'static str,
    /// `exact` or `fast`
    pub math: &'static str,
}

/// All combinations, the most accurate first.
pub(crate) const ARITHMETICS: [Arithmetic; 4] = [
    Arithmetic { precision: "f64", math: "exact" },
    Arithmetic { precision: "f64", math: "fast" },
    Arithmetic { precision: "f32", math: "exact" },
    Arithmetic { precision: "f32", math: "fast" },
];

/// Errors relative to the largest load of all bearings over the motion.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Errors {
    /// Median over all poses.
    pub median: f64,
    /// Exceeded by one pose in a hundred.
    pub most_99: f64,
    /// Largest over all poses.
    pub largest: f64,
}

/// Number of timings, of which the fastest counts: disturbances only add time.
const ROUNDS: usize = 7;

/// The bearings of one candidate in one arithmetic.
pub trait Forces {
    /// Returns the forces of bearing `i` at each pose, N and N m.
    fn wrenches(&self, i: usize, poses: &[Pose]) -> Vec<Wrench<f64>>;

    /// Returns the time for one force of every bearing, ns, and the spread of its timings.
    fn time(&self, poses: &Poses) -> (f64, f64);
}

/// Creates the candidate's bearings as mounted in the plant, or alone without one.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn forces(scene: &Scene, plant: Option<&Plant>, arithmetic: Arithmetic) -> Result<Box<dyn Forces>, BuildError> {
    Ok(match (arithmetic.precision, arithmetic.math) {
        ("f32", "exact") => Box::new(CandidateBearings::try_new(scene, plant, build::force_model::<f32, Exact>)?),
        ("f32", _) => Box::new(CandidateBearings::try_new(scene, plant, build::force_model::<f32, Fast>)?),
        (_, "exact") => Box::new(CandidateBearings::try_new(scene, plant, build::bearing)?),
        _ => Box::new(CandidateBearings::try_new(scene, plant, build::force_model::<f64, Fast>)?),
    })
}

/// Each bearing and its displacement by preload.
struct CandidateBearings<T, H> {
    bearings: Vec<(H, Displacement<T>)>,
}

impl<T: Scalar, H: BearingHandle<T> + ForceModel<T>> CandidateBearings<T, H> {
    fn try_new(
        scene: &Scene,
        plant: Option<&Plant>,
        build: fn(&Scene, &ballrace_scene::Bearing, Model) -> Result<H, BuildError>,
    ) -> Result<Self, BuildError> {
        let mounted = |(i, of): (usize, &ballrace_scene::Bearing)| {
            let mounted = plant.and_then(|plant| plant.bearings.get(i));
            let bearing = match mounted {
                Some(mounted) if of.is_linearised() => build::spring_of(&mounted.bearing),
                _ => build(scene, of, of.model)?,
            };
            let offset = mounted.map_or_else(|| build::offset_as_mounted(scene, of), |mounted| Ok(mounted.offset))?;
            Ok((bearing, precision::displacement(&offset)))
        };
        Ok(Self { bearings: scene.bearings.iter().enumerate().map(mounted).collect::<Result<_, BuildError>>()? })
    }
}

/// Returns a pose in another precision.
pub(crate) fn in_precision<T: Scalar>(pose: &Pose) -> (Displacement<T>, BearingKinematicState<T>) {
    (precision::displacement(&pose.u), precision::kinematic_state(&pose.at))
}

impl<T: Scalar, H: ForceModel<T>> Forces for CandidateBearings<T, H> {
    fn wrenches(&self, i: usize, poses: &[Pose]) -> Vec<Wrench<f64>> {
        let Some((bearing, offset)) = self.bearings.get(i) else { return vec![] };
        let wrench = |pose: &Pose| {
            let (u, at) = in_precision::<T>(pose);
            Wrench::from_array(bearing.reaction(&(u + *offset), &at).wrench.to_array().map(Scalar::to_f64))
        };
        poses.iter().map(wrench).collect()
    }

    fn time(&self, poses: &Poses) -> (f64, f64) {
        let ready: Vec<Vec<_>> = poses.iter().map(|poses| poses.iter().map(in_precision::<T>).collect()).collect();
        let of_bearing = |((bearing, offset), ready): (&(H, Displacement<T>), &Vec<_>)| {
            let round = || {
                let begun = Instant::now();
                for (u, at) in ready {
                    let u: &Displacement<T> = black_box(u);
                    black_box(bearing.reaction(&(*u + *offset), black_box(at)));
                }
                begun.elapsed().as_secs_f64() * 1e9 / ready.len().max(1) as f64
            };
            let times: Vec<f64> = (0..ROUNDS).map(|_| round()).collect();
            (times.iter().copied().fold(f64::INFINITY, f64::min), spread(times))
        };
        let all = self.bearings.iter().zip(&ready).map(of_bearing);
        all.fold((0.0, 0.0), |(sum, largest), (time, spread)| (sum + time, spread.max(largest)))
    }
}

/// The reference of all candidates.
pub struct Reference {
    wrenches: Vec<Vec<Wrench<f64>>>,
    largest: f64,
    /// Lever arm of each bearing, m, by which moments are converted to forces.
    arms: Vec<f64>,
}

impl Reference {
    /// Creates the reference from the most accurate forces.
    #[must_use]
    pub fn new(scene: &Scene, forces: &dyn Forces, poses: &Poses) -> Self {
        let wrenches: Vec<_> = poses.iter().enumerate().map(|(i, poses)| forces.wrenches(i, poses)).collect();
        let arm = |of: &ballrace_scene::Bearing| of.diameters().map_or(0.0, |[_, pitch]| 0.5 * pitch);
        let arms: Vec<f64> = scene.bearings.iter().map(arm).collect();
        let zero = Wrench::default();
        let sizes = wrenches.iter().zip(&arms).flat_map(|(all, &arm)| all.iter().map(move |f| apart(f, &zero, arm)));
        let largest = sizes.fold(0.0, f64::max);
        Self { wrenches, largest, arms }
    }

    /// Returns the largest load, N.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Returns the errors of a candidate.
    #[must_use]
    pub fn errors(&self, forces: &dyn Forces, poses: &Poses) -> Errors {
        let found: Vec<_> = poses.iter().enumerate().map(|(i, poses)| forces.wrenches(i, poses)).collect();
        self.errors_of(&found, &self.wrenches)
    }

    /// Returns the errors of a candidate against the same level in the most accurate arithmetic.
    #[must_use]
    pub fn rounding(&self, forces: &dyn Forces, exact: &dyn Forces, poses: &Poses) -> Errors {
        let all = |forces: &dyn Forces| -> Vec<_> {
            poses.iter().enumerate().map(|(i, poses)| forces.wrenches(i, poses)).collect()
        };
        self.errors_of(&all(forces), &all(exact))
    }

    fn errors_of(&self, found: &[Vec<Wrench<f64>>], right: &[Vec<Wrench<f64>>]) -> Errors {
        let largest = self.largest.max(f64::MIN_POSITIVE);
        let mut errors = Vec::new();
        for ((found, right), &arm) in found.iter().zip(right).zip(&self.arms) {
            errors.extend(found.iter().zip(right).map(|(f, r)| apart(f, r, arm) / largest));
        }
        // A NaN counts as an infinite error.
        errors.iter_mut().filter(|e| e.is_nan()).for_each(|e| *e = f64::INFINITY);
        errors.sort_by(f64::total_cmp);
        let part = |p: f64| errors.get(((errors.len() as f64 - 1.0) * p).round() as usize).copied().unwrap_or(0.0);
        Errors { median: part(0.5), most_99: part(0.99), largest: part(1.0) }
    }
}

/// Returns the length of the difference of two wrenches, moments divided by the arm.
pub fn apart(f: &Wrench<f64>, g: &Wrench<f64>, arm: f64) -> f64 {
    let per_arm = if arm > 0.0 { 1.0 / arm } else { 0.0 };
    let scale = [1.0, 1.0, 1.0, per_arm, per_arm];
    let square = f.to_array().into_iter().zip(g.to_array()).zip(scale).map(|((f, g), s)| ((f - g) * s).powi(2));
    square.sum::<f64>().sqrt()
}

/// Returns the plant with bearings that compute their forces in single precision.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub(crate) fn in_single(scene: &Scene, mut plant: Plant) -> Result<Plant, BuildError> {
    let single = CandidateBearings::try_new(scene, Some(&plant), build::force_model::<f32, Exact>)?;
    for (mounted, (bearing, offset)) in plant.bearings.iter_mut().zip(single.bearings) {
        let double = mounted.cold();
        mounted.replace(AnyBearing::new(Single { bearing, offset, double }));
    }
    Ok(plant)
}

/// A bearing whose force is computed in single precision. Its tangent, which only determines the Newton steps, and its
/// element loads are those of double precision.
struct Single {
    bearing: AnyForceModel<f32>,
    offset: Displacement<f32>,
    /// With the preload.
    double: AnyBearing<f64>,
}

impl Bearing<f64> for Single {
    fn reaction(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Reaction<f64> {
        let (u, at) = in_precision::<f32>(&Pose { u: *u, at: *at });
        let single = self.bearing.reaction(&(u + self.offset), &at);
        Reaction {
            wrench: Wrench::from_array(single.wrench.to_array().map(f64::from)),
            load: f64::from(single.load),
            status: single.status,
        }
    }
    fn reaction_and_stiffness(
        &self,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
    ) -> (Reaction<f64>, Stiffness<f64>) {
        let (_, k) = self.double.reaction_and_stiffness(u, at);
        (self.reaction(u, at), k)
    }
    fn element_loads(&self, u: &Displacement<f64>, at: &BearingKinematicState<f64>, loads: &mut [f64]) {
        self.double.element_loads(u, at, loads);
    }
}
