//! The recording as a whole, and the settings of its spectra.

use serde::Serialize;

/// The recording as a whole.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Record {
    /// Rows delivered by the reader.
    pub samples: u64,
    /// Rows that are averaged into one sample of the probes.
    pub average: u32,
    /// Samples, averaged ones counted once, in which every probe was compared.
    pub compared: u64,
    /// Samples per second.
    pub rate_hz: f64,
    /// From the first to the last sample.
    pub duration_s: f64,
    /// Turns of the shaft.
    pub turns: f64,
    /// Mean shaft speed.
    pub mean_speed_rpm: f64,
    /// Slowest.
    pub min_speed_rpm: f64,
    /// Fastest.
    pub max_speed_rpm: f64,
    /// Source of the shaft angle, in words.
    pub angle_source: String,
    /// A run-out measured at slow roll is subtracted from the readings.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_run_out_subtracted: bool,
    /// The scene's constant load on the rotor: N (three) and N m (two).
    pub load: [f64; 5],
    /// Settings of the spectra.
    pub spectra: SpectraSettings,
}

impl Record {
    /// Returns the number of samples, averaged ones counted once.
    #[must_use]
    pub fn averaged(&self) -> u64 {
        self.samples.div_ceil(u64::from(self.average.max(1)))
    }

    /// Returns true where the speed changes by more than 5 % of its mean, so that trends are shown over speed instead of time.
    #[must_use]
    pub fn speed_changes(&self) -> bool {
        (self.max_speed_rpm - self.min_speed_rpm).abs() > 0.05 * self.mean_speed_rpm.abs()
    }
}

/// Settings of the spectra.
#[derive(Debug, Clone, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SpectraSettings {
    /// Spectral lines from 0 Hz to half the rate.
    pub lines: usize,
    /// Hz between two of them.
    pub bin_hz: f64,
    /// Spectra that were averaged.
    pub averages: u64,
}
