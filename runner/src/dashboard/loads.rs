//! Load on every rolling element of one bearing, drawn around the ring.

use super::{MEASURED, MUTED, draw_empty, panel_block};
use crate::live::view::View;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::canvas::{Canvas, Circle, Line};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View, bearing: usize) {
    let Some((name, loads)) = view.snapshot.loads.get(bearing).filter(|(_, loads)| !loads.is_empty()) else {
        return draw_empty(frame, area, panel_block(" 4 Loads ".to_owned()), "no samples yet");
    };
    let largest = loads.iter().map(|l| l.1).fold(0.0_f64, f64::max);
    let block = panel_block(format!(" 4 Loads {name}, up to {largest:.1} N "));
    let (width, height) =
        (2.0 * f64::from(area.width.saturating_sub(2).max(1)), 4.0 * f64::from(area.height.saturating_sub(2).max(1)));
    let shorter = width.min(height);
    let extent = [1.7 * width / shorter, 1.7 * height / shorter];
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds([-extent[0], extent[0]])
        .y_bounds([-extent[1], extent[1]])
        .paint(|context| {
            context.draw(&Circle { x: 0.0, y: 0.0, radius: 0.6, color: MUTED });
            for &(azimuth, load) in loads {
                let (sin, cos) = azimuth.sin_cos();
                let end = 0.6 + load / largest.max(1e-9);
                context.draw(&Line { x1: 0.6 * cos, y1: 0.6 * sin, x2: end * cos, y2: end * sin, color: MEASURED });
            }
            context.layer();
            context.print(extent[0] * 0.88, 0.0, Span::styled("X", Style::new().fg(MUTED)));
            context.print(0.0, extent[1] * 0.95, Span::styled("Y", Style::new().fg(MUTED)));
        });
    frame.render_widget(canvas, area);
}
