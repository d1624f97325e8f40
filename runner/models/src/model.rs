//! Interface of the bearing models, and their constants for firmware in Rust and in C.

pub mod c;
pub mod rust;

use crate::construction::{BuildError, TableData};
use crate::handle::{AnyBearing, AnyForceModel};
use crate::solved::Solved;
use ballrace::Displacement;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::surface::Feature;
use ballrace_scene::{Bearing, Model, Scene};
use c::CStruct;
use serde::Serialize;
use std::sync::Arc;

/// All that depends on a bearing model beyond the keys of a scene, whose properties are [`Model::properties`], and its construction.
pub trait BearingModel: Sync {
    /// Returns the model.
    fn model(&self) -> Model;

    /// Returns the levels of fidelity of this model for a scene, in the order of cost; `effects` are those of the scene.
    fn levels(&self, _scene: &Scene, _effects: &[&'static str]) -> Vec<LevelOptions> {
        vec![LevelOptions::plain(self.model())]
    }

    /// Returns the model with its balls in equilibrium in `steps` Newton steps, else in those of the scene; `None` for a model that is
    /// evaluated without iteration.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value of this model or the kernel rejects one.
    fn solved(&self, _of: &Bearing, _steps: Option<u8>) -> Result<Option<Arc<dyn Solved<f64>>>, BuildError> {
        Ok(None)
    }

    /// Returns true where a bearing with one of its elements alone is cheap to build.
    fn has_cheap_elements(&self) -> bool {
        true
    }

    /// Returns the model by which the displacement of a preload is computed.
    fn preload_model(&self) -> Model {
        self.model()
    }

    /// Returns the constants of a bearing in firmware; `None` where it has none.
    fn firmware(&self, of: &Bearing) -> Option<&'static dyn FirmwareModel>;

    /// Returns the name of a smooth bearing in the tables of costs on the cores of microcontrollers.
    ///
    /// # Errors
    /// Returns the reason where the table has no similar bearing.
    fn counted_row(&self, of: &Bearing) -> Result<&'static str, NotCounted>;
}

/// Options of a level of fidelity.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LevelOptions {
    /// Name of the level.
    pub name: String,
    /// Effects of the scene that are kept.
    pub effects: Vec<&'static str>,
    /// Newton steps of a cold start, where not the kernel's own number.
    pub steps: Option<u8>,
    /// Intervals of the table.
    pub intervals: Option<[i64; 3]>,
    /// Laminae of each roller.
    pub laminae: Option<i64>,
}

impl LevelOptions {
    /// Returns the level of a model without options.
    pub(crate) fn plain(model: Model) -> Self {
        Self { name: model.name().to_owned(), ..Self::default() }
    }
}

/// Values from which the constants of a bearing are written.
#[derive(Clone, Copy)]
pub struct Constants<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The bearing.
    pub of: &'a Bearing,
    /// [`FirmwareModel::table`] of the bearing.
    pub table: Option<&'a TableData>,
    /// Displacement by preload, which is added to every displacement.
    pub offset: Displacement<f64>,
    /// Springs of a linearised bearing, at the equilibrium of its rotor.
    pub springs: Option<&'a AnyBearing<f64>>,
}

/// A model that firmware evaluates, with its constants.
pub trait FirmwareModel: BearingModel {
    /// Returns the table of a bearing, for a model that has one.
    ///
    /// # Errors
    /// Returns an error if the table has states without equilibrium.
    fn table(&self, _scene: &Scene, _of: &Bearing) -> Result<Option<TableData>, BuildError> {
        Ok(None)
    }

    /// Returns the size of a bearing's constants without its table, bytes.
    fn constant_bytes(&self, of: &Bearing) -> usize;

    /// Writes imports, constants, type `Baked` and function `bearing` of a bearing in Rust. `Displacement` is one of the imports: the checksum
    /// that follows uses it.
    ///
    /// # Errors
    /// Returns an error if a constant cannot be computed.
    fn write_rust(&self, out: &mut String, constants: &Constants<'_>) -> Result<(), BuildError>;

    /// Returns the bearing as C evaluates it.
    fn in_c(&self, of: &Bearing) -> Bearing {
        of.clone()
    }

    /// Returns the force as C computes it; `None` where it is that of Rust.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value.
    fn force_in_c(&self, _of: &Bearing) -> Result<Option<AnyForceModel<f32>>, BuildError> {
        Ok(None)
    }

    /// Returns the struct of a bearing in C, whose members a blob has too.
    ///
    /// # Errors
    /// Returns an error if a constant cannot be computed.
    fn c_struct(&self, constants: &Constants<'_>) -> Result<CStruct, BuildError>;
}

/// Reason why a force was not counted on the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NotCounted {
    /// The model is not counted in this precision with these math functions.
    Arithmetic,
    /// The surfaces of the bearing deviate: waviness, a defect, a displaced housing, a bending outer ring.
    Surface,
    /// The load law along the axis is not counted with that of the radius.
    Law,
    /// The effects are not counted together.
    Effects,
    /// The bearing has rollers by laminae.
    Rollers,
}

impl NotCounted {
    /// Returns the reason as a sentence.
    #[must_use]
    pub const fn reason(self) -> &'static str {
        match self {
            Self::Arithmetic => "the model is not counted in this arithmetic",
            Self::Surface => {
                "bearings with waviness, defects, a displaced housing or a bending outer ring are not counted"
            }
            Self::Law => "the axial load law is counted together with a radial one of power 3/2 alone",
            Self::Effects => "these effects are not counted together",
            Self::Rollers => "rollers by laminae are not counted",
        }
    }
}

/// Size of an element on a core of 32 bits, bytes.
pub(crate) const ELEMENT_BYTES: usize = size_of::<ElementPosition<f32>>();

/// Returns the size of elements, surface deviations and displacement by preload, bytes.
pub(crate) fn element_bytes(of: &Bearing) -> usize {
    let features = of.waviness.len() + of.defect.len();
    of.elements * ELEMENT_BYTES + features * size_of::<Feature<f32>>() + size_of::<Displacement<f32>>()
}
