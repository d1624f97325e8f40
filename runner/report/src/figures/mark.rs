//! Names of the lines in a spectrum, set above it so that no name covers another or its line.

use super::canvas::{Anchor, Canvas, FAINT, Frame, INK, MARK, RESIDUAL, SMALL, Stroke, text_width};
use crate::number::shortened;
use ballrace_twin::replay::outcome::MarkedLine;

/// Height of one row of names.
const ROW: f64 = 13.0;
/// Lines that are closer than this share of the highest frequency have one name.
const TOUCHING: f64 = 0.004;
/// Largest number of characters of a place and of a kind in a name; longer ones are truncated.
const LONGEST: usize = 26;

/// A marked line with its name, which is set in a row above the frame.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Mark {
    /// Frequency, Hz.
    pub(super) hz: f64,
    /// Name, such as "DE, NDE outer 3.58X".
    pub(super) name: String,
    /// The line is a natural frequency.
    pub(super) is_natural: bool,
    /// Row of the name; 0 is next to the frame.
    pub(super) row: usize,
}

/// Returns the marks with `0 < f <= highest`, sorted by frequency, all in row 0.
pub(super) fn marks(lines: &[MarkedLine], natural: &[MarkedLine], highest: f64) -> Vec<Mark> {
    let of = |lines: &[MarkedLine], is_natural: bool| -> Vec<Mark> {
        let mut inside: Vec<&MarkedLine> = lines.iter().filter(|line| line.hz > 0.0 && line.hz <= highest).collect();
        inside.sort_by(|a, b| a.hz.total_cmp(&b.hz));
        let groups = inside.chunk_by(|a, b| b.hz - a.hz < TOUCHING * highest);
        groups.map(|group| Mark { hz: group[0].hz, name: name(group), is_natural, row: 0 }).collect()
    };
    let mut marks = [of(lines, false), of(natural, true)].concat();
    marks.sort_by(|a, b| a.hz.total_cmp(&b.hz));
    marks
}

/// Returns one label for lines at one frequency; a common part appears once. The order is never truncated.
fn name(group: &[&MarkedLine]) -> String {
    let parts: Vec<Option<(&str, &str)>> = group.iter().map(|line| line.label.rsplit_once(' ')).collect();
    let kind = parts.first().copied().flatten().map(|part| part.1);
    let mut text = match kind.filter(|kind| parts.iter().all(|part| part.is_some_and(|part| part.1 == *kind))) {
        Some(kind) => {
            let places: Vec<&str> = parts.iter().flatten().map(|part| part.0).collect();
            format!("{} {}", shortened(&places.join(", "), LONGEST), shortened(kind, LONGEST))
        }
        None => shortened(&group.iter().map(|line| line.label.as_str()).collect::<Vec<_>>().join(", "), LONGEST),
    };
    let order = group[0].order;
    if order.is_finite() && !group.iter().any(|line| line.label.ends_with('X')) {
        text.push_str(&format!(" {order:.2}X"));
    }
    text
}

/// Returns the right edge of the frame, pixels, so that the last names end inside the picture.
pub(super) fn right_edge(marks: &[Mark], left: f64, width: f64, place: impl Fn(f64) -> f64) -> f64 {
    let widest = width - 14.0;
    let edge = marks.iter().map(|mark| {
        let room = width - 8.0 - text_width(&mark.name, SMALL) - left;
        left + room / place(mark.hz).max(0.05)
    });
    edge.fold(widest, f64::min).max(left + 0.5 * (width - left))
}

/// Sets the row of each mark, from right to left, so that a name is above the names of all lines that it spans. Returns the number of
/// rows.
pub(super) fn stack(marks: &mut [Mark], x_of: impl Fn(f64) -> f64) -> usize {
    for i in (0..marks.len()).rev() {
        let end = x_of(marks[i].hz) + text_width(&marks[i].name, SMALL) + 10.0;
        let passed = marks[i + 1..].iter().filter(|later| x_of(later.hz) < end);
        marks[i].row = passed.map(|later| later.row + 1).max().unwrap_or(0);
    }
    marks.iter().map(|mark| mark.row + 1).max().unwrap_or(0)
}

/// Returns the height of a number of rows, pixels.
pub(super) fn height(rows: usize) -> f64 {
    ROW * rows as f64
}

/// Draws the lines through the frame, also on the reverse side of a full spectrum.
pub(super) fn lines(canvas: &mut Canvas, frame: &Frame, marks: &[Mark]) {
    for is_natural in [false, true] {
        let of_kind = marks.iter().filter(|mark| mark.is_natural == is_natural);
        let stroke = if is_natural { Stroke(RESIDUAL, 0.75) } else { Stroke(FAINT, 0.75) };
        frame.uprights(canvas, of_kind.flat_map(|mark| [mark.hz, -mark.hz]), stroke);
    }
}

/// Draws the names, and the lines from the frame up to them.
pub(super) fn names(canvas: &mut Canvas, frame: &Frame, marks: &[Mark]) {
    frame.along(canvas, |canvas| {
        for mark in marks {
            let x = frame.at(&(mark.hz, 0.0)).0;
            let y = frame.top - ROW * (mark.row as f64 + 0.5) - 2.0;
            canvas.line(&[(x, frame.top), (x, y - 4.0)], Stroke(MARK, 0.75));
            canvas.text(&mark.name, (x + 3.0, y), Anchor::Start, INK);
        }
    });
}

/// Writes the names of the sides of a two-sided spectrum below the lowest frame.
pub(super) fn name_sides(canvas: &mut Canvas, frame: &Frame) {
    let y = frame.bottom + 26.0;
    canvas.text("\u{2190} reverse precession", (frame.left - 8.0, y), Anchor::Start, INK);
    canvas.text("forward precession \u{2192}", (frame.right, y), Anchor::End, INK);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(label: &str, order: f64) -> MarkedLine {
        MarkedLine { label: label.to_owned(), order, hz: 50.0 * order }
    }

    #[test]
    fn equal_lines_share_a_name() {
        let lines = [
            line("1X", 1.0),
            line("DE outer", 3.58),
            line("NDE outer", 3.58),
            line("DE inner", 5.42),
            line("bad", f64::NAN),
        ];
        let names: Vec<String> = marks(&lines, &[], 800.0).into_iter().map(|mark| mark.name).collect();
        assert_eq!(names, ["1X", "DE, NDE outer 3.58X", "DE inner 5.42X"]);
    }

    #[test]
    fn natural_frequencies_have_names_of_their_own() {
        let natural = |label: &str, hz: f64| MarkedLine { label: label.to_owned(), order: f64::NAN, hz };
        let marks = marks(&[line("1X", 1.0)], &[natural("N2", 50.2), natural("N1", 50.1), natural("N3", 900.0)], 800.0);
        let names: Vec<(&str, bool)> = marks.iter().map(|mark| (mark.name.as_str(), mark.is_natural)).collect();
        assert_eq!(names, [("1X", false), ("N1, N2", true)]);
    }

    #[test]
    fn no_name_covers_another_name_or_line() {
        let lines: Vec<MarkedLine> = (1..12).map(|n| line(&format!("bearing {n} outer"), 0.4 * f64::from(n))).collect();
        let mut marks = marks(&lines, &[], 300.0);
        let x_of = |hz: f64| 2.0 * hz;
        stack(&mut marks, x_of);
        for (i, mark) in marks.iter().enumerate() {
            let end = x_of(mark.hz) + text_width(&mark.name, SMALL);
            for later in marks[i + 1..].iter().filter(|later| x_of(later.hz) < end) {
                assert!(later.row < mark.row, "{mark:?} {later:?}");
            }
        }
    }
}
