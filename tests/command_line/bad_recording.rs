//! Recordings that are wrong: exit code 1 (2 where the scene asks for what is not there), or a flaw that is counted
//! and told while the replay goes on.

use serde_json::Value;

use crate::support::{
    DEMO_SCENE, SHORT, Sandbox, TURN, edited_recording, list, number, scene, short_recording, with_cell,
};

const REPLAY: [&str; 4] = ["replay", "scene.toml", "--forces", "forces.csv"];

/// Columns of the demonstration's recording.
const DE_X: usize = 1;
const DE_Y: usize = 2;

/// This recording is rejected with the demonstration's scene.
fn refused(recording: impl AsRef<[u8]>, code: i32, parts: &[&str]) {
    let sandbox = Sandbox::rig();
    sandbox.put("healthy.csv", recording);
    sandbox.refused(&REPLAY, code, parts);
}

#[test]
fn missing() {
    let sandbox = Sandbox::rig();
    std::fs::remove_file(sandbox.path("healthy.csv")).unwrap();
    sandbox.refused(&REPLAY, 1, &["healthy.csv: cannot be opened: "]);
    let answer = sandbox.run(&["replay", "scene.toml", "--recording", "other.csv"]);
    assert_eq!(answer.err.matches("other.csv: cannot be opened").count(), 1, "{answer:?}");
    assert_eq!(answer.err.matches("os error").count(), 1, "the reason is told once: {answer:?}");
}

#[test]
fn folder() {
    let sandbox = Sandbox::rig();
    std::fs::create_dir(sandbox.path("notes")).unwrap();
    sandbox.put("notes/today.txt.bak", "nothing");
    let args = [&REPLAY[..], &["--recording", "notes"]].concat();
    sandbox.refused(&args, 1, &["notes: folder without a recording: 1 other file, expected files of a recording"]);
}

#[test]
fn empty() {
    refused("", 1, &["healthy.csv: empty file, expected a line of column names and a row for each sample"]);
    refused("\n\n", 1, &["healthy.csv: empty file"]);
}

#[test]
fn header_only() {
    refused(short_recording(0), 1, &["healthy.csv: no row below the header, expected a row for each sample"]);
}

/// The keyphasor's levels seem to change again and again within few samples; this recording overflowed the stack.
#[test]
fn a_keyphasor_whose_levels_change_in_every_revolution() {
    let sandbox = Sandbox::rig();
    sandbox.put("healthy.csv", include_bytes!("../fuzz/corpus/csv/nested-levels.csv"));
    let answer = sandbox.run(&REPLAY);
    assert_eq!(answer.code, Some(4), "{answer:?}");
    assert!(answer.out.starts_with("The recording is not plausible for the scene: shaft speed: "), "{answer:?}");
}

#[test]
fn no_header() {
    let rows = short_recording(300).lines().skip(1).collect::<Vec<_>>().join("\n");
    refused(
        rows,
        1,
        &[
            "healthy.csv:1: numbers instead of a header: `0.0000000,0.090,",
            "expected a line with the names of the columns",
        ],
    );
}

#[test]
fn binary() {
    let parts = [
        "healthy.csv:1: not plain text (binary, or UTF-16 without a byte order mark), expected a line of column names",
    ];
    refused([b'R', b'I', b'F', b'F', 0, 1, 2, 0xff], 1, &parts);
}

#[test]
fn column_that_is_absent() {
    let columns = "expected one of `time_s`, `DE_X_um`, `DE_Y_um`, `NDE_X_um`, `NDE_Y_um`, `axial_um`, `keyphasor`";
    for (from, to, missing, hint) in [
        ("\"DE_X_um\"", "\"de_x_mm\"", "`de_x_mm`", " (did you mean `DE_X_um`?)"),
        ("column = \"keyphasor\"", "column = \"temperature\"", "`temperature`", ""),
        ("rate = \"12.8 kHz\"", "time = \"time\"", "`time`", " (did you mean `time_s`?)"),
    ] {
        let sandbox = Sandbox::with(&scene(&[(from, to)]), &short_recording(SHORT));
        sandbox.refused(&REPLAY, 2, &[&format!("healthy.csv:1: no such column: {missing}{hint}, {columns}")]);
    }
}

#[test]
fn column_that_is_there_twice() {
    let twice = short_recording(SHORT).replace("DE_Y_um,NDE", "DE_X_um,NDE");
    refused(twice, 1, &["healthy.csv:1: repeated column: `DE_X_um`, expected each name once"]);
}

#[test]
fn text_in_a_cell() {
    let text = edited(100, |row| with_cell(row, DE_Y, "oops"));
    refused(text, 1, &["healthy.csv:100: column DE_Y_um: invalid value: `oops`, expected a number, or NaN or nothing"]);
}

/// A word, an infinity or nothing in place of a reading: a missing value at its position, as for NaN.
#[test]
fn overload_in_a_cell() {
    for cell in ["OVL", "-Inf", "inf", "1.#INF00", "n/a"] {
        let text = edited(1001, |row| with_cell(row, DE_Y, cell));
        let said = "DE_Y_um: no value in 1 sample, at line 1001 (0.078047 s)";
        let outcome = flawed(DEMO_SCENE, &text, &[("missing_value", Some("DE_Y_um"), 1001, 1, 1, said)]);
        assert_eq!(number(&outcome, "/record/compared"), SHORT as f64 - 1.0, "{cell}");
    }
}

/// Three of a hundred samples at the upper end of a probe with noise in coarse steps.
#[test]
fn clipped_probe() {
    let plain = short_recording(SHORT);
    let reading = |row: &str| row.split(',').nth(DE_X).and_then(|cell| cell.parse::<f64>().ok());
    let mut readings: Vec<f64> = plain.lines().skip(1).filter_map(reading).collect();
    readings.sort_by(f64::total_cmp);
    let rail = readings[SHORT * 97 / 100];
    let clipped = edited_recording(|_, row| {
        let clipped = reading(row).is_some_and(|reading| reading > rail);
        vec![if clipped { with_cell(row, DE_X, &format!("{rail:.3}")) } else { row.into() }]
    });
    for (text, is_clipped) in [(&plain, false), (&clipped, true)] {
        let outcome = Sandbox::with(DEMO_SCENE, text).replay("scene.toml", &[]);
        let flaws = list(&outcome, "flaws");
        let found = flaws.iter().any(|flaw| flaw["kind"] == "clipped_probe" && flaw["column"] == "DE_X_um");
        assert_eq!(found, is_clipped, "{flaws:?}");
    }
}

/// Lines above the rows, and clocks of loggers: the figures are those of the plain recording.
#[test]
fn lines_above_the_rows() {
    let plain = short_recording(SHORT);
    let (names, rows) = plain.split_once('\n').unwrap();
    let expected = Sandbox::with(DEMO_SCENE, &plain).replay("scene.toml", &[]);
    let units = "s,um,um,um,um,um,V";
    for text in [
        format!("# logger 5\n# rate: 12800 Hz\n{plain}"),
        format!(";Scopy version,0.2\n;Sample rate,12800\n;Tool,Oscilloscope\n{plain}"),
        format!("sep=,\n{plain}"),
        format!("{names}\n{units}\n{rows}"),
        format!("{names}\n{units}\n,DE,DE,NDE,NDE,NDE,shaft\n{rows}"),
        format!("# {names}\n{rows}"),
    ] {
        let found = Sandbox::with(DEMO_SCENE, &text).replay("scene.toml", &[]);
        assert_eq!(found["probes"], expected["probes"], "{}", &text[..200]);
    }
    let sandbox = Sandbox::with(
        &scene(&[("rate = \"12.8 kHz\"", "rate = \"12.8 kHz\"\nskip = 2")]),
        &format!("1,2\n3,4\n{plain}"),
    );
    assert_eq!(sandbox.replay("scene.toml", &[])["probes"], expected["probes"]);
}

/// Time stamps in another unit than seconds are refused by name, and read with their unit.
#[test]
fn time_in_another_unit() {
    let text = |stamp: &dyn Fn(f64) -> String| {
        edited_recording(|line, row| {
            vec![if line == 1 { row.into() } else { with_cell(row, 0, &stamp((line - 2) as f64 / 12_800.0)) }]
        })
    };
    let milliseconds = text(&|time| format!("{:.4}", 1_764_151_872_000.0 + 1e3 * time));
    let days = text(&|time| format!("{:.15}", 45_983.4 + time / 86_400.0));
    let sandbox = Sandbox::with(&timed(), &milliseconds);
    sandbox.refused(
        &REPLAY,
        2,
        &["milliseconds since 1970, expected seconds, or time = { column = \"time_s\", unit = \"ms\" }"],
    );
    let sandbox = Sandbox::with(&timed(), &days);
    let said = "time stamps of 45983.4, days since 1900 as Excel counts them, expected seconds, or time = {";
    sandbox.refused(&REPLAY, 2, &[said]);
    // `check` does not look for another number of marks.
    sandbox.refused(&["check", "scene.toml"], 2, &[said]);
    let nanoseconds = text(&|time| format!("{:.0}", 1e9 * time));
    let sandbox = Sandbox::with(&timed(), &nanoseconds);
    for command in [&REPLAY[..], &["check", "scene.toml"]] {
        let said = ["sampling rate from its time stamps: implausible rate", "in ns the rate is plausible"];
        sandbox.refused(command, 1, &said);
    }
    for (unit, text) in [("ms", &milliseconds), ("d", &days)] {
        let time = format!("time = {{ column = \"time_s\", unit = \"{unit}\" }}");
        let outcome = Sandbox::with(&scene(&[("rate = \"12.8 kHz\"", &time)]), text).replay("scene.toml", &[]);
        assert_eq!(number(&outcome, "/record/samples"), SHORT as f64);
        assert!((number(&outcome, "/record/duration_s") - (SHORT - 1) as f64 / 12_800.0).abs() < 1e-5, "{unit}");
    }
}

#[test]
fn more_cells_than_names() {
    let text = edited(1000, |row| format!("{row},0"));
    refused(text, 1, &["healthy.csv:1000: too many cells: 8, expected 7 as in the header"]);
}

#[test]
fn time_that_does_not_run() {
    let still = edited_recording(|line, row| vec![if line > 1 { with_cell(row, 0, "0.5") } else { row.into() }]);
    let sandbox = Sandbox::with(&timed(), &still);
    let said = "healthy.csv: column time_s: a clock with a resolution coarser than a sample: the first 1000 time stamps are \
                equal, expected time stamps in seconds";
    sandbox.refused(&REPLAY, 1, &[said]);
}

/// Blocks of equal stamps from a clock of 1 ms, as numbers and as times: the error names resolution, rate and key.
#[test]
fn time_from_a_clock_coarser_than_a_sample() {
    let stamps: [&dyn Fn(f64) -> String; 2] = [&|time| format!("{:.3}", (time * 1e3).floor() / 1e3), &|time| {
        format!("2026-11-22T10:11:12.{:03.0}", (time * 1e3).floor())
    }];
    for stamp in stamps {
        let stamped = |line: usize, row: &str| {
            vec![if line > 1 { with_cell(row, 0, &stamp((line - 2) as f64 / 12_800.0)) } else { row.into() }]
        };
        let sandbox = Sandbox::with(&timed(), &edited_recording(stamped));
        let said = "healthy.csv: column time_s: a clock with a resolution of 0.001 s, coarser than a sample: 921 of the first 1000 \
                    time stamps repeat the one before (about 12800 rows a second), expected time stamps in seconds that rise from \
                    row to row, or `rate` instead of `time` in the scene";
        sandbox.refused(&REPLAY, 1, &[said]);
    }
}

/// The demonstration's scene with its samples placed by their time stamps.
fn timed() -> String {
    scene(&[("rate = \"12.8 kHz\"", "time = \"time_s\"")])
}

/// The short recording with one line (the header is line 1) edited.
fn edited(line: usize, edit: impl Fn(&str) -> String) -> String {
    edited_recording(|i, row| vec![if i == line { edit(row) } else { row.into() }])
}

/// Expected flaw: kind, column, line of the first, how often, samples, sentence.
type Flaw<'a> = (&'a str, Option<&'a str>, u64, u64, u64, &'a str);

/// Replays a recording to its end; its flaws are exactly those wanted, in JSON, in the text and in the report.
fn flawed(scene: &str, recording: &str, wanted: &[Flaw]) -> Value {
    let sandbox = Sandbox::with(scene, recording);
    let outcome = sandbox.replay("scene.toml", &["--forces", "forces.csv"]);
    let text = sandbox.done(&["replay", "scene.toml"]).out.split_whitespace().collect::<Vec<_>>().join(" ");
    let flaws = list(&outcome, "flaws");
    assert_eq!(flaws.len(), wanted.len(), "{flaws:#?}");
    for (flaw, (kind, column, line, count, samples, sentence)) in flaws.iter().zip(wanted) {
        assert_eq!((flaw["kind"].as_str(), flaw["column"].as_str()), (Some(*kind), *column));
        assert_eq!(flaw["first_line"].as_u64(), Some(*line), "{flaw:#}");
        assert_eq!((flaw["count"].as_u64(), flaw["samples_affected"].as_u64()), (Some(*count), Some(*samples)));
        let said = flaw["sentence"].as_str().unwrap();
        assert!(said.contains(sentence), "{said}");
        assert!(text.contains(said), "the text lacks {said:?}: {text}");
        assert!(sandbox.read("scene-report.html").contains(said), "the report lacks {said:?}");
    }
    let rows = sandbox.read("forces.csv").lines().count() as f64 - 1.0;
    assert_eq!(rows, number(&outcome, "/record/samples"), "a row of forces for every sample");
    outcome
}

/// Samples whose force is the one before, at each bearing.
fn held(outcome: &Value) -> f64 {
    let held = [0, 1].map(|i| number(outcome, &format!("/bearings/{i}/held_samples")));
    assert_eq!(held[0], held[1]);
    held[0]
}

#[test]
fn nothing_is_wrong_with_the_short_recording() {
    for scene in [DEMO_SCENE, &timed()] {
        let outcome = flawed(scene, &short_recording(SHORT), &[]);
        assert_eq!(number(&outcome, "/record/compared"), SHORT as f64);
        assert_eq!(held(&outcome), 0.0);
    }
}

#[test]
fn not_a_number_in_a_cell() {
    for cell in ["NaN", "nan", ""] {
        let text = edited(1001, |row| with_cell(row, DE_Y, cell));
        let said = "DE_Y_um: no value in 1 sample, at line 1001 (0.078047 s)";
        let outcome = flawed(DEMO_SCENE, &text, &[("missing_value", Some("DE_Y_um"), 1001, 1, 1, said)]);
        assert_eq!(number(&outcome, "/record/compared"), SHORT as f64 - 1.0);
        assert_eq!(held(&outcome), 1.0);
    }
}

#[test]
fn last_row_cut_short() {
    let whole = short_recording(SHORT);
    let cut = &whole[..whole.len() - 20];
    let line = SHORT as u64 + 1;
    let said = "1 row truncated, at line 2049 (0.159922 s)";
    let outcome = flawed(DEMO_SCENE, cut, &[("short_row", None, line, 1, 1, said)]);
    assert_eq!(number(&outcome, "/record/samples"), SHORT as f64);
    assert_eq!(held(&outcome), 1.0);
}

#[test]
fn repeated_and_backward_time_stamps() {
    let mut early = String::new();
    let text = edited_recording(|line, row| {
        if line == 300 {
            early = row.into();
        }
        match line {
            1000 => vec![row.into(), row.into()],
            1500 => vec![row.into(), early.clone()],
            _ => vec![row.into()],
        }
    });
    let repeated = "time_s: 1 row omitted for a repeated time stamp, at line 1001 (0.077969 s)";
    let backward = "time_s: 1 row omitted for a time stamp that goes back, at line 1502 (0.023281 s)";
    let wanted = [
        ("repeated_time_stamp", Some("time_s"), 1001, 1, 1, repeated),
        ("backward_time_stamp", Some("time_s"), 1502, 1, 1, backward),
    ];
    let outcome = flawed(&timed(), &text, &wanted);
    assert_eq!(number(&outcome, "/record/samples"), SHORT as f64);
}

#[test]
fn gap() {
    let text = edited_recording(|line, row| if (1101..1201).contains(&line) { vec![] } else { vec![row.into()] });
    let said = "100 samples missing in 1 gap, at line 1101 (0.093672 s)";
    let outcome = flawed(&timed(), &text, &[("gap", None, 1101, 1, 100, said)]);
    assert_eq!(number(&outcome, "/record/samples"), SHORT as f64 - 100.0);
    let end = (SHORT - 1) as f64 / 12_800.0;
    assert!((number(&outcome, "/record/duration_s") - end).abs() < 1e-6, "time goes on over the gap");
    let residual = number(&outcome, "/probes/0/residual_rms_um");
    assert!(residual < 1.5 * number(&outcome, "/probes/0/noise_um"), "the twin coasts over the gap: {residual}");
}

#[test]
fn gap_over_a_pulse() {
    let text = edited_recording(|line, row| if (1001..1301).contains(&line) { vec![] } else { vec![row.into()] });
    let wanted = [
        ("gap", None, 1001, 1, 300, "300 samples missing in 1 gap"),
        ("missed_pulse", Some("keyphasor"), 1238, 1, 2, "keyphasor: 2 pulses missing and filled in"),
    ];
    let outcome = flawed(&timed(), &text, &wanted);
    assert!((number(&outcome, "/record/turns") - (SHORT - 1) as f64 / TURN as f64).abs() < 1e-3);
}

#[test]
fn stuck_probe() {
    let stuck = |line: usize| (601..901).contains(&line);
    let text = edited_recording(|line, row| vec![if stuck(line) { with_cell(row, DE_X, "0.105") } else { row.into() }]);
    let said = "DE_X_um: stuck at 0.105 um from line 601 for 300 samples";
    let outcome = flawed(DEMO_SCENE, &text, &[("stuck_probe", Some("DE_X_um"), 601, 1, 300, said)]);
    // It takes 10 ms, 128 samples, to be sure.
    assert_eq!(held(&outcome), 300.0 - 127.0);
}

#[test]
fn probe_that_is_dead_throughout() {
    let text = edited_recording(|line, row| vec![if line > 1 { with_cell(row, DE_X, "0.105") } else { row.into() }]);
    let said = "DE_X_um: stuck at 0.105 um from line 2 for 2048 samples";
    flawed(DEMO_SCENE, &text, &[("stuck_probe", Some("DE_X_um"), 2, 1, SHORT as u64, said)]);
}

#[test]
fn probe_without_a_reading_throughout() {
    let text = edited_recording(|line, row| vec![if line > 1 { with_cell(row, DE_X, "") } else { row.into() }]);
    let wanted = ("missing_value", Some("DE_X_um"), 2, 1, SHORT as u64, "DE_X_um: no value in 2048 samples");
    let outcome = flawed(DEMO_SCENE, &text, &[wanted]);
    assert_eq!((number(&outcome, "/record/compared"), held(&outcome)), (0.0, SHORT as f64));
}
