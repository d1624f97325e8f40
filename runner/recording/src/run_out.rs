//! Run-out of the shaft under each probe: mechanical and electrical errors of the measured surface that repeat with the shaft angle.

use std::path::PathBuf;

use ballrace::Phase;

/// Amplitudes of cosine and sine of orders 1, 2, ...
pub(super) type Harmonics = Vec<[f64; 2]>;

/// Run-out of all probes.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOut {
    pub(super) file: PathBuf,
    pub(super) revolutions: usize,
    /// Mean speed, rpm.
    pub(super) speed_rpm: f64,
    pub(super) probes: Vec<ProbeRunOut>,
}

/// Run-out under one probe.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeRunOut {
    /// Column of the probe.
    pub column: String,
    /// Harmonics, m; 0 where an order does not repeat.
    pub(super) harmonics: Harmonics,
}

impl ProbeRunOut {
    /// Returns the run-out at an angle, m.
    fn at(&self, (cosine, sine): (f64, f64)) -> f64 {
        let (mut c, mut s, mut sum) = (cosine, sine, 0.0);
        for [a, b] in &self.harmonics {
            sum += a * c + b * s;
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
        }
        sum
    }

    /// Returns the root of its mean square, m.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (0.5 * self.harmonics.iter().map(|[a, b]| a * a + b * b).sum::<f64>()).sqrt()
    }
}

impl RunOut {
    /// Subtracts the run-out at a shaft angle from the readings of all probes.
    pub(crate) fn subtract(&self, angle: Phase, readings: &mut [f64]) {
        let (sine, cosine) = angle.radians().sin_cos();
        for (reading, probe) in readings.iter_mut().zip(&self.probes) {
            *reading -= probe.at((cosine, sine));
        }
    }

    /// Returns the run-out of each probe.
    #[must_use]
    pub fn probes(&self) -> &[ProbeRunOut] {
        &self.probes
    }

    /// Returns the note of a report.
    #[must_use]
    pub fn note(&self) -> String {
        let each: Vec<String> =
            self.probes.iter().map(|probe| format!("{} {:.3} um", probe.column, probe.rms() * 1e6)).collect();
        format!(
            "The run-out in {}, {} revolutions at {:.1} rpm, is subtracted from the readings; rms: {}.",
            self.file.display(),
            self.revolutions,
            self.speed_rpm,
            each.join(", ")
        )
    }
}
