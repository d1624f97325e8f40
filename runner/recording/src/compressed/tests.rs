use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::harness::{Trial, cut_short, damaged, error, read_file, recording, values};

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn text() -> Vec<u8> {
    let rows: String = (0..300).map(|i| format!("{},{}\n", 0.1 * f64::from(i), -i)).collect();
    format!("x,y\n{rows}").into_bytes()
}

fn npy() -> Vec<u8> {
    let head = format!("{:117}\n", "{'descr': '<f8', 'fortran_order': False, 'shape': (50, 2), }");
    let numbers = (0..100).flat_map(|i| f64::from(i).to_le_bytes()).collect::<Vec<_>>();
    [b"\x93NUMPY\x01\0".as_slice(), &(head.len() as u16).to_le_bytes(), head.as_bytes(), &numbers].concat()
}

#[test]
fn text_and_binary_formats() {
    let (rows, flaws) = Trial::new().read(&gzip(&text()), &recording(&["y", "x"])).unwrap();
    assert!(flaws.is_empty());
    assert_eq!((rows.len(), rows[3].probes.as_slice()), (300, [-3.0, 0.1 * 3.0].as_slice()));
    // Members one after the other, as loggers append them.
    let members = [gzip(b"x\n1\n"), gzip(b"2\n3\n")].concat();
    assert_eq!(Trial::new().read(&members, &recording(&["x"])).unwrap().0.len(), 3);
    assert_eq!(values(&gzip(&npy()), &["c1"])[7], [15.0]);
    // An extension before that of the compression identifies the format too.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.npy.gz");
    std::fs::write(&path, gzip(b"no array")).unwrap();
    assert!(read_file(&path, &recording(&["c0"])).unwrap_err().to_string().contains("NPY file"));
}

#[cfg(feature = "zstd")]
#[test]
fn zstandard() {
    let packed = |bytes: &[u8]| zstd::encode_all(bytes, 3).unwrap();
    assert_eq!(Trial::new().read(&packed(&text()), &recording(&["y"])).unwrap().0.len(), 300);
    assert_eq!(values(&packed(&npy()), &["c1"])[7], [15.0]);
    let file = packed(&npy());
    cut_short(&file, &["c0"], &[]);
    damaged(&file, &["c0", "c1"]);
    damaged(&packed(&text()), &["x"]);
}

#[test]
fn short_and_damaged_files() {
    let file = gzip(&npy());
    cut_short(&file, &["c0"], &[]);
    damaged(&file, &["c0", "c1"]);
    let file = gzip(&text());
    cut_short(&file, &["x"], &[]);
    damaged(&file, &["x", "y"]);
    assert!(error(&gzip(&npy())[..40], &recording(&["c0"])).contains("a compressed file that is truncated"));
}

#[test]
fn the_unpacked_size_is_bounded() {
    let sizes = [0, 1 << 20, 1 << 24, 1 << 30].map(super::largest);
    assert_eq!(sizes, [1 << 30, 1 << 30, 100 << 24, 8 << 30]);
    let copied = |bytes: u64, most: u64| {
        let mut file = tempfile::tempfile().unwrap();
        let found = super::copied(std::io::Read::take(std::io::repeat(0), bytes), &mut file, most).unwrap();
        (found, file.metadata().unwrap().len())
    };
    assert_eq!(copied(1000, 1000), (None, 1000));
    assert_eq!(copied(40 << 20, 40 << 20), (None, 40 << 20));
    let (found, written) = copied(u64::MAX, 40 << 20);
    assert!(found.is_some_and(|found| found.contains("more than 41943040 bytes")) && written <= (40 << 20) + 1);
    let file = tempfile::tempfile().unwrap();
    assert_eq!(super::lacks_space(&file, 1, 0).unwrap(), None);
    #[cfg(unix)]
    assert!(super::lacks_space(&file, 1 << 62, 0).unwrap().is_some_and(|found| found.contains("free space")));
}
