use std::io::Read;

use crate::Reader;
use crate::harness::{cut_short, damaged, error, recording, values};
use ballrace_scene::{Clock, Recording};

/// Files that h5py wrote: group `rig` with `x` (contiguous), `y` (big-endian, chunks, deflate, shuffle, checksum), matrices `m`
/// (contiguous), `c` (the same in chunks) and `w` (transposed), numbers `rate` and attribute `fs`. `v18` has 60 datasets in one
/// group, `latest` an extensible array of chunks, `matlab` the form of MATLAB 7.3.
const EARLIEST: &[u8] = include_bytes!("earliest.h5");
const V18: &[u8] = include_bytes!("v18.h5");
const LATEST: &[u8] = include_bytes!("latest.h5");
const MATLAB: &[u8] = include_bytes!("matlab.mat");
/// Types of elements: floats of 16 bits, compound types, text; the filter LZF, three dimensions.
const TYPES: &[u8] = include_bytes!("types.h5");
/// `x` in deflated chunks that h5py wrote with libver="latest".
const CHUNKS_LATEST: &[u8] = include_bytes!("chunks-latest.h5");
/// Every index of chunks, as h5py 3.16 writes it with libver="v110" (data layouts of version 4) and "latest" (version 5), by gzip.
const INDICES: [&[u8]; 2] = [include_bytes!("indices-v110.h5.gz"), include_bytes!("indices-v200.h5.gz")];

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
    assert_eq!(error(LATEST, &recording(&["z"])), ": no such column: `z`, expected one of `/x`, `/y`");
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
}

#[test]
fn every_index_of_chunks() {
    for file in INDICES {
        let columns = [
            "/single",
            "/single_deflate",
            "/implicit",
            "/edges",
            "/gaps",
            "/extensible_deflate",
            "/fixed[:,0]",
            "/fixed[:,2]",
            "/fixed_grows[:,1]",
            "/fixed_grows[:,2]",
            "/wide[0,:]",
            "/wide[2,:]",
            "/tree[:,0]",
            "/tree[:,2]",
            "/tree_deflate[:,1]",
        ];
        let rows = values(file, &columns);
        assert_eq!(rows.len(), 40);
        for (row, i) in rows.iter().zip(0_u8..) {
            let t = f64::from(i);
            let gaps = if i == 5 { 7.0 } else { 0.0 };
            let first = [0.5 * t, 0.25 * t, t - 5.0, 3.0 * t, gaps, 0.125 * t];
            let fixed = [3.0 * t, 3.0 * t + 2.0, 3.0 * t + 1.0, 3.0 * t + 2.0];
            let others = [t, 80.0 + t, 3.0 * t, 3.0 * t + 2.0, 3.0 * t + 1.0];
            assert_eq!(row.as_slice(), [first.as_slice(), &fixed, &others].concat(), "{i}");
        }
        // 2000 chunks of one element: pages of a fixed array, super blocks of an extensible one.
        let rows = values(file, &["/pages", "/extensible"]);
        assert_eq!(rows.len(), 2000);
        for (row, i) in rows.iter().zip(0_u16..) {
            assert_eq!(row.as_slice(), [f64::from(i % 117); 2], "{i}");
        }
        let rows = values(file, &["/implicit_grows[:,0]", "/implicit_grows[:,2]"]);
        assert_eq!(rows.len(), 10);
        for (row, i) in rows.iter().zip(0_u8..) {
            assert_eq!(row.as_slice(), [3.0 * f64::from(i), 3.0 * f64::from(i) + 2.0], "{i}");
        }
    }
    assert_eq!(values(LATEST, &["/x", "/y"])[7][1], 7.0);
    assert!(values(CHUNKS_LATEST, &["/x"]).len() > 1);
}

#[test]
fn damaged_indices_of_chunks() {
    let columns: [&[&str]; 2] = [
        &["/single_deflate", "/implicit", "/edges", "/fixed[:,1]", "/gaps", "/extensible_deflate", "/wide[1,:]"],
        &["/tree[:,1]", "/tree_deflate[:,1]", "/fixed_grows[:,1]"],
    ];
    for (file, columns) in INDICES.into_iter().zip(columns) {
        let mut plain = Vec::new();
        flate2::read::GzDecoder::new(file).read_to_end(&mut plain).unwrap();
        damaged(&plain, columns);
    }
    cut_short(CHUNKS_LATEST, &["/x"], &[]);
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
