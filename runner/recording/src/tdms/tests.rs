use std::path::Path;

use super::{BIG_ENDIAN, DAQMX, INTERLEAVED, METADATA, NEW_LIST, RAW_DATA};
use crate::harness::{Trial, cut_short, damaged, error, probe, read_file, recording, values};
use ballrace_scene::{Clock, Recording, Sensor};

fn text(of: &str) -> Vec<u8> {
    [&(of.len() as u32).to_le_bytes(), of.as_bytes()].concat()
}

fn property(name: &str, value: &str) -> Vec<u8> {
    [text(name), 0x20_u32.to_le_bytes().into(), text(value)].concat()
}

fn number(name: &str, value: f64) -> Vec<u8> {
    [text(name), 10_u32.to_le_bytes().into(), value.to_le_bytes().into()].concat()
}

/// An object with its index and properties.
fn object(path: &str, index: &[u8], properties: &[Vec<u8>]) -> Vec<u8> {
    let count = (properties.len() as u32).to_le_bytes();
    [text(path), index.into(), count.into(), properties.concat()].concat()
}

fn index(kind: u32, values: u64) -> Vec<u8> {
    [20_u32.to_le_bytes(), kind.to_le_bytes(), 1_u32.to_le_bytes()]
        .concat()
        .into_iter()
        .chain(values.to_le_bytes())
        .collect()
}

fn about(objects: &[Vec<u8>]) -> Vec<u8> {
    [(objects.len() as u32).to_le_bytes().into(), objects.concat()].concat()
}

fn segment(contents: u32, about: &[u8], numbers: &[u8]) -> Vec<u8> {
    let next = (about.len() + numbers.len()) as u64;
    let mut out = [b"TDSm".as_slice(), &contents.to_le_bytes(), &4713_u32.to_le_bytes()].concat();
    out.extend(next.to_le_bytes());
    out.extend((about.len() as u64).to_le_bytes());
    [&out, about, numbers].concat()
}

fn doubles(from: u16, count: u16) -> Vec<u8> {
    (from..from + count).flat_map(|i| (f64::from(i) * 0.1).to_le_bytes()).collect()
}

fn words(from: i16, count: i16) -> Vec<u8> {
    (from..from + count).flat_map(i16::to_le_bytes).collect()
}

const AS_BEFORE: [u8; 4] = [0; 4];
const NO_DATA: [u8; 4] = [0xff; 4];
const NEW: u32 = METADATA | NEW_LIST | RAW_DATA;

/// Two chunks of 5; a segment of one chunk as before; one with a property alone; the lengths of its parts.
fn file() -> (Vec<u8>, Vec<usize>) {
    let units = [number("wf_increment", 1e-3), property("unit_string", "m")];
    let first = about(&[
        object("/", &NO_DATA, &[property("name", "test")]),
        object("/'G'", &NO_DATA, &[]),
        object("/'G'/'x'", &index(10, 5), &units),
        object("/'G'/'y'''", &index(2, 5), &[property("NI_UnitDescription", "Furlong")]),
        object("/'H'/'x'", &NO_DATA, &[]),
    ]);
    let chunks = [doubles(0, 5), words(0, 5), doubles(5, 5), words(5, 5)].concat();
    let again = about(&[object("/'G'/'x'", &AS_BEFORE, &[property("note", "still on")])]);
    let parts = [
        segment(NEW, &first, &chunks),
        segment(RAW_DATA, &[], &[doubles(10, 5), words(10, 5)].concat()),
        segment(METADATA | RAW_DATA, &again, &[doubles(15, 5), words(15, 5)].concat()),
    ];
    let lengths = parts.iter().scan(0, |sum, part| {
        *sum += part.len();
        Some(*sum)
    });
    (parts.concat(), lengths.collect())
}

#[test]
fn segments_continue_each_other() {
    let rows = values(&file().0, &["y'", "G/x"]);
    assert_eq!(rows.len(), 20);
    assert!(rows.iter().zip(0_u16..).all(|(row, i)| *row == [f64::from(i), f64::from(i) * 0.1]));
    let said = error(&file().0, &recording(&["x"]));
    assert_eq!(said, ": repeated column: `x`, expected each name once");
    assert_eq!(error(&file().0, &recording(&["z"])), ": no such column: `z`, expected one of `G/x`, `G/y'`, `H/x`");
}

#[test]
fn a_new_list_and_new_lengths() {
    let start = about(&[object("/'G'/'x'", &index(3, 4), &[]), object("/'G'/'old'", &index(5, 1), &[])]);
    let numbers: Vec<u8> = (0..4_i32).flat_map(i32::to_le_bytes).chain([9]).collect();
    let more = about(&[object("/'G'/'x'", &index(3, 1), &[])]);
    let last: Vec<u8> = (4..7_i32).flat_map(i32::to_le_bytes).collect();
    let file = [segment(NEW, &start, &numbers), segment(NEW, &more, &last)].concat();
    assert_eq!(values(&file, &["x"]).concat(), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let said = error(&file, &recording(&["x", "old"]));
    assert!(said.contains("7 in `G/x`, 1 in `G/old`, expected columns of equal length"), "{said}");
}

#[test]
fn interleaved_and_big_endian() {
    let objects = about(&[object("/'G'/'a'", &index(2, 3), &[]), object("/'G'/'b'", &index(9, 3), &[])]);
    let row = |i: i16| [i.to_le_bytes().as_slice(), &(f32::from(i) * 0.1).to_le_bytes()].concat();
    let numbers: Vec<u8> = (0..3).flat_map(row).collect();
    let rows = values(&segment(NEW | INTERLEAVED, &objects, &numbers), &["a", "b"]);
    assert_eq!(rows[2], [2.0, f64::from(2.0_f32 * 0.1)]);

    let path = "/'G'/'a'";
    let mut about = [1_u32.to_be_bytes(), (path.len() as u32).to_be_bytes()].concat();
    about.extend(path.as_bytes());
    about.extend([20_u32, 10, 1].map(u32::to_be_bytes).concat());
    about.extend(2_u64.to_be_bytes());
    about.extend(0_u32.to_be_bytes());
    let mut file = [b"TDSm".as_slice(), &(NEW | BIG_ENDIAN).to_le_bytes(), &4713_u32.to_be_bytes()].concat();
    file.extend((about.len() as u64 + 16).to_be_bytes());
    file.extend((about.len() as u64).to_be_bytes());
    let file = [file, about, [0.1_f64, -7.5].map(f64::to_be_bytes).concat()].concat();
    assert_eq!(values(&file, &["a"]), [[0.1], [-7.5]]);
}

#[test]
fn a_segment_still_being_written() {
    let objects = about(&[object("/'G'/'x'", &index(10, 4), &[])]);
    let mut file = segment(NEW, &objects, &doubles(0, 10));
    file[12..20].fill(0xff);
    let (rows, flaws) = Trial::new().read(&file, &recording(&["x"])).unwrap();
    assert_eq!((rows.len(), flaws.len(), flaws[0].first_line), (9, 1, 9));
    assert!(rows[8].probes[0].is_nan() && rows[7].probes[0] == 7.0 * 0.1);
}

#[test]
fn contradictions_of_the_scene_are_rejected() {
    let (file, _) = file();
    let mut other = recording(&["G/x"]);
    other.probes[0] = probe("G/x", 1e-6);
    assert_eq!(error(&file, &other), ": column G/x: unit differs from the scene's: `m`, expected `um` or no unit");
    // A sensor's unit is not a probe's.
    other.probes.clear();
    other.sensors = vec![Sensor { column: "G/x".into(), unit: "m/s^2".into(), bearing: None }];
    assert!(error(&file, &other).contains("unit differs from the scene's: `m`, expected `m/s^2`"));
    other = recording(&["G/x"]);
    other.clock = Clock::Rate(12_800.0);
    assert!(error(&file, &other).contains("sampling rate differs from the scene's: 1000 Hz, expected 12800 Hz"));
}

#[test]
fn named_text_that_is_no_number_is_rejected() {
    let text = [index(0x20, 2), 6_u64.to_le_bytes().into()].concat();
    let objects = about(&[
        object("/'G'/'x'", &index(10, 2), &[]),
        object("/'G'/'words'", &text, &[]),
        object("/'G'/'time'", &index(0x44, 2), &[]),
        object(
            "/'G'/'raw'",
            &index(2, 2),
            &[[super::tests::text("NI_Number_Of_Scales"), 7_u32.to_le_bytes().into(), 1_u32.to_le_bytes().into()]
                .concat()],
        ),
    ]);
    let numbers = [doubles(0, 2), vec![b'a'; 6], vec![0; 32], words(0, 2)].concat();
    let file = segment(NEW, &objects, &numbers);
    assert_eq!(values(&file, &["x"]), [[0.0], [0.1]]);
    assert!(error(&file, &recording(&["words"])).contains("`G/words`: contains no numbers"));
    assert!(error(&file, &recording(&["time"])).contains("`G/time`: contains no numbers"));
    assert!(error(&file, &recording(&["raw"])).contains("`G/raw`: contains raw values without their scale 0"));
}

/// The index of a count of 16 bits in a row of DAQmx raw data.
fn scaler(offset: u32, width: u32) -> Vec<u8> {
    let head = [[0x69, 0x12, 0, 0], [0xff; 4], 1_u32.to_le_bytes()].concat();
    let rest = [1, 3, 0, offset, 0, 0, 1, width].map(u32::to_le_bytes).concat();
    [head, 0_u64.to_le_bytes().into(), rest].concat()
}

fn linear(number: u32, slope: f64, intercept: f64, input: u32) -> Vec<Vec<u8>> {
    let name = |what: &str| format!("NI_Scale[{number}]_{what}");
    vec![
        property(&name("Scale_Type"), "Linear"),
        self::number(&name("Linear_Slope"), slope),
        self::number(&name("Linear_Y_Intercept"), intercept),
        [text(&name("Linear_Input_Source")), 7_u32.to_le_bytes().into(), input.to_le_bytes().into()].concat(),
    ]
}

fn scales(count: u32) -> Vec<Vec<u8>> {
    let count = [text("NI_Number_Of_Scales"), 7_u32.to_le_bytes().into(), count.to_le_bytes().into()].concat();
    vec![property("NI_Scaling_Status", "unscaled"), count]
}

/// Two channels in rows of 4 bytes, a linear scale on one and two on the other.
fn raw_file() -> Vec<u8> {
    let one = [scales(2), linear(1, 0.5, 3.0, 0)].concat();
    let two = [scales(3), linear(1, 0.5, 3.0, 0), linear(2, -10.0, 1.0, 1)].concat();
    let objects = about(&[object("/'G'/'a'", &scaler(0, 4), &one), object("/'G'/'b'", &scaler(2, 4), &two)]);
    let row = |i: i16| [i.to_le_bytes(), (100 - i).to_le_bytes()].concat();
    let rows = |from: i16| (from..from + 6).flat_map(row).collect::<Vec<u8>>();
    [segment(NEW | DAQMX, &objects, &rows(0)), segment(RAW_DATA | DAQMX, &[], &rows(6))].concat()
}

#[test]
fn raw_counts_become_what_their_linear_scales_say() {
    let rows = values(&raw_file(), &["a", "b"]);
    assert_eq!(rows.len(), 12);
    for (row, i) in rows.iter().zip(0_i16..) {
        let (a, b) = (f64::from(i), f64::from(100 - i));
        assert_eq!(*row, [0.5 * a + 3.0, -10.0 * (0.5 * b + 3.0) + 1.0]);
    }
    let cube = [scales(2), linear(1, 0.5, 3.0, 0), vec![property("NI_Scale[1]_Scale_Type", "Polynomial")]].concat();
    let file = segment(NEW | DAQMX, &about(&[object("/'G'/'a'", &scaler(0, 2), &cube)]), &words(0, 2));
    assert!(error(&file, &recording(&["a"])).contains("a scale of the kind \"Polynomial\", not a linear one"));
    let round = [scales(2), linear(1, 0.5, 3.0, 1)].concat();
    let file = segment(NEW | DAQMX, &about(&[object("/'G'/'a'", &scaler(0, 2), &round)]), &words(0, 2));
    assert!(error(&file, &recording(&["a"])).contains("takes a later one"));
    let beyond = about(&[object("/'G'/'a'", &scaler(3, 4), &scales(1))]);
    assert!(error(&segment(NEW | DAQMX, &beyond, &words(0, 4)), &recording(&["a"])).contains("DAQmx raw data of"));
}

#[test]
fn short_and_damaged_files() {
    let (file, sound) = file();
    cut_short(&file, &["G/x", "y'"], &sound);
    damaged(&file, &["G/x", "y'"]);
    damaged(&raw_file(), &["G/a", "b"]);
}

/// Measured files, where they are at hand.
#[test]
fn measured_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings/real/tdms");
    let said = |name: &str| {
        let path = folder.join(name);
        path.is_file().then(|| read_file(&path, &recording(&["none"])).unwrap_err().to_string())
    };
    for (name, channels, samples, rate) in [("raw1.tdms", 7, 2000, 5e4), ("big_endian.tdms", 2, 3500, 1e3)] {
        let Some(absent) = said(name) else { continue };
        let (_, names) = absent.split_once("expected one of ").unwrap();
        let names: Vec<&str> = names.split('`').skip(1).step_by(2).collect();
        assert_eq!(names.len(), channels, "{names:?}");
        let of = Recording { clock: Clock::Rate(rate), ..recording(&names) };
        let (rows, _) = read_file(&folder.join(name), &of).unwrap();
        assert_eq!(rows.len(), samples);
        if name == "raw1.tdms" {
            // As npTDMS 1.13 scales them, volts.
            let told =
                [(0, 0, -0.184_026_612_140_263_06), (1234, 6, 4.784_997_100_741_6), (0, 3, 2.498_245_185_705_13)];
            for (row, channel, volts) in told {
                assert!((rows[row].probes[channel] - volts).abs() < 1e-12, "{row} {channel}");
            }
        }
    }
}

/// A rate belongs to its group; a group's name may have a slash and more than sixty characters.
#[test]
fn rates_of_other_groups() {
    let long = "07/09/2012 06:58:23 PM - Digital Input - All Data of a long campaign on the rig";
    let objects = about(&[
        object("/'G'/'x'", &index(10, 5), &[number("wf_increment", 1e-3)]),
        object("/'G'/'y'", &index(10, 5), &[]),
        object(&format!("/'{long}'/'line 0'"), &index(10, 5), &[]),
    ]);
    let file = segment(NEW, &objects, &doubles(0, 15));
    let stated = |columns: &[&str]| Recording { clock: Clock::Stated, ..recording(columns) };
    assert_eq!(values(&file, &["line 0"])[1], [11.0 * 0.1]);
    let trial = Trial::new();
    assert_eq!(trial.read(&file, &stated(&["x", "y"])).unwrap().0.len(), 5);
    let said = error(&file, &stated(&["x", "line 0"]));
    assert!(said.contains(&format!("sampling rate of the file: none for `{long}/line 0`, expected rate = ")), "{said}");
    let said = error(&file, &recording(&["line 1"]));
    assert!(said.contains(&format!("`{long}/line 0`")), "{said}");
}
