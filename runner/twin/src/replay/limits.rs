//! Limits of the scene: which figure of which probe was beyond its limit, from when to when, and how far.
//!
//! Figures are of blocks of 16 turns, so that each starts anew. An event begins with the block that crosses a limit and
//! lasts until a block falls below it by the hysteresis; what lasts shorter than the limit's duration is no event.

use super::baseline::Baseline;
use super::comparison::{followed, inner_line, outer_line};
use super::outcome::LimitLine;
use crate::fault::SceneFault;
use crate::plant::Seat;
use crate::scene::{Allowed, Direction, Indicator, Limit, Probe};
use anyhow::{Result, bail};
use ballrace::Exact;
use ballrace::twin::{Figures, Statistics};
use serde::Serialize;

const UM: f64 = 1e6;

/// A limit that was crossed.
#[derive(Debug, Clone, Serialize)]
pub struct Event {
    /// The indicator, as the scene names it.
    pub indicator: &'static str,
    /// The probe's column.
    pub probe: String,
    /// Of a race's line.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bearing: Option<String>,
    /// Start of the first block beyond the limit, s.
    pub start_s: f64,
    /// End of the last one; none where it was still beyond at the end of the recording.
    pub end_s: Option<f64>,
    /// The worst value and the end of its block.
    pub worst: f64,
    /// s
    pub worst_s: f64,
    /// The limit.
    pub limit: f64,
    /// Of `worst` and `limit`: um, or nothing.
    pub unit: &'static str,
    /// For the maintenance engineer.
    pub sentence: String,
}

/// One limit on one probe.
struct Guard {
    limit: Limit,
    probe: usize,
    /// Index of the followed line, where the indicator is one.
    line: Option<usize>,
    max: f64,
    open: Option<Open>,
}

struct Open {
    told: bool,
    start: f64,
    worst: f64,
    worst_at: f64,
}

/// All limits of a scene over a recording.
pub struct Guards {
    guards: Vec<Guard>,
    names: Vec<String>,
    /// The running block of readings.
    readings: Block,
    /// The running block of residuals, which follows where the twin runs.
    residuals: Block,
    events: Vec<Event>,
    news: Vec<Event>,
}

/// Statistics of every probe over a running block.
struct Block {
    /// Time of its first sample, s; none before the first.
    start: Option<f64>,
    probes: Vec<Statistics<f64>>,
}

impl Block {
    fn new(probes: usize) -> Self {
        Self { start: None, probes: vec![Statistics::new(u32::MAX); probes] }
    }

    fn add(&mut self, time: f64, values: impl Iterator<Item = f64>) {
        self.start.get_or_insert(time);
        for (statistics, value) in self.probes.iter_mut().zip(values) {
            statistics.add::<Exact>(value);
        }
    }

    /// Ends the block at `time` and begins the next; returns its start and the figures of every probe.
    fn close(&mut self, time: f64) -> Option<(f64, Vec<Figures<f64>>)> {
        let start = self.start.replace(time)?;
        Some((start, self.probes.iter_mut().map(Statistics::close::<Exact>).collect()))
    }
}

impl Guards {
    /// From the scene's limits.
    ///
    /// # Errors
    /// A probe or bearing that the scene does not have, growth without a baseline.
    pub fn try_new(limits: &[Limit], probes: &[Probe], seats: &[Seat], baseline: Option<&Baseline>) -> Result<Self> {
        let mut guards = Vec::new();
        for limit in limits {
            let line = line(limit, seats)?;
            let named = limit.probe.as_deref();
            let wanted = |p: &Probe| named.map_or(p.direction != Direction::Axial, |name| p.column == name);
            let mut any = false;
            for (probe, _) in probes.iter().enumerate().filter(|(_, p)| wanted(p)) {
                any = true;
                let max = match limit.allowed {
                    Allowed::Most(max) => max,
                    Allowed::Growth(factor) => factor * usual(limit, line, probe, baseline)?,
                };
                guards.push(Guard { limit: limit.clone(), probe, line, max, open: None });
            }
            if !any {
                bail!(SceneFault(format!(
                    "limit: probe: found {:?}, allowed: a probe of [recording]",
                    named.unwrap_or("no radial probe")
                )));
            }
        }
        let names = probes.iter().map(|p| p.column.clone()).collect();
        let (readings, residuals) = (Block::new(probes.len()), Block::new(probes.len()));
        Ok(Self { guards, names, readings, residuals, events: vec![], news: vec![] })
    }

    /// True where the scene has no limit.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.guards.is_empty()
    }

    /// The limits as lines to draw, in um where they are lengths.
    #[must_use]
    pub fn lines(&self) -> Vec<LimitLine> {
        let line = |guard: &Guard| {
            let (indicator, length) = guard.limit.indicator.name();
            let max = guard.max * if length { UM } else { 1.0 };
            LimitLine { indicator, probe: self.names.get(guard.probe).cloned().unwrap_or_default(), max }
        };
        self.guards.iter().map(line).collect()
    }

    /// Adds a sample with a reading of every probe, for limits on readings.
    pub fn add_readings(&mut self, time: f64, measured: &[f64]) {
        if !self.is_empty() {
            self.readings.add(time, measured.iter().copied());
        }
    }

    /// Adds the residuals of such a sample, for limits on residuals.
    pub fn add_residuals(&mut self, time: f64, measured: &[f64], twin: &[f64]) {
        if !self.is_empty() {
            self.residuals.add(time, measured.iter().zip(twin).map(|(y, x)| y - x));
        }
    }

    /// Ends a block of readings at `time`; `amplitude` returns a followed line's amplitude in a probe's motion, m.
    pub fn close_readings(&mut self, time: f64, amplitude: impl Fn(usize, usize) -> f64) {
        let Some((start, figures)) = self.readings.close(time) else { return };
        self.evaluate(start, time, |guard| {
            let of = &figures[guard.probe];
            match guard.limit.indicator {
                Indicator::PeakToPeak => Some(of.peak_to_peak),
                Indicator::Rms => Some(of.rms),
                Indicator::CrestFactor => Some(of.crest_factor),
                Indicator::Kurtosis => Some(of.kurtosis),
                Indicator::OneX => Some(amplitude(0, guard.probe)),
                Indicator::TwoX => Some(amplitude(1, guard.probe)),
                Indicator::Residual | Indicator::OuterRace | Indicator::InnerRace => None,
            }
        });
    }

    /// Ends a block of residuals at `time`; `amplitude` returns a followed line's amplitude in a probe's residual, m.
    pub fn close_residuals(&mut self, time: f64, amplitude: impl Fn(usize, usize) -> f64) {
        let Some((start, figures)) = self.residuals.close(time) else { return };
        self.evaluate(start, time, |guard| match guard.limit.indicator {
            Indicator::Residual => Some(figures[guard.probe].rms),
            Indicator::OuterRace | Indicator::InnerRace => {
                Some(guard.line.map_or(0.0, |line| amplitude(line, guard.probe)))
            }
            _ => None,
        });
    }

    /// Compares the limits whose indicator has a `value` in the block from `start` to `end`.
    fn evaluate(&mut self, start: f64, end: f64, value: impl Fn(&Guard) -> Option<f64>) {
        for guard in &mut self.guards {
            let (Some(value), Some(name)) = (value(guard), self.names.get(guard.probe)) else { continue };
            if let Some(event) = guard.hear(value, start, end, name) {
                self.news.push(event.clone());
                self.events.push(event);
            }
            self.news.extend(guard.tell(end, name));
        }
    }

    /// Crossings that have lasted long enough to be events (without an end), and events that ended, since the last call.
    pub fn news(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.news)
    }

    /// The events, those still open last.
    pub fn finish(mut self) -> Vec<Event> {
        for guard in &mut self.guards {
            if let Some(open) = guard.open.take() {
                let residual =
                    matches!(guard.limit.indicator, Indicator::Residual | Indicator::OuterRace | Indicator::InnerRace);
                let block = if residual { &self.residuals } else { &self.readings };
                let last = block.start.unwrap_or(open.start);
                self.events.extend(guard.event(&open, None, last, &self.names[guard.probe]));
            }
        }
        self.events
    }
}

impl Guard {
    /// A block's value from `start` to `end`; the event that it ended.
    fn hear(&mut self, value: f64, start: f64, end: f64, probe: &str) -> Option<Event> {
        match &mut self.open {
            None => {
                if value > self.max {
                    self.open = Some(Open { told: false, start, worst: value, worst_at: end });
                }
                None
            }
            Some(open) if value > self.max * (1.0 - self.limit.hysteresis) => {
                if value > open.worst {
                    (open.worst, open.worst_at) = (value, end);
                }
                None
            }
            Some(_) => self.open.take().and_then(|open| self.event(&open, Some(start), start, probe)),
        }
    }

    /// The crossing under way, once, as soon as it is an event.
    fn tell(&mut self, now: f64, probe: &str) -> Option<Event> {
        let open = self.open.as_ref().filter(|open| !open.told)?;
        let mut event = self.event(open, None, now, probe)?;
        event.sentence = event.sentence.replace(" to the end,", " on,");
        if let Some(open) = &mut self.open {
            open.told = true;
        }
        Some(event)
    }

    fn event(&self, open: &Open, end: Option<f64>, last: f64, probe: &str) -> Option<Event> {
        if last - open.start < self.limit.duration {
            return None;
        }
        let (name, length) = self.limit.indicator.name();
        let (size, unit) = if length { (UM, "um") } else { (1.0, "") };
        let space = if length { " um" } else { "" };
        let of = self.limit.bearing.as_ref().map_or_else(String::new, |b| format!(" of {b}"));
        let until = end.map_or_else(|| "the end".to_owned(), |t| format!("{t:.2} s"));
        let (worst, limit) = (open.worst * size, self.max * size);
        Some(Event {
            indicator: name,
            probe: probe.to_owned(),
            bearing: self.limit.bearing.clone(),
            start_s: open.start,
            end_s: end,
            worst,
            worst_s: open.worst_at,
            limit,
            unit,
            sentence: format!(
                "Limit crossed: {name}{of} at {probe} up to {worst:.3}{space}, limit {limit:.3}{space}, from {:.2} s to {until}, worst at {:.2} s.",
                open.start, open.worst_at
            ),
        })
    }
}

/// Index among the followed lines.
fn line(limit: &Limit, seats: &[Seat]) -> Result<Option<usize>> {
    let of: fn(usize, i32) -> usize = match limit.indicator {
        Indicator::OuterRace => outer_line,
        Indicator::InnerRace => inner_line,
        Indicator::OneX => return Ok(Some(0)),
        Indicator::TwoX => return Ok(Some(1)),
        _ => return Ok(None),
    };
    let named = |s: &Seat| limit.bearing.as_ref().is_some_and(|name| *name == s.name);
    let Some(i) = seats.iter().position(named) else {
        bail!(SceneFault(format!(
            "limit: bearing: found {:?}, allowed: the name of a bearing",
            limit.bearing.as_deref().unwrap_or("none")
        )));
    };
    debug_assert!(of(i, 1) < followed(seats).len());
    Ok(Some(of(i, 1)))
}

/// What the baseline says of an indicator.
fn usual(limit: &Limit, line: Option<usize>, probe: usize, baseline: Option<&Baseline>) -> Result<f64> {
    let Some(baseline) = baseline else {
        bail!(SceneFault("limit: growth: found no baseline, allowed: replay with --baseline, or max".to_owned()))
    };
    let usual = match (limit.indicator, line) {
        (Indicator::OuterRace | Indicator::InnerRace, Some(line)) => baseline.line(line, probe),
        (_, Some(line)) => baseline.motion_line(line, probe),
        _ => baseline.residual(probe),
    };
    if usual > 0.0 {
        return Ok(usual);
    }
    let (name, _) = limit.indicator.name();
    bail!(SceneFault(format!(
        "limit: growth_db: found a baseline without {name}, allowed: one learned by this version"
    )))
}
