//! Keys of the model `multibody`, and their defaults in SI units.

use crate::key::{Key, Kind, NOT_NEGATIVE, POSITIVE, key};
use crate::units::Dimension;
use std::ops::Bound::{Excluded, Included};

/// Largest traction coefficient on the races.
pub const TRACTION_PEAK: f64 = 0.06;
/// Slip speed at which it is reached, m/s.
pub const TRACTION_PEAK_SLIP: f64 = 0.2;
/// Traction coefficient far beyond that slip over the largest one.
pub const TRACTION_LIMIT_SHARE: f64 = 0.75;
/// `alpha` of Hunt and Crossley on the races, s/m.
pub const CONTACT_DAMPING: f64 = 0.2;
/// Mass of oil in a unit of volume, kg/m^3.
pub const MIXTURE_DENSITY: f64 = 0.0;
/// Diametral clearance of a ball in its pocket over its diameter.
pub const POCKET_CLEARANCE_SHARE: f64 = 0.03;
/// Stiffness of a contact of the cage, N/m.
pub const CAGE_STIFFNESS: f64 = 1e7;
/// Damping of a contact of the cage over its force, s/m.
pub const CAGE_DAMPING: f64 = 5.0;
/// Friction coefficient of the cage.
pub const CAGE_FRICTION: f64 = 0.05;
/// Error of a ball's position in one integration step, m.
pub const STEP_ERROR: f64 = 1e-10;

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

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use crate::units::parse;

    #[test]
    fn the_reference_has_the_defaults() {
        let text = |name: &str| KEYS.iter().find(|key| key.name == name).unwrap().default;
        let leading = |name: &str| text(name).split(' ').next().unwrap().parse::<f64>().unwrap();
        assert_eq!(leading("traction_peak"), TRACTION_PEAK);
        assert_eq!(parse(text("traction_peak_slip"), Dimension::Velocity).unwrap(), TRACTION_PEAK_SLIP);
        assert_eq!((text("traction_limit"), TRACTION_LIMIT_SHARE), ("three quarters of `traction_peak`", 3.0 / 4.0));
        assert_eq!(leading("contact_damping"), CONTACT_DAMPING);
        assert_eq!(leading("mixture_density"), MIXTURE_DENSITY);
        assert_eq!(leading("pocket_clearance") / 100.0, POCKET_CLEARANCE_SHARE);
        assert_eq!(parse(text("cage_stiffness"), Dimension::Stiffness).unwrap(), CAGE_STIFFNESS);
        assert_eq!(leading("cage_damping"), CAGE_DAMPING);
        assert_eq!(leading("cage_friction"), CAGE_FRICTION);
        assert!((parse(text("step_error"), Dimension::Length).unwrap() / STEP_ERROR - 1.0).abs() < 1e-15);
    }
}
