//! Vectors of a probe before and after a correction, in the complex plane.

use super::Picture;
use super::canvas::{BELOW, Key, MARK, MEASURED, Marker, Stroke, TWIN, equal_scales, picture};
use super::line::Point;
use ballrace_twin::balance::Predicted;
use std::f64::consts::TAU;

const SIDE: f64 = 260.0;
const BEFORE: Stroke = Stroke(MEASURED, 1.8);
const AFTER: Stroke = Stroke(TWIN, 1.8);
/// Share of the square that the data fill.
const FILLED: f64 = 0.85;

/// Draws the vectors of one probe at one speed, with the circle in which that after the correction lies with 95 %.
pub(crate) fn vectors(of: &Predicted, unit: &str) -> Picture {
    let at = |size: f64, degrees: f64| -> Point {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        (size * cosine, size * sine)
    };
    let (before, after) = (at(of.before, of.before_deg), at(of.after, of.after_deg));
    // The square of a complex normal value is beyond its variance times ln 20 in one of twenty cases.
    let radius = of.deviation * 20.0_f64.ln().sqrt();
    let around = |i: i32| {
        let (sine, cosine) = (TAU * f64::from(i) / 64.0).sin_cos();
        (after.0 + radius * cosine, after.1 + radius * sine)
    };
    let circle: Vec<Point> = (0..=64).map(around).collect();
    let reach = circle.iter().chain([&before]).map(|(x, y)| x.abs().max(y.abs())).fold(f64::MIN_POSITIVE, f64::max);
    let titles = [format!("Real part, {unit}"), format!("Imaginary part, {unit}")];
    let frame =
        equal_scales(((-reach, reach), (-reach, reach)), (28.0, SIDE, FILLED), titles.each_ref().map(String::as_str));
    let drawing = picture((frame.right + 12.0, frame.bottom + BELOW), |canvas| {
        canvas.legend(8.0, 0.0, &[(Key::Line(BEFORE), "before"), (Key::Line(AFTER), "after, expected")]);
        frame.axes(canvas, true);
        frame.uprights(canvas, [0.0], Stroke(MARK, 0.9));
        frame.levels(canvas, [0.0], Stroke(MARK, 0.9));
        frame.curve(canvas, &[(0.0, 0.0), before], BEFORE);
        frame.curve(canvas, &[(0.0, 0.0), after], AFTER);
        frame.curve(canvas, &circle, Stroke(TWIN, 0.9));
        frame.scatter(canvas, ("before", &[before]), Marker::Dot(4.0, MEASURED));
        frame.scatter(canvas, ("after", &[after]), Marker::Dot(4.0, TWIN));
    });
    Picture {
        title: format!("{} at {:.0} rpm", of.probe, of.speed_rpm),
        note: "The circle holds the vector after the correction with 95 %.".to_owned(),
        drawing,
        ..Picture::default()
    }
}
