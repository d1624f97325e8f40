//! Measures the diagnosis on recordings with known faults:
//! `cargo bench -q -p ballrace-benches --bench diagnosis -- FOLDER`.
//!
//! FOLDER has `truth.json` and one folder a rotor with `scene.toml`, `scene-rough.toml` and the recordings (see `fleet`).
//! `--rough` diagnoses with the rough scene, calibrated with the recording `healthy`; `--no-slow-roll` leaves the recording at slow
//! roll out that a scene of a site names. `--recordings N` takes the first N.
//! `--generate N --seed S` first simulates N random rotors into FOLDER; with `--site` as a site measures them. `--program FILE` measures another binary than the
//! release binary. With `BALLRACE_WRITE=1` the tables are written to `benches/README.md`.

mod envelope;
mod fleet;
mod generate;
#[path = "../marks.rs"]
mod marks;
mod program;
mod random;
mod score;
mod site;
mod tables;

use envelope::Signature;
use fleet::{Fleet, HEALTHY, Recording};
use marks::Marks;
use program::{Baseline, Program, Replay};
use score::Score;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, fs, thread};
use tables::Judged;

const USAGE: &str = "usage: cargo bench -q -p ballrace-benches --bench diagnosis -- FOLDER [--rough] [--no-slow-roll] \
                     [--recordings N] [--generate N [--site]] [--seed S] [--program FILE]";
/// Replays at a time.
const PROCESSES: usize = 2;

#[derive(Default)]
struct Arguments {
    folder: PathBuf,
    rough: bool,
    no_slow_roll: bool,
    recordings: Option<usize>,
    generate: Option<usize>,
    site: bool,
    seed: u64,
    program: Option<PathBuf>,
}

impl Arguments {
    fn parse(mut given: impl Iterator<Item = String>) -> Result<Self, Box<dyn Error>> {
        let mut arguments = Self::default();
        let mut folders = vec![];
        while let Some(argument) = given.next() {
            let mut value = || given.next().ok_or_else(|| format!("missing value of {argument}\n{USAGE}"));
            match argument.as_str() {
                "--bench" => {}
                "--rough" => arguments.rough = true,
                "--no-slow-roll" => arguments.no_slow_roll = true,
                "--recordings" => arguments.recordings = Some(value()?.parse()?),
                "--generate" => arguments.generate = Some(value()?.parse()?),
                "--site" => arguments.site = true,
                "--seed" => arguments.seed = value()?.parse()?,
                "--program" => arguments.program = Some(value()?.into()),
                option if option.starts_with('-') => return Err(format!("unknown option {option}\n{USAGE}").into()),
                _ => folders.push(PathBuf::from(argument)),
            }
        }
        let [folder] = folders.try_into().map_err(|_| USAGE)?;
        Ok(Self { folder, ..arguments })
    }

    /// The section of `benches/README.md`.
    fn section(&self) -> String {
        let generated = if self.generate.is_some() { "-generated" } else { "" };
        let site = if self.site { "-site" } else { "" };
        let rough = if self.rough { "-rough" } else { "" };
        format!("diagnosis{generated}{site}{rough}")
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo test --all-targets` runs every benchmark without this argument.
    if !env::args().any(|argument| argument == "--bench") {
        return Ok(());
    }
    let arguments = Arguments::parse(env::args().skip(1))?;
    let program = Program::find(arguments.program.clone())?;
    let mut fleet = match arguments.generate {
        Some(rotors) => {
            let generate = if arguments.site { generate::generate_site } else { generate::generate };
            generate(&program, &arguments.folder, rotors, arguments.seed)?
        }
        None => Fleet::read(&arguments.folder)?,
    };
    fleet.recordings.truncate(arguments.recordings.unwrap_or(usize::MAX));
    fleet.no_slow_roll = arguments.no_slow_roll;
    let text = measure(&program, &fleet, arguments.rough)?;
    println!("{text}");
    if env::var_os("BALLRACE_WRITE").is_some() {
        let readme: PathBuf = [env!("CARGO_MANIFEST_DIR"), "README.md"].iter().collect();
        let old = fs::read_to_string(&readme)?;
        let section = arguments.section();
        let new = Marks(&section).replaced(&old, &text).ok_or(format!("benches/README.md has no marks {section}"))?;
        fs::write(readme, new)?;
    }
    Ok(())
}

/// Replays and scores every recording; returns the tables.
fn measure(program: &Program, fleet: &Fleet, rough: bool) -> Result<String, Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let baseline = |rig: &str| folder.path().join(format!("{rig}.json"));
    let mut learning = vec![];
    if rough {
        let rigs = fleet.rigs();
        learning = two_at_a_time(&rigs, |rig| {
            let path = baseline(rig);
            let replay = replay(program, fleet, rig, HEALTHY, folder.path(), rough, &Baseline::Learn(&path));
            eprintln!("{rig}: {}", if path.is_file() { "baseline learned" } else { "no baseline was written" });
            replay.filter(|_| path.is_file()).map(|replay| replay.seconds)
        })
        .into_iter()
        .flatten()
        .collect();
    }
    // The recording that calibrates the rough scene is not judged.
    let judged = |recording: &Recording| !(rough && recording.recording == HEALTHY);
    let recordings: Vec<&Recording> = fleet.recordings.iter().filter(|recording| judged(recording)).collect();
    let done = AtomicUsize::new(0);
    let replays = two_at_a_time(&recordings, |recording| {
        let path = baseline(&recording.rig);
        let baseline = if rough { Baseline::Use(&path) } else { Baseline::None };
        let replay = replay(program, fleet, &recording.rig, &recording.recording, folder.path(), rough, &baseline);
        let (words, seconds) =
            replay.as_ref().map_or(("no result".to_owned(), 0.0), |r| (tables::named(&r.diagnoses), r.seconds));
        let Score { verdict, .. } = judge(recording, replay.as_ref()).score;
        let number = done.fetch_add(1, Ordering::Relaxed) + 1;
        let (all, Recording { rig, .. }) = (recordings.len(), recording);
        eprintln!("[{number}/{all}] {rig} {}: {verdict:?}: {words} ({seconds:.1} s)", recording.title());
        replay
    });
    let failed = replays.iter().filter(|replay| replay.is_none()).count();
    let seconds = replays.iter().flatten().map(|replay| replay.seconds).collect();
    let signatures = two_at_a_time(&fleet.recordings, |recording| {
        Signature::new(fleet, recording)
            .inspect_err(|error| eprintln!("{} {}: {error}", recording.rig, recording.recording))
            .ok()
    });
    let of_envelope = envelope::diagnoses(&fleet.recordings, &signatures);
    let twin: Vec<Judged> =
        recordings.iter().zip(&replays).map(|(recording, replay)| judge(recording, replay.as_ref())).collect();
    let pairs = fleet.recordings.iter().zip(&of_envelope).filter(|(recording, _)| judged(recording));
    let envelope: Vec<Judged> = pairs.map(|(recording, found)| Judged::new(recording, found)).collect();

    let scenes =
        if rough { "Rough scenes, calibrated with one recording of the machine in good order" } else { "Exact scenes" };
    let exceptions = tables::exceptions(&twin);
    let exceptions = if exceptions.is_empty() { String::new() } else { format!("Not right:\n\n{exceptions}\n") };
    let failures = if failed == 0 { String::new() } else { format!("Replays without a result: {failed}.\n\n") };
    let of_learning = tables::durations("Duration of a replay that learns", learning);
    Ok(format!(
        "{scenes}: {} recordings of {} rotors.\n\n{}\n{failures}{exceptions}{}{}{of_learning}\n{}",
        recordings.len(),
        fleet.rigs().len(),
        tables::verdicts(&twin),
        tables::errors(&twin),
        tables::durations("Duration of a replay, two at a time", seconds),
        tables::comparison(&twin, &envelope).trim_end()
    ))
}

/// Scores a replay, which may have failed.
fn judge<'a>(recording: &'a Recording, replay: Option<&'a Replay>) -> Judged<'a> {
    replay.map_or_else(|| Judged::failed(recording), |replay| Judged::new(recording, &replay.diagnoses))
}

/// Replays one recording; reports a failure on standard error.
fn replay(
    program: &Program,
    fleet: &Fleet,
    rig: &str,
    recording: &str,
    folder: &Path,
    rough: bool,
    baseline: &Baseline,
) -> Option<Replay> {
    let replay = fleet
        .scene_without_slow_roll(rig, rough, folder)
        .and_then(|scene| program.replay(&scene, &fleet.file(rig, recording), folder, baseline));
    replay.inspect_err(|error| eprintln!("{error}")).ok()
}

/// Computes a result for each item, two at a time.
fn two_at_a_time<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let (next, results) = (AtomicUsize::new(0), Mutex::new(vec![]));
    thread::scope(|scope| {
        for _ in 0..PROCESSES {
            scope.spawn(|| {
                while let Some((i, item)) = {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    items.get(i).map(|item| (i, item))
                } {
                    let result = work(item);
                    if let Ok(mut results) = results.lock() {
                        results.push((i, result));
                    }
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_default();
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}
