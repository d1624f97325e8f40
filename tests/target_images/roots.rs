//! The machine's square root against the one in integer arithmetic: correctly rounded both, so the same bits.

use super::{Board, MPS2_M4F, printed};
use std::process::Command;

const BOARDS: [(&str, Board); 2] = [(super::FPU, MPS2_M4F), ("thumbv8m.main-none-eabihf", Board::arm("mps2-an505"))];

/// Builds the program for all targets once and returns its path for one of them.
fn image(target: &str) -> std::path::PathBuf {
    static BUILT: std::sync::OnceLock<std::path::PathBuf> = std::sync::OnceLock::new();
    let targets: Vec<&str> = BOARDS.iter().map(|(target, _)| *target).chain([super::HOST]).collect();
    BUILT
        .get_or_init(|| super::build("images", "release", &["roots"], &targets, &[]))
        .join(target)
        .join("release/roots")
}

/// All 2^32 inputs, 20 s on two cores; in the usual run one of 101.
#[test]
#[ignore = "builds an image; tests/run runs it"]
fn every_root_on_the_desktop() {
    let (step, compared) = if ballrace_tests::runs_all() { ("1", 4_294_967_296_u64) } else { ("101", 42_524_430) };
    let output = Command::new(image(super::HOST)).arg(step).output().expect("the program runs");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert_eq!(printed.trim(), format!("{compared} compared, 0 differ; 0 groups differ"));
}

/// A million inputs and all corners on both targets that have an FPU.
#[test]
#[ignore = "needs qemu-system-arm and two targets; tests/run runs it"]
fn a_dense_set_of_roots_on_the_target() {
    for (target, board) in BOARDS {
        let printed = String::from_utf8(printed(&mut board.command(&image(target)))).expect("text");
        assert_eq!(printed.trim(), "1081089 compared, 0 differ", "{target}");
    }
}
