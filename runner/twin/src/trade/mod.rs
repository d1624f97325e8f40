//! Speed against accuracy, measured on a scene's own motion: every level in every arithmetic against the best truth there
//! is, what it costs, and which to take.

mod choose;
mod cortex;
mod force;
mod level;
mod poses;
mod response;

pub use choose::{Choice, Goal, Target};
pub use cortex::Cost;
pub use force::{Arithmetic, Errors};
pub use level::FidelityLevel;
pub use response::MotionErrors;

use crate::effect_significance::{self, EffectSignificance};
use crate::error::{Result, TradeError, with_causes};
use crate::plant::Plant;
use crate::scene::{Method, Model, Scene};
use force::{ARITHMETICS, Truth, forces};
use response::METHODS;
use serde::Serialize;

/// Result of a comparison of models.
#[derive(Debug, Clone, Serialize)]
pub struct Trade {
    /// The scene's name.
    pub scene: String,
    /// Where the motion is from: `recording` or `simulation`.
    pub motion: &'static str,
    /// Poses of each bearing at which forces are compared.
    pub poses: usize,
    /// The reference of all candidates.
    pub truth: String,
    /// The largest load of a bearing over the motion, N: what errors of force are relative to.
    pub largest_load: f64,
    /// Forces.
    pub candidates: Vec<Candidate>,
    /// Motions.
    pub responses: Vec<Response>,
    /// Models that do not apply to the scene, with the reason.
    pub impossible: Vec<Impossible>,
    /// Which effects the scene needs.
    #[serde(rename = "needs")]
    pub significance: Vec<EffectSignificance>,
    /// The recommended candidate, where a goal was given.
    pub choice: Option<Choice>,
}

/// One level in one arithmetic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Candidate {
    /// The level with its options.
    pub model: String,
    /// In which numbers.
    pub arithmetic: Arithmetic,
    /// Against the truth.
    pub error: Errors,
    /// Part of it that the level has in exact arithmetic too.
    pub modelling: Errors,
    /// Against the same level in exact arithmetic.
    pub rounding: Errors,
    /// One force of every bearing on this machine, ns.
    pub desktop_ns: f64,
    /// The same on a Cortex-M4F; none where that was never counted.
    pub cortex: Option<Cost>,
    /// Nothing is both cheaper on this machine and truer.
    pub front_desktop: bool,
    /// Nothing is both cheaper on the target and truer.
    pub front_cortex: bool,
}

/// One computed motion.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Response {
    /// The level.
    pub model: String,
    /// Precision of the forces; the rotor is computed in `f64`.
    pub precision: &'static str,
    /// Integrator, as a scene names it.
    pub method: &'static str,
    /// s
    pub step: f64,
    /// The integrator and step that a scene takes by itself.
    pub usual: bool,
    /// Against the truth.
    pub error: MotionErrors,
    /// How much faster than the machine turns.
    pub times_real_time: f64,
    /// Steps that overflowed.
    pub held: u64,
    /// Nothing is both faster and truer.
    pub front: bool,
}

/// A level that the scene does not allow.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Impossible {
    /// The level.
    pub model: String,
    /// In the words of whoever refused it.
    pub why: String,
}

/// A level that the scene allows.
struct Allowed {
    level: FidelityLevel,
    scene: Scene,
    plant: Plant,
}

/// Callback of the progress: steps done, steps in all.
pub type Progress<'a> = &'a dyn Fn(usize, usize);

/// Runs everything that the scene allows; without `motions` the forces only.
///
/// # Errors
/// A scene without a rotor, or in which nothing is possible.
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
    let truth_plant = Plant::try_new(&truth_scene)?;
    let poses = match &scene.recording {
        Some(recording) => poses::measured(scene, &truth_plant, recording)?,
        None => poses::computed(&truth_scene, &truth_plant)?,
    };
    let right = forces(&truth_scene, &truth_plant, ARITHMETICS[0])?;
    let truth = Truth::new(&truth_scene, right.as_ref(), &poses);
    if truth.largest() <= 0.0 {
        return Err(TradeError::NoLoad { file: scene.path.clone() }.into());
    }
    let work = allowed.len() * if motions { 1 + METHODS.len() * STEPS.len() } else { 1 };
    let mut candidates = Vec::new();
    for (i, one) in allowed.iter().enumerate() {
        if one.level.model() != Model::Dynamic {
            candidates.extend(candidates_of(one, &truth, &poses)?);
        }
        progress(i + 1, work);
    }
    choose::mark(&mut candidates);
    let responses = if motions { responses(&allowed, (&truth_scene, &truth_plant), work, progress)? } else { vec![] };
    let choice = goal.map(|goal| choose::choose(goal, &candidates)).transpose()?;
    Ok(Trade {
        scene: scene.name.clone(),
        motion: if scene.recording.is_some() { "recording" } else { "simulation" },
        poses: poses.first().map_or(0, Vec::len),
        truth: truth_level.name,
        largest_load: truth.largest(),
        candidates,
        responses,
        impossible,
        significance: effect_significance::of_scene(scene)?,
        choice,
    })
}

/// The scene's text with the level of that name in it.
///
/// # Errors
/// No such level.
pub fn written(scene: &Scene, text: &str, level: &str) -> Result<String, TradeError> {
    let levels = FidelityLevel::all(scene);
    let unknown = || TradeError::UnknownLevel { found: level.to_owned() };
    levels.iter().find(|r| r.name == level).ok_or_else(unknown)?.written(text, scene)
}

fn allowed(scene: &Scene, text: &str) -> Result<(Vec<Allowed>, Vec<Impossible>)> {
    if scene.rotor.is_none() && scene.system.is_none() {
        return Err(TradeError::NoRotor { file: scene.path.clone() }.into());
    }
    let (mut allowed, mut impossible) = (Vec::new(), Vec::new());
    for level in FidelityLevel::all(scene) {
        let tried = level.scene(text, &scene.path, scene).and_then(|scene| Ok((Plant::try_new(&scene)?, scene)));
        match tried {
            Ok((plant, scene)) => allowed.push(Allowed { level, scene, plant }),
            Err(error) => impossible.push(Impossible { model: level.name, why: with_causes(&error) }),
        }
    }
    Ok((allowed, impossible))
}

/// The last level with forces of its own.
fn dearest(allowed: &[Allowed]) -> Option<&Allowed> {
    allowed.iter().rev().find(|one| one.level.model() != Model::Dynamic)
}

fn candidates_of(one: &Allowed, truth: &Truth, poses: &poses::Poses) -> Result<Vec<Candidate>> {
    let exact = forces(&one.scene, &one.plant, ARITHMETICS[0])?;
    let modelling = truth.errors(exact.as_ref(), poses);
    let candidate = |arithmetic: Arithmetic| {
        let forces = forces(&one.scene, &one.plant, arithmetic)?;
        let cost = |of| cortex::force(of, arithmetic.precision, arithmetic.math);
        let cortex = one.scene.bearings.iter().map(cost).reduce(|a, b| Some(a?.plus(b?))).flatten();
        Ok(Candidate {
            model: one.level.name.clone(),
            arithmetic,
            error: truth.errors(forces.as_ref(), poses),
            modelling,
            rounding: truth.rounding(forces.as_ref(), exact.as_ref(), poses),
            desktop_ns: forces.time(poses),
            cortex,
            front_desktop: false,
            front_cortex: false,
        })
    };
    ARITHMETICS.into_iter().map(candidate).collect()
}

/// Steps that are tried, over the one that a scene takes by itself.
const STEPS: [f64; 3] = [0.5, 1.0, 2.0];

fn responses(
    allowed: &[Allowed],
    solved: (&Scene, &Plant),
    work: usize,
    progress: Progress<'_>,
) -> Result<Vec<Response>> {
    // Balls with a mass of their own know more of a motion than balls in equilibrium.
    let dynamic = allowed.iter().find(|one| one.level.model() == Model::Dynamic);
    let (moving, plant) = dynamic.map_or(solved, |one| (&one.scene, &one.plant));
    let truth_plant = plant.with_step(Method::RungeKutta, 0.25);
    let span = poses::span(moving, &truth_plant);
    let truth = response::run(moving, &truth_plant, span)?;
    let mut all = Vec::new();
    for (i, one) in allowed.iter().enumerate() {
        for (j, (name, method)) in METHODS.into_iter().enumerate() {
            for (k, part) in STEPS.into_iter().enumerate() {
                progress(allowed.len() + (i * METHODS.len() + j) * STEPS.len() + k + 1, work);
                // From the last sample every number of steps comes to the same.
                if one.level.has_own_steps() {
                    continue;
                }
                let plant = one.plant.with_step(method, part);
                let usual = part == 1.0 && method == Method::RungeKutta;
                all.push(response_of(one, &plant, (name, "f64", usual), span, &truth)?);
                if usual && one.level.model() != Model::Dynamic {
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
    span: crate::motion::Span,
    truth: &response::Motion,
) -> Result<Response> {
    let found = response::run(&one.scene, plant, span)?;
    Ok(Response {
        model: one.level.name.clone(),
        precision,
        method,
        step: 1.0 / span.rate / f64::from(plant.substeps(1.0 / span.rate)?),
        usual,
        error: found.errors(truth),
        times_real_time: 1.0 / found.seconds_per_second,
        held: found.held,
        front: false,
    })
}
