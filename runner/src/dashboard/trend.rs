//! An indicator of one probe over the last minutes, with its limit.

use super::{ALARM, Choice, MEASURED, Machine, QUIET, empty, panel};
use crate::live::view::View;
use ballrace_twin::replay::second::ProbeSecond;
use ballrace_twin::scene::{Allowed, Indicator};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::{Axis, Chart, Dataset, GraphType};

type Figure = fn(&ProbeSecond) -> f64;

/// Name, unit, value, and the indicator of a limit that is drawn with it.
pub(super) const INDICATORS: [(&str, &str, Figure, Option<Indicator>); 7] = [
    ("peak-to-peak", "um pp", |p| p.peak_to_peak_um, Some(Indicator::PeakToPeak)),
    ("rms", "um rms", |p| p.rms_um, Some(Indicator::Rms)),
    ("1X", "um peak", |p| p.one_x_um, Some(Indicator::OneX)),
    ("residual", "um rms", |p| p.residual_rms_um, Some(Indicator::Residual)),
    ("crest factor", "", |p| p.crest_factor, Some(Indicator::CrestFactor)),
    ("kurtosis", "", |p| p.kurtosis, Some(Indicator::Kurtosis)),
    ("mean position", "um", |p| p.mean_um, None),
];

pub(super) fn draw(frame: &mut Frame, area: Rect, machine: &Machine, view: &View, choice: Choice) {
    let (name, unit, figure, indicator) = INDICATORS[choice.indicator % INDICATORS.len()];
    let probe = machine.probes.get(choice.probe).map_or("", String::as_str);
    let block = panel(format!(" {probe} {name}{}{unit} ", if unit.is_empty() { "" } else { ", " }));
    let value = |p: &ProbeSecond| (p.name == probe).then(|| figure(p));
    let points: Vec<(f64, f64)> =
        view.seconds.iter().filter_map(|s| Some((s.time_s, s.probes.iter().find_map(value)?))).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return empty(frame, area, block, "no second yet");
    };
    let limit = limit(machine, probe, indicator);
    let values = points.iter().map(|p| p.1).chain(limit);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let room = (0.1 * (high - low)).max(1e-3 * high.abs()).max(1e-6);
    let line = limit.map(|limit| [(first.0, limit), (last.0, limit)]);
    let mut sets = Vec::new();
    if let Some(line) = &line {
        sets.push(set(line).style(Style::new().fg(ALARM)));
    }
    sets.push(set(&points).style(Style::new().fg(MEASURED)));
    let quiet = Style::new().fg(QUIET);
    let label = |text: String| Span::styled(text, quiet);
    let x = Axis::default()
        .bounds([first.0, last.0.max(first.0 + 1.0)])
        .style(quiet)
        .labels([label(format!("{:.0} s", first.0)), label(format!("{:.0} s", last.0))]);
    let y = Axis::default()
        .bounds([low - room, high + room])
        .style(quiet)
        .labels([label(format!("{:.3}", low - room)), label(format!("{:.3}", high + room))]);
    frame.render_widget(Chart::new(sets).block(block).x_axis(x).y_axis(y), area);
}

fn set(points: &[(f64, f64)]) -> Dataset<'_> {
    Dataset::default().marker(Marker::Braille).graph_type(GraphType::Line).data(points)
}

/// The scene's own limit, in the indicator's unit. What is allowed over a baseline is judged, but has no line here.
fn limit(machine: &Machine, probe: &str, indicator: Option<Indicator>) -> Option<f64> {
    let indicator = indicator?;
    let of = |l: &&ballrace_twin::scene::Limit| {
        l.indicator == indicator && l.probe.as_deref().is_none_or(|name| name == probe)
    };
    let Allowed::Most(most) = machine.limits.iter().find(of)?.allowed else { return None };
    let (_, is_length) = indicator.name();
    Some(if is_length { most * 1e6 } else { most })
}
