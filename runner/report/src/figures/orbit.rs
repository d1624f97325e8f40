//! Orbits on equal scales, with the directions of the probes, and a blank and a dot at each keyphasor pulse.

use super::axis::{extent, signed};
use super::canvas::{
    Anchor, BELOW, Canvas, FAINT, Frame, INK, Key, MARK, MEASURED, MEASURED_LINE, SMALL, Stroke, TWIN, TWIN_LINE,
    equal_scales, picture, text_width,
};
use super::line::Point;
use super::{Context, Figure, Picture, PointBudget, Shape, Source};
use crate::number::{at_station, fixed, shortened};
use ballrace_twin::replay::outcome::{FilteredOrbit, Orbit, Pictures};

/// Side of the square.
const SIDE: f64 = 290.0;
/// Radius of the circle on which the probes are drawn.
const RIM: f64 = 0.5 * SIDE - 22.0;
/// Share of this radius that the orbit fills.
const FILLED: f64 = 0.8;
/// Largest number of revolutions drawn.
const TURNS: usize = 8;
/// Share of a revolution that is blank before the keyphasor dot.
const BLANK: f64 = 0.035;

/// Explanation below the figure.
const NOTE: &str = "Equal scales. X to the right, Y up, Z towards the reader. Blank, then bright: motion runs from the \
                    gap to the keyphasor dot (twin: ring).";

/// Points of a 1X orbit.
const ELLIPSE: u16 = 180;

/// Orbits, direct and 1X side by side.
pub(super) struct Orbits;

impl Figure for Orbits {
    fn heading(&self) -> &'static str {
        "Orbits"
    }

    fn shape(&self) -> Shape {
        Shape::Square
    }

    fn lines(&self, data: &Pictures) -> usize {
        2 * data.orbits.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        let both = |(i, direct): (usize, &Orbit)| {
            let all = Picture { source: Some(Source::Orbit(i)), ..orbit(direct, context.forward, context.budget) };
            let filtered = one_x(direct, context.forward, context.budget);
            [Some(all), filtered.map(|one| Picture { source: Some(Source::FilteredOrbit(i)), ..one })]
        };
        context.data.orbits.iter().enumerate().flat_map(both).flatten().collect()
    }
}

/// Draws the 1X part of an orbit over one revolution; `forward` is the sense of rotation, +1 from +X towards +Y. Returns `None`
/// without a 1X part.
pub(super) fn one_x(orbit: &Orbit, forward: f64, budget: PointBudget) -> Option<Picture> {
    let FilteredOrbit { speed_rpm, measured, twin } = orbit.one_x?;
    let around = |[cos, sin]: [(f64, f64); 2]| -> Vec<Point> {
        let point = |i: u16| {
            // The points are in the order of time: the shaft angle decreases in negative rotation.
            let (s, c) = (forward * std::f64::consts::TAU * f64::from(i) / f64::from(ELLIPSE)).sin_cos();
            (cos.0 * c + sin.0 * s, cos.1 * c + sin.1 * s)
        };
        (0..=ELLIPSE).map(point).collect()
    };
    let filtered = Orbit {
        name: orbit.name.clone(),
        station_mm: orbit.station_mm,
        measured: around(measured),
        twin: around(twin),
        keyphasor: vec![0, usize::from(ELLIPSE)],
        probes: orbit.probes.clone(),
        one_x: None,
    };
    let drawn = self::orbit(&filtered, forward, budget);
    let title = drawn.title.replacen("Orbit", &format!("1X orbit at {} rpm", fixed(speed_rpm, 0)), 1);
    Some(Picture { title, ..drawn })
}

/// Returns the sense of precession relative to that of rotation; an empty text where noise alone may cause it.
fn precession(points: &[Point], forward: f64) -> &'static str {
    let finite: Vec<&Point> = points.iter().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
    let count = finite.len().max(1) as f64;
    let middle = finite.iter().fold((0.0, 0.0), |sum, p| (sum.0 + p.0 / count, sum.1 + p.1 / count));
    let area = |pair: &[&Point]| {
        let [a, b] = [pair[0], pair[1]].map(|p| (p.0 - middle.0, p.1 - middle.1));
        a.0 * b.1 - a.1 * b.0
    };
    let steps: Vec<f64> = finite.windows(2).map(area).collect();
    let by_chance = steps.iter().map(|step| step * step).sum::<f64>().sqrt();
    match forward * steps.iter().sum::<f64>() {
        area if area > 4.0 * by_chance => ", forward precession",
        area if area < -4.0 * by_chance => ", reverse precession",
        _ => "",
    }
}

/// Draws the orbit in one plane; `forward` is the sense of rotation, +1 from +X towards +Y.
pub(super) fn orbit(orbit: &Orbit, forward: f64, budget: PointBudget) -> Picture {
    let shown = shown_samples(orbit);
    let frame = square(orbit, shown);
    let drawing = picture((frame.right + 14.0, frame.bottom + BELOW), |canvas| {
        canvas.legend(4.0, 0.0, &legend());
        frame.axes(canvas, true);
        rim(canvas, &frame, orbit);
        sense(canvas, &frame, forward);
        let marks: Vec<usize> = orbit.keyphasor.iter().copied().filter(|at| *at < shown).collect();
        for (name, points, stroke) in [("measured", &orbit.measured, MEASURED_LINE), ("twin", &orbit.twin, TWIN_LINE)] {
            frame.series(canvas, (name, &turns(points, &marks, shown)), budget.path(), stroke);
        }
        dots(canvas, &frame, orbit, &marks);
        frame.note_if_empty(canvas, &[&orbit.measured, &orbit.twin]);
    });
    // The 1X orbit beside it, which is free of noise, states the sense of precession.
    let filtered = orbit.one_x.is_some();
    let run = orbit.measured.get(..shown).unwrap_or(&orbit.measured);
    let sense = if filtered { "" } else { precession(run, forward) };
    Picture {
        title: format!("Orbit of {}{}{sense}", orbit.name, signed(&at_station(orbit.station_mm, 0))),
        note: NOTE.to_owned(),
        drawing,
        ..Picture::default()
    }
}

fn legend() -> [(Key, &'static str); 3] {
    [(Key::Line(MEASURED_LINE), "measured"), (Key::Line(TWIN_LINE), "twin"), (Key::Dot(MEASURED), "keyphasor")]
}

/// Returns the number of samples in the first [`TURNS`] revolutions.
fn shown_samples(orbit: &Orbit) -> usize {
    let all = orbit.measured.len().max(orbit.twin.len());
    orbit.keyphasor.get(TURNS).map_or(all, |end| all.min(end + 1))
}

/// Returns a square frame about the middle of both curves, with one scale in both directions.
fn square(orbit: &Orbit, shown: usize) -> Frame {
    let points = || orbit.measured.iter().take(shown).chain(orbit.twin.iter().take(shown));
    let x = extent(points().map(|point| point.0)).unwrap_or((-1.0, 1.0));
    let y = extent(points().map(|point| point.1)).unwrap_or((-1.0, 1.0));
    let radius = 0.5 * (x.1 - x.0).max(y.1 - y.0);
    let size = [x.0, x.1, y.0, y.1].into_iter().map(f64::abs).fold(0.0, f64::max);
    // A motion that the digits of its position cannot show is drawn as a point.
    let radius = if radius > 1e-9 * size.max(1e-3) { radius } else { 1.0f64.max(1e-3 * size) };
    let about = |range: (f64, f64)| {
        let middle = 0.5 * (range.0 + range.1);
        (middle - radius, middle + radius)
    };
    equal_scales((about(x), about(y)), (24.0, SIDE, FILLED * RIM / (0.5 * SIDE)), ["X, um", "Y, um"])
}

/// Draws the circle with the probes.
fn rim(canvas: &mut Canvas, frame: &Frame, orbit: &Orbit) {
    let (x, y) = (0.5 * (frame.left + frame.right), 0.5 * (frame.top + frame.bottom));
    canvas.circle(x, y, RIM, Stroke(FAINT, 0.75));
    for (name, angle) in orbit.probes.iter().filter(|probe| probe.1.is_finite()) {
        let (sine, cosine) = angle.sin_cos();
        let tip = (x + RIM * cosine, y - RIM * sine);
        canvas.triangle(tip, *angle, 11.0, MARK);
        name_probe(canvas, frame, tip, (cosine, sine), &shortened(name, 14));
    }
}

/// Writes the name of a probe between circle and frame; vertically near the X axis, where the space is narrow.
fn name_probe(canvas: &mut Canvas, frame: &Frame, tip: Point, (cosine, sine): Point, name: &str) {
    let half = 0.5 * text_width(name, SMALL) + 3.0;
    let side = if cosine < -1e-6 { -1.0 } else { 1.0 };
    if cosine.abs() > 0.87 {
        let x = if side > 0.0 { frame.right - 7.0 } else { frame.left + 7.0 };
        return canvas.upright(name, (x, tip.1.clamp(frame.top + half, frame.bottom - half)));
    }
    // A long name is written in the corner, where there is more space outside the circle.
    if half > 30.0 && cosine.abs() > 0.3 {
        let y = (tip.1 - 34.0 * sine).clamp(frame.top + 32.0, frame.bottom - 8.0);
        let (x, anchor) = if side > 0.0 { (frame.right - 5.0, Anchor::End) } else { (frame.left + 5.0, Anchor::Start) };
        return canvas.text(name, (x, y), anchor, INK);
    }
    let x = (tip.0 + side * (half + 10.0)).clamp(frame.left + half, frame.right - half);
    let y = (tip.1 - 9.0 * sine).clamp(frame.top + 8.0, frame.bottom - 8.0);
    canvas.text(name, (x, y), Anchor::Middle, INK)
}

/// Draws an arrow in the sense of rotation in the upper left corner.
fn sense(canvas: &mut Canvas, frame: &Frame, forward: f64) {
    let (x, y, radius) = (frame.left + 18.0, frame.top + 18.0, 9.0);
    let at = |angle: f64| (x + radius * angle.cos(), y - radius * angle.sin());
    let turn = |share: f64| std::f64::consts::PI * (0.5 + forward * (1.5 * share - 0.75));
    let arc: Vec<Point> = (0..=18).map(|i| at(turn(f64::from(i) / 18.0))).collect();
    canvas.line(&arc, Stroke(MARK, 1.2));
    let end = turn(1.0) + forward * 0.35;
    let back = turn(1.0) - forward * std::f64::consts::FRAC_PI_2;
    canvas.triangle(at(end), back, 7.0, MARK);
    canvas.text("rotation", (x + 14.0, y), Anchor::Start, MARK)
}

/// Returns the first `shown` points of a curve, blank just before each keyphasor pulse.
fn turns(points: &[Point], marks: &[usize], shown: usize) -> Vec<Point> {
    let turn = marks.windows(2).map(|pair| pair[1].saturating_sub(pair[0])).max().unwrap_or(0);
    let blank = if turn > 0 { 2 + (BLANK * turn as f64) as usize } else { 0 };
    let is_blank = |i: &usize| marks.iter().any(|mark| *i < *mark && i + blank > *mark);
    let place = |(i, point): (usize, &Point)| if is_blank(&i) { (f64::NAN, f64::NAN) } else { *point };
    points.iter().take(shown).enumerate().map(place).collect()
}

/// Draws the keyphasor marks: dots for the measured orbit, rings for the twin, so that both are visible at the same position.
fn dots(canvas: &mut Canvas, frame: &Frame, orbit: &Orbit, marks: &[usize]) {
    let at = |points: &[Point], mark: &usize| {
        points.get(*mark).filter(|point| point.0.is_finite() && point.1.is_finite()).map(|point| frame.at(point))
    };
    frame.inside(canvas, |canvas| {
        for (x, y) in marks.iter().filter_map(|mark| at(&orbit.measured, mark)) {
            canvas.dot(x, y, 3.6, MEASURED);
        }
        for (x, y) in marks.iter().filter_map(|mark| at(&orbit.twin, mark)) {
            canvas.ring(x, y, TWIN);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn precession_follows_the_path() {
        let circle: Vec<Point> = (0..50).map(|i| f64::from(i).sin_cos()).map(|(s, c)| (3.0 + c, s)).collect();
        assert_eq!(precession(&circle, 1.0), ", forward precession");
        assert_eq!(precession(&circle, -1.0), ", reverse precession");
        assert_eq!(precession(&[(0.0, 0.0), (1.0, 1.0), (f64::NAN, 0.0)], 1.0), "");
        let scattered: Vec<Point> = (0..500).map(|i| (f64::from(i * 37 % 101), f64::from(i * i * 53 % 97))).collect();
        assert_eq!(precession(&scattered, 1.0), "");
    }
}
