//! Deflected line of a flexible rotor: the mean position of the shaft over the stations in the twin, and as measured at the probe planes.

use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, Canvas, Dashes, FAINT, Frame, INK, Key, MEASURED, SMALL, Stroke, TWIN, gutter, picture, text_width,
};
use super::line::Point;
use super::{Context, Figure, Picture};
use crate::number::shortened;
use anyhow::Result;
use ballrace_twin::replay::outcome::DeflectedLine;

const WIDTH: f64 = 560.0;
const TOP: f64 = 38.0;
/// Height of a frame, and the space between the two.
const HEIGHT: f64 = 118.0;
const SPACE: f64 = 12.0;

/// Deflected line in the report of a replay.
pub(super) struct DeflectedLines;

impl Figure for DeflectedLines {
    fn heading(&self) -> &'static str {
        "Deflected line"
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        context.data.deflected_line.iter().map(deflected_line).collect()
    }
}

/// Draws the line along X and along Y, at one scale.
fn deflected_line(line: &DeflectedLine) -> Result<Picture> {
    let points = || line.twin.iter().chain(&line.measured);
    let x = Axis::padded(extent(points().map(|p| p[0])), 7, "Station Z, mm");
    let ranges = [1, 2].map(|i| extent(points().map(|p| p[i])).unwrap_or((0.0, 1.0)));
    let half = ranges.iter().map(|(low, high)| 0.56 * (high - low)).fold(1e-3, f64::max);
    let [across, up] = [("X, um", ranges[0]), ("Y, um", ranges[1])].map(|(title, (low, high))| {
        let middle = 0.5 * (low + high);
        Axis::exact(Some((middle - half, middle + half)), 5, title)
    });
    let left = gutter(&[&across, &up]);
    let frame = |i: f64, y: Axis| {
        let top = TOP + i * (HEIGHT + SPACE);
        Frame { start: 0.0, left, top, right: WIDTH - 16.0, bottom: top + HEIGHT, x: x.clone(), y }
    };
    let frames = [frame(0.0, across), frame(1.0, up)];
    let svg = picture((WIDTH, frames[1].bottom + 36.0), Dashes::Twin, |canvas| {
        let keys = [(Key::Dot(MEASURED), "measured mean"), (Key::Line(Stroke(TWIN, 1.8)), "twin, mean")];
        canvas.legend(left, 0.0, &keys)?;
        bearing_names(canvas, &frames[0], line)?;
        for (i, frame) in frames.iter().enumerate() {
            frame.axes(canvas, i == 1)?;
            for (_, station) in line.bearings.iter().filter(|bearing| frame.x.holds(bearing.1)) {
                let at = frame.at(&(*station, 0.0)).0;
                canvas.line(&[(at, frame.top), (at, frame.bottom)], Stroke(FAINT, 1.4))?;
            }
            let curve: Vec<Point> = line.twin.iter().map(|p| (p[0], p[i + 1])).collect();
            frame.curve(canvas, &curve, Stroke(TWIN, 1.8))?;
            for p in line.measured.iter().filter(|p| p[0].is_finite() && p[i + 1].is_finite()) {
                let (x, y) = frame.at(&(p[0], p[i + 1]));
                canvas.dot(x, y, 4.0, MEASURED)?;
            }
        }
        Ok(())
    })?;
    Ok(Picture {
        title: "Mean deflected line of the shaft".to_owned(),
        note: "Mean over the recording against the scene's line through the bearing centres. Equal scales along X and Y. Vertical lines: \
               bearings. The orbits show the motion about these means."
            .to_owned(),
        svg,
    })
}

/// Writes the names of the bearings above their lines; a name that would cover the one before is omitted.
fn bearing_names(canvas: &mut Canvas, frame: &Frame, line: &DeflectedLine) -> Result<()> {
    let mut bearings: Vec<&(String, f64)> = line.bearings.iter().filter(|b| frame.x.holds(b.1)).collect();
    bearings.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut free = 0.0;
    for (name, station) in bearings {
        let name = shortened(name, 16);
        let half = 0.5 * text_width(&name, SMALL) + 2.0;
        let x = frame.at(&(*station, 0.0)).0.clamp(half, WIDTH - half);
        if x - half >= free {
            canvas.text(&name, (x, frame.top - 8.0), Anchor::Middle, INK)?;
            free = x + half + 4.0;
        }
    }
    Ok(())
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn one_dot_for_each_plane_and_direction() {
        let line = DeflectedLine {
            twin: (0..20).map(f64::from).map(|z| [z, 0.1 * z, -0.01 * z * z]).collect(),
            measured: vec![[5.0, 0.5, -0.2], [15.0, f64::NAN, -2.2]],
            bearings: vec![("DE".to_owned(), 2.0), ("NDE".to_owned(), 18.0)],
        };
        let svg = deflected_line(&line).unwrap().svg;
        // One more in the legend.
        assert_eq!(svg.matches("<circle").count(), 3 + 1);
        assert!(svg.contains("class=\"dash\"") && svg.contains("NDE"));
        assert!(!deflected_line(&DeflectedLine::default()).unwrap().svg.contains("NaN"));
    }
}
