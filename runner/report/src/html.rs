//! The HTML page of a replay: one self-contained file with a style for print.

use super::figures::{POINTS, Picture, Section, Shape, sections};
use super::number::{NONE, alone, count, decimals, fixed, maybe, microseconds};
use super::words;
use anyhow::{Context, Result};
use ballrace_twin::outcome::Implausibility;
use ballrace_twin::replay::outcome::{
    BearingOutcome, Finding, Motion, Outcome, PlaneOutcome, ProbeOutcome, Quantiles, SimplePredictor, Standing,
    TabularList, Timing,
};
use minijinja::{Environment, Value, context};

const NAME: &str = "report.html";
const TEMPLATE: &str = include_str!("report.html");
/// Facts that the title of the page contains.
const IN_TITLE: [&str; 2] = ["Machine", "Recording"];
/// Components of a force with their units.
const COMPONENTS: [(&str, &str); 5] = [("FX", "N"), ("FY", "N"), ("FZ", "N"), ("MX", "N m"), ("MY", "N m")];

/// Returns the outcome as one HTML file without external references: verdict, tables, figures.
///
/// # Errors
/// A figure or the page that cannot be rendered.
pub fn html(outcome: &Outcome) -> Result<String> {
    let mut environment = Environment::new();
    // The name ends in .html: every value is escaped, save those marked as safe.
    environment.add_template(NAME, TEMPLATE).context("reading the report's template")?;
    let template = environment.get_template(NAME).context("reading the report's template")?;
    template.render(page(outcome, &sections(outcome, POINTS)?)).context("writing the report")
}

fn page(outcome: &Outcome, sections: &[Section]) -> Value {
    context! {
        scene => titled(&outcome.scene),
        recording => outcome.recording.as_str(),
        version => outcome.version.as_str(),
        verdict => outcome.verdict.as_str(),
        facts => pairs(words::facts(outcome).into_iter().filter(|fact| !IN_TITLE.contains(&fact.0))),
        compared => outcome.probes.iter().any(ProbeOutcome::has_twin),
        list => list_rows(&outcome.probes),
        planes => plane_rows(&outcome.planes),
        units => words::UNITS,
        motion => motion_rows(&outcome.probes),
        baselines => baseline_rows(&outcome.probes),
        normaliser => words::normaliser(&outcome.probes),
        beaten => words::beaten(&outcome.probes),
        findings => outcome.findings.iter().map(finding).collect::<Vec<_>>(),
        events => outcome.events.iter().map(|event| event.sentence.clone()).collect::<Vec<_>>(),
        event_action => words::EVENT_ACTION,
        implausible => outcome.implausible.iter().map(implausible).collect::<Vec<_>>(),
        no_action => words::no_action(outcome),
        ball_pass => ball_pass_rows(&outcome.probes),
        bearings => outcome.bearings.iter().map(bearing).collect::<Vec<_>>(),
        timing => timing(&outcome.timing),
        flaws => outcome.flaws.iter().map(|flaw| flaw.sentence.clone()).collect::<Vec<_>>(),
        notes => outcome.notes.clone(),
        galleries => galleries(sections),
    }
}

fn implausible(one: &Implausibility) -> Value {
    context! {
        subject => one.subject.as_str(),
        found => one.found.as_str(),
        cause => one.cause.as_str(),
        remedy => one.remedy.as_str(),
    }
}

fn titled(scene: &str) -> &str {
    if scene.trim().is_empty() { "Unnamed machine" } else { scene }
}

/// Formats a number for the page: with a minus sign, a dash where it is missing.
fn typeset(text: &str) -> String {
    if text == NONE { "\u{2013}".to_owned() } else { text.replace('-', "\u{2212}") }
}

fn pairs(facts: impl IntoIterator<Item = (&'static str, String)>) -> Vec<Value> {
    facts.into_iter().map(|(name, value)| context! { name => name, value => value }).collect()
}

/// Formats a column with the same number of decimals in each row.
fn column(values: impl Iterator<Item = f64>) -> Vec<String> {
    let values: Vec<f64> = values.collect();
    let decimals = decimals(values.iter().copied());
    values.iter().map(|value| typeset(&fixed(*value, decimals))).collect()
}

/// Returns row `i` of columns.
fn row(columns: &[Vec<String>], i: usize) -> Vec<String> {
    columns.iter().filter_map(|column| column.get(i).cloned()).collect()
}

fn motion_rows(probes: &[ProbeOutcome]) -> Vec<Value> {
    let both =
        |of: fn(&Motion) -> f64| column(probes.iter().flat_map(move |probe| [of(&probe.measured), of(&probe.twin)]));
    let one = |of: fn(&ProbeOutcome) -> f64| column(probes.iter().map(of));
    let motion = [
        both(|motion| motion.mean_um),
        both(|motion| motion.peak_to_peak_um),
        both(|motion| motion.rms_um),
        both(|motion| motion.one_x_um),
        probes.iter().flat_map(|probe| [lag(&probe.measured), lag(&probe.twin)]).collect(),
    ];
    let difference = [
        one(|probe| probe.one_x_error_um),
        one(|probe| probe.residual_bias_um),
        one(|probe| probe.residual_rms_um),
        one(|probe| probe.nrmse_percent),
        one(|probe| probe.noise_um.unwrap_or(f64::NAN)),
    ];
    let rows = probes.iter().enumerate().map(|(i, probe)| {
        context! {
            name => probe.name.as_str(),
            station => typeset(&fixed(probe.station_mm, 1)),
            angle => probe.angle_deg.map_or_else(|| "axial".to_owned(), |angle| typeset(&fixed(angle, 1))),
            measured => row(&motion, 2 * i),
            twin => row(&motion, 2 * i + 1),
            difference => row(&difference, i),
        }
    });
    rows.collect()
}

/// Returns the tabular list; a probe without a complete block has no row.
fn list_rows(probes: &[ProbeOutcome]) -> Vec<Value> {
    let listed: Vec<(&ProbeOutcome, TabularList)> =
        probes.iter().filter_map(|probe| probe.list.map(|list| (probe, list))).collect();
    let of = |value: fn(&TabularList) -> f64| column(listed.iter().map(|(_, list)| value(list)));
    let plain = |value: fn(&TabularList) -> f64| -> Vec<String> {
        listed.iter().map(|(_, list)| typeset(&fixed(value(list), 2))).collect()
    };
    let figures = [
        of(|list| list.direct_um_pp),
        of(|list| list.greatest_um_pp),
        of(|list| list.gap_um),
        of(|list| list.one_x_um_pp),
        listed.iter().map(|(_, list)| typeset(&fixed(list.one_x_phase_lag_deg.unwrap_or(f64::NAN), 1))).collect(),
        of(|list| list.two_x_um_pp),
        of(|list| list.not_one_x_um_pp),
        of(|list| list.half_x_um_pp),
        plain(|list| list.crest_factor),
        plain(|list| list.kurtosis),
    ];
    let rows = listed.iter().enumerate().map(|(i, (probe, _))| {
        context! { name => probe.name.as_str(), figures => row(&figures, i) }
    });
    rows.collect()
}

fn plane_rows(planes: &[PlaneOutcome]) -> Vec<Value> {
    let of = |value: fn(&PlaneOutcome) -> f64| column(planes.iter().map(value));
    let figures =
        [of(|plane| plane.smax_um_peak), of(|plane| plane.one_x_major_um_pp), of(|plane| plane.one_x_minor_um_pp)];
    let rows = planes.iter().enumerate().map(|(i, plane)| {
        context! {
            name => plane.name.as_str(),
            station => typeset(&fixed(plane.station_mm, 1)),
            figures => row(&figures, i),
            precession => if plane.one_x_forward { "forward" } else { "reverse" },
        }
    });
    rows.collect()
}

fn lag(motion: &Motion) -> String {
    typeset(&fixed(motion.one_x_phase_lag_deg, 1))
}

fn baseline_rows(probes: &[ProbeOutcome]) -> Vec<Value> {
    let simple = |probe: &ProbeOutcome| probe.baselines.all();
    // The numbers of a row are compared, so that each row has its own number of decimals.
    let rows = probes.iter().map(|probe| {
        let rms = simple(probe).map(|b| b.residual_rms_um);
        let digits = decimals(rms.into_iter().chain([probe.residual_rms_um]));
        let shown = |value: f64| typeset(&fixed(value, digits));
        let cell =
            |b: SimplePredictor| context! { text => shown(b.residual_rms_um), better => b.twin_is == Standing::Worse };
        context! {
            name => probe.name.as_str(),
            twin => shown(probe.residual_rms_um),
            simple => simple(probe).map(cell).to_vec(),
            standing => words::standing(probe.baselines.worst()),
        }
    });
    rows.collect()
}

fn finding(finding: &Finding) -> Value {
    context! {
        kind => words::kind(finding.kind),
        bearing => finding.bearing.as_deref().unwrap_or_default(),
        line => if finding.order == 0.0 { "\u{2013}".to_owned() } else { typeset(&fixed(finding.line_hz, 1)) },
        order => if finding.order == 0.0 { "\u{2013}".to_owned() } else { typeset(&fixed(finding.order, 3)) },
        level => typeset(&fixed(finding.level_db, 1)),
        confidence => typeset(&fixed(100.0 * finding.confidence, 0)),
        severity => words::severity(finding),
        action => words::action(finding.kind),
        sentence => finding.sentence.as_str(),
    }
}

fn ball_pass_rows(probes: &[ProbeOutcome]) -> Vec<Value> {
    let lines = || probes.iter().flat_map(|probe| probe.ball_pass.iter().map(move |line| (probe, line)));
    let digits = decimals(lines().flat_map(|(_, line)| [line.measured_um, line.twin_um, line.residual_um]));
    let rows = lines().map(|(probe, line)| {
        context! {
            probe => probe.name.as_str(),
            bearing => line.bearing.as_str(),
            figures => vec![
                typeset(&fixed(line.order, 3)),
                typeset(&fixed(line.frequency_hz, 1)),
                typeset(&fixed(line.measured_um, digits)),
                typeset(&fixed(line.twin_um, digits)),
                typeset(&fixed(line.residual_um, digits)),
            ],
        }
    });
    rows.collect()
}

fn bearing(bearing: &BearingOutcome) -> Value {
    let orders = &bearing.orders;
    let order = |order: f64| if order > 0.0 { fixed(order, 3) } else { "\u{2013}".to_owned() };
    context! {
        name => bearing.name.as_str(),
        model => bearing.model.as_str(),
        station => typeset(&fixed(bearing.station_mm, 1)),
        cage => order(orders.cage),
        outer => order(orders.outer_race),
        inner => order(orders.inner_race),
        spin => order(orders.ball_spin.unwrap_or(0.0)),
        largest => typeset(&if bearing.largest_element_load_n > 0.0 { alone(bearing.largest_element_load_n) } else { NONE.to_owned() }),
        remarks => words::remarks(bearing.contact_lost_samples, bearing.held_samples).join("; "),
        forces => (0..COMPONENTS.len()).map(|i| force(bearing, i)).collect::<Vec<_>>(),
    }
}

fn force(bearing: &BearingOutcome, i: usize) -> Value {
    let (measured, twin) = (&bearing.force_measured[i], &bearing.force_twin[i]);
    let values = [measured.mean, measured.min, measured.max, twin.mean, twin.min, twin.max];
    let digits = decimals(values);
    let mut cells = values.map(|value| typeset(&fixed(value, digits))).to_vec();
    cells.insert(3, typeset(&maybe(measured.noise_sigma)));
    context! { name => COMPONENTS[i].0, unit => COMPONENTS[i].1, figures => cells }
}

fn timing(timing: &Timing) -> Value {
    let mut rows = vec![quantiles("Work, a sample", &timing.compute)];
    if let Some(pacing) = &timing.pacing {
        rows.push(quantiles("Work, a block", &pacing.compute));
        rows.push(quantiles("Lateness", &pacing.lateness));
    }
    let mut facts = vec![
        ("Samples", count(timing.samples)),
        ("Samples come every", format!("{} us", alone(microseconds(timing.sample_period_ns)))),
        ("Wall time", format!("{} s", fixed(timing.wall_s, 3))),
        ("Pace", format!("{} times real time", alone(timing.times_real_time))),
    ];
    if timing.diagnosis_s > 0.0 {
        facts.push(("Diagnosis", format!("{} s", fixed(timing.diagnosis_s, 1))));
    }
    facts.extend(timing.peak_memory_bytes.map(|bytes| ("Peak memory", format!("{} MB", fixed(bytes as f64 / 1e6, 1)))));
    context! { rows => rows, facts => pairs(facts), pacing => words::pacing(timing) }
}

fn quantiles(name: &str, times: &Quantiles) -> Value {
    let figures = [times.p50_ns, times.p99_ns, times.p999_ns, times.max_ns].map(|ns| fixed(microseconds(ns), 2));
    context! { name => name, figures => figures.to_vec() }
}

fn galleries(sections: &[Section]) -> Vec<Value> {
    let gallery = |section: &Section| {
        let shape = match section.shape {
            Shape::Square => "square",
            Shape::Wide => "wide",
        };
        let shared = shared_note(&section.pictures);
        let pictures: Vec<Value> = section.pictures.iter().map(|one| picture(one, shared.is_empty())).collect();
        context! { heading => section.heading, shape => shape, note => shared, pictures => pictures }
    };
    sections.iter().map(gallery).collect()
}

/// Returns the note of all pictures where they share it; it is printed once, under the heading.
fn shared_note(pictures: &[Picture]) -> &str {
    let first = pictures.first().map_or("", |picture| picture.note.as_str());
    if pictures.iter().all(|picture| picture.note == first) { first } else { "" }
}

fn picture(picture: &Picture, with_note: bool) -> Value {
    context! {
        title => picture.title.as_str(),
        note => if with_note { picture.note.as_str() } else { "" },
        svg => Value::from_safe_string(picture.svg.clone()),
    }
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

    #[test]
    fn page_names_everything_and_has_no_external_resource() {
        for outcome in [fixture::usual(), fixture::crowded(), fixture::run_up()] {
            let page = html(&outcome).unwrap();
            assert!(outcome.probes.iter().all(|probe| page.contains(&escaped(&probe.name))));
            assert!(outcome.bearings.iter().all(|bearing| page.contains(&escaped(&bearing.name))));
            assert!(outcome.findings.iter().all(|finding| page.contains(&escaped(&finding.sentence))));
            for outside in ["http://", "https://", "<script", "<link", "<img", "url(", "@import", "<b>proximity"] {
                assert!(!page.contains(outside), "{outside}");
            }
            assert!(page.len() < 3_000_000, "{}", page.len());
        }
    }

    #[test]
    fn pictures_are_all_there() {
        let page = html(&fixture::usual()).unwrap();
        // Rotor, deflected line. Traces, trends, half spectra; orbits direct and 1X, centrelines, full spectra, waterfalls, forces, loads; an envelope; three
        // of the finding.
        assert_eq!(page.matches("<svg").count(), 2 + 3 * 5 + 7 * 2 + 1 + 3);
        let run_up = html(&fixture::run_up()).unwrap();
        assert_eq!(run_up.matches("<svg").count() - page.matches("<svg").count(), 2 * 4);
        for there in ["Cascade of", "Bode plot of DE_X", "Polar plot of NDE_Y", "Trend of AXIAL", "1X orbit at"] {
            assert!(run_up.contains(there), "{there}");
        }
        assert_eq!(page.matches("</svg>").count(), page.matches("<svg").count());
        assert!(page.contains("class=\"dash\""));
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
            assert!(!page.contains("NaN"));
        }
    }
}
