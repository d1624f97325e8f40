//! Rows and trends as files: Parquet and CSV.

use super::row::{Row, State};
use super::trend::Trend;
use ballrace_base::bounded::open_regular;
use ballrace_base::caught::caught;
use ballrace_base::output::cell_text;
use ballrace_plant::error::FleetError;
use ballrace_recording::Time;
use ballrace_recording::parquet_table::{self, Column, Values};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::io::Write;
use std::path::Path;

fn failed(error: impl std::fmt::Display) -> FleetError {
    FleetError::Rows(error.to_string())
}

fn json(value: &impl Serialize) -> Result<String, FleetError> {
    serde_json::to_string(value).map_err(failed)
}

/// Columns of a table of rows. An absent text is empty; lists are JSON text.
const TEXTS: [&str; 10] = [
    "machine",
    "recording",
    "time",
    "state",
    "verdict",
    "error",
    "diagnoses_json",
    "indicators_json",
    "tags_json",
    "inputs",
];
const NUMBERS: [&str; 2] = ["duration_s", "mean_speed_rpm"];

fn texts(row: &Row) -> Result<[String; 10], FleetError> {
    Ok([
        row.machine.clone(),
        row.recording.clone(),
        row.time.map(|time| time.to_string()).unwrap_or_default(),
        row.state.name().to_owned(),
        row.verdict.clone(),
        row.error.clone().unwrap_or_default(),
        json(&row.diagnoses)?,
        json(&row.indicators)?,
        json(&row.tags)?,
        row.inputs.clone(),
    ])
}

const fn numbers(row: &Row) -> [Option<f64>; 2] {
    [row.duration_s, row.mean_speed_rpm]
}

/// Writes rows as Parquet; diagnoses, indicators and tags are JSON text.
///
/// # Errors
/// Returns an error if the writer fails.
pub fn parquet<'a>(out: impl Write + Send, rows: impl IntoIterator<Item = &'a Row>) -> Result<(), FleetError> {
    let rows: Vec<&Row> = rows.into_iter().collect();
    let mut words = TEXTS.map(|_| Vec::with_capacity(rows.len()));
    for row in &rows {
        words.iter_mut().zip(texts(row)?).for_each(|(column, text)| column.push(text));
    }
    let words = TEXTS.iter().zip(words).map(|(name, column)| Column::new(name, Values::Word(column)));
    let figures = NUMBERS.iter().enumerate().map(|(i, name)| {
        let column = rows.iter().map(|row| numbers(row).get(i).copied().flatten()).collect();
        Column::new(name, Values::Number(column))
    });
    let columns: Vec<Column> = words.chain(figures).collect();
    parquet_table::write(out, "outcomes", &columns).map_err(failed)
}

/// Reads the rows of a file that [`parquet()`] has written.
pub(super) fn read_parquet(file: &Path) -> Result<Vec<Row>, FleetError> {
    let wrong = |found: String| FleetError::Part { file: file.to_owned(), found };
    // The library's decoders panic on some damaged files.
    let read = caught(|| rows_of(file)).unwrap_or_else(|_| Err("a damaged file, which cannot be decoded".into()));
    read.map_err(|error| wrong(error.to_string()))
}

fn rows_of(file: &Path) -> Result<Vec<Row>, Box<dyn std::error::Error>> {
    let reader = SerializedFileReader::new(open_regular(file)?)?;
    reader.get_row_iter(None)?.map(|row| row_of(&row?)).collect()
}

fn row_of(row: &parquet::record::Row) -> Result<Row, Box<dyn std::error::Error>> {
    let cells: HashMap<&str, &Field> = row.get_column_iter().map(|(name, field)| (name.as_str(), field)).collect();
    let text = |name: &str| match cells.get(name) {
        Some(Field::Str(text)) => Ok(text.clone()),
        _ => Err(format!("missing text {name:?}")),
    };
    let number = |name: &str| match cells.get(name) {
        Some(Field::Double(value)) => Some(*value),
        _ => None,
    };
    let some = |text: String| if text.is_empty() { None } else { Some(text) };
    let state = text("state")?;
    let known = State::ALL.into_iter().find(|one| one.name() == state);
    Ok(Row {
        machine: text("machine")?,
        recording: text("recording")?,
        time: some(text("time")?).map(Time::try_from).transpose()?,
        state: known.ok_or_else(|| format!("unknown state {state:?}"))?,
        verdict: text("verdict")?,
        diagnoses: parsed(&text("diagnoses_json")?)?,
        indicators: parsed(&text("indicators_json")?)?,
        tags: parsed(&text("tags_json")?)?,
        error: some(text("error")?),
        duration_s: number("duration_s"),
        mean_speed_rpm: number("mean_speed_rpm"),
        inputs: text("inputs")?,
    })
}

fn parsed<T: DeserializeOwned>(text: &str) -> Result<T, serde_json::Error> {
    serde_json::from_str(text)
}

/// Writes rows as CSV with the columns of [`parquet()`].
///
/// # Errors
/// Returns an error if the writer fails.
pub fn csv<'a>(out: impl Write, rows: impl IntoIterator<Item = &'a Row>) -> Result<(), FleetError> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(TEXTS.iter().chain(&NUMBERS)).map_err(failed)?;
    for row in rows {
        let figures = numbers(row).map(|value| value.map(|value| value.to_string()).unwrap_or_default());
        let texts = texts(row)?.map(|text| cell_text(&text).into_owned());
        writer.write_record(texts.iter().chain(&figures)).map_err(failed)?;
    }
    writer.flush().map_err(failed)
}

/// Writes trends as CSV, one row per quantity.
///
/// # Errors
/// Returns an error if the writer fails.
pub fn trends_csv(out: impl Write, trends: &[Trend]) -> Result<(), FleetError> {
    let mut writer = csv::Writer::from_writer(out);
    let header = [
        "machine",
        "kind",
        "name",
        "probe",
        "bearing",
        "unit",
        "snapshots",
        "first_time",
        "last_time",
        "last_value",
        "limit",
        "slope_per_day",
        "slope_low",
        "slope_high",
        "crossed_on",
        "crosses_on",
        "crosses_earliest",
        "crosses_latest",
    ];
    writer.write_record(header).map_err(failed)?;
    for trend in trends {
        let text = |time: Option<Time>| time.map(|time| time.to_string()).unwrap_or_default();
        let safe = |text: &str| cell_text(text).into_owned();
        let (first, last) = (trend.snapshots.first(), trend.snapshots.last());
        let quantity = &trend.quantity;
        let crossing = trend.crosses_on;
        let record = [
            safe(&trend.machine),
            safe(&quantity.kind),
            safe(&quantity.name),
            safe(quantity.probe.as_deref().unwrap_or_default()),
            safe(quantity.bearing.as_deref().unwrap_or_default()),
            safe(&quantity.unit),
            trend.snapshots.len().to_string(),
            text(first.map(|one| one.time)),
            text(last.map(|one| one.time)),
            last.map(|one| one.value.to_string()).unwrap_or_default(),
            trend.limit.map(|limit| limit.to_string()).unwrap_or_default(),
            trend.slope_per_day.to_string(),
            trend.slope_low.to_string(),
            trend.slope_high.to_string(),
            text(trend.crossed_on),
            text(crossing.map(|crossing| crossing.time)),
            text(crossing.map(|crossing| crossing.earliest)),
            text(crossing.and_then(|crossing| crossing.latest)),
        ];
        writer.write_record(record).map_err(failed)?;
    }
    writer.flush().map_err(failed)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fleet::row::tests::{limited, row, with_diagnosis};
    use std::fs::File;

    #[test]
    fn parquet_returns_the_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("rows.parquet");
        let mut broken = row("broken, \"quoted\"", State::Error);
        broken.error = Some("no file\nof this name".to_owned());
        broken.duration_s = None;
        broken.verdict = "=cmd|' /C calc'!A0".to_owned();
        broken.tags.insert("hall".to_owned(), "Ä".to_owned());
        broken.time = Time::parse("2026-01-02T03:04:05Z");
        let rows = vec![limited("a", 0.123_456_789), with_diagnosis("b", 17.0), broken];
        parquet(File::create(&file).unwrap(), &rows).unwrap();
        assert_eq!(read_parquet(&file).unwrap(), rows);
        let mut text = Vec::new();
        csv(&mut text, &rows).unwrap();
        let mut reader = csv::Reader::from_reader(text.as_slice());
        assert_eq!(
            reader.records().map(|record| record.unwrap()[0].to_owned()).collect::<Vec<_>>()[2],
            rows[2].machine
        );
        assert!(String::from_utf8(text).unwrap().contains(",'=cmd|"), "a formula");
        let json = serde_json::to_string(&rows).unwrap();
        assert_eq!(serde_json::from_str::<Vec<Row>>(&json).unwrap(), rows);
    }
}
