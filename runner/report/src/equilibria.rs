//! Equilibria over ranges of keys: text for the terminal, CSV and HTML page.

use super::figures::{NamedCurve, Shape, over};
use super::html::typeset;
use super::number::{alone, count};
use super::page::{self, Column, Fact, Page, PageSection, Table};
use anyhow::Result;
use ballrace_twin::equilibria::{EquilibriumPoint, FIGURES};
use ballrace_twin::output::quoted;
use ballrace_twin::sweep::Axis;
use std::borrow::Cow;
use std::fmt::Write;

/// Largest number of curves in a figure.
const MAX_CURVES: usize = 6;
/// Largest number of points in the table of the page; the CSV has all.
const MAX_ROWS: usize = 120;
/// Figures of the table in the terminal, which is 100 characters wide, as far as the scene has them, with their headings.
const IN_TEXT: [(&str, &str); 7] = [
    ("axial_force_N", "axial N"),
    ("largest_load_N", "element N"),
    ("largest_pressure_MPa", "peak MPa"),
    ("stiffness_x_N_um", "X N/um"),
    ("L10r_h", "L10r h"),
    ("power_W", "loss W"),
    ("inner_ring_degC", "inner degC"),
];

/// Returns the number of each figure that some point has.
fn present(points: &[EquilibriumPoint]) -> Vec<usize> {
    let has = |i: &usize| {
        points.iter().flat_map(|point| &point.bearings).any(|(_, figures)| figures.get(*i).is_some_and(Option::is_some))
    };
    (0..FIGURES.len()).filter(has).collect()
}

fn with_unit(axis: &Axis) -> String {
    if axis.unit.is_empty() { axis.key.clone() } else { format!("{}, {}", axis.key, axis.unit) }
}

/// Returns the points as a table for the terminal.
#[must_use]
pub fn text(scene: &str, axes: &[Axis], points: &[EquilibriumPoint]) -> String {
    let mut out = format!("{scene}: {} equilibria\n\n", count(points.len() as u64));
    let heading = |i: usize| IN_TEXT.iter().find(|(name, _)| *name == FIGURES[i].name).map(|(_, heading)| *heading);
    let shown: Vec<(usize, &str)> = present(points).into_iter().filter_map(|i| Some((i, heading(i)?))).collect();
    let heads = shown.iter().map(|(_, heading)| (*heading).to_owned());
    let mut rows: Vec<Vec<String>> =
        vec![axes.iter().map(with_unit).chain(["bearing".to_owned()]).chain(heads).collect()];
    for point in points {
        let values = || point.values.iter().map(|value| alone(*value));
        if let Some(failure) = &point.failure {
            rows.push(values().chain([failure.clone()]).collect());
        }
        for (name, figures) in &point.bearings {
            let figure =
                |(i, _): &(usize, &str)| figures.get(*i).copied().flatten().map_or_else(|| "-".to_owned(), alone);
            rows.push(values().chain([name.clone()]).chain(shown.iter().map(figure)).collect());
        }
    }
    let whole: Vec<&Vec<String>> = rows.iter().filter(|row| row.len() > axes.len() + 1).collect();
    let widths: Vec<usize> = (0..axes.len() + 1 + shown.len())
        .map(|i| whole.iter().filter_map(|row| row.get(i)).map(|cell| cell.chars().count()).max().unwrap_or(0))
        .collect();
    for row in &rows {
        let cells: Vec<String> = row.iter().zip(&widths).map(|(cell, width)| format!("{cell:>width$}")).collect();
        let _ = writeln!(out, "{}", cells.join("  ").trim_end());
    }
    out
}

/// Returns name and figures of each bearing of a point; a point without an equilibrium has one entry without them.
fn bearings(point: &EquilibriumPoint) -> Cow<'_, [(String, Vec<Option<f64>>)]> {
    match point.failure {
        Some(_) => vec![(String::new(), vec![None; FIGURES.len()])].into(),
        None => point.bearings.as_slice().into(),
    }
}

/// Returns all figures of all points as CSV, one row a point and bearing; a point without an equilibrium has one row with its reason.
#[must_use]
pub fn csv(axes: &[Axis], points: &[EquilibriumPoint]) -> String {
    let heads = axes.iter().map(|axis| quoted(&with_unit(axis)).to_string()).chain(["bearing".to_owned()]);
    let heads = heads.chain(FIGURES.iter().map(|figure| figure.name.to_owned())).chain(["failure".to_owned()]);
    let mut out = heads.collect::<Vec<_>>().join(",") + "\n";
    for point in points {
        let values: Vec<String> = point.values.iter().map(f64::to_string).collect();
        for (name, figures) in bearings(point).iter() {
            let figure = |x: &Option<f64>| x.map_or_else(String::new, |x| format!("{x:.16e}"));
            let failure = point.failure.as_deref().unwrap_or_default();
            let cells = values.iter().cloned().chain([quoted(name).to_string()]).chain(figures.iter().map(figure));
            let cells = cells.chain([quoted(failure).to_string()]);
            out += &(cells.collect::<Vec<_>>().join(",") + "\n");
        }
    }
    out
}

/// Returns the HTML page, one file without external references: a picture of each figure over the first key.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(scene: &str, axes: &[Axis], points: &[EquilibriumPoint]) -> Result<String> {
    let present = present(points);
    let along = axes.first().map_or_else(String::new, with_unit);
    let pictures = present.iter().map(|i| {
        let figure = &FIGURES[*i];
        over(&capital(figure.words), [&along, figure.unit], &curves(axes, points, *i))
    });
    let keys: Vec<&str> = axes.iter().map(|axis| axis.key.as_str()).collect();
    let failed = points.iter().filter(|point| point.failure.is_some()).count();
    let mut facts = vec![Fact::new("Points", count(points.len() as u64))];
    if failed > 0 {
        facts.push(Fact::new("Without an equilibrium", count(failed as u64)));
    }
    page::render(Page {
        title: scene.to_owned(),
        subtitle: format!("Static equilibria over {}", keys.join(", ")),
        facts,
        sections: vec![
            PageSection::figures("Bearings over the range", Shape::Wide, pictures.collect()),
            PageSection::table("Points", table(axes, points, &present)),
        ],
        footer: "Force on the inner ring; axes: Z along the shaft, X and Y across it.".to_owned(),
        ..Page::default()
    })
}

/// Returns a text with its first letter a capital.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Returns the curves of a figure over the first axis: one of each bearing and combination of the other axes, at most [`MAX_CURVES`].
fn curves(axes: &[Axis], points: &[EquilibriumPoint], figure: usize) -> Vec<NamedCurve> {
    let mut curves: Vec<NamedCurve> = Vec::new();
    for point in points {
        let Some(x) = point.values.first() else { continue };
        let others = axes.iter().zip(&point.values).skip(1);
        let others: String =
            others.map(|(axis, value)| format!(", {} {} {}", axis.key, alone(*value), axis.unit)).collect();
        for (bearing, figures) in &point.bearings {
            let Some(y) = figures.get(figure).copied().flatten() else { continue };
            let name = format!("{bearing}{}", others.trim_end());
            match curves.iter_mut().find(|(own, _)| *own == name) {
                Some((_, of)) => of.push((*x, y)),
                None => curves.push((name, vec![(*x, y)])),
            }
        }
    }
    curves.truncate(MAX_CURVES);
    curves
}

fn table(axes: &[Axis], points: &[EquilibriumPoint], present: &[usize]) -> Table {
    let every = points.len().div_ceil(MAX_ROWS).max(1);
    let mut heads: Vec<Column> = axes.iter().map(|axis| Column::number(with_unit(axis), "")).collect();
    heads.push(Column::name("Bearing"));
    heads.extend(present.iter().map(|i| Column::number(capital(FIGURES[*i].words), FIGURES[*i].unit)));
    heads.push(Column::words("Without an equilibrium"));
    let rows = points.iter().step_by(every).flat_map(|point| {
        let values: Vec<String> = point.values.iter().map(|value| typeset(&alone(*value))).collect();
        bearings(point).into_owned().into_iter().map(move |(name, figures)| {
            let figure =
                |i: &usize| figures.get(*i).copied().flatten().map_or_else(String::new, |x| typeset(&alone(x)));
            let cells = values.iter().cloned().chain([name]).chain(present.iter().map(figure));
            cells.chain([point.failure.clone().unwrap_or_default()]).collect::<Vec<_>>()
        })
    });
    let note = if every == 1 { String::new() } else { format!("One in {every} points; the CSV has all.") };
    Table::of(heads, rows.collect::<Vec<_>>(), note)
}
