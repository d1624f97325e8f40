//! Trends of indicators and sizes of diagnoses over the snapshots of a machine.

use super::regression::Line;
use super::row::Row;
use ballrace_recording::Time;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Quantity of a trend.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Quantity {
    /// `indicator`, or `diagnosis` for its size.
    pub kind: String,
    /// Name of the indicator or of the fault.
    pub name: String,
    /// Column of the probe.
    pub probe: Option<String>,
    /// Bearing.
    pub bearing: Option<String>,
    /// Unit of values and limit; empty for a number.
    pub unit: String,
}

impl Quantity {
    /// Returns the name with bearing and probe, such as `1X at DE_X` or `size of outer-race spall of DE`.
    #[must_use]
    pub fn label(&self) -> String {
        let size = if self.kind == "diagnosis" { "size of " } else { "" };
        let bearing = self.bearing.as_ref().map_or_else(String::new, |bearing| format!(" of {bearing}"));
        let probe = self.probe.as_ref().map_or_else(String::new, |probe| format!(" at {probe}"));
        format!("{size}{}{bearing}{probe}", self.name)
    }
}

/// Value of a quantity in one snapshot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Time of the recording.
    pub time: Time,
    /// Value.
    pub value: f64,
    /// True where the recording crossed the limit.
    pub crossed: bool,
}

/// Time at which a limit will be crossed, with its 90 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Crossing {
    /// Time at which the line reaches the limit.
    pub time: Time,
    /// Lower end of the interval, not before the last snapshot.
    pub earliest: Time,
    /// Upper end of the interval; `None` beyond the year 9999.
    pub latest: Option<Time>,
}

/// Trend of one quantity of one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trend {
    /// Name of the machine.
    pub machine: String,
    /// The quantity.
    pub quantity: Quantity,
    /// Limit of the last snapshot that has one.
    pub limit: Option<f64>,
    /// Snapshots in the order of their times.
    pub snapshots: Vec<Snapshot>,
    /// Slope of the line of ordinary least squares, per day.
    pub slope_per_day: f64,
    /// Lower end of its 90 % interval by Student's t.
    pub slope_low: f64,
    /// Upper end of the interval.
    pub slope_high: f64,
    /// Time of the first snapshot beyond the limit.
    pub crossed_on: Option<Time>,
    /// Time at which the line reaches a limit that no snapshot has crossed; `None` if the slope is not significantly above 0.
    pub crosses_on: Option<Crossing>,
}

impl Trend {
    /// Returns true where the slope differs from 0: its 90 % interval does not contain 0.
    #[must_use]
    pub fn is_significant(&self) -> bool {
        self.slope_low > 0.0 || self.slope_high < 0.0
    }

    /// Returns the time at which the limit was crossed or will be.
    #[must_use]
    pub fn crossing(&self) -> Option<Time> {
        self.crossed_on.or_else(|| self.crosses_on.map(|crossing| crossing.time))
    }
}

/// Values of one quantity and its last limit.
#[derive(Default)]
struct Series {
    snapshots: Vec<Snapshot>,
    limit: Option<(Time, f64)>,
}

/// Returns the trend of every quantity that at least three snapshots of a machine have, by machine and quantity.
///
/// A crossing is extrapolated only where the slope is above 0 at a significance of 5 % (one-sided, Student's t with `n - 2` degrees of
/// freedom): otherwise the data agree with a quantity that never reaches the limit, and the interval of the crossing has no
/// upper end. The interval is Fieller's. Rows without a time are ignored.
#[must_use]
pub fn trends<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Vec<Trend> {
    let mut all: BTreeMap<(&str, Quantity), Series> = BTreeMap::new();
    for row in rows {
        let Some(time) = row.time else { continue };
        for (quantity, value, limit, crossed) in quantities(row) {
            let series = all.entry((&row.machine, quantity)).or_default();
            series.snapshots.push(Snapshot { time, value, crossed });
            if let Some(limit) = limit.filter(|_| series.limit.is_none_or(|(last, _)| last <= time)) {
                series.limit = Some((time, limit));
            }
        }
    }
    all.into_iter().filter_map(|((machine, quantity), series)| trend(machine, quantity, series)).collect()
}

/// Returns the quantities of a row with value, limit and whether the limit is crossed.
fn quantities(row: &Row) -> impl Iterator<Item = (Quantity, f64, Option<f64>, bool)> {
    let indicators = row.indicators.iter().map(|one| {
        let (kind, name, unit) = ("indicator".to_owned(), one.name.clone(), one.unit.clone());
        let quantity = Quantity { kind, name, probe: one.probe.clone(), bearing: one.bearing.clone(), unit };
        (quantity, one.value, one.limit, one.crossed)
    });
    let sizes = row.diagnoses.iter().filter_map(|one| {
        let (kind, name, unit) = ("diagnosis".to_owned(), one.name(), one.size_unit.clone());
        let quantity = Quantity { kind, name, probe: None, bearing: one.bearing.clone(), unit };
        Some((quantity, one.size?, None, false))
    });
    indicators.chain(sizes)
}

fn trend(machine: &str, quantity: Quantity, mut series: Series) -> Option<Trend> {
    series.snapshots.sort_by_key(|one| one.time);
    let (first, last) = (series.snapshots.first()?.time, series.snapshots.last()?.time);
    let points: Vec<(f64, f64)> = series.snapshots.iter().map(|one| (one.time.days_since(first), one.value)).collect();
    let line = Line::fit(&points)?;
    let limit = series.limit.map(|(_, limit)| limit);
    let crossed_on = series.snapshots.iter().find(|one| one.crossed).map(|one| one.time);
    let crossing = || {
        let [at, low, high] = line.reaches(limit?)?;
        // The limit was not crossed so far.
        let (time, earliest) = (first.after_days(at)?.max(last), first.after_days(low)?.max(last));
        Some(Crossing { time, earliest, latest: first.after_days(high).map(|latest| latest.max(last)) })
    };
    Some(Trend {
        machine: machine.to_owned(),
        quantity,
        limit,
        slope_per_day: line.slope,
        slope_low: line.slope - line.slope_half_width,
        slope_high: line.slope + line.slope_half_width,
        crossed_on,
        crosses_on: if crossed_on.is_none() { crossing() } else { None },
        snapshots: series.snapshots,
    })
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fleet::row::tests::{limited, with_diagnosis};

    fn day(row: Row, day: u32) -> Row {
        let text = format!("2026-03-{:02}", day + 1);
        Row { time: Time::parse(&text), recording: text, ..row }
    }

    #[test]
    fn a_line_crosses_its_limit_on_the_day_of_the_closed_form() {
        // 0.1 + 0.05 t reaches 1 after 18 days.
        let rows: Vec<Row> = [3, 0, 2, 1].map(|d| day(limited("pump", 0.1 + 0.05 * f64::from(d)), d)).to_vec();
        let trends = trends(&rows);
        let trend = &trends[0];
        assert_eq!((trends.len(), trend.snapshots.len(), trend.limit), (1, 4, Some(1.0)));
        assert!((trend.slope_per_day - 0.05).abs() < 1e-12 && trend.slope_high - trend.slope_low < 1e-12);
        assert_eq!(trend.crossed_on, None);
        let crossing = trend.crosses_on.unwrap();
        assert_eq!(crossing.time.to_string(), "2026-03-19T00:00:00Z");
        assert_eq!([Some(crossing.earliest), crossing.latest], [Some(crossing.time); 2]);
    }

    #[test]
    fn a_crossed_limit_has_the_time_of_its_first_snapshot() {
        let rows: Vec<Row> = (0..6).map(|d| day(limited("pump", 0.75 + 0.1 * f64::from(d)), d)).collect();
        let trends = trends(&rows);
        assert_eq!(trends[0].crossed_on.unwrap().date(), "2026-03-04");
        assert_eq!(trends[0].crosses_on, None);
    }

    #[test]
    fn a_falling_or_level_quantity_never_crosses() {
        for slope in [-0.05, 0.0] {
            let rows: Vec<Row> = (0..6).map(|d| day(limited("pump", 0.5 + slope * f64::from(d)), d)).collect();
            assert_eq!(trends(&rows)[0].crosses_on, None);
        }
        // A rise within the noise.
        let noisy: Vec<Row> =
            [0.5, 0.9, 0.2, 0.8, 0.4].iter().zip(0..).map(|(v, d)| day(limited("pump", *v), d)).collect();
        assert!(!trends(&noisy)[0].is_significant() && trends(&noisy)[0].crosses_on.is_none());
    }

    #[test]
    fn sizes_of_diagnoses_have_trends() {
        let rows: Vec<Row> = (0..4).map(|d| day(with_diagnosis("fan", 20.0 + 2.0 * f64::from(d)), d)).collect();
        let trends = trends(&rows);
        assert_eq!(trends[0].quantity.label(), "size of outer-race spall of DE");
        assert!((trends[0].slope_per_day - 0.2).abs() < 1e-12);
        assert_eq!((trends[0].limit, trends[0].crossing()), (None, None));
    }

    #[test]
    fn two_snapshots_or_no_times_have_no_trend() {
        let rows: Vec<Row> = (0..2).map(|d| day(limited("pump", 0.5), d)).collect();
        assert!(trends(&rows).is_empty());
        assert!(trends(&[limited("pump", 0.5), limited("pump", 0.6), limited("pump", 0.7)]).is_empty());
    }
}
