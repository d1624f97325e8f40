use crate::recording::harness::{cut_short, damaged, error, recording, values};

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
fn what_is_no_table_is_refused() {
    let refused =
        |description: &str, shape: &str| error(&npy(description, "False", shape, &[0; 64]), &recording(&["c0"]));
    assert!(refused("'<c16'", "(4,)").contains("numbers of type <c16"));
    assert!(refused("'<f8'", "(2, 2, 2)").contains("an array of 3 dimensions"));
    assert!(refused("'<f8'", "(9,)").contains("a truncated file: `c0` extends beyond its 192 bytes"));
    assert!(refused("'<f8'", "(4611686018427387904, 3)").contains("a truncated file"));
    assert!(refused("'<f8'", "(0,)").contains("0 in `c0`"));
    assert!(refused("'<f8'", "(1, 1000000000)").contains("1000000000 columns"));
    assert!(refused("[[[[[[[['<f8']]]]]]]]", "(9,)").contains("a structure within a structure"));
}

#[test]
fn short_and_damaged_files() {
    cut_short(&structured(), &["x", "y"], &[]);
    damaged(&structured(), &["x", "y"]);
    damaged(&npy("'<f8'", "True", "(20, 3)", &doubles(60)), &["c0", "c2"]);
}
