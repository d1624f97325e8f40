//! `[[bearing]]` of a scene: geometry, model, effects, damage.

use super::{Cooling, Coordinates, Lubrication, Model, Mounting, Rollers, Temperatures};
use crate::catalogue::Listed;
use ballrace::bearing::kinematics::{Orders, orders};
use ballrace::bearing::quasi_static::film;

/// One `[[bearing]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Bearing {
    /// Unique among the bearings.
    pub name: String,
    /// Station along Z from the rotor's centre of mass, m.
    pub station: f64,
    /// Thrust direction it carries.
    pub facing: Facing,
    /// Bearing model.
    pub model: Model,
    /// Rolling elements, 3 to 64.
    pub elements: usize,
    /// Azimuth of the first element at shaft angle 0, rad.
    pub first_element_azimuth: f64,
    /// Cage speed over shaft speed, when given.
    pub cage_ratio: Option<f64>,
    /// Ball, race and material, when given.
    pub geometry: Option<Geometry>,
    /// Rollers in place of balls, when given; their stiffness and play are the law's.
    pub rollers: Option<Rollers>,
    /// Source of the orders of a bearing without `model`.
    pub kinematics: Option<KinematicData>,
    /// Load-deflection law, when given directly instead of by geometry.
    pub law: Option<Law>,
    /// `axial = {...}` of the lumped model: separate axial elements.
    pub axial: Option<Axial>,
    /// `housing_displacement = [[x, y, z], ...]`: displacement of the outer ring, m, at points fixed in the
    /// housing: those of the elements with the cage at angle 0; empty when rigid.
    pub housing_displacement: Vec<[f64; 3]>,
    /// `outer_ring`: an outer ring that bends under the forces of the elements.
    pub outer_ring: Option<OuterRing>,
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
    /// `outer_ring_tilt`: tilt of the outer ring in its seat about X and Y, rad.
    pub outer_ring_tilt: [f64; 2],
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
    /// Values of the keys that only its model takes, as far as the scene has them.
    pub own: Vec<(&'static str, f64)>,
    /// `bearing`: its entry of the catalogue, whose values stand for keys that the scene does not have.
    pub catalogue: Option<FromCatalogue>,
    /// `fit` and `temperatures`: the clearance before mounting; geometry and law have the operating clearance.
    pub mounting: Option<Mounting>,
    /// `dynamic_rating` and `static_rating` of the maker, N
    pub ratings: [Option<f64>; 2],
    /// `lubrication`, from which friction and modified life follow
    pub lubrication: Option<Lubrication>,
    /// `cooling`, from which the temperatures of the rings follow
    pub cooling: Option<Cooling>,
}

impl Bearing {
    /// Returns the value of a key that only its model takes, in SI units; `None` where the scene does not have it.
    #[must_use]
    pub fn own(&self, key: &str) -> Option<f64> {
        self.own.iter().find(|(name, _)| *name == key).map(|(_, value)| *value)
    }

    /// Returns true for springs with the tangent of another model.
    #[must_use]
    pub fn is_linearised(&self) -> bool {
        self.evaluated_model() != self.model
    }

    /// Returns the model by which the bearing is evaluated: for a linearised bearing, the model that is linearised.
    #[must_use]
    pub fn evaluated_model(&self) -> Model {
        match self.linear {
            Some(Linear::Of(source)) if !self.model.has_elements() => source,
            _ => self.model,
        }
    }

    /// Returns true where the outer ring keeps its shape.
    #[must_use]
    pub fn has_rigid_outer_ring(&self) -> bool {
        self.housing_displacement.is_empty() && self.outer_ring.is_none()
    }

    /// Returns the diameters of an element and of the pitch circle of its geometry, m.
    #[must_use]
    pub fn diameters(&self) -> Option<[f64; 2]> {
        let of_rollers = || self.rollers.as_ref().map(|rollers| [rollers.diameter, rollers.pitch_diameter]);
        self.geometry.map(|geometry| [geometry.ball_diameter, geometry.pitch_diameter]).or_else(of_rollers)
    }

    /// Returns true where a spring keeps the force of the preload, or nothing changes it.
    #[must_use]
    pub fn has_constant_preload_force(&self) -> bool {
        self.preload.is_some_and(|preload| {
            matches!(preload.amount, PreloadAmount::Force(_))
                && (preload.set == PreloadState::Operating || self.mounting.is_none())
        })
    }

    /// Sets the diametral clearance of geometry and law, m. A contact angle changes with it.
    pub fn set_clearance(&mut self, clearance: f64) {
        if let Some(geometry) = &mut self.geometry {
            geometry.fit = match geometry.fit {
                FreeAngle::DiametralClearance(_) => FreeAngle::DiametralClearance(clearance),
                FreeAngle::ContactAngle(_) => FreeAngle::ContactAngle(geometry.contact_angle_of(clearance)),
            };
        }
        if let Some(play) = self.law.as_mut().and_then(|law| law.radial_play.as_mut()) {
            *play = 0.5 * clearance;
        }
    }

    /// Sets the temperatures of its rings, and the clearance that it has with them; nothing without `temperatures` in the scene.
    pub fn set_temperatures(&mut self, temperatures: Temperatures) {
        let Some(mounting) = self.mounting.as_mut().filter(|mounting| mounting.temperatures.is_some()) else { return };
        mounting.temperatures = Some(temperatures);
        let clearance = mounting.operating().value();
        self.set_clearance(clearance);
    }

    /// Returns the temperature of its lubricant, K, and its kinematic viscosity there, m^2/s; none without `lubrication`.
    #[must_use]
    pub fn oil(&self) -> Option<(f64, f64)> {
        let lubrication = self.lubrication?;
        let of_rings = || self.mounting?.temperatures.map(|t| 0.5 * (t.inner + t.outer));
        let temperature = lubrication.temperature.or_else(of_rings)?;
        Some((temperature, lubrication.viscosity(temperature)))
    }

    /// Returns the contact angle that the scene gives, before fits and temperatures, rad; `None` without a geometry or where it has a
    /// clearance instead.
    #[must_use]
    pub fn nominal_contact_angle(&self) -> Option<f64> {
        let geometry = self.geometry?;
        let FreeAngle::ContactAngle(operating) = geometry.fit else { return None };
        Some(self.mounting.map_or(operating, |mounting| geometry.contact_angle_of(mounting.unmounted_clearance)))
    }

    /// Returns the diametral clearance of the law, else of the geometry, m.
    #[must_use]
    pub fn clearance(&self) -> Option<f64> {
        let play = self.law.and_then(|law| law.radial_play).map(|play| 2.0 * play);
        play.or_else(|| self.geometry.map(|geometry| geometry.clearance()))
    }
}

/// Values of a bearing without `model`, from which its orders follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum KinematicData {
    /// Diameters of elements and pitch circle, and the contact angle.
    Diameters {
        /// `ball_diameter` or `roller_diameter`, m, above 0.
        element: f64,
        /// `pitch_diameter`, m, above the diameter of the elements.
        pitch: f64,
        /// `contact_angle`, rad, 0 to pi/3.
        contact_angle: f64,
    },
    /// `orders`, as on a data sheet.
    Orders(Orders),
}

impl KinematicData {
    /// Returns the orders of pure rolling of a bearing with `elements` rolling elements.
    #[must_use]
    pub fn orders(&self, elements: usize) -> Orders {
        match *self {
            Self::Diameters { element, pitch, contact_angle } => {
                let ratio = element / pitch;
                orders(elements, ratio * contact_angle.cos(), ratio)
            }
            Self::Orders(orders) => orders,
        }
    }

    /// Returns the keys that forces need beside those of the scene.
    #[must_use]
    pub const fn keys_of_forces(&self) -> &'static str {
        match self {
            Self::Diameters { .. } => "model, inner_conformity and outer_conformity",
            Self::Orders(_) => {
                "model, elements, ball_diameter, pitch_diameter, contact_angle, inner_conformity and outer_conformity"
            }
        }
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
    /// Mass, kg, above 0.
    pub mass: f64,
    /// Stiffness along X and Y, N/m, above 0.
    pub stiffness: [f64; 2],
    /// Cross-coupled stiffness between X and Y, N/m.
    pub cross_stiffness: f64,
    /// Damping along X and along Y, N s/m, 0 or more.
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

impl Effects {
    /// Returns the names of the effects that are on, in the order in which they can be omitted.
    pub fn named(&self) -> impl Iterator<Item = &'static str> + use<> {
        let Self { centrifugal, gyroscopic, film, .. } = self;
        let all = [(*centrifugal, "centrifugal"), (*gyroscopic, "gyroscopic"), (film.is_some(), "film")];
        all.into_iter().filter(|(is_on, _)| *is_on).map(|(_, name)| name)
    }
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
    /// Heating of the inlet of the contacts, which thins the film.
    pub inlet_heating: Option<InletHeating>,
}

/// `lubricant.inlet_heating`
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InletHeating {
    /// 1/K, above 0: relative decrease of the viscosity
    pub temperature_coefficient: f64,
    /// W/(m K), above 0
    pub conductivity: f64,
}

impl InletHeating {
    /// Values of mineral oils.
    pub const MINERAL_OIL: Self = Self { temperature_coefficient: 0.04, conductivity: 0.14 };

    /// Returns the constants of the kernel's film.
    #[must_use]
    pub const fn of_film(self) -> film::InletHeating {
        let Self { temperature_coefficient, conductivity } = self;
        film::InletHeating { temperature_coefficient, conductivity }
    }
}

impl Lubricant {
    /// Returns the oil of the kernel's film.
    #[must_use]
    pub const fn for_film(&self) -> film::Lubricant {
        film::Lubricant { viscosity: self.viscosity, pressure_viscosity: self.pressure_viscosity }
    }
}

/// `preload`, along the thrust direction that the bearing carries
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preload {
    /// Its size.
    pub amount: PreloadAmount,
    /// `set`: the state in which it has this size.
    pub set: PreloadState,
}

/// State of a bearing in which its preload has the given size.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PreloadState {
    /// `"unmounted"`: before fits and temperatures; the rings are locked axially, so that fits and temperatures change the preload
    #[default]
    Unmounted,
    /// `"fitted"`: with the fits, at the temperature of assembly; the rings are locked axially
    Fitted,
    /// `"operating"`: with fits and temperatures; a spring keeps a force
    Operating,
}

impl PreloadState {
    /// All states by their names in a scene.
    pub const ALL: [(&'static str, Self); 3] =
        [("unmounted", Self::Unmounted), ("fitted", Self::Fitted), ("operating", Self::Operating)];

    /// Returns the name of the state in a scene.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, state)| *state == self).map_or("", |(name, _)| name)
    }
}

/// Size of a preload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PreloadAmount {
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

/// Density of bearing steel, kg/m^3.
pub(crate) const STEEL_DENSITY: f64 = 7800.0;

/// Ball, races and material of one bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    /// Ball diameter, m, above 0.
    pub ball_diameter: f64,
    /// Pitch diameter, m, above the ball diameter.
    pub pitch_diameter: f64,
    /// Groove radius of the inner race over ball diameter, above 0.5 and at most 1.
    pub inner_conformity: f64,
    /// Groove radius of the outer race over ball diameter, above 0.5 and at most 1.
    pub outer_conformity: f64,
    /// How the free contact angle is given.
    pub fit: FreeAngle,
    /// Young's modulus of balls and races, Pa, above 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio of balls and races, 0 or more and below 0.5.
    pub poissons_ratio: f64,
    /// Density of the balls, kg/m^3, above 0
    pub density: f64,
}

impl Geometry {
    /// Returns the distance of the groove centres at first contact, m.
    fn groove_centres(&self) -> f64 {
        (self.inner_conformity + self.outer_conformity - 1.0) * self.ball_diameter
    }

    /// Returns the axial distance of the groove centres at first contact, m.
    #[must_use]
    pub fn axial_groove_distance(&self) -> f64 {
        match self.fit {
            FreeAngle::ContactAngle(angle) => self.groove_centres() * angle.sin(),
            FreeAngle::DiametralClearance(clearance) => self.groove_centres() * self.contact_angle_of(clearance).sin(),
        }
    }

    /// Returns the diametral clearance, m.
    #[must_use]
    pub fn clearance(&self) -> f64 {
        match self.fit {
            FreeAngle::ContactAngle(angle) => 2.0 * self.groove_centres() * (1.0 - angle.cos()),
            FreeAngle::DiametralClearance(clearance) => clearance,
        }
    }

    /// Returns the free contact angle with a diametral clearance, rad; 0 with an interference.
    fn contact_angle_of(&self, clearance: f64) -> f64 {
        (1.0 - 0.5 * clearance / self.groove_centres()).clamp(0.5, 1.0).acos()
    }
}

/// Free contact angle, or the clearance that determines it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FreeAngle {
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
    /// Contact stiffness, N/m^exponent, above 0.
    pub stiffness: f64,
    /// Exponent of the load-deflection law, 1 to 3.
    pub exponent: f64,
    /// Axial play, m.
    pub play: f64,
    /// Radius at which the elements act, m, 0 or more.
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
    /// Azimuth of the centre from the zero of the surface, rad.
    pub azimuth: f64,
    /// Half of the angular width, rad, above 0 and at most pi.
    pub half_width: f64,
    /// Depth, m, above 0.
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

/// `outer_ring = { radius, width, thickness, youngs_modulus, orders }`: a thin ring that bends
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OuterRing {
    /// m, of the neutral line, above 0
    pub radius: f64,
    /// m, above 0
    pub width: f64,
    /// m, radial, above 0
    pub thickness: f64,
    /// Pa, above 0
    pub youngs_modulus: f64,
    /// Highest order of the shape, 2 or more.
    pub orders: usize,
}
