use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use crate::Reader;
use crate::harness::{cut_short, damaged, error, probe, read_file, recording, values};
use ballrace_scene::{Clock, Recording};

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

/// The text before the version is free, and version 4 has none.
#[test]
fn files_of_other_makers() {
    let of = recording(&["x"]);
    let mut other = file();
    other[..120].fill(b' ');
    other[..19].copy_from_slice(b"Rig logger, level 5");
    assert_eq!(values(&other, &["x"]), values(&file(), &["x"]));
    other[124..128].fill(b' ');
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.mat");
    let refused = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        read_file(&path, &of).unwrap_err().to_string()
    };
    let said = refused(&other);
    assert!(said.contains("no MATLAB file of version 5, but a file that begins with `Rig logger, level 5"), "{said}");
    let head: Vec<u8> = [0_u32, 3, 1, 0, 2].iter().flat_map(|word| word.to_le_bytes()).collect();
    let doubles: Vec<u8> = [1.0_f64, 2.0, 3.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert!(refused(&[head.as_slice(), b"x\0", &doubles].concat()).contains("a MATLAB file of version 4"));
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
fn columns_that_the_scene_names_are_required() {
    assert_eq!(
        error(&file(), &recording(&["X"])),
        ": no such column: `X` (did you mean `x`?), expected one of `x`, `y`, `square(:,1)`, `square(:,2)`, `few`"
    );
    let said = error(&file(), &recording(&["x", "few"]));
    assert!(
        said.starts_with(": unreadable file: numbers of values 40 in `x`, 3 in `few`, expected columns of equal"),
        "{said}"
    );

    let lies = mat(&[variable("x", 6, [1 << 30, 1], 9, &[0; 16])]);
    assert!(error(&lies, &recording(&["x"])).contains("1073741824 numbers in 16 bytes for `x`"));
}

/// Files that `scipy.io.savemat` wrote: structure `bearing` (`gs`, `sr`, `rate`, `load`), `N09` with the structure array `Y` of
/// three elements (`Name`, `Data`), cell array `x` of a text and a vector, matrices `m` (12 x 3) and `w` (2 x 12), number `fs`.
const STRUCTURES: [&[u8]; 2] = [include_bytes!("structures.mat"), include_bytes!("structures-packed.mat")];

#[test]
fn vectors_by_their_paths() {
    for file in STRUCTURES {
        let rows = values(file, &["bearing.gs", "N09.Y(3).Data", "x{2}", "m(:,2)", "w(2,:)"]);
        assert_eq!(rows.len(), 12);
        assert_eq!(rows[4], [0.0, 12.0, 4.0 / 11.0, 13.0, 16.0]);
        assert_eq!(values(file, &["bearing(1).gs"])[1], [-0.75]);
        assert_eq!(
            error(file, &recording(&["bearing.gx"])),
            ": no such column: `bearing.gx` (did you mean `bearing.gs`?), expected one of `bearing.gs`, `N09.Y(1).Data`, \
             `N09.Y(2).Data`, `N09.Y(3).Data`, `x{2}`, `m(:,1)`, `m(:,2)`, `m(:,3)`, `w(1,:)`, `w(2,:)`"
        );
    }
}

#[test]
fn rate_of_the_file() {
    let of = |name: &str, hertz| {
        let clock = Clock::Number { name: name.into(), hertz };
        Recording { clock, ..recording(&["bearing.gs"]) }
    };
    for file in STRUCTURES {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.mat");
        std::fs::write(&path, file).unwrap();
        for (name, hertz, rate) in
            [("bearing.sr", 1.0, 97_656.0), ("N09.Info.Rate", 1.0, 64_000.0), ("fs", 1000.0, 48e6)]
        {
            assert_eq!(Reader::open(&path, &of(name, hertz)).unwrap().rate(), rate);
        }
        assert_eq!(
            error(file, &of("bearing.fs", 1.0)),
            ": no such single number: `bearing.fs`, expected one of `bearing.sr`, `bearing.rate`, `bearing.load`, \
             `N09.Info.Rate`, `fs`"
        );
    }
    let none = mat(&[variable("x", 6, [4, 1], 2, &[1, 2, 3, 4])]);
    let of = Recording { clock: Clock::Stated, ..recording(&["x"]) };
    let said = error(&none, &of);
    assert_eq!(said, ": sampling rate of the file: none, expected rate = \"12.8 kHz\" or `time` in the scene");
    let of = Recording { clock: Clock::Number { name: "x".into(), hertz: 1.0 }, ..of };
    assert!(error(&none, &of).contains("`x`, expected rate = \"12.8 kHz\": the file has no single number"));
    let zero = mat(&[variable("x", 6, [2, 1], 2, &[1, 2]), variable("fs", 6, [1, 1], 2, &[0])]);
    let of = Recording { clock: Clock::Number { name: "fs".into(), hertz: 1.0 }, ..of };
    assert_eq!(error(&zero, &of), ": sampling rate of the file: 0 Hz, expected a rate above 0");
}

#[test]
fn structures_cut_short_and_damaged() {
    for file in STRUCTURES {
        cut_short(file, &["bearing.gs"], &(128..file.len()).collect::<Vec<_>>());
        damaged(file, &["bearing.gs", "N09.Y(3).Data", "m(:,2)", "w(2,:)"]);
    }
}

#[test]
fn structures_beyond_all_bounds() {
    // Cell arrays within each other, with a head that states more elements than there are.
    let mut inner = variable("", 6, [2, 1], 2, &[1, 2]);
    for _ in 0..40 {
        let size: Vec<u8> = [1, 1].iter().flat_map(|n: &i32| n.to_le_bytes()).collect();
        let parts = [element(6, &[1, 0, 0, 0, 0, 0, 0, 0]), element(5, &size), element(1, b"c"), inner];
        inner = element(14, &parts.concat());
    }
    assert!(error(&mat(&[inner]), &recording(&["c"])).contains("no readable array at `c{1}{1}"));
    let size: Vec<u8> = [1 << 30, 1 << 30].iter().flat_map(|n: &i32| n.to_le_bytes()).collect();
    let parts = [element(6, &[1, 0, 0, 0, 0, 0, 0, 0]), element(5, &size), element(1, b"c")];
    assert!(error(&mat(&[element(14, &parts.concat())]), &recording(&["c"])).contains("truncated"));
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

/// Files that `scipy.io.savemat` wrote: `K`, `M`, `G`, `C` of five coordinates, sparse, and a full `F`.
const SPARSE: [&[u8]; 2] = [include_bytes!("sparse.mat"), include_bytes!("sparse-packed.mat")];

fn matrix(bytes: &[u8], name: &str) -> std::io::Result<nalgebra::DMatrix<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.mat");
    std::fs::write(&path, bytes).unwrap();
    super::matrix(&path, &[name], 4096)
}

#[test]
fn sparse_matrices() {
    for file in SPARSE {
        let mass = matrix(file, "M").unwrap();
        assert_eq!((mass.nrows(), mass.ncols(), mass[(0, 0)], mass[(1, 2)], mass[(4, 4)]), (5, 5, 2.25, 0.0, 6.0));
        assert!((mass[(0, 1)] - 0.75).abs() < 1e-15 && mass.transpose() == mass);
        let gyroscopic = matrix(file, "G").unwrap();
        assert!((gyroscopic[(2, 0)] + 0.15).abs() < 1e-15 && (gyroscopic[(0, 2)] - 0.15).abs() < 1e-15);
        assert!(matrix(file, "K").unwrap().iter().all(|x| *x == 0.0));
        assert_eq!(matrix(file, "F").unwrap().shape(), (5, 1));
        assert!(matrix(file, "B").unwrap_err().to_string().contains("no matrix B among its variables: K, M, G, C, F"));
    }
}

/// A part of a file is an error, or the matrix where it is within the part; a changed byte is either too, and never a panic.
#[test]
fn sparse_matrices_cut_short_and_damaged() {
    for file in SPARSE {
        let mass = matrix(file, "M").unwrap();
        for length in 0..file.len() {
            if let Ok(found) = matrix(&file[..length], "M") {
                assert_eq!(found, mass, "{length} bytes");
            }
        }
        for at in 128..file.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut damaged = file.to_vec();
                damaged[at] = value;
                drop(matrix(&damaged, "M"));
            }
        }
    }
}

#[test]
fn a_sparse_matrix_beyond_all_bounds() {
    let int = |numbers: &[i32]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let sparse = |size: [i32; 2], rows: &[i32], firsts: &[i32], values: &[u8]| {
        let parts = [
            element(6, &[5, 0, 0, 0, 4, 0, 0, 0]),
            element(5, &int(&size)),
            element(1, b"M"),
            element(5, &int(rows)),
            element(5, &int(firsts)),
            // Small numbers are stored in few bytes.
            element(2, values),
        ];
        mat(&[element(14, &parts.concat())])
    };
    let good = matrix(&sparse([2, 2], &[0, 1], &[0, 1, 2], &[3, 4]), "M").unwrap();
    assert_eq!(good.as_slice(), [3.0, 0.0, 0.0, 4.0]);
    for (size, rows, firsts, values, said) in [
        ([1 << 30, 1 << 30], &[0, 1][..], &[0, 1, 2][..], &[3, 4][..], "1073741824 x 1073741824, more than 4096"),
        ([2, 2], &[0, 2], &[0, 1, 2], &[3, 4], "with an element outside"),
        ([2, 2], &[0, -1], &[0, 1, 2], &[3, 4], "with an element outside"),
        ([2, 2], &[0, 1], &[0, 1, 3], &[3, 4], "with an element outside"),
        ([2, 2], &[0, 1], &[0, 2, 1], &[3, 4], "with an element outside"),
        ([2, 2], &[0, 1], &[0, 1], &[3, 4], "with an element outside"),
        ([2, 2], &[0, 1], &[0, 1, 2], &[3], "with an element outside"),
    ] {
        let error = matrix(&sparse(size, rows, firsts, values), "M").unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}
