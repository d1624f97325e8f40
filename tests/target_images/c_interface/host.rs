//! The shared library on the desktop: the examples in C and Python print the forces of the kernel.

use ballrace::bearing::LastValidWrench;
use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::evenly_spaced;
use ballrace::bearing::geometry::{BEARING_STEEL, BallBearingGeometry};
use ballrace::{Bearing, DeepGroove, Displacement, Phase};
use std::path::PathBuf;
use std::process::Command;

/// Builds the library for the desktop and returns its folder.
fn library() -> PathBuf {
    let folder = super::super::root().join("target/c");
    let built = Command::new(env!("CARGO"))
        .args(["rustc", "--locked", "--quiet", "-p", "ballrace-c", "--profile", "c-library", "--crate-type", "cdylib"])
        .args(["--features", "checks", "--target-dir"])
        .arg(&folder)
        .current_dir(super::super::root())
        .status();
    assert!(built.expect("cargo runs").success(), "the shared library builds");
    folder.join("c-library")
}

/// Status bits and force of each displacement.
type Rows = Vec<(u32, [f32; 5])>;

fn expected() -> Rows {
    let geometry = BallBearingGeometry {
        ball_diameter: 7.94e-3,
        pitch_diameter: 39.04e-3,
        inner_conformity: 0.52,
        outer_conformity: 0.52,
        contact_angle: 0.0,
        ball: BEARING_STEEL,
        race: BEARING_STEEL,
    };
    let geometry = geometry.with_clearance(10e-6).expect("a geometry");
    let bearing = DeepGroove::<f32, 9>::try_new(geometry, evenly_spaced(Phase::ZERO), DisplacementDatum::Centred);
    let (bearing, mut last_valid) = (bearing.expect("a bearing"), LastValidWrench::new());
    let row = |i: u8| {
        let u = Displacement { u: 8e-6 * f32::from(i), v: -2e-6, w: 30e-6, ..Displacement::default() };
        let cage = Phase::from_revolutions(0.1 * f64::from(i));
        let (wrench, status) = bearing.sample(&mut last_valid, &u, &cage.into());
        (u32::from(status.bits()), wrench.to_array())
    };
    (0..4).map(row).collect()
}

fn rows(text: &str) -> Rows {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(' ').collect();
        let [status, wrench @ ..] = &cells[..] else { panic!("six cells: {line}") };
        let wrench: Vec<f32> = wrench.iter().map(|cell| cell.parse().expect("a number")).collect();
        (status.parse().expect("a number"), wrench.try_into().expect("five numbers"))
    };
    text.lines().map(row).collect()
}

fn output(command: &mut Command) -> String {
    let output = command.output().unwrap_or_else(|error| panic!("{command:?}: {error}"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

#[test]
#[ignore = "needs cc and python3; tests/run runs it"]
fn the_shared_library_gives_the_forces_of_the_kernel() {
    let (library, expected) = (library(), expected());
    let example = super::folder().join("examples/host");
    let folder = tempfile::tempdir().expect("a folder");
    let name = if cfg!(target_os = "macos") { "libballrace_c.dylib" } else { "libballrace_c.so" };
    let printed = output(Command::new("python3").arg(example.join("example.py")).arg(library.join(name)));
    assert_eq!(rows(&printed), expected, "Python");
    for standard in ["c99", "c11"] {
        let program = folder.path().join(standard);
        let built = Command::new("cc")
            .args(["-Wall", "-Wextra", "-Werror", "-pedantic", &format!("-std={standard}")])
            .arg(example.join("main.c"))
            .arg("-I")
            .arg(super::folder().join("include"))
            .arg("-L")
            .arg(&library)
            .args(["-lballrace_c", "-o"])
            .arg(&program)
            .status();
        assert!(built.expect("missing: a compiler").success(), "{standard}");
        let printed = output(Command::new(program).env("LD_LIBRARY_PATH", &library));
        assert_eq!(rows(&printed), expected, "{standard}");
    }
}

/// With checks, a call with NULL returns `BALLRACE_INVALID_ARGUMENT`.
#[test]
#[ignore = "needs python3; tests/run runs it"]
fn null_is_rejected_by_the_library_with_checks() {
    let library = library().join(if cfg!(target_os = "macos") { "libballrace_c.dylib" } else { "libballrace_c.so" });
    let program = "import ctypes, sys\n\
                   library = ctypes.CDLL(sys.argv[1])\n\
                   print(library.ballrace_force(None, None, ctypes.c_uint64(0), None))\n\
                   print(library.ballrace_last_valid_init(None))\n\
                   print(library.ballrace_rotor_step(None, None, None))\n";
    let printed = output(Command::new("python3").args(["-c", program]).arg(library));
    assert_eq!(printed, "512\n512\n512\n");
}
