//! Summary for the terminal.

use super::{Fleet, against_limit, crossing, verdict, word};
use crate::number::{counted, shortened};
use ballrace_twin::fleet::Row;
use ballrace_twin::printable;
use std::fmt::Write;

/// Number of machines in the list of the worst.
const WORST: usize = 10;
/// Longest text of a line in the list, in characters.
const LONGEST: usize = 110;
/// Longest name of a machine, in characters.
const LONGEST_NAME: usize = 40;

/// Returns counts by state and the worst machines as text.
#[must_use]
pub fn text(fleet: &Fleet) -> String {
    let entries = fleet.entries();
    let [machines, recordings] = [(entries.len(), "machine"), (fleet.rows.len(), "recording")]
        .map(|(number, noun)| counted(number as u64, noun));
    let counts = Fleet::counts(&entries);
    let counts = counts.iter().filter(|(_, number)| *number > 0);
    let counts: Vec<String> = counts.map(|(state, number)| format!("{number} {}", word(*state))).collect();
    let mut text = format!("{}: {machines}, {recordings}\n{}\n\nWorst first\n", fleet.name, counts.join(", "));
    let shown = || entries.iter().take(WORST);
    let width = shown().map(|entry| name(entry.row).chars().count()).max().unwrap_or(0);
    for (entry, rank) in shown().zip(1..) {
        let row = entry.row;
        let crossed = row.worst_indicator().filter(|one| one.crossed);
        let cause = crossed.map(|one| format!("{} {}", one.label(), against_limit(one)));
        // A line break in a name would start an additional line.
        let cause = printable::message(cause.as_deref().unwrap_or(verdict(row)));
        let crossing = entry.trend.map(crossing).filter(|text| !text.is_empty());
        let day = crossing.map_or_else(String::new, |text| format!(" ({text})"));
        let name = name(row);
        let _ =
            writeln!(text, "{rank:>3}  {name:<width$}  {:<15}  {}{day}", word(row.state), shortened(&cause, LONGEST));
    }
    text
}

fn name(row: &Row) -> String {
    shortened(&printable::name(&row.machine), LONGEST_NAME)
}
