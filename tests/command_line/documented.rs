//! Every command line that stands in a README or in `docs`, run as it stands.

use crate::support::{DEMO_SCENE, HEALTHY_RECORDING, SHORT, Sandbox, program, put_trial, short_recording};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// Command lines that are not run here, by their beginning, and why.
const EXCEPTIONS: [(&str, &str); 18] = [
    ("ballrace new --bearing", "a transcript that new_scene.rs runs in its order"),
    ("ballrace replay pump.toml", "as above"),
    ("cargo rustc -p ballrace-c", "needs a Rust target; the tests of the target build the library"),
    ("cargo deny", "needs a program and a database of others"),
    ("cargo doc", "a part of tests/run"),
    ("cargo install", "installs a program"),
    ("cargo fmt", "formats the source; tests/run checks the format"),
    ("cargo clippy", "a part of tests/run"),
    ("cargo publish", "uploads packages; a test packs them"),
    ("tests/run", "runs this test"),
    ("tests/fuzz/run", "needs a C++ compiler and runs for the minutes that it is given"),
    ("cargo build --release", "builds the program, or the image of a board, which tests/run does too"),
    ("cargo run -r", "needs a board and a debug probe; tests/run builds the image"),
    ("cargo test", "a part of tests/run"),
    ("cargo bench", "measures for minutes; tests/run checks the instruction counts"),
    ("cargo build --release && cargo bench", "needs a folder of recordings and replays them for minutes"),
    ("BALLRACE_WRITE=1 cargo bench", "rewrites a file of the repository"),
    ("BALLRACE_WRITE=1 cargo test", "rewrites a file of the repository"),
];

/// Values for the words that stand for a value. `SCENE`, `NAME` and `F.csv` are names of files of the sandbox.
const VALUES: [(&str, &str); 6] = [
    ("completions SHELL", "completions bash"),
    // The demonstration has two.
    ("force SCENE", "force SCENE --bearing DE"),
    // All of one scene in the sandbox.
    ("bake scene.toml -o bearings.rs", "bake SCENE -o bearings.rs"),
    ("--duration D", "--duration '1 ms'"),
    ("--rate R", "--rate '1 kHz'"),
    ("KEY=FROM..TO:COUNT", "shaft.speed=2000rpm..3000rpm:2"),
];

/// The same with less work, for the runs that are not ignored.
const SMALLER: [(&str, &str); 4] = [
    ("500rpm..10000rpm:200", "500rpm..10000rpm:2"),
    ("2000rpm..3000rpm:2 ", "2000rpm..3000rpm:2 --periods 16 "),
    ("ballrace trade ", "ballrace trade --forces-only "),
    ("ballrace fit ", "ballrace fit --only unbalance --turns 4 "),
];

#[derive(Debug, PartialEq, Eq, Clone, Copy)]
enum Kind {
    /// Ends by itself.
    Plain,
    /// Needs a terminal.
    Terminal,
    /// Listens for samples until it is stopped.
    Monitor,
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The Markdown files for users and developers, without the gallery, whose commands `gallery.rs` runs in their order.
fn documents() -> Vec<PathBuf> {
    let mut all = vec![];
    let mut folders = vec![(repository(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if path.is_dir() && depth < 3 && name != "target" && !name.starts_with('.') {
                folders.push((path, depth + 1));
            } else if name.ends_with(".md") && !["CHANGELOG.md", "gallery.md"].contains(&name) {
                all.push(path);
            }
        }
    }
    for known in ["README.md", "docs/src/guide.md"] {
        assert!(all.iter().any(|path| path.ends_with(known)), "{known}");
    }
    all
}

/// True for text that a user would type at a prompt.
fn is_command(text: &str) -> bool {
    let is_script = text.starts_with("tests/") && text.split(' ').next().is_some_and(|word| word.ends_with("/run"));
    text.starts_with("ballrace ") || text.starts_with("cargo ") || text.contains(" cargo ") || is_script
}

/// The command lines of a document: lines of its fenced blocks for a shell, and its inline code.
fn commands_of(text: &str) -> Vec<String> {
    let mut commands = vec![];
    let mut fence: Option<&str> = None;
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            fence = if fence.is_none() { Some(language) } else { None };
        } else if let Some(language) = fence {
            let command = line.split(" #").next().unwrap().trim();
            let is_shell = matches!(language, "" | "sh");
            commands.extend((is_shell && is_command(command)).then(|| command.to_owned()));
        } else {
            let code = line.split('`').skip(1).step_by(2).map(|code| code.replace("\\|", "|"));
            commands.extend(code.filter(|code| is_command(code)));
        }
    }
    commands
}

/// Every documented command line that is no exception, each once, as a shell takes it.
fn documented(kind: Kind) -> BTreeSet<String> {
    let mut lines = BTreeSet::new();
    for document in documents() {
        for command in commands_of(&fs::read_to_string(&document).unwrap()) {
            if EXCEPTIONS.iter().any(|(start, _)| command.starts_with(start)) {
                continue;
            }
            let command = command.replace("cargo run --release -- ", "ballrace ");
            assert!(
                command.starts_with("ballrace "),
                "{}: {command}: no way to run it and not among the exceptions",
                document.display()
            );
            let command = VALUES.iter().fold(command, |line, (word, value)| line.replace(word, value));
            // A command by its name only, as text speaks of it.
            let is_name = command.split(' ').count() == 2;
            match command.split_once(" [") {
                Some((without, optional)) => {
                    let value = match optional {
                        "NAME]" => "tiwari-balanced",
                        "COMMAND]" => "replay",
                        _ => optional.trim_end_matches(']'),
                    };
                    lines.extend([without.to_owned(), format!("{without} {value}")]);
                }
                None if is_name && !["ballrace watch", "ballrace replay", "ballrace scenes"].contains(&&*command) => {
                    lines.insert(format!("{command} --help"));
                }
                None => {
                    lines.insert(command);
                }
            }
        }
    }
    lines.retain(|line| kind_of(line) == kind);
    assert!(!lines.is_empty(), "no documented command is {kind:?}");
    lines
}

fn kind_of(line: &str) -> Kind {
    match line {
        line if line.contains("--help") => Kind::Plain,
        line if line.starts_with("ballrace watch") => Kind::Terminal,
        line if line.contains("--source tcp:") => Kind::Monitor,
        _ => Kind::Plain,
    }
}

/// A folder with the files that the documented lines name.
fn sandbox(recording: &str) -> Sandbox {
    let sandbox = Sandbox::with(DEMO_SCENE, recording);
    for name in ["SCENE", "machine.toml", "my-machine.toml", "rig.toml", "pump.toml", "spalled.toml"] {
        sandbox.put(name, DEMO_SCENE);
    }
    sandbox.put("F.csv", "u,v,w,thu,thv\n1e-6,0,1e-6,0,0\n");
    sandbox.put(
        "log.csv",
        "u,v,w,thu,thv,cage_phase\n0x36a7c5ac,0x00000000,0x378637bd,0x00000000,0x00000000,0x1000000000000000\n",
    );
    sandbox.put("vectors.csv", include_str!("../../docs/src/vectors.csv"));
    sandbox.put("machines.csv", "machine,scene\nrig,machine.toml\n");
    put_trial(&sandbox);
    // The lines run in any order; this recording is the output of one of them.
    let spalled = ["simulate", "spalled.toml", "--duration", "0.1 s", "--as-recording", "-o", "spalled.parquet"];
    sandbox.done(&spalled);
    sandbox
}

/// The folders of commands, the program's own first.
fn path() -> std::ffi::OsString {
    let folders = std::env::var_os("PATH").unwrap();
    let folders = std::iter::once(program().parent().unwrap().to_owned()).chain(std::env::split_paths(&folders));
    std::env::join_paths(folders).unwrap()
}

/// `line` in a shell that finds the program as an installed one.
fn shell(sandbox: &Sandbox, line: &str) -> Command {
    let mut shell = Command::new("sh");
    shell.arg("-c").arg(line).current_dir(sandbox.path("")).env("PATH", path());
    shell.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    shell
}

fn assert_done(line: &str, output: &Output) {
    let err = String::from_utf8_lossy(&output.stderr);
    assert!(matches!(output.status.code(), Some(0 | 3)), "{line}: {:?}: {err}", output.status);
}

/// Runs all lines in one folder: what one writes another may read.
fn run_all(recording: &str, smaller: &[(&str, &str)]) {
    let sandbox = sandbox(recording);
    let lines = documented(Kind::Plain);
    // A line that writes a file for others comes first.
    let (first, then): (Vec<_>, Vec<_>) = lines.iter().partition(|line| line.contains(" > "));
    for line in first.into_iter().chain(then) {
        let line = smaller.iter().fold(line.clone(), |line, (from, to)| line.replace(from, to));
        let output = shell(&sandbox, &line).output().unwrap();
        assert_done(&line, &output);
        // `simulate` writes where `force` reads.
        sandbox.put("F.csv", "u,v,w,thu,thv\n1e-6,0,1e-6,0,0\n");
        let _ = fs::remove_file(sandbox.path("NAME.journal"));
    }
}

#[test]
fn documented_commands_end_well_with_less_work() {
    run_all(&short_recording(SHORT), &SMALLER);
}

#[test]
#[ignore = "slow: sweeps, fits and trades as documented; tests/run --all runs it"]
fn long_documented_commands_end_well_as_they_stand() {
    run_all(HEALTHY_RECORDING, &[]);
}

#[test]
fn unknown_commands_are_found_in_text_and_blocks() {
    let text = "See `ballrace a`, `ballrace-report.html` and `x \\| y`.\n```sh\nballrace b c   # why\ntests/run\n```\n```toml\nballrace = 1\n```\n`cargo d`\n";
    assert_eq!(commands_of(text), ["ballrace a", "ballrace b c", "tests/run", "cargo d"]);
}

/// The live view in a pseudo-terminal, from its start to the key that ends it, with main and other stacks of 1 MiB.
#[cfg(unix)]
#[test]
fn the_documented_live_view_runs_to_its_end_in_a_terminal() {
    let sandbox = sandbox(HEALTHY_RECORDING);
    for line in documented(Kind::Terminal) {
        let command = pty_process::blocking::Command::new("sh").args(["-c", &format!("ulimit -s 1024; exec {line}")]);
        let command = command.env("PATH", path()).env("RUST_MIN_STACK", "1048576").current_dir(sandbox.path(""));
        let (mut screen, mut child) = crate::terminal::Screen::start(120, 40, command);
        // The demonstration has no end.
        screen.wait_for(if line == "ballrace watch" { "ALARM" } else { "ENDED" });
        screen.press(b"q");
        let status = child.wait().unwrap();
        assert!(matches!(status.code(), Some(0 | 3)), "{line}: {status:?}");
    }
}

/// A monitor as documented, fed with frames, ended by a signal.
#[cfg(unix)]
#[test]
fn the_documented_monitor_follows_a_source_until_a_signal() {
    use std::io::{BufRead, BufReader, Write};
    let sandbox = sandbox(HEALTHY_RECORDING);
    for line in documented(Kind::Monitor) {
        let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let line = line.replace("tcp:9000", &format!("tcp:{port}"));
        let child = shell(&sandbox, &format!("exec {line}")).spawn().unwrap();
        let mut stream = crate::live::connected(port);
        let acknowledged = BufReader::new(stream.try_clone().unwrap());
        let rows = crate::live::rows(12_800);
        for (sequence, row) in (0..).zip(rows.iter().cycle().take(16_000)) {
            stream.write_all(&crate::live::frame(sequence, row)).unwrap();
        }
        let told = acknowledged.lines().next().unwrap().unwrap();
        assert!(told.starts_with("acknowledged "), "{told}");
        let killed = Command::new("kill").arg("-TERM").arg(child.id().to_string()).status().unwrap();
        assert!(killed.success());
        assert_done(&line, &child.wait_with_output().unwrap());
        assert!(sandbox.read("rig.jsonl").contains("source-connected"));
    }
}

/// Words with a hyphen in the sources of live operation that are no kind of an event.
const NO_EVENTS: [&str; 11] = [
    "http-also",
    "http-host",
    "http-origin",
    "http-token-file",
    "kebab-case",
    "mqtt-ca",
    "mqtt-password-file",
    "no-referrer",
    "no-store",
    "peak-to-peak",
    "secret-token",
];

/// Every kind of an event that the sources have stands in the table of the chapter.
#[test]
fn every_kind_of_event_is_documented() {
    let chapter = fs::read_to_string(repository().join("docs/src/live.md")).unwrap();
    let table: String = chapter.lines().filter(|line| line.starts_with("| `")).collect();
    let mut folders: Vec<PathBuf> = ["runner/src/live", "runner/replay/src"].map(|f| repository().join(f)).into();
    let mut kinds = BTreeSet::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.ends_with("fleet") || path.ends_with("check") {
                // Tables of these commands, no events.
            } else if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") && !path.ends_with("tests.rs") {
                let text = fs::read_to_string(path).unwrap();
                let text = text.split("mod tests").next().unwrap().to_owned();
                let is_kind = |word: &&str| word.contains('-') && word.split('-').all(is_word);
                kinds.extend(text.split('"').filter(is_kind).map(str::to_owned));
            }
        }
    }
    assert!(kinds.len() > 30, "{kinds:?}");
    let missing: Vec<&String> = kinds
        .iter()
        .filter(|kind| !NO_EVENTS.contains(&kind.as_str()) && !table.contains(&format!("`{kind}`")))
        .collect();
    assert!(missing.is_empty(), "not in the table of docs/src/live.md: {missing:?}");
}

fn is_word(word: &str) -> bool {
    !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_lowercase())
}
