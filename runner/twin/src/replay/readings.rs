//! Limits and indicators that need readings and shaft angle only: evaluated before the twin takes a sample.

use super::comparison::Angles;
use super::limits::LimitMonitor;
use super::lines::{Demodulator, Line};
use super::second::{ProbeSecond, Second, Seconds};
use crate::recording::Sample;
use ballrace::Phase;

/// Monitors readings.
pub(super) struct Readings {
    /// 1X and 2X of every probe.
    lines: Demodulator,
    /// Revolution and angle at the last sample.
    last: Option<(i64, Phase)>,
    /// Indicators of every second, until the twin supplies them.
    seconds: Option<Seconds>,
    /// In place of the twin's readings.
    no_twin: Vec<f64>,
    /// Seconds that ended.
    ended: Vec<Second>,
}

impl Readings {
    /// For probes of these names; `watched` asks for the indicators of every second.
    pub(super) fn new(names: Vec<String>, watched: bool) -> Self {
        let probes = names.len();
        Self {
            lines: Demodulator::new(vec![Line::shaft(1), Line::shaft(2)], probes),
            last: None,
            seconds: watched.then(|| Seconds::new(names, vec![])),
            no_twin: vec![f64::NAN; probes],
            ended: vec![],
        }
    }

    /// Adds a sample, and compares `limits` where it ends a block.
    pub(super) fn add(&mut self, sample: &Sample, limits: &mut LimitMonitor) {
        let (revolution, angle) =
            self.last.replace((sample.revolution, sample.angle)).unwrap_or((sample.revolution, sample.angle));
        let measured = &sample.row.probes;
        let needed = self.seconds.is_some() || !limits.is_empty();
        if !needed || measured.iter().any(|y| y.is_nan()) {
            return;
        }
        limits.add_readings(sample.row.index, sample.row.time, measured);
        if let Some(seconds) = &mut self.seconds {
            self.ended.extend(seconds.add(sample, &self.no_twin, self.lines.block(0)).map(without_twin));
        }
        let arc = (sample.revolution - revolution) as f64 + (sample.angle.revolutions() - angle.revolutions());
        // After a restart, blocks begin where those of the limits go on.
        let index = sample.row.index;
        if limits.are_readings_due(index) && self.lines.add(measured, Angles { shaft: sample.angle, cages: &[], arc }) {
            let amplitude =
                |line: usize, probe: usize| self.lines.block(line).get(probe).map_or(0.0, |[c, s]| c.hypot(*s));
            limits.close_readings(index, sample.row.time, amplitude);
        }
    }

    /// The shaft angle begins anew with the next sample.
    pub(super) fn restart(&mut self) {
        self.last = None;
    }

    /// The twin follows the samples and supplies the indicators of every second.
    pub(super) fn hand_over(&mut self) {
        self.seconds = None;
    }

    /// Returns the seconds that ended since the last call.
    pub(super) fn ended(&mut self) -> Vec<Second> {
        std::mem::take(&mut self.ended)
    }
}

/// A second without the figures of twin and observer.
fn without_twin(second: Second) -> Second {
    let probe = |probe| ProbeSecond { residual_rms_um: f64::NAN, ..probe };
    let probes = second.probes.into_iter().map(probe).collect();
    Second { innovation: f64::NAN, probes, bearings: vec![], ..second }
}
