//! Snapshots of vibration and their trends.

use crate::fault::FaultKind;
use crate::field::{NumericField, UNIT_OF_SENSOR};
use serde::Serialize;

/// One snapshot: a short recording of its own.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SnapshotOutcome {
    /// Number of the file, from 1.
    pub number: usize,
    /// Name of the file.
    pub file: String,
    /// Date and time in the name of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// First time stamp, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_stamp_s: Option<f64>,
    /// One a sensor.
    pub sensors: Vec<SnapshotFigures>,
}

/// Figures of one sensor in a snapshot.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SnapshotFigures {
    /// Column of the sensor.
    pub sensor: String,
    /// Root mean square in the unit of the sensor.
    pub rms: f64,
    /// Largest deviation from the mean in the unit of the sensor.
    pub peak: f64,
    /// Peak over root mean square.
    pub crest_factor: f64,
    /// Kurtosis, 3 for noise.
    pub kurtosis: f64,
    /// Levels of the lines of the bearings, from as many snapshots as have 16 revolutions together.
    pub lines: Vec<LineLevel>,
}

impl SnapshotFigures {
    /// Numeric fields.
    pub const FIELDS: [NumericField<Self>; 4] = [
        NumericField::new("rms", "Rms", UNIT_OF_SENSOR, |figures| figures.rms),
        NumericField::new("peak", "Peak", UNIT_OF_SENSOR, |figures| figures.peak),
        NumericField::new("crest_factor", "Crest factor", "", |figures| figures.crest_factor),
        NumericField::new("kurtosis", "Kurtosis", "", |figures| figures.kurtosis),
    ];
}

/// Level of a line in the envelope spectrum.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LineLevel {
    /// Name of the bearing.
    pub bearing: String,
    /// Component.
    pub component: FaultKind,
    /// Mean level of the line and its first two multiples above their surroundings, in the band where that is the greatest.
    pub level_db: f64,
}

/// Trend of one indicator over the snapshots.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SnapshotTrend {
    /// Column of the sensor.
    pub sensor: String,
    /// `rms`, `peak`, `crest-factor`, `kurtosis` or `line`.
    pub indicator: String,
    /// Bearing of a line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Component of a line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub component: Option<FaultKind>,
    /// Median of the last tenth over that of the first tenth, dB.
    pub growth_db: f64,
    /// Number of the snapshot from which the values stay above those of the first tenth, where chance does not explain it.
    pub onset: Option<usize>,
}
