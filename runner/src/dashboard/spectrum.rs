//! Spectrum of one probe over the latest samples, with the characteristic frequencies of shaft and bearings.

use super::{MEASURED, MUTED, RunInfo, draw_empty, panel_block};
use crate::live::view::View;
use ballrace_twin::spectrum::amplitudes;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Line as Stroke};

/// Highest order shown; higher orders are not visible at the resolution of a terminal.
const MAX_ORDER: f64 = 16.0;

pub(super) fn draw(frame: &mut Frame, area: Rect, info: &RunInfo, view: &View, probe: usize) {
    let name = info.probes.get(probe).map_or("", String::as_str);
    let block = panel_block(format!(" 2 Spectrum {name}, um peak "));
    let Some((amplitudes, bin)) = spectrum(view, probe) else {
        return draw_empty(frame, area, block, "no samples yet");
    };
    let rotation_hz = view.snapshot.lines.first().map_or(50.0, |line| line.hz);
    let last = (MAX_ORDER * rotation_hz).clamp(4.0 * bin, 0.5 * view.snapshot.rate_hz);
    let shown: Vec<(f64, f64)> =
        amplitudes.iter().enumerate().skip(2).map(|(i, a)| (i as f64 * bin, *a)).take_while(|p| p.0 <= last).collect();
    let highest = shown.iter().map(|p| p.1).fold(1e-9, f64::max) * 1.15;
    let lines: Vec<(f64, String)> =
        view.snapshot.lines.iter().filter(|l| l.hz > 0.0 && l.hz < last).map(|l| (l.hz, l.label.clone())).collect();
    let rows = usize::from(area.height.saturating_sub(2).max(1));
    let canvas = Canvas::default()
        .block(block.title_bottom(Line::from(format!(" to {highest:.2} um, 0 to {last:.0} Hz ")).right_aligned()))
        .marker(Marker::Braille)
        .x_bounds([0.0, last])
        .y_bounds([0.0, highest])
        .paint(|context| {
            for (hz, _) in &lines {
                context.draw(&Stroke { x1: *hz, y1: 0.0, x2: *hz, y2: highest, color: MUTED });
            }
            context.layer();
            for (hz, amplitude) in &shown {
                context.draw(&Stroke { x1: *hz, y1: 0.0, x2: *hz, y2: *amplitude, color: MEASURED });
            }
            // Each label is one row below the previous one, so that labels do not overlap.
            for (i, (hz, label)) in lines.iter().enumerate() {
                let y = highest * (1.0 - ((i % rows) as f64 + 0.5) / rows as f64);
                context.print(*hz, y, Span::styled(label.clone(), Style::new()));
            }
        });
    frame.render_widget(canvas, area);
}

/// Returns the amplitudes (um, zero to peak) of the latest samples with a Hann window, and the bin width, Hz.
fn spectrum(view: &View, probe: usize) -> Option<(Vec<f64>, f64)> {
    let samples = &view.snapshot.samples;
    let length = 1 << samples.len().checked_ilog2().filter(|n| *n >= 6)?;
    let values: Vec<f64> = samples.iter().rev().take(length).filter_map(|s| s.measured.get(probe).copied()).collect();
    if values.len() != length || values.iter().any(|x| !x.is_finite()) {
        return None;
    }
    let micrometres = amplitudes(&values).iter().map(|metres| metres * 1e6).collect();
    Some((micrometres, view.snapshot.rate_hz / length as f64))
}
