//! Baked firmware beside the desktop: checksums, a log that `ballrace force` replays, the motion of a flexible rotor.

#[path = "../target/baked/src/bearings.rs"]
#[rustfmt::skip]
pub mod bearings;
#[path = "../target/baked/src/flexible.rs"]
#[rustfmt::skip]
mod flexible;
#[path = "../target/baked/src/log.rs"]
mod log;
#[path = "../target/baked/src/motion.rs"]
mod motion;

use bearings::{bearing_de, bearing_nde};

/// Returns the output of the desktop for the same constants.
fn expected() -> String {
    let mut lines = String::new();
    for (name, computed, constant) in
        [("DE", bearing_de::checksum(), bearing_de::CHECKSUM), ("NDE", bearing_nde::checksum(), bearing_nde::CHECKSUM)]
    {
        assert_eq!(computed, constant, "{name}: checksum of the certificate");
        lines += &format!("checksum,{name},{computed:#018x},{constant:#018x}\n");
    }
    let (de, nde) = (bearing_de::bearing(), bearing_nde::bearing());
    for i in 0..log::SAMPLES {
        let (u, at) = (log::displacement(i), log::rotation(i));
        lines += &format!("DE,{}\nNDE,{}\n", log::Row::new(&de, &u, &at), log::Row::new(&nde, &u.mirrored(), &at));
    }
    motion::run(|i, moved, observed| {
        assert!(moved.iter().chain(observed).all(|x| x.abs() < 1e-3), "{moved:?} {observed:?}");
        let bits: String = moved.iter().chain(observed).map(|x| format!(",{:08x}", x.to_bits())).collect();
        lines += &format!("rotor,{i}{bits}\n");
    })
    .expect("symmetric matrices");
    lines
}

/// Firmware with a baked scene prints the bits that the desktop computes from the same constants.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn a_baked_scene_gives_the_same_bits() {
    let expected = expected();
    let rows = expected.lines().filter(|line| line.contains("DE,0x") && !line.starts_with("checksum"));
    assert!(
        rows.clone().count() == 128 && rows.clone().all(|l| l.ends_with(",0x00")),
        "inside both tables:\n{expected}"
    );
    assert_eq!(super::run("baked"), expected);
}

/// `ballrace force` computes the bits of a log from the columns of its input.
#[test]
#[ignore = "needs qemu-system-arm and the target thumbv7em-none-eabihf; tests/run runs it"]
fn the_desktop_replays_the_log_of_the_image() {
    let printed = super::run("baked");
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["DE", "NDE"] {
        let columns = log::INPUT.split(',').count();
        let (mut input, mut forces) = (format!("{}\n", log::INPUT), "FX,FY,FZ,MX,MY,status\n".to_owned());
        for line in printed.lines().filter_map(|line| line.strip_prefix(name)?.strip_prefix(',')) {
            let cells: Vec<&str> = line.split(',').collect();
            let (displacement, force) = cells.split_at(columns);
            input += &format!("{}\n", displacement.join(","));
            forces += &format!("{}\n", force.join(","));
        }
        assert_eq!(forces.lines().count(), 1 + usize::from(log::SAMPLES));
        let file = folder.path().join("log.csv");
        std::fs::write(&file, input).expect("a file");
        let output = std::process::Command::new(env!("CARGO"))
            .args(["run", "-q", "--release", "-p", "ballrace-runner", "--", "force", "tests/target/baked/scene.toml"])
            .args(["--bearing", name, "--precision", "f32", "--bits", "--format", "csv", "--displacements"])
            .arg(file)
            .current_dir(super::root())
            .output()
            .expect("cargo runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(String::from_utf8_lossy(&output.stdout), forces, "{name}");
    }
}
