//! History of the indicators: the last hours from the indicator files, else the last minutes from memory.

use crate::live::out::history::{INDICATORS, SecondValues, read};
use crate::live::view::View;
use anyhow::Result;
use ballrace_report::live::{self, LiveFigure};
use ballrace_twin::outcome::{Block, BlockFigures, LimitLine, NumericField};
use ballrace_twin::replay::second::ProbeSecond;
use ballrace_twin::scene::Scene;
use std::path::Path;

/// Number of intervals of a history. Each keeps the lowest and the highest value of every indicator.
const INTERVALS: f64 = 400.0;
/// Longest history, h.
const MAX_HOURS: f64 = 168.0;
/// Shortest history, h.
const MIN_HOURS: f64 = 0.1;
/// Seconds per hour.
const HOUR: f64 = 3600.0;

/// Parses `hours=N` with N from 0.1 to 168; 1 without this parameter. Returns `None` for an invalid value.
pub fn parse_hours(query: &str) -> Option<f64> {
    let hours = query.split('&').find_map(|pair| pair.strip_prefix("hours="));
    hours.unwrap_or("1").parse().ok().filter(|hours| (MIN_HOURS..=MAX_HOURS).contains(hours))
}

/// Draws the last `hours` of the files in `folder`, or the seconds of the view without a folder.
///
/// # Errors
/// Returns an error if a file cannot be read.
pub fn figures(scene: &Scene, folder: Option<&Path>, view: &View, hours: f64) -> Result<Vec<LiveFigure>> {
    let names: Vec<&str> = scene.recording.iter().flat_map(|r| &r.probes).map(|p| p.column.as_str()).collect();
    let mut history = History::new(hours * HOUR, names.len());
    let source = match folder {
        Some(folder) => {
            read(folder, &names, hours * HOUR, |second| history.add(second))?;
            "the indicator files"
        }
        None => {
            let last = view.seconds.back().map_or(0.0, |second| second.time_s);
            for second in &view.seconds {
                let values = |probe: &ProbeSecond| {
                    let fields =
                        BlockFigures::TRENDS.map(|trend| NumericField::find(&ProbeSecond::FIELDS, trend.field.key));
                    fields.map(|field| field.map_or(f64::NAN, |field| (field.value)(probe)))
                };
                history.add(&SecondValues {
                    age_s: last - second.time_s,
                    probes: second.probes.iter().map(values).collect(),
                });
            }
            "memory, at most ten minutes: --indicators keeps more"
        }
    };
    let limit = |limit: &ballrace_twin::replay::limits::LimitStatus| LimitLine {
        indicator: limit.indicator,
        probe: limit.probe.clone(),
        bearing: limit.bearing.clone(),
        max: limit.limit,
        largest: None,
    };
    let note = format!(
        "From {source}. 0 is the present. Lowest and highest second of each interval of {:.0} s.",
        history.width
    );
    Ok(live::history(scene, history.blocks(), view.limits.iter().map(limit).collect(), &note))
}

/// Lowest and highest values of every interval.
struct History {
    /// Length of an interval, s.
    width: f64,
    probes: usize,
    /// Lowest and highest value of each indicator of each probe, per interval from the present to the past; empty without a second.
    intervals: Vec<Vec<[[f64; 2]; INDICATORS]>>,
}

impl History {
    fn new(span_s: f64, probes: usize) -> Self {
        let width = (span_s / INTERVALS).max(1.0);
        Self { width, probes, intervals: vec![vec![]; (span_s / width).ceil() as usize] }
    }

    fn add(&mut self, second: &SecondValues) {
        if !(0.0..f64::INFINITY).contains(&second.age_s) {
            return;
        }
        let Some(interval) = self.intervals.get_mut((second.age_s / self.width) as usize) else { return };
        interval.resize(self.probes, [[f64::INFINITY, f64::NEG_INFINITY]; INDICATORS]);
        for (extremes, values) in interval.iter_mut().zip(&second.probes) {
            for ([low, high], value) in extremes.iter_mut().zip(values).filter(|(_, value)| value.is_finite()) {
                (*low, *high) = (low.min(*value), high.max(*value));
            }
        }
    }

    /// Returns two blocks for each interval, from the past to the present. An interval without a second interrupts the lines.
    fn blocks(&self) -> Vec<Block> {
        let number = |value: f64| if value.is_finite() { value } else { f64::NAN };
        let figures = |values: [f64; INDICATORS]| {
            let mut figures = BlockFigures::default();
            BlockFigures::TRENDS.iter().zip(values).for_each(|(trend, value)| (trend.set)(&mut figures, number(value)));
            figures
        };
        let mut blocks = vec![];
        for (i, interval) in self.intervals.iter().enumerate().rev() {
            let middle_s = -(i as f64 + 0.5) * self.width;
            let mut add = |start_s: f64, probes: Vec<BlockFigures>| {
                blocks.push(Block { start_s, end_s: start_s + 0.5 * self.width, probes, ..Block::default() });
            };
            if interval.is_empty() {
                add(middle_s, vec![figures([f64::NAN; INDICATORS]); self.probes]);
            } else {
                add(middle_s - 0.5 * self.width, interval.iter().map(|probe| figures(probe.map(|e| e[0]))).collect());
                add(middle_s, interval.iter().map(|probe| figures(probe.map(|e| e[1]))).collect());
            }
        }
        blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_are_bounded() {
        assert_eq!(
            (parse_hours(""), parse_hours("hours=24"), parse_hours("a=1&hours=0.5")),
            (Some(1.0), Some(24.0), Some(0.5))
        );
        for query in ["hours=0", "hours=1e9", "hours=nan", "hours=", "hours=-1"] {
            assert_eq!(parse_hours(query), None, "{query}");
        }
    }

    #[test]
    fn extremes_survive_and_gaps_interrupt() {
        let mut history = History::new(40.0 * HOUR, 1);
        let seconds = (0..3600).chain(7200..36_000);
        for age in seconds {
            let value = if age == 8000 { 50.0 } else { 1.0 };
            history.add(&SecondValues { age_s: f64::from(age), probes: vec![[value, f64::NAN, 2.0, 3.0]] });
        }
        // A second without a time of day has no place.
        history.add(&SecondValues { age_s: f64::NAN, probes: vec![[99.0, f64::NAN, 2.0, 3.0]] });
        let blocks = history.blocks();
        assert!(blocks.len() < 801, "{}", blocks.len());
        let values: Vec<f64> = blocks.iter().map(|block| block.probes[0].greatest_um_pp).collect();
        assert_eq!(values.iter().copied().fold(0.0, f64::max), 50.0);
        let spike = values.iter().position(|value| *value == 50.0).map(|i| &blocks[i]);
        assert!(spike.is_some_and(|block| (block.start_s + 8000.0).abs() < 400.0), "{spike:?}");
        // One hour without a second, between values.
        let present: Vec<bool> = values.iter().map(|value| value.is_finite()).collect();
        assert_eq!(present.windows(2).filter(|pair| pair[0] != pair[1]).count(), 3);
        assert!(blocks.iter().all(|block| block.probes[0].one_x_um[0].is_nan()));
    }
}
