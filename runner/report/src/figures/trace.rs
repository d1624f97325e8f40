//! Time traces: the twin over the machine, the difference below.

use super::axis::{Axis, extent};
use super::canvas::{Canvas, Dashes, Frame, Key, MARK, MEASURED, RESIDUAL, Stroke, TWIN, gutter, picture};
use super::line::{Point, decimated, zipped};
use super::{Context, Figure, Picture, PointBudget};
use anyhow::Result;
use ballrace_twin::replay::outcome::{Pictures, Trace};

const WIDTH: f64 = 620.0;

/// Time traces, one per probe.
pub(super) struct Traces;

impl Figure for Traces {
    fn heading(&self) -> &'static str {
        "Time traces"
    }

    fn lines(&self, data: &Pictures) -> usize {
        3 * data.traces.len()
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        context.data.traces.iter().map(|one| trace(one, context.budget)).collect()
    }
}

/// One picture for each probe.
pub(super) fn trace(trace: &Trace, budget: PointBudget) -> Result<Picture> {
    let clock = Clock::of(&trace.time);
    let time: Vec<f64> = trace.time.iter().map(|t| t * clock.scale).collect();
    let curves = Curves::new(trace, &time, budget.line());
    let x = Axis::exact(extent(time.iter().copied()), 10, clock.title);
    let (upper, lower) = frames(&curves, x);
    let svg = picture((WIDTH, lower.bottom + 36.0), Dashes::Twin, |canvas| {
        canvas.legend(upper.left, 0.0, &legend())?;
        upper.axes(canvas, false)?;
        lower.axes(canvas, true)?;
        keyphasor(canvas, [&upper, &lower], trace.keyphasor.iter().map(|t| t * clock.scale))?;
        upper.curve(canvas, &curves.measured, Stroke(MEASURED, 1.6))?;
        upper.curve(canvas, &curves.twin, Stroke(TWIN, 1.3))?;
        lower.curve(canvas, &curves.residual, Stroke(MARK, 0.8))?;
        upper.note_if_empty(canvas, &[&curves.measured, &curves.twin])?;
        lower.note_if_empty(canvas, &[&curves.residual])
    })?;
    Ok(Picture { title: format!("Position at {} over time", trace.name), note: String::new(), svg })
}

fn legend() -> [(Key, &'static str); 4] {
    [
        (Key::Line(Stroke(MEASURED, 1.8)), "measured"),
        (Key::Line(Stroke(TWIN, 1.6)), "twin"),
        (Key::Line(Stroke(MARK, 1.0)), "measured \u{2212} twin"),
        (Key::Triangle(MARK), "keyphasor"),
    ]
}

/// The three lines, with no more points than the page can show.
struct Curves {
    measured: Vec<Point>,
    twin: Vec<Point>,
    residual: Vec<Point>,
}

impl Curves {
    fn new(trace: &Trace, time: &[f64], limit: usize) -> Self {
        let residual: Vec<f64> = trace.measured.iter().zip(&trace.twin).map(|(m, t)| m - t).collect();
        Self {
            measured: decimated(&zipped(time, &trace.measured), limit),
            twin: decimated(&zipped(time, &trace.twin), limit),
            residual: decimated(&zipped(time, &residual), limit),
        }
    }
}

fn frames(curves: &Curves, x: Axis) -> (Frame, Frame) {
    let above = extent(curves.measured.iter().chain(&curves.twin).map(|point| point.1));
    let below = extent(curves.residual.iter().map(|point| point.1));
    let position = Axis::padded(above, 7, "Position, um");
    let difference = Axis::padded(below, 5, "Diff., um");
    let left = gutter(&[&position, &difference]);
    let right = WIDTH - 18.0;
    let upper = Frame { start: 0.0, left, top: 34.0, right, bottom: 190.0, x: x.clone(), y: position };
    let lower = Frame { start: 0.0, left, top: 202.0, right, bottom: 278.0, x, y: difference };
    (upper, lower)
}

/// A triangle above and a fine line through the frames at each passage of the mark.
fn keyphasor(canvas: &mut Canvas, frames: [&Frame; 2], times: impl Iterator<Item = f64>) -> Result<()> {
    for time in times.filter(|time| frames[0].x.holds(*time)).take(64) {
        for frame in frames {
            let x = frame.at(&(time, 0.0)).0;
            canvas.line(&[(x, frame.top), (x, frame.bottom)], Stroke(RESIDUAL, 0.5))?;
        }
        let tip = (frames[0].at(&(time, 0.0)).0, frames[0].top - 1.0);
        canvas.triangle(tip, std::f64::consts::FRAC_PI_2, 8.0, MARK)?;
    }
    Ok(())
}

/// Seconds or milliseconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// Units in a second.
    pub(super) scale: f64,
    /// Title of the axis.
    pub(super) title: &'static str,
}

impl Clock {
    /// Milliseconds where the last time is below two seconds.
    pub(super) fn of(time: &[f64]) -> Self {
        let last = extent(time.iter().copied()).map_or(0.0, |range| range.0.abs().max(range.1.abs()));
        if last < 2.0 { Self { scale: 1000.0, title: "Time, ms" } } else { Self { scale: 1.0, title: "Time, s" } }
    }
}
