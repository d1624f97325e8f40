//! The results of a sweep as tables: CSV and Parquet, the same numbers in the same order.

use ballrace_base::output::quoted;
use ballrace_recording::parquet_table::{self, Column, Values};
use std::io::Write;

use super::{Axis, Row};

fn columns(axes: &[Axis], rows: &[&Row]) -> Vec<Column> {
    let number = |name: &str, of: &dyn Fn(&Row) -> Option<f64>| {
        Column::new(name, Values::Number(rows.iter().map(|row| of(row).filter(|x| !x.is_nan())).collect()))
    };
    let count = |name: &str, of: &dyn Fn(&Row) -> Option<i64>| {
        Column::new(name, Values::Count(rows.iter().map(|row| of(row)).collect()))
    };
    let mut all = vec![
        count("point", &|r| i64::try_from(r.point).ok()),
        Column::new("direction", Values::Word(rows.iter().map(|r| r.direction.clone()).collect())),
    ];
    for (i, axis) in axes.iter().enumerate() {
        let unit = if axis.unit.is_empty() { String::new() } else { format!("_{}", axis.unit.replace(' ', "_")) };
        let values = number(&format!("{}{unit}", axis.key), &|r| r.values.get(i).copied());
        all.push(values.with_unit(&axis.unit));
    }
    all.push(number("speed_rpm", &|r| Some(r.figures.speed_rpm)));
    for (i, along) in ["u", "v", "w"].into_iter().enumerate() {
        all.push(number(&format!("{along}_peak_to_peak_um"), &|r| Some(r.figures.peak_to_peak[i])));
        all.push(number(&format!("{along}_mean_um"), &|r| Some(r.figures.mean[i])));
    }
    for (k, line) in ["one_x", "ball_pass", "half_section", "third_section"].into_iter().enumerate() {
        for (i, along) in ["u", "v"].into_iter().enumerate() {
            all.push(number(&format!("{along}_{line}_um"), &|r| Some(r.figures.lines[k][i])));
        }
    }
    all.push(count("period", &|r| r.figures.period.and_then(|p| i64::try_from(p).ok())));
    all.push(number("lyapunov_per_s", &|r| r.figures.lyapunov));
    let overflow = |row: &&Row| row.figures.overflow.clone().unwrap_or_default();
    all.push(Column::new("overflow", Values::Word(rows.iter().map(overflow).collect())));
    all
}

fn cell(column: &Column, i: usize) -> String {
    match &column.values {
        Values::Number(values) => values.get(i).copied().flatten().map_or(String::new(), |x| format!("{x:.16e}")),
        Values::Count(values) | Values::Time(values) => {
            values.get(i).copied().flatten().map_or(String::new(), |x| x.to_string())
        }
        Values::Word(values) => values.get(i).map(|text| quoted(text)).unwrap_or_default(),
    }
}

/// Writes one row per point; absent values, such as the period of a motion that does not repeat and all measures of one that
/// overflows, are empty cells.
///
/// # Errors
/// Returns the writer's error.
pub fn csv(out: &mut impl Write, axes: &[Axis], rows: &[&Row]) -> std::io::Result<()> {
    let columns = columns(axes, rows);
    let names: Vec<String> = columns.iter().map(|column| quoted(&column.name)).collect();
    writeln!(out, "{}", names.join(","))?;
    for i in 0..rows.len() {
        let cells: Vec<String> = columns.iter().map(|column| cell(column, i)).collect();
        writeln!(out, "{}", cells.join(","))?;
    }
    Ok(())
}

/// Writes one row per section: the points of the bifurcation diagram.
///
/// # Errors
/// Returns the writer's error.
pub fn sections(out: &mut impl Write, rows: &[&Row]) -> std::io::Result<()> {
    writeln!(out, "point,direction,section,u_um,v_um")?;
    for row in rows {
        for (k, [u, v]) in row.figures.section.iter().enumerate() {
            writeln!(out, "{},{},{k},{u:.16e},{v:.16e}", row.point, row.direction)?;
        }
    }
    Ok(())
}

/// Writes the table of [`csv()`] as Parquet, uncompressed.
///
/// # Errors
/// Returns the writer's error.
pub fn parquet(out: impl Write + Send, axes: &[Axis], rows: &[&Row]) -> parquet::errors::Result<()> {
    parquet_table::write(out, "sweep", &columns(axes, rows))
}
