//! The kernel on an emulated Cortex-M4F: builds the images of tests/target, runs them, reads what they print.
//!
//! `BALLRACE_WRITE=1 cargo test -p ballrace-target-tests -- --ignored` rewrites the figures of `docs/src/performance.md`.

mod baked;
mod baked_c;
mod bits;
mod board;
mod c_interface;
mod counts;
/// Inputs of the counting images.
#[path = "../target/counts/src/inputs.rs"]
mod counts_inputs;
mod deny;
mod firmware;
mod isr;
mod links;
mod roots;
mod smallest;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::Instant;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

const FPU: &str = "thumbv7em-none-eabihf";
const HOST: &str = "x86_64-unknown-linux-gnu";

/// Builds packages in a folder of `target` and returns the folder. Cargo builds all targets of one call in parallel.
fn build(folder: &str, profile: &str, packages: &[&str], targets: &[&str], more: &[&str]) -> PathBuf {
    let built = root().join("target").join(folder);
    let started = Instant::now();
    let success = cargo()
        .args(["build", "--profile", profile, "--target-dir"])
        .arg(&built)
        .args(packages.iter().flat_map(|package| ["-p", package]))
        .args(targets.iter().flat_map(|target| ["--target", target]))
        .args(more)
        .status()
        .expect("cargo runs")
        .success();
    assert!(success, "{packages:?} build; missing target? type: rustup target add {}", targets.join(" "));
    println!("{packages:?} for {targets:?}, {profile}: built in {:.1} s", started.elapsed().as_secs_f64());
    built
}

/// Returns the folder of the images for a Cortex-M4F.
fn images() -> PathBuf {
    static IMAGES: OnceLock<PathBuf> = OnceLock::new();
    let packages = ["baked", "board", "firmware", "counts", "isr", "smallest"];
    IMAGES.get_or_init(|| build("images", "release", &packages, &[FPU], &[])).join(FPU).join("release")
}

/// The images with the kernel's feature `defmt`, and the example logging by it.
fn images_with_defmt() -> PathBuf {
    static IMAGES: OnceLock<PathBuf> = OnceLock::new();
    let build = || build("images-defmt", "release", &["firmware", "smallest"], &[FPU], &["--features", "defmt"]);
    IMAGES.get_or_init(build).join(FPU).join("release")
}

/// Cargo in the workspace of the images.
fn cargo() -> Command {
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(root().join("tests/target")).env_remove("RUSTFLAGS");
    cargo
}

/// One instruction takes 256 ns of the emulated machine's time.
const COUNTING: &[&str] = &["-icount", "shift=8,align=off,sleep=off"];

/// What an image prints, under instruction counting.
fn run(image: &str) -> String {
    run_with(image, COUNTING)
}

fn run_with(image: &str, arguments: &[&str]) -> String {
    emulated(&images().join(image), arguments)
}

fn emulated(image: &Path, arguments: &[&str]) -> String {
    String::from_utf8(emulated_bytes(image, arguments)).expect("text")
}

fn emulated_bytes(image: &Path, arguments: &[&str]) -> Vec<u8> {
    printed(MPS2_M4F.command(image).args(arguments))
}

/// A board of an emulator.
#[derive(Clone, Copy)]
struct Board {
    emulator: &'static str,
    machine: &'static str,
    /// Options that the machine needs.
    options: &'static [&'static str],
}

impl Board {
    const fn arm(machine: &'static str) -> Self {
        Self { emulator: "qemu-system-arm", machine, options: &[] }
    }

    /// Returns the command that runs an image without a display; what it prints by semihosting is the output of the command.
    fn command(&self, image: &Path) -> Command {
        let mut command = Command::new(self.emulator);
        command
            .args(["-M", self.machine, "-nographic", "-monitor", "none", "-serial", "none"])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(self.options)
            .arg("-kernel")
            .arg(image);
        command
    }
}

/// A board with a Cortex-M4F.
const MPS2_M4F: Board = Board::arm("mps2-an386");
/// A board with a RISC-V core of 32 bits.
const RISC_V: Board = Board { emulator: "qemu-system-riscv32", machine: "virt", options: &["-bios", "none"] };

/// Returns what a program prints.
fn printed(program: &mut Command) -> Vec<u8> {
    let output = program.output().expect("missing: an emulator; tests/run names the line to type");
    assert!(output.status.success(), "{program:?}: {}", String::from_utf8_lossy(&output.stdout));
    output.stdout
}
