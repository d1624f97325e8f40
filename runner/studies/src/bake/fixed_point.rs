//! The path with a constant number of instructions on a core without a floating-point unit.

use crate::trade::Core;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::checksum::ChecksumRange;
use ballrace::bearing::fixed_point::{TabulatedElements, TabulatedParams, direction};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::tabulated::{Table, Tabulated};
use ballrace::{Exact, Phase};
use ballrace_models::build::{self, TableData};
use ballrace_scene::{Bearing, Model};

/// Parameters of `bearing::fixed_point`, where the arithmetic of the bearing itself takes a number of instructions that depends on the input.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum FixedPointPath {
    /// Elements of the lumped model.
    Lumped {
        /// Stiffness of a radial element, N/m^n.
        stiffness: f64,
        /// Exponent `n`.
        exponent: f64,
        /// Radial play, m.
        radial_play: f64,
        /// The bearing has axial elements too.
        has_axial: bool,
    },
    /// Balls in the table of the constants.
    Tabulated {
        /// Least range of the counts, m: twice the distance of the groove centres.
        least_range: f64,
        /// Memory of the nodes at one speed, bytes.
        node_bytes: usize,
    },
}

impl FixedPointPath {
    /// Returns the path; `None` for a core with a floating-point unit, and for a bearing that has no such path.
    pub(super) fn of(bearing: &Bearing, core: Core, table: Option<&TableData>, range: &ChecksumRange) -> Option<Self> {
        let is_plain = bearing.waviness.is_empty() && bearing.defect.is_empty() && bearing.has_rigid_outer_ring();
        if core.has_fpu() || !is_plain {
            return None;
        }
        if let Some(table) = table {
            return Self::of_table(bearing, table, range);
        }
        if bearing.model != Model::Lumped {
            return None;
        }
        let (stiffness, exponent, radial_play) = build::law(bearing).ok()?;
        Some(Self::Lumped { stiffness, exponent, radial_play, has_axial: bearing.axial.is_some() })
    }

    fn of_table(bearing: &Bearing, table: &TableData, range: &ChecksumRange) -> Option<Self> {
        let [speed, _] = if table.by_outer { range.outer_speed } else { range.inner_speed };
        let least_range = 2.0 * table.constants.distance;
        let params = TabulatedParams { speed: f64::from(speed), range: least_range, mirrored: false };
        let set_up = if table.friction { set_up::<3> } else { set_up::<2> };
        let nodes = set_up(table, &params, bearing.elements).ok()?;
        Some(Self::Tabulated { least_range, node_bytes: nodes * table.fields() * size_of::<i32>() })
    }
}

/// Sets a bearing up as firmware does; returns the number of its nodes.
fn set_up<const F: usize>(
    table: &TableData,
    params: &TabulatedParams,
    elements: usize,
) -> Result<usize, InvalidParameter> {
    let numbers = |node: &[f64; 3]| core::array::from_fn(|k| node.get(k).copied().unwrap_or_default());
    let nodes: Vec<[f64; F]> = table.nodes.iter().map(numbers).collect();
    let positions: Vec<ElementPosition<f64>> = Vec::new();
    let (grid, constants) = (Table::new(table.grid, nodes), table.constants);
    let of = Tabulated::<f64, Exact, _, _, F>::new(positions, constants, grid, table.by_outer);
    let directions: Vec<_> = (0..elements).map(|j| direction(Phase::ZERO, j, elements)).collect();
    let count = table.grid.approach.count * table.grid.angle.count;
    TabulatedElements::with_directions(directions, &of, params, vec![[0; F]; count])?;
    Ok(count)
}
