//! Keys of the model `multibody`.

use crate::key::{Key, Kind, NOT_NEGATIVE, POSITIVE, key};
use crate::units::Dimension;
use std::ops::Bound::{Excluded, Included};

const CLEARANCE: Kind = Kind::Quantity(Dimension::Length, NOT_NEGATIVE);
const ONLY: &str = "only `multibody`";

#[rustfmt::skip] // table
pub(crate) static KEYS: [Key; 13] = [
    key("traction_peak", Kind::Number((Included(0.0), Included(0.5))),
        "largest traction coefficient of the oil on the races", "0.06", ONLY, "0.05"),
    key("traction_peak_slip", Kind::Quantity(Dimension::Velocity, POSITIVE),
        "slip speed at which it is reached", "0.2 m/s", ONLY, "\"0.3 m/s\""),
    key("traction_limit", Kind::Number((Included(1e-4), Included(0.5))),
        "traction coefficient far beyond that slip, at most `traction_peak`", "three quarters of `traction_peak`", ONLY, "0.04"),
    key("contact_damping", Kind::NumberIn("s/m", (Included(0.0), Included(10.0))),
        "`alpha` of Hunt and Crossley: loss of the coefficient of restitution per m/s; 0.08 to 0.32 s/m for steel", "0.2 s/m",
        ONLY, "0.1"),
    key("mixture_density", Kind::Quantity(Dimension::Density, NOT_NEGATIVE),
        "mass of oil in a unit of volume of the space between the rings, which drags the balls", "0", ONLY, "\"20 kg/m^3\""),
    key("cage_mass", Kind::Quantity(Dimension::Mass, POSITIVE),
        "mass of the cage", "that of a phenolic ring, 0.3 times as thick and 1.2 times as wide as a ball", ONLY, "\"40 g\""),
    key("pocket_clearance", CLEARANCE, "diametral clearance of a ball in its pocket", "3 % of the ball's diameter", ONLY,
        "\"0.3 mm\""),
    key("inner_land_clearance", CLEARANCE, "diametral clearance of the cage on the inner ring, where that guides it", "none", ONLY,
        "\"0.4 mm\""),
    key("outer_land_clearance", CLEARANCE, "the same on the outer ring; without both the balls guide the cage", "none", ONLY,
        "\"0.4 mm\""),
    key("cage_stiffness", Kind::Quantity(Dimension::Stiffness, POSITIVE),
        "stiffness of a contact of the cage with a ball or a land", "10 N/um", ONLY, "\"5 N/um\""),
    key("cage_damping", Kind::NumberIn("s/m", (Included(0.0), Included(100.0))),
        "damping of such a contact over its force", "5 s/m", ONLY, "2"),
    key("cage_friction", Kind::Number((Included(0.0), Included(0.5))),
        "friction coefficient of the cage", "0.05", ONLY, "0.1"),
    key("step_error", Kind::Quantity(Dimension::Length, (Excluded(0.0), Included(1e-6))),
        "error of a ball's position in one integration step", "0.1 nm", ONLY, "\"0.01 nm\""),
];
