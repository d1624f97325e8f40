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
    measured: Vec<Statistics<f64>>,
    residual: Vec<Statistics<f64>>,
    since: Option<f64>,
    events: Vec<Event>,
    news: Vec<Event>,
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
        let blocks = || vec![Statistics::new(u32::MAX); probes.len()];
        let names = probes.iter().map(|p| p.column.clone()).collect();
        Ok(Self { guards, names, measured: blocks(), residual: blocks(), since: None, events: vec![], news: vec![] })
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

    /// One sample with a reading of every probe.
    pub fn add(&mut self, time: f64, measured: &[f64], twin: &[f64]) {
        if self.guards.is_empty() {
            return;
        }
        self.since.get_or_insert(time);
        for (i, (y, x)) in measured.iter().zip(twin).enumerate() {
            self.measured[i].add::<Exact>(*y);
            self.residual[i].add::<Exact>(y - x);
        }
    }

    /// Ends a block at `time`; `amplitude` gives a followed line's in a probe's motion (false) or residual (true), m.
    pub fn block(&mut self, time: f64, amplitude: impl Fn(usize, usize, bool) -> f64) {
        let Some(start) = self.since.replace(time) else { return };
        let measured: Vec<Figures<f64>> = self.measured.iter_mut().map(Statistics::close::<Exact>).collect();
        let residual: Vec<Figures<f64>> = self.residual.iter_mut().map(Statistics::close::<Exact>).collect();
        for guard in &mut self.guards {
            let (m, p) = (&measured[guard.probe], guard.probe);
            let value = match guard.limit.indicator {
                Indicator::PeakToPeak => m.peak_to_peak,
                Indicator::Rms => m.rms,
                Indicator::CrestFactor => m.crest_factor,
                Indicator::Kurtosis => m.kurtosis,
                Indicator::Residual => residual[p].rms,
                Indicator::OneX => amplitude(0, p, false),
                Indicator::TwoX => amplitude(1, p, false),
                Indicator::OuterRace | Indicator::InnerRace => guard.line.map_or(0.0, |line| amplitude(line, p, true)),
            };
            if let Some(event) = guard.hear(value, start, time, &self.names[p]) {
                self.news.push(event.clone());
                self.events.push(event);
            }
            self.news.extend(guard.tell(time, &self.names[p]));
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
                let last = self.since.unwrap_or(open.start);
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
