//! One recording in every format: the same figures to the last digit.

use std::io::Write;
use std::sync::Arc;

use parquet::data_type::DoubleType;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use serde_json::Value;

use crate::support::{DEMO_SCENE, SHORT, Sandbox, numbers, scene, short_recording, swap};

/// Names and columns of the recording on a rig.
fn table() -> (Vec<String>, Vec<Vec<f64>>) {
    let (names, rows) = numbers(&short_recording(SHORT));
    let columns = (0..names.len()).map(|place| rows.iter().map(|row| row[place]).collect()).collect();
    (names, columns)
}

fn little_endian<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// Rows of a structure with the columns as its fields.
fn npy() -> Vec<u8> {
    let (names, columns) = table();
    let fields: String = names.iter().map(|name| format!("('{name}', '<f8'), ")).collect();
    let text = format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({SHORT},), }}");
    let text = format!("{text:501}\n");
    let rows = (0..SHORT).flat_map(|row| columns.iter().map(move |column| &column[row]));
    let length = (text.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0".as_slice(), &length, text.as_bytes(), &little_endian(rows)].concat()
}

fn parquet() -> Vec<u8> {
    let (names, columns) = table();
    let fields: String = names.iter().map(|name| format!("REQUIRED DOUBLE {name}; ")).collect();
    let schema = Arc::new(parse_message_type(&format!("message schema {{ {fields} }}")).unwrap());
    let mut out = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut out, schema, Arc::default()).unwrap();
    for rows in [0..SHORT / 3, SHORT / 3..SHORT] {
        let mut group = writer.next_row_group().unwrap();
        for column in &columns {
            let mut out = group.next_column().unwrap().unwrap();
            out.typed::<DoubleType>().write_batch(&column[rows.clone()], None, None).unwrap();
            out.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    out
}

fn mat() -> Vec<u8> {
    let (names, columns) = table();
    let columns: Vec<(&str, &[f64])> =
        names.iter().map(String::as_str).zip(columns.iter().map(Vec::as_slice)).collect();
    mat_of(&columns)
}

/// A MATLAB file with a vector of each name.
fn mat_of(columns: &[(&str, &[f64])]) -> Vec<u8> {
    let element = |kind: u32, bytes: &[u8]| {
        let mut out = [kind.to_le_bytes(), (bytes.len() as u32).to_le_bytes()].concat();
        out.extend(bytes);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let mut out = b"MATLAB 5.0 MAT-file, made by a test".to_vec();
    out.resize(124, b' ');
    out.extend([0, 1, b'I', b'M']);
    for (name, column) in columns {
        let size = [column.len() as i32, 1].map(i32::to_le_bytes).concat();
        let flags = element(6, &[6, 0, 0, 0, 0, 0, 0, 0]);
        let parts = [flags, element(5, &size), element(1, name.as_bytes()), element(9, &little_endian(*column))];
        out.extend(element(14, &parts.concat()));
    }
    out
}

/// A TDMS file of one segment in chunks of a turn, whose channels have `unit`.
fn tdms(unit: &str) -> Vec<u8> {
    let text = |of: &str| [&(of.len() as u32).to_le_bytes(), of.as_bytes()].concat();
    let words = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let chunk = 256_usize;
    let (names, columns) = table();
    let mut about = words(&[names.len() as u32]);
    for name in &names {
        about.extend(
            [text(&format!("/'Rig'/'{name}'")), words(&[20, 10, 1]), (chunk as u64).to_le_bytes().into()].concat(),
        );
        about.extend(
            [words(&[2]), text("wf_increment"), words(&[10]), (1.0 / 12_800.0_f64).to_le_bytes().into()].concat(),
        );
        about.extend([text("unit_string"), words(&[0x20]), text(unit)].concat());
    }
    let starts = (0..SHORT).step_by(chunk);
    let chunks = starts.flat_map(|from| columns.iter().flat_map(move |column| &column[from..from + chunk]));
    let numbers = little_endian(chunks);
    let mut out = [b"TDSm".to_vec(), words(&[0b1110, 4713])].concat();
    out.extend(((about.len() + numbers.len()) as u64).to_le_bytes());
    out.extend((about.len() as u64).to_le_bytes());
    [out, about, numbers].concat()
}

fn wav() -> Vec<u8> {
    let (names, columns) = table();
    let channels = names.len() as u16;
    let rows = (0..SHORT).flat_map(|row| columns.iter().map(move |column| column[row] as f32));
    let samples: Vec<u8> = rows.flat_map(f32::to_le_bytes).collect();
    let mut out = b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0\x03\0".to_vec();
    out.extend(channels.to_le_bytes());
    out.extend([12_800, 12_800 * 4 * u32::from(channels)].map(u32::to_le_bytes).concat());
    out.extend([4 * channels, 32].map(u16::to_le_bytes).concat());
    out.extend(b"data");
    out.extend((samples.len() as u32).to_le_bytes());
    out.extend(samples);
    out
}

/// The outcome but for how long it took and what the file is called.
fn figures(sandbox: &Sandbox, recording: &str) -> Value {
    let mut outcome = sandbox.replay("scene.toml", &["--recording", recording]);
    let all = outcome.as_object_mut().unwrap();
    assert_eq!(all.remove("recording").unwrap(), recording);
    all.remove("timing").unwrap();
    let file = all.remove("file").unwrap();
    assert_eq!(file["bytes"], std::fs::metadata(sandbox.path(recording)).unwrap().len());
    outcome
}

#[test]
fn the_same_figures_from_every_format() {
    let sandbox = Sandbox::rig();
    let text = figures(&sandbox, "healthy.csv");
    let files = [("r.npy", npy()), ("r.parquet", parquet()), ("r.mat", mat()), ("r.tdms", tdms("V"))];
    for (name, bytes) in files {
        sandbox.put(name, &bytes);
        assert_eq!(figures(&sandbox, name), text, "{name}");
        // Content comes before the name.
        sandbox.put("r.dat", &bytes);
        assert_eq!(figures(&sandbox, "r.dat"), text, "{name} as r.dat");
    }
}

#[test]
fn the_same_figures_from_sound() {
    let (names, columns) = table();
    let numbered = names.iter().enumerate().fold(DEMO_SCENE.to_owned(), |text, (place, name)| {
        text.replace(&format!("\"{name}\""), &format!("\"c{place}\""))
    });
    let header: Vec<String> = (0..names.len()).map(|place| format!("c{place}")).collect();
    let row = |row: usize| columns.iter().map(|column| (f64::from(column[row] as f32)).to_string()).collect::<Vec<_>>();
    let rows: String = (0..SHORT).map(|at| row(at).join(",") + "\n").collect();
    let sandbox = Sandbox::with(&numbered, &(header.join(",") + "\n" + &rows));
    sandbox.put("r.wav", wav());
    assert_eq!(figures(&sandbox, "r.wav"), figures(&sandbox, "healthy.csv"));
}

/// The log of a device, frame by frame, gives the figures of the same readings as text; a damaged frame is a flaw with its place.
#[test]
fn the_same_figures_from_frames() {
    let (names, columns) = table();
    let reading = |name: &str, row: usize| columns[names.iter().position(|own| own == name).unwrap()][row] as f32;
    let used = ["DE_X_um", "DE_Y_um", "NDE_X_um", "NDE_Y_um", "axial_um", "keyphasor"];
    let row = |row: usize| used.map(|name| reading(name, row));
    let frame = |i: usize| ballrace::log::frame::<6, 32>(i as u32, &row(i));
    let text = |i: usize| row(i).map(|x| f64::from(x).to_string()).join(",") + "\n";
    let rows: String = (0..SHORT).map(text).collect();
    let sandbox = Sandbox::with(DEMO_SCENE, &(used.join(",") + "\n" + &rows));
    let mut bytes: Vec<u8> = (0..SHORT).flat_map(frame).collect();
    sandbox.put("r.frames", &bytes);
    let expected = figures(&sandbox, "healthy.csv");
    assert_eq!(figures(&sandbox, "r.frames"), expected);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&bytes).unwrap();
    sandbox.put("r.frames.gz", packed.finish().unwrap());
    assert_eq!(figures(&sandbox, "r.frames.gz"), expected);

    bytes[32 * 1000 + 7] ^= 4;
    sandbox.put("r.frames", &bytes);
    let outcome = sandbox.replay("scene.toml", &["--recording", "r.frames"]);
    let flaws = outcome["flaws"].as_array().unwrap();
    let at = |kind: &str| flaws.iter().find(|flaw| flaw["kind"] == kind).map(|flaw| flaw["places"][0]["index"].clone());
    assert_eq!([at("damaged_frame"), at("gap")], [Some(1001.into()), Some(1001.into())], "{outcome:#}");
    sandbox.put("r.frames", &bytes[..31]);
    let said = "r.frames: unreadable file: no frame of 32 bytes with the right checksum in ";
    sandbox.refused(&["replay", "scene.toml", "--recording", "r.frames"], 1, &[said]);
}

#[test]
fn files_that_contradict_the_scene() {
    let sandbox = Sandbox::rig();
    sandbox.put("r.tdms", tdms("mm"));
    let replay = ["replay", "scene.toml", "--recording", "r.tdms"];
    sandbox.refused(
        &replay,
        2,
        &["r.tdms: column Rig/DE_X_um: unit differs from the scene's: `mm`, expected `um` or no unit"],
    );
    sandbox.put("r.tdms", tdms("µm"));
    sandbox.put("scene.toml", scene(&[("12.8 kHz", "25.6 kHz")]));
    let said = "r.tdms: sampling rate differs from the scene's: 12800 Hz, expected 25600 Hz within 0.1 %";
    sandbox.refused(&replay, 2, &[said]);
    sandbox.put("scene.toml", swap(DEMO_SCENE, "\"DE_X_um\"", "\"DE_X\""));
    sandbox.refused(&replay, 2, &["r.tdms: no such column: `DE_X`, expected one of `Rig/time_s`, `Rig/DE_X_um`"]);
}

#[test]
fn files_cut_short() {
    let sandbox = Sandbox::rig();
    for (name, bytes) in [("r.npy", npy()), ("r.parquet", parquet()), ("r.mat", mat())] {
        sandbox.put(name, &bytes[..bytes.len() - 100]);
        let replay = ["replay", "scene.toml", "--recording", name];
        sandbox.refused(&replay, 1, &[name, ": unreadable file: ", ", expected a"]);
    }
    // The rows that a logger wrote before it was stopped are used.
    let whole = tdms("um");
    sandbox.put("r.tdms", &whole[..whole.len() - 100]);
    let outcome = sandbox.replay("scene.toml", &["--recording", "r.tdms"]);
    let flaws = outcome["flaws"].as_array().unwrap();
    assert!(flaws.iter().any(|flaw| flaw["kind"] == "short_row"), "{outcome:#}");
}

/// Text as spreadsheets write it in UTF-16, of either byte order, packed or not.
#[test]
fn the_same_figures_from_utf_16() {
    let sandbox = Sandbox::rig();
    let text = figures(&sandbox, "healthy.csv");
    let table = sandbox.read("healthy.csv");
    let of = |text: &str, order: fn(u16) -> [u8; 2]| -> Vec<u8> {
        "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(order).collect()
    };
    let unicode_text = table.replace(',', "\t").replace('\n', "\r\n");
    sandbox.put("r.txt", of(&unicode_text, u16::to_le_bytes));
    assert_eq!(figures(&sandbox, "r.txt"), text);
    sandbox.put("r.csv", of(&table, u16::to_be_bytes));
    assert_eq!(figures(&sandbox, "r.csv"), text);
}

/// A keyphasor as instants of its pulses, a vector shorter than those of the samples, gives the figures of the same instants as pulses.
#[test]
fn instants_of_pulses() {
    let (names, columns) = table();
    let key = names.iter().position(|name| name == "keyphasor").unwrap();
    // A pulse recorded as a step is known to half a sample.
    let rises = columns[key].windows(2).enumerate().filter(|(_, pair)| pair[0] < 0.5 && pair[1] > 0.5);
    let instants: Vec<f64> = rises.map(|(i, _)| (i as f64 + 0.5) / 12_800.0 * 1e3).collect();
    assert!(instants.len() >= 6 && instants.len() < SHORT);
    let keyed = |unit: &str| {
        swap(
            DEMO_SCENE,
            "column = \"keyphasor\"",
            &format!("column = \"tach\", kind = \"instants\", unit = \"{unit}\""),
        )
    };
    let others: Vec<(&str, &[f64])> = names.iter().map(String::as_str).zip(columns.iter().map(Vec::as_slice)).collect();
    let with = |tach: &[f64]| mat_of(&[&others[..], &[("tach", tach)]].concat());
    let sandbox = Sandbox::rig();
    let pulses = sandbox.replay("scene.toml", &[]);
    sandbox.put("keyed.toml", keyed("ms"));
    sandbox.put("r.mat", with(&instants));
    let found = sandbox.replay("keyed.toml", &["--recording", "r.mat"]);
    for path in ["/speed/mean_rpm", "/probes/0/one_x/amplitude_um", "/bearings/0/measured/fx/rms"] {
        let [found, pulses] = [&found, &pulses].map(|outcome| outcome.pointer(path).and_then(Value::as_f64));
        if let (Some(found), Some(pulses)) = (found, pulses) {
            assert!((found / pulses - 1.0).abs() < 1e-3, "{path}: {found} {pulses}");
        }
    }
    let speed = |outcome: &Value| outcome.to_string();
    assert!(speed(&found).contains("; their instants"), "{found}");
    let refused = |unit: &str, tach: &[f64], part: &str| {
        sandbox.put("keyed.toml", keyed(unit));
        sandbox.put("r.mat", with(tach));
        sandbox.refused(&["replay", "keyed.toml", "--recording", "r.mat", "--no-report"], 1, &[part]);
    };
    refused("ms", &[2.0, 1.0, 3.0], "r.mat: column tach: 1 after 2, expected instants of pulses that rise");
    refused("us", &instants, "r.mat: column tach: instants that are ");
    sandbox.put("keyed.toml", keyed("h"));
    sandbox.put("r.mat", with(&instants));
    let text = sandbox.done(&["replay", "keyed.toml", "--recording", "r.mat", "--no-report"]).out;
    assert!(text.contains("No verdict: ") && text.contains("column tach: no instant of a pulse within"), "{text}");
    // Text has one length for all its columns.
    sandbox.put("keyed.toml", swap(&keyed("ms"), "\"tach\"", "\"keyphasor\""));
    let said = "healthy.csv: column keyphasor: a column of a file whose columns have equal lengths, expected instants of pulses";
    sandbox.refused(&["replay", "keyed.toml", "--no-report"], 1, &[said]);
    let args = ["simulate", "keyed.toml", "--duration", "0.1 s", "--as-recording", "-o", "o.csv"];
    sandbox.refused(&args, 2, &["recording.keyphasor.kind: \"instants\", expected \"pulses\" or \"count\""]);
}
