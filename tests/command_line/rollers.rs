//! Commands on machines with roller bearings.

use crate::support::{Sandbox, list, number, swap};
use serde_json::Value;

/// A rotor on a 6205 and an NU205 whose rollers have 5 laminae.
const SCENE: &str = r#"
name = "rollers"
[shaft]
speed = "1500 rpm"
[rotor]
mass = "12 kg"
diametral_inertia = 0.06
polar_inertia = 0.02
damping = [800, 800, 800, 1, 1]
unbalance = [{ moment = "60 g mm", angle = "40 deg", station = "20 mm" }]
[[bearing]]
name = "DE"
station = "-100 mm"
bearing = "6205"
diametral_clearance = "10 um"
[[bearing]]
name = "NDE"
station = "100 mm"
bearing = "NU205"
laminae = 5
radial_play = "8 um"
[recording]
file = "run.csv"
rate = "12.8 kHz"
keyphasor = { column = "kp", pulses_per_turn = 1 }
probes = [
  { column = "D1", unit = "um", station = "-120 mm", angle = "45 deg", noise = "0.05 um" },
  { column = "D2", unit = "um", station = "-120 mm", angle = "135 deg", noise = "0.05 um" },
  { column = "N1", unit = "um", station = "120 mm", angle = "45 deg", noise = "0.05 um" },
  { column = "N2", unit = "um", station = "120 mm", angle = "135 deg", noise = "0.05 um" },
]
"#;

/// A sandbox with the scene and twenty turns of `machine`.
fn recorded(machine: &str) -> Sandbox {
    let duration = if machine.contains("3000 rpm") { "0.4 s" } else { "0.8 s" };
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    sandbox.put("machine.toml", machine);
    let args =
        ["simulate", "machine.toml", "--as-recording", "--duration", duration, "--settle", "0.4 s", "-o", "run.csv"];
    sandbox.done(&args);
    sandbox
}

/// The play of rollers is a clearance that the diagnosis names, with its size.
#[test]
fn another_clearance_of_rollers_is_named() {
    let outcome = recorded(&swap(SCENE, "\"8 um\"", "\"14 um\"")).replay("scene.toml", &[]);
    let [finding] = list(&outcome, "findings") else { panic!("{}", outcome["findings"]) };
    assert_eq!((&finding["kind"], &finding["bearing"]), (&"clearance".into(), &"NDE".into()));
    let found = number(finding, "/clearance_um/value");
    assert!((found - 28.0).abs() < 0.5, "{found}");
}

/// Damage of a roller of a catalogue bearing has its line, although the scene names no model.
#[test]
fn a_spall_on_a_roller_is_named() {
    let spall = "radial_play = \"8 um\"\ndefect = [{ surface = \"element\", azimuth = \"30 deg\", half_width = \"6 deg\", depth = \"3 um\", shape = \"half-sine\", element = 3 }]";
    let outcome = recorded(&swap(SCENE, "radial_play = \"8 um\"", spall)).replay("scene.toml", &[]);
    let [finding] = list(&outcome, "findings") else { panic!("{}", outcome["findings"]) };
    assert_eq!((&finding["kind"], &finding["bearing"]), (&"element".into(), &"NDE".into()));
    assert!((number(finding, "/depth_um/value") - 3.0).abs() < 1.0, "{finding}");
}

/// Balls and rollers each have the models that are theirs.
#[test]
fn balls_and_rollers_in_one_trade() {
    let found: Value = recorded(SCENE).done(&["trade", "scene.toml", "--forces-only", "--format", "json"]).json();
    assert!(found["truth"].as_str().is_some_and(|truth| truth.starts_with("quasi-static")), "{}", found["truth"]);
    let names: Vec<String> = list(&found, "candidates").iter().map(|one| one["model"].to_string()).collect();
    for name in ["linear", "lumped", "angular", "roller, 11 laminae", "tabulated 8 x 8"] {
        assert!(names.iter().any(|found| found.contains(name)), "{name}: {names:?}");
    }
    assert_eq!(list(&found, "impossible"), &[] as &[Value], "{}", found["impossible"]);
}

/// A thrust that no bearing carries is named by its direction.
#[test]
fn a_thrust_on_cylindrical_rollers_has_no_equilibrium() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", SCENE);
    let of = |load: &str| sandbox.run(&["equilibrium", "scene.toml", "--bearing", "NDE", "--load", load]);
    let thrust = of("0,-2000,300,0,0");
    assert!(thrust.code == Some(1) && thrust.out.contains("unsupported along Z."), "{thrust:?}");
    assert!(of("0,-2000,0,5,0").code == Some(0));
}

/// Without tilt the pressure along a roller is drawn symmetrically.
#[test]
fn the_pressure_along_a_roller_is_drawn_symmetrically() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", swap(SCENE, "laminae = 5", "laminae = 30"));
    let text = sandbox.done(&["equilibrium", "scene.toml", "--bearing", "NDE", "--load", "0,-2000,0,0,0"]).out;
    let (_, drawn) = text.split_once("pressure along roller").unwrap();
    let lines: Vec<Vec<&str>> = drawn.lines().skip(1).map(|line| line.split_whitespace().collect()).collect();
    let pressures: Vec<(usize, f64)> = lines
        .iter()
        .take_while(|words| words.get(2) == Some(&"MPa"))
        .map(|words| (words[0].parse().unwrap(), words[1].parse().unwrap()))
        .collect();
    assert_eq!(pressures.len(), 15, "{drawn}");
    for ((lamina, pressure), (other, opposite)) in pressures.iter().zip(pressures.iter().rev()).take(7) {
        assert!(lamina + other == 31 && (pressure - opposite).abs() <= 1.0, "{drawn}");
    }
}

/// An outer ring that is turned by a positive angle about X is nearer to a shaft that its weight presses down at the end towards -Z, and shortens the
/// life.
#[test]
fn a_tilted_outer_ring_loads_one_end_of_the_rollers() {
    let sandbox = Sandbox::empty();
    let with = |tilt: f64| {
        let laminae = format!("laminae = 30\nouter_ring_tilt = [\"{tilt} mrad\", 0]");
        sandbox.put("scene.toml", swap(SCENE, "laminae = 5", &laminae));
        let found: Value = sandbox.done(&["equilibrium", "scene.toml", "--format", "json"]).json();
        let rollers = list(&found, "elements").iter().filter(|one| one["bearing"] == "NDE");
        let loads = |one: &Value| list(&one["roller"], "lamina_loads").iter().map(|x| x.as_f64().unwrap()).collect();
        let loads: Vec<Vec<f64>> = rollers.map(loads).collect();
        let at = |k: usize| loads.iter().map(|of| of[k]).sum::<f64>();
        let [towards_minus_z, towards_plus_z]: [f64; 2] = [(0..15).map(at).sum(), (15..30).map(at).sum()];
        let life = found["bearings"][1]["life"]["reference_life"].as_f64().unwrap();
        (towards_minus_z / (towards_minus_z + towards_plus_z), life)
    };
    let [tilted, aligned, other_way] = [1.0, 0.0, -1.0].map(with);
    assert!(tilted.0 > 0.7 && (aligned.0 - 0.5).abs() < 0.02, "{tilted:?}, {aligned:?}");
    assert!((tilted.0 + other_way.0 - 1.0).abs() < 0.02, "{tilted:?}, {other_way:?}");
    assert!(tilted.1 < 0.9 * aligned.1 && other_way.1 < 0.9 * aligned.1, "{tilted:?}, {aligned:?}, {other_way:?}");
}

/// The columns of `check` line up with the longest name of a model.
#[test]
fn check_aligns_its_columns() {
    let sandbox = recorded(SCENE);
    sandbox.put("scene.toml", swap(SCENE, "laminae = 5", "model = \"quasi-static\""));
    let text = sandbox.done(&["check", "scene.toml"]).out;
    let ends: Vec<usize> =
        text.lines().skip_while(|line| !line.contains("designation")).take(3).map(|line| line.len()).collect();
    assert!(ends.len() == 3 && ends.iter().all(|end| *end == ends[0]), "{text}");
}

/// A baseline has the clearance of the rollers of its machine.
#[test]
fn the_clearance_of_rollers_is_learned() {
    let changes = [
        ("\"1500 rpm\"", "\"3000 rpm\""),
        ("\"60 g mm\"", "\"900 g mm\""),
        ("probes = [", "probes = [\n{ column = \"A\", unit = \"um\", axial = true, noise = \"0.05 um\" },"),
        ("damping =", "load = [0, \"-600 N\", \"60 N\", 0, 0]\ndamping ="),
    ];
    let machine = changes.iter().fold(SCENE.to_owned(), |text, (from, to)| swap(&text, from, to));
    let sandbox = recorded(&machine);
    sandbox.put("scene.toml", swap(&machine, "\"8 um\"", "\"8.6 um\""));
    sandbox.done(&["replay", "scene.toml", "--learn", "b.json"]);
    let learned: Value = serde_json::from_str(&sandbox.read("b.json")).unwrap();
    let of_rollers = |p: &&Value| p["name"] == "diametral_clearance" && p["bearing"] == "NDE";
    let clearance = learned.pointer("/calibration/parameters").unwrap().as_array().unwrap().iter().find(of_rollers);
    let found = number(clearance.unwrap(), "/value");
    assert!((found - 16e-6).abs() < 0.1e-6, "{found}");
}
