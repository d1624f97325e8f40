//! Keys of `[recording]`.

use super::super::mounting::TEMPERATURE_UNITS;
use super::super::recording::{
    KEYPHASOR_KINDS, MAX_SKIP, ORIENTATIONS, RINGS, SEQUENCES, SLOPES, SYNCHRONOUS, VIBRATION,
};
use super::bearing::COORDINATES;
use super::{ANGLE, BEARING_NAME, COLUMN, FILE, LENGTH, POSITIVE_LENGTH};
use crate::key::Choice::{Any, AtMostOne, One};
use crate::key::Kind::{Boolean, Either, Integer, List, Number, Quantity, Table, Text, Unit, Words};
use crate::key::{ANY, Keys, Kind, POSITIVE, REQUIRED, key, words};
use crate::units::{self, Dimension};

const TIME_UNIT: Kind = Words(|| words(&units::TIME_COLUMN));
const VOLTAGE: Kind = Quantity(Dimension::Voltage, ANY);

pub(super) static RECORDING: Keys = Keys {
    name: "recording",
    #[rustfmt::skip] // a table
    sections: &[("recording", &[&[
        key("file", Either(&[FILE, List(&FILE)]), "recording: a file, a folder or a list of files", REQUIRED,
            "relative to the scene's folder; see [several files](recordings.md#several-files)", "\"healthy.csv\""),
        key("sequence", Words(|| words(&SEQUENCES)), "relation of several files to each other",
            "required for several files", "snapshots only with `sensors`, without `probes`, `keyphasor` and `speed`",
            "\"snapshots\""),
        key("rate", Either(&[Quantity(Dimension::Frequency, POSITIVE), Words(|| vec!["file"]), Table(&RATE)]),
            "sampling rate; `\"file\"`: the rate that the [file](recordings.md#formats) states", "this or `time`", "",
            "\"12.8 kHz\""),
        key("time", Either(&[COLUMN, Table(&TIME)]), "column of seconds, or of [date and time](recordings.md#text)",
            "this or `rate`", "", "\"time_s\""),
        key("average", Integer(1, 1024), "number of samples of the probes that are averaged into one first", "1",
            "`sensors` keep the rate of the recording, and alone they allow no `average`", "8"),
        key("probes", List(&Table(&PROBE)), "displacement probes", "this, `sensors` or both", "at least one", ""),
        key("sensors", List(&Table(&SENSOR)), "sensors of [vibration](diagnosis.md#vibration)",
            "this, `probes` or both", "at least one", ""),
        key("temperature", List(&Table(&TEMPERATURE)),
            "temperatures of rings, which correct the [operating clearance](models.md#operating-clearance)", "none",
            "with `probes`; each ring once", ""),
        key("keyphasor", Either(&[Table(&KEYPHASOR), Words(|| words(&SYNCHRONOUS))]),
            "keyphasor; `\"synchronous\"`: the [file](recordings.md#exports-of-system-1) states samples per revolution",
            "none", "not with `speed`; `\"synchronous\"` with `rate`", "\"synchronous\""),
        key("speed", Table(&SPEED), "column of the shaft speed", "none", "not with `keyphasor`", ""),
        key("run_out", FILE, "recording at slow roll with the same columns; see [run-out](recordings.md#run-out)",
            "none", "relative to the scene's folder; only with `probes` and `keyphasor`", "\"slow-roll.csv\""),
        key("header", Boolean, "`false`: the first line of a text has values, and the columns are `c0`, `c1`, ...",
            "`true`", "", "false"),
        key("orientation", Words(|| words(&ORIENTATIONS)), "order of the samples of an array",
            "from the [shape](recordings.md#orientation-of-arrays)", "only NPY and NPZ", "\"channels-first\""),
        key("skip", Integer(0, MAX_SKIP), "number of lines of a text above the line with the names of the columns",
            "detected", "", "3"),
        key("comment", Text("character"), "first character of lines of a text that are no rows", "`#`, `%`", "",
            "\"!\""),
    ]])],
    choices: &[One(&[&["rate"], &["time"]]), Any(&[&["probes"], &["sensors"]]), AtMostOne(&["keyphasor", "speed"])],
};

static RATE: Keys = Keys {
    name: "rate",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", Text("single number of the file"), "number such as a variable of MATLAB", REQUIRED, "",
            "\"bearing.sr\""),
        key("unit", Unit(Dimension::Frequency), "its unit", REQUIRED, "`\"Hz\"`, `\"kHz\"`", "\"Hz\""),
    ]])],
    choices: &[],
};

static TIME: Keys = Keys {
    name: "time",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", COLUMN, "column of time", REQUIRED, "", "\"t_ms\""),
        key("unit", TIME_UNIT, "its unit", REQUIRED, "", "\"ms\""),
    ]])],
    choices: &[],
};

static PROBE: Keys = Keys {
    name: "probe",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", COLUMN, "column of the readings", REQUIRED, "used once", "\"DE_X_um\""),
        key("unit", Either(&[Unit(Dimension::Length), Unit(Dimension::Voltage)]), "its unit", REQUIRED,
            "`\"um\"`, `\"mil\"`, `\"mm\"`, `\"m\"` and others; `\"V\"`, `\"mV\"` with `sensitivity`", "\"um\""),
        key("station", LENGTH, "position along Z", "required with `rotor`; 0 for an axial probe", "not with `system`",
            "\"-120 mm\""),
        key("coordinates", COORDINATES, "coordinates of the shaft's `u, v, w, thu, thv` at the probe",
            "required with `system`", "as those of a [bearing](#position-and-model)", "[5, 6, 0, -8, 7]"),
        key("angle", ANGLE, "measuring direction, from X towards Y", "required for a radial probe", "", "\"45 deg\""),
        key("axial", Boolean, "`true`: the probe measures along Z", "`false`", "without `angle`", "true"),
        key("noise", POSITIVE_LENGTH, "rms noise of one reading", "unknown", "", "\"0.03 um\""),
        key("offset", Either(&[LENGTH, VOLTAGE]), "reading with the shaft in the middle, subtracted from every reading",
            "0", "a voltage only with `sensitivity`, there a text with its unit", "\"3.2 um\""),
        key("sensitivity", Quantity(Dimension::Sensitivity, ANY),
            "voltage per length of a [probe in volts](recordings.md#probes-in-volts)", "required for a column in volts",
            "not 0; its sign has a meaning", "\"7.87 mV/um\""),
    ]])],
    choices: &[],
};

static SENSOR: Keys = Keys {
    name: "sensor",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", COLUMN, "column of the readings", REQUIRED, "used once", "\"DE\""),
        key("unit", Words(|| VIBRATION.to_vec()), "its unit", REQUIRED, "", "\"g\""),
        key("bearing", BEARING_NAME, "bearing at the sensor", "every bearing", "", "\"DE\""),
    ]])],
    choices: &[],
};

static TEMPERATURE: Keys = Keys {
    name: "temperature",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", COLUMN, "column of the readings", REQUIRED, "used once", "\"T_DE\""),
        key("unit", Words(|| words(&TEMPERATURE_UNITS)), "its unit", REQUIRED, "", "\"degC\""),
        key("bearing", BEARING_NAME, "bearing of the ring", REQUIRED, "one with `temperatures`", "\"DE\""),
        key("ring", Words(|| words(&RINGS)), "ring at the sensor", REQUIRED, "", "\"outer\""),
    ]])],
    choices: &[],
};

static KEYPHASOR: Keys = Keys {
    name: "keyphasor",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", COLUMN, "column of the pulses", REQUIRED, "used once", "\"keyphasor\""),
        key("pulses_per_turn", Integer(1, u32::MAX as i64),
            "pulses per revolution; on a toothed wheel with a gap, absent teeth are counted", REQUIRED, "", "1"),
        key("missing", Integer(1, u32::MAX as i64), "absent teeth of a toothed wheel, one after another", "no gap",
            "up to half of `pulses_per_turn`", "2"),
        key("kind", Words(|| words(&KEYPHASOR_KINDS)),
            "`\"count\"`: the column counts the pulses; `\"instants\"`: a vector has the \
             [instants](recordings.md#instants-of-pulses) of the pulses", "`\"pulses\"`", "", "\"count\""),
        key("unit", Either(&[Unit(Dimension::Voltage), TIME_UNIT]), "unit of the column",
            "none; required for `\"instants\"`, and with `threshold` or `hysteresis` in volts",
            "of time for `\"instants\"`, else `\"V\"`, `\"mV\"`", "\"V\""),
        key("threshold", Either(&[VOLTAGE, Number(ANY)]), "level at which a pulse begins",
            "half way between the levels, which are followed", "without `unit` a number of the column", "\"-10.5 V\""),
        key("hysteresis", Either(&[Quantity(Dimension::Voltage, POSITIVE), Number(POSITIVE)]),
            "full width of the band about the threshold that a pulse crosses", "from the noise",
            "without `unit` a number of the column", "\"0.5 V\""),
        key("slope", Words(|| words(&SLOPES)), "edge at which a pulse is timed", "that into the rarer level", "",
            "\"falling\""),
    ]])],
    choices: &[],
};

static SPEED: Keys = Keys {
    name: "speed-column",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("column", COLUMN, "column of the speed", REQUIRED, "used once", "\"rpm\""),
        key("unit", Unit(Dimension::Speed), "its unit", REQUIRED, "`\"rpm\"`, `\"rev/s\"`, `\"rad/s\"`", "\"rpm\""),
    ]])],
    choices: &[],
};
