//! The keys of a scene.
//!
//! Each table has its keys in the order in which messages list them. The tables of `docs/src/scene.md` and the schema for editors are
//! written from them.

mod bearing;
mod recording;
mod rotor;

use super::{METHODS, SUPPORTS};
use crate::Indicator;
use crate::key::Choice::{AtMostOne, One};
use crate::key::Kind::{Either, Integer, List, Number, Quantity, Table, Text, Tuple, Words};
use crate::key::{ANY, BELOW_ONE, Bounds, Keys, Kind, NOT_NEGATIVE, POSITIVE, REQUIRED, key, words};
use crate::units::Dimension;
use std::ops::Bound::Excluded;

const LENGTH: Kind = Quantity(Dimension::Length, ANY);
const POSITIVE_LENGTH: Kind = Quantity(Dimension::Length, POSITIVE);
const ANGLE: Kind = Quantity(Dimension::Angle, ANY);
const SPEED: Kind = Quantity(Dimension::Speed, ANY);
const POSITIVE_TIME: Kind = Quantity(Dimension::Time, POSITIVE);
const TIME_OR_0: Kind = Quantity(Dimension::Time, NOT_NEGATIVE);
const PRESSURE: Kind = Quantity(Dimension::Pressure, POSITIVE);
const DENSITY: Kind = Quantity(Dimension::Density, POSITIVE);
const POISSONS_RATIO: Kind = Number((std::ops::Bound::Included(0.0), Excluded(0.5)));
const BEARING_NAME: Kind = Text("name of a bearing");
const FILE: Kind = Text("file");
const COLUMN: Kind = Text("column");

pub(crate) static SCENE: Keys = Keys {
    name: "scene",
    #[rustfmt::skip] // a table
    sections: &[("Top level", &[&[
        key("name", Text("text"), "name of the scene", "name of the file", "", "\"spindle\""),
        key("shaft", Table(&SHAFT), "[rotation](#shaft)", REQUIRED, "", ""),
        key("rotor", Table(&rotor::ROTOR), "[rotor](#rotor), rigid or flexible", "none", "not together with `system`",
            ""),
        key("system", Table(&SYSTEM), "[matrices](#system) of a rotor", "none", "not together with `rotor`", ""),
        key("bearing", List(&Table(&bearing::BEARING)), "[bearings](#bearing)", REQUIRED, "1 to 8", ""),
        key("machine", Table(&MACHINE), "[class](#machine) of the machine, for the vibration of its housings", "none", "", ""),
        key("recording", Table(&recording::RECORDING), "[recording](#recording) of the machine", "none", "", ""),
        key("integration", Table(&INTEGRATION), "[integration](#integration) in time", "defaults of its keys", "", ""),
        key("observer", Table(&OBSERVER), "[observer](#observer) of the twin", "defaults of its keys", "", ""),
        key("limit", List(&Table(&LIMIT)), "[alarm limits](#limit)", "none", "", ""),
    ]])],
    choices: &[AtMostOne(&["rotor", "system"])],
};

static SHAFT: Keys = Keys {
    name: "shaft",
    #[rustfmt::skip] // a table
    sections: &[("shaft", &[&[
        key("speed", Either(&[SPEED, Table(&SPEEDS)]),
            "speed of the shaft, positive about +Z; as a table a ramp or a fluctuation", REQUIRED, "", "\"3000 rpm\""),
        key("outer_speed", SPEED, "speed of the outer rings", "0", "only with one constant shaft speed",
            "\"-500 rpm\""),
    ]])],
    choices: &[],
};

static SPEEDS: Keys = Keys {
    name: "speed",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("from", SPEED, "speed at the start of a ramp", "required of a ramp", "",
            "{ from = \"600 rpm\", to = \"6000 rpm\", over = \"2 s\" }"),
        key("to", SPEED, "speed at its end, constant from there on", "required of a ramp", "", ""),
        key("over", POSITIVE_TIME, "its duration", "required of a ramp", "", ""),
        key("mean", SPEED, "mean of a fluctuating speed", "required of a fluctuation", "",
            "{ mean = \"3000 rpm\", fluctuation = 0.02, frequency = \"7 Hz\" }"),
        key("fluctuation", Number(BELOW_ONE), "amplitude over mean", "required of a fluctuation", "", ""),
        key("frequency", Quantity(Dimension::Frequency, POSITIVE), "its frequency", "required of a fluctuation", "",
            ""),
    ]])],
    choices: &[One(&[&["from", "to", "over"], &["mean", "fluctuation", "frequency"]])],
};

static SYSTEM: Keys = Keys {
    name: "system",
    #[rustfmt::skip] // a table
    sections: &[("system", &[&[
        key("mass", FILE, "mass matrix", REQUIRED, "symmetric", "\"M.mtx\""),
        key("damping", FILE, "damping matrix", "0", "symmetric", "\"B.mtx\""),
        key("gyroscopic", FILE, "gyroscopic matrix, multiplied by the speed", "0", "antisymmetric", "\"G.mtx\""),
        key("stiffness", FILE, "stiffness matrix", REQUIRED, "symmetric", "\"K.mtx\""),
        key("load", FILE, "constant load", "0", "one value a coordinate", "\"f.npy\""),
        key("proportional_damping", TIME_OR_0, "damping over stiffness", "0", "", "1e-5"),
        key("unbalance", List(&Table(&SYSTEM_UNBALANCE)), "unbalances", "none", "", ""),
    ]])],
    choices: &[],
};

static SYSTEM_UNBALANCE: Keys = Keys {
    name: "system-unbalance",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("moment", Quantity(Dimension::Unbalance, NOT_NEGATIVE), "mass times radius", REQUIRED, "", "\"30 g mm\""),
        key("angle", ANGLE, "angle from the keyphasor mark in the direction of rotation", REQUIRED, "", "\"0 deg\""),
        key("x", Integer(1, 128), "number of the coordinate along X", REQUIRED, "", "5"),
        key("y", Integer(1, 128), "number of the coordinate along Y", REQUIRED, "", "6"),
    ]])],
    choices: &[],
};

static MACHINE: Keys = Keys {
    name: "machine",
    #[rustfmt::skip] // a table
    sections: &[("machine", &[&[
        key("group", Integer(1, 2), "group of ISO 20816-3: 1 above 300 kW, 2 from 15 to 300 kW",
            "this and `support`, or `velocity_limits`", "", "2"),
        key("support", Words(|| words(&SUPPORTS)),
            "support; rigid: its natural frequencies are above 1.25 times the shaft speed",
            "this and `group`, or `velocity_limits`", "", "\"rigid\""),
        key("velocity_limits", Tuple(&[Quantity(Dimension::Velocity, POSITIVE); 3]),
            "limits of the zones A, B and C, rms from 10 to 1000 Hz", "those of `group` and `support`", "rising",
            "[\"1.4 mm/s\", \"2.8 mm/s\", \"4.5 mm/s\"]"),
    ]])],
    choices: &[One(&[&["group", "support"], &["velocity_limits"]])],
};

static INTEGRATION: Keys = Keys {
    name: "integration",
    #[rustfmt::skip] // a table
    sections: &[("integration", &[&[
        key("method", Words(|| words(&METHODS)), "integration method", "`\"runge-kutta\"`", "", "\"verlet\""),
        key("step", POSITIVE_TIME, "longest step", "from the highest natural frequency", "", "\"20 us\""),
        key("newton_steps", Integer(1, 20), "Newton steps of each step", "2", "only `newmark`", "3"),
    ]])],
    choices: &[],
};

static OBSERVER: Keys = Keys {
    name: "observer",
    #[rustfmt::skip] // a table
    sections: &[("observer", &[&[
        key("process_noise", Number(POSITIVE), "process noise of an unmodelled force, N per root second",
            "most likely value over the first samples", "required by `bake` for an observer", "50"),
        key("wander", Number(POSITIVE), "former name of `process_noise`", "none", "not together with `process_noise`",
            ""),
    ]])],
    choices: &[AtMostOne(&["process_noise", "wander"])],
};

/// Range of `growth_db`.
const DECIBELS: Bounds = (Excluded(0.0), Excluded(200.0));

static LIMIT: Keys = Keys {
    name: "limit",
    #[rustfmt::skip] // a table
    sections: &[("limit", &[&[
        key("indicator", Words(|| words(&Indicator::ALL)), "limited number", REQUIRED, "", "\"1X\""),
        key("probe", Text("column of a probe"), "probe whose number is limited", "every radial probe", "",
            "\"DE_X_um\""),
        key("bearing", BEARING_NAME, "bearing whose line is limited",
            "required for `\"outer-race\"` and `\"inner-race\"`", "only there", "\"DE\""),
        key("max", Either(&[POSITIVE_LENGTH, Number(POSITIVE)]), "upper limit", "this or `growth_db`",
            "a number for crest factor and kurtosis, else a length", "\"25 um\""),
        key("growth_db", Number(DECIBELS), "upper limit over the baseline, dB", "this or `max`",
            "not for peak-to-peak, rms, crest factor, kurtosis", "6"),
        key("hysteresis", Number(BELOW_ONE),
            "share of the limit by which a value falls below it at the end of an event", "0.1", "", "0.05"),
        key("duration", TIME_OR_0, "duration below which an event is not reported", "0", "", "\"1 s\""),
    ]])],
    choices: &[One(&[&["max"], &["growth_db"]])],
};
