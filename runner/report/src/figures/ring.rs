//! Loads of the rolling elements: by azimuth, and of element 1 along its path.

use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, Canvas, Dashes, Frame, GRID, INK, Key, MARK, MEASURED, RESIDUAL, Stroke, TWIN, gutter, picture,
};
use super::line::{Point, decimated};
use super::{Context, Figure, Picture, PointBudget};
use anyhow::Result;
use ballrace_twin::replay::outcome::{ElementLoads, Pictures};
use std::f64::consts::{FRAC_PI_2, TAU};

const WIDTH: f64 = 620.0;
/// Middle and radius of the polar picture.
pub(super) const MIDDLE: Point = (142.0, 184.0);
const RADIUS: f64 = 112.0;
/// Largest load, from the machine.
const LARGEST: Stroke = Stroke(RESIDUAL, 1.2);
const MEAN: Stroke = Stroke(MEASURED, 1.6);
const TWIN_MEAN: Stroke = Stroke(TWIN, 1.5);

/// Loads around the ring, one picture per bearing with elements.
pub(super) struct ElementLoadPlots;

impl Figure for ElementLoadPlots {
    fn heading(&self) -> &'static str {
        "Load on the rolling elements"
    }

    fn lines(&self, data: &Pictures) -> usize {
        4 * data.element_loads.len()
    }

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        context.data.element_loads.iter().map(|one| loads(one, context.budget)).collect()
    }
}

/// One picture for each bearing with elements.
pub(super) fn loads(loads: &ElementLoads, budget: PointBudget) -> Result<Picture> {
    let top = extent(loads.largest.iter().chain(&loads.mean).chain(&loads.twin_mean).copied()).map(|range| range.1);
    let radial = Axis::from_zero(top, 5, "");
    let frame = way_frame(loads);
    let svg = picture((WIDTH, 330.0), Dashes::Twin, |canvas| {
        canvas.legend(8.0, 0.0, &legend())?;
        rings(canvas, &radial)?;
        for (values, stroke) in [(&loads.largest, LARGEST), (&loads.mean, MEAN), (&loads.twin_mean, TWIN_MEAN)] {
            polar(canvas, &loads.azimuth, values, &radial, stroke)?;
        }
        ring_labels(canvas, loads, &radial)?;
        frame.axes(canvas, true)?;
        frame.curve(canvas, &path(&loads.first_element, budget.line()), Stroke(MEASURED, 1.0))?;
        frame.note_if_empty(canvas, &[&loads.first_element])
    })?;
    Ok(Picture {
        title: format!("Load on the elements of bearing {}", loads.name),
        note:
            "Left: load of the element that passes at each azimuth. Right: element 1 from the measured displacement, \
               every turn of the cage drawn over the ones before. Azimuth from +X towards +Y."
                .to_owned(),
        svg,
    })
}

/// The load on every element of a bearing at one moment: azimuth (rad) and load (N).
pub(crate) fn present_loads(name: &str, loads: &[(f64, f64)]) -> Result<Picture> {
    let radial = Axis::from_zero(extent(loads.iter().map(|load| load.1)).map(|range| range.1), 5, "");
    let svg = picture((2.0 * MIDDLE.0 + 60.0, 330.0), Dashes::None, |canvas| {
        canvas.legend(8.0, 0.0, &[(Key::Line(MEAN), "load on each element now")])?;
        rings(canvas, &radial)?;
        for (azimuth, load) in loads.iter().filter(|(azimuth, load)| azimuth.is_finite() && *load > 0.0) {
            canvas.line(&[MIDDLE, around(*azimuth, radial.place(*load))], Stroke(MEASURED, 3.0))?;
        }
        for (value, label) in radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
            canvas.text(&format!("{label} N"), around(FRAC_PI_2 / 2.0, radial.place(*value)), Anchor::Middle, INK)?;
        }
        Ok(())
    })?;
    let title = format!("Load on the elements of bearing {name}");
    Ok(Picture { title, note: "At the estimated displacement. Azimuth from +X towards +Y.".to_owned(), svg })
}

fn legend() -> [(Key, &'static str); 3] {
    [
        (Key::Line(MEAN), "mean, from measured displacement"),
        (Key::Line(LARGEST), "largest"),
        (Key::Line(TWIN_MEAN), "mean, twin"),
    ]
}

/// Circles of equal load and the four directions.
pub(super) fn rings(canvas: &mut Canvas, radial: &Axis) -> Result<()> {
    for (name, angle) in [("0\u{b0} (+X)", 0.0), ("90\u{b0} (+Y)", 90.0), ("180\u{b0}", 180.0), ("270\u{b0}", 270.0)] {
        let radians: f64 = f64::to_radians(angle);
        canvas.line(&[MIDDLE, around(radians, 1.0)], Stroke(GRID, 0.75))?;
        let (sine, cosine) = radians.sin_cos();
        let (x, y) = around(radians, 1.0);
        let anchor = if cosine > 0.5 {
            Anchor::Start
        } else if cosine < -0.5 {
            Anchor::End
        } else {
            Anchor::Middle
        };
        canvas.text(name, (x + 5.0 * cosine, y - 9.0 * sine), anchor, INK)?;
    }
    canvas.circle(MIDDLE.0, MIDDLE.1, RADIUS, Stroke(MARK, 0.75))?;
    for (value, _) in radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
        canvas.circle(MIDDLE.0, MIDDLE.1, radial.place(*value) * RADIUS, Stroke(GRID, 1.0))?;
    }
    Ok(())
}

/// Draws the values of the circles, over the curves.
fn ring_labels(canvas: &mut Canvas, loads: &ElementLoads, radial: &Axis) -> Result<()> {
    let free = unloaded(loads);
    for (value, label) in radial.ticks.iter().filter(|tick| tick.0 > 0.0) {
        canvas.text(&format!("{label} N"), around(free, radial.place(*value)), Anchor::Middle, INK)?;
    }
    Ok(())
}

/// A diagonal on which little load is drawn, for the labels of the circles.
fn unloaded(loads: &ElementLoads) -> f64 {
    let load = |diagonal: f64| -> f64 {
        let near = |azimuth: f64| ((azimuth - diagonal + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0).abs() < 0.4;
        let values = loads.azimuth.iter().zip(&loads.largest).filter(|(azimuth, _)| near(**azimuth));
        values.map(|(_, load)| *load).filter(|load| load.is_finite()).fold(0.0, f64::max)
    };
    let diagonals = [0.125, 0.375, 0.625, 0.875].map(|share| share * TAU);
    diagonals.into_iter().min_by(|a, b| load(*a).total_cmp(&load(*b))).unwrap_or(FRAC_PI_2)
}

/// The point of the polar picture at an azimuth, `share` of the radius out.
pub(super) fn around(azimuth: f64, share: f64) -> Point {
    (MIDDLE.0 + RADIUS * share * azimuth.cos(), MIDDLE.1 - RADIUS * share * azimuth.sin())
}

/// A closed curve; a missing value breaks it.
fn polar(canvas: &mut Canvas, azimuth: &[f64], values: &[f64], radial: &Axis, stroke: Stroke) -> Result<()> {
    let ring: Vec<Point> = azimuth.iter().copied().zip(values.iter().copied()).collect();
    let closed: Vec<Point> = ring.iter().chain(ring.first()).copied().collect();
    for piece in super::line::pieces(&closed) {
        let pixels: Vec<Point> = piece.iter().map(|(azimuth, value)| around(*azimuth, radial.place(*value))).collect();
        canvas.line(&pixels, stroke)?;
    }
    Ok(())
}

fn way_frame(loads: &ElementLoads) -> Frame {
    let top = extent(loads.first_element.iter().map(|point| point.1)).map(|range| range.1);
    let y = Axis::from_zero(top, 8, "Load on element 1, N");
    let mut x = Axis::exact(Some((0.0, 360.0)), 4, "Azimuth of element 1, deg");
    x.ticks = [0.0, 90.0, 180.0, 270.0, 360.0].map(|degrees: f64| (degrees, format!("{degrees:.0}"))).to_vec();
    Frame { start: 312.0, left: 312.0 + gutter(&[&y]), top: 48.0, right: WIDTH - 18.0, bottom: 292.0, x, y }
}

/// Azimuth folded into one turn, broken where it passes 0.
fn path(points: &[Point], limit: usize) -> Vec<Point> {
    let mut folded: Vec<Point> = Vec::with_capacity(points.len() + 16);
    for (azimuth, load) in points.iter().filter(|point| point.0.is_finite()) {
        let degrees = azimuth.rem_euclid(TAU).to_degrees();
        if folded.last().is_some_and(|last| (last.0 - degrees).abs() > 180.0) {
            folded.push((degrees, f64::NAN));
        }
        folded.push((degrees, *load));
    }
    decimated(&folded, limit)
}
