use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::recording::harness::{cut_short, damaged, error, probe, read_file, recording, values};
use crate::scene::Clock;

fn element(kind: u32, bytes: &[u8]) -> Vec<u8> {
    let mut out = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
    out.extend(bytes);
    out.resize(out.len().next_multiple_of(8), 0);
    out
}

/// A variable of `size` with numbers of type `kind`.
fn variable(name: &str, class: u8, size: [i32; 2], kind: u32, numbers: &[u8]) -> Vec<u8> {
    let size: Vec<u8> = size.iter().flat_map(|n| n.to_le_bytes()).collect();
    let flags = element(6, &[class, 0, 0, 0, 0, 0, 0, 0]);
    let parts = [flags, element(5, &size), element(1, name.as_bytes()), element(kind, numbers)];
    element(14, &parts.concat())
}

fn packed(variable: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(variable).unwrap();
    let bytes = encoder.finish().unwrap();
    [15_u32.to_le_bytes().as_slice(), &(bytes.len() as u32).to_le_bytes(), &bytes].concat()
}

fn mat(variables: &[Vec<u8>]) -> Vec<u8> {
    let mut out = b"MATLAB 5.0 MAT-file, made by a test".to_vec();
    out.resize(124, b' ');
    out.extend([0, 1, b'I', b'M']);
    out.extend(variables.concat());
    out
}

fn file() -> Vec<u8> {
    let doubles: Vec<u8> = (0..40).flat_map(|i| (f64::from(i) * 0.1).to_le_bytes()).collect();
    let words: Vec<u8> = (0..40).flat_map(|i: i16| (-i).to_le_bytes()).collect();
    mat(&[
        variable("x", 6, [40, 1], 9, &doubles),
        variable("text", 4, [1, 2], 4, &[1, 0, 2, 0]),
        packed(&variable("y", 12, [1, 40], 3, &words)),
        variable("square", 6, [2, 2], 2, &[1, 2, 3, 4]),
        packed(&variable("few", 6, [1, 3], 9, &doubles[..24])),
    ])
}

#[test]
fn vectors_are_exact() {
    let rows = values(&file(), &["y", "x"]);
    assert_eq!((rows.len(), rows[7].as_slice()), (40, [-7.0, 7.0 * 0.1].as_slice()));
}

#[test]
fn what_the_scene_names_has_to_be_there() {
    assert_eq!(
        error(&file(), &recording(&["X"])),
        ": no column `X`; found the columns `x`, `y`, `few`; did you mean `x`?"
    );
    let said = error(&file(), &recording(&["x", "few"]));
    assert!(said.starts_with(": found numbers of values 40 in `x`, 3 in `few`; allowed: columns of equal"), "{said}");
    let newer = [b"MATLAB 7.3 MAT-file".as_slice(), &[b' '; 200]].concat();
    assert!(error(&newer, &recording(&["x"])).contains("version 7.3, which is HDF5 (save it with -v7)"));
    let lies = mat(&[variable("x", 6, [1 << 30, 1], 9, &[0; 16])]);
    assert!(error(&lies, &recording(&["x"])).contains("1073741824 numbers in 16 bytes for `x`"));
}

#[test]
fn short_and_damaged_files() {
    let file = file();
    // Between two variables a file of fewer of them ends.
    cut_short(&file, &["x"], &(500..file.len()).collect::<Vec<_>>());
    cut_short(&mat(&[packed(&variable("x", 9, [1, 64], 2, &[7; 64]))]), &["x"], &[]);
    damaged(&file, &["x", "y"]);
}

/// A measured file, where it is at hand.
#[test]
fn measured_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings/real/cwru_6205");
    let path = folder.join("normal_0_97.mat");
    if !path.is_file() {
        return;
    }
    let mut recording = recording(&[]);
    recording.clock = Clock::Rate(48e3);
    recording.probes = vec![probe("X097_DE_time", 1.0), probe("X097_FE_time", 1.0)];
    let said = read_file(&path, &recording);
    assert!(said.is_ok() || said.is_err_and(|error| error.to_string().contains("`X097")));
}
