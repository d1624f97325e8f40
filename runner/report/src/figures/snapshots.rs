//! Trends over snapshots of vibration: statistics of each sensor, and the line that has grown most.

use super::axis::{Axis, extent};
use super::canvas::{Canvas, Dashes, Frame, Key, MEASURED, RESIDUAL, Stroke, gutter, picture};
use super::line::{Point, decimated};
use super::{Context, Figure, Picture, PointBudget};
use anyhow::Result;
use ballrace_twin::replay::outcome::{LineLevel, Outcome, SnapshotFigures, SnapshotTrend};

const WIDTH: f64 = 620.0;
const HEIGHT: f64 = 78.0;
const VALUE: Stroke = Stroke(MEASURED, 1.4);
const ONSET: Stroke = Stroke(RESIDUAL, 1.0);

/// Trends over snapshots, one picture per sensor.
pub(super) struct SnapshotTrends;

impl Figure for SnapshotTrends {
    fn heading(&self) -> &'static str {
        "Trends over the snapshots"
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
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

fn sensor(outcome: &Outcome, k: usize, name: &str, budget: PointBudget) -> Result<Picture> {
    let trends = || outcome.snapshot_trends.iter().filter(|trend| trend.sensor == name);
    let points = |of: &dyn Fn(&SnapshotFigures) -> f64| -> Vec<Point> {
        let value = |figures: Option<&SnapshotFigures>| figures.map_or(f64::NAN, of);
        outcome.snapshots.iter().map(|snapshot| (snapshot.number as f64, value(snapshot.sensors.get(k)))).collect()
    };
    let of = |indicator: &str| trends().find(|trend| trend.indicator == indicator);
    let mut curves = vec![
        Curve { title: "Rms", points: points(&|f| f.rms), trend: of("rms") },
        Curve { title: "Kurtosis", points: points(&|f| f.kurtosis), trend: of("kurtosis") },
    ];
    let line = trends().filter(|t| t.component.is_some()).max_by(|a, b| a.growth_db.total_cmp(&b.growth_db));
    let mut note = "A vertical line marks the first snapshot of those that stay above the first tenth.".to_owned();
    if let Some(line) = line {
        let level = |figures: &SnapshotFigures| {
            let is_it = |l: &&LineLevel| is_of(l, line);
            figures.lines.iter().find(is_it).map_or(f64::NAN, |l| l.level_db)
        };
        curves.push(Curve { title: "Line, dB", points: points(&level), trend: Some(line) });
        let component = serde_json::to_string(&line.component).unwrap_or_default();
        let component = component.trim_matches('"').replace('-', " ");
        note +=
            &format!(" Line: {component} of {}, which has grown most.", line.bearing.as_deref().unwrap_or_default());
    }
    let frames = frames(&curves);
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let svg = picture((WIDTH, bottom + 36.0), Dashes::None, |canvas| {
        let left = frames.first().map_or(0.0, |frame| frame.left);
        canvas.legend(left, 0.0, &[(Key::Line(VALUE), "measured"), (Key::Line(ONSET), "onset of growth")])?;
        for (i, (frame, curve)) in frames.iter().zip(&curves).enumerate() {
            frame.axes(canvas, i + 1 == curves.len())?;
            onset(canvas, frame, curve.trend)?;
            frame.curve(canvas, &decimated(&curve.points, budget.line()), VALUE)?;
            frame.note_if_empty(canvas, &[&curve.points])?;
        }
        Ok(())
    })?;
    Ok(Picture { title: format!("Trend of {name}"), note, svg })
}

fn is_of(line: &LineLevel, trend: &SnapshotTrend) -> bool {
    Some(&line.bearing) == trend.bearing.as_ref() && Some(line.component) == trend.component
}

fn onset(canvas: &mut Canvas, frame: &Frame, trend: Option<&SnapshotTrend>) -> Result<()> {
    let Some(number) = trend.and_then(|trend| trend.onset) else { return Ok(()) };
    let x = frame.at(&(number as f64, 0.0)).0;
    canvas.line(&[(x, frame.bottom), (x, frame.top)], ONSET)
}

fn frames(curves: &[Curve<'_>]) -> Vec<Frame> {
    let numbers = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.0));
    let x = Axis::exact(extent(numbers), 9, "Snapshot");
    let axis = |curve: &Curve<'_>| {
        let highest = extent(curve.points.iter().map(|point| point.1)).map(|range| range.1);
        Axis::from_zero(highest, 3, curve.title)
    };
    let axes: Vec<Axis> = curves.iter().map(axis).collect();
    let left = gutter(&axes.iter().collect::<Vec<_>>());
    let frame = |(i, y): (usize, Axis)| {
        let top = 30.0 + i as f64 * (HEIGHT + 16.0);
        Frame { start: 0.0, left, top, right: WIDTH - 18.0, bottom: top + HEIGHT, x: x.clone(), y }
    };
    axes.into_iter().enumerate().map(frame).collect()
}
