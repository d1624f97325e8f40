use super::*;
use crate::harness::recording;

fn folder(names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for name in names {
        std::fs::write(folder.path().join(name), "x\n1\n").unwrap();
    }
    folder
}

fn of(folder: &Path) -> Result<Files, RecordingError> {
    Files::of(folder, &Recording { sequence: Some(Sequence::Snapshots), ..recording(&["x"]) })
}

fn names(files: &Files) -> Vec<String> {
    files.paths.iter().map(|path| shown(path)).collect()
}

#[test]
fn names_are_in_natural_order() {
    let found = folder(&["acc_10.csv", "acc_2.csv", "acc_1.csv", ".acc_3.csv", "read me.md", "scene.toml"]);
    std::fs::create_dir(found.path().join("inner.csv")).unwrap();
    let files = of(found.path()).unwrap();
    assert_eq!(names(&files), ["acc_1.csv", "acc_2.csv", "acc_10.csv"]);
    assert_eq!(
        files.notes,
        [
            "3 files from acc_1.csv to acc_10.csv, one snapshot each.",
            "Files of the folder that are hidden or not .csv are omitted: .acc_3.csv, read me.md, scene.toml."
        ]
    );
    let order = ["2", "02", "10", "a", "a1b2", "a1b10", "a2"];
    for pair in order.windows(2) {
        assert!(natural_key(pair[0]) <= natural_key(pair[1]), "{pair:?}");
    }
}

#[test]
fn names_of_dates_have_no_ending() {
    let found = folder(&["2003.10.22.12.16.24", "2003.10.22.12.06.24", "2003.10.22.9.06.24"]);
    assert_eq!(names(&of(found.path()).unwrap()), ["2003.10.22.9.06.24", "2003.10.22.12.06.24", "2003.10.22.12.16.24"]);
}

#[test]
fn folders_that_cannot_be_read() {
    let error = |names: &[&str]| of(folder(names).path()).unwrap_err().to_string();
    assert!(error(&[]).ends_with(": empty folder, expected files of a recording"));
    assert!(
        error(&["a.md", ".b.csv"])
            .ends_with(": folder without a recording: 2 other files, expected files of a recording")
    );
    let two = folder(&["a1.csv", "a2.csv"]);
    let absent = Files::of(two.path(), &recording(&["x"])).unwrap_err();
    assert!(absent.is_scene_fault());
    assert!(
        absent.to_string().ends_with(
            ": 2 files from a1.csv to a2.csv without [recording] sequence, expected \"continuous\" where each file goes on where the \
             one before ends, or \"snapshots\" where an unknown time is between them"
        ),
        "{absent}"
    );
}

#[test]
fn times_in_names() {
    let time = |name: &str| time_in_name(Path::new(name)).map(|time| time.to_string());
    for name in ["2003.10.22.12.06.24", "rig_20031022_120624.csv", "r1-2003-10-22T12:06:24.npy", "20031022120624.csv"] {
        assert_eq!(time(name).as_deref(), Some("2003-10-22T12:06:24Z"), "{name}");
    }
    assert_eq!(time("a_2003-10-22_12-06.csv").as_deref(), Some("2003-10-22T12:06:00Z"));
    for name in ["acc_00001.csv", "2003.csv", "2003.13.22.12.06.24", "123.csv", "x"] {
        assert_eq!(time(name), None, "{name}");
    }
}
