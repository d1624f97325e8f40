//! Scenes: the description of a machine (TOML with units) and the kernel's parameters from it.
//!
//! [`read`] converts the text to the SI numbers of this file and rejects unknown content. [`catalogue`] has bearings by designation,
//! [`flexible_rotor`] the drawing of a shaft and its few coordinates.
#![forbid(unsafe_code)]

mod bearing;
pub mod catalogue;
pub mod edit;
pub mod flexible_rotor;
mod key;
mod lubrication;
mod machine;
mod model;
mod mounting;
pub mod multibody;
pub mod read;
mod recording;
#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod reference;
mod rollers;
mod schema;
mod table;
pub mod units;

pub use crate::flexible_rotor::{Disk, FlexibleRotor, Section};
pub use bearing::{
    Axial, Bearing, CageRunout, Defect, DefectShape, Effects, Facing, FreeAngle, FrictionSharing, FromCatalogue,
    Geometry, InletHeating, KinematicData, Law, Linear, Lubricant, OuterRing, Preload, PreloadAmount, PreloadState,
    RaceControl, Support, Surface, TableRange, Wave,
};
pub use lubrication::{Cooling, Lubrication, LubricationMethod, OilFlow};
pub use machine::{MachineClass, MachineGroup, MachineSupport};
pub use model::{Model, ModelInput, ModelProperties};
pub use mounting::{Mounting, OperatingClearance, PartMaterial, Ring, RingFit, Temperatures};
pub use recording::{
    Clock, Direction, FileLayout, KeyphasorSignal, Orientation, Probe, PulseDetection, Recording, RotationSource,
    Sensor, Sequence, Slope, TemperatureChannel,
};
pub use rollers::{RollerKind, RollerProfile, Rollers};
pub use schema::json_schema;

use std::path::PathBuf;

/// A whole scene file in SI units, checked field by field.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// `name`
    pub name: String,
    /// Path of the file; relative paths in the scene start from its folder.
    pub path: PathBuf,
    /// `[shaft]`
    pub shaft: Shaft,
    /// `[rotor]`
    pub rotor: Option<Rotor>,
    /// `[system]`, instead of a rotor
    pub system: Option<System>,
    /// `[[bearing]]`, at least one
    pub bearings: Vec<Bearing>,
    /// `[machine]`
    pub machine: Option<MachineClass>,
    /// `[recording]`
    pub recording: Option<Recording>,
    /// `[integration]`
    pub integration: Integration,
    /// `[observer]`
    pub observer: Observer,
    /// `[[limit]]`
    pub limits: Vec<Limit>,
}

impl Scene {
    /// Returns a station from the centre of mass as the scene's drawing has it, m.
    #[must_use]
    pub fn drawn_station(&self, station: f64) -> f64 {
        station + self.rotor.as_ref().map_or(0.0, |rotor| rotor.centre_of_mass)
    }
}

/// One `[[limit]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// `indicator`
    pub indicator: Indicator,
    /// `probe`: its column; every radial probe when absent
    pub probe: Option<String>,
    /// `bearing` of a race's line
    pub bearing: Option<String>,
    /// `max` or `growth_db`
    pub allowed: Allowed,
    /// `hysteresis`: share of the limit by which a value has to fall below it, 0 or more and below 1
    pub hysteresis: f64,
    /// `duration`, s: a shorter crossing is no event
    pub duration: f64,
}

/// Condition of a limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Allowed {
    /// m, or a number
    Most(f64),
    /// Times the baseline's value
    Growth(f64),
}

/// `indicator` of a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Indicator {
    /// `"peak-to-peak"`
    PeakToPeak,
    /// `"rms"` about the mean
    Rms,
    /// `"crest-factor"`
    CrestFactor,
    /// `"kurtosis"`
    Kurtosis,
    /// `"residual"`: rms of measured - twin
    Residual,
    /// `"1X"`, amplitude
    OneX,
    /// `"2X"`, amplitude
    TwoX,
    /// `"outer-race"`: its line in the residual
    OuterRace,
    /// `"inner-race"`
    InnerRace,
}

impl Indicator {
    /// All indicators by their names in the scene.
    pub const ALL: [(&'static str, Self); 9] = [
        ("peak-to-peak", Self::PeakToPeak),
        ("rms", Self::Rms),
        ("crest-factor", Self::CrestFactor),
        ("kurtosis", Self::Kurtosis),
        ("residual", Self::Residual),
        ("1X", Self::OneX),
        ("2X", Self::TwoX),
        ("outer-race", Self::OuterRace),
        ("inner-race", Self::InnerRace),
    ];

    /// Returns the name of the indicator in a scene.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name)
    }

    /// Returns true where the indicator is a length.
    #[must_use]
    pub(crate) const fn is_length(self) -> bool {
        !matches!(self, Self::CrestFactor | Self::Kurtosis)
    }

    /// Returns the unit of its values in outputs, empty for a number, and its factor from the SI unit.
    #[must_use]
    pub const fn unit(self) -> (&'static str, f64) {
        if self.is_length() { ("um", 1e6) } else { ("", 1.0) }
    }
}

/// `[observer]`: parameters of the observer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Observer {
    /// `process_noise`, N per root second, above 0: process noise of the unmodelled force; estimated from the first turns when absent
    pub process_noise: Option<f64>,
}

/// `[integration]`: how motion is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Integration {
    /// `method`
    pub method: Method,
    /// `step`, s: the longest; from the highest natural frequency when absent
    pub step: Option<f64>,
}

/// `method`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// `"runge-kutta"`: the method of Nystrom, order 4, three evaluations a step
    RungeKutta,
    /// `"newmark"`: implicit, stable at any step
    Newmark {
        /// `newton_steps`
        newton_steps: u8,
    },
    /// `"verlet"`: symplectic, one evaluation a step
    Verlet,
}

impl Default for Integration {
    fn default() -> Self {
        Self { method: Method::RungeKutta, step: None }
    }
}

/// `[shaft]`: how the shaft turns.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaft {
    /// Speed about +Z over time.
    pub speed: Speed,
    /// Speed of the outer rings, rad/s.
    pub outer_speed: f64,
}

/// Shaft speed over time, rad/s and s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Speed {
    /// One speed.
    Constant(f64),
    /// A uniform ramp, constant before and after it.
    Ramp {
        /// Speed at time 0.
        from: f64,
        /// Speed after `over`.
        to: f64,
        /// Length of the ramp, s, above 0.
        over: f64,
    },
    /// `mean * (1 + fluctuation * cos(2 pi frequency t))`
    Fluctuating {
        /// Mean speed.
        mean: f64,
        /// Relative amplitude, 0 or more and below 1.
        fluctuation: f64,
        /// Frequency, Hz, above 0.
        frequency: f64,
    },
}

impl Speed {
    /// Returns the speed at `time` (s, 0 or more), rad/s.
    #[must_use]
    pub fn at(self, time: f64) -> f64 {
        match self {
            Self::Constant(speed) => speed,
            Self::Ramp { from, to, over } => from + (to - from) * (time / over).min(1.0),
            Self::Fluctuating { mean, fluctuation, frequency } => {
                mean * (1.0 + fluctuation * (std::f64::consts::TAU * frequency * time).cos())
            }
        }
    }

    /// Returns the speed at which static equilibria and preloads are computed, rad/s: the constant or mean speed, or that before a ramp.
    #[must_use]
    pub fn nominal(self) -> f64 {
        match self {
            Self::Constant(speed) | Self::Ramp { from: speed, .. } | Self::Fluctuating { mean: speed, .. } => speed,
        }
    }

    /// Returns the lowest and the highest speed, rad/s.
    #[must_use]
    pub fn range(self) -> (f64, f64) {
        let (a, b) = match self {
            Self::Constant(speed) => (speed, speed),
            Self::Ramp { from, to, .. } => (from, to),
            Self::Fluctuating { mean, fluctuation, .. } => (mean * (1.0 - fluctuation), mean * (1.0 + fluctuation)),
        };
        (a.min(b), a.max(b))
    }

    /// Returns the revolutions from time 0 to `time` (s, 0 or more).
    #[must_use]
    pub fn revolutions(self, time: f64) -> f64 {
        use std::f64::consts::TAU;
        match self {
            Self::Constant(speed) => speed * time / TAU,
            Self::Ramp { from, to, over } => {
                let on_ramp = time.min(over);
                (from * on_ramp + 0.5 * (to - from) / over * on_ramp * on_ramp + to * (time - on_ramp)) / TAU
            }
            Self::Fluctuating { mean, fluctuation, frequency } => {
                let circular = TAU * frequency;
                mean * (time + fluctuation * (circular * time).sin() / circular) / TAU
            }
        }
    }
}

/// `[rotor]`: a rotor about its centre of mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Rotor {
    /// Mass, kg, above 0.
    pub mass: f64,
    /// Diametral moment of inertia about the centre of mass, kg m^2, above 0.
    pub diametral_inertia: f64,
    /// Polar moment of inertia, kg m^2, 0 or more.
    pub polar_inertia: f64,
    /// Damping of the rotor: N s/m (three) and N m s/rad (two), each 0 or more.
    pub damping: [f64; 5],
    /// Factor of the stiffness in the damping, s, 0 or more.
    pub proportional_damping: f64,
    /// Springs on the rotor itself: N/m (three) and N m/rad (two), each 0 or more.
    pub stiffness: [f64; 5],
    /// Acceleration of gravity along X, Y and Z, m/s^2.
    pub gravity: [f64; 3],
    /// Constant load on the rotor, reduced to the centre of mass: N (three) and N m (two).
    pub load: [f64; 5],
    /// Unbalances; empty when the rotor is balanced.
    pub unbalance: Vec<Unbalance>,
    /// Station of the centre of mass as drawn, m; 0 of a rigid rotor
    pub centre_of_mass: f64,
    /// Drawing of a shaft that bends; none of a rigid rotor
    pub flexible: Option<FlexibleRotor>,
}

impl Rotor {
    /// Returns the station at which the load acts, m, and the load there.
    #[must_use]
    pub fn local_load(&self) -> (f64, [f64; 5]) {
        let station = self.flexible.as_ref().map_or(0.0, |drawn| drawn.load_station);
        (station, load_at(self.load, -station))
    }
}

/// Returns the load at one place as a load `distance` before it along Z.
#[must_use]
pub fn load_at([fx, fy, fz, mx, my]: [f64; 5], distance: f64) -> [f64; 5] {
    [fx, fy, fz, mx - distance * fy, my + distance * fx]
}

/// `[system]`: any linear system by its matrices, such as a reduced finite-element rotor.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// M, a file
    pub mass: PathBuf,
    /// B, a file
    pub damping: Option<PathBuf>,
    /// G, a file, to be multiplied by the speed
    pub gyroscopic: Option<PathBuf>,
    /// K, a file
    pub stiffness: PathBuf,
    /// Constant load on each coordinate, a file
    pub load: Option<PathBuf>,
    /// s, times the stiffness of system and bearings; 0 or more
    pub proportional_damping: f64,
    /// Unbalances; empty when it is balanced.
    pub unbalance: Vec<SystemUnbalance>,
}

/// One entry of a system's `unbalance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SystemUnbalance {
    /// kg m, 0 or more
    pub moment: f64,
    /// rad, from the keyphasor mark in the direction of positive rotation
    pub angle: f64,
    /// Coordinates along X and Y of its plane, from 0
    pub at: [usize; 2],
}

/// `coordinates` of a bearing or a probe on a system: which coordinate each of `u v w thu thv` is, from 1, negative where it counts
/// the other way, 0 where there is none.
pub type Coordinates = [i64; 5];

/// One entry of `unbalance`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unbalance {
    /// kg m, 0 or more
    pub moment: f64,
    /// rad, from the keyphasor mark in the direction of positive rotation
    pub angle: f64,
    /// m along Z from the centre of mass
    pub station: f64,
}
