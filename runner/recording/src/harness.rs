//! Helpers of the tests of all binary formats: a file from bytes, read, truncated at every length, and damaged.

use std::path::Path;

use tempfile::TempDir;

use super::error::RecordingError;
use super::flaws::FlawSummary;
use super::{Reader, Row};
use ballrace_scene::{Clock, Direction, FileLayout, Probe, Recording, RotationSource};

/// Upper bound of the memory of the tests, bytes, damaged files included.
const MAX_MEMORY: u64 = 1 << 30;

pub(super) fn probe(column: &str, metres_per_unit: f64) -> Probe {
    let direction = Direction::Radial(0.0);
    Probe {
        column: column.into(),
        metres_per_unit,
        station: 0.0,
        coordinates: None,
        direction,
        noise: None,
        offset: 0.0,
        sensitivity: None,
    }
}

/// Returns a recording with columns in metres at 1 kHz.
pub(super) fn recording(columns: &[&str]) -> Recording {
    Recording {
        average: 1,
        file: "r".into(),
        clock: Clock::Rate(1000.0),
        probes: columns.iter().map(|column| probe(column, 1.0)).collect(),
        sensors: vec![],
        layout: FileLayout::default(),
        temperatures: vec![],
        rotation: RotationSource::Scene,
        run_out: None,
        further_files: vec![],
        sequence: None,
    }
}

type Result<T> = core::result::Result<T, RecordingError>;

pub(super) fn read_file(path: &Path, recording: &Recording) -> Result<(Vec<Row>, Vec<FlawSummary>)> {
    let mut reader = Reader::open(path, recording)?;
    let (mut rows, mut row) = (Vec::new(), Row::default());
    while reader.next_row(&mut row)? {
        rows.push(row.clone());
        assert!(rows.len() < 1_000_000, "rows without end");
    }
    Ok((rows, reader.flaws().summary()))
}

/// The file `r.bin`, so that only its content identifies its format.
pub(super) struct Trial {
    folder: TempDir,
}

impl Trial {
    pub(super) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(super) fn read(&self, bytes: &[u8], recording: &Recording) -> Result<(Vec<Row>, Vec<FlawSummary>)> {
        let path = self.folder.path().join("r.bin");
        std::fs::write(&path, bytes).unwrap();
        read_file(&path, recording)
    }
}

/// Returns the values of the columns, row by row, of a file without flaws.
pub(super) fn values(bytes: &[u8], columns: &[&str]) -> Vec<Vec<f64>> {
    let (rows, flaws) = Trial::new().read(bytes, &recording(columns)).unwrap();
    assert!(flaws.is_empty(), "{flaws:?}");
    assert!(rows.iter().zip(1..).all(|(row, line)| row.line == line));
    rows.into_iter().map(|row| row.probes).collect()
}

/// Returns the error message for a file, without its path.
pub(super) fn error(bytes: &[u8], recording: &Recording) -> String {
    let message = Trial::new().read(bytes, recording).unwrap_err().to_string();
    assert!(!message.contains('\n'), "one sentence: {message}");
    message.split_once("r.bin").unwrap().1.to_owned()
}

/// Checks that the file is rejected or its rows are reported as short at every length, except at the lengths `sound`, at
/// which it is a valid file of fewer rows.
pub(super) fn cut_short(bytes: &[u8], columns: &[&str], sound: &[usize]) {
    let (trial, recording) = (Trial::new(), recording(columns));
    let whole = trial.read(bytes, &recording).unwrap().0;
    for length in 0..bytes.len() {
        match trial.read(&bytes[..length], &recording) {
            Ok((rows, flaws)) => {
                assert!(!flaws.is_empty() || sound.contains(&length), "{length}: {} rows", rows.len());
                let good = rows.iter().take_while(|row| !row.probes[0].is_nan()).count();
                assert_eq!(rows[..good], whole[..good], "{length}");
            }
            Err(error) => assert!(!error.to_string().contains('\n'), "{error}"),
        }
    }
}

/// Checks two thousand files with one to eight inverted bits: an error or rows, in bounded memory.
pub(super) fn damaged(bytes: &[u8], columns: &[&str]) {
    let (trial, recording) = (Trial::new(), recording(columns));
    let mut seed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed % below as u64) as usize
    };
    let mut refused = 0;
    for _ in 0..2000 {
        let mut bytes = bytes.to_vec();
        for _ in 0..=random(8) {
            let bit = random(8 * bytes.len());
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        refused += usize::from(trial.read(&bytes, &recording).is_err());
    }
    let most = most_memory();
    println!("{refused} of 2000 refused, at most {most} bytes of memory");
    assert!(most < MAX_MEMORY, "{most} bytes");
}

/// Returns the peak memory of the process, bytes; 0 where the system does not report it.
fn most_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) * 1024
}
