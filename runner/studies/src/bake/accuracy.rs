//! Error of the written constants against the highest-fidelity model, over poses of the scene's bearings.

use super::{Language, Selected};
use crate::force;
use crate::precision;
use crate::trade::FidelityLevel;
use crate::trade::force::{apart, in_precision};
use crate::trade::poses::{self, Pose, Poses, SAMPLES_PER_REVOLUTION, TURNS, pose_of_sample};
use ballrace::bearing::Bearing as _;
use ballrace::bearing::checksum::ChecksumRange;
use ballrace::{Displacement, Exact, Wrench};
use ballrace_diagnosis::plausibility::range::{LARGEST_UNSEEN_FORCE, plausible_force};
use ballrace_models::bearing_model;
use ballrace_models::build::{self, TableData};
use ballrace_models::handle::{AnyBearing, AnyForceModel, ForceModel};
use ballrace_plant::error::{BakeError, Error, Result};
use ballrace_plant::{LARGEST_RESIDUAL, Plant};
use ballrace_scene::{Bearing, Model, Scene};
use std::path::Path;

/// Largest number of rows of a recording that are read: 80 s at 12.8 kHz.
const MAX_ROWS: usize = 1 << 20;
/// Largest number of samples of the transient of a computed motion: 64 revolutions.
const MAX_SETTLING: u64 = (4.0 * TURNS * SAMPLES_PER_REVOLUTION) as u64;

/// Number of poses of which one may be a spike.
const SPIKES: usize = 100;

/// Largest number of steps of the integrator.
const MAX_STEPS: f64 = 1e5;

/// Origin of the poses at which errors are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoseSource {
    /// Readings of the scene's recording.
    Recording,
    /// Motion of the scene's rotor on the written models.
    Simulation,
    /// Displacements of the checksum, for a scene without a rotor.
    Checksum,
}

impl PoseSource {
    /// All sources by their names.
    pub const ALL: [(&'static str, Self); 3] =
        [("recording", Self::Recording), ("simulation", Self::Simulation), ("checksum", Self::Checksum)];

    /// Returns the name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }
}

/// Returns the source of the poses and the poses of every bearing; the poses are `None` for [`PoseSource::Checksum`].
///
/// The source is `wanted`, or the first source that the scene allows.
///
/// # Errors
/// Returns an error if the source `wanted` cannot be read or computed.
pub fn poses(scene: &Scene, wanted: Option<PoseSource>) -> Result<(PoseSource, Option<Poses>)> {
    let written = scene_as_written(scene);
    let computed = |source| match source {
        PoseSource::Recording => recorded(&written),
        PoseSource::Simulation => simulated(&written).map(Some),
        PoseSource::Checksum => Ok(None),
    };
    if let Some(source) = wanted {
        return Ok((source, computed(source)?));
    }
    for source in [PoseSource::Recording, PoseSource::Simulation] {
        match computed(source) {
            Ok(Some(poses)) => return Ok((source, Some(poses))),
            Err(refused @ (Error::Bake(_) | Error::Motion(_))) => return Err(refused),
            // A source without displacements is not an error here: the next source replaces it.
            Ok(None) | Err(_) => {}
        }
    }
    Ok((PoseSource::Checksum, None))
}

/// Returns the scene with the models of the written constants.
pub fn scene_as_written(scene: &Scene) -> Scene {
    let mut written = scene.clone();
    for bearing in &mut written.bearings {
        bearing.model =
            bearing_model(bearing.model).firmware(bearing).map_or(bearing.model, |firmware| firmware.model());
    }
    written
}

fn recorded(scene: &Scene) -> Result<Option<Poses>> {
    let Some(recording) = &scene.recording else { return Ok(None) };
    let plant = Plant::try_new(scene)?;
    // Where the rotor bends or its supports move, the probes do not show the displacement of the bearings.
    if !plant.layout.is_rigid() {
        return Ok(None);
    }
    check_equilibrium(scene, &plant)?;
    let poses = poses::measured(scene, &plant, recording, MAX_ROWS)?;
    check_position(scene, &plant, (&recording.file, &poses))?;
    check_loads(scene, &plant, (&recording.file, &poses))?;
    Ok(Some(poses))
}

fn simulated(scene: &Scene) -> Result<Poses> {
    let plant = Plant::try_new(scene)?;
    check_equilibrium(scene, &plant)?;
    let mut span = poses::span(scene, &plant);
    span.settle = span.settle.min(MAX_SETTLING);
    let steps = f64::from(plant.substeps(1.0 / span.rate)?) * (span.settle + span.samples) as f64;
    // A higher rate limits the number of steps; a slow shaft then turns through fewer revolutions.
    span.rate *= (steps / MAX_STEPS).max(1.0);
    let poses = poses::computed_over(scene, &plant, span)?;
    check_loads(scene, &plant, (&scene.path, &poses))?;
    Ok(poses)
}

/// Rejects a rotor that its bearings do not support: its motion has no bounds.
fn check_equilibrium(scene: &Scene, plant: &Plant) -> Result<(), BakeError> {
    if plant.residual <= LARGEST_RESIDUAL {
        return Ok(());
    }
    Err(BakeError::NoEquilibrium { file: scene.path.clone(), residual: plant.residual, most: LARGEST_RESIDUAL })
}

/// Rejects a recorded position whose median force on a bearing is far beyond the loads on the rotor.
fn check_position(scene: &Scene, plant: &Plant, (file, poses): (&Path, &Poses)) -> Result<(), BakeError> {
    for (i, (mounted, poses)) in plant.bearings.iter().zip(poses).enumerate() {
        let most = plausible_force(scene, plant, i);
        let force = |pose: &Pose| {
            let force = ForceModel::reaction(&mounted.bearing, &pose.u, &pose.at).wrench;
            force.fx.hypot(force.fy).hypot(force.fz)
        };
        let mut forces: Vec<f64> = poses.iter().map(force).collect();
        forces.sort_by(f64::total_cmp);
        let found = forces.get(forces.len() / 2).copied().unwrap_or_default();
        if found > most {
            let (file, bearing) = (file.to_owned(), mounted.name.clone());
            return Err(BakeError::Position { file, bearing, found, most, factor: LARGEST_UNSEEN_FORCE });
        }
    }
    Ok(())
}

/// Rejects displacements that are no numbers or at which an element carries more than the static limit. Single readings of a recording
/// may be spikes.
fn check_loads(scene: &Scene, plant: &Plant, (file, poses): (&Path, &Poses)) -> Result<()> {
    for ((of, mounted), poses) in scene.bearings.iter().zip(&plant.bearings).zip(poses) {
        let bearing = || of.name.clone();
        if poses.iter().any(|pose| !pose.u.is_finite()) {
            let figure = "a displacement of the motion";
            return Err(BakeError::NotFinite { file: file.to_owned(), bearing: bearing(), figure }.into());
        }
        let Some(most) = build::static_limit(of)? else { continue };
        let mut on_elements = vec![0.0; mounted.elements];
        let largest = |pose: &Pose| {
            on_elements.fill(0.0);
            mounted.bearing.element_loads(&pose.u, &pose.at, &mut on_elements);
            on_elements.iter().copied().fold(0.0, f64::max)
        };
        let mut loads: Vec<f64> = poses.iter().map(largest).collect();
        loads.sort_by(f64::total_cmp);
        let found = loads.get(loads.len().saturating_sub(1 + loads.len() / SPIKES)).copied().unwrap_or_default();
        if found > most {
            return Err(BakeError::Overload { file: file.to_owned(), bearing: bearing(), found, most }.into());
        }
    }
    Ok(())
}

/// A bearing with the written constants, evaluated on the desktop.
pub(crate) struct BakedModel {
    /// Model of the constants.
    pub model: Model,
    /// Force in single precision: the same bits as firmware.
    pub force: AnyForceModel<f32>,
    /// Displacement by preload.
    pub offset: Displacement<f64>,
}

impl BakedModel {
    /// Creates the model that the firmware evaluates, with its table.
    ///
    /// # Errors
    /// Returns an error if the kernel rejects a parameter.
    pub fn try_new(
        scene: &Scene,
        Selected { of, firmware }: Selected<'_>,
        table: Option<&TableData>,
        language: Language,
    ) -> Result<Self> {
        let (model, offset) = (firmware.model(), build::offset_as_mounted(scene, of)?);
        let force = |of: &Bearing| match table {
            Some(made) => Ok(build::of_table::<f32, Exact, AnyForceModel<f32>>(of, made)?),
            None => force::handle(scene, of, model, build::force_model::<f32, Exact>),
        };
        let force = match language {
            Language::Rust => force(of)?,
            Language::C | Language::Blob => firmware.force_in_c(of)?.map_or_else(|| force(&firmware.in_c(of)), Ok)?,
        };
        Ok(Self { model, force, offset })
    }
}

/// Errors of one bearing.
#[derive(Debug, Clone, PartialEq)]
pub struct Accuracy {
    /// Number of poses.
    pub poses: usize,
    /// Name of the reference.
    pub reference: String,
    /// Largest load of the reference, N.
    pub largest_load: f64,
    /// Largest error, N; moments divided by half the pitch diameter.
    pub error: f64,
    /// True where the poses are the displacements of the checksum.
    pub is_of_checksum: bool,
}

/// Computes the error of bearing `i` of the scene against the highest-fidelity model.
///
/// The poses are the displacements of the checksum if no pose has a load.
///
/// # Errors
/// Returns an error if no model can be built from the scene.
pub fn accuracy(
    (scene, text): (&Scene, &str),
    i: usize,
    baked: &BakedModel,
    (poses, range): (Option<&Poses>, &ChecksumRange),
) -> Result<Accuracy> {
    let reference = dearest(scene, text, i)?;
    let arm = scene.bearings.get(i).and_then(Bearing::diameters).map_or(0.0, |[_, pitch]| 0.5 * pitch);
    if let Some(poses) = poses.and_then(|poses| poses.get(i)) {
        let found = error_at(poses, baked, &reference, arm);
        if found.largest_load > 0.0 {
            return Ok(found);
        }
    }
    let poses: Vec<Pose> = range.samples().map(|sample| pose_of_sample(&sample, &baked.offset)).collect();
    Ok(Accuracy { is_of_checksum: true, ..error_at(&poses, baked, &reference, arm) })
}

/// Returns the largest error over the poses; `arm` converts moments to forces.
fn error_at(poses: &[Pose], baked: &BakedModel, (name, exact, offset): &Reference, arm: f64) -> Accuracy {
    let (mut error, mut largest_load) = (0.0_f64, 0.0_f64);
    for pose in poses {
        let right = ForceModel::reaction(exact, &(pose.u + *offset), &pose.at).wrench;
        let (u, at) = in_precision::<f32>(pose);
        let found = baked.force.reaction(&(u + precision::displacement(&baked.offset)), &at).wrench;
        let found = Wrench::from_array(found.to_array().map(f64::from));
        largest_load = largest_load.max(apart(&right, &Wrench::default(), arm));
        let difference = apart(&found, &right, arm);
        error = if difference.is_nan() { f64::INFINITY } else { error.max(difference) };
    }
    Accuracy { poses: poses.len(), reference: name.clone(), largest_load, error, is_of_checksum: false }
}

/// Returns the total displacement of every pose.
#[must_use]
pub fn totals(poses: &[Pose], offset: &Displacement<f64>) -> Vec<Displacement<f64>> {
    poses.iter().map(|pose| pose.u + *offset).collect()
}

/// Name, bearing and displacement by preload of the reference.
type Reference = (String, AnyBearing<f64>, Displacement<f64>);

/// Returns the highest-fidelity model that the scene allows for bearing `i`, iterated to convergence.
fn dearest(scene: &Scene, text: &str, i: usize) -> Result<Reference> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let levels = FidelityLevel::all(scene);
    let levels = levels.iter().rev().filter(|level| !level.has_moving_elements());
    let mut levels = levels.filter_map(|level| reference(&level.converged(), scene, text, i).ok());
    levels.next().map_or_else(|| own_model(scene, i), Ok)
}

fn reference(level: &FidelityLevel, scene: &Scene, text: &str, i: usize) -> Result<Reference> {
    let edited = level.scene_with_one(text, scene, i)?;
    let (own, bearing, offset) = own_model(&edited, i)?;
    let name = match edited.bearings.get(i) {
        Some(of) if of.model.properties().solver_steps => format!("{own}, {}", effects(of)),
        Some(of) if of.model.has_elements() => level.name().to_owned(),
        _ => own,
    };
    Ok((name, bearing, offset))
}

/// Returns the names of the effects of a bearing.
fn effects(of: &Bearing) -> String {
    let named: Vec<&str> = of.effects.named().collect();
    if named.is_empty() { "no effects".to_owned() } else { named.join(", ") }
}

/// Returns the scene's own model in double precision.
fn own_model(scene: &Scene, i: usize) -> Result<Reference> {
    let of = scene.bearings.get(i).ok_or(ballrace_plant::error::TradeError::NoModel)?;
    let bearing = force::handle(scene, of, of.model, build::bearing)?;
    Ok((of.model.name().to_owned(), bearing, build::offset_as_mounted(scene, of)?))
}
