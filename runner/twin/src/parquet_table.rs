//! Columns of equal length as a Parquet file, uncompressed.

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::Result;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// One column.
pub enum Column {
    /// Column of numbers.
    Number(String, Vec<Option<f64>>),
    /// Column of whole numbers.
    Count(String, Vec<Option<i64>>),
    /// Column of text.
    Word(String, Vec<String>),
}

impl Column {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Number(name, _) | Self::Count(name, _) | Self::Word(name, _) => name,
        }
    }

    fn field(&self) -> Result<Arc<Type>> {
        let physical = match self {
            Self::Number(..) => Physical::DOUBLE,
            Self::Count(..) => Physical::INT64,
            Self::Word(..) => Physical::BYTE_ARRAY,
        };
        let field = Type::primitive_type_builder(self.name(), physical);
        let field = match self {
            Self::Word(..) => field.with_repetition(Repetition::REQUIRED).with_logical_type(Some(LogicalType::String)),
            _ => field.with_repetition(Repetition::OPTIONAL),
        };
        Ok(Arc::new(field.build()?))
    }

    fn write<W: Write + Send>(&self, group: &mut SerializedRowGroupWriter<'_, W>) -> Result<()> {
        let Some(mut writer) = group.next_column()? else { return Ok(()) };
        match self {
            Self::Number(_, values) => {
                let (there, which) = split(values);
                writer.typed::<DoubleType>().write_batch(&there, Some(&which), None)?;
            }
            Self::Count(_, values) => {
                let (there, which) = split(values);
                writer.typed::<Int64Type>().write_batch(&there, Some(&which), None)?;
            }
            Self::Word(_, values) => {
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
    let properties = WriterProperties::builder().set_compression(Compression::UNCOMPRESSED).build();
    let mut file = SerializedFileWriter::new(out, schema, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for column in columns {
        column.write(&mut group)?;
    }
    group.close()?;
    file.close()?;
    Ok(())
}

/// Those that are there, and for each row whether it is.
fn split<A: Copy>(values: &[Option<A>]) -> (Vec<A>, Vec<i16>) {
    (values.iter().copied().flatten().collect(), values.iter().map(|x| i16::from(x.is_some())).collect())
}
