//! Entries of the catalogue.

use crate::RollerKind;
use ballrace::bearing::kinematics::{Orders, orders};
use std::sync::LazyLock;

/// Length of a cylindrical roller over the width of the bearing, times its effective share without the rounded edges.
const SHARE_OF_WIDTH: f64 = 0.62 * 0.9;

/// Kind of a bearing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BearingKind {
    /// Deep-groove ball bearing.
    DeepGroove,
    /// Single-row angular-contact ball bearing.
    AngularContact,
    /// Cylindrical-roller bearing.
    CylindricalRoller,
    /// Drawn-cup needle-roller bearing with cage; its bore is the diameter of the shaft, on which the needles roll.
    Needle,
    /// Single-row tapered-roller bearing.
    TaperedRoller,
    /// Double-row spherical-roller bearing.
    SphericalRoller,
}

impl BearingKind {
    const NAMED: [(Self, &'static str); 6] = [
        (Self::DeepGroove, "deep-groove"),
        (Self::AngularContact, "angular-contact"),
        (Self::CylindricalRoller, "cylindrical-roller"),
        (Self::Needle, "needle"),
        (Self::TaperedRoller, "tapered-roller"),
        (Self::SphericalRoller, "spherical-roller"),
    ];

    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMED.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// Returns the kind of its rollers; `None` for balls.
    #[must_use]
    pub const fn rollers(self) -> Option<RollerKind> {
        match self {
            Self::DeepGroove | Self::AngularContact => None,
            Self::CylindricalRoller => Some(RollerKind::Cylindrical),
            Self::Needle => Some(RollerKind::Needle),
            Self::TaperedRoller => Some(RollerKind::Tapered),
            Self::SphericalRoller => Some(RollerKind::Spherical),
        }
    }

    pub(super) fn of_name(name: &str) -> Self {
        Self::NAMED.into_iter().find(|(_, own)| *own == name).map_or(Self::DeepGroove, |(kind, _)| kind)
    }
}

/// Origin of number, diameter and pitch diameter of the elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Provenance {
    /// Printed by a maker, in a paper or in the documentation of a data set.
    Published,
    /// The numbers reproduce the frequencies that a maker publishes.
    Derived,
    /// Number and diameter are printed or solved from printed load ratings; the pitch diameter is the mean of the diameters of
    /// the rings.
    Ratings,
    /// Estimated from the boundary dimensions (`docs/src/scene.md#catalogue`).
    Dimensions,
}

impl Provenance {
    const NAMED: [(Self, &'static str); 4] = [
        (Self::Published, "published"),
        (Self::Derived, "derived"),
        (Self::Ratings, "ratings"),
        (Self::Dimensions, "dimensions"),
    ];

    /// Returns its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMED.iter().find(|(status, _)| *status == self).map_or("", |(_, name)| name)
    }

    fn of_name(name: &str) -> Self {
        Self::NAMED.into_iter().find(|(_, own)| *own == name).map_or(Self::Ratings, |(status, _)| status)
    }
}

/// Entry of the catalogue, with lengths in mm and angles in degrees as makers print them.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Designation without maker and suffixes, such as `6309`.
    pub designation: &'static str,
    /// Kind.
    pub kind: BearingKind,
    /// Bore, mm.
    pub bore: f64,
    /// Outer diameter, mm.
    pub outer_diameter: f64,
    /// Width, mm.
    pub width: f64,
    /// Number of rolling elements of a row.
    pub elements: usize,
    /// Diameter of the elements, mm.
    pub element_diameter: f64,
    /// Pitch diameter, mm.
    pub pitch_diameter: f64,
    /// Nominal contact angle, degrees.
    pub contact_angle: f64,
    /// Origin of the numbers of the elements.
    pub status: Provenance,
    /// Source.
    pub source: &'static str,
    /// Frequencies that a maker publishes, for the check of the entry.
    pub published: Option<PublishedFactors>,
    /// Effective length of the rollers, mm; `None` for balls.
    pub roller_length: Option<f64>,
}

/// Frequencies over the shaft frequency with a stationary outer ring, as a maker publishes them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PublishedFactors {
    /// Cage.
    pub cage: Option<f64>,
    /// Outer-race ball pass.
    pub outer_race: Option<f64>,
    /// Inner-race ball pass.
    pub inner_race: Option<f64>,
    /// Ball spin, once per revolution of the ball about its axis.
    pub ball_spin: Option<f64>,
    /// Maker and publication.
    pub source: &'static str,
}

impl Entry {
    /// Returns the orders of the bearing with a stationary outer ring, at its nominal contact angle.
    #[must_use]
    pub fn orders(&self) -> Orders {
        let ratio = self.element_diameter / self.pitch_diameter;
        orders(self.elements, ratio * self.contact_angle.to_radians().cos(), ratio)
    }
}

static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let text: &'static str = include_str!("bearings.csv");
    text.lines().filter(|line| !line.starts_with('#')).skip(1).map(entry).collect()
});

/// Returns all bearings in the order of the catalogue.
#[must_use]
pub fn all() -> &'static [Entry] {
    &ENTRIES
}

/// Reads a cell of the built-in tables, whose numbers a test checks.
pub(super) fn number(cell: Option<&str>) -> f64 {
    cell.and_then(|cell| cell.trim().parse().ok()).unwrap_or(f64::NAN)
}

fn entry(line: &'static str) -> Entry {
    let mut cells = line.split(',');
    let mut text = || cells.next().unwrap_or_default();
    let (designation, kind) = (text(), BearingKind::of_name(text()));
    let [bore, outer_diameter, width, elements, element_diameter, pitch_diameter, contact_angle] =
        std::array::from_fn(|_| number(Some(text())));
    let (status, source) = (Provenance::of_name(text()), text());
    let factors: [Option<f64>; 4] = std::array::from_fn(|_| text().trim().parse().ok());
    let (maker, length) = (text(), text().trim().parse().ok());
    let [cage, outer_race, inner_race, ball_spin] = factors;
    let published =
        (!maker.is_empty()).then_some(PublishedFactors { cage, outer_race, inner_race, ball_spin, source: maker });
    Entry {
        designation,
        kind,
        bore,
        outer_diameter,
        width,
        elements: elements as usize,
        element_diameter,
        pitch_diameter,
        contact_angle,
        status,
        source,
        published,
        roller_length: length.or_else(|| kind.rollers().map(|_| SHARE_OF_WIDTH * width)),
    }
}
