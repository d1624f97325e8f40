//! Errors of reading a recording.

use ballrace_base::printable::name;
use std::io;
use std::path::{Path, PathBuf};

/// Largest number of column names in a message.
const COLUMNS_SHOWN: usize = 30;

/// Error that stops the reading of a recording; other flaws are counted in the ledger.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The file cannot be opened.
    #[error("{file}: cannot be opened: {cause}")]
    Open {
        /// The recording.
        file: PathBuf,
        /// The system's error. Not a `source`: the message contains it.
        cause: io::Error,
    },
    /// A folder without a file of a recording.
    #[error("{file}: {}, expected files of a recording", other_files(*.files))]
    Folder {
        /// The path.
        file: PathBuf,
        /// Number of other files in it.
        files: usize,
    },
    /// A folder in place of a file.
    #[error("{file}: a folder, expected one of its files")]
    NoFile {
        /// The path.
        file: PathBuf,
    },
    /// Several files whose sequence the scene does not state.
    #[error(
        "{file}: {count} files from {first} to {last} without [recording] sequence, expected \"continuous\" where each file goes on where the one before ends, or \"snapshots\" where an unknown time is between them"
    )]
    NoSequence {
        /// The folder or the first file.
        file: PathBuf,
        /// Number of files.
        count: usize,
        /// Name of the first file.
        first: String,
        /// Name of the last file.
        last: String,
    },
    /// A file of a continuous recording differs from the first.
    #[error("{file}: {subject} differ from those of {first}: {found}, expected {expected}")]
    Differs {
        /// The file.
        file: PathBuf,
        /// Name of the first file.
        first: Box<str>,
        /// Property in which they differ.
        subject: &'static str,
        /// Found in the file.
        found: Box<str>,
        /// Found in the first file.
        expected: Box<str>,
    },
    /// The time stamps of a continuous recording go back from one file to the next.
    #[error(
        "{file}: time stamps begin at {found} s, before the end of {before} at {end} s, expected files in the order of their time; where the time of each file begins again, `rate` instead of `time`"
    )]
    Order {
        /// The file.
        file: PathBuf,
        /// The file before it.
        before: PathBuf,
        /// First time stamp of the file, s.
        found: f64,
        /// Last time stamp of the file before, s.
        end: f64,
    },
    /// A binary file that cannot be used.
    #[error("{file}: unreadable file: {found}, expected {expected}")]
    Format {
        /// The recording.
        file: PathBuf,
        /// Content of the file.
        found: String,
        /// Content expected.
        expected: &'static str,
    },
    /// A vector that is not one of instants of pulses.
    #[error("{file}: column {column}: {found}, expected instants of pulses that rise, in the time of the samples", column = name(.column))]
    Instants {
        /// The recording.
        file: PathBuf,
        /// Name of the column.
        column: String,
        /// Content of the vector.
        found: String,
    },
    /// The units of file and scene differ.
    #[error("{file}: column {column}: unit differs from the scene's: `{found}`, expected `{expected}` or no unit", column = name(.column), found = name(.found))]
    Unit {
        /// The recording.
        file: PathBuf,
        /// Name of the column.
        column: String,
        /// Unit in the file.
        found: String,
        /// Unit in the scene.
        expected: String,
    },
    /// The sampling rates of file and scene differ.
    #[error("{file}: sampling rate differs from the scene's: {found} Hz, expected {expected} Hz within 0.1 %")]
    Rate {
        /// The recording.
        file: PathBuf,
        /// Rate in the file, Hz.
        found: f64,
        /// Rate in the scene, Hz.
        expected: f64,
    },
    /// The file cannot be read to its end.
    #[error("{file}:{line}: cannot be read after this line: {cause}")]
    Read {
        /// The recording.
        file: PathBuf,
        /// Last complete line.
        line: u64,
        /// The system's error. Not a `source`: the message contains it.
        cause: io::Error,
    },
    /// The file is empty or has blank lines only.
    #[error("{file}: empty file, expected a line of column names and a row for each sample")]
    Empty {
        /// The recording.
        file: PathBuf,
    },
    /// The file is not text.
    #[error(
        "{file}:{line}: not plain text (binary, or UTF-16 without a byte order mark), expected a line of column names in UTF-8"
    )]
    NotText {
        /// The recording.
        file: PathBuf,
        /// First line that is not text.
        line: u64,
    },
    /// A line above the rows is too long.
    #[error("{file}:{line}: a line longer than 4 MiB, expected lines of text")]
    LongLine {
        /// The recording.
        file: PathBuf,
        /// The line.
        line: u64,
    },
    /// The first line has numbers instead of column names.
    #[error(
        "{file}:{line}: numbers instead of a header: `{found}`, expected a line with the names of the columns, `skip` with the number of lines above it, or `header = false` in the scene"
    )]
    NoHeader {
        /// The recording.
        file: PathBuf,
        /// The first line that is not blank.
        line: u64,
        /// Its text, shortened.
        found: String,
    },
    /// The file has a header and no row.
    #[error("{file}: no row below the header, expected a row for each sample")]
    NoRows {
        /// The recording.
        file: PathBuf,
    },
    /// The scene names a column that the file lacks.
    #[error("{file}{at}: no such column: `{column}`{hint}, expected one of {found}", column = name(.column), at = at_line(*.line), hint = did_you_mean(.nearest.as_deref()))]
    AbsentColumn {
        /// The recording.
        file: PathBuf,
        /// Line of the header, where the file has lines.
        line: Option<u64>,
        /// Name of the column in the scene.
        column: String,
        /// Names of the columns in the file.
        found: String,
        /// Most similar name in the file, where one is similar.
        nearest: Option<String>,
    },
    /// A key of the scene that the format does not have.
    #[error("{file}: [recording] {key}: misplaced key, expected {expected}")]
    Misplaced {
        /// The recording.
        file: PathBuf,
        /// The key.
        key: &'static str,
        /// Formats that have it.
        expected: &'static str,
    },
    /// The scene names a single number that the file lacks.
    #[error("{file}: no such single number: `{number}`, expected {found}", number = name(.number))]
    AbsentNumber {
        /// The recording.
        file: PathBuf,
        /// Name of the number in the scene.
        number: String,
        /// Names of the single numbers in the file, or another form of the value.
        found: String,
    },
    /// The rate in the file is no sampling rate.
    #[error("{file}: sampling rate of the file: {found}, expected {expected}")]
    StatedRate {
        /// The recording.
        file: PathBuf,
        /// Rate in the file, or its absence.
        found: String,
        /// Rates expected.
        expected: &'static str,
    },
    /// The samples of the file are not in step with the shaft.
    #[error(
        "{file}: no samples in step with the shaft, expected a file that states its samples per revolution for keyphasor = \"synchronous\""
    )]
    NotSynchronous {
        /// The recording.
        file: PathBuf,
    },
    /// Two columns have the same name.
    #[error("{file}{at}: repeated column: `{column}`, expected each name once", column = name(.column), at = at_line(*.line))]
    ColumnTwice {
        /// The recording.
        file: PathBuf,
        /// Line of the header, where the file has lines.
        line: Option<u64>,
        /// Name of the column.
        column: String,
    },
    /// A cell is not a number.
    #[error("{file}:{line}: column {column}: invalid value: `{found}`, expected {expected}", column = name(.column))]
    Cell {
        /// The recording.
        file: PathBuf,
        /// Line of the row.
        line: u64,
        /// Name of the column.
        column: String,
        /// The cell's text, shortened.
        found: String,
        /// Values expected.
        expected: &'static str,
    },
    /// A row has more cells than the header has names.
    #[error("{file}:{line}: too many cells: {found}, expected {expected} as in the header{}", or_skip(*.names))]
    RowTooLong {
        /// The recording.
        file: PathBuf,
        /// Line of the row.
        line: u64,
        /// Number of cells in the row.
        found: usize,
        /// Number of names in the header.
        expected: usize,
        /// Line of the header, for the first row.
        names: Option<u64>,
    },
    /// The time stamps are in another unit than seconds.
    #[error("{file}: column {column}: {found}, expected seconds, or time = {{ column = \"{column}\", unit = \"{unit}\" }} in the scene", column = name(.column))]
    TimeUnit {
        /// The recording.
        file: PathBuf,
        /// The column of time stamps.
        column: String,
        /// Evidence of the unit.
        found: String,
        /// The unit.
        unit: String,
    },
    /// The time stamps go back at the end of summer time.
    #[error(
        "{file}:{line}: time stamps go back by 1 h and go on, as at the end of summer time, expected time stamps in UTC or with a zone, or `rate` instead of `time` in the scene"
    )]
    SummerTime {
        /// The recording.
        file: PathBuf,
        /// First line of winter time.
        line: u64,
    },
    /// The time stamps give no sampling rate.
    #[error(
        "{file}: column {column}: {found}, expected time stamps in seconds that rise from row to row, or `rate` instead of `time` in the scene", column = name(.column)
    )]
    Clock {
        /// The recording.
        file: PathBuf,
        /// The column of time stamps.
        column: String,
        /// Defect of the time stamps.
        found: String,
    },
}

impl RecordingError {
    /// Returns the error of a binary file whose reading ended with `cause`.
    pub(super) fn unreadable(file: &Path, cause: &io::Error, expected: &'static str) -> Self {
        let found = match cause.kind() {
            io::ErrorKind::UnexpectedEof => "a file that is truncated".to_owned(),
            _ => cause.to_string(),
        };
        Self::Format { file: file.into(), found, expected }
    }

    /// Returns true where scene and file contradict each other.
    #[must_use]
    pub const fn is_scene_fault(&self) -> bool {
        matches!(
            self,
            Self::AbsentColumn { .. }
                | Self::Unit { .. }
                | Self::Rate { .. }
                | Self::AbsentNumber { .. }
                | Self::NotSynchronous { .. }
                | Self::Misplaced { .. }
                | Self::NoSequence { .. }
                | Self::TimeUnit { .. }
        )
    }
}

/// Returns a read error for unsupported or invalid content of a file.
pub(super) fn refuse(found: impl Into<String>) -> io::Error {
    io::Error::other(found.into())
}

fn other_files(count: usize) -> String {
    match count {
        0 => "empty folder".to_owned(),
        1 => "folder without a recording: 1 other file".to_owned(),
        _ => format!("folder without a recording: {count} other files"),
    }
}

/// Returns the other cause of a first row that does not fit to line `names`.
fn or_skip(names: Option<u64>) -> String {
    names.map_or_else(String::new, |line| {
        format!(" at line {line}, or `skip` in the scene with the number of lines above the names of the columns")
    })
}

fn at_line(line: Option<u64>) -> String {
    line.map(|line| format!(":{line}")).unwrap_or_default()
}

fn did_you_mean(nearest: Option<&str>) -> String {
    nearest.map(|near| format!(" (did you mean `{}`?)", name(near))).unwrap_or_default()
}

/// Returns names for a message; a long list is shortened.
pub fn listed(names: &[String]) -> String {
    let shown: Vec<String> = names.iter().take(COLUMNS_SHOWN).map(|column| format!("`{}`", name(column))).collect();
    match names.len() - shown.len() {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}

/// Returns the name most similar to `wanted`, where one is similar; letter case is ignored.
pub(super) fn nearest(wanted: &str, names: &[String]) -> Option<String> {
    let wanted = wanted.to_lowercase();
    let length = wanted.chars().count();
    // A name of which every letter differs is not similar.
    let limit = (length / 3).max(2).min(length.saturating_sub(1));
    names
        .iter()
        // A length that differs by more needs no comparison, however long the name.
        .filter(|name| !name.is_empty() && name.chars().count().abs_diff(length) <= limit)
        .map(|name| (edits(&wanted, &name.to_lowercase()), name))
        .min_by_key(|(edits, _)| *edits)
        .filter(|(edits, _)| *edits <= limit)
        .map(|(_, name)| name.clone())
}

/// Returns the number of single-letter changes from one text to the other (Levenshtein distance).
fn edits(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let mut above: Vec<usize> = (0..=to.len()).collect();
    for (row, letter) in from.chars().enumerate() {
        let mut corner = above[0];
        above[0] = row + 1;
        for (column, other) in to.iter().enumerate() {
            let change = corner + usize::from(letter != *other);
            corner = above[column + 1];
            above[column + 1] = change.min(corner + 1).min(above[column] + 1);
        }
    }
    above[to.len()]
}
