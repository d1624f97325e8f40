//! The file `modelDescription.xml` of a unit.

use super::variable::{Causality, Variable};
use super::{Content, Unit};
use ballrace_scene::Scene;
use std::fmt::Write as _;

/// Units of the variables with the exponents of their SI base units.
const UNITS: [(&str, &str); 7] = [
    ("s", "s=\"1\""),
    ("m", "m=\"1\""),
    ("rad", "rad=\"1\""),
    ("m/s", "m=\"1\" s=\"-1\""),
    ("rad/s", "rad=\"1\" s=\"-1\""),
    ("N", "kg=\"1\" m=\"1\" s=\"-2\""),
    ("N.m", "kg=\"1\" m=\"2\" s=\"-2\""),
];
/// Longest identifier of a model.
const LONGEST: usize = 64;

/// Returns the description of a unit and the identifier of its model, which is the name of its library.
///
/// # Errors
/// A text that cannot be formatted.
pub fn model_description(
    unit: &Unit,
    scene: &Scene,
    content: &Content,
    token: &str,
) -> Result<(String, String), std::fmt::Error> {
    let name = match content {
        Content::Rotor { .. } => format!("{} rotor", scene.name),
        Content::Bearing { name } => format!("{} bearing {name}", scene.name),
    };
    let (identifier, version) = (identifier(&name), env!("CARGO_PKG_VERSION"));
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    writeln!(
        out,
        "<fmiModelDescription fmiVersion=\"3.0\" modelName=\"{}\" instantiationToken=\"{token}\" \
         generationTool=\"ballrace {version}\" variableNamingConvention=\"structured\">",
        escaped(&name)
    )?;
    let step = unit.internal_step();
    let internal = step.map_or(String::new(), |step| format!(" fixedInternalStepSize=\"{step:?}\""));
    writeln!(
        out,
        "  <CoSimulation modelIdentifier=\"{identifier}\" canGetAndSetFMUState=\"true\" \
         canHandleVariableCommunicationStepSize=\"true\"{internal}/>"
    )?;
    writeln!(out, "  <UnitDefinitions>")?;
    for (name, base) in UNITS {
        if unit.variables().iter().any(|variable| variable.unit == Some(name)) {
            writeln!(out, "    <Unit name=\"{name}\"><BaseUnit {base}/></Unit>")?;
        }
    }
    writeln!(out, "  </UnitDefinitions>")?;
    if let Some(step) = step {
        writeln!(out, "  <DefaultExperiment startTime=\"0\" stepSize=\"{step:?}\"/>")?;
    }
    writeln!(out, "  <ModelVariables>")?;
    for (reference, variable) in unit.variables().iter().enumerate() {
        write_variable(&mut out, reference, variable)?;
    }
    writeln!(out, "  </ModelVariables>\n  <ModelStructure>")?;
    write_structure(&mut out, unit)?;
    writeln!(out, "  </ModelStructure>\n</fmiModelDescription>")?;
    Ok((out, identifier))
}

fn write_variable(out: &mut String, reference: usize, variable: &Variable) -> std::fmt::Result {
    let (kind, variability) = if variable.is_whole { ("Int32", "discrete") } else { ("Float64", "continuous") };
    write!(
        out,
        "    <{kind} name=\"{}\" valueReference=\"{reference}\" causality=\"{}\" variability=\"{variability}\" \
         description=\"{}\"",
        escaped(&variable.name),
        variable.causality.name(),
        escaped(&variable.description)
    )?;
    if let Some(unit) = variable.unit {
        write!(out, " unit=\"{unit}\"")?;
    }
    if let Some(of) = variable.rate_of {
        write!(out, " derivative=\"{of}\"")?;
    }
    if variable.causality == Causality::Input {
        write!(out, " start=\"{:?}\"", variable.start)?;
    }
    writeln!(out, "/>")
}

/// Writes the outputs, with the inputs of the same time on which each depends.
fn write_structure(out: &mut String, unit: &Unit) -> std::fmt::Result {
    let of = |wanted: Causality| {
        let all = unit.variables().iter().enumerate().filter(move |(_, variable)| variable.causality == wanted);
        all.map(|(reference, _)| reference)
    };
    let inputs: Vec<String> =
        if unit.is_direct() { of(Causality::Input).map(|input| input.to_string()).collect() } else { vec![] };
    let inputs = inputs.join(" ");
    for element in ["Output", "InitialUnknown"] {
        for output in of(Causality::Output) {
            writeln!(out, "    <{element} valueReference=\"{output}\" dependencies=\"{inputs}\"/>")?;
        }
    }
    Ok(())
}

/// Returns a name as an identifier of C.
fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let start = if name.starts_with(|c: char| c.is_ascii_digit()) { "_" } else { "" };
    start.chars().chain(name.chars().map(plain)).take(LONGEST).collect()
}

/// Returns a text as the value of an attribute.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '"' => escaped += "&quot;",
            // XML has no such characters.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}
