use super::*;
use crate::flaws::{Flaw, FlawSummary};
use crate::harness::{read_file, recording};
use ballrace_scene::Clock;

#[test]
fn frames_of_a_wrong_size_or_checksum_are_rejected() {
    for has_checksum in [false, true] {
        let probes = vec![[1e-6, 0.0], [1e-6, 2e-6]];
        let layout = FrameLayout { probes, sensors: 2, rotation: Some(1.0), has_checksum };
        let mut frame = 7_u32.to_le_bytes().to_vec();
        for value in [1.5_f32, f32::INFINITY, 0.25, f32::NAN, 1.0] {
            frame.extend(value.to_le_bytes());
        }
        if has_checksum {
            frame.extend(crc32fast::hash(&frame).to_le_bytes());
        }
        let mut row = Row::default();
        assert_eq!(layout.read(&frame, &mut row), Some(7));
        assert_eq!((row.probes[0], row.rotation), (1.5e-6, 1.0));
        assert!(row.probes[1].is_nan() && row.sensors[0] == 0.25 && row.sensors[1].is_nan());
        for size in 0..frame.len() {
            assert_eq!(layout.read(&frame[..size], &mut row), None);
        }
        for byte in 0..if has_checksum { frame.len() } else { 0 } {
            let mut wrong = frame.clone();
            wrong[byte] ^= 1;
            assert_eq!(layout.read(&wrong, &mut row), None);
        }
    }
}

fn readings(i: u32) -> [f32; 2] {
    let x = (i % 64) as f32;
    [x * 1.1e-6, x * x * 1.3e-7]
}

/// A log of the device.
fn logged(numbers: impl IntoIterator<Item = u32>) -> Vec<u8> {
    let frame = |i: u32| ballrace::log::frame::<2, 16>(i, &readings(i));
    numbers.into_iter().flat_map(frame).collect()
}

fn read(bytes: &[u8]) -> Result<(Vec<Row>, Vec<FlawSummary>), RecordingError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.frames");
    std::fs::write(&path, bytes).unwrap();
    read_file(&path, &recording(&["x", "y"]))
}

fn kinds(flaws: &[FlawSummary]) -> Vec<(Flaw, u64, u64, f64)> {
    flaws.iter().map(|flaw| (flaw.kind, flaw.count, flaw.samples_affected, flaw.first_time_s)).collect()
}

/// The numbers of the device are those of the desktop, bit for bit; the count wraps.
#[test]
fn a_log_of_the_kernel_is_a_recording() {
    let (rows, flaws) = read(&logged((0..100).map(|i| (u32::MAX - 50).wrapping_add(i)))).unwrap();
    assert_eq!((rows.len(), flaws), (100, vec![]));
    for (i, row) in rows.iter().enumerate() {
        let [x, y] = readings((u32::MAX - 50).wrapping_add(i as u32));
        assert_eq!((row.index, row.line, row.time), (i as u64, i as u64 + 1, i as f64 / 1000.0));
        let bits = |x: f64| (x as f32).to_bits();
        assert_eq!(bits(row.probes[0]), x.to_bits());
        assert_eq!(bits(row.probes[1]), y.to_bits());
    }
}

#[test]
fn gaps_and_damage_are_counted_with_their_place() {
    let (rows, flaws) = read(&logged((0..10).chain(15..30))).unwrap();
    assert_eq!((rows.len(), rows[10].index, rows[24].index), (25, 15, 29));
    assert_eq!(kinds(&flaws), [(Flaw::Gap, 1, 5, 0.015)]);

    let mut bytes = logged(0..30);
    bytes[16 * 20 + 5] ^= 1;
    let (rows, flaws) = read(&bytes).unwrap();
    assert_eq!((rows.len(), rows[20].index), (29, 21));
    assert_eq!(kinds(&flaws), [(Flaw::DamagedFrame, 1, 1, 0.021), (Flaw::Gap, 1, 1, 0.021)]);
    assert_eq!(flaws[0].sentence, "1 damaged frame omitted, at line 21 (0.021000 s)");

    // Bytes that are too many, and a frame that the end of the file cuts.
    let mut bytes = logged(0..10);
    bytes.extend([7; 5]);
    bytes.extend(logged(10..20));
    let (rows, flaws) = read(&bytes[..bytes.len() - 3]).unwrap();
    assert_eq!(rows.len(), 19);
    assert_eq!(kinds(&flaws), [(Flaw::DamagedFrame, 2, 2, 0.01)]);
}

#[test]
fn a_file_that_is_no_log_of_the_scene_is_refused() {
    let message = |bytes: &[u8]| read(bytes).unwrap_err().to_string();
    let other: Vec<u8> = (0..9).flat_map(|i| ballrace::log::frame::<3, 20>(i, &[0.0; 3])).collect();
    assert!(
        message(&other).contains("no frame of 16 bytes with the right checksum in 180 bytes"),
        "{}",
        message(&other)
    );
    assert!(message(&[]).contains("in 0 bytes"));
    let anew = message(&logged((0..10).chain(3..6)));
    assert!(anew.contains("the sequence number 3 after 9 in the frame at byte 160"), "{anew}");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.frames");
    std::fs::write(&path, logged(0..9)).unwrap();
    let mut of_time = recording(&["x", "y"]);
    of_time.clock = Clock::column("t");
    assert!(read_file(&path, &of_time).is_err(), "no column of times");
    let of_nothing = crate::preview::preview(&path).unwrap_err().to_string();
    assert!(of_nothing.contains("frames, which have no names of columns"), "{of_nothing}");
}
