//! Bearings as a blob: what `ballrace bake -o F.blob` writes, the kernel reads with the bits of the constants in C; damage is found.

use crate::bake::EVERY_MODEL_OF_C;
use crate::support::{Sandbox, swap};
use ballrace::bearing::angular::Angular;
use ballrace::bearing::roller::{Lamina, LaminaRoller};
use ballrace::bearing::{ElementPosition, Mirrored};
use ballrace::blob::{Blob, BlobBearing, InvalidBlob};
use ballrace::{Bearing, Exact};

type Elements<'a> = &'a [ElementPosition<f32>];

/// Checks bytes that begin `shift` bytes after an address that is a multiple of 8.
fn at<R>(shift: usize, bytes: &[u8], check: impl FnOnce(&[u8]) -> R) -> R {
    let mut room = vec![0; bytes.len() + 16];
    let begin = room.as_ptr().align_offset(8) + shift;
    let page = &mut room[begin..begin + bytes.len()];
    page.copy_from_slice(bytes);
    check(page)
}

fn baked(scene: &str) -> (Sandbox, Vec<u8>) {
    let sandbox = Sandbox::empty();
    sandbox.put("scene.toml", scene);
    sandbox.done(&["bake", "scene.toml", "-o", "bearings.blob"]);
    let blob = std::fs::read(sandbox.path("bearings.blob")).unwrap();
    (sandbox, blob)
}

/// The tests of the target hold the other models, in Rust and in C.
#[test]
fn rollers_of_a_blob_have_the_checksum_of_the_desktop() {
    let scene =
        std::fs::read_to_string(crate::documents::root().join("runner/scenes/tapered-32008-pair.toml")).unwrap();
    let (_, blob) = baked(&scene);
    at(0, &blob, |bytes| {
        type Rollers<'a> = LaminaRoller<f32, Exact, Elements<'a>, &'a [Lamina<f32>]>;
        fn is_right<'a>(record: BlobBearing<'a>, bearing: &impl Bearing<f32>) -> bool {
            record.checksum_range().checksum(bearing) == record.checksum()
        }
        let blob = Blob::try_new(bytes).unwrap();
        let names: Vec<&[u8]> = blob.bearings().map(|record| record.name()).collect();
        assert_eq!(names, [&b"left"[..], b"right"]);
        let [left, right] = ["left", "right"].map(|name| blob.bearing(name).unwrap());
        let found = [left.bearing::<Rollers>().is_ok(), right.bearing::<Rollers>().is_ok()];
        assert_eq!(found.iter().filter(|found| **found).count(), 1, "they face each other: {found:?}");
        let (plain, mirrored) = if found[0] { (left, right) } else { (right, left) };
        assert!(is_right(plain, &plain.bearing::<Rollers>().unwrap()));
        assert!(is_right(mirrored, &mirrored.bearing::<Mirrored<Rollers>>().unwrap()));
        let other = plain.bearing::<Angular<f32, Exact, Elements>>().err();
        assert_eq!(other, Some(InvalidBlob::Model(0x60)));
    });
}

#[test]
fn damage_of_a_blob_is_found_and_named() {
    let (sandbox, sound) = baked(EVERY_MODEL_OF_C);
    let reason = |bytes: &[u8]| at(0, bytes, |bytes| Blob::try_new(bytes).err());
    assert_eq!(reason(&sound), None);
    // Every 37th byte, and the first ones.
    for byte in (0..16).chain((16..sound.len()).step_by(37)) {
        let mut damaged = sound.clone();
        damaged[byte] ^= 0x10;
        let expected = match byte {
            0..4 => |reason: InvalidBlob| reason == InvalidBlob::NotABlob,
            4 | 5 => |reason| matches!(reason, InvalidBlob::Version(_)),
            8..12 => |reason| matches!(reason, InvalidBlob::Length(_) | InvalidBlob::Checksum),
            _ => |reason| reason == InvalidBlob::Checksum,
        };
        assert!(reason(&damaged).is_some_and(expected), "byte {byte}: {:?}", reason(&damaged));
    }
    for length in [0, 3, 15, 23, 200, sound.len() - 8] {
        assert!(reason(&sound[..length]).is_some(), "{length} bytes");
    }
    at(4, &sound, |bytes| assert_eq!(Blob::try_new(bytes).err(), Some(InvalidBlob::NotAligned)));

    // The scene is the measure of the blob, from the certificate beside it or by its name.
    assert!(sandbox.done(&["verify", "bearings.blob"]).out.contains("equal to its scene"));
    let mut damaged = sound.clone();
    // The stiffness of the first bearing: its header, nine elements, no table.
    damaged[16 + 160 + 9 * 16] ^= 1;
    std::fs::write(sandbox.path("bearings.blob"), &damaged).unwrap();
    let answer = sandbox.run(&["verify", "bearings.blob"]);
    assert_eq!(answer.code, Some(1), "{answer:?}");
    assert!(answer.out.contains("byte 320, constants of bearing radial: "), "{answer:?}");
}

#[test]
fn a_blob_refuses_what_it_cannot_hold() {
    let sandbox = Sandbox::empty();
    sandbox
        .put("scene.toml", swap(EVERY_MODEL_OF_C, "name = \"radial\"", "name = \"radial bearing at the drive end\""));
    let parts =
        ["bearing radial bearing at the drive end: a name of 31 bytes with --language blob, expected at most 24"];
    sandbox.refused(&["bake", "scene.toml", "-o", "bearings.blob"], 2, &parts);
    sandbox.put("scene.toml", EVERY_MODEL_OF_C);
    let parts = ["--output: invalid name for --language blob: bearings.bin, expected a name that ends in .blob"];
    sandbox.refused(&["bake", "scene.toml", "--language", "blob", "-o", "bearings.bin"], 2, &parts);
    std::fs::write(sandbox.path("bearings.blob"), "BRBL").unwrap();
    let parts = ["bearings.blob: no certificate beside this blob (not a blob of ballrace): bearings.txt is missing"];
    sandbox.refused(&["verify", "bearings.blob"], 2, &parts);
}

/// A blob is named by its scene and by the CRC-32 that a device reads; without its certificate, by what it has, and a scene is the measure.
#[test]
fn a_blob_is_named() {
    let (sandbox, blob) = baked(EVERY_MODEL_OF_C);
    let crc32 = u32::from_le_bytes(*blob.last_chunk().unwrap());
    let name = format!("Blob: CRC-32 {crc32:#010x}");
    let out = sandbox.done(&["verify", "bearings.blob"]).out;
    let scene = out.lines().find(|line| line.starts_with("Scene ") && line.contains(": SHA-256 ")).unwrap().to_owned();
    assert!(sandbox.read("bearings.txt").contains(scene.rsplit(' ').next().unwrap()), "{out}");
    assert!(out.contains(&name), "{out}");
    std::fs::remove_file(sandbox.path("bearings.txt")).unwrap();
    let names: Vec<String> = at(0, &blob, |bytes| {
        let blob = Blob::try_new(bytes).unwrap();
        blob.bearings().map(|one| String::from_utf8_lossy(one.name()).into_owned()).collect()
    });
    let found = format!("bearings {}, CRC-32 {crc32:#010x}): bearings.txt is missing", names.join(", "));
    sandbox.refused(&["verify", "bearings.blob"], 2, &[&found]);
    let out = sandbox.done(&["verify", "bearings.blob", "--scene", "scene.toml"]).out;
    assert!(out.contains("equal to its scene") && out.contains(&scene) && out.contains(&name), "{out}");
    let mut damaged = blob.clone();
    damaged[100] ^= 1;
    std::fs::write(sandbox.path("bearings.blob"), &damaged).unwrap();
    sandbox.refused(&["verify", "bearings.blob"], 2, &["damaged: its bytes have 0x"]);
    let answer = sandbox.run(&["verify", "bearings.blob", "--scene", "scene.toml"]);
    assert!(answer.code == Some(1) && answer.out.contains("byte 100, header of bearing radial"), "{answer:?}");
}
