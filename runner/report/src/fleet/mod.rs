//! Reports of a fleet: the overview as one HTML page, the summary for the terminal, and the files of its folder.

mod folder;
mod page;
mod sparkline;
mod text;

pub use folder::{Folder, page_of};
pub use page::html;
pub use text::text;

use crate::number::alone;
use ballrace_twin::fleet::{IndicatorValue, Key, Row, State, Trend, current, worst_first};

/// Rows of a fleet with their trends and the links to their reports.
pub struct Fleet<'a> {
    /// Name of the table of machines.
    pub name: &'a str,
    /// All rows.
    pub rows: &'a [Row],
    /// Trends of their snapshots.
    pub trends: &'a [Trend],
    /// Returns the link to the report of a row; `None` without a report.
    pub link: &'a dyn Fn(&Key) -> Option<String>,
}

/// A machine of the overview.
struct Entry<'a> {
    /// Row with its present condition.
    row: &'a Row,
    /// All of its rows, latest first.
    history: Vec<&'a Row>,
    /// Trend that reaches its limit first, otherwise that of the indicator nearest to its limit.
    trend: Option<&'a Trend>,
}

impl<'a> Fleet<'a> {
    /// Returns the machines, worst first.
    fn entries(&self) -> Vec<Entry<'a>> {
        let mut rows: Vec<&Row> = self.rows.iter().collect();
        rows.sort_by(|a, b| {
            a.machine.cmp(&b.machine).then_with(|| b.time.cmp(&a.time)).then_with(|| worst_first(a, b))
        });
        let entry = |row: &'a Row| {
            let start = rows.partition_point(|one| one.machine < row.machine);
            let own = rows.get(start..).unwrap_or_default().iter().take_while(|one| one.machine == row.machine);
            Entry { row, history: own.copied().collect(), trend: self.trend(row) }
        };
        current(self.rows).into_iter().map(entry).collect()
    }

    fn trend(&self, row: &Row) -> Option<&'a Trend> {
        let start = self.trends.partition_point(|trend| trend.machine < row.machine);
        let own = self.trends.get(start..).unwrap_or_default().iter();
        let own: Vec<&Trend> = own.take_while(|trend| trend.machine == row.machine).collect();
        let worst = row.worst_indicator();
        let is_worst = |trend: &&&Trend| {
            let quantity = &trend.quantity;
            worst.is_some_and(|one| {
                one.name == quantity.name && one.probe == quantity.probe && one.bearing == quantity.bearing
            })
        };
        let crossing = own.iter().filter_map(|trend| Some((trend.crossing()?, *trend))).min_by_key(|(time, _)| *time);
        let size = || own.iter().find(|trend| trend.quantity.kind == "diagnosis");
        let growing = || own.iter().find(|trend| trend.slope_low > 0.0 && trend.quantity.name == "residual");
        crossing
            .map(|(_, trend)| trend)
            .or_else(|| own.iter().find(is_worst).copied())
            .or_else(|| size().or_else(growing).or(own.first()).copied())
    }

    /// Returns the number of machines in each state, worst first.
    fn counts(entries: &[Entry]) -> [(State, usize); 6] {
        State::ALL.map(|state| (state, entries.iter().filter(|entry| entry.row.state == state).count()))
    }
}

/// Returns the word of a state for readers.
const fn word(state: State) -> &'static str {
    match state {
        State::Limit => "limit crossed",
        State::Fault => "fault diagnosed",
        State::Implausible => "implausible",
        State::Error => "error",
        State::NotJudged => "no verdict",
        State::Normal => "normal",
    }
}

/// Returns value and limit of an indicator, such as `12.3 um, limit 10.0 um`.
fn against_limit(one: &IndicatorValue) -> String {
    let space = if one.unit.is_empty() { "" } else { " " };
    let with_unit = |value: f64| format!("{}{space}{}", alone(value), one.unit);
    let limit = one.limit.map(|limit| format!(", limit {}", with_unit(limit)));
    with_unit(one.value) + &limit.unwrap_or_default()
}

/// Returns when the limit was or will be crossed; empty without a crossing.
fn crossing(trend: &Trend) -> String {
    if let Some(time) = trend.crossed_on {
        return format!("crossed on {}", time.date());
    }
    trend.crosses_on.map_or_else(String::new, |crossing| {
        let [day, earliest] = [crossing.time, crossing.earliest].map(|time| time.date());
        let latest = crossing.latest.map_or_else(|| "an open end".to_owned(), |latest| latest.date());
        let interval = if earliest == latest { String::new() } else { format!(" ({earliest} to {latest})") };
        format!("expected on {day}{interval}")
    })
}

/// Returns the slope of a trend with its interval.
fn slope(trend: &Trend) -> String {
    let half = (trend.slope_high - trend.slope_low) / 2.0;
    let space = if trend.quantity.unit.is_empty() { "" } else { " " };
    let sign = if trend.slope_per_day > 0.0 { "+" } else { "" };
    format!("{sign}{} ± {}{space}{} a day", alone(trend.slope_per_day), alone(half), trend.quantity.unit)
}

/// Returns the verdict, or the error where there is none.
fn verdict(row: &Row) -> &str {
    row.error.as_deref().unwrap_or(&row.verdict)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_twin::fleet::trends;

    /// A growing machine, one with a text that is not harmless, and one with an error.
    fn rows() -> Vec<Row> {
        let row = |machine: &str, day: u32, value: f64| {
            let crossed = value > 1.0;
            let text = serde_json::json!({
                "machine": machine, "recording": format!("{day}.csv"), "time": format!("2026-03-{day:02}"),
                "state": if crossed { "limit" } else { "normal" }, "verdict": "The twin follows <b>the machine</b>.",
                "diagnoses": [], "tags": {"hall": "A & B"}, "error": null, "duration_s": 1.0, "mean_speed_rpm": 3000.0,
                "inputs": "", "indicators":
                    [{"name": "1X", "unit": "um", "probe": "DE_X", "value": value, "limit": 1.0, "crossed": crossed}]
            });
            serde_json::from_value::<Row>(text).unwrap()
        };
        let mut rows: Vec<Row> = (1..=5).map(|day| row("growing", day, 0.1 * f64::from(day))).collect();
        rows.extend((1..=5).map(|day| row("<script>alert(1)</script>", day, 0.3 * f64::from(day))));
        let mut broken = row("broken", 1, 0.5);
        (broken.state, broken.error) = (State::Error, Some("no file of this name".to_owned()));
        rows.push(broken);
        rows
    }

    fn rendered(link: &dyn Fn(&Key) -> Option<String>) -> (String, String) {
        let rows = rows();
        let trends = trends(&rows);
        let fleet = Fleet { name: "machines.csv", rows: &rows, trends: &trends, link };
        (html(&fleet).unwrap(), text(&fleet))
    }

    #[test]
    fn the_page_is_ranked_escaped_and_self_contained() {
        let (page, _) = rendered(&|key| Some(format!("reports/{}", key.recording)));
        for outside in ["http://", "https://", "<script", "<link", "<img", "url(", "@import", "<b>"] {
            assert!(!page.contains(outside), "{outside}");
        }
        let at = |text: &str| page.find(text).unwrap_or_else(|| unreachable!("{text} in {page}"));
        let body = at("<tbody");
        let place = |text: &str| body + page[body..].find(text).unwrap();
        assert!(place("&lt;script&gt;") < place("broken") && place("broken") < place("growing"));
        assert!(page.contains("crossed on 2026-03-04") && page.contains("expected on 2026-03-10"));
        assert_eq!(page.matches("<svg").count(), 2);
        assert!(page.contains("limit crossed") && page.contains("no file of this name"));
        assert!(page.contains("href=\"reports&#x2f;5.csv\""));
    }

    #[test]
    fn the_summary_counts_states_and_lists_the_worst() {
        let (_, text) = rendered(&|_| None);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].contains("3 machines") && lines[0].contains("11 recordings"), "{text}");
        assert!(text.contains("1 limit crossed, 1 error, 1 normal"), "{text}");
        let rank = |word: &str| lines.iter().position(|line| line.contains(word)).unwrap();
        assert!(rank("alert") < rank("broken"), "{text}");
    }
}
