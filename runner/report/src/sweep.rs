//! HTML page of a sweep: response curve, bifurcation diagram, waterfall.

use super::equilibrium::page;
use super::figures::{Curve, bifurcation, response, waterfall};
use anyhow::Result;
use ballrace_twin::sweep::{Axis, Row};

/// Largest number of curves in a figure.
const MAX_CURVES: usize = 6;

/// Returns the HTML page, one file without external references.
///
/// # Errors
/// Returns an error if a figure cannot be drawn.
pub fn html(scene: &str, axes: &[Axis], rows: &[&Row]) -> Result<String> {
    let Some(first) = axes.first() else { return page(scene, "sweep", &[], "") };
    let title = if first.unit.is_empty() { first.key.clone() } else { format!("{}, {}", first.key, first.unit) };
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for row in rows {
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
    let mut pictures = vec![response(&title, &curves)?, bifurcation(&title, &curves)?];
    if let Some(curve) = curves.first() {
        pictures.push(waterfall(&title, curve)?);
    }
    let mut words =
        format!("{} points over {}.", rows.len(), axes.iter().map(|a| a.key.as_str()).collect::<Vec<_>>().join(", "));
    if all > MAX_CURVES {
        words += &format!(" The figures show {MAX_CURVES} of {all} curves; the tables contain all.");
    }
    page(scene, "sweep", &pictures, &words)
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
