//! Small curve of a trend.

use ballrace_twin::fleet::Trend;
use std::fmt::Write;

const WIDTH: f64 = 150.0;
const HEIGHT: f64 = 36.0;
const MARGIN: f64 = 4.0;
/// Largest limit over the largest value at which the limit is drawn; a farther one would flatten the curve.
const FARTHEST_LIMIT: f64 = 4.0;

/// Returns an SVG element with the values over time and, where it is near, the limit.
pub(super) fn svg(trend: &Trend) -> String {
    let Some(first) = trend.snapshots.first() else { return String::new() };
    let points: Vec<(f64, f64)> =
        trend.snapshots.iter().map(|one| (one.time.days_since(first.time), one.value)).collect();
    let extremes = |of: fn(&(f64, f64)) -> f64| {
        points.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (days, values) = (extremes(|p| p.0), extremes(|p| p.1));
    let limit = trend.limit.filter(|limit| *limit <= FARTHEST_LIMIT * values.1);
    let (low, high) = limit.map_or(values, |limit| (values.0.min(limit), values.1.max(limit)));
    let scale = |x: f64, (from, to): (f64, f64), size: f64| {
        let share = if to > from { (x - from) / (to - from) } else { 0.5 };
        MARGIN + share * (size - 2.0 * MARGIN)
    };
    let x = |day: f64| scale(day, days, WIDTH);
    let y = |value: f64| HEIGHT - scale(value, (low, high), HEIGHT);
    let mut svg = format!("<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"trend\">");
    if let Some(limit) = limit {
        let y = y(limit);
        let _ = write!(svg, "<path class=\"limit\" d=\"M{MARGIN} {y:.1}H{:.1}\"/>", WIDTH - MARGIN);
    }
    let curve: Vec<String> = points.iter().map(|(day, value)| format!("{:.1},{:.1}", x(*day), y(*value))).collect();
    let _ = write!(svg, "<polyline points=\"{}\"/>", curve.join(" "));
    for (point, snapshot) in points.iter().zip(&trend.snapshots) {
        let class = if snapshot.crossed { "beyond" } else { "within" };
        let _ = write!(svg, "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"2\"/>", x(point.0), y(point.1));
    }
    svg + "</svg>"
}
