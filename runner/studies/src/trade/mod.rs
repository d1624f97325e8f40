//! Speed against accuracy on the motion of a scene: error and cost of every fidelity level in every arithmetic, against the
//! most accurate level as the reference.

mod choose;
pub(crate) mod cores;
pub mod force;
mod level;
pub mod poses;
mod response;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod table_tests;
mod timing;

pub use choose::{Choice, Goal, Target};
pub use cores::{Core, Cost, NotCounted};
pub use force::{Arithmetic, Errors};
pub use level::FidelityLevel;
pub use response::MotionErrors;
pub use timing::TimingSpread;

use crate::effect_significance::{self, EffectSignificance};
use ballrace_models::build::check_forces;
use ballrace_plant::Plant;
use ballrace_plant::error::{Result, TradeError, with_causes};
use ballrace_scene::{Method, Scene};
use force::{ARITHMETICS, Reference, forces};
use response::METHODS;
use serde::Serialize;

/// Result of a comparison of models.
#[derive(Debug, Clone, Serialize)]
pub struct Trade {
    /// The scene's name.
    pub scene: String,
    /// Source of the poses: `recording`, `simulation`, or `displacements about the preload` of bearings without a rotor.
    pub motion: &'static str,
    /// Poses of each bearing at which forces are compared.
    pub poses: usize,
    /// The reference of all candidates.
    pub truth: String,
    /// Name of the level that the motions are compared with: one whose balls move by themselves, where the scene has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion_truth: Option<String>,
    /// The largest load of a bearing over the motion, N: denominator of relative errors.
    pub largest_load: f64,
    /// Candidates for the forces.
    pub candidates: Vec<Candidate>,
    /// Computed motions.
    pub responses: Vec<Response>,
    /// Models that do not apply to the scene, with the reason.
    pub impossible: Vec<Impossible>,
    /// Spread of the timings on this machine.
    pub timing_spread: TimingSpread,
    /// Predicted change of force by each effect.
    #[serde(rename = "effect_significance")]
    pub significance: Vec<EffectSignificance>,
    /// The recommended candidate, where a goal was given.
    pub choice: Option<Choice>,
}

/// One level in one arithmetic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// The level with its options.
    pub model: String,
    /// Precision and math of the forces.
    pub arithmetic: Arithmetic,
    /// Error against the reference.
    pub error: Errors,
    /// Error of the level in exact arithmetic.
    pub modelling: Errors,
    /// Error against the same level in exact arithmetic.
    pub rounding: Errors,
    /// Time of one force of every bearing on this machine, ns.
    pub desktop_ns: f64,
    /// Interquartile range of its timings over their median.
    pub desktop_spread: f64,
    /// Cost of one sample of every bearing, a force with its input checked, on a Cortex-M4F; `None` where it was not counted.
    pub cortex: Option<Cost>,
    /// Reason where it was not counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cortex_not_counted: Option<NotCounted>,
    /// Error of the motion with this model where it overflows with every integrator and step; such a candidate is not recommended.
    pub overflow: Option<String>,
    /// True where no candidate is both cheaper on this machine and more accurate.
    pub front_desktop: bool,
    /// True where no candidate is both cheaper on the target and more accurate.
    pub front_cortex: bool,
}

/// One computed motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// The level.
    pub model: String,
    /// Precision of the forces; the rotor is computed in `f64`.
    pub precision: &'static str,
    /// Name of the integrator in a scene.
    pub method: &'static str,
    /// Time step, s.
    pub step: f64,
    /// True for the default integrator and step.
    pub usual: bool,
    /// Error against the reference.
    pub error: MotionErrors,
    /// Simulated time over computing time; 0 for a motion that overflows.
    pub times_real_time: f64,
    /// Interquartile range of the computing times of equal parts over their median.
    pub spread: f64,
    /// Error of a motion that overflows.
    pub overflow: Option<String>,
    /// True where no response is both faster and more accurate.
    pub front: bool,
}

/// A level that the scene does not allow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Impossible {
    /// The level.
    pub model: String,
    /// Reason: the error of the scene or the kernel.
    pub why: String,
}

/// A level that the scene allows.
struct Allowed {
    level: FidelityLevel,
    scene: Scene,
    /// None for bearings without a rotor.
    plant: Option<Plant>,
}

/// Callback of the progress: number of finished steps, number of all steps.
pub type Progress<'a> = &'a dyn Fn(usize, usize);

/// Compares all levels that the scene allows; without `motions` or without a rotor their forces only.
///
/// # Errors
/// A scene without a possible level.
pub fn trade(
    scene: &Scene,
    text: &str,
    (goal, motions): (Option<&Goal>, bool),
    progress: Progress<'_>,
) -> Result<Trade> {
    let (allowed, impossible) = allowed(scene, text)?;
    let dearest = dearest(&allowed).ok_or(TradeError::NoModel)?;
    let truth_level = dearest.level.converged();
    let truth_scene = truth_level.scene(text, &scene.path, scene)?;
    let truth_plant = dearest.plant.is_some().then(|| Plant::try_new(&truth_scene)).transpose()?;
    // Where the rotor bends or its supports move, the probes do not show the displacement of the bearings.
    let is_rigid = truth_plant.as_ref().is_some_and(|plant| plant.layout.is_rigid());
    let recording = scene.recording.as_ref().filter(|_| is_rigid);
    let (motion, poses) = match (&truth_plant, recording) {
        (Some(plant), Some(recording)) => ("recording", poses::measured(scene, plant, recording, usize::MAX)?),
        (Some(plant), None) => ("simulation", poses::computed(&truth_scene, plant)?),
        (None, _) => ("displacements about the preload", poses::about_preload(&truth_scene)?),
    };
    let right = forces(&truth_scene, truth_plant.as_ref(), ARITHMETICS[0])?;
    let truth = Reference::new(&truth_scene, right.as_ref(), &poses);
    if truth.largest() <= 0.0 {
        return Err(TradeError::NoLoad { file: scene.path.clone() }.into());
    }
    let solved = truth_plant.as_ref().filter(|_| motions);
    let work = allowed.len() * if solved.is_some() { 1 + METHODS.len() * STEPS.len() } else { 1 };
    let mut candidates = Vec::new();
    for (i, one) in allowed.iter().enumerate() {
        if !one.level.has_moving_elements() {
            candidates.extend(candidates_of(one, &truth, &poses)?);
        }
        progress(i + 1, work);
    }
    // Balls with mass describe the motion more accurately than balls in equilibrium.
    let dynamic = allowed.iter().rev().find(|one| one.level.has_moving_elements());
    let moving = dynamic.and_then(|one| Some((&one.scene, one.plant.as_ref()?, one.level.name())));
    let compared = solved.map(|plant| moving.unwrap_or((&truth_scene, plant, truth_level.name())));
    let responses = match compared {
        Some((scene, plant, _)) => responses(&allowed, (scene, plant), work, progress)?,
        None => vec![],
    };
    for candidate in &mut candidates {
        let level = allowed.iter().find(|one| one.level.name() == candidate.model);
        let model = level.map_or(candidate.model.as_str(), |one| one.level.name_without_steps());
        let motions: Vec<&Response> = responses.iter().filter(|r| r.model == model).collect();
        if motions.iter().all(|motion| motion.overflow.is_some()) {
            candidate.overflow = motions.first().and_then(|motion| motion.overflow.clone());
        }
    }
    choose::mark(&mut candidates);
    let choice = goal.map(|goal| choose::choose(goal, &candidates)).transpose()?;
    let spreads = candidates.iter().map(|c| c.desktop_spread).chain(responses.iter().map(|r| r.spread)).collect();
    Ok(Trade {
        scene: scene.name.clone(),
        motion,
        poses: poses.first().map_or(0, Vec::len),
        truth: truth_level.name().to_owned(),
        motion_truth: compared.map(|(_, _, name)| name.to_owned()),
        largest_load: truth.largest(),
        candidates,
        responses,
        impossible,
        timing_spread: TimingSpread::new(spreads),
        significance: effect_significance::of_scene(scene)?,
        choice,
    })
}

/// Returns the scene's text with the level of this name.
///
/// # Errors
/// No such level.
pub fn written(scene: &Scene, text: &str, level: &str) -> Result<String, TradeError> {
    let levels = FidelityLevel::all(scene);
    let unknown = || TradeError::UnknownLevel { found: level.to_owned() };
    levels.iter().find(|r| r.name() == level).ok_or_else(unknown)?.written(text, scene)
}

fn allowed(scene: &Scene, text: &str) -> Result<(Vec<Allowed>, Vec<Impossible>)> {
    check_forces(scene)?;
    let moves = scene.rotor.is_some() || scene.system.is_some();
    let (mut allowed, mut impossible) = (Vec::new(), Vec::new());
    for level in FidelityLevel::all(scene) {
        let tried = level.scene(text, &scene.path, scene).and_then(|scene| {
            let plant = moves.then(|| Plant::try_new(&scene)).transpose()?;
            forces(&scene, plant.as_ref(), ARITHMETICS[0])?;
            Ok((plant, scene))
        });
        match tried {
            Ok((plant, scene)) => allowed.push(Allowed { level, scene, plant }),
            Err(error) => impossible.push(Impossible { model: level.name().to_owned(), why: with_causes(&error) }),
        }
    }
    Ok((allowed, impossible))
}

/// Returns the most expensive level with forces of its own.
fn dearest(allowed: &[Allowed]) -> Option<&Allowed> {
    allowed.iter().rev().find(|one| !one.level.has_moving_elements())
}

fn candidates_of(one: &Allowed, truth: &Reference, poses: &poses::Poses) -> Result<Vec<Candidate>> {
    let exact = forces(&one.scene, one.plant.as_ref(), ARITHMETICS[0])?;
    let modelling = truth.errors(exact.as_ref(), poses);
    let candidate = |arithmetic: Arithmetic| {
        let forces = forces(&one.scene, one.plant.as_ref(), arithmetic)?;
        let cost = |of| cores::sample(Core::CortexM4f, of, arithmetic.precision, arithmetic.math);
        let cortex = one.scene.bearings.iter().map(cost).reduce(|a, b| Ok(a?.plus(b?))).transpose();
        let (desktop_ns, desktop_spread) = forces.time(poses);
        Ok(Candidate {
            model: one.level.name().to_owned(),
            arithmetic,
            error: truth.errors(forces.as_ref(), poses),
            modelling,
            rounding: truth.rounding(forces.as_ref(), exact.as_ref(), poses),
            desktop_ns,
            desktop_spread,
            cortex: cortex.ok().flatten(),
            cortex_not_counted: cortex.err(),
            overflow: None,
            front_desktop: false,
            front_cortex: false,
        })
    };
    ARITHMETICS.into_iter().map(candidate).collect()
}

/// Time steps that are compared, over the default step.
const STEPS: [f64; 3] = [0.5, 1.0, 2.0];

fn responses(
    allowed: &[Allowed],
    (moving, plant): (&Scene, &Plant),
    work: usize,
    progress: Progress<'_>,
) -> Result<Vec<Response>> {
    let truth_plant = plant.with_step(Method::RungeKutta, 0.25);
    let span = poses::span(moving, &truth_plant);
    let truth = response::run(moving, &truth_plant, span)?;
    if let Some(reason) = truth.overflow.clone() {
        return Err(TradeError::Reference { reason }.into());
    }
    let mut all = Vec::new();
    for (i, one) in allowed.iter().enumerate() {
        if one.level.has_bodies() {
            // The reference itself, which is as slow as all others together.
            all.push(response(one, ("dormand-prince", "f64", true), truth.mean_step.unwrap_or(0.0), &truth, &truth));
            continue;
        }
        for (j, (name, method)) in METHODS.into_iter().enumerate() {
            for (k, part) in STEPS.into_iter().enumerate() {
                progress(allowed.len() + (i * METHODS.len() + j) * STEPS.len() + k + 1, work);
                // Started from the last sample, every number of solver steps gives the same result.
                if one.level.has_own_steps() {
                    continue;
                }
                let Some(plant) = &one.plant else { continue };
                let plant = plant.with_step(method, part);
                let usual = part == 1.0 && method == Method::RungeKutta;
                all.push(response_of(one, &plant, (name, "f64", usual), span, &truth)?);
                if usual && !one.level.has_moving_elements() {
                    let single = force::in_single(&one.scene, plant)?;
                    all.push(response_of(one, &single, (name, "f32", usual), span, &truth)?);
                }
            }
        }
    }
    choose::mark_responses(&mut all);
    Ok(all)
}

fn response_of(
    one: &Allowed,
    plant: &Plant,
    (method, precision, usual): (&'static str, &'static str, bool),
    span: ballrace_plant::motion::Span,
    truth: &response::Motion,
) -> Result<Response> {
    let found = response::run(&one.scene, plant, span)?;
    let step = 1.0 / span.rate / f64::from(plant.substeps(1.0 / span.rate)?);
    Ok(response(one, (method, precision, usual), step, &found, truth))
}

fn response(
    one: &Allowed,
    (method, precision, usual): (&'static str, &'static str, bool),
    step: f64,
    found: &response::Motion,
    truth: &response::Motion,
) -> Response {
    Response {
        model: one.level.name().to_owned(),
        precision,
        method,
        step,
        usual,
        error: found.errors(truth),
        spread: found.spread,
        times_real_time: if found.overflow.is_some() { 0.0 } else { 1.0 / found.seconds_per_second },
        overflow: found.overflow.clone(),
        front: false,
    }
}
