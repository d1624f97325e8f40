//! Tables of the report of a replay.

use super::{DASH, column, rows, typeset};
use crate::number::{alone, count, decimals, fixed, maybe, microseconds};
use crate::page::{Cell, Column, Fact, PageSection, Row, Table};
use crate::words;
use ballrace_twin::replay::Source;
use ballrace_twin::replay::outcome::{
    BearingOutcome, LearnedParameter, Learning, Motion, Outcome, ProbeOutcome, Quantiles, Standing, TabularList, Timing,
};

/// Components of a force with their units.
const COMPONENTS: [(&str, &str); 5] = [("FX", "N"), ("FY", "N"), ("FZ", "N"), ("MX", "N m"), ("MY", "N m")];

/// Returns the tables of a report: probes, bearings, forces.
pub(super) fn tables(outcome: &Outcome, compared: bool) -> Vec<PageSection> {
    let mut all = vec![];
    let listed: Vec<(&ProbeOutcome, TabularList)> =
        outcome.probes.iter().filter_map(|probe| probe.list.map(|list| (probe, list))).collect();
    if !listed.is_empty() {
        all.push(PageSection::table("Tabular list", tabular_list(&listed, compared)));
        if !outcome.planes.is_empty() {
            all.push(PageSection::table("Planes", planes(outcome)));
        }
    }
    if compared {
        all.push(PageSection::table("Comparison at the probes", comparison(&outcome.probes)));
        all.push(PageSection::table("Residual of simpler models", baselines(outcome)));
    }
    if let Some(learning) = &outcome.learning {
        all.push(PageSection::table("Learned parameters", learned(learning)));
    }
    if outcome.probes.iter().any(|probe| !probe.ball_pass.is_empty()) {
        all.push(PageSection::table("Ball-pass lines of the outer races", ball_pass(&outcome.probes)));
    }
    if !outcome.bearings.is_empty() {
        all.push(PageSection::table("Bearings", bearings(&outcome.bearings)));
        if compared {
            all.push(PageSection::table("Forces on the inner rings", forces(&outcome.bearings)));
        }
    }
    all
}

fn learned(learning: &Learning) -> Table {
    let columns = vec![
        Column::name("Parameter"),
        Column::name("Unit"),
        Column::number("Scene", ""),
        Column::number("Learned", ""),
        Column::number("From", ""),
        Column::number("To", ""),
    ];
    let row = |of: &LearnedParameter| {
        let values = column([of.scene, of.value, of.low, of.high].into_iter());
        [of.name.clone(), of.unit.to_owned()].into_iter().chain(values).collect::<Vec<_>>()
    };
    Table::of(columns, learning.parameters.iter().map(row), words::learned(learning))
}

fn tabular_list(listed: &[(&ProbeOutcome, TabularList)], compared: bool) -> Table {
    let of = |value: fn(&TabularList) -> f64| column(listed.iter().map(|(_, list)| value(list)));
    let plain = |value: &dyn Fn(&TabularList) -> f64, decimals: usize| -> Vec<String> {
        listed.iter().map(|(_, list)| typeset(&fixed(value(list), decimals))).collect()
    };
    let columns = [
        of(|list| list.direct_um_pp),
        of(|list| list.greatest_um_pp),
        of(|list| list.gap_um),
        of(|list| list.one_x_um_pp),
        plain(&|list| list.one_x_phase_lag_deg.unwrap_or(f64::NAN), 1),
        of(|list| list.two_x_um_pp),
        of(|list| list.not_one_x_um_pp),
        of(|list| list.half_x_um_pp),
        plain(&|list| list.crest_factor, 2),
        plain(&|list| list.kurtosis, 2),
    ];
    let heads = vec![
        Column::name("Probe"),
        Column::number("Direct", "um pp"),
        Column::number("Greatest", "um pp"),
        Column::number("Gap", "um"),
        Column::number("1X", "um pp"),
        Column::number("1X phase", "deg lag"),
        Column::number("2X", "um pp"),
        Column::number("Not 1X", "um pp"),
        Column::number("0.5X band", "um pp"),
        Column::number("Crest factor", ""),
        Column::number("Kurtosis", ""),
    ];
    let over =
        if compared { "Means over blocks of four turns; greatest: of any block." } else { "Over the whole recording." };
    let note = format!(
        "As measured, not compensated. {over} Direct: peak to peak of all frequencies. Gap: mean position. Not 1X: the motion without its 1X component. \
         0.5X band: 0.3X to 0.7X. Kurtosis: 1.5 of a sine, 3 of noise."
    );
    Table::of(heads, rows(listed.iter().map(|(probe, _)| probe.name.clone()), &columns), note)
}

fn planes(outcome: &Outcome) -> Table {
    let planes = &outcome.planes;
    let precession = |forward: bool| if forward { "forward" } else { "reverse" }.to_owned();
    let columns = [
        planes.iter().map(|plane| typeset(&fixed(plane.station_mm, 1))).collect(),
        column(planes.iter().map(|plane| plane.smax_um_peak)),
        column(planes.iter().map(|plane| plane.one_x_major_um_pp)),
        column(planes.iter().map(|plane| plane.one_x_minor_um_pp)),
        planes.iter().map(|plane| precession(plane.one_x_forward)).collect(),
    ];
    let heads = vec![
        Column::name("Plane"),
        Column::number("Station", "mm"),
        Column::number("Smax", "um peak"),
        Column::number("1X long axis", "um pp"),
        Column::number("1X short axis", "um pp"),
        Column::number("1X precession", ""),
    ];
    let note = "Smax: largest distance from the mean position, mean over blocks of four turns.";
    Table::of(heads, rows(planes.iter().map(|plane| plane.name.clone()), &columns), note)
}

/// Returns the comparison: two rows per probe, measured and twin.
fn comparison(probes: &[ProbeOutcome]) -> Table {
    let both =
        |of: fn(&Motion) -> f64| column(probes.iter().flat_map(move |probe| [of(&probe.measured), of(&probe.twin)]));
    let one = |of: fn(&ProbeOutcome) -> f64| column(probes.iter().map(of));
    let lag = |motion: &Motion| typeset(&fixed(motion.one_x_phase_lag_deg, 1));
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
    let mut table = Table {
        groups: vec![(4, ""), (5, "motion"), (4, "residual"), (1, "")],
        columns: vec![
            Column::name("Probe"),
            Column::number("Station", "mm"),
            Column::number("Angle", "deg"),
            Column::name(""),
            Column::number("Mean", "um"),
            Column::number("Peak to peak", "um pp"),
            Column::number("RMS", "um rms"),
            Column::number("1X", "um peak"),
            Column::number("1X phase", "deg lag"),
            Column::number("1X vector", "um peak"),
            Column::number("Bias", "um"),
            Column::number("RMS", "um rms"),
            Column::number("NRMSE", "%"),
            Column::number("Probe noise", "um rms"),
        ],
        note: format!("The bias is part of the RMS of the residual. {}", words::normaliser(probes)),
        ..Table::default()
    };
    let of = |text: &String| Cell { class: "number of", ..Cell::from(text.as_str()) };
    for (i, probe) in probes.iter().enumerate() {
        let spanning = |text: String| Cell { rows: 2, ..Cell::from(text) };
        let angle = probe.angle_deg.map_or_else(|| "axial".to_owned(), |angle| typeset(&fixed(angle, 1)));
        let mut first = vec![
            spanning(probe.name.clone()),
            spanning(typeset(&fixed(probe.station_mm, 1))),
            spanning(angle),
            Cell { class: "name of", ..Cell::from("measured") },
        ];
        first.extend(motion.iter().map(|column| of(&column[2 * i])));
        first.extend(difference.iter().map(|column| spanning(column[i].clone())));
        table.push(Row { cells: first, class: "measured", diagnosis: None });
        let twin = [Cell { class: "name of", ..Cell::from("twin") }];
        let twin = twin.into_iter().chain(motion.iter().map(|column| of(&column[2 * i + 1])));
        table.push(Row { cells: twin.collect(), class: "twin", diagnosis: None });
    }
    table
}

fn baselines(outcome: &Outcome) -> Table {
    let probes = &outcome.probes;
    let is_judged = words::are_models_judged(outcome);
    let worse = match words::beaten(probes).is_empty() {
        true => "",
        false => "Underlined: a simpler model leaves over 2 % less than the twin. ",
    };
    let mut table = Table {
        groups: vec![(2, ""), (4, "model"), (1, "")],
        columns: vec![
            Column::name("Probe"),
            Column::number("Twin", "um rms"),
            Column::number("Mean", "um rms"),
            Column::number("Previous sample", "um rms"),
            Column::number("Mean and 1X", "um rms"),
            Column::number("Linear springs", "um rms"),
            Column::number("Twin is", ""),
        ],
        note: match is_judged {
            true => format!("{worse}Same: within 2 %, so this motion does not distinguish the two."),
            false => words::NOT_JUDGED.to_owned(),
        },
        ..Table::default()
    };
    if !is_judged {
        table.columns.pop();
        table.groups.pop();
    }
    // The numbers of a row are compared, so that each row has its own number of decimals.
    for probe in probes {
        let simple = probe.baselines.all();
        let digits = decimals(simple.map(|b| b.residual_rms_um).into_iter().chain([probe.residual_rms_um]));
        let shown = |value: f64| typeset(&fixed(value, digits));
        let mut cells = vec![Cell::from(probe.name.as_str()), Cell::from(shown(probe.residual_rms_um))];
        cells.extend(simple.map(|model| Cell {
            class: if is_judged && model.twin_is == Standing::Worse { "number better" } else { "" },
            ..Cell::from(shown(model.residual_rms_um))
        }));
        cells.extend(is_judged.then(|| Cell::from(words::standing(probe.baselines.worst()))));
        table.push(Row { cells, ..Row::default() });
    }
    table
}

fn ball_pass(probes: &[ProbeOutcome]) -> Table {
    let lines = || probes.iter().flat_map(|probe| probe.ball_pass.iter().map(move |line| (probe, line)));
    let digits = decimals(lines().flat_map(|(_, line)| [line.measured_um, line.twin_um, line.residual_um]));
    let row = |(probe, line): (&ProbeOutcome, &ballrace_twin::replay::outcome::BallPassLine)| {
        let sizes = [line.measured_um, line.twin_um, line.residual_um].map(|x| typeset(&fixed(x, digits)));
        let place = [typeset(&fixed(line.order, 3)), typeset(&fixed(line.frequency_hz, 1))];
        [probe.name.clone(), line.bearing.clone()].into_iter().chain(place).chain(sizes).collect::<Vec<_>>()
    };
    let columns = vec![
        Column::name("Probe"),
        Column::name("Bearing"),
        Column::number("Order", "X"),
        Column::number("Line", "Hz"),
        Column::number("Measured", "um peak"),
        Column::number("Twin", "um peak"),
        Column::number("Residual", "um peak"),
    ];
    Table::of(columns, lines().map(row), "")
}

fn bearings(bearings: &[BearingOutcome]) -> Table {
    let order = |order: f64| if order > 0.0 { fixed(order, 3) } else { DASH.to_owned() };
    let row = |bearing: &BearingOutcome| {
        let (orders, largest) = (&bearing.orders, bearing.largest_element_load_n);
        let remarks = words::straight_line(bearing)
            .into_iter()
            .chain(words::remarks(bearing.contact_lost_samples, bearing.held_samples))
            .collect::<Vec<_>>()
            .join("; ");
        [
            bearing.name.clone(),
            bearing.model.clone(),
            typeset(&fixed(bearing.station_mm, 1)),
            order(orders.cage),
            order(orders.outer_race),
            order(orders.inner_race),
            order(orders.ball_spin.unwrap_or(0.0)),
            if largest > 0.0 { typeset(&alone(largest)) } else { DASH.to_owned() },
            if remarks.is_empty() { DASH.to_owned() } else { remarks },
        ]
    };
    let columns = vec![
        Column::name("Bearing"),
        Column::name("Model"),
        Column::number("Station", "mm"),
        Column::number("Cage", "X"),
        Column::number("Outer race", "X"),
        Column::number("Inner race", "X"),
        Column::number("Ball spin", "X"),
        Column::number("Largest element load", "N"),
        Column::words("Remarks"),
    ];
    Table {
        groups: vec![(3, ""), (4, "orders, per turn of the shaft"), (2, "")],
        ..Table::of(columns, bearings.iter().map(row), "")
    }
}

fn forces(bearings: &[BearingOutcome]) -> Table {
    let source = bearings.first().map_or(Source::Displacement, |bearing| words::shown_forces(bearing).0);
    let mut table = Table {
        groups: vec![(3, ""), (4, words::force_source(source)), (3, "twin")],
        columns: vec![
            Column::name("Bearing"),
            Column::name(""),
            Column::name("Unit"),
            Column::number("Mean", ""),
            Column::number("Smallest", ""),
            Column::number("Largest", ""),
            Column::number("Noise, 1 sigma", ""),
            Column::number("Mean", ""),
            Column::number("Smallest", ""),
            Column::number("Largest", ""),
        ],
        ..Table::default()
    };
    for bearing in bearings {
        for (i, (name, unit)) in COMPONENTS.into_iter().enumerate() {
            let (measured, twin) = (&words::shown_forces(bearing).1[i], &bearing.force_twin[i]);
            let values = [measured.mean, measured.min, measured.max, twin.mean, twin.min, twin.max];
            let digits = decimals(values);
            let mut cells = values.map(|value| typeset(&fixed(value, digits))).to_vec();
            cells.insert(3, typeset(&maybe(measured.noise_sigma)));
            let head = if i == 0 { bearing.name.clone() } else { String::new() };
            let cells = [head, name.to_owned(), unit.to_owned()].into_iter().chain(cells);
            table.push(Row { class: if i == 0 { "first" } else { "" }, ..Row::new(cells) });
        }
    }
    table
}

/// Returns the sections on computing time.
pub(super) fn timing(timing: &Timing, compared: bool) -> Vec<PageSection> {
    let mut facts = vec![
        Fact::new("Samples", count(timing.samples)),
        Fact::new("Sample period", format!("{} us", alone(microseconds(timing.sample_period_ns)))),
        Fact::new("Wall time", format!("{} s", fixed(timing.wall_s, 3))),
        Fact::new("Pace", format!("{} times real time", alone(timing.times_real_time))),
    ];
    if timing.diagnosis_s > 0.0 {
        facts.push(Fact::new("Diagnosis", format!("{} s", fixed(timing.diagnosis_s, 1))));
    }
    let memory = timing.peak_memory_bytes.map(|bytes| format!("{} MB", fixed(bytes as f64 / 1e6, 1)));
    facts.extend(memory.map(|memory| Fact::new("Peak memory", memory)));
    facts.extend(words::stages(timing).map(|sentence| Fact::new("Stages", sentence)));
    facts.extend(words::pacing(timing).into_iter().map(|sentence| Fact::new("Pacing", sentence)));
    let mut all = vec![PageSection::facts("Timing", facts)];
    if compared {
        let mut rows = vec![quantiles("Work, every 7th sample", &timing.compute)];
        if let Some(pacing) = &timing.pacing {
            rows.push(quantiles("Work, a block", &pacing.compute));
            rows.push(quantiles("Lateness", &pacing.lateness));
        }
        let columns = vec![
            Column::name(""),
            Column::number("Median", "us"),
            Column::number("99 %", "us"),
            Column::number("99.9 %", "us"),
            Column::number("Largest", "us"),
        ];
        all.push(PageSection::table("Compute time", Table::of(columns, rows, "")));
    }
    all
}

fn quantiles(name: &str, times: &Quantiles) -> Vec<String> {
    let figures = [times.p50_ns, times.p99_ns, times.p999_ns, times.max_ns].map(|ns| fixed(microseconds(ns), 2));
    [name.to_owned()].into_iter().chain(figures).collect()
}
