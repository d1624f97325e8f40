//! Fidelity levels of a scene's bearings with their options, each as an edit of the scene's text.
//!
//! A candidate is the scene as a user would have written it, read and checked like any other: what the reader or the
//! kernel rejects does not apply to the scene; the error states the reason.

use ballrace_plant::error::{Result, TradeError};
use ballrace_scene::read::read_str;
use ballrace_scene::{Bearing, Effects, Linear, Model, Scene};
use std::path::Path;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Value, value};

/// One level with its options.
#[derive(Debug, Clone, PartialEq)]
pub struct FidelityLevel {
    /// Name of the level.
    pub name: String,
    model: Model,
    /// Effects of the scene that are kept.
    effects: Vec<&'static str>,
    /// Newton steps of a cold start, where not the kernel's own number.
    steps: Option<u8>,
    /// Intervals of the table.
    intervals: Option<[i64; 3]>,
}

/// Keys of a bearing that only models with balls in equilibrium accept.
const OF_BALLS: [&str; 6] = ["effects", "race_control", "friction_sharing", "lubricant", "table", "solver_steps"];
/// Keys of a bearing that only the lumped model takes and that its geometry can replace.
const OF_LUMPED: [&str; 4] = ["stiffness", "exponent", "radial_play", "axial"];
/// Effects in the order in which they can be omitted.
const NESTED: [&str; 3] = ["centrifugal", "gyroscopic", "film"];
/// Newton steps of a cold solution that are compared, and those of the reference.
const STEPS: [u8; 4] = [3, 4, 5, 6];
const CONVERGED: u8 = 20;
/// Intervals of a table along approach and angle that are compared.
const TABLES: [i64; 4] = [8, 16, 24, 32];
/// Intervals along a speed that hardly changes.
const ABOUT_ONE_SPEED: i64 = 2;
/// Intervals along a speed that changes.
const OVER_SPEEDS: i64 = 8;

impl FidelityLevel {
    fn new(name: &str, model: Model) -> Self {
        Self { name: name.to_owned(), model, effects: vec![], steps: None, intervals: None }
    }

    /// Returns the kernel's model.
    #[must_use]
    pub fn model(&self) -> Model {
        self.model
    }

    /// Returns every level for a scene, in the order of cost.
    #[must_use]
    pub fn all(scene: &Scene) -> Vec<Self> {
        let named = named(scene);
        let mut levels = vec![Self::new("linear", Model::Linear)];
        if scene.bearings.iter().all(given_as_springs) {
            return levels;
        }
        levels.push(Self::new("lumped", Model::Lumped));
        levels.push(Self::new("angular", Model::Angular));
        let span = match scene.shaft.speed {
            ballrace_scene::Speed::Constant(_) => ABOUT_ONE_SPEED,
            _ => OVER_SPEEDS,
        };
        for intervals in TABLES {
            let mut level = Self::new(&format!("tabulated {intervals} x {intervals}"), Model::Tabulated);
            level.effects.clone_from(&named);
            level.intervals = Some([intervals, intervals, span]);
            levels.push(level);
        }
        for kept in 0..=named.len() {
            let effects = named.get(..kept).unwrap_or_default().to_vec();
            let name = if effects.is_empty() { "no effects".to_owned() } else { effects.join(", ") };
            let base = Self { effects, ..Self::new(&format!("quasi-static, {name}"), Model::QuasiStatic) };
            if kept == named.len() {
                levels.extend(STEPS.map(|steps| Self {
                    name: format!("{}, {steps} steps", base.name),
                    steps: Some(steps),
                    ..base.clone()
                }));
            }
            levels.push(base);
        }
        if scene.bearings.iter().any(|b| b.model == Model::Dynamic) {
            levels.push(Self::new("dynamic", Model::Dynamic));
        }
        levels
    }

    /// Returns this level with the number of solver steps of a converged solution (quasi-static model) or with the kernel's
    /// default (other models).
    #[must_use]
    pub fn converged(&self) -> Self {
        let steps = (self.model == Model::QuasiStatic).then_some(CONVERGED);
        Self { steps, ..self.clone() }
    }

    /// Returns true where the level has another number of steps than the kernel's default.
    #[must_use]
    pub fn has_own_steps(&self) -> bool {
        self.steps.is_some()
    }

    /// Returns the name of the level without a number of steps of its own.
    #[must_use]
    pub fn name_without_steps(&self) -> &str {
        let name = self.steps.and_then(|steps| self.name.strip_suffix(&format!(", {steps} steps")));
        name.unwrap_or(&self.name)
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
            let has = |key: &str| table.contains_key(key);
            let (geometry, film) = (has("ball_diameter"), has("lubricant"));
            let mut gone: Vec<&str> = Vec::new();
            if !matches!(self.model, Model::QuasiStatic | Model::Tabulated) {
                gone.extend(OF_BALLS);
            }
            if geometry && !matches!(self.model, Model::Lumped | Model::Dynamic) {
                gone.extend(OF_LUMPED);
            }
            gone.extend(["solver_steps", "linearise", "element_damping"]);
            for key in gone.iter().filter(|key| self.model != Model::Dynamic || **key != "element_damping") {
                table.remove(key);
            }
            table.insert("model", value(self.model.name()));
            match self.model {
                Model::QuasiStatic | Model::Tabulated => {
                    let kept = self.effects.iter().filter(|e| **e != "film" || film);
                    table.insert("effects", value(kept.copied().collect::<Array>()));
                }
                Model::Linear => {
                    table.insert("linearise", value(if geometry { "angular" } else { "lumped" }));
                }
                _ => {}
            }
            if let Some(steps) = self.steps {
                table.insert("solver_steps", value(i64::from(steps)));
            }
            if let Some(intervals) = self.intervals {
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
    pub fn scene_with_one(&self, text: &str, scene: &Scene, i: usize) -> Result<Scene> {
        Ok(read_str(&self.written_for(text, scene, |bearing| bearing == i)?, &scene.path)?)
    }
}

/// Returns true for springs that are given directly, which have no other model.
fn given_as_springs(of: &Bearing) -> bool {
    matches!(of.linear, Some(Linear::Matrix(_) | Linear::TwoSpring { .. }))
}

/// Returns the effects that any bearing names, in the order in which they can be omitted.
fn named(scene: &Scene) -> Vec<&'static str> {
    let has = |name: &str| {
        scene.bearings.iter().any(|b| {
            let Effects { centrifugal, gyroscopic, film, .. } = b.effects;
            match name {
                "centrifugal" => centrifugal,
                "gyroscopic" => gyroscopic,
                _ => film.is_some(),
            }
        })
    };
    NESTED.into_iter().filter(|name| has(name)).collect()
}
