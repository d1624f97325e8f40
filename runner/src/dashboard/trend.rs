//! Trend of one indicator of one probe, with its limit.

use super::{ALARM, DisplaySettings, MEASURED, MUTED, RunInfo, draw_empty, panel_block};
use crate::live::view::View;
use ballrace_twin::replay::outcome::NumericField;
use ballrace_twin::replay::second::ProbeSecond;
use ballrace_twin::scene::{Allowed, Indicator};
use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::symbols::Marker;
use ratatui::text::Span;
use ratatui::widgets::{Axis, Chart, Dataset, GraphType};

/// Keys of the indicators, and the indicator of the limit that is drawn with each.
pub(super) const INDICATORS: [(&str, Option<Indicator>); 7] = [
    ("peak_to_peak_um", Some(Indicator::PeakToPeak)),
    ("rms_um", Some(Indicator::Rms)),
    ("one_x_um", Some(Indicator::OneX)),
    ("residual_rms_um", Some(Indicator::Residual)),
    ("crest_factor", Some(Indicator::CrestFactor)),
    ("kurtosis", Some(Indicator::Kurtosis)),
    ("mean_um", None),
];

pub(super) fn draw(frame: &mut Frame, area: Rect, info: &RunInfo, view: &View, settings: DisplaySettings) {
    let (key, indicator) = INDICATORS[settings.indicator % INDICATORS.len()];
    let Some(field) = ProbeSecond::FIELDS.into_iter().find(|field| field.key == key) else { return };
    let NumericField { name, unit, .. } = field;
    let probe = info.probes.get(settings.probe).map_or("", String::as_str);
    let block = panel_block(format!(" 3 {probe} {name}{}{unit} ", if unit.is_empty() { "" } else { ", " }));
    let value = |p: &ProbeSecond| (p.name == probe).then(|| (field.value)(p));
    let points: Vec<(f64, f64)> =
        view.seconds.iter().filter_map(|s| Some((s.time_s, s.probes.iter().find_map(value)?))).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return draw_empty(frame, area, block, "no complete second yet");
    };
    let limit = limit(info, probe, indicator);
    let values = points.iter().map(|p| p.1).chain(limit);
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    let margin = (0.1 * (high - low)).max(1e-3 * high.abs()).max(1e-6);
    let line = limit.map(|limit| [(first.0, limit), (last.0, limit)]);
    let mut datasets = Vec::new();
    if let Some(line) = &line {
        datasets.push(dataset(line).style(Style::new().fg(ALARM)));
    }
    datasets.push(dataset(&points).style(Style::new().fg(MEASURED)));
    let muted = Style::new().fg(MUTED);
    let label = |text: String| Span::styled(text, muted);
    let x = Axis::default()
        .bounds([first.0, last.0.max(first.0 + 1.0)])
        .style(muted)
        .labels([label(format!("{:.0} s", first.0)), label(format!("{:.0} s", last.0))]);
    let y = Axis::default()
        .bounds([low - margin, high + margin])
        .style(muted)
        .labels([label(format!("{:.3}", low - margin)), label(format!("{:.3}", high + margin))]);
    frame.render_widget(Chart::new(datasets).block(block).x_axis(x).y_axis(y), area);
}

fn dataset(points: &[(f64, f64)]) -> Dataset<'_> {
    Dataset::default().marker(Marker::Braille).graph_type(GraphType::Line).data(points)
}

/// Returns the absolute limit of the scene, in the unit of the indicator. A limit relative to a baseline is not drawn.
fn limit(info: &RunInfo, probe: &str, indicator: Option<Indicator>) -> Option<f64> {
    let indicator = indicator?;
    let applies = |l: &&ballrace_twin::scene::Limit| {
        l.indicator == indicator && l.probe.as_deref().is_none_or(|name| name == probe)
    };
    let Allowed::Most(most) = info.limits.iter().find(applies)?.allowed else { return None };
    Some(most * indicator.unit().1)
}
