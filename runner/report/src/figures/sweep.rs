//! Figures of a sweep: response curves, bifurcation diagram, waterfall.

use super::Picture;
use super::axis::{Axis, extent};
use super::canvas::{
    Anchor, BELOW, Frame, INK, Key, Marker, SERIES, Stroke, WIDE, WIDE_RIGHT, gutter, legend_height, picture, stacked,
};
use super::line::{Point, Thinning};
use ballrace_twin::sweep::Row;

/// Largest number of spectra of a waterfall.
const MAX_LINES: usize = 60;
/// Largest number of sections of one point in the bifurcation diagram.
const SECTIONS: usize = 48;
/// Height of the highest peak of a waterfall.
const PEAK: f64 = 56.0;

/// Rows that belong together, in the order of the first axis.
pub(crate) struct Curve<'a> {
    /// Label of the curve.
    pub(crate) name: String,
    /// `rest`, `up` or `down`.
    pub(crate) direction: String,
    /// One row per value of the first axis.
    pub(crate) rows: Vec<&'a Row>,
}

fn along(row: &Row) -> f64 {
    row.values.first().copied().unwrap_or(0.0)
}

fn stroke(i: usize) -> Stroke {
    Stroke(SERIES[i % SERIES.len()], 1.5)
}

fn horizontal(title: &str, curves: &[Curve<'_>]) -> Axis {
    Axis::exact(extent(curves.iter().flat_map(|c| c.rows.iter().map(|row| along(row)))), 8, title)
}

fn legend<'a>(curves: &'a [Curve<'a>]) -> Vec<(Key, &'a str)> {
    curves.iter().enumerate().map(|(i, c)| (Key::Line(stroke(i)), c.name.as_str())).collect()
}

/// Draws the peak-to-peak motion along X and, below it, along Y.
pub(crate) fn response(title: &str, curves: &[Curve<'_>]) -> Picture {
    let x = horizontal(title, curves);
    let points = |curve: &Curve<'_>, k: usize| -> Vec<Point> {
        curve.rows.iter().map(|row| (along(row), row.figures.peak_to_peak[k])).collect()
    };
    let vertical = |k: usize, name: &str| {
        let all = curves.iter().flat_map(|c| points(c, k)).map(|p| p.1);
        Axis::from_zero(extent(all).map(|range| range.1), 5, name)
    };
    let axes = vec![vertical(0, "X, um pp"), vertical(1, "Y, um pp")];
    let legend = legend(curves);
    let top = legend_height(gutter(&[&axes[0], &axes[1]]), &legend) + 10.0;
    let frames = stacked(&x, axes, (top, 120.0, 14.0));
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        canvas.legend(frames[0].left, 0.0, &legend);
        for (k, frame) in frames.iter().enumerate() {
            frame.axes(canvas, k == 1);
            for (i, curve) in curves.iter().enumerate() {
                frame.series(canvas, (&curve.name, &points(curve, k)), Thinning::None, stroke(i));
            }
        }
    });
    Picture {
        title: "Response: peak to peak of the steady-state motion".to_owned(),
        note: "Motion of the rotor's centre of mass.".to_owned(),
        drawing,
        ..Picture::default()
    }
}

/// Draws the position of the rotor along X at each section.
pub(crate) fn bifurcation(title: &str, curves: &[Curve<'_>]) -> Picture {
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
    let legend = legend(curves);
    let top = legend_height(left, &legend) + 10.0;
    let frame = Frame { start: 0.0, left, top, right: WIDE_RIGHT, bottom: top + 250.0, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        canvas.legend(left, 0.0, &legend);
        frame.axes(canvas, true);
        for (i, curve) in curves.iter().enumerate() {
            let mut points: Vec<Point> = Vec::new();
            for row in &curve.rows {
                let mut seen: Vec<i64> = Vec::new();
                for u in sections(row) {
                    // Points that coincide in the picture are drawn once.
                    let place = (frame.at(&(along(row), u)).1 * 2.0).round() as i64;
                    if !seen.contains(&place) {
                        seen.push(place);
                        points.push((along(row), u));
                    }
                }
            }
            frame.scatter(canvas, (&curve.name, &points), Marker::Dot(1.2, stroke(i).0));
        }
    });
    Picture {
        title: "Bifurcation diagram".to_owned(),
        note: "One dot: period one. Two, three, four: the motion repeats after as many section periods. A cloud: the motion does not repeat."
            .to_owned(),
        drawing,
        ..Picture::default()
    }
}

/// Draws the spectra along X of the points, one behind the other.
pub(crate) fn waterfall(title: &str, curve: &Curve<'_>) -> Picture {
    let every = curve.rows.len().div_ceil(MAX_LINES).max(1);
    let rows: Vec<&&Row> = curve.rows.iter().step_by(every).collect();
    let count = rows.iter().map(|row| row.figures.spectrum.len()).max().unwrap_or(0);
    let largest = rows.iter().flat_map(|row| &row.figures.spectrum).fold(0.0_f64, |most, a| most.max(*a));
    let x = Axis::exact(Some((0.0, 4.0)), 9, "Frequency over that of the section");
    let values = extent(rows.iter().map(|row| along(row)));
    let (height, top) = (300.0, 24.0);
    // The last spectrum fits inside the frame.
    let range = values.map(|(low, high)| (low, high + (high - low).max(1e-9 * high.abs()) * PEAK / (height - PEAK)));
    let y = Axis::exact(range, 8, title);
    let left = gutter(&[&y]);
    let frame = Frame { start: 0.0, left, top, right: WIDE_RIGHT, bottom: top + height, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        frame.axes(canvas, true);
        // Spectra further up lie behind: they are drawn first.
        for row in rows.iter().rev() {
            let frequency = |k: usize| 4.0 * (k as f64 + 0.5) / count.max(1) as f64;
            let points: Vec<Point> =
                row.figures.spectrum.iter().enumerate().map(|(k, amplitude)| (frequency(k), *amplitude)).collect();
            frame.ridge(canvas, along(row), ("amplitude, um peak", &points), (largest, PEAK));
        }
        let words = format!("height: root of the amplitude, highest {largest:.3} um peak");
        canvas.text(&words, (left, 8.0), Anchor::Start, INK);
    });
    Picture {
        title: format!("Waterfall of the motion along X ({})", curve.name),
        note: "1 is the frequency at which the section is taken; lines between whole numbers are subharmonic or belong to the shaft."
            .to_owned(),
        drawing,
        ..Picture::default()
    }
}
