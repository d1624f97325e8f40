//! State of a monitor for a restart: one small file, replaced as a whole.
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
        let path = folder.join("state.json");
        let mut state = match read_text(&path, MAX_LENGTH) {
            Ok(text) => serde_json::from_str::<State>(&text)
                .with_context(|| format!("{}: not the state of a monitor, expected another folder", path.display()))?,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                State { format_version: FORMAT_VERSION, scene: scene.to_owned(), id: new_id(), ..State::default() }
            }
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
        };
        if state.format_version == VERSION_WITHOUT_LIMITS {
            state = State { format_version: FORMAT_VERSION, id: new_id(), seconds_index: state.resume.index, ..state };
        }
        if state.format_version != FORMAT_VERSION || state.scene != scene {
            bail!(crate::error::UsageError(format!(
                "{}: state of another scene or format: scene {:?}, format {}, expected scene {scene:?}, format \
                 {FORMAT_VERSION}, or another folder",
                path.display(),
                state.scene,
                state.format_version
            )));
        }
        Ok(Self { path, state, _lock: lock })
    }

    /// Increments the number of starts and writes the state.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn begin(&mut self) -> Result<()> {
        self.state.starts += 1;
        self.save()
    }

    /// Writes the state; it is on disk when this returns.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn save(&self) -> Result<()> {
        let text = serde_json::to_string_pretty(&self.state)?;
        output::replace(&self.path, text.as_bytes())
            .map(drop)
            .with_context(|| format!("{}: this file cannot be written", self.path.display()))
    }
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
        std::fs::write(folder.path().join("state.json"), "{\"form\":2,").unwrap();
        assert!(open("rig").is_err());
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
