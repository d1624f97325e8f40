//! Data of the figure of a rotor. Stations are those of the scene: from the centre of mass of a rigid rotor, from the origin of a
//! flexible rotor's drawing.

use ballrace_scene::{Direction, Scene};

const MM: f64 = 1e3;

/// Drawing of a rotor with everything on it, in mm.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RotorDrawing {
    /// Sections of the shaft, in order; empty for a rigid rotor, whose shape the scene does not have.
    pub sections: Vec<DrawnSection>,
    /// Disks.
    pub disks: Vec<DrawnDisk>,
    /// Names and stations of the bearings.
    pub bearings: Vec<(String, f64)>,
    /// Probes.
    pub probes: Vec<DrawnProbe>,
    /// Unbalances.
    pub unbalances: Vec<DrawnUnbalance>,
    /// Station of the centre of mass.
    pub centre_of_mass_mm: f64,
}

/// A section of the shaft.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DrawnSection {
    /// Stations of its ends.
    pub ends_mm: [f64; 2],
    /// Outer diameters at its ends.
    pub outer_mm: [f64; 2],
    /// Diameter of the bore, 0 without one.
    pub inner_mm: f64,
}

/// A disk.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DrawnDisk {
    /// Station of its centre.
    pub station_mm: f64,
    /// Outer diameter; without a size in the scene, that of a solid cylinder with the disk's mass and polar inertia.
    pub diameter_mm: f64,
    /// Width; `None` without a size in the scene.
    pub width_mm: Option<f64>,
}

/// A probe.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DrawnProbe {
    /// Its column.
    pub name: String,
    /// Station; it has no meaning for an axial probe.
    pub station_mm: f64,
    /// Direction from +X towards +Y; `None` for an axial probe.
    pub angle_deg: Option<f64>,
}

/// An unbalance.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DrawnUnbalance {
    /// Moment.
    pub moment_g_mm: f64,
    /// Angle from the keyphasor mark in the direction of rotation.
    pub angle_deg: f64,
    /// Station.
    pub station_mm: f64,
}

impl RotorDrawing {
    /// Returns the drawing of a scene's rotor; `None` for a scene without a rotor.
    #[must_use]
    pub fn new(scene: &Scene) -> Option<Self> {
        let rotor = scene.rotor.as_ref()?;
        let station = |z: f64| scene.drawn_station(z) * MM;
        let sections = rotor.flexible.iter().flat_map(|drawn| &drawn.sections);
        let disks = rotor.flexible.iter().flat_map(|drawn| &drawn.disks);
        let probes = scene.recording.iter().flat_map(|recording| &recording.probes);
        Some(Self {
            sections: sections
                .map(|s| DrawnSection {
                    ends_mm: [station(s.from), station(s.to)],
                    outer_mm: [s.outer_diameter * MM, s.outer_diameter_to * MM],
                    inner_mm: s.inner_diameter * MM,
                })
                .collect(),
            disks: disks
                .map(|d| DrawnDisk {
                    station_mm: station(d.station),
                    diameter_mm: d.size.map_or((8.0 * d.polar_inertia / d.mass).sqrt(), |size| size[0]) * MM,
                    width_mm: d.size.map(|size| size[1] * MM),
                })
                .collect(),
            bearings: scene.bearings.iter().map(|b| (b.name.clone(), station(b.station))).collect(),
            probes: probes
                .map(|p| match p.direction {
                    Direction::Radial(angle) => DrawnProbe {
                        name: p.column.clone(),
                        station_mm: station(p.station),
                        angle_deg: Some(angle.to_degrees()),
                    },
                    Direction::Axial => {
                        DrawnProbe { name: p.column.clone(), station_mm: p.station * MM, angle_deg: None }
                    }
                })
                .collect(),
            unbalances: rotor
                .unbalance
                .iter()
                .filter(|u| u.moment > 0.0)
                .map(|u| DrawnUnbalance {
                    moment_g_mm: u.moment * 1e6,
                    angle_deg: u.angle.to_degrees(),
                    station_mm: station(u.station),
                })
                .collect(),
            centre_of_mass_mm: station(0.0),
        })
    }

    /// Returns the stations of the two ends of the shaft; for a rigid rotor, the outermost stations on it.
    #[must_use]
    pub fn ends_mm(&self) -> [f64; 2] {
        if let (Some(first), Some(last)) = (self.sections.first(), self.sections.last()) {
            return [first.ends_mm[0], last.ends_mm[1]];
        }
        let radial = self.probes.iter().filter(|p| p.angle_deg.is_some()).map(|p| p.station_mm);
        let others = self.bearings.iter().map(|b| b.1).chain(self.unbalances.iter().map(|u| u.station_mm));
        radial.chain(others).fold([self.centre_of_mass_mm; 2], |[low, high], z| [low.min(z), high.max(z)])
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
pub(super) mod tests {
    use super::*;
    use ballrace_scene::read::read_str;
    use std::path::Path;

    pub const SCENE: &str = r#"
        [shaft]
        speed = "3000 rpm"
        [rotor]
        sections = [{ from = "100 mm", to = "500 mm", outer_diameter = "30 mm" }]
        disks = [{ station = "200 mm", outer_diameter = "150 mm", width = "20 mm" }]
        unbalance = [{ moment = "50 g mm", angle = "30 deg", station = "200 mm" }]
        [[bearing]]
        name = "DE"
        station = "120 mm"
        facing = "both"
        model = "linear"
        elements = 8
        cage_ratio = 0.4
        stiffness_matrix = [[5e7, 0, 0, 0, 0], [0, 5e7, 0, 0, 0], [0, 0, 1e7, 0, 0], [0, 0, 0, 1e3, 0], [0, 0, 0, 0, 1e3]]
        [recording]
        file = "a.csv"
        rate = "1 kHz"
        probes = [
          { column = "X", unit = "um", station = "150 mm", angle = "45 deg" },
          { column = "Z", unit = "um", axial = true },
        ]
        keyphasor = { column = "k", pulses_per_turn = 1 }
    "#;

    #[test]
    fn a_drawing_has_the_stations_of_the_scene() {
        let drawing = RotorDrawing::new(&read_str(SCENE, Path::new("scene.toml")).unwrap()).unwrap();
        let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        drawing.ends_mm().iter().zip([100.0, 500.0]).for_each(|(a, b)| is(*a, b));
        is(drawing.disks[0].station_mm, 200.0);
        is(drawing.disks[0].width_mm.unwrap(), 20.0);
        is(drawing.bearings[0].1, 120.0);
        is(drawing.probes[0].station_mm, 150.0);
        is(drawing.probes[1].station_mm, 0.0);
        is(drawing.unbalances[0].station_mm, 200.0);
        assert!(drawing.centre_of_mass_mm > 200.0 && drawing.centre_of_mass_mm < 300.0);
    }
}
