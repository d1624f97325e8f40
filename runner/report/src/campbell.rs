//! The Campbell table for people: a text for the terminal, a page with the diagram.

use super::equilibrium::page;
use super::figures::diagram;
use anyhow::Result;
use ballrace_twin::campbell::{AtSpeed, Whirl};
use std::fmt::Write;

/// For the terminal.
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
        // A string takes all that is written.
        let _ = writeln!(out, "{:8.0} rpm {}", at.speed_rpm, modes.join(" "));
    }
    out
}

/// The page, one file without references.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn html(scene: &str, all: &[AtSpeed]) -> Result<String> {
    page(scene, "Campbell diagram", &[diagram(all)?], &text(scene, all))
}
