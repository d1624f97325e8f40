//! Fidelity levels of a scene's bearings with their options, each as an edit of the scene's text.
//!
//! A candidate is the scene as a user would have written it, read and checked like any other: what the reader or the
//! kernel rejects does not apply to the scene; the error states the reason.

use ballrace_models::{LevelOptions, bearing_model};
use ballrace_plant::error::{Result, TradeError};
use ballrace_scene::read::read_str;
use ballrace_scene::{Bearing, Linear, Model, ModelInput, Scene};
use std::path::Path;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Value, value};

/// One level with its options.
#[derive(Debug, Clone, PartialEq)]
pub struct FidelityLevel {
    model: Model,
    options: LevelOptions,
}

/// Keys of a bearing that only models with balls in equilibrium accept.
const OF_BALLS: [&str; 5] = ["effects", "race_control", "friction_sharing", "lubricant", "table"];
/// Keys of a bearing that only the lumped model takes and that its geometry can replace.
const OF_LUMPED: [&str; 4] = ["stiffness", "exponent", "radial_play", "axial"];
/// Effects in the order in which they can be omitted.
const NESTED: [&str; 3] = ["centrifugal", "gyroscopic", "film"];
/// Newton steps of a cold solution of the reference.
const CONVERGED: u8 = 20;

impl FidelityLevel {
    /// Returns the name of the level.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.options.name
    }

    /// Returns true for a model whose elements are coordinates of the system, and which has no forces of its own.
    #[must_use]
    pub(crate) fn has_moving_elements(&self) -> bool {
        self.model.properties().moving_elements
    }

    /// Returns true for a model whose integrator chooses its own steps.
    #[must_use]
    pub(crate) fn has_bodies(&self) -> bool {
        self.model.properties().bodies
    }

    /// Returns every level for a scene, in the order of cost.
    #[must_use]
    pub fn all(scene: &Scene) -> Vec<Self> {
        let effects = named(scene);
        let springs_alone = scene.bearings.iter().all(given_as_springs);
        let has = |model: Model| scene.bearings.iter().any(|of| level_of(model, of) == Some(model));
        let fits = |model: &Model| match model {
            Model::QuasiStaticRoller => has(*model) && !has(Model::QuasiStatic),
            model => has(*model),
        };
        let is_own = |model: Model| scene.bearings.iter().any(|of| of.model == model);
        let mut models: Vec<Model> =
            Model::with_forces().filter(|model| fits(model) && (!springs_alone || is_own(*model))).collect();
        models.sort_unstable_by_key(|model| model.properties().cost);
        let levels = models.into_iter().map(|model| (model, bearing_model(model).levels(scene, &effects)));
        levels.flat_map(|(model, all)| all.into_iter().map(move |options| Self { model, options })).collect()
    }

    /// Returns this level with the number of solver steps of a converged solution (quasi-static model) or with the kernel's
    /// default (other models).
    #[must_use]
    pub fn converged(&self) -> Self {
        let steps = self.model.properties().solver_steps.then_some(CONVERGED);
        Self { options: LevelOptions { steps, ..self.options.clone() }, ..*self }
    }

    /// Returns true where the level has another number of steps than the kernel's default.
    #[must_use]
    pub(crate) fn has_own_steps(&self) -> bool {
        self.options.steps.is_some()
    }

    /// Returns the name of the level without a number of steps of its own.
    #[must_use]
    pub(crate) fn name_without_steps(&self) -> &str {
        let LevelOptions { name, steps, .. } = &self.options;
        steps.and_then(|steps| name.strip_suffix(&format!(", {steps} steps"))).unwrap_or(name)
    }

    /// Returns the scene's text with this level as the model of its bearings. Bearings given by a stiffness matrix keep it.
    ///
    /// # Errors
    /// A text that is no TOML, or that has no `[[bearing]]`.
    pub fn written(&self, text: &str, scene: &Scene) -> Result<String, TradeError> {
        self.written_for(text, scene, |_| true)
    }

    /// Returns the text as [`written`](Self::written), with this level for the bearings whose number passes `chosen`.
    fn written_for(&self, text: &str, scene: &Scene, chosen: impl Fn(usize) -> bool) -> Result<String, TradeError> {
        let file = || scene.path.clone();
        let syntax = |source| TradeError::Syntax { file: file(), source };
        let mut document: DocumentMut = text.parse().map_err(syntax)?;
        let tables = document.get_mut("bearing").and_then(Item::as_array_of_tables_mut);
        self.put(tables.ok_or_else(|| TradeError::NoBearing { file: file() })?, scene, chosen);
        Ok(document.to_string())
    }

    fn put(&self, tables: &mut ArrayOfTables, scene: &Scene, chosen: impl Fn(usize) -> bool) {
        for (i, (table, of)) in tables.iter_mut().zip(&scene.bearings).enumerate() {
            if given_as_springs(of) || !chosen(i) {
                continue;
            }
            let Some(level) = level_of(self.model, of) else { continue };
            let (geometry, film) = (of.geometry.is_some(), table.contains_key("lubricant"));
            let rollers = of.rollers.is_some();
            let model = level.properties();
            let others = Model::ALL.into_iter().filter(|other| *other != level);
            let mut gone = vec!["solver_steps", "linearise"];
            gone.extend(others.flat_map(Model::own_keys));
            if !model.effects {
                gone.extend(OF_BALLS);
            }
            if geometry && model.input != ModelInput::Law {
                gone.extend(OF_LUMPED);
            }
            for key in gone {
                table.remove(key);
            }
            table.insert("model", value(model.name));
            if model.effects {
                let kept = self.options.effects.iter().filter(|e| **e != "film" || film);
                table.insert("effects", value(kept.copied().collect::<Array>()));
            }
            if model.input == ModelInput::Stiffness {
                table.insert(
                    "linearise",
                    value(if geometry {
                        "angular"
                    } else if rollers {
                        "roller"
                    } else {
                        "lumped"
                    }),
                );
            }
            if let Some(steps) = self.options.steps.filter(|_| model.solver_steps) {
                table.insert("solver_steps", value(i64::from(steps)));
            }
            if let Some(laminae) = self.options.laminae.filter(|_| rollers) {
                table.insert("laminae", value(laminae));
            }
            if let Some(intervals) = self.options.intervals {
                let list: Value = intervals.into_iter().collect::<Array>().into();
                match table.get_mut("table").and_then(Item::as_table_like_mut) {
                    Some(given) => {
                        given.insert("intervals", value(list));
                    }
                    None => {
                        let inline: InlineTable = [("intervals", list)].into_iter().collect();
                        table.insert("table", value(inline));
                    }
                }
            }
        }
    }

    /// Returns the scene with this level.
    ///
    /// # Errors
    /// Returns an error if the edited scene is invalid.
    pub fn scene(&self, text: &str, path: &Path, scene: &Scene) -> Result<Scene> {
        Ok(read_str(&self.written(text, scene)?, path)?)
    }

    /// Returns the scene with this level for bearing `i` alone.
    ///
    /// # Errors
    /// Returns an error if the edited scene is invalid.
    pub(crate) fn scene_with_one(&self, text: &str, scene: &Scene, i: usize) -> Result<Scene> {
        Ok(read_str(&self.written_for(text, scene, |bearing| bearing == i)?, &scene.path)?)
    }
}

/// Returns the model of a bearing at the level of `model`; `None` where it keeps its own. Balls and rollers have models of their own, and those with
/// elements in equilibrium are one level, of which inclined rollers have the model in series.
fn level_of(model: Model, of: &Bearing) -> Option<Model> {
    let kind = of.rollers.as_ref().map(|rollers| rollers.kind);
    match (model.properties().input, kind) {
        (ModelInput::ContactAngle, Some(kind)) => {
            let solved = if kind.is_radial() { Model::QuasiStaticRoller } else { Model::Roller };
            (model == Model::QuasiStatic).then_some(solved)
        }
        (ModelInput::Rollers, None) => None,
        _ => Some(model),
    }
}

/// Returns true for springs that are given directly, which have no other model.
fn given_as_springs(of: &Bearing) -> bool {
    matches!(of.linear, Some(Linear::Matrix(_) | Linear::TwoSpring { .. }))
}

/// Returns the effects that any bearing names, in the order in which they can be omitted.
fn named(scene: &Scene) -> Vec<&'static str> {
    let has = |name: &str| scene.bearings.iter().any(|of| of.effects.named().any(|on| on == name));
    NESTED.into_iter().filter(|name| has(name)).collect()
}
