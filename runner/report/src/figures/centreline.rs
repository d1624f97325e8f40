//! Shaft centrelines: the mean position in a plane from the start of the recording to its end, within the clearance.

use super::axis::{extent, signed};
use super::canvas::{BELOW, Frame, Key, MARK, MEASURED, MEASURED_LINE, Stroke, TWIN, equal_scales, picture};
use super::line::{Point, Thinning};
use super::{Context, Figure, Picture, Shape};
use crate::number::{at_station, fixed};
use ballrace_twin::replay::outcome::{Block, Clearance, Orbit, Outcome};

const SIDE: f64 = 290.0;
const CLEARANCE: Stroke = Stroke(MARK, 1.2);

/// Shaft centrelines, one per plane.
pub(super) struct Centrelines;

impl Figure for Centrelines {
    fn heading(&self) -> &'static str {
        "Shaft centrelines"
    }

    fn shape(&self) -> Shape {
        Shape::Square
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let data = context.data;
        let planes = data.orbits.iter().zip(&data.clearances).filter(|_| data.blocks.len() > 1);
        planes
            .map(|(orbit, clearance)| centreline(orbit, &positions(context.outcome, orbit), clearance.as_ref()))
            .collect()
    }
}

/// Returns the mean positions in a plane with their speeds, um and rpm.
fn positions(outcome: &Outcome, orbit: &Orbit) -> Vec<(Point, f64)> {
    let index = |name: &str| outcome.probes.iter().position(|probe| probe.name == name);
    let [(a, from_a), (b, from_b), ..] = &orbit.probes[..] else { return vec![] };
    let (Some(a), Some(b)) = (index(a), index(b)) else { return vec![] };
    let determinant = (from_b - from_a).sin();
    let mean = |block: &Block| {
        let (a, b) = (block.probes.get(a)?.mean_um, block.probes.get(b)?.mean_um);
        let x = (from_b.sin() * a - from_a.sin() * b) / determinant;
        let y = (from_a.cos() * b - from_b.cos() * a) / determinant;
        Some(((x, y), block.speed_rpm))
    };
    outcome.pictures.blocks.iter().filter_map(mean).collect()
}

/// Draws the shaft centreline in one plane; each point has its speed.
pub(super) fn centreline(orbit: &Orbit, path: &[(Point, f64)], clearance: Option<&Clearance>) -> Picture {
    let points: Vec<Point> = path.iter().map(|(point, _)| *point).collect();
    let radius = clearance.map(|c| c.radius_um).filter(|radius| *radius > 0.0 && *radius < 1e6);
    let frame = square(&points, radius);
    let rpm = |at: Option<&(Point, f64)>| fixed(at.map_or(f64::NAN, |(_, rpm)| *rpm), 0);
    let (start, end) = (format!("start, {} rpm", rpm(path.first())), format!("end, {} rpm", rpm(path.last())));
    let rim = clearance.map_or_else(String::new, |c| format!("clearance of {}", c.bearing));
    let mut legend =
        vec![(Key::Line(MEASURED_LINE), "mean position"), (Key::Ring(TWIN), &start), (Key::Dot(MEASURED), &end)];
    if radius.is_some() {
        legend.push((Key::Line(CLEARANCE), &rim));
    }
    let drawing = picture((frame.right + 14.0, frame.bottom + BELOW), |canvas| {
        canvas.legend(4.0, 0.0, &legend);
        frame.axes(canvas, true);
        if let Some(radius) = radius {
            let circle = (0..=180).map(|i| f64::from(2 * i).to_radians().sin_cos());
            let circle: Vec<Point> = circle.map(|(s, c)| (radius * c, radius * s)).collect();
            frame.series(canvas, (&rim, &circle), Thinning::Path(circle.len()), CLEARANCE);
        }
        frame.series(canvas, ("mean position", &points), Thinning::Path(points.len()), MEASURED_LINE);
        frame.inside(canvas, |canvas| {
            let ends = [points.first(), points.last()].map(|end| end.filter(|(x, y)| x.is_finite() && y.is_finite()));
            if let [Some(first), Some(last)] = ends {
                let (x, y) = frame.at(last);
                canvas.dot(x, y, 3.6, MEASURED);
                let (x, y) = frame.at(first);
                canvas.ring(x, y, TWIN);
            }
        });
        frame.note_if_empty(canvas, &[&points]);
    });
    let title = format!("Shaft centreline at {}{}", orbit.name, signed(&at_station(orbit.station_mm, 0)));
    Picture { title, note: words(clearance), drawing, ..Picture::default() }
}

fn words(clearance: Option<&Clearance>) -> String {
    let circle = clearance.map_or_else(
        || "The scene has no clearance to compare with.".to_owned(),
        |c| {
            format!(
                "Circle: the room that half the diametral clearance of {}, {} um, leaves about the bearing centre; the \
                 bearing is {} mm away along the shaft.",
                c.bearing,
                fixed(c.radius_um, 2),
                fixed(c.distance_mm, 0)
            )
        },
    );
    format!(
        "Shows where the shaft runs on average, not how it vibrates: one point for the mean of each block of four turns, \
         joined from start (ring) to end (dot). A shaft that sinks with speed or load, or leaves its side of the clearance, \
         has another load or a worn bearing. Equal scales. {circle}"
    )
}

/// Returns a square that contains the centreline and the clearance.
fn square(points: &[Point], radius: Option<f64>) -> Frame {
    let rim = radius.map_or_else(Vec::new, |radius| vec![-radius, radius]);
    let range = |of: fn(&Point) -> f64| extent(points.iter().map(of).chain(rim.iter().copied())).unwrap_or((-1.0, 1.0));
    let (x, y) = (range(|point| point.0), range(|point| point.1));
    let widened = |(low, high): (f64, f64)| if high - low > 1e-3 { (low, high) } else { (low - 5e-4, high + 5e-4) };
    equal_scales((widened(x), widened(y)), (56.0, SIDE, 0.91), ["X, um", "Y, um"])
}
