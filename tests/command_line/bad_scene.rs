//! Scenes that are wrong: exit code 2 and one line with file, line, key, the value found and the values expected.

use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, Sandbox, scene, short_recording, swap};

/// Every command that reads a scene, with every output that it has.
const COMMANDS: [&[&str]; 3] = [
    &["replay", "scene.toml", "--report", "report.html", "--forces", "forces.csv"],
    &["force", "scene.toml", "--bearing", "DE", "--displacements", "u.csv"],
    &["simulate", "scene.toml", "--duration", "0.1 s", "--rate", "1 kHz", "-o", "motion.csv"],
];

/// Every command rejects this scene with one line that has all `parts`.
fn refused(scene: impl AsRef<[u8]>, parts: &[&str]) {
    let sandbox = Sandbox::rig();
    sandbox.put("scene.toml", scene);
    sandbox.put("u.csv", "u,v,w,thu,thv\n0,0,6e-5,0,0\n");
    for command in COMMANDS {
        sandbox.refused(command, 2, parts);
    }
}

/// Every command rejects the demonstration's scene with `to` instead of `from`, naming that line.
fn refused_with(from: &str, to: &str, parts: &[&str]) {
    let line = 1 + DEMO_SCENE[..DEMO_SCENE.find(from).unwrap()].matches('\n').count();
    let place = format!("scene.toml:{line}: ");
    refused(scene(&[(from, to)]), &[&[place.as_str()], parts].concat());
}

#[test]
fn the_commands_accept_the_unchanged_scene() {
    let sandbox = Sandbox::rig();
    sandbox.put("u.csv", "u,v,w,thu,thv\n0,0,6e-5,0,0\n");
    for command in COMMANDS {
        sandbox.done(command);
    }
    assert_eq!(
        sandbox.files(),
        ["forces.csv", "healthy.csv", "motion.csv", "report.html", "scene.toml", "u.csv"],
        "outputs and nothing besides"
    );
}

#[test]
fn missing() {
    let sandbox = Sandbox::empty();
    for command in COMMANDS {
        sandbox.refused(command, 2, &["scene.toml: no file of this name, expected a scene file"]);
    }
}

#[test]
fn folder() {
    let sandbox = Sandbox::empty();
    std::fs::create_dir(sandbox.path("scene.toml")).unwrap();
    for command in COMMANDS {
        sandbox.refused(command, 2, &["scene.toml: a directory, expected a scene file"]);
    }
}

#[test]
fn empty() {
    refused("", &["scene.toml: an empty file, expected a scene file (TOML text with at least [shaft]"]);
}

#[test]
fn nothing_but_comments() {
    refused("\n# later\n", &["scene.toml: an empty file, expected a scene file"]);
}

#[test]
fn binary() {
    refused([0x7f, b'E', b'L', b'F', 0xff, 0xfe, 0, 0], &["scene.toml:1: bytes that are not UTF-8 text"]);
}

#[test]
fn recording_instead() {
    refused(short_recording(300), &["scene.toml:1: ", "not TOML at \"time_s,DE_X_um,"]);
    let large: String = std::iter::repeat_n(HEALTHY_RECORDING, 8).collect();
    refused(large, &["scene.toml: a file of more than 4 MiB, expected a scene file"]);
}

#[test]
fn toml_of_something_else() {
    let manifest = "[package]\nname = \"pump\"\nversion = \"0.1.0\"\n";
    refused(
        manifest,
        &[
            "scene.toml:1: package: unknown key, expected one of name, shaft, rotor, system, bearing, machine, recording, integration",
        ],
    );
}

#[test]
fn broken_toml() {
    refused(swap(DEMO_SCENE, "mass = \"6 kg\"", "mass = \"6 kg"), &["scene.toml:9: not TOML at \"mass = \\\"6 kg\""]);
}

#[test]
fn unknown_key_with_a_hint() {
    let hint =
        "bearing[0].ball_daimeter: unknown key (did you mean ball_diameter?), expected one of name, bearing, station";
    refused_with("ball_diameter =", "ball_daimeter =", &[hint]);
}

#[test]
fn unknown_key_like_no_other() {
    refused_with("mass = \"6 kg\"", "colour = \"red\"", &["rotor.colour: unknown key, expected one of mass, "]);
}

#[test]
fn unknown_key_at_the_top() {
    refused_with("[shaft]", "[shafts]", &["shafts: unknown key (did you mean shaft?), expected one of name, shaft"]);
}

#[test]
fn missing_key() {
    refused(scene(&[("mass = \"6 kg\"\n", "")]), &["scene.toml:8: rotor.mass: missing key, expected a mass above 0"]);
}

#[test]
fn missing_table() {
    refused(
        scene(&[("[shaft]\nspeed = \"3000 rpm\"\n", "")]),
        &["scene.toml:1: shaft: missing key, expected a table [shaft]"],
    );
}

#[test]
fn unknown_unit() {
    refused_with(
        "6 kg",
        "6 lbs",
        &["rotor.mass: invalid value: \"6 lbs\" (\"lbs\" is no known unit), expected a mass"],
    );
}

#[test]
fn unit_of_another_dimension() {
    refused_with(
        "6 kg",
        "6 mm",
        &["rotor.mass: invalid value: \"6 mm\" (a length), expected a mass, such as \"6 kg\""],
    );
}

#[test]
fn probe_in_a_unit_that_is_no_length() {
    let wants = "recording.probes[0].unit: invalid value: \"furlong\" (\"furlong\" is no known unit), expected a unit of length: um";
    refused_with("unit = \"um\"", "unit = \"furlong\"", &[wants]);
    let wants = "recording.probes[0].sensitivity: missing key, expected a voltage per length of a column in volts";
    refused_with("unit = \"um\"", "unit = \"V\"", &[wants]);
}

#[test]
fn negative_mass() {
    refused_with("6 kg", "-6 kg", &["rotor.mass: invalid value: \"-6 kg\", expected a mass above 0, such as \"6 kg\""]);
}

#[test]
fn mass_that_is_no_number() {
    refused_with("\"6 kg\"", "nan", &["rotor.mass: invalid value: nan, expected a mass above 0, such as \"6 kg\""]);
}

#[test]
fn number_of_elements() {
    for count in ["0", "1", "2", "200", "-9", "9.5", "\"nine\""] {
        let wants = format!("bearing[0].elements: invalid value: {count}, expected a whole number from 3 to 64");
        refused_with("elements = 9", &format!("elements = {count}"), &[&wants]);
    }
}

#[test]
fn elements_that_do_not_fit_on_the_pitch_circle() {
    let wants = "bearing[0].elements: invalid value: 16, expected 3 to 15: more balls of this ball_diameter do not fit";
    refused_with("elements = 9", "elements = 16", &[wants]);
}

#[test]
fn conformity_below_one_half() {
    let wants = "bearing[0].inner_conformity: invalid value: 0.49, expected a number above 0.5 and at most 1";
    refused_with("inner_conformity = 0.52", "inner_conformity = 0.49", &[wants]);
}

#[test]
fn clearance_wider_than_the_grooves() {
    let wants = "bearing[0].diametral_clearance: invalid value: \"10 mm\", expected a length from 0 to below 317.6 um";
    refused_with("\"10 um\"", "\"10 mm\"", &[wants]);
}

#[test]
fn two_bearings_of_one_name() {
    refused_with(
        "\"NDE\"",
        "\"DE\"",
        &["bearing[1].name: repeated value: \"DE\", expected a name of its own (bearing[0] has this"],
    );
}

#[test]
fn effects_where_no_model_has_them() {
    let text = scene(&[("poissons_ratio = 0.3", "poissons_ratio = 0.3\neffects = [\"film\"]")]);
    refused(
        text,
        &["scene.toml:29: bearing[0].effects: misplaced key: [\"film\"], expected only with model = \"quasi-static\""],
    );
}

#[test]
fn film_without_oil() {
    let text = scene(&[("model = \"angular\"", "model = \"quasi-static\"\neffects = [\"film\"]")]);
    refused(text, &["bearing[0].lubricant: missing key", "viscosity = \"0.04 Pa s\""]);
}

#[test]
fn a_rotor_that_replay_does_not_take() {
    let sandbox = Sandbox::with(&swap(DEMO_SCENE, "\"angular\"", "\"dynamic\""), &short_recording(600));
    let wants = "scene.toml: bearing DE: model = \"dynamic\" in replay, expected another model";
    sandbox.refused(&["replay", "scene.toml", "--report", "report.html"], 2, &[wants]);
}

/// `replay` rejects the demonstration's scene with these probes, naming `why`.
fn not_observable(probes: &[(&str, &str, &str)], why: &str) {
    let entry = |(column, station, angle): &(&str, &str, &str)| {
        format!("{{ column = \"{column}\", unit = \"um\", station = \"{station}\", angle = \"{angle}\" }}")
    };
    let list: Vec<String> = probes.iter().map(entry).collect();
    let (before, rest) = DEMO_SCENE.split_once("probes = [").unwrap();
    let (_, after) = rest.split_once("]\n").unwrap();
    let sandbox = Sandbox::with(&format!("{before}probes = [{}]\n{after}", list.join(", ")), &short_recording(600));
    let found = "scene.toml: recording.probes: probes that do not determine the shaft's position: ";
    let expected = "expected two planes, each with two directions that are not parallel";
    sandbox.refused(COMMANDS[0], 2, &[found, why, expected]);
}

#[test]
fn two_probes_in_one_direction() {
    not_observable(
        &[("DE_X_um", "-120 mm", "30 deg"), ("NDE_X_um", "120 mm", "30 deg")],
        "all 2 radial probes measure along 30.0 deg, so the motion across it is not observable",
    );
}

#[test]
fn opposite_probe_directions_are_parallel() {
    let de = [("DE_X_um", "-120 mm", "0 deg"), ("DE_Y_um", "-120 mm", "180 deg")];
    let nde = [("NDE_X_um", "120 mm", "0 deg"), ("NDE_Y_um", "120 mm", "-180 deg")];
    not_observable(&[de, nde].concat(), "so the motion across it is not observable");
}

#[test]
fn all_probes_in_one_plane() {
    let first = [("DE_X_um", "-120 mm", "0 deg"), ("DE_Y_um", "-120 mm", "90 deg")];
    let more = [("NDE_X_um", "-120 mm", "45 deg"), ("NDE_Y_um", "-120 mm", "135 deg")];
    let why = "all radial probes are in one plane at -120.0 mm, so the tilt is not observable";
    not_observable(&first, why);
    not_observable(&[first, more].concat(), why);
}

#[test]
fn three_probes() {
    let three = [("DE_X_um", "-120 mm", "0 deg"), ("DE_Y_um", "-120 mm", "90 deg"), ("NDE_X_um", "120 mm", "0 deg")];
    not_observable(&three, "3 radial probes do not determine the motion");
}
