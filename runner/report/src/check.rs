//! Result of `check`: a drawing of the machine in text characters, the recording, and each implausibility.

use super::figures::rotor;
use super::number::{alone, count, fixed};
use super::text::broken;
use super::words;
use ballrace_twin::check::{Checked, Implausibility, ProbeCentre, RecordingSummary, UnknownValue};
use ballrace_twin::outcome::{DrawnProbe, RotorDrawing};
use std::fmt::Write;

/// Width of the drawing, characters.
const WIDTH: usize = 90;
/// Columns of the drawing in which the shaft lies.
const SHAFT: [usize; 2] = [8, WIDTH - 9];

/// Returns the result as text for the terminal.
#[must_use]
pub fn text(checked: &Checked) -> String {
    let mut out = format!("{}\n", checked.scene);
    if let Some(drawing) = &checked.drawing {
        let _ = write!(out, "\n{}", sketch(drawing));
    }
    let _ = writeln!(out, "\nBearing    designation  model                Z   outer   inner    cage");
    for bearing in &checked.bearings {
        let [outer, inner, cage] = bearing.orders.map(|order| fixed(order, 4));
        let designation = bearing.designation.as_deref().unwrap_or("-");
        let (name, model, z) = (&bearing.name, bearing.model, bearing.elements);
        let _ = writeln!(out, "{name:<10} {designation:<12} {model:<19} {z:>2} {outer:>7} {inner:>7} {cage:>7}");
    }
    if let Some(recording) = &checked.recording {
        out.push_str(&of_recording(recording));
    }
    if let Some(rotor) = &checked.rotor {
        paragraph(&mut out, "\n", &words::reduced_rotor(rotor), "");
    }
    for note in &checked.notes {
        paragraph(&mut out, "\n", note, "");
    }
    out.push('\n');
    match checked.implausible.len() {
        0 => out.push_str("Nothing implausible found.\n"),
        n => {
            let _ = writeln!(out, "NOT PLAUSIBLE: {n}");
            checked.implausible.iter().for_each(|one| implausible(&mut out, one));
        }
    }
    out
}

fn implausible(out: &mut String, one: &Implausibility) {
    paragraph(out, "- ", &format!("{}: {}", one.subject, one.found), "  ");
    paragraph(out, "  Probable cause: ", &one.cause, "    ");
    paragraph(out, "  Remedy: ", &one.remedy, "    ");
}

/// Writes lines of at most [`WIDTH`] characters, the first after `lead` and the others after `indent`.
fn paragraph(out: &mut String, lead: &str, text: &str, indent: &str) {
    for (i, line) in broken(&format!("{}{text}", lead.trim_start_matches(['\n', ' '])), WIDTH - 4).iter().enumerate() {
        let start: String = lead.chars().take_while(|c| c.is_whitespace()).collect();
        let _ = writeln!(out, "{}{line}", if i == 0 { start.as_str() } else { indent });
    }
}

fn of_recording(recording: &RecordingSummary) -> String {
    let mut out = format!(
        "\n{}: {} samples at {} Hz, {} s\n",
        recording.file,
        count(recording.samples),
        alone(recording.rate_hz),
        fixed(recording.seconds, 3)
    );
    let source = if recording.speed_is_measured { "measured" } else { "of the scene, not measured" };
    if let Some([least, mean, greatest]) = recording.speed_rpm {
        let [least, mean, greatest] = [least, mean, greatest].map(|rpm| fixed(rpm, 1));
        let _ = writeln!(out, "Shaft speed, rpm: mean {mean}, {least} to {greatest} ({source})");
    }
    paragraph(&mut out, "", &format!("Shaft angle from: {}", recording.angle_source), "");
    let _ = writeln!(out, "\n{:<20} unit       mean        rms   peak to peak         1X    lag, deg", "Column");
    for reading in &recording.readings {
        let [mean, rms, peak] = [reading.mean, reading.rms, reading.peak_to_peak].map(|x| fixed(x, 3));
        let [size, lag] = reading
            .one_x
            .map_or_else(|| ["-".to_owned(), "-".to_owned()], |[size, lag]| [fixed(size, 3), fixed(lag, 1)]);
        let (column, unit) = (&reading.column, &reading.unit);
        let _ = writeln!(out, "{column:<20} {unit:<5} {mean:>9} {rms:>10} {peak:>14} {size:>10} {lag:>11}");
    }
    for reading in &recording.readings {
        let Some(voltage) = reading.voltage else { continue };
        let [offset, mean] = [voltage.offset_v, voltage.mean_v].map(|volts| fixed(volts, 3));
        let sensitivity = alone(voltage.sensitivity_mv_per_um);
        let column = &reading.column;
        let _ = writeln!(out, "{column}: {sensitivity} mV/um, mean voltage {mean} V, offset {offset} V");
    }
    for ProbeCentre { column, mean_um, equilibrium_um, half_clearance_um, offset_um } in &recording.centres {
        let [mean, equilibrium, offset] = [mean_um, equilibrium_um, offset_um].map(|um| fixed(*um, 1));
        let clearance = half_clearance_um.map_or_else(String::new, |um| format!(", clearance +-{} um", fixed(um, 1)));
        let text = format!(
            "{column}: mean {mean} um{clearance}, static equilibrium {equilibrium} um; offset = \"{offset} um\" makes them equal"
        );
        paragraph(&mut out, "", &text, "  ");
    }
    if let Some(note) = &recording.run_out {
        paragraph(&mut out, "", &format!("1X without run-out: {note}"), "");
    }
    for flaw in &recording.flaws {
        paragraph(&mut out, "", &flaw.sentence, "");
    }
    out
}

/// Returns the values of a draft that are still unknown, one per line.
#[must_use]
pub fn unknown(file: &str, values: &[UnknownValue]) -> String {
    let mut out = String::new();
    for UnknownValue { line, text, hint } in values {
        let hint = if hint.is_empty() { String::new() } else { format!("   # {hint}") };
        let _ = writeln!(out, "{file}:{line}: {text}{hint}");
    }
    out
}

/// Returns the drawing of the rotor as SVG; `None` without a rotor.
#[must_use]
pub fn svg(checked: &Checked) -> Option<String> {
    checked.drawing.as_ref().map(|drawing| rotor(drawing).drawing.file())
}

/// Returns the side view of the rotor in text characters: probes above, bearings on the shaft, names and legend below.
fn sketch(drawing: &RotorDrawing) -> String {
    let probes: Vec<&DrawnProbe> = drawing.probes.iter().filter(|probe| probe.angle_deg.is_some()).collect();
    let sections = drawing.sections.iter().flat_map(|section| section.ends_mm);
    let disks = drawing.disks.iter().map(|disk| disk.station_mm);
    let bearings = drawing.bearings.iter().map(|(_, station)| *station);
    let stations: Vec<f64> =
        sections.chain(disks).chain(bearings).chain(probes.iter().map(|probe| probe.station_mm)).collect();
    let (least, most) = stations.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    let [left, right] = SHAFT;
    let place = |station: f64| {
        let share = if most > least { (station - least) / (most - least) } else { 0.5 };
        left + (share * (right - left) as f64).round() as usize
    };
    let mut shaft = vec![' '; WIDTH];
    shaft.get_mut(left - 3..=right + 3).unwrap_or_default().fill('=');
    let mut above = Vec::new();
    for probe in &probes {
        let angle = probe.angle_deg.map_or_else(String::new, |angle| format!(" {angle:.0}°"));
        above.push((place(probe.station_mm), format!("{}{angle}", probe.name)));
    }
    let mut below: Vec<(usize, String)> = Vec::new();
    for disk in &drawing.disks {
        put(&mut shaft, place(disk.station_mm), "|");
        below.push((place(disk.station_mm), "disk".to_owned()));
    }
    put(&mut shaft, place(drawing.centre_of_mass_mm), "o");
    for (name, station) in &drawing.bearings {
        put(&mut shaft, place(*station), "[X]");
        below.push((place(*station), format!("{name} {station:.0} mm")));
    }
    let (names, mut marks) = (rows(&above), vec![' '; WIDTH]);
    above.iter().for_each(|(at, _)| put(&mut marks, *at, "v"));
    let line = |cells: &[char]| format!("{}\n", cells.iter().collect::<String>().trim_end());
    let mut out: String = names.iter().rev().map(|row| line(row)).collect();
    if !above.is_empty() {
        out.push_str(&line(&marks));
    }
    out.push_str(&line(&shaft));
    rows(&below).iter().for_each(|row| out.push_str(&line(row)));
    let axial: Vec<&str> =
        drawing.probes.iter().filter(|probe| probe.angle_deg.is_none()).map(|probe| probe.name.as_str()).collect();
    out.push_str("Z to the right; [X] bearing, o centre of mass, v radial probe with its angle from +X to +Y.");
    if !axial.is_empty() {
        let _ = write!(out, " Axial: {}.", axial.join(", "));
    }
    out.push('\n');
    out
}

/// Writes text into a line of characters, centred on a column.
fn put(line: &mut [char], at: usize, text: &str) {
    let start = at.saturating_sub(text.chars().count() / 2);
    for (cell, c) in line.iter_mut().skip(start).zip(text.chars()) {
        *cell = c;
    }
}

/// Places names in as few rows as possible without overlap.
fn rows(names: &[(usize, String)]) -> Vec<Vec<char>> {
    let mut rows: Vec<Vec<char>> = Vec::new();
    for (at, name) in names {
        let length = name.chars().count();
        let start = at.saturating_sub(length / 2).min(WIDTH.saturating_sub(length));
        let free = |row: &Vec<char>| row.iter().skip(start.saturating_sub(1)).take(length + 2).all(|c| *c == ' ');
        let index = rows.iter().position(free).unwrap_or_else(|| {
            rows.push(vec![' '; WIDTH]);
            rows.len() - 1
        });
        if let Some(row) = rows.get_mut(index) {
            put(row, start + length / 2, name);
        }
    }
    rows
}
