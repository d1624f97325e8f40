//! Constants as a header and a source file of C99, for the library `ballrace-c`.

use super::observer::ObserverConstants;
use super::{BakedFile, Comments, Language, Part, Selected, embedded, linearised, rotor};
use ballrace::Displacement;
use ballrace::bearing::ElementPosition;
use ballrace::bearing::checksum::ChecksumRange;
use ballrace::rotor::{RotorParams, Unbalance};
use ballrace_models::build;
use ballrace_models::model::Constants;
use ballrace_models::model::c::{close, list, single};
use ballrace_plant::error::{BakeError, Result};
use ballrace_scene::{Bearing, Scene};
use std::fmt::Write;

/// Largest number of elements of the library.
const MAX_ELEMENTS: usize = 32;

/// Rejects bearings and rotors for which the library has no structs.
///
/// # Errors
/// Returns an error for waviness, damage or too many elements and, for a whole scene, for coordinates beyond those of a rigid rotor.
pub fn check(scene: &Scene, chosen: &[&Bearing], (language, whole): (Language, bool)) -> Result<(), BakeError> {
    let (file, language) = (&scene.path, language.name());
    let refused = |place: String, found: String, expected| BakeError::NotInC {
        file: file.clone(),
        language,
        place,
        found,
        expected,
    };
    for of in chosen {
        let place = format!("bearing {}", of.name);
        if !of.waviness.is_empty() || !of.defect.is_empty() {
            let expected = "a smooth bearing, or --language rust";
            return Err(refused(place, "waviness or damage".to_owned(), expected));
        }
        if of.elements > MAX_ELEMENTS {
            let expected = "at most 32, or --language rust";
            return Err(refused(place, format!("{} elements", of.elements), expected));
        }
    }
    if whole && rotor::has_further_coordinates(scene) {
        let expected = "--bearing with the name of one bearing, or --language rust";
        return Err(refused("[rotor]".to_owned(), "flexible rotor or elastic support".to_owned(), expected));
    }
    Ok(())
}

/// Returns the header and the source file.
///
/// # Errors
/// Returns an error if a constant cannot be computed.
pub fn files(
    (scene, whole): (&Scene, bool),
    parts: &[Part<'_>],
    comments: &Comments<'_>,
    name: &str,
) -> Result<Vec<BakedFile>> {
    let (mut header, mut source) = (String::new(), String::new());
    let guard = macro_name(name);
    let title = embedded::escaped(&scene.name);
    writeln!(header, "// Made by `ballrace bake` from the scene \"{title}\". Do not edit: bake the scene again.")?;
    writeln!(
        header,
        "//\n// `ballrace verify` computes these fields and all constants again from the scene at the end of this file."
    )?;
    write!(header, "{}", embedded::CERTIFICATE.write(&comments.certificate))?;
    writeln!(header, "\n#ifndef {guard}_H\n#define {guard}_H\n\n#include \"ballrace.h\"\n#include <stdint.h>")?;
    writeln!(header, "\n#ifdef __cplusplus\nextern \"C\" {{\n#endif")?;
    writeln!(source, "// Made by `ballrace bake`: the certificate is in {name}.h. Do not edit: bake the scene again.")?;
    writeln!(source, "\n#include \"{name}.h\"\n#include <stddef.h>")?;
    for part in parts {
        Writer::new(scene, part)?.write(&mut header, &mut source)?;
    }
    if whole {
        write_observer(scene, parts, &mut header, &mut source)?;
    }
    writeln!(header, "\n#ifdef __cplusplus\n}}\n#endif\n\n#endif\n\n// Text of the scene.")?;
    write!(header, "{}", embedded::SCENE.write(comments.scene))?;
    Ok(vec![
        BakedFile { extension: Some("h"), content: header.into() },
        BakedFile { extension: Some("c"), content: source.into() },
    ])
}

/// Returns a name in capital letters for the preprocessor.
fn macro_name(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_uppercase() } else { '_' };
    let name: String = name.chars().map(letter).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) { format!("SCENE_{name}") } else { name }
}

/// Writes one bearing.
struct Writer<'a> {
    scene: &'a Scene,
    of: Bearing,
    part: &'a Part<'a>,
    /// Prefix of all names.
    name: &'a str,
    elements: Vec<ElementPosition<f32>>,
}

impl<'a> Writer<'a> {
    fn new(scene: &'a Scene, part: &'a Part<'a>) -> Result<Self> {
        let of = part.selected.firmware.in_c(part.selected.of);
        let elements = if of.model.has_elements() { build::places(&of) } else { vec![] };
        Ok(Self { scene, of, part, name: &part.certificate.module, elements })
    }

    fn write(&self, header: &mut String, source: &mut String) -> Result<()> {
        let Self { scene, of, name, .. } = self;
        let title = embedded::escaped(&of.name);
        let upper = macro_name(name);
        writeln!(header, "\n// Bearing \"{title}\".\n")?;
        writeln!(header, "// Along Z from the rotor's centre of mass, m.")?;
        writeln!(header, "#define {upper}_STATION ({})", single(of.station as f32))?;
        if !self.elements.is_empty() {
            let kinematics = build::kinematics(scene, of)?;
            writeln!(header, "// Cage, ball and outer ring over shaft.")?;
            writeln!(header, "#define {upper}_CAGE_RATIO ({:?})", kinematics.cage_ratio)?;
            writeln!(header, "#define {upper}_BALL_RATIO ({:?})", kinematics.ball_ratio())?;
            writeln!(header, "#define {upper}_OUTER_RATIO ({:?})", kinematics.outer_ratio)?;
        }
        writeln!(header, "// Checksum of 1024 forces, computed on the desktop.")?;
        writeln!(header, "#define {upper}_CHECKSUM UINT64_C({:#018x})\n", self.part.certificate.checksum)?;
        writeln!(source, "\n// Bearing \"{title}\".\n")?;
        let offset = build::offset_as_mounted(scene, self.part.selected.of)?;
        writeln!(header, "// By preload, to be added to every displacement.\nextern const float {name}_offset[5];")?;
        writeln!(source, "const float {name}_offset[5] = {};\n", list(&offset.to_array().map(|x| x as f32)))?;
        if !self.elements.is_empty() {
            self.write_elements(source)?;
        }
        let springs = linearised(scene, of)?;
        let constants = Constants { scene, of, table: self.part.table.as_ref(), offset, springs: springs.as_ref() };
        let own = self.part.selected.firmware.c_struct(&constants)?;
        own.write(source, name, &constants)?;
        let kind = own.kind;
        writeln!(header, "// The bearing: `&{name}.head` is the argument of all calls.\nextern const {kind} {name};")?;
        self.write_checksum(header, source)
    }

    fn write_elements(&self, source: &mut String) -> Result<()> {
        writeln!(source, "static const ballrace_element {}_elements[{}] = {{", self.name, self.elements.len())?;
        for element in &self.elements {
            let (cos, sin) = element.direction();
            let azimuth = element.azimuth().0;
            writeln!(source, "    {{ {}, {}, UINT64_C({azimuth:#018x}) }},", single(cos), single(sin))?;
        }
        writeln!(source, "}};\n")?;
        Ok(())
    }

    fn write_checksum(&self, header: &mut String, source: &mut String) -> Result<()> {
        let name = self.name;
        let ChecksumRange { centre, amplitude, inner_speed, outer_speed } = self.part.certificate.range;
        writeln!(source, "\nstatic const ballrace_checksum_range {name}_checksum_range = {{")?;
        let displacement = |u: Displacement<f32>| list(&u.to_array());
        let members = [
            ("centre", displacement(centre)),
            ("amplitude", displacement(amplitude)),
            ("inner_speed", list(&inner_speed)),
            ("outer_speed", list(&outer_speed)),
        ];
        close(source, &members)?;
        writeln!(
            header,
            "// Computes the checksum; every target returns {}_CHECKSUM. For start-up: 1024 forces.",
            macro_name(name)
        )?;
        writeln!(header, "uint64_t {name}_checksum(void);")?;
        writeln!(
            source,
            "\nuint64_t {name}_checksum(void)\n{{\n    return ballrace_checksum(&{name}.head, &{name}_checksum_range);\n}}"
        )?;
        Ok(())
    }
}

/// Largest numbers of bearings and probes of an observer of the library.
const MAX_OBSERVED: [usize; 2] = [4, 8];

/// Writes the observer of a rigid rotor, where the scene has one: the arguments of `ballrace_observer_init`.
fn write_observer(scene: &Scene, parts: &[Part<'_>], header: &mut String, source: &mut String) -> Result<()> {
    let Some(constants) = ObserverConstants::try_new(scene)? else { return Ok(()) };
    let (bearings, probes) = (parts.len(), constants.rows.len());
    let [most_bearings, most_probes] = MAX_OBSERVED;
    let Some((rotor, unbalances)) =
        constants.rigid_rotor().filter(|_| bearings <= most_bearings && probes <= most_probes)
    else {
        return Err(BakeError::NotInC {
            file: scene.path.clone(),
            language: Language::C.name(),
            place: "[observer]".to_owned(),
            found: format!("{bearings} bearings and {probes} probes"),
            expected: "a rigid rotor with at most 4 bearings and 8 probes, or --language rust",
        }
        .into());
    };
    let plural = |count: usize, one: &'static str| format!("{count}_{one}{}", if count == 1 { "" } else { "s" });
    let model = format!("ballrace_observer_of_{}_{}", plural(bearings, "bearing"), plural(probes, "probe"));
    let names = embedded::escaped(&constants.names.join(", "));
    writeln!(header, "\n// The observer behind the probes {names}: the arguments of `ballrace_observer_init`.\n")?;
    writeln!(header, "// From sample to sample, s.\n#define OBSERVER_PERIOD ({})", single(constants.period as f32))?;
    writeln!(header, "#define OBSERVER_BEARINGS {bearings}\n#define OBSERVER_PROBES {probes}")?;
    writeln!(header, "#define OBSERVER_MODEL (&{model})")?;
    writeln!(header, "extern const ballrace_rotor_params observer_rotor;")?;
    writeln!(header, "extern const ballrace_rotor_bearing observer_bearings[{bearings}];")?;
    writeln!(header, "extern const ballrace_observer_params observer_params;")?;
    write_rotor(source, &rotor, &unbalances)?;
    writeln!(source, "const ballrace_rotor_bearing observer_bearings[{bearings}] = {{")?;
    for Part { selected: Selected { of, .. }, certificate, .. } in parts {
        let kinematics = build::kinematics(scene, of)?;
        let ratios = [kinematics.cage_ratio, kinematics.ball_ratio(), kinematics.outer_ratio];
        let ratios = ratios.map(|ratio| format!("{ratio:?}")).join(", ");
        writeln!(source, "    {{ &{}.head, {ratios}, {} }},", certificate.module, single(of.station as f32))?;
    }
    writeln!(source, "}};\n")?;
    let flat = |rows: &[Vec<f64>]| {
        let numbers = rows.iter().flatten().map(|x| single(*x as f32));
        numbers.collect::<Vec<_>>().join(", ")
    };
    writeln!(source, "static const float observer_probes[{}] = {{", 5 * probes)?;
    writeln!(source, "    {},\n}};\n", flat(&constants.rows))?;
    let gains = constants.gains();
    let count = gains.len();
    writeln!(source, "static const float observer_gains[{}] = {{", count * (20 * probes + probes * probes))?;
    for (_, columns) in gains.flatten() {
        writeln!(source, "    {},", flat(&columns))?;
    }
    writeln!(source, "}};\n\nconst ballrace_observer_params observer_params = {{")?;
    let [first, density] = constants.speeds;
    let substeps = constants.verlet_substeps()?;
    let step = constants.period as f32 / substeps as f32;
    close(
        source,
        &[
            ("probes", "observer_probes".to_owned()),
            ("gains", "observer_gains".to_owned()),
            ("gain_count", count.to_string()),
            ("substeps", substeps.to_string()),
            ("step", single(step)),
            ("first_speed", single(first)),
            ("speed_density", single(density)),
            ("load_retention", single(constants.memory)),
            ("gate", single(constants.gate)),
        ],
    )?;
    Ok(())
}

/// Writes the rotor and its unbalances.
fn write_rotor(source: &mut String, rotor: &RotorParams, unbalances: &[Unbalance]) -> Result<()> {
    writeln!(source, "\n// The observer.\n")?;
    if !unbalances.is_empty() {
        writeln!(source, "static const ballrace_unbalance observer_unbalances[{}] = {{", unbalances.len())?;
        for Unbalance { moment, angle, station } in unbalances {
            writeln!(source, "    {{ {moment:?}, {angle:?}, {station:?} }},")?;
        }
        writeln!(source, "}};\n")?;
    }
    let doubles =
        |numbers: &[f64]| format!("{{ {} }}", numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", "));
    let RotorParams { mass, diametral_inertia, polar_inertia, damping, stiffness, gravity, load } = rotor;
    let list = if unbalances.is_empty() { "NULL" } else { "observer_unbalances" };
    writeln!(source, "const ballrace_rotor_params observer_rotor = {{")?;
    close(
        source,
        &[
            ("mass", format!("{mass:?}")),
            ("diametral_inertia", format!("{diametral_inertia:?}")),
            ("polar_inertia", format!("{polar_inertia:?}")),
            ("damping", doubles(damping.as_flattened())),
            ("stiffness", doubles(stiffness)),
            ("gravity", doubles(gravity)),
            ("load", doubles(load)),
            ("unbalances", list.to_owned()),
            ("unbalance_count", unbalances.len().to_string()),
        ],
    )?;
    writeln!(source)?;
    Ok(())
}
