//! Long recordings: the memory of `replay` does not grow with them.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::process::Command;

use serde_json::Value;

use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, Sandbox, list, number};

/// The demonstration's rows over and over: 50 whole turns each time, so that the keyphasor goes on evenly. Gives the
/// number of samples.
///
/// `spare` columns that no probe uses follow the others, as in the recordings of many-channel systems.
fn write_repeated(sandbox: &Sandbox, at_least: u64, spare: usize) -> f64 {
    let (header, rows) = HEALTHY_RECORDING.split_once('\n').unwrap();
    let names: String = (0..spare).map(|i| format!(",spare_{i}")).collect();
    let cells = ",-12.345".repeat(spare);
    let rows: String = rows.lines().map(|row| format!("{row}{cells}\n")).collect();
    let mut file = BufWriter::new(File::create(sandbox.path("healthy.csv")).unwrap());
    writeln!(file, "{header}{names}").unwrap();
    let times = at_least.div_ceil(rows.len() as u64);
    for _ in 0..times {
        file.write_all(rows.as_bytes()).unwrap();
    }
    file.flush().unwrap();
    (times * rows.lines().count() as u64) as f64
}

/// The outcome and the peak memory of the process, where the system reports it.
fn replayed(sandbox: &Sandbox, samples: f64) -> (Value, Option<f64>) {
    let outcome = sandbox.replay("scene.toml", &[]);
    assert_eq!(number(&outcome, "/record/compared"), samples);
    assert_eq!((list(&outcome, "flaws").len(), list(&outcome, "findings").len()), (0, 0), "{outcome:#}");
    for probe in list(&outcome, "probes") {
        assert!(number(probe, "/residual_rms_um") < 1.5 * number(probe, "/noise_um"), "{probe:#}");
    }
    let memory = outcome["timing"]["peak_memory_bytes"].as_f64();
    (outcome, memory)
}

/// The peak memory of a recording of 64 000 samples, nearly the longest that is read ahead to its end.
fn short() -> Option<f64> {
    let sandbox = Sandbox::with(DEMO_SCENE, "");
    let samples = write_repeated(&sandbox, 4 * HEALTHY_RECORDING.len() as u64 + 1, 0);
    replayed(&sandbox, samples).1
}

/// The peak memory of a longer recording is below `factor` times that of a short one.
fn assert_no_larger(long: Option<f64>, factor: f64) {
    let (Some(short), Some(long)) = (short(), long) else {
        assert_ne!(std::env::consts::OS, "linux", "Linux tells the peak memory");
        return println!("not compared: this system does not tell the peak memory");
    };
    println!("peak memory: {:.1} MB, of a short recording {:.1} MB", long / 1e6, short / 1e6);
    assert!(long < factor * short, "{long} against {short} bytes");
}

#[test]
fn recording_ten_times_as_long() {
    let sandbox = Sandbox::with(DEMO_SCENE, "");
    let samples = write_repeated(&sandbox, 9 * HEALTHY_RECORDING.len() as u64 + 1, 0);
    assert_eq!(samples, 128_000.0);
    let (outcome, memory) = replayed(&sandbox, samples);
    assert!((number(&outcome, "/record/turns") - 500.0).abs() < 0.01);
    assert_no_larger(memory, 1.2);
}

/// Free bytes in the folder of the sandbox, by `df`.
fn free_bytes(sandbox: &Sandbox) -> Option<u64> {
    let output = Command::new("df").arg("-Pk").arg(sandbox.path("")).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let blocks: u64 = text.lines().nth(1)?.split_whitespace().nth(3)?.parse().ok()?;
    Some(1024 * blocks)
}

#[test]
#[ignore = "writes and replays 1 GB; tests/run --all runs it"]
fn one_gigabyte() {
    const MIN_FREE: u64 = 3_000_000_000;
    let sandbox = Sandbox::with(DEMO_SCENE, "");
    match free_bytes(&sandbox) {
        Some(free) if free >= MIN_FREE => {}
        Some(free) => return println!("skipped: {:.1} GB free for temporary files, 3 GB needed", free as f64 / 1e9),
        None => return println!("skipped: df does not tell how much is free for temporary files"),
    }
    let samples = write_repeated(&sandbox, 1 << 30, 12);
    let (outcome, memory) = replayed(&sandbox, samples);
    println!("{samples} samples, {:.0} times real time", number(&outcome, "/timing/times_real_time"));
    assert_no_larger(memory, 1.5);
}
