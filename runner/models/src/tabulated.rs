//! Tabulated model: the quasi-static model of one ball, interpolated in a table.

use crate::construction::service_load::approach_in_service;
use crate::construction::{
    BuildError, PRESSURE_LIMIT, TableData, blocked_places, contact_geometry, facing, inertia_params, lubricant, named,
    numbers, outer_ratio, point_contact_approach, uneven,
};
use crate::handle::BearingHandle;
use crate::model::c::{Array, CStruct, Member};
use crate::model::{self as firmware, Constants, FirmwareModel, NotCounted, rust};
use crate::model::{BearingModel, LevelOptions};
use crate::simd::OnWideRegisters;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::{QuasiStatic, TableConstants};
use ballrace::bearing::tabulated::{Axis, Table, TableDomain, Tabulated, fill_table};
use ballrace::contact::hertz::Race;
use ballrace::{Exact, Math, Phase, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, FrictionSharing, Model, Scene, Speed};
use std::borrow::Cow;
use std::fmt::Write;

/// Intervals of a table along approach and angle that are compared.
const COMPARED_INTERVALS: [i64; 4] = [8, 16, 24, 32];
/// Intervals along a speed that hardly changes.
const ABOUT_ONE_SPEED: i64 = 2;
/// Intervals along a speed that changes.
const OVER_SPEEDS: i64 = 8;

/// [`Model::Tabulated`]
pub(crate) struct TabulatedModel;

impl BearingModel for TabulatedModel {
    fn model(&self) -> Model {
        Model::Tabulated
    }
    fn levels(&self, scene: &Scene, effects: &[&'static str]) -> Vec<LevelOptions> {
        let span = match scene.shaft.speed {
            Speed::Constant(_) => ABOUT_ONE_SPEED,
            Speed::Ramp { .. } | Speed::Fluctuating { .. } => OVER_SPEEDS,
        };
        let level = |intervals| LevelOptions {
            name: format!("{} {intervals} x {intervals}", Model::Tabulated.name()),
            effects: effects.to_vec(),
            steps: None,
            intervals: Some([intervals, intervals, span]),
            laminae: None,
        };
        COMPARED_INTERVALS.map(level).into()
    }
    /// Each element alone would have a table of its own.
    fn has_cheap_elements(&self) -> bool {
        false
    }
    /// A table of the state without load would be used only there.
    fn preload_model(&self) -> Model {
        Model::QuasiStatic
    }
    fn firmware(&self, _of: &BearingScene) -> Option<&'static dyn FirmwareModel> {
        Some(&Self)
    }
    fn counted_row(&self, of: &BearingScene) -> Result<&'static str, NotCounted> {
        // A table with friction at the inner contact has a third number in each node.
        if of.effects.gyroscopic && of.effects.sharing != FrictionSharing::Outer {
            return Err(NotCounted::Effects);
        }
        Ok("tabulated")
    }
}

/// Size of a table's grid with its flag, bytes.
const GRID_BYTES: usize = 2 * 4 + 3 * (4 + 4 * 4) + 4;

impl FirmwareModel for TabulatedModel {
    fn table(&self, scene: &Scene, of: &BearingScene) -> Result<Option<TableData>, BuildError> {
        table(scene, of, FIRMWARE_TABLE).map(Some)
    }

    fn constant_bytes(&self, of: &BearingScene) -> usize {
        firmware::element_bytes(of) + size_of::<TableConstants<f32>>() + GRID_BYTES
    }

    fn write_rust(&self, out: &mut String, constants: &Constants<'_>) -> Result<(), BuildError> {
        let of = constants.of;
        let made = firmware_table(constants)?;
        let fields = made.fields();
        let TableConstants { couple, distance, axis, offset, arm } = made.constants.rounded::<f32>();
        let grid = made.grid.rounded::<f32>();
        writeln!(out, "    use ballrace::bearing::ElementPosition;")?;
        writeln!(out, "    use ballrace::bearing::quasi_static::TableConstants;")?;
        rust::surface_imports(out, of)?;
        writeln!(out, "    use ballrace::bearing::tabulated::{{Axis, Grid, Node, Table, Tabulated}};")?;
        writeln!(out, "    use ballrace::{{Displacement, Exact, Phase}};\n")?;
        rust::position_constants(out, constants)?;
        writeln!(
            out,
            "    const CONSTANTS: TableConstants<f32> = TableConstants {{ couple: {couple:?}, distance: {distance:?}, axis: {axis:?}, offset: {offset:?}, arm: {arm:?} }};"
        )?;
        writeln!(out, "    const GRID: Grid<f32> = Grid {{")?;
        writeln!(out, "        scale: {:?},\n        speed_scale: {:?},", grid.scale, grid.speed_scale)?;
        for (name, axis) in [("approach", &grid.approach), ("angle", &grid.angle), ("speed", &grid.speed)] {
            writeln!(out, "        {name}: {},", axis_text(axis))?;
        }
        writeln!(out, "    }};\n    const BY_OUTER: bool = {};", made.by_outer)?;
        rust::feature_constants(out, of)?;
        writeln!(out, "    /// The table: {} bytes of flash.", made.bytes())?;
        writeln!(out, "    #[rustfmt::skip]\n    pub static NODES: [Node<f32, {fields}>; {}] = [", made.nodes.len())?;
        for row in made.nodes.chunks(6) {
            let text: Vec<String> = row.iter().map(|node| node_text(node, fields)).collect();
            writeln!(out, "        {},", text.join(", "))?;
        }
        writeln!(out, "    ];\n")?;
        let (surface, with) = rust::surface(of);
        let n = of.elements;
        let kind = format!(
            "Tabulated<f32, Exact, [ElementPosition<f32>; {n}], &'static [Node<f32, {fields}>], {fields}{surface}>"
        );
        let value = format!("Tabulated::new(POSITIONS, CONSTANTS, Table::new(GRID, NODES.as_slice()), BY_OUTER){with}");
        rust::function(out, of, &kind, &value)
    }

    fn c_struct(&self, constants: &Constants<'_>) -> Result<CStruct, BuildError> {
        let made = firmware_table(constants)?;
        let fields = made.fields();
        let TableConstants { couple, distance, axis: [cos, sin], offset, arm } = made.constants.rounded::<f32>();
        let grid = made.grid.rounded::<f32>();
        let numbers = [
            ("couple", couple),
            ("distance", distance),
            ("axis_cos", cos),
            ("axis_sin", sin),
            ("offset", offset),
            ("arm", arm),
            ("scale", grid.scale),
            ("speed_scale", grid.speed_scale),
        ];
        let axes = [("approach", grid.approach), ("angle", grid.angle), ("speed", grid.speed)];
        let counts = [("by_outer_speed", u32::from(made.by_outer)), ("node_count", made.nodes.len() as u32)];
        let members = numbers
            .map(|(name, x)| (name, Member::Number(x)))
            .into_iter()
            .chain(axes.map(|(name, axis)| (name, Member::Axis(axis))))
            .chain(counts.map(|(name, count)| (name, Member::Integer(count))));
        let new = if made.friction { CStruct::new::<InFirmware<'_, 3>> } else { CStruct::new::<InFirmware<'_, 2>> };
        let model = if made.friction { "ballrace_tabulated_friction" } else { "ballrace_tabulated" };
        Ok(new(constants.of, "ballrace_tabulated", model, members.collect()).with_array(Array {
            member: "nodes",
            kind: "float",
            numbers_per_entry: 1,
            numbers_per_line: 6 * fields,
            numbers: made.nodes.iter().flat_map(|node| node.iter().take(fields)).map(|x| *x as f32).collect(),
            comment: Some(format!("The table: {} bytes of flash.", made.bytes())),
        }))
    }
}

/// The bearing as firmware has it.
type InFirmware<'a, const F: usize> = Tabulated<f32, Exact, &'a [ElementPosition<f32>], &'a [[f32; F]], F>;

/// Returns the table of the constants, which is computed where it is not given.
fn firmware_table<'a>(constants: &Constants<'a>) -> Result<Cow<'a, TableData>, BuildError> {
    match constants.table {
        Some(table) => Ok(Cow::Borrowed(table)),
        None => table(constants.scene, constants.of, FIRMWARE_TABLE).map(Cow::Owned),
    }
}

fn node_text(node: &[f64; 3], fields: usize) -> String {
    let numbers: Vec<String> = node.iter().take(fields).map(|x| format!("{:?}", *x as f32)).collect();
    format!("[{}]", numbers.join(", "))
}

fn axis_text(axis: &Axis<f32>) -> String {
    let [low, high] = axis.range;
    format!(
        "Axis {{ count: {}, origin: {:?}, density: {:?}, range: [{low:?}, {high:?}] }}",
        axis.count, axis.origin, axis.density
    )
}

/// Returns true where the inner contact has friction.
fn has_inner_friction(of: &BearingScene) -> bool {
    of.effects.gyroscopic && of.effects.sharing != FrictionSharing::Outer
}

/// Size of a table whose intervals the scene does not state.
#[derive(Debug, Clone, Copy)]
pub struct TableSize {
    /// Largest size in `f32`.
    pub bytes: usize,
    /// Intervals along a speed that changes.
    over_speeds: usize,
}

/// Size of a table on the desktop.
pub const DESKTOP_TABLE: TableSize = TableSize { bytes: 64 << 10, over_speeds: 12 };
/// Size of a table in firmware.
pub const FIRMWARE_TABLE: TableSize = TableSize { bytes: 32 << 10, over_speeds: 8 };

/// Samples the quasi-static model of one bearing.
///
/// # Errors
/// As [`crate::build::quasi_static`], and a table with states without equilibrium.
pub fn table(scene: &Scene, of: &BearingScene, size: TableSize) -> Result<TableData, BuildError> {
    let (geometry, zero) = contact_geometry(of, "tabulated")?;
    let (domain, by_outer) = domain(scene, of, &geometry, size)?;
    let one = [ElementPosition::from_azimuth(Phase::ZERO)];
    let plain =
        QuasiStatic::<f64, OnWideRegisters<Exact>, _>::try_new(geometry, one, zero).map_err(|e| named(of, e))?;
    let constants = plain.table_constants();
    let grid = domain.grid(constants.distance).map_err(|e| named(of, e))?;
    let mut nodes = vec![[0.0; 3]; grid.len()];
    let full = plain
        .with_selected_inertia(&inertia_params(of))
        .and_then(|b| b.with_selected_film(lubricant(of)))
        .map_err(|e| named(of, e))?;
    let open = fill_table(&full, &domain, &grid, &mut nodes);
    if open > 0 {
        return Err(BuildError::Table {
            file: scene.path.clone(),
            bearing: of.name.clone(),
            found: open,
            states: grid.len(),
        });
    }
    Ok(TableData { by_outer, grid, nodes, constants, friction: has_inner_friction(of) })
}

/// Contact angles to either side of the free one, rad.
const TABLE_ANGLES: f64 = 0.4;
/// Squares of the speeds about a constant one; inertia loads are linear in the square, and the constant speed is a node.
const TABLE_SPEEDS_SQUARED: [f64; 2] = [0.64, 1.36];
/// Range of speeds of a table that does not depend on them, rad/s.
const EVERY_SPEED: [f64; 2] = [0.0, 1e9];
/// Scale of a wide range of speeds over the highest, with an oil film: its thickness rises with a power of the speed below 1, inertia
/// loads with the square.
const SPEEDS_WITH_FILM: f64 = 10.0;
/// Intervals along the angle of a bearing with a contact angle, over which its forces change evenly: at a constant speed, and over a
/// range, where the other coordinates need the nodes.
const ANGLE_INTERVALS: [usize; 2] = [12, 8];
/// Intervals along the angle of a deep-groove bearing over those along the approach.
const GROOVE_ANGLE_INTERVALS: f64 = 0.85;
/// Least and largest number of intervals along approach and angle.
const INTERVALS: [usize; 2] = [4, 64];
/// Nodes along approach and angle beyond the number of intervals.
const FURTHER_NODES: usize = 3;
/// Least approach in service over the largest approach: a rotor without weight and load still moves.
const LEAST_SCALE: f64 = 0.02;
/// Load of a ball in service over that at the static pressure limit, where the scene states no load.
const TYPICAL_LOAD: f64 = 0.05;

/// Returns the range of a bearing's table: the scene's, else up to the static pressure limit, about free angle and speed.
///
/// The intervals are the scene's, else as many as `size` allows.
fn domain(
    scene: &Scene,
    of: &BearingScene,
    geometry: &BallBearingGeometry,
    size: TableSize,
) -> Result<(TableDomain, bool), BuildError> {
    let given = of.table.unwrap_or_default();
    let contact = geometry.contact(Race::Inner);
    let (_, _, pressure) = contact.ellipse(1.0);
    let load = (PRESSURE_LIMIT / pressure).powi(3);
    let most = point_contact_approach(geometry.stiffness(), load);
    let both = of.facing == Facing::Both;
    let free = if both { [0.0, geometry.contact_angle] } else { [geometry.contact_angle; 2] };
    let widest = if both { free[1] + TABLE_ANGLES } else { TABLE_ANGLES };
    let angles = [(free[0] - widest).max(-1.3), (free[1] + TABLE_ANGLES).min(1.3)];
    let (inner, outer) = (scene.shaft.speed, scene.shaft.outer_speed);
    let about = |speed: f64| TABLE_SPEEDS_SQUARED.map(|part| part.sqrt() * speed.abs());
    let by_outer = inner == Speed::Constant(0.0) && outer != 0.0;
    let speeds = match inner {
        _ if by_outer => about(outer),
        Speed::Constant(speed) => about(speed),
        Speed::Ramp { from, to, .. } => [from.abs().min(to.abs()), from.abs().max(to.abs())],
        Speed::Fluctuating { mean, fluctuation, .. } => [1.0 - fluctuation, 1.0 + fluctuation].map(|p| p * mean.abs()),
    };
    let turning = if by_outer { [0.0, 1.0] } else { [1.0, outer_ratio(scene)?] };
    // Without inertia and film the table does not depend on the speed.
    let still = of.effects == ballrace_scene::Effects::default();
    let speed = if still { EVERY_SPEED } else { given.speed.unwrap_or(speeds) };
    let narrow = matches!(inner, Speed::Constant(_)) && given.speed.is_none();
    let layers = match (still || speed[0] == speed[1], narrow) {
        (true, _) => 0,
        (_, true) if both => 2,
        (_, true) => 4,
        (_, false) => size.over_speeds,
    };
    let intervals = match given.intervals {
        Some([nx, na, nv]) => [nx, na, if layers == 0 { 0 } else { nv }],
        None => {
            let nodes = size.bytes / (size_of::<f32>() * numbers(has_inner_friction(of))) / (layers + 1);
            let [nx, na] = if both { groove_resolution(nodes) } else { resolution(nodes, narrow || still) };
            [nx, na, layers]
        }
    };
    let in_service = approach_in_service(scene, of, geometry);
    let domain = TableDomain {
        approach: given.approach.unwrap_or([-0.5 * most, most]),
        scale: in_service
            .unwrap_or_else(|| point_contact_approach(geometry.stiffness(), TYPICAL_LOAD * load))
            .clamp(LEAST_SCALE * most, most),
        angle: given.angle.unwrap_or(angles),
        speed,
        speed_scale: if of.effects.film.is_some() && !narrow { SPEEDS_WITH_FILM * speed[1] } else { 0.0 },
        speed_ratios: turning,
        intervals,
    };
    Ok((domain, by_outer))
}

/// Returns the intervals along approach and angle of a layer of at most `nodes` nodes, for a bearing with a contact angle.
fn resolution(nodes: usize, at_one_speed: bool) -> [usize; 2] {
    let ([least, most], [at_one, over_range]) = (INTERVALS, ANGLE_INTERVALS);
    let across = if at_one_speed { at_one } else { over_range };
    let along = (nodes / (across + FURTHER_NODES)).saturating_sub(FURTHER_NODES);
    [along.clamp(least, most), across]
}

/// Returns the same for a deep-groove bearing. Its balls change sides in the plane of the grooves, where an even number puts nodes.
fn groove_resolution(nodes: usize) -> [usize; 2] {
    let [least, most] = INTERVALS;
    let pair = |along: usize| [along, ((GROOVE_ANGLE_INTERVALS * along as f64) as usize & !1).max(least)];
    let fits = |[along, across]: &[usize; 2]| (along + FURTHER_NODES) * (across + FURTHER_NODES) <= nodes;
    (least..=most).rev().map(pair).find(fits).unwrap_or([least; 2])
}

/// Builds the tabulated model of a bearing, with its table.
pub fn build<T: Scalar, M: Math<T>, H: BearingHandle<T>>(scene: &Scene, of: &BearingScene) -> Result<H, BuildError> {
    of_table::<T, M, H>(of, &table(scene, of, DESKTOP_TABLE)?)
}

/// Builds the tabulated model from its table.
///
/// # Errors
/// None with a table of this bearing.
pub fn of_table<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    of: &BearingScene,
    made: &TableData,
) -> Result<H, BuildError> {
    // Four numbers per node, the last of them 0: one 256-bit register.
    if made.friction { looked_up::<T, M, H, 4>(of, made) } else { looked_up::<T, M, H, 2>(of, made) }
}

fn looked_up<T: Scalar, M: Math<T>, H: BearingHandle<T>, const F: usize>(
    of: &BearingScene,
    made: &TableData,
) -> Result<H, BuildError> {
    let round = |node: &[f64; 3]| std::array::from_fn(|i| T::from_f64(node.get(i).copied().unwrap_or_default()));
    let nodes: Vec<[T; F]> = made.nodes.iter().map(round).collect();
    let table = Table::new(made.grid.rounded::<T>(), nodes);
    let bearing = Tabulated::<T, M, _, _, F>::new(blocked_places(of), made.constants.rounded(), table, made.by_outer);
    Ok(match uneven::<T, M>(of) {
        None => facing(of, H::dispatched(bearing)),
        Some(surface) => facing(of, H::dispatched(bearing.with_surface(surface))),
    })
}
