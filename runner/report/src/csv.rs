//! The comparison as CSV: one row per probe, units in the column names, empty cells for missing numbers. For snapshots: the trend, one
//! row per snapshot and sensor.

use ballrace_twin::output::quoted;
use ballrace_twin::replay::outcome::{
    BallPassLine, LineLevel, Motion, NumericField, Outcome, ProbeOutcome, SimplePredictors, SnapshotFigures,
};

/// Column names and cells of one row, in order.
type Row = Vec<(String, String)>;

/// Returns the comparison as CSV: a header and one row per probe, in the scene's order.
///
/// Each bearing with ball-pass lines adds five columns, named after the bearing. For snapshots, the rows are those of the trend.
#[must_use]
pub fn csv(outcome: &Outcome) -> String {
    if !outcome.snapshots.is_empty() {
        return snapshots(outcome);
    }
    let bearings = bearings(outcome);
    let heads = row(&ProbeOutcome::default(), &bearings).into_iter().map(|cell| cell.0);
    let mut text = joined(heads);
    for probe in &outcome.probes {
        text.push_str(&joined(row(probe, &bearings).into_iter().map(|cell| cell.1)));
    }
    text
}

/// Returns the figures of the snapshots as CSV, one row per snapshot and sensor.
fn snapshots(outcome: &Outcome) -> String {
    let lines = outcome.snapshots.iter().flat_map(|snapshot| &snapshot.sensors).map(|figures| &figures.lines);
    let all = lines.max_by_key(|lines| lines.len()).map_or(&[][..], Vec::as_slice);
    let same = |a: &LineLevel, b: &LineLevel| a.bearing == b.bearing && a.component == b.component;
    let fields = SnapshotFigures::FIELDS;
    let fixed = ["snapshot", "file", "time", "sensor"].into_iter().chain(fields.iter().map(|field| field.key));
    let line_heads = all.iter().map(|line| format!("{}_{}_db", line.bearing, line.component.name().replace('-', "_")));
    let mut text = joined(fixed.map(str::to_owned).chain(line_heads));
    for snapshot in &outcome.snapshots {
        for figures in &snapshot.sensors {
            let stamp = snapshot.first_stamp_s.map(|stamp| stamp.to_string());
            let mut cells = vec![
                snapshot.number.to_string(),
                snapshot.file.clone(),
                snapshot.time.clone().or(stamp).unwrap_or_default(),
                figures.sensor.clone(),
            ];
            cells.extend(numbers("", &fields, figures).map(|cell| cell.1));
            cells.extend(all.iter().map(|of| {
                let level = figures.lines.iter().find(|line| same(line, of));
                number("", level.map_or(f64::NAN, |line| line.level_db)).1
            }));
            text.push_str(&joined(cells.into_iter()));
        }
    }
    text
}

/// Returns the names of all bearings with a ball-pass line at a probe, each once.
fn bearings(outcome: &Outcome) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for line in outcome.probes.iter().flat_map(|probe| &probe.ball_pass) {
        if !names.contains(&line.bearing) {
            names.push(line.bearing.clone());
        }
    }
    names
}

fn row(probe: &ProbeOutcome, bearings: &[String]) -> Row {
    let mut row = vec![("probe".to_owned(), probe.name.clone())];
    row.extend(numbers("", &ProbeOutcome::PLACE, probe));
    row.extend(numbers("measured_", &Motion::FIELDS, &probe.measured));
    row.extend(numbers("twin_", &Motion::FIELDS, &probe.twin));
    row.extend(numbers("", &ProbeOutcome::RESIDUAL, probe));
    row.push(("nrmse_normaliser".to_owned(), probe.nrmse_normaliser.clone()));
    row.extend(numbers("", &[ProbeOutcome::NOISE], probe));
    row.extend(SimplePredictors::FIELDS.map(|field| {
        number(&format!("baselines_{}_residual_rms_um", field.key), (field.value)(&probe.baselines).residual_rms_um)
    }));
    row.push(("twin_to_best_baseline".to_owned(), super::words::standing(probe.baselines.worst()).to_lowercase()));
    let none = BallPassLine::NONE;
    for bearing in bearings {
        let line = probe.ball_pass.iter().find(|line| line.bearing == *bearing).unwrap_or(&none);
        row.extend(numbers(&format!("{bearing}_ball_pass_"), &BallPassLine::FIELDS, line));
    }
    row
}

/// Returns the columns of the fields of an object.
fn numbers<T>(before: &str, fields: &[NumericField<T>], of: &T) -> impl Iterator<Item = (String, String)> {
    fields.iter().map(move |field| number(&format!("{before}{}", field.key), (field.value)(of)))
}

fn number(head: &str, value: f64) -> (String, String) {
    (head.to_owned(), if value.is_finite() { value.to_string() } else { String::new() })
}

fn joined(cells: impl Iterator<Item = String>) -> String {
    let mut line = cells.map(|cell| quoted(&cell)).collect::<Vec<_>>().join(",");
    line.push('\n');
    line
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fixture;

    #[test]
    fn every_row_has_every_column() {
        for outcome in [fixture::usual(), fixture::bare(), fixture::broken(), fixture::crowded()] {
            let text = csv(&outcome);
            let mut reader = ::csv::Reader::from_reader(text.as_bytes());
            let columns = reader.headers().unwrap().len();
            let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
            assert_eq!(rows.len(), outcome.probes.len());
            assert!(rows.iter().all(|row| row.len() == columns));
            assert!(!text.contains("NaN") && !text.contains("inf"));
        }
    }

    /// A column is named after the path of its JSON key: `measured_one_x_um` is `one_x_um` of `measured`.
    #[test]
    fn columns_have_the_names_of_json_keys() {
        fn paths(value: &serde_json::Value, before: &str, into: &mut Vec<String>) {
            for (key, value) in value.as_object().into_iter().flatten() {
                let path = format!("{before}{key}");
                paths(value, &format!("{path}_"), into);
                into.push(path);
            }
        }
        let probe = &fixture::usual().probes[0];
        let mut known = vec!["probe".to_owned(), "twin_to_best_baseline".to_owned()];
        paths(&serde_json::to_value(probe).unwrap(), "", &mut known);
        for line in &probe.ball_pass {
            paths(&serde_json::to_value(line).unwrap(), &format!("{}_ball_pass_", line.bearing), &mut known);
        }
        let text = csv(&fixture::usual());
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        let unknown: Vec<&str> =
            reader.headers().unwrap().iter().filter(|head| !known.iter().any(|name| name == head)).collect();
        assert!(unknown.is_empty(), "{unknown:?}");
    }

    #[test]
    fn figures_are_in_the_columns_of_their_heads() {
        let outcome = fixture::usual();
        let text = csv(&outcome);
        let mut reader = ::csv::Reader::from_reader(text.as_bytes());
        let heads = reader.headers().unwrap().clone();
        let row = reader.records().next().unwrap().unwrap();
        let cell = |name: &str| row.get(heads.iter().position(|head| head == name).unwrap()).unwrap().to_owned();
        assert_eq!(cell("probe"), "DE_X");
        assert_eq!(cell("residual_rms_um").parse::<f64>().unwrap(), outcome.probes[0].residual_rms_um);
        assert_eq!(cell("NDE_ball_pass_twin_um").parse::<f64>().unwrap(), outcome.probes[0].ball_pass[1].twin_um);
    }
}
