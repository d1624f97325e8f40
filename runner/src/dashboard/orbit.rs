//! Orbits of all planes: machine and twin on equal scales, a dot where the keyphasor passes.

use super::{MEASURED, TWIN, empty, panel};
use crate::live::view::View;
use ballrace_twin::probes::Plane;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Points};

/// Passages of the keyphasor that an orbit reaches back.
const TURNS: usize = 3;
const UM: f64 = 1e6;

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let planes = &view.glance.planes;
    if planes.is_empty() || view.glance.samples.is_empty() {
        return empty(frame, area, panel(" Orbits ".to_owned()), "no samples yet");
    }
    let share = Constraint::Ratio(1, planes.len() as u32);
    let places = Layout::horizontal(vec![share; planes.len()]).split(area);
    for ((name, plane), place) in planes.iter().zip(places.iter()) {
        one(frame, *place, name, &Curves::new(view, plane));
    }
}

struct Curves {
    measured: Vec<(f64, f64)>,
    twin: Vec<(f64, f64)>,
    marks: Vec<(f64, f64)>,
    /// Half of the larger extent, and the middle.
    reach: f64,
    middle: (f64, f64),
}

impl Curves {
    fn new(view: &View, plane: &Plane) -> Self {
        let samples = &view.glance.samples;
        let passages = samples.iter().enumerate().rev().filter(|(_, s)| s.passed).map(|(i, _)| i);
        let from = passages.take(TURNS).last().unwrap_or(samples.len().saturating_sub(512));
        let shown = samples.get(from..).unwrap_or_default();
        let um = |readings: &[f64]| {
            let (x, y) = plane.xy(readings);
            (x * UM, y * UM)
        };
        let measured: Vec<_> =
            shown.iter().map(|s| um(&s.measured)).filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        let marks = shown.iter().filter(|s| s.passed).map(|s| um(&s.measured)).collect();
        let twin = shown.iter().map(|s| um(&s.twin)).collect();
        let extent = |of: fn(&(f64, f64)) -> f64| {
            let values = measured.iter().map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let ((x0, x1), (y0, y1)) = (extent(|p| p.0), extent(|p| p.1));
        let reach = (0.55 * (x1 - x0).max(y1 - y0)).clamp(1e-6, 1e9);
        Self { measured, twin, marks, reach, middle: (0.5 * (x0 + x1), 0.5 * (y0 + y1)) }
    }
}

fn one(frame: &mut Frame, area: Rect, name: &str, curves: &Curves) {
    let size = format!(" {:.2} um pp ", curves.reach / 0.55);
    let block = panel(format!(" {name} ")).title_bottom(Line::from(size).right_aligned());
    // A braille cell has two columns and four rows of about square dots.
    let (across, down) =
        (2.0 * f64::from(area.width.saturating_sub(2).max(1)), 4.0 * f64::from(area.height.saturating_sub(2).max(1)));
    let least = across.min(down);
    let (half_x, half_y) = (curves.reach * across / least, curves.reach * down / least);
    let (x, y) = if curves.middle.0.is_finite() && curves.middle.1.is_finite() { curves.middle } else { (0.0, 0.0) };
    let canvas = Canvas::default()
        .block(block)
        .marker(Marker::Braille)
        .x_bounds([x - half_x, x + half_x])
        .y_bounds([y - half_y, y + half_y])
        .paint(|context| {
            context.draw(&Points { coords: &curves.twin, color: TWIN });
            context.draw(&Points { coords: &curves.measured, color: MEASURED });
            context.layer();
            for &(x, y) in &curves.marks {
                context.print(x, y, Span::styled("\u{25cf}", Style::new().fg(Color::White)));
            }
        });
    frame.render_widget(canvas, area);
}
