//! The comparison as CSV: one row per probe, units in the column names, empty cells for missing numbers. For snapshots: the trend, one
//! row per snapshot and sensor.

use ballrace_twin::output::quoted;
use ballrace_twin::replay::outcome::{BallPassLine, LineLevel, Motion, Outcome, ProbeOutcome};

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
    let fixed = ["snapshot", "file", "time", "sensor", "rms", "peak", "crest_factor", "kurtosis"].map(str::to_owned);
    let line_heads = all.iter().map(|line| {
        let component = serde_json::to_string(&line.component).unwrap_or_default();
        format!("{}_{}_db", line.bearing, component.trim_matches('"').replace('-', "_"))
    });
    let mut text = joined(fixed.into_iter().chain(line_heads));
    for snapshot in &outcome.snapshots {
        for figures in &snapshot.sensors {
            let stamp = snapshot.first_stamp_s.map(|stamp| stamp.to_string());
            let mut cells = vec![
                snapshot.number.to_string(),
                snapshot.file.clone(),
                snapshot.time.clone().or(stamp).unwrap_or_default(),
                figures.sensor.clone(),
            ];
            let values = [figures.rms, figures.peak, figures.crest_factor, figures.kurtosis];
            cells.extend(values.map(|value| number("", value).1));
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
    let mut row = vec![
        ("probe".to_owned(), probe.name.clone()),
        number("station_mm", probe.station_mm),
        number("angle_deg", probe.angle_deg.unwrap_or(f64::NAN)),
    ];
    row.extend(motion("measured", &probe.measured));
    row.extend(motion("twin", &probe.twin));
    row.extend(difference(probe));
    for bearing in bearings {
        row.extend(ball_pass(bearing, probe.ball_pass.iter().find(|line| line.bearing == *bearing)));
    }
    row
}

fn motion(whose: &str, motion: &Motion) -> Row {
    vec![
        number(&format!("{whose}_mean_um"), motion.mean_um),
        number(&format!("{whose}_peak_to_peak_um"), motion.peak_to_peak_um),
        number(&format!("{whose}_rms_um"), motion.rms_um),
        number(&format!("{whose}_one_x_um"), motion.one_x_um),
        number(&format!("{whose}_one_x_phase_lag_deg"), motion.one_x_phase_lag_deg),
    ]
}

fn difference(probe: &ProbeOutcome) -> Row {
    vec![
        number("one_x_error_um", probe.one_x_error_um),
        number("residual_bias_um", probe.residual_bias_um),
        number("residual_rms_um", probe.residual_rms_um),
        number("nrmse_percent", probe.nrmse_percent),
        ("nrmse_normaliser".to_owned(), probe.nrmse_normaliser.clone()),
        number("noise_um", probe.noise_um.unwrap_or(f64::NAN)),
        number("baselines_mean_residual_rms_um", probe.baselines.mean.residual_rms_um),
        number("baselines_persistence_residual_rms_um", probe.baselines.persistence.residual_rms_um),
        number("baselines_one_x_residual_rms_um", probe.baselines.one_x.residual_rms_um),
        number("baselines_linear_residual_rms_um", probe.baselines.linear.residual_rms_um),
        ("twin_to_best_baseline".to_owned(), super::words::standing(probe.baselines.worst()).to_lowercase()),
    ]
}

fn ball_pass(bearing: &str, line: Option<&BallPassLine>) -> Row {
    let head = |what: &str| format!("{bearing}_ball_pass_{what}");
    let value = |of: fn(&BallPassLine) -> f64| line.map_or(f64::NAN, of);
    vec![
        number(&head("order"), value(|line| line.order)),
        number(&head("frequency_hz"), value(|line| line.frequency_hz)),
        number(&head("measured_um"), value(|line| line.measured_um)),
        number(&head("twin_um"), value(|line| line.twin_um)),
        number(&head("residual_um"), value(|line| line.residual_um)),
    ]
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
