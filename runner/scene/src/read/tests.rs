use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

use super::super::{Axial, Defect, DefectShape, Facing, FreeAngle, Geometry, Law, Linear, Model, Support};
use super::*;
use crate::{Clock, RotationSource};

/// Each `[[bearing]]`.
mod bearing;
/// Fits and temperatures.
mod mounting;
/// The `[recording]`.
mod recording;
/// Files and texts that are no scene.
mod text;

/// The example of the scene format with the keys that this version has.
const SPINDLE: &str = r#"name = "spindle"

[shaft]
speed = "10000 rpm"
outer_speed = "0 rpm"

[rotor]
mass = "6 kg"
diametral_inertia = 0.030
polar_inertia = 0.006
damping = [400, "400 N s/m", 400, 0.4, "0.4 N m s/rad"]
proportional_damping = 1e-5
stiffness = [0, 0, 0, 0, "1 N m"]
gravity = [0.0, "-9.81 m/s^2", 0.0]
load = [0.0, 0.0, "60 N", 0.0, 0.0]
unbalance = [{ moment = "120 g mm", angle = "17 deg", station = "20 mm" }]

[[bearing]]
name = "DE"
station = "-100 mm"
facing = "+z"
model = "angular"
elements = 16
first_element_azimuth = "0 deg"
cage_ratio = 0.4
ball_diameter = "22.23 mm"
pitch_diameter = "125.26 mm"
inner_conformity = 0.5232
outer_conformity = 0.5232
contact_angle = "40 deg"
youngs_modulus = "206 GPa"
poissons_ratio = 0.3
density = 7800
defect = [{ surface = "outer", azimuth = "-90 deg", half_width = "2.9 deg", depth = "3 um", shape = "half-sine" }]

[[bearing]]
name = "NDE"
station = "100 mm"
model = "lumped"
elements = 9
cage_ratio = 0.38
stiffness = "1.2e10 N/m^1.5"
exponent = 1.5
radial_play = "5 um"
axial = { stiffness = 1.0e9, exponent = 1.5, play = "0 um", radius = "20 mm" }

[[bearing]]
name = "middle"
station = 0
model = "linear"
elements = 8
linearise = "lumped"
stiffness = 1e9
radial_play = "-1 um"

[recording]
file = "healthy.csv"
rate = "12.8 kHz"
probes = [
  { column = "DE_X_um", unit = "um", station = "-120 mm", angle = "0 deg", noise = "0.2 um" },
  { column = "axial_um", unit = "um", axial = true },
]
keyphasor = { column = "keyphasor", pulses_per_turn = 1 }
"#;

/// The least scene, with room for more keys in each table.
const MINIMAL: &str = r#"[shaft]
speed = 100
[[bearing]]
name = "A"
station = 0
model = "angular"
elements = 8
ball_diameter = "10 mm"
pitch_diameter = "50 mm"
inner_conformity = 0.52
outer_conformity = 0.53
contact_angle = "15 deg"
"#;

const LUMPED: &str = r#"[shaft]
speed = 100
[[bearing]]
name = "A"
station = 0
model = "lumped"
elements = 8
cage_ratio = 0.4
stiffness = 1e10
radial_play = "5 um"
"#;

const RECORDING: &str = r#"[recording]
file = "a.csv"
rate = 1000
probes = [{ column = "x", unit = "um", station = 0, angle = 0 }]
"#;

const ROTOR: &str = "[rotor]\nmass = 1\ndiametral_inertia = 1\npolar_inertia = 1\n";

fn read(text: &str) -> Read<Scene> {
    read_str(text, Path::new("machines/pump.toml"))
}

/// `text` with one piece replaced.
fn with(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from} is not in the text");
    text.replacen(from, to, 1)
}

fn refusal(text: &str) -> String {
    let error = read(text).unwrap_err();
    let shown = error.to_string();
    assert!(!shown.contains('\n'), "{shown}");
    assert!(shown.starts_with("machines/pump.toml:"), "{shown}");
    shown
}

/// Each case: a piece of the text, what stands there instead, and parts of the error.
fn assert_refused(text: &str, cases: &[(&str, &str, &[&str])]) {
    assert!(read(text).is_ok(), "{:?}", read(text));
    for (from, to, parts) in cases {
        let shown = refusal(&with(text, from, to));
        for part in *parts {
            assert!(shown.contains(part), "{from} -> {to}:\n{shown}\nlacks {part}");
        }
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs()
}

#[test]
fn the_whole_example_reads() {
    let scene = read(SPINDLE).unwrap();
    assert_eq!(scene.name, "spindle");
    assert_eq!(scene.path, Path::new("machines/pump.toml"));
    assert!(matches!(scene.shaft, Shaft { speed: Speed::Constant(w), outer_speed: 0.0 } if near(w, PI * 1000.0 / 3.0)));
    let rotor = scene.rotor.unwrap();
    assert_eq!((rotor.mass, rotor.diametral_inertia, rotor.polar_inertia), (6.0, 0.03, 0.006));
    assert_eq!(rotor.damping, [400.0, 400.0, 400.0, 0.4, 0.4]);
    assert_eq!(rotor.proportional_damping, 1e-5);
    assert_eq!(rotor.stiffness, [0.0, 0.0, 0.0, 0.0, 1.0]);
    assert_eq!(rotor.gravity, [0.0, -9.81, 0.0]);
    assert_eq!(rotor.load, [0.0, 0.0, 60.0, 0.0, 0.0]);
    let [unbalance] = rotor.unbalance.as_slice() else { unreachable!("one unbalance") };
    assert!(near(unbalance.moment, 120e-6) && near(unbalance.station, 0.02));
    assert!(near(unbalance.angle, 17.0 * PI / 180.0));
    let [de, nde, middle] = scene.bearings.as_slice() else { unreachable!("three bearings") };
    assert_angular_bearing(de);
    assert_lumped_bearing(nde);
    assert_eq!(middle.linear, Some(Linear::Of(Model::Lumped)));
    assert_eq!(middle.cage_ratio, None);
    assert_eq!(middle.law.unwrap().stiffness, Some(1e9));
    let recording = scene.recording.unwrap();
    assert_eq!(recording.file, Path::new("machines/healthy.csv"));
    assert_eq!(recording.clock, Clock::Rate(12800.0));
    let [radial, axial] = recording.probes.as_slice() else { unreachable!("two probes") };
    assert_eq!((radial.column.as_str(), radial.direction), ("DE_X_um", Direction::Radial(0.0)));
    assert!(near(radial.metres_per_unit, 1e-6) && near(radial.station, -0.12));
    assert!(near(radial.noise.unwrap(), 0.2e-6));
    assert_eq!((axial.station, axial.direction, axial.noise), (0.0, Direction::Axial, None));
    assert_eq!(recording.rotation, RotationSource::keyphasor("keyphasor", 1));
}

fn assert_angular_bearing(de: &Bearing) {
    assert_eq!((de.name.as_str(), de.facing, de.model), ("DE", Facing::PlusZ, Model::Angular));
    assert_eq!((de.elements, de.cage_ratio), (16, Some(0.4)));
    let Some(Geometry { ball_diameter, fit: FreeAngle::ContactAngle(angle), youngs_modulus, .. }) = de.geometry else {
        unreachable!("a contact angle")
    };
    assert!(near(ball_diameter, 22.23e-3) && near(angle, 40.0 * PI / 180.0));
    assert!(near(youngs_modulus, 206e9));
    assert!(de.law.is_none() && de.axial.is_none() && de.linear.is_none());
    let [Defect { azimuth, depth, shape, .. }] = de.defect.as_slice() else { unreachable!("one defect") };
    assert!(near(*azimuth, -FRAC_PI_2) && near(*depth, 3e-6));
    assert_eq!(*shape, DefectShape::HalfSine);
}

fn assert_lumped_bearing(nde: &Bearing) {
    assert_eq!((nde.facing, nde.geometry), (Facing::Both, None));
    let law = Law { stiffness: Some(1.2e10), exponent: 1.5, radial_play: Some(5.0 * 1e-6) };
    assert_eq!(nde.law, Some(law));
    let axial = Axial { stiffness: 1e9, exponent: 1.5, play: 0.0, radius: 20.0 * 1e-3 };
    assert_eq!(nde.axial, Some(axial));
}

#[test]
fn defaults_are_those_of_the_format() {
    let scene = read(&format!("{MINIMAL}{ROTOR}{RECORDING}")).unwrap();
    assert_eq!(scene.name, "pump", "a scene without a name is called as its file");
    assert_eq!(scene.shaft.outer_speed, 0.0);
    let rotor = scene.rotor.unwrap();
    assert_eq!(rotor.gravity, [0.0, -9.80665, 0.0]);
    assert_eq!((rotor.damping, rotor.load), ([0.0; 5], [0.0; 5]));
    assert!(rotor.unbalance.is_empty());
    let bearing = scene.bearings.first().unwrap();
    assert_eq!((bearing.facing, bearing.first_element_azimuth), (Facing::Both, 0.0));
    let geometry = bearing.geometry.unwrap();
    assert_eq!((geometry.youngs_modulus, geometry.poissons_ratio), (206e9, 0.3));
    assert_eq!(scene.recording.unwrap().rotation, RotationSource::Scene);
    let law = read(LUMPED).unwrap().bearings.first().unwrap().law.unwrap();
    assert_eq!(law.exponent, 1.5);
}

#[test]
fn every_notation_of_toml_reads_the_same() {
    let inline = read(MINIMAL).unwrap();
    let dotted = with(MINIMAL, "[shaft]\nspeed = 100\n", "shaft.speed = 100.0\n");
    assert_eq!(read(&dotted), Ok(inline.clone()));
    let marked = format!("\u{feff}{}", MINIMAL.replace('\n', "\r\n"));
    assert_eq!(read(&marked), Ok(inline));
    let unbalance = "{ moment = 1, angle = 0, station = 0 }";
    let list = format!("{MINIMAL}{ROTOR}unbalance = [{unbalance}]\n");
    let headers = format!("{MINIMAL}{ROTOR}[[rotor.unbalance]]\nmoment = 1\nangle = 0\nstation = 0\n");
    assert_eq!(read(&list), read(&headers));
    assert!(read(&list).is_ok());
    let shaft = "shaft = { speed = 1 }\nbearing = [{ name = \"A\", station = 0, model = \"lumped\", elements = 3, \
                 cage_ratio = 0, stiffness = 1e9, radial_play = 0 }]";
    assert!(read(shaft).is_ok());
}

#[test]
#[rustfmt::skip] // a table
fn speeds() {
    let speed = |text: &str| read(&with(MINIMAL, "speed = 100", text)).map(|s| s.shaft.speed);
    let ramp = speed("speed = { from = 0, to = \"10 rad/s\", over = \"500 ms\" }").unwrap();
    assert_eq!(
        ramp,
        Speed::Ramp {
            from: 0.0,
            to: 10.0,
            over: 0.5
        }
    );
    let fluctuating = Speed::Fluctuating {
        mean: -3.0,
        fluctuation: 0.02,
        frequency: 7.0,
    };
    assert_eq!(
        speed("speed = { mean = -3, fluctuation = 0.02, frequency = \"7 Hz\" }"),
        Ok(fluctuating)
    );
    assert_refused(
        MINIMAL,
        &[
            ("speed = 100", "speed = {}", &[":2: shaft.speed: invalid value: {}", "{ from, to, over }"]),
            ("speed = 100", "speed = { from = 1, mean = 2 }", &["shaft.speed", "or { mean"]),
            ("speed = 100", "speed = { from = 1, to = 2 }", &["shaft.speed.over", "a time above 0"]),
            ("speed = 100", "speed = { from = 1, to = 2, over = 0 }", &["invalid value: 0 (a bare number is in s)"]),
            ("speed = 100", "speed = { mean = 1, fluctuation = 1, frequency = 1 }", &["below 1"]),
            ("speed = 100", "speed = { mean = 1, fluctuation = 0, frequency = 0 }", &["a frequency above 0"]),
            ("speed = 100", "speed = \"50 Hz\"", &["invalid value: \"50 Hz\" (a frequency)", "Hz is not taken"]),
            ("speed = 100", "speed = nan", &["shaft.speed: invalid value: nan, expected a speed of rotation"]),
            ("speed = 100", "speed = -inf", &["shaft.speed: invalid value: -inf, expected"]),
            ("speed = 100", "speed = true", &["invalid value: true, expected a speed"]),
        ],
    );
}

#[test]
fn errors_name_file_line_and_key() {
    let text = with(SPINDLE, "inner_conformity = 0.5232", "inner_conformity = 0.49");
    assert_eq!(
        refusal(&text),
        "machines/pump.toml:28: bearing[0].inner_conformity: invalid value: 0.49, expected a number above 0.5 and at most 1 \
         (groove radius / ball diameter), usually 0.51 to 0.54"
    );
    let text = with(SPINDLE, "station = \"100 mm\"\n", "");
    assert_eq!(
        refusal(&text),
        "machines/pump.toml:36: bearing[1].station: missing key, expected a length, such as \"12.7 mm\" or \"5 um\""
    );
    let text = with(SPINDLE, "ball_diameter", "ball_daimeter");
    let shown = refusal(&text);
    assert!(shown.starts_with(
        "machines/pump.toml:26: bearing[0].ball_daimeter: unknown key (did you mean ball_diameter?), \
         expected one of name, bearing, station, facing"
    ));
    let text = with(SPINDLE, "unit = \"um\", axial", "unit = \"bit\", axial");
    let error = read(&text).unwrap_err();
    assert_eq!((error.line, error.key.as_str()), (Some(61), "recording.probes[1].unit"));
    assert_eq!(error.problem, Problem::InvalidValue);
    assert_eq!(error.found, "\"bit\" (\"bit\" is no known unit)");
    assert_eq!(error.expected, "a unit of length: um, mil, mm or m; or V or mV");
}

#[test]
#[rustfmt::skip] // a table
fn top_of_the_file() {
    assert_refused(
        MINIMAL,
        &[
            ("[shaft]\nspeed = 100\n", "", &[":1: shaft: missing key"]),
            ("speed = 100", "", &[":1: shaft.speed: missing key"]),
            ("[[bearing]]", "[bearing]", &["invalid value: a table", "[[bearing]]"]),
            ("[[bearing]]", "[[baering]]", &["did you mean bearing?"]),
            ("[shaft]", "colour = 1\n[shaft]", &["pump.toml:1: colour: unknown key, expected one of name, shaft"]),
            ("[shaft]", "name = 3\n[shaft]", &["name: invalid value: 3, expected a name"]),
            ("[shaft]", "name = \"\"\n[shaft]", &["name: invalid value: \"\""]),
            ("[shaft]", "\"a\\nb\" = 1\n[shaft]", &["unknown key"]),
            ("[shaft]\nspeed", "shaft", &["shaft: invalid value: 100, expected a table with the keys speed, outer_speed"]),
        ],
    );
    assert!(refusal("bearing = []\nshaft = { speed = 1 }").contains("bearing: invalid value: [], expected"));
    assert!(refusal("shaft = { speed = 1 }").contains("at least one table [[bearing]]"));
    let twice = with(SPINDLE, "name = \"NDE\"", "name = \"DE\"");
    assert!(
        refusal(&twice)
            .contains(":37: bearing[1].name: repeated value: \"DE\", expected a name of its own (bearing[0]")
    );
}

/// A bare number is in SI units; one that no machine has is most likely in the unit that people write.
#[test]
fn plain_number_in_another_unit() {
    for value in ["250", "-100.5"] {
        let error = refusal(&MINIMAL.replace("station = 0", &format!("station = {value}")));
        assert!(error.contains("(a bare number is in m), expected a length"), "{error}");
        assert!(error.ends_with(&format!("; likely \"{value} mm\"")), "{error}");
    }
    let error = refusal(&with(SPINDLE, "angle = \"0 deg\"", "angle = 90"));
    assert!(error.contains("90 (a bare number is in rad)") && error.ends_with("; likely \"90 deg\""), "{error}");
}

#[test]
fn a_former_key_is_read() {
    let noise = |keys: &str| read(&format!("{MINIMAL}\n[observer]\n{keys}\n")).unwrap().observer.process_noise;
    assert_eq!(noise("process_noise = 5"), Some(5.0));
    assert_eq!(noise("wander = 5"), Some(5.0));
    let both = refusal(&format!("{MINIMAL}\n[observer]\nprocess_noise = 5\nwander = 5\n"));
    assert!(both.contains("observer.process_noise: misplaced key"), "{both}");
}

#[test]
#[rustfmt::skip] // a table
fn rotor_out_of_range() {
    let text = format!("{MINIMAL}{ROTOR}load = [0, 0, 0, 0, 0]\n");
    assert_refused(
        &text,
        &[
            ("mass = 1", "mass = 0", &["rotor.mass: invalid value: 0 (a bare number is in kg), expected a mass above 0"]),
            ("mass = 1", "", &["rotor.mass: missing key"]),
            ("mass = 1", "mass = \"1 N\"", &["invalid value: \"1 N\" (a force), expected a mass"]),
            ("polar_inertia = 1", "polar_inertia = 2.1", &["at most twice diametral_inertia, here 2 kg m^2"]),
            ("polar_inertia = 1", "polar_inertia = -1", &["of 0 or more"]),
            ("load = [0, 0, 0, 0, 0]", "load = [0, 0, 0, 0]", &["rotor.load: a list of 4", "a list of 5"]),
            ("load = [0, 0, 0, 0, 0]", "load = 3", &["rotor.load: invalid value: 3"]),
            ("load = [0, 0, 0, 0, 0]", "load = [0, 0, 0, 0, \"1 N\"]", &["rotor.load[4]", "a moment"]),
            ("load = [0, 0, 0, 0, 0]", "load = [0, nan, 0, 0, 0]", &["rotor.load[1]: invalid value: nan"]),
            ("load = [0, 0, 0, 0, 0]", "damping = [0, -1, 0, 0, 0]", &["rotor.damping[1]", "of 0 or more"]),
            ("load = [0, 0, 0, 0, 0]", "stiffness = [0, 0, 0, -1, 0]", &["rotor.stiffness[3]"]),
            ("load = [0, 0, 0, 0, 0]", "gravity = [0, 0]", &["rotor.gravity: a list of 2"]),
            ("load = [0, 0, 0, 0, 0]", "proportional_damping = -1", &["a time of 0 or more"]),
            ("load = [0, 0, 0, 0, 0]", "unbalance = 1", &["rotor.unbalance: invalid value: 1"]),
            ("load = [0, 0, 0, 0, 0]", "unbalance = [1]", &["rotor.unbalance[0]: invalid value: 1, expected a table"]),
            ("load = [0, 0, 0, 0, 0]", "unbalance = [{ moment = -1, angle = 0, station = 0 }]", &["rotor.unbalance[0].moment", "of 0 or more"]),
        ],
    );
}
