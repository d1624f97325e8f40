//! Wrong inputs as users make them: each gives one clear message from `check` and from `replay`, and no diagnosis. The chapter
//! "Wrong inputs" of the guide lists the messages, written by this test.

use crate::support::{DEMO_SCENE, Sandbox, TURN, changed, list, scene, short_recording, swap, with_cell};
use serde_json::Value;
use std::path::Path;

const SAMPLES: usize = 20 * TURN;
const KEYPHASOR: &str = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
const DE_X: &str =
    "{ column = \"DE_X_um\", unit = \"um\", station = \"-120 mm\", angle = \"0 deg\", noise = \"0.03 um\" }";
const DE_Y: &str =
    "{ column = \"DE_Y_um\", unit = \"um\", station = \"-120 mm\", angle = \"90 deg\", noise = \"0.03 um\" }";
const NDE_Y: &str =
    "{ column = \"NDE_Y_um\", unit = \"um\", station = \"120 mm\", angle = \"90 deg\", noise = \"0.03 um\" }";

/// A wrong input.
struct Wrong {
    name: &'static str,
    scene: String,
    recording: String,
    /// Parts of the message.
    says: Vec<&'static str>,
}

fn in_scene(name: &'static str, swaps: &[(&str, &str)], says: &[&'static str]) -> Wrong {
    Wrong { name, scene: scene(swaps), recording: short_recording(SAMPLES), says: says.to_vec() }
}

fn in_recording(name: &'static str, recording: String, says: &[&'static str]) -> Wrong {
    Wrong { name, scene: DEMO_SCENE.to_owned(), recording, says: says.to_vec() }
}

fn in_both(name: &'static str, swaps: &[(&str, &str)], recording: String, says: &[&'static str]) -> Wrong {
    Wrong { recording, ..in_scene(name, swaps, says) }
}

/// The recording with the readings of the probes multiplied.
fn scaled(factor: f64) -> String {
    changed(SAMPLES, move |_, k, x| if (1..6).contains(&k) { factor * x } else { x })
}

/// The recording with one column replaced.
fn column(column: usize, value: impl Fn(usize, f64) -> f64) -> String {
    changed(SAMPLES, move |i, k, x| if k == column { value(i, x) } else { x })
}

/// The recording with its text edited.
fn text(edit: impl Fn(String) -> String) -> String {
    edit(short_recording(SAMPLES))
}

fn keys_and_units() -> Vec<Wrong> {
    let two = "elements = 9\nball_diameter = \"7.94 mm\"\npitch_diameter";
    vec![
        in_scene("a key with a typing error", &[("mass =", "masss =")], &["masss", "mass"]),
        in_scene(
            "a number without its unit, too large in SI",
            &[("pitch_diameter = \"39.04 mm\"", "pitch_diameter = 39.04")],
            &["39.04", "mm"],
        ),
        in_scene("an angle in degrees without its unit", &[("angle = \"90 deg\"", "angle = 90")], &["90", "deg"]),
        in_scene("a unit of another quantity", &[("mass = \"6 kg\"", "mass = \"6 N\"")], &["6 N", "kg"]),
        in_scene(
            "a probe without a unit",
            &[("unit = \"um\", station = \"-120 mm\", angle = \"0 deg\"", "station = \"-120 mm\", angle = \"0 deg\"")],
            &["unit"],
        ),
        in_scene("a column that the recording does not have", &[("\"DE_X_um\"", "\"DE_X\"")], &["DE_X", "DE_X_um"]),
        in_scene("two bearings of one name", &[("name = \"NDE\"", "name = \"DE\"")], &["DE"]),
        in_scene(
            "balls larger than the pitch circle allows",
            &[("ball_diameter = \"7.94 mm\"", "ball_diameter = \"79.4 mm\"")],
            &["pitch_diameter"],
        ),
        in_scene(
            "a designation that is in no catalogue",
            &[("model = \"angular\"", "bearing = \"6299X\"")],
            &["6299X"],
        ),
        in_scene("a quotation mark left open", &[("\"6 kg\"", "\"6 kg")], &["TOML"]),
        in_scene("neither rate nor time", &[("rate = \"12.8 kHz\"\n", "")], &["rate", "time"]),
        in_scene("a keyphasor without its pulses per turn", &[(", pulses_per_turn = 1", "")], &["pulses_per_turn"]),
        in_scene(
            "keyphasor and speed at once",
            &[(KEYPHASOR, &format!("{KEYPHASOR}\nspeed = {{ column = \"time_s\", unit = \"rpm\" }}"))],
            &["speed", "keyphasor"],
        ),
        in_scene("a number of elements below three", &[(two, &two.replace("= 9", "= 2"))], &["elements", "2"]),
        in_scene("a rate in kHz without its unit", &[("\"12.8 kHz\"", "12.8")], &["rate", "12.8"]),
        in_scene("a recording that is not there", &[("healthy.csv", "health.csv")], &["health.csv"]),
    ]
}

fn files() -> Vec<Wrong> {
    let wide = |text: &str| text.replace('.', ",");
    vec![
        in_recording("an empty file", String::new(), &["healthy.csv", "empty"]),
        in_recording("a header without rows", short_recording(0), &["healthy.csv"]),
        in_recording(
            "no header",
            text(|text| text.split_once('\n').unwrap().1.to_owned()),
            &["healthy.csv:1", "header"],
        ),
        in_recording(
            "a text in a cell",
            text(|text| {
                text.lines()
                    .enumerate()
                    .map(|(i, line)| if i == 40 { with_cell(line, 1, "oops") + "\n" } else { line.to_owned() + "\n" })
                    .collect()
            }),
            &["healthy.csv:41", "oops"],
        ),
        in_recording(
            "a decimal comma between commas",
            text(|text| {
                text.lines()
                    .enumerate()
                    .map(|(i, line)| if i == 0 { line.to_owned() + "\n" } else { wide(line) + "\n" })
                    .collect()
            }),
            &["healthy.csv:2"],
        ),
        in_recording(
            "two columns of one name",
            text(|text| swap(&text, "DE_Y_um", "DE_X_um")),
            &["healthy.csv:1", "DE_X_um"],
        ),
        in_recording(
            "a page instead of a table",
            "<!DOCTYPE html>\n<html><body>Not found</body></html>\n".to_owned(),
            &["healthy.csv"],
        ),
        in_both(
            "time stamps that stand still",
            &[("rate = \"12.8 kHz\"", "time = \"time_s\"")],
            column(0, |_, _| 1.0),
            &["time_s"],
        ),
        in_recording("a dead keyphasor", column(6, |_, _| 0.0), &["keyphasor"]),
        in_recording("a recording shorter than two turns", short_recording(TURN / 2), &["keyphasor"]),
    ]
}

fn machines() -> Vec<Wrong> {
    let speed_in = |unit: &str| format!("speed = {{ column = \"keyphasor\", unit = \"{unit}\" }}");
    let other = |probe: &str| probe.replace("\"90 deg\"", "\"-90 deg\"");
    let same = |probe: &str| probe.replace("\"90 deg\"", "\"0 deg\"");
    let exchanged = [DE_X.replace("DE_X", "DE_Y"), DE_Y.replace("DE_Y", "DE_X")];
    let no_keyphasor = |speed: &str| scene(&[(KEYPHASOR, ""), ("3000 rpm", speed)]);
    let plain = || short_recording(50 * TURN);
    let rate = swap(&no_keyphasor("3000 rpm"), "12.8 kHz", "9 kHz");
    vec![
        in_scene(
            "two marks on the shaft, one in the scene",
            &[("3000 rpm", "1500 rpm")],
            &["shaft speed", "pulses_per_turn = 2"],
        ),
        in_scene("another speed", &[("3000 rpm", "1100 rpm")], &["shaft speed", "3000 rpm measured"]),
        in_scene(
            "half the sampling rate",
            &[("\"12.8 kHz\"", "\"6.4 kHz\"")],
            &["shaft speed", "1500 rpm measured", "rate"],
        ),
        in_both(
            "rev/s in a column of rpm",
            &[(KEYPHASOR, &speed_in("rev/s"))],
            column(6, |_, _| 3000.0),
            &["rev/s and rpm"],
        ),
        in_both(
            "rad/s in a column of rpm",
            &[(KEYPHASOR, &speed_in("rad/s"))],
            column(6, |_, _| 3000.0),
            &["rad/s and rpm"],
        ),
        in_recording("mm in columns of um", scaled(0.001), &["possible in mm"]),
        in_recording("nm in columns of um", scaled(1000.0), &["possible in nm"]),
        in_recording("micro-inches in columns of um", scaled(39.37), &["another unit"]),
        in_recording("mil in columns of um", scaled(1.0 / 25.4), &["possible in mil"]),
        in_recording("the gap of a probe in its readings", column(1, |_, x| x + 900.0), &["offset = \"900"]),
        in_scene("all probes in one direction", &[(DE_Y, &same(DE_Y)), (NDE_Y, &same(NDE_Y))], &["direction"]),
        in_scene(
            "angles in the other direction",
            &[(DE_Y, &other(DE_Y)), (NDE_Y, &other(NDE_Y))],
            &["backward in every plane"],
        ),
        in_scene(
            "X and Y of one plane exchanged",
            &[(DE_X, &exchanged[0]), (DE_Y, &exchanged[1])],
            &["columns of X and Y exchanged"],
        ),
        in_recording(
            "one plane in another unit",
            changed(SAMPLES, |_, k, x| if k == 3 || k == 4 { 0.001 * x } else { x }),
            &["NDE", "dead probe"],
        ),
        in_recording(
            "a probe that is not connected",
            column(2, |i, _| 1e-4 * f64::from(i as u8 % 7)),
            &["DE_Y_um", "dead probe"],
        ),
        in_scene("the column of time for a probe", &[("\"DE_X_um\"", "\"time_s\"")], &["time_s"]),
        Wrong {
            name: "another speed, without a keyphasor",
            scene: no_keyphasor("2200 rpm"),
            recording: plain(),
            says: vec!["strongest line", "[shaft] speed"],
        },
        Wrong {
            name: "another rate, without a keyphasor",
            scene: rate,
            recording: plain(),
            says: vec!["strongest line", "rate"],
        },
        in_both(
            "another number of balls",
            &[
                ("elements = 9", "elements = 8"),
                (
                    "name = \"NDE\"\nstation = \"100 mm\"\nfacing = \"both\"\nmodel = \"angular\"\nelements = 9",
                    "name = \"NDE\"\nstation = \"100 mm\"\nfacing = \"both\"\nmodel = \"angular\"\nelements = 8",
                ),
            ],
            include_str!("../recordings/outer-spall.csv").to_owned(),
            &["elements = 9"],
        ),
        in_recording("a machine that is lifted off its bearings", column(5, |_, _| 0.0), &["no element carries load"]),
    ]
}

/// Runs `check` and `replay` and returns the message.
fn message(wrong: &Wrong) -> String {
    let Wrong { name, scene, recording, says } = wrong;
    let sandbox = Sandbox::with(scene, recording);
    let replayed = sandbox.run(&["replay", "scene.toml", "--format", "json", "--learn", "learned.json"]);
    assert!(!sandbox.files().contains(&"learned.json".to_owned()), "{name}: it is no baseline");
    let message = match replayed.code {
        Some(1 | 2) => {
            let error = replayed.err.trim_end().to_owned();
            assert_eq!((error.lines().count(), replayed.out.as_str()), (1, ""), "{name}: {replayed:?}");
            error.strip_prefix("ballrace: ").unwrap().to_owned()
        }
        Some(0 | 4) => {
            let outcome: Value = replayed.json();
            assert!(list(&outcome, "findings").is_empty() && outcome["diagnosis"].is_null(), "{name}: {outcome:#}");
            let implausible = list(&outcome, "implausible");
            assert_eq!(replayed.code == Some(4), !implausible.is_empty(), "{name}: {outcome:#}");
            match implausible.first() {
                Some(one) => {
                    let part = |key: &str| one[key].as_str().unwrap();
                    format!(
                        "{}: {}. Probable cause: {}. Remedy: {}",
                        part("subject"),
                        part("found"),
                        part("cause"),
                        part("remedy")
                    )
                }
                None => outcome["verdict"].as_str().unwrap().to_owned(),
            }
        }
        _ => panic!("{name}: {replayed:?}"),
    };
    for part in says {
        assert!(message.contains(part), "{name}: {message}, expected {part}");
    }
    let checked = sandbox.run(&["check", "scene.toml"]);
    // Two checks need the motion of the twin, which `check` does not compute.
    let needs_twin = message.contains("carries load") || message.starts_with("No verdict");
    assert!(checked.code != Some(0) || needs_twin, "{name}: {checked:?}");
    message
}

#[test]
fn each_gives_one_message_and_no_diagnosis() {
    let groups = [("Keys and units", keys_and_units()), ("Files", files()), ("Machine and recording", machines())];
    assert!(groups.iter().map(|(_, all)| all.len()).sum::<usize>() >= 40);
    let mut chapter = String::from(
        "# Wrong inputs\n\nEach of these inputs gives one message and no diagnosis. They are changes of the scene and the recording of the \
         demonstration. A test makes them and writes the messages below.\n",
    );
    for (title, all) in groups {
        chapter += &format!("\n## {title}\n\n| input | message |\n| --- | --- |\n");
        for wrong in all {
            let message = message(&wrong).replace('|', "\\|").replace('<', "&lt;");
            chapter += &format!("| {} | {message} |\n", wrong.name);
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/wrong-inputs.md");
    if std::env::var_os("BALLRACE_WRITE").is_some() {
        std::fs::write(&path, &chapter).unwrap();
    }
    let kept = std::fs::read_to_string(path).unwrap();
    assert_eq!(kept, chapter, "BALLRACE_WRITE=1 rewrites it");
}
