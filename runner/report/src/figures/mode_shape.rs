//! Mode shapes of a flexible rotor over the stations of the shaft, one strip per mode.

use super::Picture;
use super::axis::{Axis, signed};
use super::canvas::{Anchor, Canvas, FAINT, GRID, INK, Key, MARK, MEASURED, RESIDUAL, Stroke, TWIN, WIDE, picture};
use super::deflected_line::bearing_names;
use super::line::Point;
use crate::number::fixed;
use ballrace_twin::campbell::{ModeShape, ModeShapePoint, Whirl};
use ballrace_twin::replay::outcome::RotorDrawing;

const EDGES: [f64; 2] = [24.0, WIDE - 24.0];
/// Height of a mode's title, and of its strip.
const TITLE: f64 = 17.0;
const STRIP: f64 = 66.0;
/// Space below a strip.
const SPACE: f64 = 8.0;
/// Displacement over the largest one below which a direction is not drawn.
const LEAST_SHOWN: f64 = 0.03;
/// Difference of the shapes along X and Y below which one is drawn for both.
const ALIKE: f64 = 0.02;
/// Height of the thickest section behind the shapes.
const SHAFT: f64 = 26.0;

const X: Stroke = Stroke(MEASURED, 2.0);
const Y: Stroke = Stroke(TWIN, 2.0);
const Z: Stroke = Stroke(RESIDUAL, 1.4);

/// Draws the modes at one speed; none without a mode shape.
pub(crate) fn mode_shapes(shapes: &[ModeShape], rotor: &RotorDrawing) -> Option<Picture> {
    let lowest = shapes.first()?;
    let [from, to] = rotor.ends_mm();
    let axis = Axis::exact(Some((from, to)), 7, "Station Z, mm");
    let x_of = |station: f64| EDGES[0] + axis.place(station) * (EDGES[1] - EDGES[0]);
    let first = 40.0;
    let bottom = first + (TITLE + STRIP + SPACE) * shapes.len() as f64;
    let drawing = picture((WIDE, bottom + 36.0), |canvas| {
        let keys = [(Key::Line(X), "along X"), (Key::Line(Y), "along Y"), (Key::Line(Z), "along Z")];
        canvas.legend(EDGES[0], 0.0, &keys);
        bearing_names(canvas, &rotor.bearings, x_of, 28.0);
        for (i, shape) in shapes.iter().enumerate() {
            let top = first + (TITLE + STRIP + SPACE) * i as f64;
            canvas.text(&title(i, shape), (EDGES[0], top + 0.5 * TITLE), Anchor::Start, INK);
            strip(canvas, shape, rotor, x_of, top + TITLE);
        }
        canvas.line(&[(EDGES[0], bottom), (EDGES[1], bottom)], Stroke(MARK, 0.75));
        for (value, label) in &axis.ticks {
            canvas.line(&[(x_of(*value), bottom), (x_of(*value), bottom + 4.0)], Stroke(MARK, 0.75));
            canvas.text(label, (x_of(*value), bottom + 11.0), Anchor::Middle, INK);
        }
        canvas.text(&axis.title, (0.5 * WIDE, bottom + 27.0), Anchor::Middle, INK);
    });
    Some(Picture {
        title: format!("Mode shapes at {} rpm", fixed(lowest.speed_rpm, 0)),
        note: "Linearised at the static equilibrium, with damping. Each mode has its own scale; in each direction the shape is that at its \
               largest displacement. Vertical lines: bearings. Grey: the shaft."
            .to_owned(),
        drawing,
        ..Picture::default()
    })
}

fn title(i: usize, shape: &ModeShape) -> String {
    let whirl = match shape.mode.whirl {
        Whirl::Forward => ", forward whirl",
        Whirl::Backward => ", backward whirl",
        Whirl::Straight => "",
    };
    let [x, y, _] = shape.largest();
    let alike = if x.max(y) > LEAST_SHOWN && shape.is_alike_in_both_planes(ALIKE) { ", X and Y alike" } else { "" };
    let (hz, damping) = (fixed(shape.mode.frequency_hz, 2), signed(&fixed(100.0 * shape.mode.damping_ratio, 2)));
    format!("N{}: {hz} Hz, damping {damping} %{whirl}{alike}", i + 1)
}

fn strip(canvas: &mut Canvas, shape: &ModeShape, drawing: &RotorDrawing, x_of: impl Fn(f64) -> f64, top: f64) {
    let middle = top + 0.5 * STRIP;
    let thickest = drawing.sections.iter().flat_map(|s| s.outer_mm).fold(f64::MIN_POSITIVE, f64::max);
    for section in &drawing.sections {
        let [from, to] = section.ends_mm.map(&x_of);
        let [a, b] = section.outer_mm.map(|d| 0.5 * SHAFT * d / thickest);
        canvas.polygon(&[(from, middle - a), (to, middle - b), (to, middle + b), (from, middle + a)], GRID);
    }
    canvas.line(&[(EDGES[0], middle), (EDGES[1], middle)], Stroke(FAINT, 0.75));
    for (_, station) in &drawing.bearings {
        let x = x_of(*station);
        canvas.line(&[(x, top), (x, top + STRIP)], Stroke(FAINT, 1.0));
    }
    let curve = |canvas: &mut Canvas, of: fn(&ModeShapePoint) -> f64, stroke: Stroke| {
        let point = |p: &ModeShapePoint| (x_of(p.station_mm), middle - 0.48 * STRIP * of(p));
        canvas.line(&shape.points.iter().map(point).collect::<Vec<Point>>(), stroke);
    };
    let [x, y, z] = shape.largest();
    if z > LEAST_SHOWN {
        curve(canvas, |p| p.z, Z);
    }
    if x > LEAST_SHOWN {
        curve(canvas, |p| p.x, X);
    }
    if y > LEAST_SHOWN && !shape.is_alike_in_both_planes(ALIKE) {
        curve(canvas, |p| p.y, Y);
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_twin::campbell::Mode;

    fn shape(y: f64) -> ModeShape {
        let point = |i: u32| {
            let sine = (std::f64::consts::PI * f64::from(i) / 20.0).sin();
            ModeShapePoint { station_mm: 10.0 * f64::from(i), x: sine, y: y * sine, z: 0.0 }
        };
        let mode = Mode { frequency_hz: 105.5, damping_ratio: 0.045, whirl: Whirl::Forward };
        ModeShape { mode, speed_rpm: 3000.0, points: (0..=20).map(point).collect() }
    }

    #[test]
    fn one_line_where_both_planes_are_alike() {
        let drawing = RotorDrawing { bearings: vec![("DE".to_owned(), 0.0)], ..RotorDrawing::default() };
        let lines = |shape: ModeShape| {
            let svg = mode_shapes(&[shape], &drawing).unwrap().drawing.svg;
            (svg.matches("<polyline").count(), svg.contains("X and Y alike"))
        };
        assert_eq!(lines(shape(1.0)), (1, true));
        assert_eq!(lines(shape(0.5)), (2, false));
        assert_eq!(lines(shape(0.0)), (1, false));
        assert!(mode_shapes(&[], &drawing).is_none());
    }
}
