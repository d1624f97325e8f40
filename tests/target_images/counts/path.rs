//! The path a call takes through the machine code, written down by the emulator.

use super::{Name, Subject, subjects};

/// Runs every subject once, one instruction at a time: the subjects, and every address visited.
pub fn traced() -> (Vec<Subject>, Vec<u32>) {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("trace");
    let path = log.to_str().expect("a path in UTF-8");
    let subjects = subjects("trace", &["-singlestep", "-d", "exec,nochain", "-D", path]);
    let text = std::fs::read_to_string(&log).expect("the emulator writes a trace");
    // `Trace 0: 0x7f14900d4240 [00800400/00000458/00000010/ff000201] name`
    let address = |line: &str| u32::from_str_radix(line.split_once('/')?.1.split('/').next()?, 16).ok();
    (subjects, text.lines().filter(|line| line.starts_with("Trace")).filter_map(address).collect())
}

/// The addresses from the entry of a function to its return, both included.
pub fn of_call<'a>(visited: &'a [u32], entry: u32, name: &Name) -> &'a [u32] {
    let start = visited.iter().position(|&address| address == entry).unwrap_or_else(|| panic!("{name} is not called"));
    let caller = visited[start - 1];
    let length = visited[start..]
        .iter()
        .position(|&address| address == caller + 4 || address == caller + 2)
        .unwrap_or_else(|| panic!("{name} does not return"));
    &visited[start..start + length]
}
