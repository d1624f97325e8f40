//! The text and CSV of a fit.

use ballrace_twin::fit::Fitted;
use std::fmt::Write;

/// Returns the fit as text for the terminal.
#[must_use]
pub fn text(found: &Fitted) -> String {
    let mut out = format!(
        "{} fitted to {}: {} samples, {:.1} revolutions\n\n",
        found.scene, found.recording, found.samples, found.turns
    );
    let _ = writeln!(out, "{:<28} {:>11} {:>11} {:>11} {:>11}  unit", "", "scene", "fitted", "from", "to");
    for p in &found.parameters {
        let mark = if p.identified { "" } else { "  not identifiable" };
        // A ratio has its first digit after the point.
        let digits = if p.unit.is_empty() { 6 } else { 4 };
        let end = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), |x| format!("{x:.digits$}"));
        let line = format!(
            "{:<28} {:>11.digits$} {:>11.digits$} {:>11} {:>11}  {}{mark}",
            p.name,
            p.given,
            p.value,
            end(p.low),
            end(p.high),
            p.unit
        );
        let _ = writeln!(out, "{}", line.trim_end());
    }
    if found.consistent {
        let _ = writeln!(out, "\nThe intervals have a joint confidence level of 95 %.");
    } else {
        let _ = writeln!(
            out,
            "\nWARNING: the scene does not describe the recording: chi-squared per reading is {:.3e}, expected about 1 \
             and at most {:.3} by the noise of the probes. No intervals are given.",
            found.chi_square_per_reading, found.largest_chi_square_per_reading
        );
    }
    let _ = writeln!(out, "Chi-squared of the residuals: {:.1} for {} readings.\n", found.chi_square, found.readings);
    let _ = writeln!(out, "{:<16} {:>10} {:>10} {:>10}", "residual, um rms", "scene", "fitted", "noise");
    for r in &found.residuals {
        let _ = writeln!(out, "{:<16} {:>10.4} {:>10.4} {:>10.4}", r.probe, r.before_um, r.after_um, r.noise_um);
    }
    for note in &found.notes {
        let _ = write!(out, "\n{note}\n");
    }
    out
}

/// Returns CSV with one row per parameter.
#[must_use]
pub fn csv(found: &Fitted) -> String {
    let mut out = "parameter,unit,scene,fitted,from,to,identified\n".to_owned();
    for p in &found.parameters {
        let end = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
        let (low, high) = (end(p.low), end(p.high));
        let _ = writeln!(out, "{},{},{},{},{low},{high},{}", p.name, p.unit, p.given, p.value, p.identified);
    }
    out
}
