//! One row of the table of machines.

use super::patience::within;
use super::row::Key;
use ballrace_recording::Time;
use ballrace_scene::Scene;
use ballrace_scene::read::{SceneError, read_file, read_str};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::fs::Metadata;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

/// Scene of a machine.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SceneSource {
    /// A scene file.
    Path(PathBuf),
    /// Text of a scene; relative paths in it start from `folder`.
    Text {
        /// The text.
        text: String,
        /// Folder of relative paths.
        folder: PathBuf,
    },
}

/// A machine with one of its recordings.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the machine.
    pub name: String,
    /// Its scene.
    pub scene: SceneSource,
    /// Path of the recording; `None` for the recording of the scene.
    pub recording: Option<PathBuf>,
    /// The recording as the table names it, part of the row's key; empty where it is that of the scene.
    pub recording_name: String,
    /// Baseline to compare with.
    pub baseline: Option<PathBuf>,
    /// Time of the recording.
    pub time: Option<Time>,
    /// Further columns of the table by their names.
    pub tags: BTreeMap<String, String>,
}

impl Machine {
    /// Creates a machine with the scene's own recording, without baseline, time and tags.
    #[must_use]
    pub fn new(name: impl Into<String>, scene: SceneSource) -> Self {
        let (recording, recording_name, baseline) = (None, String::new(), None);
        Self { name: name.into(), scene, recording, recording_name, baseline, time: None, tags: BTreeMap::new() }
    }

    /// Returns the machine with another recording.
    #[must_use]
    pub fn with_recording(mut self, path: impl Into<PathBuf>) -> Self {
        let path = path.into();
        self.recording_name = path.display().to_string();
        self.recording = Some(path);
        self
    }

    /// Returns the key of its row.
    #[must_use]
    pub fn key(&self) -> Key {
        Key { machine: self.name.clone(), recording: self.recording_name.clone() }
    }

    /// Reads the scene.
    ///
    /// # Errors
    /// Returns the first error of the scene.
    pub fn read_scene(&self) -> Result<Scene, SceneError> {
        match &self.scene {
            SceneSource::Path(path) => read_file(path),
            SceneSource::Text { text, folder } => read_str(text, &folder.join(format!("{}.toml", safe(&self.name)))),
        }
    }

    /// Returns a hash of the row of the table and of the files that it names, or `None` where a file does not answer within
    /// `patience`.
    #[must_use]
    pub fn fingerprint_within(&self, patience: Duration) -> Option<String> {
        let one = self.clone();
        within(patience, move |_| one.fingerprint()).ok().flatten()
    }

    /// Returns a hash, in hexadecimal digits, that changes with the row of the table and with the size or modification time of the
    /// files that it names. A stored row with another hash is out of date.
    #[must_use]
    pub(crate) fn fingerprint(&self) -> String {
        let mut hash = Fnv::default();
        hash.add(env!("CARGO_PKG_VERSION"));
        match &self.scene {
            SceneSource::Path(path) => hash.add_file(path),
            SceneSource::Text { text, .. } => hash.add(text),
        }
        match &self.recording {
            Some(path) => hash.add_file(path),
            None => match self.read_scene().ok().and_then(|scene| scene.recording) {
                Some(recording) => hash.add_file(&recording.file),
                None => hash.add("no recording"),
            },
        }
        if let Some(file) = self.read_scene().ok().and_then(|scene| scene.recording?.run_out) {
            hash.add_file(&file);
        }
        match &self.baseline {
            Some(path) => hash.add_file(path),
            None => hash.add("no baseline"),
        }
        hash.add(&self.time.map(|time| time.to_string()).unwrap_or_default());
        for (name, value) in &self.tags {
            hash.add(name);
            hash.add(value);
        }
        format!("{:016x}", hash.0)
    }
}

/// Hash of 64 bits by FNV-1a.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    fn add(&mut self, text: &str) {
        // The terminator, which UTF-8 text cannot contain, separates consecutive texts.
        for byte in text.bytes().chain([0xff]) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    /// Adds size and modification time of a file. Its path is excluded, so that the hash stays valid if the folder is moved.
    fn add_file(&mut self, path: &Path) {
        let stamp = |about: &Metadata| Some(about.modified().ok()?.duration_since(UNIX_EPOCH).ok()?.as_nanos());
        let about = path.metadata().ok();
        let about = about.map(|about| format!("{} {}", about.len(), stamp(&about).unwrap_or_default()));
        self.add(about.as_deref().unwrap_or("no file"));
    }
}

/// Returns the names of the reports of `machines`, without folder: `MACHINE.html` with the scene's own recording,
/// `MACHINE-RECORDING.html` with another one.
///
/// Characters other than letters, digits, `.`, `-` and `_` are replaced by `_`. A name that is taken, whatever its case, gets a number
/// from the row's key. Rows that are added to the end of a table do not change the names of the others.
#[must_use]
pub fn report_names(machines: &[Machine]) -> Vec<String> {
    let mut used = HashSet::new();
    let name = |Machine { name, recording, recording_name, .. }: &Machine| {
        let mut stem = safe(name);
        if let Some(path) = recording {
            stem += "-";
            stem += &safe(&path.file_stem().unwrap_or_default().to_string_lossy());
        }
        let mut hash = Fnv::default();
        hash.add(name);
        hash.add(recording_name);
        let mut unique = stem.clone();
        while !used.insert(unique.to_lowercase()) {
            unique = format!("{stem}-{:08x}", hash.0 >> 32);
            hash.add("again");
        }
        unique + ".html"
    };
    machines.iter().map(name).collect()
}

/// Longest part of a file name, in characters.
const LONGEST_PART: usize = 60;

/// Returns `text` as a part of a file name on any system.
fn safe(text: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '_');
    let safe: String = text.chars().map(|c| if allowed(c) { c } else { '_' }).take(LONGEST_PART).collect();
    // A leading dot hides a file; some systems reserve names such as CON.
    let reserved = ["con", "prn", "aux", "nul"].contains(&safe.to_lowercase().as_str());
    if safe.is_empty() || safe.starts_with('.') || reserved { format!("_{safe}") } else { safe }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine(name: &str, recording: &str) -> Machine {
        let machine = Machine::new(name, SceneSource::Path("scene.toml".into()));
        if recording.is_empty() { machine } else { machine.with_recording(recording) }
    }

    #[test]
    fn report_names_are_safe_and_distinct() {
        let machines = [
            ("pump 1", ""),
            ("pump_1", ""),
            ("PUMP/1", ""),
            ("fan", "a/day1.csv"),
            ("fan", "b/day1.csv"),
            ("fan-day1", ""),
            ("../../x", ""),
            ("", ""),
            ("nul", ""),
            ("Lüfter", "día.csv"),
        ]
        .map(|(name, recording)| machine(name, recording));
        let names = report_names(&machines);
        let distinct: HashSet<String> = names.iter().map(|name| name.to_lowercase()).collect();
        assert_eq!(distinct.len(), machines.len(), "{names:?}");
        assert_eq!(
            [&names[0], &names[3], &names[6], &names[8]],
            ["pump_1.html", "fan-day1.html", "_.._.._x.html", "_nul.html"]
        );
        assert!(names.iter().all(|name| name.is_ascii() && !name.contains(['/', '\\', ' ']) && !name.starts_with('.')));
        assert_eq!(report_names(&machines[..7]), names[..7]);
    }

    #[test]
    fn a_fingerprint_changes_with_the_row() {
        let one = machine("fan", "a.csv");
        let other = Machine { time: Time::parse("2026-01-01"), ..one.clone() };
        assert_eq!(one.fingerprint(), one.clone().fingerprint());
        assert_ne!(one.fingerprint(), other.fingerprint());
    }
}
