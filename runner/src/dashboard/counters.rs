//! Counters of deadlines and of the source, and the list of events.

use super::{ALARM, MUTED, panel_block};
use crate::live::view::View;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

/// Returns the counters as two lines; counters above 0 are highlighted.
pub(super) fn lines(view: &View) -> [Line<'static>; 2] {
    let milliseconds = |ns: u64| format!("{:.1}", ns as f64 * 1e-6);
    let source = &view.source;
    let counter = |label: &str, count: u64| {
        let style = if count > 0 { Style::new().fg(ALARM) } else { Style::new() };
        Span::styled(format!("{label} {count}  "), style)
    };
    [
        Line::from(vec![
            counter("deadlines missed", view.pacing.deadline_misses),
            Span::raw(format!("late {} ms  ", milliseconds(view.pacing.lateness.max_ns))),
            Span::raw(view.pacing.idle_percent.map_or_else(String::new, |idle| format!("idle {idle:.0} %"))),
        ]),
        Line::from(vec![
            counter("lost", source.lost_frames),
            counter("repeated", source.repeated_frames),
            counter("dropped", source.dropped_rows),
            counter("malformed", source.malformed_frames),
        ]),
    ]
}

pub(super) fn draw_events(frame: &mut Frame, area: Rect, view: &View) {
    let block = panel_block(format!(" 5 Events, {}, times in UTC ", view.events.len()));
    let lines: Vec<Line> = view
        .events
        .iter()
        .rev()
        .map(|event| {
            let style = if event.kind == "limit-crossed" { Style::new().fg(ALARM) } else { Style::new() };
            let clock = event.at.get(11..19).unwrap_or_default().to_owned();
            Line::from(vec![
                Span::styled(clock, Style::new().fg(MUTED)),
                Span::styled(format!(" {}", event.sentence), style),
            ])
        })
        .collect();
    let list = if lines.is_empty() { Paragraph::new("none") } else { Paragraph::new(lines) };
    frame.render_widget(list.wrap(Wrap { trim: true }).block(block), area);
}
