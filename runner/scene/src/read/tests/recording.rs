//! Accepted and rejected keys of `[recording]`.

use super::*;
use crate::{Clock, KeyphasorSignal, Orientation, PulseDetection, RotationSource, Slope};

#[test]
#[rustfmt::skip] // a table
fn recording_out_of_range() {
    let text = format!("{MINIMAL}{RECORDING}");
    let probe = "{ column = \"x\", unit = \"um\", station = 0, angle = 0 }";
    assert_refused(&text, &[
        ("file = \"a.csv\"", "", &["recording.file: missing key"]),
        ("file = \"a.csv\"", "file = 3", &["recording.file: invalid value: 3, expected the name of a file or a folder", "or a list of names"]),
        ("file = \"a.csv\"", "file = []", &["recording.file: invalid value: [], expected the name of a file or a folder"]),
        ("file = \"a.csv\"", "file = [\"a\", \"a\"]", &["recording.file: \"a\" twice, expected each file once"]),
        ("rate = 1000", "rate = 1\nsequence = \"joined\"", &["recording.sequence: invalid value: \"joined\", expected \"continuous\" or \"snapshots\""]),
        ("rate = 1000", "rate = 1\nsequence = \"snapshots\"", &["recording.sequence: misplaced key", "one row each in a table of `ballrace fleet`"]),
        ("rate = 1000", "", &["recording: neither rate nor time", "exactly one"]),
        ("rate = 1000", "rate = 1\ntime = \"t\"", &["recording.time: both rate and time"]),
        ("rate = 1000", "rate = \"1000 rpm\"", &["(a speed of rotation), expected a frequency"]),
        ("rate = 1000", "rate = 0", &["a frequency above 0"]),
        ("rate = 1000", "time = \"x\"", &["probes[0].column: repeated value: \"x\", expected a column of its own (time has this one)"]),
        ("rate = 1000", "time = 3", &["recording.time: invalid value: 3, expected the name of a column"]),
        (probe, "", &["recording.probes: invalid value: [], expected a list of at least one probe"]),
        (probe, &format!("{probe}, {probe}"), &["recording.probes[1].column", "a column of its own (a probe"]),
        (", unit = \"um\"", "", &["probes[0].unit: missing key", "the unit of the column: um, mil, mm or m, or V or mV"]),
        ("unit = \"um\"", "unit = \"rpm\"", &["invalid value: \"rpm\" (a speed of rotation), expected a unit of length"]),
        (", angle = 0", "", &["probes[0].angle: missing key", "or axial = true"]),
        (", angle = 0", ", axial = false", &["probes[0].angle: missing key"]),
        (", station = 0", "", &["probes[0].station: missing key"]),
        ("angle = 0", "angle = 0, axial = true", &["no angle with axial = true"]),
        ("angle = 0", "angle = 0, axial = 1", &["invalid value: 1, expected true or false"]),
        ("angle = 0", "angle = 0, noise = 0", &["noise", "a length above 0"]),
        ("unit = \"um\"", "unit = \"V\"", &["probes[0].sensitivity: missing key", "such as \"7.87 mV/um\""]),
        ("angle = 0", "angle = 0, sensitivity = \"8 mV/um\"", &["probes[0].sensitivity: misplaced key: \"8 mV/um\"", "unit = \"V\" or \"mV\"", "found \"um\""]),
        ("unit = \"um\"", "unit = \"V\", sensitivity = \"8 mV\"", &["invalid value: \"8 mV\" (a voltage), expected a voltage per length"]),
        ("unit = \"um\"", "unit = \"V\", sensitivity = \"8 um/V\"", &["a quantity in m V^-1"]),
        ("unit = \"um\"", "unit = \"V\", sensitivity = 0", &["invalid value: 0 (a bare number is in V/m)", "that is not 0"]),
        ("angle = 0", "angle = 0, offset = \"-9.5 V\"", &["probes[0].offset: invalid value: \"-9.5 V\" (a voltage), expected a length"]),
        ("unit = \"um\"", "unit = \"V\", sensitivity = \"8 mV/um\", offset = -9.5", &["probes[0].offset: invalid value: -9.5, expected a voltage or a length with its unit"]),
        ("unit = \"um\"", "unit = \"V\", sensitivity = \"8 mV/um\", offset = \"9 N\"", &["(a force), expected a voltage or a length"]),
        ("rate = 1000", "rate = 1\nkeyphasor = { column = \"k\", pulses_per_turn = 0 }", &["a whole number, 1 or more"]),
        ("rate = 1000", "rate = 1\nkeyphasor = { column = \"k\", pulses_per_turn = 4294967296 }", &["a whole number"]),
        ("rate = 1000", "rate = 1\nkeyphasor = { column = \"x\", pulses_per_turn = 1 }", &["a column of its own"]),
        ("rate = 1000", "rate = 1\nspeed = { column = \"n\", unit = \"Hz\" }", &["invalid value: \"Hz\" (a frequency)"]),
        ("rate = 1000", "rate = \"files\"", &["recording.rate: invalid value: \"files\"", "expected a frequency"]),
        (
            "rate = 1000",
            "rate = { column = \"fs\" }",
            &["recording.rate.unit: missing key, expected the unit of the column: Hz or kHz"],
        ),
        (
            "rate = 1000",
            "rate = { column = \"fs\", unit = \"rpm\" }",
            &["recording.rate.unit: invalid value: \"rpm\" (a speed of rotation), expected a unit of frequency: Hz or kHz"],
        ),
        (
            "rate = 1000",
            "rate = { unit = \"Hz\" }",
            &["recording.rate.column: missing key, expected the name of a single number of the recording"],
        ),
        (
            "rate = 1000",
            "rate = { column = \"x\", unit = \"Hz\" }",
            &["recording.probes[0].column: repeated value", "the rate has this one"],
        ),
        (
            "rate = 1000",
            "rate = 1\nkeyphasor = \"yes\"",
            &["recording.keyphasor: invalid value: \"yes\", expected \"synchronous\""],
        ),
        (
            "rate = 1000",
            "time = \"t\"\nkeyphasor = \"synchronous\"",
            &["recording.time: time beside keyphasor = \"synchronous\", expected rate = \"file\""],
        ),
        ("rate = 1000", "rate = 1\nheader = \"no\"", &["recording.header: invalid value: \"no\", expected true or false"]),
        (
            "rate = 1000",
            "rate = 1\norientation = \"rows\"",
            &["recording.orientation: invalid value: \"rows\", expected \"samples-first\" or \"channels-first\""],
        ),
        ("rate = 1000", "rate = 1\nspeed = { column = \"n\" }", &["recording.speed.unit: missing key"]),
        (
            "rate = 1000",
            "rate = 1\nspeed = { column = \"n\", unit = \"rpm\" }\nkeyphasor = { column = \"k\", pulses_per_turn = 1 }",
            &["recording.speed: both keyphasor and speed"],
        ),
    ]);
    let speed = with(&text, "rate = 1000", "time = \"t\"\nspeed = { column = \"n\", unit = \"rpm\" }");
    let recording = read(&speed).unwrap().recording.unwrap();
    assert_eq!(recording.clock, Clock::column("t"));
    assert!(matches!(recording.rotation, RotationSource::SpeedColumn { radians_per_second: f, .. } if near(f, PI / 30.0)));
    let keys = "rate = { column = \"fs\", unit = \"kHz\" }\nheader = false\norientation = \"channels-first\"";
    let recording = read(&with(&text, "rate = 1000", keys)).unwrap().recording.unwrap();
    assert_eq!(recording.clock, Clock::Number { name: "fs".into(), hertz: 1000.0 });
    assert!(recording.layout.is_headless && recording.layout.orientation == Some(Orientation::ChannelsFirst));
    let keys = "rate = \"file\"\nkeyphasor = \"synchronous\"";
    let recording = read(&with(&text, "rate = 1000", keys)).unwrap().recording.unwrap();
    assert_eq!((recording.clock, recording.rotation), (Clock::Stated, RotationSource::Synchronous));
}

#[test]
#[rustfmt::skip] // a table
fn keys_of_a_keyphasor() {
    let text = format!("{MINIMAL}{RECORDING}keyphasor = {{ column = \"k\", pulses_per_turn = 60 }}\n");
    let keys = "pulses_per_turn = 60";
    let more = |key: &str| format!("{keys}, {key}");
    let refused = |key: &str, expected: &[&str]| assert_refused(&text, &[(keys, &more(key), expected)]);
    refused("missing = 0", &["recording.keyphasor.missing: invalid value: 0, expected a whole number from 1 to 30"]);
    refused("missing = 31", &["half of pulses_per_turn"]);
    refused("missing = 1.5", &["keyphasor.missing: invalid value: 1.5"]);
    refused("kind = \"counter\"", &["keyphasor.kind: invalid value: \"counter\", expected \"pulses\" or \"count\""]);
    refused("kind = \"count\", slope = \"rising\"", &["keyphasor.slope: misplaced key", "only with kind = \"pulses\""]);
    refused("kind = \"count\", missing = 1", &["keyphasor.missing: misplaced key"]);
    refused("unit = \"um\"", &["keyphasor.unit: invalid value: \"um\" (a length), expected a unit of voltage: V or mV"]);
    refused("threshold = \"-5 V\"", &["keyphasor.threshold: invalid value: \"-5 V\", expected a number as in the column, or a voltage with unit"]);
    refused("unit = \"V\", threshold = \"5 um\"", &["keyphasor.threshold: invalid value: \"5 um\" (a length), expected a voltage"]);
    refused("unit = \"V\", hysteresis = \"-1 V\"", &["keyphasor.hysteresis: invalid value: \"-1 V\", expected a voltage above 0"]);
    refused("hysteresis = 0", &["keyphasor.hysteresis: invalid value: 0, expected a number above 0 as in the column"]);
    refused("slope = \"down\"", &["keyphasor.slope: invalid value: \"down\", expected \"rising\" or \"falling\""]);
    let run_out = |line: &str, expected: &[&str]| assert_refused(&format!("{MINIMAL}{RECORDING}"), &[("rate = 1000", line, expected)]);
    let with_keyphasor = "keyphasor = { column = \"k\", pulses_per_turn = 1 }";
    run_out("rate = 1\nrun_out = \"slow.csv\"", &["recording.run_out: misplaced key: \"slow.csv\"", "only with a keyphasor"]);
    run_out("rate = 1\nrun_out = \"slow.csv\"\nspeed = { column = \"n\", unit = \"rpm\" }", &["only with a keyphasor"]);
    run_out(&format!("rate = 1\nrun_out = 3\n{with_keyphasor}"), &["recording.run_out: invalid value: 3, expected the name of a recording"]);
    refused("treshold = 1", &["unknown key (did you mean threshold?)"]);
    assert_refused(&text, &[(keys, "pulses_per_turn = 2, missing = 1", &["keyphasor.missing: misplaced key", "pulses_per_turn of 3 or more"])]);
    let read = |key: &str| read(&with(&text, keys, &more(key))).unwrap().recording.unwrap().rotation;
    let RotationSource::Keyphasor { missing, signal: KeyphasorSignal::Pulses(found), .. } =
        read("missing = 2, unit = \"mV\", threshold = \"-5 V\", hysteresis = 0.5, slope = \"falling\"")
    else {
        unreachable!("pulses")
    };
    let wanted = PulseDetection {
        volts_per_unit: Some(1e-3),
        threshold: Some(-5.0),
        hysteresis: Some(0.5),
        slope: Some(Slope::Falling),
    };
    assert_eq!((missing, found), (2, wanted));
    assert!(matches!(read("kind = \"count\""), RotationSource::Keyphasor { signal: KeyphasorSignal::Count, .. }));
    let instants = read("kind = \"instants\", unit = \"ms\"");
    assert!(
        matches!(instants, RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { seconds: 1e-3 }, .. }),
        "{instants:?}"
    );
    assert_eq!((instants.unit(), instants.factor()), (Some("ms"), None));
    refused("kind = \"instants\"", &["keyphasor.unit: missing key, expected the unit of the column: s, ms"]);
    refused("kind = \"instants\", unit = \"V\"", &["keyphasor.unit", "a unit of time"]);
    refused("kind = \"instants\", unit = \"s\", threshold = 1", &["keyphasor.threshold: misplaced key", "kind = \"pulses\""]);
}

/// Displacement of a reading by the factor and the offset of the probe.
#[test]
fn a_probe_in_volts() {
    let text = format!("{MINIMAL}{RECORDING}");
    let displacement = |keys: &str, reading: f64| {
        let scene = read(&with(&text, "unit = \"um\"", keys)).unwrap();
        let [probe] = scene.recording.as_ref().unwrap().probes.as_slice() else { unreachable!("one probe") };
        assert!(probe.sensitivity.is_some() && probe.unit().is_some());
        reading * probe.metres_per_unit - probe.offset
    };
    // The gap closes by 100 um: the voltage rises by 787 mV.
    for (keys, reading, metres) in [
        ("unit = \"V\", sensitivity = \"7.87 mV/um\", offset = \"-9.5 V\"", -8.713, 100e-6),
        ("unit = \"mV\", sensitivity = \"7.87 V/mm\", offset = \"-9.5 V\"", -8713.0, 100e-6),
        ("unit = \"V\", sensitivity = \"200 mV/mil\", offset = \"-9500 mV\"", -9.3, 25.4e-6),
        ("unit = \"V\", sensitivity = \"-8 mV/um\", offset = \"-10 V\"", -9.2, -100e-6),
        ("unit = \"V\", sensitivity = \"8 mV/um\", offset = \"5 um\"", 0.08, 5e-6),
        ("unit = \"V\", sensitivity = 8000", 0.8, 100e-6),
    ] {
        let found = displacement(keys, reading);
        assert!((found - metres).abs() < 1e-9, "{keys}: {found}");
    }
}
