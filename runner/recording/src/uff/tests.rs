use crate::Reader;
use crate::harness::{cut_short, damaged, error, recording, values};
use crate::preview::preview;
use ballrace_scene::{Clock, Recording};

/// Files as pyuff writes them: `DE X` (1X+), `DE Y` (1Y-) in um and `KPH` without a node in V, 50 values at 1 kHz, in text of double
/// and single precision and in binary.
const TEXT: &[u8] = include_bytes!("text.uff");
const SINGLE: &[u8] = include_bytes!("single.uff");
const BINARY: &[u8] = include_bytes!("binary.uff");

fn recorded(columns: &[&str]) -> Recording {
    let mut of = Recording { clock: Clock::Stated, ..recording(columns) };
    of.probes.iter_mut().for_each(|probe| probe.metres_per_unit = 1e-6);
    of
}

/// The text without units, as the harness reads metres.
fn without_unit(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for at in 0..bytes.len().saturating_sub(3) {
        if bytes[at..].starts_with(b" um ") {
            bytes[at + 1..at + 3].copy_from_slice(b"  ");
        }
    }
    bytes
}

/// The binary file with the other byte order.
fn swapped() -> Vec<u8> {
    let mut bytes = BINARY.to_vec();
    let mut at = 0;
    while let Some(head) = bytes[at..].windows(7).position(|w| w == b"    58b") {
        at += head;
        bytes[at + 7..at + 13].copy_from_slice(b"     2");
        let lines = bytes[at..].iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(place, _)| place);
        at += lines.take(12).last().unwrap() + 1;
        bytes[at..at + 400].chunks_exact_mut(8).for_each(<[u8]>::reverse);
    }
    bytes
}

#[test]
fn time_responses() {
    for file in [TEXT, SINGLE, BINARY, &swapped()] {
        let rows = values(&without_unit(file), &["1X+", "1Y-", "KPH"]);
        assert_eq!((rows.len(), rows[20].as_slice()), (50, [5.0, -10.0, 5.0].as_slice()));
        assert_eq!(values(&without_unit(file), &["DE Y"])[7], [-3.5]);
        assert_eq!(
            error(file, &recording(&["1X+"])),
            ": column 1X+: unit differs from the scene's: `um`, expected `m` or no unit"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.unv");
    std::fs::write(&path, TEXT).unwrap();
    assert!((Reader::open(&path, &recorded(&["1X+"])).unwrap().rate() - 1000.0).abs() < 1e-6);
    let found = preview(&path).unwrap();
    assert_eq!(found.columns.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["1X+", "1Y-", "KPH"]);
}

/// Columns of a line count characters, whatever their bytes.
#[test]
fn labels_in_utf_8_and_latin_1() {
    let text = String::from_utf8(without_unit(TEXT)).unwrap();
    let utf_8 = text.replacen("DE X", "D\u{c9} X", 1).replacen("NONE ", "\u{b5}ber ", 1);
    let latin_1: Vec<u8> = utf_8.chars().map(|letter| letter as u8).collect();
    for file in [utf_8.as_bytes(), &latin_1] {
        assert_eq!(values(file, &["D\u{c9} X"]), values(text.as_bytes(), &["DE X"]));
    }
}

#[test]
fn other_data_sets_are_refused() {
    let text = String::from_utf8(without_unit(TEXT)).unwrap();
    for (from, to, said) in [
        ("    58 ", "   151 ", "no data set 58"),
        ("    1         0    0", "    4         0    0", "functions of type 4, no time response"),
        ("         4        50         1", "         6        50         1", "a time response with complex values"),
        ("         4        50         1", "         4        50         0", "a time response with an uneven spacing"),
        ("  1.00000e-03", "  0.00000e+00", "a time response with the spacing `0.00000e+00`"),
        ("         4        50", "         4        51", "values in"),
        ("         4        50", "         49999999999", "9999999999 values"),
        ("    1         0    0", "    x         0    0", "`x` in data set 58"),
    ] {
        let changed = text.replace(from, to);
        let message = error(changed.as_bytes(), &recording(&["1X+"]));
        assert!(message.contains(said), "{to}: {message}");
    }
}

#[test]
fn short_and_damaged_files() {
    for file in [TEXT, BINARY, &swapped()] {
        let file = without_unit(file);
        // Between two data sets a file of fewer of them ends.
        let ends: Vec<usize> =
            (0..file.len()).filter(|end| file[..*end].trim_ascii_end().ends_with(b"-1") && *end > 1000).collect();
        cut_short(&file, &["1X+"], &ends);
        damaged(&file, &["1X+", "KPH"]);
    }
}
