//! A fit as text, CSV and HTML page.

use super::figures::{Shape, changes, residuals};
use super::html::typeset;
use super::number::{count, fixed};
use super::page::{self, Column, Fact, Level, Page, PageSection, Row, Table, Verdict};
use anyhow::Result;
use ballrace_twin::fit::{Estimate, Fitted};
use ballrace_twin::outcome::ReadingOutcome;
use ballrace_twin::output::quoted;
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
            "\nWARNING: the scene does not describe the recording: chi-squared per {} is {:.3e}, expected about 1 \
             and at most {:.3} by the noise of the probes. No intervals are given.",
            one(found),
            found.chi_square_per_reading,
            found.largest_chi_square_per_reading
        );
    }
    let _ = writeln!(
        out,
        "Chi-squared of the residuals: {:.1} for {} {}s.\n",
        found.chi_square,
        found.readings,
        one(found)
    );
    let _ = writeln!(out, "{:<16} {:>10} {:>10} {:>10}", "residual, um rms", "scene", "fitted", "noise");
    for r in &found.residuals {
        let _ = writeln!(out, "{:<16} {:>10.4} {:>10.4} {:>10.4}", r.probe, r.before_um, r.after_um, r.noise_um);
    }
    if !found.errors.is_empty() {
        let _ = writeln!(
            out,
            "\n{:<16} {:>10} {:>10} {:>10} {:>10} {:>10}",
            "errors of reading", "gap, um", "drift, um", "run-out", "hum, um", "hum, Hz"
        );
    }
    for e in &found.errors {
        let _ = writeln!(
            out,
            "{:<16} {:>10.2} {:>10.2} {:>10.3} {:>10.3} {:>10.0}",
            e.probe, e.gap_um, e.drift_um, e.run_out_um, e.hum_um, e.hum_hz
        );
    }
    for note in &found.notes {
        let _ = write!(out, "\n{note}\n");
    }
    out
}

/// Returns the name of a value of the residual: a reading, or at a site one of the spectra of the readings.
fn one(found: &Fitted) -> &'static str {
    if found.errors.is_empty() { "reading" } else { "value" }
}

/// Returns CSV with one row per parameter.
#[must_use]
pub fn csv(found: &Fitted) -> String {
    let mut out = "parameter,unit,scene,fitted,from,to,identified\n".to_owned();
    for p in &found.parameters {
        let end = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
        let (low, high) = (end(p.low), end(p.high));
        let _ = writeln!(out, "{},{},{},{},{low},{high},{}", quoted(&p.name), p.unit, p.given, p.value, p.identified);
    }
    out
}

/// Returns the HTML page, one file without external references: verdict, residuals, changes with their intervals, tables.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(found: &Fitted) -> Result<String> {
    let figures = [residuals(found)].into_iter().chain(changes(found)).collect();
    let mut sections = vec![
        PageSection::figures("Residuals and changes", Shape::Wide, figures),
        PageSection::table("Parameters", parameter_table(&found.parameters)),
        PageSection::table("Residual at each probe", residual_table(found)),
    ];
    if !found.errors.is_empty() {
        sections.push(PageSection::table("Errors of the readings", error_table(&found.errors)));
    }
    if !found.notes.is_empty() {
        sections.push(PageSection::list("Notes", found.notes.clone()));
    }
    page::render(Page {
        title: found.scene.clone(),
        subtitle: format!("Scene fitted to {}", found.recording),
        verdict: Some(verdict(found)),
        facts: vec![
            Fact::new("Samples", count(found.samples as u64)),
            Fact::new("Revolutions", fixed(found.turns, 1)),
            Fact::new(
                "Chi-squared",
                format!("{} for {} {}s", fixed(found.chi_square, 1), count(found.readings as u64), one(found)),
            ),
        ],
        sections,
        footer:
            "Maximum-likelihood estimates. Chi-squared: sum of the squared residuals in units of the probes' noise."
                .to_owned(),
        ..Page::default()
    })
}

fn verdict(found: &Fitted) -> Verdict {
    let [per_reading, largest] = [found.chi_square_per_reading, found.largest_chi_square_per_reading];
    let unidentified = found.parameters.iter().filter(|p| !p.identified).count();
    if !found.consistent {
        return Verdict {
            level: Level::Amber,
            word: "SCENE DOES NOT DESCRIBE THE RECORDING",
            sentence: format!(
                "Chi-squared per {} is {per_reading:.3e}; about 1 is expected and at most {largest:.3} by the noise of the \
                 probes. No intervals are given.",
                one(found)
            ),
            action: "add what the scene lacks (fault, clearance, load), check the noise of the probes, or fit a recording of the \
                     machine in good order."
                .to_owned(),
        };
    }
    let unidentified = match unidentified {
        0 => String::new(),
        1 => " 1 parameter is not identifiable from this recording.".to_owned(),
        n => format!(" {n} parameters are not identifiable from this recording."),
    };
    Verdict {
        level: Level::Green,
        word: "SCENE DESCRIBES THE RECORDING",
        sentence: format!(
            "Chi-squared per {} is {per_reading:.3}, at most {largest:.3} by the noise of the probes.{unidentified}",
            one(found)
        ),
        action: String::new(),
    }
}

fn parameter_table(parameters: &[Estimate]) -> Table {
    let mut table = Table {
        groups: vec![(4, ""), (2, "95 % interval"), (1, "")],
        columns: vec![
            Column::name("Parameter"),
            Column::name("Unit"),
            Column::number("Scene", ""),
            Column::number("Fitted", ""),
            Column::number("From", ""),
            Column::number("To", ""),
            Column::name("Identifiable"),
        ],
        note: "The intervals have a joint confidence level of 95 %.".to_owned(),
        ..Table::default()
    };
    for p in parameters {
        // A ratio has its first digit after the point.
        let digits = if p.unit.is_empty() { 6 } else { 4 };
        let shown = |x: Option<f64>| typeset(&fixed(x.unwrap_or(f64::NAN), digits));
        let values = [Some(p.given), Some(p.value), p.low, p.high].map(shown);
        let cells = [p.name.clone(), p.unit.to_owned()].into_iter().chain(values);
        table.push(Row::new(cells.chain([if p.identified { "yes" } else { "no" }.to_owned()])));
    }
    table
}

fn error_table(errors: &[ReadingOutcome]) -> Table {
    let columns = vec![
        Column::name("Probe"),
        Column::number("Gap", "um"),
        Column::number("Drift", "um"),
        Column::number("Run-out", "um rms"),
        Column::number("Hum", "um"),
        Column::number("Hum", "Hz"),
    ];
    let row = |e: &ReadingOutcome| {
        let lengths = [e.gap_um, e.drift_um, e.run_out_um, e.hum_um].map(|x| typeset(&fixed(x, 3)));
        [e.probe.clone()].into_iter().chain(lengths).chain([fixed(e.hum_hz, 0)]).collect::<Vec<_>>()
    };
    Table::of(columns, errors.iter().map(row), "Beyond the offsets and the run-out at slow roll.")
}

fn residual_table(found: &Fitted) -> Table {
    let columns = vec![
        Column::name("Probe"),
        Column::number("Scene", "um rms"),
        Column::number("Fitted", "um rms"),
        Column::number("Noise", "um rms"),
    ];
    let row = |r: &ballrace_twin::fit::Residual| {
        let values = [r.before_um, r.after_um, r.noise_um].map(|x| typeset(&fixed(x, 4)));
        [r.probe.clone()].into_iter().chain(values).collect::<Vec<_>>()
    };
    Table::of(columns, found.residuals.iter().map(row), "")
}
