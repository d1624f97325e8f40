//! Columns of equal length as an uncompressed Parquet file. The file's metadata contains its schema version, the units of its
//! columns and the time zone of its times of day.

use parquet::basic::{Compression, LogicalType, Repetition, TimeUnit, TimestampType, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::collections::BTreeMap;
use std::io::Write;
use std::sync::Arc;

/// Version of the columns of the written tables; it rises with every incompatible change.
const SCHEMA_VERSION: u32 = 1;

/// Suffixes of column names and their units.
const UNITS: [(&str, &str); 11] = [
    ("_um", "um"),
    ("_mm", "mm"),
    ("_deg", "deg"),
    ("_rpm", "rpm"),
    ("_hz", "Hz"),
    ("_Nm", "N m"),
    ("_N", "N"),
    ("_percent", "%"),
    ("_db", "dB"),
    ("_per_s", "1/s"),
    ("_s", "s"),
];

/// Type of times of day.
const TIME_OF_DAY: LogicalType =
    LogicalType::Timestamp(TimestampType { is_adjusted_to_u_t_c: true, unit: TimeUnit::MILLIS });

/// One column.
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its unit, if it has one.
    pub unit: Option<String>,
    /// Its values.
    pub values: Values,
}

/// Values of a column.
pub enum Values {
    /// Numbers.
    Number(Vec<Option<f64>>),
    /// Whole numbers.
    Count(Vec<Option<i64>>),
    /// Times of day, ms since 1970-01-01 00:00 UTC.
    Time(Vec<Option<i64>>),
    /// Text.
    Word(Vec<String>),
}

impl Column {
    /// Creates a column; the suffix of its name determines its unit.
    #[must_use]
    pub fn new(name: &str, values: Values) -> Self {
        let unit = UNITS.iter().find(|(end, _)| name.ends_with(end)).map(|(_, unit)| (*unit).to_owned());
        Self { name: name.to_owned(), unit, values }
    }

    /// Returns the column with another unit; empty for none.
    #[must_use]
    pub fn with_unit(self, unit: &str) -> Self {
        Self { unit: (!unit.is_empty()).then(|| unit.to_owned()), ..self }
    }

    fn field(&self) -> Result<Arc<Type>> {
        let physical = match self.values {
            Values::Number(_) => Physical::DOUBLE,
            Values::Count(_) | Values::Time(_) => Physical::INT64,
            Values::Word(_) => Physical::BYTE_ARRAY,
        };
        let field = Type::primitive_type_builder(&self.name, physical);
        let field = match self.values {
            Values::Word(_) => field.with_repetition(Repetition::REQUIRED).with_logical_type(Some(LogicalType::String)),
            Values::Time(_) => field.with_repetition(Repetition::OPTIONAL).with_logical_type(Some(TIME_OF_DAY)),
            _ => field.with_repetition(Repetition::OPTIONAL),
        };
        Ok(Arc::new(field.build()?))
    }

    fn write<W: Write + Send>(&self, group: &mut SerializedRowGroupWriter<'_, W>) -> Result<()> {
        let Some(mut writer) = group.next_column()? else { return Ok(()) };
        match &self.values {
            Values::Number(values) => {
                let (there, which) = split(values);
                writer.typed::<DoubleType>().write_batch(&there, Some(&which), None)?;
            }
            Values::Count(values) | Values::Time(values) => {
                let (there, which) = split(values);
                writer.typed::<Int64Type>().write_batch(&there, Some(&which), None)?;
            }
            Values::Word(values) => {
                let words: Vec<ByteArray> = values.iter().map(|word| ByteArray::from(word.as_str())).collect();
                writer.typed::<ByteArrayType>().write_batch(&words, None, None)?;
            }
        }
        writer.close()?;
        Ok(())
    }
}

/// Writes a table called `name`.
///
/// # Errors
/// Returns the writer's error.
pub fn write(out: impl Write + Send, name: &str, columns: &[Column]) -> Result<()> {
    let fields = columns.iter().map(Column::field).collect::<Result<Vec<_>>>()?;
    let schema = Arc::new(Type::group_type_builder(name).with_fields(fields).build()?);
    let properties = WriterProperties::builder()
        .set_compression(Compression::UNCOMPRESSED)
        .set_key_value_metadata(Some(metadata(name, columns)?))
        .build();
    let mut file = SerializedFileWriter::new(out, schema, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for column in columns {
        column.write(&mut group)?;
    }
    group.close()?;
    file.close()?;
    Ok(())
}

/// Returns the metadata of the file.
fn metadata(name: &str, columns: &[Column]) -> Result<Vec<KeyValue>> {
    let units: BTreeMap<&str, &str> =
        columns.iter().filter_map(|column| Some((column.name.as_str(), column.unit.as_deref()?))).collect();
    let units = serde_json::to_string(&units).map_err(|e| ParquetError::External(Box::new(e)))?;
    let pair = |key: &str, value: String| KeyValue::new(key.to_owned(), value);
    Ok(vec![
        pair("schema", format!("ballrace-{name}-{SCHEMA_VERSION}")),
        pair("units", units),
        pair("time_zone", "UTC".to_owned()),
    ])
}

/// Returns the values that are present, and the definition level of each row: 1 where its value is present, 0 elsewhere.
fn split<A: Copy>(values: &[Option<A>]) -> (Vec<A>, Vec<i16>) {
    (values.iter().copied().flatten().collect(), values.iter().map(|x| i16::from(x.is_some())).collect())
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};

    #[test]
    fn metadata_state_schema_units_and_time_zone() {
        let columns = [
            Column::new("at", Values::Time(vec![Some(1_795_000_000_123), None])),
            Column::new("DE_FX_N", Values::Number(vec![Some(1.5), None])),
            Column::new("DE_MX_Nm", Values::Number(vec![None, None])),
            Column::new("A_rms", Values::Number(vec![Some(2.0), Some(3.0)])).with_unit("m/s^2"),
            Column::new("speed_rpm", Values::Number(vec![Some(3000.0), Some(3000.0)])),
            Column::new("samples", Values::Count(vec![Some(7), Some(8)])),
        ];
        let mut file = tempfile::tempfile().unwrap();
        write(&mut file, "indicators", &columns).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let metadata = reader.metadata().file_metadata();
        let value = |key: &str| {
            let pairs = metadata.key_value_metadata().unwrap();
            pairs.iter().find(|pair| pair.key == key).unwrap().value.clone().unwrap()
        };
        assert_eq!((value("schema").as_str(), value("time_zone").as_str()), ("ballrace-indicators-1", "UTC"));
        let units = r#"{"A_rms":"m/s^2","DE_FX_N":"N","DE_MX_Nm":"N m","speed_rpm":"rpm"}"#;
        assert_eq!(value("units"), units);
        let at = metadata.schema_descr().column(0).logical_type_ref().cloned();
        assert_eq!(at, Some(TIME_OF_DAY));
        let row = reader.get_row_iter(None).unwrap().next().unwrap().unwrap();
        assert!(row.to_string().contains("DE_FX_N: 1.5"), "{row}");
    }
}
