//! Comparison stage: the readings against those of the twin and of simpler predictors, probe by probe.

use super::lines::{Angles, Demodulator, followed, followed_orders, outer_line};
use super::statistics::{MotionSums, ShaftAngles};
use ballrace::Exact;
use ballrace::math::Math;
use ballrace_base::moments::Moments;
use ballrace_outcome::baseline::{Baseline, BaselineProbe};
use ballrace_outcome::{BallPassLine, Motion, ProbeOutcome, SimplePredictor, SimplePredictors};
use ballrace_plant::MountedBearing;
use ballrace_plant::probes::{Plane, reading};
use ballrace_plant::spectrum::Welch;
use ballrace_scene::Probe;

const UM: f64 = 1e6;

/// Readings of one sample at every probe, m.
#[derive(Default)]
pub struct SampleReadings {
    /// Measured, NaN where missing.
    pub measured: Vec<f64>,
    /// At the position of the twin.
    pub twin: Vec<f64>,
    /// At the position of the twin on linear springs.
    pub linear: Vec<f64>,
}

impl SampleReadings {
    /// Computes the readings of a sample from the coordinates of the twins. `measured` is absent where the sample is not compared.
    pub fn evaluate(&mut self, measured: Option<&[f64]>, [twin, linear]: [&[f64]; 2], rows: &[Vec<f64>]) {
        self.measured.clear();
        match measured {
            Some(measured) => self.measured.extend_from_slice(measured),
            None => self.measured.resize(rows.len(), f64::NAN),
        }
        for (readings, position) in [(&mut self.twin, twin), (&mut self.linear, linear)] {
            readings.clear();
            readings.extend(rows.iter().map(|row| reading(row, position)));
        }
    }

    /// Returns true where every probe has a reading.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        !self.measured.iter().any(|y| y.is_nan())
    }
}

#[derive(Default, Clone)]
struct OneProbe {
    /// Shaft angles of the samples in which another probe has no reading.
    angles: ShaftAngles,
    measured: MotionSums,
    twin: MotionSums,
    residual: Moments,
    /// Difference from the previous sample.
    persistence: Moments,
    linear: Moments,
    last: Option<f64>,
}

/// Sums over the recording, of all probes.
pub struct Comparison {
    probes: Vec<OneProbe>,
    /// Shaft angles of the samples with a reading of every probe.
    angles: ShaftAngles,
    /// Order tracking of measured, twin and residual of each probe.
    pub lines: Demodulator,
    /// Spectra of the same signals, and full spectra of the planes.
    pub spectra: Welch,
    /// Number of samples with a reading of every probe.
    pub compared: u64,
    /// Measured readings of the current sample, then those of the twin.
    signals: Vec<f64>,
}

impl Comparison {
    /// Creates the comparison of `probes` probes, of which some form `planes`.
    #[must_use]
    pub fn new(probes: usize, bearings: &[MountedBearing], planes: Vec<Plane>) -> Self {
        Self {
            probes: vec![OneProbe::default(); probes],
            angles: ShaftAngles::default(),
            lines: Demodulator::with_differences(followed(bearings), probes),
            spectra: Welch::new(probes, planes),
            compared: 0,
            signals: Vec::with_capacity(2 * probes),
        }
    }

    /// Adds a sample; returns true where it ends a block of the followed lines.
    pub fn add(&mut self, readings: &SampleReadings, angles: Angles) -> bool {
        let basis: (f64, f64) = Exact::sin_cos(angles.shaft);
        for (i, probe) in self.probes.iter_mut().enumerate() {
            probe.add(readings.measured[i], readings.twin[i], readings.linear[i], basis);
        }
        if !readings.is_complete() {
            let read = self.probes.iter_mut().zip(&readings.measured).filter(|(_, measured)| !measured.is_nan());
            read.for_each(|(probe, _)| probe.angles.add(basis));
            self.spectra.interrupt();
            return false;
        }
        self.angles.add(basis);
        self.compared += 1;
        self.signals.clear();
        self.signals.extend_from_slice(&readings.measured);
        self.signals.extend_from_slice(&readings.twin);
        self.spectra.add(&self.signals);
        self.lines.add(&self.signals, angles)
    }

    /// Ends the recording.
    pub fn finish(&mut self) {
        self.lines.finish();
        self.spectra.finish();
    }

    /// Returns the root mean square of the residual of a probe about its mean, m.
    #[must_use]
    pub(crate) fn residual_rms_about_mean(&self, probe: usize) -> f64 {
        self.probes[probe].residual.rms_about_mean()
    }

    /// Returns the amplitude of a followed line in a probe's motion, m.
    #[must_use]
    pub fn motion_line(&self, line: usize, probe: usize) -> f64 {
        self.lines.amplitude(line, probe)
    }

    /// Returns the amplitude of a followed line in a probe's residual over the last block, m.
    #[must_use]
    pub(crate) fn block_line(&self, line: usize, probe: usize) -> f64 {
        let signal = 2 * self.probes.len() + probe;
        self.lines.block(line).get(signal).map_or(0.0, |[c, s]| c.hypot(*s))
    }

    /// Returns the amplitude of a followed line in a probe's residual, m.
    #[must_use]
    pub(crate) fn residual_line(&self, line: usize, probe: usize) -> f64 {
        self.lines.amplitude(line, 2 * self.probes.len() + probe)
    }

    /// Returns the amplitudes of cosine and sine of each probe's 1X over the last block.
    #[must_use]
    pub fn one_x(&self) -> &[[f64; 2]] {
        self.lines.block(0)
    }

    /// Returns the recording as a baseline for later ones.
    #[must_use]
    pub fn baseline(&self, scene: &str, recording: &str, probes: &[Probe], bearings: &[MountedBearing]) -> Baseline {
        let orders = followed_orders(bearings);
        let lines = orders.len();
        let probe = |(i, probe): (usize, &Probe)| BaselineProbe {
            name: probe.column.clone(),
            residual_rms_um: self.residual_rms_about_mean(i) * UM,
            lines_um: (0..lines).map(|line| self.residual_line(line, i) * UM).collect(),
            motion_lines_um: (0..lines).map(|line| self.motion_line(line, i) * UM).collect(),
        };
        let probes = probes.iter().enumerate().map(probe).collect();
        Baseline::of_probes(scene, recording, orders, probes)
    }

    /// Returns the outcome of every probe.
    #[must_use]
    pub fn outcomes(&self, probes: &[Probe], bearings: &[MountedBearing], mean_speed_hz: f64) -> Vec<ProbeOutcome> {
        probes
            .iter()
            .enumerate()
            .map(|(i, probe)| ProbeOutcome {
                ball_pass: self.ball_pass(i, bearings, mean_speed_hz),
                ..self.probes[i].outcome(probe, self.angles)
            })
            .collect()
    }

    fn ball_pass(&self, probe: usize, bearings: &[MountedBearing], mean_speed_hz: f64) -> Vec<BallPassLine> {
        let n = self.probes.len();
        let moving = bearings.iter().enumerate().filter(|(_, s)| s.kinematics.cage_ratio != 0.0);
        moving
            .map(|(i, bearing)| {
                let amplitude = |signal: usize| self.lines.amplitude(outer_line(i, 1), signal) * UM;
                BallPassLine {
                    bearing: bearing.name.clone(),
                    order: bearing.kinematics.orders.outer_race,
                    frequency_hz: bearing.kinematics.orders.outer_race * mean_speed_hz,
                    measured_um: amplitude(probe),
                    twin_um: amplitude(n + probe),
                    residual_um: amplitude(2 * n + probe),
                }
            })
            .collect()
    }
}

impl OneProbe {
    fn add(&mut self, measured: f64, twin: f64, linear: f64, basis: (f64, f64)) {
        if measured.is_nan() {
            self.last = None;
            return;
        }
        self.measured.add(measured, basis);
        self.twin.add(twin, basis);
        self.residual.add(measured - twin);
        self.linear.add(measured - linear);
        if let Some(last) = self.last.replace(measured) {
            self.persistence.add(measured - last);
        }
    }

    /// Returns the outcome of `probe`; `complete` are the shaft angles of the samples with a reading of every probe.
    fn outcome(&self, probe: &Probe, complete: ShaftAngles) -> ProbeOutcome {
        let angles = complete + self.angles;
        let (_, one_x_left) = self.measured.one_x(&angles);
        let residual = self.residual.rms() * UM;
        let spread = self.measured.rms_about_mean() * UM;
        let against = |rms: f64| SimplePredictor::new(rms, residual, spread);
        let baselines = SimplePredictors {
            mean: against(spread),
            persistence: against(self.persistence.rms() * UM),
            one_x: against(one_x_left * UM),
            linear: against(self.linear.rms() * UM),
        };
        let (measured, twin) = (self.measured.motion(&angles), self.twin.motion(&angles));
        ProbeOutcome {
            name: probe.column.clone(),
            station_mm: probe.station * 1e3,
            angle_deg: probe.direction.angle().map(f64::to_degrees),
            measured,
            twin,
            one_x_error_um: vector_error(&measured, &twin),
            ball_pass: vec![],
            residual_bias_um: self.residual.mean() * UM,
            residual_rms_um: residual,
            nrmse_percent: if spread > 0.0 { 100.0 * residual / spread } else { f64::NAN },
            nrmse_normaliser: "rms of the measured signal about its mean".to_owned(),
            noise_um: probe.noise.map(|n| n * UM),
            baselines,
            list: None,
        }
    }
}

fn vector_error(a: &Motion, b: &Motion) -> f64 {
    let parts = |m: &Motion| {
        let (s, c) = m.one_x_phase_lag_deg.to_radians().sin_cos();
        (m.one_x_um * c, m.one_x_um * s)
    };
    let ((ax, ay), (bx, by)) = (parts(a), parts(b));
    (ax - bx).hypot(ay - by)
}
