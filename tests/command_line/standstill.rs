//! Recordings and monitors whose shaft does not turn: the report has what was measured, and nothing is diagnosed.

use serde_json::Value;
use std::io::Write;
use std::time::Instant;

use crate::live::{connected, frame, kinds, listening, rows};
use crate::live_start::{PROMPT, at_rest_with_gap, ended, terminate, wait_for_event};
use crate::support::{DEMO_SCENE, Sandbox, TURN, edited_recording, list, number, short_recording, swap, with_cell};

const KEYPHASOR: usize = 6;

/// The demonstration's first turns with another cell of the keyphasor.
fn with_keyphasor(cell: &str) -> String {
    edited_recording(|line, row| vec![if line > 1 { with_cell(row, KEYPHASOR, cell) } else { row.into() }])
}

/// The range and the mean of DE_X_um in a recording.
fn range_and_mean(recording: &str) -> (f64, f64) {
    let readings: Vec<f64> = recording.lines().skip(1).map(|l| l.split(',').nth(1).unwrap().parse().unwrap()).collect();
    let (low, high) = readings.iter().fold((f64::MAX, f64::MIN), |(low, high), y| (low.min(*y), high.max(*y)));
    (high - low, readings.iter().sum::<f64>() / readings.len() as f64)
}

/// The report of readings without a shaft angle.
fn check_readings(outcome: &Value, recording: &str, cause: &str) {
    let verdict = outcome["verdict"].as_str().unwrap();
    assert!(verdict.contains(cause), "{verdict}");
    let notes = outcome["notes"].to_string();
    assert!(notes.contains("nothing is compared with the twin and nothing is diagnosed"), "{notes}");
    let samples = recording.lines().count() as f64 - 1.0;
    assert_eq!((number(outcome, "/record/samples"), number(outcome, "/record/compared")), (samples, 0.0));
    assert_eq!(number(outcome, "/record/rate_hz"), 12_800.0);
    assert!((number(outcome, "/record/duration_s") - (samples - 1.0) / 12_800.0).abs() < 1e-9);
    let (range, mean) = range_and_mean(recording);
    for (pointer, expected) in [
        ("/probes/0/measured/peak_to_peak_um", range),
        ("/probes/0/measured/mean_um", mean),
        ("/probes/0/list/direct_um_pp", range),
        ("/probes/0/list/gap_um", mean),
    ] {
        let found = number(outcome, pointer);
        assert!((found - expected).abs() < 1e-6 * expected.abs().max(1.0), "{pointer}: {found}, expected {expected}");
    }
    for absent in ["/probes/0/twin/mean_um", "/probes/0/residual_rms_um", "/bearings/0/force_measured/0/mean"] {
        assert!(outcome.pointer(absent).unwrap().is_null(), "{absent} of {outcome:#}");
    }
    assert!(list(outcome, "findings").is_empty());
}

/// Replays a recording whose shaft angle cannot be found, in every format.
fn reported(scene: &str, recording: &str, code: i32, cause: &str) {
    let sandbox = Sandbox::with(scene, recording);
    let args = ["replay", "scene.toml", "--learn", "learned.json", "--forces", "forces.csv", "--format"];
    let run = |format: &str| {
        let answer = sandbox.run(&[&args[..], &[format]].concat());
        assert!(answer.code == Some(code) && answer.err.is_empty(), "{answer:?}");
        answer
    };
    check_readings(&run("json").json(), recording, cause);
    let text = run("text").out;
    for part in [cause, "MOTION AT THE PROBES", "DE_X_um", "not judged", "none compared"] {
        assert!(text.split_whitespace().collect::<Vec<_>>().join(" ").contains(part), "{part:?} is not in {text}");
    }
    for part in ["RESIDUAL, measured", "FORCES", "twin  ", "NaN", "follows"] {
        assert!(!text.contains(part), "{part:?} in {text}");
    }
    assert!(run("csv").out.contains("DE_X_um"));
    let page = sandbox.page("scene-report.html");
    assert!(page.contains("Tabular list") && !page.contains("NaN"));
    assert!(!page.contains("Forces on the inner rings"));
    assert_eq!(page.matches("<svg").count(), 1, "the rotor alone");
    assert_eq!(sandbox.read("forces.csv").lines().count(), 1);
    assert!(!sandbox.files().contains(&"learned.json".to_owned()), "it is no baseline");
}

#[test]
fn a_keyphasor_without_pulses() {
    let cause =
        "the shaft did not turn: column keyphasor: no keyphasor pulses in 2048 samples: it stays between 0 and 0";
    reported(DEMO_SCENE, &with_keyphasor("0"), 0, cause);
}

#[test]
fn a_keyphasor_without_a_value() {
    reported(DEMO_SCENE, &with_keyphasor("nan"), 0, "no keyphasor pulses in 2048 samples: it has no value");
}

#[test]
fn a_recording_shorter_than_a_turn() {
    let cause = "one keyphasor pulse only, at line 3: the recording is shorter than a turn";
    reported(DEMO_SCENE, &short_recording(TURN - 20), 0, cause);
    reported(DEMO_SCENE, &short_recording(1), 0, "no keyphasor pulses in 1 samples");
}

#[test]
fn invalid_speeds() {
    let keyphasor = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
    let scene = swap(DEMO_SCENE, keyphasor, "speed = { column = \"keyphasor\", unit = \"rpm\" }");
    reported(&scene, &with_keyphasor("nan"), 0, "the shaft speed is not measured");
    reported(
        &scene,
        &with_keyphasor("1e30"),
        4,
        "not plausible for the scene: shaft angle: column keyphasor: no plausible speed in 2048 readings",
    );
}

/// The shaft turns, stands for 30 turns' time, and turns again.
#[test]
fn a_standstill_in_the_middle_of_a_recording() {
    let rows = |range: std::ops::Range<usize>| {
        short_recording(12_800).lines().skip(1 + range.start).take(range.len()).map(str::to_owned).collect::<Vec<_>>()
    };
    let still = rows(0..1)[0].clone();
    let mut lines = vec![short_recording(0).trim().to_owned()];
    lines.extend(rows(0..16 * TURN));
    lines.extend((0..30 * TURN).map(|i| with_cell(&still, 1, &format!("{}", 0.1 * (i % 7) as f64))));
    lines.extend(rows(0..16 * TURN));
    let sandbox = Sandbox::with(DEMO_SCENE, &(lines.join("\n") + "\n"));
    let outcome = sandbox.replay("scene.toml", &[]);
    let compared = number(&outcome, "/record/compared");
    assert!(compared > 20.0 * TURN as f64, "{compared}");
    let (verdict, notes) = (outcome["verdict"].as_str().unwrap(), outcome["notes"].to_string());
    assert!(verdict.starts_with("No verdict: the shaft angle is not measured in"), "{verdict}");
    assert!(notes.contains("samples have no shaft angle") && notes.contains("standstill"), "{notes}");
}

/// A monitor that is stopped before the shaft turns ends at once, with exit code 0 and a report.
#[test]
fn a_monitor_stopped_before_the_shaft_turns() {
    let recording = with_keyphasor("0");
    let sandbox = Sandbox::with(DEMO_SCENE, &recording);
    let (child, port) = listening(&sandbox, "tcp", &["--events", "events.jsonl", "--report", "r.html"]);
    let mut stream = connected(port);
    stream.write_all(recording.as_bytes()).unwrap();
    drop(stream);
    wait_for_event(&sandbox, "events.jsonl", "source-gone");
    let since = Instant::now();
    terminate(child.id());
    let output = ended(child);
    println!("ended after {:?}", since.elapsed());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    check_readings(&serde_json::from_slice(&output.stdout).unwrap(), &recording, "the shaft did not turn");
    assert!(sandbox.read("r.html").contains("</html>"));
}

/// After 10 s without a pulse the monitor reports it and goes on; readings until then are in the report.
#[test]
fn a_monitor_at_standstill_for_longer_than_it_waits() {
    let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(TURN));
    let (child, port) = listening(&sandbox, "tcp", &["--encoding", "frames", "--events", "events.jsonl"]);
    let mut still = rows(TURN)[10].clone();
    still[5] = 0.0;
    let mut stream = connected(port);
    (0..140_000).for_each(|sequence| stream.write_all(&frame(sequence, &still)).unwrap());
    drop(stream);
    wait_for_event(&sandbox, "events.jsonl", "source-gone");
    wait_for_event(&sandbox, "events.jsonl", "shaft-not-turning");
    terminate(child.id());
    let output = ended(child);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let outcome: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(number(&outcome, "/record/samples"), 140_000.0);
    let mean = number(&outcome, "/probes/0/measured/mean_um");
    assert!((mean - f64::from(still[0])).abs() < 1e-6, "{mean}");
    assert_eq!(kinds(&sandbox, "events.jsonl").iter().filter(|kind| *kind == "shaft-not-turning").count(), 1);
}

/// A source at 0 rpm that pauses for 10 min of its time: no loop runs through the gap.
#[test]
fn a_gap_at_standstill_does_not_hold_up_a_signal() {
    let sandbox = at_rest_with_gap(600.0);
    let (child, port) = listening(&sandbox, "tcp", &["--events", "events.jsonl"]);
    let mut stream = connected(port);
    stream.write_all(sandbox.read("healthy.csv").as_bytes()).unwrap();
    drop(stream);
    wait_for_event(&sandbox, "events.jsonl", "source-gone");
    let since = Instant::now();
    terminate(child.id());
    let output = ended(child);
    let took = since.elapsed();
    println!("ended after {took:?}");
    assert!(took < PROMPT, "{took:?}");
    // A shaft at 0 rpm is not the scene's at 3000 rpm.
    assert_eq!(output.status.code(), Some(4), "{output:?}");
    let outcome: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(number(&outcome, "/record/samples"), 4096.0);
    let gap = list(&outcome, "flaws").iter().find(|flaw| flaw["kind"] == "gap").unwrap();
    assert_eq!(gap["samples_affected"], 600 * 12_800);
}
