//! Rollers of one bearing: kind, geometry, laminae and profile.

use ballrace::bearing::roller::{CYLINDRICAL_PROFILE, TAPERED_PROFILE};

/// `kind`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RollerKind {
    /// `"cylindrical"`
    Cylindrical,
    /// `"needle"`
    Needle,
    /// `"tapered"`
    Tapered,
    /// `"spherical"`: two rows in an outer ring with a spherical raceway.
    Spherical,
}

impl RollerKind {
    /// All kinds by their names in a scene.
    pub const ALL: [(&'static str, Self); 4] = [
        ("cylindrical", Self::Cylindrical),
        ("needle", Self::Needle),
        ("tapered", Self::Tapered),
        ("spherical", Self::Spherical),
    ];

    /// Returns the name of the kind in a scene.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, kind)| *kind == self).map_or("", |(name, _)| name)
    }

    /// Returns true for rollers whose line of contact is radial.
    #[must_use]
    pub const fn is_radial(self) -> bool {
        matches!(self, Self::Cylindrical | Self::Needle)
    }

    /// Returns the number of rows.
    #[must_use]
    pub const fn rows(self) -> usize {
        match self {
            Self::Spherical => 2,
            Self::Cylindrical | Self::Needle | Self::Tapered => 1,
        }
    }

    /// Returns the coefficient of the logarithmic profile over the diameter of the roller (ISO/TS 16281).
    #[must_use]
    pub const fn profile_ratio(self) -> f64 {
        match self {
            Self::Cylindrical => CYLINDRICAL_PROFILE,
            Self::Needle | Self::Tapered | Self::Spherical => TAPERED_PROFILE,
        }
    }
}

/// `profile`
#[derive(Debug, Clone, PartialEq)]
pub enum RollerProfile {
    /// `"straight"`
    Straight,
    /// `{ coefficient = ... }`, m, 0 or more, or `"iso"`.
    Logarithmic(f64),
    /// Drop of each lamina, m.
    Drops(Vec<f64>),
}

/// Rollers of one bearing.
#[derive(Debug, Clone, PartialEq)]
pub struct Rollers {
    /// Kind.
    pub kind: RollerKind,
    /// `roller_diameter`, m, above 0; of tapered rollers the mean.
    pub diameter: f64,
    /// `roller_length`, effective length, m, above 0.
    pub length: f64,
    /// `pitch_diameter`, m, above the diameter of the rollers.
    pub pitch_diameter: f64,
    /// `contact_angle`, rad, 0 for cylindrical and needle rollers, else above 0 and at most pi/3.
    pub contact_angle: f64,
    /// `laminae` of each roller, 1 or more.
    pub laminae: usize,
    /// `profile`
    pub profile: RollerProfile,
    /// `density`, kg/m^3, above 0.
    pub density: f64,
}

impl Rollers {
    /// Returns `D cos(alpha)/d_m`.
    #[must_use]
    pub fn gamma(&self) -> f64 {
        self.diameter * self.contact_angle.cos() / self.pitch_diameter
    }
}
