//! Campbell diagram: text for the terminal and HTML page.

use super::equilibrium::page;
use super::figures::{diagram, mode_shapes, rotor};
use anyhow::Result;
use ballrace_twin::campbell::{AtSpeed, ModeShape, Whirl};
use ballrace_twin::replay::outcome::RotorDrawing;
use std::fmt::Write;

/// Returns the table as text for the terminal.
#[must_use]
pub fn text(scene: &str, all: &[AtSpeed]) -> String {
    let mut out = format!("{scene}: natural frequencies in Hz (f forward, b backward whirl), damping in per cent\n\n");
    for at in all {
        let mode = |m: &ballrace_twin::campbell::Mode| {
            let whirl = match m.whirl {
                Whirl::Forward => 'f',
                Whirl::Backward => 'b',
                Whirl::Straight => ' ',
            };
            format!("{:9.2}{whirl} {:5.2}", m.frequency_hz, m.damping_ratio * 100.0)
        };
        let modes: Vec<String> = at.modes.iter().map(mode).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{:8.0} rpm {}", at.speed_rpm, modes.join(" "));
    }
    out
}

/// Returns the HTML page, one file without external references: the diagram, and the rotor with its mode shapes where there are any.
///
/// # Errors
/// Returns an error if a figure cannot be drawn.
pub fn html(scene: &str, all: &[AtSpeed], drawing: Option<&RotorDrawing>, shapes: &[ModeShape]) -> Result<String> {
    let mut pictures = vec![diagram(all)?];
    if let Some(drawing) = drawing {
        pictures.extend(mode_shapes(shapes, drawing)?);
        pictures.push(rotor(drawing)?);
    }
    page(scene, "Campbell diagram", &pictures, &text(scene, all))
}
