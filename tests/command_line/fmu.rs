//! Units for co-simulation: what `fmu` writes, and what it refuses. The Python package's tests run units in a host.

use crate::support::{DEMO_SCENE, Sandbox, program, scene};
use serde_json::Value;
use std::process::Command;

/// Names of the files in an archive, from the headers before each.
fn names(archive: &[u8]) -> Vec<String> {
    const HEADER: [u8; 4] = *b"PK\x03\x04";
    let starts = archive.windows(4).enumerate().filter(|(_, window)| *window == HEADER);
    let name = |at: usize| {
        let length = usize::from(u16::from_le_bytes([archive[at + 26], archive[at + 27]]));
        String::from_utf8(archive.get(at + 30..at + 30 + length)?.to_vec()).ok()
    };
    starts.filter_map(|(at, _)| name(at)).collect()
}

#[test]
fn a_unit_has_description_library_and_scene() {
    let sandbox = Sandbox::rig();
    let unit: Value = sandbox.done(&["fmu", "scene.toml", "-o", "rotor.fmu", "--format", "json"]).json();
    assert_eq!(unit["internal_step_s"], 1.0 / 12_800.0);
    let rows = unit["variables"].as_array().unwrap();
    assert_eq!(rows.len(), 1 + 5 + 10 + 10 + 1, "{rows:?}");
    assert_eq!(rows[6]["name"], "u");
    assert_eq!(rows[16]["name"], "DE.FX");
    let archive = std::fs::read(sandbox.path("rotor.fmu")).unwrap();
    let found = names(&archive);
    let platform = unit["platform"].as_str().unwrap();
    assert_eq!(found.len(), 4, "{found:?}");
    assert_eq!(found[0], "modelDescription.xml");
    assert!(found[1].starts_with(&format!("binaries/{platform}/_6205_rig_rotor.")), "{found:?}");
    assert_eq!(found[2..], ["resources/scene.toml", "resources/unit.toml"]);
    // The same scene gives the same bytes.
    sandbox.done(&["fmu", "scene.toml", "-o", "again.fmu"]);
    assert!(std::fs::read(sandbox.path("again.fmu")).unwrap() == archive);
}

#[test]
fn a_table_of_variables_is_printed() {
    let sandbox = Sandbox::rig();
    let table = sandbox.done(&["fmu", "scene.toml", "--bearing", "DE", "-o", "bearing.fmu", "--format", "csv"]).out;
    let rows: Vec<&str> = table.lines().collect();
    assert_eq!(rows[0], "value_reference,name,causality,unit,description");
    assert!(rows[2].starts_with("1,u,input,m,"), "{table}");
    assert!(rows[9].starts_with("8,FX,output,N,"), "{table}");
    assert_eq!(rows.len(), 1 + 1 + 7 + 5 + 1, "{table}");
}

/// Without a recording the internal step is a round one, twenty in a period of the highest natural frequency; without a rotor the unit is the bearing.
#[test]
fn scenes_without_a_recording_or_a_rotor() {
    let sandbox = Sandbox::rig();
    sandbox.put("unclocked.toml", DEMO_SCENE.split("[recording]").next().unwrap());
    let unit: Value = sandbox.done(&["fmu", "unclocked.toml", "-o", "rotor.fmu", "--format", "json"]).json();
    let highest =
        sandbox.done(&["equilibrium", "unclocked.toml", "--format", "json"]).json::<Value>()["natural_frequencies_hz"]
            .as_array()
            .unwrap()
            .iter()
            .filter_map(Value::as_f64)
            .fold(0.0, f64::max);
    let rate = 1.0 / unit["internal_step_s"].as_f64().unwrap();
    // The margin of the plant is for contacts that stiffen under load.
    assert!(rate >= 20.0 * highest && rate <= 80.0 * highest, "{rate} {highest}");
    let leading = rate / 10_f64.powf(rate.log10().floor());
    assert!([1.0, 2.0, 5.0].iter().any(|round| (leading / round - 1.0).abs() < 1e-9), "{rate}");
    sandbox.put("alone.toml", sandbox.done(&["scenes", "jones-1960"]).out);
    let unit: Value = sandbox.done(&["fmu", "alone.toml", "-o", "bearing.fmu", "--format", "json"]).json();
    assert!(unit["internal_step_s"].is_null() && unit["bearing"].is_string(), "{unit}");
}

#[test]
fn wrong_command_lines_are_refused() {
    let sandbox = Sandbox::rig();
    sandbox.put("lone.toml", scene(&[("[rotor]", "[unused]")]));
    let write = ["-o", "unit.fmu"];
    let refused = |args: &[&str], code: i32, parts: &[&str]| {
        sandbox.refused(&[&["fmu"], args, &write].concat(), code, parts);
    };
    refused(&["scene.toml", "--bearing", "XE"], 2, &["--bearing: ", "\"XE\"", "DE, NDE"]);
    refused(&["scene.toml", "--rate", "fast"], 2, &["--rate: ", "fast"]);
    refused(&["scene.toml", "--rate", "1 Hz"], 2, &["too many integration steps"]);
    refused(&["lone.toml"], 2, &["unused"]);
    refused(
        &["scene.toml", "--library", "healthy.csv"],
        2,
        &["--library: no library of units: healthy.csv, expected one"],
    );
    refused(&["scene.toml", "--library", "none.so"], 1, &["none.so: no library of units", "-p ballrace-fmu"]);
    let both = sandbox.run(&["fmu", "scene.toml", "--bearing", "DE", "--rate", "1 kHz", "-o", "unit.fmu"]);
    assert!(both.code == Some(2) && both.err.contains("cannot be used with"), "{both:?}");
}

/// A program without the library beside it names it.
#[test]
fn a_missing_library_is_named() {
    let sandbox = Sandbox::rig();
    let alone = sandbox.path("alone");
    std::fs::copy(program(), &alone).unwrap();
    let run = |more: &[&str]| {
        let mut command = Command::new(&alone);
        command.args(["fmu", "scene.toml", "-o", "unit.fmu"]).args(more).current_dir(sandbox.path(""));
        command.output().unwrap()
    };
    let output = run(&[]);
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && err.contains("ballrace_fmu"), "{err}");
    assert!(err.contains("expected the one beside the program in its archive, or --library FILE"), "{err}");
    let library = std::env::consts::DLL_PREFIX.to_owned() + "ballrace_fmu" + std::env::consts::DLL_SUFFIX;
    let library = program().with_file_name(library);
    assert!(run(&["--library", library.to_str().unwrap()]).status.success());
}
