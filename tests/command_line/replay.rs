//! `ballrace replay`: the demonstration, the formats of its output, verdicts on machines in good order and with faults.

use std::time::Instant;

use serde_json::Value;

use crate::support::{
    DEMO_SCENE, DIAGNOSED, SHORT, Sandbox, demonstrated, head, list, number, recorded, short_recording, sound, spalled,
    swap,
};

/// On one line, with single spaces: sentences of the text are broken to fit the terminal.
fn unbroken(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Runs that share a folder have reports of their own, and `--no-report` writes none.
#[test]
fn reports_are_named_after_scene_and_recording() {
    let sandbox = Sandbox::rig();
    sandbox.put("pump.toml", DEMO_SCENE);
    sandbox.put("today.csv", short_recording(SHORT));
    let before = sandbox.files();
    sandbox.done(&["replay", "scene.toml", "--no-report"]);
    assert_eq!(sandbox.files(), before);
    let both = sandbox.run(&["replay", "scene.toml", "--no-report", "--report", "a.html"]);
    assert!(both.code == Some(2) && both.err.contains("'--no-report' cannot be used with '--report"), "{both:?}");
    assert_eq!(sandbox.files(), before);
    let text = sandbox.done(&["replay", "scene.toml"]).out;
    assert!(text.contains("Report: scene-report.html"), "{text}");
    sandbox.done(&["replay", "pump.toml"]);
    sandbox.done(&["replay", "pump.toml", "--recording", "today.csv"]);
    sandbox.run(&["replay", "--paced", "--source", "demonstration", "--for", "0.1 s"]);
    let reports: Vec<String> = sandbox.files().into_iter().filter(|name| name.ends_with(".html")).collect();
    let expected = [
        "ballrace-demonstration-simulated-report.html",
        "pump-report.html",
        "pump-today-report.html",
        "scene-report.html",
    ];
    assert_eq!(reports, expected);
}

#[test]
fn demonstration_in_an_empty_folder() {
    let sandbox = Sandbox::empty();
    let text = sandbox.done(&["replay"]).out;
    assert_eq!(sandbox.files(), ["ballrace-report.html"]);
    let report = sandbox.read("ballrace-report.html");
    assert!(report.starts_with("<!DOCTYPE html>") && report.trim_end().ends_with("</html>"));
    assert!(text.contains("Report: ballrace-report.html"), "{text}");
    let outcome = spalled();
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(!verdict.is_empty() && unbroken(&text).contains(verdict), "{text}");
    assert!(report.contains(verdict));
    let diagnoses = list(outcome, "findings");
    assert_eq!(diagnoses.len(), 1, "{outcome:#}");
    assert_eq!((diagnoses[0]["kind"].as_str(), diagnoses[0]["bearing"].as_str()), (Some("outer-race"), Some("DE")));
    for (key, truth, widest) in [("azimuth_deg", 270.0, 15.0), ("depth_um", 3.0, 8.0)] {
        let [low, high] = ["/low", "/high"].map(|end| number(&diagnoses[0][key], end));
        assert!(low < truth && truth < high && high - low < widest, "{}", diagnoses[0][key]);
    }
    assert_eq!(list(&diagnoses[0], "failure_modes")[0], "5.1 rolling contact fatigue", "{outcome:#}");
    assert!(unbroken(&text).contains("Failure mode of ISO 15243: 5.1 rolling contact fatigue"), "{text}");
    assert!(report.contains("Failure mode of ISO 15243: 5.1 rolling contact fatigue"));
    assert_eq!(list(outcome, "flaws").len(), 0, "{outcome:#}");
}

#[test]
fn demonstration_is_the_scene_and_recording_of_the_source() {
    let damaged = demonstrated("outer-spall.csv");
    let own = Sandbox::with(DEMO_SCENE, "").replay("scene.toml", &["--recording", &damaged]);
    for key in ["probes", "bearings", "findings", "flaws", "verdict"] {
        assert_eq!(spalled()[key], own[key], "{key}");
    }
}

/// Gaps, run-out, drift, hum and imperfect races are no fault, without a baseline as well.
#[test]
fn the_sound_machine_of_the_demonstration_has_no_diagnosis() {
    let sound = demonstrated("healthy.csv");
    let outcome = Sandbox::with(DEMO_SCENE, "").replay("scene.toml", &["--recording", &sound]);
    assert_eq!(diagnoses(&outcome), [], "{outcome:#}");
}

#[test]
fn json_has_the_documented_keys() {
    let outcome = Sandbox::rig().replay("scene.toml", &[]);
    let names = |key: &str| list(&outcome, key).iter().map(|p| p["name"].as_str().unwrap()).collect::<Vec<_>>();
    assert_eq!(names("probes"), ["DE_X_um", "DE_Y_um", "NDE_X_um", "NDE_Y_um", "axial_um"]);
    assert_eq!(names("bearings"), ["DE", "NDE"]);
    assert_eq!(list(&outcome, "findings").len(), 0);
    assert_eq!(number(&outcome, "/timing/samples"), SHORT as f64);
    assert_eq!(number(&outcome, "/timing/sample_period_ns"), 78_125.0);
    for quantile in ["p50_ns", "p99_ns", "p999_ns", "max_ns"] {
        assert!(number(&outcome, &format!("/timing/compute/{quantile}")) > 0.0);
    }
    for probe in list(&outcome, "probes") {
        for pointer in ["/measured/one_x_um", "/twin/one_x_phase_lag_deg", "/residual_rms_um", "/nrmse_percent"] {
            assert!(number(probe, pointer).is_finite());
        }
    }
}

#[test]
fn csv_has_a_row_for_each_probe() {
    let sandbox = Sandbox::rig();
    let out = sandbox.done(&["replay", "scene.toml", "--format", "csv"]).out;
    let rows: Vec<Vec<&str>> = out.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 6, "{out}");
    assert!(rows.iter().all(|row| row.len() == rows[0].len()), "{out}");
    let residual = rows[0].iter().position(|head| *head == "residual_rms_um").unwrap();
    let outcome = sandbox.replay("scene.toml", &[]);
    for (row, probe) in rows[1..].iter().zip(list(&outcome, "probes")) {
        assert_eq!(row[0], probe["name"]);
        let (printed, full) = (row[residual].parse::<f64>().unwrap(), number(probe, "/residual_rms_um"));
        assert!((printed / full - 1.0).abs() < 1e-3, "{printed} {full}");
    }
}

#[test]
fn forces_of_every_sample() {
    let sandbox = Sandbox::rig();
    sandbox.done(&["replay", "scene.toml", "--forces", "forces.csv"]);
    let text = sandbox.read("forces.csv");
    let mut lines = text.lines();
    let head = "time_s,DE_FX_N,DE_FY_N,DE_FZ_N,DE_MX_Nm,DE_MY_Nm,NDE_FX_N,NDE_FY_N,NDE_FZ_N,NDE_MX_Nm,NDE_MY_Nm,status";
    assert_eq!(lines.next(), Some(head));
    assert_eq!(lines.clone().count(), SHORT);
    for (i, line) in lines.enumerate() {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!((cells.len(), cells[11]), (12, 0.0), "{line}");
        assert!((cells[0] - i as f64 / 12_800.0).abs() < 1e-9, "{line}");
        assert!(cells.iter().all(|x| x.is_finite()), "{line}");
    }
}

#[test]
fn paced_keeps_to_the_time_of_the_recording() {
    let samples = 3840;
    let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(samples));
    let begun = Instant::now();
    let outcome = sandbox.replay("scene.toml", &["--paced"]);
    let took = begun.elapsed().as_secs_f64();
    let length = (samples - 1) as f64 / 12_800.0;
    assert!(took >= length, "{took} s for {length} s");
    assert!(number(&outcome, "/timing/wall_s") >= length);
    assert_eq!(outcome["timing"]["paced"], true);
    let late = |quantile: &str| number(&outcome, &format!("/timing/lateness/{quantile}"));
    assert!(late("p50_ns") > 0.0 && late("p50_ns") <= late("p99_ns") && late("p99_ns") <= late("max_ns"));
    for stage in ["twin", "observer", "forces", "comparison"] {
        let mean = number(&outcome, &format!("/timing/stages/{stage}_ns"));
        assert!(mean > 0.0, "{stage}: {mean} ns");
    }
    let misses = outcome["timing"]["deadline_misses"].as_u64().unwrap();
    assert!(misses <= samples as u64);
    let text = sandbox.done(&["replay", "scene.toml", "--paced"]).out;
    assert!(text.contains("lateness") && text.contains("missed") && text.contains("Mean of a sample: twin"), "{text}");
}

#[test]
fn unpaced_has_no_lateness() {
    let outcome = Sandbox::rig().replay("scene.toml", &[]);
    assert_eq!(outcome["timing"]["paced"], false);
    assert_eq!((&outcome["timing"]["lateness"], &outcome["timing"]["deadline_misses"]), (&Value::Null, &Value::Null));
}

/// Outcome of a recording against the scene of the machine in good order.
fn sound_scene_on(recording: &str) -> Value {
    Sandbox::empty().replay(&recorded("healthy.toml"), &["--recording", &recorded(recording)])
}

/// Each diagnosis as (kind, bearing).
fn diagnoses(outcome: &Value) -> Vec<(&str, Option<&str>)> {
    list(outcome, "findings").iter().map(|f| (f["kind"].as_str().unwrap(), f["bearing"].as_str())).collect()
}

/// The diagnosis is put in figures and in words.
fn assert_told(outcome: &Value, order: f64) {
    let diagnosis = &list(outcome, "findings")[0];
    assert!((number(diagnosis, "/order") - order).abs() < 0.01, "{diagnosis:#}");
    assert!((number(diagnosis, "/line_hz") - 50.0 * order).abs() < 0.5, "{diagnosis:#}");
    assert!(number(diagnosis, "/level_db") > 12.0, "{diagnosis:#}");
    assert!((0.5..=1.0).contains(&number(diagnosis, "/confidence")), "{diagnosis:#}");
    let sentence = diagnosis["sentence"].as_str().unwrap();
    assert!(outcome["verdict"].as_str().unwrap().contains(sentence), "{outcome:#}");
}

#[test]
fn sound_scene_finds_the_unbalance() {
    let outcome = sound_scene_on("unbalanced.csv");
    assert_eq!(diagnoses(&outcome), [("unbalance", None)], "{outcome:#}");
    assert_told(&outcome, 1.0);
}

#[test]
fn sound_scene_finds_the_spall() {
    let outcome = sound_scene_on("outer-spall.csv");
    assert_eq!(diagnoses(&outcome), [("outer-race", Some("DE"))], "{outcome:#}");
    assert_told(&outcome, 3.599);
}

#[test]
fn sound_scene_finds_nothing_in_sound_recordings() {
    for outcome in [sound(), &sound_scene_on("run-up.csv")] {
        assert_eq!(diagnoses(outcome), [], "{outcome:#}");
        assert_eq!(list(outcome, "flaws").len(), 0);
    }
}

/// Smallest difference of two angles, degrees.
fn apart(a: f64, b: f64) -> f64 {
    ((a - b + 180.0).rem_euclid(360.0) - 180.0).abs()
}

#[test]
fn twin_follows_the_sound_machine() {
    for probe in list(sound(), "probes") {
        let of = |pointer: &str| number(probe, pointer);
        assert!(of("/residual_rms_um") <= 1.5 * of("/noise_um"), "{probe:#}");
        assert!(of("/measured/one_x_um") > 0.01, "a line to compare: {probe:#}");
        assert!((of("/twin/one_x_um") / of("/measured/one_x_um") - 1.0).abs() < 0.1, "{probe:#}");
        let lags = (of("/twin/one_x_phase_lag_deg"), of("/measured/one_x_phase_lag_deg"));
        assert!(apart(lags.0, lags.1) < 10.0, "{probe:#}");
    }
}

#[test]
fn recording_is_found_beside_its_scene() {
    let sandbox = Sandbox::empty();
    for folder in ["scenes", "data"] {
        std::fs::create_dir(sandbox.path(folder)).unwrap();
    }
    sandbox.put("scenes/pump.toml", swap(DEMO_SCENE, "healthy.csv", "../data/pump.csv"));
    sandbox.put("data/pump.csv", short_recording(SHORT));
    let outcome = sandbox.replay("scenes/pump.toml", &["--report", "data/pump.html"]);
    assert_eq!(outcome["recording"], "pump.csv");
    assert_eq!(sandbox.files(), ["data", "scenes"], "the report goes where it is asked for");
    assert!(sandbox.read("data/pump.html").contains("pump.csv"));
}

#[test]
fn same_recording_in_other_forms() {
    let plain = Sandbox::rig().replay("scene.toml", &[]);
    let text = short_recording(SHORT);
    for (form, other) in [
        ("semicolons", text.replace(',', ";")),
        ("tabs", text.replace(',', "\t")),
        ("breaks of Windows", text.replace('\n', "\r\n")),
        ("a byte order mark", format!("\u{feff}{text}")),
        ("no break at the end", text.trim_end().to_owned()),
    ] {
        let outcome = Sandbox::with(DEMO_SCENE, &other).replay("scene.toml", &[]);
        for key in ["probes", "bearings", "flaws"] {
            assert_eq!(outcome[key], plain[key], "{form}: {key}");
        }
    }
}

#[test]
fn recording_is_compared_with_a_learned_baseline() {
    let sandbox = Sandbox::empty();
    let scene = recorded("healthy.toml");
    for recording in ["outer-spall.csv", "unbalanced.csv"] {
        sandbox.put(recording, head(&std::fs::read_to_string(recorded(recording)).unwrap(), DIAGNOSED));
    }
    let run =
        |recording: &str, option: &str, file: &str| sandbox.replay(&scene, &["--recording", recording, option, file]);
    run("outer-spall.csv", "--learn", "spalled.json");
    assert!(sandbox.read("spalled.json").contains("\"ballrace_baseline\": 1"));
    let again = run("outer-spall.csv", "--baseline", "spalled.json");
    assert_eq!(diagnoses(&again), [], "nothing new since the baseline");
    let other = run("unbalanced.csv", "--baseline", "spalled.json");
    assert_eq!(diagnoses(&other)[0], ("unbalance", None));
}
