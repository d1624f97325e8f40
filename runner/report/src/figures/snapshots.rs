//! Trends over snapshots of vibration: statistics of each sensor, and the line that has grown most.

use super::axis::{Axis, extent};
use super::canvas::{BELOW, FAULT, Frame, Key, MEASURED_LINE, Stroke, WIDE, picture, stacked};
use super::line::Point;
use super::{Context, Figure, Picture, PointBudget};
use ballrace_twin::replay::outcome::{FaultKind, LineLevel, NumericField, Outcome, SnapshotFigures, SnapshotTrend};

const HEIGHT: f64 = 78.0;
const ONSET: Stroke = Stroke(FAULT, 1.0);
/// Keys of the statistics that are drawn.
const DRAWN: [&str; 2] = ["rms", "kurtosis"];

/// Trends over snapshots, one picture per sensor.
pub(super) struct SnapshotTrends;

impl Figure for SnapshotTrends {
    fn heading(&self) -> &'static str {
        "Trends over the snapshots"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let first = context.outcome.snapshots.iter().take(1).flat_map(|snapshot| &snapshot.sensors);
        first.enumerate().map(|(k, figures)| sensor(context.outcome, k, &figures.sensor, context.budget)).collect()
    }
}

/// One indicator in a frame.
struct Curve<'a> {
    title: &'static str,
    points: Vec<Point>,
    trend: Option<&'a SnapshotTrend>,
}

fn sensor(outcome: &Outcome, k: usize, name: &str, budget: PointBudget) -> Picture {
    let trends = || outcome.snapshot_trends.iter().filter(|trend| trend.sensor == name);
    let points = |of: &dyn Fn(&SnapshotFigures) -> f64| -> Vec<Point> {
        let value = |figures: Option<&SnapshotFigures>| figures.map_or(f64::NAN, of);
        outcome.snapshots.iter().map(|snapshot| (snapshot.number as f64, value(snapshot.sensors.get(k)))).collect()
    };
    let of = |indicator: &str| trends().find(|trend| trend.indicator == indicator);
    let drawn = SnapshotFigures::FIELDS.into_iter().filter(|field| DRAWN.contains(&field.key));
    let curve = |field: NumericField<SnapshotFigures>| Curve {
        title: field.name,
        points: points(&field.value),
        trend: of(field.key),
    };
    let mut curves: Vec<Curve<'_>> = drawn.map(curve).collect();
    let line = trends().filter(|t| t.component.is_some()).max_by(|a, b| a.growth_db.total_cmp(&b.growth_db));
    let mut note = "A vertical line marks the first snapshot of those that stay above the first tenth.".to_owned();
    if let Some(line) = line {
        let level = |figures: &SnapshotFigures| {
            let is_it = |l: &&LineLevel| is_of(l, line);
            figures.lines.iter().find(is_it).map_or(f64::NAN, |l| l.level_db)
        };
        curves.push(Curve { title: "Line, dB", points: points(&level), trend: Some(line) });
        let component = line.component.map_or("", FaultKind::name).replace('-', " ");
        note +=
            &format!(" Line: {component} of {}, which has grown most.", line.bearing.as_deref().unwrap_or_default());
    }
    let frames = frames(&curves);
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        let left = frames.first().map_or(0.0, |frame| frame.left);
        canvas.legend(left, 0.0, &[(Key::Line(MEASURED_LINE), "measured"), (Key::Line(ONSET), "onset of growth")]);
        for (i, (frame, curve)) in frames.iter().zip(&curves).enumerate() {
            frame.axes(canvas, i + 1 == curves.len());
            frame.uprights(canvas, curve.trend.and_then(|trend| trend.onset).map(|number| number as f64), ONSET);
            frame.series(canvas, (curve.title, &curve.points), budget.time(), MEASURED_LINE);
            frame.note_if_empty(canvas, &[&curve.points]);
        }
    });
    Picture { title: format!("Trend of {name}"), note, drawing, ..Picture::default() }
}

fn is_of(line: &LineLevel, trend: &SnapshotTrend) -> bool {
    Some(&line.bearing) == trend.bearing.as_ref() && Some(line.component) == trend.component
}

fn frames(curves: &[Curve<'_>]) -> Vec<Frame> {
    let numbers = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.0));
    let x = Axis::exact(extent(numbers), 9, "Snapshot");
    let axis = |curve: &Curve<'_>| {
        let highest = extent(curve.points.iter().map(|point| point.1)).map(|range| range.1);
        Axis::from_zero(highest, 3, curve.title)
    };
    stacked(&x, curves.iter().map(axis).collect(), (30.0, HEIGHT, 16.0))
}
