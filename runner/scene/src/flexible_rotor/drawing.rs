//! Drawing of a flexible rotor: sections of the shaft and disks, as a scene gives them.

/// A flexible shaft with its disks: `sections`, `disks` and material of `[rotor]`.
#[derive(Debug, Clone, PartialEq)]
pub struct FlexibleRotor {
    /// `sections`, in order and without gaps.
    pub sections: Vec<Section>,
    /// `disks`.
    pub disks: Vec<Disk>,
    /// `youngs_modulus` of the shaft, Pa, above 0.
    pub youngs_modulus: f64,
    /// `poissons_ratio`, 0 or more and below 0.5.
    pub poissons_ratio: f64,
    /// `density`, kg/m^3, above 0.
    pub density: f64,
    /// `proportional_damping`: factors of the mass (1/s) and of the stiffness of the rotor alone (s); each 0 or more.
    pub proportional_damping: [f64; 2],
    /// `modal_damping`: damping ratio of the elastic coordinates, 0 or more and below 1.
    pub modal_damping: f64,
    /// `load_station`: station at which `load` acts, m from the centre of mass.
    pub load_station: f64,
    /// `coordinates` of the reduced rotor; `None` if the scene does not give them.
    pub coordinates: Option<usize>,
}

/// One of `sections`: a cylinder or a cone with a cylindrical bore.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Station of the first end, m from the centre of mass.
    pub from: f64,
    /// Station of the second end, m from the centre of mass, above `from`.
    pub to: f64,
    /// Outer diameter at `from`, m, above `inner_diameter`.
    pub outer_diameter: f64,
    /// Outer diameter at `to`, m, above `inner_diameter`.
    pub outer_diameter_to: f64,
    /// Diameter of the bore, m, 0 or more.
    pub inner_diameter: f64,
}

/// One of `disks`: a rigid body on the shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disk {
    /// Station, m from the centre of mass.
    pub station: f64,
    /// Mass, kg, above 0.
    pub mass: f64,
    /// Diametral inertia about its centre, kg m^2, above 0.
    pub diametral_inertia: f64,
    /// Polar inertia, kg m^2, above 0 and at most twice the diametral one.
    pub polar_inertia: f64,
    /// Outer diameter and width as drawn, m; `None` if only the inertia is given.
    pub size: Option<[f64; 2]>,
}

impl Section {
    /// Returns the outer diameter at a station within the section, m.
    #[must_use]
    pub(crate) fn outer_diameter_at(&self, station: f64) -> f64 {
        let share = ((station - self.from) / (self.to - self.from)).clamp(0.0, 1.0);
        self.outer_diameter + share * (self.outer_diameter_to - self.outer_diameter)
    }
}

impl FlexibleRotor {
    /// Returns the stations of the two ends, m.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        let from = self.sections.first().map_or(0.0, |s| s.from);
        [from, self.sections.last().map_or(from, |s| s.to)]
    }

    /// Returns the length of the shaft, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        let [from, to] = self.ends();
        to - from
    }

    /// Returns the drawing with every station moved by `by`, m.
    #[must_use]
    pub fn moved(mut self, by: f64) -> Self {
        for section in &mut self.sections {
            section.from += by;
            section.to += by;
        }
        for disk in &mut self.disks {
            disk.station += by;
        }
        self.load_station += by;
        self
    }
}
