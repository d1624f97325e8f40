//! The verdict and the findings at the end of a run.

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
    let Some(conclusion) = &view.conclusion else {
        return empty(frame, area, panel(" Findings ".to_owned()), "the diagnosis is made at the end of the run");
    };
    let mut lines = vec![];
    for finding in &conclusion.findings {
        let [head, facts] = report::finding(finding);
        let strong = Style::new().fg(ALARM).add_modifier(Modifier::BOLD);
        lines.push(Line::styled(printable::lines(&head).into_owned(), strong));
        lines.push(Line::raw(printable::lines(&facts).into_owned()));
    }
    lines.push(Line::from(Span::styled(printable::lines(&conclusion.verdict).into_owned(), Style::new().fg(QUIET))));
    let block = panel(format!(" Findings, {} ", conclusion.findings.len()));
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }).block(block), area);
}
