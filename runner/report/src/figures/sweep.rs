//! A sweep in pictures: how large the motion is, where it is at each section, which frequencies it has.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{Anchor, Dashes, Frame, INK, Key, MEASURED, PAPER, Stroke, TWIN, gutter, picture};
use super::line::Point;
use anyhow::Result;
use ballrace_twin::sweep::Row;
use plotters::prelude::RGBColor;

const WIDTH: f64 = 760.0;
/// Spectra of a waterfall at most.
const MAX_LINES: usize = 60;
/// Sections of one point that the bifurcation diagram shows.
const SECTIONS: usize = 48;
/// Strokes of the curves in turn; the second of each is for decreasing values.
const COLOURS: [RGBColor; 6] = [
    MEASURED,
    TWIN,
    RGBColor(0x00, 0x7a, 0x5e),
    RGBColor(0x7a, 0x3e, 0x9d),
    RGBColor(0x8a, 0x6d, 0x00),
    RGBColor(0xb0, 0x2a, 0x4c),
];

/// Rows that belong together, in the order of the first axis.
pub(crate) struct Curve<'a> {
    /// Label of the curve.
    pub(crate) name: String,
    /// `rest`, `up` or `down`.
    pub(crate) direction: String,
    /// One a value of the first axis.
    pub(crate) rows: Vec<&'a Row>,
}

fn along(row: &Row) -> f64 {
    row.values.first().copied().unwrap_or(0.0)
}

fn colour(i: usize) -> RGBColor {
    COLOURS.get(i % COLOURS.len()).copied().unwrap_or(MEASURED)
}

fn horizontal(title: &str, curves: &[Curve<'_>]) -> Axis {
    Axis::exact(extent(curves.iter().flat_map(|c| c.rows.iter().map(|row| along(row)))), 9, title)
}

fn legend<'a>(curves: &'a [Curve<'a>]) -> Vec<(Key, &'a str)> {
    curves.iter().enumerate().map(|(i, c)| (Key::Line(Stroke(colour(i), 1.8)), c.name.as_str())).collect()
}

/// Peak to peak along X above, along Y below.
pub(crate) fn response(title: &str, curves: &[Curve<'_>]) -> Result<Picture> {
    let x = horizontal(title, curves);
    let points = |curve: &Curve<'_>, k: usize| -> Vec<Point> {
        curve.rows.iter().map(|row| (along(row), row.figures.peak_to_peak[k])).collect()
    };
    let vertical = |k: usize, name: &str| {
        let all = curves.iter().flat_map(|c| points(c, k)).map(|p| p.1);
        Axis::from_zero(extent(all).map(|range| range.1), 5, name)
    };
    let (above, below) = (vertical(0, "X, um pp"), vertical(1, "Y, um pp"));
    let left = gutter(&[&above, &below]);
    let top = 34.0;
    let upper = Frame { start: 0.0, left, top, right: WIDTH - 18.0, bottom: top + 150.0, x: x.clone(), y: above };
    let lower = Frame { top: upper.bottom + 16.0, bottom: upper.bottom + 166.0, y: below, ..upper.clone() };
    let svg = picture((WIDTH, lower.bottom + 36.0), Dashes::None, |canvas| {
        canvas.legend(left, 0.0, &legend(curves))?;
        for (k, frame) in [&upper, &lower].into_iter().enumerate() {
            frame.axes(canvas, k == 1)?;
            for (i, curve) in curves.iter().enumerate() {
                frame.curve(canvas, &points(curve, k), Stroke(colour(i), 1.4))?;
            }
        }
        Ok(())
    })?;
    Ok(Picture {
        title: "Response: peak to peak of the steady-state motion".to_owned(),
        note: "For the rotor's centre of mass.".to_owned(),
        svg,
    })
}

/// Displacement of the rotor along X at each point of the section.
pub(crate) fn bifurcation(title: &str, curves: &[Curve<'_>]) -> Result<Picture> {
    let x = horizontal(title, curves);
    let sections = |row: &Row| -> Vec<f64> {
        let all = &row.figures.section;
        all.iter().skip(all.len().saturating_sub(SECTIONS)).map(|[u, _]| *u).collect()
    };
    let y = Axis::padded(
        extent(curves.iter().flat_map(|c| c.rows.iter().flat_map(|row| sections(row)))),
        6,
        "X at the section, um",
    );
    let left = gutter(&[&y]);
    let frame = Frame { start: 0.0, left, top: 34.0, right: WIDTH - 18.0, bottom: 334.0, x, y };
    let svg = picture((WIDTH, frame.bottom + 36.0), Dashes::None, |canvas| {
        canvas.legend(left, 0.0, &legend(curves))?;
        frame.axes(canvas, true)?;
        for (i, curve) in curves.iter().enumerate() {
            for row in &curve.rows {
                let mut seen: Vec<i64> = Vec::new();
                for u in sections(row) {
                    let (px, py) = frame.at(&(along(row), u));
                    // Points that fall on one another are one.
                    let place = (py * 2.0).round() as i64;
                    if !seen.contains(&place) {
                        seen.push(place);
                        canvas.dot(px, py, 1.2, colour(i))?;
                    }
                }
            }
        }
        Ok(())
    })?;
    Ok(Picture {
        title: "Bifurcation diagram".to_owned(),
        note: "One dot: period one. Two, three, four: the motion repeats after as many section periods. A cloud: it does not repeat."
            .to_owned(),
        svg,
    })
}

/// The spectrum along X of each point, one behind the other.
pub(crate) fn waterfall(title: &str, curve: &Curve<'_>) -> Result<Picture> {
    let every = curve.rows.len().div_ceil(MAX_LINES).max(1);
    let rows: Vec<&&Row> = curve.rows.iter().step_by(every).collect();
    let count = rows.iter().map(|row| row.figures.spectrum.len()).max().unwrap_or(0);
    let largest = rows.iter().flat_map(|row| &row.figures.spectrum).fold(0.0_f64, |most, a| most.max(*a));
    let x = Axis::exact(Some((0.0, 4.0)), 9, "Frequency over that of the section");
    let y = Axis::exact(extent(rows.iter().map(|row| along(row))), 8, title);
    let left = gutter(&[&y]);
    let frame = Frame { start: 0.0, left, top: 70.0, right: WIDTH - 18.0, bottom: 400.0, x, y };
    let height = 60.0;
    let svg = picture((WIDTH, frame.bottom + 36.0), Dashes::None, |canvas| {
        frame.axes(canvas, true)?;
        // Those further up lie behind.
        for row in rows.iter().rev() {
            let base = frame.at(&(0.0, along(row))).1;
            let points: Vec<Point> = row
                .figures
                .spectrum
                .iter()
                .enumerate()
                .map(|(k, a)| {
                    let order = 4.0 * (k as f64 + 0.5) / count.max(1) as f64;
                    (frame.at(&(order, 0.0)).0, base - height * (a / largest.max(f64::MIN_POSITIVE)).sqrt())
                })
                .collect();
            let mut body = points.clone();
            body.extend([(frame.right, base), (frame.left, base)]);
            canvas.polygon(&body, PAPER)?;
            canvas.line(&points, Stroke(MEASURED, 0.9))?;
        }
        canvas.text(&format!("height: root of the amplitude, highest {largest:.3} um"), (left, 8.0), Anchor::Start, INK)
    })?;
    Ok(Picture {
        title: format!("Waterfall of the motion along X ({})", curve.name),
        note: "1 is the frequency at which the section is taken; lines between whole numbers are subharmonic or belong to the shaft."
            .to_owned(),
        svg,
    })
}
