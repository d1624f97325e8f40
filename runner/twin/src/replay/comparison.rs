//! Measured against twin, probe by probe, as the samples go by.

use super::lines::{Demodulator, Line};
use super::outcome::{BallPassLine, Baseline, Baselines, Motion, ProbeOutcome};
use super::spectrum::Welch;
use super::statistics::Sums;
use crate::plant::MountedBearing;
use crate::scene::{Direction, Probe};
use ballrace::math::Math;
use ballrace::{Exact, Phase};

const UM: f64 = 1e6;

/// Harmonics of the outer ball-pass line that are followed.
pub const OUTER_HARMONICS: i32 = 5;
/// Harmonics of the inner ball-pass line that are followed.
pub const INNER_HARMONICS: i32 = 3;

/// What one sample says at every probe, m.
pub struct SampleReadings<'a> {
    /// Readings, NaN where missing.
    pub measured: &'a [f64],
    /// The twin's.
    pub twin: &'a [f64],
    /// Those of the twin on linear springs.
    pub linear: &'a [f64],
    /// X and Y of each plane, measured then twin, as the spectra take them.
    pub planes: &'a [f64],
}

/// Where the shaft and the cages are.
#[derive(Clone, Copy)]
pub struct Angles<'a> {
    /// Shaft.
    pub shaft: Phase,
    /// Cage of each bearing.
    pub cages: &'a [Phase],
    /// Revolutions since the last sample.
    pub arc: f64,
}

#[derive(Default, Clone)]
struct OneProbe {
    measured: Sums,
    twin: Sums,
    residual: Sums,
    /// Difference to the sample before.
    persistence: Sums,
    linear: Sums,
    last: Option<f64>,
}

/// Sums of all probes.
pub struct Comparison {
    probes: Vec<OneProbe>,
    /// Lines of measured, twin and residual of each probe.
    pub lines: Demodulator,
    /// Spectra of the same, then of the planes.
    pub spectra: Welch,
    /// Samples in which every probe had a reading.
    pub compared: u64,
    signals: Vec<f64>,
}

/// Lines that are followed: 1X, 2X, then of each bearing the outer and inner ball pass and harmonics.
#[must_use]
pub fn followed(seats: &[MountedBearing]) -> Vec<Line> {
    let mut lines = vec![Line::shaft(1), Line::shaft(2)];
    for (i, seat) in seats.iter().enumerate() {
        let n = seat.elements as i32;
        lines.extend((1..=OUTER_HARMONICS).map(|k| Line { shaft: 0, cage: Some((i, k * n)) }));
        lines.extend((1..=INNER_HARMONICS).map(|k| Line { shaft: k * n, cage: Some((i, -k * n)) }));
    }
    lines
}

/// Index in [`followed`] of harmonic `k` (1 is the line itself) of a bearing's outer ball pass.
#[must_use]
pub fn outer_line(bearing: usize, k: i32) -> usize {
    2 + bearing * (OUTER_HARMONICS + INNER_HARMONICS) as usize + (k - 1) as usize
}

/// The same of the inner ball pass.
#[must_use]
pub fn inner_line(bearing: usize, k: i32) -> usize {
    outer_line(bearing, OUTER_HARMONICS + k)
}

impl Comparison {
    /// For probes, seats and planes.
    #[must_use]
    pub fn new(probes: usize, seats: &[MountedBearing], planes: usize) -> Self {
        let first_plane = 3 * probes;
        let pairs = (0..2 * planes).map(|i| (first_plane + 2 * i, first_plane + 2 * i + 1)).collect();
        Self {
            probes: vec![OneProbe::default(); probes],
            lines: Demodulator::new(followed(seats), 3 * probes),
            spectra: Welch::new(first_plane + 4 * planes, pairs),
            compared: 0,
            signals: Vec::with_capacity(3 * probes),
        }
    }

    /// One sample; true where it ended a block of the followed lines.
    pub fn add(&mut self, seen: &SampleReadings, angles: Angles) -> bool {
        let basis: (f64, f64) = Exact::sin_cos(angles.shaft);
        for (i, probe) in self.probes.iter_mut().enumerate() {
            probe.add(seen.measured[i], seen.twin[i], seen.linear[i], basis);
        }
        if seen.measured.iter().any(|y| y.is_nan()) {
            self.spectra.interrupt();
            return false;
        }
        self.compared += 1;
        self.signals.clear();
        self.signals.extend_from_slice(seen.measured);
        self.signals.extend_from_slice(seen.twin);
        self.signals.extend(seen.measured.iter().zip(seen.twin).map(|(y, x)| y - x));
        self.spectra.add(self.signals.iter().chain(seen.planes).copied());
        self.lines.add(&self.signals, angles)
    }

    /// Ends the recording.
    pub fn finish(&mut self) {
        self.lines.finish();
        self.spectra.finish();
    }

    /// Root mean square of the residual of a probe about its mean, m.
    #[must_use]
    pub fn residual_rms_about_mean(&self, probe: usize) -> f64 {
        self.probes[probe].residual.rms_about_mean()
    }

    /// Amplitude of a followed line in a probe's motion, m.
    #[must_use]
    pub fn motion_line(&self, line: usize, probe: usize) -> f64 {
        self.lines.amplitude(line, probe)
    }

    /// Amplitude of a followed line in a probe's residual over the last block, m.
    #[must_use]
    pub fn block_line(&self, line: usize, probe: usize) -> f64 {
        let signal = 2 * self.probes.len() + probe;
        self.lines.block(line).get(signal).map_or(0.0, |[c, s]| c.hypot(*s))
    }

    /// Amplitude of a followed line in a probe's residual, m.
    #[must_use]
    pub fn residual_line(&self, line: usize, probe: usize) -> f64 {
        self.lines.amplitude(line, 2 * self.probes.len() + probe)
    }

    /// The figures of every probe.
    #[must_use]
    pub fn outcomes(&self, probes: &[Probe], seats: &[MountedBearing], mean_speed_hz: f64) -> Vec<ProbeOutcome> {
        probes
            .iter()
            .enumerate()
            .map(|(i, probe)| ProbeOutcome {
                ball_pass: self.ball_pass(i, seats, mean_speed_hz),
                ..self.probes[i].outcome(probe)
            })
            .collect()
    }

    fn ball_pass(&self, probe: usize, seats: &[MountedBearing], mean_speed_hz: f64) -> Vec<BallPassLine> {
        let n = self.probes.len();
        let moving = seats.iter().enumerate().filter(|(_, s)| s.kinematics.cage_ratio != 0.0);
        moving
            .map(|(i, seat)| {
                let amplitude = |signal: usize| self.lines.amplitude(outer_line(i, 1), signal) * UM;
                BallPassLine {
                    bearing: seat.name.clone(),
                    order: seat.kinematics.orders.outer_race,
                    frequency_hz: seat.kinematics.orders.outer_race * mean_speed_hz,
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
        self.residual.add(measured - twin, basis);
        self.linear.add(measured - linear, basis);
        if let Some(last) = self.last.replace(measured) {
            self.persistence.add(measured - last, basis);
        }
    }

    fn outcome(&self, probe: &Probe) -> ProbeOutcome {
        let (_, one_x_left) = self.measured.one_x();
        let residual = self.residual.rms() * UM;
        let spread = self.measured.rms_about_mean() * UM;
        let against = |rms: f64| Baseline::new(rms, residual);
        let baselines = Baselines {
            mean: against(spread),
            persistence: against(self.persistence.rms() * UM),
            one_x: against(one_x_left * UM),
            linear: against(self.linear.rms() * UM),
        };
        let (measured, twin) = (self.measured.motion(), self.twin.motion());
        ProbeOutcome {
            name: probe.column.clone(),
            station_mm: probe.station * 1e3,
            angle_deg: match probe.direction {
                Direction::Radial(angle) => Some(angle.to_degrees()),
                Direction::Axial => None,
            },
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
