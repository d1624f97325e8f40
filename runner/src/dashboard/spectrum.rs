//! The spectrum of one probe over the last samples, with the lines of shaft and bearings.

use super::{MEASURED, Machine, QUIET, empty, panel};
use crate::live::view::View;
use ballrace_twin::spectrum::amplitudes;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Line as Stroke};

/// Orders that are shown at most: what lies above is noise on the scale of a terminal.
const ORDERS: f64 = 16.0;

pub(super) fn draw(frame: &mut Frame, area: Rect, machine: &Machine, view: &View, probe: usize) {
    let name = machine.probes.get(probe).map_or("", String::as_str);
    let block = panel(format!(" Spectrum {name}, um peak "));
    let Some((amplitudes, bin)) = spectrum(view, probe) else { return empty(frame, area, block, "no samples yet") };
    let turn = view.glance.lines.first().map_or(50.0, |line| line.hz);
    let last = (ORDERS * turn).clamp(4.0 * bin, 0.5 * view.glance.rate_hz);
    let shown: Vec<(f64, f64)> =
        amplitudes.iter().enumerate().skip(2).map(|(i, a)| (i as f64 * bin, *a)).take_while(|p| p.0 <= last).collect();
    let highest = shown.iter().map(|p| p.1).fold(1e-9, f64::max) * 1.15;
    let lines: Vec<(f64, String)> =
        view.glance.lines.iter().filter(|l| l.hz > 0.0 && l.hz < last).map(|l| (l.hz, l.label.clone())).collect();
    let rows = usize::from(area.height.saturating_sub(2).max(1));
    let canvas = Canvas::default()
        .block(block.title_bottom(Line::from(format!(" to {highest:.2} um, 0 to {last:.0} Hz ")).right_aligned()))
        .marker(Marker::Braille)
        .x_bounds([0.0, last])
        .y_bounds([0.0, highest])
        .paint(|context| {
            for (hz, _) in &lines {
                context.draw(&Stroke { x1: *hz, y1: 0.0, x2: *hz, y2: highest, color: QUIET });
            }
            context.layer();
            for (hz, amplitude) in &shown {
                context.draw(&Stroke { x1: *hz, y1: 0.0, x2: *hz, y2: *amplitude, color: MEASURED });
            }
            // Each name one row below the last, so that none covers another.
            for (i, (hz, label)) in lines.iter().enumerate() {
                let y = highest * (1.0 - ((i % rows) as f64 + 0.5) / rows as f64);
                context.print(*hz, y, Span::styled(label.clone(), Style::new()));
            }
        });
    frame.render_widget(canvas, area);
}

/// Amplitudes (um, zero to peak) of the last samples under a Hann window, and Hz from one to the next.
fn spectrum(view: &View, probe: usize) -> Option<(Vec<f64>, f64)> {
    let samples = &view.glance.samples;
    let length = 1 << samples.len().checked_ilog2().filter(|n| *n >= 6)?;
    let values: Vec<f64> = samples.iter().rev().take(length).filter_map(|s| s.measured.get(probe).copied()).collect();
    if values.len() != length || values.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let micrometres = amplitudes(&values).iter().map(|metres| metres * 1e6).collect();
    Some((micrometres, view.glance.rate_hz / length as f64))
}
