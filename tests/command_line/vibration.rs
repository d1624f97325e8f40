//! Recordings of vibration: measured ones, of machines whose damage is known, and files that are none.

use serde_json::Value;

use crate::live::{connected, frame, listening, outcome};
use crate::support::{DEMO_SCENE, Sandbox, recorded, swap};
use std::io::Write;

/// A scene of one bearing with one sensor.
pub fn scene(rpm: f64, [elements, ball, pitch]: [f64; 3], file: &str, rate: &str, column: &str, unit: &str) -> String {
    format!(
        "[shaft]\nspeed = \"{rpm} rpm\"\n[[bearing]]\nname = \"B\"\nstation = \"0 mm\"\nfacing = \"both\"\nmodel = \"angular\"\n\
         elements = {elements}\nball_diameter = \"{ball} mm\"\npitch_diameter = \"{pitch} mm\"\ninner_conformity = 0.52\n\
         outer_conformity = 0.52\ncontact_angle = \"0 deg\"\n[recording]\nfile = {file:?}\nrate = \"{rate}\"\n\
         sensors = [{{ column = \"{column}\", unit = \"{unit}\" }}]\n"
    )
}

fn diagnoses(sandbox: &Sandbox) -> Vec<(String, f64)> {
    let outcome = sandbox.replay("scene.toml", &[]);
    let all = outcome.pointer("/findings").and_then(Value::as_array).unwrap();
    all.iter().map(|f| (f["kind"].as_str().unwrap().to_owned(), f["line_hz"].as_f64().unwrap())).collect()
}

/// Support force of a faulty NMB 1560KK (pybearing 1.0.4, MIT License): the envelope of 100 to 300 Hz has 22.4 Hz, the
/// inner race's ball-pass frequency.
#[test]
fn the_miniature_bearing_has_a_bad_inner_race() {
    let sandbox = Sandbox::empty();
    let file = recorded("real/support_force_306rpm_6400Hz.csv");
    sandbox.put("scene.toml", scene(306.0, [7.0, 2.770, 10.514], &file, "6400 Hz", "force_N", "N"));
    let found = diagnoses(&sandbox);
    assert!(matches!(&found[..], [(kind, hz)] if kind == "inner-race" && (hz - 22.4).abs() < 0.3), "{found:?}");
    // Only 2X of the shaft stands out, which does not determine the speed: at another one nothing is named.
    sandbox.put("scene.toml", scene(1.03 * 306.0, [7.0, 2.770, 10.514], &file, "6400 Hz", "force_N", "N"));
    assert_eq!(diagnoses(&sandbox), []);
    let outcome = sandbox.replay("scene.toml", &[]);
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(verdict.starts_with("No verdict: the speed is not determined"), "{verdict}");
    assert!(verdict.contains("the line at 22.4 Hz would be that of the inner race of B"), "{verdict}");
}

/// The same recording with a bearing that has no model: by its diameters, and by the orders of a data sheet.
#[test]
fn a_bearing_for_vibration_alone_has_no_model() {
    let sandbox = Sandbox::empty();
    let file = recorded("real/support_force_306rpm_6400Hz.csv");
    let scene = |bearing: &str| {
        format!(
            "shaft.speed = \"306 rpm\"\n[[bearing]]\nname = \"B\"\n{bearing}\n[recording]\nfile = {file:?}\n\
             rate = \"6400 Hz\"\nsensors = [{{ column = \"force_N\", unit = \"N\" }}]\n"
        )
    };
    let diameters =
        "elements = 7\nball_diameter = \"2.770 mm\"\npitch_diameter = \"10.514 mm\"\ncontact_angle = \"0 deg\"";
    let orders = "orders = { outer = 2.578, inner = 4.422, element = 1.766, cage = 0.368 }";
    for (bearing, missing) in [
        (diameters, "missing keys model, inner_conformity and outer_conformity"),
        (orders, "missing keys model, elements, ball_diameter, pitch_diameter, contact_angle, inner_conformity and"),
    ] {
        sandbox.put("scene.toml", scene(bearing));
        let found = diagnoses(&sandbox);
        assert!(matches!(&found[..], [(kind, hz)] if kind == "inner-race" && (hz - 22.4).abs() < 0.3), "{found:?}");
        let check = sandbox.run(&["check", "scene.toml"]);
        let text = check.out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            check.code == Some(0) && text.contains("Bearing B has no model: vibration sensors are diagnosed"),
            "{text}"
        );
        assert!(text.contains("B - kinematics 7 2.57"), "{text}");
        sandbox.put("u.csv", "u,v,w,thu,thv\n0,0,0,0,0\n");
        let rotor = "[rotor]\nmass = 1\ndiametral_inertia = 1\npolar_inertia = 1\n";
        let with_rotor =
            swap(&swap(&scene(bearing), "name", "station = 0\nname"), "[recording]", &format!("{rotor}[recording]"));
        sandbox.put("rotor.toml", &with_rotor);
        sandbox.put(
            "probes.toml",
            swap(&with_rotor, "sensors = [{ column", "probes = [{ station = 0, angle = 0, column")
                .replace("\"N\"", "\"um\""),
        );
        for command in [
            &["force", "scene.toml", "--displacements", "u.csv"][..],
            &["equilibrium", "scene.toml"],
            &["simulate", "scene.toml", "--duration", "1 s", "--rate", "1 kHz", "-o", "o.csv"],
            &["trade", "scene.toml"],
            &["bake", "scene.toml", "-o", "b.rs"],
            &["campbell", "rotor.toml"],
            &["equilibrium", "rotor.toml"],
            &["fit", "probes.toml"],
            &["replay", "probes.toml", "--report", "r.html"],
        ] {
            let run = sandbox.run(command);
            let lines = run.err.lines().filter(|line| !line.trim().is_empty()).count();
            assert!(
                run.code == Some(2) && lines == 1 && run.err.contains(missing),
                "{command:?}: {:?} {}",
                run.code,
                run.err
            );
        }
    }
}

/// Housing acceleration of an SKF 6205 (Case Western Reserve University Bearing Data Center), where the files are at hand.
#[test]
fn bearings_of_type_6205_are_distinguished() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/recordings/real/cwru_6205/");
    let records = [
        ("12k_Drive_End_IR007_0_105.mat", 1797.0, "12 kHz", "X105", Some(("inner-race", 161.7))),
        ("12k_Drive_End_OR007@6_0_130.mat", 1796.0, "12 kHz", "X130", Some(("outer-race", 107.6))),
        ("normal_0_97.mat", 1796.0, "48 kHz", "X097", None),
    ];
    for (name, rpm, rate, of, expected) in records {
        let file = format!("{folder}{name}");
        if !std::path::Path::new(&file).is_file() {
            println!("{name} is not here: not tried");
            continue;
        }
        for sensor in ["DE", "FE"] {
            let sandbox = Sandbox::empty();
            let column = format!("{of}_{sensor}_time");
            sandbox.put("scene.toml", scene(rpm, [9.0, 7.94, 39.04], &file, rate, &column, "g"));
            let found = diagnoses(&sandbox);
            println!("{column}: {found:?}");
            match (expected, &found[..]) {
                (None, []) => {}
                // Within 1.5 % of geometry.
                (Some((kind, hz)), [(k, line)]) if k == kind && (line / hz - 1.0).abs() < 0.015 => {}
                _ => panic!("{column}: {found:?}"),
            }
        }
    }
}

/// A MATLAB file of version 5 with one vector.
fn mat(name: &str, values: &[f64]) -> Vec<u8> {
    let element = |kind: u32, bytes: &[u8]| {
        let mut out = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
        out.extend(bytes);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let numbers: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    let size: Vec<u8> = [values.len() as i32, 1].iter().flat_map(|n| n.to_le_bytes()).collect();
    let parts =
        [element(6, &[6, 0, 0, 0, 0, 0, 0, 0]), element(5, &size), element(1, name.as_bytes()), element(9, &numbers)];
    let mut out = b"MATLAB 5.0 MAT-file, made by a test".to_vec();
    out.resize(124, b' ');
    out.extend([0, 1, b'I', b'M']);
    out.extend(element(14, &parts.concat()));
    out
}

#[test]
fn matlab_files_are_read_or_refused() {
    let sandbox = Sandbox::empty();
    let whole = mat("a", &(0..4000).map(|i| f64::from(i * 37 % 101)).collect::<Vec<_>>());
    sandbox.put("scene.toml", scene(3000.0, [9.0, 7.94, 39.04], "r.mat", "6 kHz", "a", "m/s^2"));
    sandbox.put("r.mat", &whole);
    let outcome = sandbox.replay("scene.toml", &[]);
    assert_eq!(outcome.pointer("/record/samples").and_then(Value::as_u64), Some(4000));
    for (bytes, says) in [
        (&whole[..whole.len() / 2], "expected a MATLAB file of version 5"),
        (&whole[..140], "expected a MATLAB file of version 5"),
        (&mat("b", &[1.0; 4000])[..], "no such column: `a`"),
    ] {
        sandbox.put("r.mat", bytes);
        let run = sandbox.run(&["replay", "scene.toml", "--report", "r.html"]);
        assert!(run.code != Some(0) && run.err.contains(says), "{}", run.err);
    }
}

#[test]
fn sensors_are_checked() {
    let good = scene(3000.0, [9.0, 7.94, 39.04], "r.csv", "6 kHz", "a", "m/s^2");
    let sandbox = Sandbox::empty();
    sandbox.put("r.csv", "a\n".to_owned() + &"1\n2\n".repeat(100));
    for (from, to, says) in [
        ("unit = \"m/s^2\"", "unit = \"um\"", "m/s^2, g, m/s, mm/s, N, V"),
        ("rate =", "average = 4\nrate =", "average without probes"),
        ("unit = \"m/s^2\"", "unit = \"m/s^2\", bearing = \"X\"", "the name of a [[bearing]]"),
        ("sensors =", "probes = []\nsensors =", "a list of at least one probe"),
        ("rate = \"6 kHz\"", "rate = \"6 kHz\"", "turns of the shaft, expected 16 or more"),
    ] {
        sandbox.put("scene.toml", good.replacen(from, to, 1));
        let run = sandbox.run(&["replay", "scene.toml", "--report", "r.html"]);
        assert!(run.code != Some(0) && run.err.contains(says), "{says}: {}", run.err);
    }
}

/// The demonstration's recording `of` with an accelerometer at the drive end that rings `order` times a turn, in noise.
fn with_accelerometer(of: &str, order: f64) -> String {
    let text = std::fs::read_to_string(recorded(of)).unwrap();
    let mut lines = text.lines();
    let mut out = lines.next().unwrap().to_owned() + ",DE_acc_g\n";
    let (mut state, mut next, mut hit) = (1_u64, 0.5, -1.0);
    for (i, line) in lines.enumerate() {
        let time = i as f64 / 12_800.0;
        if order * 50.0 * time >= next {
            (next, hit) = (next + 1.0, time);
        }
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let noise = (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
        let since = time - hit;
        let ring = if order > 0.0 {
            3.0 * (-900.0 * since).exp() * (4100.0 * std::f64::consts::TAU * since).sin()
        } else {
            0.0
        };
        out += &format!("{line},{:.5}\n", 0.2 * noise + ring);
    }
    out
}

/// The demonstration's scene with the accelerometer, beside the probes.
fn scene_of_both() -> String {
    swap(
        DEMO_SCENE,
        "keyphasor = {",
        "sensors = [{ column = \"DE_acc_g\", unit = \"g\", bearing = \"DE\" }]\nkeyphasor = {",
    )
}

fn all_diagnoses(outcome: &Value) -> Vec<Value> {
    outcome["findings"].as_array().unwrap().clone()
}

/// Order of the outer race of the demonstration's bearings.
const OUTER: f64 = 4.5 * (1.0 - 7.94 / 39.04);

#[test]
fn an_accelerometer_beside_the_probes() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene_of_both());
    // The probes show the spall too: one diagnosis.
    sandbox.put("healthy.csv", with_accelerometer("outer-spall.csv", OUTER));
    let outcome = sandbox.replay("scene.toml", &[]);
    let found = all_diagnoses(&outcome);
    let same: Vec<&Value> = found.iter().filter(|f| f["kind"] == "outer-race" && f["bearing"] == "DE").collect();
    assert_eq!(same.len(), 1, "{found:?}");
    assert_eq!(same[0]["evidence"], serde_json::json!(["shaft-motion", "vibration"]));
    assert_eq!(same[0]["vibration"]["sensor"], "DE_acc_g");
    assert!(same[0]["depth_um"]["value"].as_f64().unwrap() > 0.1);
    // The probes show a sound machine: the diagnosis is that of the accelerometer.
    sandbox.put("healthy.csv", with_accelerometer("healthy.csv", OUTER));
    let outcome = sandbox.replay("scene.toml", &["--report", "r.html"]);
    let found = all_diagnoses(&outcome);
    assert!(
        matches!(&found[..], [f] if f["kind"] == "outer-race" && f["evidence"] == serde_json::json!(["vibration"])),
        "{found:?}"
    );
    assert!(outcome["verdict"].as_str().unwrap().starts_with("The vibration shows a fault. Outer race of DE"));
    assert!(
        found[0]["sentence"].as_str().unwrap().ends_with("The vibration alone shows it, the shaft motion does not.")
    );
    assert!(sandbox.read("r.html").contains("Envelope spectrum of"));
    // Noise: no diagnosis, and the probes are replayed as without the sensor.
    sandbox.put("healthy.csv", with_accelerometer("healthy.csv", 0.0));
    let with = sandbox.replay("scene.toml", &[]);
    assert_eq!(all_diagnoses(&with), [] as [Value; 0]);
    assert!(with["notes"].as_array().unwrap().iter().any(|note| note.as_str().unwrap().starts_with("DE_acc_g: ")));
    sandbox.put("scene.toml", DEMO_SCENE);
    let without = sandbox.replay("scene.toml", &[]);
    assert_eq!(with["probes"], without["probes"]);
    assert_eq!(with["bearings"], without["bearings"]);
}

/// A sensor with a keyphasor or a speed column, without probes and without a rotor.
#[test]
fn sensors_at_a_measured_speed() {
    let sandbox = Sandbox::empty();
    sandbox.put("r.csv", with_accelerometer("healthy.csv", OUTER));
    let keyed = scene(3000.0, [9.0, 7.94, 39.04], "r.csv", "12.8 kHz", "DE_acc_g", "g")
        + "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }\n";
    sandbox.put("scene.toml", &keyed);
    let outcome = sandbox.replay("scene.toml", &[]);
    let found = all_diagnoses(&outcome);
    assert!(matches!(&found[..], [f] if f["kind"] == "outer-race"), "{found:?}");
    assert!(outcome["record"]["angle_source"].as_str().unwrap().starts_with("keyphasor in column keyphasor"));
    assert!((outcome["record"]["mean_speed_rpm"].as_f64().unwrap() - 3000.0).abs() < 1.0);
    // A keyphasor of two pulses per revolution that the scene takes for one.
    sandbox.put("scene.toml", swap(&keyed, "3000 rpm", "1500 rpm"));
    let run = sandbox.run(&["replay", "scene.toml", "--report", "r.html"]);
    assert_eq!(run.code, Some(4), "{}", run.err);
    let said = run.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("shaft speed: 3000 rpm measured, 1500 rpm in the scene"), "{said}");
}

/// Velocity of a sensor and its zone by the class of the machine.
#[test]
fn the_velocity_of_a_housing_has_a_zone() {
    let sandbox = Sandbox::empty();
    sandbox.put("r.csv", with_accelerometer("healthy.csv", OUTER));
    let of = |machine: &str| {
        sandbox.put("scene.toml", scene(3000.0, [9.0, 7.94, 39.04], "r.csv", "12.8 kHz", "DE_acc_g", "g") + machine);
        sandbox.replay("scene.toml", &[])
    };
    let without = of("");
    let velocity = without.pointer("/sensors/0/velocity_rms_mm_s").and_then(Value::as_f64).unwrap();
    assert!((0.5..1.0).contains(&velocity), "{velocity}");
    assert_eq!(without.pointer("/sensors/0/zone"), None);
    let verdict = |outcome: &Value| outcome["verdict"].as_str().unwrap().to_owned();
    assert!(!verdict(&without).contains("velocity"));
    let medium = of("[machine]\ngroup = 2\nsupport = \"rigid\"\n");
    assert_eq!(medium.pointer("/sensors/0/zone"), Some(&serde_json::json!("A")));
    let expected = "zone A, as of a newly commissioned machine (ISO 20816-3, group 2, rigid support, indicative: 1.4 / 2.8 / 4.5 mm/s).";
    assert!(verdict(&medium).ends_with(expected), "{}", verdict(&medium));
    // The zone is beside the fault, not in its place.
    assert_eq!(medium["findings"], without["findings"]);
    let own = of("[machine]\nvelocity_limits = [\"0.1 mm/s\", \"0.2 mm/s\", \"0.3 mm/s\"]\n");
    assert_eq!(own.pointer("/sensors/0/zone"), Some(&serde_json::json!("D")));
    for (machine, says) in [
        ("group = 3\nsupport = \"rigid\"", "machine.group: invalid value: 3, expected 1 (above 300 kW) or 2"),
        ("group = 2", "machine.support: missing key, expected \"rigid\" or \"flexible\""),
        ("group = 2\nvelocity_limits = [1, 2, 3]", "machine.group: misplaced key"),
        ("velocity_limits = [1, 3, 2]", "machine.velocity_limits: invalid value: [1, 3, 2], expected three rising"),
        ("velocity_limits = [\"1 mm\", 2, 3]", "(a length), expected a velocity, such as \"4.5 mm/s\""),
    ] {
        let text = scene(3000.0, [9.0, 7.94, 39.04], "r.csv", "12.8 kHz", "DE_acc_g", "g");
        sandbox.put("scene.toml", format!("{text}[machine]\n{machine}\n"));
        let run = sandbox.run(&["check", "scene.toml"]);
        assert!(run.code == Some(2) && run.err.contains(says), "{machine}: {}", run.err);
    }
}

/// Frames of the probes, the accelerometer and the keyphasor; one without the accelerometer is of a wrong size.
#[test]
fn an_accelerometer_in_a_stream() {
    let sandbox = Sandbox::with(&scene_of_both(), &with_accelerometer("healthy.csv", OUTER));
    let args = ["--encoding", "frames", "--for", "1.4 s", "--indicators", "indicators"];
    let (child, port) = listening(&sandbox, "tcp", &args);
    let mut stream = connected(port);
    let text = sandbox.read("healthy.csv");
    let cells = |line: &str| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
    let rows: Vec<Vec<f32>> = text.lines().skip(1).map(cells).collect();
    for sequence in 0..19_200 {
        // Probes, keyphasor, accelerometer in the file; probes, accelerometer, keyphasor in a frame.
        let mut row = rows[sequence as usize % rows.len()].clone();
        row.swap(5, 6);
        let _ = stream.write_all(&frame(sequence, &row));
    }
    let outcome = outcome(child);
    assert_eq!(outcome.pointer("/timing/source/malformed_frames"), Some(&serde_json::json!(0)));
    assert_eq!(all_diagnoses(&outcome), [] as [Value; 0]);
    let table = std::fs::read(sandbox.path("indicators/indicators-0001.parquet")).unwrap();
    for column in ["DE_acc_g_rms", "DE_acc_g_peak", "DE_acc_g_crest_factor", "DE_acc_g_kurtosis"] {
        assert!(table.windows(column.len()).any(|bytes| bytes == column.as_bytes()), "{column}");
    }
}

/// Recordings of others are read from scenes of at most 15 lines, with bearings of the catalogue and rates of the files where they
/// have them.
#[test]
fn recordings_of_others_need_short_scenes() {
    let shared = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/recordings/real");
    let head = |rpm: f64, bearing: &str| {
        format!("shaft.speed = \"{rpm} rpm\"\n[[bearing]]\nname = \"DE\"\nstation = \"0 mm\"\n{bearing}\n[recording]\n")
    };
    let force = recorded("real/support_force_306rpm_6400Hz.csv");
    let geometry = "model = \"angular\"\nelements = 7\nball_diameter = \"2.770 mm\"\npitch_diameter = \"10.514 mm\"\n\
                    inner_conformity = 0.52\nouter_conformity = 0.52\ncontact_angle = \"0 deg\"";
    let cwru = |name: &str, rate: &str, column: &str| {
        let file = format!("{shared}/cwru_6205/{name}");
        let sensors = format!("rate = \"{rate}\"\nsensors = [{{ column = \"{column}\", unit = \"g\" }}]\n");
        (file, head(1797.0, "bearing = \"6205\""), sensors)
    };
    let tdms = |name: &str, column: &str| {
        let sensors = format!("rate = \"file\"\nsensors = [{{ column = \"{column}\", unit = \"V\" }}]\n");
        (format!("{shared}/tdms/{name}"), head(1500.0, "bearing = \"6205\""), sensors)
    };
    let force_of = "rate = \"6400 Hz\"\nsensors = [{ column = \"force_N\", unit = \"N\" }]\n";
    let all = [
        (force, head(306.0, geometry), force_of.to_owned()),
        cwru("12k_Drive_End_IR007_0_105.mat", "12 kHz", "X105_DE_time"),
        cwru("12k_Drive_End_OR007@6_0_130.mat", "12 kHz", "X130_DE_time"),
        cwru("normal_0_97.mat", "48 kHz", "X097_DE_time"),
        tdms("raw1.tdms", "Layer Data/First  Channel"),
        tdms("big_endian.tdms", "Measured Data/Amplitude sweep"),
    ];
    for (file, head, sensors) in all {
        if !std::path::Path::new(&file).is_file() {
            println!("{file} is not here: not tried");
            continue;
        }
        let scene = format!("{head}file = {file:?}\n{sensors}");
        assert!(scene.lines().count() <= 15, "{scene}");
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", &scene);
        let checked: Value = sandbox.run(&["check", "scene.toml", "--format", "json"]).json();
        println!("{file}: {} lines, {}", scene.lines().count(), checked["recording"]["samples"]);
        assert!(checked["recording"]["samples"].as_u64().unwrap() > 1000, "{checked:#}");
    }
}
