//! Trends: the indicators of one probe from the start of the recording to its end, with limits and events.

use super::axis::{Axis, extent};
use super::canvas::{BAND, BELOW, Canvas, FAULT, Frame, Key, MEASURED_LINE, RESIDUAL, Stroke, WIDE, picture, stacked};
use super::line::Point;
use super::{Context, Figure, Picture, PointBudget};
use ballrace_twin::outcome::Event;
use ballrace_twin::replay::outcome::{Block, BlockFigures, LimitLine, Pictures, ProbeOutcome, TrendField};

const HEIGHT: f64 = 70.0;
const LIMIT: Stroke = Stroke(FAULT, 1.4);

/// Data of one probe's trend.
pub(super) struct Trend<'a> {
    /// The probe, and its index.
    pub(super) name: &'a str,
    pub(super) probe: usize,
    pub(super) blocks: &'a [Block],
    pub(super) limits: Vec<&'a LimitLine>,
    pub(super) events: Vec<&'a Event>,
}

/// Trends, one per probe of a recording of several blocks.
pub(super) struct Trends;

impl Figure for Trends {
    fn heading(&self) -> &'static str {
        "Trends"
    }

    fn lines(&self, data: &Pictures) -> usize {
        BlockFigures::TRENDS.len() * data.traces.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let (outcome, data) = (context.outcome, context.data);
        let probes = outcome.probes.iter().enumerate().filter(|_| data.blocks.len() > 1);
        let one = |(probe, named): (usize, &ProbeOutcome)| {
            let name = named.name.as_str();
            let limits = data.limits.iter().filter(|limit| limit.probe == name).collect();
            let events = outcome.events.iter().filter(|event| event.probe == name).collect();
            trend(&Trend { name, probe, blocks: &data.blocks, limits, events }, context.budget)
        };
        probes.map(one).collect()
    }
}

/// Draws the trend of one probe.
pub(super) fn trend(trend: &Trend, budget: PointBudget) -> Picture {
    let clock = Clock::of(trend.blocks);
    let frames = frames(trend, &clock);
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let left = frames.first().map_or(0.0, |frame| frame.left);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        canvas.legend(left, 0.0, &legend(trend));
        for (k, (frame, field)) in frames.iter().zip(&BlockFigures::TRENDS).enumerate() {
            events(canvas, frame, trend, field, &clock);
            frame.axes(canvas, k + 1 == BlockFigures::TRENDS.len());
            frame.levels(canvas, trend.limits_of(field), LIMIT);
            let points = trend.points(field, &clock);
            frame.series(canvas, ("measured", &points), budget.time(), MEASURED_LINE);
            frame.note_if_empty(canvas, &[&points]);
        }
    });
    Picture { title: format!("Trend of {}", trend.name), note: trend.words(), drawing, ..Picture::default() }
}

impl Trend<'_> {
    fn points(&self, field: &TrendField, clock: &Clock) -> Vec<Point> {
        let of = |block: &Block| {
            let value = block.probes.get(self.probe).map_or(f64::NAN, field.field.value);
            (0.5 * (block.start_s + block.end_s) * clock.scale, value)
        };
        self.blocks.iter().map(of).collect()
    }

    fn limits_of<'s>(&'s self, field: &'s TrendField) -> impl Iterator<Item = f64> + 's {
        self.limits.iter().filter(|limit| limit.indicator == field.indicator.name()).map(|limit| limit.max)
    }

    fn words(&self) -> String {
        let others = self.events.iter().filter(|event| !is_drawn(event.indicator)).count();
        let others = if others > 0 { " Events of other indicators: shaded in all." } else { "" };
        format!(
            "Blocks of four turns, or neighbours of them joined: peak to peak is the greatest, the others are means. Limits \
             are compared with blocks of 16 turns.{others}"
        )
    }
}

fn legend(trend: &Trend) -> Vec<(Key, &'static str)> {
    let mut legend = vec![(Key::Line(MEASURED_LINE), "measured")];
    if !trend.limits.is_empty() {
        legend.push((Key::Line(LIMIT), "limit"));
    }
    if !trend.events.is_empty() {
        legend.push((Key::Band(BAND), "limit crossed"));
    }
    legend
}

fn frames(trend: &Trend, clock: &Clock) -> Vec<Frame> {
    let ends = trend.blocks.iter().flat_map(|block| [block.start_s, block.end_s]);
    let x = Axis::exact(extent(ends.map(|t| t * clock.scale)), 7, clock.title);
    let axis = |field: &TrendField| {
        let values = trend.points(field, clock).into_iter().map(|point| point.1);
        let highest = extent(values.chain(trend.limits_of(field))).map(|range| range.1);
        Axis::from_zero(highest, 3, &field.field.title())
    };
    stacked(&x, BlockFigures::TRENDS.iter().map(axis).collect(), (34.0, HEIGHT, 20.0))
}

/// Returns true for an indicator with a frame.
fn is_drawn(indicator: &str) -> bool {
    BlockFigures::TRENDS.iter().any(|field| field.indicator.name() == indicator)
}

/// Shades the events of this field's indicator, from start to end. Events of indicators that are not drawn are shaded in every frame.
fn events(canvas: &mut Canvas, frame: &Frame, trend: &Trend, field: &TrendField, clock: &Clock) {
    let shown = trend.events.iter().filter(|e| e.indicator == field.indicator.name() || !is_drawn(e.indicator));
    let ranges: Vec<[f64; 2]> = shown
        .map(|event| [event.start_s * clock.scale, event.end_s.map_or(frame.x.high(), |end| end * clock.scale)])
        .collect();
    frame.shade(canvas, ranges.iter().copied(), BAND);
    frame.uprights(canvas, ranges.iter().map(|range| range[0]), Stroke(RESIDUAL, 0.75));
}

/// Unit of the time axis: seconds, minutes or hours.
struct Clock {
    scale: f64,
    title: &'static str,
}

impl Clock {
    fn of(blocks: &[Block]) -> Self {
        // A history has negative times up to the present.
        let longest = blocks.iter().flat_map(|block| [block.start_s, block.end_s]).fold(0.0_f64, |t, x| t.max(x.abs()));
        let (unit, title) = match longest {
            t if t > 3.0 * 3600.0 => (3600.0, "Time, h"),
            t if t > 600.0 => (60.0, "Time, min"),
            _ => (1.0, "Time, s"),
        };
        Self { scale: 1.0 / unit, title }
    }
}
