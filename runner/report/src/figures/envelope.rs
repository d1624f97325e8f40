//! Envelope spectra: modulation frequencies of a vibration band, with the lines of the bearing's components.

use super::axis::{Axis, extent};
use super::canvas::{BAND, Dashes, FAINT, Frame, Key, MEASURED, Stroke, gutter, picture};
use super::line::{Point, peaks};
use super::{Context, Figure, Picture, PointBudget, mark};
use anyhow::Result;
use ballrace_twin::replay::outcome::{EnvelopeSpectrum, Pictures};

const WIDTH: f64 = 620.0;
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

    fn draw(&self, context: &Context<'_>) -> Result<Vec<Picture>> {
        context.data.envelopes.iter().map(|one| envelope(one, context.budget)).collect()
    }
}

/// One picture for each sensor.
pub(super) fn envelope(envelope: &EnvelopeSpectrum, budget: PointBudget) -> Result<Picture> {
    let points: Vec<Point> =
        envelope.modulation.iter().enumerate().skip(1).map(|(i, a)| (i as f64 * envelope.bin_hz, *a)).collect();
    let highest = points.last().map(|point| point.0).filter(|hz| *hz > 0.0 && hz.is_finite()).unwrap_or(1.0);
    let x = Axis::exact(Some((0.0, highest)), 9, "Frequency, Hz");
    let y = Axis::from_zero(extent(points.iter().map(|p| p.1)).map(|range| range.1), 6, "Modulation, peak");
    let mut marks = mark::marks(&envelope.lines, highest);
    let left = gutter(&[&y]);
    let right = mark::right_edge(&marks, left, WIDTH, |hz| x.place(hz));
    let rows = mark::stack(&mut marks, |hz| left + x.place(hz) * (right - left));
    let top = 24.0 + mark::height(rows);
    let frame = Frame { start: 0.0, left, top, right, bottom: top + HEIGHT, x, y };
    let svg = picture((WIDTH, frame.bottom + 36.0), Dashes::None, |canvas| {
        let keys = [
            (Key::Line(Stroke(MEASURED, 1.2)), "envelope"),
            (Key::Line(MULTIPLE), "lines and their multiples"),
            (Key::Line(SIDE_BAND), "side bands"),
        ];
        canvas.legend(left, 0.0, &keys)?;
        frame.axes(canvas, true)?;
        let mut upright = |hz: f64, stroke: Stroke| {
            let x = frame.at(&(hz, 0.0)).0;
            if frame.x.holds(hz) { canvas.line(&[(x, frame.bottom), (x, frame.top)], stroke) } else { Ok(()) }
        };
        for hz in &envelope.side_bands_hz {
            upright(*hz, SIDE_BAND)?;
        }
        for line in envelope.lines.iter().filter(|line| line.order > 0.0) {
            MULTIPLES.into_iter().try_for_each(|k| upright(k * line.hz, MULTIPLE))?;
        }
        mark::lines(canvas, &frame, &marks)?;
        mark::names(canvas, &frame, &marks)?;
        frame.curve(canvas, &peaks(&points, budget.spectrum()), Stroke(MEASURED, 1.2))?;
        frame.note_if_empty(canvas, &[&points])
    })?;
    let [low, high] = envelope.band_hz;
    Ok(Picture {
        title: format!("Envelope spectrum of {}", envelope.name),
        note: format!(
            "Squared envelope of {low:.0} to {high:.0} Hz: {}. Amplitude over the band's mean square: 1 swells from \
             nothing to twice the mean. Side bands: inner race by the shaft's turns, twice the spin by the cage's.",
            envelope.reason
        ),
        svg,
    })
}
