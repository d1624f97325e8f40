//! Order of machines, worst first.

use super::row::{Row, State};
use std::cmp::Ordering;

/// Compares two rows for a list with the worst first.
///
/// The order is that of [`State::ALL`]: crossed limits before diagnoses, then recordings that are implausible or have an error, then those
/// without a verdict, then normal ones. Within crossed limits the largest indicator over its limit comes first, within diagnoses
/// the highest level of the evidence, then, as in all other states, the largest indicator over its limit. Equal rows keep
/// the order of the names and recordings.
#[must_use]
pub fn worst_first(a: &Row, b: &Row) -> Ordering {
    let share = |row: &Row| row.worst_indicator().and_then(|one| one.utilisation()).unwrap_or(0.0);
    let level = |row: &Row| match row.state {
        State::Limit => share(row),
        _ => row.diagnoses.iter().map(|one| one.level_db).fold(0.0, f64::max),
    };
    (a.state.cmp(&b.state))
        .then_with(|| level(b).total_cmp(&level(a)))
        .then_with(|| share(b).total_cmp(&share(a)))
        .then_with(|| a.key().cmp(&b.key()))
}

/// Returns the row with the present condition of each machine, worst first: the latest row, or the worst row if a row of the machine
/// has no time.
#[must_use]
pub fn current<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Vec<&'a Row> {
    let mut all: Vec<&Row> = rows.into_iter().collect();
    // The first row of each machine is the worst one.
    all.sort_by(|a, b| a.machine.cmp(&b.machine).then_with(|| worst_first(a, b)));
    let mut current: Vec<&Row> = all
        .chunk_by(|a, b| a.machine == b.machine)
        .filter_map(|rows| {
            let is_timed = rows.iter().all(|row| row.time.is_some());
            let latest = || rows.iter().rev().max_by_key(|row| row.time);
            if is_timed { latest() } else { rows.first() }.copied()
        })
        .collect();
    current.sort_by(|a, b| worst_first(a, b));
    current
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::row::tests::{limited, row, with_diagnosis};

    #[test]
    fn the_worst_comes_first() {
        let mut rows = vec![
            row("normal", State::Normal),
            row("standstill", State::NotJudged),
            row("broken", State::Error),
            row("implausible", State::Implausible),
            with_diagnosis("slight", 12.0),
            with_diagnosis("strong", 40.0),
            limited("just", 1.1),
            limited("far", 3.0),
            limited("near", 0.9),
        ];
        rows.sort_by(worst_first);
        let order: Vec<&str> = rows.iter().map(|row| row.machine.as_str()).collect();
        assert_eq!(order, ["far", "just", "strong", "slight", "implausible", "broken", "standstill", "near", "normal"]);
    }

    #[test]
    fn the_latest_row_stands_for_a_machine() {
        let at = |mut row: Row, day: &str| {
            row.time = ballrace_recording::Time::parse(day);
            row.recording = day.to_owned();
            row
        };
        let mut rows = vec![
            at(limited("a", 2.0), "2026-01-01"),
            at(row("a", State::Normal), "2026-01-03"),
            at(row("a", State::Error), "2026-01-02"),
            at(row("b", State::Normal), "2026-01-01"),
        ];
        let states =
            |rows: &[Row]| current(rows).iter().map(|row| (row.machine.clone(), row.state)).collect::<Vec<_>>();
        let [a, b] = ["a", "b"].map(str::to_owned);
        assert_eq!(states(&rows), [(a.clone(), State::Normal), (b.clone(), State::Normal)]);
        if let Some(first) = rows.first_mut() {
            first.time = None;
        }
        assert_eq!(states(&rows), [(a, State::Limit), (b, State::Normal)]);
    }
}
