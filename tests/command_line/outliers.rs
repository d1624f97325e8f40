//! Single bad samples: they are omitted, flagged and reported, and leave no trace in what comes after.

use serde_json::Value;

use crate::support::{
    DEMO_SCENE, HEALTHY_RECORDING, SHORT, Sandbox, list, number, numbers, short_recording, swap, with_cell,
};

const BAD: usize = 1000;

/// The short recording with one cell replaced.
fn with_bad(column: usize, cell: &str) -> String {
    replaced(&short_recording(SHORT), column, cell)
}

fn replaced(recording: &str, column: usize, cell: &str) -> String {
    let replaced = |(i, row): (usize, &str)| if i == BAD + 1 { with_cell(row, column, cell) } else { row.to_owned() };
    recording.lines().enumerate().map(|line| replaced(line) + "\n").collect()
}

/// Outcome and forces of a replay.
fn replayed(scene: &str, recording: &str) -> (Value, Vec<Vec<f64>>) {
    let sandbox = Sandbox::with(scene, recording);
    let outcome = sandbox.replay("scene.toml", &["--forces", "forces.csv"]);
    (outcome, numbers(&sandbox.read("forces.csv")).1)
}

fn status(row: &[f64]) -> u16 {
    row[row.len() - 1] as u16
}

/// The bad sample alone is flagged with `flag`, and no force elsewhere differs by more than `most` newton.
fn leaves_no_trace(plain: &[Vec<f64>], found: &[Vec<f64>], flag: u16, most: f64) {
    assert_eq!(plain.len(), found.len());
    for (i, (a, b)) in plain.iter().zip(found).enumerate() {
        let expected = if i == BAD { flag } else { 0 };
        assert_eq!(status(b) & !1, expected, "sample {i}: {b:?}");
        let off = a[1..a.len() - 1].iter().zip(&b[1..]).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        assert!(off <= most, "sample {i}: {off} N");
    }
}

#[test]
fn a_wild_reading() {
    let (plain, forces) = replayed(DEMO_SCENE, &short_recording(SHORT));
    for cell in ["1e4", "1e7", "-1e12"] {
        let (outcome, found) = replayed(DEMO_SCENE, &with_bad(1, cell));
        leaves_no_trace(&forces, &found, 256, 2.0);
        let flaw = &list(&outcome, "flaws")[0];
        assert_eq!(
            (flaw["kind"].as_str(), flaw["first_line"].as_u64()),
            (Some("reading_out_of_range"), Some(BAD as u64 + 2))
        );
        for (a, b) in list(&plain, "probes").iter().zip(list(&outcome, "probes")) {
            let ratio = number(b, "/residual_rms_um") / number(a, "/residual_rms_um");
            assert!((ratio - 1.0).abs() < 0.01, "{cell}: {ratio}");
        }
        let verdict = outcome["verdict"].as_str().unwrap();
        assert!(verdict.contains("1 sample with a reading out of range is omitted"), "{verdict}");
    }
}

/// The same before the twin has started, where the observer takes its noise from.
#[test]
fn a_wild_reading_at_the_start() {
    let text: String = short_recording(SHORT)
        .lines()
        .enumerate()
        .map(|(i, row)| if i == 50 { with_cell(row, 2, "1e9") } else { row.to_owned() } + "\n")
        .collect();
    let outcome = Sandbox::with(DEMO_SCENE, &text).replay("scene.toml", &[]);
    assert!(number(&outcome, "/observer/nis_mean") < 10.0, "{outcome:#}");
    assert_eq!(number(&outcome, "/observer/distrusted_samples"), 0.0);
}

/// A reading within the range and far outside of the noise: the observer's gate rejects the sample.
#[test]
fn a_reading_beyond_the_gate() {
    let (_, forces) = replayed(DEMO_SCENE, &short_recording(SHORT));
    let (outcome, found) = replayed(DEMO_SCENE, &with_bad(1, "20"));
    leaves_no_trace(&forces, &found, 64, 3.0);
    assert_eq!(number(&outcome, "/observer/rejected_samples"), 1.0);
    assert_eq!(number(&outcome, "/observer/restarts"), 0.0);
}

#[test]
fn a_wild_speed() {
    let keyphasor = "keyphasor = { column = \"keyphasor\", pulses_per_turn = 1 }";
    let scene = swap(DEMO_SCENE, keyphasor, "speed = { column = \"keyphasor\", unit = \"rpm\" }");
    let speeds = |bad: &str| -> String {
        let row = |(i, row): (usize, &str)| match i {
            0 => row.to_owned(),
            _ if i == BAD + 1 => with_cell(row, 6, bad),
            _ => with_cell(row, 6, "3000"),
        };
        short_recording(SHORT).lines().enumerate().map(|line| row(line) + "\n").collect()
    };
    let (plain, forces) = replayed(&scene, &speeds("3000"));
    for bad in ["1e5", "1e9", "1e30", "-1e300"] {
        let (outcome, found) = replayed(&scene, &speeds(bad));
        leaves_no_trace(&forces, &found, 1024, 1e-3);
        assert_eq!(list(&outcome, "flaws")[0]["kind"], "implausible_speed");
        let ratio = number(&outcome, "/probes/0/residual_rms_um") / number(&plain, "/probes/0/residual_rms_um");
        assert!((ratio - 1.0).abs() < 0.01, "{bad}: {ratio}");
    }
}

/// A monitor reports it in its event log.
#[test]
fn a_monitor_reports_a_wild_reading() {
    let sandbox = Sandbox::with(DEMO_SCENE, &replaced(HEALTHY_RECORDING, 1, "1e7"));
    sandbox.done(&["replay", "scene.toml", "--paced", "--events", "events.jsonl"]);
    let events = sandbox.read("events.jsonl");
    let kinds: Vec<Value> =
        events.lines().map(|line| serde_json::from_str::<Value>(line).unwrap()["kind"].clone()).collect();
    assert!(kinds.contains(&Value::from("reading-out-of-range")), "{events}");
}

/// A comma in a bearing's name is quoted in the header, so that every row has as many cells as the header.
#[test]
fn a_comma_in_the_name_of_a_bearing() {
    let sandbox = Sandbox::with(&swap(DEMO_SCENE, "name = \"DE\"", "name = \"DE, left\""), &short_recording(SHORT));
    sandbox.replay("scene.toml", &["--forces", "forces.csv"]);
    sandbox.done(&["simulate", "scene.toml", "--duration", "1 ms", "--rate", "10 kHz", "-o", "motion.csv"]);
    for (file, cell) in [("forces.csv", "\"DE, left_FX_N\""), ("motion.csv", "\"DE, left_FX\"")] {
        let text = sandbox.read(file);
        let mut lines = text.lines();
        let head = lines.next().unwrap();
        assert!(head.contains(cell), "{head}");
        let quotes = head.split('"').skip(1).step_by(2).map(|quoted| quoted.matches(',').count()).sum::<usize>();
        assert_eq!(head.matches(',').count() - quotes, lines.next().unwrap().matches(',').count(), "{head}");
    }
}
