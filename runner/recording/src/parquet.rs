//! Parquet files as recordings: flat columns of numbers by their names, decoded a row group and a block at a time. A column of
//! timestamps is the time of the samples.

mod page;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests;

use std::fs::File;
use std::path::{Path, PathBuf};

use ::parquet::basic::{ConvertedType, LogicalType, Repetition, TimeUnit, Type as Physical};
use ::parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use ::parquet::data_type::DataType;
use ::parquet::errors::{ParquetError, Result as Decoded};
use ::parquet::file::metadata::ColumnChunkMetaData;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::Type;

use super::error::RecordingError;
use super::table::{Cells, Table, TimeOrigin, equal_lengths};
use ballrace_base::caught::caught;

const EXPECTED: &str = "a Parquet file with flat columns of numbers, and with seconds or timestamps for `time`";

/// Values decoded at once.
const BLOCK: usize = 4096;

/// A file with its current row group and the current block of each column.
struct ParquetTable {
    path: PathBuf,
    reader: SerializedFileReader<File>,
    names: Vec<String>,
    fields: Vec<Field>,
    selected: Vec<Column>,
    /// Field of the time stamps.
    time: Option<usize>,
    /// First timestamp, in nanoseconds from 1970.
    first: Option<i128>,
    /// The row group to open next.
    group: usize,
    /// Number of rows left in the current row group.
    left: u64,
    row: u64,
    bytes_read: u64,
}

/// A field at the root of the schema.
struct Field {
    /// Its column among the leaves of the schema.
    leaf: usize,
    optional: bool,
    unsigned: bool,
    /// Form of timestamps, which are read as time only.
    timestamp: Option<Timestamp>,
    /// Reason for which it cannot be read; reported where the scene names it.
    refused: Option<String>,
}

/// Form of timestamps.
#[derive(Debug, Clone, Copy)]
struct Timestamp {
    /// Nanoseconds of one unit.
    unit: i128,
    has_zone: bool,
}

/// A column that is read.
struct Column {
    field: usize,
    reader: Option<ColumnReader>,
    block: std::vec::IntoIter<f64>,
}

/// Opens a file.
pub(super) fn open(file: File, path: &Path) -> Result<Box<dyn Table>, RecordingError> {
    let reader = guarded(|| SerializedFileReader::new(file)).map_err(|error| wrong(path, error))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let roots = schema.root_schema().get_fields();
    let leaf = |root: usize| (0..schema.num_columns()).find(|leaf| schema.get_column_root_idx(*leaf) == root);
    let fields = roots.iter().enumerate().map(|(place, root)| field(root, leaf(place))).collect();
    let names = roots.iter().map(|root| root.name().to_owned()).collect();
    let path = path.into();
    let (selected, time, first, group, left, row, bytes_read) = (Vec::new(), None, None, 0, 0, 0, 0);
    Ok(Box::new(ParquetTable { path, reader, names, fields, selected, time, first, group, left, row, bytes_read }))
}

fn wrong(path: &Path, error: impl ToString) -> RecordingError {
    let text = error.to_string();
    let found = text.split_whitespace().collect::<Vec<_>>().join(" ");
    RecordingError::Format { file: path.into(), found, expected: EXPECTED }
}

/// Runs the library's decoder.
///
/// The library checks most of its input, but its page decoders panic on some damaged files. Their panics are caught and
/// become an error that names the file; no state of the decoder is used afterwards.
fn guarded<T>(work: impl FnOnce() -> Decoded<T>) -> Decoded<T> {
    caught(work).unwrap_or_else(|_| Err(ParquetError::General("a damaged file, which cannot be decoded".into())))
}

fn field(root: &Type, leaf: Option<usize>) -> Field {
    let unsigned = |kind| {
        use ConvertedType::{UINT_8, UINT_16, UINT_32, UINT_64};
        matches!(kind, UINT_8 | UINT_16 | UINT_32 | UINT_64)
    };
    let about = root.get_basic_info();
    let logical_unsigned = matches!(about.logical_type_ref(), Some(LogicalType::Integer(kind)) if !kind.is_signed);
    Field {
        leaf: leaf.unwrap_or_default(),
        optional: about.has_repetition() && about.repetition() == Repetition::OPTIONAL,
        unsigned: logical_unsigned || unsigned(about.converted_type()),
        timestamp: timestamp(root),
        refused: refusal(root).or_else(|| leaf.is_none().then(|| "has no values".into())),
    }
}

/// Returns the form of a field of timestamps; none for other fields. Those of 96 bits (Impala, Spark) state no zone.
fn timestamp(root: &Type) -> Option<Timestamp> {
    let about = root.get_basic_info();
    let form = |unit, has_zone| Some(Timestamp { unit, has_zone });
    if !root.is_primitive() || about.has_repetition() && about.repetition() == Repetition::REPEATED {
        return None;
    }
    match (root.get_physical_type(), about.logical_type_ref(), about.converted_type()) {
        (Physical::INT96, ..) => form(1, false),
        (Physical::INT64, Some(LogicalType::Timestamp(of)), _) => {
            let unit = match of.unit {
                TimeUnit::MILLIS => 1_000_000,
                TimeUnit::MICROS => 1000,
                TimeUnit::NANOS => 1,
            };
            form(unit, of.is_adjusted_to_u_t_c)
        }
        (Physical::INT64, None, ConvertedType::TIMESTAMP_MILLIS) => form(1_000_000, true),
        (Physical::INT64, None, ConvertedType::TIMESTAMP_MICROS) => form(1000, true),
        _ => None,
    }
}

/// Returns the reason for which a field is no column of numbers; none where it is one.
fn refusal(root: &Type) -> Option<String> {
    let about = root.get_basic_info();
    if !root.is_primitive() || about.has_repetition() && about.repetition() == Repetition::REPEATED {
        return Some("is nested".into());
    }
    let physical = root.get_physical_type();
    if !matches!(physical, Physical::BOOLEAN | Physical::INT32 | Physical::INT64 | Physical::FLOAT | Physical::DOUBLE) {
        return Some(format!("is of type {physical}"));
    }
    // Whole numbers with a special meaning.
    match (about.logical_type_ref(), about.converted_type()) {
        (None | Some(LogicalType::Integer(_) | LogicalType::Unknown), kind) => match kind {
            ConvertedType::DECIMAL
            | ConvertedType::DATE
            | ConvertedType::TIME_MILLIS
            | ConvertedType::TIME_MICROS
            | ConvertedType::TIMESTAMP_MILLIS
            | ConvertedType::TIMESTAMP_MICROS => Some(format!("is of type {kind}")),
            _ => None,
        },
        (Some(other), _) => Some(format!("is of type {other:?}")),
    }
}

impl ParquetTable {
    /// Opens the next row group; false where there is none.
    fn open_group(&mut self) -> Decoded<bool> {
        while self.left == 0 {
            if self.group == self.reader.num_row_groups() {
                return Ok(false);
            }
            let group = self.reader.get_row_group(self.group)?;
            self.left = u64::try_from(group.metadata().num_rows()).unwrap_or_default();
            for column in &mut self.selected {
                let Some(field) = self.fields.get(column.field) else { continue };
                let chunk: &ColumnChunkMetaData = group.metadata().column(field.leaf);
                self.bytes_read += page::check(&self.path, chunk)?;
                column.reader = Some(group.get_column_reader(field.leaf)?);
                column.block = Vec::new().into_iter();
            }
            self.group += 1;
        }
        Ok(true)
    }

    fn next_row(&mut self, values: &mut Vec<f64>) -> Decoded<bool> {
        if self.left == 0 && !guarded(|| self.open_group())? {
            return Ok(false);
        }
        for column in &mut self.selected {
            if column.block.len() == 0
                && let (Some(field), Some(reader)) = (self.fields.get(column.field), &mut column.reader)
            {
                let is_time = self.time == Some(column.field);
                column.block = match field.timestamp.filter(|_| is_time) {
                    Some(form) => guarded(|| decode_time(reader, field, form, &mut self.first))?.into_iter(),
                    None => guarded(|| decode(reader, field))?.into_iter(),
                };
            }
            let short = || ParquetError::General(format!("fewer values than rows, after row {}", self.row));
            values.push(column.block.next().ok_or_else(short)?);
        }
        self.left -= 1;
        Ok(true)
    }
}

/// Reads the next block of a column.
fn decode(reader: &mut ColumnReader, field: &Field) -> Decoded<Vec<f64>> {
    use ColumnReader as Of;
    match reader {
        Of::BoolColumnReader(own) => block(own, field, |x| f64::from(u8::from(x))),
        Of::Int32ColumnReader(own) if field.unsigned => block(own, field, |x| f64::from(x.cast_unsigned())),
        Of::Int32ColumnReader(own) => block(own, field, f64::from),
        Of::Int64ColumnReader(own) if field.unsigned => block(own, field, |x| x.cast_unsigned() as f64),
        Of::Int64ColumnReader(own) => block(own, field, |x| x as f64),
        Of::FloatColumnReader(own) => block(own, field, f64::from),
        Of::DoubleColumnReader(own) => block(own, field, |x| x),
        _ => Err(ParquetError::General("a column of another type than its field".into())),
    }
}

/// Reads the next block of timestamps, in seconds from the first. The differences are computed in whole nanoseconds.
fn decode_time(
    reader: &mut ColumnReader,
    field: &Field,
    form: Timestamp,
    first: &mut Option<i128>,
) -> Decoded<Vec<f64>> {
    let mut seconds = |nanoseconds: i128| {
        let first = *first.get_or_insert(nanoseconds);
        (nanoseconds - first) as f64 / 1e9
    };
    match reader {
        ColumnReader::Int64ColumnReader(own) => block(own, field, |x| seconds(i128::from(x) * form.unit)),
        ColumnReader::Int96ColumnReader(own) => block(own, field, |x| seconds(i128::from(x.to_nanos()))),
        _ => Err(ParquetError::General("a column of another type than its field".into())),
    }
}

/// Reads the next numbers, one for each row; NaN for a null.
fn block<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    field: &Field,
    number: impl FnMut(T::T) -> f64,
) -> Decoded<Vec<f64>> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    reader.read_records(BLOCK, field.optional.then_some(&mut levels), None, &mut values)?;
    let mut numbers = values.into_iter().map(number);
    if !field.optional {
        return Ok(numbers.collect());
    }
    let short = || ParquetError::General("fewer values than are not null".into());
    levels.into_iter().map(|level| if level == 0 { Ok(f64::NAN) } else { numbers.next().ok_or_else(short) }).collect()
}

impl Table for ParquetTable {
    fn columns(&self) -> &[String] {
        &self.names
    }

    fn select(&mut self, places: &[usize]) -> Result<(), RecordingError> {
        let groups = self.reader.metadata().row_groups().iter();
        let rows = groups.fold(0_u64, |sum, group| sum.saturating_add(u64::try_from(group.num_rows()).unwrap_or(0)));
        let mut lengths = Vec::new();
        let named = |place: &usize| Some((*place, self.fields.get(*place)?, self.names.get(*place)?));
        for (place, field, name) in places.iter().filter_map(named) {
            let is_time = self.time == Some(place) && field.timestamp.is_some();
            if let Some(reason) = field.refused.as_ref().filter(|_| !is_time) {
                return Err(wrong(&self.path, format!("`{name}`: {reason}")));
            }
            lengths.push((name.as_str(), rows));
        }
        equal_lengths(&self.path, &lengths)?;
        let column = |field: &usize| Column { field: *field, reader: None, block: Vec::new().into_iter() };
        self.selected = places.iter().map(column).collect();
        Ok(())
    }

    fn next(&mut self, cells: &mut Cells) -> Result<bool, RecordingError> {
        cells.values.clear();
        let more = self.next_row(&mut cells.values).map_err(|error| wrong(&self.path, error))?;
        self.row += 1;
        (cells.line, cells.whole) = (self.row, self.names.len());
        Ok(more)
    }

    fn set_time(&mut self, place: usize) {
        self.time = Some(place);
    }

    fn time_origin(&self) -> Option<TimeOrigin> {
        let form = self.fields.get(self.time?)?.timestamp?;
        Some(TimeOrigin { nanoseconds: self.first?, has_zone: form.has_zone, has_date: true })
    }

    fn bytes_read(&self) -> u64 {
        self.bytes_read
    }
}
