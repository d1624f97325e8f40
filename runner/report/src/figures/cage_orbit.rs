//! Orbit of a cage's centre in its clearance.

use super::Picture;
use super::canvas::{BELOW, FAINT, Key, SERIES, Stroke, equal_scales, picture};
use super::line::{Point, Thinning};

/// Side of the frame.
const SIDE: f64 = 300.0;
/// Half of the frame's width over the clearance.
const AROUND: f64 = 1.15;
/// Points of the circle.
const CIRCLE: u16 = 90;

/// Draws the path of the cage's centre (mm) within the circle of its clearance (mm) to what guides it.
pub(crate) fn cage_orbit(path: &[Point], clearance: f64, guided_by: &str) -> Picture {
    let reach = path.iter().map(|(x, y)| x.hypot(*y)).fold(clearance.max(1e-6), f64::max) * AROUND;
    let (orbit, limit) = (Stroke(SERIES[0], 1.0), Stroke(FAINT, 1.0));
    let circle: Vec<Point> = (0..=CIRCLE)
        .map(|i| (std::f64::consts::TAU * f64::from(i) / f64::from(CIRCLE)).sin_cos())
        .map(|(sin, cos)| (clearance * cos, clearance * sin))
        .collect();
    let frame = equal_scales(((-reach, reach), (-reach, reach)), (24.0, SIDE, 1.0), ["X, mm", "Y, mm"]);
    let drawing = picture((frame.right + 14.0, frame.bottom + BELOW), |canvas| {
        canvas.legend(4.0, 0.0, &[(Key::Line(orbit), "centre of the cage"), (Key::Line(limit), "clearance")]);
        frame.axes(canvas, true);
        frame.series(canvas, ("clearance", &circle), Thinning::None, limit);
        frame.series(canvas, ("cage", path), Thinning::None, orbit);
    });
    Picture { title: format!("Orbit of the cage, guided by the {guided_by}"), drawing, ..Picture::default() }
}
