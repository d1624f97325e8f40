//! Operating clearance by fits and temperatures, from the scene and from a temperature channel.

use crate::support::{DEMO_SCENE, DIAGNOSED, Sandbox, number, short_recording, swap};
use serde_json::Value;

const CLEARANCE: &str = "diametral_clearance = \"10 um\"\n";

/// The demonstration's scene; its drive-end bearing has 16 um before mounting and `keys`.
fn scene(keys: &str) -> String {
    swap(DEMO_SCENE, CLEARANCE, &format!("diametral_clearance = \"16 um\"\n{keys}\n"))
}

fn notes(outcome: &Value) -> String {
    let all = outcome["notes"].as_array().unwrap();
    all.iter().map(|note| note.as_str().unwrap()).collect::<Vec<_>>().join("\n")
}

/// 5 um on a solid shaft of steel grow the raceway by 5 * 25/31.1 um; 10 K and a pitch diameter of 39.04 mm take 4.68 um.
#[test]
fn every_command_reports_the_operating_clearance() {
    let fit = "fit = { shaft_interference = \"5 um\", bore = \"25 mm\", outside_diameter = \"52 mm\" }\n\
               temperatures = { inner = \"55 degC\", outer = \"45 degC\" }";
    let sandbox = Sandbox::with(&scene(fit), &short_recording(DIAGNOSED));
    let [by_fits, by_temperature] = [5.0 * 25.0 / 31.1, 12e-6 * 39.04e3 * 10.0];
    let expected = 16.0 - by_fits - by_temperature;
    for command in ["check", "equilibrium"] {
        let found = sandbox.done(&[command, "scene.toml", "--format", "json"]).json();
        let clearance = |key: &str| number(&found, &format!("/bearings/0/operating_clearance/{key}"));
        assert!((clearance("operating_um") - expected).abs() < 1e-9, "{command}");
        assert!((clearance("by_fits_um") - by_fits).abs() < 1e-9 && clearance("unmounted_um") == 16.0);
        assert!((clearance("by_temperature_um") - by_temperature).abs() < 1e-9);
        assert!(found.pointer("/bearings/1/operating_clearance").is_none());
        let text = sandbox.done(&[command, "scene.toml"]).out;
        assert!(text.contains("7.30 um: 16.00 um before mounting"), "{command}: {text}");
    }
    let outcome = sandbox.replay("scene.toml", &[]);
    assert!(notes(&outcome).contains("Bearing DE: operating clearance 7.30 um: 16.00 um before mounting, less 4.02 um by the fits and 4.68 um by temperature."));
    // The recording is of a machine with 10 um.
    let is_of_clearance = |f: &Value| f["kind"] == "clearance" && f["bearing"] == "DE";
    assert!(outcome["findings"].as_array().unwrap().iter().any(is_of_clearance), "{}", outcome["findings"]);
}

/// An inner ring that is 12.81 K hotter than the outer one takes the 6 um by which the clearance of the scene is too large.
#[test]
fn a_channel_corrects_the_clearance_of_a_replay() {
    let channels = "temperature = [\n{ column = \"T_outer\", unit = \"degC\", bearing = \"DE\", ring = \"outer\" },\n\
                    { column = \"T_inner\", unit = \"degC\", bearing = \"DE\", ring = \"inner\" },\n]\nkeyphasor = {";
    let cold = scene("temperatures = { inner = \"40 degC\", outer = \"40 degC\" }");
    let add = |(i, line): (usize, &str)| match i {
        0 => format!("{line},T_outer,T_inner\n"),
        _ => format!("{line},42.81,{}\n", 42.81 + 6.0 / (12e-6 * 39.04e3)),
    };
    let recording: String = short_recording(DIAGNOSED).lines().enumerate().map(add).collect();
    let sandbox = Sandbox::with(&cold, &recording);
    // At equal temperatures the bearing would carry no load.
    assert_eq!(sandbox.run(&["replay", "scene.toml", "--report", "r.html"]).code, Some(4));
    sandbox.put("scene.toml", swap(&cold, "keyphasor = {", channels));
    let outcome = sandbox.replay("scene.toml", &[]);
    assert_eq!(outcome["findings"].as_array().map(Vec::len), Some(0), "{}", outcome["findings"]);
    let notes = notes(&outcome);
    assert!(notes.contains("Bearing DE: operating clearance 10.00 um: 16.00 um before mounting"), "{notes}");
    assert!(notes.contains("T_outer: 42.8 degC in the mean"), "{notes}");
}

/// Two angular-contact bearings face to face, without load.
fn pair(keys: &str) -> String {
    let bearing = |name: &str, station: &str, facing: &str| {
        format!(
            "[[bearing]]\nname = \"{name}\"\nstation = {station}\nfacing = \"{facing}\"\nmodel = \"angular\"\nelements = 14\n\
             ball_diameter = 7e-3\npitch_diameter = 38.5e-3\ninner_conformity = 0.52\nouter_conformity = 0.52\n\
             contact_angle = \"25 deg\"\n{keys}\n"
        )
    };
    "[shaft]\nspeed = \"1000 rpm\"\n[rotor]\nmass = 2\ndiametral_inertia = 4e-3\npolar_inertia = 2e-3\n\
     damping = [300, 300, 300, 0.3, 0.3]\ngravity = [0, 0, 0]\n"
        .to_owned()
        + &bearing("l", "-0.05", "+z")
        + &bearing("r", "0.05", "-z")
}

/// Axial force of each bearing of [`pair`] at rest, N.
fn axial_forces(keys: &str) -> [f64; 2] {
    let found = Sandbox::with(&pair(keys), "").done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    [0, 1].map(|i| number(&found, &format!("/bearings/{i}/force/2")).abs())
}

/// Relative tolerance of [`locked_force`]: the contact stiffness changes a little with the free contact angle.
const TOLERANCE: f64 = 2e-4;

/// Axial force of a locked bearing of [`pair`] whose clearance is `reduction` smaller than that of its preload of 500 N: `F = N K_n delta^1.5
/// sin(alpha)`, with the static values of `docs/src/validation.md`.
fn locked_force(reduction: f64) -> f64 {
    let (distance, angle, w) = (0.28e-3, 25_f64.to_radians(), 10.000495e-6);
    let (radial, axial) = (distance * angle.cos() + 0.5 * reduction, distance * angle.sin() + w);
    let length = radial.hypot(axial);
    14.0 * 8.660_350_4e9 * (length - distance).powf(1.5) * axial / length
}

/// A warmer inner ring raises the preload of a pair whose rings are locked axially; a spring keeps it.
#[test]
fn a_warmer_inner_ring_raises_the_preload() {
    let mut last = 0.0;
    for rise in [0.0, 20.0, 40.0] {
        let keys = |preload: &str| {
            format!(
                "preload = {{ {preload} }}\ntemperatures = {{ inner = \"{} degC\", outer = \"40 degC\" }}",
                40.0 + rise
            )
        };
        let expected = locked_force(12e-6 * 38.5e-3 * rise);
        for found in axial_forces(&keys("force = \"500 N\"")) {
            println!("{rise} K: {found:.1} N, {expected:.1} N expected");
            assert!(
                (found / expected - 1.0).abs() < TOLERANCE && found > last,
                "{rise} K: {found} N, {expected} N expected"
            );
            last = found - 1.0;
        }
        let displaced = axial_forces(&keys("displacement = \"10.000495 um\""));
        assert!((displaced[0] / expected - 1.0).abs() < TOLERANCE, "{rise} K: {displaced:?}");
        let spring = axial_forces(&keys("force = \"500 N\", set = \"operating\""));
        assert!((spring[0] / 500.0 - 1.0).abs() < 1e-6, "{rise} K: {spring:?}");
    }
    // Computed by an independent program: 1337 and 2391 N.
    assert!((locked_force(12e-6 * 38.5e-3 * 20.0) - 1337.0).abs() < 1.0);
    assert!((last + 1.0 - 2391.0).abs() < 2.0, "{last}");
}

/// A press fit does the same, unless the preload is set after it; `check` states the preload in operation.
#[test]
fn a_press_fit_raises_a_preload_that_is_set_before_it() {
    let fit = "fit = { shaft_interference = \"10 um\", bore = \"25 mm\", outside_diameter = \"52 mm\" }";
    let keys = |set: &str| format!("preload = {{ force = \"500 N\"{set} }}\n{fit}");
    let expected = locked_force(10e-6 * 25.0 / 31.5);
    let before = axial_forces(&keys(""));
    assert!((before[0] / expected - 1.0).abs() < TOLERANCE, "{before:?} N, {expected} N expected");
    let after = axial_forces(&keys(", set = \"fitted\""));
    assert!((after[0] / 500.0 - 1.0).abs() < 1e-6, "{after:?}");
    let text = Sandbox::with(&pair(&keys("")), "").done(&["check", "scene.toml"]).out;
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let note =
        format!("a preload of 500 N before mounting is {expected:.0} N in operation; the rings are locked axially");
    assert!(text.contains(&note), "{text}");
    // Without a rotor as well.
    let alone = pair(&keys("")).replace("\n[rotor]", "\n[other]");
    let alone = alone[..alone.find("[other]").unwrap()].to_owned() + &alone[alone.find("[[bearing]]").unwrap()..];
    let alone = &alone[..alone.rfind("[[bearing]]").unwrap()];
    let found = Sandbox::with(alone, "").done(&["equilibrium", "scene.toml", "--format", "json"]).json();
    assert!((number(&found, "/force/2").abs() / expected - 1.0).abs() < TOLERANCE, "{}", found["force"]);
    let error = Sandbox::with(&pair(&keys(", set = \"hot\"")), "").run(&["check", "scene.toml"]);
    assert!(error.code == Some(2) && error.err.contains("\"unmounted\""), "{}", error.err);
}
