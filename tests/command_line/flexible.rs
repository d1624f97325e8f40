//! A rotor that bends, with probes away from its bearings (`tests/recordings/flexible`): motion, forces and diagnosis against an
//! independent program.

use crate::support::{Sandbox, list, recorded, swap};
use serde_json::Value;
use std::fs;

/// Rms noise of the probes, um.
const NOISE: f64 = 0.05;
/// Samples of the recording per sample of the truth.
const TRUTH_STRIDE: usize = 16;
/// Samples of the truth during the transient of the observer.
const SETTLING: usize = 40;
/// Samples of a recording, and of those that are replayed, 28 revolutions, or 18 for the unbalance, which is seen in fewer.
const RECORDED: usize = 12_800;
const SAMPLES: usize = 6_400;
const FEW_SAMPLES: usize = 4_096;

fn scene() -> String {
    fs::read_to_string(recorded("flexible/scene.toml")).unwrap()
}

/// The first samples of a recording.
fn head(recording: &str, samples: usize) -> Vec<u8> {
    let bytes = fs::read(recorded(&format!("flexible/{recording}.npy"))).unwrap();
    let header = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let row = (bytes.len() - header) / RECORDED;
    let count = b"(12800,), }";
    let rest = format!("{:width$}", format!("({samples},), }}"), width = count.len());
    let at = bytes.windows(count.len()).position(|window| window == count).unwrap();
    [&bytes[..at], rest.as_bytes(), &bytes[at + count.len()..header + samples * row]].concat()
}

/// Replays the first samples of a recording; returns the outcome and the estimated forces.
fn replayed(recording: &str, samples: usize) -> (Value, Vec<Vec<f64>>) {
    let sandbox = Sandbox::empty();
    sandbox.put("head.npy", head(recording, samples));
    let scene = recorded("flexible/scene.toml");
    let arguments =
        ["replay", &scene, "--recording", "head.npy", "--no-report", "--forces", "f.csv", "--format", "json"];
    let answer = sandbox.done(&arguments);
    let rows = sandbox
        .read("f.csv")
        .lines()
        .skip(1)
        .map(|line| line.split(',').filter_map(|x| x.parse().ok()).collect())
        .collect();
    (serde_json::from_str(&answer.out).unwrap(), rows)
}

/// Forces of the independent program during the first samples: FX FY FZ MX MY of each bearing.
fn truth(recording: &str, samples: usize) -> Vec<Vec<f64>> {
    let bytes = fs::read(recorded(&format!("flexible/{recording}.truth.npy"))).unwrap();
    let header = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let numbers: Vec<f64> =
        bytes[10 + header..].as_chunks::<4>().0.iter().map(|x| f64::from(f32::from_le_bytes(*x))).collect();
    numbers.chunks(10).take(samples / TRUTH_STRIDE).map(<[f64]>::to_vec).collect()
}

/// The estimated radial forces are at least three times closer to the truth than the mean of those from the straight line.
fn forces_are_closer(recording: &str, outcome: &Value, forces: &[Vec<f64>]) {
    let truth = truth(recording, forces.len());
    for (b, bearing) in list(outcome, "bearings").iter().enumerate() {
        let mut square = 0.0;
        let mut mean = 0.0;
        for (i, truth) in truth.iter().enumerate().skip(SETTLING) {
            let (row, at) = (&forces[i * TRUTH_STRIDE], 5 * b);
            square += (row[1 + at] - truth[at]).powi(2) + (row[2 + at] - truth[at + 1]).powi(2);
            mean += truth[at + 1];
        }
        let count = (truth.len() - SETTLING) as f64;
        let error = (square / count).sqrt();
        let straight = (bearing["force_measured"][1]["mean"].as_f64().unwrap() - mean / count).abs();
        assert!(3.0 * error < straight, "{recording}: {error} N, {straight} N from the straight line");
        // The error of the straight line is known without the truth.
        let stated = bearing["straight_line_error"][1].as_f64().unwrap();
        assert!((stated / straight - 1.0).abs() < 0.2, "{recording}: stated {stated} N, {straight} N is true");
    }
}

fn diagnoses(outcome: &Value) -> Vec<(&str, Option<&str>)> {
    list(outcome, "findings").iter().map(|f| (f["kind"].as_str().unwrap(), f["bearing"].as_str())).collect()
}

#[test]
fn the_twin_of_a_flexible_rotor_in_good_order() {
    let (outcome, forces) = replayed("healthy", SAMPLES);
    assert!(diagnoses(&outcome).is_empty(), "{}", outcome["findings"]);
    for probe in list(&outcome, "probes") {
        let residual = probe["residual_rms_um"].as_f64().unwrap();
        assert!(residual < 1.5 * NOISE, "{}: {residual} um", probe["name"]);
        let of = |motion: &str, key: &str| probe[motion][key].as_f64().unwrap();
        let ratio = of("twin", "one_x_um") / of("measured", "one_x_um");
        assert!((ratio - 1.0).abs() < 0.1, "{}: {ratio}", probe["name"]);
        let lag = of("twin", "one_x_phase_lag_deg") - of("measured", "one_x_phase_lag_deg");
        assert!((lag + 180.0).rem_euclid(360.0) - 180.0 < 10.0, "{}: {lag} deg", probe["name"]);
    }
    forces_are_closer("healthy", &outcome, &forces);
}

/// The report shows the forces of the observer and not those of a straight line between the planes of the probes, which are seven times too large.
#[test]
fn forces_of_a_flexible_rotor_are_those_of_the_observer() {
    let sandbox = Sandbox::empty();
    // Seven revolutions: too few for a diagnosis, of which this says nothing.
    let samples = 1_600;
    sandbox.put("head.npy", head("healthy", samples));
    let scene = recorded("flexible/scene.toml");
    let text = sandbox.done(&["replay", &scene, "--recording", "head.npy", "--report", "r.html"]).out;
    let (_, forces) = text.split_once("FORCES ON THE INNER RINGS").unwrap();
    let (forces, _) = forces.split_once("ORDERS").unwrap();
    assert!(forces.contains("observer") && !forces.contains("measured"), "{forces}");
    assert!(forces.split_whitespace().collect::<Vec<_>>().join(" ").contains("a straight line between the planes"));
    let truth = truth("healthy", samples);
    for b in 0..2 {
        let mean = truth.iter().map(|row| row[5 * b + 1]).sum::<f64>() / truth.len() as f64;
        let line = forces.lines().filter(|line| line.contains("FY, N ")).nth(b).unwrap();
        let shown: f64 = line.split_whitespace().nth(2).unwrap().parse().unwrap();
        assert!((shown / mean - 1.0).abs() < 0.2, "{line}: {mean} N is true");
    }
    let html = sandbox.read("r.html");
    assert!(html.contains("from the observer") && !html.contains("from measured displacement"));
}

#[test]
fn unbalance_of_a_flexible_rotor() {
    let (outcome, forces) = replayed("unbalance", FEW_SAMPLES);
    assert_eq!(diagnoses(&outcome), [("unbalance", None)]);
    let diagnosis = &list(&outcome, "findings")[0];
    let value = |key: &str| diagnosis[key]["value"].as_f64().unwrap();
    // 3 x 102.0 g mm at -97.1 deg and 109.9 g mm at 52.1 deg.
    assert!((value("moment_g_mm") / 219.0 - 1.0).abs() < 0.05, "{diagnosis}");
    assert!((value("angle_deg") - 277.8).abs() < 3.0, "{diagnosis}");
    forces_are_closer("unbalance", &outcome, &forces);
}

#[test]
fn inner_race_spall_of_a_flexible_rotor() {
    let (outcome, forces) = replayed("inner-spall", SAMPLES);
    assert_eq!(diagnoses(&outcome), [("inner-race", Some("NDE"))]);
    let azimuth = &list(&outcome, "findings")[0]["azimuth_deg"];
    let (low, high) = (azimuth["low"].as_f64().unwrap(), azimuth["high"].as_f64().unwrap());
    let expected = 0.5_f64.to_degrees();
    assert!(low < expected && expected < high && high - low < 30.0, "{azimuth}");
    forces_are_closer("inner-spall", &outcome, &forces);
}

/// One clear error for each, with the line and the key.
/// The unbalance of a flexible rotor stays in the planes of the drawing: near the bearings it would bend the rotor less.
#[test]
fn clearance_and_unbalance_of_a_flexible_rotor_are_fitted() {
    let sandbox = Sandbox::empty();
    let swaps = [
        ("diametral_clearance = \"11.529 um\"", "diametral_clearance = \"13 um\""),
        ("\"102.02123 g mm\"", "\"120 g mm\""),
    ];
    sandbox.put("scene.toml", swaps.iter().fold(scene(), |text, (from, to)| swap(&text, from, to)));
    let recording = recorded("flexible/healthy.npy");
    let only = ["--only", "unbalance,clearance,damping,stiffness"];
    let arguments =
        [&["fit", "scene.toml", "--recording", &recording, "--turns", "2", "--format", "json"][..], &only].concat();
    let found: Value = serde_json::from_str(&sandbox.done(&arguments).out).unwrap();
    assert_eq!(found["consistent"], true, "{found:#}");
    let value = |name: &str, key: &str| {
        let estimate = list(&found, "parameters").iter().find(|p| p["name"] == name);
        estimate.unwrap_or_else(|| panic!("no {name} in {found:#}"))[key].as_f64().unwrap()
    };
    for (name, truth) in
        [("DE: diametral_clearance", 11.529), ("unbalance: moment", 69.404), ("DE: youngs_modulus", 206.0)]
    {
        let [low, high] = ["low", "high"].map(|key| value(name, key));
        assert!(low <= truth && truth <= high && high - low < 0.25 * truth, "{name}: {low} to {high}, {truth} is true");
    }
    // Damping is that of the drawing.
    assert!(
        list(&found, "parameters").iter().all(|p| !p["name"].as_str().unwrap().starts_with("damping")),
        "{found:#}"
    );
    sandbox.done(&["equilibrium", "scene-fitted.toml"]);
    assert_eq!(sandbox.read("scene-fitted.toml").matches("g mm\"").count(), 2, "{}", sandbox.read("scene-fitted.toml"));
}

#[test]
fn wrong_drawings_are_refused() {
    let cases = [
        (
            "from = \"65.6 mm\"",
            "from = \"60 mm\"",
            "rotor.sections[1].from: an overlap: from 60 mm after a section to 65.6 mm",
        ),
        (
            "from = \"65.6 mm\"",
            "from = \"70 mm\"",
            "rotor.sections[1].from: a gap: from 70 mm after a section to 65.6 mm",
        ),
        (
            "to = \"246.2 mm\", outer_diameter = \"30 mm\"",
            "to = \"246.2 mm\", outer_diameter = \"0 mm\"",
            "rotor.sections[1].outer_diameter",
        ),
        (
            "to = \"246.2 mm\", outer_diameter = \"30 mm\"",
            "to = \"246.2 mm\", outer_diameter = \"30 mm\", inner_diameter = \"30 mm\"",
            "rotor.sections[1].outer_diameter",
        ),
        (
            "to = \"246.2 mm\", outer_diameter = \"30 mm\"",
            "to = \"246.2 kg\", outer_diameter = \"30 mm\"",
            "rotor.sections[1].to",
        ),
        ("station = \"246.2 mm\", mass", "station = \"600 mm\", mass", "rotor.disks[0].station"),
        ("name = \"NDE\"\nstation = \"514.2 mm\"", "name = \"NDE\"\nstation = \"560 mm\"", "bearing[1].station"),
        (
            "column = \"DE_X\", unit = \"um\", station = \"65.6 mm\"",
            "column = \"DE_X\", unit = \"um\", station = \"-5 mm\"",
            "recording.probes[1].station",
        ),
        ("load_station", "mass = \"9 kg\"\nload_station", "rotor.mass"),
        (
            "{ from = \"0 mm\", to = \"65.6 mm\", outer_diameter = \"25 mm\" },",
            "{ from = \"0 mm\", outer_diameter = \"25 mm\" },",
            "rotor.sections[0].to",
        ),
    ];
    for (from, to, expected) in cases {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", swap(&scene(), from, to));
        sandbox.refused(&["equilibrium", "scene.toml"], 2, &["scene.toml:", expected]);
    }
}

/// The critical speeds stand below the table; the first modes of the rotor cross 1X near 106 and 108 Hz.
#[test]
fn critical_speeds_are_printed() {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene());
    let text = sandbox.done(&["campbell", "scene.toml", "--speeds", "0 rpm..12000 rpm:5"]).out;
    let (_, critical) = text.split_once("\nCritical speeds").unwrap();
    let first = critical.lines().find(|line| line.contains(" rpm  1X ")).unwrap();
    let rpm: f64 = first.split_whitespace().next().unwrap().parse().unwrap();
    assert!((6250.0..6400.0).contains(&rpm), "{critical}");
}

/// A drawing in thousands of pieces is the same rotor, and more than a drawing has are refused.
#[test]
fn a_rotor_of_many_sections() {
    let pieces = |count: usize| {
        let section = |i: usize| {
            let [from, to] =
                [i, i + 1].map(|end| format!("{:.6} mm", 65.6 + (246.2 - 65.6) * end as f64 / count as f64));
            format!("{{ from = \"{from}\", to = \"{to}\", outer_diameter = \"30 mm\" }},")
        };
        let whole = "{ from = \"65.6 mm\", to = \"246.2 mm\", outer_diameter = \"30 mm\" },";
        swap(&scene(), whole, &(0..count).map(section).collect::<String>())
    };
    let frequencies = |text: &str| {
        let sandbox = Sandbox::empty();
        sandbox.put("scene.toml", text);
        let found = sandbox.done(&["campbell", "scene.toml", "--speeds", "3000 rpm", "--format", "json"]);
        let found: Value = serde_json::from_str(&found.out).unwrap();
        found[0]["modes"].as_array().unwrap().iter().map(|m| m["frequency_hz"].as_f64().unwrap()).collect::<Vec<_>>()
    };
    for (few, many) in frequencies(&scene()).iter().zip(&frequencies(&pieces(2000))).take(8) {
        assert!((few / many - 1.0).abs() < 5e-3, "{few} {many} Hz");
    }
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", pieces(10_001));
    sandbox.refused(&["check", "scene.toml"], 2, &["scene.toml:", "10005 sections", "at most 10000"]);
}

/// A rigid rotor on supports is replayed and diagnosed too: its recording is the program's own.
#[test]
fn supports_are_observed() {
    let sandbox = Sandbox::empty();
    let support = "support = { mass = \"3 kg\", stiffness_x = 2e7, stiffness_y = 3e7, damping = 800 }";
    let text =
        crate::observer::rotor("angular", support, "Z").replace("name = \"B\"", &format!("name = \"B\"\n{support}"));
    sandbox.put("scene.toml", &text);
    let motion = crate::observer::motion(&sandbox, "scene.toml", 20..60);
    sandbox.put("recording.csv", crate::observer::recording(&motion, crate::observer::TURN));
    let outcome = sandbox.done(&["replay", "scene.toml", "--report", "r.html", "--format", "json"]);
    let outcome: Value = serde_json::from_str(&outcome.out).unwrap();
    assert!(diagnoses(&outcome).is_empty(), "{}", outcome["findings"]);
    for probe in list(&outcome, "probes") {
        let residual = probe["residual_rms_um"].as_f64().unwrap();
        assert!(residual < 1.5 * 0.03, "{}: {residual} um", probe["name"]);
    }
}
