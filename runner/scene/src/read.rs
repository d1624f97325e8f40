//! Reader of scenes: from TOML text to a [`Scene`] in SI units. Unknown content is an error.
//!
//! This module reads the file, `[shaft]` and `[system]`; `rotor` reads `[rotor]`, `bearing` each `[[bearing]]`, `recording` reads
//! `[recording]`.

mod bearing;
mod catalogue;
mod effects;
pub(crate) mod keys;
mod kinematics;
mod lubrication;
mod mounting;
mod pitch_circle;
mod recording;
mod rollers;
mod rotor;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::io::Read as _;
use std::path::Path;

use toml_edit::{Document, TomlError};

use super::table::{Node, Read, Source, Table, line_of};
pub use super::table::{Problem, SceneError};
use super::units::{self, Dimension};
use super::{
    Allowed, Bearing, Direction, Indicator, Integration, Limit, MachineClass, MachineGroup, MachineSupport, Method,
    Observer, Scene, Shaft, Speed, System, SystemUnbalance,
};
use ballrace_base::bounded::open_regular;
use catalogue::Expansion;

/// Largest size of a scene, bytes: a larger file is most likely a recording.
const LARGEST_FILE: u64 = 4 << 20;

/// Distance beyond the end of the shaft that is taken for rounding, m.
const ROUNDING: f64 = 1e-6;

/// Values expected of `speed`.
const SPEEDS: &str = "a speed of rotation, such as \"3000 rpm\", or { from, to, over }, \
                      or { mean, fluctuation, frequency }";

/// Reads a scene file.
///
/// # Errors
/// The first error in the file, as one line.
pub fn read_file(path: &Path) -> Result<Scene, SceneError> {
    read_str(&load(path)?, path)
}

/// Reads a scene from its text; `path` is the file, for errors and for relative paths.
///
/// # Errors
/// The first error in the text, as one line.
pub fn read_str(text: &str, path: &Path) -> Result<Scene, SceneError> {
    // Some editors start a file with a byte order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let document = Document::parse(text).map_err(|e| syntax_error(text, path, &e))?;
    if document.as_table().is_empty() {
        return Err(SceneError::file(path, "an empty file"));
    }
    let source = Source { text, file: path };
    let root = Table::root(source, document.as_table(), &keys::SCENE)?;
    let catalogue = catalogue::of_bearings(&root)?;
    scene(&root, path, &catalogue)
}

/// Returns the text of a scene file.
///
/// # Errors
/// A file that cannot be read, is not UTF-8 text or is larger than 4 MiB.
pub fn load(path: &Path) -> Result<String, SceneError> {
    let unreadable = |e: std::io::Error| SceneError::file(path, format!("no readable file ({e})"));
    let file = open_regular(path).map_err(|e| match e.kind() {
        std::io::ErrorKind::NotFound => SceneError::file(path, "no file of this name"),
        std::io::ErrorKind::IsADirectory => SceneError::file(path, "a directory"),
        _ => unreadable(e),
    })?;
    let mut bytes = Vec::new();
    file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(SceneError::file(path, "a file of more than 4 MiB"));
    }
    String::from_utf8(bytes).map_err(|e| not_text(path, &e))
}

fn not_text(path: &Path, error: &std::string::FromUtf8Error) -> SceneError {
    let at = error.utf8_error().valid_up_to();
    SceneError { line: Some(line_of(error.as_bytes(), at)), ..SceneError::file(path, "bytes that are not UTF-8 text") }
}

fn syntax_error(text: &str, path: &Path, error: &TomlError) -> SceneError {
    let at = error.span().map_or(0, |span| span.start);
    let line = line_of(text.as_bytes(), at);
    let shown = text.lines().nth(line - 1).unwrap_or_default().trim();
    let message: Vec<&str> = error.message().split_whitespace().collect();
    let found = format!("not TOML at {}: {}", units::quote(shown), message.join(" "));
    Source { text, file: path }.error(at, "", found, "")
}

fn scene<'a>(root: &Table<'a>, path: &Path, catalogue: &'a [Option<Expansion>]) -> Read<Scene> {
    let name = root.read("name", |n| n.text("a name for the scene"))?;
    // In the order of the file, in which errors are reported.
    let shaft = shaft(&root.required("shaft", "a table [shaft] with speed")?)?;
    let rotor = root.read("rotor", rotor::read)?;
    let system = root.read("system", |n| system(n, root, path))?;
    let bearings = bearings(root, catalogue)?;
    if let (Some(node), true) = (root.optional("integration"), bearings.iter().any(|of| of.model.properties().bodies)) {
        let why = "none with model = \"multibody\", whose integrator chooses its steps by step_error; remove it";
        return Err(node.misplaced(why));
    }
    let scene = Scene {
        name: name.map_or_else(|| stem(path), str::to_owned),
        path: path.to_owned(),
        shaft,
        rotor,
        system,
        machine: root.read("machine", machine)?,
        recording: root.read("recording", |n| recording::read(n, path, root.has("system"), &bearings))?,
        bearings,
        integration: root.read("integration", integration)?.unwrap_or_default(),
        observer: root.read("observer", observer)?.unwrap_or_default(),
        limits: root.read("limit", limits)?.unwrap_or_default(),
    };
    about_centre_of_mass(scene, root)
}

/// Moves the stations of bearings and probes from the origin of the drawing to the centre of mass; those of the rotor are there
/// already.
fn about_centre_of_mass(mut scene: Scene, root: &Table<'_>) -> Read<Scene> {
    let Some(drawn) = scene.rotor.as_ref().and_then(|r| Some((r.centre_of_mass, r.flexible.as_ref()?.ends()))) else {
        return Ok(scene);
    };
    let (centre, ends) = drawn;
    let beyond = |station: f64| station - centre < ends[0] - ROUNDING || station - centre > ends[1] + ROUNDING;
    let [from, to] = ends.map(|z| (z + centre) * 1e3);
    let range = Dimension::Length.expected(&format!("between the ends of the shaft, {from:.3} and {to:.3} mm"));
    let refuse = |node: Option<Node<'_>>, i: usize| {
        let node = node.and_then(|n| n.list("").ok()?.into_iter().nth(i));
        let station = node.and_then(|n| n.any_table().ok()?.optional("station"));
        station.map_or_else(|| root.fail("a station beyond the shaft", &range), |n| n.refuse(&range))
    };
    for (i, bearing) in scene.bearings.iter_mut().enumerate() {
        if beyond(bearing.station) {
            return Err(refuse(root.optional("bearing"), i));
        }
        bearing.station -= centre;
    }
    let probes = scene.recording.iter_mut().flat_map(|recording| &mut recording.probes);
    for (i, probe) in probes.enumerate() {
        let is_radial = matches!(probe.direction, Direction::Radial(_));
        if is_radial && beyond(probe.station) {
            let list = root.optional("recording").and_then(|n| n.any_table().ok()?.optional("probes"));
            return Err(refuse(list, i));
        }
        probe.station -= if is_radial { centre } else { 0.0 };
    }
    Ok(scene)
}

/// `method`, with the default of `newton_steps`
const METHODS: [(&str, Method); 3] =
    [("runge-kutta", Method::RungeKutta), ("newmark", Method::Newmark { newton_steps: 2 }), ("verlet", Method::Verlet)];

fn integration(node: &Node<'_>) -> Read<Integration> {
    let table = node.table()?;
    let newton_steps = table.read("newton_steps", |n| n.integer("a whole number from 1 to 20"))?;
    let mut method = table.read("method", |n| n.choice(&METHODS))?.unwrap_or(Method::RungeKutta);
    if let Some(given) = newton_steps.and_then(|n| u8::try_from(n).ok()) {
        let Method::Newmark { newton_steps } = &mut method else {
            return Err(table.required("newton_steps", "")?.misplaced("only with method = \"newmark\"; remove it"));
        };
        *newton_steps = given;
    }
    Ok(Integration { method, step: table.optional_quantity("step")? })
}

/// `group`
const GROUPS: [MachineGroup; 2] = [MachineGroup::Large, MachineGroup::Medium];
/// `support`
const SUPPORTS: [(&str, MachineSupport); 2] =
    [("rigid", MachineSupport::Rigid), ("flexible", MachineSupport::Flexible)];

fn machine(node: &Node<'_>) -> Read<MachineClass> {
    let table = node.table()?;
    let choice = "group and support, or velocity_limits = [\"1.4 mm/s\", \"2.8 mm/s\", \"4.5 mm/s\"]";
    let Some(limits) = table.optional("velocity_limits") else {
        let range = "1 (above 300 kW) or 2 (15 to 300 kW)";
        let node = table.required("group", &format!("{range}, with support; or velocity_limits"))?;
        let group = usize::try_from(node.integer(range)? - 1).ok().and_then(|i| GROUPS.get(i).copied());
        let support = table.required("support", "\"rigid\" or \"flexible\"")?.choice(&SUPPORTS)?;
        return Ok(MachineClass::Iso20816 { group: group.ok_or_else(|| node.refuse(range))?, support });
    };
    if let Some(other) = ["group", "support"].iter().find_map(|key| table.optional(key)) {
        return Err(other.misplaced(format!("either {choice}")));
    }
    let expected = "three rising velocities: those between the zones A and B, B and C, C and D";
    let rising: [f64; 3] = limits.array(expected)?;
    if rising.is_sorted_by(|a, b| a < b) { Ok(MachineClass::Own(rising)) } else { Err(limits.refuse(expected)) }
}

fn limits(node: &Node<'_>) -> Read<Vec<Limit>> {
    node.list("tables [[limit]], in double brackets")?.iter().map(limit).collect()
}

fn limit(node: &Node<'_>) -> Read<Limit> {
    let table = node.table()?;
    let indicator = table.required("indicator", "the name of an indicator")?.choice(&Indicator::ALL)?;
    let race = matches!(indicator, Indicator::OuterRace | Indicator::InnerRace);
    if race != table.has("bearing") {
        return Err(table.fail(
            if race { "no bearing" } else { "a bearing" },
            "bearing = \"NAME\" with indicator = \"outer-race\" or \"inner-race\", and only there",
        ));
    }
    let comparable = matches!(indicator, Indicator::Residual | Indicator::OneX | Indicator::TwoX) || race;
    let allowed = match (table.optional("max"), table.optional("growth_db")) {
        (Some(max), None) if indicator.is_length() => Allowed::Most(max.quantity()?),
        (Some(max), None) => Allowed::Most(max.number("a number above 0")?),
        (None, Some(growth)) if comparable => {
            let decibels = growth.number("decibels over the baseline, above 0")?;
            Allowed::Growth(10_f64.powf(decibels / 20.0))
        }
        (None, Some(growth)) => {
            let expected = "only with indicator = \"residual\", \"1X\", \"2X\", \"outer-race\" or \"inner-race\"; give max instead";
            return Err(growth.misplaced(expected));
        }
        _ => return Err(table.fail("neither or both of max and growth_db", "exactly one of them")),
    };
    let text = |key: &str| table.read(key, |n| Ok(n.text("a name")?.to_owned()));
    let share = "0 or more and below 1 (part of the limit)";
    let hysteresis = table.read("hysteresis", |n| n.number(share))?;
    let duration = table.optional_quantity("duration")?;
    Ok(Limit {
        indicator,
        probe: text("probe")?,
        bearing: text("bearing")?,
        allowed,
        hysteresis: hysteresis.unwrap_or(0.1),
        duration: duration.unwrap_or(0.0),
    })
}

fn observer(node: &Node<'_>) -> Read<Observer> {
    // The former name of the key.
    const FORMER: &str = "wander";
    let table = node.table()?;
    let key = if table.has(FORMER) { FORMER } else { "process_noise" };
    if let Some(both) = table.optional("process_noise").filter(|_| key == FORMER) {
        return Err(both.misplaced("either process_noise or its former name `wander`"));
    }
    let process_noise = table.read(key, |n| n.number("a number above 0, in N per root second"))?;
    Ok(Observer { process_noise })
}

/// Returns the name of a scene without `name`: that of the file.
fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

fn shaft(node: &Node<'_>) -> Read<Shaft> {
    let table = node.table()?;
    let outer = table.optional_quantity("outer_speed")?;
    Ok(Shaft { speed: speed(&table.required("speed", SPEEDS)?)?, outer_speed: outer.unwrap_or(0.0) })
}

fn speed(node: &Node<'_>) -> Read<Speed> {
    if !node.is_table() {
        return node.quantity().map(Speed::Constant);
    }
    let table = node.table()?;
    let named = |keys: &[&str]| keys.iter().any(|key| table.has(key));
    match (named(&["from", "to", "over"]), named(&["mean", "fluctuation", "frequency"])) {
        (true, false) => speed_ramp(&table),
        (false, true) => speed_fluctuating(&table),
        _ => Err(node.refuse(SPEEDS)),
    }
}

fn speed_ramp(table: &Table<'_>) -> Read<Speed> {
    Ok(Speed::Ramp { from: table.quantity("from")?, to: table.quantity("to")?, over: table.quantity("over")? })
}

fn speed_fluctuating(table: &Table<'_>) -> Read<Speed> {
    let range = "0 or more and below 1 (part of the mean speed)";
    Ok(Speed::Fluctuating {
        mean: table.quantity("mean")?,
        fluctuation: table.required("fluctuation", range)?.number(range)?,
        frequency: table.quantity("frequency")?,
    })
}

fn system(node: &Node<'_>, root: &Table<'_>, scene: &Path) -> Read<System> {
    if root.has("rotor") {
        return Err(node.fail("both [rotor] and [system]", "one of them: a system has its rotor in its matrices"));
    }
    let table = node.table()?;
    let expected = "the name of a Matrix Market or NPY file, relative to the scene's folder";
    let file = |n: &Node<'_>| Ok(scene.parent().unwrap_or(Path::new("")).join(n.text(expected)?));
    let unbalances = |n: &Node<'_>| {
        let list = n.list("a list of tables { moment, angle, x, y }")?;
        list.iter().map(system_unbalance).collect::<Read<Vec<_>>>()
    };
    Ok(System {
        mass: file(&table.required("mass", expected)?)?,
        damping: table.read("damping", file)?,
        gyroscopic: table.read("gyroscopic", file)?,
        stiffness: file(&table.required("stiffness", expected)?)?,
        load: table.read("load", file)?,
        proportional_damping: table.optional_quantity("proportional_damping")?.unwrap_or(0.0),
        unbalance: table.read("unbalance", unbalances)?.unwrap_or_default(),
    })
}

fn system_unbalance(node: &Node<'_>) -> Read<SystemUnbalance> {
    let table = node.table()?;
    let expected = "the number of a coordinate, 1 for the first";
    let coordinate = |key: &str| -> Read<usize> {
        let node = table.required(key, expected)?;
        usize::try_from(node.integer(expected)? - 1).map_err(|_| node.refuse(expected))
    };
    Ok(SystemUnbalance {
        moment: table.quantity("moment")?,
        angle: table.quantity("angle")?,
        at: [coordinate("x")?, coordinate("y")?],
    })
}

fn bearings<'a>(root: &Table<'a>, catalogue: &'a [Option<Expansion>]) -> Read<Vec<Bearing>> {
    let expected = "at least one table [[bearing]], in double brackets";
    let node = root.required("bearing", expected)?;
    let mut bearings: Vec<Bearing> = Vec::new();
    for (node, expansion) in node.list(expected)?.iter().zip(catalogue) {
        let table = bearing::table(node)?;
        let table = match (expansion, table.optional(bearing::DESIGNATION)) {
            (Some(expansion), Some(key)) => table.with_defaults(&expansion.defaults, &key),
            _ => table,
        };
        let mut bearing = bearing::read(&table, root)?;
        bearing.catalogue = expansion.as_ref().map(|expansion| expansion.used.clone());
        mounting::read(&table, &mut bearing)?;
        lubrication::read(&table, &mut bearing)?;
        if let Some(other) = bearings.iter().position(|b| b.name == bearing.name) {
            let own = format!("a name of its own (bearing[{other}] has this one)");
            return Err(table.required("name", &own)?.repeated(own));
        }
        bearings.push(bearing);
    }
    if bearings.is_empty() {
        return Err(node.refuse(expected));
    }
    Ok(bearings)
}
