//! The built program, a folder with scene and recording to run it in, and its output.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde::de::DeserializeOwned;
use serde_json::Value;
use tempfile::TempDir;

/// The scene of the built-in demonstration.
pub const DEMO_SCENE: &str = include_str!("../../runner/demo/healthy.toml");
/// A recording of its machine in good order without any error of the readings: 12800 samples at 12.8 kHz, 50 turns of 256 samples.
pub const HEALTHY_RECORDING: &str = include_str!("../recordings/healthy.csv");
/// Samples of one turn there.
pub const TURN: usize = 256;
/// Samples of the recording on a [`Sandbox::rig`]: eight turns.
pub const SHORT: usize = 8 * TURN;

/// The release binary, which the README's first command builds; `tests/run` names the one that it has built.
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        if let Some(built) = std::env::var_os("BALLRACE_PROGRAM") {
            return built.into();
        }
        let build = escargot::CargoBuild::new()
            .manifest_path(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml"))
            .package("ballrace-runner")
            .bin("ballrace")
            // And the library that `fmu` puts into units.
            .args(["--package", "ballrace-fmu", "--lib"])
            .release();
        let build = match own_target_folder() {
            Some(folder) => build.target_dir(folder),
            None => build,
        };
        build.run().unwrap().path().to_owned()
    })
}

/// Cargo's folder that this test itself was built in, however it was chosen: what is built already is used again.
fn own_target_folder() -> Option<PathBuf> {
    let test = std::env::current_exe().ok()?;
    let mut folders = test.ancestors().skip(1);
    folders.find(|folder| folder.join(".rustc_info.json").is_file()).map(Path::to_owned)
}

/// A file of `tests/recordings`.
pub fn recorded(name: &str) -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/recordings/").to_owned() + name
}

/// A file of the demonstration: readings with all the errors of a site.
pub fn demonstrated(name: &str) -> String {
    concat!(env!("CARGO_MANIFEST_DIR"), "/../runner/demo/").to_owned() + name
}

/// `text` with the first `from`, which has to be there, replaced.
pub fn swap(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from:?} is not in the text");
    text.replacen(from, to, 1)
}

/// The demonstration's scene with pieces of its text replaced.
pub fn scene(swaps: &[(&str, &str)]) -> String {
    swaps.iter().fold(DEMO_SCENE.to_owned(), |text, (from, to)| swap(&text, from, to))
}

/// The header and the first `samples` rows of the demonstration's recording.
pub fn short_recording(samples: usize) -> String {
    head(HEALTHY_RECORDING, samples)
}

/// The header and the first `samples` rows of a recording.
pub fn head(recording: &str, samples: usize) -> String {
    recording.split_inclusive('\n').take(1 + samples).collect()
}

/// Samples of the demonstration that are enough for a diagnosis.
pub const DIAGNOSED: usize = 17 * TURN;

/// The demonstration's first turns with each cell of a row changed.
pub fn changed(samples: usize, change: impl Fn(usize, usize, f64) -> f64) -> String {
    let text = short_recording(samples);
    let (header, rows) = numbers(&text);
    let line = |(i, row): (usize, &Vec<f64>)| {
        let cells: Vec<String> = row.iter().enumerate().map(|(k, x)| change(i, k, *x).to_string()).collect();
        cells.join(",") + "\n"
    };
    header.join(",") + "\n" + &rows.iter().enumerate().map(line).collect::<String>()
}

/// The recording on a [`Sandbox::rig`] with its lines (the header is line 1) edited.
pub fn edited_recording(mut edit: impl FnMut(usize, &str) -> Vec<String>) -> String {
    let text = short_recording(SHORT);
    let lines = text.lines().enumerate().flat_map(|(i, line)| edit(i + 1, line));
    lines.map(|line| line + "\n").collect()
}

/// A row with one of its cells replaced.
pub fn with_cell(row: &str, column: usize, cell: &str) -> String {
    let mut cells: Vec<&str> = row.split(',').collect();
    cells[column] = cell;
    cells.join(",")
}

/// The outcome of [`HEALTHY_RECORDING`] on the scene of the demonstration, and that of the demonstration. All tests share them.
pub fn sound() -> &'static Value {
    static OUTCOME: OnceLock<Value> = OnceLock::new();
    OUTCOME.get_or_init(|| Sandbox::with(DEMO_SCENE, HEALTHY_RECORDING).replay("scene.toml", &[]))
}

pub fn spalled() -> &'static Value {
    static OUTCOME: OnceLock<Value> = OnceLock::new();
    OUTCOME.get_or_init(|| Sandbox::empty().replay("", &[]))
}

/// Writes the recordings of the demonstration without added masses, with a trial mass, and with a correction mass: `before.csv`, `trial.csv`,
/// `trim.csv`.
pub fn put_trial(sandbox: &Sandbox) {
    for (masses, recording) in
        [("", "before.csv"), ("60 g mm at 90 deg", "trial.csv"), ("120 g mm at 197 deg", "trim.csv")]
    {
        let added = masses.split_once(" at ").map_or_else(String::new, |(moment, angle)| {
            format!("{{ moment = \"{moment}\", angle = \"{angle}\", station = \"20 mm\" }}, ")
        });
        sandbox.put("run.toml", scene(&[("unbalance = [", &format!("unbalance = [{added}"))]));
        sandbox.done(&["simulate", "run.toml", "--duration", "0.3 s", "--as-recording", "-o", recording]);
    }
}

/// A folder to work in, removed at the end.
pub struct Sandbox {
    folder: TempDir,
}

/// A number of `/proc/PID/status`, MiB.
#[cfg(target_os = "linux")]
pub fn memory(pid: u32, name: &str) -> Option<f64> {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let line = status.lines().find(|line| line.starts_with(name))?;
    Some(line.split_whitespace().nth(1)?.parse::<f64>().ok()? / 1024.0)
}

/// Returns true where standard error has nothing but progress and the state of a monitor.
pub fn is_progress(err: &str) -> bool {
    let words = ["Fitting ", "Learning from ", "Diagnosing ", "Replaying ", "Simulated ", "State at "];
    err.lines().all(|line| words.iter().any(|word| line.starts_with(word)))
}

impl Sandbox {
    /// Output of the program `source`, which uses the kernel, compiled and run. All such programs share the compiled kernel.
    pub fn compiled(&self, source: &str) -> String {
        let kernel = concat!(env!("CARGO_MANIFEST_DIR"), "/../kernel");
        // A name of its own, since the programs of several tests stand in one folder.
        let folder_name = self.folder.path().file_name().unwrap().to_string_lossy().into_owned();
        let name: String = "baked".chars().chain(folder_name.chars().filter(char::is_ascii_alphanumeric)).collect();
        let target = own_target_folder().map_or_else(|| self.path("target"), |folder| folder.join("baked"));
        fs::create_dir(self.path("src")).unwrap();
        self.put(
            "Cargo.toml",
            format!(
                "[package]\nname = \"{name}\"\nversion = \"0.0.0\"\nedition = \"2024\"\n[dependencies]\nballrace = {{ path = {kernel:?} }}\n[workspace]\n"
            ),
        );
        self.put("src/main.rs", source);
        let cargo = Command::new(env!("CARGO"))
            .args(["run", "-q", "--offline"])
            .env("CARGO_TARGET_DIR", &target)
            .env("CARGO_INCREMENTAL", "0")
            .current_dir(self.path(""))
            .output()
            .unwrap();
        for folder in ["debug", "debug/deps"].map(|folder| target.join(folder)) {
            let own = fs::read_dir(folder).into_iter().flatten().flatten();
            own.filter(|file| file.file_name().to_string_lossy().starts_with(&name)).for_each(|file| {
                let _ = fs::remove_file(file.path());
            });
        }
        assert!(cargo.status.success(), "{}", String::from_utf8_lossy(&cargo.stderr));
        String::from_utf8(cargo.stdout).unwrap()
    }

    /// With nothing on it.
    pub fn empty() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    /// With the demonstration's scene and the first turns of its recording.
    pub fn rig() -> Self {
        Self::with(DEMO_SCENE, &short_recording(SHORT))
    }

    /// With `scene.toml` and its recording `healthy.csv`.
    pub fn with(scene: &str, recording: &str) -> Self {
        let sandbox = Self::empty();
        sandbox.put("scene.toml", scene);
        sandbox.put("healthy.csv", recording);
        sandbox
    }

    pub fn put(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path(name), contents).unwrap();
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A report without its script.
    pub fn page(&self, name: &str) -> String {
        let page = self.read(name);
        assert!(page.contains("</html>"));
        page.split("<script").next().unwrap().to_owned()
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Names of all that lies on it.
    pub fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The program at this sandbox, its output to be read.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(program());
        command.args(args).current_dir(self.folder.path());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub fn run(&self, args: &[&str]) -> Answer {
        let output = self.command(args).output().unwrap();
        Answer {
            command: args.join(" "),
            code: output.status.code(),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs the program and kills it once `limit` has passed: the answer then has no exit code.
    pub fn run_within(&self, limit: Duration, args: &[&str]) -> Answer {
        bounded(self.command(args), limit, args)
    }

    /// The same with a limit of the address space, KiB.
    #[cfg(unix)]
    pub fn run_in_memory(&self, kibibytes: u32, limit: Duration, args: &[&str]) -> Answer {
        let mut command = Command::new("sh");
        command.arg("-c").arg(format!("ulimit -v {kibibytes}; exec \"$@\"")).arg("sh").arg(program()).args(args);
        command.current_dir(self.folder.path());
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        bounded(command, limit, args)
    }

    /// Runs what has to go well, without a word on standard error but for progress and the state of a monitor.
    pub fn done(&self, args: &[&str]) -> Answer {
        let answer = self.run(args);
        assert_eq!(answer.code, Some(0), "{answer:?}");
        assert!(is_progress(&answer.err), "{answer:?}");
        answer
    }

    /// Runs what has to be refused: with this exit code and one line that has all `parts`, leaving nothing behind.
    pub fn refused(&self, args: &[&str], code: i32, parts: &[&str]) {
        let before = self.files();
        let answer = self.run(args);
        assert_eq!(answer.code, Some(code), "{answer:?}");
        assert!(answer.err.starts_with("ballrace: ") && answer.err.ends_with('\n'), "{answer:?}");
        assert_eq!(answer.err.lines().count(), 1, "{answer:?}");
        for part in parts {
            assert!(answer.err.contains(part), "{part:?} is missing: {answer:?}");
        }
        assert!(!answer.err.contains("panicked"), "{answer:?}");
        assert_eq!(answer.out, "", "{answer:?}");
        assert_eq!(self.files(), before, "files left behind: {answer:?}");
    }

    /// Replays the scene on the sandbox (or the demonstration where `scene` is empty) and gives the outcome.
    pub fn replay(&self, scene: &str, more: &[&str]) -> Value {
        let scene = [scene];
        let scene = if scene == [""] { &[][..] } else { &scene[..] };
        self.done(&[&["replay"], scene, more, &["--format", "json"]].concat()).json()
    }
}

/// Runs `command` to its end, or kills it once `limit` has passed.
fn bounded(mut command: Command, limit: Duration, args: &[&str]) -> Answer {
    let mut child = command.spawn().unwrap();
    let mut pipes = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
    let read = |pipe: &mut dyn Read| {
        let mut text = String::new();
        pipe.read_to_string(&mut text).unwrap();
        text
    };
    std::thread::scope(|scope| {
        let (out, err) = (scope.spawn(|| read(&mut pipes.0)), scope.spawn(|| read(&mut pipes.1)));
        let deadline = Instant::now() + limit;
        let code = loop {
            if let Some(status) = child.try_wait().unwrap() {
                break status.code();
            }
            if Instant::now() > deadline {
                child.kill().unwrap();
                child.wait().unwrap();
                break None;
            }
            std::thread::sleep(Duration::from_millis(5));
        };
        Answer { command: args.join(" "), code, out: out.join().unwrap(), err: err.join().unwrap() }
    })
}

/// Output and exit code of the program.
#[derive(Debug)]
pub struct Answer {
    #[expect(dead_code, reason = "shown where a test fails")]
    command: String,
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Answer {
    pub fn json<T: DeserializeOwned>(&self) -> T {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {self:?}"))
    }
}

/// The header and the numbers of a CSV file.
pub fn numbers(text: &str) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut lines = text.lines();
    let header = lines.next().unwrap().split(',').map(str::to_owned).collect();
    let rows = lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    (header, rows)
}

/// A number of an outcome, such as `number(&outcome, "/timing/samples")`.
pub fn number(outcome: &Value, pointer: &str) -> f64 {
    let value = outcome.pointer(pointer).and_then(Value::as_f64);
    value.unwrap_or_else(|| panic!("no number at {pointer} of {outcome:#}"))
}

/// The entries of a list of an outcome.
pub fn list<'a>(outcome: &'a Value, key: &str) -> &'a [Value] {
    outcome[key].as_array().unwrap_or_else(|| panic!("no list {key} in {outcome:#}"))
}
