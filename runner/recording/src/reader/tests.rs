use super::*;
use crate::flaws::FlawSummary;
use ballrace_scene::{FileLayout, Probe};

fn probe(column: &str) -> Probe {
    crate::harness::probe(column, 1e-6)
}

fn recording(clock: Clock) -> Recording {
    Recording {
        average: 1,
        file: PathBuf::from("r.csv"),
        clock,
        probes: vec![probe("x"), probe("y")],
        sensors: vec![],
        rotation: RotationSource::keyphasor("key", 1),
        run_out: None,
        further_files: vec![],
        sequence: None,
        layout: FileLayout::default(),
        temperatures: vec![],
    }
}

fn rated() -> Recording {
    recording(Clock::Rate(1000.0))
}

fn stamped() -> Recording {
    recording(Clock::column("t"))
}

fn reader(text: &str, recording: &Recording) -> Result<Reader<'static>, RecordingError> {
    let bytes = std::io::Cursor::new(text.as_bytes().to_vec());
    Reader::from_reader(Box::new(bytes), Path::new("r.csv"), Some(text.len() as u64), recording)
}

fn read(text: &str, recording: &Recording) -> Result<(Vec<Row>, Vec<FlawSummary>), RecordingError> {
    let mut reader = reader(text, recording)?;
    let (mut rows, mut row) = (Vec::new(), Row::default());
    while reader.next_row(&mut row)? {
        rows.push(row.clone());
    }
    assert!(!reader.next_row(&mut row)?);
    Ok((rows, reader.flaws().summary()))
}

fn good(text: &str, recording: &Recording) -> (Vec<Row>, Vec<FlawSummary>) {
    read(text, recording).unwrap()
}

fn error(text: &str, recording: &Recording) -> String {
    let error = read(text, recording).unwrap_err();
    let said = error.to_string();
    assert!(!said.contains('\n'), "one sentence: {said}");
    said
}

/// Rows `t,x,y,key` at 1 kHz from sample 0 on, readings all different.
fn rows(samples: impl IntoIterator<Item = u32>) -> String {
    let line = |i: u32| format!("{:.4},{}.5,{}.25,{}\n", f64::from(i) * 1e-3, i, 2 * i, u8::from(i.is_multiple_of(10)));
    samples.into_iter().map(line).collect()
}

fn file(samples: impl IntoIterator<Item = u32>) -> String {
    format!("t,x,y,key\n{}", rows(samples))
}

#[test]
fn clean_file() {
    let text = file(0..50);
    let mut reader = reader(&text, &stamped()).unwrap();
    assert!((reader.rate() - 1000.0).abs() < 1e-6);
    assert_eq!(reader.columns(), ["t", "x", "y", "key"]);
    let mut row = Row::default();
    for index in 0..50 {
        assert!(reader.next_row(&mut row).unwrap());
        assert_eq!((row.index, row.line), (index, index + 2));
        assert!((row.probes[1] - (2.0 * index as f64 + 0.25) * 1e-6).abs() < 1e-18);
        assert_eq!(row.rotation, f64::from(u8::from(index % 10 == 0)));
        assert!((row.time - index as f64 * 1e-3).abs() < 1e-12);
    }
    assert!(!reader.next_row(&mut row).unwrap());
    assert!(reader.flaws().is_empty());
    assert_eq!(reader.progress(), (text.len() as u64, Some(text.len() as u64)));
}

#[test]
fn delimiters_breaks_quotes_and_mark() {
    let plain = good(&file(0..5), &stamped());
    for delimiter in [";", "\t", "|"] {
        assert_eq!(good(&file(0..5).replace(',', delimiter), &stamped()), plain);
    }
    assert_eq!(good(&file(0..5).replace('\n', "\r\n"), &stamped()), plain);
    assert_eq!(good(&format!("\u{feff}{}", file(0..5)), &stamped()), plain);
    assert_eq!(good(file(0..5).trim_end(), &stamped()), plain);
    let spaced = file(0..5).replace(',', " , ");
    assert_eq!(good(&spaced, &stamped()), plain);
    let quoted = "\"t\",\"a, b\",\"x\",\"y\",\"key\"\n\"0\",\"p,q\",\"1\",\"2\",\"0\"\r\n\"0.001\",,3,4,\"1\"\r\n";
    let (rows, flaws) = good(quoted, &stamped());
    assert_eq!((rows.len(), rows[1].probes[0], rows[1].rotation, flaws.len()), (2, 3e-6, 1.0, 0));
}

#[test]
fn lines_are_counted_over_blank_ones() {
    let text = "\n \r\nx,y,key\r\n\r\n1,2,0\r\n  \r\n\r\n3,4,0\r\n5,6,0";
    let (rows, flaws) = good(text, &rated());
    assert_eq!(rows.iter().map(|row| (row.index, row.line)).collect::<Vec<_>>(), [(0, 5), (1, 8), (2, 9)]);
    assert!(flaws.is_empty());
}

#[test]
fn missing_values() {
    let (rows, flaws) = good("x,y,key\n1,NaN,0\n2,,0\n,nan,1\n4,5,\n", &rated());
    assert!(rows[0].probes[1].is_nan() && rows[1].probes[1].is_nan() && rows[2].probes[0].is_nan());
    assert!(rows[3].rotation.is_nan());
    let found: Vec<_> = flaws.iter().map(|flaw| (flaw.column.as_deref(), flaw.samples_affected)).collect();
    assert_eq!(found, [(Some("y"), 3), (Some("x"), 1), (Some("key"), 1)]);
    assert_eq!(flaws[0].count, 1);
}

#[test]
fn short_rows_lose_their_last_cell() {
    for text in ["x,y,key\n1,2,0\n3,4", "x,y,key\n1,2,0\n3,4\n", "x,y,key\n1,2,0\n3,4,-", "x,y,key\n1,2,0\n3,4,1e"] {
        let (rows, flaws) = good(text, &rated());
        assert_eq!(rows[1].probes[0], 3e-6);
        assert_eq!(rows[1].probes[1].is_nan(), !text.contains("4,"), "{text}");
        assert!(rows[1].rotation.is_nan());
        assert_eq!((flaws.len(), flaws[0].kind, flaws[0].first_line), (1, Flaw::ShortRow, 3), "{text}");
    }
    let (rows, flaws) = good(&format!("{}0.0", file(0..10)), &stamped());
    assert_eq!((rows.len(), rows[10].index), (11, 10));
    assert!((rows[10].time - 0.01).abs() < 1e-9);
    assert!(flaws.iter().any(|flaw| flaw.kind == Flaw::ShortRow));
}

#[test]
fn wrong_cells_stop() {
    let said = error("x,y,key\n1,2,0\n1,oops,0\n", &rated());
    assert_eq!(
        said,
        "r.csv:3: column y: invalid value: `oops`, expected a number, or NaN or nothing where the reading is missing"
    );
    assert!(error("x,y,key\n1,1e999,0\n", &rated()).contains("invalid value: `1e999`"));
    assert!(error("x,y,key\n1,\"0,125\",0\n", &rated()).contains("decimal point"));
    assert!(error("x,y,key\n1,2,0\n1,-\n1,2,-\n", &rated()).contains("r.csv:4: column key"));
    assert!(error("x,y,key\n1,2,0,9\n", &rated()).contains("too many cells: 4, expected 3"));
    // A column that is not used may hold anything.
    assert_eq!(good("x,y,key,note\n1,2,0,fine\n3,4,0,?", &rated()).1, []);
}

#[test]
fn headers() {
    assert!(error("", &rated()).contains("empty file, expected a line of column names"));
    assert!(error("\n\n", &rated()).contains("empty file, expected a line of column names"));
    assert!(error("x,y,key\n", &rated()).contains("no row below the header"));
    assert!(
        error("1,2,3\n4,5,6\n", &rated())
            .contains("numbers instead of a header: `1,2,3`, expected a line with the names of the columns")
    );
    assert!(error("x,y\0,key\n", &rated()).contains("not plain text"));
    assert!(error("x,y,key,y\n1,2,3,4\n", &rated()).contains("repeated column: `y`, expected each name once"));
    let absent = read("time,x,Y1,key\n0,1,2,3\n", &rated()).unwrap_err();
    assert!(absent.is_scene_fault());
    assert_eq!(absent.to_string(), "r.csv:1: no such column: `y`, expected one of `time`, `x`, `Y1`, `key`");
}

#[test]
fn nearest_column() {
    let mut recording = rated();
    recording.probes[0].column = "DE_X_um".into();
    let absent = read("DE_Z,de_x_mm,y,key\n1,2,3,4\n", &recording).unwrap_err();
    assert!(absent.to_string().contains("`DE_X_um` (did you mean `de_x_mm`?), expected one of `DE_Z`"), "{absent}");
    recording.probes[0].column = "temperature".into();
    assert!(!read("a,y,key\n1,2,3\n", &recording).unwrap_err().to_string().contains("mean"));
}

#[test]
fn files_that_cannot_be_read() {
    let gone = Reader::open(Path::new("no/such/file.csv"), &rated()).err().unwrap();
    assert!(matches!(gone, RecordingError::Open { .. }) && !gone.is_scene_fault());
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("notes.toml"), "no recording").unwrap();
    let folder = Reader::open(folder.path(), &rated()).err().unwrap();
    assert!(folder.to_string().ends_with(": folder without a recording: 1 other file, expected files of a recording"));
}

#[test]
fn open_quotation_mark_is_bounded() {
    let mut text = String::from("x,y,key\n1,2,\"0\n");
    text.push_str(&"1,2,0\n".repeat(2_000_000));
    assert!(error(&text, &rated()).contains("quotation mark"));
}

#[test]
fn repeated_and_backward_stamps_are_left_out() {
    let text = file((0..20).chain([19, 20, 21, 5, 6]).chain(22..30));
    let (rows, flaws) = good(&text, &stamped());
    assert_eq!(rows.iter().map(|row| row.index).collect::<Vec<_>>(), (0..30).collect::<Vec<_>>());
    assert_eq!((flaws[0].kind, flaws[0].count, flaws[0].first_line), (Flaw::RepeatedTimeStamp, 1, 22));
    assert_eq!((flaws[1].kind, flaws[1].count, flaws[1].first_line), (Flaw::BackwardTimeStamp, 2, 25));
    assert_eq!(flaws.len(), 2);
}

#[test]
fn gaps_jump() {
    let (rows, flaws) = good(&file((0..20).chain(30..40).chain([41])), &stamped());
    assert_eq!((rows[19].index, rows[20].index, rows[30].index), (19, 30, 41));
    assert_eq!((flaws[0].kind, flaws[0].count, flaws[0].samples_affected), (Flaw::Gap, 2, 11));
    assert_eq!(flaws[0].sentence, "11 samples missing in 2 gaps, first at line 22 (0.030000 s)");
}

#[test]
fn stray_stamp_is_no_gap() {
    let text = file(0..30).replace("0.0120,", "99.5,");
    let (rows, flaws) = good(&text, &stamped());
    assert_eq!(rows.iter().map(|row| row.index).collect::<Vec<_>>(), (0..30).collect::<Vec<_>>());
    assert!((rows[12].time - 0.012).abs() < 1e-6);
    assert_eq!((flaws.len(), flaws[0].kind, flaws[0].first_line), (1, Flaw::StrayTimeStamp, 14));
}

#[test]
fn missing_stamp_keeps_its_place() {
    let text = file(0..30).replace("0.0120,", "NaN,").replace("0.0000,", ",");
    let (rows, flaws) = good(&text, &stamped());
    assert_eq!(rows.iter().map(|row| row.index).collect::<Vec<_>>(), (0..30).collect::<Vec<_>>());
    assert!((rows[12].time - 0.012).abs() < 1e-6 && rows[0].time.abs() < 1e-6);
    assert_eq!((flaws.len(), flaws[0].count), (1, 2));
}

#[test]
fn clocks_that_do_not_run() {
    assert!(error("t,x,y,key\n0,1,2,0\n", &stamped()).contains("fewer than two"));
    assert!(error("t,x,y,key\n0,1,2,0\n0,1,2,0\n0,1,2,0\n", &stamped()).contains("time stamps are equal"));
    assert!(error(&file((0..20).rev()), &stamped()).contains("rise from row to row"));
}

#[test]
fn stuck_probe_reads_nothing() {
    let stuck = |i: u32| if (100..400).contains(&i) { 7.5 } else { f64::from(i) };
    let rows: String = (0..500).map(|i| format!("{},{i},{}\n", stuck(i), u8::from(i.is_multiple_of(100)))).collect();
    let (rows, flaws) = good(&format!("x,y,key\n{rows}"), &rated());
    assert!(rows.iter().all(|row| row.probes[0].is_nan() == (163..400).contains(&row.index)));
    assert!(rows.iter().all(|row| !row.probes[1].is_nan() && !row.rotation.is_nan()));
    assert_eq!(flaws.len(), 1);
    assert_eq!(flaws[0].sentence, "x: stuck at 7.5 um from line 102 for 300 samples");
}

#[test]
fn clipped_probe_is_counted() {
    let x = |i: u32| ((f64::from(i) * 0.3).sin() * 50.0 + (f64::from(i) * 7.7).sin()).clamp(-60.0, 40.0);
    let rows: String = (0..2000).map(|i| format!("{},{i},0\n", x(i))).collect();
    let (rows, flaws) = good(&format!("x,y,key\n{rows}"), &rated());
    assert!(rows.iter().all(|row| !row.probes[0].is_nan()));
    assert_eq!((flaws.len(), flaws[0].kind), (1, Flaw::ClippedProbe));
    assert!(flaws[0].sentence.starts_with("x: clipped at 40 um in "), "{}", flaws[0].sentence);
}

#[test]
fn speed_column_is_in_radians_per_second() {
    let mut recording = rated();
    recording.rotation = RotationSource::SpeedColumn { column: "key".into(), radians_per_second: 0.5 };
    assert_eq!(good("x,y,key\n1,2,30\n", &recording).0[0].rotation, 15.0);
    recording.rotation = RotationSource::Scene;
    assert_eq!(good("x,y\n1,2\n", &recording).0[0].rotation, 0.0);
}

#[test]
fn rig_recordings_are_flawless() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/recordings/rig-6205");
    for (name, samples) in [("healthy", 12_800), ("unbalanced", 12_800), ("outer-spall", 12_800), ("run-up", 25_600)] {
        let path = folder.join(format!("{name}.csv"));
        if !path.exists() {
            continue;
        }
        let probes = ["DE_X_um", "DE_Y_um", "NDE_X_um", "NDE_Y_um", "axial_um"].map(probe).to_vec();
        let rotation = RotationSource::keyphasor("keyphasor", 1);
        let recording = Recording {
            file: path.clone(),
            clock: Clock::column("time_s"),
            average: 1,
            sensors: vec![],
            layout: FileLayout::default(),
            temperatures: vec![],
            probes,
            rotation,
            run_out: None,
            further_files: vec![],
            sequence: None,
        };
        let mut reader = Reader::open(&path, &recording).unwrap();
        assert!((reader.rate() - 12_800.0).abs() < 0.01, "{}", reader.rate());
        let (mut row, mut count) = (Row::default(), 0);
        while reader.next_row(&mut row).unwrap() {
            assert_eq!(row.index, count);
            count += 1;
        }
        assert_eq!(count, samples);
        assert!(reader.flaws().is_empty(), "{name}: {:?}", reader.flaws().summary());
    }
}
