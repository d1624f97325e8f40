//! Measures the diagnosis of vibration on recordings with known faults:
//! `cargo bench -q -p ballrace-benches --bench vibration -- FOLDER`.
//!
//! FOLDER has recordings and `labels.csv` (see `labels`). Each recording is replayed by the release binary with a
//! scene that an owner writes: four numbers of the bearing, speed of the name plate, rate, columns. Options:
//!
//! - `--methods` adds the three methods of Smith and Randall to the table (see `methods`),
//! - `--kernel` adds the detector of the kernel to the table and lists where its verdict is another (see `kernel`),
//! - `--decoys` replays the damaged recordings with geometry that moves the order of the damage by 4 % up and down,
//! - `--speed SHARE` changes the speed of the scene, such as 0.05 or -0.05,
//! - `--baseline` learns the healthy recording of the same machine and speed first,
//! - `--only TEXT` takes the recordings whose name of data set has TEXT, `--program FILE` measures another binary than
//!   the release binary,
//! - `--halves` scores the rigs in two halves, for each division: the constants of the program are the same for all, so that the
//!   table shows how much they depend on the rig and is no test on rigs unknown to them,
//! - `--list` prints every recording with what is named.

mod kernel;
mod labels;
mod methods;
mod program;
mod score;

use ballrace::twin::{DamageHypothesis, DamageVerdict};
use labels::Recording;
use methods::METHODS;
use program::{Outcome, Program};
use score::{ROWS, Score, is_accused};
use std::error::Error;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{env, thread};

const USAGE: &str = "usage: cargo bench -q -p ballrace-benches --bench vibration -- FOLDER [--methods] [--kernel] [--decoys] [--speed SHARE] \
                     [--baseline] [--halves] [--only TEXT] [--list] [--program FILE]";
/// Replays at a time.
const PROCESSES: usize = 2;
/// Displacement of the orders of a decoy.
const DECOYS: [f64; 2] = [0.04, -0.04];

#[derive(Default)]
struct Arguments {
    folder: PathBuf,
    methods: bool,
    kernel: bool,
    decoys: bool,
    baseline: bool,
    halves: bool,
    list: bool,
    speed: f64,
    only: Option<String>,
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
                "--methods" => arguments.methods = true,
                "--kernel" => arguments.kernel = true,
                "--decoys" => arguments.decoys = true,
                "--baseline" => arguments.baseline = true,
                "--halves" => arguments.halves = true,
                "--list" => arguments.list = true,
                "--speed" => arguments.speed = value()?.parse()?,
                "--only" => arguments.only = Some(value()?),
                "--program" => arguments.program = Some(value()?.into()),
                option if option.starts_with("--") => return Err(format!("unknown option {option}\n{USAGE}").into()),
                _ => folders.push(PathBuf::from(argument)),
            }
        }
        let [folder] = folders.try_into().map_err(|_| USAGE)?;
        Ok(Self { folder: std::path::absolute(folder)?, ..arguments })
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    // `cargo test --all-targets` runs every benchmark without this argument.
    if !env::args().any(|argument| argument == "--bench") {
        return Ok(());
    }
    let arguments = Arguments::parse(env::args().skip(1))?;
    let scratch = tempfile::tempdir()?;
    let program = Program::find(arguments.program.clone(), scratch.path())?;
    let mut recordings = labels::read(&arguments.folder)?;
    if let Some(text) = &arguments.only {
        recordings.retain(|recording| recording.dataset.contains(text.as_str()));
    }
    if arguments.decoys {
        return decoys(&arguments, &program, &recordings);
    }
    for recording in &mut recordings {
        recording.rpm *= 1.0 + arguments.speed;
    }
    let mut references: Vec<Option<usize>> = vec![None; recordings.len()];
    if arguments.baseline {
        let healthy = |one: &Recording| recordings.iter().position(|r| r.is_healthy() && r.is_beside(one));
        references = recordings.iter().map(healthy).collect();
        let learned: Vec<usize> = (0..recordings.len()).filter(|&i| references[i] == Some(i)).collect();
        in_parallel(learned.len(), |k| {
            let file = scratch.path().join(format!("{}.json", learned[k]));
            program.replay(&arguments.folder, &recordings[learned[k]], &format!("learn-{k}"), Some((true, &file)))
        })?;
    }
    // A reference is not judged against itself, and a recording without one not at all.
    let judged: Vec<usize> = (0..recordings.len())
        .filter(|&i| !arguments.baseline || references[i].is_some_and(|reference| reference != i))
        .collect();
    let outcomes = in_parallel(judged.len(), |k| {
        let i = judged[k];
        let file = references[i].map(|reference| scratch.path().join(format!("{reference}.json")));
        let baseline = file.as_deref().map(|file| (false, file));
        program.replay(&arguments.folder, &recordings[i], &format!("replay-{i}"), baseline)
    })?;
    let recordings: Vec<Recording> = judged.iter().map(|&i| recordings[i].clone()).collect();
    let answers: Vec<Vec<String>> = outcomes.iter().map(kinds).collect();
    if arguments.list {
        list(&recordings, &outcomes);
    }
    let mut columns = vec![("ballrace".to_owned(), scored(&recordings, &answers))];
    if arguments.methods {
        let levels = in_parallel(recordings.len(), |i| methods::levels(&arguments.folder, &recordings[i]))?;
        for (method, name) in METHODS.iter().enumerate() {
            let (threshold, answers) = methods::answers(&recordings, &levels, method);
            columns.push((format!("{name} ({threshold:.1} dB)"), scored(&recordings, &answers)));
        }
    }
    if arguments.kernel {
        let verdicts = in_parallel(recordings.len(), |i| kernel::verdict(&arguments.folder, &recordings[i]))?;
        let kinds =
            |verdict: &DamageVerdict<f32>| verdict.named.map(|c| kernel::kind(c).to_owned()).into_iter().collect();
        let found: Vec<Vec<String>> = verdicts.iter().map(kinds).collect();
        compare(&recordings, &answers, &verdicts, arguments.list);
        columns.push(("kernel".to_owned(), scored(&recordings, &found)));
    }
    let mut datasets: Vec<&str> = recordings.iter().map(|r| r.dataset.as_str()).collect();
    datasets.dedup();
    let of_rigs = |rigs: &[&str]| {
        let own = recordings.iter().zip(&answers).filter(|(recording, _)| rigs.contains(&recording.dataset.as_str()));
        let (recordings, answers): (Vec<Recording>, Vec<Vec<String>>) =
            own.map(|(recording, answer)| (recording.clone(), answer.clone())).unzip();
        (rigs.join(", "), scored(&recordings, &answers))
    };
    if arguments.halves {
        columns.extend(halves(&datasets).iter().flatten().map(|rigs| of_rigs(rigs)));
    } else if columns.len() == 1 && datasets.len() > 1 {
        columns.extend(datasets.iter().map(|rig| of_rigs(&[rig])));
    }
    print(&columns);
    let seconds: Vec<f64> = outcomes.iter().map(|outcome| outcome.seconds).collect();
    let longest = seconds.iter().copied().fold(0.0, f64::max);
    println!(
        "\n{:.1} s a replay, the longest {longest:.1} s.",
        seconds.iter().sum::<f64>() / seconds.len().max(1) as f64
    );
    Ok(())
}

/// Returns the divisions of rigs into two halves; the first rig is in the first half.
fn halves<'a>(rigs: &[&'a str]) -> Vec<[Vec<&'a str>; 2]> {
    let is_half = |chosen: &usize| chosen & 1 == 1 && chosen.count_ones() as usize == rigs.len().div_ceil(2);
    let divided = |chosen: usize| {
        let is_first = |i: usize| chosen >> i & 1 == 1;
        [true, false].map(|first| (0..rigs.len()).filter(|i| is_first(*i) == first).map(|i| rigs[i]).collect())
    };
    (0..1_usize << rigs.len().min(16)).filter(is_half).map(divided).collect()
}

/// Replays the damaged recordings with wrong geometry.
fn decoys(arguments: &Arguments, program: &Program, recordings: &[Recording]) -> Result<(), Box<dyn Error>> {
    let damaged = recordings.iter().filter(|recording| recording.damage().is_some());
    let all: Vec<Recording> = damaged.flat_map(|recording| DECOYS.map(|share| recording.decoy(share))).collect();
    let outcomes = in_parallel(all.len(), |i| program.replay(&arguments.folder, &all[i], &format!("decoy-{i}"), None))?;
    if arguments.list {
        list(&all, &outcomes);
    }
    let named = outcomes.iter().filter(|outcome| is_accused(&kinds(outcome))).count();
    println!("| decoys named, orders moved by 4 % | {named} of {} |", all.len());
    Ok(())
}

fn kinds(outcome: &Outcome) -> Vec<String> {
    outcome.findings.iter().map(|finding| finding.kind.clone()).collect()
}

fn list(recordings: &[Recording], outcomes: &[Outcome]) {
    for (recording, outcome) in recordings.iter().zip(outcomes) {
        let found: Vec<String> = outcome
            .findings
            .iter()
            .map(|f| format!("{} {:.3} ({:.0} %)", f.kind, f.order, 100.0 * f.confidence))
            .collect();
        let mark = if Score::is_right(recording, &kinds(outcome)) { ' ' } else { '!' };
        let verdict = if found.is_empty() { &outcome.verdict } else { "" };
        println!("{mark} {} {}: {} {verdict}", recording.file, recording.fault, found.join(", "));
    }
}

/// Prints where the kernel names another component than the program, or every recording.
fn compare(recordings: &[Recording], answers: &[Vec<String>], verdicts: &[DamageVerdict<f32>], all: bool) {
    let mut same = 0;
    for ((recording, answer), verdict) in recordings.iter().zip(answers).zip(verdicts) {
        let kind = verdict.named.map(kernel::kind);
        let is_same = answer.iter().map(String::as_str).eq(kind);
        same += usize::from(is_same);
        if !is_same || all {
            let of = |h: &DamageHypothesis<f32>| format!("{:.1} at {:.3}, {:.2}", h.evidence, h.order, h.modulation);
            let hypotheses: Vec<String> = verdict.hypotheses.iter().map(of).collect();
            println!(
                "{} {} {}: program {}, kernel {} ({:.0} %) after {} blocks; {}",
                if is_same { '=' } else { '!' },
                recording.file,
                recording.fault,
                answer.first().map_or("none", String::as_str),
                kind.unwrap_or("none"),
                100.0 * verdict.confidence,
                verdict.blocks,
                hypotheses.join("; ")
            );
        }
    }
    println!("Kernel: the verdict of the program on {same} of {}.", recordings.len());
}

fn scored(recordings: &[Recording], answers: &[Vec<String>]) -> Score {
    let mut score = Score::default();
    recordings.iter().zip(answers).for_each(|(recording, kinds)| score.add(recording, kinds));
    score
}

fn print(columns: &[(String, Score)]) {
    let names: Vec<&str> = columns.iter().map(|column| column.0.as_str()).collect();
    println!("| | {} |\n| --- |{}", names.join(" | "), " --- |".repeat(columns.len()));
    for (name, share) in ROWS {
        let cells: Vec<String> = columns.iter().map(|column| share(&column.1).to_string()).collect();
        println!("| {name} | {} |", cells.join(" | "));
    }
}

/// Computes `count` results by `PROCESSES` threads, in their order.
fn in_parallel<T: Send>(
    count: usize,
    of: impl Fn(usize) -> Result<T, Box<dyn Error>> + Sync,
) -> Result<Vec<T>, Box<dyn Error>> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, Result<T, String>)>> = Mutex::new(vec![]);
    thread::scope(|scope| {
        for _ in 0..PROCESSES {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    if i >= count {
                        break;
                    }
                    let result = of(i).map_err(|error| error.to_string());
                    if let Ok(mut done) = done.lock() {
                        done.push((i, result));
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().map_err(|error| error.to_string())?;
    done.sort_by_key(|(i, _)| *i);
    done.into_iter().map(|(_, result)| result.map_err(Into::into)).collect()
}
