//! Stack use: every command works with a main thread and other threads of 1 MiB, the size that Windows gives a main thread.

use crate::support::{DEMO_SCENE, DIAGNOSED, Sandbox, program, short_recording, swap};
use std::fmt::Write;
use std::process::{Command, Stdio};

/// Stack of the main thread and of every other thread, KiB.
const STACK: u32 = 1024;
/// Coordinates of the largest system.
const COORDINATES: usize = 128;

/// A chain of masses in Matrix Market files, each entry as `entry` gives it.
fn matrix(entry: impl Fn(usize, usize) -> f64) -> String {
    let mut entries = String::new();
    let mut count = 0;
    for i in 0..COORDINATES {
        for j in 0..=i {
            let x = entry(i, j);
            if x != 0.0 {
                count += 1;
                writeln!(entries, "{} {} {x:e}", i + 1, j + 1).unwrap();
            }
        }
    }
    format!("%%MatrixMarket matrix coordinate real symmetric\n{COORDINATES} {COORDINATES} {count}\n{entries}")
}

/// The demonstration with its bearings on the first coordinates of a chain of 128 masses.
fn largest_system(method: &str) -> String {
    let (head, rest) = DEMO_SCENE.split_once("[rotor]").unwrap();
    let (_, bearings) = rest.split_once("[[bearing]]").unwrap();
    let (bearings, _) = bearings.split_once("[recording]").unwrap();
    let bearings = swap(bearings, "station = \"-100 mm\"", "coordinates = [1, 2, 3, 0, 0]");
    let bearings = swap(&bearings, "station = \"100 mm\"", "coordinates = [4, 5, 6, 0, 0]");
    let system = "[system]\nmass = \"M.mtx\"\ndamping = \"B.mtx\"\nstiffness = \"K.mtx\"\n\
        unbalance = [{ moment = \"20 g mm\", angle = 0, x = 1, y = 2 }]\n\n";
    format!("{head}{system}[[bearing]]{bearings}\n[integration]\nmethod = \"{method}\"\nstep = \"10 us\"\n")
}

fn sandbox() -> Sandbox {
    let sandbox = Sandbox::with(DEMO_SCENE, &short_recording(DIAGNOSED));
    let chain = |own: f64, beside: f64| {
        matrix(move |i, j| {
            if i == j {
                own
            } else if i == j + 1 {
                beside
            } else {
                0.0
            }
        })
    };
    sandbox.put("M.mtx", chain(1.0, 0.0));
    sandbox.put("B.mtx", chain(200.0, 0.0));
    sandbox.put("K.mtx", chain(3e6, -1e6));
    for method in ["runge-kutta", "newmark", "verlet"] {
        sandbox.put(&format!("{method}.toml"), largest_system(method));
    }
    sandbox.put("machines.csv", "machine,scene\nrig,scene.toml\n");
    let (rigid, _) = DEMO_SCENE.split_once("[recording]").unwrap();
    let held = "[[bearing]]\nsupport = { mass = \"2 kg\", stiffness_x = 1e8, stiffness_y = 1e8, damping = 200 }\n";
    sandbox.put("supported.toml", rigid.replace("[[bearing]]\n", held));
    sandbox
}

/// Runs the program with stacks of `kib` KiB and drops its output.
fn ends_well(sandbox: &Sandbox, args: &[&str], main: u32, others: u32) -> bool {
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("ulimit -s {main} && exec \"$0\" \"$@\"")).arg(program()).args(args);
    command.env("RUST_MIN_STACK", (1024 * others).to_string()).current_dir(sandbox.path(""));
    let status = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status().unwrap();
    matches!(status.code(), Some(0 | 3))
}

/// Smallest stack in KiB with which `works`, to a tenth; it works with [`STACK`].
fn smallest(works: impl Fn(u32) -> bool) -> u32 {
    let (mut fails, mut works_with) = (16, STACK);
    while works_with > fails + fails / 10 {
        let middle = u32::midpoint(fails, works_with);
        if works(middle) { works_with = middle } else { fails = middle }
    }
    works_with
}

const MOTION: [&str; 6] = ["--duration", "1 ms", "--rate", "1 kHz", "-o", "motion.csv"];

/// Every command that is quick, on the smallest and on the largest scenes that it takes.
fn quick_commands() -> Vec<Vec<&'static str>> {
    let mut all = vec![
        vec!["replay", "scene.toml", "--report", "report.html"],
        vec!["equilibrium", "scene.toml"],
        vec!["campbell", "scene.toml", "--speeds", "3000rpm..6000rpm:2"],
        vec!["sweep", "scene.toml", "--over", "shaft.speed=2000rpm..3000rpm:2", "--periods", "16", "-o", "rigid"],
        vec!["bake", "scene.toml", "-o", "baked.rs"],
        vec!["scenes"],
        vec!["fleet", "machines.csv", "-o", "fleet"],
        vec!["equilibrium", "newmark.toml"],
        vec!["campbell", "newmark.toml", "--speeds", "3000rpm"],
        vec![
            "sweep",
            "verlet.toml",
            "--over",
            "shaft.speed=2000rpm..3000rpm:2",
            "--settle",
            "1 ms",
            "--periods",
            "16",
            "-o",
            "system",
        ],
    ];
    for scene in ["scene.toml", "supported.toml", "runge-kutta.toml", "newmark.toml", "verlet.toml"] {
        all.push([&["simulate", scene], &MOTION[..]].concat());
    }
    all
}

#[test]
fn quick_commands_work_with_stacks_of_one_mebibyte() {
    let sandbox = sandbox();
    for args in quick_commands() {
        assert!(ends_well(&sandbox, &args, STACK, STACK), "{args:?}");
    }
}

/// Prints what each command needs: `cargo test --release -p ballrace-tests --test command_line stack -- --ignored --nocapture`.
#[test]
#[ignore = "slow: runs each command a dozen times; tests/run --all runs it"]
fn long_stack_use_of_every_thread() {
    let sandbox = sandbox();
    let slow = [
        vec!["replay", "scene.toml", "--paced", "--state", "state", "--events", "e.jsonl", "--indicators", "i"],
        vec!["fit", "scene.toml", "--only", "unbalance", "--turns", "8"],
        vec!["trade", "scene.toml", "--forces-only"],
    ];
    println!("main thread KiB, largest of the other threads KiB, command");
    for args in quick_commands().into_iter().chain(slow) {
        let main = smallest(|main| ends_well(&sandbox, &args, main, STACK));
        let others = smallest(|others| ends_well(&sandbox, &args, STACK, others));
        println!("{main:>6} {others:>6}  {}", args.join(" "));
        assert!(ends_well(&sandbox, &args, STACK, STACK), "{args:?}");
    }
}
