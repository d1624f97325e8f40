//! Readings stage: limits and indicators that need readings and shaft angle only, before a sample waits for the twin.

use super::limits::LimitMonitor;
use super::lines::{Angles, Demodulator, Line};
use super::second::{ProbeSecond, Second, SecondIndicators};
use crate::recording::Sample;
use ballrace::Phase;

/// Monitor of readings.
pub(super) struct ReadingsStage {
    /// 1X and 2X of every probe.
    lines: Demodulator,
    /// Revolution and angle at the last sample.
    last: Option<(i64, Phase)>,
    /// Indicators of every second, until the twin supplies them.
    seconds: Option<SecondIndicators>,
    /// NaN for every probe, in place of the twin's readings.
    no_twin: Vec<f64>,
    /// Seconds that ended since the last call of [`Self::take_ended`].
    ended: Vec<Second>,
}

impl ReadingsStage {
    /// Creates the stage for probes of these names. `live` computes the indicators of every second.
    pub(super) fn new(names: Vec<String>, live: bool) -> Self {
        let probes = names.len();
        Self {
            lines: Demodulator::new(vec![Line::shaft(1), Line::shaft(2)], probes),
            last: None,
            seconds: live.then(|| SecondIndicators::new(names, vec![])),
            no_twin: vec![f64::NAN; probes],
            ended: vec![],
        }
    }

    /// Adds a sample, and evaluates `limits` where it ends a block.
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
        let revolutions = (sample.revolution - revolution) as f64 + (sample.angle.revolutions() - angle.revolutions());
        // After a restart, blocks begin where those of the limits go on.
        let index = sample.row.index;
        let angles = Angles { shaft: sample.angle, parts: &[], revolutions };
        if limits.are_readings_due(index) && self.lines.add(measured, angles) {
            let amplitude =
                |line: usize, probe: usize| self.lines.block(line).get(probe).map_or(0.0, |[c, s]| c.hypot(*s));
            limits.close_readings(index, sample.row.time, amplitude);
        }
    }

    /// The shaft angle is interrupted before the next sample.
    pub(super) fn restart(&mut self) {
        self.last = None;
    }

    /// Ends the indicators of every second, because the stages after the twin supply them.
    pub(super) fn stop_seconds(&mut self) {
        self.seconds = None;
    }

    /// Returns the seconds that ended since the last call.
    pub(super) fn take_ended(&mut self) -> Vec<Second> {
        std::mem::take(&mut self.ended)
    }
}

/// Returns a second without the indicators of twin and observer.
fn without_twin(second: Second) -> Second {
    let probe = |probe| ProbeSecond { residual_rms_um: f64::NAN, ..probe };
    let probes = second.probes.into_iter().map(probe).collect();
    Second { innovation: f64::NAN, probes, bearings: vec![], ..second }
}
