//! Recordings that cannot be of the scene's machine: exit code 4, the verdict states it first, nothing is diagnosed.

use serde_json::Value;
use std::path::Path;

use crate::support::{
    DEMO_SCENE, Sandbox, TURN, changed, head, list, number, numbers, scene, short_recording, sound, swap,
};

/// Replays what is not plausible and returns the outcome.
fn implausible(scene: &str, recording: &str) -> Value {
    let sandbox = Sandbox::with(scene, recording);
    let args = ["replay", "scene.toml", "--format", "json", "--learn", "learned.json"];
    let answer = sandbox.run(&args);
    assert_eq!(answer.code, Some(4), "{answer:?}");
    let outcome: Value = answer.json();
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(verdict.starts_with("The recording is not plausible for the scene: "), "{verdict}");
    assert!(!verdict.contains("follows"), "{verdict}");
    assert_eq!(list(&outcome, "findings").len(), 0, "{outcome:#}");
    assert!(!list(&outcome, "implausible").is_empty());
    assert!(sandbox.read("scene-report.html").contains("not plausible"));
    assert!(!sandbox.files().contains(&"learned.json".to_owned()), "it is no baseline");
    let is_said = |note: &Value| note.as_str().unwrap().starts_with("No baseline is stored in learned.json: ");
    assert!(list(&outcome, "notes").iter().any(is_said), "{outcome:#}");
    let text = sandbox.run(&args[..2]).out;
    assert!(text.starts_with("The recording is not plausible") && text.contains("not judged"), "{text}");
    outcome
}

const KEYPHASOR: usize = 6;
const SAMPLES: usize = 16 * TURN;

/// A keyphasor with a second pulse half a turn after the first.
fn twice_the_speed() -> String {
    let (_, rows) = numbers(&short_recording(SAMPLES));
    changed(SAMPLES, |i, k, x| if k == KEYPHASOR && i >= TURN / 2 { x.max(rows[i - TURN / 2][k]) } else { x })
}

#[test]
fn twice_the_speed_of_the_scene() {
    let outcome = implausible(DEMO_SCENE, &twice_the_speed());
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(verdict.contains("6000 rpm") && verdict.contains("3000 rpm"), "{verdict}");
}

#[test]
fn half_the_speed_of_the_scene() {
    implausible(&scene(&[("3000 rpm", "6000 rpm")]), &short_recording(SAMPLES));
}

#[test]
fn a_unit_a_thousand_times_off() {
    let probes =
        |factor: f64| changed(SAMPLES, move |_, k, x| if (1..KEYPHASOR).contains(&k) { factor * x } else { x });
    let large = implausible(DEMO_SCENE, &probes(1000.0));
    assert!(large["verdict"].as_str().unwrap().contains("farther from zero than"), "{large:#}");
    let small = implausible(DEMO_SCENE, &probes(0.001));
    let found = &list(&small, "implausible")[0];
    assert!(found["remedy"].as_str().unwrap().contains("possible in mm"), "{found}");
}

/// A machine off centre in the other direction along its axis: no element carries load.
#[test]
fn no_element_carries_load() {
    let lifted = changed(SAMPLES, |_, k, x| if k == 5 { 0.0 } else { x });
    let outcome = implausible(DEMO_SCENE, &lifted);
    assert!(outcome["verdict"].as_str().unwrap().contains("no element carries load"), "{outcome:#}");
}

#[test]
fn a_speed_column_without_a_plausible_speed() {
    let keyphasor = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
    let speed = swap(DEMO_SCENE, keyphasor, "speed = { column = \"keyphasor\", unit = \"rpm\" }");
    let fast = changed(2 * TURN, |_, k, x| if k == KEYPHASOR { 1e9 } else { x });
    let outcome = implausible(&speed, &fast);
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(
        verdict
            .contains("not plausible for the scene: shaft angle: column keyphasor: no plausible speed in 512 readings"),
        "{verdict}"
    );
}

#[test]
fn the_demonstration_is_plausible() {
    let outcome = sound();
    assert_eq!((list(outcome, "implausible").len(), list(outcome, "not_judged").len()), (0, 0));
}

/// A keyphasor that fails: its part of the recording is flagged and the machine has no verdict.
#[test]
fn keyphasor_that_fails() {
    let dead = 10 * TURN;
    let text = changed(SAMPLES, |i, k, x| if k == KEYPHASOR && i > dead { 0.0 } else { x });
    let sandbox = Sandbox::with(DEMO_SCENE, &text);
    let outcome = sandbox.replay("scene.toml", &["--forces", "forces.csv"]);
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(verdict.starts_with("No verdict: the shaft angle is not measured in 3"), "{verdict}");
    assert_eq!(list(&outcome, "findings").len(), 0);
    let flaw = &list(&outcome, "flaws")[0];
    assert_eq!((flaw["kind"].as_str(), flaw["column"].as_str()), (Some("dead_keyphasor"), Some("keyphasor")));
    let lost = flaw["samples_affected"].as_u64().unwrap() as usize;
    assert!((SAMPLES - dead - 2 * TURN..SAMPLES - dead).contains(&lost), "{lost}");
    let (_, rows) = numbers(&sandbox.read("forces.csv"));
    let flagged = rows.iter().filter(|row| row[row.len() - 1] as u16 & 1024 != 0).count();
    assert_eq!(flagged, lost, "each of its samples is flagged");
}

/// A spike of twice the pulse's level, wherever it is, is omitted and changes nothing else.
#[test]
fn a_spike_of_the_keyphasor() {
    let plain = Sandbox::with(DEMO_SCENE, &short_recording(SAMPLES)).replay("scene.toml", &[]);
    for place in [100, 5 * TURN + 77, 14 * TURN + 100] {
        let text = changed(SAMPLES, |i, k, x| if k == KEYPHASOR && i == place { 2.0 } else { x });
        let outcome = Sandbox::with(DEMO_SCENE, &text).replay("scene.toml", &[]);
        for key in ["verdict", "probes", "record"] {
            assert_eq!(outcome[key], plain[key], "{place}: {key}");
        }
        assert_eq!(list(&outcome, "flaws")[0]["kind"], "spurious_pulse", "{place}");
    }
}

/// Eight balls in the scene, nine in the recording: `--force` diagnoses all the same and states what it overrides.
#[test]
fn diagnosis_despite_implausible_data() {
    let wrong = DEMO_SCENE.replace("elements = 9", "elements = 8");
    let spall = head(include_str!("../recordings/outer-spall.csv"), 40 * TURN);
    implausible(&wrong, &spall);
    let outcome = Sandbox::with(&wrong, &spall).replay("scene.toml", &["--force"]);
    // The scene is that of another bearing: the recording proves no fault of it.
    assert!(number(&outcome, "/diagnosis/chi_square_before") > 0.0, "{outcome:#}");
    assert!(list(&outcome, "implausible").is_empty(), "{outcome:#}");
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("Not plausible, diagnosed all the same: bearing DE: elements"), "{notes}");
}

/// Recordings of other machines, sound and with faults of every kind, fail no check of their scenes, where the files are at hand.
#[test]
fn faults_are_plausible() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/recordings/fleet");
    let rigs = std::fs::read_dir(&folder).into_iter().flatten().map(|rig| rig.unwrap().path());
    let sandbox = Sandbox::empty();
    for rig in rigs.filter(|path| path.is_dir()) {
        let scene = rig.join("scene.toml");
        for recording in std::fs::read_dir(&rig).unwrap().map(|file| file.unwrap().path()) {
            if recording.extension().is_some_and(|ending| ending == "npy") {
                sandbox.done(&["check", scene.to_str().unwrap(), "--recording", recording.to_str().unwrap()]);
            }
        }
    }
}

/// Checks a scene with a recording and returns the text, with its lines joined.
fn checked(scene: &str, recording: &str) -> String {
    let sandbox = Sandbox::with(scene, recording);
    let answer = sandbox.run(&["check", "scene.toml"]);
    assert_eq!(answer.code, Some(4), "{answer:?}");
    assert!(!answer.out.contains("Nothing implausible"), "{answer:?}");
    answer.out.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn check_finds_values_that_contradict_each_other() {
    let plain = short_recording(SAMPLES);
    let of_scene = |swaps: &[(&str, &str)]| checked(&scene(swaps), &plain);
    let text = of_scene(&[("mass = \"6 kg\"", "mass = \"6 g\"")]);
    assert!(text.contains("rotor.mass: 0.006 kg, while a steel shaft through the bearings has"), "{text}");
    let text = of_scene(&[("\"60 N\"", "\"12 kN\"")]);
    assert!(text.contains("rotor.load: 12000 N on a rotor of 6 kg, 204 times its weight"), "{text}");
    let text = of_scene(&[("\"-120 mm\"", "\"-1200 mm\"")]);
    assert!(text.contains("DE_X_um: station: -1200 mm, while the bearings are at -100 to 100 mm"), "{text}");
    let text = of_scene(&[("\"-120 mm\"", "\"121 mm\""), ("\"120 mm\"", "\"-121 mm\"")]);
    assert!(text.contains("DE_X_um: station: 121 mm is nearer to bearing NDE than to DE"), "{text}");
    let text = of_scene(&[("noise = \"0.03 um\"", "noise = \"10 um\"")]);
    assert!(text.contains("DE_X_um: noise: 10 um is more than the whole motion"), "{text}");
    let text = of_scene(&[("noise = \"0.03 um\"", "noise = \"0.1 nm\"")]);
    assert!(text.contains("DE_X_um: noise: 0.0001 um is far below the noise of the readings, about 0.0"), "{text}");
}

#[test]
fn check_finds_what_a_recording_lacks() {
    let gap = changed(SAMPLES, |_, k, x| if k == 1 { x + 100.0 } else { x });
    let text = checked(DEMO_SCENE, &gap);
    assert!(text.contains("DE_X_um: offset: mean of 100 um, while the bearings allow"), "{text}");
    assert!(text.contains("Remedy: offset = \"100.0 um\""), "{text}");
    let plain = short_recording(SAMPLES);
    let empty: String = plain
        .lines()
        .enumerate()
        .map(|(i, line)| if i == 0 { line.to_owned() } else { crate::support::with_cell(line, 2, "") } + "\n")
        .collect();
    assert!(checked(DEMO_SCENE, &empty).contains("DE_Y_um: no reading in the whole column"));
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", DEMO_SCENE);
    let answer = sandbox.run(&["check", "scene.toml"]);
    assert_eq!(answer.code, Some(1), "{answer:?}");
    assert!(!answer.out.contains("Nothing implausible") && answer.out.contains("no such file"), "{answer:?}");
    let sandbox = Sandbox::with(DEMO_SCENE, &plain);
    let text = sandbox.done(&["check", "scene.toml"]).out;
    assert!(text.contains("DE_X_um: mean") && text.contains("clearance +-5.0 um"), "{text}");
    assert!(text.contains("Nothing implausible found."), "{text}");
    sandbox.refused(&["new", "--bearing", "6309 C8"], 2, &["6309 C8", "C2, CN, C3, C4 or C5"]);
}

/// A scene that names another bearing of the same bore than the recording shows.
#[test]
fn check_finds_another_designation() {
    let bearing = |name: &str, station: &str, designation: &str| {
        format!(
            "[[bearing]]\nname = \"{name}\"\nstation = \"{station}\"\nfacing = \"both\"\nmodel = \"angular\"\nbearing = \"{designation}\"\n"
        )
    };
    let (before, after) = (DEMO_SCENE.find("[[bearing]]").unwrap(), DEMO_SCENE.find("[recording]").unwrap());
    let with = |designation: &str| {
        let bearings = bearing("DE", "-100 mm", designation) + &bearing("NDE", "100 mm", designation);
        let text = format!("{}{bearings}\n{}", &DEMO_SCENE[..before], &DEMO_SCENE[after..]);
        swap(&text, "\"0 N\", \"0 N\", \"60 N\"", "\"0 N\", \"-2 kN\", \"60 N\"")
    };
    let sandbox = Sandbox::empty();
    for designation in ["6209", "6309"] {
        sandbox.put("scene.toml", with(designation));
        let output = format!("{designation}.csv");
        sandbox.done(&[
            "simulate",
            "scene.toml",
            "--duration",
            "2 s",
            "--settle",
            "0.5 s",
            "--as-recording",
            "-o",
            &output,
        ]);
    }
    for (ours, other) in [("6209", "6309"), ("6309", "6209")] {
        sandbox.put("scene.toml", with(ours));
        sandbox.done(&["check", "scene.toml", "--recording", &format!("{ours}.csv")]);
        let answer = sandbox.run(&["check", "scene.toml", "--recording", &format!("{other}.csv")]);
        let text = answer.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(answer.code, Some(4), "{text}");
        assert!(text.contains(&format!("no line at the outer-race ball pass of {ours}")), "{text}");
        assert!(text.contains(&format!("with its double, as of {other}")), "{text}");
    }
}
