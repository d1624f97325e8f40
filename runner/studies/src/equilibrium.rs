//! Static equilibrium of a bearing or a rotor, with the load on each element.

use crate::campbell::{ModeShape, mode_shapes, modes};
use crate::effect_significance::{self, EffectSignificance};
use crate::elements::BearingElements;
pub use crate::elements::{Element, RollerLoads};
use crate::friction::{BallContacts, BearingFriction};
use crate::heat::BearingTemperatures;
use crate::life::{BearingLife, ElementLoads};
use ballrace::bearing::Bearing;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::{BearingKinematicState, Displacement, Phase};
use ballrace_models::build::{self, AnyBearing, ElementContact, Kinematics};
use ballrace_outcome::{BearingOrders, ClearanceOutcome, RotorDrawing, RotorOutcome};
use ballrace_plant::error::{NoLoad, Result};
use ballrace_plant::{LARGEST_RESIDUAL, Plant};
use ballrace_scene::{Bearing as BearingScene, Effects, PreloadAmount, Scene};
use serde::Serialize;
use std::time::Instant;

/// Positions of the cage within a pitch whose element loads make the life.
const CAGE_POSITIONS: u32 = 8;

/// Result of `equilibrium`, SI units.
#[derive(Debug, Clone, Serialize)]
pub struct StaticEquilibrium {
    /// Name of the scene.
    pub scene: String,
    /// Shaft speed, rad/s.
    pub speed: f64,
    /// Displacement: of the inner ring against the outer ring of a single bearing, of the centre of mass on a rotor.
    pub displacement: [f64; 5],
    /// Force of the bearings on the inner ring or the rotor, N and N m.
    pub force: [f64; 5],
    /// Tangent stiffness.
    pub stiffness: [[f64; 5]; 5],
    /// Elements of all bearings.
    pub elements: Vec<Element>,
    /// Flexible rotor; `None` for a rigid rotor or a single bearing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotor: Option<RotorOutcome>,
    /// Drawing of the rotor, not part of the JSON; `None` for a single bearing.
    #[serde(skip)]
    pub drawing: Option<RotorDrawing>,
    /// Undamped natural frequencies of the rotor at this speed; empty without a rotor.
    pub natural_frequencies_hz: Vec<f64>,
    /// Shapes of the lowest damped modes of a flexible rotor, not part of the JSON.
    #[serde(skip)]
    pub mode_shapes: Vec<ModeShape>,
    /// Results of each bearing.
    pub bearings: Vec<BearingEquilibrium>,
    /// Residual of the equilibrium over the load.
    pub residual: f64,
    /// Time of the solution, s.
    pub solving_seconds: f64,
    /// Changes when one effect is switched off.
    pub effects: Vec<EffectShare>,
    /// Predicted change by each effect, also by neglected ones.
    #[serde(rename = "effect_significance")]
    pub significance: Vec<EffectSignificance>,
}

impl StaticEquilibrium {
    /// Returns the elements of a bearing.
    pub fn of<'a>(&'a self, bearing: &'a str) -> impl Iterator<Item = &'a Element> {
        self.elements.iter().filter(move |element| element.bearing == bearing)
    }

    /// Returns true if the residual over the load is at most [`LARGEST_RESIDUAL`].
    #[must_use]
    pub fn is_in_equilibrium(&self) -> bool {
        self.residual <= LARGEST_RESIDUAL
    }

    /// Returns the directions in which nothing has a stiffness: along `X`, `Y`, `Z`, about `X`, `Y`.
    #[must_use]
    pub fn unsupported(&self) -> Vec<&'static str> {
        let names = ["along X", "along Y", "along Z", "about X", "about Y"];
        names.into_iter().enumerate().filter(|(i, _)| self.stiffness[*i][*i] == 0.0).map(|(_, name)| name).collect()
    }
}

/// Equilibrium of one bearing.
#[derive(Debug, Clone, Serialize)]
pub struct BearingEquilibrium {
    /// Name in the scene.
    pub name: String,
    /// Displacement of the inner ring against the outer ring, with the preload.
    pub displacement: [f64; 5],
    /// Force on the inner ring, N and N m.
    pub force: [f64; 5],
    /// Tangent stiffness.
    pub stiffness: [[f64; 5]; 5],
    /// `cage_ratio` of the scene, where it has one.
    pub cage_ratio: Option<f64>,
    /// Contact angles; `None` without a geometry.
    pub contact_angle: Option<ContactAngle>,
    /// Orders of the bearing that every command uses: from the scene's `cage_ratio`, else by rolling at the free contact
    /// angle; `None` if neither is given.
    pub orders: Option<BearingOrders>,
    /// Orders by rolling at the mean contact angle under this load; `None` if no contact angle is known.
    pub orders_under_load: Option<BearingOrders>,
    /// Permissible static contact pressure of ISO 76, Pa; `None` where the contact is not known.
    pub pressure_limit: Option<f64>,
    /// Operating clearance; `None` without `fit` and `temperatures`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operating_clearance: Option<ClearanceOutcome>,
    /// Load ratings and life; `None` where the contact is not known.
    pub life: Option<BearingLife>,
    /// Friction; `None` without `lubrication` in the scene or where the contact is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<BearingFriction>,
    /// Temperatures that friction and cooling keep; `None` where they were not sought.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperatures: Option<BearingTemperatures>,
}

/// Contact angles of a bearing, rad, 0 or more.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ContactAngle {
    /// Free contact angle: `contact_angle` of the scene, or `cos(free) = 1 - s/(2 A)` from the diametral clearance `s` and
    /// the groove distance `A`. The cage speed and the orders use it.
    pub free: f64,
    /// Mean of the angles at the inner and outer contacts under this load, weighted by their loads.
    pub loaded: Option<f64>,
}

/// Change of the equilibrium when one effect is switched off.
#[derive(Debug, Clone, Serialize)]
pub struct EffectShare {
    /// Name of the effect: `centrifugal`, `gyroscopic` or `film`.
    pub effect: String,
    /// Change of displacement, m and rad.
    pub displacement: [f64; 5],
    /// Relative change of the diagonal of the stiffness.
    pub stiffness: [f64; 5],
    /// Relative change of the largest load on an element.
    pub largest_load: f64,
}

/// Computes the static equilibrium of the scene's rotor, or of one of its bearings under a load (N, N m) on the inner ring.
///
/// # Errors
/// Returns an error if there is no load or the scene lacks a value.
pub fn static_equilibrium(scene: &Scene, bearing: Option<&str>, load: Option<[f64; 5]>) -> Result<StaticEquilibrium> {
    let mut whole = settled(scene, bearing, load)?;
    for (effect, off) in EFFECTS {
        let mut without = scene.clone();
        let named = without.bearings.iter_mut().fold(false, |named, b| off(&mut b.effects) | named);
        if named {
            whole.effects.push(share(effect, &whole, &settled(&without, bearing, load)?));
        }
    }
    Ok(whole)
}

/// Computes the static equilibrium without the share of each effect.
///
/// # Errors
/// As [`static_equilibrium`].
pub(crate) fn settled(scene: &Scene, bearing: Option<&str>, load: Option<[f64; 5]>) -> Result<StaticEquilibrium> {
    let alone = (scene.rotor.is_none() && scene.system.is_none()) || bearing.is_some() || load.is_some();
    if alone { bearing_equilibrium(scene, bearing, load) } else { rotor_equilibrium(scene) }
}

/// Function that switches an effect off and returns true if it was on.
type Switch = fn(&mut Effects) -> bool;

const EFFECTS: [(&str, Switch); 3] = [
    ("centrifugal", |e| std::mem::replace(&mut e.centrifugal, false)),
    ("gyroscopic", |e| std::mem::replace(&mut e.gyroscopic, false)),
    ("film", |e| e.film.take().is_some()),
];

fn share(effect: &str, with: &StaticEquilibrium, without: &StaticEquilibrium) -> EffectShare {
    let largest = |s: &StaticEquilibrium| s.elements.iter().map(|e| e.inner_load.max(e.outer_load)).fold(0.0, f64::max);
    EffectShare {
        effect: effect.to_owned(),
        displacement: std::array::from_fn(|i| without.displacement[i] - with.displacement[i]),
        stiffness: std::array::from_fn(|i| without.stiffness[i][i] / with.stiffness[i][i] - 1.0),
        largest_load: largest(without) / largest(with) - 1.0,
    }
}

fn bearing_equilibrium(scene: &Scene, name: Option<&str>, load: Option<[f64; 5]>) -> Result<StaticEquilibrium> {
    let of = build::pick(scene, name)?;
    let built = build::bearing(scene, of, of.model)?;
    let at = resting(scene, of)?;
    let begun = Instant::now();
    let (u, residual) = match (load, of.preload) {
        (None, Some(_)) if !of.has_constant_preload_force() => {
            (build::mounted_offset(scene, of, &built)?.unwrap_or_default(), 0.0)
        }
        (load, preload) => {
            let force = match preload.map(|preload| preload.amount) {
                Some(PreloadAmount::Force(_)) => build::preload_force(scene, of)?,
                _ => None,
            };
            let Some(total) = total_load(of, load, force) else {
                return Err(NoLoad { file: scene.path.clone(), bearing: of.name.clone() }.into());
            };
            let rest = build::loaded(&built, total, &at)?;
            (rest.displacement(), rest.residual)
        }
    };
    let solving_seconds = begun.elapsed().as_secs_f64();
    let solved = BearingElements::try_new(scene, of, &built)?;
    let elements = solved.at(&u, &at);
    let one = equilibrium_of_bearing(&of.name, &built, &u, &u, &at).with_kinematics(scene, of, &elements)?;
    let one = one.with_life(of, &solved, &u, &at)?;
    // The displacement contains the preload.
    let alone = BearingScene { preload: None, outer_ring_tilt: [0.0; 2], ..of.clone() };
    let significance = effect_significance::of_bearing(scene, &alone, &u, &at)?;
    Ok(StaticEquilibrium {
        scene: scene.name.clone(),
        speed: at.inner_speed,
        displacement: one.displacement,
        force: one.force,
        stiffness: one.stiffness,
        elements,
        rotor: None,
        drawing: None,
        natural_frequencies_hz: vec![],
        mode_shapes: vec![],
        bearings: vec![one],
        residual,
        solving_seconds,
        effects: vec![],
        significance,
    })
}

/// Returns the sum of the load and the preload force; `None` if neither is given.
fn total_load(of: &BearingScene, load: Option<[f64; 5]>, preload_force: Option<f64>) -> Option<[f64; 5]> {
    let sign = if of.facing == ballrace_scene::Facing::MinusZ { -1.0 } else { 1.0 };
    match (load, preload_force) {
        (load, Some(force)) => {
            let mut total = load.unwrap_or_default();
            total[2] += sign * force;
            Some(total)
        }
        (load, _) => load,
    }
}

pub(crate) fn resting(scene: &Scene, of: &BearingScene) -> Result<BearingKinematicState<f64>> {
    let at = build::rotation_at(scene, of, 0.0)?;
    Ok(BearingKinematicState { inner_speed: scene.shaft.speed.nominal(), ..at })
}

fn rows<S: nalgebra::RawStorage<f64, R, C>, R: nalgebra::Dim, C: nalgebra::Dim>(
    k: &nalgebra::Matrix<f64, R, C, S>,
) -> [[f64; 5]; 5] {
    std::array::from_fn(|i| std::array::from_fn(|j| k.get((i, j)).copied().unwrap_or(0.0)))
}

/// Returns the equilibrium of `bearing`, which reacts to the displacement `moved`; `total` contains the preload.
fn equilibrium_of_bearing(
    name: &str,
    bearing: &AnyBearing<f64>,
    moved: &Displacement<f64>,
    total: &Displacement<f64>,
    at: &BearingKinematicState<f64>,
) -> BearingEquilibrium {
    let (reaction, k) = bearing.reaction_and_stiffness(moved, at);
    BearingEquilibrium {
        name: name.to_owned(),
        displacement: total.to_array(),
        force: reaction.wrench.to_array(),
        stiffness: rows(&k),
        cage_ratio: None,
        contact_angle: None,
        orders: None,
        orders_under_load: None,
        pressure_limit: None,
        operating_clearance: None,
        life: None,
        friction: None,
        temperatures: None,
    }
}

impl BearingEquilibrium {
    /// Adds load ratings, life and friction; `u` is the displacement with the preload.
    fn with_life(
        self,
        of: &BearingScene,
        elements: &BearingElements,
        u: &Displacement<f64>,
        at: &BearingKinematicState<f64>,
    ) -> Result<Self> {
        let turned = (0..CAGE_POSITIONS).map(|i| {
            let part = f64::from(i) / f64::from(CAGE_POSITIONS) / of.elements.max(1) as f64;
            let cage = at.cage.wrapping_add(Phase::from_revolutions(part));
            elements.at(u, &BearingKinematicState { cage, ..*at })
        });
        let turned: Vec<Vec<Element>> = turned.collect();
        let loads: Vec<ElementLoads> = turned.iter().flatten().map(Element::loads).collect();
        let speeds = [at.inner_speed, at.outer_speed];
        let life = BearingLife::of(of, &loads, &self.force, speeds)?;
        let balls: Vec<BallContacts> = turned.iter().take(1).flatten().filter_map(Element::contacts).collect();
        let friction = BearingFriction::of(of, &balls, &self.force, life.as_ref(), speeds)?;
        Ok(Self { life, friction, ..self })
    }

    /// Adds contact angles, orders and the limit of pressure; `elements` are those of this bearing.
    fn with_kinematics(self, scene: &Scene, of: &BearingScene, elements: &[Element]) -> Result<Self> {
        let orders = |kinematics: &Kinematics| {
            let Kinematics { orders: o, spin_known, .. } = kinematics;
            let ball_spin = spin_known.then_some(o.ball_spin);
            let orders = BearingOrders { cage: o.cage, outer_race: o.outer_race, inner_race: o.inner_race, ball_spin };
            (o.cage != 0.0).then_some(orders)
        };
        let geometry = build::geometry(of)?;
        let contact_angle =
            geometry.map(|g| ContactAngle { free: g.contact_angle, loaded: mean_contact_angle(elements) });
        let loaded = geometry.zip(contact_angle.and_then(|angle| angle.loaded));
        let rolling = BearingScene { cage_ratio: None, ..of.clone() };
        let under_load = |(g, contact_angle): (BallBearingGeometry, f64)| {
            build::kinematics_of(scene, &rolling, Some(BallBearingGeometry { contact_angle, ..g }))
        };
        Ok(Self {
            operating_clearance: of.mounting.map(|mounting| mounting.operating().into()),
            cage_ratio: of.cage_ratio,
            contact_angle,
            pressure_limit: ElementContact::of(of)?.map(|contact| contact.limit()),
            orders: orders(&build::kinematics(scene, of)?),
            orders_under_load: loaded.map(under_load).transpose()?.as_ref().and_then(orders),
            ..self
        })
    }
}

/// Returns the mean size of the contact angles, weighted by the loads of the contacts; `None` if no contact with an angle
/// is loaded.
fn mean_contact_angle(elements: &[Element]) -> Option<f64> {
    let contacts = elements.iter().flat_map(|e| [(e.inner_load, e.inner_angle), (e.outer_load, e.outer_angle)]);
    let (sum, load) = contacts
        .filter_map(|(load, angle)| angle.map(|angle| (load, angle.abs())))
        .fold((0.0, 0.0), |(sum, all), (load, angle)| (sum + load * angle, all + load));
    (load > 0.0).then(|| sum / load)
}

fn rotor_equilibrium(scene: &Scene) -> Result<StaticEquilibrium> {
    let begun = Instant::now();
    let plant = Plant::try_new(scene)?;
    let solving_seconds = begun.elapsed().as_secs_f64();
    let speed = scene.shaft.speed.nominal();
    let (mut bearings, mut all) = (Vec::new(), Vec::new());
    let mut force = [0.0; 5];
    for (i, (of, mounted)) in scene.bearings.iter().zip(&plant.bearings).enumerate() {
        let at = plant.resting(mounted, Phase::ZERO);
        let (moved, total) = displacements(&plant, i);
        let one = equilibrium_of_bearing(&mounted.name, &mounted.bearing, &moved, &total, &at);
        let wrench = ballrace::Wrench::from_array(one.force).from_station(mounted.station).to_array();
        for (sum, f) in force.iter_mut().zip(wrench) {
            *sum += f;
        }
        let plain = build::bearing(scene, of, of.evaluated_model())?;
        let solved = BearingElements::try_new(scene, of, &plain)?;
        let elements = solved.at(&total, &at);
        bearings.push(one.with_kinematics(scene, of, &elements)?.with_life(of, &solved, &total, &at)?);
        all.extend(elements);
    }
    Ok(StaticEquilibrium {
        scene: scene.name.clone(),
        speed,
        displacement: plant.pose(&plant.rest).to_array(),
        force,
        stiffness: rows(&plant.stiffness),
        elements: all,
        rotor: plant.rotor_outcome(scene),
        drawing: RotorDrawing::new(scene),
        natural_frequencies_hz: modes(&plant, speed, false)?.iter().map(|mode| mode.frequency_hz).collect(),
        mode_shapes: mode_shapes(scene, &plant, speed)?,
        bearings,
        residual: plant.residual,
        solving_seconds,
        effects: vec![],
        significance: effect_significance::at_rest(scene, &plant)?,
    })
}

/// Returns the displacement of a bearing by the rotor, without and with its preload.
fn displacements(plant: &Plant, i: usize) -> (Displacement<f64>, Displacement<f64>) {
    let moved = plant.displacement(i, &plant.rest);
    (moved, moved + plant.bearings.get(i).map_or_else(Displacement::default, |s| s.offset))
}
