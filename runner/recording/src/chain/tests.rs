use std::path::Path;

use crate::error::RecordingError;
use crate::harness::recording;
use crate::{Reader, Row};
use ballrace_scene::{Clock, Recording, Sequence};

/// A folder with these files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

fn continuous() -> Recording {
    Recording { sequence: Some(Sequence::Continuous), ..recording(&["x"]) }
}

fn timed() -> Recording {
    Recording { clock: Clock::column("t"), ..continuous() }
}

fn rows(path: &Path, recording: &Recording) -> Result<(Vec<Row>, Vec<String>), RecordingError> {
    let mut reader = Reader::open(path, recording)?;
    let (mut rows, mut row) = (vec![], Row::default());
    while reader.next_row(&mut row)? {
        rows.push(row.clone());
    }
    Ok((rows, reader.notes()))
}

fn error(files: &[(&str, &str)], recording: &Recording) -> String {
    let folder = folder(files);
    let text = rows(folder.path(), recording).unwrap_err().to_string();
    text.replace(&format!("{}/", folder.path().display()), "")
}

#[test]
fn rows_follow_each_other_at_a_rate() {
    let folder = folder(&[("r2.csv", "x\n3\n"), ("r10.csv", "x\n4\n5\n"), ("r1.csv", "x\n1\n2\n")]);
    let (rows, notes) = rows(folder.path(), &continuous()).unwrap();
    assert_eq!(rows.iter().map(|row| row.probes[0]).collect::<Vec<_>>(), [1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(rows.iter().map(|row| row.index).collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    assert_eq!(notes, ["3 files from r1.csv to r10.csv, one continuous recording."]);
}

#[test]
fn gaps_between_files_are_found_by_the_clock() {
    let dates = |first: u32| {
        let line = |i: u32| format!("2026-11-22T10:11:12.{:03},{i}\n", first + i);
        format!("t,x\n{}", (0..20).map(line).collect::<String>())
    };
    let seconds = |first: u32| {
        let line = |i: u32| format!("0.{:03},{i}\n", first + i);
        format!("t,x\n{}", (0..20).map(line).collect::<String>())
    };
    for text in [&dates as &dyn Fn(u32) -> String, &seconds] {
        let folder = folder(&[("1.csv", &text(100)), ("2.csv", &text(120)), ("3.csv", &text(145))]);
        let (rows, _) = rows(folder.path(), &timed()).unwrap();
        let index = |i: usize| rows[i].index;
        assert_eq!((rows.len(), index(19), index(20), index(39), index(40)), (60, 19, 20, 39, 45));
    }
}

#[test]
fn files_that_do_not_agree() {
    let good = ("1.csv", "x,y\n1,2\n3,4\n");
    assert_eq!(
        error(&[good, ("2.csv", "x,z\n1,2\n")], &continuous()),
        "2.csv: columns differ from those of 1.csv: `x`, `z`, expected `x`, `y`"
    );
    assert_eq!(
        error(&[good, ("2.csv", "x,y\n5,6\n"), ("3.csv", "x,y\n1,2\nsix,7\n")], &continuous()),
        "3.csv:3: column x: invalid value: `six`, expected a number, or NaN or nothing where the reading is missing"
    );
    assert!(
        error(&[good, ("2.csv", "x,y\n5,6\n"), ("3.csv", "x,y\n1e999,7\n")], &continuous()).starts_with("3.csv:2: ")
    );
    assert_eq!(
        error(&[good, ("2.csv", "x,y\n")], &continuous()),
        "2.csv: no row below the header, expected a row for each sample"
    );
    let timed_rows = "t,x\n0.001,1\n0.002,1\n0.003,1\n";
    assert_eq!(
        error(&[("1.csv", timed_rows), ("2.csv", timed_rows)], &timed()),
        "2.csv: time stamps begin at 0.001 s, before the end of 1.csv at 0.003 s, expected files in the order of their time; where \
         the time of each file begins again, `rate` instead of `time`"
    );
    let dated = "t,x\n2026-11-22T10:11:12.100,1\n";
    assert_eq!(
        error(&[("1.csv", timed_rows), ("2.csv", dated)], &timed()),
        "2.csv: time stamps differ from those of 1.csv: dates without a zone, expected seconds"
    );
}

#[test]
fn lists_of_files() {
    let folder = folder(&[("b.csv", "x\n1\n"), ("a.csv", "x\n2\n")]);
    let path = |name: &str| folder.path().join(name);
    let list = Recording { file: path("b.csv"), further_files: vec![path("a.csv")], ..continuous() };
    let (all, _) = rows(&list.file, &list).unwrap();
    assert_eq!(all.iter().map(|row| row.probes[0]).collect::<Vec<_>>(), [1.0, 2.0]);
    // Another recording replaces the whole list.
    assert_eq!(rows(&path("a.csv"), &list).unwrap().0.len(), 1);
    let absent = Recording { further_files: vec![path("a.csv"), path("c.csv")], ..list };
    let error = rows(&absent.file, &absent).unwrap_err().to_string();
    assert!(error.contains("c.csv: cannot be opened: "), "{error}");
}
