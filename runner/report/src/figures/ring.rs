//! Loads of the rolling elements: by azimuth, and of element 1 along its path.

use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, Canvas, Frame, GRID, INK, Key, MARK, MEASURED, MEASURED_LINE, RESIDUAL_LINE, Stroke, TWIN_LINE, WIDE,
    WIDE_RIGHT, gutter, legend_height, picture,
};
use super::line::{Point, pieces};
use super::{Context, Figure, Picture, PointBudget};
use crate::words;
use ballrace_twin::replay::outcome::{ElementLoads, Pictures};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Radius of the polar picture.
const RADIUS: f64 = 88.0;
/// Middle of the polar picture: distance from the left and from the upper edge, pixels.
const MIDDLE: Point = (126.0, RADIUS + 20.0);
/// Left end of the frame beside it, pixels.
const BESIDE: f64 = 252.0;

/// A polar picture of a ring: its middle and its radial axis.
pub(super) struct Polar {
    middle: Point,
    radial: Axis,
}

/// Loads around the ring, one picture per bearing with elements.
pub(super) struct ElementLoadPlots;

impl Figure for ElementLoadPlots {
    fn heading(&self) -> &'static str {
        "Load on the rolling elements"
    }

    fn lines(&self, data: &Pictures) -> usize {
        4 * data.element_loads.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        context.data.element_loads.iter().map(|one| loads(one, context.budget)).collect()
    }
}

/// Draws the loads on the elements of one bearing.
pub(super) fn loads(loads: &ElementLoads, budget: PointBudget) -> Picture {
    let source = words::force_source(loads.source);
    let mean = format!("mean, {source}");
    let legend = [
        (Key::Line(MEASURED_LINE), mean.as_str()),
        (Key::Line(TWIN_LINE), "mean, twin"),
        (Key::Line(RESIDUAL_LINE), "largest"),
    ];
    let top = legend_height(8.0, &legend) + 12.0;
    let largest = loads.largest.iter().chain(&loads.mean).chain(&loads.twin_mean).copied();
    let polar = Polar::new(top, largest);
    let highest = extent(loads.first_element.iter().map(|point| point.1)).map(|range| range.1);
    let frame = beside(top, Axis::from_zero(highest, 6, "Load on element 1, N"));
    let drawing = picture((WIDE, polar.bottom()), |canvas| {
        canvas.legend(8.0, 0.0, &legend);
        polar.rings(canvas);
        let curves = [(&loads.largest, RESIDUAL_LINE), (&loads.mean, MEASURED_LINE), (&loads.twin_mean, TWIN_LINE)];
        for (values, stroke) in curves {
            polar.curve(canvas, &loads.azimuth, values, stroke);
        }
        polar.labels(canvas, unloaded(loads));
        frame.axes(canvas, true);
        let passes = ("element 1", &passes(&loads.first_element)[..]);
        frame.series(canvas, passes, budget.path(), Stroke(MEASURED, 0.9));
        frame.note_if_empty(canvas, &[&loads.first_element]);
    });
    Picture {
        title: format!("Load on the elements of bearing {}", loads.name),
        note: format!(
            "Left: load of the element that passes at each azimuth. Right: element 1 {source}, every turn of the cage drawn over the \
             ones before. Azimuth from +X towards +Y."
        ),
        drawing,
        ..Picture::default()
    }
}

/// Draws the present load on every element of a bearing; `loads` contains azimuth (rad) and load (N) of each element.
pub(crate) fn present_loads(name: &str, loads: &[(f64, f64)]) -> Picture {
    let polar = Polar::new(24.0, loads.iter().map(|load| load.1));
    let drawing = picture((2.0 * MIDDLE.0 + 30.0, polar.bottom()), |canvas| {
        canvas.legend(8.0, 0.0, &[(Key::Line(Stroke(MEASURED, 3.0)), "load on each element now")]);
        polar.rings(canvas);
        for (azimuth, load) in loads.iter().filter(|(azimuth, load)| azimuth.is_finite() && *load > 0.0) {
            polar.spoke(canvas, *azimuth, *load, Stroke(MEASURED, 3.0));
        }
        polar.labels(canvas, FRAC_PI_2 / 2.0);
    });
    Picture {
        title: format!("Load on the elements of bearing {name}"),
        note: "At the estimated displacement. Azimuth from +X towards +Y.".to_owned(),
        drawing,
        ..Picture::default()
    }
}

impl Polar {
    /// Creates the picture below `top`, for loads (N) from 0 to the largest.
    pub(super) fn new(top: f64, loads: impl Iterator<Item = f64>) -> Self {
        let radial = Axis::from_zero(extent(loads).map(|range| range.1), 4, "");
        Self { middle: (MIDDLE.0, top + MIDDLE.1), radial }
    }

    /// Returns the lower edge of a picture with this one.
    pub(super) fn bottom(&self) -> f64 {
        self.middle.1 + RADIUS + 26.0
    }

    /// Returns the point at an azimuth and a load.
    pub(super) fn at(&self, azimuth: f64, load: f64) -> Point {
        self.around(azimuth, self.radial.place(load))
    }

    fn around(&self, azimuth: f64, share: f64) -> Point {
        (self.middle.0 + RADIUS * share * azimuth.cos(), self.middle.1 - RADIUS * share * azimuth.sin())
    }

    /// Draws a line from the middle to a load.
    pub(super) fn spoke(&self, canvas: &mut Canvas, azimuth: f64, load: f64, stroke: Stroke) {
        canvas.line(&[self.middle, self.at(azimuth, load)], stroke);
    }

    /// Draws circles of equal load and the four directions.
    pub(super) fn rings(&self, canvas: &mut Canvas) {
        for (name, angle) in [("+X", 0.0), ("90\u{b0} (+Y)", 90.0), ("180\u{b0}", 180.0), ("270\u{b0}", 270.0)] {
            let radians: f64 = f64::to_radians(angle);
            canvas.line(&[self.middle, self.around(radians, 1.0)], Stroke(GRID, 0.75));
            let (sine, cosine) = radians.sin_cos();
            let (x, y) = self.around(radians, 1.0);
            let anchor = match cosine {
                cosine if cosine > 0.5 => Anchor::Start,
                cosine if cosine < -0.5 => Anchor::End,
                _ => Anchor::Middle,
            };
            canvas.text(name, (x + 4.0 * cosine, y - 9.0 * sine), anchor, INK);
        }
        canvas.circle(self.middle.0, self.middle.1, RADIUS, Stroke(MARK, 0.75));
        for (value, _) in self.radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
            canvas.circle(self.middle.0, self.middle.1, self.radial.place(*value) * RADIUS, Stroke(GRID, 1.0));
        }
    }

    /// Draws the values of the circles along an azimuth, over the curves.
    pub(super) fn labels(&self, canvas: &mut Canvas, azimuth: f64) {
        for (value, label) in self.radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
            canvas.text(&format!("{label} N"), self.at(azimuth, *value), Anchor::Middle, INK);
        }
    }

    /// Draws a closed curve, which is interrupted at missing values.
    fn curve(&self, canvas: &mut Canvas, azimuth: &[f64], values: &[f64], stroke: Stroke) {
        let ring: Vec<Point> = azimuth.iter().copied().zip(values.iter().copied()).collect();
        let closed: Vec<Point> = ring.iter().chain(ring.first()).copied().collect();
        for piece in pieces(&closed) {
            let pixels: Vec<Point> = piece.iter().map(|(azimuth, load)| self.at(*azimuth, *load)).collect();
            canvas.line(&pixels, stroke);
        }
    }
}

/// Returns the azimuth of the diagonal with the lowest load, rad, for the labels of the circles.
fn unloaded(loads: &ElementLoads) -> f64 {
    let load = |diagonal: f64| -> f64 {
        let near = |azimuth: f64| ((azimuth - diagonal + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0).abs() < 0.4;
        let values = loads.azimuth.iter().zip(&loads.largest).filter(|(azimuth, _)| near(**azimuth));
        values.map(|(_, load)| *load).filter(|load| load.is_finite()).fold(0.0, f64::max)
    };
    let diagonals = [0.125, 0.375, 0.625, 0.875].map(|share| share * TAU);
    diagonals.into_iter().min_by(|a, b| load(*a).total_cmp(&load(*b))).unwrap_or(FRAC_PI_2)
}

/// Returns the frame over the azimuth, in degrees, to the right of a polar picture below `top`.
pub(super) fn beside(top: f64, y: Axis) -> Frame {
    let mut x = Axis::exact(Some((0.0, 360.0)), 4, "Azimuth, deg");
    x.ticks = [0.0, 90.0, 180.0, 270.0, 360.0].map(|degrees: f64| (degrees, format!("{degrees:.0}"))).to_vec();
    beside_over(top, x, y)
}

/// Returns a frame to the right of a polar picture below `top`.
pub(super) fn beside_over(top: f64, x: Axis, y: Axis) -> Frame {
    let bottom = top + MIDDLE.1 + RADIUS - 14.0;
    Frame { start: BESIDE, left: BESIDE + gutter(&[&y]), top: top + 8.0, right: WIDE_RIGHT, bottom, x, y }
}

/// Returns a curve with its azimuth in degrees within one revolution, interrupted where the azimuth wraps.
fn passes(points: &[Point]) -> Vec<Point> {
    let mut folded: Vec<Point> = Vec::with_capacity(points.len() + 16);
    for (azimuth, load) in points.iter().filter(|point| point.0.is_finite()) {
        let degrees = azimuth.rem_euclid(TAU).to_degrees();
        if folded.last().is_some_and(|last| (last.0 - degrees).abs() > 180.0) {
            folded.push((degrees, f64::NAN));
        }
        folded.push((degrees, *load));
    }
    folded
}
