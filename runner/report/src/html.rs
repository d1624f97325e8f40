//! The HTML report of a replay; `tables` has its tables.

mod tables;

use super::figures::{POINTS, Section, Shape, sections};
use super::number::{self, NONE, decimals, fixed};
use super::page::{self, Column, Fact, Level, Page, PageSection, Row, Table, Verdict, steps};
use super::words;
use anyhow::Result;
use ballrace_twin::replay::outcome::{Diagnosis, FaultKind, NumericField, Outcome, ProbeOutcome};
use ballrace_twin::verdict;
use serde_json::json;
use tables::{tables, timing};

/// Facts below the verdict; the title of the page contains the machine, the section on the measurement the others.
const FIRST_FACTS: [&str; 3] = ["Speed", "Duration", "Rotation"];
/// Multiples of a fault's line that a click on it marks.
const MULTIPLES: u32 = 5;

/// Returns the outcome as one HTML file without external references: verdict, evidence, figures, tables.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(outcome: &Outcome) -> Result<String> {
    let compared = outcome.probes.iter().any(ProbeOutcome::has_twin);
    let what = if compared { "Measured shaft motion against its digital twin" } else { "Recording" };
    let recording = if outcome.recording.is_empty() { "no recording" } else { &outcome.recording };
    let (first_facts, facts): (Vec<_>, Vec<_>) =
        words::facts(outcome).into_iter().partition(|fact| FIRST_FACTS.contains(&fact.0));
    let named = |facts: Vec<(&'static str, String)>| -> Vec<Fact> {
        facts.into_iter().map(|(name, value)| Fact::new(name, value)).collect()
    };
    let mut all = vec![];
    all.extend(diagnosis(outcome));
    let (evidence, others) = evidence(outcome, sections(outcome, POINTS));
    all.extend(evidence);
    all.extend(others.into_iter().map(|one| PageSection::figures(one.heading, one.shape, one.pictures)));
    all.extend(tables(outcome, compared));
    all.push(PageSection::facts("Measurement", named(facts)));
    all.extend(timing(&outcome.timing, compared));
    let flaws: Vec<String> = outcome.flaws.iter().map(|flaw| flaw.sentence.clone()).collect();
    let none = vec!["None found.".to_owned()];
    all.push(PageSection::list("Flaws of the recording", if flaws.is_empty() { none } else { flaws }));
    if !outcome.notes.is_empty() {
        all.push(PageSection::list("Notes and assumptions", outcome.notes.clone()));
    }
    page::render(Page {
        title: if outcome.scene.trim().is_empty() { "Unnamed machine".to_owned() } else { outcome.scene.clone() },
        subtitle: format!("{what}: {recording}"),
        verdict: Some(verdict_of(outcome, compared)),
        facts: named(first_facts),
        sections: all,
        footer: format!(
            "Units: {}. Axes: Z along the shaft, X and Y across it; azimuth and angle from +X towards +Y; stations along Z \
             from the centre of mass. Amplitudes are zero to peak unless the unit says pp or rms; phase is lag behind the \
             keyphasor mark. Residual: measured \u{2212} twin.",
            words::UNITS
        ),
        data: data(outcome),
        relevant: relevant(outcome),
    })
}

/// Returns colour and word of the verdict.
fn verdict_of(outcome: &Outcome, compared: bool) -> Verdict {
    let (level, word) = if outcome.diagnoses.iter().any(Diagnosis::is_decided) {
        (Level::Red, "FAULT FOUND")
    } else if outcome.diagnoses.iter().any(Diagnosis::is_of_machine) {
        (Level::Amber, "NOT DECIDED")
    } else if !outcome.diagnoses.is_empty() {
        (Level::Amber, "CHECK THE PROBE")
    } else if !outcome.implausible.is_empty() {
        (Level::Amber, "NOT PLAUSIBLE")
    } else if !outcome.not_judged.is_empty() {
        (Level::Amber, "NO VERDICT")
    } else if !outcome.events.is_empty() {
        (Level::Amber, "LIMIT EXCEEDED")
    } else if compared && !verdict::is_explained(outcome) {
        (Level::Amber, "TWIN DOES NOT FOLLOW")
    } else if compared && outcome.diagnosis.is_none() {
        (Level::Amber, "NOT DIAGNOSED")
    } else if compared || !outcome.pictures.envelopes.is_empty() {
        (Level::Green, "NO FAULT FOUND")
    } else {
        (Level::Neutral, "NO VERDICT")
    };
    let action = match outcome.diagnoses.first() {
        Some(diagnosis) => diagnosis.action().to_owned(),
        None if !outcome.events.is_empty() => words::EVENT_ACTION.to_owned(),
        None => words::no_action(outcome).to_owned(),
    };
    let sentence = if outcome.verdict.is_empty() { "No verdict.".to_owned() } else { outcome.verdict.clone() };
    Verdict { level, word, sentence, action }
}

/// Returns the names of probes and bearings that the verdict refers to: those of the diagnoses and events, and the probe with the largest
/// residual for its noise.
fn relevant(outcome: &Outcome) -> Vec<String> {
    let motions = outcome.diagnoses.iter().filter_map(|f| f.figures.motion.as_ref()).map(|motion| motion.probe.clone());
    let bearings = outcome.diagnoses.iter().filter_map(|diagnosis| diagnosis.bearing.clone());
    let events = outcome.events.iter().map(|event| event.probe.clone());
    let mut names: Vec<String> = motions.chain(bearings).chain(events).collect();
    names.extend(worst_probe(outcome).map(|probe| probe.name.clone()));
    names
}

/// Returns the probe with the largest ratio of residual to noise; for a probe of unknown noise, the residual itself is compared.
fn worst_probe(outcome: &Outcome) -> Option<&ProbeOutcome> {
    let size =
        |probe: &ProbeOutcome| probe.residual_rms_um / probe.noise_um.filter(|noise| *noise > 0.0).unwrap_or(1.0);
    let compared = outcome.probes.iter().filter(|probe| probe.has_twin() && size(probe).is_finite());
    compared.max_by(|a, b| size(a).total_cmp(&size(b)))
}

/// Divides the figures into the evidence of the verdict and the others.
fn evidence(outcome: &Outcome, mut sections: Vec<Section>) -> (Option<PageSection>, Vec<Section>) {
    let worst = worst_probe(outcome).map(|probe| probe.name.as_str());
    let mut proof = vec![];
    let mut take = |sections: &mut Vec<Section>, heading: &str, name: Option<&str>| {
        for section in sections.iter_mut().filter(|section| section.heading == heading) {
            let is_it = |title: &str| name.is_none_or(|name| title.contains(name));
            let (of_it, others) = section.pictures.drain(..).partition(|picture| is_it(&picture.title));
            section.pictures = others;
            proof.extend(of_it);
        }
    };
    take(&mut sections, "Diagnosis", None);
    let is_of_vibration = |diagnosis: &Diagnosis| diagnosis.vibration.is_some();
    if outcome.diagnoses.iter().any(is_of_vibration) {
        take(&mut sections, "Envelope spectra", None);
    }
    let first_event = outcome.events.first().map(|event| event.probe.as_str());
    if outcome.diagnoses.is_empty()
        && let Some(probe) = first_event.or(worst)
    {
        if first_event.is_some() {
            take(&mut sections, "Trends", Some(probe));
        }
        take(&mut sections, "Spectra", Some(probe));
        take(&mut sections, "Time traces", Some(probe));
    }
    sections.retain(|section| !section.pictures.is_empty());
    let proof = (!proof.is_empty()).then(|| PageSection::figures(page::EVIDENCE, Shape::Wide, proof));
    (proof, sections)
}

/// Returns the section of diagnoses and events, or of implausibilities; `None` without any of them.
fn diagnosis(outcome: &Outcome) -> Option<PageSection> {
    if outcome.diagnoses.is_empty() && outcome.events.is_empty() {
        let row = |one: &ballrace_twin::outcome::Implausibility| {
            [&one.subject, &one.found, &one.cause, &one.remedy].map(Clone::clone)
        };
        let columns = vec![
            Column::name("Not plausible"),
            Column::words("Found"),
            Column::words("Probable cause"),
            Column::words("Remedy"),
        ];
        let table = Table::of(columns, outcome.implausible.iter().map(row), "");
        return (!outcome.implausible.is_empty()).then(|| PageSection::table("Diagnosis", table));
    }
    let note = "Severity is how far the fault stands out (slight below 20 dB, strong from 30 dB), indicative; it is no rate of \
                damage. Confidence is the share of the unexplained motion that the fault explains at all probes, times its probability \
                against the next cause.";
    let mut table = Table {
        columns: vec![
            Column::name("Diagnosis"),
            Column::name("Bearing"),
            Column::name("Severity"),
            Column::number("Line", "Hz"),
            Column::number("Order", "X"),
            Column::number("Level", "dB"),
            Column::number("Confidence", "%"),
            Column::words("Evidence"),
            Column::words("Standards"),
            Column::words("Action"),
        ],
        note: if outcome.diagnoses.is_empty() { String::new() } else { note.to_owned() },
        ..Table::default()
    };
    for (i, diagnosis) in outcome.diagnoses.iter().enumerate() {
        let line = |value: f64, decimals: usize| {
            if diagnosis.order == 0.0 { DASH.to_owned() } else { typeset(&fixed(value, decimals)) }
        };
        let sentences = [words::failure_modes(diagnosis), words::vibration_severity(outcome, diagnosis)];
        let standards: Vec<String> = sentences.into_iter().flatten().collect();
        let cells = [
            diagnosis.kind.name().to_owned(),
            diagnosis.bearing.clone().unwrap_or_else(|| DASH.to_owned()),
            words::severity(diagnosis).to_owned(),
            line(diagnosis.line_hz, 1),
            line(diagnosis.order, 3),
            typeset(&fixed(diagnosis.level_db, 1)),
            typeset(&fixed(100.0 * diagnosis.confidence, 0)),
            diagnosis.sentence.clone(),
            standards.join(" "),
            diagnosis.action().to_owned(),
        ];
        table.push(Row { diagnosis: Some(i), ..Row::new(cells) });
    }
    for event in &outcome.events {
        let cells = ["limit", DASH, DASH, DASH, DASH, DASH, DASH, &event.sentence, DASH, words::EVENT_ACTION];
        table.push(Row::new(cells));
    }
    Some(PageSection::table("Diagnosis", table))
}

/// Text of an absent value.
const DASH: &str = "\u{2013}";

/// Returns the orders of the lines of a diagnosis, for the marks in the figures.
fn lines_of(diagnosis: &Diagnosis) -> Vec<f64> {
    if diagnosis.order.is_nan() || diagnosis.order <= 0.0 {
        return vec![];
    }
    let multiples = (1..=MULTIPLES).map(|k| f64::from(k) * diagnosis.order);
    match diagnosis.kind {
        FaultKind::OuterRace | FaultKind::Cage | FaultKind::Element => multiples.collect(),
        // The load at a position on the inner ring changes once per revolution, which causes side bands.
        FaultKind::InnerRace => multiples.flat_map(|order| [order - 1.0, order, order + 1.0]).collect(),
        _ => vec![diagnosis.order],
    }
}

/// Returns the values that the script reads in addition to those of the figures.
fn data(outcome: &Outcome) -> serde_json::Map<String, serde_json::Value> {
    let pictures = &outcome.pictures;
    let diagnosis = |diagnosis: &Diagnosis| {
        json!({
            "orders": lines_of(diagnosis),
            "names": diagnosis.bearing.iter().collect::<Vec<_>>(),
            "sentence": diagnosis.sentence,
        })
    };
    let plane = |orbit: &ballrace_twin::replay::outcome::Orbit| {
        let index = |name: &str| outcome.probes.iter().position(|probe| probe.name == name);
        let [(a, from_a), (b, from_b), ..] = &orbit.probes[..] else { return json!(null) };
        json!({ "probes": [index(a), index(b)], "angles": [from_a, from_b] })
    };
    let stretch = |stretch: &ballrace_twin::replay::outcome::Stretch| {
        json!({
            "start": stretch.start_s,
            "count": stretch.samples(),
            "keyphasor": stretch.keyphasor,
            "measured": stretch.measured.iter().map(|values| steps(values)).collect::<Vec<_>>(),
            "twin": stretch.twin.iter().map(|values| steps(values)).collect::<Vec<_>>(),
        })
    };
    let value = json!({
        "speed_hz": outcome.record.mean_speed_rpm.abs() / 60.0,
        "forward": if outcome.record.mean_speed_rpm < 0.0 { -1 } else { 1 },
        "diagnoses": outcome.diagnoses.iter().map(diagnosis).collect::<Vec<_>>(),
        "excerpt": {
            "rate_hz": pictures.excerpt.rate_hz,
            "segment": 2 * outcome.record.spectra.lines,
            "planes": pictures.orbits.iter().map(plane).collect::<Vec<_>>(),
            "stretches": pictures.excerpt.stretches.iter().map(stretch).collect::<Vec<_>>(),
        },
    });
    match value {
        serde_json::Value::Object(map) => map,
        _ => serde_json::Map::new(),
    }
}

/// Formats the text of a number for the page: with a minus sign, or a dash for a missing number.
pub(super) fn typeset(text: &str) -> String {
    if text == NONE { DASH.to_owned() } else { text.replace('-', "\u{2212}") }
}

/// Formats a column with the same number of decimals in each row.
pub(super) fn column(values: impl Iterator<Item = f64>) -> Vec<String> {
    let values: Vec<f64> = values.collect();
    let decimals = decimals(values.iter().copied());
    values.iter().map(|value| typeset(&fixed(*value, decimals))).collect()
}

/// Formats a field of each object, with the same number of decimals.
pub(super) fn field_column<'a, T: 'a>(
    field: &NumericField<T>,
    objects: impl IntoIterator<Item = &'a T>,
) -> Vec<String> {
    number::field_column(field, objects).iter().map(|text| typeset(text)).collect()
}

/// Returns rows whose cells are a name and the entries of columns.
pub(super) fn rows(names: impl Iterator<Item = String>, columns: &[Vec<String>]) -> Vec<Vec<String>> {
    let cells = |(i, name): (usize, String)| {
        let entries = columns.iter().map(|column| column.get(i).cloned().unwrap_or_default());
        [name].into_iter().chain(entries).collect()
    };
    names.enumerate().map(cells).collect()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fixture;

    fn escaped(text: &str) -> String {
        text.replace('&', "&amp;")
            .replace('<', "&lt;")
            .replace('>', "&gt;")
            .replace('"', "&quot;")
            .replace('/', "&#x2f;")
    }

    /// Returns the SVG elements.
    fn drawings(page: &str) -> String {
        page.split("<svg").skip(1).filter_map(|rest| rest.split("</svg>").next()).collect()
    }

    /// Returns the page without its script and data.
    fn still(page: &str) -> &str {
        page.split("<script").next().unwrap()
    }

    #[test]
    fn page_names_everything_and_has_no_external_resource() {
        for outcome in [fixture::usual(), fixture::crowded(), fixture::run_up()] {
            let page = html(&outcome).unwrap();
            assert!(outcome.probes.iter().all(|probe| page.contains(&escaped(&probe.name))));
            assert!(outcome.bearings.iter().all(|bearing| page.contains(&escaped(&bearing.name))));
            assert!(outcome.diagnoses.iter().all(|diagnosis| page.contains(&escaped(&diagnosis.sentence))));
            for outside in ["http://", "https://", "<link", "<img", "url(", "@import", "<b>proximity"] {
                assert!(!still(&page).contains(outside), "{outside}");
            }
            // One script and one block of data, and a policy that allows this script alone.
            assert_eq!(page.matches("<script").count(), 2);
            assert!(page.contains(&page::script_hash()) && page.contains("default-src 'none'"));
            assert!(page.len() < 3_000_000, "{}", page.len());
        }
    }

    #[test]
    fn the_verdict_has_a_colour_and_words() {
        let of = |outcome: &Outcome| verdict_of(outcome, true);
        let usual = fixture::usual();
        let found = of(&usual);
        assert!(found.level == Level::Red && found.word == "FAULT FOUND" && found.action.contains("spare bearing"));
        let probes = usual.probes.iter().cloned().map(|probe| ProbeOutcome { noise_um: Some(10.0), ..probe }).collect();
        let sound = Outcome { diagnoses: vec![], events: vec![], probes, diagnosis: Some(Default::default()), ..usual };
        assert_eq!((of(&sound).level, of(&sound).word), (Level::Green, "NO FAULT FOUND"));
        let undiagnosed = Outcome { diagnosis: None, ..sound };
        assert_eq!((of(&undiagnosed).level, of(&undiagnosed).word), (Level::Amber, "NOT DIAGNOSED"));
        let unjudged = Outcome { not_judged: vec!["a reason".to_owned()], ..undiagnosed };
        assert_eq!((of(&unjudged).level, of(&unjudged).word), (Level::Amber, "NO VERDICT"));
        assert_eq!(verdict_of(&Outcome::default(), false).level, Level::Neutral);
    }

    #[test]
    fn evidence_precedes_the_other_figures_and_tables_follow_them() {
        let page = html(&fixture::usual()).unwrap();
        let headings: Vec<&str> = page.split("<h2>").skip(1).filter_map(|rest| rest.split("</h2>").next()).collect();
        let place = |heading: &str| headings.iter().position(|one| *one == heading).unwrap();
        assert!(place("Diagnosis") < place("Evidence") && place("Evidence") < place("Orbits"));
        assert!(place("Load on the rolling elements") < place("Tabular list"));
        let contents = page.split("class=\"contents\"").nth(1).unwrap().split("</nav>").next().unwrap();
        assert_eq!(contents.matches("<li>").count(), headings.len());
    }

    #[test]
    fn pictures_are_all_there() {
        let page = html(&fixture::usual()).unwrap();
        // Rotor, deflected line. Traces, trends, half spectra; orbits direct and 1X, centrelines, full spectra, waterfalls, forces, loads; an envelope; three
        // of the diagnosis.
        assert_eq!(page.matches("<svg").count(), 2 + 3 * 5 + 7 * 2 + 1 + 3);
        let run_up = html(&fixture::run_up()).unwrap();
        assert_eq!(run_up.matches("<svg").count() - page.matches("<svg").count(), 2 * 4);
        for there in ["Cascade of", "Bode plot of DE_X", "Polar plot of NDE_Y", "Trend of AXIAL", "1X orbit at"] {
            assert!(run_up.contains(there), "{there}");
        }
        assert_eq!(page.matches("</svg>").count(), page.matches("<svg").count());
        assert!(page.contains("stroke-dasharray"));
    }

    #[test]
    fn degenerate_data_draw_no_nan() {
        let data: [&[f64]; 6] = [&[], &[0.0], &[0.0; 50], &[7.0; 50], &[f64::NAN; 9], &[1e-15, 1e15, -1e15]];
        let outcomes = data.map(fixture::with_data);
        for outcome in outcomes.iter().chain(&[fixture::bare(), fixture::broken()]) {
            let page = html(outcome).unwrap();
            let drawn = drawings(&page);
            assert!(!drawn.contains("NaN") && !drawn.contains("inf"), "{drawn}");
            // Pixels saturate where a place is not finite.
            assert!(!drawn.contains("2147483647"));
            assert!(!still(&page).contains("NaN"));
        }
    }
}
