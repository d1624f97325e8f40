//! The load on every element of one bearing, around the ring.

use super::{MEASURED, QUIET, empty, panel};
use crate::live::view::View;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::canvas::{Canvas, Circle, Line};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View, bearing: usize) {
    let Some((name, loads)) = view.glance.loads.get(bearing).filter(|(_, loads)| !loads.is_empty()) else {
        return empty(frame, area, panel(" Loads ".to_owned()), "no samples yet");
    };
    let largest = loads.iter().map(|l| l.1).fold(0.0_f64, f64::max);
    let block = panel(format!(" Loads {name}, up to {largest:.1} N "));
    let (across, down) =
        (2.0 * f64::from(area.width.saturating_sub(2).max(1)), 4.0 * f64::from(area.height.saturating_sub(2).max(1)));
    let least = across.min(down);
    let reach = [1.7 * across / least, 1.7 * down / least];
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds([-reach[0], reach[0]])
        .y_bounds([-reach[1], reach[1]])
        .paint(|context| {
            context.draw(&Circle { x: 0.0, y: 0.0, radius: 0.6, color: QUIET });
            for &(azimuth, load) in loads {
                let (sin, cos) = azimuth.sin_cos();
                let end = 0.6 + load / largest.max(1e-9);
                context.draw(&Line { x1: 0.6 * cos, y1: 0.6 * sin, x2: end * cos, y2: end * sin, color: MEASURED });
            }
            context.layer();
            context.print(reach[0] * 0.88, 0.0, Span::styled("X", Style::new().fg(QUIET)));
            context.print(0.0, reach[1] * 0.95, Span::styled("Y", Style::new().fg(QUIET)));
        });
    frame.render_widget(canvas, area);
}
