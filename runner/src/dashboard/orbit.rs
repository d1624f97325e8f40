//! Orbits of all measurement planes: measured and computed motion on equal scales, with a dot at each keyphasor pulse.

use super::{MEASURED, TWIN, draw_empty, panel_block};
use crate::live::view::View;
use ballrace_twin::probes::Plane;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style};
use ratatui::symbols::Marker;
use ratatui::text::{Line, Span};
use ratatui::widgets::canvas::{Canvas, Points};

/// Number of revolutions that an orbit shows.
const REVOLUTIONS: usize = 3;
/// Micrometres per metre.
const UM: f64 = 1e6;
/// Samples shown without keyphasor pulses.
const SAMPLES: usize = 512;

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let planes = &view.snapshot.planes;
    if planes.is_empty() || view.snapshot.samples.is_empty() {
        return draw_empty(frame, area, panel_block(" 1 Orbits ".to_owned()), "no samples yet");
    }
    let width = Constraint::Ratio(1, planes.len() as u32);
    let areas = Layout::horizontal(vec![width; planes.len()]).split(area);
    for ((name, plane), area) in planes.iter().zip(areas.iter()) {
        draw_orbit(frame, *area, name, &Curves::new(view, plane));
    }
}

/// Orbit of one measurement plane, um.
struct Curves {
    measured: Vec<(f64, f64)>,
    twin: Vec<(f64, f64)>,
    /// Positions at the keyphasor pulses.
    marks: Vec<(f64, f64)>,
    /// Half of the larger extent of the measured orbit, with a margin of 10 %.
    half_extent: f64,
    centre: (f64, f64),
}

impl Curves {
    fn new(view: &View, plane: &Plane) -> Self {
        let samples = &view.snapshot.samples;
        let pulses = samples.iter().enumerate().rev().filter(|(_, s)| s.passed).map(|(i, _)| i);
        let from = pulses.take(REVOLUTIONS).last().unwrap_or(samples.len().saturating_sub(SAMPLES));
        let shown = samples.get(from..).unwrap_or_default();
        let um = |readings: &[f64]| {
            let (x, y) = plane.xy(readings);
            (x * UM, y * UM)
        };
        let measured: Vec<_> =
            shown.iter().map(|s| um(&s.measured)).filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        let marks = shown.iter().filter(|s| s.passed).map(|s| um(&s.measured)).collect();
        let twin = shown.iter().map(|s| um(&s.twin)).collect();
        let range = |coordinate: fn(&(f64, f64)) -> f64| {
            let values = measured.iter().map(coordinate);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let ((x0, x1), (y0, y1)) = (range(|p| p.0), range(|p| p.1));
        let half_extent = (0.55 * (x1 - x0).max(y1 - y0)).clamp(1e-6, 1e9);
        Self { measured, twin, marks, half_extent, centre: (0.5 * (x0 + x1), 0.5 * (y0 + y1)) }
    }
}

fn draw_orbit(frame: &mut Frame, area: Rect, name: &str, curves: &Curves) {
    let size = format!(" {:.2} um pp ", curves.half_extent / 0.55);
    let block = panel_block(format!(" 1 {name} ")).title_bottom(Line::from(size).right_aligned());
    // A cell with a braille character has two columns and four rows of dots with about equal spacing.
    let (width, height) =
        (2.0 * f64::from(area.width.saturating_sub(2).max(1)), 4.0 * f64::from(area.height.saturating_sub(2).max(1)));
    let shorter = width.min(height);
    let (half_x, half_y) = (curves.half_extent * width / shorter, curves.half_extent * height / shorter);
    let (x, y) = if curves.centre.0.is_finite() && curves.centre.1.is_finite() { curves.centre } else { (0.0, 0.0) };
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
