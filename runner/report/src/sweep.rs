//! HTML page of a sweep: response curve, bifurcation diagram, waterfall.

use super::figures::{Curve, Shape, bifurcation, response, waterfall};
use super::html::{column, rows as table_rows, typeset};
use super::number::{count, counted, fixed};
use super::page::{self, Column, Fact, Page, PageSection, Table};
use anyhow::Result;
use ballrace_twin::sweep::{Axis, Row};

/// Largest number of curves in a figure.
const MAX_CURVES: usize = 6;
/// Largest number of rows in the table of the page; the files contain all points.
const MAX_ROWS: usize = 120;

/// Returns the HTML page, one file without external references.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(scene: &str, axes: &[Axis], rows: &[&Row]) -> Result<String> {
    let page = Page { title: scene.to_owned(), ..Page::default() };
    let Some(first) = axes.first() else { return page::render(page) };
    let title = format!("{}{}", first.key, with_unit(&first.unit));
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for row in rows.iter().filter(|row| row.figures.overflow.is_none()) {
        let name = named(axes, row);
        match curves.iter_mut().find(|curve| curve.name == name && curve.direction == row.direction) {
            Some(curve) => curve.rows.push(row),
            None => curves.push(Curve { name, direction: row.direction.clone(), rows: vec![row] }),
        }
    }
    for curve in &mut curves {
        curve.rows.sort_by(|a, b| along(a).total_cmp(&along(b)));
    }
    let all = curves.len();
    curves.truncate(MAX_CURVES);
    let mut pictures = vec![response(&title, &curves), bifurcation(&title, &curves)];
    pictures.extend(curves.first().map(|curve| waterfall(&title, curve)));
    let swept: Vec<String> = axes.iter().map(range).collect();
    let mut facts = vec![Fact::new("Points", count(rows.len() as u64)), Fact::new("Over", swept.join("; "))];
    let overflowed = rows.iter().filter(|row| row.figures.overflow.is_some()).count();
    if overflowed > 0 {
        facts.push(Fact::new("The motion overflows", format!("at {}", counted(overflowed as u64, "point"))));
    }
    if all > MAX_CURVES {
        let shown = format!("{MAX_CURVES} of {all} curves; the tables contain all");
        facts.push(Fact::new("In the figures", shown));
    }
    let keys: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
    page::render(Page {
        subtitle: format!("Sweep over {}", keys.join(", ")),
        facts,
        sections: vec![
            PageSection::figures("Motion over the sweep", Shape::Wide, pictures),
            PageSection::table("Points", points(axes, rows)),
        ],
        footer:
            "Motion of the rotor's centre of mass after it has settled. Section: the motion is sampled once per period."
                .to_owned(),
        ..page
    })
}

/// Describes the values of an axis.
fn range(axis: &Axis) -> String {
    let ends = [axis.values.first(), axis.values.last()].map(|end| end.copied().unwrap_or(f64::NAN));
    format!(
        "{} from {} to {} {}, {} values",
        axis.key,
        significant(ends[0]),
        significant(ends[1]),
        axis.unit,
        axis.values.len()
    )
}

/// Returns the points as a table, evenly thinned where there are many.
fn points(axes: &[Axis], rows: &[&Row]) -> Table {
    let every = rows.len().div_ceil(MAX_ROWS).max(1);
    let rows: Vec<&&Row> = rows.iter().step_by(every).collect();
    let mut columns = vec![Column::number("Point", "")];
    columns.extend(axes.iter().map(|axis| Column::number(format!("{}{}", axis.key, with_unit(&axis.unit)), "")));
    columns.extend([
        Column::name("Start"),
        Column::number("Speed", "rpm"),
        Column::number("X", "um pp"),
        Column::number("Y", "um pp"),
        Column::number("1X along X", "um peak"),
        Column::number("1X along Y", "um peak"),
        Column::number("Period", "sections"),
    ]);
    let has_exponents = rows.iter().any(|row| row.figures.lyapunov.is_some());
    columns.extend(has_exponents.then(|| Column::number("Lyapunov exponent", "1/s")));
    let of = |value: &dyn Fn(&Row) -> f64| column(rows.iter().map(|row| value(row)));
    let direction =
        |row: &&&Row| if row.direction == "rest" { "from equilibrium".to_owned() } else { row.direction.clone() };
    let period = |row: &&&Row| match (&row.figures.overflow, row.figures.period) {
        (Some(_), _) => "overflows".to_owned(),
        (None, Some(period)) => period.to_string(),
        (None, None) => "none".to_owned(),
    };
    let exponent = |row: &&&Row| typeset(&fixed(row.figures.lyapunov.unwrap_or(f64::NAN), 3));
    let mut cells: Vec<Vec<String>> = (0..axes.len())
        .map(|k| {
            rows.iter().map(|row| typeset(&row.values.get(k).map_or_else(String::new, |x| significant(*x)))).collect()
        })
        .collect();
    cells.push(rows.iter().map(direction).collect());
    cells.push(of(&|row| row.figures.speed_rpm));
    cells.extend((0..2).map(|k| of(&|row| row.figures.peak_to_peak[k])));
    cells.extend((0..2).map(|k| of(&|row| row.figures.lines[0][k])));
    cells.push(rows.iter().map(period).collect());
    cells.extend(has_exponents.then(|| rows.iter().map(exponent).collect()));
    let note = match every {
        1 => String::new(),
        every => format!("One in {every} points; the CSV and Parquet files contain all."),
    };
    let numbers = rows.iter().map(|row| row.point.to_string());
    Table::of(columns, table_rows(numbers, &cells), note)
}

/// Formats a value of an axis with six significant digits.
fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    rounded.to_string()
}

fn with_unit(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(", {unit}") }
}

fn along(row: &Row) -> f64 {
    row.values.first().copied().unwrap_or(0.0)
}

/// Names a curve by the values of the other axes and the direction.
fn named(axes: &[Axis], row: &Row) -> String {
    let others = axes.iter().zip(&row.values).skip(1).map(|(axis, value)| {
        let key = axis.key.rsplit('.').next().unwrap_or(&axis.key);
        format!("{key} {value} {}", axis.unit).trim_end().to_owned()
    });
    let direction = (row.direction != "rest").then(|| row.direction.clone());
    let all: Vec<String> = others.chain(direction).collect();
    if all.is_empty() { "from equilibrium".to_owned() } else { all.join(", ") }
}
