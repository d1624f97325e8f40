//! Known errors of the readings of each probe: gap, and run-out of the shaft under it, mechanical and electrical errors of the measured
//! surface that repeat with the shaft angle.

use ballrace::Phase;
use std::fmt::Write as _;

/// Amplitudes of cosine and sine of orders 1, 2, ...
pub(super) type Harmonics = Vec<[f64; 2]>;

/// Run-out of all probes.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOut {
    pub(super) probes: Vec<ProbeRunOut>,
    /// Where it is known from, with its size: a sentence of a report for each source.
    pub(super) notes: Vec<String>,
}

/// Run-out under one probe.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbeRunOut {
    /// Column of the probe.
    pub column: String,
    /// Reading with the shaft in the middle, m; 0 where it is not known.
    pub(super) gap: f64,
    /// Harmonics, m; 0 where an order does not repeat.
    pub(super) harmonics: Harmonics,
}

impl ProbeRunOut {
    /// Returns the run-out at an angle, m.
    fn at(&self, (cosine, sine): (f64, f64)) -> f64 {
        let (mut c, mut s, mut sum) = (cosine, sine, self.gap);
        for [a, b] in &self.harmonics {
            sum += a * c + b * s;
            (c, s) = (c * cosine - s * sine, s * cosine + c * sine);
        }
        sum
    }

    /// Adds an error of the same probe.
    fn add(&mut self, other: &Self) {
        self.gap += other.gap;
        self.harmonics.resize(self.harmonics.len().max(other.harmonics.len()), [0.0; 2]);
        for (sum, x) in self.harmonics.iter_mut().zip(&other.harmonics) {
            *sum = [sum[0] + x[0], sum[1] + x[1]];
        }
    }

    /// Returns the root of the mean square of its run-out, m.
    #[must_use]
    pub fn rms(&self) -> f64 {
        (0.5 * self.harmonics.iter().map(|[a, b]| a * a + b * b).sum::<f64>()).sqrt()
    }
}

impl RunOut {
    /// Adds errors that are known from elsewhere to those of a recording at slow roll: column, gap (m), cosine and sine of each multiple of
    /// the shaft angle (m) of each probe, in the order of the probes.
    #[must_use]
    pub fn with_errors<'a>(
        slow_roll: Option<&Self>,
        errors: impl Iterator<Item = (&'a str, f64, &'a [[f64; 2]])>,
        source: &str,
    ) -> Self {
        let mut sum = slow_roll.cloned().unwrap_or(Self { probes: vec![], notes: vec![] });
        let mut note = format!("Gap and run-out (rms) {source} are subtracted from the readings:");
        for (i, (column, gap, harmonics)) in errors.enumerate() {
            let own = ProbeRunOut { column: column.to_owned(), gap, harmonics: harmonics.to_vec() };
            let comma = if i == 0 { "" } else { "," };
            _ = write!(note, "{comma} {column} {:.2} um and {:.3} um", 1e6 * gap, 1e6 * own.rms());
            match sum.probes.get_mut(i) {
                Some(known) => known.add(&own),
                None => sum.probes.push(own),
            }
        }
        sum.notes.push(note + ".");
        sum
    }

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

    /// Returns the notes of a report: where the errors are known from, and their size.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }
}
