//! Mean time of a sample in a replay, stage by stage: `cargo build --release && cargo bench -p ballrace-benches --bench replay` writes the table in
//! `docs/src/performance.md`. The program is the release binary.

mod marks;

use marks::Marks;
use serde_json::Value;
use std::error::Error;
use std::path::Path;
use std::process::Command;
use std::{env, fs};

/// Replays of each recording; the table holds the median of each figure.
const RUNS: usize = 5;
const STAGES: [&str; 4] = ["twin", "observer", "forces", "comparison"];
/// Every sample of a rig at 51.2 kHz goes to the twin, for this long.
const DURATION: &str = "4 s";

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    // Without the option that `cargo bench` gives, this is `cargo test`, which measures nothing.
    if !env::args().any(|argument| argument == "--bench") {
        return Ok(());
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let program = root.join("target/release/ballrace");
    let folder = tempfile::tempdir()?;
    let scene = fs::read_to_string(root.join("benches/load/scene.toml"))?;
    let full_rate = scene.replace("average = 8\n", "").replace("step = \"78.2 us\"\n", "step = \"19.6 us\"\n");
    fs::write(folder.path().join("rig.toml"), full_rate)?;
    let simulated = ["simulate", "rig.toml", "--duration", DURATION, "--as-recording", "-o", "rig.npy"];
    run(&program, folder.path(), &simulated)?;
    let processors = std::thread::available_parallelism()?;
    let mut lines = vec![
        format!("| us of a sample | twin | observer | forces | comparison | all, {processors} processors |"),
        "| --- | --: | --: | --: | --: | --: |".to_owned(),
    ];
    let recordings: [(&str, &[&str]); 2] = [
        ("demonstration", &[]),
        ("five probes at 51.2 kHz, two `tabulated` bearings of 16 balls", &["rig.toml", "--recording", "rig.npy"]),
    ];
    for (name, recording) in recordings {
        let arguments = [&["replay", "--no-report", "--format", "json"], recording].concat();
        let runs = (0..RUNS).map(|_| stages(&run(&program, folder.path(), &arguments)?)).collect::<Result<Vec<_>>>()?;
        let median = |i: usize| {
            let mut values: Vec<f64> = runs.iter().map(|run| run[i]).collect();
            values.sort_by(f64::total_cmp);
            values[RUNS / 2]
        };
        let mut cells: Vec<String> = (0..=STAGES.len()).map(|i| format!("{:.2}", median(i))).collect();
        if !recording.is_empty() {
            // The last block of a longer recording is diagnosed within this time.
            cells[STAGES.len()] = "–".to_owned();
        }
        lines.push(format!("| {name} | {} |", cells.join(" | ")));
    }
    let table = lines.join("\n");
    println!("{table}");
    let chapter = root.join("docs/src/performance.md");
    let text = fs::read_to_string(&chapter)?;
    fs::write(chapter, Marks("replay").replaced(&text, &table).ok_or("no marks in docs/src/performance.md")?)?;
    Ok(())
}

fn run(program: &Path, folder: &Path, arguments: &[&str]) -> Result<Vec<u8>> {
    let output = Command::new(program).args(arguments).current_dir(folder).output()?;
    if output.stdout.is_empty() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    Ok(output.stdout)
}

/// Returns the mean times of a sample in the stages and in all, us.
fn stages(json: &[u8]) -> Result<Vec<f64>> {
    let outcome: Value = serde_json::from_slice(json)?;
    let number = |pointer: &str| outcome.pointer(pointer).and_then(Value::as_f64).ok_or(format!("no {pointer}"));
    let mut times = STAGES
        .iter()
        .map(|stage| Ok(number(&format!("/timing/stages/{stage}_ns"))? * 1e-3))
        .collect::<Result<Vec<_>>>()?;
    times.push(number("/timing/wall_s")? * 1e6 / number("/timing/samples")?);
    Ok(times)
}
