//! The results of a sweep as tables: CSV and Parquet, the same numbers in the same order.

use super::{Axis, Row};
use anyhow::Result;
use parquet::basic::{Compression, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::io::Write;
use std::sync::Arc;

/// One column.
enum Column {
    Number(String, Vec<Option<f64>>),
    Count(String, Vec<Option<i64>>),
    Word(String, Vec<String>),
}

fn columns(axes: &[Axis], rows: &[&Row]) -> Vec<Column> {
    let number = |name: &str, of: &dyn Fn(&Row) -> Option<f64>| {
        Column::Number(name.to_owned(), rows.iter().map(|row| of(row)).collect())
    };
    let count = |name: &str, of: &dyn Fn(&Row) -> Option<i64>| {
        Column::Count(name.to_owned(), rows.iter().map(|row| of(row)).collect())
    };
    let mut all = vec![
        count("point", &|r| i64::try_from(r.point).ok()),
        Column::Word("way".to_owned(), rows.iter().map(|r| r.way.clone()).collect()),
    ];
    for (i, axis) in axes.iter().enumerate() {
        let unit = if axis.unit.is_empty() { String::new() } else { format!("_{}", axis.unit.replace(' ', "_")) };
        all.push(number(&format!("{}{unit}", axis.key), &|r| r.values.get(i).copied()));
    }
    all.push(number("speed_rpm", &|r| Some(r.figures.speed_rpm)));
    all.push(count("held_steps", &|r| i64::try_from(r.figures.held).ok()));
    for (i, along) in ["u", "v", "w"].into_iter().enumerate() {
        all.push(number(&format!("{along}_peak_to_peak_um"), &|r| Some(r.figures.peak_to_peak[i])));
        all.push(number(&format!("{along}_mean_um"), &|r| Some(r.figures.mean[i])));
    }
    for (k, line) in ["1x", "ball_pass", "half_section", "third_section"].into_iter().enumerate() {
        for (i, along) in ["u", "v"].into_iter().enumerate() {
            all.push(number(&format!("{along}_{line}_um"), &|r| Some(r.figures.lines[k][i])));
        }
    }
    all.push(count("period", &|r| r.figures.period.and_then(|p| i64::try_from(p).ok())));
    all.push(number("lyapunov_per_s", &|r| r.figures.lyapunov));
    all
}

impl Column {
    fn name(&self) -> &str {
        match self {
            Self::Number(name, _) | Self::Count(name, _) | Self::Word(name, _) => name,
        }
    }

    fn cell(&self, i: usize) -> String {
        match self {
            Self::Number(_, values) => values.get(i).copied().flatten().map_or(String::new(), |x| format!("{x:.16e}")),
            Self::Count(_, values) => values.get(i).copied().flatten().map_or(String::new(), |x| x.to_string()),
            Self::Word(_, values) => values.get(i).cloned().unwrap_or_default(),
        }
    }

    fn physical(&self) -> Physical {
        match self {
            Self::Number(..) => Physical::DOUBLE,
            Self::Count(..) => Physical::INT64,
            Self::Word(..) => Physical::BYTE_ARRAY,
        }
    }
}

/// One row a point; an empty cell is what there is not, such as the period of a motion that does not repeat.
///
/// # Errors
/// What the writer gives.
pub fn csv(out: &mut impl Write, axes: &[Axis], rows: &[&Row]) -> Result<()> {
    let columns = columns(axes, rows);
    let names: Vec<&str> = columns.iter().map(Column::name).collect();
    writeln!(out, "{}", names.join(","))?;
    for i in 0..rows.len() {
        let cells: Vec<String> = columns.iter().map(|column| column.cell(i)).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

/// One row a section: the points of the bifurcation diagram.
///
/// # Errors
/// What the writer gives.
pub fn sections(out: &mut impl Write, rows: &[&Row]) -> Result<()> {
    writeln!(out, "point,way,section,u_um,v_um")?;
    for row in rows {
        for (k, [u, v]) in row.figures.section.iter().enumerate() {
            writeln!(out, "{},{},{k},{u:.16e},{v:.16e}", row.point, row.way)?;
        }
    }
    Ok(())
}

/// The table of [`csv()`] as Parquet, uncompressed.
///
/// # Errors
/// What the writer gives.
pub fn parquet(out: impl Write + Send, axes: &[Axis], rows: &[&Row]) -> Result<()> {
    let columns = columns(axes, rows);
    let field = |column: &Column| -> Result<Arc<Type>> {
        let field = Type::primitive_type_builder(column.name(), column.physical());
        let field = match column {
            Column::Word(..) => {
                field.with_repetition(Repetition::REQUIRED).with_logical_type(Some(parquet::basic::LogicalType::String))
            }
            _ => field.with_repetition(Repetition::OPTIONAL),
        };
        Ok(Arc::new(field.build()?))
    };
    let fields = columns.iter().map(field).collect::<Result<Vec<_>>>()?;
    let schema = Arc::new(Type::group_type_builder("sweep").with_fields(fields).build()?);
    let properties = WriterProperties::builder().set_compression(Compression::UNCOMPRESSED).build();
    let mut file = SerializedFileWriter::new(out, schema, Arc::new(properties))?;
    let mut group = file.next_row_group()?;
    for column in &columns {
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

impl Column {
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
