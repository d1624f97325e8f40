use crate::harness::{Trial, cut_short, damaged, error, recording, values};
use ballrace_scene::Clock;

/// A file with these samples, frame by frame.
fn wav(tag: u16, bits: u16, channels: u16, samples: &[u8]) -> Vec<u8> {
    let frame = channels * bits / 8;
    let mut format = [tag.to_le_bytes(), channels.to_le_bytes()].concat();
    format.extend(1000_u32.to_le_bytes());
    format.extend((1000 * u32::from(frame)).to_le_bytes());
    format.extend([frame.to_le_bytes(), bits.to_le_bytes()].concat());
    let chunk = |name: &[u8], bytes: &[u8]| {
        let mut out = [name, &(bytes.len() as u32).to_le_bytes(), bytes].concat();
        out.resize(out.len().next_multiple_of(2), 0);
        out
    };
    let body = [b"WAVE".to_vec(), chunk(b"LIST", b"odd"), chunk(b"fmt ", &format), chunk(b"data", samples)].concat();
    chunk(b"RIFF", &body)
}

fn floats(rows: u16) -> Vec<u8> {
    let samples: Vec<u8> = (0..2 * rows).flat_map(|i| (f32::from(i) * 0.1).to_le_bytes()).collect();
    wav(3, 32, 2, &samples)
}

#[test]
fn samples_are_exact() {
    let rows = values(&floats(40), &["c1", "c0"]);
    assert_eq!(rows.len(), 40);
    assert_eq!(rows[7], [f64::from(15.0_f32 * 0.1), f64::from(14.0_f32 * 0.1)]);
    let doubles: Vec<u8> = [0.1_f64, -0.7].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(values(&wav(3, 64, 1, &doubles), &["c0"]), [[0.1], [-0.7]]);
}

#[test]
fn integers_are_parts_of_full_scale() {
    assert_eq!(values(&wav(1, 8, 1, &[0, 128, 192, 255]), &["c0"]), [[-1.0], [0.0], [0.5], [127.0 / 128.0]]);
    let words: Vec<u8> = [i16::MIN, -1, 16384].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(values(&wav(1, 16, 1, &words), &["c0"]), [[-1.0], [-1.0 / 32768.0], [0.5]]);
    assert_eq!(values(&wav(1, 24, 1, &[0, 0, 0x80, 0, 0, 0x40]), &["c0"]), [[-1.0], [0.5]]);
    let long: Vec<u8> = [i32::MIN, 1 << 30].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(values(&wav(1, 32, 1, &long), &["c0"]), [[-1.0], [0.5]]);
}

/// The file with lengths and format in big-endian order; its samples are of two bytes.
fn rifx(samples: &[i16]) -> Vec<u8> {
    let chunk = |name: &[u8], bytes: &[u8]| [name, &(bytes.len() as u32).to_be_bytes(), bytes].concat();
    let words = |words: &[u16]| words.iter().flat_map(|word| word.to_be_bytes()).collect::<Vec<_>>();
    let rates: Vec<u8> = [1000_u32, 2000].iter().flat_map(|rate| rate.to_be_bytes()).collect();
    let format = [words(&[1, 1]), rates, words(&[2, 16])].concat();
    let samples: Vec<u8> = samples.iter().flat_map(|sample| sample.to_be_bytes()).collect();
    chunk(b"RIFX", &[b"WAVE".to_vec(), chunk(b"fmt ", &format), chunk(b"data", &samples)].concat())
}

/// The file with the lengths of 64 bits.
fn long(file: &[u8], name: &[u8]) -> Vec<u8> {
    let at = file.windows(4).position(|bytes| bytes == b"data").unwrap();
    let length = u64::from(u32::from_le_bytes(*file[at + 4..].first_chunk().unwrap()));
    let mut sizes = [b"ds64".as_slice(), &28_u32.to_le_bytes(), &(file.len() as u64 + 28).to_le_bytes()].concat();
    sizes.extend([&length.to_le_bytes(), &(length / 4).to_le_bytes(), [0; 4].as_slice()].concat());
    let unknown = u32::MAX.to_le_bytes();
    [name, &unknown, b"WAVE", &sizes, &file[12..at + 4], &unknown, &file[at + 8..]].concat()
}

#[test]
fn other_forms() {
    assert_eq!(values(&rifx(&[i16::MIN, -1, 16384]), &["c0"]), [[-1.0], [-1.0 / 32768.0], [0.5]]);
    for name in [b"RF64", b"BW64"] {
        assert_eq!(values(&long(&floats(40), name), &["c0", "c1"]), values(&floats(40), &["c0", "c1"]));
    }
}

#[test]
fn contradictions_of_the_scene_are_rejected() {
    assert_eq!(error(&floats(9), &recording(&["x"])), ": no such column: `x`, expected one of `c0`, `c1`");
    let mut other = recording(&["c0"]);
    other.clock = Clock::Rate(1002.0);
    let said = ": sampling rate differs from the scene's: 1000 Hz, expected 1002 Hz within 0.1 %";
    assert_eq!(error(&floats(9), &other), said);
    other.clock = Clock::Rate(1000.5);
    assert_eq!(values(&floats(9), &["c0"]).len(), 9);
    assert!(error(&wav(2, 4, 1, &[1; 8]), &recording(&["c0"])).contains("unreadable file: format 2 with 4 bits"));
    let (rows, flaws) = Trial::new().read(&wav(3, 32, 1, &f32::INFINITY.to_le_bytes()), &recording(&["c0"])).unwrap();
    assert!(rows[0].probes[0].is_nan() && flaws.len() == 1, "{flaws:?}");
    assert!(error(&wav(1, 16, 1, &[]), &recording(&["c0"])).contains("0 in `c0`"));
}

#[test]
fn short_and_damaged_files() {
    cut_short(&floats(40), &["c0", "c1"], &[]);
    damaged(&floats(40), &["c0", "c1"]);
}
