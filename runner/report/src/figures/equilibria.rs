//! Figures of equilibria over a range: one figure of the bearings each, over the first key.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{BELOW, Frame, Key, SERIES, Stroke, WIDE, WIDE_RIGHT, gutter, legend_height, picture};
use super::line::{Point, Thinning};

/// Ratio of the largest to the least value from which an axis is logarithmic.
const DECADES: f64 = 100.0;
/// Room for the half of the last number below the frame.
const LAST_NUMBER: f64 = 10.0;

/// A named curve.
pub(crate) type NamedCurve = (String, Vec<(f64, f64)>);

/// Draws a figure of the bearings; `title` names it, `horizontal` and `vertical` are the titles of the axes.
pub(crate) fn over(title: &str, [horizontal, vertical]: [&str; 2], curves: &[NamedCurve]) -> Picture {
    let points = || curves.iter().flat_map(|(_, points): &(String, Vec<Point>)| points);
    let x = Axis::exact(extent(points().map(|point| point.0)), 8, horizontal);
    let range = extent(points().map(|point| point.1));
    let y = match range {
        Some((low, high)) if low > 0.0 && high > DECADES * low => Axis::decades(low, high, vertical),
        _ => Axis::padded(range, 6, vertical),
    };
    let left = gutter(&[&y]);
    let stroke = |i: usize| Stroke(SERIES[i % SERIES.len()], 1.5);
    let legend: Vec<(Key, &str)> =
        curves.iter().enumerate().map(|(i, (name, _))| (Key::Line(stroke(i)), name.as_str())).collect();
    let top = legend_height(left, &legend) + 10.0;
    let frame = Frame { start: 0.0, left, top, right: WIDE_RIGHT - LAST_NUMBER, bottom: top + 180.0, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        canvas.legend(left, 0.0, &legend);
        frame.axes(canvas, true);
        for (i, (name, points)) in curves.iter().enumerate() {
            frame.series(canvas, (name, points), Thinning::None, stroke(i));
        }
    });
    Picture { title: title.to_owned(), drawing, ..Picture::default() }
}
