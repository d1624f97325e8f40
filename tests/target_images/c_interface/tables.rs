//! The tables of the baked scene, without surface deviations, as bearings of the kernel and as source of C.

use super::super::baked::bearings::{bearing_de, bearing_nde};
use ballrace::bearing::ElementPosition;
use ballrace::bearing::quasi_static::TableConstants;
use ballrace::bearing::tabulated::{Axis, Grid, Node, Table, Tabulated};
use ballrace::{Exact, TabulatedBearing};
use std::fmt::Write;

/// Bearing "DE": two numbers per node.
pub fn de() -> TabulatedBearing<f32, 8, 2> {
    bearing_de::bearing()
}

/// Bearing "NDE" without its surface deviations: three numbers per node.
pub fn nde() -> TabulatedBearing<f32, 9, 3> {
    let baked = bearing_nde::bearing().0;
    let table: Table<f32, &'static [Node<f32, 3>], 3> = Table::new(*baked.table().grid(), &bearing_nde::NODES);
    Tabulated::<_, Exact, _, _, 3>::new(bearing_nde::POSITIONS, *baked.constants(), table, false)
}

/// Source of C with both tables: macros that initialise a `ballrace_tabulated` with a model.
pub fn header() -> String {
    let mut text = "#pragma once\n\n#include \"ballrace.h\"\n".to_owned();
    let (de, nde) = (de(), nde());
    write_table(&mut text, "DE", &bearing_de::POSITIONS, de.constants(), de.table().grid(), &bearing_de::NODES);
    write_table(&mut text, "NDE", &bearing_nde::POSITIONS, nde.constants(), nde.table().grid(), &bearing_nde::NODES);
    text
}

fn write_table<const F: usize>(
    text: &mut String,
    name: &str,
    positions: &[ElementPosition<f32>],
    constants: &TableConstants<f32>,
    grid: &Grid<f32>,
    nodes: &[Node<f32, F>],
) {
    let nodes_text: Vec<String> = nodes.iter().flatten().map(|x| format!("{x:?}f")).collect();
    let elements: Vec<String> = positions
        .iter()
        .map(|position| {
            let (cos, sin) = position.direction();
            format!("{{ {cos:?}f, {sin:?}f, {:#x}u }}", position.azimuth().0)
        })
        .collect();
    let axis = |axis: &Axis<f32>| {
        let Axis { count, origin, density, range: [least, greatest] } = axis;
        format!("{{ {count}, {origin:?}f, {density:?}f, {least:?}f, {greatest:?}f }}")
    };
    let TableConstants { couple, distance, axis: [cos, sin], offset, arm } = constants;
    let result = write!(
        text,
        "static const float nodes_{name}[] = {{ {} }};\n\
         static const ballrace_element elements_{name}[] = {{ {} }};\n\
         #define TABULATED_{name}(model_) {{ {{ model_, elements_{name}, {} }}, {couple:?}f, {distance:?}f, {cos:?}f, \
         {sin:?}f, {offset:?}f, {arm:?}f, {:?}f, {:?}f, {}, {}, {}, 0, {}, nodes_{name} }}\n",
        nodes_text.join(", "),
        elements.join(", "),
        positions.len(),
        grid.scale,
        grid.speed_scale,
        axis(&grid.approach),
        axis(&grid.angle),
        axis(&grid.speed),
        nodes.len(),
    );
    result.expect("a text grows");
}
