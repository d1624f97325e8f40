//! Deflected line of a flexible rotor: the mean position of the shaft over the stations in the twin, and as measured at the probe planes.

use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, BELOW, Canvas, FAINT, INK, Key, MEASURED, Marker, SMALL, Stroke, TWIN, WIDE, picture, stacked, text_width,
};
use super::line::{Point, Thinning};
use super::{Context, Figure, Picture};
use crate::number::shortened;
use ballrace_twin::replay::outcome::DeflectedLine;

const TOP: f64 = 38.0;
/// Height of a frame, and the space between the two.
const HEIGHT: f64 = 118.0;
const SPACE: f64 = 12.0;
const LINE: Stroke = Stroke(TWIN, 1.8);

/// Deflected line in the report of a replay.
pub(super) struct DeflectedLines;

impl Figure for DeflectedLines {
    fn heading(&self) -> &'static str {
        "Deflected line"
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        context.data.deflected_line.iter().map(deflected_line).collect()
    }
}

/// Draws the line along X and along Y, at one scale.
fn deflected_line(line: &DeflectedLine) -> Picture {
    let points = || line.twin.iter().chain(&line.measured);
    let x = Axis::padded(extent(points().map(|p| p[0])), 7, "Station Z, mm");
    let ranges = [1, 2].map(|i| extent(points().map(|p| p[i])).unwrap_or((0.0, 1.0)));
    let half = ranges.iter().map(|(low, high)| 0.56 * (high - low)).fold(1e-3, f64::max);
    let [across, up] = [("X, um", ranges[0]), ("Y, um", ranges[1])].map(|(title, (low, high))| {
        let middle = 0.5 * (low + high);
        Axis::exact(Some((middle - half, middle + half)), 5, title)
    });
    let frames = stacked(&x, vec![across, up], (TOP, HEIGHT, SPACE));
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        let [upper, _] = &frames[..] else { return };
        canvas.legend(upper.left, 0.0, &[(Key::Dot(MEASURED), "measured mean"), (Key::Line(LINE), "twin, mean")]);
        let shown: Vec<(String, f64)> = line.bearings.iter().filter(|b| upper.x.holds(b.1)).cloned().collect();
        bearing_names(canvas, &shown, |station| upper.at(&(station, 0.0)).0, upper.top - 8.0);
        for (i, frame) in frames.iter().enumerate() {
            frame.axes(canvas, i == 1);
            frame.uprights(canvas, line.bearings.iter().map(|bearing| bearing.1), Stroke(FAINT, 1.4));
            let curve: Vec<Point> = line.twin.iter().map(|p| (p[0], p[i + 1])).collect();
            frame.series(canvas, ("twin", &curve), Thinning::None, LINE);
            let measured: Vec<Point> = line.measured.iter().map(|p| (p[0], p[i + 1])).collect();
            frame.scatter(canvas, ("measured", &measured), Marker::Dot(4.0, MEASURED));
        }
    });
    Picture {
        title: "Mean deflected line of the shaft".to_owned(),
        note: "Mean over the recording against the scene's line through the bearing centres. Equal scales along X and Y. Vertical lines: \
               bearings. The orbits show the motion about these means."
            .to_owned(),
        drawing,
        ..Picture::default()
    }
}

/// Writes names of bearings above their lines; a name that would cover the one before is omitted.
pub(super) fn bearing_names(canvas: &mut Canvas, bearings: &[(String, f64)], x_of: impl Fn(f64) -> f64, y: f64) {
    let mut bearings: Vec<&(String, f64)> = bearings.iter().collect();
    bearings.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut free = 0.0;
    for (name, station) in bearings {
        let name = shortened(name, 16);
        let half = 0.5 * text_width(&name, SMALL) + 2.0;
        let x = x_of(*station).clamp(half, WIDE - half);
        if x - half >= free {
            canvas.text(&name, (x, y), Anchor::Middle, INK);
            free = x + half + 4.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_dot_for_each_plane_and_direction() {
        let line = DeflectedLine {
            twin: (0..20).map(f64::from).map(|z| [z, 0.1 * z, -0.01 * z * z]).collect(),
            measured: vec![[5.0, 0.5, -0.2], [15.0, f64::NAN, -2.2]],
            bearings: vec![("DE".to_owned(), 2.0), ("NDE".to_owned(), 18.0)],
        };
        let svg = deflected_line(&line).drawing.svg;
        // One more in the legend.
        assert_eq!(svg.matches("<circle").count(), 3 + 1);
        assert!(svg.contains("stroke-dasharray") && svg.contains("NDE"));
        assert!(!deflected_line(&DeflectedLine::default()).drawing.svg.contains("NaN"));
    }
}
