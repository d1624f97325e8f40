//! Any bytes as a matrix: Matrix Market or NPY, or one error.
#![no_main]

use ballrace_twin::plant::matrix;
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

fuzz_target!(|bytes: &[u8]| {
    let ending = if bytes.starts_with(b"\x93NUMPY") { "npy" } else { "mtx" };
    let path = FOLDER.path().join(format!("matrix.{ending}"));
    std::fs::write(&path, bytes).expect("a file");
    let _ = matrix::read(&path, &["M"]);
});
