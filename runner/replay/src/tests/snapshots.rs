use crate::{Options, open, replay};
use ballrace_outcome::{FaultKind, Outcome};
use ballrace_scene::Scene;
use ballrace_scene::read::read_str;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

const RATE: f64 = 25_600.0;
const TURN_HZ: f64 = 30.0;
const ROWS: usize = 2560;
/// Order of the outer race of the scene.
const ORDER: f64 = 4.5 * (1.0 - 7.94 / 39.04);

fn scene(folder: &Path, keys: &str) -> Scene {
    let text = format!(
        "[shaft]\nspeed = \"1800 rpm\"\n[[bearing]]\nname = \"DE\"\nstation = \"0 mm\"\nfacing = \"both\"\nmodel = \"angular\"\n\
         elements = 9\nball_diameter = \"7.94 mm\"\npitch_diameter = \"39.04 mm\"\ninner_conformity = 0.52\nouter_conformity = 0.52\n\
         contact_angle = \"0 deg\"\n[recording]\nfile = \"set\"\nrate = \"25.6 kHz\"\nheader = false\n\
         sensors = [{{ column = \"c4\", unit = \"g\" }}]\n{keys}"
    );
    read_str(&text, &folder.join("scene.toml")).unwrap()
}

/// Uniform numbers, -1 to 1.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Writes a snapshot with impacts of the outer race, in the layout of FEMTO: hour, minute, second, microsecond, acceleration.
fn write(path: &Path, seed: u64, strength: f64, rows: usize) {
    let mut noise = noise(seed);
    let mut signal: Vec<f64> = (0..rows).map(|_| 0.3 * noise()).collect();
    let mut at = (1.0 + noise()) / (ORDER * TURN_HZ);
    while strength > 0.0 && at < rows as f64 / RATE {
        for (i, x) in signal.iter_mut().enumerate().skip((at * RATE).ceil() as usize).take(200) {
            let t = i as f64 / RATE - at;
            *x += strength * (-900.0 * t).exp() * (TAU * 7100.0 * t).sin();
        }
        at += (1.0 + 5e-3 * noise()) / (ORDER * TURN_HZ);
    }
    let mut text = String::new();
    for (i, x) in signal.iter().enumerate() {
        writeln!(text, "9,39,39,{},{x:.5}", i * 39).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// A set of snapshots of which number `i` has impacts of `strength(i)`.
fn set(count: usize, strength: impl Fn(usize) -> f64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("set")).unwrap();
    for i in 0..count {
        write(&folder.path().join(format!("set/acc_{}.csv", i + 1)), i as u64 + 1, strength(i), ROWS);
    }
    folder
}

fn evaluated(folder: &Path) -> ballrace_plant::error::Result<Outcome> {
    let scene = scene(folder, "sequence = \"snapshots\"");
    let (reader, _) = open(&scene, None)?;
    replay(&scene, reader, "set", &Options::default())
}

#[test]
fn a_growing_fault_is_found_with_its_onset() {
    // From snapshot 181 on, 0.2 dB a snapshot.
    let folder = set(300, |i| if i < 180 { 0.0 } else { 0.3 * 1.023_f64.powi(i as i32 - 180) });
    let outcome = evaluated(folder.path()).unwrap();
    let kinds: Vec<FaultKind> = outcome.diagnoses.iter().map(|diagnosis| diagnosis.kind).collect();
    assert_eq!(kinds, [FaultKind::OuterRace], "{}", outcome.verdict);
    assert_eq!((outcome.snapshots.len(), outcome.snapshots[9].file.as_str()), (300, "acc_10.csv"));
    let trend = |indicator: &str| {
        let is_outer = |kind: Option<FaultKind>| kind.is_none_or(|kind| kind == FaultKind::OuterRace);
        outcome.snapshot_trends.iter().find(|t| t.indicator == indicator && is_outer(t.component)).unwrap()
    };
    for indicator in ["rms", "kurtosis", "line"] {
        let found = trend(indicator);
        let onset = found.onset.unwrap_or(0);
        assert!(found.growth_db > 3.0 && (175..=235).contains(&onset), "{found:?}");
    }
    assert!(outcome.verdict.contains("Its level has grown by "), "{}", outcome.verdict);
    assert!(
        outcome
            .notes
            .iter()
            .any(|note| note.contains("Each snapshot has 3.00 revolutions; the verdict is on 30 snapshots (90.0 rev")),
        "{:?}",
        outcome.notes
    );
    assert!(outcome.notes.iter().any(|note| note.starts_with("Lines closer than 0.33 orders are not separated")));
}

#[test]
fn sound_snapshots_have_no_onset() {
    let folder = set(300, |_| 0.0);
    let outcome = evaluated(folder.path()).unwrap();
    assert!(outcome.diagnoses.is_empty(), "{}", outcome.verdict);
    let onsets: Vec<_> = outcome.snapshot_trends.iter().filter(|trend| trend.onset.is_some()).collect();
    assert!(onsets.is_empty() && outcome.snapshot_trends.len() == 7, "{onsets:?}");
}

#[test]
fn snapshots_that_cannot_be_used_are_left_out() {
    let folder = set(20, |_| 3.0);
    let path = |i: usize| folder.path().join(format!("set/acc_{i}.csv"));
    write(&path(3), 3, 3.0, ROWS - 7);
    std::fs::write(path(5), "time;value\nnine;ten\n").unwrap();
    std::fs::write(path(1), "").unwrap();
    let outcome = evaluated(folder.path()).unwrap();
    assert_eq!(outcome.snapshots.len(), 17);
    let note = outcome.notes.iter().find(|note| note.contains("are omitted")).unwrap();
    assert!(note.starts_with("3 of 20 snapshots are omitted: acc_1.csv (empty file"), "{note}");
    assert!(note.contains("acc_3.csv (2553 rows, expected 2560 as in the first), acc_5.csv ("), "{note}");
    assert_eq!(outcome.diagnoses[0].kind, FaultKind::OuterRace);
}

#[test]
fn too_few_revolutions_are_not_judged() {
    let folder = set(4, |_| 3.0);
    let outcome = evaluated(folder.path()).unwrap();
    assert_eq!(
        outcome.verdict,
        "No verdict: 12.0 revolutions of the shaft in the last snapshots, expected 16 or more."
    );
    assert!(outcome.diagnoses.is_empty() && outcome.snapshots.len() == 4);
}
