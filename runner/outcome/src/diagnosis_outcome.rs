//! Figures of a diagnosis besides the faults: samples used, residual, cages, errors of the readings.

use crate::fault::Estimate;
use serde::Serialize;

/// Figures of a diagnosis.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DiagnosisOutcome {
    /// Samples that were used, the last ones of the recording in a row.
    pub samples: usize,
    /// Revolutions of the shaft in them.
    pub revolutions: f64,
    /// Mean square of the residual in units of its noise, by the machine in good order: about 1 where that describes the recording.
    pub chi_square_before: f64,
    /// The same with the faults found.
    pub chi_square_after: f64,
    /// Cages in the order of the bearings.
    pub cages: Vec<CageOutcome>,
    /// Errors of the readings of a site beyond those of its baseline, in the order of the probes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<ReadingOutcome>,
    /// True at a site whose machine was not recorded in good order before.
    pub is_without_baseline: bool,
}

/// What the readings of a probe have besides the motion of the shaft, as far as the recording shows it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReadingOutcome {
    /// Column of the probe.
    pub probe: String,
    /// Constant part.
    pub gap_um: f64,
    /// Drift over the samples used.
    pub drift_um: f64,
    /// Multiples of the shaft angle, root of the mean square.
    pub run_out_um: f64,
    /// Largest amplitude at a multiple of the frequency of the mains.
    pub hum_um: f64,
    /// Its frequency.
    pub hum_hz: f64,
}

/// Estimate of one cage.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CageOutcome {
    /// Bearing.
    pub bearing: String,
    /// True where the passing of the elements is observable. Otherwise no figure depends on the angle of the cage.
    pub observable: bool,
    /// Cage speed below that of pure rolling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_percent: Option<Estimate>,
    /// Lowest and highest slip while the observer followed the cage through a recording longer than the samples used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub followed_slip_percent: Option<[f64; 2]>,
    /// Cage speed over shaft speed.
    pub cage_ratio: f64,
    /// Azimuth of the first element with the shaft at its angle 0, between 0 and one pitch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub first_element_azimuth_deg: Option<Estimate>,
}
