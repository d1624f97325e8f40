use crate::recording::Reader;
use crate::recording::harness::{cut_short, damaged, error, recording, values};
use crate::scene::{Clock, Recording};

/// Files that h5py wrote: group `rig` with `x` (contiguous), `y` (big-endian, chunks, deflate, shuffle, checksum), matrices `m`
/// (contiguous), `c` (the same in chunks) and `w` (transposed), numbers `rate` and attribute `fs`. `v18` has 60 datasets in one
/// group, `latest` an index of chunks that is not read, `matlab` the form of MATLAB 7.3.
const EARLIEST: &[u8] = include_bytes!("earliest.h5");
const V18: &[u8] = include_bytes!("v18.h5");
const LATEST: &[u8] = include_bytes!("latest.h5");
const MATLAB: &[u8] = include_bytes!("matlab.mat");
/// Types of elements: floats of 16 bits, compound types, text; the filter LZF, three dimensions.
const TYPES: &[u8] = include_bytes!("types.h5");
/// `x` in deflated chunks that h5py wrote with libver="latest".
const CHUNKS_LATEST: &[u8] = include_bytes!("chunks-latest.h5");

#[test]
fn vectors_and_columns() {
    let rows = values(EARLIEST, &["/rig/x", "/rig/y", "rig/m[:,1]", "/rig/c[:,2]", "/rig/w[1,:]", "/rig/flag"]);
    assert_eq!(rows.len(), 40);
    for (i, row) in rows.iter().enumerate() {
        let t = i as f64;
        let expected = [t * 0.1, -3.0 * t, 3.0 * t + 1.0, 3.0 * t + 2.0, 3.0 * t + 1.0, 1.0 - t % 2.0];
        assert_eq!(row.as_slice(), expected, "{i}");
    }
}

#[test]
fn groups_of_many_members() {
    let rows = values(V18, &["/many/d00", "/many/d37", "/many/d59"]);
    assert_eq!(rows[2], [2.0, 39.0, 61.0]);
    let rows = values(V18, &["/rig/x"]);
    assert_eq!(rows[3], [3.0 * 0.1]);
}

#[test]
fn matlab_of_version_7_3() {
    let rows = values(MATLAB, &["bearing.gs", "m(:,2)", "w(2,:)", "N09.Y(3).Data", "cell{2}", "bearing(1).gs"]);
    assert_eq!(rows.len(), 40);
    for (i, row) in rows.iter().enumerate() {
        let t = i as f64;
        assert_eq!(row.as_slice(), [0.25 * t, 3.0 * t + 1.0, 40.0 + t, 3.0 * t, 2.0 * t, 0.25 * t], "{i}");
    }
    assert_eq!(
        error(MATLAB, &recording(&["bearing.g"])),
        ": no such column: `bearing.g` (did you mean `bearing.gs`?), expected one of `N09.Y(1).Data`, `N09.Y(2).Data`, \
         `N09.Y(3).Data`, `bearing.gs`, `cell{1}`, `cell{2}`, `m(:,1)`, `m(:,2)`, `m(:,3)`, `w(1,:)`, `w(2,:)`"
    );
}

#[test]
fn rate_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.bin");
    let cases = [
        (EARLIEST, "/rig/rate", "/rig/x", 48_000.0),
        (EARLIEST, "rig@fs", "/rig/x", 51_200.0),
        (MATLAB, "bearing.sr", "bearing.gs", 97_656.0),
    ];
    for (file, name, column, rate) in cases {
        std::fs::write(&path, file).unwrap();
        let clock = Clock::Number { name: name.into(), hertz: 1.0 };
        let of = Recording { clock, ..recording(&[column]) };
        assert_eq!(Reader::open(&path, &of).unwrap().rate(), rate);
    }
}

#[test]
fn other_content_is_refused() {
    assert!(error(b"\x89HDF\r\n\x1a\n", &recording(&["x"])).contains("a file that is truncated"));
    let older = [b"MATLAB 7.3 MAT-file".as_slice(), &[b' '; 800]].concat();
    assert!(error(&older, &recording(&["x"])).contains("no HDF5 file"));
    assert!(error(LATEST, &recording(&["x"])).contains("`/x`: a chunk index of layout version 4 (extensible array, "));
    assert_eq!(error(LATEST, &recording(&["z"])), ": no such column: `z`, expected one of `/y`");
    assert_eq!(values(LATEST, &["/y"])[7], [7.0]);
}

#[test]
fn half_floats_and_compound_types() {
    let columns =
        ["/half", "rig/table.t", "rig/table.DE", "/rig/table.on", "/rig/table.NDE", "rig/plain.t", "rig/plain.NDE"];
    let rows = values(TYPES, &columns);
    assert_eq!(rows.len(), 40);
    for (row, i) in rows.iter().zip(0_u16..) {
        let t = f64::from(i) * 0.1;
        assert!((row[0] - t).abs() <= 1e-3 * t, "{row:?}");
        let (narrow, count) = (-f64::from(t as f32), 3.0 * f64::from(i));
        assert_eq!(row[1..], [t, narrow, f64::from(i % 2), count, t, count]);
    }
}

#[test]
fn data_that_cannot_be_read_are_named() {
    for (column, said) in [
        ("lzf", "`/lzf`: compressed by the filter LZF"),
        ("/cube", "`/cube`: an array of 3 dimensions"),
        ("/cube[:,0]", "`/cube`: an array of 3 dimensions"),
        ("text", "`/text`: text"),
        ("rig/table.note", "`/rig/table.note`: text"),
        ("/rig/table.pair", "`/rig/table.pair`: arrays as elements"),
    ] {
        let found = error(TYPES, &recording(&[column]));
        assert!(found.starts_with(&format!(": unreadable file: {said}, expected an HDF5 file with")), "{found}");
    }
    let found = error(CHUNKS_LATEST, &recording(&["/x"]));
    assert!(
        found.contains("`/x`: a chunk index of layout version ") && found.contains("(extensible array, "),
        "{found}"
    );
}

#[test]
fn short_files() {
    cut_short(EARLIEST, &["/rig/x", "/rig/y"], &(2000..EARLIEST.len()).collect::<Vec<_>>());
    cut_short(MATLAB, &["bearing.gs"], &(2000..MATLAB.len()).collect::<Vec<_>>());
}

#[test]
fn damaged_files() {
    damaged(EARLIEST, &["/rig/x", "/rig/y", "/rig/c[:,1]", "/rig/w[1,:]"]);
    damaged(V18, &["/many/d00", "/many/d59"]);
    damaged(MATLAB, &["bearing.gs", "m(:,2)", "N09.Y(3).Data", "cell{2}"]);
    damaged(LATEST, &["/y"]);
    damaged(TYPES, &["/half", "rig/table.DE", "rig/plain.NDE"]);
}
