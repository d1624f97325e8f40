//! State of a monitor that a restart needs: one small file, replaced as a whole.
//!
//! The indicators and the limits have positions of their own in the stream of samples. A restart reads again from the
//! earlier of the two; each of them ignores samples before its own position, so that nothing is written twice.

use super::lock::FolderLock;
use super::source::Resume;
use anyhow::{Context, Result, bail};
use ballrace_twin::output;
use ballrace_twin::replay::limits::LimitState;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Form of the file.
const FORM: u32 = 2;
/// Earlier form, without limits and events.
const FORM_WITHOUT_LIMITS: u32 = 1;

/// State of a monitor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct State {
    /// Form of this file.
    pub form: u32,
    /// The scene that is monitored.
    pub scene: String,
    /// Identifies this state in the indicator journal.
    pub id: String,
    /// The first sample that a restart reads.
    pub resume: Resume,
    /// The first sample after the seconds whose indicators are on disk.
    pub seconds_index: u64,
    /// End of those seconds in the recording's time, s.
    pub time_s: f64,
    /// The limits; absent where the scene has none.
    pub limits: Option<LimitState>,
    /// Lines that were appended to the event log after this state was written, or are still to be appended.
    pub events: Vec<String>,
    /// Times the monitor was started.
    pub starts: u64,
}

impl State {
    /// The first and the last of the positions at which indicators and limits go on.
    fn positions(&self) -> [u64; 2] {
        let limits = self.limits.as_ref().and_then(LimitState::positions).unwrap_or([self.seconds_index; 2]);
        [self.seconds_index.min(limits[0]), self.seconds_index.max(limits[1])]
    }

    /// The first sample that is not yet processed by both indicators and limits.
    #[must_use]
    pub fn first_unprocessed(&self) -> u64 {
        self.positions()[0]
    }

    /// The sample at which a source goes on. A source that `can_repeat` samples repeats those that only one of indicators
    /// and limits has processed. The samples of any other source are new and have later numbers.
    #[must_use]
    pub fn resume(&self, can_repeat: bool) -> Resume {
        let [_, last] = self.positions();
        if can_repeat { self.resume } else { Resume { index: last, sequence: self.resume.sequence } }
    }
}

/// The state in its folder, which belongs to this process.
pub struct StateFile {
    path: PathBuf,
    /// As it is on disk after [`StateFile::save`].
    pub state: State,
    _lock: FolderLock,
}

impl StateFile {
    /// Locks a folder and reads its state. Writes nothing but the lock: a start that fails changes no state.
    ///
    /// # Errors
    /// A folder that cannot be written or that another monitor owns, a state of another scene or form.
    pub fn open(folder: &Path, scene: &str) -> Result<Self> {
        let lock = FolderLock::acquire(folder, "state.lock")?;
        let path = folder.join("state.json");
        let mut state = match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str::<State>(&text)
                .with_context(|| format!("{}: found no state of a monitor, allowed: another folder", path.display()))?,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                State { form: FORM, scene: scene.to_owned(), id: new_id(), ..State::default() }
            }
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
        };
        if state.form == FORM_WITHOUT_LIMITS {
            state = State { form: FORM, id: new_id(), seconds_index: state.resume.index, ..state };
        }
        if state.form != FORM || state.scene != scene {
            bail!(crate::error::UsageError(format!(
                "{}: found the state of scene {:?} (form {}), allowed: that of {scene:?} (form {FORM}), or another folder",
                path.display(),
                state.scene,
                state.form
            )));
        }
        Ok(Self { path, state, _lock: lock })
    }

    /// Counts a start and writes the state for the first time.
    ///
    /// # Errors
    /// A full disk.
    pub fn begin(&mut self) -> Result<()> {
        self.state.starts += 1;
        self.save()
    }

    /// Writes the state; durable when this returns.
    ///
    /// # Errors
    /// A full disk.
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
    fn goes_on_where_it_was_and_refuses_another_scene() {
        let folder = tempfile::tempdir().unwrap();
        let open = |scene| StateFile::open(folder.path(), scene);
        let mut file = open("rig").unwrap();
        file.state.resume = Resume { index: 12_345, sequence: Some(7) };
        file.begin().unwrap();
        assert!(open("rig").is_err_and(|e| e.to_string().contains("in use by process")));
        drop(file);
        let again = open("rig").unwrap();
        assert_eq!((again.state.resume.index, again.state.starts), (12_345, 1));
        drop(again);
        assert!(open("other").is_err());
        std::fs::write(folder.path().join("state.json"), "{\"form\":2,").unwrap();
        assert!(open("rig").is_err());
    }

    #[test]
    fn a_start_that_fails_changes_nothing() {
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
    fn positions_decide_where_a_source_goes_on() {
        let limits = Some(LimitState { readings_index: Some(900), ..LimitState::default() });
        let resume = Resume { index: 800, sequence: None };
        let state = State { seconds_index: 800, limits, resume, ..State::default() };
        assert_eq!((state.first_unprocessed(), state.resume(true).index, state.resume(false).index), (800, 800, 900));
    }
}
