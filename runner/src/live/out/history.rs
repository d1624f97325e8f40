//! Reads indicator files and the journal back, for the history of the live page.

use super::indicators::{JOURNAL, parse_journal};
use anyhow::{Context, Result};
use ballrace_twin::outcome::BlockFigures;
use ballrace_twin::record::TIME_OF_DAY;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::{Field, Row};
use parquet::schema::types::Type;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

/// Number of indicators that are read: those with a trend.
pub const INDICATORS: usize = BlockFigures::TRENDS.len();

/// Indicators of one second.
#[derive(Debug, Clone, PartialEq)]
pub struct SecondValues {
    /// Time from the end of the second to the present, s.
    pub age_s: f64,
    /// Indicators of each probe.
    pub probes: Vec<[f64; INDICATORS]>,
}

/// Passes the seconds of the last `span_s` in a folder of indicators to `visit`, for probes of these names.
///
/// # Errors
/// Returns an error if a file cannot be read.
pub fn read(folder: &Path, names: &[&str], span_s: f64, mut visit: impl FnMut(&SecondValues)) -> Result<()> {
    let wanted: Vec<String> =
        names.iter().flat_map(|name| BlockFigures::TRENDS.map(|trend| format!("{name}_{}", trend.field.key))).collect();
    let now = SystemTime::now();
    let mut journal_number = None;
    let path = folder.join(JOURNAL);
    if let Ok(bytes) = std::fs::read(&path)
        && let Some((header, table, _)) = parse_journal(&bytes)
    {
        journal_number = Some(header.number);
        let column = |name: &str| table.names.iter().position(|known| known.name == name);
        let (at, columns) = (column(TIME_OF_DAY), wanted.iter().map(|name| column(name)).collect::<Vec<_>>());
        for row in &table.rows {
            let value = |i: Option<usize>| i.and_then(|i| row.values.get(i)).copied().unwrap_or(f64::NAN);
            let values: Vec<f64> = columns.iter().map(|i| value(*i)).collect();
            visit(&SecondValues { age_s: age_of_second(now, value(at)), probes: probes(&values) });
        }
    }
    for entry in std::fs::read_dir(folder).with_context(|| folder.display().to_string())? {
        let path = entry.with_context(|| folder.display().to_string())?.path();
        let number = path.file_name().and_then(|name| name.to_str());
        let number = number.and_then(|name| name.strip_prefix("indicators-")?.strip_suffix(".parquet")?.parse().ok());
        // A journal that was converted just now is not read twice.
        if number.is_none() || number == journal_number || age(now, &path)? > span_s {
            continue;
        }
        read_file(&path, &wanted, now, &mut visit).with_context(|| path.display().to_string())?;
    }
    Ok(())
}

fn read_file(path: &Path, wanted: &[String], now: SystemTime, visit: &mut impl FnMut(&SecondValues)) -> Result<()> {
    let reader = SerializedFileReader::new(File::open(path)?)?;
    let schema = reader.metadata().file_metadata().schema();
    let is_wanted = |field: &&Arc<Type>| field.name() == TIME_OF_DAY || wanted.iter().any(|name| name == field.name());
    let fields = schema.get_fields().iter().filter(is_wanted).cloned().collect();
    let projection = Type::group_type_builder(schema.name()).with_fields(fields).build()?;
    let number = |row: &Row, name: &str| {
        row.get_column_iter().find(|(column, _)| *column == name).map_or(f64::NAN, |(_, field)| match field {
            Field::Double(value) => *value,
            Field::TimestampMillis(value) => *value as f64,
            _ => f64::NAN,
        })
    };
    for row in reader.get_row_iter(Some(projection))? {
        let row = row?;
        let values: Vec<f64> = wanted.iter().map(|name| number(&row, name)).collect();
        visit(&SecondValues { age_s: age_of_second(now, number(&row, TIME_OF_DAY)), probes: probes(&values) });
    }
    Ok(())
}

/// Returns the age of a second from its time of day (ms since 1970), s; 0 if the clock was set back, NaN if it has none.
fn age_of_second(now: SystemTime, at_ms: f64) -> f64 {
    let age_s = now.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64() - 1e-3 * at_ms;
    if age_s < 0.0 { 0.0 } else { age_s }
}

/// Returns the age of a file, s; 0 if the clock was set back.
fn age(now: SystemTime, path: &Path) -> Result<f64> {
    let modified =
        path.metadata().and_then(|metadata| metadata.modified()).with_context(|| path.display().to_string())?;
    Ok(now.duration_since(modified).map_or(0.0, |age| age.as_secs_f64()))
}

fn probes(values: &[f64]) -> Vec<[f64; INDICATORS]> {
    values.chunks_exact(INDICATORS).map(|chunk| std::array::from_fn(|i| chunk[i])).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::super::indicators::Indicators;
    use super::*;
    use ballrace_twin::record::SecondRecord;
    use ballrace_twin::replay::second::{ProbeSecond, Second};
    use std::time::Duration;

    /// Seconds in two files and a journal are read back, each once.
    #[test]
    fn files_and_journal_are_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let mut indicators = Indicators::open(folder.path(), "", 10).unwrap();
        for i in 1..=25_u32 {
            let probe = ProbeSecond {
                name: "X".to_owned(),
                peak_to_peak_um: f64::from(i),
                one_x_um: f64::NAN,
                kurtosis: 3.0,
                ..ProbeSecond::default()
            };
            let second = Second { time_s: f64::from(i), probes: vec![probe], ..Second::default() };
            // Written at once, but from the last hour.
            let at = SystemTime::now() - Duration::from_secs(u64::from(1000 - i));
            let record = SecondRecord { at, second: &second };
            indicators.add(&record, u64::from(100 * i));
            indicators.save().unwrap();
        }
        let mut seconds = vec![];
        read(folder.path(), &["X", "absent"], 3600.0, |second| seconds.push(second.clone())).unwrap();
        let mut values: Vec<f64> = seconds.iter().map(|second| second.probes[0][0]).collect();
        values.sort_by(f64::total_cmp);
        assert_eq!(values, (1..=25).map(f64::from).collect::<Vec<_>>());
        let first = seconds.iter().find(|second| second.probes[0][0] == 21.0).unwrap();
        assert!((979.0..985.0).contains(&first.age_s), "{first:?}");
        let oldest = seconds.iter().find(|second| second.probes[0][0] == 1.0).unwrap();
        assert!((999.0..1005.0).contains(&oldest.age_s), "{oldest:?}");
        assert!(first.probes[0][1].is_nan() && first.probes[0][3] == 3.0 && first.probes[1][0].is_nan());
        assert!(read(&folder.path().join("absent"), &["X"], 1.0, |_| {}).is_err());
    }
}
