//! Baked firmware beside the desktop: checksums, a log that `ballrace force` replays (`tests/command_line/bake.rs`), the motion of a
//! flexible rotor.

#[path = "../target/baked/src/bearings.rs"]
#[rustfmt::skip]
pub mod bearings;
#[path = "../target/baked/src/flexible.rs"]
#[rustfmt::skip]
mod flexible;
#[path = "../target/baked/src/blob.rs"]
mod blob;
#[path = "../target/baked/src/framed.rs"]
mod framed;
#[path = "../target/baked/src/log.rs"]
#[expect(dead_code, reason = "the columns are those of the replay in tests/command_line/bake.rs")]
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
    let mut device = framed::device();
    for i in 0..framed::SAMPLES {
        lines += &format!("frame,{}\n", framed::Row::new(&mut device, i));
    }
    let rows = std::cell::RefCell::new(lines);
    blob::run(|row| *rows.borrow_mut() += &format!("blob,{row}\n")).expect("a blob");
    rows.into_inner()
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
    let of_blob: Vec<&str> = expected.lines().filter_map(|line| line.strip_prefix("blob,")).collect();
    let is_right =
        |row: &&&str| row.split_once(',').and_then(|(_, sums)| sums.split_once(',')).is_some_and(|(a, b)| a == b);
    assert_eq!(of_blob.iter().filter(is_right).count(), 7, "checksums of the blob: {of_blob:?}");
    assert_eq!(of_blob[7..], ["balls,bearing of another model: code 0x52", "ball,no bearing of this name"]);
    assert_eq!(super::run("baked"), expected);
}
