//! Reader of the section `[recording]`.

use super::{bearing, mounting};
use crate::table::{Node, Read, Table};
use crate::units::{self, Dimension};
use crate::{
    Bearing, Clock, Direction, FileLayout, KeyphasorSignal, Orientation, Probe, PulseDetection, Recording, Ring,
    RotationSource, Sensor, Sequence, Slope, TemperatureChannel,
};
use std::path::{Path, PathBuf};

/// `sequence`
pub(super) const SEQUENCES: [(&str, Sequence); 2] =
    [("continuous", Sequence::Continuous), ("snapshots", Sequence::Snapshots)];
/// `orientation`
pub(super) const ORIENTATIONS: [(&str, Orientation); 2] =
    [("samples-first", Orientation::SamplesFirst), ("channels-first", Orientation::ChannelsFirst)];
/// `ring` of a temperature
pub(super) const RINGS: [(&str, Ring); 2] = [("inner", Ring::Inner), ("outer", Ring::Outer)];
/// `keyphasor` that is no table
pub(super) const SYNCHRONOUS: [(&str, ()); 1] = [("synchronous", ())];
/// `kind` of a keyphasor
pub(super) const KEYPHASOR_KINDS: [(&str, Kind); 3] =
    [("pulses", Kind::Pulses), ("count", Kind::Count), ("instants", Kind::Instants)];
/// `slope` of a keyphasor
pub(super) const SLOPES: [(&str, Slope); 2] = [("rising", Slope::Rising), ("falling", Slope::Falling)];

/// Columns that are already in use, with their use.
type Taken = Vec<(String, &'static str)>;

pub(super) fn read(node: &Node<'_>, scene: &Path, on_system: bool, bearings: &[Bearing]) -> Read<Recording> {
    let table = node.table()?;
    let (file, further_files) = files(&table, scene.parent().unwrap_or(Path::new("")))?;
    let mut taken = Taken::new();
    let average = table.read("average", |n| average(n, &table))?.unwrap_or(1);
    Ok(Recording {
        average,
        file,
        further_files,
        sequence: table.read("sequence", |n| sequence(n, &table))?,
        layout: file_layout(&table)?,
        clock: clock(&table, &mut taken)?,
        sensors: table.read("sensors", |n| sensors(n, &mut taken))?.unwrap_or_default(),
        probes: probes(&table, average, on_system, &mut taken)?,
        temperatures: table.read("temperature", |n| temperatures(n, &table, bearings, &mut taken))?.unwrap_or_default(),
        rotation: rotation(&table, &mut taken)?,
        run_out: table.read("run_out", |n| run_out(n, &table, scene))?,
    })
}

/// Reads the path of the recording, or those of a list: the first and the others.
fn files(table: &Table<'_>, folder: &Path) -> Read<(PathBuf, Vec<PathBuf>)> {
    let expected = "the name of a file or a folder relative to the scene's folder, or a list of names of files";
    let node = table.required("file", expected)?;
    if let Ok(file) = node.text(expected) {
        return Ok((folder.join(file), vec![]));
    }
    let names = node.list(expected)?.iter().map(|n| n.text(expected)).collect::<Read<Vec<_>>>()?;
    for (i, name) in names.iter().enumerate() {
        if names[..i].contains(name) {
            return Err(node.fail(format!("\"{name}\" twice"), "each file once"));
        }
    }
    let mut paths = names.into_iter().map(|name| folder.join(name));
    let first = paths.next().ok_or_else(|| node.refuse(expected))?;
    Ok((first, paths.collect()))
}

/// Reads the relation of several files to each other. Snapshots are evaluated at the speed of the scene.
fn sequence(node: &Node<'_>, table: &Table<'_>) -> Read<Sequence> {
    let sequence = node.choice(&SEQUENCES)?;
    let is_measured = ["keyphasor", "speed"].into_iter().find(|key| table.has(key));
    if sequence == Sequence::Continuous {
        return Ok(sequence);
    }
    if table.has("probes") {
        let expected = "only sensors; snapshots of displacement are one row each in a table of `ballrace fleet`";
        return Err(node.misplaced(expected));
    }
    match is_measured {
        Some(key) => Err(node.misplaced(format!("no {key}: snapshots have the speed of [shaft]"))),
        None => Ok(sequence),
    }
}

/// Reads the path of the recording at slow roll.
fn run_out(node: &Node<'_>, table: &Table<'_>, scene: &Path) -> Read<PathBuf> {
    let file = node.text("the name of a recording at slow roll, relative to the scene's folder")?;
    if !table.has("probes") {
        return Err(node.misplaced("only with probes; remove it"));
    }
    if !table.has("keyphasor") {
        return Err(node.misplaced("only with a keyphasor, which gives the same angle in both recordings"));
    }
    Ok(scene.parent().unwrap_or(Path::new("")).join(file))
}

fn file_layout(table: &Table<'_>) -> Read<FileLayout> {
    Ok(FileLayout {
        is_headless: !table.read("header", Node::boolean)?.unwrap_or(true),
        orientation: table.read("orientation", |n| n.choice(&ORIENTATIONS))?,
        skip: table
            .read("skip", |n| n.integer("the number of lines above the header, 0 to 10000"))?
            .map(|lines| lines as u32),
        comment: table.read("comment", comment)?,
    })
}

/// Largest number of lines above the header.
pub(super) const MAX_SKIP: i64 = 10_000;

/// Reads the character with which a line begins that is no row.
fn comment(node: &Node<'_>) -> Read<u8> {
    let expected = "the character with which a line begins that is no row, such as \"#\"";
    match node.text(expected)?.as_bytes() {
        [mark] if mark.is_ascii_punctuation() && !b"+-.,\"'".contains(mark) => Ok(*mark),
        _ => Err(node.refuse(expected)),
    }
}

fn average(node: &Node<'_>, table: &Table<'_>) -> Read<u32> {
    if !table.has("probes") && table.has("sensors") {
        return Err(node.fail("average without probes", "probes to average; sensors keep the recording's own rate"));
    }
    node.integer("a whole number of samples from 1 to 1024").map(|count| count as u32)
}

fn clock(table: &Table<'_>, taken: &mut Taken) -> Read<Clock> {
    let choice = "exactly one of rate (samples per second, such as \"12.8 kHz\") \
                  and time (the name of a column in seconds)";
    match (table.optional("rate"), table.optional("time")) {
        (Some(rate), None) => sampling_rate(&rate, taken),
        (None, Some(time)) => time_column(&time, taken),
        (Some(_), Some(time)) => Err(time.fail("both rate and time", choice)),
        (None, None) => Err(table.fail("neither rate nor time", choice)),
    }
}

/// Reads the column of time: its name, or a table with its unit.
fn time_column(node: &Node<'_>, taken: &mut Taken) -> Read<Clock> {
    if !node.is_table() {
        return column_name(node, "time", taken).map(|name| Clock::Column { name, seconds: None });
    }
    let table = node.table()?;
    let column = table.required("column", "the name of the column of time")?;
    let name = column_name(&column, "time", taken)?;
    Ok(Clock::Column { name, seconds: Some(unit(&table, units::time_column, units::TIME_UNITS)?) })
}

fn sampling_rate(node: &Node<'_>, taken: &mut Taken) -> Read<Clock> {
    if node.text("").is_ok_and(|text| text == "file") {
        return Ok(Clock::Stated);
    }
    if !node.is_table() {
        return node.quantity().map(Clock::Rate);
    }
    let table = node.table()?;
    let name = table.required("column", "the name of a single number of the recording")?;
    Ok(Clock::Number {
        name: column_name(&name, "the rate", taken)?,
        hertz: unit(&table, units::frequency_column, "Hz or kHz")?,
    })
}

fn probes(table: &Table<'_>, average: u32, on_system: bool, taken: &mut Taken) -> Read<Vec<Probe>> {
    let expected = "a list of at least one probe, such as \
                 { column = \"DE_X\", unit = \"um\", station = \"-120 mm\", angle = \"0 deg\" }";
    if !table.has("probes") && table.has("sensors") {
        return Ok(vec![]);
    }
    let node = table.required("probes", expected)?;
    let list = node.list(expected)?;
    if list.is_empty() {
        return Err(node.refuse(expected));
    }
    let mut probes: Vec<Probe> = list.iter().map(|node| probe(node, on_system, taken)).collect::<Read<_>>()?;
    // The scene gives the noise of one reading; the means of several have less.
    for noise in probes.iter_mut().filter_map(|probe| probe.noise.as_mut()) {
        *noise /= f64::from(average).sqrt();
    }
    Ok(probes)
}

fn sensors(node: &Node<'_>, taken: &mut Taken) -> Read<Vec<Sensor>> {
    let expected = "a list of at least one sensor, such as { column = \"DE\", unit = \"m/s^2\" }";
    let list = node.list(expected)?;
    if list.is_empty() {
        return Err(node.refuse(expected));
    }
    list.iter().map(|node| sensor(node, taken)).collect()
}

/// Units of vibration.
pub(super) const VIBRATION: [&str; 6] = ["m/s^2", "g", "m/s", "mm/s", "N", "V"];

fn sensor(node: &Node<'_>, taken: &mut Taken) -> Read<Sensor> {
    let table = node.table()?;
    let column = table.required("column", "the name of a column of the recording")?;
    let column = column_name(&column, "a sensor", taken)?;
    let expected = format!("the unit of the column: {}", VIBRATION.join(", "));
    let node = table.required("unit", &expected)?;
    let unit = node.text(&expected)?;
    if !VIBRATION.contains(&unit) {
        return Err(node.refuse(expected));
    }
    let bearing = table.read("bearing", |n| Ok(n.text("the name of a bearing")?.to_owned()))?;
    Ok(Sensor { column, unit: unit.to_owned(), bearing })
}

fn temperatures(
    node: &Node<'_>,
    table: &Table<'_>,
    bearings: &[Bearing],
    taken: &mut Taken,
) -> Read<Vec<TemperatureChannel>> {
    if !table.has("probes") {
        return Err(node.misplaced("only with probes, whose twin has a clearance; remove it"));
    }
    let expected = "a list of at least one temperature, such as \
                 { column = \"T_DE\", unit = \"degC\", bearing = \"DE\", ring = \"outer\" }";
    let list = node.list(expected)?;
    if list.is_empty() {
        return Err(node.refuse(expected));
    }
    let mut channels: Vec<TemperatureChannel> = vec![];
    for node in &list {
        let channel = temperature(node, bearings, taken)?;
        if channels.iter().any(|other| other.bearing == channel.bearing && other.ring == channel.ring) {
            return Err(node.repeated("one temperature of each ring"));
        }
        channels.push(channel);
    }
    Ok(channels)
}

fn temperature(node: &Node<'_>, bearings: &[Bearing], taken: &mut Taken) -> Read<TemperatureChannel> {
    let table = node.table()?;
    let column = table.required("column", "the name of a column of the recording")?;
    let column = column_name(&column, "a temperature", taken)?;
    let expected = "the unit of the column: degC, K or degF";
    let unit = table.required("unit", expected)?;
    let Some((kelvins_per_unit, zero)) = mounting::temperature_unit(unit.text(expected)?) else {
        return Err(unit.refuse(expected));
    };
    let expected = "the name of a [[bearing]]";
    let node = table.required("bearing", expected)?;
    let name = node.text(expected)?;
    let Some(bearing) = bearings.iter().find(|bearing| bearing.name == name) else { return Err(node.refuse(expected)) };
    if bearing.mounting.is_none_or(|mounting| mounting.temperatures.is_none()) {
        return Err(
            node.refuse("a bearing with temperatures = { inner, outer }, whose difference the other ring keeps")
        );
    }
    let ring = table.required("ring", "\"inner\" or \"outer\"")?;
    let ring = ring.choice(&RINGS)?;
    Ok(TemperatureChannel { column, kelvins_per_unit, zero, bearing: name.to_owned(), ring })
}

fn probe(node: &Node<'_>, on_system: bool, taken: &mut Taken) -> Read<Probe> {
    let table = node.table()?;
    let column = table.required("column", "the name of a column of the recording")?;
    let column = column_name(&column, "a probe", taken)?;
    let (metres_per_unit, sensitivity) = conversion(&table)?;
    let noise = table.optional_quantity("noise")?;
    let direction = direction(&table)?;
    let station = probe_station(&table, direction, on_system)?;
    let coordinates = bearing::coordinates(&table, "coordinates", on_system)?;
    let offset = table.read("offset", |n| offset(n, sensitivity))?.unwrap_or(0.0);
    Ok(Probe { column, metres_per_unit, station, coordinates, direction, noise, offset, sensitivity })
}

/// Returns the metres per unit of a probe's column, and the sensitivity (V/m) of one in volts.
fn conversion(table: &Table<'_>) -> Read<(f64, Option<f64>)> {
    let expected = "the unit of the column: um, mil, mm or m, or V or mV with a sensitivity";
    let node = table.required("unit", expected)?;
    let text = node.text(expected)?;
    let Ok(volts) = units::voltage_column(text) else {
        let metres =
            units::length_column(text).map_err(|e| node.invalid(e.found, format!("{}; or V or mV", e.expected)))?;
        return match table.optional("sensitivity") {
            Some(key) => {
                Err(key.misplaced(format!("unit = \"V\" or \"mV\" with a sensitivity, found {}", node.shown())))
            }
            None => Ok((metres, None)),
        };
    };
    let expected = "a voltage per length of a column in volts, such as \"7.87 mV/um\" or \"200 mV/mil\"";
    let range = "that is not 0; negative where the voltage falls as the shaft moves along the angle of the probe";
    let node = table.required("sensitivity", expected)?;
    let sensitivity = node.within(range, |s| s != 0.0 && (volts / s).is_finite())?;
    Ok((volts / sensitivity, Some(sensitivity)))
}

/// Reads the reading of a probe with the shaft in the middle, in m; of a probe in volts also as a voltage.
fn offset(node: &Node<'_>, sensitivity: Option<f64>) -> Read<f64> {
    let Some(sensitivity) = sensitivity else { return node.quantity() };
    let expected = "a voltage or a length with its unit, such as \"-9.5 V\" or \"3.2 um\"";
    let text = node.text(expected)?;
    match units::parse(text, Dimension::Voltage) {
        Ok(volts) if (volts / sensitivity).is_finite() => Ok(volts / sensitivity),
        Ok(_) => Err(node.refuse(expected)),
        Err(_) => units::parse(text, Dimension::Length).map_err(|e| node.invalid(e.found, expected)),
    }
}

fn direction(table: &Table<'_>) -> Read<Direction> {
    if table.read("axial", Node::boolean)?.unwrap_or(false) {
        return match table.optional("angle") {
            Some(angle) => Err(angle.misplaced("no angle with axial = true; remove one of the two")),
            None => Ok(Direction::Axial),
        };
    }
    let expected =
        format!("{}, from +X towards +Y; or axial = true for a probe along Z", Dimension::Angle.expected(""));
    Ok(Direction::Radial(table.required("angle", &expected)?.quantity()?))
}

fn probe_station(table: &Table<'_>, direction: Direction, on_system: bool) -> Read<f64> {
    if on_system {
        if let Some(station) = table.optional("station") {
            return Err(station.misplaced("no station on a [system], whose coordinates define the position; remove it"));
        }
        return table.required("coordinates", bearing::COORDINATES).map(|_| 0.0);
    }
    match direction {
        Direction::Radial(_) => table.quantity("station"),
        Direction::Axial => Ok(table.optional_quantity("station")?.unwrap_or(0.0)),
    }
}

fn rotation(table: &Table<'_>, taken: &mut Taken) -> Read<RotationSource> {
    match (table.optional("keyphasor"), table.optional("speed")) {
        (None, None) => Ok(RotationSource::Scene),
        (Some(node), None) => {
            let source = keyphasor(&node, taken)?;
            if source == RotationSource::Synchronous
                && let Some(time) = table.optional("time")
            {
                return Err(time.fail("time beside keyphasor = \"synchronous\"", "rate = \"file\""));
            }
            Ok(source)
        }
        (None, Some(node)) => speed_column(&node, taken),
        (Some(_), Some(node)) => {
            Err(node.fail("both keyphasor and speed", "at most one of them as the source of the shaft angle"))
        }
    }
}

/// `kind` of a keyphasor.
#[derive(Clone, Copy)]
pub(super) enum Kind {
    Pulses,
    Count,
    Instants,
}

fn keyphasor(node: &Node<'_>, taken: &mut Taken) -> Read<RotationSource> {
    if !node.is_table() {
        return node.choice(&SYNCHRONOUS).map(|()| RotationSource::Synchronous);
    }
    let table = node.table()?;
    let column = table.required("column", "the name of the column with the pulses")?;
    let column = column_name(&column, "the keyphasor", taken)?;
    let expected = "a whole number, 1 or more";
    let pulses = table.required("pulses_per_turn", expected)?;
    let pulses_per_turn = u32::try_from(pulses.integer(expected)?).map_err(|_| pulses.refuse(expected))?;
    let kind = table.read("kind", |n| n.choice(&KEYPHASOR_KINDS))?.unwrap_or(Kind::Pulses);
    let misplaced: &[&str] = match kind {
        Kind::Pulses => &[],
        Kind::Count => &["missing", "unit", "threshold", "hysteresis", "slope"],
        Kind::Instants => &["threshold", "hysteresis", "slope"],
    };
    if let Some(node) = misplaced.iter().find_map(|key| table.optional(key)) {
        return Err(node.misplaced("only with kind = \"pulses\"; remove it"));
    }
    let missing = table.read("missing", |n| missing_teeth(n, pulses_per_turn))?.unwrap_or(0);
    let signal = match kind {
        Kind::Pulses => KeyphasorSignal::Pulses(pulse_detection(&table)?),
        Kind::Count => KeyphasorSignal::Count,
        Kind::Instants => KeyphasorSignal::Instants { seconds: unit(&table, units::time_column, units::TIME_UNITS)? },
    };
    Ok(RotationSource::Keyphasor { column, pulses_per_turn, missing, signal })
}

/// Reads the number of absent teeth. More than half of them would be a wheel without teeth for the most part.
fn missing_teeth(node: &Node<'_>, pulses_per_turn: u32) -> Read<u32> {
    let most = pulses_per_turn / 2;
    let expected =
        format!("a whole number from 1 to {most}, half of pulses_per_turn, in which the absent teeth are counted");
    if pulses_per_turn < 3 {
        return Err(node.misplaced("only with pulses_per_turn of 3 or more; remove it"));
    }
    node.integer_within(1, most.into(), &expected).map(|missing| missing as u32)
}

fn pulse_detection(table: &Table<'_>) -> Read<PulseDetection> {
    let voltage = |n: &Node<'_>| {
        let expected = "the unit of the column: V or mV";
        units::voltage_column(n.text(expected)?).map_err(|e| n.invalid(e.found, e.expected))
    };
    let volts_per_unit = table.read("unit", voltage)?;
    let level = |node: &Node<'_>, range: &str| match volts_per_unit {
        Some(_) => node.quantity(),
        None => {
            node.number(&format!("a number{range} as in the column, or a voltage{range} with unit = \"V\" or \"mV\""))
        }
    };
    Ok(PulseDetection {
        volts_per_unit,
        threshold: table.read("threshold", |n| level(n, ""))?,
        hysteresis: table.read("hysteresis", |n| level(n, " above 0"))?,
        slope: table.read("slope", |n| n.choice(&SLOPES))?,
    })
}

fn speed_column(node: &Node<'_>, taken: &mut Taken) -> Read<RotationSource> {
    let table = node.table()?;
    let column = table.required("column", "the name of the column with the speed")?;
    Ok(RotationSource::SpeedColumn {
        column: column_name(&column, "the speed", taken)?,
        radians_per_second: unit(&table, units::speed_column, "rpm, rev/s or rad/s")?,
    })
}

/// Reads the factor of the `unit` of a column, which has no default: units are never assumed.
fn unit(table: &Table<'_>, factor: impl Fn(&str) -> Result<f64, units::Mismatch>, names: &str) -> Read<f64> {
    let expected = format!("the unit of the column: {names}");
    let node = table.required("unit", &expected)?;
    factor(node.text(&expected)?).map_err(|e| node.invalid(e.found, e.expected))
}

/// Reads the name of a column that has no other use; `user` is its use.
fn column_name(node: &Node<'_>, user: &'static str, taken: &mut Taken) -> Read<String> {
    let name = node.text("the name of a column of the recording")?;
    if let Some((_, other)) = taken.iter().find(|(column, _)| column == name) {
        return Err(node.repeated(format!("a column of its own ({other} has this one)")));
    }
    taken.push((name.to_owned(), user));
    Ok(name.to_owned())
}
