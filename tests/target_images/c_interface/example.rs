//! The example for a bare Cortex-M4 runs.

use super::image::{Abi, library};
use std::process::Command;

#[test]
#[ignore = "needs qemu-system-arm, gcc-arm-none-eabi and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_example_on_bare_metal_runs() {
    let source = super::folder().join("examples/bare_metal");
    let folder = tempfile::tempdir().expect("a folder");
    let image = folder.path().join("bare_metal");
    let built = Command::new("arm-none-eabi-gcc")
        .args(["-O2", "-std=c99", "-Wall", "-Wextra", "-Werror"])
        .args(Abi::Hard.arguments())
        .args(["-nostdlib", "-ffreestanding", "-ffunction-sections", "-fdata-sections", "-z", "noexecstack"])
        .args(["-Wl,--gc-sections", "-T", "mps2.ld", "main.c", "startup.c", "-I"])
        .arg(super::folder().join("include"))
        .arg("-o")
        .arg(&image)
        .arg(library(Abi::Hard.target()))
        .current_dir(source)
        .status();
    assert!(built.expect("missing: the cross compiler").success(), "the example links");
    // The emulator fails unless the example found the expected statistics.
    super::super::emulated(&image, super::super::COUNTING);
}
