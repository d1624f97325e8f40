//! The hand-written C beside the kernel: compiled and counted in the same run.

use std::path::{Path, PathBuf};
use std::process::Command;

/// One C function: its name and its instructions.
pub struct Yardstick {
    pub name: String,
    pub instructions: u32,
}

/// All of them, and what compiled them.
pub struct Compiled {
    pub compiler: String,
    pub functions: Vec<Yardstick>,
}

const COMPILER: &str = "arm-none-eabi-gcc";
const MISSING: &str = "missing: the cross compiler; type: apt-get install -y --no-install-recommends gcc-arm-none-eabi";

/// Compiles it into an image in `folder`.
pub fn compiled_into(folder: &Path) -> PathBuf {
    let source = super::super::root().join("tests/target/yardstick");
    let image = folder.join("yardstick");
    let built = Command::new(COMPILER)
        .args(["-O3", "-fno-math-errno", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"])
        .args(["-nostdlib", "-ffreestanding", "-T", "link.ld", "main.c", "forces.c", "-o"])
        .arg(&image)
        .current_dir(source)
        .status()
        .expect(MISSING);
    assert!(built.success(), "the yardstick compiles");
    image
}

/// Compiled and counted.
pub fn rows() -> Compiled {
    let folder = tempfile::tempdir().expect("a folder");
    let image = compiled_into(folder.path());
    let printed = super::super::emulated(&image, super::super::COUNTING);
    let functions = printed
        .lines()
        .map(|line| {
            let (name, count) = line.split_once(';').expect("two cells");
            Yardstick { name: name.to_owned(), instructions: count.parse().expect("a number") }
        })
        .collect();
    Compiled { compiler: version(), functions }
}

fn version() -> String {
    let output = Command::new(COMPILER).arg("-dumpfullversion").output().expect(MISSING);
    format!("gcc {}", String::from_utf8_lossy(&output.stdout).trim())
}
