//! Texts shared by the HTML page and the terminal.

use super::number::{alone, at_station, count, counted, fixed};
use ballrace_twin::replay::Source;
use ballrace_twin::replay::outcome::{
    BearingOutcome, ComparedTwin, Diagnosis, Estimate, EstimateKind, FORCE_COMPONENTS, FaultField, FaultForm,
    FaultKind, FaultParameters, ForceFigures, Learning, LifeOutcome, NumericField, Observation, Outcome, OutputFigures,
    ProbeOutcome, Record, RotorOutcome, SourceFigures, Standing, Timing, UnexplainedMotion,
};
use ballrace_twin::verdict;

/// Condition number above which the arrangement of the probes is poor.
const BADLY_PLACED: f64 = 100.0;

/// Returns the cause of a diagnosis without location and size, such as "Spall on the outer race" or "Unbalance".
pub(super) fn cause(diagnosis: &Diagnosis) -> String {
    let surface = match diagnosis.kind {
        FaultKind::OuterRace => "the outer race",
        FaultKind::InnerRace => "the inner race",
        FaultKind::Element => "a rolling element",
        other => return capitalised(other.name()),
    };
    match (diagnosis.parameters.form, diagnosis.parameters.waviness_order) {
        (Some(FaultForm::Waviness), Some(order)) => format!("Waviness of order {order} on {surface}"),
        (Some(FaultForm::Waviness), None) => format!("Waviness on {surface}"),
        (Some(FaultForm::Spall), _) => format!("Spall on {surface}"),
        (None, _) => format!("Damage of {surface}"),
    }
}

/// Returns the cause of a diagnosis with its location, such as "Spall on the outer race at 290 deg".
pub(super) fn place(diagnosis: &Diagnosis) -> String {
    let parameters = &diagnosis.parameters;
    match (parameters.azimuth_deg, parameters.element) {
        (Some(azimuth), _) => format!("{} at {} deg", cause(diagnosis), fixed(azimuth.value, 0)),
        (None, Some(element)) => format!("Spall on element {element}"),
        _ => cause(diagnosis),
    }
}

/// Returns a diagnosis for a terminal: its cause with the bearing, then location, size with 95 % interval, odds and confidence.
pub fn diagnosis(diagnosis: &Diagnosis) -> [String; 2] {
    let p = &diagnosis.parameters;
    let head = match &diagnosis.bearing {
        Some(bearing) => format!("{}, bearing {bearing}", cause(diagnosis)),
        None => cause(diagnosis),
    };
    let interval = |(_, field): (EstimateKind, FaultField)| {
        let Estimate { value, low, high } = (field.value)(p)?;
        let [value, low, high] = [value, low, high].map(|number| fixed(number, field.decimals.unwrap_or(0)));
        let origin = match (field.key, diagnosis.kind) {
            ("azimuth_deg", FaultKind::InnerRace) => " from the keyphasor mark",
            ("azimuth_deg", _) => " from +X",
            _ => "",
        };
        Some(format!("{} {value} ({low} to {high}) {}{origin}", field.name, field.unit))
    };
    let load = p.load_n.map(|load| load.map(|e| fixed(e.value, 1)).join(", "));
    let odds = p.odds_to_next.map(|odds| match odds {
        odds if odds >= 1e6 => "odds beyond 1e6".to_owned(),
        odds => format!("odds {}", fixed(odds, 0)),
    });
    let facts: Vec<String> = p
        .element
        .map(|element| format!("element {element}"))
        .into_iter()
        .chain(FaultParameters::FIELDS.into_iter().filter_map(interval))
        .chain(load.map(|load| format!("{load} N along X, Y, Z")))
        .chain(odds)
        .chain([format!("confidence {} %", fixed(100.0 * diagnosis.confidence, 0))])
        .collect();
    [head, facts.join("; ")]
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Recommended action after a limit was crossed.
pub const EVENT_ACTION: &str =
    "Compare with the operating state at that time; where it recurs without a cause in operation, look for a fault.";
/// Returns the recommended action where there is no diagnosis.
pub(super) fn no_action(outcome: &Outcome) -> &'static str {
    if !outcome.implausible.is_empty() || !outcome.not_judged.is_empty() {
        return "remove the cause that the verdict states, then replay or measure again.";
    }
    match (outcome.probes.is_empty(), verdict::is_explained(outcome)) {
        (true, _) => "none; repeat the measurement as planned.",
        (_, true) => "none; keep this recording as the baseline (--learn) for later ones.",
        (_, false) => "see that the scene is this machine, or fit it (ballrace fit), before you use the comparison.",
    }
}

/// Units of all numbers on the page.
pub(super) const UNITS: &str = "lengths um, forces N, moments N m; pp, peak and rms as each column states; phase in \
                                degrees of lag, 0 to 360; frequency in Hz and orders (X)";

/// Returns the unexplained motion at the probe that shows a fault best, without and with it, as a sentence.
pub(super) fn unexplained_motion(of: &UnexplainedMotion) -> String {
    format!(
        "Unexplained motion at {} over all samples of the diagnosis: {} um rms without the fault, {} um with it (noise of the probes up to \
         {} um); the fault explains {} % of its square.",
        of.probe,
        alone(of.without_um),
        alone(of.with_um),
        alone(of.noise_um),
        fixed(100.0 * of.explained, 0)
    )
}

/// Returns the severity of a diagnosis as a word; it is a level, not a rate of damage.
pub(super) fn severity(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.level_db {
        db if db >= 30.0 => "strong",
        db if db >= 20.0 => "clear",
        _ => "slight",
    }
}

/// Returns the failure modes of a diagnosis as a sentence; none where it is no failure of a bearing.
pub(super) fn failure_modes(diagnosis: &Diagnosis) -> Option<String> {
    let (first, others) = diagnosis.failure_modes.split_first()?;
    let of = match diagnosis.parameters.form {
        Some(FaultForm::Waviness) => "of a wave that has grown in service, ",
        _ => "",
    };
    let others: Vec<&str> = others.iter().map(|mode| mode.name()).collect();
    let others = match others.as_slice() {
        [] => String::new(),
        others => format!(" or {}", others.join(", ")),
    };
    Some(format!(
        "Failure mode of ISO 15243: {of}{}{others}; the appearance of the opened bearing decides.",
        first.name()
    ))
}

/// Returns the vibration severity at the sensor of a diagnosis as a sentence; none without a class of machine.
pub(super) fn vibration_severity(outcome: &Outcome, diagnosis: &Diagnosis) -> Option<String> {
    let column = &diagnosis.vibration.as_ref()?.sensor;
    let sensor = outcome.sensors.iter().find(|sensor| sensor.name == *column)?;
    let (zone, velocity) = (sensor.zone?, fixed(sensor.velocity_rms_mm_s, 2));
    Some(format!(
        "Vibration velocity at {column}: {velocity} mm/s rms, zone {zone:?} of ISO 20816, {}.",
        zone.meaning()
    ))
}

/// Returns the facts that precede the figures: name and value.
pub(super) fn facts(outcome: &Outcome) -> Vec<(&'static str, String)> {
    let record = &outcome.record;
    let mut facts = vec![("Machine", outcome.scene.clone()), ("Recording", outcome.recording.clone())];
    if let Some(file) = &outcome.file {
        let modified = file.modified.replace('T', " ").replace('Z', " UTC");
        facts.push(("File", format!("changed on {modified}, {} bytes, SHA-256 {}", count(file.bytes), file.sha256)));
    }
    facts.extend([
        ("Speed", speed(record)),
        ("Rotation", rotation(record).to_owned()),
        ("Shaft angle from", record.angle_source.clone()),
        ("Rate", rates(record)),
        ("Duration", format!("{} s, {} turns", fixed(record.duration_s, 3), fixed(record.turns, 1))),
        ("Samples", samples(record)),
    ]);
    facts.extend(setting(outcome));
    if !outcome.probes.is_empty() {
        facts.push(("Condition number", condition(&outcome.observation)));
    }
    if outcome.observation.noise_gain > 0.0 {
        facts.push((
            "Noise gain",
            format!("at most {} from a probe to a bearing", alone(outcome.observation.noise_gain)),
        ));
    }
    if outcome.twin.synchronised || outcome.twin.spread.is_some() {
        facts.push(("Compared with", compared_twin(&outcome.twin)));
    }
    let supplied = &outcome.observation.supplied_by_twin;
    if !supplied.is_empty() {
        facts.push(("Supplied by the twin", format!("{}: no probe measures it", supplied.join(", "))));
    }
    facts
}

/// Returns the settings of measurement and evaluation: bearings, probes, load, spectra, filters.
fn setting(outcome: &Outcome) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    let bearings = outcome.bearings.iter().map(|b| format!("{} ({}){}", b.name, b.model, at_station(b.station_mm, 1)));
    let bearings: Vec<String> = bearings.collect();
    if !bearings.is_empty() {
        facts.push(("Bearings", bearings.join("; ")));
    }
    facts.extend(outcome.rotor.iter().flat_map(rotor));
    if outcome.probes.is_empty() {
        return facts;
    }
    facts.push(("Probes", outcome.probes.iter().map(probe).collect::<Vec<_>>().join("; ")));
    let load = outcome.record.load.iter().zip(FORCE_COMPONENTS).filter(|(x, _)| **x != 0.0);
    let load: Vec<String> = load.map(|(x, (name, unit))| format!("{name} {} {unit}", alone(*x))).collect();
    let load = if load.is_empty() { "weight alone".to_owned() } else { load.join(", ") };
    let by_system = outcome.record.load.iter().all(|x| x.is_nan());
    facts.push(("Load on the rotor", if by_system { "that of the [system]".to_owned() } else { load }));
    if !outcome.probes.iter().any(ProbeOutcome::has_twin) {
        return facts;
    }
    let spectra = &outcome.record.spectra;
    facts.push((
        "Spectra",
        format!(
            "{} lines, {} Hz apart, Hann window, {}",
            count(spectra.lines as u64),
            alone(spectra.bin_hz),
            counted(spectra.averages, "average"),
        ),
    ));
    facts.push(("Filter", "1X, 2X and 0.5X by the shaft's angle, blocks of 4 turns".to_owned()));
    let compensated = if outcome.record.is_run_out_subtracted {
        "run-out at slow roll subtracted from every reading; see the notes"
    } else if outcome.record.speed_changes() {
        "compensated in Bode and polar plots where stated, nowhere else"
    } else {
        "none in this recording, not compensated"
    };
    facts.push(("Slow roll", compensated.to_owned()));
    facts
}

/// Describes a flexible rotor, and its reduced model with the error.
pub(super) fn rotor(rotor: &RotorOutcome) -> [(&'static str, String); 2] {
    let percent = |error: f64| if error < 0.01 { "below 0.01 %".to_owned() } else { format!("{} %", fixed(error, 2)) };
    let body = format!(
        "flexible, {} kg, centre of mass at {} mm as drawn, diametral inertia {} kg m^2, polar {} kg m^2",
        fixed(rotor.mass_kg, 3),
        fixed(rotor.centre_of_mass_mm, 2),
        fixed(rotor.diametral_inertia_kg_m2, 5),
        fixed(rotor.polar_inertia_kg_m2, 5),
    );
    let model = format!(
        "{} coordinates instead of the {} of the finite-element model; error of the natural frequencies up to {} Hz {}, of the static \
         deflection {}, of the 1X response {}",
        rotor.coordinates,
        rotor.finite_element_coordinates,
        fixed(rotor.highest_line_hz, 0),
        percent(rotor.frequency_error_percent),
        percent(rotor.deflection_error_percent),
        percent(rotor.response_error_percent),
    );
    [("Rotor", body), ("Reduced model", model)]
}

/// Returns name, station and angle of a probe.
fn probe(probe: &ProbeOutcome) -> String {
    let looks = probe.angle_deg.map_or_else(|| "axial".to_owned(), |angle| format!("{} deg", fixed(angle, 0)));
    format!("{}{}, {looks}", probe.name, at_station(probe.station_mm, 1))
}

/// Returns the reduced model of a flexible rotor with its error, as a line of text.
#[must_use]
pub fn reduced_rotor(of: &RotorOutcome) -> String {
    let [_, (name, model)] = rotor(of);
    format!("{name}: {model}")
}

/// Returns the rate of the samples, with that of the recording where they are averages.
fn rates(record: &Record) -> String {
    match record.average {
        0 | 1 => format!("{} Hz", rate(record.rate_hz)),
        n => format!("{} Hz, averages of {n} at {} Hz", rate(record.rate_hz), rate(record.rate_hz * f64::from(n))),
    }
}

/// Formats a whole number of hertz as a count.
fn rate(hz: f64) -> String {
    if (1.0..1e15).contains(&hz) && hz.fract() == 0.0 { count(hz as u64) } else { alone(hz) }
}

fn speed(record: &Record) -> String {
    let (low, high) = (record.min_speed_rpm, record.max_speed_rpm);
    if record.mean_speed_rpm.is_nan() {
        return "not measured".to_owned();
    }
    let mean = format!("{} rpm", fixed(record.mean_speed_rpm, 1));
    if high - low < 0.1 { mean } else { format!("{mean} mean, {} to {}", fixed(low, 1), fixed(high, 1)) }
}

fn rotation(record: &Record) -> &'static str {
    match record.mean_speed_rpm {
        speed if speed > 0.0 => "from +X towards +Y (anticlockwise, Z towards the reader)",
        speed if speed < 0.0 => "from +Y towards +X (clockwise, Z towards the reader)",
        speed if speed.is_nan() => "not measured",
        _ => "none",
    }
}

fn samples(record: &Record) -> String {
    let left_out = record.averaged().saturating_sub(record.compared);
    let read = if record.average > 1 {
        format!(
            "{} read, averages of {}: {}",
            count(record.samples),
            count(u64::from(record.average)),
            count(record.averaged())
        )
    } else {
        format!("{} read", count(record.samples))
    };
    if record.compared == 0 {
        format!("{read}, none compared")
    } else if left_out == 0 {
        format!("{read}, all compared")
    } else {
        format!("{read}, {} not compared", count(left_out))
    }
}

/// States which twin is compared and why, where it does not run freely.
fn compared_twin(twin: &ComparedTwin) -> String {
    let twin_is = if twin.synchronised {
        "a twin that starts each sample period at the observer's state"
    } else {
        "a twin that runs freely, which has no meaning here, as there is no observer"
    };
    match &twin.spread {
        None => format!("{twin_is}, as in the baseline"),
        Some(spread) => format!(
            "{twin_is}: two twins of the scene that started a turn apart still differ by {} um rms at {} after {:.1} s",
            fixed(spread.difference_um, 2),
            spread.probe,
            spread.time_s
        ),
    }
}

fn condition(observation: &Observation) -> String {
    if observation.condition_number.is_nan() || observation.condition_number <= 0.0 {
        return "not known".to_owned();
    }
    let number = alone(observation.condition_number);
    let verdict = if observation.condition_number > BADLY_PLACED {
        "the positions of the probes are unfavourable"
    } else {
        "best value 1; above 100 small errors of the readings become large errors of the motion"
    };
    format!("{number} ({verdict})")
}

/// Describes the normaliser of the NRMSE: one sentence for all probes, or one for each kind.
pub(super) fn normaliser(probes: &[ProbeOutcome]) -> String {
    let mut kinds: Vec<&str> =
        probes.iter().map(|probe| probe.nrmse_normaliser.as_str()).filter(|kind| !kind.is_empty()).collect();
    kinds.sort_unstable();
    kinds.dedup();
    match kinds.as_slice() {
        [] => String::new(),
        [kind] => format!("NRMSE: residual rms over {kind}."),
        _ => probes
            .iter()
            .map(|probe| format!("NRMSE of {}: residual rms over {}.", probe.name, probe.nrmse_normaliser))
            .collect::<Vec<_>>()
            .join(" "),
    }
}

/// Returns the words for the displacement of the forces that are not the twin's.
pub(super) const fn force_source(source: Source) -> &'static str {
    match source {
        Source::Displacement => "from measured displacement",
        Source::Observer => "from the observer",
    }
}

/// Returns the forces of a bearing that the report shows beside the twin's, with their source: the observer's where the straight line between
/// the planes of the probes has an error.
pub(super) const fn shown_forces(bearing: &BearingOutcome) -> (Source, &[ForceFigures; 5]) {
    match bearing.straight_line_error {
        None => (Source::Displacement, &bearing.force_measured),
        Some(_) => (Source::Observer, &bearing.force_estimated),
    }
}

/// Longest life in hours that is printed as a number: beyond it, a bearing does not fail by fatigue.
pub(super) const LONGEST_HOURS: f64 = 1e6;

/// Remark on the lives of the bearings.
pub(super) const LIFE: &str = "For 90 % reliability, by the mean of the loads along this recording at the displacement of the observer, and at its mean speed: L10r from the loads of the elements (ISO/TS 16281), L10mr with a_ISO, L10 from the equivalent load P (ISO 281).";

/// Name of a bearing and its cells of a table.
pub(super) type BearingRow<'a> = (&'a str, Vec<String>);

/// Returns the bearings with a life, each with its figures, and the fields that any of them has.
pub(super) fn lives(bearings: &[BearingOutcome]) -> (Vec<NumericField<LifeOutcome>>, Vec<BearingRow<'_>>) {
    let known = || bearings.iter().filter_map(|bearing| Some((bearing.name.as_str(), bearing.life.as_ref()?)));
    let is_known = |field: &NumericField<LifeOutcome>| known().any(|(_, life)| (field.value)(life).is_finite());
    let fields: Vec<_> = LifeOutcome::FIELDS.into_iter().filter(is_known).collect();
    let cell = |field: &NumericField<LifeOutcome>, life| match (field.value)(life) {
        hours if field.unit == "h" && hours > LONGEST_HOURS => "> 1 000 000".to_owned(),
        value => fixed(value, field.decimals.unwrap_or(0)),
    };
    let rows = known().map(|(name, life)| (name, fields.iter().map(|field| cell(field, life)).collect())).collect();
    (fields, rows)
}

/// Returns the sentence on the error of the straight line between the planes of the probes; none where it has none.
pub(super) fn straight_line(bearing: &BearingOutcome) -> Option<String> {
    let [x, y, z, ..] = bearing.straight_line_error?;
    Some(format!(
        "a straight line between the planes of the probes would be wrong by FX {} N, FY {} N, FZ {} N rms, as the rotor bends or its \
         supports move",
        alone(x),
        alone(y),
        alone(z)
    ))
}

/// Returns remarks about lost contact and held forces of one bearing.
pub(super) fn remarks(contact_lost: u64, held: u64) -> Vec<String> {
    let mut remarks = Vec::new();
    if contact_lost > 0 {
        remarks.push(format!("no element carried load in {}", counted(contact_lost, "sample")));
    }
    if held > 0 {
        remarks.push(format!("last valid force held for {}", counted(held, "sample")));
    }
    remarks
}

/// Returns true where the twin is compared with simpler models. A twin without the fault of its machine is worse than what is fitted to the
/// recording, which is no measure of the twin.
pub(super) fn are_models_judged(outcome: &Outcome) -> bool {
    outcome.diagnoses.is_empty()
}

/// Remark where the twin is not compared with simpler models.
pub(super) const NOT_JUDGED: &str =
    "Not judged: the twin is the machine of the scene without a fault, and a fault is diagnosed.";

/// Remark where a simpler model has a smaller residual than the twin.
pub(super) const BEATEN: &str = "worse: a simpler model leaves over 2 % less than the twin, which is the machine of the scene without a fault. With a fault this is so; without one, the machine differs from its scene.";

/// Returns the word for the standing of the twin against a simpler model.
pub(super) const fn standing(standing: Standing) -> &'static str {
    match standing {
        Standing::Better => "better",
        Standing::Same => "same",
        Standing::Worse => "worse",
    }
}

/// Returns the probes at which a simpler model is better than the twin, such as "DE_X, NDE_X".
pub(super) fn beaten(probes: &[ProbeOutcome]) -> String {
    let names: Vec<&str> =
        probes.iter().filter(|p| p.baselines.worst() == Standing::Worse).map(|p| p.name.as_str()).collect();
    names.join(", ")
}

/// Returns the mean time of a sample by stage; `None` where no twin ran.
pub fn stages(timing: &Timing) -> Option<String> {
    timing.stages.map(|stages| {
        let us = |ns: f64| fixed(ns * 1e-3, 2);
        format!(
            "Mean of a sample: twin {} us, observer {} us, forces {} us, comparison {} us.",
            us(stages.twin_ns),
            us(stages.observer_ns),
            us(stages.forces_ns),
            us(stages.comparison_ns)
        )
    })
}

/// Returns sentences on the timing and the source of a paced replay; none for other replays.
pub fn pacing(timing: &Timing) -> Vec<String> {
    let kept = timing.pacing.as_ref().map(|pacing| {
        format!(
            "Blocks of {} ms: {}, deadline missed {}; {}started in {} s; {}.",
            alone(pacing.block_ns as f64 * 1e-6),
            count(pacing.blocks),
            counted(pacing.deadline_misses, "time"),
            pacing.idle_percent.map(|idle| format!("{} % of one processor idle; ", fixed(idle, 1))).unwrap_or_default(),
            fixed(pacing.starting_s, 2),
            pacing.scheduling
        )
    });
    kept.into_iter().chain(timing.source.as_ref().map(source)).chain(timing.outputs.and_then(not_written)).collect()
}

/// Returns a sentence with the numbers of events, seconds and messages that the outputs could not write; `None` where all are written.
fn not_written(outputs: OutputFigures) -> Option<String> {
    (outputs != OutputFigures::default()).then(|| {
        format!(
            "Not written: {}, {} of indicators, {} to the MQTT broker.",
            counted(outputs.events_not_written, "event"),
            counted(outputs.seconds_not_written, "second"),
            counted(outputs.messages_not_delivered, "message")
        )
    })
}

fn source(source: &SourceFigures) -> String {
    let counts = [
        (source.lost_frames, "lost"),
        (source.repeated_frames, "repeated or late"),
        (source.malformed_frames, "malformed"),
        (source.dropped_rows, "dropped because the buffer was full"),
    ];
    let losses: Vec<String> = counts.iter().map(|(n, what)| format!("{} {what}", count(*n))).collect();
    let stalls = match source.stalls {
        0 => "no interruption".to_owned(),
        n => format!("silent {}, up to {} s", counted(n, "time"), fixed(source.longest_stall_s, 1)),
    };
    format!(
        "Source: {} read, {}; {stalls}; ring buffer: up to {} of {} slots used.",
        counted(source.rows, "sample"),
        losses.join(", "),
        count(source.ring_highest),
        count(source.ring_capacity)
    )
}

/// Returns what the intervals of learned parameters mean, and how well the parameters describe the recording.
pub(super) fn learned(of: &Learning) -> String {
    let meaning = match of.taken {
        true => "The intervals have a joint confidence level of 95 %.",
        false => "They do not describe the recording, so that the intervals state nothing about the machine.",
    };
    format!(
        "{meaning} Chi-squared per value: {:.3}; expected about 1, at most {:.3}.",
        of.chi_square_per_value, of.largest_chi_square_per_value
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averaged_samples_are_not_left_out() {
        let mut record = Record { samples: 102_400, average: 4, compared: 25_600, ..Record::default() };
        assert_eq!(samples(&record), "102 400 read, averages of 4: 25 600, all compared");
        record.compared = 25_000;
        assert_eq!(samples(&record), "102 400 read, averages of 4: 25 600, 600 not compared");
        record.average = 1;
        assert_eq!(samples(&record), "102 400 read, 77 400 not compared");
    }

    #[test]
    fn range_of_speed_is_printed_where_the_speed_varies() {
        let mut record =
            Record { mean_speed_rpm: 3000.0, min_speed_rpm: 3000.0, max_speed_rpm: 3000.0, ..Record::default() };
        assert_eq!(speed(&record), "3000.0 rpm");
        record.max_speed_rpm = 3012.0;
        assert_eq!(speed(&record), "3000.0 rpm mean, 3000.0 to 3012.0");
        record.mean_speed_rpm = -3000.0;
        assert!(rotation(&record).starts_with("from +Y towards +X"));
    }
}
