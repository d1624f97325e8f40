//! Error over cost: one dot per candidate, the Pareto front as a line with numbered dots.

use super::Picture;
use super::axis::Axis;
use super::canvas::{
    Anchor, BELOW, Canvas, FAINT, Frame, INK, Key, MEASURED, Marker, Stroke, TWIN, WIDE, WIDE_RIGHT, gutter, picture,
};
use super::line::Point;

const HEIGHT: f64 = 300.0;
/// Smallest error drawn; smaller ones are rounding.
const LEAST_ERROR: f64 = 1e-16;

/// One candidate in the figure.
pub(crate) struct Dot {
    /// Cost, in the unit of the axis.
    pub cost: f64,
    /// Relative error.
    pub error: f64,
    /// The candidate is on the Pareto front.
    pub front: bool,
    /// The candidate computes in single precision.
    pub single: bool,
    /// Name in the list below the figure.
    pub name: String,
}

/// Draws the figure; `None` where no candidate has a cost.
pub(crate) fn front(title: &str, costs: &str, errors: &str, dots: &[Dot]) -> Option<Picture> {
    let shown: Vec<&Dot> = dots.iter().filter(|d| d.cost > 0.0 && d.error.is_finite()).collect();
    if shown.is_empty() {
        return None;
    }
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
    };
    let error = |d: &Dot| d.error.max(LEAST_ERROR);
    let (low, high) = range(&mut shown.iter().map(|d| d.cost));
    let x = Axis::decades(low / 1.6, high * 1.6, costs);
    let (low, high) = range(&mut shown.iter().map(|d| error(d)));
    // The number of the lowest dot stands below it, inside the frame.
    let y = Axis::decades(low / 10.0, high * 2.5, errors);
    let left = gutter(&[&y]);
    let frame = Frame { start: 0.0, left, top: 30.0, right: WIDE_RIGHT, bottom: HEIGHT, x, y };
    let mut best: Vec<&Dot> = shown.iter().copied().filter(|d| d.front).collect();
    best.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let drawing = picture((WIDE, HEIGHT + BELOW), |canvas| {
        let keys =
            [(Key::Dot(MEASURED), "f64"), (Key::Ring(TWIN), "f32"), (Key::Line(Stroke(FAINT, 1.5)), "Pareto front")];
        canvas.legend(left, 0.0, &keys);
        frame.axes(canvas, true);
        frame.curve(canvas, &stairs(&best), Stroke(FAINT, 1.5));
        let kinds = [
            ("f64", false, false, Marker::Dot(2.4, MEASURED)),
            ("f32", true, false, Marker::Ring(TWIN)),
            ("f64, on the Pareto front", false, true, Marker::Dot(4.0, MEASURED)),
            ("f32, on the Pareto front", true, true, Marker::Ring(TWIN)),
        ];
        for (name, is_single, is_front, marker) in kinds {
            let of_kind = shown.iter().filter(|dot| dot.single == is_single && dot.front == is_front);
            let points: Vec<Point> = of_kind.map(|dot| (dot.cost, error(dot))).collect();
            frame.scatter(canvas, (name, &points), marker);
        }
        frame.inside(canvas, |canvas| numbers(canvas, &frame, &best));
    });
    let list: Vec<String> = best.iter().enumerate().map(|(i, d)| format!("{} {}", i + 1, d.name)).collect();
    Some(Picture {
        title: title.to_owned(),
        note: format!("On the Pareto front: {}.", list.join("; ")),
        drawing,
        ..Picture::default()
    })
}

/// Returns the Pareto front as a staircase.
fn stairs(best: &[&Dot]) -> Vec<Point> {
    let mut line = Vec::new();
    for dot in best {
        let error = dot.error.max(LEAST_ERROR);
        if let Some(&(_, above)) = line.last() {
            line.push((dot.cost, above));
        }
        line.push((dot.cost, error));
    }
    line
}

/// Draws numbers beside the dots of the front, on the side of lower cost and error.
fn numbers(canvas: &mut Canvas, frame: &Frame, best: &[&Dot]) {
    let mut last: Option<Point> = None;
    for (i, dot) in best.iter().enumerate() {
        let (px, py) = frame.at(&(dot.cost, dot.error.max(LEAST_ERROR)));
        // Labels of nearly coincident dots would overlap.
        let near = last.is_some_and(|(x, y)| (px - x).abs() < 12.0 && (py - y).abs() < 12.0);
        let at = if near { (px + 9.0, py - 9.0) } else { (px - 9.0, py + 9.0) };
        canvas.text(&(i + 1).to_string(), at, Anchor::Middle, INK);
        last = Some((px, py));
    }
}
