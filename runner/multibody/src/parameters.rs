//! Parameters of a bearing, from a scene.

use crate::traction::TractionCurve;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::film::Lubricant;
use ballrace::bearing::surface::{BearingComponent, Feature, SurfaceDeviation};
use ballrace::{Exact, Phase};
use ballrace_models::build::{self, BuildError};
use ballrace_scene::multibody as defaults;
use ballrace_scene::{Bearing as BearingScene, Facing, Scene};
use std::f64::consts::PI;

/// Density of a cage of fabric-reinforced phenolic resin, kg/m^3.
const CAGE_DENSITY: f64 = 1400.0;
/// Radial thickness and width of a cage over the diameter of the balls.
const CAGE_SECTION: [f64; 2] = [0.3, 1.2];
/// Drag coefficient of a sphere at Reynolds numbers from 1e3 to 2e5 (Schlichting, Boundary-Layer Theory).
const SPHERE_DRAG: f64 = 0.45;

/// Cage of a bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CageParams {
    /// Mass, kg.
    pub mass: f64,
    /// Moments of inertia about a diameter and about the axis, kg m^2.
    pub inertia: [f64; 2],
    /// Diametral clearance of a ball in its pocket, m.
    pub pocket_clearance: f64,
    /// Diametral clearance at the land of the inner and of the outer ring, m; none where that ring does not guide the cage.
    pub land_clearance: [Option<f64>; 2],
    /// Radius of the guided surface at the inner and the outer ring, m.
    pub land_radius: [f64; 2],
    /// Half of the axial distance of the edges that touch a land, m.
    pub half_width: f64,
    /// Stiffness of a contact of the cage, N/m.
    pub stiffness: f64,
    /// Damping of a contact of the cage over its force, s/m.
    pub damping: f64,
    /// Friction coefficient of the cage.
    pub friction: f64,
}

/// Parameters of a bearing.
#[derive(Debug, Clone)]
pub struct Params {
    /// Geometry and material.
    pub geometry: BallBearingGeometry,
    /// 1 where the bearing carries thrust along +Z, -1 along -Z, 0 where the rings are centred at zero displacement.
    pub facing: f64,
    /// Azimuths of the balls with the cage at angle 0.
    pub azimuths: Vec<Phase>,
    /// Density of the balls, kg/m^3.
    pub density: f64,
    /// alpha of Hunt and Crossley on the races, s/m.
    pub contact_damping: f64,
    /// Traction on the races.
    pub traction: TractionCurve,
    /// Oil of the film between balls and races, whose thickness is reported.
    pub oil: Option<Lubricant>,
    /// Drag of the oil on a ball over the square of its speed, kg/m.
    pub drag: f64,
    /// Error of a ball's position in one integration step, m.
    pub step_error: f64,
    /// Weight over mass, m/s^2.
    pub gravity: [f64; 3],
    /// The cage.
    pub cage: CageParams,
    /// Surfaces of inner race, outer race and balls that deviate.
    pub surfaces: [SurfaceDeviation<Exact, Vec<Feature<f64>>>; 3],
}

impl Params {
    /// Returns the parameters of a bearing with the model `multibody`.
    ///
    /// # Errors
    /// Returns an error if the scene lacks a value of this model or the kernel rejects one.
    pub fn of(scene: &Scene, of: &BearingScene) -> Result<Self, BuildError> {
        let (geometry, _) = build::contact_geometry(of, of.model.name())?;
        let own = |key: &str, default: f64| of.own(key).unwrap_or(default);
        let (diameter, peak) = (geometry.ball_diameter, own("traction_peak", defaults::TRACTION_PEAK));
        // Features as the scene has them: this model turns the groove instead of the frame of a bearing that faces -Z.
        let as_given = BearingScene { facing: Facing::Both, ..of.clone() };
        let features: Vec<Feature<f64>> = build::features(&as_given);
        let on = |which: fn(&BearingComponent) -> bool| {
            SurfaceDeviation::new(features.iter().copied().filter(|one| which(&component(one))).collect::<Vec<_>>())
        };
        Ok(Self {
            facing: match of.facing {
                Facing::PlusZ => 1.0,
                Facing::MinusZ => -1.0,
                Facing::Both => 0.0,
            },
            azimuths: (0..of.elements).map(|j| build::place::<f64>(of, j).azimuth()).collect(),
            density: of.geometry.map_or(0.0, |g| g.density),
            contact_damping: own("contact_damping", defaults::CONTACT_DAMPING),
            traction: TractionCurve::with_peak(
                peak,
                own("traction_peak_slip", defaults::TRACTION_PEAK_SLIP),
                own("traction_limit", defaults::TRACTION_LIMIT_SHARE * peak),
            ),
            step_error: own("step_error", defaults::STEP_ERROR),
            oil: of.lubricant.map(|oil| oil.for_film()),
            drag: 0.125 * SPHERE_DRAG * own("mixture_density", defaults::MIXTURE_DENSITY) * PI * diameter * diameter,
            gravity: scene.rotor.as_ref().map_or([0.0; 3], |rotor| rotor.gravity),
            cage: CageParams::of(of, &geometry),
            surfaces: [
                on(|c| matches!(c, BearingComponent::Inner)),
                on(|c| matches!(c, BearingComponent::Outer)),
                on(|c| matches!(c, BearingComponent::Ball(_))),
            ],
            geometry,
        })
    }

    /// Returns the mass of a ball, kg.
    #[must_use]
    pub fn ball_mass(&self) -> f64 {
        self.density * PI / 6.0 * self.geometry.ball_diameter.powi(3)
    }

    /// Returns the moment of inertia of a ball, kg m^2.
    #[must_use]
    pub fn ball_inertia(&self) -> f64 {
        0.1 * self.ball_mass() * self.geometry.ball_diameter.powi(2)
    }
}

fn component(feature: &Feature<f64>) -> BearingComponent {
    match feature {
        Feature::Wave(wave) => wave.component,
        Feature::Spall(spall) => spall.component,
    }
}

impl CageParams {
    /// Returns the ring that guides the cage, 0 the inner and 1 the outer: that with the smaller clearance; none where the balls do.
    #[must_use]
    pub fn guide(&self) -> Option<usize> {
        match self.land_clearance {
            [Some(inner), Some(outer)] => Some(usize::from(outer <= inner)),
            [inner, outer] => outer.map(|_| 1).or(inner.map(|_| 0)),
        }
    }

    fn of(of: &BearingScene, geometry: &BallBearingGeometry) -> Self {
        let own = |key: &str, default: f64| of.own(key).unwrap_or(default);
        let (diameter, radius) = (geometry.ball_diameter, 0.5 * geometry.pitch_diameter);
        let [thickness, width] = CAGE_SECTION.map(|share| share * diameter);
        let pockets = of.elements as f64 * 0.25 * PI * diameter * diameter * thickness;
        let mass = own("cage_mass", CAGE_DENSITY * (2.0 * PI * radius * thickness * width - pockets));
        let polar = mass * (radius * radius + 0.25 * thickness * thickness);
        Self {
            mass,
            inertia: [0.5 * polar + mass * width * width / 12.0, polar],
            pocket_clearance: own("pocket_clearance", defaults::POCKET_CLEARANCE_SHARE * diameter),
            land_clearance: [of.own("inner_land_clearance"), of.own("outer_land_clearance")],
            land_radius: [radius - 0.5 * thickness, radius + 0.5 * thickness],
            half_width: 0.5 * width,
            stiffness: own("cage_stiffness", defaults::CAGE_STIFFNESS),
            damping: own("cage_damping", defaults::CAGE_DAMPING),
            friction: own("cage_friction", defaults::CAGE_FRICTION),
        }
    }
}
