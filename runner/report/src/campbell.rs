//! Campbell diagram: text for the terminal and HTML page.

use super::figures::{Shape, diagram, mode_shapes, rotor};
use super::html::typeset;
use super::number::{count, fixed};
use super::page::{self, Column, Fact, Page, PageSection, Table};
use super::words::reduced_rotor;
use anyhow::Result;
use ballrace_twin::campbell::{AtSpeed, CriticalSpeed, ModeBranch, ModeShape, Whirl, branches, critical_speeds};
use ballrace_twin::outcome::RotorOutcome;
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
    out.push_str(&critical_text(&critical_speeds(&branches(all))));
    if let Some(rotor) = largest_reduction_error(all) {
        out.push('\n');
        out.push_str(&reduction(&rotor));
    }
    out
}

/// Returns the critical speeds as lines of text.
fn critical_text(critical: &[CriticalSpeed]) -> String {
    if critical.is_empty() {
        return "\nNo mode crosses 1X or 2X in this range of speeds.\n".to_owned();
    }
    let mut out =
        "\nCritical speeds, by linear interpolation between these speeds; unbalance excites forward modes at 1X\n"
            .to_owned();
    for one in critical {
        let (mode, whirl) = (format!("N{}", one.mode), one.whirl.name());
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "{:8.0} rpm  {:.0}X  {mode:<4} {whirl:<8} {:9.2} Hz, damping {:.2} %",
            one.speed_rpm,
            one.order,
            one.frequency_hz,
            100.0 * one.damping_ratio
        );
    }
    out
}

/// Returns the reduced rotor at the speed with the largest error of its frequencies; `None` for a rotor that does not bend.
fn largest_reduction_error(all: &[AtSpeed]) -> Option<RotorOutcome> {
    let error = |rotor: &RotorOutcome| rotor.frequency_error_percent;
    all.iter().filter_map(|at| at.rotor).max_by(|a, b| error(a).total_cmp(&error(b)))
}

/// Returns the reduced rotor with its error, and a warning about too large an error.
fn reduction(rotor: &RotorOutcome) -> String {
    let lines = [Some(reduced_rotor(rotor)), rotor.excess_error()];
    lines.into_iter().flatten().map(|line| line + "\n").collect()
}

/// Returns the HTML page, one file without external references: the diagram with connected modes, the critical speeds, the natural
/// frequencies at each speed, and the rotor with its mode shapes where there are any.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(scene: &str, all: &[AtSpeed], drawing: Option<&RotorDrawing>, shapes: &[ModeShape]) -> Result<String> {
    let branches = branches(all);
    let critical = critical_speeds(&branches);
    let mut sections = vec![PageSection::figures("Campbell diagram", Shape::Wide, vec![diagram(&branches, &critical)])];
    sections.push(PageSection::table("Critical speeds", critical_table(&critical)));
    if let Some(drawing) = drawing {
        let pictures = mode_shapes(shapes, drawing).into_iter().chain([rotor(drawing)]).collect();
        let heading = if shapes.is_empty() { "Rotor" } else { "Mode shapes and rotor" };
        sections.push(PageSection::figures(heading, Shape::Wide, pictures));
    }
    sections.push(PageSection::table("Natural frequencies", frequencies(all, &branches)));
    let speeds: Vec<f64> = all.iter().map(|at| at.speed_rpm).collect();
    let [low, high] = [speeds.first(), speeds.last()].map(|rpm| fixed(rpm.copied().unwrap_or(f64::NAN), 0));
    page::render(Page {
        title: scene.to_owned(),
        subtitle: format!("Natural frequencies from {low} to {high} rpm"),
        facts: vec![
            Fact::new("Speeds", count(all.len() as u64)),
            Fact::new("Modes", count(branches.len() as u64)),
            Fact::new("Critical speeds of 1X", count(critical.iter().filter(|one| one.order == 1.0).count() as u64)),
        ],
        sections,
        footer: "Damped natural frequencies, linearised at the static equilibrium of each speed. Damping: share of critical damping. \
                 Whirl: forward in the sense of rotation, backward against it, straight along a line."
            .to_owned()
            + &largest_reduction_error(all).map_or_else(String::new, |rotor| format!(" {}", reduction(&rotor).trim_end())),
        ..Page::default()
    })
}

fn critical_table(critical: &[CriticalSpeed]) -> Table {
    let row = |one: &CriticalSpeed| {
        [
            format!("N{}", one.mode),
            one.whirl.name().to_owned(),
            format!("{:.0}X", one.order),
            fixed(one.speed_rpm, 0),
            fixed(one.frequency_hz, 2),
            typeset(&fixed(100.0 * one.damping_ratio, 2)),
        ]
    };
    let columns = vec![
        Column::name("Mode"),
        Column::name("Whirl"),
        Column::name("Crosses"),
        Column::number("Critical speed", "rpm"),
        Column::number("Natural frequency", "Hz"),
        Column::number("Damping", "%"),
    ];
    let note = if critical.is_empty() {
        "No mode crosses 1X or 2X in this range of speeds."
    } else {
        "By linear interpolation between the speeds of the diagram. Unbalance excites the forward modes at 1X; other modes need a \
         support that differs between X and Y, or another excitation."
    };
    Table::of(columns, critical.iter().map(row), note)
}

/// Returns the frequency and damping of each mode at each speed.
fn frequencies(all: &[AtSpeed], branches: &[ModeBranch]) -> Table {
    let mut columns = vec![Column::number("Speed", "rpm")];
    columns.extend(branches.iter().map(|branch| Column::number(branch.name(), "Hz, %")));
    let row = |at: &AtSpeed| {
        let cell = |branch: &ModeBranch| {
            let point = branch.points.iter().find(|point| point.speed_rpm == at.speed_rpm);
            point.map_or_else(String::new, |point| {
                let whirl = match point.mode.whirl {
                    Whirl::Forward => " f",
                    Whirl::Backward => " b",
                    Whirl::Straight => "",
                };
                let damping = typeset(&fixed(100.0 * point.mode.damping_ratio, 2));
                format!("{}{whirl}, {damping}", fixed(point.mode.frequency_hz, 2))
            })
        };
        [fixed(at.speed_rpm, 0)].into_iter().chain(branches.iter().map(cell)).collect::<Vec<_>>()
    };
    let note =
        "Frequency in Hz, with f for forward and b for backward whirl, and damping in per cent of critical damping.";
    Table::of(columns, all.iter().map(row), note)
}
