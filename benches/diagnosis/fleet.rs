//! A folder of recordings with known faults: `truth.json`, and one folder a rotor with `scene.toml`, `scene-rough.toml` and
//! the recordings.

use serde::{Deserialize, Serialize};
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

/// The recording of the machine in good order that calibrates a rough scene.
pub const HEALTHY: &str = "healthy";
/// The kind of a recording without a fault.
pub const NO_FAULT: &str = "none";
/// The kind of a recording with several faults, which `faults` lists.
pub const SEVERAL: &str = "several";

/// Least effect of a fault on a probe that can be seen, um: rms, and of the mean.
const VISIBLE: (f64, f64) = (0.1, 1.0);

/// A fault as `truth.json` states it: SI units, angles in rad.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    pub kind: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Spall: angle on the outer ring from +X, on the inner ring from the keyphasor mark.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_width: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth: Option<f64>,
    /// Waves around the surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt: Option<f64>,
    /// Axis of the tilt, from +X.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<f64>,
    /// Diametral clearance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance: Option<f64>,
    /// Unbalance, kg m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moment: Option<f64>,
    /// Angle of the unbalance from the keyphasor mark.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Station of the unbalance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub station: Option<f64>,
}

impl Fault {
    /// Returns `spall` or `waviness` where the fault is one of them.
    pub fn form(&self) -> Option<&'static str> {
        self.depth.map(|_| "spall").or(self.amplitude.map(|_| "waviness"))
    }
}

/// A recording and its faults.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Recording {
    /// Folder of the rotor.
    pub rig: String,
    /// Name of the recording, without its extension.
    pub recording: String,
    /// Conditions of the recording, such as `1 um noise`; empty for the usual ones.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub group: String,
    #[serde(flatten)]
    fault: Fault,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    faults: Vec<Fault>,
    /// What the fault changes at a probe, um: rms, and of the mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    effect_rms_um: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    effect_mean_um: Option<f64>,
}

impl Recording {
    /// Creates an entry of `truth.json`.
    pub fn new(rig: &str, recording: &str, group: &str, faults: &[Fault]) -> Self {
        let of_kind = |kind: &str| Fault { kind: kind.to_owned(), ..Fault::default() };
        let (fault, faults) = match faults {
            [] => (of_kind(NO_FAULT), vec![]),
            [fault] => (fault.clone(), vec![]),
            several => (of_kind(SEVERAL), several.to_vec()),
        };
        Self {
            rig: rig.to_owned(),
            recording: recording.to_owned(),
            group: group.to_owned(),
            fault,
            faults,
            ..Self::default()
        }
    }

    /// Returns true where the fault moves a probe by more than recordings of a sound machine differ, or where that is not known.
    pub fn is_visible(&self) -> bool {
        let (rms, mean) = VISIBLE;
        self.effect_rms_um.is_none_or(|effect| effect >= rms)
            || self.effect_mean_um.is_some_and(|effect| effect >= mean)
    }

    /// Returns the entry with what its fault changes at a probe: rms, and of the mean.
    pub fn with_effect(self, effect_um: Option<[f64; 2]>) -> Self {
        let [effect_rms_um, effect_mean_um] = [0, 1].map(|i| effect_um.map(|effect| effect[i]));
        Self { effect_rms_um, effect_mean_um, ..self }
    }

    /// Returns the faults of the machine; empty where it is in good order.
    pub fn faults(&self) -> &[Fault] {
        match self.fault.kind.as_str() {
            NO_FAULT => &[],
            SEVERAL => &self.faults,
            _ => std::slice::from_ref(&self.fault),
        }
    }

    /// Returns the name of the recording with its conditions.
    pub fn title(&self) -> String {
        if self.group.is_empty() { self.recording.clone() } else { format!("{}, {}", self.recording, self.group) }
    }
}

/// A folder of recordings.
pub struct Fleet {
    pub folder: PathBuf,
    pub recordings: Vec<Recording>,
    /// The recordings at slow roll that scenes name are left out.
    pub no_slow_roll: bool,
}

impl Fleet {
    /// Reads `truth.json` of a folder.
    pub fn read(folder: &Path) -> Result<Self, Box<dyn Error>> {
        let path = folder.join("truth.json");
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let recordings = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { folder: folder.to_owned(), recordings, no_slow_roll: false })
    }

    /// Writes `truth.json`.
    pub fn write(&self) -> Result<(), Box<dyn Error>> {
        Ok(fs::write(self.folder.join("truth.json"), serde_json::to_string_pretty(&self.recordings)? + "\n")?)
    }

    /// Returns the path of a recording, which may be compressed.
    pub fn file(&self, rig: &str, recording: &str) -> PathBuf {
        let path = |ending: &str| self.folder.join(rig).join(format!("{recording}{ending}"));
        let compressed = path(".npy.gz");
        if compressed.is_file() { compressed } else { path(".npy") }
    }

    /// Returns the path of a rotor's scene.
    pub fn scene(&self, rig: &str, rough: bool) -> PathBuf {
        self.folder.join(rig).join(if rough { "scene-rough.toml" } else { "scene.toml" })
    }

    /// Returns the path of a rotor's scene, or of a copy in `folder` without its recording at slow roll.
    pub fn scene_without_slow_roll(&self, rig: &str, rough: bool, folder: &Path) -> Result<PathBuf, Box<dyn Error>> {
        let scene = self.scene(rig, rough);
        if !self.no_slow_roll {
            return Ok(scene);
        }
        let text = fs::read_to_string(&scene)?;
        let lines: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("run_out")).collect();
        let copy = folder.join(rig).with_extension("toml");
        fs::write(&copy, lines.join("\n") + "\n")?;
        Ok(copy)
    }

    /// Returns the folders of the rotors, each once.
    pub fn rigs(&self) -> Vec<&str> {
        let mut rigs: Vec<&str> = self.recordings.iter().map(|recording| recording.rig.as_str()).collect();
        rigs.dedup();
        rigs
    }
}
