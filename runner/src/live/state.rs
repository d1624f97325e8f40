//! State of a monitor for a restart: one small file, replaced as a whole, and a copy of it.
//!
//! The copy is written after the file is on disk. A file that is damaged, which its checksum shows, is put aside, and the
//! monitor goes on with the copy.
//!
//! The indicators and the limits have separate positions in the stream of samples. A restart reads from the earlier position;
//! indicators and limits each ignore samples before their own position, so that nothing is written twice.

use super::alarms::AlarmList;
use super::source::Resume;
use anyhow::{Context, Result, bail};
use ballrace_twin::folder_lock::FolderLock;
use ballrace_twin::output;
use ballrace_twin::replay::FaultState;
use ballrace_twin::replay::limits::LimitState;
use ballrace_twin::scene::bounded::read_text;
use serde::{Deserialize, Serialize};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Version of the file format.
const FORMAT_VERSION: u32 = 2;
/// Largest length of the file, bytes: it holds at most 10 000 events.
const MAX_LENGTH: u64 = 64 << 20;
/// Version without limits and events.
const VERSION_WITHOUT_LIMITS: u32 = 1;

/// State of a monitor.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct State {
    /// Version of the file format.
    #[serde(rename = "form")]
    pub format_version: u32,
    /// Name of the monitored scene.
    pub scene: String,
    /// Identifier of this state in the indicator journal.
    pub id: String,
    /// First sample that a restart reads.
    pub resume: Resume,
    /// First sample whose acknowledgement the source may not have; `None` in a state of an earlier program.
    pub acknowledged: Option<u64>,
    /// First sample after the seconds whose indicators are on disk.
    pub seconds_index: u64,
    /// End of these seconds in the time of the recording, s.
    pub time_s: f64,
    /// State of the limits; `None` for a scene without limits.
    pub limits: Option<LimitState>,
    /// Alarms that are active or not acknowledged.
    pub alarms: AlarmList,
    /// Faults that the last diagnoses found.
    pub faults: FaultState,
    /// Lines that may be missing in the event log: they are appended after this state was written.
    pub events: Vec<String>,
    /// Number of starts of the monitor.
    pub starts: u64,
}

impl State {
    /// Returns the earliest and the latest position of indicators and limits.
    fn positions(&self) -> [u64; 2] {
        let limits = self.limits.as_ref().and_then(LimitState::positions).unwrap_or([self.seconds_index; 2]);
        [self.seconds_index.min(limits[0]), self.seconds_index.max(limits[1])]
    }

    /// Returns the first sample that indicators and limits have not both processed.
    #[must_use]
    pub fn first_unprocessed(&self) -> u64 {
        self.positions()[0]
    }

    /// Returns the sample at which a source continues. A source that `can_repeat` samples continues at the earliest position
    /// of indicators and limits. Samples of any other source are new and are numbered from the latest position.
    #[must_use]
    pub fn resume(&self, can_repeat: bool) -> Resume {
        let [_, last] = self.positions();
        if can_repeat { self.resume } else { Resume { index: last, sequence: self.resume.sequence } }
    }
}

/// State file in a folder that is locked by this process.
pub struct StateFile {
    path: PathBuf,
    copy: PathBuf,
    /// The file is damaged or missing beside its copy: what was found and with what the monitor goes on, for users.
    pub damage: Option<String>,
    /// Content of the file after the next [`StateFile::save`].
    pub state: State,
    _lock: FolderLock,
}

impl StateFile {
    /// Locks a folder and reads its state. Only the lock file is written, so that a failed start does not change the state.
    ///
    /// # Errors
    /// Returns an error if the folder cannot be written, is locked by another monitor, or has a state of another scene or
    /// format.
    pub fn open(folder: &Path, scene: &str) -> Result<Self> {
        let lock = FolderLock::acquire(folder, "state.lock")?;
        let [path, copy] = ["state.json", "state.json.copy"].map(|name| folder.join(name));
        let new =
            || State { format_version: FORMAT_VERSION, scene: scene.to_owned(), id: new_id(), ..State::default() };
        let (state, damage) = match (read(&path)?, read(&copy)?) {
            (Content::State(state), _) => (*state, None),
            (Content::Missing, Content::Missing) => (new(), None),
            (found, Content::State(state)) => {
                (*state, Some(damage(&path, &found, "The monitor goes on with its copy.")))
            }
            (found, _) => {
                let consequence =
                    "Its copy is damaged or missing too: alarms, acknowledgements and limits start empty.";
                (new(), Some(damage(&path, &found, consequence)))
            }
        };
        let state = upgraded(state);
        if state.format_version != FORMAT_VERSION || state.scene != scene {
            bail!(crate::error::UsageError(format!(
                "{}: state of another scene or format: scene {:?}, format {}, expected scene {scene:?}, format \
                 {FORMAT_VERSION}, or another folder",
                path.display(),
                state.scene,
                state.format_version
            )));
        }
        Ok(Self { path, copy, damage, state, _lock: lock })
    }

    /// Increments the number of starts and writes the state. A damaged file is kept as `state.json.damaged`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn begin(&mut self) -> Result<()> {
        if self.damage.is_some() {
            // It is for examination only: the monitor starts without it too.
            let _ = std::fs::rename(&self.path, self.path.with_extension("json.damaged"));
        }
        self.state.starts += 1;
        self.save()
    }

    /// Writes the state and then its copy; both are on disk when this returns.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn save(&self) -> Result<()> {
        let text = with_checksum(&serde_json::to_string_pretty(&self.state)?);
        for path in [&self.path, &self.copy] {
            output::replace(path, text.as_bytes())
                .with_context(|| format!("{}: this file cannot be written", path.display()))?;
        }
        Ok(())
    }
}

/// Content of a state file.
enum Content {
    /// A state.
    State(Box<State>),
    /// No file.
    Missing,
    /// No whole state: the reason.
    Damaged(String),
}

/// Reads a state file or its copy.
///
/// # Errors
/// Returns an error if the file may not be read, or is whole but not the state of a monitor.
fn read(path: &Path) -> Result<Content> {
    let text = match read_text(path, MAX_LENGTH) {
        Ok(text) => text,
        Err(error) => match error.kind() {
            ErrorKind::NotFound => return Ok(Content::Missing),
            // Not readable by this user, or no file that a monitor wrote.
            ErrorKind::PermissionDenied | ErrorKind::IsADirectory | ErrorKind::Other => {
                return Err(error).with_context(|| path.display().to_string());
            }
            _ => return Ok(Content::Damaged(error.to_string())),
        },
    };
    let damaged = |error: serde_json::Error| Ok(Content::Damaged(error.to_string()));
    let value = match serde_json::from_str::<serde_json::Value>(&text) {
        Ok(value) => value,
        Err(error) => return damaged(error),
    };
    if value.get(CHECKSUM).is_none() && value.get("form").is_none() {
        bail!(crate::error::UsageError(format!(
            "{}: not the state of a monitor, expected another folder",
            path.display()
        )));
    }
    if !has_valid_checksum(&text) {
        return Ok(Content::Damaged("its checksum is wrong".to_owned()));
    }
    serde_json::from_value(value).map_or_else(damaged, |state| Ok(Content::State(Box::new(state))))
}

/// Returns the sentence about a damaged or missing state file.
fn damage(path: &Path, found: &Content, consequence: &str) -> String {
    let what = match found {
        Content::Damaged(reason) => format!("damaged ({reason})"),
        Content::Missing | Content::State(_) => "missing".to_owned(),
    };
    format!("The state {} is {what}. {consequence}", path.display())
}

/// Returns a state of an earlier format in the present one.
fn upgraded(state: State) -> State {
    if state.format_version == VERSION_WITHOUT_LIMITS {
        return State { format_version: FORMAT_VERSION, id: new_id(), seconds_index: state.resume.index, ..state };
    }
    state
}

/// First key of a state file: the CRC-32 (IEEE 802.3) of all that follows it.
const CHECKSUM: &str = "crc32";

/// Returns a JSON object with the checksum of the rest as its first key.
fn with_checksum(object: &str) -> String {
    let rest = object.strip_prefix('{').unwrap_or(object);
    format!("{{\n  \"{CHECKSUM}\": {},{rest}", crc32fast::hash(rest.as_bytes()))
}

/// Returns `false` for a text whose checksum does not fit the rest; a state of an earlier program has none.
fn has_valid_checksum(text: &str) -> bool {
    let parts = text.strip_prefix(&format!("{{\n  \"{CHECKSUM}\": ")).and_then(|text| text.split_once(','));
    parts.is_none_or(|(sum, rest)| sum.parse() == Ok(crc32fast::hash(rest.as_bytes())))
}

fn new_id() -> String {
    let now = humantime::format_rfc3339_nanos(std::time::SystemTime::now());
    format!("{now} {}", std::process::id())
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn a_restart_continues_and_rejects_another_scene() {
        let folder = tempfile::tempdir().unwrap();
        let open = |scene| StateFile::open(folder.path(), scene);
        let mut file = open("rig").unwrap();
        file.state.resume = Resume { index: 12_345, sequence: Some(7) };
        file.begin().unwrap();
        assert!(open("rig").is_err_and(|e| e.to_string().contains("in use by process")));
        drop(file);
        let reopened = open("rig").unwrap();
        assert_eq!((reopened.state.resume.index, reopened.state.starts), (12_345, 1));
        drop(reopened);
        assert!(open("other").is_err());
    }

    /// A folder with the state of a monitor that has read 640 samples.
    fn folder_with_state() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let mut file = StateFile::open(folder.path(), "rig").unwrap();
        file.state.resume = Resume { index: 640, sequence: Some(7) };
        file.begin().unwrap();
        folder
    }

    #[test]
    fn a_damaged_state_goes_on_with_its_copy() {
        let folder = folder_with_state();
        let path = folder.path().join("state.json");
        let whole = std::fs::read(&path).unwrap();
        let flipped = |at: usize| {
            let mut bytes = whole.clone();
            bytes[at] ^= 1;
            bytes
        };
        let cuts = (0..whole.len()).map(|length| whole[..length].to_vec());
        let damages = cuts.chain((0..whole.len()).map(flipped)).chain([vec![0; whole.len()], vec![0xff; 9]]);
        for bytes in damages {
            std::fs::write(&path, &bytes).unwrap();
            let file = StateFile::open(folder.path(), "rig").unwrap();
            let text = String::from_utf8_lossy(&bytes).into_owned();
            assert_eq!((file.state.resume.index, file.state.resume.sequence), (640, Some(7)), "{text}");
            // A changed letter in the name of the first key changes nothing else.
            assert!(file.damage.is_some() || text.contains("\"form\": 2,\n  \"scene\": \"rig\","), "{text}");
        }
        std::fs::remove_file(&path).unwrap();
        let mut file = StateFile::open(folder.path(), "rig").unwrap();
        assert!(file.damage.as_ref().is_some_and(|text| text.contains("missing")), "{:?}", file.damage);
        file.begin().unwrap();
        drop(file);
        assert!(StateFile::open(folder.path(), "rig").unwrap().damage.is_none());
    }

    #[test]
    fn a_state_starts_empty_where_its_copy_is_damaged_too() {
        let folder = folder_with_state();
        for name in ["state.json", "state.json.copy"] {
            std::fs::write(folder.path().join(name), "{\"form\":2,").unwrap();
        }
        let mut file = StateFile::open(folder.path(), "rig").unwrap();
        assert_eq!((file.state.resume.index, file.state.starts), (0, 0));
        assert!(file.damage.as_ref().is_some_and(|text| text.contains("start empty")), "{:?}", file.damage);
        file.begin().unwrap();
        assert_eq!(std::fs::read_to_string(folder.path().join("state.json.damaged")).unwrap(), "{\"form\":2,");
    }

    #[test]
    fn another_scene_or_file_is_refused_whatever_the_copy_is() {
        let folder = folder_with_state();
        assert!(StateFile::open(folder.path(), "other").is_err());
        std::fs::write(folder.path().join("state.json"), "cut").unwrap();
        assert!(StateFile::open(folder.path(), "other").is_err());
        for foreign in ["[1, 2]", "{\"colour\": \"red\"}", "3"] {
            std::fs::write(folder.path().join("state.json"), foreign).unwrap();
            assert!(StateFile::open(folder.path(), "rig").is_err_and(|e| e.to_string().contains("not the state")));
        }
    }

    #[test]
    fn a_failed_start_does_not_change_the_state() {
        let folder = tempfile::tempdir().unwrap();
        drop(StateFile::open(folder.path(), "rig").unwrap());
        assert!(!folder.path().join("state.json").exists());
    }

    #[test]
    fn a_state_without_limits_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let text = r#"{"form":1,"scene":"rig","resume":{"index":640,"sequence":9},"time_s":5.0,"starts":3}"#;
        std::fs::write(folder.path().join("state.json"), text).unwrap();
        let state = StateFile::open(folder.path(), "rig").unwrap().state;
        assert_eq!((state.first_unprocessed(), state.resume(true).sequence, state.starts), (640, Some(9), 3));
    }

    #[test]
    fn a_source_continues_at_the_earliest_or_latest_position() {
        let limits = Some(LimitState { readings_index: Some(900), ..LimitState::default() });
        let resume = Resume { index: 800, sequence: None };
        let state = State { seconds_index: 800, limits, resume, ..State::default() };
        assert_eq!((state.first_unprocessed(), state.resume(true).index, state.resume(false).index), (800, 800, 900));
    }
}
