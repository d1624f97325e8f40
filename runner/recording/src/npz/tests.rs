use crate::Reader;
use crate::harness::{cut_short, damaged, error, recording, values};
use ballrace_scene::{Clock, Recording};

/// Files that `numpy.savez` and `numpy.savez_compressed` wrote: vector `x`, matrix `m` (50 x 3), number `rate`; `wide` (2 x 1200)
/// in the first, the structure `s` in the second.
const STORED: &[u8] = include_bytes!("stored.npz");
const PACKED: &[u8] = include_bytes!("packed.npz");

#[test]
fn arrays_by_their_names() {
    for file in [STORED, PACKED] {
        let rows = values(file, &["x", "m[:,2]"]);
        assert_eq!((rows.len(), rows[7].as_slice()), (50, [0.1 * 7.0, 23.0].as_slice()));
    }
    assert_eq!(values(STORED, &["wide[1,:]"])[5], [1205.0]);
    assert_eq!(values(PACKED, &["s.u", "s.v"])[5], [0.0, 0.0]);
    assert!(
        error(STORED, &recording(&["m"])).contains("expected one of `x`, `m[:,0]`, `m[:,1]`, `m[:,2]`, `wide[0,:]`")
    );
    assert!(error(STORED, &recording(&["x", "wide[0,:]"])).contains("50 in `x`, 1200 in `wide[0,:]`"));
}

#[test]
fn rate_and_notes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.npz");
    for file in [STORED, PACKED] {
        std::fs::write(&path, file).unwrap();
        let clock = Clock::Number { name: "rate".into(), hertz: 1.0 };
        let reader = Reader::open(&path, &Recording { clock, ..recording(&["x"]) }).unwrap();
        assert_eq!(reader.rate(), 25_600.0);
        let notes = reader.notes();
        assert!(file != STORED || notes[0].starts_with("Array wide of 2 x 1200 is read as 2 channels"), "{notes:?}");
    }
}

#[test]
fn short_and_damaged_files() {
    for file in [STORED, PACKED] {
        cut_short(file, &["x"], &[]);
        damaged(file, &["x", "m[:,1]"]);
    }
    assert!(error(&STORED[..3000], &recording(&["x"])).contains("an archive without its directory"));
}

/// An archive whose directory announces more than may be unpacked is refused before anything is written.
#[test]
fn the_unpacked_size_is_bounded() {
    let mut bytes = PACKED.to_vec();
    let entry = bytes.windows(4).position(|bytes| bytes == b"PK\x01\x02").unwrap();
    bytes[entry + 24..entry + 28].copy_from_slice(&(3_u32 << 30).to_le_bytes());
    let found = error(&bytes, &recording(&["x"]));
    assert!(found.contains("bytes when unpacked, more than 1073741824"), "{found}");
}
