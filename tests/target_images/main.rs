//! The kernel on an emulated Cortex-M4F: builds the images of tests/target, runs them, reads what they print.
//!
//! `BALLRACE_WRITE=1 cargo test -p ballrace-target-tests -- --ignored` rewrites the figures of `docs/src/performance.md`.

mod baked;
mod baked_c;
mod bits;
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

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Builds every image once and gives the folder they are in.
fn images() -> &'static Path {
    static IMAGES: OnceLock<PathBuf> = OnceLock::new();
    IMAGES.get_or_init(|| build("images", &[]))
}

/// The images with the kernel's feature `defmt`, and the example logging by it.
fn images_with_defmt() -> &'static Path {
    static IMAGES: OnceLock<PathBuf> = OnceLock::new();
    IMAGES.get_or_init(|| build("images-defmt", &["-p", "firmware", "-p", "smallest", "--features", "defmt"]))
}

fn build(folder: &str, arguments: &[&str]) -> PathBuf {
    let target = root().join("target").join(folder);
    let built = cargo().args(["build", "--release", "--target-dir"]).arg(&target).args(arguments).status();
    let built = built.expect("cargo runs");
    assert!(built.success(), "the images build; missing target? type: rustup target add thumbv7em-none-eabihf");
    target.join("thumbv7em-none-eabihf/release")
}

const HOST: &str = "x86_64-unknown-linux-gnu";

/// Builds the program of one package for any target, and gives it.
fn build_package(package: &str, target: &str, profile: &str, flags: Option<&str>) -> PathBuf {
    let folder = root().join("target").join(if flags.is_some() { "images-avx2" } else { "images" });
    let mut cargo = cargo();
    cargo.args(["build", "-p", package, "--profile", profile, "--target", target, "--target-dir"]).arg(&folder);
    if let Some(flags) = flags {
        cargo.env("RUSTFLAGS", flags);
    }
    let built = cargo.status().expect("cargo runs");
    assert!(built.success(), "{package} builds; missing target? type: rustup target add {target}");
    let profile_folder = if profile == "dev" { "debug" } else { profile };
    folder.join(target).join(profile_folder).join(package)
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
    emulated_on("mps2-an386", image, arguments)
}

fn emulated_on(board: &str, image: &Path, arguments: &[&str]) -> Vec<u8> {
    let output = Command::new("qemu-system-arm")
        .args(["-M", board, "-nographic", "-monitor", "none", "-serial", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(arguments)
        .arg("-kernel")
        .arg(image)
        .output()
        .expect("missing: the emulator; type: apt-get install -y --no-install-recommends qemu-system-arm");
    assert!(output.status.success(), "{}: {}", image.display(), String::from_utf8_lossy(&output.stdout));
    output.stdout
}
