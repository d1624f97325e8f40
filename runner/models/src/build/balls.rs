//! Models with balls in equilibrium: solved ball by ball, and tabulated.

use super::service_load::approach_in_service;
use super::{
    BuildError, Shared, blocked_places, contact_geometry, facing, features, named, outer_ratio, places, uneven,
};
use crate::handle::BearingHandle;
use crate::simd::OnWideRegisters;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::film::{Film, InletHeating, Lubricant};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, Inertia, InertiaParams, RaceControl};
use ballrace::bearing::quasi_static::{BallPosition, BallState, DEFAULT_NEWTON_STEPS, QuasiStatic, TableConstants};
use ballrace::bearing::surface::{Surface, SurfaceDeviation};
use ballrace::bearing::tabulated::{Grid, Table, TableDomain, Tabulated, fill_table};
use ballrace::bearing::{Bearing, ElementLayout, ElementPosition, Mirrored, Reaction};
use ballrace::contact::hertz::Race;
use ballrace::contact::line::roller_stiffness;
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase, Scalar};
use ballrace_scene::{Bearing as BearingScene, Facing, Scene, Speed};
use std::f64::consts::PI;
use std::sync::Arc;

/// Returns the parameters of the balls' inertia.
#[must_use]
pub fn inertia_params(scene: &BearingScene) -> InertiaParams {
    InertiaParams {
        density: scene.geometry.map_or(0.0, |g| g.density),
        centrifugal: scene.effects.centrifugal,
        gyroscopic: scene.effects.gyroscopic,
        race_control: match scene.effects.control {
            ballrace_scene::RaceControl::Outer => RaceControl::Outer,
            ballrace_scene::RaceControl::Inner => RaceControl::Inner,
        },
        friction_sharing: match scene.effects.sharing {
            ballrace_scene::FrictionSharing::Outer => FrictionSharing::Outer,
            ballrace_scene::FrictionSharing::Equal => FrictionSharing::Equal,
            ballrace_scene::FrictionSharing::Proportional => FrictionSharing::Proportional,
        },
    }
}

/// A quasi-static bearing with any of its effects, and its internal states.
pub trait Solved<T: Scalar>: Bearing<T> {
    /// Writes the state of each ball, up to the length of `states`.
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]);

    /// Sets the balls to the positions of a cold start.
    fn initial_ball_positions(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, balls: &mut [BallPosition<T>]);

    /// Returns the reaction, with the solution started from the balls' last positions.
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T>;
}

impl<T, M, P, I, F, S> Solved<T> for QuasiStatic<T, M, P, I, F, S>
where
    T: Scalar,
    M: Math<T>,
    P: ElementLayout<T>,
    I: Inertia<T>,
    F: Film<T>,
    S: Surface<T>,
{
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        QuasiStatic::ball_states(self, u, at, states);
    }
    fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        QuasiStatic::initial_ball_positions(self, u, at, balls);
    }
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        QuasiStatic::warm_started_reaction(self, u, at, balls)
    }
}

impl<T: Scalar> Solved<T> for Mirrored<Shared<dyn Solved<T>>> {
    fn ball_states(&self, u: &Displacement<T>, at: &BearingKinematicState<T>, states: &mut [BallState<T>]) {
        self.0.0.ball_states(&u.mirrored(), &at.reversed(), states);
        // Angles count towards +Z of the scene.
        for state in states {
            let turned = |[cos, sin]: [T; 2]| [cos, -sin];
            state.inner_direction = turned(state.inner_direction);
            state.outer_direction = turned(state.outer_direction);
            state.orbital_speed = -state.orbital_speed;
        }
    }
    fn initial_ball_positions(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) {
        self.0.0.initial_ball_positions(&u.mirrored(), &at.reversed(), balls);
    }
    fn warm_started_reaction(
        &self,
        u: &Displacement<T>,
        at: &BearingKinematicState<T>,
        balls: &mut [BallPosition<T>],
    ) -> Reaction<T> {
        let local = self.0.0.warm_started_reaction(&u.mirrored(), &at.reversed(), balls);
        Reaction { wrench: local.wrench.mirrored(), ..local }
    }
}

/// Builds the quasi-static model of one bearing.
///
/// # Errors
/// Returns an error if the scene lacks a value of this model or the kernel rejects one.
pub fn quasi_static(scene: &BearingScene) -> Result<Arc<dyn Solved<f64>>, BuildError> {
    solved_in(scene, steps(scene))
}

/// Builds the quasi-static model with another number of Newton steps.
///
/// # Errors
/// As [`quasi_static`].
pub fn solved_in(scene: &BearingScene, steps: u8) -> Result<Arc<dyn Solved<f64>>, BuildError> {
    let built: Arc<dyn Solved<f64>> = Arc::new(unmirrored::<f64, OnWideRegisters<Exact>>(scene, steps)?);
    Ok(if scene.facing == Facing::MinusZ { Arc::new(Mirrored(Shared(built))) } else { built })
}

pub(super) fn quasi_static_bearing<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    scene: &BearingScene,
) -> Result<H, BuildError> {
    Ok(facing(scene, H::new(unmirrored::<T, H::Registers<M>>(scene, steps(scene))?)))
}

fn steps(scene: &BearingScene) -> u8 {
    scene.solver_steps.unwrap_or(DEFAULT_NEWTON_STEPS)
}

/// Returns the quasi-static model, facing +Z.
fn unmirrored<T: Scalar, M: Math<T>>(scene: &BearingScene, steps: u8) -> Result<impl Solved<T> + 'static, BuildError> {
    let (geometry, zero) = contact_geometry(scene, "quasi-static")?;
    let built = QuasiStatic::<T, M, _>::try_new(geometry, places(scene), zero)
        .and_then(|b| b.with_selected_inertia(&inertia_params(scene)))
        .and_then(|b| b.with_selected_film(lubricant(scene)))
        .map_err(|e| named(scene, e))?;
    let surface = SurfaceDeviation::<M, _>::new(features(scene));
    Ok(built.with_newton_steps(steps).with_surface(surface))
}

fn lubricant(scene: &BearingScene) -> Option<(Lubricant, Option<InletHeating>)> {
    let oil = scene.effects.film?;
    Some((oil.for_film(), oil.inlet_heating.map(ballrace_scene::InletHeating::of_film)))
}

/// Table of a bearing.
pub struct TableData {
    /// True where the speed axis is that of the outer ring.
    pub by_outer: bool,
    /// Grid of the nodes.
    pub grid: Grid<f64>,
    /// Nodes; the third number is the friction, where the inner contact has one.
    pub nodes: Vec<[f64; 3]>,
    /// Constants of the bearing.
    pub constants: TableConstants<f64>,
    /// True where the third number is used.
    pub friction: bool,
}

impl TableData {
    /// Returns the numbers of each node that are used.
    #[must_use]
    pub const fn fields(&self) -> usize {
        numbers(self.friction)
    }
}

/// Returns the numbers of a node.
const fn numbers(friction: bool) -> usize {
    if friction { 3 } else { 2 }
}

/// Returns true where the inner contact has friction.
fn has_inner_friction(of: &BearingScene) -> bool {
    of.effects.gyroscopic && of.effects.sharing != ballrace_scene::FrictionSharing::Outer
}

/// Size of a table whose intervals the scene does not state.
#[derive(Debug, Clone, Copy)]
pub struct TableSize {
    /// Largest size in `f32`.
    pub bytes: usize,
    /// Intervals along a speed that changes.
    over_speeds: usize,
}

/// Size of a table on the desktop.
pub const DESKTOP_TABLE: TableSize = TableSize { bytes: 64 << 10, over_speeds: 12 };
/// Size of a table in firmware.
pub const FIRMWARE_TABLE: TableSize = TableSize { bytes: 32 << 10, over_speeds: 8 };

/// Samples the quasi-static model of one bearing.
///
/// # Errors
/// As [`quasi_static`], and a table with states without equilibrium.
pub fn table(scene: &Scene, of: &BearingScene, size: TableSize) -> Result<TableData, BuildError> {
    let (geometry, zero) = contact_geometry(of, "tabulated")?;
    let (domain, by_outer) = domain(scene, of, &geometry, size)?;
    let one = [ElementPosition::from_azimuth(Phase::ZERO)];
    let plain =
        QuasiStatic::<f64, OnWideRegisters<Exact>, _>::try_new(geometry, one, zero).map_err(|e| named(of, e))?;
    let constants = plain.table_constants();
    let grid = domain.grid(constants.distance).map_err(|e| named(of, e))?;
    let mut nodes = vec![[0.0; 3]; grid.len()];
    let full = plain
        .with_selected_inertia(&inertia_params(of))
        .and_then(|b| b.with_selected_film(lubricant(of)))
        .map_err(|e| named(of, e))?;
    let open = fill_table(&full, &domain, &grid, &mut nodes);
    if open > 0 {
        return Err(BuildError::Table {
            file: scene.path.clone(),
            bearing: of.name.clone(),
            found: open,
            states: grid.len(),
        });
    }
    Ok(TableData { by_outer, grid, nodes, constants, friction: has_inner_friction(of) })
}

/// Returns the load of a Hertzian point contact, N: `Q = K delta^1.5`, 0 without contact.
#[must_use]
pub fn point_contact_load(stiffness: f64, approach: f64) -> f64 {
    stiffness * approach.max(0.0).powf(1.5)
}

/// Returns the approach of a Hertzian point contact under `load`, m: `delta = (Q / K)^(2/3)`.
#[must_use]
pub fn point_contact_approach(stiffness: f64, load: f64) -> f64 {
    (load / stiffness).powf(2.0 / 3.0)
}

/// Permissible static contact pressure of ball bearings, Pa (ISO 76); the default upper limit of a table.
const PRESSURE_LIMIT: f64 = 4.2e9;
/// Permissible static contact pressure of roller bearings, Pa (ISO 76).
const ROLLER_PRESSURE_LIMIT: f64 = 4.0e9;
/// Young's modulus (Pa) and Poisson's ratio of the rollers of the catalogue.
const ROLLER_STEEL: [f64; 2] = [206e9, 0.3];

/// Contact of an element with its races, from which pressures follow.
#[derive(Debug, Clone, Copy)]
pub enum ElementContact {
    /// Hertzian point contact of a ball.
    Ball(BallBearingGeometry),
    /// Hertzian line contact of a cylindrical roller.
    Roller {
        /// Effective length, m.
        length: f64,
        /// Radius of roller and inner race together, and of roller and outer race, m.
        radius: [f64; 2],
    },
}

impl ElementContact {
    /// Returns the contact of balls with a geometry, and of the rollers of the catalogue with the length that their stiffness has by
    /// [`roller_stiffness`]; none where the contact is not known.
    ///
    /// # Errors
    /// A bearing geometry that the kernel rejects.
    pub fn of(of: &BearingScene) -> Result<Option<Self>, BuildError> {
        if let Some(geometry) = super::geometry(of)? {
            return Ok(Some(Self::Ball(geometry)));
        }
        let entry = of.catalogue.as_ref().map(|catalogue| catalogue.listed.entry);
        let stiffness = of.law.and_then(|law| law.stiffness);
        let (Some(entry), Some(stiffness)) = (entry, stiffness) else { return Ok(None) };
        let length = (stiffness / roller_stiffness(1.0)).powf(9.0 / 8.0);
        let [roller, pitch] = [entry.element_diameter, entry.pitch_diameter].map(|diameter| diameter * 1e-3);
        let radius = [1.0 / (2.0 / roller + 2.0 / (pitch - roller)), 1.0 / (2.0 / roller - 2.0 / (pitch + roller))];
        Ok(Some(Self::Roller { length, radius }))
    }

    /// Returns the permissible static contact pressure of ISO 76, Pa.
    #[must_use]
    pub const fn limit(&self) -> f64 {
        match self {
            Self::Ball(_) => PRESSURE_LIMIT,
            Self::Roller { .. } => ROLLER_PRESSURE_LIMIT,
        }
    }

    /// Returns the peak pressure at a race under the load of an element (N), Pa; 0 without load.
    #[must_use]
    pub fn pressure(&self, race: Race, load: f64) -> f64 {
        if load <= 0.0 {
            return 0.0;
        }
        match self {
            Self::Ball(geometry) => geometry.contact(race).ellipse(load).2,
            Self::Roller { length, radius: [inner, outer] } => {
                let radius = match race {
                    Race::Inner => inner,
                    Race::Outer => outer,
                };
                let [youngs_modulus, poissons_ratio] = ROLLER_STEEL;
                let modulus = youngs_modulus / (2.0 * (1.0 - poissons_ratio * poissons_ratio));
                // A Hertzian line contact: p^2 = Q E / (pi l R).
                (load * modulus / (PI * length * radius)).sqrt()
            }
        }
    }

    /// Returns the load on an element at the permissible pressure, N; the inner race has the higher pressure.
    #[must_use]
    pub fn load_limit(&self) -> f64 {
        let ratio = self.limit() / self.pressure(Race::Inner, 1.0);
        match self {
            // The pressure grows with the third root of the load, in a line contact with the square root.
            Self::Ball(_) => ratio.powi(3),
            Self::Roller { .. } => ratio.powi(2),
        }
    }
}

/// Returns the load on an element at the permissible static contact pressure of ISO 76, N; none where the contact is not known.
///
/// # Errors
/// A bearing geometry that the kernel rejects.
pub fn static_limit(of: &BearingScene) -> Result<Option<f64>, BuildError> {
    Ok(ElementContact::of(of)?.map(|contact| contact.load_limit()))
}

/// Contact angles to either side of the free one, rad.
const TABLE_ANGLES: f64 = 0.4;
/// Squares of the speeds about a constant one; inertia loads are linear in the square, and the constant speed is a node.
const TABLE_SPEEDS_SQUARED: [f64; 2] = [0.64, 1.36];
/// Range of speeds of a table that does not depend on them, rad/s.
const EVERY_SPEED: [f64; 2] = [0.0, 1e9];
/// Scale of a wide range of speeds over the highest, with an oil film: its thickness rises with a power of the speed below 1, inertia
/// loads with the square.
const SPEEDS_WITH_FILM: f64 = 10.0;
/// Intervals along the angle of a bearing with a contact angle, over which its forces change evenly: at a constant speed, and over a
/// range, where the other coordinates need the nodes.
const ANGLE_INTERVALS: [usize; 2] = [12, 8];
/// Intervals along the angle of a deep-groove bearing over those along the approach.
const GROOVE_ANGLE_INTERVALS: f64 = 0.85;
/// Least and largest number of intervals along approach and angle.
const INTERVALS: [usize; 2] = [4, 64];
/// Nodes along approach and angle beyond the number of intervals.
const FURTHER_NODES: usize = 3;
/// Least approach in service over the largest approach: a rotor without weight and load still moves.
const LEAST_SCALE: f64 = 0.02;
/// Load of a ball in service over that at the static pressure limit, where the scene states no load.
const TYPICAL_LOAD: f64 = 0.05;

/// Returns the range of a bearing's table: the scene's, else up to the static pressure limit, about free angle and speed.
///
/// The intervals are the scene's, else as many as `size` allows.
fn domain(
    scene: &Scene,
    of: &BearingScene,
    geometry: &BallBearingGeometry,
    size: TableSize,
) -> Result<(TableDomain, bool), BuildError> {
    let given = of.table.unwrap_or_default();
    let contact = geometry.contact(Race::Inner);
    let (_, _, pressure) = contact.ellipse(1.0);
    let load = (PRESSURE_LIMIT / pressure).powi(3);
    let most = point_contact_approach(geometry.stiffness(), load);
    let both = of.facing == Facing::Both;
    let free = if both { [0.0, geometry.contact_angle] } else { [geometry.contact_angle; 2] };
    let widest = if both { free[1] + TABLE_ANGLES } else { TABLE_ANGLES };
    let angles = [(free[0] - widest).max(-1.3), (free[1] + TABLE_ANGLES).min(1.3)];
    let (inner, outer) = (scene.shaft.speed, scene.shaft.outer_speed);
    let about = |speed: f64| TABLE_SPEEDS_SQUARED.map(|part| part.sqrt() * speed.abs());
    let by_outer = inner == Speed::Constant(0.0) && outer != 0.0;
    let speeds = match inner {
        _ if by_outer => about(outer),
        Speed::Constant(speed) => about(speed),
        Speed::Ramp { from, to, .. } => [from.abs().min(to.abs()), from.abs().max(to.abs())],
        Speed::Fluctuating { mean, fluctuation, .. } => [1.0 - fluctuation, 1.0 + fluctuation].map(|p| p * mean.abs()),
    };
    let turning = if by_outer { [0.0, 1.0] } else { [1.0, outer_ratio(scene)?] };
    // Without inertia and film the table does not depend on the speed.
    let still = of.effects == ballrace_scene::Effects::default();
    let speed = if still { EVERY_SPEED } else { given.speed.unwrap_or(speeds) };
    let narrow = matches!(inner, Speed::Constant(_)) && given.speed.is_none();
    let layers = match (still || speed[0] == speed[1], narrow) {
        (true, _) => 0,
        (_, true) if both => 2,
        (_, true) => 4,
        (_, false) => size.over_speeds,
    };
    let intervals = match given.intervals {
        Some([nx, na, nv]) => [nx, na, if layers == 0 { 0 } else { nv }],
        None => {
            let nodes = size.bytes / (size_of::<f32>() * numbers(has_inner_friction(of))) / (layers + 1);
            let [nx, na] = if both { groove_resolution(nodes) } else { resolution(nodes, narrow || still) };
            [nx, na, layers]
        }
    };
    let in_service = approach_in_service(scene, of, geometry);
    let domain = TableDomain {
        approach: given.approach.unwrap_or([-0.5 * most, most]),
        scale: in_service
            .unwrap_or_else(|| point_contact_approach(geometry.stiffness(), TYPICAL_LOAD * load))
            .clamp(LEAST_SCALE * most, most),
        angle: given.angle.unwrap_or(angles),
        speed,
        speed_scale: if of.effects.film.is_some() && !narrow { SPEEDS_WITH_FILM * speed[1] } else { 0.0 },
        speed_ratios: turning,
        intervals,
    };
    Ok((domain, by_outer))
}

/// Returns the intervals along approach and angle of a layer of at most `nodes` nodes, for a bearing with a contact angle.
fn resolution(nodes: usize, at_one_speed: bool) -> [usize; 2] {
    let ([least, most], [at_one, over_range]) = (INTERVALS, ANGLE_INTERVALS);
    let across = if at_one_speed { at_one } else { over_range };
    let along = (nodes / (across + FURTHER_NODES)).saturating_sub(FURTHER_NODES);
    [along.clamp(least, most), across]
}

/// Returns the same for a deep-groove bearing. Its balls change sides in the plane of the grooves, where an even number puts nodes.
fn groove_resolution(nodes: usize) -> [usize; 2] {
    let [least, most] = INTERVALS;
    let pair = |along: usize| [along, ((GROOVE_ANGLE_INTERVALS * along as f64) as usize & !1).max(least)];
    let fits = |[along, across]: &[usize; 2]| (along + FURTHER_NODES) * (across + FURTHER_NODES) <= nodes;
    (least..=most).rev().map(pair).find(fits).unwrap_or([least; 2])
}

pub(super) fn tabulated<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    scene: &Scene,
    of: &BearingScene,
) -> Result<H, BuildError> {
    of_table::<T, M, H>(of, &table(scene, of, DESKTOP_TABLE)?)
}

/// Builds the tabulated model from its table.
///
/// # Errors
/// None with a table of this bearing.
pub fn of_table<T: Scalar, M: Math<T>, H: BearingHandle<T>>(
    of: &BearingScene,
    made: &TableData,
) -> Result<H, BuildError> {
    // Four numbers per node, the last of them 0: one 256-bit register.
    if made.friction { looked_up::<T, M, H, 4>(of, made) } else { looked_up::<T, M, H, 2>(of, made) }
}

fn looked_up<T: Scalar, M: Math<T>, H: BearingHandle<T>, const F: usize>(
    of: &BearingScene,
    made: &TableData,
) -> Result<H, BuildError> {
    let round = |node: &[f64; 3]| std::array::from_fn(|i| T::from_f64(node.get(i).copied().unwrap_or_default()));
    let nodes: Vec<[T; F]> = made.nodes.iter().map(round).collect();
    let table = Table::new(made.grid.rounded::<T>(), nodes);
    let bearing = Tabulated::<T, M, _, _, F>::new(blocked_places(of), made.constants.rounded(), table, made.by_outer);
    Ok(match uneven::<T, M>(of) {
        None => facing(of, H::dispatched(bearing)),
        Some(surface) => facing(of, H::dispatched(bearing.with_surface(surface))),
    })
}
