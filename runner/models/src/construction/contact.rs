//! Contact of a rolling element with its races: load, approach and pressure.

use super::BuildError;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::contact::hertz::Race;
use ballrace::contact::line::roller_stiffness;
use ballrace_scene::Bearing as BearingScene;
use std::f64::consts::PI;

/// Returns the load of a Hertzian point contact, N: `Q = K delta^1.5`, 0 without contact.
#[must_use]
pub fn point_contact_load(stiffness: f64, approach: f64) -> f64 {
    stiffness * approach.max(0.0).powf(1.5)
}

/// Returns the approach of a Hertzian point contact under `load`, m: `delta = (Q / K)^(2/3)`.
#[must_use]
pub fn point_contact_approach(stiffness: f64, load: f64) -> f64 {
    (load / stiffness).powf(2.0 / 3.0)
}

/// Permissible static contact pressure of ball bearings, Pa (ISO 76); the default upper limit of a table.
pub(crate) const PRESSURE_LIMIT: f64 = 4.2e9;
/// Permissible static contact pressure of roller bearings, Pa (ISO 76).
const ROLLER_PRESSURE_LIMIT: f64 = 4.0e9;
/// Young's modulus (Pa) and Poisson's ratio of the rollers of the catalogue.
const ROLLER_STEEL: [f64; 2] = [206e9, 0.3];

/// Contact of an element with its races, from which pressures follow.
#[derive(Debug, Clone, Copy)]
pub enum ElementContact {
    /// Hertzian point contact of a ball.
    Ball(BallBearingGeometry),
    /// Hertzian line contact of a cylindrical roller.
    Roller {
        /// Effective length, m.
        length: f64,
        /// Radius of roller and inner race together, and of roller and outer race, m.
        radius: [f64; 2],
    },
}

impl ElementContact {
    /// Returns the contact of balls or rollers with a geometry, and of the rollers of the catalogue with the length that their stiffness has by
    /// [`roller_stiffness`]; none where the contact is not known.
    ///
    /// # Errors
    /// A bearing geometry that the kernel rejects.
    pub fn of(of: &BearingScene) -> Result<Option<Self>, BuildError> {
        if let Some(geometry) = super::geometry(of)? {
            return Ok(Some(Self::Ball(geometry)));
        }
        if let Some(rollers) = &of.rollers {
            let (curvature, gamma) = (2.0 / rollers.diameter, rollers.gamma());
            // 1/R = 2/D (1 + gamma/(1 - gamma)) at the inner race, 2/D (1 - gamma/(1 + gamma)) at the outer.
            let radius = [(1.0 - gamma) / curvature, (1.0 + gamma) / curvature];
            return Ok(Some(Self::Roller { length: rollers.length, radius }));
        }
        let entry = of.catalogue.as_ref().map(|catalogue| catalogue.listed.entry);
        let stiffness = of.law.and_then(|law| law.stiffness);
        let (Some(entry), Some(stiffness)) = (entry, stiffness) else { return Ok(None) };
        let length = (stiffness / roller_stiffness(1.0)).powf(9.0 / 8.0);
        let [roller, pitch] = [entry.element_diameter, entry.pitch_diameter].map(|diameter| diameter * 1e-3);
        let radius = [1.0 / (2.0 / roller + 2.0 / (pitch - roller)), 1.0 / (2.0 / roller - 2.0 / (pitch + roller))];
        Ok(Some(Self::Roller { length, radius }))
    }

    /// Returns the permissible static contact pressure of ISO 76, Pa.
    #[must_use]
    pub const fn limit(&self) -> f64 {
        match self {
            Self::Ball(_) => PRESSURE_LIMIT,
            Self::Roller { .. } => ROLLER_PRESSURE_LIMIT,
        }
    }

    /// Returns the peak pressure at a race under the load of an element (N), Pa; 0 without load.
    #[must_use]
    pub fn pressure(&self, race: Race, load: f64) -> f64 {
        if load <= 0.0 {
            return 0.0;
        }
        match self {
            Self::Ball(geometry) => geometry.contact(race).ellipse(load).2,
            Self::Roller { length, radius: [inner, outer] } => {
                let radius = match race {
                    Race::Inner => inner,
                    Race::Outer => outer,
                };
                let [youngs_modulus, poissons_ratio] = ROLLER_STEEL;
                let modulus = youngs_modulus / (2.0 * (1.0 - poissons_ratio * poissons_ratio));
                // A Hertzian line contact: p^2 = Q E / (pi l R).
                (load * modulus / (PI * length * radius)).sqrt()
            }
        }
    }

    /// Returns the load on an element at the permissible pressure, N; the inner race has the higher pressure.
    #[must_use]
    pub fn load_limit(&self) -> f64 {
        let ratio = self.limit() / self.pressure(Race::Inner, 1.0);
        match self {
            // The pressure grows with the third root of the load, in a line contact with the square root.
            Self::Ball(_) => ratio.powi(3),
            Self::Roller { .. } => ratio.powi(2),
        }
    }
}

/// Returns the load on an element at the permissible static contact pressure of ISO 76, N; none where the contact is not known.
///
/// # Errors
/// A bearing geometry that the kernel rejects.
pub fn static_limit(of: &BearingScene) -> Result<Option<f64>, BuildError> {
    Ok(ElementContact::of(of)?.map(|contact| contact.load_limit()))
}
