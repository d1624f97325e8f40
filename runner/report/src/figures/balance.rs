//! A bearing in equilibrium: load of each element around the ring; beside it contact angles, or the pressure along the most loaded roller.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{Key, MEASURED, Stroke, TWIN, WIDE, picture};
use super::line::{Point, Thinning};
use super::ring::{Polar, beside, beside_over};
use ballrace_twin::equilibrium::Element;

const SPOKE: Stroke = Stroke(MEASURED, 3.0);
/// Contact angles of the inner and of the outer contact.
const INNER: Stroke = Stroke(MEASURED, 1.4);
const OUTER: Stroke = Stroke(TWIN, 1.4);

/// Draws the loads of the elements of one bearing, with their contact angles, or the pressure along the roller with the most loaded lamina.
pub(crate) fn balance(name: &str, elements: &[&Element]) -> Picture {
    let top = 28.0;
    let rollers = elements.iter().filter_map(|e| Some((e.number, e.roller.as_ref()?)));
    let pressed = rollers.max_by(|a, b| a.1.largest_lamina_load.total_cmp(&b.1.largest_lamina_load));
    let polar = Polar::new(top, elements.iter().flat_map(|e| [e.inner_load, e.outer_load]));
    let angles = |of: fn(&Element) -> Option<f64>| -> Vec<Point> {
        let mut points: Vec<Point> =
            elements.iter().map(|e| (e.azimuth.to_degrees(), of(e).map_or(f64::NAN, f64::to_degrees))).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let (inner, outer) = (angles(|e| e.inner_angle), angles(|e| e.outer_angle));
    let along: Vec<Point> =
        pressed.iter().flat_map(|(_, roller)| &roller.lamina_pressures).zip(1..).map(in_megapascal).collect();
    let frame = if pressed.is_some() {
        let highest = along.iter().map(|p| p.1).fold(0.0, f64::max);
        let laminae = Axis::exact(Some((0.0, along.len() as f64 + 1.0)), 6, "Lamina, from -Z to +Z");
        beside_over(top, laminae, Axis::from_zero(Some(highest), 6, "Pressure, inner race, MPa"))
    } else {
        let range = extent(inner.iter().chain(&outer).map(|p| p.1));
        beside(top, Axis::padded(range, 6, "Contact angle, deg"))
    };
    let drawing = picture((WIDE, polar.bottom()), |canvas| {
        canvas.legend(8.0, 0.0, &[(Key::Line(SPOKE), "inner contact"), (Key::Ring(TWIN), "outer contact")]);
        polar.rings(canvas);
        for e in elements {
            polar.spoke(canvas, e.azimuth, e.inner_load, SPOKE);
            let (x, y) = polar.at(e.azimuth, e.outer_load);
            canvas.ring(x, y, TWIN);
        }
        polar.labels(canvas, least_loaded(elements));
        frame.axes(canvas, true);
        if pressed.is_some() {
            frame.series(canvas, ("pressure at the inner race", &along), Thinning::None, INNER);
            frame.note_if_empty(canvas, &[&along]);
            return;
        }
        for (name, points, stroke) in [("inner contact", &inner, INNER), ("outer contact", &outer, OUTER)] {
            frame.series(canvas, (name, points), Thinning::None, stroke);
            frame.inside(canvas, |canvas| {
                for (x, y) in points.iter().filter(|p| p.1.is_finite()).map(|point| frame.at(point)) {
                    canvas.ring(x, y, stroke.0);
                }
            });
        }
        frame.note_if_empty(canvas, &[&inner, &outer]);
    });
    Picture {
        title: match pressed {
            Some((number, _)) => format!("Bearing {name}: load on each roller and pressure along roller {number}"),
            None => format!("Bearing {name}: load on each element and contact angles"),
        },
        note: "Left: spokes are the inner contact, rings the outer one. Azimuth from +X towards +Y.".to_owned(),
        drawing,
        ..Picture::default()
    }
}

/// Returns a lamina and its pressure, Pa, as a point in MPa.
fn in_megapascal((pressure, lamina): (&f64, u32)) -> Point {
    (f64::from(lamina), pressure / 1e6)
}

/// Returns the azimuth between the least loaded element and the next one, rad, for the labels of the circles.
fn least_loaded(elements: &[&Element]) -> f64 {
    let least = elements.iter().min_by(|a, b| a.outer_load.total_cmp(&b.outer_load));
    least.map_or(0.4, |e| e.azimuth + std::f64::consts::PI / elements.len() as f64)
}
