//! Any bytes as a recording in a binary format: rows and flaws, or one error.
#![no_main]

use ballrace_twin::recording::{Reader, Row};
use ballrace_twin::scene::{Clock, Direction, FileLayout, Probe, Recording, RotationSource};
use libfuzzer_sys::fuzz_target;
use std::sync::LazyLock;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

/// Names of the columns that the seeds have.
const COLUMNS: [&str; 3] = ["c0", "x", "G/x"];

fn recording(column: &str) -> Recording {
    let probe = Probe {
        column: column.into(),
        metres_per_unit: 1.0,
        station: 0.0,
        coordinates: None,
        direction: Direction::Radial(0.0),
        noise: None,
        offset: 0.0,
        sensitivity: None,
    };
    Recording {
        temperatures: vec![],
        file: "fuzz".into(),
        clock: Clock::Rate(1000.0),
        probes: vec![probe],
        sensors: vec![],
        layout: FileLayout::default(),
        rotation: RotationSource::Scene,
        run_out: None,
        further_files: vec![],
        sequence: None,
        average: 1,
    }
}

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("recording.bin");
    std::fs::write(&path, bytes).expect("a file");
    for column in COLUMNS {
        let Ok(mut reader) = Reader::open(&path, &recording(column)) else { continue };
        let mut row = Row::default();
        while let Ok(true) = reader.next_row(&mut row) {
            assert!(row.time.is_finite() && !row.probes[0].is_infinite());
        }
    }
});
