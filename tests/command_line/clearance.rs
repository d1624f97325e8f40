//! Operating clearance by fits and temperatures, from the scene and from a temperature channel.

use crate::support::{DEMO_RECORDING, DEMO_SCENE, Desk, number, swap};
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
    let desk = Desk::with(&scene(fit), DEMO_RECORDING);
    let [by_fits, by_temperature] = [5.0 * 25.0 / 31.1, 12e-6 * 39.04e3 * 10.0];
    let expected = 16.0 - by_fits - by_temperature;
    for command in ["check", "equilibrium"] {
        let found = desk.done(&[command, "scene.toml", "--format", "json"]).json();
        let clearance = |key: &str| number(&found, &format!("/bearings/0/operating_clearance/{key}"));
        assert!((clearance("operating_um") - expected).abs() < 1e-9, "{command}");
        assert!((clearance("by_fits_um") - by_fits).abs() < 1e-9 && clearance("unmounted_um") == 16.0);
        assert!((clearance("by_temperature_um") - by_temperature).abs() < 1e-9);
        assert!(found.pointer("/bearings/1/operating_clearance").is_none());
        let text = desk.done(&[command, "scene.toml"]).out;
        assert!(text.contains("7.30 um: 16.00 um before mounting"), "{command}: {text}");
    }
    let outcome = desk.replay("scene.toml", &[]);
    assert!(notes(&outcome).contains("Bearing DE: operating clearance 7.30 um: 16.00 um before mounting, less 4.02 um by the fits and 4.68 um by temperature."));
    // The recording is of a machine with 10 um.
    let is_of_clearance = |f: &Value| f["kind"] == "clearance" && f["bearing"] == "DE";
    assert!(outcome["findings"].as_array().unwrap().iter().any(is_of_clearance), "{}", outcome["findings"]);
}

/// The outer ring is 2.81 K hotter than the scene says, and so is the inner one: the clearance stays. An inner ring that is 12.81 K
/// hotter than the outer one takes the 6 um by which the scene is too large.
#[test]
fn a_channel_corrects_the_clearance_of_a_replay() {
    let channels = "temperature = [\n{ column = \"T_outer\", unit = \"degC\", bearing = \"DE\", ring = \"outer\" },\n\
                    { column = \"T_inner\", unit = \"degC\", bearing = \"DE\", ring = \"inner\" },\n]\nkeyphasor = {";
    let cold = scene("temperatures = { inner = \"40 degC\", outer = \"40 degC\" }");
    let add = |(i, line): (usize, &str)| match i {
        0 => format!("{line},T_outer,T_inner\n"),
        _ => format!("{line},42.81,{}\n", 42.81 + 6.0 / (12e-6 * 39.04e3)),
    };
    let recording: String = DEMO_RECORDING.lines().enumerate().map(add).collect();
    let desk = Desk::with(&cold, &recording);
    let findings = |outcome: &Value| outcome["findings"].as_array().unwrap().len();
    assert!(findings(&desk.replay("scene.toml", &[])) > 0);
    desk.put("scene.toml", swap(&cold, "keyphasor = {", channels));
    let outcome = desk.replay("scene.toml", &[]);
    assert_eq!(findings(&outcome), 0, "{}", outcome["findings"]);
    let notes = notes(&outcome);
    assert!(notes.contains("Bearing DE: operating clearance 10.00 um: 16.00 um before mounting"), "{notes}");
    assert!(notes.contains("T_outer: 42.8 degC in the mean"), "{notes}");
}
