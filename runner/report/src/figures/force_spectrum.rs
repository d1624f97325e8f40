//! Full spectra of the unexplained force in the frames of housing, shaft and cage, one above the other.

use super::axis::{Axis, extent, signed};
use super::canvas::{
    Anchor, BELOW, Canvas, FAINT, Frame, INK, Key, MARK, MEASURED_LINE, SMALL, Stroke, TWIN, WIDE, picture, stacked,
    text_width,
};
use super::line::Point;
use super::mark::name_sides;
use super::{Picture, PointBudget};
use crate::number::shortened;
use crate::words;
use ballrace_twin::replay::outcome::{Diagnosis, ForceSpectrum, ReferenceFrame};

const HEIGHT: f64 = 100.0;
/// Room above a frame for the names of lines and of the frame.
const ABOVE: f64 = 32.0;
const EXPLAINED: Stroke = Stroke(TWIN, 2.6);

/// Draws the spectra of one diagnosis.
pub(super) fn force_spectra(diagnosis: &Diagnosis, budget: PointBudget) -> Picture {
    let spectra = &diagnosis.figures.spectra;
    let frames = frames(spectra);
    let bottom = frames.last().map_or(0.0, |frame| frame.bottom);
    let drawing = picture((WIDE, bottom + BELOW), |canvas| {
        canvas.legend(frames.first().map_or(0.0, |frame| frame.left), 0.0, &legend());
        for (i, (frame, spectrum)) in frames.iter().zip(spectra).enumerate() {
            frame.axes(canvas, i + 1 == frames.len());
            marks(canvas, frame, spectrum);
            let curves = [
                ("explained by the fault", &spectrum.explained, EXPLAINED),
                ("unexplained without the fault", &spectrum.unexplained, MEASURED_LINE),
            ];
            for (name, points, stroke) in curves {
                frame.series(canvas, (name, points), budget.spectrum(), stroke);
            }
            canvas.text(name(spectrum), (frame.left, frame.top - 22.0), Anchor::Start, INK);
            frame.note_if_empty(canvas, &[&spectrum.explained, &spectrum.unexplained]);
        }
        if let Some(frame) = frames.last() {
            name_sides(canvas, frame);
        }
    });
    let at =
        diagnosis.bearing.as_deref().map_or("on the rotor".to_owned(), |name| format!("at {}", shortened(name, 30)));
    let own = if diagnosis.figures.rose.is_some() {
        " In the frame of the damaged component the force keeps its direction: its lines are multiples of one order, equal on \
         both sides."
    } else {
        ""
    };
    Picture {
        title: format!("Unexplained force {at}: {}", words::cause(diagnosis).to_lowercase()),
        note: format!(
            "Force that the machine without the fault leaves unexplained, and the part that the fault adds; amplitude zero to \
             peak, mean omitted. Numbers: orders of the strongest lines of the fault, per turn of the shaft.{own}"
        ),
        drawing,
        ..Picture::default()
    }
}

fn legend() -> [(Key, &'static str); 2] {
    [(Key::Line(MEASURED_LINE), "unexplained without the fault"), (Key::Line(EXPLAINED), "explained by the fault")]
}

fn name(spectrum: &ForceSpectrum) -> &'static str {
    match (spectrum.frame, spectrum.is_of_component) {
        (ReferenceFrame::Fixed, true) => "Fixed frame, that of the damaged outer ring",
        (ReferenceFrame::Fixed, false) => "Fixed frame",
        (ReferenceFrame::Shaft, true) => "Frame of the shaft, that of the damaged inner ring",
        (ReferenceFrame::Shaft, false) => "Frame of the shaft",
        (ReferenceFrame::Cage, true) => "Frame of the cage, that of the damaged element",
        (ReferenceFrame::Cage, false) => "Frame of the cage",
    }
}

fn frames(spectra: &[ForceSpectrum]) -> Vec<Frame> {
    let points = |spectrum: &ForceSpectrum| -> Vec<Point> {
        spectrum.unexplained.iter().chain(&spectrum.explained).copied().collect()
    };
    let orders = spectra.iter().flat_map(|s| points(s).into_iter().map(|p| p.0.abs()));
    let highest = extent(orders).map_or(1.0, |range| range.1);
    let x = Axis::exact(Some((-highest, highest)), 7, "Order, X");
    let axes: Vec<Axis> = spectra
        .iter()
        .map(|s| Axis::from_zero(extent(points(s).into_iter().map(|p| p.1)).map(|range| range.1), 5, "Force, N peak"))
        .collect();
    stacked(&x, axes, (22.0 + ABOVE, HEIGHT, ABOVE + 6.0))
}

/// Draws a fine line at each order that the fault explains, with its number where there is space. The strongest lines have priority.
fn marks(canvas: &mut Canvas, frame: &Frame, spectrum: &ForceSpectrum) {
    let shown = || spectrum.lines.iter().copied().filter(|order| frame.x.holds(*order));
    frame.uprights(canvas, shown(), Stroke(FAINT, 0.75));
    frame.along(canvas, |canvas| {
        let mut taken: Vec<(f64, f64)> = vec![];
        for order in shown() {
            let x = frame.at(&(order, 0.0)).0;
            let label = signed(&format!("{order:.2}"));
            let half = 0.5 * text_width(&label, SMALL) + 2.0;
            let middle = x.clamp(frame.left + half, frame.right - half);
            if taken.iter().all(|(from, to)| middle + half < *from || middle - half > *to) {
                canvas.line(&[(x, frame.top), (x, frame.top - 3.0)], Stroke(MARK, 0.75));
                canvas.text(&label, (middle, frame.top - 8.5), Anchor::Middle, INK);
                taken.push((middle - half, middle + half));
            }
        }
    });
    frame.uprights(canvas, [0.0], Stroke(MARK, 1.0));
}
