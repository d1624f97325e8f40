//! Geometry and material of a ball bearing, with validation.

use crate::contact::hertz::{Material, PointContact, Race, effective_modulus, in_series};
use core::fmt;

/// Geometry and material of a ball bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BallBearingGeometry {
    /// D, ball diameter, m.
    pub ball_diameter: f64,
    /// d_m, pitch diameter, m.
    pub pitch_diameter: f64,
    /// f_i, inner groove radius divided by D.
    pub inner_conformity: f64,
    /// f_o, outer groove radius divided by D.
    pub outer_conformity: f64,
    /// alpha_0, free contact angle, rad.
    pub contact_angle: f64,
    /// Material of the balls.
    pub ball: Material,
    /// Material of both races.
    pub race: Material,
}

/// Error returned when a parameter of a geometry, a bearing or a rotor is outside its range.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct InvalidParameter {
    /// Name of the parameter.
    pub name: &'static str,
    /// Value found.
    pub found: f64,
    /// Allowed range, in words.
    pub expected: &'static str,
}

impl fmt::Display for InvalidParameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: value out of range: {}, expected {}", self.name, self.found, self.expected)
    }
}

impl core::error::Error for InvalidParameter {}

/// Returns an error unless `condition` holds and `found` is finite.
pub(crate) fn check(
    condition: bool,
    name: &'static str,
    found: f64,
    expected: &'static str,
) -> Result<(), InvalidParameter> {
    if condition && found.is_finite() { Ok(()) } else { Err(InvalidParameter { name, found, expected }) }
}

/// Bearing steel: 206 GPa, 0.3.
pub const BEARING_STEEL: Material = Material { youngs_modulus: 206e9, poissons_ratio: 0.3 };

impl BallBearingGeometry {
    /// Validates all parameters.
    ///
    /// # Errors
    /// The first parameter outside its range.
    pub fn checked(self) -> Result<Self, InvalidParameter> {
        let Self { ball_diameter, pitch_diameter, inner_conformity, outer_conformity, contact_angle, .. } = self;
        check(ball_diameter > 0.0, "ball_diameter", ball_diameter, "above 0 m")?;
        check(pitch_diameter > ball_diameter, "pitch_diameter", pitch_diameter, "above the ball diameter")?;
        for (name, f) in [("inner_conformity", inner_conformity), ("outer_conformity", outer_conformity)] {
            check(f > 0.5 && f <= 1.0, name, f, "above 0.5, at most 1")?;
        }
        let largest = core::f64::consts::FRAC_PI_3 * (1.0 + 1e-12);
        check((0.0..=largest).contains(&contact_angle), "contact_angle", contact_angle, "0 to pi/3 rad")?;
        for material in [self.ball, self.race] {
            check(material.youngs_modulus > 0.0, "youngs_modulus", material.youngs_modulus, "above 0 Pa")?;
            let nu = material.poissons_ratio;
            check((0.0..0.5).contains(&nu), "poissons_ratio", nu, "0 or more, below 0.5")?;
        }
        Ok(self)
    }

    /// Returns the geometry with the free contact angle of a diametral clearance `s` (m): `cos(alpha_0) = 1 - s/(2A)`.
    ///
    /// # Errors
    /// A clearance below 0 or above A (60 degrees).
    pub fn with_clearance(mut self, diametral_clearance: f64) -> Result<Self, InvalidParameter> {
        let a = self.groove_distance();
        let s = diametral_clearance;
        check((0.0..=a).contains(&s), "diametral_clearance", s, "0 to A = (f_i + f_o - 1) D")?;
        self.contact_angle = libm::acos(1.0 - s / (2.0 * a));
        Ok(self)
    }

    /// Returns A = r_i + r_o - D, the distance of the groove centres, m.
    #[must_use]
    pub fn groove_distance(&self) -> f64 {
        (self.inner_conformity + self.outer_conformity - 1.0) * self.ball_diameter
    }

    /// Returns R_i, the radius of the circle of inner groove centres, m: the lever arm of deflection and moment.
    #[must_use]
    pub fn inner_groove_radius(&self) -> f64 {
        let offset = (self.inner_conformity - 0.5) * self.ball_diameter;
        0.5 * self.pitch_diameter + offset * libm::cos(self.contact_angle)
    }

    /// Returns R_o, the radius of the circle of outer groove centres, m.
    #[must_use]
    pub fn outer_groove_radius(&self) -> f64 {
        let offset = (self.outer_conformity - 0.5) * self.ball_diameter;
        0.5 * self.pitch_diameter - offset * libm::cos(self.contact_angle)
    }

    /// Returns gamma = D cos(alpha_0) / d_m.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.ball_diameter * libm::cos(self.contact_angle) / self.pitch_diameter
    }

    /// Returns the Hertz contact on `race` at the free contact angle.
    #[must_use]
    pub fn contact(&self, race: Race) -> PointContact {
        let conformity = match race {
            Race::Inner => self.inner_conformity,
            Race::Outer => self.outer_conformity,
        };
        let modulus = effective_modulus(self.ball, self.race);
        PointContact::ball_on_race(race, self.ball_diameter, conformity, self.gamma(), modulus)
    }

    /// Returns K_n, the stiffness of both contacts in series, N/m^1.5.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        in_series(self.contact(Race::Inner).stiffness, self.contact(Race::Outer).stiffness)
    }
}
