//! Draft of a scene: every value that the catalogue and a recording give, and `"?"` for those that the user has to fill in.

use ballrace_base::printable::number;
use ballrace_recording::preview::{ColumnLevel, ColumnRole, NamedDirection, Preview, PreviewColumn};
use ballrace_scene::catalogue::{BearingKind, Listed, clearance_range, scene_keys};
pub use ballrace_scene::edit::UNKNOWN;
use ballrace_scene::units;
use std::fmt::Write;
use toml_edit::Value;

/// Column at which comments begin.
const COMMENT: usize = 38;

/// Largest number of scalars of a recording that a comment lists.
const NUMBERS_SHOWN: usize = 20;

/// Content of a draft.
#[derive(Debug, Default)]
pub struct Draft<'a> {
    /// Name of the scene.
    pub name: String,
    /// Shaft speed with its unit.
    pub speed: Option<String>,
    /// Bearings in the order of their stations.
    pub bearings: Vec<Listed>,
    /// Name of the recording's file from the folder of the scene, and its columns.
    pub recording: Option<(String, &'a Preview)>,
}

/// Returns the scene as TOML with a comment on each key.
///
/// ```
/// use ballrace_scene::catalogue::find;
/// use ballrace_replay::draft::{Draft, draft};
///
/// let bearings = vec![find("6205")?, find("6205")?];
/// let text = draft(&Draft { name: "pump".to_owned(), speed: Some("3000 rpm".to_owned()), bearings, recording: None });
/// assert!(text.contains("bearing = \"6205 CN\"") && text.contains("mass = \"?\""));
/// # Ok::<(), ballrace_scene::catalogue::UnknownBearing>(())
/// ```
#[must_use]
pub fn draft(of: &Draft) -> String {
    let mut page = Page::default();
    page.comment(
        "A scene of ballrace. Replace every \"?\"; `ballrace check` lists those that are left and draws the machine.",
    );
    page.comment("A text carries its unit, such as \"6 kg\"; a number is in SI units. The frame is X, Y radial, Z along the shaft.");
    page.key("name", &quoted(&of.name), "");
    page.table("[shaft]");
    page.text("speed", of.speed.as_deref(), "nameplate or control system, such as \"3000 rpm\"; positive from X to Y");
    if !of.is_vibration() {
        rotor(&mut page, of);
    }
    for (i, listed) in of.bearings.iter().enumerate() {
        bearing(&mut page, i, listed, of);
    }
    match &of.recording {
        Some((file, preview)) => recording(&mut page, file, preview, of.radial_clearance()),
        None => no_recording(&mut page),
    }
    page.0
}

impl Draft<'_> {
    /// Returns the largest play to either side of the centre of a bearing, m; none where a bearing has no class of clearance.
    fn radial_clearance(&self) -> Option<f64> {
        let each = self.bearings.iter().map(|listed| Some(clearance_range(listed)?[1] / 2.0));
        each.collect::<Option<Vec<_>>>()?.into_iter().reduce(f64::max)
    }

    /// Returns true for a recording of vibration, which needs no rotor.
    fn is_vibration(&self) -> bool {
        let Some((_, preview)) = &self.recording else { return false };
        let has = |displacement| {
            preview.columns.iter().any(|column| match &column.role {
                ColumnRole::Displacement(..) | ColumnRole::GapVoltage(..) => displacement,
                ColumnRole::Vibration(_) => !displacement,
                _ => false,
            })
        };
        has(false) && !has(true)
    }
}

/// Lines of the scene.
#[derive(Default)]
struct Page(String);

impl Page {
    fn line(&mut self, line: &str) {
        self.0.push_str(line.trim_end());
        self.0.push('\n');
    }

    fn comment(&mut self, text: &str) {
        self.line(&format!("# {text}"));
    }

    fn table(&mut self, header: &str) {
        self.line("");
        self.line(header);
    }

    fn key(&mut self, key: &str, value: &str, comment: &str) {
        let start = format!("{key} = {value}");
        let comment = if comment.is_empty() { String::new() } else { format!("  # {comment}") };
        self.line(&format!("{start:<COMMENT$}{comment}"));
    }

    /// Writes a text, or `"?"` where it is not known.
    fn text(&mut self, key: &str, value: Option<&str>, comment: &str) {
        self.key(key, &quoted(value.unwrap_or(UNKNOWN)), comment);
    }

    /// Writes a key with its default as a comment.
    fn by_default(&mut self, key: &str, value: &str, comment: &str) {
        let start = format!("# {key} = {value}");
        self.line(&format!("{start:<COMMENT$}  # {comment}"));
    }
}

/// Returns a text as a quoted TOML string.
fn quoted(text: &str) -> String {
    Value::from(text).to_string().trim().to_owned()
}

fn rotor(page: &mut Page, of: &Draft) {
    page.table("[rotor]");
    page.comment("A rigid rotor. A shaft that bends has `sections` and `disks` in place of mass and inertias.");
    page.text("mass", None, "such as \"6 kg\": scales or CAD model");
    page.text(
        "diametral_inertia",
        None,
        "about X and Y through the centre of mass, such as \"0.03 kg m^2\": CAD model",
    );
    page.text("polar_inertia", None, "about Z, such as \"0.006 kg m^2\": CAD model");
    page.text(
        "damping",
        None,
        "such as [400, 400, 400, 0.4, 0.4], N s/m and N m s/rad: a guess, from which `ballrace fit` starts",
    );
    page.by_default("gravity", "[0, -9.80665, 0]", "the default; m/s^2");
    page.by_default(
        "load",
        "[0, 0, 0, 0, 0]",
        "the default; constant force and moment on the rotor, N and N m, such as an axial load, which `ballrace fit` does not estimate",
    );
    let unbalance = "[{ moment = \"60 g mm\", angle = \"0 deg\", station = \"0 mm\" }]";
    page.by_default("unbalance", unbalance, "none by default: `ballrace fit` estimates it");
    if of.bearings.len() == 1 {
        page.by_default(
            "stiffness",
            "[0, 0, 0, 0, 0]",
            "the default; N/m and N m/rad: springs that carry the rotor beside the bearing",
        );
    }
}

/// Returns the name of bearing `i`: drive end, non-drive end, then numbers.
fn bearing_name(i: usize) -> String {
    match i {
        0 => "DE".to_owned(),
        1 => "NDE".to_owned(),
        _ => format!("B{}", i + 1),
    }
}

fn bearing(page: &mut Page, i: usize, listed: &Listed, of: &Draft) {
    let entry = listed.entry;
    page.table("[[bearing]]");
    page.key("name", &quoted(&bearing_name(i)), "any name");
    let class = listed.class.name();
    let size = format!("{}, {} x {} x {} mm", entry.kind.name(), entry.bore, entry.outer_diameter, entry.width);
    let designation = format!("{} {class}", entry.designation);
    page.key("bearing", &quoted(&designation), &format!("{size}; the class of clearance is {class}"));
    if of.is_vibration() {
        return kinematics(page, listed);
    }
    page.text("station", None, "along Z from the rotor's centre of mass, such as \"-100 mm\": drawing");
    if entry.kind == BearingKind::AngularContact {
        page.text("facing", None, "\"+z\" or \"-z\": direction in which the inner ring carries thrust");
    }
    page.comment("The catalogue stands for these keys; a value in the scene replaces it.");
    for key in scene_keys(listed) {
        let estimated = if key.is_estimated { "estimated: " } else { "" };
        page.by_default(key.key, &key.value, &format!("{estimated}{}", key.origin));
    }
}

/// Writes the keys that vibration needs without a designation.
fn kinematics(page: &mut Page, listed: &Listed) {
    let entry = listed.entry;
    let element = if entry.kind.rollers().is_some() { "roller_diameter" } else { "ball_diameter" };
    page.comment("In place of the designation, for a bearing that is not in the catalogue:");
    page.by_default("elements", &entry.elements.to_string(), entry.source);
    page.by_default(element, &format!("\"{} mm\"", entry.element_diameter), "of one element");
    page.by_default("pitch_diameter", &format!("\"{} mm\"", entry.pitch_diameter), "of the circle of element centres");
    page.by_default("contact_angle", &format!("\"{} deg\"", entry.contact_angle), "0 for deep-groove bearings");
    page.comment("Or the frequencies of a data sheet, per revolution of the shaft; element is the spin (BSF), not twice the spin:");
    let o = entry.orders();
    let [outer, inner, element, cage] =
        [o.outer_race, o.inner_race, o.ball_spin, o.cage].map(|order| format!("{order:.3}"));
    page.comment(&format!("orders = {{ outer = {outer}, inner = {inner}, element = {element}, cage = {cage} }}"));
}

fn recording(page: &mut Page, file: &str, preview: &Preview, clearance: Option<f64>) {
    page.table("[recording]");
    page.key("file", &quoted(file), "recording; a relative path begins at the folder of this scene");
    let column = |role: &ColumnRole| preview.columns.iter().find(|column| column.role == *role);
    if preview.is_headless {
        page.key("header", "false", "the first line has values; the columns are c0, c1, ...");
    }
    match (column(&ColumnRole::Time), preview.rate) {
        (None, Some(_)) if preview.is_synchronous => page.key("rate", "\"file\"", "samples per revolution times speed"),
        (Some(time), _) => match units::unit_in_name(&time.name) {
            Some(unit) if unit != "s" => {
                let value = format!("{{ column = {}, unit = {} }}", quoted(&time.name), quoted(unit));
                page.key("time", &value, "column of the time, unit by its name");
            }
            _ => page.key("time", &quoted(&time.name), "column of the time in s"),
        },
        (None, Some(rate)) => {
            // The inverse of a stated period has rounding errors.
            let rate = (rate * 1e6).round() / 1e6;
            page.key("rate", &quoted(&format!("{rate} Hz")), "as the file states");
        }
        (None, None) => page.text("rate", None, "samples per second, such as \"12.8 kHz\": settings of the recorder"),
    }
    // The scalars of the file include the speed, which is no sampling rate.
    let is_speed = |name: &str| name.to_ascii_lowercase().contains("rpm");
    let rates = || preview.numbers.iter().filter(|name| !is_speed(name));
    if preview.rate.is_none() && rates().next().is_some() {
        let numbers: Vec<String> = rates().take(NUMBERS_SHOWN).map(|name| quoted(name)).collect();
        page.comment(&format!(
            "Or rate = {{ column = \"...\", unit = \"Hz\" }} by a number of the file: {}",
            numbers.join(", ")
        ));
    }
    if preview.is_synchronous {
        page.key("keyphasor", "\"synchronous\"", "the file was sampled in step with the shaft, from its mark");
    } else if let Some(keyphasor) = column(&ColumnRole::Keyphasor) {
        let value = format!("{{ column = {}, pulses_per_turn = 1 }}", quoted(&keyphasor.name));
        page.key("keyphasor", &value, "number of marks on the shaft");
    } else if let Some((speed, unit)) = preview.columns.iter().find_map(speed) {
        let value = format!("{{ column = {}, unit = {} }}", quoted(&speed.name), quoted(unit));
        page.key("speed", &value, "unit by the name of the column");
    } else {
        page.comment(
            "No keyphasor and no speed: the shaft turns at the scene's speed from angle 0 at the first sample.",
        );
    }
    let probes = preview.columns.iter().filter_map(|column| probe(column, clearance)).collect();
    let sensors = preview.columns.iter().filter_map(sensor).collect();
    let mut is_empty = true;
    for (key, lines) in [("probes", probes), ("sensors", sensors)] {
        let lines: Vec<String> = lines;
        if lines.is_empty() {
            continue;
        }
        is_empty = false;
        if preview.columns.iter().any(|column| matches!(column.role, ColumnRole::GapVoltage(..))) {
            page.comment(
                "Voltages: sensitivity such as \"7.87 mV/um\"; offset such as \"-9.5 V\", with the shaft in the middle; noise such as \"0.05 um\".",
            );
        }
        page.line(&format!("{key} = ["));
        lines.iter().for_each(|line| page.line(line));
        page.line("]");
    }
    let unknown = || preview.columns.iter().filter(|column| column.role == ColumnRole::Unknown);
    // Columns without a unit may be probes; their names are known.
    let unitless: Vec<&PreviewColumn> = unknown().filter(|column| column.level.is_some()).collect();
    if is_empty && !unitless.is_empty() {
        page.comment("Columns without a unit. Delete those that are no probes.");
        page.line("probes = [");
        for column in &unitless {
            let (column, direction) = (quoted(&column.name), direction(column.direction));
            page.line(&format!("  {{ column = {column}, unit = \"?\", {direction} }},"));
        }
        page.line("]");
    } else if is_empty {
        page.comment("Such as { column = \"DE_X\", unit = \"um\", station = \"-120 mm\", angle = \"0 deg\" }.");
        page.line("probes = [{ column = \"?\", unit = \"?\", station = \"?\", angle = \"?\" }]");
    }
    if is_empty {
        page.comment(
            "Vibration of the housing instead: sensors = [{ column = \"...\", unit = \"g\" }], without probes and [rotor].",
        );
    }
    let is_listed = |column: &&PreviewColumn| is_empty && column.level.is_some();
    let others: Vec<String> =
        unknown().filter(|column| !is_listed(column)).map(|column| quoted(&column.name)).collect();
    if !others.is_empty() {
        page.comment(&format!("Other columns of the recording: {}", others.join(", ")));
    }
}

/// Writes an example of a recording as comments.
fn no_recording(page: &mut Page) {
    page.line("");
    page.comment("No recording was given. `replay` and `simulate --as-recording` need its columns, for example:");
    page.comment("[recording]");
    page.by_default("file", "\"run.csv\"", "a relative path begins at the folder of this scene");
    page.by_default("rate", "\"25.6 kHz\"", "samples per second; a column of the time instead: time = \"t\"");
    page.by_default("keyphasor", "{ column = \"key\", pulses_per_turn = 1 }", "number of marks on the shaft");
    page.comment("probes = [");
    for (name, station, angle) in [("DE_X", -120, 45), ("DE_Y", -120, 135), ("NDE_X", 120, 45), ("NDE_Y", 120, 135)] {
        page.comment(&format!(
            "  {{ column = \"{name}\", unit = \"um\", station = \"{station} mm\", angle = \"{angle} deg\", noise = \"0.05 um\" }},"
        ));
    }
    page.comment("]");
}

fn speed(column: &PreviewColumn) -> Option<(&PreviewColumn, &str)> {
    match &column.role {
        ColumnRole::Speed(unit) => Some((column, unit)),
        _ => None,
    }
}

fn probe(column: &PreviewColumn, clearance: Option<f64>) -> Option<String> {
    let (unit, named, is_voltage) = match &column.role {
        ColumnRole::Displacement(unit, direction) => (unit, *direction, false),
        ColumnRole::GapVoltage(unit, direction) => (unit, *direction, true),
        _ => return None,
    };
    let mut line = format!("  {{ column = {}, unit = {}, ", quoted(&column.name), quoted(unit));
    if is_voltage {
        let offset = column.level.map_or_else(|| UNKNOWN.to_owned(), |level| in_unit(level.mean, level.noise, unit));
        let _ = write!(line, "sensitivity = \"?\", offset = {}, ", quoted(&offset));
    }
    line += &direction(named);
    let mut comments = match (column.has_unit, named.is_some()) {
        (true, true) => vec!["unit of the file, direction by the name".to_owned()],
        (true, false) => vec!["unit of the file".to_owned()],
        (false, true) => vec!["unit and direction by the name of the column".to_owned()],
        (false, false) => vec!["unit by the name of the column".to_owned()],
    };
    if let Some(level) = column.level {
        comments.push(estimates(&mut line, level, unit, is_voltage, named, clearance));
    }
    let _ = write!(line, " }},  # {}", comments.join("; "));
    Some(line)
}

/// Adds noise and offset to a probe as far as the rows give them, and returns the comment on both.
fn estimates(
    line: &mut String,
    level: ColumnLevel,
    unit: &str,
    is_voltage: bool,
    named: Option<NamedDirection>,
    clearance: Option<f64>,
) -> String {
    let (noise, mean) = (in_unit(level.noise, level.noise, unit), in_unit(level.mean, level.noise, unit));
    let of = format!("estimated from {} rows", level.rows);
    if is_voltage {
        return format!("offset {of}, as the mean; noise of {noise} by the scatter, to be divided by the sensitivity");
    }
    let _ = write!(line, ", noise = {}", quoted(&noise));
    let metres = units::length_column(unit).map_or(f64::NAN, |metres| level.mean.abs() * metres);
    match (named, clearance) {
        (Some(NamedDirection::Axial), _) => format!("noise {of}; mean {mean}"),
        (_, Some(play)) if metres <= play => {
            format!("noise {of}; mean {mean}, within the clearance of +-{} um", number(play * 1e6))
        }
        (_, Some(play)) => {
            let _ = write!(line, ", offset = {}", quoted(&mean));
            format!("noise and offset {of}: the mean is beyond the clearance of +-{} um", number(play * 1e6))
        }
        (_, None) => format!("noise {of}; mean {mean}, of which offset is the part that is no displacement"),
    }
}

/// Returns a value with two digits of its noise, and its unit.
fn in_unit(value: f64, noise: f64, unit: &str) -> String {
    let digits = if noise > 0.0 { (1.0 - noise.log10().floor()).clamp(0.0, 12.0) as usize } else { 3 };
    let text = format!("{value:.digits$}");
    // A mean within its rounding has no sign.
    let is_zero = !text.contains(|digit: char| ('1'..='9').contains(&digit));
    format!("{} {unit}", if is_zero { text.trim_start_matches('-') } else { &text })
}

/// Returns the keys of a direction.
fn direction(named: Option<NamedDirection>) -> String {
    match named {
        Some(NamedDirection::Axial) => "axial = true".to_owned(),
        Some(NamedDirection::X) => "station = \"?\", angle = \"0 deg\"".to_owned(),
        Some(NamedDirection::Y) => "station = \"?\", angle = \"90 deg\"".to_owned(),
        Some(NamedDirection::Degrees(angle)) => format!("station = \"?\", angle = \"{angle} deg\""),
        None => "station = \"?\", angle = \"?\"".to_owned(),
    }
}

fn sensor(column: &PreviewColumn) -> Option<String> {
    let ColumnRole::Vibration(unit) = &column.role else { return None };
    let (name, unit) = (quoted(&column.name), quoted(unit));
    let origin = if column.has_unit { "unit of the file" } else { "unit by the name of the column" };
    Some(format!("  {{ column = {name}, unit = {unit} }},  # {origin}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_of_gap_voltages() {
        let column = |name: &str, role| PreviewColumn {
            name: name.to_owned(),
            role,
            has_unit: false,
            direction: None,
            level: Some(ColumnLevel { mean: -9.512_34, noise: 0.002_1, rows: 4096 }),
        };
        let columns = vec![
            column("DE_X_V", ColumnRole::GapVoltage("V".to_owned(), Some(NamedDirection::X))),
            column("key", ColumnRole::Keyphasor),
        ];
        let preview = Preview { columns, rate: None, is_headless: false, is_synchronous: false, numbers: vec![] };
        let text = draft(&Draft { recording: Some(("a.csv".to_owned(), &preview)), ..Draft::default() });
        let line = "{ column = \"DE_X_V\", unit = \"V\", sensitivity = \"?\", offset = \"-9.5123 V\", station = \"?\", angle = \"0 deg\" },";
        assert!(text.contains(line) && text.contains("such as \"7.87 mV/um\"") && text.contains("[rotor]"), "{text}");
    }
}
