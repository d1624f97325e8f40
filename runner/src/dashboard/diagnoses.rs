//! Faults found so far; at the end of a run, the faults of the whole run and the verdict.

use super::{ALARM, MUTED, draw_empty, panel_block};
use crate::live::view::View;
use ballrace_report as report;
use ballrace_twin::printable;
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Paragraph, Wrap};

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let diagnoses = view.conclusion.as_ref().map_or(&view.diagnoses, |conclusion| &conclusion.diagnoses);
    if diagnoses.is_empty() && view.conclusion.is_none() {
        return draw_empty(frame, area, panel_block(" 6 Diagnoses ".to_owned()), "no fault found so far");
    }
    let mut lines = vec![];
    for diagnosis in diagnoses {
        let [title, details] = report::diagnosis(diagnosis);
        let emphasis = Style::new().fg(ALARM).add_modifier(Modifier::BOLD);
        lines.push(Line::styled(printable::lines(&title).into_owned(), emphasis));
        lines.push(Line::raw(printable::lines(&details).into_owned()));
    }
    if let Some(conclusion) = &view.conclusion {
        lines
            .push(Line::from(Span::styled(printable::lines(&conclusion.verdict).into_owned(), Style::new().fg(MUTED))));
    }
    let block = panel_block(format!(" 6 Diagnoses, {} ", diagnoses.len()));
    frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }).block(block), area);
}
