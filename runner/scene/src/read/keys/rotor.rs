//! Keys of `[rotor]`.

use super::{ANGLE, DENSITY, LENGTH, POISSONS_RATIO, POSITIVE_LENGTH, PRESSURE, TIME_OR_0};
use crate::key::Choice::One;
use crate::key::Kind::{Either, Integer, List, Number, Quantity, Table, Tuple};
use crate::key::{ANY, BELOW_ONE, Keys, Kind, NOT_NEGATIVE, POSITIVE, REQUIRED, five, key};
use crate::units::Dimension;

const MASS: Kind = Quantity(Dimension::Mass, POSITIVE);
const DIAMETRAL_INERTIA: Kind = Quantity(Dimension::Inertia, POSITIVE);
const POLAR_INERTIA: Kind = Quantity(Dimension::Inertia, NOT_NEGATIVE);
const ACCELERATION: Kind = Quantity(Dimension::Acceleration, ANY);

/// Default of mass and inertias of a rotor.
const REQUIRED_OF_RIGID: &str = "required without `sections`";
/// The same of a disk.
const REQUIRED_OF_DISK: &str = "required, or `outer_diameter` and `width`";

pub(super) static ROTOR: Keys = Keys {
    name: "rotor",
    #[rustfmt::skip] // tables
    sections: &[
        ("rotor", &[&[
            key("mass", MASS, "mass", REQUIRED_OF_RIGID, "", "\"6 kg\""),
            key("diametral_inertia", DIAMETRAL_INERTIA, "moment of inertia about a diameter", REQUIRED_OF_RIGID, "",
                "\"0.030 kg m^2\""),
            key("polar_inertia", POLAR_INERTIA, "moment of inertia about the axis", REQUIRED_OF_RIGID,
                "at most twice the diametral one", "\"0.006 kg m^2\""),
            key("damping", Tuple(&five(Dimension::Damping, Dimension::AngularDamping, NOT_NEGATIVE)),
                "dampers on the rotor itself", "0", "", "[400, 400, 400, 0.4, 0.4]"),
            key("proportional_damping", Either(&[TIME_OR_0, Table(&PROPORTIONAL_DAMPING)]),
                "damping over stiffness; as a table only of a [flexible rotor](#flexible-rotor)", "0", "",
                "\"1e-5 s\""),
            key("stiffness", Tuple(&five(Dimension::Stiffness, Dimension::AngularStiffness, NOT_NEGATIVE)),
                "springs on the rotor itself", "0", "", "[0, 0, \"1e6 N/m\", 0, 0]"),
            key("gravity", Tuple(&[ACCELERATION; 3]), "acceleration of gravity", "`[0, -9.80665, 0]`", "",
                "[0, 0, -9.81]"),
            key("load", Tuple(&five(Dimension::Force, Dimension::Moment, ANY)), "constant load at `load_station`", "0",
                "", "[0, 0, \"60 N\", 0, 0]"),
            key("load_station", LENGTH, "station of the load", "centre of mass", "", "\"246 mm\""),
            key("unbalance", List(&Table(&UNBALANCE)), "unbalances", "none", "", ""),
        ]]),
        ("Flexible rotor", &[&[
            key("coordinates", Integer(7, 31), "number of coordinates of the reduced rotor", "by the error", "", "11"),
            key("sections", List(&Table(&SECTION)), "sections of the shaft", "required of a flexible rotor",
                "in order, without gap or overlap; at most 10 000", ""),
            key("disks", List(&Table(&DISK)), "rigid bodies on the shaft", "none", "at most 1000", ""),
            key("youngs_modulus", PRESSURE, "Young's modulus of the shaft", "206 GPa", "", "\"206 GPa\""),
            key("poissons_ratio", POISSONS_RATIO, "Poisson's ratio of the shaft", "0.3", "", "0.3"),
            key("density", DENSITY, "density of the shaft", "7800 kg/m^3", "", "7800"),
            key("modal_damping", Number(BELOW_ONE), "damping ratio of every elastic coordinate", "0", "", "0.01"),
        ]]),
    ],
    choices: &[One(&[&["mass", "diametral_inertia", "polar_inertia"], &["sections"]])],
};

static PROPORTIONAL_DAMPING: Keys = Keys {
    name: "proportional-damping",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("mass", Quantity(Dimension::Rate, NOT_NEGATIVE), "damping over mass", "0", "", "{ mass = \"60 1/s\" }"),
        key("stiffness", TIME_OR_0, "damping over stiffness", "0", "", "{ stiffness = \"2e-6 s\" }"),
    ]])],
    choices: &[],
};

static UNBALANCE: Keys = Keys {
    name: "unbalance",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("moment", Quantity(Dimension::Unbalance, NOT_NEGATIVE), "mass times radius", REQUIRED, "", "\"120 g mm\""),
        key("angle", ANGLE, "angle from the keyphasor mark in the direction of rotation", REQUIRED, "", "\"17 deg\""),
        key("station", LENGTH, "position along Z", REQUIRED, "", "\"20 mm\""),
    ]])],
    choices: &[],
};

static SECTION: Keys = Keys {
    name: "section",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("from", LENGTH, "station of the beginning", REQUIRED, "", "\"0 mm\""),
        key("to", LENGTH, "station of the end", REQUIRED, "beyond `from`", "\"66 mm\""),
        key("outer_diameter", LENGTH, "outer diameter", REQUIRED, "above `inner_diameter`", "\"30 mm\""),
        key("outer_diameter_to", LENGTH, "outer diameter at `to`, of a cone", "`outer_diameter`",
            "above `inner_diameter`", "\"36 mm\""),
        key("inner_diameter", Quantity(Dimension::Length, NOT_NEGATIVE), "diameter of the bore", "0", "", "\"10 mm\""),
    ]])],
    choices: &[],
};

static DISK: Keys = Keys {
    name: "disk",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("station", LENGTH, "position of its centre along Z", REQUIRED, "on the shaft", "\"246 mm\""),
        key("mass", MASS, "mass", REQUIRED_OF_DISK, "", "\"3.3 kg\""),
        key("diametral_inertia", DIAMETRAL_INERTIA, "moment of inertia about a diameter through its centre",
            REQUIRED_OF_DISK, "", "0.007"),
        key("polar_inertia", POLAR_INERTIA, "moment of inertia about the axis", REQUIRED_OF_DISK,
            "at most twice the diametral one", "0.012"),
        key("outer_diameter", POSITIVE_LENGTH, "outer diameter of a cylinder on the shaft",
            "this and `width`, or `mass`", "above that of the shaft", "\"200 mm\""),
        key("width", POSITIVE_LENGTH, "width of the cylinder", "this and `outer_diameter`, or `mass`", "", "\"20 mm\""),
        key("density", DENSITY, "density of the cylinder", "that of the shaft", "only with `outer_diameter`", "7800"),
    ]])],
    choices: &[One(&[&["mass", "diametral_inertia", "polar_inertia"], &["outer_diameter", "width"]])],
};
