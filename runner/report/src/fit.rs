//! A fit in words.

use ballrace_twin::fit::Fitted;
use std::fmt::Write;

/// For people.
#[must_use]
pub fn text(found: &Fitted) -> String {
    let mut out = format!(
        "{} fitted to {}: {} samples, {:.1} turns\n\n",
        found.scene, found.recording, found.samples, found.turns
    );
    let _ = writeln!(out, "{:<28} {:>11} {:>11} {:>11} {:>11}  unit", "", "scene", "fitted", "from", "to");
    for p in &found.parameters {
        let mark = if p.told { "" } else { "  not told" };
        let _ = writeln!(
            out,
            "{:<28} {:>11.4} {:>11.4} {:>11.4} {:>11.4}  {}{mark}",
            p.name, p.given, p.value, p.low, p.high, p.unit
        );
    }
    let _ = writeln!(out, "\nThe intervals hold together in 95 of 100 cases.");
    let _ = writeln!(
        out,
        "Squares of what is left over those of the noise: {:.1} for {} readings.\n",
        found.chi_square, found.readings
    );
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
    let mut out = "parameter,unit,scene,fitted,from,to,told\n".to_owned();
    for p in &found.parameters {
        let _ = writeln!(out, "{},{},{},{},{},{},{}", p.name, p.unit, p.given, p.value, p.low, p.high, p.told);
    }
    out
}
