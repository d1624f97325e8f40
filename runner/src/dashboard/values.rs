//! Values of the probes against their limits, and the counters of deadlines and of the source.

use super::{ALARM, counters, panel_block};
use crate::live::view::View;
use ballrace_twin::printable;
use ballrace_twin::replay::limits::LimitStatus;
use ratatui::Frame;
use ratatui::layout::{Constraint, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::Line;
use ratatui::widgets::{Cell, Paragraph, Row, Table};

/// Share of a limit above which a value is highlighted.
const NEAR: f64 = 0.8;

pub(super) fn draw(frame: &mut Frame, area: Rect, view: &View) {
    let block = panel_block(format!(" 7 Values, {} limits ", view.limits.len()));
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let counters = counters::lines(view);
    let counter_rows = (counters.len() as u16).min(inner.height);
    let table_rows = inner.height - counter_rows;
    let table = Rect { height: table_rows, ..inner };
    let below = Rect { y: inner.y + table_rows, height: counter_rows, ..inner };
    frame.render_widget(Paragraph::new(counters.to_vec()), below);
    if table_rows == 0 {
        return;
    }
    if view.limits.is_empty() {
        let values = view.seconds.back().map(|second| {
            let value =
                |p: &ballrace_twin::replay::second::ProbeSecond| format!("{} {:.2} um pp", p.name, p.peak_to_peak_um);
            second.probes.iter().map(value).collect::<Vec<_>>().join("  ")
        });
        let text = values.unwrap_or_else(|| "no complete second yet".to_owned());
        return frame.render_widget(Paragraph::new(printable::lines(&text).into_owned()), table);
    }
    let mut limits: Vec<&LimitStatus> = view.limits.iter().collect();
    // The table is cut off at its lower end: the values closest to their limits come first.
    limits.sort_by(|a, b| share(b).total_cmp(&share(a)));
    let widths = [
        Constraint::Fill(2),
        Constraint::Fill(2),
        Constraint::Length(10),
        Constraint::Length(10),
        Constraint::Length(6),
    ];
    let mut rows = limits.into_iter().map(row).collect::<Vec<_>>();
    if table_rows > 1 {
        let bold = Style::new().add_modifier(Modifier::BOLD);
        rows.insert(
            0,
            Row::new(["probe", "indicator", "value", "limit", ""].map(|text| Cell::from(Line::styled(text, bold)))),
        );
    }
    frame.render_widget(Table::new(rows, widths), table);
}

/// Returns the value over its limit; 0 without a value.
fn share(limit: &LimitStatus) -> f64 {
    limit.value.map_or(0.0, |value| value / limit.limit)
}

fn row(limit: &LimitStatus) -> Row<'static> {
    let share = share(limit);
    let style = if limit.exceeded_since_s.is_some() || share > 1.0 {
        Style::new().fg(ALARM).add_modifier(Modifier::BOLD)
    } else if share > NEAR {
        Style::new().add_modifier(Modifier::BOLD)
    } else {
        Style::new()
    };
    let number = |value: f64| format!("{value:.2} {}", limit.unit);
    let indicator = match &limit.bearing {
        Some(bearing) => format!("{} of {bearing}", limit.indicator),
        None => limit.indicator.to_owned(),
    };
    let cells = [
        limit.probe.clone(),
        indicator,
        limit.value.map_or_else(|| "-".to_owned(), number),
        number(limit.limit),
        limit.value.map_or_else(String::new, |_| format!("{:.0} %", 100.0 * share)),
    ];
    Row::new(cells.map(|text| Cell::from(printable::lines(&text).into_owned()))).style(style)
}
