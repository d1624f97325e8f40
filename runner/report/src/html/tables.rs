//! Tables of the report of a replay.

use super::{DASH, column, field_column, rows, typeset};
use crate::number::{alone, common_decimals, count, decimals, field_row, fixed, maybe, microseconds};
use crate::page::{Cell, Column, Fact, PageSection, Row, Table};
use crate::words;
use ballrace_twin::replay::Source;
use ballrace_twin::replay::outcome::{
    BallPassLine, BearingOrders, BearingOutcome, FORCE_COMPONENTS, ForceFigures, LearnedParameter, Learning, Motion,
    Outcome, PlaneOutcome, ProbeOutcome, Quantiles, SimplePredictors, Standing, TabularList, Timing,
};

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
            all.extend(lives(&outcome.bearings).map(|lives| PageSection::table("Ratings and life", lives)));
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
    let columns = TabularList::FIELDS.map(|field| field_column(&field, listed.iter().map(|(_, list)| list)));
    let heads = [Column::name("Probe")].into_iter().chain(TabularList::FIELDS.iter().map(Column::field)).collect();
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
    let mut columns = PlaneOutcome::FIELDS.map(|field| field_column(&field, planes)).to_vec();
    columns.push(planes.iter().map(|plane| precession(plane.one_x_forward)).collect());
    let mut heads = vec![Column::name("Plane")];
    heads.extend(PlaneOutcome::FIELDS.iter().map(Column::field));
    heads.push(Column::number("1X precession", ""));
    let note = "Smax: largest distance from the mean position, mean over blocks of four turns.";
    Table::of(heads, rows(planes.iter().map(|plane| plane.name.clone()), &columns), note)
}

/// Returns the comparison: two rows per probe, measured and twin.
fn comparison(probes: &[ProbeOutcome]) -> Table {
    let residual = || ProbeOutcome::RESIDUAL.into_iter().chain([ProbeOutcome::NOISE]);
    let motions = || probes.iter().flat_map(|probe| [&probe.measured, &probe.twin]);
    let [station, angle] = ProbeOutcome::PLACE.map(|field| field_column(&field, probes));
    let motion = Motion::FIELDS.map(|field| field_column(&field, motions()));
    let difference: Vec<_> = residual().map(|field| field_column(&field, probes)).collect();
    let mut columns = vec![Column::name("Probe")];
    columns.extend(ProbeOutcome::PLACE.iter().map(Column::field));
    columns.push(Column::name(""));
    columns.extend(Motion::FIELDS.iter().map(Column::field));
    columns.extend(residual().map(|field| Column::field(&field)));
    let mut table = Table {
        groups: vec![(4, ""), (Motion::FIELDS.len(), "motion"), (ProbeOutcome::RESIDUAL.len(), "residual"), (1, "")],
        columns,
        note: format!("The bias is part of the RMS of the residual. {}", words::normaliser(probes)),
        ..Table::default()
    };
    let of = |text: &String| Cell { class: "number of", ..Cell::from(text.as_str()) };
    for (i, probe) in probes.iter().enumerate() {
        let spanning = |text: String| Cell { rows: 2, ..Cell::from(text) };
        let angle = probe.angle_deg.map_or_else(|| "axial".to_owned(), |_| angle[i].clone());
        let mut first = vec![
            spanning(probe.name.clone()),
            spanning(station[i].clone()),
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
    let mut columns = vec![Column::name("Probe"), Column::number("Twin", "um rms")];
    columns.extend(SimplePredictors::FIELDS.iter().map(Column::field));
    let mut groups = vec![(2, ""), (SimplePredictors::FIELDS.len(), "model")];
    if is_judged {
        columns.push(Column::number("Twin is", ""));
        groups.push((1, ""));
    }
    let note = match is_judged {
        true => format!("{worse}Same: within 2 %, so this motion does not distinguish the two."),
        false => words::NOT_JUDGED.to_owned(),
    };
    let mut table = Table { groups, columns, note, ..Table::default() };
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
    let digits = common_decimals(&BallPassLine::FIELDS, lines().map(|(_, line)| line));
    let row = |(probe, line): (&ProbeOutcome, &BallPassLine)| {
        let cells = field_row(&BallPassLine::FIELDS, line, digits).into_iter().map(|cell| typeset(&cell));
        [probe.name.clone(), line.bearing.clone()].into_iter().chain(cells).collect::<Vec<_>>()
    };
    let columns = [Column::name("Probe"), Column::name("Bearing")].into_iter();
    Table::of(columns.chain(BallPassLine::FIELDS.iter().map(Column::field)).collect(), lines().map(row), "")
}

fn bearings(bearings: &[BearingOutcome]) -> Table {
    let row = |bearing: &BearingOutcome| {
        let largest = bearing.largest_element_load_n;
        let remarks = words::straight_line(bearing)
            .into_iter()
            .chain(words::remarks(bearing.contact_lost_samples, bearing.held_samples))
            .collect::<Vec<_>>()
            .join("; ");
        let mut cells = vec![bearing.name.clone(), bearing.model.clone(), typeset(&fixed(bearing.station_mm, 1))];
        cells.extend(BearingOrders::FIELDS.map(|field| match (field.value)(&bearing.orders) {
            order if order > 0.0 => fixed(order, 3),
            _ => DASH.to_owned(),
        }));
        cells.push(if largest > 0.0 { typeset(&alone(largest)) } else { DASH.to_owned() });
        cells.push(if remarks.is_empty() { DASH.to_owned() } else { remarks });
        cells
    };
    let mut columns = vec![Column::name("Bearing"), Column::name("Model"), Column::number("Station", "mm")];
    columns.extend(BearingOrders::FIELDS.iter().map(Column::field));
    columns.extend([Column::number("Largest element load", "N"), Column::words("Remarks")]);
    Table {
        groups: vec![(3, ""), (BearingOrders::FIELDS.len(), "orders, per turn of the shaft"), (2, "")],
        ..Table::of(columns, bearings.iter().map(row), "")
    }
}

fn forces(bearings: &[BearingOutcome]) -> Table {
    let source = bearings.first().map_or(Source::Displacement, |bearing| words::shown_forces(bearing).0);
    let fields = || ForceFigures::FIELDS.iter().map(Column::field);
    let names = ["Bearing", "", "Unit"].map(Column::name).into_iter();
    let columns = names.chain(fields()).chain([Column::number("Noise, 1 sigma", "")]).chain(fields()).collect();
    let count = ForceFigures::FIELDS.len();
    let groups = vec![(3, ""), (count + 1, words::force_source(source)), (count, "twin")];
    let mut table = Table { groups, columns, ..Table::default() };
    for bearing in bearings {
        for (i, (name, unit)) in FORCE_COMPONENTS.into_iter().enumerate() {
            let (measured, twin) = (&words::shown_forces(bearing).1[i], &bearing.force_twin[i]);
            let digits = common_decimals(&ForceFigures::FIELDS, [measured, twin]);
            let mut cells =
                vec![if i == 0 { bearing.name.clone() } else { String::new() }, name.to_owned(), unit.to_owned()];
            cells.extend(field_row(&ForceFigures::FIELDS, measured, digits).iter().map(|cell| typeset(cell)));
            cells.push(typeset(&maybe(measured.noise_sigma)));
            cells.extend(field_row(&ForceFigures::FIELDS, twin, digits).iter().map(|cell| typeset(cell)));
            table.push(Row { class: if i == 0 { "first" } else { "" }, ..Row::new(cells) });
        }
    }
    table
}

/// Returns the ratings and lives of the bearings; none where no bearing has them.
fn lives(bearings: &[BearingOutcome]) -> Option<Table> {
    let (fields, lives) = words::lives(bearings);
    let columns = [Column::name("Bearing")].into_iter().chain(fields.iter().map(Column::field)).collect();
    let row = |(name, cells): &(&str, Vec<String>)| {
        [(*name).to_owned()].into_iter().chain(cells.iter().map(|cell| typeset(cell))).collect::<Vec<_>>()
    };
    (!lives.is_empty()).then(|| Table::of(columns, lives.iter().map(row), words::LIFE))
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
