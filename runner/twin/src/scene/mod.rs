//! Scenes: the description of a machine (TOML with units) and the kernel's parameters from it.
//!
//! [`read`] converts the text to the SI numbers of this file and rejects unknown content; [`build`] converts these to kernel
//! types.

pub mod bounded;
pub mod build;
pub mod draft;
pub mod edit;
mod flexible_rotor;
pub mod matrix;
mod mounting;
pub mod read;
mod recording;
mod table;
pub mod units;

pub use flexible_rotor::{Disk, FlexibleRotor, Section};
pub use mounting::{Mounting, OperatingClearance, PartMaterial, Ring, RingFit, Temperatures};
pub use recording::{
    Clock, Direction, FileLayout, KeyphasorSignal, Orientation, Probe, PulseDetection, Recording, RotationSource,
    Sensor, Sequence, Slope, TemperatureChannel,
};

use crate::catalogue::Listed;
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

    /// As a scene names it, and whether it is a length.
    #[must_use]
    pub fn name(self) -> (&'static str, bool) {
        let name = Self::ALL.iter().find(|(_, one)| *one == self).map_or("", |(name, _)| name);
        (name, !matches!(self, Self::CrestFactor | Self::Kurtosis))
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
    /// `"runge-kutta"`: order 4, four evaluations a step
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
    /// At `time` (s, 0 or more), rad/s.
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

    /// The speed at which rest positions and preloads are taken: the constant or mean one, or that before a ramp.
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

    /// Revolutions from time 0 to `time` (s, 0 or more).
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
    /// kg, above 0
    pub mass: f64,
    /// kg m^2, above 0
    pub diametral_inertia: f64,
    /// kg m^2, 0 or more
    pub polar_inertia: f64,
    /// N s/m (three) and N m s/rad (two), each 0 or more
    pub damping: [f64; 5],
    /// s, times the stiffness; 0 or more
    pub proportional_damping: f64,
    /// N/m (three) and N m/rad (two), each 0 or more: springs on the rotor itself
    pub stiffness: [f64; 5],
    /// m/s^2
    pub gravity: [f64; 3],
    /// N (three) and N m (two): constant load on the rotor, as one at the centre of mass
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

/// One `[[bearing]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Bearing {
    /// Unique among the bearings.
    pub name: String,
    /// m along Z from the rotor's centre of mass
    pub station: f64,
    /// Thrust direction it carries.
    pub facing: Facing,
    /// Bearing model.
    pub model: Model,
    /// Rolling elements, 3 to 64.
    pub elements: usize,
    /// rad, at shaft angle 0
    pub first_element_azimuth: f64,
    /// Cage speed over shaft speed, when given.
    pub cage_ratio: Option<f64>,
    /// Ball, race and material, when given.
    pub geometry: Option<Geometry>,
    /// Load-deflection law, when given directly instead of by geometry.
    pub law: Option<Law>,
    /// `axial = {...}` of the lumped model: separate axial elements.
    pub axial: Option<Axial>,
    /// `housing_displacement = [[x, y, z], ...]`: displacement of the outer ring at each element, m; empty when rigid.
    pub housing_displacement: Vec<[f64; 3]>,
    /// Source of the linear model; only with `model = "linear"`.
    pub linear: Option<Linear>,
    /// Local damage of races and balls.
    pub defect: Vec<Defect>,
    /// Waviness of races and balls.
    pub waviness: Vec<Wave>,
    /// Effects in the quasi-static and tabulated models.
    pub effects: Effects,
    /// `lubricant`, whether or not its film is one of the effects.
    pub lubricant: Option<Lubricant>,
    /// How the bearing is preloaded.
    pub preload: Option<Preload>,
    /// Range of the tabulated model, as far as the scene defines it.
    pub table: Option<TableRange>,
    /// `coordinates`: of the inner ring, on a `[system]`
    pub coordinates: Option<Coordinates>,
    /// `housing_coordinates`: of the outer ring, on a `[system]`, when it moves.
    pub housing_coordinates: Option<Coordinates>,
    /// `support`: elastic support of the outer ring.
    pub support: Option<Support>,
    /// `element_azimuths`, rad, at shaft angle 0; empty where the elements are evenly spaced.
    pub element_azimuths: Vec<f64>,
    /// `cage_runout`
    pub cage_runout: Option<CageRunout>,
    /// `element_damping` of the dynamic model, N s/m on each element's radial motion.
    pub element_damping: f64,
    /// `solver_steps` of the quasi-static model; the kernel's own number when absent.
    pub solver_steps: Option<u8>,
    /// `bearing`: its entry of the catalogue, whose values stand for keys that the scene does not have.
    pub catalogue: Option<FromCatalogue>,
    /// `fit` and `temperatures`: the clearance before mounting; geometry and law have the operating clearance.
    pub mounting: Option<Mounting>,
}

impl Bearing {
    /// Sets the diametral clearance of geometry and law, m. A contact angle changes with it.
    pub fn set_clearance(&mut self, clearance: f64) {
        if let Some(geometry) = &mut self.geometry {
            geometry.fit = match geometry.fit {
                Fit::DiametralClearance(_) => Fit::DiametralClearance(clearance),
                Fit::ContactAngle(_) => Fit::ContactAngle(geometry.contact_angle_of(clearance)),
            };
        }
        if let Some(play) = self.law.as_mut().and_then(|law| law.radial_play.as_mut()) {
            *play = 0.5 * clearance;
        }
    }

    /// Returns the diametral clearance of the law, else of the geometry, m.
    #[must_use]
    pub fn clearance(&self) -> Option<f64> {
        let play = self.law.and_then(|law| law.radial_play).map(|play| 2.0 * play);
        play.or_else(|| self.geometry.map(|geometry| geometry.clearance()))
    }
}

/// Values of the catalogue in a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct FromCatalogue {
    /// The bearing.
    pub listed: Listed,
    /// Estimated values, such as `inner_conformity = 0.52`.
    pub estimated: Vec<String>,
}

/// `support = { mass, stiffness_x, stiffness_y, stiffness_xy, damping }`
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support {
    /// kg, above 0
    pub mass: f64,
    /// N/m along X and Y, above 0
    pub stiffness: [f64; 2],
    /// N/m between X and Y
    pub cross_stiffness: f64,
    /// N s/m along both, 0 or more
    pub damping: f64,
}

/// `cage_runout = { offset, angle, radius }`: the cage turns about a point beside its centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CageRunout {
    /// m, 0 or more
    pub offset: f64,
    /// rad, direction of the offset at shaft angle 0
    pub angle: f64,
    /// m, of the elements' circle; half the pitch diameter when absent
    pub radius: f64,
}

/// `table = { approach = [..], angle = [..], speed = [..], intervals = [..] }`
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TableRange {
    /// m: least and greatest approach of the rings along the line of groove centres
    pub approach: Option<[f64; 2]>,
    /// rad: of that line
    pub angle: Option<[f64; 2]>,
    /// rad/s, 0 or more
    pub speed: Option<[f64; 2]>,
    /// along approach, angle and speed
    pub intervals: Option<[usize; 3]>,
}

/// `effects` with their parameters; each is off unless named.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effects {
    /// `"centrifugal"`
    pub centrifugal: bool,
    /// `"gyroscopic"`
    pub gyroscopic: bool,
    /// `"film"`, with the oil of `lubricant`
    pub film: Option<Lubricant>,
    /// `race_control`
    pub control: RaceControl,
    /// `friction_sharing`
    pub sharing: FrictionSharing,
}

/// `race_control`
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RaceControl {
    /// `"outer"`
    #[default]
    Outer,
    /// `"inner"`
    Inner,
}

/// `friction_sharing`
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FrictionSharing {
    /// `"outer"`
    #[default]
    Outer,
    /// `"equal"`
    Equal,
    /// `"proportional"`
    Proportional,
}

/// `lubricant`
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lubricant {
    /// Pa s, above 0
    pub viscosity: f64,
    /// 1/Pa, above 0
    pub pressure_viscosity: f64,
    /// m, rms of ball and race together, above 0: denominator of the film ratio
    pub roughness: Option<f64>,
}

/// `preload`, along the thrust direction that the bearing carries
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Preload {
    /// N, above 0: the inner ring is displaced until the bearing reacts with this force at the scene's speed
    Force(f64),
    /// m, above 0
    Displacement(f64),
}

/// `facing`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Facing {
    /// `"+z"`
    PlusZ,
    /// `"-z"`
    MinusZ,
    /// `"both"`: a deep groove bearing
    Both,
}

/// `model`
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// A constant 5 x 5 stiffness.
    Linear,
    /// Separate radial and axial elements (Hajzman).
    Lumped,
    /// Closed-form variable contact angle (`docs/src/models.md#angular-contact-bearing`).
    Angular,
    /// Every ball in equilibrium between both races, solved ball by ball (`docs/src/models.md#quasi-static-bearing`).
    QuasiStatic,
    /// The same from a table, at a small fixed cost.
    Tabulated,
    /// Elements with a mass of their own that moves along their radius (`docs/src/models.md#balls-with-mass`).
    Dynamic,
}

impl Model {
    /// All of them, cheapest first, as a scene names them.
    pub const ALL: [(&'static str, Self); 6] = [
        ("linear", Self::Linear),
        ("lumped", Self::Lumped),
        ("angular", Self::Angular),
        ("quasi-static", Self::QuasiStatic),
        ("tabulated", Self::Tabulated),
        ("dynamic", Self::Dynamic),
    ];

    /// As a scene names it.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, model)| *model == self).map_or("", |(name, _)| name)
    }
}

/// Ball, races and material of one bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// m
    pub ball_diameter: f64,
    /// m
    pub pitch_diameter: f64,
    /// groove radius / ball diameter, above 0.5
    pub inner_conformity: f64,
    /// groove radius / ball diameter, above 0.5
    pub outer_conformity: f64,
    /// How the free contact angle is given.
    pub fit: Fit,
    /// Pa
    pub youngs_modulus: f64,
    /// 0 or more, below 0.5
    pub poissons_ratio: f64,
    /// Density of the balls, kg/m^3, above 0
    pub density: f64,
}

impl Geometry {
    /// Returns the distance of the groove centres at first contact, m.
    fn groove_centres(&self) -> f64 {
        (self.inner_conformity + self.outer_conformity - 1.0) * self.ball_diameter
    }

    /// Returns the diametral clearance, m.
    #[must_use]
    pub fn clearance(&self) -> f64 {
        match self.fit {
            Fit::ContactAngle(angle) => 2.0 * self.groove_centres() * (1.0 - angle.cos()),
            Fit::DiametralClearance(clearance) => clearance,
        }
    }

    /// Returns the free contact angle with a diametral clearance, rad; 0 with an interference.
    fn contact_angle_of(&self, clearance: f64) -> f64 {
        (1.0 - 0.5 * clearance / self.groove_centres()).clamp(0.5, 1.0).acos()
    }
}

/// Free contact angle, given one way or the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fit {
    /// rad, 0 to pi/3
    ContactAngle(f64),
    /// m; negative is an interference fit (only for the lumped model)
    DiametralClearance(f64),
}

/// `stiffness`, `exponent`, `radial_play`: F = stiffness * Delta^exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// N/m^exponent, above 0; from geometry when absent
    pub stiffness: Option<f64>,
    /// 1 to 3; 1.5 when absent
    pub exponent: f64,
    /// m, half the diametral clearance; negative is preload; from geometry when absent
    pub radial_play: Option<f64>,
}

/// Separate axial elements of the lumped model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axial {
    /// N/m^exponent, above 0
    pub stiffness: f64,
    /// 1 to 3
    pub exponent: f64,
    /// m
    pub play: f64,
    /// m, 0 or more
    pub radius: f64,
}

/// Source of a linear bearing's stiffness.
#[derive(Debug, Clone, PartialEq)]
pub enum Linear {
    /// `stiffness_matrix`, N/m, N, N/rad, N m/rad
    Matrix([[f64; 5]; 5]),
    /// `two_spring = { static_load = "500 N" }`: the formula of Friswell et al. for balls
    TwoSpring {
        /// N, above 0
        static_load: f64,
    },
    /// `linearise = "angular"` or `"lumped"`: the tangent of that model at the rotor's static equilibrium
    Of(Model),
}

/// Surface of a defect or a wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// `"inner"`
    Inner,
    /// `"outer"`
    Outer,
    /// `"ball"` or `"element"`; damage is on this one (0 is the first), waviness on all
    Ball(usize),
}

/// One entry of `waviness`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Surface.
    pub surface: Surface,
    /// `direction = "axial"`; false is radial
    pub axial: bool,
    /// Waves around the surface, 1 or more
    pub order: u32,
    /// m, above 0
    pub amplitude: f64,
    /// rad of the wave
    pub phase: f64,
}

/// One entry of `defect`: a spall on a race or a ball.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Defect {
    /// Surface.
    pub surface: Surface,
    /// rad, centre, from the surface's own zero
    pub azimuth: f64,
    /// rad, above 0
    pub half_width: f64,
    /// m, above 0
    pub depth: f64,
    /// Section along the race.
    pub shape: DefectShape,
}

/// `shape` of a defect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DefectShape {
    /// `"half-sine"`
    HalfSine,
    /// `"rectangular"`
    Rectangular,
}
