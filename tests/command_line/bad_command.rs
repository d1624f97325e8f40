//! Commands that are wrong, or that ask for what the scene does not have.

use crate::support::{DEMO_SCENE, Sandbox, scene, short_recording};

/// Command lines that the parser rejects, with its own message of several lines.
fn no_such(args: &[&str], part: &str) {
    let sandbox = Sandbox::rig();
    let answer = sandbox.run(args);
    assert_eq!(answer.code, Some(2), "{answer:?}");
    assert!(answer.err.contains(part) && !answer.err.contains("panicked"), "{answer:?}");
    assert_eq!(answer.out, "");
    assert_eq!(sandbox.files(), ["healthy.csv", "scene.toml"]);
}

#[test]
fn unknown_words() {
    no_such(&["reply", "scene.toml"], "unrecognized subcommand 'reply'");
    no_such(&["replay", "--fast"], "unexpected argument '--fast'");
    no_such(&["replay", "scene.toml", "healthy.csv"], "unexpected argument 'healthy.csv'");
    no_such(&["replay", "--format", "xml"], "possible values: text, json, csv");
    no_such(&["force", "scene.toml", "--displacements", "u.csv", "--precision", "f16"], "possible values: f32, f64");
    no_such(&["force", "scene.toml", "--displacements", "u.csv", "--model", "best"], "angular");
    no_such(&[], "Usage: ballrace");
}

#[test]
fn missing_options() {
    no_such(&["force", "scene.toml"], "--displacements");
    no_such(&["simulate", "scene.toml", "--duration", "1 s", "--rate", "1 kHz"], "--output");
    no_such(&["simulate", "scene.toml", "--rate", "1 kHz", "-o", "motion.csv"], "--duration");
    no_such(&["simulate", "--duration", "1 s", "--rate", "1 kHz", "-o", "motion.csv"], "<SCENE>");
}

#[test]
fn help_and_version() {
    let sandbox = Sandbox::empty();
    let help = sandbox.done(&["--help"]).out;
    for command in ["replay", "force", "simulate"] {
        assert!(help.contains(command), "{help}");
        assert!(sandbox.done(&[command, "--help"]).out.contains("--format"));
    }
    assert!(sandbox.done(&["--version"]).out.starts_with("ballrace "));
}

/// With a file of displacements as `force` takes it.
fn desk_with(scene: &str) -> Sandbox {
    let sandbox = Sandbox::with(scene, &short_recording(600));
    sandbox.put("u.csv", "u,v,w,thu,thv\n0,0,6e-5,0,0\n");
    sandbox
}

const FORCE: [&str; 4] = ["force", "scene.toml", "--displacements", "u.csv"];

#[test]
fn bearing_that_is_not_there() {
    let sandbox = desk_with(DEMO_SCENE);
    let wrong = [&FORCE[..], &["--bearing", "XE"]].concat();
    sandbox.refused(&wrong, 2, &["--bearing: no such bearing in scene.toml: \"XE\", expected one of DE, NDE"]);
    sandbox.refused(&FORCE, 2, &["--bearing: no bearing selected in scene.toml, expected one of DE, NDE"]);
}

#[test]
fn model_that_the_scene_does_not_allow() {
    let linear = [&FORCE[..], &["--bearing", "DE", "--model", "linear"]].concat();
    desk_with(DEMO_SCENE).refused(&linear, 2, &["scene.toml: bearing DE: model linear: no stiffness, expected "]);
    let lumped = "[shaft]\nspeed = 100\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"lumped\"\nelements = 8\n\
                  cage_ratio = 0.4\nstiffness = 1e10\nradial_play = 0\n";
    let angular = [&FORCE[..], &["--model", "angular"]].concat();
    let sandbox = desk_with(lumped);
    sandbox.refused(&angular, 2, &["scene.toml: bearing A: model angular: no geometry, expected ball_diameter"]);
    sandbox.done(&FORCE);
}

#[test]
fn replay_without_what_it_needs() {
    let (bare, _) = DEMO_SCENE.split_once("[recording]").unwrap();
    let replay = ["replay", "scene.toml", "--forces", "forces.csv"];
    desk_with(bare).refused(&replay, 2, &["scene.toml: missing table [recording], expected the columns"]);
    let with_recording = [&replay[..], &["--recording", "healthy.csv"]].concat();
    desk_with(bare).refused(&with_recording, 2, &["scene.toml: missing table [recording]"]);
    let loose = without_rotor();
    desk_with(&loose).refused(
        &replay,
        2,
        &["scene.toml: missing table [rotor] or [system], without which there is no motion"],
    );
    let simulate = ["simulate", "scene.toml", "--duration", "1 s", "--rate", "1 kHz", "-o", "motion.csv"];
    desk_with(&loose).refused(
        &simulate,
        2,
        &["scene.toml: missing table [rotor] or [system], without which there is no motion"],
    );
    desk_with(&loose).done(&[&FORCE[..], &["--bearing", "NDE"]].concat());
}

fn without_rotor() -> String {
    let (before, rest) = DEMO_SCENE.split_once("[rotor]").unwrap();
    let (_, after) = rest.split_once("[[bearing]]").unwrap();
    format!("{before}[[bearing]]{after}")
}

#[test]
fn duration_and_rate() {
    let sandbox = desk_with(DEMO_SCENE);
    for (duration, rate, parts) in [
        ("5 mm", "1 kHz", "--duration: invalid value: \"5 mm\" (a length), expected a time, such as \"2 s\""),
        (
            "soon",
            "1 kHz",
            "--duration: invalid value: \"soon\" (does not start with a number and a unit), expected a time",
        ),
        ("0 s", "1 kHz", "--duration: value out of range: \"0 s\", expected a time above 0"),
        ("inf", "1 kHz", "--duration: value out of range: \"inf\", expected a time above 0"),
        ("1 s", "3000 rpm", "--rate: invalid value: \"3000 rpm\" (a speed of rotation), expected a frequency"),
        ("1 s", "0", "--rate: value out of range: \"0\", expected a frequency above 0"),
        ("1 s", "NaN", "--rate: value out of range: \"NaN\", expected a frequency above 0"),
        ("1 ms", "100 Hz", "--duration, --rate: number of samples out of range: 0, expected 1 to 1e9"),
        ("1e9 s", "1e9", "--duration, --rate: number of samples out of range: 1000000000000000000, expected 1 to 1e9"),
    ] {
        sandbox.refused(
            &["simulate", "scene.toml", "--duration", duration, "--rate", rate, "-o", "motion.csv"],
            2,
            &[parts],
        );
    }
    sandbox.refused(
        &["simulate", "scene.toml", "--duration=-1 s", "--rate", "1 kHz", "-o", "motion.csv"],
        2,
        &["--duration: value out of range: \"-1 s\", expected a time above 0"],
    );
}

#[test]
fn displacements_that_cannot_be_read() {
    let force = [&FORCE[..], &["--bearing", "DE"]].concat();
    for (text, code, part) in [
        ("", 1, "u.csv: file is empty, expected a CSV file with the columns u,v,w,thu,thv"),
        (
            "u,v,w,thu\n0,0,0,0\n",
            2,
            "u.csv:1: missing column thv among `u`, `v`, `w`, `thu`, expected u,v,w,thu,thv and",
        ),
        (
            "u,v,w,thu,thv,t,cage_angle\n0,0,0,0,0,0,0\n",
            2,
            "u.csv:1: both t and cage_angle are given, expected at most one",
        ),
        ("u,v,w,thu,thv\n0,0,0,0,0\n0,0,0,0,x\n", 1, "u.csv:3: column thv: invalid value: `x`, expected a number"),
        ("u,v,w,thu,thv\n0,0,,0,0\n", 1, "u.csv:2: column w: invalid value: ``, expected a number"),
        ("u,v,w,thu,thv\n0,0,0,0\n", 1, "u.csv:2: wrong number of cells: 4, expected 5 as in the header"),
        ("u,v,w,thu,thv\n0,0,0,0,0,0\n", 1, "u.csv:2: wrong number of cells: 6, expected 5"),
    ] {
        let sandbox = desk_with(DEMO_SCENE);
        sandbox.put("u.csv", text);
        sandbox.refused(&force, code, &[part]);
    }
    let sandbox = desk_with(DEMO_SCENE);
    std::fs::remove_file(sandbox.path("u.csv")).unwrap();
    sandbox.refused(&force, 1, &["u.csv: this file cannot be read: "]);
    sandbox.put("u.csv", b"u,v,w,thu,thv\n\xff\xfe,0,0,0,0\n");
    sandbox.refused(&force, 1, &["u.csv: ", "invalid utf-8"]);
    sandbox.refused(
        &["force", "scene.toml", "--bearing", "DE", "--displacements", "."],
        1,
        &[".: path is a folder, expected a CSV file with the columns u,v,w,thu,thv"],
    );
}

#[test]
fn two_spring_formula_out_of_its_range() {
    let spring = "\"linear\"\ntwo_spring = { static_load = \"30 N\" }";
    let text = scene(&[("\"angular\"", spring), ("elements = 9", "elements = 7")]);
    let part = "scene.toml:22: bearing[0].elements: invalid value: 7, expected 8 to 16 with two_spring";
    desk_with(&text).refused(&["replay", "scene.toml"], 2, &[part]);
}
