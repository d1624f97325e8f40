//! Limit monitoring: compares indicators of each probe with the limits of the scene and reports crossings as events.
//!
//! Indicators are computed over separate blocks of 16 revolutions. An event begins with the block that exceeds a limit and
//! ends with the block that falls below it by the hysteresis. A crossing shorter than the duration of the limit is no event.

use super::lines::{followed, inner_line, outer_line};
use ballrace::Exact;
use ballrace::twin::{BlockStatistics, Statistics};
use ballrace_outcome::baseline::Baseline;
use ballrace_outcome::{Event, LimitLine};
use ballrace_plant::MountedBearing;
use ballrace_plant::error::LimitError;
use ballrace_scene::{Allowed, Direction, Indicator, Limit, Probe};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Largest number of events that are kept for the report.
const MAX_EVENTS: usize = 10_000;

/// State of the limits at the end of their last blocks, from which another process can continue.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LimitState {
    /// Index of the first sample after the last block of readings.
    pub readings_index: Option<u64>,
    /// Index of the first sample after the last block of residuals; none before the twin runs.
    pub residuals_index: Option<u64>,
    /// Limits that are exceeded at the end of these blocks.
    pub crossings: Vec<OpenCrossing>,
}

impl LimitState {
    /// Returns the smaller and the larger index; none before the first sample.
    #[must_use]
    pub fn positions(&self) -> Option<[u64; 2]> {
        let readings = self.readings_index?;
        let residuals = self.residuals_index.unwrap_or(readings);
        Some([readings.min(residuals), readings.max(residuals)])
    }

    /// Returns the state with every index changed by `change`.
    #[must_use]
    pub fn map_positions(self, change: impl Fn(u64) -> u64) -> Self {
        let (readings_index, residuals_index) = (self.readings_index.map(&change), self.residuals_index.map(&change));
        Self { readings_index, residuals_index, ..self }
    }
}

/// A limit that is exceeded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OpenCrossing {
    /// The indicator, as the scene names it.
    pub indicator: String,
    /// The probe's column.
    pub probe: String,
    /// The bearing, for the line of a race.
    pub bearing: Option<String>,
    /// The limit, m or dimensionless.
    pub limit: f64,
    /// True where an event has reported the crossing.
    pub is_reported: bool,
    /// Start of the first block beyond the limit, s.
    pub start_s: f64,
    /// The largest value, in the unit of the limit.
    pub worst: f64,
    /// End of the block with the largest value, s.
    pub worst_s: f64,
}

/// Present value of a limited indicator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LimitStatus {
    /// The indicator, as the scene names it.
    pub indicator: &'static str,
    /// The probe's column.
    pub probe: String,
    /// The bearing, for the line of a race.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Unit of value and limit: um, or empty for a dimensionless indicator.
    pub unit: &'static str,
    /// Value of the last block of 16 revolutions; none before it.
    pub value: Option<f64>,
    /// The limit, in the same unit.
    pub limit: f64,
    /// Start of the exceedance in the recording's time; none while the value is within the limit.
    pub exceeded_since_s: Option<f64>,
}

/// Monitor of one limit on one probe.
struct ProbeLimit {
    limit: Limit,
    probe: usize,
    /// Index of the followed line, where the indicator is a line.
    line: Option<usize>,
    max: f64,
    /// Value of the last block.
    present: Option<f64>,
    /// Largest value so far.
    largest: Option<f64>,
    crossing: Option<Crossing>,
}

/// A crossing that has not ended.
struct Crossing {
    is_reported: bool,
    start: f64,
    worst: f64,
    worst_time: f64,
}

/// All limits of a scene over a recording.
pub(crate) struct LimitMonitor {
    limits: Vec<ProbeLimit>,
    names: Vec<String>,
    /// The current block of readings.
    readings: Block,
    /// The current block of residuals, which starts with the twin.
    residuals: Block,
    events: EndedEvents,
    /// Events since the last call of [`Self::take_events`].
    new_events: Vec<Event>,
}

/// The latest events that have ended, in bounded memory: a monitor runs for months.
#[derive(Default)]
struct EndedEvents {
    latest: VecDeque<Event>,
    /// Number of events before them.
    earlier: u64,
}

impl EndedEvents {
    fn add(&mut self, event: Event) {
        if self.latest.len() >= MAX_EVENTS {
            self.latest.pop_front();
            self.earlier += 1;
        }
        self.latest.push_back(event);
    }
}

/// Statistics of every probe over the current block.
struct Block {
    /// Time of its first sample, s; none before the first.
    start: Option<f64>,
    /// Index of the first sample that is not part of a finished block; none before the first sample.
    next_index: Option<u64>,
    probes: Vec<Statistics<f64, f64>>,
}

impl Block {
    fn new(probes: usize) -> Self {
        Self { start: None, next_index: None, probes: vec![Statistics::new(u32::MAX); probes] }
    }

    /// Returns true where the sample `index` is not part of a block that was finished before a restart.
    fn is_due(&self, index: u64) -> bool {
        self.next_index.is_none_or(|next| index >= next)
    }

    fn add(&mut self, index: u64, time: f64, values: impl Iterator<Item = f64>) {
        self.next_index.get_or_insert(index);
        let is_first = self.start.is_none();
        self.start.get_or_insert(time);
        for (statistics, value) in self.probes.iter_mut().zip(values) {
            if is_first {
                *statistics = Statistics::about(value, u32::MAX);
            }
            statistics.add::<Exact>(value);
        }
    }

    /// Drops the unfinished block; returns its start.
    fn interrupt(&mut self) -> Option<f64> {
        for statistics in &mut self.probes {
            statistics.close::<Exact>();
        }
        self.start.take()
    }

    /// Ends the block with the sample `index` at `time` and begins the next; returns its start and the figures of every probe.
    fn close(&mut self, index: u64, time: f64) -> Option<(f64, Vec<BlockStatistics<f64>>)> {
        let start = self.start.replace(time)?;
        self.next_index = Some(index + 1);
        Some((start, self.probes.iter_mut().map(Statistics::close::<Exact>).collect()))
    }
}

/// Returns true for an indicator of the residual.
const fn is_of_residuals(indicator: Indicator) -> bool {
    matches!(indicator, Indicator::Residual | Indicator::OuterRace | Indicator::InnerRace)
}

impl LimitMonitor {
    /// Creates the monitor of the scene's limits.
    ///
    /// # Errors
    /// A probe or bearing that the scene does not have, growth without a baseline.
    pub fn try_new(
        limits: &[Limit],
        probes: &[Probe],
        mounted: &[MountedBearing],
        baseline: Option<&Baseline>,
    ) -> Result<Self, LimitError> {
        let mut monitored = Vec::new();
        for limit in limits {
            let line = line(limit, mounted)?;
            let named = limit.probe.as_deref();
            let wanted = |p: &Probe| named.map_or(p.direction != Direction::Axial, |name| p.column == name);
            let mut any = false;
            for (probe, _) in probes.iter().enumerate().filter(|(_, p)| wanted(p)) {
                any = true;
                let max = match limit.allowed {
                    Allowed::Most(max) => max,
                    Allowed::Growth(factor) => factor * usual(limit, line, probe, baseline)?,
                };
                let limit = limit.clone();
                monitored.push(ProbeLimit { limit, probe, line, max, present: None, largest: None, crossing: None });
            }
            if !any {
                return Err(LimitError::Probe { found: named.unwrap_or("no radial probe").to_owned() });
            }
        }
        let names = probes.iter().map(|p| p.column.clone()).collect();
        let (readings, residuals) = (Block::new(probes.len()), Block::new(probes.len()));
        Ok(Self { limits: monitored, names, readings, residuals, events: EndedEvents::default(), new_events: vec![] })
    }

    /// Returns true where the scene has no limit.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.limits.is_empty()
    }

    /// Returns the limits as lines of a diagram, in um where they are lengths.
    #[must_use]
    pub fn lines(&self) -> Vec<LimitLine> {
        let line = |monitored: &ProbeLimit| {
            let (_, scale) = monitored.limit.indicator.unit();
            LimitLine {
                indicator: monitored.limit.indicator.name(),
                probe: self.names.get(monitored.probe).cloned().unwrap_or_default(),
                bearing: monitored.limit.bearing.clone(),
                max: monitored.max * scale,
                largest: monitored.largest.map(|value| value * scale),
            }
        };
        self.limits.iter().map(line).collect()
    }

    /// Returns the present value of every limited indicator, in um where it is a length.
    #[must_use]
    pub fn status(&self) -> Vec<LimitStatus> {
        let status = |monitored: &ProbeLimit| {
            let (unit, scale) = monitored.limit.indicator.unit();
            LimitStatus {
                indicator: monitored.limit.indicator.name(),
                probe: self.names.get(monitored.probe).cloned().unwrap_or_default(),
                bearing: monitored.limit.bearing.clone(),
                unit,
                value: monitored.present.map(|value| value * scale),
                limit: monitored.max * scale,
                exceeded_since_s: monitored.crossing.as_ref().filter(|open| open.is_reported).map(|open| open.start),
            }
        };
        self.limits.iter().map(status).collect()
    }

    /// Continues from `state`: samples before its indices are ignored. Crossings of limits that the scene does not have are
    /// dropped.
    pub(crate) fn restore(&mut self, state: &LimitState) {
        (self.readings.next_index, self.residuals.next_index) = (state.readings_index, state.residuals_index);
        for crossing in &state.crossings {
            let names = &self.names;
            let matches = |monitored: &&mut ProbeLimit| {
                monitored.crossing.is_none()
                    && monitored.limit.indicator.name() == crossing.indicator
                    && monitored.limit.bearing == crossing.bearing
                    && names.get(monitored.probe) == Some(&crossing.probe)
                    // A number read from a text file may differ in its last digit.
                    && (monitored.max - crossing.limit).abs() <= 1e-9 * monitored.max.abs()
            };
            if let Some(monitored) = self.limits.iter_mut().find(matches) {
                monitored.crossing = Some(Crossing {
                    is_reported: crossing.is_reported,
                    start: crossing.start_s,
                    worst: crossing.worst,
                    worst_time: crossing.worst_s,
                });
            }
        }
    }

    /// Returns the state at the end of the last block; none without limits and before the first sample.
    #[must_use]
    pub fn state(&self) -> Option<LimitState> {
        if self.is_empty() || self.readings.next_index.is_none() {
            return None;
        }
        let crossing = |monitored: &ProbeLimit| {
            let open = monitored.crossing.as_ref()?;
            Some(OpenCrossing {
                indicator: monitored.limit.indicator.name().to_owned(),
                probe: self.names.get(monitored.probe).cloned().unwrap_or_default(),
                bearing: monitored.limit.bearing.clone(),
                limit: monitored.max,
                is_reported: open.is_reported,
                start_s: open.start,
                // An infinite value has no form in JSON.
                worst: open.worst.min(f64::MAX),
                worst_s: open.worst_time,
            })
        };
        Some(LimitState {
            readings_index: self.readings.next_index,
            residuals_index: self.residuals.next_index,
            crossings: self.limits.iter().filter_map(crossing).collect(),
        })
    }

    /// Returns true where the readings of sample `index` are not part of a block that was finished before a restart.
    #[must_use]
    pub(crate) fn are_readings_due(&self, index: u64) -> bool {
        self.readings.is_due(index)
    }

    /// Returns true where the residuals of sample `index` are not part of such a block.
    #[must_use]
    pub(crate) fn are_residuals_due(&self, index: u64) -> bool {
        self.residuals.is_due(index)
    }

    /// Adds a sample with a reading of every probe, for limits on readings.
    pub(crate) fn add_readings(&mut self, index: u64, time: f64, measured: &[f64]) {
        if !self.is_empty() && self.readings.is_due(index) {
            self.readings.add(index, time, measured.iter().copied());
        }
    }

    /// Adds the residuals of such a sample, for limits on residuals.
    pub(crate) fn add_residuals(&mut self, index: u64, time: f64, measured: &[f64], twin: &[f64]) {
        if !self.is_empty() && self.residuals.is_due(index) {
            self.residuals.add(index, time, measured.iter().zip(twin).map(|(y, x)| y - x));
        }
    }

    /// Ends a block of readings with the sample `index` at `time`; `amplitude` returns a followed line's amplitude in a probe's motion, m.
    pub(crate) fn close_readings(&mut self, index: u64, time: f64, amplitude: impl Fn(usize, usize) -> f64) {
        let Some((start, figures)) = self.readings.close(index, time) else { return };
        self.evaluate(start, time, |monitored| {
            let of = &figures[monitored.probe];
            match monitored.limit.indicator {
                Indicator::PeakToPeak => Some(of.peak_to_peak),
                Indicator::Rms => Some(of.rms),
                Indicator::CrestFactor => Some(of.crest_factor),
                Indicator::Kurtosis => Some(of.kurtosis),
                Indicator::OneX => Some(amplitude(0, monitored.probe)),
                Indicator::TwoX => Some(amplitude(1, monitored.probe)),
                Indicator::Residual | Indicator::OuterRace | Indicator::InnerRace => None,
            }
        });
    }

    /// Ends a block of residuals with the sample `index` at `time`; `amplitude` returns the amplitude of a followed line in the
    /// residual of a probe, m.
    pub(crate) fn close_residuals(&mut self, index: u64, time: f64, amplitude: impl Fn(usize, usize) -> f64) {
        let Some((start, figures)) = self.residuals.close(index, time) else { return };
        self.evaluate(start, time, |monitored| match monitored.limit.indicator {
            Indicator::Residual => Some(figures[monitored.probe].rms),
            Indicator::OuterRace | Indicator::InnerRace => {
                Some(monitored.line.map_or(0.0, |line| amplitude(line, monitored.probe)))
            }
            _ => None,
        });
    }

    /// Ends the crossings of limits on readings at the end of their last block and drops the unfinished one, because the shaft angle is
    /// interrupted: a block does not reach over a standstill.
    pub(crate) fn interrupt_readings(&mut self) {
        let end = self.readings.interrupt();
        self.end_crossings(end, false);
    }

    /// Ends the crossings of limits on residuals and drops their unfinished block, as [`Self::interrupt_readings`].
    pub(crate) fn interrupt_residuals(&mut self) {
        let end = self.residuals.interrupt();
        self.end_crossings(end, true);
    }

    fn end_crossings(&mut self, end: Option<f64>, of_residuals: bool) {
        let Some(end) = end else { return };
        for monitored in self.limits.iter_mut().filter(|one| is_of_residuals(one.limit.indicator) == of_residuals) {
            let Some(open) = monitored.crossing.take() else { continue };
            if let Some(event) = monitored.event(&open, Some(end), end, &self.names[monitored.probe]) {
                self.new_events.push(event.clone());
                self.events.add(event);
            }
        }
    }

    /// Compares the limits whose indicator has a `value` in the block from `start` to `end`.
    fn evaluate(&mut self, start: f64, end: f64, value: impl Fn(&ProbeLimit) -> Option<f64>) {
        for monitored in &mut self.limits {
            let (Some(value), Some(name)) = (value(monitored), self.names.get(monitored.probe)) else { continue };
            if let Some(event) = monitored.add(value, start, end, name) {
                self.new_events.push(event.clone());
                self.events.add(event);
            }
            self.new_events.extend(monitored.report(end, name));
        }
    }

    /// Returns the crossings that became events (without an end) and the events that ended since the last call.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.new_events)
    }

    /// Returns a note on the number of events that [`Self::finish`] does not return.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        let EndedEvents { latest, earlier } = &self.events;
        let count = latest.len();
        (*earlier > 0).then(|| format!("{earlier} exceedances of limits before the last {count} are not listed."))
    }

    /// Returns the latest events, those without an end last.
    pub fn finish(self) -> Vec<Event> {
        let Self { mut limits, names, readings, residuals, events, .. } = self;
        let mut events = Vec::from(events.latest);
        for monitored in &mut limits {
            if let Some(open) = monitored.crossing.take() {
                let block = if is_of_residuals(monitored.limit.indicator) { &residuals } else { &readings };
                let last = block.start.unwrap_or(open.start);
                events.extend(monitored.event(&open, None, last, &names[monitored.probe]));
            }
        }
        events
    }
}

impl ProbeLimit {
    /// Adds the value of a block from `start` to `end`; returns the event that it ends.
    fn add(&mut self, value: f64, start: f64, end: f64, probe: &str) -> Option<Event> {
        self.present = Some(value);
        self.largest = Some(self.largest.map_or(value, |largest| largest.max(value)));
        match &mut self.crossing {
            None => {
                if value > self.max {
                    self.crossing = Some(Crossing { is_reported: false, start, worst: value, worst_time: end });
                }
                None
            }
            Some(open) if value > self.max * (1.0 - self.limit.hysteresis) => {
                if value > open.worst {
                    (open.worst, open.worst_time) = (value, end);
                }
                None
            }
            Some(_) => self.crossing.take().and_then(|open| self.event(&open, Some(start), start, probe)),
        }
    }

    /// Returns the crossing as an event without an end, once, as soon as it has lasted long enough.
    fn report(&mut self, now: f64, probe: &str) -> Option<Event> {
        let open = self.crossing.as_ref().filter(|open| !open.is_reported)?;
        let mut event = self.event(open, None, now, probe)?;
        event.sentence = event.sentence.replace(" to the end,", " on,");
        if let Some(open) = &mut self.crossing {
            open.is_reported = true;
        }
        Some(event)
    }

    fn event(&self, open: &Crossing, end: Option<f64>, last: f64, probe: &str) -> Option<Event> {
        if last - open.start < self.limit.duration {
            return None;
        }
        let name = self.limit.indicator.name();
        let (unit, scale) = self.limit.indicator.unit();
        let space = if unit.is_empty() { "" } else { " " };
        let of = self.limit.bearing.as_ref().map_or_else(String::new, |b| format!(" of {b}"));
        let until = end.map_or_else(|| "the end".to_owned(), |t| format!("{t:.2} s"));
        let (worst, limit) = (open.worst * scale, self.max * scale);
        Some(Event {
            indicator: name,
            probe: probe.to_owned(),
            bearing: self.limit.bearing.clone(),
            start_s: open.start,
            end_s: end,
            worst,
            worst_s: open.worst_time,
            limit,
            unit,
            sentence: format!(
                "Limit crossed: {name}{of} at {probe} up to {worst:.3}{space}{unit}, limit {limit:.3}{space}{unit}, from {:.2} s to {until}, worst at {:.2} s.",
                open.start, open.worst_time
            ),
        })
    }
}

/// Returns the index of the indicator among the followed lines; none where it is no line.
fn line(limit: &Limit, mounted: &[MountedBearing]) -> Result<Option<usize>, LimitError> {
    let of: fn(usize, i32) -> usize = match limit.indicator {
        Indicator::OuterRace => outer_line,
        Indicator::InnerRace => inner_line,
        Indicator::OneX => return Ok(Some(0)),
        Indicator::TwoX => return Ok(Some(1)),
        _ => return Ok(None),
    };
    let named = |s: &MountedBearing| limit.bearing.as_ref().is_some_and(|name| *name == s.name);
    let Some(i) = mounted.iter().position(named) else {
        return Err(LimitError::Bearing { found: limit.bearing.clone().unwrap_or_else(|| "none".to_owned()) });
    };
    debug_assert!(of(i, 1) < followed(mounted).len());
    Ok(Some(of(i, 1)))
}

/// Returns the value of an indicator in the baseline.
fn usual(limit: &Limit, line: Option<usize>, probe: usize, baseline: Option<&Baseline>) -> Result<f64, LimitError> {
    let baseline = baseline.ok_or(LimitError::NoBaseline)?;
    let usual = match (limit.indicator, line) {
        (Indicator::OuterRace | Indicator::InnerRace, Some(line)) => baseline.line(line, probe),
        (_, Some(line)) => baseline.motion_line(line, probe),
        _ => baseline.residual(probe),
    };
    if usual > 0.0 {
        return Ok(usual);
    }
    Err(LimitError::Indicator { indicator: limit.indicator.name() })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;
