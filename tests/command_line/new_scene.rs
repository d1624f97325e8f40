//! `new` and `check`: from a designation and a recording to a scene, and each wrong input with its probable cause.

use crate::support::{
    DEMO_SCENE, DIAGNOSED, HEALTHY_RECORDING, Sandbox, TURN, changed, demonstrated, head, list, number,
    short_recording, swap,
};
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Values of the demonstration's rotor and probes, as a user would fill them in.
const FILLED: [(&str, &str); 4] = [
    ("mass = \"?\"", "mass = \"6 kg\"\nload = [0, 0, 60, 0, 0]"),
    ("diametral_inertia = \"?\"", "diametral_inertia = \"0.03 kg m^2\""),
    ("polar_inertia = \"?\"", "polar_inertia = \"0.006 kg m^2\""),
    ("damping = \"?\"", "damping = [400, 400, 400, 0.4, 0.4]"),
];

/// Replaces each `"?"` of the draft.
fn filled(draft: &str) -> String {
    let text = FILLED.iter().fold(draft.to_owned(), |text, (from, to)| swap(&text, from, to));
    let mut stations = ["-100 mm", "100 mm", "-120 mm", "-120 mm", "120 mm", "120 mm"].into_iter();
    let mut parts = text.split("station = \"?\"");
    let mut full = parts.next().unwrap().to_owned();
    for part in parts {
        full += &format!("station = \"{}\"{part}", stations.next().unwrap());
    }
    assert!(stations.next().is_none(), "{text}");
    full
}

/// A scene of the demonstration's machine from the catalogue, with `recording` as `run.csv`.
fn drafted(recording: &str) -> Sandbox {
    let sandbox = Sandbox::empty();
    sandbox.put("run.csv", recording);
    let bearings = ["new", "--bearing", "6205", "--bearing", "SKF 6205-2RS1", "--recording", "run.csv"];
    sandbox.done(&[&bearings[..], &["--speed", "3000 rpm", "-o", "pump.toml"]].concat());
    sandbox
}

/// The transcript of the user guide, run in its order, with a sound recording and one with a spall.
#[test]
fn from_a_designation_to_a_report_in_the_documented_commands() {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/src/guide.md");
    let guide = fs::read_to_string(guide).unwrap();
    let transcript = guide.split_once("<!-- first-machine:begin -->").unwrap().1;
    let transcript = transcript.split_once("<!-- first-machine:end -->").unwrap().0;
    let commands: Vec<&str> = transcript.lines().filter_map(|line| line.strip_prefix("ballrace ")).collect();
    assert!((3..=6).contains(&commands.len()), "{commands:?}");

    let sandbox = Sandbox::empty();
    sandbox.put("run.csv", fs::read_to_string(demonstrated("healthy.csv")).unwrap());
    sandbox.put("today.csv", fs::read_to_string(demonstrated("outer-spall.csv")).unwrap());
    for command in commands {
        let words: Vec<String> = command
            .split('"')
            .enumerate()
            .flat_map(|(i, part)| match i % 2 {
                0 => part.split_whitespace().map(str::to_owned).collect(),
                _ => vec![part.to_owned()],
            })
            .collect();
        let args: Vec<&str> = words.iter().map(String::as_str).collect();
        if args[0] == "check" {
            let open = sandbox.run(&args);
            assert_eq!(open.code, Some(2), "{open:?}");
            assert_eq!(open.out.lines().count(), 10, "{open:?}");
            assert!(open.err.contains("unknown values"), "{open:?}");
            sandbox.put("pump.toml", filled(&sandbox.read("pump.toml")));
        }
        if args.contains(&"--baseline") {
            let outcome: Value = sandbox.run(&[&args[..], &["--format", "json"]].concat()).json();
            let findings = list(&outcome, "findings");
            assert_eq!(findings.len(), 1, "{outcome:#}");
            let first = &findings[0];
            assert_eq!((first["kind"].as_str(), first["bearing"].as_str()), (Some("outer-race"), Some("DE")));
            // From the catalogue, with a clearance that is 2.5 um off: the spall is at 270 deg.
            let [low, high] = ["/low", "/high"].map(|end| number(&first["azimuth_deg"], end));
            assert!(low < 270.0 && 270.0 < high && high - low < 15.0, "{first:#}");
            assert!(sandbox.files().iter().any(|name| name.starts_with("pump-") && name.ends_with("report.html")));
        } else {
            sandbox.done(&args);
        }
    }
}

#[test]
fn a_catalogue_bearing_is_the_bearing_of_its_numbers() {
    let sandbox = Sandbox::empty();
    let own = "[shaft]\nspeed = \"3000 rpm\"\n[[bearing]]\nname = \"DE\"\nstation = \"0 mm\"\n";
    sandbox.put("listed.toml", format!("{own}bearing = \"6205\"\ndiametral_clearance = \"10 um\"\n"));
    let numbers = "model = \"angular\"\nelements = 9\nball_diameter = \"7.9375 mm\"\npitch_diameter = \"39.04 mm\"\n\
                   inner_conformity = 0.52\nouter_conformity = 0.52\ndiametral_clearance = \"10 um\"\n";
    sandbox.put("numbers.toml", format!("{own}{numbers}"));
    sandbox.put("F.csv", "u,v,w,thu,thv\n8e-6,-2e-6,3e-5,1e-4,0\n");
    let force = |scene| sandbox.done(&["force", scene, "--displacements", "F.csv", "--format", "csv"]).out;
    assert_eq!(force("listed.toml"), force("numbers.toml"));
    sandbox.put("wrong.toml", format!("{own}bearing = \"6399\"\n"));
    sandbox.refused(&["check", "wrong.toml"], 2, &["wrong.toml:6: bearing[0].bearing", "6399", "ballrace new --list"]);
    // A value that does not fit the rest of the bearing names the key at the line of the designation.
    sandbox.put("small.toml", format!("{own}bearing = \"6205\"\nball_diameter = \"40 mm\"\n"));
    sandbox.refused(&["check", "small.toml"], 2, &["small.toml:6: bearing[0].pitch_diameter", "above ball_diameter"]);
}

/// The clearance of the catalogue is 2.5 um off: no load is made of that, and a spall is found all the same.
#[test]
fn an_estimated_clearance_is_no_load() {
    let sandbox = drafted(&short_recording(DIAGNOSED));
    sandbox.put("pump.toml", filled(&sandbox.read("pump.toml")));
    sandbox.put("today.csv", head(include_str!("../recordings/outer-spall.csv"), DIAGNOSED));
    let sound = sandbox.replay("pump.toml", &[]);
    assert!(
        list(&sound, "findings")
            .iter()
            .all(|diagnosis| diagnosis["kind"] != "load" && diagnosis["kind"] != "clearance")
    );
    let notes = list(&sound, "notes");
    let is_explained =
        |note: &Value| note.as_str().unwrap().contains("the clearance of DE and NDE is that of the catalogue");
    assert!(notes.iter().any(is_explained), "{notes:#?}");
    sandbox.done(&["replay", "pump.toml", "--learn", "sound.json"]);
    let faulty = sandbox.replay("pump.toml", &["--recording", "today.csv", "--baseline", "sound.json"]);
    assert_eq!(list(&faulty, "findings")[0]["kind"].as_str(), Some("outer-race"), "{faulty:#}");
}

#[test]
fn rollers_of_the_catalogue() {
    let sandbox = Sandbox::empty();
    let machine = swap(DEMO_SCENE, "[recording]", "#");
    let machine = machine.split("[[bearing]]").next().unwrap().to_owned();
    let bearing = |name, station, designation: &str| {
        format!("[[bearing]]\nname = \"{name}\"\nstation = \"{station} mm\"\nbearing = \"{designation}\"\n")
    };
    sandbox.put("m.toml", machine + &bearing("DE", -100, "6205") + &bearing("NDE", 100, "NU205"));
    let settled: Value = sandbox.done(&["equilibrium", "m.toml", "--format", "json"]).json();
    assert!(number(&settled, "/residual") < 1e-9, "{settled:#}");
    let checked: Value = sandbox.done(&["check", "m.toml", "--format", "json"]).json();
    assert_eq!(checked["bearings"][1]["designation"].as_str(), Some("NU205"));
}

#[test]
fn the_list_of_the_catalogue() {
    let sandbox = Sandbox::empty();
    let text = sandbox.done(&["new", "--list"]).out;
    assert!(text.lines().any(|line| line.starts_with("6309 ")), "{text}");
    let rows: Value = sandbox.done(&["new", "--list", "--format", "json"]).json();
    let six = rows.as_array().unwrap().iter().find(|row| row["designation"] == "6205").unwrap();
    assert!((number(six, "/outer_race_order") - 3.585).abs() < 0.002);
    let csv = sandbox.done(&["new", "--list", "--format", "csv"]).out;
    assert_eq!(csv.lines().count(), rows.as_array().unwrap().len() + 1);
}

/// The path of a recording beside the folder of the scene leads there from the scene, wherever both are moved.
#[test]
fn a_recording_in_another_folder() {
    let sandbox = Sandbox::empty();
    fs::create_dir_all(sandbox.path("scenes/pumps")).unwrap();
    fs::create_dir_all(sandbox.path("recordings")).unwrap();
    sandbox.put("recordings/run.csv", short_recording(SAMPLES));
    let args = ["new", "--bearing", "6205", "--recording", "recordings/run.csv", "-o", "scenes/pumps/a.toml"];
    sandbox.done(&args);
    let text = sandbox.read("scenes/pumps/a.toml");
    assert!(text.contains("\"../../recordings/run.csv\""), "{text}");
}

#[test]
fn wrong_options_of_new() {
    let sandbox = Sandbox::empty();
    sandbox.refused(&["new"], 2, &["--bearing", "6309"]);
    sandbox.refused(&["new", "--bearing", "62x9"], 2, &["62x9", "ballrace new --list"]);
    sandbox.refused(&["new", "--bearing", "6205", "--speed", "50 Hz"], 2, &["--speed"]);
    sandbox.refused(&["new", "--bearing", "6205", "--set", "mass"], 2, &["--set", "KEY=VALUE"]);
    sandbox.refused(&["new", "--bearing", "6205", "--set", "rotors.mass=3"], 2, &["--set", "rotors.mass"]);
    let speed = "--set: no unit: \"shaft.speed=3000\", expected \"shaft.speed=3000 rpm\" or \"shaft.speed=3000 rad/s\"";
    sandbox.refused(&["new", "--bearing", "6205", "--set", "shaft.speed=3000"], 2, &[speed]);
    let station = ["new", "--bearing", "6205", "--set", "rotor.mass=6", "--set", "bearing[0].station=-100"];
    sandbox.refused(&station, 2, &["bearing[0].station=-100 um"]);
    sandbox.refused(&["new", "--bearing", "6205", "--recording", "none.csv"], 1, &["none.csv"]);
    sandbox.put("old.toml", "mine");
    sandbox.refused(&["new", "--bearing", "6205", "-o", "old.toml"], 2, &["old.toml", "exists"]);
    assert_eq!(sandbox.read("old.toml"), "mine");
    let text = sandbox.done(&["new", "--bearing", "6205", "--set", "rotor.mass=6 kg"]).out;
    assert!(text.contains("mass = \"6 kg\""), "{text}");
}

const SAMPLES: usize = 16 * TURN;

/// Checks the demonstration's scene after changes of its text, with a recording; returns the implausibilities.
fn found(swaps: &[(&str, &str)], recording: &str) -> Vec<[String; 4]> {
    let scene = swaps.iter().fold(DEMO_SCENE.to_owned(), |text, (from, to)| swap(&text, from, to));
    let sandbox = Sandbox::with(&scene, recording);
    let answer = sandbox.run(&["check", "scene.toml", "--format", "json"]);
    let checked: Value = answer.json();
    let found = list(&checked, "implausible");
    assert_eq!(answer.code, Some(if found.is_empty() { 0 } else { 4 }), "{answer:?}");
    let text = |one: &Value, key: &str| one[key].as_str().unwrap().to_owned();
    found.iter().map(|one| ["subject", "found", "cause", "remedy"].map(|key| text(one, key))).collect()
}

#[test]
fn the_demonstration_is_plausible() {
    assert_eq!(found(&[], HEALTHY_RECORDING), Vec::<[String; 4]>::new());
    let drafted = drafted(&short_recording(SAMPLES));
    drafted.put("pump.toml", filled(&drafted.read("pump.toml")));
    let text = drafted.done(&["check", "pump.toml", "--svg", "pump.svg"]).out;
    assert!(
        text.contains("[X]") && text.contains("DE_X_um 0°") && text.contains("Nothing implausible found"),
        "{text}"
    );
    assert!(drafted.read("pump.svg").starts_with("<svg"));
}

/// A designer has no recording yet: the example of the draft, uncommented, is simulated, checked and replayed.
#[test]
fn the_example_of_a_recording() {
    let sandbox = Sandbox::empty();
    sandbox.done(&["new", "--bearing", "6205", "--bearing", "6205", "--speed", "3000 rpm", "-o", "pump.toml"]);
    let draft = sandbox.read("pump.toml");
    let (machine, example) = draft.split_once("# No recording was given.").unwrap();
    let lines = example.lines().skip(1).map(|line| line.strip_prefix("# ").unwrap_or(line));
    let recording = lines.collect::<Vec<_>>().join("\n");
    let machine = FILLED.iter().fold(machine.to_owned(), |text, (from, to)| swap(&text, from, to));
    let station = "station = \"?\"";
    let machine = machine.replacen(station, "station = \"-100 mm\"", 1).replacen(station, "station = \"100 mm\"", 1);
    sandbox.put("pump.toml", format!("{machine}\n{recording}\n"));
    // The machine is drawn before its recording exists.
    let answer = sandbox.run(&["check", "pump.toml"]);
    assert_eq!(answer.code, Some(1), "{answer:?}");
    assert!(answer.out.contains("[X]") && answer.err.contains("run.csv: cannot be opened"), "{answer:?}");
    let args = ["simulate", "pump.toml", "--as-recording", "--duration", "1 s", "--settle", "0 s", "-o", "run.csv"];
    sandbox.done(&args);
    assert!(sandbox.done(&["check", "pump.toml"]).out.contains("Nothing implausible found"));
    let outcome = sandbox.replay("pump.toml", &[]);
    assert!(list(&outcome, "findings").is_empty(), "{}", outcome["verdict"]);
}

/// One wrong input each, with a part of its probable cause or remedy.
#[test]
fn wrong_inputs_and_their_causes() {
    let plain = short_recording(SAMPLES);
    let probes = |factor: f64| changed(SAMPLES, move |_, k, x| if (1..6).contains(&k) { factor * x } else { x });
    let keyphasor = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
    let speed_in = |unit: &str| format!("speed = {{ column = \"keyphasor\", unit = \"{unit}\" }}");
    let constant = |value: f64| changed(SAMPLES, move |_, k, x| if k == 6 { value } else { x });
    let exchanged = "\"DE_Y_um\", unit = \"um\", station = \"-120 mm\", angle = \"90 deg\"";
    let other_way = exchanged.replace("90 deg", "-90 deg");
    let (nde, nde_other) = (
        exchanged.replace("\"DE_Y", "\"NDE_Y").replace("-120", "120"),
        other_way.replace("\"DE_Y", "\"NDE_Y").replace("-120", "120"),
    );
    /// Name, changes of the scene, recording, part of cause or remedy.
    type Case<'a> = (&'a str, &'a [(&'a str, &'a str)], String, &'a str);
    let cases: [Case; 11] = [
        ("marks on the shaft", &[("3000 rpm", "1500 rpm")], plain.clone(), "pulses_per_turn = 2"),
        ("another speed", &[("3000 rpm", "1100 rpm")], plain.clone(), "[shaft] speed"),
        ("rev/s for rpm", &[(keyphasor, &speed_in("rev/s"))], constant(3000.0), "rev/s and rpm"),
        ("rad/s for rpm", &[(keyphasor, &speed_in("rad/s"))], constant(3000.0), "rad/s and rpm"),
        ("mm for um", &[], probes(0.001), "possible in mm"),
        ("nm for um", &[], probes(1000.0), "possible in nm"),
        ("micro-inches for um", &[], probes(39.37), "another unit"),
        ("an offset", &[], changed(SAMPLES, |_, k, x| if k == 1 { x + 900.0 } else { x }), "offset = \"900"),
        (
            "one direction",
            &[(exchanged, &exchanged.replace("90", "0")), (&nde, &nde.replace("90", "0"))],
            plain.clone(),
            "gives",
        ),
        ("other way", &[(exchanged, &other_way), (&nde, &nde_other)], plain.clone(), "columns of X and Y exchanged"),
        ("one plane", &[], changed(SAMPLES, |_, k, x| if k == 3 || k == 4 { 0.001 * x } else { x }), "a dead probe"),
    ];
    for (name, swaps, recording, part) in cases {
        let found = found(swaps, &recording);
        let all = found.iter().flatten().cloned().collect::<Vec<_>>().join("; ");
        assert!(!found.is_empty(), "{name}: nothing found");
        assert!(all.contains(part) || name == "one direction" && all.contains("same direction"), "{name}: {all}");
    }
}

#[test]
fn a_dead_keyphasor_and_a_slow_recorder() {
    let dead = changed(SAMPLES, |i, k, x| if k == 6 && i > 2 * TURN { 0.0 } else { x });
    let found_dead = found(&[], &dead);
    assert!(found_dead.is_empty() || found_dead[0][0] == "shaft angle", "{found_dead:?}");
    let none = changed(SAMPLES, |_, k, x| if k == 6 { 0.0 } else { x });
    assert!(found(&[], &none)[0][2].contains("dead keyphasor"), "{:?}", found(&[], &none));
    let slow =
        found(&[("rate = \"12.8 kHz\"", "rate = \"128 Hz\""), ("3000 rpm", "30 rpm")], &short_recording(SAMPLES));
    assert!(slow.iter().all(|one| one[0] != "recording.rate"), "30 rpm needs 7 Hz: {slow:?}");
}

/// The draft takes names, directions, noise and offsets from the recording, and states which of them are estimates.
#[test]
fn probes_of_a_draft() {
    // Between -0.5 and 0.5 by a hash of the row and the column.
    let noise = |row: u32, column: u32| {
        let mut hash = row ^ (column << 20);
        for factor in [0x7feb_352d_u32, 0x846c_a68b] {
            hash = (hash ^ (hash >> 16)).wrapping_mul(factor);
        }
        f64::from(hash ^ (hash >> 16)) / f64::from(u32::MAX) - 0.5
    };
    let table = |names: &str| {
        let row = |i: u32| {
            let turn = 2.0 * std::f64::consts::PI * f64::from(i) / 256.0;
            let mark = if i % 256 < 8 { -8.0 } else { -2.0 };
            let probe = |mean: f64, phase: f64, of: u32| mean + (turn + phase).cos() + 0.173 * noise(i, of);
            format!(
                "{:.3},{:.3},{:.3},{:.3}\n",
                probe(0.4, 0.0, 1),
                probe(1650.0, 1.0, 2),
                mark + 0.1 * noise(i, 3),
                i % 3
            )
        };
        format!("{names}\n{}", (0..4096).map(row).collect::<String>())
    };
    let draft = |names: &str| {
        let sandbox = Sandbox::empty();
        sandbox.put("run.csv", table(names));
        sandbox.done(&["new", "--bearing", "6205", "--recording", "run.csv"]).out
    };
    let text = draft("DE_45_um,DE_135_um,KP_V,note");
    assert!(text.contains("keyphasor = { column = \"KP_V\", pulses_per_turn = 1 }"), "{text}");
    let probe = |column: &str| {
        let line = text.lines().find(|line| line.contains(column)).unwrap_or_else(|| panic!("{text}"));
        let number = |key: &str| {
            let value = line.split_once(&format!("{key} = \""))?.1.split(' ').next()?;
            value.parse::<f64>().ok()
        };
        (line.to_owned(), number("angle"), number("noise").unwrap(), number("offset"))
    };
    // Noise of a uniform distribution of 0.173 um, whose standard deviation is 0.05 um.
    let (line, angle, noise_um, offset) = probe("DE_45_um");
    assert_eq!((angle, offset), (Some(45.0), None), "{line}");
    assert!((0.035..0.065).contains(&noise_um), "{line}");
    assert!(
        line.contains("noise estimated from 4096 rows; mean 0.4") && line.contains("within the clearance"),
        "{line}"
    );
    let (line, angle, noise_um, offset) = probe("DE_135_um");
    assert_eq!(angle, Some(135.0), "{line}");
    assert!((0.035..0.065).contains(&noise_um) && (offset.unwrap() - 1650.0).abs() < 0.1, "{line}");
    assert!(line.contains("noise and offset estimated from 4096 rows: the mean is beyond the clearance"), "{line}");

    // Columns without a unit keep their names.
    let text = draft("DE_X,DE_Y,kp,note");
    assert!(text.contains("keyphasor = { column = \"kp\""), "{text}");
    for line in [
        "{ column = \"DE_X\", unit = \"?\", station = \"?\", angle = \"0 deg\" },",
        "{ column = \"DE_Y\", unit = \"?\", station = \"?\", angle = \"90 deg\" },",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let text = draft("DE_3_um,b,kp,t");
    assert!(probe_line(&text, "DE_3_um").contains("angle = \"?\", noise = "), "{text}");
    assert!(probe_line(&text, "DE_3_um").contains("# unit by the name of the column; noise"), "{text}");
}

/// Returns the line of a draft with this column.
fn probe_line<'a>(draft: &'a str, column: &str) -> &'a str {
    draft.lines().find(|line| line.contains(&format!("column = \"{column}\""))).unwrap_or_default()
}
