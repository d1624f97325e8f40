//! A bearing in equilibrium: load of each element around the ring, contact angles and pressures beside it.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{Anchor, Dashes, Frame, INK, Key, MEASURED, Stroke, TWIN, gutter, picture};
use super::line::Point;
use super::ring::{MIDDLE, around, rings};
use anyhow::Result;
use ballrace_twin::equilibrium::Element;

const WIDTH: f64 = 620.0;
const INNER: Stroke = Stroke(MEASURED, 3.0);
const OUTER: Stroke = Stroke(TWIN, 1.5);

/// The picture of one bearing's elements.
pub(crate) fn balance(name: &str, elements: &[&Element]) -> Result<Picture> {
    let loads = elements.iter().flat_map(|e| [e.inner_load, e.outer_load]);
    let radial = Axis::from_zero(extent(loads).map(|range| range.1), 5, "");
    let angles = |of: fn(&Element) -> Option<f64>| -> Vec<Point> {
        let mut points: Vec<Point> =
            elements.iter().map(|e| (e.azimuth.to_degrees(), of(e).map_or(f64::NAN, f64::to_degrees))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let (inner, outer) = (angles(|e| e.inner_angle), angles(|e| e.outer_angle));
    let y = Axis::padded(extent(inner.iter().chain(&outer).map(|p| p.1)), 6, "Contact angle, deg");
    let mut x = Axis::exact(Some((0.0, 360.0)), 4, "Azimuth, deg");
    x.ticks = [0.0, 90.0, 180.0, 270.0, 360.0].map(|degrees: f64| (degrees, format!("{degrees:.0}"))).to_vec();
    let frame =
        Frame { start: 312.0, left: 312.0 + gutter(&[&y]), top: 48.0, right: WIDTH - 18.0, bottom: 292.0, x, y };
    let svg = picture((WIDTH, 330.0), Dashes::Twin, |canvas| {
        canvas.legend(8.0, 0.0, &[(Key::Line(INNER), "inner contact"), (Key::Line(OUTER), "outer contact")])?;
        rings(canvas, &radial)?;
        for e in elements {
            canvas.line(&[MIDDLE, around(e.azimuth, radial.place(e.inner_load))], INNER)?;
            let (px, py) = around(e.azimuth, radial.place(e.outer_load));
            canvas.ring(px, py, TWIN)?;
        }
        let between = least_loaded(elements);
        for (value, label) in radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
            canvas.text(&format!("{label} N"), around(between, radial.place(*value)), Anchor::Middle, INK)?;
        }
        frame.axes(canvas, true)?;
        for (points, colour) in [(&inner, MEASURED), (&outer, TWIN)] {
            frame.curve(canvas, points, Stroke(colour, 1.2))?;
            for point in points.iter().filter(|p| p.1.is_finite()) {
                let (px, py) = frame.at(point);
                canvas.ring(px, py, colour)?;
            }
        }
        frame.note_if_empty(canvas, &[&inner, &outer])
    })?;
    Ok(Picture {
        title: format!("Bearing {name}: load on each element and contact angles"),
        note: "Left: spokes are the inner contact, rings the outer one. Azimuth from +X towards +Y.".to_owned(),
        svg,
    })
}

/// Between the element that carries least and the next one, for the labels of the circles.
fn least_loaded(elements: &[&Element]) -> f64 {
    let least = elements.iter().min_by(|a, b| a.outer_load.total_cmp(&b.outer_load));
    least.map_or(0.4, |e| e.azimuth + std::f64::consts::PI / elements.len() as f64)
}
