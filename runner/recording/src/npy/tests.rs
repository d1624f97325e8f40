use crate::Reader;
use crate::harness::{cut_short, damaged, error, recording, values};
use ballrace_scene::{FileLayout, Orientation, Recording};

/// A file with this description of its numbers.
fn npy(description: &str, order: &str, shape: &str, numbers: &[u8]) -> Vec<u8> {
    let text = format!("{{'descr': {description}, 'fortran_order': {order}, 'shape': {shape}, }}");
    let text = format!("{text:117}\n");
    [b"\x93NUMPY\x01\0".as_slice(), &(text.len() as u16).to_le_bytes(), text.as_bytes(), numbers].concat()
}

fn doubles(count: u16) -> Vec<u8> {
    (0..count).flat_map(|i| (f64::from(i) * 0.1).to_le_bytes()).collect()
}

#[test]
fn arrays_in_both_orders() {
    let rows = values(&npy("'<f8'", "False", "(20, 3)", &doubles(60)), &["c2", "c0"]);
    assert_eq!((rows.len(), rows[4].as_slice()), (20, [14.0 * 0.1, 12.0 * 0.1].as_slice()));
    let rows = values(&npy("'<f8'", "True", "(20, 3)", &doubles(60)), &["c2", "c0"]);
    assert_eq!((rows.len(), rows[4].as_slice()), (20, [44.0 * 0.1, 4.0 * 0.1].as_slice()));
    assert_eq!(values(&npy("'<f8'", "False", "(2,)", &doubles(2)), &["c0"]), [[0.0], [0.1]]);
    // More than a block of each.
    let long = values(&npy("'<f8'", "True", "(20000, 2)", &doubles(40_000)), &["c0", "c1"]);
    assert!(long.iter().zip(0_u16..).all(|(row, i)| *row == [f64::from(i) * 0.1, f64::from(i + 20_000) * 0.1]));
}

#[test]
fn every_type_of_number() {
    let one = |kind: &str, bytes: &[u8]| values(&npy(kind, "False", "(1,)", bytes), &["c0"])[0][0];
    assert_eq!(one("'>f8'", &(-0.3_f64).to_be_bytes()), -0.3);
    for (bits, value) in [(0x3c01_u16, 1.0 + 1.0 / 1024.0), (0xc000, -2.0), (1, 2.0_f64.powi(-24)), (0x7bff, 65_504.0)]
    {
        assert_eq!(one("'<f2'", &bits.to_le_bytes()), value);
    }
    assert_eq!(one("'<f4'", &0.3_f32.to_le_bytes()), f64::from(0.3_f32));
    assert_eq!(one("'>f4'", &0.3_f32.to_be_bytes()), f64::from(0.3_f32));
    assert_eq!(one("'|i1'", &[0xfe]), -2.0);
    assert_eq!(one("'|u1'", &[0xfe]), 254.0);
    assert_eq!(one("'>i2'", &(-300_i16).to_be_bytes()), -300.0);
    assert_eq!(one("'<u2'", &60_000_u16.to_le_bytes()), 60_000.0);
    assert_eq!(one("'<i4'", &(-70_000_i32).to_le_bytes()), -70_000.0);
    assert_eq!(one("'>u4'", &u32::MAX.to_be_bytes()), f64::from(u32::MAX));
    assert_eq!(one("'<i8'", &(-5_i64).to_le_bytes()), -5.0);
    assert_eq!(one("'<u8'", &u64::MAX.to_le_bytes()), u64::MAX as f64);
}

fn structured() -> Vec<u8> {
    let row = |i: u16| [f64::from(i).to_le_bytes().as_slice(), b"noted", &(-0.5 * f32::from(i)).to_be_bytes()].concat();
    let numbers: Vec<u8> = (0..30).flat_map(row).collect();
    npy("[('x', '<f8'), ('note', '|S5'), ('y', '>f4')]", "False", "(30,)", &numbers)
}

#[test]
fn structures_give_names() {
    assert_eq!(values(&structured(), &["y", "x"])[3], [-1.5, 3.0]);
    let said = error(&structured(), &recording(&["note"]));
    assert!(said.starts_with(": unreadable file: `note`: is of type |S5, expected an NPY file"), "{said}");
    let absent = error(&structured(), &recording(&["Y"]));
    assert_eq!(absent, ": no such column: `Y` (did you mean `y`?), expected one of `x`, `note`, `y`");
}

#[test]
fn files_that_are_no_table_are_rejected() {
    let refused =
        |description: &str, shape: &str| error(&npy(description, "False", shape, &[0; 64]), &recording(&["c0"]));
    assert!(refused("'<c16'", "(4,)").contains("numbers of type <c16"));
    assert!(refused("'<f8'", "(2, 2, 2)").contains("an array of 3 dimensions"));
    assert!(refused("'<f8'", "(9,)").contains("a truncated file: `c0` extends beyond its 192 bytes"));
    assert!(refused("'<f8'", "(4611686018427387904, 3)").contains("a truncated file"));
    assert!(refused("'<f8'", "(0,)").contains("0 in `c0`"));
    assert!(refused("'<f8'", "(70, 1000000000)").contains("1000000000 columns"));
    assert!(refused("[[[[[[[['<f8']]]]]]]]", "(9,)").contains("a structure within a structure"));
}

#[test]
fn channels_in_rows() {
    // Two channels of 1200 samples, in both orders of storage.
    let file = npy("'<f8'", "False", "(2, 1200)", &doubles(2400));
    let rows = values(&file, &["c1", "c0"]);
    assert_eq!((rows.len(), rows[3].as_slice()), (1200, [1203.0 * 0.1, 3.0 * 0.1].as_slice()));
    let file_f = npy("'<f8'", "True", "(2, 1200)", &doubles(2400));
    assert_eq!(values(&file_f, &["c1", "c0"])[3], [7.0 * 0.1, 6.0 * 0.1]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.npy");
    let with = |bytes: &[u8], orientation| {
        std::fs::write(&path, bytes).unwrap();
        let layout = FileLayout { orientation, ..FileLayout::default() };
        let reader = Reader::open(&path, &Recording { layout, ..recording(&["c1"]) }).unwrap();
        (reader.columns().len(), reader.notes())
    };
    let (columns, notes) = with(&file, None);
    assert_eq!(columns, 2);
    assert_eq!(
        notes,
        ["The array of 2 x 1200 is read as 2 channels, as it has fewer than 64 rows and more than 1000 columns; \
          `orientation` in [recording] states it."]
    );
    assert_eq!(with(&file, Some(Orientation::ChannelsFirst)), (2, vec![]));
    assert_eq!(with(&file, Some(Orientation::SamplesFirst)), (1200, vec![]));
    let long = npy("'|u1'", "False", "(2, 70000)", &[0; 140_000]);
    std::fs::write(&path, long).unwrap();
    let layout = FileLayout { orientation: Some(Orientation::SamplesFirst), ..FileLayout::default() };
    let error = Reader::open(&path, &Recording { layout, ..recording(&["c1"]) }).err().unwrap().to_string();
    assert!(error.contains("70000 columns") && error.contains("orientation = \"channels-first\""), "{error}");
    let few = npy("'<f8'", "False", "(3, 20)", &doubles(60));
    assert_eq!(with(&few, None), (20, vec![]));
    assert_eq!(with(&few, Some(Orientation::ChannelsFirst)), (3, vec![]));
}

#[test]
fn orientation_is_for_arrays() {
    let layout = FileLayout { orientation: Some(Orientation::ChannelsFirst), ..FileLayout::default() };
    let of = Recording { layout, ..recording(&["x"]) };
    assert_eq!(
        error(b"x\n1\n", &of),
        ": [recording] orientation: misplaced key, expected `orientation` only for NPY and NPZ files"
    );
    let layout = FileLayout { is_headless: true, ..FileLayout::default() };
    let of = Recording { layout, ..recording(&["c0"]) };
    let said = error(&npy("'<f8'", "False", "(2,)", &doubles(2)), &of);
    assert_eq!(said, ": [recording] header: misplaced key, expected `header = false` only for text");
}

#[test]
fn short_and_damaged_files() {
    cut_short(&structured(), &["x", "y"], &[]);
    damaged(&structured(), &["x", "y"]);
    damaged(&npy("'<f8'", "True", "(20, 3)", &doubles(60)), &["c0", "c2"]);
}
