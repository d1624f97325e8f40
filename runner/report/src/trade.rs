//! Comparison of models: tables for the terminal and for programs, HTML page with the Pareto fronts.

use super::figures::{Dot, Shape, front};
use super::page::{self, Column, Fact, Level, Page, PageSection, Table, Verdict};
use anyhow::Result;
use ballrace_twin::output::quoted;
use ballrace_twin::trade::{Candidate, Choice, NotCounted, Response, Trade};
use std::fmt::Write;

/// Returns the comparison as text for the terminal: candidates in exact math or on a Pareto front, and motions by the
/// default integrator. The HTML page, JSON and CSV contain all candidates.
#[must_use]
pub fn text(trade: &Trade) -> String {
    let mut out = String::new();
    let Trade { scene, motion, poses, truth, largest_load, .. } = trade;
    line(&mut out, &format!("{scene}: cost and accuracy at {poses} poses of each bearing from the {motion}"));
    line(
        &mut out,
        &format!("Reference: {truth}, f64, converged. Errors are relative to the largest load, {largest_load:.4} N."),
    );
    forces(&mut out, &trade.candidates);
    if let Some(warning) = disturbed(trade) {
        line(&mut out, &format!("  {warning}"));
    }
    if !trade.responses.is_empty() {
        motions(&mut out, motion_reference(trade), &trade.responses);
    }
    if !trade.impossible.is_empty() {
        line(&mut out, "\nNot applicable to this scene:");
        let mut rest = trade.impossible.as_slice();
        while let Some(first) = rest.first() {
            let same = rest.iter().take_while(|one| one.why == first.why).count();
            let names: Vec<&str> = rest.iter().take(same).map(|one| one.model.as_str()).collect();
            line(&mut out, &format!("  {}: {}", names.join("; "), first.why));
            rest = rest.get(same..).unwrap_or_default();
        }
    }
    out
}

/// Returns a sentence that describes the chosen model.
#[must_use]
pub fn chosen(choice: &Choice) -> String {
    let Choice { model, precision, error, cost, unit, seconds } = choice;
    let time = seconds.map_or(String::new(), |s| format!(" ({:.3} us)", s * 1e6));
    let work = if *unit == "cycles" { "sample" } else { "force" };
    format!(
        "Recommended: {model} in {precision}: error {} at the 99th percentile of poses, {cost:.0} {unit}{time} for one {work} of every bearing.",
        percent(*error)
    )
}

/// Returns a warning where other work disturbed the timings.
fn disturbed(trade: &Trade) -> Option<String> {
    let spread = &trade.timing_spread;
    spread.is_disturbed.then(|| {
        format!(
            "Warning: timings of equal work on this machine spread by {:.0} % (interquartile range, upper quartile of all timings): other \
             work used the processor. Costs that differ by less have no order; repeat on an idle machine.",
            100.0 * spread.upper_quartile
        )
    })
}

/// Returns sentences on the candidates without a cost on the target, by reason.
fn not_counted<'a>(candidates: impl Iterator<Item = &'a Candidate>) -> Vec<String> {
    let mut reasons: Vec<(NotCounted, Vec<String>)> = vec![];
    for candidate in candidates {
        let Some(reason) = candidate.cortex_not_counted else { continue };
        let name = numbers(candidate);
        match reasons.iter_mut().find(|(other, _)| *other == reason) {
            Some((_, names)) if names.contains(&name) => {}
            Some((_, names)) => names.push(name),
            None => reasons.push((reason, vec![name])),
        }
    }
    let sentence = |(reason, numbers): (NotCounted, Vec<String>)| {
        format!("No cost on the Cortex-M4F for some candidates in {}: {}.", numbers.join(", "), reason.reason())
    };
    reasons.into_iter().map(sentence).collect()
}

/// Returns precision and math of a candidate.
fn numbers(c: &Candidate) -> String {
    format!("{}{}", c.arithmetic.precision, if c.arithmetic.math == "fast" { " fast" } else { "" })
}

/// Reason of a motion without errors.
const NOT_FINITE: &str = "-: the computed motion overflowed, so that it has no errors.";
/// Reason of motions without an error of the ball pass.
const NO_BALL_PASS: &str = "No error of the ball pass: no bearing has a known ball-pass frequency.";

/// Returns true where the motion has no errors.
fn is_not_finite(r: &Response) -> bool {
    !(r.error.residual.is_finite() && r.error.mean.is_finite())
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

/// Formats a ratio as per cent.
fn percent(x: f64) -> String {
    match x * 100.0 {
        p if !p.is_finite() => "-".to_owned(),
        0.0 => "0 %".to_owned(),
        p if p < 0.01 => format!("{p:.1e} %"),
        p if p < 10.0 => format!("{p:.3} %"),
        p if p > 1000.0 => "over 1000 %".to_owned(),
        p => format!("{p:.1} %"),
    }
}

fn forces(out: &mut String, candidates: &[Candidate]) {
    let shown = || candidates.iter().filter(|c| c.arithmetic.math == "exact" || c.front_desktop || c.front_cortex);
    // Columns in which no row has a number are left out; the reason follows.
    let has_cortex = shown().any(|c| c.cortex.is_some());
    let cortex = |a: &str, b: &str| if has_cortex { format!(" {a:>11} {b:>11}") } else { String::new() };
    let legend = if has_cortex { "; ~ interpolated or extrapolated from counted rows" } else { "" };
    line(out, &format!("\nForces of all bearings, one sample (* on the Pareto front{legend})"));
    let head = |cells: [&str; 7]| {
        let [model, numbers, median, most, largest, rounding, ns] = cells;
        format!("  {model:<52} {numbers:<9} {median:>10} {most:>10} {largest:>10} {rounding:>10} {ns:>9}")
    };
    line(out, &(head(["", "", "error:", "", "", "of which", "desktop"]) + &cortex("Cortex-M4F", "")));
    let names = ["model", "numbers", "median", "99 %", "largest", "rounding", "ns"];
    line(out, &(head(names) + &cortex("instr.", "cycles")));
    for c in shown() {
        let front = |yes: bool| if yes { "*" } else { " " };
        let (instructions, cycles) = c.cortex.map_or(("-".to_owned(), "- ".to_owned()), |cost| {
            let about = if cost.counted { "" } else { "~" };
            let [instructions, cycles] =
                [Some(cost.instructions), cost.cycles].map(|n| n.map_or("-".to_owned(), |n| format!("{about}{n:.0}")));
            (instructions, format!("{cycles}{}", front(c.front_cortex)))
        });
        let errors = [c.error.median, c.error.most_99, c.error.largest, c.rounding.most_99].map(percent);
        let [median, most, largest, rounding] = errors.each_ref().map(String::as_str);
        let (numbers, ns) = (numbers(c), format!("{:.0}{}", c.desktop_ns, front(c.front_desktop)));
        let row = head([&c.model, &numbers, median, most, largest, rounding, &ns]);
        let overflow = if c.overflow.is_some() { "  its motion overflows" } else { "" };
        line(out, &(row + &cortex(&instructions, &cycles) + overflow));
    }
    for sentence in not_counted(shown()) {
        line(out, &format!("  {sentence}"));
    }
}

/// Returns the name of the level that motions are compared with.
fn motion_reference(trade: &Trade) -> &str {
    trade.motion_truth.as_deref().unwrap_or(&trade.truth)
}

fn motions(out: &mut String, reference: &str, responses: &[Response]) {
    line(
        out,
        &format!(
            "\nMotion computed with each model (errors of 1X vector, ball pass, peak to peak, mean and residual, relative to {reference})"
        ),
    );
    let shown = || responses.iter().filter(|r| r.usual || r.front || r.overflow.is_some());
    let has_ball_pass = shown().any(|r| r.error.ball_pass.is_some());
    let ball_pass = |cell: &str| if has_ball_pass { format!(" {cell:>9}") } else { String::new() };
    let row = |names: [&str; 5], pass: &str, errors: [&str; 3], pace: &str| {
        let ([model, precision, integrator, step, one], [peak, mean, residual]) = (names, errors);
        let pass = ball_pass(pass);
        format!(
            "  {model:<52} {precision:<5} {integrator:<12} {step:>9} {one:>9}{pass} {peak:>9} {mean:>9} {residual:>9} {pace:>8}"
        )
    };
    line(out, &row(["model", "", "integrator", "step us", "1X"], "ball pass", ["p-p", "mean", "residual"], "x real"));
    for r in shown() {
        let e = &r.error;
        let front = if r.front { "*" } else { " " };
        let overflow = if r.overflow.is_some() { "  the motion overflows" } else { "" };
        let errors = [e.one_per_turn, e.peak_to_peak, e.mean, e.residual].map(percent);
        let [one, peak, mean, residual] = errors.each_ref().map(String::as_str);
        let (step, pace) = (format!("{:.2}", r.step * 1e6), format!("{:.1}{front}", r.times_real_time));
        let pass = e.ball_pass.map_or_else(String::new, percent);
        line(
            out,
            &(row([&r.model, r.precision, r.method, &step, one], &pass, [peak, mean, residual], &pace) + overflow),
        );
    }
    if !has_ball_pass {
        line(out, &format!("  {NO_BALL_PASS}"));
    }
    if shown().any(is_not_finite) {
        line(out, &format!("  {NOT_FINITE}"));
    }
}

/// Returns CSV with one row per candidate and one per motion; a cell is empty where its column does not apply.
#[must_use]
pub fn csv(trade: &Trade) -> String {
    let mut out = "kind,model,precision,math,integrator,step_s,error_median,error_99,error_largest,modelling_99,rounding_99,\
                   desktop_ns,m4f_instructions,m4f_cycles,m4f_counted,one_per_turn,ball_pass,peak_to_peak,mean,residual,\
                   times_real_time,front_desktop,front_m4f,overflow\n"
        .to_owned();
    let overflow = |reason: Option<&str>| reason.map_or_else(String::new, quoted);
    for c in &trade.candidates {
        let cortex = c.cortex.map_or(",,".to_owned(), |m| {
            format!("{},{},{}", m.instructions, m.cycles.map_or(String::new(), |n| n.to_string()), m.counted)
        });
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "force,\"{}\",{},{},,,{},{},{},{},{},{},{cortex},,,,,,,{},{},{}",
            c.model,
            c.arithmetic.precision,
            c.arithmetic.math,
            c.error.median,
            c.error.most_99,
            c.error.largest,
            c.modelling.most_99,
            c.rounding.most_99,
            c.desktop_ns,
            c.front_desktop,
            c.front_cortex,
            overflow(c.overflow.as_deref()),
        );
    }
    for r in &trade.responses {
        let e = &r.error;
        let _ = writeln!(
            out,
            "motion,\"{}\",{},exact,{},{},,,,,,,,,,{},{},{},{},{},{},{},,{}",
            r.model,
            r.precision,
            r.method,
            r.step,
            e.one_per_turn,
            e.ball_pass.map_or_else(String::new, |error| error.to_string()),
            e.peak_to_peak,
            e.mean,
            e.residual,
            r.times_real_time,
            r.front,
            overflow(r.overflow.as_deref()),
        );
    }
    out
}

/// Returns the HTML page, one file without external references.
///
/// # Errors
/// Returns an error if the page cannot be rendered.
pub fn html(trade: &Trade) -> Result<String> {
    let name = |c: &Candidate| format!("{}, {}", c.model, numbers(c));
    let dot = |c: &Candidate, cost: f64, front: bool| Dot {
        cost,
        error: c.error.most_99,
        front,
        single: c.arithmetic.precision == "f32",
        name: name(c),
    };
    let desktop: Vec<Dot> = trade.candidates.iter().map(|c| dot(c, c.desktop_ns, c.front_desktop)).collect();
    let target: Vec<Dot> =
        trade.candidates.iter().filter_map(|c| Some(dot(c, c.cortex?.cycles?, c.front_cortex))).collect();
    let moved = |r: &Response| Dot {
        cost: 1e3 / r.times_real_time,
        error: r.error.residual,
        front: r.front,
        single: r.precision == "f32",
        name: format!("{}, {}, {:.1} us", r.model, r.method, r.step * 1e6),
    };
    let motions: Vec<Dot> = trade.responses.iter().filter(|r| r.overflow.is_none()).map(moved).collect();
    let error = "Force error, 99th percentile, over largest load";
    let pictures = [
        front("Forces on a Cortex-M4F", "Modelled cycles for one sample of every bearing", error, &target),
        front("Forces on this machine", "Time for one force of every bearing, ns", error, &desktop),
        front("Motion", "Computing time per second of motion, ms", "Residual of the motion, rms over rms", &motions),
    ];
    let figures = pictures.into_iter().flatten().collect();
    let mut sections = vec![PageSection::figures("Error over cost", Shape::Wide, figures)];
    sections.push(PageSection::table("Forces of all bearings, one sample", force_table(&trade.candidates)));
    if !trade.responses.is_empty() {
        sections.push(PageSection::table(
            "Motion computed with each model",
            motion_table(motion_reference(trade), &trade.responses),
        ));
    }
    if !trade.impossible.is_empty() {
        let columns = vec![Column::name("Model"), Column::words("Reason")];
        let rows = trade.impossible.iter().map(|one| [one.model.clone(), one.why.clone()]);
        sections.push(PageSection::table("Not applicable to this scene", Table::of(columns, rows, "")));
    }
    let verdict = trade.choice.as_ref().map(|choice| Verdict {
        level: Level::Green,
        word: "RECOMMENDED",
        sentence: chosen(choice).trim_start_matches("Recommended: ").to_owned(),
        action: String::new(),
    });
    page::render(Page {
        title: trade.scene.clone(),
        subtitle: "Cost and accuracy of the bearing models".to_owned(),
        verdict,
        facts: vec![
            Fact::new("Poses of each bearing", format!("{} from the {}", trade.poses, trade.motion)),
            Fact::new("Reference", format!("{}, f64, converged", trade.truth)),
            Fact::new("Largest load", format!("{:.4} N", trade.largest_load)),
        ]
        .into_iter()
        .chain(disturbed(trade).map(|warning| Fact::new("Timings", warning)))
        .collect(),
        sections,
        footer:
            "Errors are relative to the largest load. Pareto front: no candidate is both cheaper and more accurate."
                .to_owned(),
        ..Page::default()
    })
}

fn force_table(candidates: &[Candidate]) -> Table {
    let columns = vec![
        Column::name("Model"),
        Column::name("Numbers"),
        Column::number("Median", ""),
        Column::number("99 %", ""),
        Column::number("Largest", ""),
        Column::number("Rounding, 99 %", ""),
        Column::number("This machine", "ns"),
        Column::number("Instructions", ""),
        Column::number("Cycles", ""),
        Column::name("Pareto front"),
    ];
    let row = |c: &Candidate| {
        let about = |cost: &ballrace_twin::trade::Cost| if cost.counted { "" } else { "~" };
        let cost = |of: fn(&ballrace_twin::trade::Cost) -> Option<f64>| {
            let figure = c.cortex.as_ref().and_then(|cost| Some(format!("{}{:.0}", about(cost), of(cost)?)));
            figure.unwrap_or_else(|| "\u{2013}".to_owned())
        };
        let front = match (c.front_desktop, c.front_cortex) {
            (true, true) => "both",
            (true, false) => "this machine",
            (false, true) => "Cortex-M4F",
            (false, false) => "",
        };
        [
            c.model.clone(),
            numbers(c),
            percent(c.error.median),
            percent(c.error.most_99),
            percent(c.error.largest),
            percent(c.rounding.most_99),
            format!("{:.0}", c.desktop_ns),
            cost(|cost| Some(cost.instructions)),
            cost(|cost| cost.cycles),
            front.to_owned(),
        ]
    };
    let mut sentences = vec!["~ interpolated or extrapolated from counted rows.".to_owned()];
    sentences.extend(not_counted(candidates.iter()));
    let note = sentences.join(" ");
    Table {
        groups: vec![(2, ""), (4, "error"), (1, ""), (2, "Cortex-M4F"), (1, "")],
        ..Table::of(columns, candidates.iter().map(row), &note)
    }
}

fn motion_table(reference: &str, responses: &[Response]) -> Table {
    let columns = vec![
        Column::name("Model"),
        Column::name("Numbers"),
        Column::name("Integrator"),
        Column::number("Step", "us"),
        Column::number("1X", ""),
        Column::number("Ball pass", ""),
        Column::number("Peak to peak", ""),
        Column::number("Mean", ""),
        Column::number("Residual", ""),
        Column::number("Times real time", ""),
        Column::name("Pareto front"),
        Column::words("Remarks"),
    ];
    let row = |r: &Response| {
        let e = &r.error;
        let ball_pass = e.ball_pass.map_or_else(|| "\u{2013}".to_owned(), percent);
        let [one, others @ ..] = [e.one_per_turn, e.peak_to_peak, e.mean, e.residual].map(percent);
        let errors = [one, ball_pass].into_iter().chain(others);
        let head = [r.model.clone(), r.precision.to_owned(), r.method.to_owned(), format!("{:.2}", r.step * 1e6)];
        let remarks = r.overflow.clone().unwrap_or_default();
        let tail = [format!("{:.1}", r.times_real_time), if r.front { "yes" } else { "" }.to_owned(), remarks];
        head.into_iter().chain(errors).chain(tail).collect::<Vec<_>>()
    };
    let mut note = format!("Errors are relative to {reference}.");
    for (is_so, sentence) in [
        (responses.iter().all(|r| r.error.ball_pass.is_none()), NO_BALL_PASS),
        (responses.iter().any(is_not_finite), NOT_FINITE),
    ] {
        if is_so {
            note = format!("{note} {sentence}");
        }
    }
    Table { groups: vec![(4, ""), (5, "error"), (3, "")], ..Table::of(columns, responses.iter().map(row), &note) }
}
