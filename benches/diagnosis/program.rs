//! The release binary: the diagnoses of a replay.

use serde::Deserialize;
use std::env;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Exit codes with which `replay` ends after a whole replay: no alarm, a limit crossed, not plausible for the scene.
const COMPLETE: [i32; 3] = [0, 3, 4];

/// A value with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Estimate {
    pub value: f64,
    pub low: Option<f64>,
    pub high: Option<f64>,
}

/// A number, alone or with its interval.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
enum NumberOrEstimate {
    Number(f64),
    Estimate(Estimate),
}

impl From<NumberOrEstimate> for Estimate {
    fn from(read: NumberOrEstimate) -> Self {
        match read {
            NumberOrEstimate::Number(value) => Self { value, low: None, high: None },
            NumberOrEstimate::Estimate(estimate) => estimate,
        }
    }
}

/// Reads an estimate, also where the interval or the value is absent.
fn estimate<'de, D: serde::Deserializer<'de>>(source: D) -> Result<Option<Estimate>, D::Error> {
    Ok(Option::<NumberOrEstimate>::deserialize(source)?.map(Estimate::from))
}

/// One entry of `findings`.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub struct Diagnosis {
    pub kind: String,
    pub bearing: Option<String>,
    pub form: Option<String>,
    #[serde(deserialize_with = "estimate")]
    pub azimuth_deg: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub half_width_deg: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub depth_um: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub waviness_order: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub amplitude_um: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub tilt_mrad: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub axis_deg: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub clearance_um: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub moment_g_mm: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub angle_deg: Option<Estimate>,
    #[serde(deserialize_with = "estimate")]
    pub station_mm: Option<Estimate>,
}

impl Diagnosis {
    /// Returns cause, form and bearing in words.
    pub fn words(&self) -> String {
        [Some(self.kind.as_str()), self.form.as_deref(), self.bearing.as_deref()]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(" ")
    }
}

/// The part of a replay's outcome that is measured here.
#[derive(Debug, Deserialize)]
struct Outcome {
    #[serde(rename = "findings")]
    diagnoses: Vec<Diagnosis>,
}

/// The diagnoses of a replay and its duration, s.
pub struct Replay {
    pub diagnoses: Vec<Diagnosis>,
    pub seconds: f64,
}

/// How a replay uses a baseline.
pub enum Baseline<'a> {
    None,
    Learn(&'a Path),
    Use(&'a Path),
}

/// The `ballrace` binary.
pub struct Program(PathBuf);

impl Program {
    /// Finds the release binary beside this benchmark, or takes the one given.
    pub fn find(given: Option<PathBuf>) -> Result<Self, Box<dyn Error>> {
        let name = format!("ballrace{}", env::consts::EXE_SUFFIX);
        let path = match given {
            Some(path) => path,
            None => env::current_exe()?.ancestors().nth(2).ok_or("found no target folder")?.join(name),
        };
        if !path.is_file() {
            return Err(format!("{}: found no program; type: cargo build --release", path.display()).into());
        }
        Ok(Self(path))
    }

    /// Replays a recording in a folder that takes the report.
    pub fn replay(
        &self,
        scene: &Path,
        recording: &Path,
        folder: &Path,
        baseline: &Baseline,
    ) -> Result<Replay, Box<dyn Error>> {
        let name = |path: &Path| path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let rig = scene.parent().map(name).unwrap_or_default();
        let mut command = Command::new(&self.0);
        command.arg("replay").arg(scene).arg("--recording").arg(recording).args(["--format", "json"]);
        command.arg("--report").arg(folder.join(format!("{rig}-{}.html", name(recording))));
        match baseline {
            Baseline::None => {}
            Baseline::Learn(path) => _ = command.arg("--learn").arg(path),
            Baseline::Use(path) => _ = command.arg("--baseline").arg(path),
        }
        let start = Instant::now();
        let output = command.output()?;
        let seconds = start.elapsed().as_secs_f64();
        let failed = |cause: String| format!("{} with {}: {cause}", scene.display(), recording.display());
        if !output.status.code().is_some_and(|code| COMPLETE.contains(&code)) {
            return Err(failed(format!("{}, {}", output.status, String::from_utf8_lossy(&output.stderr).trim())).into());
        }
        let outcome: Outcome = serde_json::from_slice(&output.stdout).map_err(|error| failed(error.to_string()))?;
        Ok(Replay { diagnoses: outcome.diagnoses, seconds })
    }

    /// Simulates a scene into a CSV file.
    pub fn simulate(
        &self,
        scene: &Path,
        duration: f64,
        settle: f64,
        rate: f64,
        out: &Path,
    ) -> Result<(), Box<dyn Error>> {
        let mut command = Command::new(&self.0);
        command.arg("simulate").arg(scene).arg("-o").arg(out);
        command.args([
            "--duration",
            &format!("{duration} s"),
            "--settle",
            &format!("{settle} s"),
            "--rate",
            &format!("{rate} Hz"),
        ]);
        let output = command.output()?;
        if !output.status.success() {
            return Err(format!("{}: {}", scene.display(), String::from_utf8_lossy(&output.stderr).trim()).into());
        }
        Ok(())
    }
}
