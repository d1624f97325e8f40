//! Parts of a bearing's struct of C that models have in common.

use super::Constants;
use crate::construction::BuildError;
use ballrace::bearing::tabulated::Axis;
use ballrace_scene::{Bearing, Facing};
use std::fmt::{self, Write};

/// Writes the beginning of the struct `name` of a type: its head, with the functions of `model`.
pub(crate) fn open(
    out: &mut String,
    (name, kind, model): (&str, &str, &str),
    Constants { of, .. }: &Constants<'_>,
) -> Result<(), BuildError> {
    let count = if of.model.has_elements() { of.elements } else { 0 };
    let elements = if count == 0 { "NULL".to_owned() } else { format!("{name}_elements") };
    writeln!(out, "const {kind} {name} = {{\n    .head = {{ &{model}, {elements}, {count} }},")?;
    Ok(())
}

/// Returns the part of a model's name for a bearing that carries thrust towards -Z.
pub(crate) fn facing(of: &Bearing) -> &'static str {
    if of.facing == Facing::MinusZ { "_mirrored" } else { "" }
}

/// Writes members and the end of a struct.
///
/// # Errors
/// None: `source` is a text.
pub fn close(source: &mut String, members: &[(&str, String)]) -> fmt::Result {
    for (name, value) in members {
        writeln!(source, "    .{name} = {value},")?;
    }
    writeln!(source, "}};")
}

/// Returns a number in single precision: its shortest decimal text is read as the same bits.
#[must_use]
pub fn single(x: f32) -> String {
    format!("{x:?}f")
}

/// Returns numbers as an initialiser.
#[must_use]
pub fn list(numbers: &[f32]) -> String {
    format!("{{ {} }}", numbers.iter().map(|x| single(*x)).collect::<Vec<_>>().join(", "))
}

/// Returns an axis of a table as an initialiser.
pub(crate) fn axis(axis: &Axis<f32>) -> String {
    let [least, greatest] = axis.range;
    let numbers = [axis.origin, axis.density, least, greatest].map(single).join(", ");
    format!("{{ {}, {numbers} }}", axis.count)
}
