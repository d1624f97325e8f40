//! The overview as one HTML page.

use super::{Entry, Fleet, against_limit, crossing, slope, sparkline, verdict, word};
use crate::number::{count, counted};
use anyhow::{Context, Result};
use ballrace_twin::fleet::Row;
use minijinja::{Environment, Value, context};

const NAME: &str = "fleet.html";
const TEMPLATE: &str = include_str!("fleet.html");

/// Returns the overview of a fleet, one file without external references: counts by state and the machines, worst first.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(fleet: &Fleet) -> Result<String> {
    let mut environment = Environment::new();
    // The name ends in .html: every value is escaped, save those marked as safe.
    environment.add_template(NAME, TEMPLATE).context("reading the template of the overview")?;
    let template = environment.get_template(NAME).context("reading the template of the overview")?;
    let entries = fleet.entries();
    let state = |(state, number): (ballrace_twin::fleet::State, usize)| {
        context! { class => state.name(), word => word(state), count => count(number as u64), is_none => number == 0 }
    };
    let machines: Vec<Value> = entries.iter().zip(1..).map(|(one, rank)| machine(fleet, one, rank)).collect();
    let page = context! {
        name => fleet.name,
        machines_counted => counted(entries.len() as u64, "machine"),
        recordings_counted => counted(fleet.rows.len() as u64, "recording"),
        version => env!("CARGO_PKG_VERSION"),
        states => Fleet::counts(&entries).map(state).to_vec(),
        has_trends => entries.iter().any(|entry| entry.trend.is_some()),
        machines => machines,
    };
    template.render(page).context("writing the overview")
}

fn machine(fleet: &Fleet, entry: &Entry, rank: usize) -> Value {
    let row = entry.row;
    let tags: Vec<String> = row.tags.iter().map(|(name, value)| format!("{name}: {value}")).collect();
    let worst = row.worst_indicator();
    let utilisation = worst.and_then(|one| one.utilisation());
    // The verdict already states the first diagnosis.
    let diagnoses: Vec<String> = row.diagnoses.iter().skip(1).map(|one| one.sentence.clone()).collect();
    context! {
        rank => rank,
        name => row.machine.as_str(),
        tags => tags.join(", "),
        class => row.state.name(),
        word => word(row.state),
        verdict => verdict(row),
        is_judged => row.error.is_none(),
        diagnoses => diagnoses,
        when => when(row),
        link => (fleet.link)(&row.key()),
        indicator => worst.map(|one| one.label()),
        against => worst.map(against_limit),
        // Twice the limit fills the bar.
        bar => utilisation.map(|share| format!("{:.0}", (50.0 * share).clamp(0.0, 100.0))),
        percent => utilisation.map(|share| format!("{:.0}", 100.0 * share)),
        crossed => worst.is_some_and(|one| one.crossed),
        trend => entry.trend.map(|trend| context! {
            label => trend.quantity.label(),
            slope => slope(trend),
            crossing => crossing(trend),
            crossed => trend.crossed_on.is_some(),
            svg => Value::from_safe_string(sparkline::svg(trend)),
        }),
        history => if entry.history.len() > 1 { history(fleet, entry) } else { vec![] },
    }
}

fn when(row: &Row) -> String {
    row.time.map_or_else(String::new, |time| {
        let text = time.to_string();
        text.strip_suffix("T00:00:00Z").map_or_else(|| text.clone(), str::to_owned)
    })
}

fn history(fleet: &Fleet, entry: &Entry) -> Vec<Value> {
    let item = |row: &&Row| {
        let recording = if row.recording.is_empty() { "recording of the scene" } else { &row.recording };
        context! {
            when => when(row),
            recording => recording,
            class => row.state.name(),
            word => word(row.state),
            link => (fleet.link)(&row.key()),
        }
    };
    entry.history.iter().map(item).collect()
}
