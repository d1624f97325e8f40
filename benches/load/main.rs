//! Monitors many machines at once and prints what they lose:
//! `cargo bench -q -p ballrace-benches --bench load -- --machines 16 --minutes 180`.
//!
//! Each machine has five probes at 51.2 kHz (`scene.toml`) and a monitor of its own, the release binary, which receives frames over TCP and
//! writes events, state and indicators. `--program FILE` measures another binary. With `BALLRACE_WRITE=1` the summary is written to
//! `benches/README.md`.

#[path = "../marks.rs"]
mod marks;
mod source;

use marks::Marks;
use serde_json::Value;
use source::Source;
use std::error::Error;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant};
use std::{env, thread};

const USAGE: &str = "usage: cargo bench -q -p ballrace-benches --bench load -- [--machines N] [--minutes M] [--scene FILE] [--program FILE]";
/// Scene of a machine unless another is given.
const SCENE: &str = include_str!("scene.toml");
/// Sampling rate of the scene, Hz.
const RATE: u64 = 51_200;
/// Duration of the recording that is sent again and again, s: the motion repeats after five revolutions.
const RECORDED: &str = "2 s";
/// Time after which the memory of the monitors is compared with that at the end.
const WARM: Duration = Duration::from_secs(60);

struct Arguments {
    machines: usize,
    minutes: f64,
    scene: String,
    program: PathBuf,
}

impl Arguments {
    fn parse(mut given: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/release/ballrace");
        let mut arguments = Self { machines: 16, minutes: 10.0, scene: SCENE.to_owned(), program };
        while let Some(argument) = given.next() {
            let mut value = || given.next().ok_or_else(|| format!("missing value of {argument}\n{USAGE}"));
            match argument.as_str() {
                "--bench" => {}
                "--machines" => arguments.machines = value()?.parse()?,
                "--minutes" => arguments.minutes = value()?.parse()?,
                "--scene" => arguments.scene = fs::read_to_string(value()?)?,
                "--program" => arguments.program = value()?.into(),
                option => return Err(format!("unknown option {option}\n{USAGE}").into()),
            }
        }
        Ok(arguments)
    }
}

/// A monitor of one machine in a folder of its own.
struct Monitor {
    folder: PathBuf,
    process: Child,
    source: Option<thread::JoinHandle<u64>>,
}

impl Monitor {
    fn start(program: &Path, scene: &str, folder: PathBuf, port: u16) -> Result<Self, Box<dyn Error>> {
        fs::create_dir(&folder)?;
        fs::write(folder.join("scene.toml"), scene)?;
        let process = Command::new(program)
            .args(["replay", "scene.toml", "--paced", "--encoding", "frames", "--format", "json", "--no-report"])
            .args(["--state", "state", "--events", "events.jsonl", "--indicators", "trend"])
            .args(["--source", &format!("tcp:{port}")])
            .current_dir(&folder)
            .stdout(File::create(folder.join("outcome.json"))?)
            .stderr(File::create(folder.join("messages.txt"))?)
            .stdin(Stdio::null())
            .spawn()?;
        Ok(Self { folder, process, source: None })
    }

    /// Resident memory, MB, and processor time, s.
    fn usage(&self) -> Result<[f64; 2], Box<dyn Error>> {
        let read = |name: &str| fs::read_to_string(format!("/proc/{}/{name}", self.process.id()));
        let status = read("status")?;
        let resident = status.lines().find(|line| line.starts_with("VmRSS")).ok_or("no VmRSS")?;
        let kilobytes: f64 = resident.split_whitespace().nth(1).ok_or("no VmRSS")?.parse()?;
        // User and system time are fields 14 and 15; the name before them may have spaces.
        let stat = read("stat")?;
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
        let ticks = |i: usize| fields.get(i).and_then(|field| field.parse::<f64>().ok()).unwrap_or(0.0);
        Ok([kilobytes / 1e3, (ticks(11) + ticks(12)) / 100.0])
    }

    /// Ends the monitor by SIGTERM and returns its outcome.
    fn stop(mut self) -> Result<(Value, u64), Box<dyn Error>> {
        let sent = self.source.take().and_then(|source| source.join().ok()).unwrap_or(0);
        Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status()?;
        self.process.wait()?;
        let text = fs::read_to_string(self.folder.join("outcome.json"))?;
        let outcome = serde_json::from_str(&text).map_err(|error| {
            let messages = fs::read_to_string(self.folder.join("messages.txt")).unwrap_or_default();
            format!("{error}: {messages}")
        })?;
        Ok((outcome, sent))
    }
}

impl Drop for Monitor {
    fn drop(&mut self) {
        let _ = self.process.kill();
    }
}

/// Returns the frames of one recording without their sequence numbers.
fn recorded(program: &Path, scene: &str, folder: &Path) -> Result<Vec<Vec<f32>>, Box<dyn Error>> {
    fs::write(folder.join("scene.toml"), scene)?;
    let simulated = Command::new(program)
        .args(["simulate", "scene.toml", "--duration", RECORDED, "--settle", "2 s", "--as-recording"])
        .args(["-o", "recording.csv"])
        .current_dir(folder)
        .output()?;
    if !simulated.status.success() {
        return Err(String::from_utf8_lossy(&simulated.stderr).into());
    }
    let text = fs::read_to_string(folder.join("recording.csv"))?;
    let mut lines = text.lines();
    let columns: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let first = columns.iter().position(|name| name.ends_with("_um")).ok_or("no probe in the recording")?;
    lines.map(|line| Ok(line.split(',').skip(first).map(str::parse).collect::<Result<_, _>>()?)).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { machines, minutes, scene, program } = Arguments::parse(env::args().skip(1))?;
    let folder = tempfile::tempdir()?;
    let frames = Arc::new(recorded(&program, &scene, folder.path())?);
    let is_over = Arc::new(AtomicBool::new(false));
    let mut monitors = vec![];
    for i in 0..machines {
        let port = source::free_port()?;
        let mut monitor = Monitor::start(&program, &scene, folder.path().join(format!("machine-{}", i + 1)), port)?;
        let (frames, is_over) = (frames.clone(), is_over.clone());
        monitor.source = Some(thread::spawn(move || Source::new(port, &frames).run(RATE, &is_over)));
        monitors.push(monitor);
    }
    let (start, duration) = (Instant::now(), Duration::from_secs_f64(60.0 * minutes));
    thread::sleep(WARM.min(duration / 2));
    let warm = monitors.iter().map(Monitor::usage).collect::<Result<Vec<_>, _>>()?;
    let since = start.elapsed();
    thread::sleep(duration.saturating_sub(since));
    let end = monitors.iter().map(Monitor::usage).collect::<Result<Vec<_>, _>>()?;
    let seconds = (start.elapsed() - since).as_secs_f64();
    is_over.store(true, Relaxed);
    let mut machines = vec![];
    println!(
        "| machine | samples | lost | missed deadlines | share of a core | memory after {:.0} s | at the end |",
        since.as_secs_f64()
    );
    println!("| --- | --: | --: | --: | --: | --: | --: |");
    for (i, (monitor, (warm, end))) in monitors.into_iter().zip(warm.iter().zip(&end)).enumerate() {
        let machine = Machine::new(monitor.stop()?, *warm, *end, seconds);
        println!("| {} {}", i + 1, machine.row());
        machines.push(machine);
    }
    let summary = summary(&machines, minutes);
    println!("\n{summary}");
    if env::var_os("BALLRACE_WRITE").is_some() {
        let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md");
        let text = fs::read_to_string(&readme)?;
        fs::write(&readme, Marks("load").replaced(&text, &summary).ok_or("no marks in benches/README.md")?)?;
    }
    Ok(())
}

/// Figures of one machine.
struct Machine {
    sent: u64,
    /// Samples that were sent and not read.
    lost: u64,
    missed: u64,
    blocks: u64,
    share_of_core: f64,
    /// Resident memory after the start and at the end, MB.
    memory: [f64; 2],
}

impl Machine {
    fn new((outcome, sent): (Value, u64), warm: [f64; 2], end: [f64; 2], seconds: f64) -> Self {
        let of = |pointer: &str| outcome.pointer(pointer).and_then(Value::as_u64).unwrap_or(0);
        Self {
            sent,
            lost: sent - of("/timing/source/rows").min(sent),
            missed: of("/timing/deadline_misses"),
            blocks: of("/timing/blocks"),
            share_of_core: (end[1] - warm[1]) / seconds,
            memory: [warm[0], end[0]],
        }
    }

    fn row(&self) -> String {
        let Self { sent, lost, missed, blocks, share_of_core, memory: [warm, end] } = self;
        format!(
            "| {sent} | {lost} | {missed} of {blocks} | {:.1} % | {warm:.0} MB | {end:.0} MB |",
            100.0 * share_of_core
        )
    }
}

/// Returns the figures of all machines together.
fn summary(machines: &[Machine], minutes: f64) -> String {
    let sum = |of: fn(&Machine) -> u64| machines.iter().map(of).sum::<u64>();
    let missed = 100.0 * sum(|m| m.missed) as f64 / sum(|m| m.blocks).max(1) as f64;
    let cores: f64 = machines.iter().map(|m| m.share_of_core).sum();
    let most = |i: usize| machines.iter().map(|m| m.memory[i]).fold(0.0, f64::max);
    let processors = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!(
        "| machines | minutes | processors | samples | lost | missed deadlines | cores in use | most memory after the start | at the end |\n\
         | --: | --: | --: | --: | --: | --: | --: | --: | --: |\n\
         | {} | {minutes} | {processors} | {} | {} | {missed:.2} % | {cores:.2} | {:.0} MB | {:.0} MB |",
        machines.len(),
        sum(|m| m.sent),
        sum(|m| m.lost),
        most(0),
        most(1),
    )
}
