//! The demonstration as it would come from other wiring: the results are those of the original.

mod drifting_cage;
mod snapshots;

use super::*;
use crate::check::check;
use ballrace_scene::read::read_file;
use std::f64::consts::TAU;
use tempfile::TempDir;

const SCENE: &str = include_str!("../../demo/healthy.toml");
const RECORDING: &str = include_str!("../../../tests/recordings/healthy.csv");
const RATE: f64 = 12_800.0;
/// Rows that are used.
const ROWS: usize = 6400;

/// Turns of the shaft at a sample of the demonstration.
fn turns(sample: usize) -> f64 {
    50.0 * sample as f64 / RATE
}

/// Run-out under probe `probe`, um.
fn run_out(probe: usize, turns: f64) -> f64 {
    let angle = TAU * turns - 1.3 * probe as f64;
    // Without its mean, which would be part of the gap.
    let dip = (0.5 + 0.5 * (angle - 1.0).cos()).powi(8) - 0.196_38;
    3.0 * angle.cos() + 1.5 * (2.0 * angle).sin() - 2.0 * dip
}

/// Writes a recording of the readings (um, then the keyphasor), changed by `change` (sample, column, value).
fn write(path: &Path, rows: impl Iterator<Item = Vec<f64>>, change: impl Fn(usize, usize, f64) -> f64) {
    let mut text = String::from("DE_X_um,DE_Y_um,NDE_X_um,NDE_Y_um,axial_um,keyphasor\n");
    for (sample, row) in rows.enumerate() {
        let cells: Vec<String> =
            row.iter().enumerate().map(|(column, value)| change(sample, column, *value).to_string()).collect();
        text += &cells.join(",");
        text.push('\n');
    }
    std::fs::write(path, text).unwrap();
}

fn demonstration() -> impl Iterator<Item = Vec<f64>> {
    let cells = |line: &str| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect();
    RECORDING.lines().skip(1).take(ROWS).map(cells)
}

/// Slow roll at 4 turns a second: the run-out over a gap of 20 um.
fn slow_roll() -> impl Iterator<Item = Vec<f64>> {
    let mut last = -1.0;
    (0..28_000_usize).map(move |sample| {
        let turns = 4.0 * sample as f64 / RATE - 0.2;
        let pulse = f64::from(u8::from(turns.floor() > last));
        last = turns.floor();
        (0..5).map(|probe| 20.0 + run_out(probe, turns) + 0.01 * (sample as f64 * 1.7).sin()).chain([pulse]).collect()
    })
}

/// Residual and 1X of every probe, um, and the outcome.
fn replayed(folder: &TempDir, scene: &str) -> (Vec<[f64; 3]>, Outcome) {
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, scene).unwrap();
    let scene = read_file(&path).unwrap();
    let (reader, _) = open(&scene, None).unwrap();
    let outcome = replay(&scene, reader, "healthy.csv", &Options::default()).unwrap();
    let probe = |p: &outcome::ProbeOutcome| [p.residual_rms_um, p.measured.one_x_um, p.measured.mean_um];
    (outcome.probes.iter().map(probe).collect(), outcome)
}

fn assert_near(found: &[[f64; 3]], wanted: &[[f64; 3]], most: f64) {
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().flatten().zip(wanted.iter().flatten()) {
        assert!((found - wanted).abs() < most, "{found} um, {wanted} um expected");
    }
}

#[test]
fn probes_in_volts_and_run_out() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("healthy.csv");
    write(&file, demonstration(), |_, _, value| value);
    let (original, outcome) = replayed(&folder, SCENE);
    assert!(outcome.record.angle_source.ends_with("1 per revolution; rising through 0.5, hysteresis 0.2"));

    // Proximity probes of 7.87 mV/um at a gap of -9.5 V, and a keyphasor over a notch.
    let volts = |sample: usize, column: usize, value: f64| match column {
        5 => -8.0 - 4.0 * (f64::from(u8::from((turns(sample) + 1e-9).fract() < 0.05))),
        _ => -9.5 + 7.87e-3 * value,
    };
    write(&file, demonstration(), volts);
    let wired = SCENE
        .replace("unit = \"um\"", "unit = \"V\", sensitivity = \"7.87 mV/um\", offset = \"-9.5 V\"")
        .replace("pulses_per_turn = 1", "pulses_per_turn = 1, unit = \"V\"");
    let (found, outcome) = replayed(&folder, &wired);
    assert_near(&found, &original, 1e-3);
    let source = &outcome.record.angle_source;
    assert!(source.ends_with("; falling through -10 V, hysteresis 0.8 V"), "{source}");
    let scene = read_file(&folder.path().join("scene.toml")).unwrap();
    let (reader, _) = open(&scene, None).unwrap();
    let checked = check(&scene, Some(reader), "healthy.csv", &|_, _| {}).unwrap();
    let voltage = checked.recording.as_ref().unwrap().readings[0].voltage.unwrap();
    assert!((voltage.sensitivity_mv_per_um - 7.87).abs() < 1e-9 && (voltage.offset_v + 9.5).abs() < 1e-9);
    assert!((voltage.mean_v + 9.5 - 7.87e-3 * original[0][2]).abs() < 1e-4, "{}", voltage.mean_v);

    // Run-out in the readings, first without and then with compensation.
    let with_run_out = |sample: usize, column: usize, value: f64| match column {
        5 => value,
        _ => value + run_out(column, turns(sample)),
    };
    write(&file, demonstration(), with_run_out);
    write(&folder.path().join("slow-roll.csv"), slow_roll(), |_, _, value| value);
    let (disturbed, _) = replayed(&folder, SCENE);
    let compensated = SCENE.replace("[recording]\n", "[recording]\nrun_out = \"slow-roll.csv\"\n");
    let (found, outcome) = replayed(&folder, &compensated);
    let worst = |all: &[[f64; 3]]| all.iter().map(|[residual, ..]| *residual).fold(0.0, f64::max);
    println!(
        "residual, um: {} original, {} with run-out, {} compensated",
        worst(&original),
        worst(&disturbed),
        worst(&found)
    );
    assert!(worst(&disturbed) > 1.0);
    for (found, original) in found.iter().zip(&original) {
        assert!((found[1] - original[1]).abs() < 0.05, "1X: {} um, {} um expected", found[1], original[1]);
        assert!((found[0] - original[0]).abs() < 0.05, "residual: {} um, {} um expected", found[0], original[0]);
        assert!((found[2] - original[2]).abs() < 0.02, "mean: {} um, {} um expected", found[2], original[2]);
    }
    assert!(
        outcome.notes.iter().any(|note| note.starts_with("The run-out in ") && note.contains("DE_X_um 2.")),
        "{:?}",
        outcome.notes
    );
    let scene = read_file(&folder.path().join("scene.toml")).unwrap();
    let (reader, _) = open(&scene, None).unwrap();
    let checked = check(&scene, Some(reader), "healthy.csv", &|_, _| {}).unwrap();
    let summary = checked.recording.unwrap();
    let [one_x, _] = summary.readings[0].one_x.unwrap();
    assert!((one_x - original[0][1]).abs() < 0.05 && summary.run_out.is_some(), "{one_x}");

    // A recording at full speed is no slow roll.
    let fast = SCENE.replace("[recording]\n", "[recording]\nrun_out = \"healthy.csv\"\n");
    std::fs::write(folder.path().join("scene.toml"), fast).unwrap();
    let scene = read_file(&folder.path().join("scene.toml")).unwrap();
    let (reader, _) = open(&scene, None).unwrap();
    let error = replay(&scene, reader, "healthy.csv", &Options::default()).unwrap_err();
    assert!(error.is_usage_error() && error.to_string().contains("shaft too fast: 300"), "{error}");
}

/// Limits on readings and on residuals, missing readings, and a shaft that stops and starts: all that the two steps of a replay share.
#[test]
fn one_processor_and_several_give_the_same_outcome() {
    const STARTS_AGAIN: usize = ROWS + 64_000;
    let folder = tempfile::tempdir().unwrap();
    let changed = |sample: usize, column: usize, value: f64| match (sample, column) {
        (900..920, 2) => f64::NAN,
        // Five seconds without a pulse.
        (ROWS..STARTS_AGAIN, 5) => 0.0,
        _ => value,
    };
    let still = demonstration().last().into_iter().cycle().take(STARTS_AGAIN - ROWS);
    let rows = demonstration().chain(still).chain(demonstration());
    write(&folder.path().join("healthy.csv"), rows, changed);
    let scene = format!(
        "{SCENE}\n[[limit]]\nindicator = \"peak-to-peak\"\nmax = \"0.1 um\"\n\n[[limit]]\nindicator = \"residual\"\nmax = \"1 nm\"\n"
    );
    let outcome = || {
        let (_, outcome) = replayed(&folder, &scene);
        let mut json = serde_json::to_value(&outcome).unwrap();
        json["timing"] = serde_json::Value::Null;
        (json, outcome)
    };
    let (several, found) = outcome();
    let (one, _) = ballrace_base::parallel::on_this_thread(outcome);
    assert_eq!(several, one);
    for indicator in ["peak-to-peak", "residual"] {
        assert!(found.events.iter().any(|event| event.sentence.contains(indicator)), "{indicator}: {:?}", found.events);
    }
    assert!(found.record.compared < found.record.samples, "{} of {}", found.record.compared, found.record.samples);
}
