//! The catalogue of bearings as text, CSV and JSON.

use ballrace_twin::catalogue::{Entry, all};
use serde::Serialize;
use std::fmt::Write;

/// One bearing of the catalogue; lengths in mm, orders over the shaft frequency.
#[derive(Debug, Serialize)]
pub struct Row {
    designation: &'static str,
    kind: &'static str,
    bore_mm: f64,
    outer_diameter_mm: f64,
    width_mm: f64,
    elements: usize,
    element_diameter_mm: f64,
    pitch_diameter_mm: f64,
    contact_angle_deg: f64,
    outer_race_order: f64,
    inner_race_order: f64,
    ball_spin_order: f64,
    cage_order: f64,
    status: &'static str,
    source: &'static str,
}

/// Returns the bearings in the order of the catalogue.
#[must_use]
pub fn rows() -> Vec<Row> {
    all().iter().map(row).collect()
}

fn row(entry: &Entry) -> Row {
    let orders = entry.orders();
    Row {
        designation: entry.designation,
        kind: entry.kind.name(),
        bore_mm: entry.bore,
        outer_diameter_mm: entry.outer_diameter,
        width_mm: entry.width,
        elements: entry.elements,
        element_diameter_mm: entry.element_diameter,
        pitch_diameter_mm: entry.pitch_diameter,
        contact_angle_deg: entry.contact_angle,
        outer_race_order: orders.outer_race,
        inner_race_order: orders.inner_race,
        ball_spin_order: orders.ball_spin,
        cage_order: orders.cage,
        status: entry.status.name(),
        source: entry.source,
    }
}

/// Returns the catalogue as a table for the terminal.
#[must_use]
pub fn text() -> String {
    let mut out =
        "bearing  d x D x B, mm       Z  Dw, mm   dm, mm  angle   outer   inner    ball    cage  numbers\n".to_owned();
    for row in rows() {
        let size = format!("{} x {} x {}", row.bore_mm, row.outer_diameter_mm, row.width_mm);
        let _ = writeln!(
            out,
            "{:<8} {size:<17} {:>3} {:>7} {:>8} {:>6} {:>7.3} {:>7.3} {:>7.3} {:>7.4}  {}",
            row.designation,
            row.elements,
            row.element_diameter_mm,
            row.pitch_diameter_mm,
            row.contact_angle_deg,
            row.outer_race_order,
            row.inner_race_order,
            row.ball_spin_order,
            row.cage_order,
            row.status
        );
    }
    out
}

/// Returns the catalogue as CSV.
#[must_use]
pub fn csv() -> String {
    let mut out = "designation,kind,bore_mm,outer_diameter_mm,width_mm,elements,element_diameter_mm,pitch_diameter_mm,\
                   contact_angle_deg,outer_race_order,inner_race_order,ball_spin_order,cage_order,status,source\n"
        .to_owned();
    for row in rows() {
        let _ = writeln!(
            out,
            "{},{},{},{},{},{},{},{},{},{},{},{},{},{},\"{}\"",
            row.designation,
            row.kind,
            row.bore_mm,
            row.outer_diameter_mm,
            row.width_mm,
            row.elements,
            row.element_diameter_mm,
            row.pitch_diameter_mm,
            row.contact_angle_deg,
            row.outer_race_order,
            row.inner_race_order,
            row.ball_spin_order,
            row.cage_order,
            row.status,
            row.source
        );
    }
    out
}
