//! The struct of a bearing in C, whose members are the constants of a blob too.

use super::Constants;
use crate::construction::BuildError;
use ballrace::bearing::tabulated::Axis;
use ballrace::blob::{FromBlob, MIRRORED};
use ballrace_scene::{Bearing, Facing};
use std::fmt::{self, Write};

/// Struct of a bearing in C.
pub struct CStruct {
    /// Its type.
    pub kind: &'static str,
    /// Name of the constant with the functions of its model.
    pub model: String,
    /// Code of its model in a blob.
    pub code: u32,
    /// Members between the head and the array, of 4 bytes each.
    pub members: Vec<(&'static str, Member)>,
    /// The array to which the last member points.
    pub array: Option<Array>,
}

/// Value of a member.
pub enum Member {
    /// A number.
    Number(f32),
    /// A count or a flag.
    Integer(u32),
    /// An array of numbers.
    Numbers(Vec<f32>),
    /// Rows of a stiffness.
    Rows([[f32; 5]; 5]),
    /// Axis of a table.
    Axis(Axis<f32>),
}

/// Numbers to which a member points.
pub struct Array {
    /// Name of the member.
    pub member: &'static str,
    /// Type of the entries.
    pub kind: &'static str,
    /// Numbers of an entry, in braces where there are several.
    pub numbers_per_entry: usize,
    /// Numbers in a line.
    pub numbers_per_line: usize,
    /// All numbers.
    pub numbers: Vec<f32>,
    /// Comment before it.
    pub comment: Option<String>,
}

impl CStruct {
    /// Returns the struct of a bearing with the functions `ballrace_MODEL_model`, for which the model `B` of the kernel stands in a blob.
    pub(crate) fn new<'a, B: FromBlob<'a>>(
        of: &Bearing,
        kind: &'static str,
        model: &str,
        members: Vec<(&'static str, Member)>,
    ) -> Self {
        let (facing, mirrored) = if of.facing == Facing::MinusZ { ("_mirrored", MIRRORED) } else { ("", 0) };
        Self { kind, model: format!("{model}{facing}_model"), code: B::CODE | mirrored, members, array: None }
    }

    /// Returns the struct with an array.
    pub(crate) fn with_array(self, array: Array) -> Self {
        Self { array: Some(array), ..self }
    }

    /// Writes the definition of the struct `name`, and that of its array.
    ///
    /// # Errors
    /// None: `out` is a text.
    pub fn write(&self, out: &mut String, name: &str, Constants { of, .. }: &Constants<'_>) -> Result<(), BuildError> {
        if let Some(array) = &self.array {
            array.write(out, name)?;
        }
        let count = if of.model.has_elements() { of.elements } else { 0 };
        let elements = if count == 0 { "NULL".to_owned() } else { format!("{name}_elements") };
        writeln!(out, "const {} {name} = {{\n    .head = {{ &{}, {elements}, {count} }},", self.kind, self.model)?;
        let mut members: Vec<(&str, String)> = self.members.iter().map(|(name, value)| (*name, value.text())).collect();
        members.extend(self.array.as_ref().map(|Array { member, .. }| (*member, format!("{name}_{member}"))));
        Ok(close(out, &members)?)
    }

    /// Returns the bits of the members.
    #[must_use]
    pub fn words(&self) -> Vec<u32> {
        self.members.iter().flat_map(|(_, value)| value.words()).collect()
    }
}

impl Member {
    fn text(&self) -> String {
        match self {
            Self::Number(x) => single(*x),
            Self::Integer(count) => count.to_string(),
            Self::Numbers(numbers) => list(numbers),
            Self::Rows(rows) => {
                let row = |row: &[f32; 5]| format!("        {},\n", row.map(single).join(", "));
                format!("{{\n{}    }}", rows.iter().map(row).collect::<String>())
            }
            Self::Axis(axis) => {
                let [least, greatest] = axis.range;
                let numbers = [axis.origin, axis.density, least, greatest].map(single).join(", ");
                format!("{{ {}, {numbers} }}", axis.count)
            }
        }
    }

    fn words(&self) -> Vec<u32> {
        let bits = |numbers: &[f32]| numbers.iter().map(|x| x.to_bits()).collect();
        match self {
            Self::Number(x) => vec![x.to_bits()],
            Self::Integer(count) => vec![*count],
            Self::Numbers(numbers) => bits(numbers),
            Self::Rows(rows) => bits(rows.as_flattened()),
            Self::Axis(axis) => {
                let [least, greatest] = axis.range;
                let numbers = [axis.origin, axis.density, least, greatest].map(f32::to_bits);
                std::iter::once(axis.count as u32).chain(numbers).collect()
            }
        }
    }
}

impl Array {
    fn write(&self, out: &mut String, name: &str) -> fmt::Result {
        let Self { member, kind, numbers_per_entry, numbers_per_line, numbers, comment } = self;
        if let Some(comment) = comment {
            writeln!(out, "// {comment}")?;
        }
        writeln!(out, "static const {kind} {name}_{member}[{}] = {{", numbers.len() / numbers_per_entry.max(&1))?;
        for line in numbers.chunks(*numbers_per_line) {
            let entry = |numbers: &[f32]| {
                if *numbers_per_entry > 1 {
                    list(numbers)
                } else {
                    numbers.iter().copied().map(single).collect::<String>()
                }
            };
            let entries: Vec<String> = line.chunks(*numbers_per_entry).map(entry).collect();
            writeln!(out, "    {},", entries.join(", "))?;
        }
        writeln!(out, "}};\n")
    }
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
