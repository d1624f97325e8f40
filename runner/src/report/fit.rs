//! A fit in words.

use crate::fit::Fitted;
use std::fmt::Write;

/// For people.
#[must_use]
pub fn text(found: &Fitted) -> String {
    let mut out = format!(
        "{} fitted to {}: {} samples, {:.1} turns\n\n",
        found.scene, found.recording, found.samples, found.turns
    );
    let _ = writeln!(out, "{:<32} {:>12} {:>12} {:>10}  unit", "", "scene", "fitted", "+-");
    for p in &found.parameters {
        let mark = if p.told { "" } else { "  not told" };
        let _ = writeln!(
            out,
            "{:<32} {:>12.4} {:>12.4} {:>10.4}  {}{mark}",
            p.name, p.given, p.value, p.plus_minus, p.unit
        );
    }
    let _ = writeln!(out, "\nThe intervals hold together in 95 of 100 cases.\n");
    let _ = writeln!(out, "{:<16} {:>10} {:>10} {:>10}", "left, um rms", "scene", "fitted", "noise");
    for r in &found.residuals {
        let _ = writeln!(out, "{:<16} {:>10.4} {:>10.4} {:>10.4}", r.probe, r.before_um, r.after_um, r.noise_um);
    }
    for note in &found.notes {
        let _ = write!(out, "\n{note}\n");
    }
    out
}

/// One row a number.
#[must_use]
pub fn csv(found: &Fitted) -> String {
    let mut out = "parameter,unit,scene,fitted,plus_minus,told\n".to_owned();
    for p in &found.parameters {
        let _ = writeln!(out, "{},{},{},{},{},{}", p.name, p.unit, p.given, p.value, p.plus_minus, p.told);
    }
    out
}
