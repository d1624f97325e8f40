//! The outcome as text for the terminal: aligned, at most 100 columns.

use super::number::{
    NONE, alone, common_decimals, counted, decimals, field_column, field_row, fixed, maybe, microseconds, shortened,
};
use super::words;
use ballrace_twin::replay::Source;
use ballrace_twin::replay::outcome::{
    BallPassLine, BearingOrders, BearingOutcome, FORCE_COMPONENTS, ForceFigures, LearnedParameter, Motion,
    NumericField, Outcome, ProbeOutcome, Quantiles, SimplePredictors, Timing,
};

/// Width at which sentences are broken.
const WIDTH: usize = 80;
/// Longest name in a table.
const NAME: usize = 16;

/// Returns the outcome as text: verdict, recording, results of every probe and bearing, diagnoses, flaws, timing.
#[must_use]
pub fn text(outcome: &Outcome) -> String {
    let mut page = Page::default();
    page.sentence("", if outcome.verdict.is_empty() { "No verdict." } else { &outcome.verdict });
    diagnoses(&mut page, outcome);
    page.title("RECORDING");
    for (name, value) in words::facts(outcome) {
        page.sentence(&format!("  {:<20} ", format!("{name}:")), if value.is_empty() { NONE } else { &value });
    }
    motion(&mut page, outcome);
    if outcome.probes.iter().any(ProbeOutcome::has_twin) {
        residual(&mut page, outcome);
        baselines(&mut page, outcome);
        ball_pass(&mut page, outcome);
        forces(&mut page, outcome);
        lives(&mut page, &outcome.bearings);
    }
    learned(&mut page, outcome);
    orders(&mut page, &outcome.bearings);
    sentences(&mut page, "FLAWS OF THE RECORDING", outcome.flaws.iter().map(|flaw| flaw.sentence.as_str()));
    sentences(&mut page, "NOTES", outcome.notes.iter().map(String::as_str));
    timing(&mut page, &outcome.timing);
    page.text
}

/// Text that is written line by line.
#[derive(Default)]
struct Page {
    text: String,
}

impl Page {
    fn line(&mut self, line: &str) {
        self.text.push_str(line.trim_end());
        self.text.push('\n');
    }

    fn gap(&mut self) {
        self.line("");
    }

    /// Writes a title after an empty line.
    fn title(&mut self, title: &str) {
        self.gap();
        self.line(title);
    }

    /// Writes a sentence broken at spaces; its further lines are indented as the text of the first.
    fn sentence(&mut self, lead: &str, sentence: &str) {
        let indent = lead.chars().count();
        for (i, piece) in broken(sentence, WIDTH - indent).iter().enumerate() {
            let lead = if i == 0 { lead.to_owned() } else { " ".repeat(indent) };
            self.line(&format!("{lead}{piece}"));
        }
    }

    /// Writes a table: the first `names` columns left-aligned, the others right-aligned.
    fn table<S: AsRef<str>>(&mut self, names: usize, heads: &[impl AsRef<[S]>], rows: &[Vec<String>]) {
        let owned = |head: &[S]| head.iter().map(|cell| cell.as_ref().to_owned()).collect();
        let heads: Vec<Vec<String>> = heads.iter().map(|head| owned(head.as_ref())).collect();
        let columns = heads.iter().chain(rows).map(Vec::len).max().unwrap_or(0);
        let width =
            |i: usize| heads.iter().chain(rows).filter_map(|row| row.get(i)).map(|cell| cell.chars().count()).max();
        let widths: Vec<usize> = (0..columns).map(|i| width(i).unwrap_or(0)).collect();
        for row in heads.iter().chain(rows) {
            let cells: Vec<String> =
                row.iter().zip(&widths).enumerate().map(|(i, (cell, width))| set(cell, *width, i < names)).collect();
            self.line(&format!("  {}", cells.join("  ")));
        }
    }
}

fn set(cell: &str, width: usize, left: bool) -> String {
    if left { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
}

/// Breaks a sentence into lines of at most `width` characters. A longer word is divided.
pub(super) fn broken(sentence: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in sentence.split_whitespace() {
        let mut word: Vec<char> = word.chars().collect();
        while !word.is_empty() {
            let used = lines.last().map_or(0, |line| line.chars().count());
            let space = usize::from(used > 0);
            if used + space + word.len() > width && used > 0 {
                lines.push(String::new());
                continue;
            }
            let rest = word.split_off(word.len().min(width - used - space));
            if let Some(line) = lines.last_mut() {
                line.extend(std::iter::repeat_n(' ', space).chain(word));
            }
            word = rest;
        }
    }
    lines
}

fn name(text: &str) -> String {
    shortened(text, NAME)
}

/// Returns the names and the units of columns: first those of `names`, which have no unit, then the fields.
fn heads<T>(names: &[&str], fields: impl IntoIterator<Item = NumericField<T>>) -> [Vec<String>; 2] {
    let unit = |field: &NumericField<T>| if field.unit == "X" { "per turn" } else { field.unit }.to_owned();
    let names = names.iter().map(|name| ((*name).to_owned(), String::new()));
    let (names, units) = names.chain(fields.into_iter().map(|field| (field.text_name(), unit(&field)))).unzip();
    [names, units]
}

/// Returns rows from columns.
fn rows(columns: &[Vec<String>]) -> Vec<Vec<String>> {
    let count = columns.first().map_or(0, Vec::len);
    (0..count).map(|i| columns.iter().filter_map(|column| column.get(i).cloned()).collect()).collect()
}

/// Smallest 1X amplitude that has a phase, um: a smaller one is within the rounding of the integration.
const SMALLEST_ONE_X: f64 = 1e-4;

fn motion(page: &mut Page, outcome: &Outcome) {
    if outcome.probes.is_empty() {
        return;
    }
    page.title("MOTION AT THE PROBES");
    let pairs: Vec<(&ProbeOutcome, &str, &Motion)> = outcome
        .probes
        .iter()
        .flat_map(|probe| [(probe, "measured", &probe.measured), (probe, "twin", &probe.twin)])
        .filter(|(probe, row, _)| *row == "measured" || probe.has_twin())
        .collect();
    let first =
        |pair: &(&ProbeOutcome, &str, &Motion)| if pair.1 == "twin" { String::new() } else { name(&pair.0.name) };
    let mut columns =
        vec![pairs.iter().map(first).collect(), pairs.iter().map(|pair| pair.1.to_owned()).collect::<Vec<_>>()];
    for field in Motion::FIELDS {
        let mut cells = field_column(&field, pairs.iter().map(|pair| pair.2));
        if field.key == "one_x_phase_lag_deg" {
            let is_small = pairs.iter().map(|pair| pair.2.one_x_um < SMALLEST_ONE_X);
            cells
                .iter_mut()
                .zip(is_small)
                .filter(|(_, is_small)| *is_small)
                .for_each(|(cell, _)| *cell = NONE.to_owned());
        }
        columns.push(cells);
    }
    page.table(2, &heads(&["probe", ""], Motion::FIELDS), &rows(&columns));
}

fn residual(page: &mut Page, outcome: &Outcome) {
    page.title("RESIDUAL, measured - twin");
    let mut columns = vec![outcome.probes.iter().map(|probe| name(&probe.name)).collect()];
    columns.extend(ProbeOutcome::RESIDUAL.map(|field| field_column(&field, &outcome.probes)));
    columns.push(outcome.probes.iter().map(|probe| maybe(probe.noise_um)).collect());
    let fields = ProbeOutcome::RESIDUAL.into_iter().chain([ProbeOutcome::NOISE]);
    page.table(1, &heads(&["probe"], fields), &rows(&columns));
    let normaliser = words::normaliser(&outcome.probes);
    if !normaliser.is_empty() {
        page.sentence("  ", &normaliser);
    }
}

fn baselines(page: &mut Page, outcome: &Outcome) {
    page.title("RESIDUAL OF SIMPLER MODELS, um rms");
    let is_judged = words::are_models_judged(outcome);
    // The numbers of a row are compared, so that each row has its own number of decimals.
    let row = |probe: &ProbeOutcome| {
        let simple = probe.baselines.all().map(|b| b.residual_rms_um);
        let values = || [probe.residual_rms_um].into_iter().chain(simple);
        let digits = decimals(values());
        let mut row = vec![name(&probe.name)];
        row.extend(values().map(|value| fixed(value, digits)));
        row.extend(is_judged.then(|| words::standing(probe.baselines.worst()).to_owned()));
        row
    };
    let mut heads = [vec!["probe".to_owned(), "twin".to_owned()], vec![String::new(); 2]];
    for head in SimplePredictors::FIELDS.map(|field| field.text_name()) {
        let (first, second) = head.split_once(' ').unwrap_or((&head, ""));
        heads[0].push(first.to_owned());
        heads[1].push(second.to_owned());
    }
    heads[0].extend(is_judged.then(|| "twin is".to_owned()));
    page.table(1, &heads, &outcome.probes.iter().map(row).collect::<Vec<_>>());
    if !is_judged {
        page.sentence("  ", words::NOT_JUDGED);
    } else if !words::beaten(&outcome.probes).is_empty() {
        page.sentence("  ", words::BEATEN);
    }
}

fn ball_pass(page: &mut Page, outcome: &Outcome) {
    let lines: Vec<_> =
        outcome.probes.iter().flat_map(|probe| probe.ball_pass.iter().map(move |line| (probe, line))).collect();
    if lines.is_empty() {
        return;
    }
    page.title("BALL-PASS LINES, outer race");
    let digits = common_decimals(&BallPassLine::FIELDS, lines.iter().map(|(_, line)| *line));
    let row = |(probe, line): &(&ProbeOutcome, &BallPassLine)| {
        [vec![name(&probe.name), name(&line.bearing)], field_row(&BallPassLine::FIELDS, *line, digits)].concat()
    };
    let heads = heads(&["probe", "bearing"], BallPassLine::FIELDS);
    page.table(2, &heads, &lines.iter().map(row).collect::<Vec<_>>());
}

fn forces(page: &mut Page, outcome: &Outcome) {
    if outcome.bearings.is_empty() {
        return;
    }
    page.title("FORCES ON THE INNER RINGS");
    let source = match words::shown_forces(&outcome.bearings[0]).0 {
        Source::Displacement => "measured",
        Source::Observer => "observer",
    };
    let [mean, least, largest] = &ForceFigures::FIELDS.map(|field| field.text_name());
    let heads = [
        ["bearing", "", source, "", "", "noise", "twin", "", ""],
        ["", "", mean, least, largest, "1 sigma", mean, least, largest],
    ];
    let rows: Vec<Vec<String>> = outcome.bearings.iter().flat_map(force_rows).collect();
    page.table(2, &heads, &rows);
    for bearing in &outcome.bearings {
        let mut sentences =
            vec![format!("{}, largest load on one element {} N", bearing.model, alone(bearing.largest_element_load_n))];
        sentences.extend(words::straight_line(bearing));
        sentences.extend(words::remarks(bearing.contact_lost_samples, bearing.held_samples));
        page.sentence(&format!("  {}: ", name(&bearing.name)), &format!("{}.", sentences.join("; ")));
    }
}

fn lives(page: &mut Page, bearings: &[BearingOutcome]) {
    let (fields, lives) = words::lives(bearings);
    if lives.is_empty() {
        return;
    }
    page.title("RATINGS AND LIFE");
    let rows: Vec<_> = lives.into_iter().map(|(of, cells)| [vec![name(of)], cells].concat()).collect();
    page.table(1, &heads(&["bearing"], fields), &rows);
    page.sentence("  ", words::LIFE);
}

fn force_rows(bearing: &BearingOutcome) -> Vec<Vec<String>> {
    let row = |i: usize| {
        let (measured, twin) = (&words::shown_forces(bearing).1[i], &bearing.force_twin[i]);
        let digits = common_decimals(&ForceFigures::FIELDS, [measured, twin]);
        let cells = |force| field_row(&ForceFigures::FIELDS, force, digits);
        let first = if i == 0 { name(&bearing.name) } else { String::new() };
        let (component, unit) = FORCE_COMPONENTS[i];
        let noise = vec![maybe(measured.noise_sigma)];
        [vec![first, format!("{component}, {unit}")], cells(measured), noise, cells(twin)].concat()
    };
    (0..FORCE_COMPONENTS.len()).map(row).collect()
}

/// Writes the learned parameters with their intervals.
fn learned(page: &mut Page, outcome: &Outcome) {
    let Some(learning) = &outcome.learning else { return };
    page.title(if learning.taken { "LEARNED PARAMETERS" } else { "LEARNED PARAMETERS, not taken" });
    let row = |of: &LearnedParameter| {
        let values = [of.scene, of.value, of.low, of.high];
        let digits = decimals(values);
        let mut cells = vec![of.name.clone()];
        cells.extend(values.map(|value| fixed(value, digits)));
        cells.push(of.unit.to_owned());
        cells
    };
    let rows: Vec<Vec<String>> = learning.parameters.iter().map(row).collect();
    page.table(1, &[&["", "scene", "learned", "from", "to", "unit"]], &rows);
    page.sentence("  ", &words::learned(learning));
}

fn orders(page: &mut Page, bearings: &[BearingOutcome]) {
    let known: Vec<&BearingOutcome> = bearings.iter().filter(|bearing| bearing.orders.outer_race > 0.0).collect();
    if known.is_empty() {
        return;
    }
    page.title("ORDERS, per turn of the shaft");
    let row = |bearing: &&BearingOutcome| {
        [vec![name(&bearing.name)], field_row(&BearingOrders::FIELDS, &bearing.orders, 0)].concat()
    };
    let [names, _] = heads(&["bearing"], BearingOrders::FIELDS);
    page.table(1, &[names], &known.iter().map(row).collect::<Vec<_>>());
}

fn diagnoses(page: &mut Page, outcome: &Outcome) {
    page.title("DIAGNOSES");
    if !outcome.implausible.is_empty() || !outcome.not_judged.is_empty() {
        page.line("  not judged");
        for one in &outcome.implausible {
            page.sentence("  * ", &format!("{}: {}", one.subject, one.found));
            page.sentence("    Probable cause: ", &one.cause);
            page.sentence("    Remedy: ", &one.remedy);
        }
    } else if outcome.diagnoses.is_empty() {
        let is_undiagnosed = !outcome.probes.is_empty() && outcome.diagnosis.is_none();
        page.line(if is_undiagnosed { "  not made; the verdict states why" } else { "  none" });
    }
    for diagnosis in &outcome.diagnoses {
        // The verdict is the sentence of the first diagnosis.
        let is_said = outcome.verdict.contains(&diagnosis.sentence);
        let [cause, _] = words::diagnosis(diagnosis);
        page.sentence("  * ", if is_said { &cause } else { &diagnosis.sentence });
        let line = if diagnosis.order == 0.0 {
            String::new()
        } else {
            format!("line {} Hz, order {}, ", fixed(diagnosis.line_hz, 1), fixed(diagnosis.order, 3))
        };
        let (level, confidence) = (fixed(diagnosis.level_db, 1), fixed(100.0 * diagnosis.confidence, 0));
        let evidence = format!("{}: {line}{level} dB, confidence {confidence} %", words::severity(diagnosis));
        page.sentence("    ", &evidence);
        if let Some(unexplained) = &diagnosis.parameters.unexplained_motion {
            page.sentence("    ", &words::unexplained_motion(unexplained));
        }
        let sentences = [words::failure_modes(diagnosis), words::vibration_severity(outcome, diagnosis)];
        sentences.iter().flatten().for_each(|sentence| page.sentence("    ", sentence));
        page.sentence("    Action: ", diagnosis.action());
    }
}

fn sentences<'a>(page: &mut Page, title: &str, items: impl Iterator<Item = &'a str>) {
    let mut items = items.peekable();
    if items.peek().is_none() {
        return;
    }
    page.title(title);
    items.for_each(|item| page.sentence("  * ", item));
}

fn timing(page: &mut Page, timing: &Timing) {
    page.title("TIMING");
    if timing.samples == 0 {
        page.line("  no sample was computed");
    } else {
        compute_times(page, timing);
    }
    for sentence in words::pacing(timing) {
        page.sentence("  ", &sentence);
    }
}

fn compute_times(page: &mut Page, timing: &Timing) {
    let pace = format!(
        "{} in {} s, {} times real time{}{}",
        counted(timing.samples, "sample"),
        fixed(timing.wall_s, 3),
        alone(timing.times_real_time),
        if timing.diagnosis_s > 0.0 {
            format!("; diagnosis {} s", fixed(timing.diagnosis_s, 1))
        } else {
            String::new()
        },
        timing
            .peak_memory_bytes
            .map_or_else(String::new, |bytes| format!("; peak memory {} MB", fixed(bytes as f64 / 1e6, 1)))
    );
    page.sentence("  ", &pace);
    let mut rows = vec![quantiles("a sample (every 7th)", &timing.compute)];
    if let Some(pacing) = &timing.pacing {
        rows.push(quantiles("a block", &pacing.compute));
        rows.push(quantiles("lateness", &pacing.lateness));
    }
    let heads = [["us", "median", "99 %", "99.9 %", "largest"]];
    page.table(1, &heads, &rows);
    if let Some(stages) = words::stages(timing) {
        page.sentence("  ", &stages);
    }
}

fn quantiles(what: &str, times: &Quantiles) -> Vec<String> {
    let values = [times.p50_ns, times.p99_ns, times.p999_ns, times.max_ns].map(microseconds);
    [vec![what.to_owned()], values.map(|value| fixed(value, 2)).to_vec()].concat()
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::fixture;
    use ballrace_twin::replay::outcome::{SensorOutcome, VelocityZone, VibrationLine};

    #[test]
    fn summary_is_complete_within_the_width() {
        for (outcome, width) in
            [(fixture::usual(), 80), (fixture::bare(), 80), (fixture::broken(), 100), (fixture::crowded(), 100)]
        {
            let text = text(&outcome);
            let longest = text.lines().max_by_key(|line| line.chars().count()).unwrap();
            assert!(longest.chars().count() <= width, "{longest}");
            assert!(text.starts_with(outcome.verdict.split(' ').next().unwrap()), "{text}");
            assert!(!text.contains("NaN") && !text.contains("inf "));
            assert!(text.lines().all(|line| line.trim_end() == line));
        }
    }

    #[test]
    fn names_every_probe_and_bearing() {
        let outcome = fixture::usual();
        let text = text(&outcome);
        assert!(outcome.probes.iter().all(|probe| text.contains(&probe.name)));
        assert!(outcome.bearings.iter().all(|bearing| text.contains(&bearing.model)));
        assert!(outcome.diagnoses.iter().all(|diagnosis| text.contains(&diagnosis.sentence[..20])));
    }

    #[test]
    fn no_part_is_ordered_on_an_unsure_diagnosis() {
        let mut outcome = fixture::usual();
        outcome.diagnoses.truncate(1);
        for (confidence, orders) in [(0.95, true), (0.85, false)] {
            outcome.diagnoses[0].confidence = confidence;
            assert_eq!(text(&outcome).contains("Order a spare bearing"), orders, "{confidence}");
        }
    }

    #[test]
    fn a_diagnosis_names_failure_modes_and_the_zone_of_its_sensor() {
        let mut outcome = fixture::usual();
        outcome.diagnoses.truncate(1);
        let printed = |outcome: &Outcome| text(outcome).split_whitespace().collect::<Vec<_>>().join(" ");
        let spall = "Failure mode of ISO 15243: 5.1 rolling contact fatigue or 5.3 corrosion,";
        assert!(printed(&outcome).contains(spall), "{}", printed(&outcome));
        let diagnosis = &mut outcome.diagnoses[0];
        diagnosis.vibration = Some(VibrationLine {
            sensor: "housing".to_owned(),
            band_hz: [2000.0, 4000.0],
            line_hz: 179.2,
            order: 3.58,
            modulation: 0.6,
            level_db: 22.0,
            not_excluded: vec![],
        });
        diagnosis.failure_modes = vec![];
        let zone = "Vibration velocity at housing: 3.10 mm/s rms, zone C of ISO 20816, unsatisfactory for long-term operation.";
        let sensor = |name: &str| SensorOutcome {
            name: name.to_owned(),
            velocity_rms_mm_s: 3.1,
            band_hz: [10.0, 1000.0],
            zone: Some(VelocityZone::C),
        };
        outcome.sensors = vec![sensor("another")];
        let text = printed(&outcome);
        assert!(!text.contains("ISO 20816") && !text.contains("ISO 15243"), "{text}");
        outcome.sensors.push(sensor("housing"));
        assert!(printed(&outcome).contains(zone), "{}", printed(&outcome));
    }

    #[test]
    fn a_diagnosis_of_the_verdict_is_not_repeated_and_has_its_action() {
        let mut outcome = fixture::usual();
        outcome.diagnoses.truncate(1);
        let diagnosis = outcome.diagnoses.first().unwrap();
        outcome.verdict = format!("The machine departs from its twin. {}", diagnosis.sentence);
        let text = text(&outcome).split_whitespace().collect::<Vec<_>>().join(" ");
        let said = diagnosis.sentence.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(text.matches(&said).count(), 1, "{text}");
        assert!(text.contains(diagnosis.action()) && text.contains(words::severity(diagnosis)), "{text}");
        assert!(text.contains("diagnosis 2.5 s"), "{text}");
    }

    #[test]
    fn sentences_break_between_words() {
        assert_eq!(broken("one two three", 7), ["one two", "three"]);
        assert_eq!(broken("abcdefghij k", 4), ["abcd", "efgh", "ij k"]);
        assert_eq!(broken("", 4), [""]);
    }
}
