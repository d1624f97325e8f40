//! The findings of the last diagnosis; at the end of a run, those of the whole with the verdict.

use super::{ALARM, QUIET, empty, panel};
use crate::live::view::View;
use ballrace_report as report;
use ballrace_twin::printable;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let findings = view.conclusion.as_ref().map_or(&view.glance.findings, |conclusion| &conclusion.findings);
    if findings.is_empty() && view.conclusion.is_none() {
        return empty(frame, area, panel(" Findings ".to_owned()), "no fault is found so far");
    }
    let mut lines = vec![];
    for finding in findings {
        let [head, facts] = report::finding(finding);
        let strong = Style::new().fg(ALARM).add_modifier(Modifier::BOLD);
        lines.push(Line::styled(printable::lines(&head).into_owned(), strong));
        lines.push(Line::raw(printable::lines(&facts).into_owned()));
    }
    if let Some(conclusion) = &view.conclusion {
        lines
            .push(Line::from(Span::styled(printable::lines(&conclusion.verdict).into_owned(), Style::new().fg(QUIET))));
    }
    let block = panel(format!(" Findings, {} ", findings.len()));
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }).block(block), area);
}
