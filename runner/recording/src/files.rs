//! The files of a recording: one file, the files of a folder, or those of a list.

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

use super::Time;
use super::error::RecordingError;
use super::format;
use ballrace_base::printable::name as printable;
use ballrace_scene::{Recording, Sequence};

/// Extensions of text files, without those of compressed files.
const TEXTS: [&str; 5] = ["csv", "txt", "tsv", "dat", "asc"];
/// Extensions of compressed files.
const COMPRESSED: [&str; 2] = ["gz", "zst"];
/// Number of names in a note.
const NAMES_SHOWN: usize = 3;

/// Files of a recording, in order.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// Paths.
    pub paths: Vec<PathBuf>,
    /// Sequence of more than one file.
    pub sequence: Option<Sequence>,
    /// Selection of the files, for the report.
    pub notes: Vec<String>,
}

impl Files {
    /// Returns the files of `path`: a file, a folder, or the list of the scene where `path` is the first of that.
    ///
    /// # Errors
    /// A folder without a readable file, several files without `sequence`.
    pub fn of(path: &Path, recording: &Recording) -> Result<Self, RecordingError> {
        let mut files = if path.is_dir() {
            Self::of_folder(path)?
        } else {
            Self { paths: vec![path.to_owned()], ..Self::default() }
        };
        if path == recording.file {
            for file in &recording.further_files {
                file.metadata().map_err(|cause| RecordingError::Open { file: file.clone(), cause })?;
                files.paths.push(file.clone());
            }
        }
        files.sequence = recording.sequence;
        match (files.paths.as_slice(), recording.sequence) {
            ([first, .., last], None) => Err(RecordingError::NoSequence {
                file: path.into(),
                count: files.paths.len(),
                first: shown(first),
                last: shown(last),
            }),
            ([first, .., last], Some(sequence)) => {
                let order = match sequence {
                    Sequence::Continuous => "one continuous recording",
                    Sequence::Snapshots => "one snapshot each",
                };
                let count = files.paths.len();
                files.notes.insert(0, format!("{count} files from {} to {}, {order}.", shown(first), shown(last)));
                Ok(files)
            }
            _ => Ok(files),
        }
    }

    /// Returns the files directly in a folder whose format is the most frequent one, in the natural order of their names.
    fn of_folder(folder: &Path) -> Result<Self, RecordingError> {
        let unread = |cause: io::Error| RecordingError::Open { file: folder.into(), cause };
        let (mut found, mut others): (Vec<(String, PathBuf)>, Vec<PathBuf>) = (vec![], vec![]);
        for entry in std::fs::read_dir(folder).map_err(unread)? {
            let path = entry.map_err(unread)?.path();
            match kind(&path) {
                _ if !path.is_file() => {}
                Some(kind) => found.push((kind, path)),
                None => others.push(path),
            }
        }
        found.sort_by_cached_key(|(_, path)| (natural_key(&shown(path)), path.clone()));
        let mut counts = BTreeMap::<&str, usize>::new();
        for (kind, _) in &found {
            *counts.entry(kind).or_default() += 1;
        }
        // The kind of the first file among those with the same number of files.
        let most = found.iter().rev().max_by_key(|(kind, _)| counts.get(kind.as_str())).map(|(kind, _)| kind.clone());
        let Some(most) = most else { return Err(RecordingError::Folder { file: folder.into(), files: others.len() }) };
        let (used, unused): (Vec<_>, Vec<_>) = found.into_iter().partition(|(kind, _)| *kind == most);
        others.extend(unused.into_iter().map(|(_, path)| path));
        others.sort_by_cached_key(|path| natural_key(&shown(path)));
        let mut notes = vec![];
        if !others.is_empty() {
            let ending = if most.is_empty() { "without the ending of a format".to_owned() } else { format!(".{most}") };
            notes.push(format!(
                "Files of the folder that are hidden or not {ending} are omitted: {}.",
                listed(others.iter().map(|path| shown(path)))
            ));
        }
        let paths = used.into_iter().map(|(_, path)| path).collect();
        Ok(Self { paths, sequence: None, notes })
    }
}

/// Returns the first names and the number of the others.
pub fn listed(names: impl ExactSizeIterator<Item = String>) -> String {
    let count = names.len();
    let first: Vec<String> = names.take(NAMES_SHOWN).collect();
    match count - first.len() {
        0 => first.join(", "),
        more => format!("{} and {more} more", first.join(", ")),
    }
}

/// Returns the name of a file for a message.
pub fn shown(path: &Path) -> String {
    printable(&path.file_name().unwrap_or(path.as_os_str()).to_string_lossy()).to_string()
}

/// Returns the extension of a readable file in lower case, empty for one that has none or digits only; `None` for other files.
fn kind(path: &Path) -> Option<String> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    if name.starts_with('.') {
        return None;
    }
    let unpacked = COMPRESSED.iter().find_map(|ending| name.strip_suffix(ending)?.strip_suffix('.'));
    let ending = match unpacked.unwrap_or(&name).rsplit_once('.') {
        Some((_, ending)) if !ending.bytes().all(|byte| byte.is_ascii_digit()) => ending,
        _ => return Some(String::new()),
    };
    (TEXTS.contains(&ending) || format::is_ending(ending)).then(|| ending.to_owned())
}

/// Part of a name in natural order.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    /// Number of digits without leading zeros, and the digits.
    Number(usize, String),
    Text(String),
}

/// Returns the key of the natural order: numbers in a name by their values.
fn natural_key(name: &str) -> Vec<Part> {
    let (mut parts, mut rest) = (vec![], name);
    while !rest.is_empty() {
        let (digits, after) = split(rest, true);
        let (text, after) = split(after, false);
        if !digits.is_empty() {
            let value = digits.trim_start_matches('0');
            parts.push(Part::Number(value.len(), value.to_owned()));
        }
        if !text.is_empty() {
            parts.push(Part::Text(text.to_owned()));
        }
        rest = after;
    }
    parts
}

/// Splits a text after its first digits, or after its first other characters.
fn split(text: &str, digits: bool) -> (&str, &str) {
    text.split_at(text.find(|letter: char| letter.is_ascii_digit() != digits).unwrap_or(text.len()))
}

/// Returns the date and time in the name of a file, such as `2003.10.22.12.06.24` or `rig_20031022_120624.csv`.
#[must_use]
pub fn time_in_name(path: &Path) -> Option<Time> {
    let name = path.file_name()?.to_string_lossy().into_owned();
    let groups: Vec<&str> =
        name.split(|letter: char| !letter.is_ascii_digit()).filter(|group| !group.is_empty()).collect();
    (0..groups.len()).find_map(|first| {
        let mut parts: Vec<String> = vec![];
        for group in groups.get(first..)? {
            match (parts.len(), group.len()) {
                (0, 4) | (1.., 2) => parts.push((*group).to_owned()),
                (0, 8 | 12 | 14) => {
                    parts.push(group[..4].to_owned());
                    parts.extend(pairs(&group[4..]));
                }
                (3, 4 | 6) => parts.extend(pairs(group)),
                _ => break,
            }
            if parts.len() >= 6 {
                break;
            }
        }
        let [year, month, day, hour, minute, rest @ ..] = parts.as_slice() else { return None };
        let second = rest.first().map_or("00", String::as_str);
        Time::parse(&format!("{year}-{month}-{day}T{hour}:{minute}:{second}"))
    })
}

/// Splits digits into numbers of two.
fn pairs(digits: &str) -> impl Iterator<Item = String> {
    digits.as_bytes().chunks(2).map(|pair| String::from_utf8_lossy(pair).into_owned())
}
