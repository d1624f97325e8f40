//! `[machine]`: class of a machine, which has limits of the vibration velocity of its housings.

/// Class of a machine by which the vibration velocity of its bearing housings is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MachineClass {
    /// `group` and `support`: a class of ISO 20816-3, industrial machines above 15 kW at 120 to 30 000 r/min.
    Iso20816 {
        /// Size of the machine.
        group: MachineGroup,
        /// Stiffness of its support.
        support: MachineSupport,
    },
    /// `velocity_limits`: the limits of the scene, m/s rms, rising.
    Own([f64; 3]),
}

/// `group` of ISO 20816-3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineGroup {
    /// 1: above 300 kW, or electrical machines with a shaft height of 315 mm and more.
    Large,
    /// 2: 15 to 300 kW, or electrical machines with a shaft height of 160 to 315 mm.
    Medium,
}

/// `support`: rigid where the lowest natural frequency of machine and support in the direction of measurement is above the
/// shaft speed by a quarter or more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MachineSupport {
    /// `"rigid"`
    Rigid,
    /// `"flexible"`
    Flexible,
}

impl MachineClass {
    /// Returns the velocities between the zones A and B, B and C, C and D, m/s rms from 10 to 1000 Hz.
    ///
    /// Source of those of a class: ISO 20816-3:2022, annex A, the values of ISO 10816-3:2009, after secondary sources. They are
    /// indicative.
    #[must_use]
    pub const fn velocity_limits(self) -> [f64; 3] {
        use {MachineGroup::Large, MachineGroup::Medium, MachineSupport::Flexible, MachineSupport::Rigid};
        match self {
            Self::Iso20816 { group: Large, support: Flexible } => [3.5e-3, 7.1e-3, 11.0e-3],
            Self::Iso20816 { group: Large, support: Rigid } | Self::Iso20816 { group: Medium, support: Flexible } => {
                [2.3e-3, 4.5e-3, 7.1e-3]
            }
            Self::Iso20816 { group: Medium, support: Rigid } => [1.4e-3, 2.8e-3, 4.5e-3],
            Self::Own(limits) => limits,
        }
    }

    /// Returns the source of the limits, in words.
    #[must_use]
    pub const fn name(self) -> &'static str {
        use {MachineGroup::Large, MachineGroup::Medium, MachineSupport::Flexible, MachineSupport::Rigid};
        match self {
            Self::Iso20816 { group: Large, support: Rigid } => "ISO 20816-3, group 1, rigid support, indicative",
            Self::Iso20816 { group: Large, support: Flexible } => "ISO 20816-3, group 1, flexible support, indicative",
            Self::Iso20816 { group: Medium, support: Rigid } => "ISO 20816-3, group 2, rigid support, indicative",
            Self::Iso20816 { group: Medium, support: Flexible } => "ISO 20816-3, group 2, flexible support, indicative",
            Self::Own(_) => "limits of the scene",
        }
    }
}
