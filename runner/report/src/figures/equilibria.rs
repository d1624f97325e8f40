//! Figures of named curves: of equilibria over the first key of a range, of a motion over time.

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
    let y = match range(curves) {
        Some((low, high)) if low > 0.0 && high > DECADES * low => Axis::decades(low, high, vertical),
        range => Axis::padded(range, 6, vertical),
    };
    curves_over(title, horizontal, y, curves)
}

/// Draws curves over time, s; `vertical` is the title of their axis.
pub(crate) fn over_time(title: &str, vertical: &str, curves: &[NamedCurve]) -> Picture {
    curves_over(title, "time, s", Axis::padded(range(curves), 6, vertical), curves)
}

/// Returns the lowest and the highest value of all curves.
fn range(curves: &[NamedCurve]) -> Option<(f64, f64)> {
    extent(curves.iter().flat_map(|(_, points)| points).map(|point: &Point| point.1))
}

fn curves_over(title: &str, horizontal: &str, y: Axis, curves: &[NamedCurve]) -> Picture {
    let along = curves.iter().flat_map(|(_, points)| points).map(|point: &Point| point.0);
    let x = Axis::exact(extent(along), 8, horizontal);
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
