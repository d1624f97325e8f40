//! Samples without a shaft angle: a shaft that stands still, or whose speed is not measured.
//!
//! Nothing is computed from them. Where a recording has no other samples, their statistics are the report.

use super::statistics::Running;
use ballrace_outcome::{
    BearingOutcome, ForceFigures, Implausibility, Motion, Observation, Outcome, ProbeOutcome, Record, SimplePredictor,
    SimplePredictors, TabularList, Timing,
};
use ballrace_recording::Row;
use ballrace_recording::rotation::RotationError;
use ballrace_scene::Probe;

const UM: f64 = 1e6;

/// Statistics of the samples without a shaft angle.
#[derive(Default)]
pub(super) struct Standstill {
    samples: u64,
    /// Times of the first and the last of them, s.
    times: Option<(f64, f64)>,
    probes: Vec<Signal>,
    /// Why the first of them has no angle.
    reason: Option<RotationError>,
}

/// Readings of one probe, m.
#[derive(Default, Clone)]
struct Signal {
    /// First reading, subtracted from all, so that a large mean costs no digits.
    origin: Option<f64>,
    from_origin: Running,
}

impl Standstill {
    /// Adds a sample.
    pub(super) fn add(&mut self, row: &Row) {
        self.samples += 1;
        self.times = Some((self.times.map_or(row.time, |(first, _)| first), row.time));
        self.probes.resize_with(row.probes.len(), Signal::default);
        for (signal, &reading) in self.probes.iter_mut().zip(&row.probes).filter(|(_, y)| y.is_finite()) {
            signal.add(reading);
        }
    }

    /// Stores why samples have no angle; the first reason is kept.
    pub(super) fn explain(&mut self, reason: RotationError) {
        self.reason.get_or_insert(reason);
    }

    /// Returns the reason where it is a speed that the scene's machine cannot have.
    pub(super) fn implausible_speed(&self) -> Option<&RotationError> {
        self.reason.as_ref().filter(|reason| matches!(reason, RotationError::ImplausibleSpeed { .. }))
    }

    /// Returns the number of samples.
    pub(super) const fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the reason as a note of a report that has other samples; none without such samples.
    pub(super) fn note(&self) -> Option<String> {
        let reason = self.reason.as_ref().filter(|_| self.samples > 0)?;
        Some(format!("{} samples have no shaft angle and are not compared: {reason}.", self.samples))
    }

    /// Returns the report of a recording in which no sample has a shaft angle.
    pub(super) fn outcome(&self, of: Measured) -> Outcome {
        let (first, last) = self.times.unwrap_or_default();
        let record = Record {
            samples: of.rows,
            rate_hz: of.rate,
            duration_s: last - first,
            mean_speed_rpm: f64::NAN,
            min_speed_rpm: f64::NAN,
            max_speed_rpm: f64::NAN,
            angle_source: of.angle_source,
            load: of.load,
            ..Record::default()
        };
        let reason = self.reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
        let not_judged = match &self.reason {
            _ if !of.implausible.is_empty() => vec![],
            Some(RotationError::NoSpeed { .. }) => vec![format!("the shaft speed is not measured{reason}")],
            _ => vec![format!("the shaft did not turn{reason}")],
        };
        Outcome {
            record,
            implausible: of.implausible,
            not_judged,
            observation: of.observation,
            probes: of.probes.iter().enumerate().map(|(i, probe)| self.probe(i, probe)).collect(),
            bearings: of.bearings.into_iter().map(without_forces).collect(),
            timing: Timing { samples: 0, times_real_time: f64::NAN, ..of.timing },
            notes: vec![
                "No sample has a shaft angle: nothing is compared with the twin and nothing is diagnosed; the figures are those of the readings.".to_owned(),
            ],
            ..Outcome::default()
        }
    }

    fn probe(&self, i: usize, probe: &Probe) -> ProbeOutcome {
        let measured = self.probes.get(i).and_then(Signal::motion).unwrap_or(Motion::NONE);
        let absent = SimplePredictor { residual_rms_um: f64::NAN, ..SimplePredictor::default() };
        ProbeOutcome {
            name: probe.column.clone(),
            station_mm: probe.station * 1e3,
            angle_deg: probe.direction.angle().map(f64::to_degrees),
            measured,
            twin: Motion::NONE,
            one_x_error_um: f64::NAN,
            residual_bias_um: f64::NAN,
            residual_rms_um: f64::NAN,
            nrmse_percent: f64::NAN,
            noise_um: probe.noise.map(|n| n * UM),
            baselines: SimplePredictors { mean: absent, persistence: absent, one_x: absent, linear: absent },
            list: Some(TabularList {
                direct_um_pp: measured.peak_to_peak_um,
                greatest_um_pp: measured.peak_to_peak_um,
                gap_um: measured.mean_um,
                ..TabularList::NONE
            }),
            ..ProbeOutcome::default()
        }
    }
}

/// Facts of a replay without a shaft angle.
pub(super) struct Measured<'a> {
    /// The scene's probes.
    pub(super) probes: &'a [Probe],
    /// The bearings with their orders.
    pub(super) bearings: Vec<BearingOutcome>,
    /// How the probes determine the motion.
    pub(super) observation: Observation,
    /// Rows delivered by the reader.
    pub(super) rows: u64,
    /// Sampling rate, Hz.
    pub(super) rate: f64,
    /// Source of the shaft angle.
    pub(super) angle_source: String,
    /// Constant load on the rotor.
    pub(super) load: [f64; 5],
    /// Everything that is not plausible.
    pub(super) implausible: Vec<Implausibility>,
    /// Compute time.
    pub(super) timing: Timing,
}

impl Signal {
    fn add(&mut self, reading: f64) {
        let origin = *self.origin.get_or_insert(reading);
        self.from_origin.add(reading - origin);
    }

    fn motion(&self) -> Option<Motion> {
        let (low, high) = self.from_origin.extremes();
        let mean = self.from_origin.mean();
        Some(Motion {
            mean_um: (self.origin? + mean) * UM,
            peak_to_peak_um: (high - low) * UM,
            rms_um: (self.from_origin.rms().powi(2) - mean * mean).max(0.0).sqrt() * UM,
            ..Motion::NONE
        })
    }
}

fn without_forces(bearing: BearingOutcome) -> BearingOutcome {
    let none = [ForceFigures { mean: f64::NAN, min: f64::NAN, max: f64::NAN, noise_sigma: None }; 5];
    BearingOutcome {
        force_measured: none,
        force_estimated: none,
        force_twin: none,
        straight_line_error: None,
        largest_element_load_n: f64::NAN,
        ..bearing
    }
}
