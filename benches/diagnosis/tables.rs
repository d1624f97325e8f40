//! The tables in Markdown.

use crate::fleet::{Fault, Recording};
use crate::program::Diagnosis;
use crate::score::{Comparison, QUANTITIES, QuantityError, Score, Verdict};
use std::fmt::Write as _;

const ABSENT: &str = "–";

/// A recording with the diagnoses of a program.
pub struct Judged<'a> {
    pub recording: &'a Recording,
    pub diagnoses: &'a [Diagnosis],
    pub score: Score,
}

impl<'a> Judged<'a> {
    pub fn new(recording: &'a Recording, diagnoses: &'a [Diagnosis]) -> Self {
        Self { recording, diagnoses, score: Score::new(recording.faults(), diagnoses) }
    }

    /// Creates the entry of a recording whose replay failed.
    pub fn failed(recording: &'a Recording) -> Self {
        let score = Score { verdict: Verdict::NotNamed, matches: vec![], further: 0 };
        Self { recording, diagnoses: &[], score }
    }

    /// Pairs of a fault and the diagnosis that names it.
    fn matches(&self) -> impl Iterator<Item = (&Fault, &Diagnosis)> {
        self.score
            .matches
            .iter()
            .map(|&(fault, diagnosis)| (&self.recording.faults()[fault], &self.diagnoses[diagnosis]))
    }
}

/// Numbers of recordings by verdict.
#[derive(Default, Clone, Copy)]
struct Counts {
    recordings: usize,
    right: usize,
    partial: usize,
    /// The first diagnosis has the cause of a fault, on whichever bearing.
    cause: usize,
    wrong: usize,
    not_named: usize,
    form: usize,
    further: usize,
}

impl Counts {
    fn of<'a>(judged: impl IntoIterator<Item = &'a Judged<'a>>) -> Self {
        let mut counts = Self::default();
        for one in judged {
            counts.recordings += 1;
            match one.score.verdict {
                Verdict::Right => counts.right += 1,
                Verdict::Partial => counts.partial += 1,
                Verdict::Wrong => counts.wrong += 1,
                Verdict::NotNamed => counts.not_named += 1,
            }
            let faults = one.recording.faults();
            let has_cause = |diagnosis: &Diagnosis| faults.iter().any(|fault| fault.kind == diagnosis.kind);
            counts.cause += usize::from(one.diagnoses.first().is_some_and(has_cause));
            let other_form = |(fault, diagnosis): (&Fault, &Diagnosis)| {
                fault.form().is_some_and(|f| diagnosis.form.as_deref() != Some(f))
            };
            counts.form += usize::from(one.matches().any(other_form));
            counts.further += usize::from(one.score.further > 0);
        }
        counts
    }

    fn line(&self, name: &str) -> String {
        let Self { recordings, right, partial, wrong, not_named, form, further, .. } = self;
        let share = 100.0 * *right as f64 / (*recordings).max(1) as f64;
        format!(
            "| {name} | {recordings} | {right} | {share:.0} | {wrong} | {not_named} | {partial} | {form} | {further} |\n"
        )
    }
}

/// The titles of the recordings that satisfy a condition, each once, in their order.
fn titles(judged: &[Judged], which: impl Fn(&Judged) -> bool) -> Vec<String> {
    let mut titles: Vec<String> = vec![];
    for title in judged.iter().filter(|one| which(one)).map(|one| one.recording.title()) {
        if !titles.contains(&title) {
            titles.push(title);
        }
    }
    titles
}

fn is_healthy(one: &Judged) -> bool {
    one.recording.faults().is_empty()
}

/// The sets of faulty recordings that have a total of their own: single faults and pairs, each under the same conditions.
fn totals(judged: &[Judged]) -> Vec<(String, usize, String)> {
    let mut totals: Vec<(String, usize, String)> = vec![];
    for one in judged.iter().filter(|one| !is_healthy(one)) {
        let (faults, group) = (one.recording.faults().len(), one.recording.group.clone());
        if totals.iter().any(|(_, f, g)| *f == faults && *g == group) {
            continue;
        }
        let name = if faults == 1 { "all single faults" } else { "all pairs of faults" };
        let comma = if group.is_empty() { "" } else { ", " };
        totals.push((format!("**{name}{comma}{group}**"), faults, group));
    }
    totals
}

/// Verdicts by recording, and in total.
pub fn verdicts(judged: &[Judged]) -> String {
    let mut table = "| recording | number | right | right, % | wrong | not named | one of two named | spall and wave confused | further diagnoses |\n\
                     | --- | --: | --: | --: | --: | --: | --: | --: | --: |\n"
        .to_owned();
    let rows = titles(judged, is_healthy).into_iter().chain(titles(judged, |one| !is_healthy(one)));
    for title in rows {
        table += &Counts::of(judged.iter().filter(|one| one.recording.title() == title)).line(&title);
    }
    for (name, faults, group) in totals(judged) {
        let within = |one: &&Judged| {
            one.recording.faults().len() == faults && one.recording.group == group && one.recording.is_visible()
        };
        table += &Counts::of(judged.iter().filter(within)).line(&name);
    }
    let hidden = judged.iter().filter(|one| !one.recording.is_visible()).count();
    if hidden > 0 {
        _ = writeln!(
            table,
            "\nNot in the totals: {hidden} faults that move no probe by 0.1 um rms or its mean by 1 um."
        );
    }
    let healthy = Counts::of(judged.iter().filter(|one| is_healthy(one)));
    _ = write!(
        table,
        "\nFalse alarms: {} of {} recordings of machines in good order.\n",
        healthy.wrong, healthy.recordings
    );
    table
}

/// The recordings that are not right, one line each.
pub fn exceptions(judged: &[Judged]) -> String {
    let mut list = String::new();
    for one in judged.iter().filter(|one| one.score.verdict != Verdict::Right) {
        let Recording { rig, .. } = one.recording;
        _ = writeln!(list, "- {rig} {}: {}", one.recording.title(), named(one.diagnoses));
    }
    list
}

/// The diagnoses in words.
pub fn named(diagnoses: &[Diagnosis]) -> String {
    let words: Vec<String> = diagnoses.iter().map(Diagnosis::words).collect();
    if words.is_empty() { "no diagnosis".to_owned() } else { words.join("; ") }
}

/// Median of sorted values.
fn median(sorted: &[f64]) -> f64 {
    let n = sorted.len();
    if n.is_multiple_of(2) { f64::midpoint(sorted[n / 2 - 1], sorted[n / 2]) } else { sorted[n / 2] }
}

/// Errors of place and size of the faults that are named right, one table for each group of conditions.
pub fn errors(judged: &[Judged]) -> String {
    let mut groups: Vec<&str> = vec![];
    for one in judged.iter().filter(|one| !is_healthy(one)) {
        if !groups.contains(&one.recording.group.as_str()) {
            groups.push(&one.recording.group);
        }
    }
    let mut text = String::new();
    for group in groups {
        let of_group = || judged.iter().filter(|one| one.recording.group == group);
        let rows = QUANTITIES.iter().filter_map(|quantity| {
            let errors: Vec<QuantityError> = of_group()
                .flat_map(Judged::matches)
                .filter_map(|(fault, diagnosis)| quantity.error(fault, diagnosis))
                .collect();
            let mut sorted: Vec<f64> = errors.iter().map(|e| e.error).filter(|e| e.is_finite()).collect();
            sorted.sort_by(f64::total_cmp);
            let covered: Vec<bool> = errors.iter().filter_map(|e| e.covered).collect();
            let digits = if quantity.comparison == Comparison::Difference { 1 } else { 2 };
            let number = |value: Option<f64>| value.map_or(ABSENT.to_owned(), |value| format!("{value:.digits$}"));
            let middle = (!sorted.is_empty()).then(|| median(&sorted));
            let name = if quantity.unit.is_empty() {
                quantity.name.to_owned()
            } else {
                format!("{}, {}", quantity.name, quantity.unit)
            };
            let intervals = if covered.is_empty() {
                ABSENT.to_owned()
            } else {
                format!("{} of {}", covered.iter().filter(|c| **c).count(), covered.len())
            };
            (!errors.is_empty()).then(|| {
                let (stated, all) = (sorted.len(), errors.len());
                let line = format!(
                    "| {name} | {stated} of {all} | {} | {} | {intervals} |\n",
                    number(middle),
                    number(sorted.last().copied())
                );
                (line, covered)
            })
        });
        let (lines, covered): (Vec<String>, Vec<Vec<bool>>) = rows.unzip();
        let covered = covered.concat();
        if lines.is_empty() {
            continue;
        }
        let heading = if group.is_empty() { String::new() } else { format!(" ({group})") };
        _ = write!(
            text,
            "| error of the faults named right{heading} | stated | median | worst | 95 % interval holds the truth |\n| --- | --: | --: | --: | --: |\n{}",
            lines.concat()
        );
        if !covered.is_empty() {
            let held = covered.iter().filter(|c| **c).count();
            let share = 100.0 * held as f64 / covered.len() as f64;
            _ = writeln!(text, "| **all intervals** | | | | {held} of {} ({share:.0} %) |", covered.len());
        }
        text.push('\n');
    }
    text
}

/// Median and worst duration of a replay.
pub fn durations(name: &str, mut seconds: Vec<f64>) -> String {
    seconds.sort_by(f64::total_cmp);
    let worst = seconds.last().copied();
    worst.map_or(String::new(), |worst| format!("{name}: median {:.1} s, worst {worst:.1} s.\n", median(&seconds)))
}

/// The twin beside the envelope spectrum: right and wrong by recording.
pub fn comparison(twin: &[Judged], envelope: &[Judged]) -> String {
    let mut table =
        "| recording | number | twin: right | twin: wrong | envelope spectrum: right | right cause, any bearing | envelope spectrum: wrong |\n\
                     | --- | --: | --: | --: | --: | --: | --: |\n"
            .to_owned();
    let mut add = |name: &str, which: &dyn Fn(&Judged) -> bool| {
        let [twin, envelope] = [twin, envelope].map(|judged| Counts::of(judged.iter().filter(|one| which(one))));
        let Counts { recordings, right, wrong, .. } = twin;
        _ = writeln!(
            table,
            "| {name} | {recordings} | {right} | {wrong} | {} | {} | {} |",
            envelope.right, envelope.cause, envelope.wrong
        );
    };
    for title in titles(twin, is_healthy).into_iter().chain(titles(twin, |one| !is_healthy(one))) {
        add(&title, &|one| one.recording.title() == title);
    }
    for (name, faults, group) in totals(twin) {
        add(&name, &|one| one.recording.faults().len() == faults && one.recording.group == group);
    }
    table
}
