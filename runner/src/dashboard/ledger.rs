//! The ledger of deadlines and of the source, and the list of events.

use super::{ALARM, QUIET, panel};
use crate::live::view::View;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let us = |ns: u64| format!("{:.0}", ns as f64 * 1e-3);
    let source = &view.source;
    let counted = |what: &str, count: u64| {
        let style = if count > 0 { Style::new().fg(ALARM) } else { Style::new() };
        Span::styled(format!("{what} {count}  "), style)
    };
    let lines = vec![
        Line::from(vec![
            Span::raw(format!("late us {} / {}  ", us(view.lateness.p50_ns), us(view.lateness.max_ns))),
            Span::raw(format!("work us {}", us(view.compute.p99_ns))),
        ]),
        Line::from(vec![
            counted("missed", view.misses),
            counted("lost", source.lost_frames),
            counted("repeated", source.repeated_frames),
        ]),
        Line::from(vec![
            counted("dropped", source.dropped_rows),
            counted("malformed", source.malformed_frames),
            Span::raw(view.idle_percent.map_or_else(String::new, |idle| format!("idle {idle:.0} %"))),
        ]),
    ];
    frame.render_widget(Paragraph::new(lines).block(panel(" Deadlines ".to_owned())), area);
}

pub(super) fn events(frame: &mut Frame, area: Rect, view: &View) {
    let block = panel(format!(" Events, {} ", view.events.len()));
    let lines: Vec<Line> = view
        .events
        .iter()
        .rev()
        .map(|event| {
            let style = if event.kind == "limit-crossed" { Style::new().fg(ALARM) } else { Style::new() };
            let clock = event.at.get(11..19).unwrap_or_default().to_owned();
            Line::from(vec![
                Span::styled(clock, Style::new().fg(QUIET)),
                Span::styled(format!(" {}", event.sentence), style),
            ])
        })
        .collect();
    let list = if lines.is_empty() { Paragraph::new("none") } else { Paragraph::new(lines) };
    frame.render_widget(list.wrap(Wrap { trim: true }).block(block), area);
}
