//! Replays of vibration recordings by the release binary.

use crate::labels::Recording;
use serde::Deserialize;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use std::{env, fs};

/// Exit codes of a complete replay.
const COMPLETE: [i32; 3] = [0, 3, 4];

/// The part of a replay's outcome that is measured here.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Outcome {
    pub findings: Vec<Finding>,
    pub verdict: String,
    #[serde(skip)]
    pub seconds: f64,
}

/// One entry of `findings`.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Finding {
    pub kind: String,
    pub confidence: f64,
    pub order: f64,
}

/// The `ballrace` binary, with a folder for scenes and reports.
pub struct Program {
    binary: PathBuf,
    folder: PathBuf,
}

impl Program {
    /// Finds the release binary beside this benchmark, or takes the one given.
    pub fn find(given: Option<PathBuf>, folder: &Path) -> Result<Self, Box<dyn Error>> {
        let name = format!("ballrace{}", env::consts::EXE_SUFFIX);
        let binary = match given {
            Some(path) => path,
            None => env::current_exe()?.ancestors().nth(2).ok_or("found no target folder")?.join(name),
        };
        if !binary.is_file() {
            return Err(format!("{}: found no program; type: cargo build --release", binary.display()).into());
        }
        Ok(Self { binary, folder: folder.to_owned() })
    }

    /// Replays a recording of `data`; `names` distinguishes the files of this replay. With `learn` the baseline is
    /// written, else read.
    pub fn replay(
        &self,
        data: &Path,
        recording: &Recording,
        names: &str,
        baseline: Option<(bool, &Path)>,
    ) -> Result<Outcome, Box<dyn Error>> {
        let path = self.folder.join(format!("{names}.toml"));
        fs::write(&path, scene(data, recording))?;
        let mut command = Command::new(&self.binary);
        command.arg("replay").arg(&path).args(["--format", "json"]);
        command.arg("--report").arg(self.folder.join(format!("{names}.html")));
        if let Some((learn, file)) = baseline {
            command.arg(if learn { "--learn" } else { "--baseline" }).arg(file);
        }
        let start = Instant::now();
        let output = command.output()?;
        let seconds = start.elapsed().as_secs_f64();
        let failed = |cause: String| format!("{}: {cause}", recording.file);
        if !output.status.code().is_some_and(|code| COMPLETE.contains(&code)) {
            let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            return Err(failed(format!("{}, {said}", output.status)).into());
        }
        let outcome: Outcome = serde_json::from_slice(&output.stdout).map_err(|error| failed(error.to_string()))?;
        Ok(Outcome { seconds, ..outcome })
    }
}

/// Returns the scene that an owner writes.
pub fn scene(data: &Path, of: &Recording) -> String {
    let sensors: Vec<String> = (0..of.channels).map(|i| format!("{{ column = \"c{i}\", unit = \"g\" }}")).collect();
    let header = if of.file.contains(".npy") { "" } else { "header = false\n" };
    format!(
        "shaft.speed = \"{} rpm\"\n[[bearing]]\nname = \"B\"\nelements = {}\nball_diameter = \"{} mm\"\npitch_diameter = \"{} mm\"\n\
         contact_angle = \"{} deg\"\n[recording]\nfile = {:?}\n{header}rate = \"{} Hz\"\nsensors = [{}]\n",
        of.rpm,
        of.elements,
        of.diameter_mm,
        of.pitch_mm,
        of.angle_deg,
        data.join(&of.file).display().to_string(),
        of.rate_hz,
        sensors.join(", ")
    )
}
