//! What a monitor that was killed needs to go on: one small file, replaced as a whole.

use super::source::Resume;
use ballrace_twin::output::AtomicFile;
use anyhow::{Context, Result, bail};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Form of the file; another one is not read.
const FORM: u32 = 1;

/// State of a monitor.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Form of this file.
    pub form: u32,
    /// The scene that was watched.
    pub scene: String,
    /// The first sample that is not yet worked off.
    pub resume: Resume,
    /// Seconds of the recording whose indicators and events are on disk.
    pub time_s: f64,
    /// Times the monitor was started.
    pub starts: u64,
}

/// Keeps the state in a folder.
pub struct StateFile {
    path: PathBuf,
    /// As it is on disk.
    pub state: State,
}

impl StateFile {
    /// Opens a folder's state, or begins it.
    ///
    /// # Errors
    /// A folder that cannot be written, a state of another scene or form.
    pub fn open(folder: &Path, scene: &str) -> Result<Self> {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
        let path = folder.join("state.json");
        let mut state = match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str::<State>(&text)
                .with_context(|| format!("{}: found no state of a monitor, allowed: another folder", path.display()))?,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                State { form: FORM, scene: scene.to_owned(), ..State::default() }
            }
            Err(error) => return Err(error).with_context(|| path.display().to_string()),
        };
        if state.form != FORM || state.scene != scene {
            bail!(ballrace_twin::fault::SceneFault(format!(
                "{}: found the state of scene {:?} (form {}), allowed: that of {scene:?} (form {FORM}), or another folder",
                path.display(),
                state.scene,
                state.form
            )));
        }
        state.starts += 1;
        let mut file = Self { path, state };
        file.keep()?;
        Ok(file)
    }

    /// Writes the state.
    ///
    /// # Errors
    /// A full disk.
    pub fn keep(&mut self) -> Result<()> {
        AtomicFile::write(&self.path, &serde_json::to_string_pretty(&self.state)?)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn goes_on_where_it_was_and_refuses_another_scene() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = StateFile::open(folder.path(), "rig").unwrap();
        file.state.resume = Resume { index: 12_345, sequence: Some(7) };
        file.keep().unwrap();
        let again = StateFile::open(folder.path(), "rig").unwrap();
        assert_eq!((again.state.resume.index, again.state.starts), (12_345, 2));
        assert!(StateFile::open(folder.path(), "other").is_err());
        std::fs::write(folder.path().join("state.json"), "{\"form\":1,").unwrap();
        assert!(StateFile::open(folder.path(), "rig").is_err());
    }
}
