//! Envelope spectra: modulation frequencies of a vibration band, with the lines of the bearing's components.

use super::axis::{Axis, extent};
use super::canvas::{BAND, BELOW, FAINT, Frame, Key, MEASURED_LINE, Stroke, WIDE, gutter, legend_height, picture};
use super::line::Point;
use super::{Context, Figure, Picture, PointBudget, mark};
use ballrace_twin::replay::outcome::{EnvelopeSpectrum, Pictures};

const HEIGHT: f64 = 190.0;
/// Multiples of each line that are marked too.
const MULTIPLES: [f64; 2] = [2.0, 3.0];
const SIDE_BAND: Stroke = Stroke(BAND, 2.4);
const MULTIPLE: Stroke = Stroke(FAINT, 0.9);

/// Envelope spectra, one per vibration sensor.
pub(super) struct EnvelopeSpectra;

impl Figure for EnvelopeSpectra {
    fn heading(&self) -> &'static str {
        "Envelope spectra"
    }

    fn lines(&self, data: &Pictures) -> usize {
        data.envelopes.len()
    }

    fn draw(&self, context: &Context<'_>) -> Vec<Picture> {
        context.data.envelopes.iter().map(|one| envelope(one, context.budget)).collect()
    }
}

/// Draws the envelope spectrum of one sensor.
pub(super) fn envelope(envelope: &EnvelopeSpectrum, budget: PointBudget) -> Picture {
    let points: Vec<Point> =
        envelope.modulation.iter().enumerate().skip(1).map(|(i, a)| (i as f64 * envelope.bin_hz, *a)).collect();
    let highest = points.last().map(|point| point.0).filter(|hz| *hz > 0.0 && hz.is_finite()).unwrap_or(1.0);
    let x = Axis::exact(Some((0.0, highest)), 7, "Frequency, Hz");
    let y = Axis::from_zero(extent(points.iter().map(|p| p.1)).map(|range| range.1), 6, "Modulation, peak");
    let mut marks = mark::marks(&envelope.lines, &[], highest);
    let left = gutter(&[&y]);
    let right = mark::right_edge(&marks, left, WIDE, |hz| x.place(hz));
    let rows = mark::stack(&mut marks, |hz| left + x.place(hz) * (right - left));
    let legend = [
        (Key::Line(MEASURED_LINE), "envelope"),
        (Key::Line(MULTIPLE), "lines and their multiples"),
        (Key::Line(SIDE_BAND), "side bands"),
    ];
    let top = legend_height(left, &legend) + 8.0 + mark::height(rows);
    let frame = Frame { start: 0.0, left, top, right, bottom: top + HEIGHT, x, y };
    let drawing = picture((WIDE, frame.bottom + BELOW), |canvas| {
        canvas.legend(left, 0.0, &legend);
        frame.axes(canvas, true);
        frame.uprights(canvas, envelope.side_bands_hz.iter().copied(), SIDE_BAND);
        let lines = envelope.lines.iter().filter(|line| line.order > 0.0);
        let multiples = lines.flat_map(|line| MULTIPLES.map(|k| k * line.hz));
        frame.uprights(canvas, multiples, MULTIPLE);
        mark::lines(canvas, &frame, &marks);
        mark::names(canvas, &frame, &marks);
        frame.series(canvas, ("envelope", &points), budget.spectrum(), MEASURED_LINE);
        frame.note_if_empty(canvas, &[&points]);
    });
    let [low, high] = envelope.band_hz;
    Picture {
        title: format!("Envelope spectrum of {}", envelope.name),
        note: format!(
            "Squared envelope of {low:.0} to {high:.0} Hz: {}. Amplitude over the band's mean square: 1 swells from \
             nothing to twice the mean. Side bands: inner race by the shaft's turns, twice the spin by the cage's.",
            envelope.reason
        ),
        drawing,
        ..Picture::default()
    }
}
