//! Recordings of vibration: measured ones, of machines whose damage is known, and files that are none.

use serde_json::Value;

use crate::support::{Desk, recorded};

/// A scene of one bearing with one sensor.
pub fn scene(rpm: f64, [elements, ball, pitch]: [f64; 3], file: &str, rate: &str, column: &str, unit: &str) -> String {
    format!(
        "[shaft]\nspeed = \"{rpm} rpm\"\n[[bearing]]\nname = \"B\"\nstation = \"0 mm\"\nfacing = \"both\"\nmodel = \"angular\"\n\
         elements = {elements}\nball_diameter = \"{ball} mm\"\npitch_diameter = \"{pitch} mm\"\ninner_conformity = 0.52\n\
         outer_conformity = 0.52\ncontact_angle = \"0 deg\"\n[recording]\nfile = {file:?}\nrate = \"{rate}\"\n\
         sensors = [{{ column = \"{column}\", unit = \"{unit}\" }}]\n"
    )
}

fn findings(desk: &Desk) -> Vec<(String, f64)> {
    let outcome = desk.replay("scene.toml", &[]);
    let all = outcome.pointer("/findings").and_then(Value::as_array).unwrap();
    all.iter().map(|f| (f["kind"].as_str().unwrap().to_owned(), f["line_hz"].as_f64().unwrap())).collect()
}

/// Support force of a faulty NMB 1560KK (pybearing 1.0.4, MIT License): the envelope of 100 to 300 Hz has 22.4 Hz, the
/// inner race's ball-pass frequency.
#[test]
fn the_miniature_bearing_has_a_bad_inner_race() {
    let desk = Desk::empty();
    let file = recorded("real/support_force_306rpm_6400Hz.csv");
    desk.put("scene.toml", scene(306.0, [7.0, 2.770, 10.514], &file, "6400 Hz", "force_N", "N"));
    let found = findings(&desk);
    assert!(matches!(&found[..], [(kind, hz)] if kind == "inner-race" && (hz - 22.4).abs() < 0.3), "{found:?}");
}

/// Housing acceleration of an SKF 6205 (Case Western Reserve University Bearing Data Center), where the files are at hand.
#[test]
fn the_6205s_are_told_apart() {
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
            let desk = Desk::empty();
            let column = format!("{of}_{sensor}_time");
            desk.put("scene.toml", scene(rpm, [9.0, 7.94, 39.04], &file, rate, &column, "g"));
            let found = findings(&desk);
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
    let desk = Desk::empty();
    let whole = mat("a", &(0..4000).map(|i| f64::from(i * 37 % 101)).collect::<Vec<_>>());
    desk.put("scene.toml", scene(3000.0, [9.0, 7.94, 39.04], "r.mat", "6 kHz", "a", "m/s^2"));
    desk.put("r.mat", &whole);
    let outcome = desk.replay("scene.toml", &[]);
    assert_eq!(outcome.pointer("/record/samples").and_then(Value::as_u64), Some(4000));
    for (bytes, says) in [
        (&whole[..whole.len() / 2], "expected a MATLAB file of version 5"),
        (&whole[..140], "expected a MATLAB file of version 5"),
        (&mat("b", &[1.0; 4000])[..], "no such column: `a`"),
    ] {
        desk.put("r.mat", bytes);
        let run = desk.run(&["replay", "scene.toml", "--report", "r.html"]);
        assert!(run.code != Some(0) && run.err.contains(says), "{}", run.err);
    }
}

#[test]
fn sensors_are_checked() {
    let good = scene(3000.0, [9.0, 7.94, 39.04], "r.csv", "6 kHz", "a", "m/s^2");
    let desk = Desk::empty();
    desk.put("r.csv", "a\n".to_owned() + &"1\n2\n".repeat(100));
    for (from, to, says) in [
        ("unit = \"m/s^2\"", "unit = \"um\"", "m/s^2, g, m/s, mm/s, N, V"),
        (
            "speed = \"3000 rpm\"",
            "speed = { from = \"1 rpm\", to = \"2 rpm\", over = \"1 s\" }",
            "one speed in [shaft]",
        ),
        ("unit = \"m/s^2\"", "unit = \"m/s^2\", bearing = \"X\"", "the name of a [[bearing]]"),
        ("sensors =", "probes = []\nsensors =", "both probes and sensors"),
        ("rate = \"6 kHz\"", "rate = \"6 kHz\"", "turns of the shaft, expected 16 or more"),
    ] {
        desk.put("scene.toml", good.replacen(from, to, 1));
        let run = desk.run(&["replay", "scene.toml", "--report", "r.html"]);
        assert!(run.code != Some(0) && run.err.contains(says), "{says}: {}", run.err);
    }
}
