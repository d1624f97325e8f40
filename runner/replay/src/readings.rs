//! Readings stage: limits and indicators that need readings and shaft angle only, before a sample waits for the twin.

use super::limits::LimitMonitor;
use super::lines::{Angles, BLOCK_TURNS, Demodulator, Line};
use super::second::{ProbeSecond, Second, SecondIndicators};
use ballrace::Phase;
use ballrace_recording::Sample;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Next event of a recording, before the sample waits for the twin.
pub(super) enum Reading<'s> {
    /// A sample with a shaft angle.
    Sample(Cow<'s, Sample>),
    /// A sample without a shaft angle.
    WithoutAngle,
    /// An interruption of the shaft angle.
    Restart,
}

impl Reading<'_> {
    /// Returns the reading with its own copy of the sample.
    pub(super) fn into_owned(self) -> Reading<'static> {
        match self {
            Self::Sample(sample) => Reading::Sample(Cow::Owned(sample.into_owned())),
            Self::WithoutAngle => Reading::WithoutAngle,
            Self::Restart => Reading::Restart,
        }
    }
}

/// Monitor of readings.
pub(super) struct ReadingsStage {
    /// 1X and 2X of every probe.
    lines: Demodulator,
    /// Revolution, angle and time (s) at the last sample.
    last: Option<(i64, Phase, f64)>,
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
        let now = (sample.revolution, sample.angle, sample.row.time);
        let missed = |(_, _, time): (i64, Phase, f64)| sample.speed.abs() * (sample.row.time - time) / TAU;
        if self.last.is_some_and(|last| missed(last) > BLOCK_TURNS) {
            self.restart(limits);
        }
        let (revolution, angle, _) = self.last.replace(now).unwrap_or(now);
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

    /// Drops unfinished blocks, because the shaft angle is interrupted before the next sample or a whole block is missing.
    pub(super) fn restart(&mut self, limits: &mut LimitMonitor) {
        self.last = None;
        self.lines.interrupt();
        limits.interrupt_readings();
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
