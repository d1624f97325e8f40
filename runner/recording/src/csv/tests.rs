use std::io::Cursor;
use std::path::Path;

use crate::error::RecordingError;
use crate::flaws::FlawSummary;
use crate::harness::recording;
use crate::preview::preview;
use crate::{Reader, Row};
use ballrace_scene::{Clock, FileLayout, Recording, RotationSource};

type Result<T> = core::result::Result<T, RecordingError>;

fn reader(text: &[u8], recording: &Recording) -> Result<Reader<'static>> {
    Reader::from_reader(Box::new(Cursor::new(text.to_vec())), Path::new("r.csv"), None, recording)
}

fn read(text: &[u8], recording: &Recording) -> Result<(Vec<Row>, Vec<FlawSummary>)> {
    let mut reader = reader(text, recording)?;
    let (mut rows, mut row) = (Vec::new(), Row::default());
    while reader.next_row(&mut row)? {
        rows.push(row.clone());
    }
    Ok((rows, reader.flaws().summary()))
}

/// Readings of a flawless text.
fn readings(text: &str, recording: &Recording) -> Vec<Vec<f64>> {
    let (rows, flaws) = read(text.as_bytes(), recording).unwrap();
    assert!(flaws.is_empty(), "{flaws:?}");
    rows.into_iter().map(|row| row.probes).collect()
}

fn error(text: &str, recording: &Recording) -> String {
    let message = read(text.as_bytes(), recording).unwrap_err().to_string();
    assert!(!message.contains('\n'), "{message}");
    message
}

fn headless(columns: &[&str]) -> Recording {
    Recording { layout: FileLayout { is_headless: true, ..FileLayout::default() }, ..recording(columns) }
}

fn stamped(columns: &[&str]) -> Recording {
    Recording { clock: Clock::column("t"), ..recording(columns) }
}

#[test]
fn decimal_comma() {
    let of = recording(&["x", "y"]);
    for text in ["x;y\n1,5;-0,25\n2;1e-1\n", "x\ty\n1,5\t-0,25\n2\t0,1\n"] {
        assert_eq!(readings(text, &of), [[1.5, -0.25], [2.0, 0.1]]);
    }
    // Three decimals may separate thousands, until a cell decides.
    let rows = readings("x;y\n1,234;2,345\n3,456;4,567\n0,500;6,789\n7,890;1,000\n", &of);
    assert_eq!(rows, [[1.234, 2.345], [3.456, 4.567], [0.5, 6.789], [7.89, 1.0]]);
    assert_eq!(
        error("x;y\n1,234;2,345\n3,456;4,567\n", &of),
        "r.csv:2: column x: invalid value: `1,234`, expected a decimal point, or a decimal comma that is no separator of \
         thousands: a cell such as `1,5` or `0,250` in one of the first 1000 rows"
    );
    assert!(
        error("x;y\n1,5;2,5\n1.5;2,5\n", &of)
            .contains(":3: column x: invalid value: `1.5`, expected a number with a decimal comma")
    );
    assert!(
        error("x;y\n1.5;2.5\n1,5;2,5\n", &of)
            .contains(":3: column x: invalid value: `1,5`, expected a number with a decimal point")
    );
    assert!(error("x;y\n1.234,5;2\n", &of).contains("invalid value: `1.234,5`"));
    // A comma between the cells is no decimal comma.
    assert!(error("x,y\n\"1,5\",2\n", &of).contains("a number with a decimal point"));
}

#[test]
fn trailing_delimiters_and_blanks() {
    let of = recording(&["x", "y"]);
    for text in ["x,y,\n1,2,\n3,4,\n", "x,y\n1,2, \n3,4,,\n", "x,y,,\n1,2\n3,4,\n", "x;y;\n1 ; 2;\n3;4 ;  \n"] {
        assert_eq!(readings(text, &of), [[1.0, 2.0], [3.0, 4.0]], "{text:?}");
    }
    assert!(error("x,y\n1,2,3\n", &of).contains(":2: too many cells: 3, expected 2 as in the header"));
}

#[test]
fn time_stamps_of_iso_8601() {
    let rows = |stamps: [&str; 4]| {
        let text: String = stamps.iter().map(|stamp| format!("{stamp},1\n")).collect();
        let (rows, flaws) = read(format!("t,x\n{text}").as_bytes(), &stamped(&["x"])).unwrap();
        assert!(flaws.is_empty(), "{flaws:?}");
        rows.into_iter().map(|row| row.time).collect::<Vec<_>>()
    };
    let tenths = [0.0, 0.1, 0.2, 0.3];
    for (day, zone) in [("2026-11-22 ", ""), ("2026-11-22T", "Z"), ("2026-11-22T", "+05:30"), ("2026-11-22T", "-0800")]
    {
        let stamp = |second: &str| format!("{day}10:11:{second}{zone}");
        let stamps = ["59.900", "60.000", "60.1", "60.200000000"].map(stamp);
        let found = rows([&stamps[0], &stamps[1], &stamps[2], &stamps[3]]);
        assert!(found.iter().zip(tenths).all(|(found, expected)| (found - expected).abs() < 1e-12), "{found:?}");
    }
    // Nanoseconds, over the end of a leap day.
    let found = rows([
        "2028-02-29T23:59:59.999999900",
        "2028-03-01T00:00:00.000000000",
        "2028-03-01T00:00:00.000000100",
        "2028-03-01T00:00:00.000000201",
    ]);
    assert_eq!(found, [0.0, 100e-9, 200e-9, 301e-9]);
    // A comma within quotation marks.
    let found = rows([
        "\"2026-11-22 10:11:12,345\"",
        "\"2026-11-22 10:11:12,346\"",
        "\"2026-11-22 10:11:12,347\"",
        "\"2026-11-22 10:11:12,348\"",
    ]);
    assert!((found[3] - 0.003).abs() < 1e-12);
}

#[test]
fn invalid_time_stamps() {
    for wrong in [
        "2026-11-22",
        "2026-13-22 10:11:12",
        "2026-11-22 24:00:00",
        "2026-11-22 10",
        "22.11.2026",
        "2026-11-22 10:11:12.1234567891",
        "2026-11-22 10:11:12+1",
        "2026-11-22 10:11:12Zulu",
        "2026-11-22 10:11:12Z",
    ] {
        let text = format!("t,x\n2026-11-22 10:11:12,1\n{wrong},1\n2026-11-22 10:11:13,1\n");
        assert!(
            error(&text, &stamped(&["x"]))
                .contains(&format!(":3: column t: invalid value: `{wrong}`, expected seconds, or a time such as"))
        );
    }
    assert!(error("t,x\n0,1\n2026-11-22 10:11:12,1\n", &stamped(&["x"])).contains("expected seconds, or a time"));
    assert!(error("t,x\n2026-11-22 10:11:12,1\n1,1\n", &stamped(&["x"])).contains("expected seconds, or a time"));
}

#[test]
fn time_stamps_of_loggers() {
    let day = |stamps: [&str; 3]| {
        let text: String = stamps.iter().map(|stamp| format!("{stamp};1\n")).collect();
        let (rows, flaws) = read(format!("t;x\n{text}").as_bytes(), &stamped(&["x"])).unwrap();
        assert!(flaws.is_empty(), "{flaws:?}");
        rows.into_iter().map(|row| row.time).collect::<Vec<_>>()
    };
    for stamps in [
        ["31.12.2026 23:59:59,9", "01.01.2027 00:00:00,0", "1.1.2027 00:00:00,1"],
        ["2026/12/31 23:59:59.9", "2027/01/01 00:00:00.0", "2027/01/01 00:00:00.1"],
        ["23:59:59.900", "00:00:00.000", "00:00:00.100"],
        ["11:59:59.9 PM", "12:00:00.0 AM", "12:00:00.1 AM"],
        ["2026-12-31 23:59:59.9 UTC", "2027-01-01 00:00:00.0 UTC", "2027-01-01 00:00:00.1 UTC"],
    ] {
        let found = day(stamps);
        assert!(found.iter().zip([0.0, 0.1, 0.2]).all(|(found, s)| (found - s).abs() < 1e-9), "{stamps:?}: {found:?}");
    }
    for (stamp, said) in [
        ("11/12/2026 10:11:12", "a date whose day and month are certain"),
        ("22-11-2026 10:11:12", "a date whose day and month are certain"),
        ("22.11.26 10:11:12", "a date whose day and month are certain"),
        ("2026-11-22 10:11:12 CET", "a zone by its offset"),
        ("2026-11-22 10:11:12 Europe/Berlin", "a zone by its offset"),
        ("11:12.3", "a time of day with hours, minutes and seconds"),
    ] {
        let found = error(&format!("t,x\n{stamp},1\n{stamp},2\n"), &stamped(&["x"]));
        assert!(found.contains(&format!(":2: column t: invalid value: `{stamp}`, expected {said}")), "{found}");
    }
}

#[test]
fn end_of_summer_time() {
    let stamp = |hour: u32, tenth: u32| format!("2026-10-25 {hour:02}:59:59.{tenth},1\n");
    let rows: String = (0..10).map(|i| stamp(2, i)).collect();
    let later: String = (0..10).map(|i| format!("2026-10-25 02:00:00.{i},1\n")).collect();
    let said = error(&format!("t,x\n{rows}{later}"), &stamped(&["x"]));
    assert!(said.starts_with("r.csv:12: time stamps go back by 1 h and go on, as at the end of summer time"), "{said}");
    // A single row of an earlier time is a flaw.
    let (_, flaws) =
        read(format!("t,x\n{rows}{}{}", stamp(1, 9), "2026-10-25 03:00:00.0,1\n").as_bytes(), &stamped(&["x"]))
            .unwrap();
    assert_eq!(flaws.len(), 1, "{flaws:?}");
}

#[test]
fn units_of_time_by_the_name_of_the_column() {
    let recording = |seconds| Recording { clock: Clock::Column { name: "t_ms".into(), seconds }, ..recording(&["x"]) };
    let text = "t_ms,x\n0,1\n1,1\n2,1\n";
    let said = error(text, &recording(None));
    assert!(said.contains("time stamps in ms by the name of the column, expected seconds, or time = {"), "{said}");
    let reader = reader(text.as_bytes(), &recording(Some(1e-3))).unwrap();
    assert!((reader.rate() - 1000.0).abs() < 1e-9);
}

#[test]
fn lines_above_and_below_the_names() {
    let of = recording(&["x", "y"]);
    let expected = [[1.5, 2.0], [3.5, 4.0]];
    for text in [
        "# logger\n# Time: 10:11:12, Device: 0\nt,x,y\n0,1.5,2\n1,3.5,4\n",
        "% t,x,y\n0,1.5,2\n1,3.5,4\n",
        ";Version,0.2\n;Samples,2\n;Rate,1000\nt,x,y\n0,1.5,2\n1,3.5,4\n",
        "sep=;\nt;x;y\n0;1,5;2\n1;3,5;4\n",
        "\"sep=,\"\r\nt,x,y\r\n0,1.5,2\r\n1,3.5,4\r\n",
        "t,x,y\ns,m,m\n0,1.5,2\n1,3.5,4\n",
        "t;x;y\n(s);(m);(m)\n;DE;DE\n\n0;1,5;2\n1;3,5;4\n",
        "My rig\nDate,22.11.2026\nOperator,A\n\nt,x,y\n0,1.5,2\n# pause\n1,3.5,4\n".replace("# pause\n", "").as_str(),
        "# rig\nt,x,y\n0,1.5,2\n# pause\n1,3.5,4\n",
        "Device,M2K\nx,y\n1.5,2\n3.5,4\n",
        "x,y\nm,m\n1.5,2\n3.5,4\n",
        "x,1,y\n1.5,0,2\n3.5,0,4\n",
    ] {
        assert_eq!(readings(text, &of), expected, "{text:?}");
    }
    let layout = |skip, comment| Recording {
        layout: FileLayout { skip, comment, ..FileLayout::default() },
        ..recording(&["x", "y"])
    };
    assert_eq!(readings("1,2\n3,4\nx,y\n1.5,2\n3.5,4\n", &layout(Some(2), None)), expected);
    assert_eq!(readings("! rig\nx,y\n1.5,2\n!\n3.5,4\n", &layout(None, Some(b'!'))), expected);
    // Lines and units are those of the file.
    let (rows, _) = read(b"# rig\nx,y\nm,m\n1.5,2\n3.5,4\n", &of).unwrap();
    assert_eq!((rows[0].line, rows[1].line), (4, 5));
    assert!(error("x,y\nmm,m\n1.5,2\n", &of).contains("unit differs from the scene's: `mm`"));
    // A row that is damaged remains an error.
    assert!(error("x,y\noops,2\n1.5,2\n", &of).contains("r.csv:2: column x: invalid value: `oops`"));
    assert!(error("x,y\n1,2\noops,bad\n1.5,2\n", &of).contains("r.csv:3: column x: invalid value: `oops`"));
    let reader = reader(b"# rig\nx,y\nm,m\n1.5,2\n", &of).unwrap();
    assert_eq!(
        reader.notes(),
        ["2 lines of the file beside the names of the columns are no rows, the first is line 1: `# rig`."]
    );
}

#[test]
fn words_for_missing_readings() {
    for word in ["OVL", "-Inf", "inf", "NaN", "", "1.#INF00", "-1.#IND", "#N/A", "n/a", "NULL"] {
        let (rows, flaws) = read(format!("x,y\n1,2\n{word},2\n3,4\n").as_bytes(), &recording(&["x", "y"])).unwrap();
        assert!(rows[1].probes[0].is_nan() && rows[1].probes[1] == 2.0, "{word}");
        assert_eq!((flaws.len(), flaws[0].count, flaws[0].first_line), (1, 1, 3), "{word}");
    }
    assert!(error("x\n1\n1e999\n", &recording(&["x"])).contains("invalid value: `1e999`"));
}

#[test]
fn wide_tables() {
    let cells = |cell: &str| vec![cell; 200_000].join(",");
    let names: Vec<String> = (0..200_000).map(|place| format!("c{place}")).collect();
    let text = format!("{}\n{}\n{}\n", names.join(","), cells("1.5"), cells("2.5"));
    assert_eq!(readings(&text, &recording(&["c0", "c199999"])), [[1.5, 1.5], [2.5, 2.5]]);
    let said = error(&vec!["name"; 1_000_000].join(","), &recording(&["x"]));
    assert!(said.starts_with("r.csv:1: a line longer than 4 MiB"), "{said}");
}

#[test]
fn text_without_a_header() {
    let expected = [[0.5, 2.0], [1.5, 3.0]];
    let aligned = "  5.0e-01   2.0e+00 \r\n  1.5e+00   3.0e+00\r\n";
    for text in
        [aligned, "0.5 2\n1.5 3\n", "0.5,2\n1.5,3\n", "\n0.5\t2\r\n1.5\t3\r\n", "0,5;2\n1,5;3\n", "0.5;2;\n1.5;3;\n"]
    {
        assert_eq!(readings(text, &headless(&["c0", "c1"])), expected, "{text:?}");
    }
    let said = error("0.5,2\n1.5,3\n", &recording(&["c0"]));
    assert!(
        said.contains("`0.5,2`, expected a line with the names of the columns, ") && said.ends_with("in the scene")
    );
    assert!(error("0,5;2\n1,5;3\n", &recording(&["c0"])).contains("numbers instead of a header"));
    assert!(error(aligned, &recording(&["c0"])).contains("numbers instead of a header"));
    let (rows, _) = read(b"\n0.5,2\n1.5,3\n", &headless(&["c1"])).unwrap();
    assert_eq!((rows[0].line, rows[1].line), (2, 3));
}

#[test]
fn preview_of_text_without_a_header() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("r.txt");
    std::fs::write(&path, "0.5\t2\n1.5\t3\n").unwrap();
    let found = preview(&path).unwrap();
    assert!(found.is_headless && found.columns.len() == 2 && found.columns[1].name == "c1");
}

/// Export of two measuring points: 4 samples per revolution, 3 revolutions, 3000 rpm, so 200 Hz.
fn export(variable: &str, times: [&str; 2]) -> String {
    let record = |point: &str, time: &str, sign: f64| {
        let samples: String =
            (0..12).map(|k| format!("{},{}\r\n", f64::from(k) * 5.0, sign * f64::from(k) * 0.5)).collect();
        format!(
            "Machine Name,STG-10\r\nPoint Name,{point}\r\nWf Amp,51.063\r\nNumber of Revs,3\r\nX-Axis Unit,ms\r\n\
             Y-Axis Unit,um\r\nSample Speed, 3000 rpm\r\nSample Status,Valid\r\nTimestamp,{time}\r\n\
             Variable,{variable}\r\nX-Axis Value,Y-Axis Value\r\n{samples}"
        )
    };
    format!("\u{feff}{}\r\n{}", record("1XD TURBINE", times[0], 1.0), record("1YD TURBINE", times[1], -1.0))
}

const TIME: &str = "9/21/2026 8:29:22 PM";

fn synchronous(columns: &[&str]) -> Recording {
    Recording { clock: Clock::Stated, rotation: RotationSource::Synchronous, ..recording(columns) }
}

#[test]
fn waveforms_of_system_1() {
    let text = export("Disp Wf(4X/3revs).KPH TURBINE", [TIME, TIME]);
    let of = synchronous(&["1XD TURBINE", "1YD TURBINE"]);
    assert!(error(&text, &of).contains("unit differs from the scene's: `um`, expected `m`"));
    let mut of = of;
    of.probes.iter_mut().for_each(|probe| probe.metres_per_unit = 1e-6);
    let mut reader = reader(text.as_bytes(), &of).unwrap();
    assert!((reader.rate() - 200.0).abs() < 1e-9);
    let (rows, flaws) = read(text.as_bytes(), &of).unwrap();
    assert!(flaws.is_empty(), "{flaws:?}");
    assert_eq!((rows.len(), rows[0].line, rows[3].probes[1]), (12, 12, -1.5e-6));
    // A quarter of a revolution each sample.
    let mut tracker = crate::rotation::Tracker::of(&of, reader.rate(), ballrace_scene::Speed::Constant(-300.0));
    let mut row = Row::default();
    while reader.next_row(&mut row).unwrap() {
        tracker.push(core::mem::take(&mut row)).unwrap();
    }
    tracker.finish().unwrap();
    for k in 0..12 {
        let sample = tracker.pop().unwrap();
        assert!((sample.total_revolutions() + f64::from(k) / 4.0).abs() < 1e-9, "{}", sample.total_revolutions());
    }
}

#[test]
fn records_of_system_1_that_do_not_fit() {
    let names = ["1XD TURBINE", "1YD TURBINE"];
    let metres = |text: &str| text.replace("Y-Axis Unit,um", "Y-Axis Unit,m");
    let of = synchronous(&names);
    let other = metres(&export("Disp Wf(4X/3revs)", [TIME, "9/21/2026 8:30:22 PM"]));
    assert!(error(&other, &of).contains(
        "Timestamp `9/21/2026 8:29:22 PM` of `1XD TURBINE` and `9/21/2026 8:30:22 PM` of `1YD TURBINE`, expected records of one time"
    ));
    assert_eq!(readings(&other, &synchronous(&names[1..])).len(), 12);
    // Two records of one point are numbered.
    let twice = other.replace("1YD", "1XD");
    assert!(error(&twice, &synchronous(&names[..1])).contains("expected one of `1XD TURBINE #1`, `1XD TURBINE #2`"));
    assert_eq!(readings(&twice, &synchronous(&["1XD TURBINE #2"]))[2], [-1.0]);
    let good = metres(&export("Disp Wf(4X/3revs)", [TIME, TIME]));
    for (from, to, said) in [
        ("3000 rpm", "50 Hz", ":7: column Sample Speed: invalid value: `50 Hz`, expected a number above 0 in rpm"),
        ("3000 rpm", "0 rpm", "expected a number above 0 in rpm"),
        ("Unit,ms", "Unit,rpm", "`X-Axis Unit` is `rpm` above line 11, no unit of time"),
        ("Point Name,1XD TURBINE", "Point Name,", "a record without `Point Name`"),
        ("5,0.5", "5,abc", ":13: column 1XD TURBINE: invalid value: `abc`"),
    ] {
        assert!(error(&good.replacen(from, to, 1), &of).contains(said), "{to}");
    }
    // Without a speed the rate follows from the X axis.
    let free =
        good.replace("Sample Speed, 3000 rpm\r\n", "").replace("Number of Revs,3\r\n", "").replace("(4X/3revs)", "");
    let of = Recording { clock: Clock::Stated, ..recording(&names) };
    assert!((reader(free.as_bytes(), &of).unwrap().rate() - 200.0).abs() < 1e-9);
    let of = synchronous(&names);
    assert_eq!(
        error(&free, &of),
        "r.csv: no samples in step with the shaft, expected a file that states its samples per revolution for keyphasor = \"synchronous\""
    );
    assert!(
        error("x,y\n1,2\n", &Recording { clock: Clock::Rate(1.0), ..synchronous(&["x"]) })
            .contains("no samples in step with the shaft")
    );
}

/// A part of an export is an error, or its rows with a flaw.
#[test]
fn exports_of_system_1_cut_short() {
    let text = export("Disp Wf(4X/3revs)", [TIME, TIME]).replace("Y-Axis Unit,um", "Y-Axis Unit,m");
    let of = synchronous(&["1XD TURBINE", "1YD TURBINE"]);
    let (whole, _) = read(text.as_bytes(), &of).unwrap();
    for length in 0..text.len() - 6 {
        if let Ok((rows, flaws)) = read(&text.as_bytes()[..length], &of) {
            assert!(!flaws.is_empty(), "{length}");
            let good = rows.iter().take_while(|row| !row.probes[0].is_nan()).count();
            assert_eq!(rows[..good], whole[..good]);
        }
    }
}
