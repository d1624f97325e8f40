//! Keys of `[[bearing]]`.

use super::super::bearing::{DEFECT_SHAPES, FACINGS, SURFACES, WAVE_DIRECTIONS, all_models, linearised_models};
use super::super::effects::{EFFECTS, FRICTION_SHARINGS, RACE_CONTROLS};
use super::super::pitch_circle::ELEMENTS;
use super::super::rollers::{MOST_LAMINAE, PROFILES};
use super::{ANGLE, DENSITY, LENGTH, POISSONS_RATIO, POSITIVE_LENGTH, PRESSURE, SPEED};
use crate::key::Choice::{Any, AtMostOne, One};
use crate::key::Kind::{Either, Integer, List, Number, NumberIn, Quantity, Table, Temperature, Text, Tuple, Words};
use crate::key::{ANY, BELOW_ONE, Keys, Kind, NOT_NEGATIVE, POSITIVE, REQUIRED, key, words};
use crate::model::OWN_KEYS;
use crate::units::Dimension;
use crate::{LubricationMethod, PreloadState, RollerKind};
use std::ops::Bound::{Excluded, Included};

/// Coordinates of a system.
pub(super) const COORDINATES: Kind = Tuple(&[Integer(-128, 128); 5]);
/// Conformity of a race.
const CONFORMITY: Kind = Number((Excluded(0.5), Included(1.0)));
/// Exponent of a load-deflection law.
const EXPONENT: Kind = Number((Included(1.0), Included(3.0)));
/// Stiffness of a load-deflection law; its unit has the exponent of the law.
const CONTACT_STIFFNESS: Kind = Quantity(Dimension::ContactStiffness(1.5), POSITIVE);
/// Linear thermal expansion.
const EXPANSION: Kind = NumberIn("1/K", (Included(0.0), Included(1e-4)));
const KINEMATIC_VISCOSITY: Kind = Quantity(Dimension::KinematicViscosity, POSITIVE);
const RATING: Kind = Quantity(Dimension::Force, POSITIVE);
/// Conductance of heat.
const CONDUCTANCE: Kind = NumberIn("W/K", (Included(0.0), Included(1e4)));
const STIFFNESS: Kind = Quantity(Dimension::Stiffness, ANY);
const POSITIVE_STIFFNESS: Kind = Quantity(Dimension::Stiffness, POSITIVE);
const CROSS_STIFFNESS: Kind = Quantity(Dimension::CrossStiffness, ANY);
const ANGULAR_STIFFNESS: Kind = Quantity(Dimension::AngularStiffness, ANY);
const DAMPING: Kind = Quantity(Dimension::Damping, NOT_NEGATIVE);
const FORCES: Kind = Tuple(&[STIFFNESS, STIFFNESS, STIFFNESS, CROSS_STIFFNESS, CROSS_STIFFNESS]);
const MOMENTS: Kind = Tuple(&[CROSS_STIFFNESS, CROSS_STIFFNESS, CROSS_STIFFNESS, ANGULAR_STIFFNESS, ANGULAR_STIFFNESS]);

/// Section of the reference whose keys stand apart in the order of messages.
const POSITION: &str = "Position and model";
/// The same of the models that solve for each ball.
const QUASI_STATIC: &str = "Keys of `quasi-static` and `tabulated`";

pub(super) static BEARING: Keys = Keys {
    name: "bearing",
    #[rustfmt::skip] // tables
    sections: &[
        (POSITION, &[&[
            key("name", Text("text"), "name of the bearing", REQUIRED, "unique", "\"DE\""),
            key("bearing", Text("designation"),
                "bearing of the [catalogue](#catalogue), whose values stand for keys that the scene does not have",
                "none", "", "\"6309 C3\""),
            key("station", LENGTH, "position along Z", "required with `rotor`; 0 without",
                "not with `system`", "\"-100 mm\""),
            key("facing", Words(|| words(&FACINGS)),
                "thrust direction that the bearing carries; `\"both\"`: deep groove", "`\"both\"`", "", "\"+z\""),
            key("model", Words(|| words(&all_models())), "model of the forces",
                "that of the catalogue; none for [vibration alone](#bearing-for-vibration-alone)", "",
                "\"angular\""),
            key("elements", Integer(*ELEMENTS.start(), *ELEMENTS.end()), "number of rolling elements",
                "required without `bearing` and `orders`", "as many as fit on the pitch circle", "9"),
            key("first_element_azimuth", ANGLE, "azimuth of the first element at shaft angle 0", "0", "", "\"10 deg\""),
            key("cage_ratio", Number(BELOW_ONE), "cage speed over shaft speed, also where the outer ring turns",
                "pure rolling at the free contact angle; required without geometry, except for `linear`", "", "0.4"),
        ]]),
        ("Geometry", &[&[
            key("ball_diameter", POSITIVE_LENGTH, "diameter of the balls", "required of a geometry", "", "\"7.94 mm\""),
            key("pitch_diameter", POSITIVE_LENGTH, "diameter of the circle of ball centres", "required of a geometry",
                "above `ball_diameter`", "\"39.04 mm\""),
            key("inner_conformity", CONFORMITY, "groove radius over ball diameter of the inner race",
                "required of a geometry", "", "0.52"),
            key("outer_conformity", CONFORMITY, "the same of the outer race", "required of a geometry", "", "0.52"),
            key("contact_angle", ANGLE, "free contact angle", "this or `diametral_clearance`", "0 to 60 deg",
                "\"40 deg\""),
            key("diametral_clearance", LENGTH, "diametral clearance", "this or `contact_angle`",
                "0 to below `A = (f_i + f_o - 1) D`; negative (interference) only with `lumped`, `linear` and \
                 `dynamic`", "\"10 um\""),
            key("youngs_modulus", PRESSURE, "Young's modulus of balls and races", "206 GPa", "", "\"206 GPa\""),
            key("poissons_ratio", POISSONS_RATIO, "their Poisson's ratio", "0.3", "", "0.3"),
            key("density", DENSITY, "density of the balls", "7800 kg/m^3", "", "\"3200 kg/m^3\""),
        ]]),
        ("Rollers", &[&[
            key("roller_diameter", POSITIVE_LENGTH,
                "diameter of the rollers, in place of `ball_diameter`; of tapered rollers the mean", "none",
                "below `pitch_diameter`; with `roller`, `quasi-static`, `lumped` and without `model`", "\"7.5 mm\""),
            key("roller_length", POSITIVE_LENGTH, "effective length of the rollers", "required with a model", "",
                "\"7.5 mm\""),
            key("kind", Words(|| words(&RollerKind::ALL)), "kind of the rollers",
                "`\"cylindrical\"`, with a contact angle `\"tapered\"`",
                "`\"tapered\"` and `\"spherical\"` only with `roller`", "\"tapered\""),
            key("laminae", Integer(1, MOST_LAMINAE), "laminae of each roller", "30", "", "30"),
            key("profile", Either(&[Words(|| words(&PROFILES)), Table(&PROFILE), List(&PROFILE_DROP)]),
                "profile of the rollers: coefficient `c` of `c ln(1/(1 - (2x/L)^2))`, or the drop of each lamina",
                "`\"iso\"`: `c` is 0.00035 (other than cylindrical: 0.00045) of the diameter", "",
                "{ coefficient = \"2.6 um\" }"),
        ]]),
        ("Bearing for vibration alone", &[&[
            key("orders", Table(&ORDERS), "orders as on a data sheet, in place of diameters and angle", "none",
                "only without `model`", "{ outer = 3.585, inner = 5.415, element = 2.357, cage = 0.398 }"),
        ]]),
        ("Keys of `lumped`", &[&[
            key("stiffness", CONTACT_STIFFNESS, "`K` of `F = K Delta^n`", "from the geometry", "",
                "\"1.2e10 N/m^1.5\""),
            key("exponent", EXPONENT, "`n` of `F = K Delta^n`", "1.5",
                "1.5 where the stiffness comes from the geometry", "1.5"),
            key("radial_play", LENGTH, "half the diametral clearance", "half the `diametral_clearance`",
                "negative is preload", "\"5 um\""),
            key("axial", Table(&AXIAL), "axial springs", "none", "", ""),
            key("housing_displacement", List(&Tuple(&[LENGTH; 3])),
                "displacement of the outer ring at points that are fixed in the housing: where the elements are with \
                 the cage at angle 0; between them it is [interpolated](models.md#lumped-bearing)", "0",
                "one list per element", "[[\"1 um\", 0, 0], [0, 0, 0], [0, 0, 0]]"),
            key("outer_ring", Table(&OUTER_RING), "outer ring that [bends](models.md#bending-outer-ring)", "none",
                "not together with `housing_displacement`", ""),
        ]]),
        ("Keys of `linear`", &[&[
            key("stiffness_matrix", Tuple(&[FORCES, FORCES, FORCES, MOMENTS, MOMENTS]),
                "force along X, Y, Z and moment about X, Y per displacement along X, Y, Z and rotation about X, Y",
                "one of the three", "",
                "[[1e8, 0, 0, 0, 0], [0, 1e8, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 1e4, 0], [0, 0, 0, 0, 1e4]]"),
            key("two_spring", Table(&TWO_SPRING), "stiffness by the two-spring formula", "one of the three",
                "8 to 16 elements, with geometry", "{ static_load = \"500 N\" }"),
            key("linearise", Words(|| words(&linearised_models())),
                "model whose stiffness at the static equilibrium is taken, as its mean over a pitch of the elements", "one of the three", "", "\"angular\""),
        ]]),
        ("Waviness and damage", &[&[
            key("defect", List(&Table(&DEFECT)), "damage of races and balls", "none", "", ""),
            key("waviness", List(&Table(&WAVE)), "waves of races and balls", "none", "", ""),
        ]]),
        (QUASI_STATIC, &[&[
            key("effects", List(&Words(|| words(&EFFECTS))), "inertia of the balls and oil film", "none", "each once",
                "[\"centrifugal\", \"gyroscopic\"]"),
            key("race_control", Words(|| words(&RACE_CONTROLS)), "race on which the balls roll without spin",
                "`\"outer\"`", "", "\"outer\""),
            key("friction_sharing", Words(|| words(&FRICTION_SHARINGS)), "races that carry the gyroscopic moment",
                "`\"outer\"`", "", "\"proportional\""),
            key("lubricant", Table(&LUBRICANT), "oil of the film", "required for `film`", "", ""),
        ]]),
        ("Preload", &[&[
            key("preload", Table(&PRELOAD), "preload along the thrust direction", "none",
                "exactly one of `force` and `displacement`", "{ force = \"500 N\" }"),
        ]]),
        ("Misalignment", &[&[
            key("outer_ring_tilt", Tuple(&[ANGLE; 2]), "tilt of the outer ring in its seat about X and Y", "0",
                "not with `lumped`, `linear`, `dynamic` and `multibody`", "[\"0.5 mrad\", 0]"),
        ]]),
        (QUASI_STATIC, &[&[
            key("table", Table(&TABLE), "ranges of the table of `tabulated`", "defaults of its keys", "", ""),
        ]]),
        ("Support", &[&[
            key("support", Table(&SUPPORT), "elastic support of the outer ring", "none", "only with `rotor`", ""),
        ]]),
        (POSITION, &[&[
            key("element_azimuths", List(&ANGLE), "azimuth of each element at shaft angle 0", "evenly spaced",
                "one angle per element", "[\"0 deg\", \"125 deg\", \"240 deg\"]"),
            key("cage_runout", Table(&CAGE_RUNOUT), "eccentric cage", "none", "", ""),
        ]]),
        (POSITION, &[&[
            key("coordinates", COORDINATES,
                "coordinates of the inner ring's `u, v, w, thu, thv`; negative: opposite sign; 0: none",
                "required with `system`", "only with `system`", "[5, 6, 0, -8, 7]"),
            key("housing_coordinates", COORDINATES, "the same of the outer ring", "none", "only with `system`",
                "[1, 2, 0, 0, 0]"),
        ]]),
        ("Fits and temperatures", &[&[
            key("fit", Table(&FIT), "interferences of the rings", "none", "", ""),
            key("temperatures", Table(&TEMPERATURES), "temperatures in operation", "none", "", ""),
            key("inner_raceway_diameter", POSITIVE_LENGTH, "diameter of the inner raceway",
                "pitch diameter less ball diameter", "only with `fit` or `temperatures`; required without a geometry",
                "\"31.1 mm\""),
            key("outer_raceway_diameter", POSITIVE_LENGTH, "diameter of the outer raceway",
                "pitch diameter plus ball diameter", "only with `fit` or `temperatures`; required without a geometry",
                "\"46.9 mm\""),
        ]]),
        ("Life, friction and heat", &[&[
            key("dynamic_rating", RATING, "basic dynamic load rating `C` of the maker",
                "[from the geometry](models.md#ratings-and-life-of-an-equilibrium)", "", "\"14.8 kN\""),
            key("static_rating", RATING, "basic static load rating `C_0` of the maker", "from the geometry", "",
                "\"7.8 kN\""),
            key("lubrication", Table(&LUBRICATION),
                "oil or grease, from which [friction](models.md#friction) and modified life follow", "none",
                "not with `linear`", ""),
            key("cooling", Table(&COOLING),
                "where the heat goes; `equilibrium --thermal` finds the [temperatures](models.md#temperatures-of-a-bearing)",
                "none", "only with `lubrication` and `temperatures`", ""),
        ]]),
        ("Keys of one model", &OWN_KEYS),
    ],
    choices: &[
        Any(&[&["model", "elements"], &["bearing"], &["elements", "pitch_diameter", "contact_angle"], &["orders"]]),
        AtMostOne(&["contact_angle", "diametral_clearance"]),
        AtMostOne(&["stiffness_matrix", "two_spring", "linearise"]),
        AtMostOne(&["housing_displacement", "outer_ring"]),
    ],
};

static ORDERS: Keys = Keys {
    name: "orders",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("outer", Number(POSITIVE), "passes of an element over a point of the outer ring (BPFO)", REQUIRED,
            "below `inner`", "3.585"),
        key("inner", Number(POSITIVE), "passes of an element over a point of the inner ring (BPFI)", REQUIRED,
            "`outer` and `inner` together are the number of elements", "5.415"),
        key("element", Number(POSITIVE), "spin of an element about its own axis (BSF)", REQUIRED,
            "not the double, with which damage of an element strikes both races", "2.357"),
        key("cage", Number(BELOW_ONE), "revolutions of the cage (FTF)", REQUIRED, "`outer` over the number of elements",
            "0.398"),
    ]])],
    choices: &[],
};

static AXIAL: Keys = Keys {
    name: "axial",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("stiffness", CONTACT_STIFFNESS, "stiffness of the springs", REQUIRED, "", "\"1e9 N/m^1.5\""),
        key("exponent", EXPONENT, "exponent of their law", "1.5", "", "1.5"),
        key("play", LENGTH, "axial play", REQUIRED, "negative is preload", "\"0 um\""),
        key("radius", Quantity(Dimension::Length, NOT_NEGATIVE), "radius on which they act", REQUIRED, "", "\"20 mm\""),
    ]])],
    choices: &[],
};

/// Profile drop of a lamina.
const PROFILE_DROP: Kind = Quantity(Dimension::Length, NOT_NEGATIVE);

static PROFILE: Keys = Keys {
    name: "profile",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("coefficient", PROFILE_DROP, "coefficient `c` of the logarithmic profile", REQUIRED, "", "\"2.6 um\""),
    ]])],
    choices: &[],
};

static OUTER_RING: Keys = Keys {
    name: "outer-ring",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("radius", POSITIVE_LENGTH, "radius of its neutral line", REQUIRED, "", "\"50 mm\""),
        key("width", POSITIVE_LENGTH, "width", REQUIRED, "", "\"18 mm\""),
        key("thickness", POSITIVE_LENGTH, "radial thickness", REQUIRED, "at most 0.4 of the radius", "\"5 mm\""),
        key("youngs_modulus", PRESSURE, "Young's modulus", "206 GPa", "", "\"206 GPa\""),
        key("orders", Integer(2, 12), "highest order of its shape", "6", "", "6"),
    ]])],
    choices: &[],
};

static TWO_SPRING: Keys = Keys {
    name: "two-spring",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("static_load", Quantity(Dimension::Force, POSITIVE), "radial load", REQUIRED, "", "\"500 N\""),
    ]])],
    choices: &[],
};

static LUBRICANT: Keys = Keys {
    name: "lubricant",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("viscosity", Quantity(Dimension::Viscosity, POSITIVE), "dynamic viscosity at the inlet", REQUIRED, "",
            "\"0.04 Pa s\""),
        key("pressure_viscosity", Quantity(Dimension::PressureViscosity, POSITIVE), "pressure-viscosity coefficient",
            REQUIRED, "", "\"2.2e-8 1/Pa\""),
        key("roughness", POSITIVE_LENGTH, "rms roughness of ball and race together", "none", "", "\"0.1 um\""),
        key("inlet_heating", Table(&INLET_HEATING), "[heating of the inlet](models.md#oil-film), which thins the film",
            "none: isothermal", "keys that are absent are those of mineral oils", "{}"),
    ]])],
    choices: &[],
};

static INLET_HEATING: Keys = Keys {
    name: "inlet-heating",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("temperature_coefficient", NumberIn("1/K", (Included(1e-3), Included(0.2))),
            "relative decrease of the viscosity", "0.04 1/K", "", "\"0.04 1/K\""),
        key("conductivity", NumberIn("W/(m K)", (Included(0.01), Included(10.0))), "thermal conductivity",
            "0.14 W/(m K)", "", "\"0.14 W/(m K)\""),
    ]])],
    choices: &[],
};

static LUBRICATION: Keys = Keys {
    name: "lubrication",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("method", Words(|| words(&LubricationMethod::ALL)), "how the lubricant comes to the bearing", REQUIRED,
            "a bath up to the middle of the lowest element; `\"oil-jet\"` also a bath of a vertical shaft",
            "\"oil-bath\""),
        key("viscosity_40", KINEMATIC_VISCOSITY, "kinematic viscosity of the (base) oil at 40 degC", REQUIRED, "",
            "\"32 mm^2/s\""),
        key("viscosity_100", KINEMATIC_VISCOSITY, "the same at 100 degC", REQUIRED, "below `viscosity_40`",
            "\"5.4 mm^2/s\""),
        key("temperature", Temperature, "temperature of the oil in the bearing", "mean of `temperatures`, else required",
            "no bare number", "\"50 degC\""),
        key("contamination", Number((Excluded(0.0), Included(1.0))),
            "contamination factor `e_C` of ISO 281, for the modified life: 1 extreme cleanliness, 0.8 to 0.6 high, \
             0.6 to 0.5 normal, 0.3 to 0.1 typical contamination (small bearings)", "none: no modified life", "", "0.5"),
        key("f0", Number((Excluded(0.0), Included(50.0))), "factor of the viscous friction",
            "by [kind and method](models.md#friction)", "", "2"),
        key("f1", Number((Excluded(0.0), Included(0.1))), "factor of the friction by the load",
            "by [kind and load](models.md#friction)", "", "0.0003"),
        key("sliding_friction", Number((Included(0.0), Included(0.3))), "coefficient of friction in sliding contacts",
            "0.05, a full film of mineral oil", "", "0.05"),
    ]])],
    choices: &[],
};

static COOLING: Keys = Keys {
    name: "cooling",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("ambient", Temperature, "temperature of the surroundings", REQUIRED, "no bare number", "\"20 degC\""),
        key("shaft", CONDUCTANCE, "conductance from the inner ring through the shaft to the surroundings",
            "seat in the catalogue's size by ISO 15312, else required", "", "\"1.2 W/K\""),
        key("housing", CONDUCTANCE, "conductance from the housing to the surroundings",
            "seat in the catalogue's size by ISO 15312, else required", "", "\"2.5 W/K\""),
        key("seat", NumberIn("W/K", (Excluded(0.0), Included(1e4))), "conductance from the outer ring to the housing",
            "none: both have one temperature", "", "\"20 W/K\""),
        key("elements", CONDUCTANCE, "conductance from ring to ring through the elements", "0", "", "\"0.5 W/K\""),
        key("oil_flow", NumberIn("l/min", (Excluded(0.0), Included(1000.0))), "flow of oil that cools the bearing",
            "none", "with `oil_inlet`", "\"0.5 l/min\""),
        key("oil_inlet", Temperature, "temperature at which this oil enters", "none", "with `oil_flow`", "\"40 degC\""),
    ]])],
    choices: &[],
};

static PRELOAD: Keys = Keys {
    name: "preload",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("force", Quantity(Dimension::Force, POSITIVE), "axial force", "this or `displacement`", "",
            "{ force = \"500 N\" }"),
        key("displacement", POSITIVE_LENGTH, "axial displacement", "this or `force`", "",
            "{ displacement = \"10 um\" }"),
        key("set", Words(|| words(&PreloadState::ALL)), "state in which the preload has the given size",
            "`\"unmounted\"`", "without `fit` and `temperatures` all are the same",
            "{ force = \"500 N\", set = \"operating\" }"),
    ]])],
    choices: &[One(&[&["force"], &["displacement"]])],
};

static TABLE: Keys = Keys {
    name: "table",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("approach", Tuple(&[LENGTH; 2]), "least and greatest approach of the races",
            "up to 4.2 GPa, half as much gap", "first at most second", "[\"-20 um\", \"60 um\"]"),
        key("angle", Tuple(&[ANGLE; 2]), "least and greatest angle between the groove centres",
            "23 deg about the free angle", "first at most second", "[\"10 deg\", \"40 deg\"]"),
        key("speed", Tuple(&[SPEED; 2]), "least and greatest speed",
            "0.8 to 1.17 of a constant speed, all of a variable one", "first at most second",
            "[\"0 rpm\", \"12000 rpm\"]"),
        key("intervals", Tuple(&[Integer(4, 1000), Integer(4, 1000), Integer(1, 1000)]),
            "intervals along approach, angle and speed", "as many as fit into [64 kB](models.md#tabulated-bearing)",
            "along the speed 1 to 1000", "[64, 32, 8]"),
    ]])],
    choices: &[],
};

static SUPPORT: Keys = Keys {
    name: "support",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("mass", Quantity(Dimension::Mass, POSITIVE), "mass of outer ring and support", REQUIRED, "", "\"2 kg\""),
        key("stiffness_x", POSITIVE_STIFFNESS, "stiffness along X", REQUIRED, "", "\"1e8 N/m\""),
        key("stiffness_y", POSITIVE_STIFFNESS, "stiffness along Y", REQUIRED, "", "\"1e8 N/m\""),
        key("stiffness_xy", STIFFNESS, "stiffness between X and Y", "0",
            "magnitude below the geometric mean of the two", "0"),
        key("damping", DAMPING, "damping along X and Y", "0", "", "\"200 N s/m\""),
    ]])],
    choices: &[],
};

static CAGE_RUNOUT: Keys = Keys {
    name: "cage-runout",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("offset", Quantity(Dimension::Length, NOT_NEGATIVE), "distance of its centre from the axis", REQUIRED,
            "below a tenth of the radius", "\"20 um\""),
        key("angle", ANGLE, "direction of its centre at shaft angle 0", "0", "", "\"30 deg\""),
        key("radius", POSITIVE_LENGTH, "radius of the circle of element centres", "half the pitch diameter", "",
            "\"19.5 mm\""),
    ]])],
    choices: &[],
};

static DEFECT: Keys = Keys {
    name: "defect",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("surface", Words(|| words(&SURFACES)), "damaged surface", REQUIRED, "`\"element\"` is `\"ball\"`",
            "\"outer\""),
        key("azimuth", ANGLE, "middle of the damage, from the zero of the surface", REQUIRED, "", "\"-90 deg\""),
        key("half_width", Quantity(Dimension::Angle, POSITIVE), "half of its width along the surface", REQUIRED,
            "at most 180 deg", "\"2.9 deg\""),
        key("depth", POSITIVE_LENGTH, "greatest depth", REQUIRED, "", "\"3 um\""),
        key("shape", Words(|| words(&DEFECT_SHAPES)), "depth along the surface", REQUIRED, "", "\"half-sine\""),
        key("element", Integer(1, *ELEMENTS.end()), "number of the damaged ball", "1",
            "up to `elements`; only on a ball", "3"),
    ]])],
    choices: &[],
};

static WAVE: Keys = Keys {
    name: "wave",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("surface", Words(|| words(&SURFACES)), "wavy surface", REQUIRED, "`\"element\"` is `\"ball\"`",
            "\"inner\""),
        key("direction", Words(|| words(&WAVE_DIRECTIONS)), "direction of the waves", "`\"radial\"`",
            "`\"axial\"` of races only", "\"axial\""),
        key("order", Integer(1, 10_000), "waves around the surface", REQUIRED, "", "13"),
        key("amplitude", POSITIVE_LENGTH, "amplitude", REQUIRED, "", "\"0.1 um\""),
        key("phase", ANGLE, "angle of the wave", "0", "", "\"90 deg\""),
    ]])],
    choices: &[],
};

static FIT: Keys = Keys {
    name: "fit",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("shaft_interference", LENGTH, "diametral interference of inner ring and shaft",
            "0; this or `housing_interference`", "up to 1 % of the diameter; negative is a loose fit", "\"10 um\""),
        key("housing_interference", LENGTH, "diametral interference of outer ring and housing",
            "0; this or `shaft_interference`", "up to 1 % of the diameter; negative is a loose fit", "\"-5 um\""),
        key("bore", LENGTH, "bore of the inner ring", "catalogue, else required", "below the inner raceway",
            "\"25 mm\""),
        key("outside_diameter", LENGTH, "outside diameter of the outer ring", "catalogue, else required",
            "above the outer raceway", "\"52 mm\""),
        key("shaft_bore", LENGTH, "bore of the shaft", "0, a solid shaft", "0 to below `bore`", "\"8 mm\""),
        key("housing_diameter", LENGTH, "outside diameter of the housing", "unlimited", "above `outside_diameter`",
            "\"80 mm\""),
        key("shaft_material", Table(&MATERIAL), "material of the shaft", "that of the rings",
            "keys that are absent are those of the rings", ""),
        key("housing_material", Table(&MATERIAL), "material of the housing", "that of the rings",
            "keys that are absent are those of the rings", ""),
    ]])],
    choices: &[Any(&[&["shaft_interference"], &["housing_interference"]])],
};

static MATERIAL: Keys = Keys {
    name: "material",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("youngs_modulus", PRESSURE, "Young's modulus", "that of the rings", "", "\"70 GPa\""),
        key("poissons_ratio", POISSONS_RATIO, "Poisson's ratio", "that of the rings", "", "0.33"),
        key("expansion", EXPANSION, "linear thermal expansion", "that of the rings", "", "\"23e-6 1/K\""),
    ]])],
    choices: &[],
};

static TEMPERATURES: Keys = Keys {
    name: "temperatures",
    #[rustfmt::skip] // a table
    sections: &[("", &[&[
        key("inner", Temperature, "inner ring and shaft", REQUIRED, "no bare number", "\"60 degC\""),
        key("outer", Temperature, "outer ring and housing", REQUIRED, "no bare number", "\"45 degC\""),
        key("assembled", Temperature, "temperature at which clearance and interferences hold", "`\"20 degC\"`",
            "no bare number", "\"20 degC\""),
        key("expansion", EXPANSION, "linear thermal expansion of rings and elements", "12e-6 1/K", "", "\"12e-6 1/K\""),
    ]])],
    choices: &[],
};
