//! Time traces: measured motion and twin, with the residual below.

use super::axis::{Axis, extent};
use super::canvas::{
    BELOW, Canvas, FAINT, Frame, Key, MARK, MEASURED_LINE, RESIDUAL_LINE, Stroke, TWIN_LINE, WIDE, picture, stacked,
};
use super::line::{Point, zipped};
use super::{Context, Figure, Picture, PointBudget, Source};
use ballrace_twin::replay::outcome::{Pictures, Trace};

/// Largest number of keyphasor marks drawn.
const MAX_MARKS: usize = 64;

/// Time traces, one per probe.
pub(super) struct Traces;

impl Figure for Traces {
    fn heading(&self) -> &'static str {
        "Time traces"
    }

    fn lines(&self, data: &Pictures) -> usize {
        3 * data.traces.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let one =
            |(i, named): (usize, &Trace)| Picture { source: Some(Source::Trace(i)), ..trace(named, context.budget) };
        context.data.traces.iter().enumerate().map(one).collect()
    }
}

/// Draws the time trace of one probe.
pub(super) fn trace(trace: &Trace, budget: PointBudget) -> Picture {
    let clock = Clock::of(&trace.time);
    let time: Vec<f64> = trace.time.iter().map(|t| t * clock.scale).collect();
    let residual: Vec<f64> = trace.measured.iter().zip(&trace.twin).map(|(m, t)| m - t).collect();
    let [measured, twin, residual] = [&trace.measured, &trace.twin, &residual].map(|values| zipped(&time, values));
    let x = Axis::exact(extent(time.iter().copied()), 8, clock.title);
    let [upper, lower] = two_frames(x, [&[&measured, &twin], &[&residual]], "Residual, um");
    let drawing = picture((WIDE, lower.bottom + BELOW), |canvas| {
        canvas.legend(upper.left, 0.0, &legend());
        upper.axes(canvas, false);
        lower.axes(canvas, true);
        keyphasor(canvas, [&upper, &lower], trace.keyphasor.iter().map(|t| t * clock.scale));
        upper.series(canvas, ("measured", &measured), budget.time(), MEASURED_LINE);
        upper.series(canvas, ("twin", &twin), budget.time(), TWIN_LINE);
        lower.series(canvas, ("residual", &residual), budget.time(), RESIDUAL_LINE);
        upper.note_if_empty(canvas, &[&measured, &twin]);
        lower.note_if_empty(canvas, &[&residual]);
    });
    Picture { title: format!("Position at {} over time", trace.name), drawing, ..Picture::default() }
}

fn legend() -> [(Key, &'static str); 4] {
    [
        (Key::Line(MEASURED_LINE), "measured"),
        (Key::Line(TWIN_LINE), "twin"),
        (Key::Line(RESIDUAL_LINE), "residual"),
        (Key::Triangle(MARK), "keyphasor"),
    ]
}

/// Returns a frame for positions and, below it, one for differences with this title of their axis.
pub(super) fn two_frames(x: Axis, curves: [&[&Vec<Point>]; 2], differences: &'static str) -> [Frame; 2] {
    let [above, below] = curves.map(|curves| extent(curves.iter().flat_map(|curve| curve.iter().map(|point| point.1))));
    let axes = vec![Axis::padded(above, 6, "Position, um"), Axis::padded(below, 4, differences)];
    let mut frames = stacked(&x, axes, (36.0, 140.0, 12.0)).into_iter();
    let (Some(upper), Some(mut lower)) = (frames.next(), frames.next()) else {
        unreachable!("two axes give two frames")
    };
    lower.bottom = lower.top + 84.0;
    [upper, lower]
}

/// Draws a triangle above the frames and a fine line through them at each keyphasor pulse.
pub(super) fn keyphasor(canvas: &mut Canvas, frames: [&Frame; 2], marks: impl Iterator<Item = f64>) {
    let marks: Vec<f64> = marks.filter(|mark| frames[0].x.holds(*mark)).take(MAX_MARKS).collect();
    for frame in frames {
        frame.uprights(canvas, marks.iter().copied(), Stroke(FAINT, 0.6));
    }
    frames[0].along(canvas, |canvas| {
        for mark in &marks {
            let tip = (frames[0].at(&(*mark, 0.0)).0, frames[0].top - 1.0);
            canvas.triangle(tip, std::f64::consts::FRAC_PI_2, 8.0, MARK);
        }
    });
}

/// Unit of the time axis: seconds or milliseconds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clock {
    /// Number of units per second.
    pub(super) scale: f64,
    /// Title of the axis.
    pub(super) title: &'static str,
}

impl Clock {
    /// Returns milliseconds where all times are below two seconds, else seconds.
    pub(super) fn of(time: &[f64]) -> Self {
        let last = extent(time.iter().copied()).map_or(0.0, |range| range.0.abs().max(range.1.abs()));
        if last < 2.0 { Self { scale: 1000.0, title: "Time, ms" } } else { Self { scale: 1.0, title: "Time, s" } }
    }
}
