//! The same bits everywhere: checksums over a recording on the desktop and on six kinds of microcontroller.

use super::{Board, HOST, MPS2_M4F, RISC_V, build, printed};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::thread;

/// Samples of the recording that are taken: 40 turns of the shaft, or 4 in the usual run.
fn samples() -> usize {
    if ballrace_tests::runs_all() { 10_240 } else { 1_024 }
}
/// Invalid samples: the kernel replaces them by the last valid value.
const SPOILT: [(usize, usize, f32); 3] = [(100, 0, f32::NAN), (101, 2, f32::INFINITY), (900, 4, f32::NEG_INFINITY)];
/// The samples of one turn that are changed to see that the checksums depend on them.
const CHANGED: std::ops::Range<usize> = 640..896;

/// A kind of microcontroller, and the boards on which its images run.
struct Microcontroller {
    target: &'static str,
    release_board: Board,
    debug_board: Board,
}

const MICROCONTROLLERS: [Microcontroller; 6] = [
    on(MPS2_M4F, "thumbv7em-none-eabihf"),
    on(MPS2_M4F, "thumbv7em-none-eabi"),
    Microcontroller {
        target: "thumbv6m-none-eabi",
        release_board: Board::arm("microbit"),
        debug_board: Board::arm("mps2-an385"),
    },
    on(Board::arm("mps2-an505"), "thumbv8m.main-none-eabihf"),
    on(RISC_V, "riscv32imac-unknown-none-elf"),
    on(RISC_V, "riscv32imafc-unknown-none-elf"),
];

const fn on(board: Board, target: &'static str) -> Microcontroller {
    Microcontroller { target, release_board: board, debug_board: board }
}

/// The rig's recording with a spall as the images read it: five `f32` and a turn counter a sample.
fn recording() -> Vec<u8> {
    let text = include_str!("../recordings/outer-spall.csv");
    let mut bytes = Vec::new();
    for (i, line) in text.lines().skip(1).take(samples()).enumerate() {
        let cells: Vec<f32> = line.split(',').map(|cell| cell.parse().expect("a number")).collect();
        let [_, de_x, de_y, nde_x, nde_y, axial, _] = cells[..] else { panic!("seven columns: {line}") };
        let micro = |x: f32| x * 1e-6;
        let tilt = |de: f32, nde: f32| micro(nde - de) / 0.24;
        let (u, v) = (micro(0.5 * (de_x + nde_x)), micro(0.5 * (de_y + nde_y)));
        let mut sample = [u, v, micro(axial), -tilt(de_y, nde_y), tilt(de_x, nde_x)];
        for (at, entry, value) in SPOILT {
            if at == i {
                sample[entry] = value;
            }
        }
        // 3000 rpm at 12.8 kHz: 1/256 turn a sample.
        let turn = (i as u64).wrapping_mul(1 << 56);
        bytes.extend(sample.iter().flat_map(|x| x.to_le_bytes()).chain(turn.to_le_bytes()));
    }
    assert_eq!(bytes.len(), samples() * 28);
    bytes
}

/// What a program prints, started beside the recording.
fn checksums(program: &mut Command, folder: &Path) -> String {
    String::from_utf8(printed(program.current_dir(folder))).expect("text")
}

/// Builds the program for this machine with AVX2 and FMA, once, and returns its path.
pub fn with_avx2() -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let flags = ["--config", "build.rustflags=[\"-Ctarget-feature=+avx2,+fma\"]"];
    BUILT.get_or_init(|| build("images-avx2", "release", &["bits"], &[HOST], &flags)).join(HOST).join("release/bits")
}

/// Every run beside the reference: its name and what to start.
fn runs(folder: &Path) -> Vec<(String, Command)> {
    // With assertions on one machine in the usual run, on all of them in the full one.
    let checked = if ballrace_tests::runs_all() { &MICROCONTROLLERS[..] } else { &MICROCONTROLLERS[..1] };
    let targets: Vec<&str> = checked.iter().map(|machine| machine.target).chain([HOST]).collect();
    build("images", "dev", &["bits"], &targets, &[]);
    let image = |target: &str, profile: &str| folder.join(target).join(profile).join("bits");
    let mut runs = vec![("x86-64, not optimised".to_owned(), Command::new(image(HOST, "debug")))];
    if cfg!(target_arch = "x86_64") && std::arch::is_x86_feature_detected!("avx2") {
        runs.push(("x86-64 with AVX2 and FMA".to_owned(), Command::new(with_avx2())));
    } else {
        println!("no AVX2 here: not compared");
    }
    for machine in &MICROCONTROLLERS {
        let image = image(machine.target, "release");
        runs.push((format!("{}, release", machine.target), machine.release_board.command(&image)));
    }
    for machine in checked {
        let image = image(machine.target, "debug");
        runs.push((format!("{}, dev", machine.target), machine.debug_board.command(&image)));
    }
    runs
}

#[test]
#[ignore = "needs qemu-system-arm, qemu-system-misc and six targets; tests/run runs it"]
fn every_machine_gives_the_same_bits() {
    let targets: Vec<&str> = MICROCONTROLLERS.iter().map(|machine| machine.target).chain([HOST]).collect();
    let images = build("images", "release", &["bits"], &targets, &[]);
    let folder = tempfile::tempdir().expect("a folder");
    let mut bytes = recording();
    std::fs::write(folder.path().join("recording.bin"), &bytes).expect("the recording is written");
    let host = images.join(HOST).join("release/bits");
    let expected = checksums(&mut Command::new(&host), folder.path());
    assert!(expected.lines().count() >= 18, "{expected}");

    let runs = std::sync::Mutex::new(runs(&images));
    let next = || runs.lock().expect("no thread panics while it takes a run").pop();
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some((name, mut run)) = next() {
                    compare(&name, &checksums(&mut run, folder.path()), &expected);
                }
            });
        }
    });

    // The comparison can fail: a thousandth of some samples changes all but what follows from the shaft's angle alone, and the counts.
    for sample in CHANGED {
        bytes[sample * 28 + 1] ^= 0x40;
        bytes[sample * 28 + 9] ^= 0x40;
    }
    std::fs::write(folder.path().join("recording.bin"), &bytes).expect("the recording is written");
    let other = checksums(&mut Command::new(&host), folder.path());
    let same: Vec<&str> = expected.lines().filter(|line| other.contains(line)).collect();
    assert!(same.len() == 4, "too little depends on the recording: {same:?}");
}

fn compare(name: &str, found: &str, expected: &str) {
    println!("{name}");
    for (found, expected) in found.lines().zip(expected.lines()) {
        assert_eq!(found, expected, "{name} gives other bits than x86-64");
    }
    assert_eq!(found.lines().count(), expected.lines().count(), "{name}: {found}");
}
