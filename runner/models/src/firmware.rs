//! Constants of a bearing for firmware, in Rust and in C.

pub mod c;
pub mod rust;

use crate::construction::{BuildError, TableData};
use crate::handle::{AnyBearing, AnyForceModel};
use crate::registry::BearingModel;
use ballrace::Displacement;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::surface::Feature;
use ballrace_scene::{Bearing, Scene};
use serde::Serialize;

/// Values from which the constants of a bearing are written.
#[derive(Clone, Copy)]
pub struct Constants<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The bearing.
    pub of: &'a Bearing,
    /// [`FirmwareModel::table`] of the bearing.
    pub table: Option<&'a TableData>,
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

    /// Writes imports, constants, type and function of a bearing in Rust.
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

    /// Writes the struct `name` of a bearing in C, and returns its type.
    ///
    /// # Errors
    /// Returns an error if a constant cannot be computed.
    fn write_c(&self, out: &mut String, name: &str, constants: &Constants<'_>) -> Result<&'static str, BuildError>;
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
