//! Scene -> kernel: the one place that knows both.

use super::{
    Axial, Bearing as BearingScene, DefectShape, Facing, Fit, Linear, Model, Preload, Rotor, Scene, Speed, Surface,
};
use anyhow::{Context, Result, bail};
use ballrace::bearing::angular::{Angular, Zero};
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::geometry::{BallBearingGeometry, InvalidParameter};
use ballrace::bearing::kinematics::{Orders, orders};
use ballrace::bearing::linear::{Linear as LinearBearing, two_spring_ball};
use ballrace::bearing::lumped::{self, Combined};
use ballrace::bearing::quasi_static::film::{Dry, Film, Lubricant};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, Inertia, InertiaParams, RaceControl};
use ballrace::bearing::quasi_static::{BallState, QuasiStatic, TableSeat};
use ballrace::bearing::surface::{self, Direction, Feature, Part, Spall, SpallShape, Uneven, Wave};
use ballrace::bearing::tabulated::{Domain, Grid, Table, Tabulated, fill};
use ballrace::bearing::{Arrangement, Bearing, InCage, Mirrored, Place, Reaction};
use ballrace::contact::hertz::{Material, Race};
use ballrace::contact::law::{Law, Line, Point, Power};
use ballrace::rotor::{
    Equilibrium, Gear, Machine, Mounted, PartAngles, RigidRotor, RotorParams, Unbalance, equilibrium, solve,
};
use ballrace::{Displacement, Math, Rotation, Scalar, Stiffness, Turn, Wrench};
use std::sync::Arc;

/// Any rung behind one pointer: how the runner holds bearings whose kind it learns at run time.
#[derive(Clone)]
pub struct AnyBearing<T>(pub Arc<dyn Bearing<T>>);

impl<T: Scalar> Bearing<T> for AnyBearing<T> {
    fn reaction(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &Rotation<T>) -> (Reaction<T>, Stiffness<T>) {
        self.0.reaction_and_stiffness(u, at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
        self.0.element_loads(u, at, loads);
    }
}

/// How the elements of a bearing go round.
#[derive(Debug, Clone, Copy)]
pub struct Kinematics {
    /// Cage speed over shaft speed; 0 where nothing moves.
    pub cage_ratio: f64,
    /// Orders per turn of the shaft.
    pub orders: Orders,
    /// Whether the ball-spin order is known (it needs the geometry).
    pub spin_known: bool,
    /// Outer ring's speed over shaft speed.
    pub outer_ratio: f64,
}

impl Kinematics {
    /// How the kernel's rotor follows the shaft; balls and outer ring only where they turn.
    #[must_use]
    pub fn gear(&self) -> Gear<f64> {
        let gear = Gear::new(self.cage_ratio);
        let gear = if self.spin_known { gear.with_ball(self.ball_ratio()) } else { gear };
        if self.outer_ratio == 0.0 { gear } else { gear.with_outer(self.outer_ratio) }
    }

    /// Spin of the balls over shaft speed: against the shaft where the inner ring is the faster.
    #[must_use]
    pub fn ball_ratio(&self) -> f64 {
        -self.orders.ball_spin * (1.0 - self.outer_ratio).signum()
    }

    /// Angles of the parts with the shaft at `revolutions` from its angle 0.
    #[must_use]
    pub fn parts_at(&self, revolutions: f64) -> PartAngles {
        let turned = |ratio: f64| Turn::from_revolutions(ratio * revolutions);
        PartAngles { cage: turned(self.cage_ratio), ball: turned(self.ball_ratio()), outer: turned(self.outer_ratio) }
    }
}

/// Cage ratio and orders of a bearing: from the scene's `cage_ratio`, or by pure rolling from geometry.
///
/// # Errors
/// An outer ring that turns under a shaft whose speed changes: the ratio is then no constant.
pub fn kinematics(scene: &Scene, bearing: &BearingScene) -> Result<Kinematics> {
    let n = bearing.elements as f64;
    let by_geometry =
        geometry(bearing)?.map(|g| orders(bearing.elements, g.gamma(), g.ball_diameter / g.pitch_diameter));
    let spin = by_geometry.map(|o| o.ball_spin);
    let rolling = by_geometry.map(|o| o.cage).unwrap_or(0.0);
    let outer = outer_ratio(scene)?;
    // Harris: w_c = [w_i (1 - gamma) + w_o (1 + gamma)]/2, here over w_i.
    let cage_ratio = bearing.cage_ratio.unwrap_or(rolling + outer * (1.0 - rolling) * f64::from(rolling > 0.0));
    if cage_ratio.abs() >= 1.0 {
        bail!(
            "{}: bearing {}: found a cage that turns {cage_ratio:.3} times as fast as the shaft, allowed: slower than the shaft",
            scene.path.display(),
            bearing.name
        );
    }
    let orders = Orders {
        cage: cage_ratio,
        outer_race: n * (cage_ratio - outer).abs(),
        inner_race: n * (1.0 - cage_ratio),
        ball_spin: spin.unwrap_or(0.0) * (1.0 - outer).abs(),
    };
    Ok(Kinematics { cage_ratio, orders, spin_known: spin.is_some(), outer_ratio: outer })
}

fn outer_ratio(scene: &Scene) -> Result<f64> {
    match (scene.shaft.outer_speed, scene.shaft.speed) {
        (0.0, _) => Ok(0.0),
        (outer, Speed::Constant(shaft)) if shaft != 0.0 => Ok(outer / shaft),
        _ => bail!(
            "{}: shaft.outer_speed: found {} rad/s with a shaft speed that changes or is 0, allowed: an outer speed only with one constant shaft speed",
            scene.path.display(),
            scene.shaft.outer_speed
        ),
    }
}

/// The kernel's geometry, where the scene gives one.
///
/// # Errors
/// What the kernel refuses.
pub fn geometry(bearing: &BearingScene) -> Result<Option<BallBearingGeometry>> {
    let Some(g) = bearing.geometry else { return Ok(None) };
    let steel = Material { youngs_modulus: g.youngs_modulus, poissons_ratio: g.poissons_ratio };
    let built = BallBearingGeometry {
        ball_diameter: g.ball_diameter,
        pitch_diameter: g.pitch_diameter,
        inner_conformity: g.inner_conformity,
        outer_conformity: g.outer_conformity,
        contact_angle: 0.0,
        ball: steel,
        race: steel,
    };
    let built = match g.fit {
        Fit::ContactAngle(contact_angle) => BallBearingGeometry { contact_angle, ..built },
        Fit::DiametralClearance(s) if s >= 0.0 => built.with_clearance(s).map_err(|e| named(bearing, e))?,
        // An interference fit: the balls sit at the bottom of the grooves.
        Fit::DiametralClearance(_) => built,
    };
    Ok(Some(built.checked().map_err(|e| named(bearing, e))?))
}

fn named(bearing: &BearingScene, error: InvalidParameter) -> anyhow::Error {
    anyhow::anyhow!("bearing {}: {error}", bearing.name)
}

/// The rung `model` of one bearing. A linear rung that is made from another one needs the rotor's equilibrium
/// (see [`crate::replay::twin`]) and is refused here.
///
/// # Errors
/// What the scene does not say for this model, or the kernel refuses.
pub fn bearing<T: Scalar, M: Math<T>>(scene: &Scene, of: &BearingScene, model: Model) -> Result<AnyBearing<T>> {
    match model {
        Model::Linear => linear(of),
        Model::Lumped => lumped::<T, M>(of),
        Model::Angular => angular::<T, M>(of),
        Model::QuasiStatic => Ok(AnyBearing(Arc::new(Unsolved(quasi_static::<T, M>(of)?)))),
        Model::Tabulated => tabulated::<T, M>(scene, of),
    }
}

/// Where the elements stand; mirrored where the bearing faces -Z.
#[must_use]
pub fn places<T: Scalar>(scene: &BearingScene) -> Vec<Place<T>> {
    let first = Turn::from_radians(scene.first_element_azimuth);
    let place = |j| Place::even(first, j, scene.elements);
    let mirror = |p: Place<T>| if scene.facing == Facing::MinusZ { p.mirrored() } else { p };
    (0..scene.elements).map(place).map(mirror).collect()
}

/// Turned about X by pi where the bearing faces -Z.
fn facing<T: Scalar>(scene: &BearingScene, bearing: impl Bearing<T> + 'static) -> AnyBearing<T> {
    if scene.facing == Facing::MinusZ { AnyBearing(Arc::new(Mirrored(bearing))) } else { AnyBearing(Arc::new(bearing)) }
}

/// Waviness and damage as the kernel takes them; any number of either.
#[must_use]
pub fn features<T: Scalar>(scene: &BearingScene) -> Vec<Feature<T>> {
    let waves = scene.waviness.iter().map(|w| {
        Feature::Wave(Wave {
            part: part(scene, w.surface),
            direction: if w.axial { Direction::Axial } else { Direction::Radial },
            order: w.order,
            amplitude: T::from_f64(w.amplitude),
            phase: Turn::from_radians(w.phase),
        })
    });
    let spalls = scene.defect.iter().map(|defect| {
        let shape = match defect.shape {
            DefectShape::HalfSine => SpallShape::HalfSine,
            DefectShape::Rectangular => SpallShape::Rectangular,
        };
        let centre = Turn::from_radians(defect.azimuth);
        let (half_width, depth) = (T::from_f64(defect.half_width), T::from_f64(defect.depth));
        Feature::Spall(Spall::new(part(scene, defect.surface), centre, half_width, depth, shape))
    });
    let mirror = |feature: Feature<T>| if scene.facing == Facing::MinusZ { feature.mirrored() } else { feature };
    waves.chain(spalls).map(mirror).collect()
}

fn part(scene: &BearingScene, surface: Surface) -> Part {
    match surface {
        Surface::Inner => Part::Inner,
        Surface::Outer => Part::Outer,
        Surface::Ball(j) => {
            let first = Turn::from_radians(scene.first_element_azimuth);
            Part::Ball(Place::<f64>::even(first, j, scene.elements).azimuth())
        }
    }
}

/// Surfaces that are round where the scene names nothing.
fn uneven<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Option<Uneven<M, Vec<Feature<T>>>> {
    let features = features(scene);
    (!features.is_empty()).then(|| Uneven::new(features))
}

fn angular<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Result<AnyBearing<T>> {
    let (geometry, zero) = contact_geometry(scene, "angular")?;
    let built = Angular::<T, M, _>::try_new(geometry, places(scene), zero).map_err(|e| named(scene, e))?;
    Ok(match uneven::<T, M>(scene) {
        None => facing(scene, built),
        Some(surface) => facing(scene, built.with_surface(surface)),
    })
}

/// The geometry of a model with a contact angle, and where its rings stand at zero displacement.
fn contact_geometry(scene: &BearingScene, model: &str) -> Result<(BallBearingGeometry, Zero)> {
    let Some(geometry) = geometry(scene)? else {
        bail!(
            "bearing {}: model {model}: found no geometry, allowed: with ball_diameter, pitch_diameter, the conformities and contact_angle or diametral_clearance",
            scene.name
        );
    };
    if let Some(super::Geometry { fit: Fit::DiametralClearance(s), .. }) = scene.geometry
        && s < 0.0
    {
        bail!("bearing {}: diametral_clearance: found {s} m, allowed for model {model}: 0 or more", scene.name);
    }
    Ok((geometry, if scene.facing == Facing::Both { Zero::Centred } else { Zero::Touching }))
}

/// The balls' inertia as the kernel takes it.
#[must_use]
pub fn inertia_params(scene: &BearingScene) -> InertiaParams {
    InertiaParams {
        density: scene.geometry.map_or(0.0, |g| g.density),
        centrifugal: scene.effects.centrifugal,
        gyroscopic: scene.effects.gyroscopic,
        control: match scene.effects.control {
            super::RaceControl::Outer => RaceControl::Outer,
            super::RaceControl::Inner => RaceControl::Inner,
        },
        sharing: match scene.effects.sharing {
            super::FrictionSharing::Outer => FrictionSharing::Outer,
            super::FrictionSharing::Equal => FrictionSharing::Equal,
            super::FrictionSharing::Proportional => FrictionSharing::Proportional,
        },
    }
}

/// A quasi-static bearing with any of its effects, and what it alone can tell.
pub trait Solved<T: Scalar>: Bearing<T> {
    /// What each ball does.
    fn ball_states(&self, u: &Displacement<T>, at: &Rotation<T>) -> Vec<BallState<T>>;
}

/// As [`AnyBearing`], with the balls' states.
pub type AnySolved<T> = Arc<dyn Solved<T>>;

struct SolvedBy<B>(B, usize);

impl<T: Scalar, B: Bearing<T>> Bearing<T> for SolvedBy<B> {
    fn reaction(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &Rotation<T>) -> (Reaction<T>, Stiffness<T>) {
        self.0.reaction_and_stiffness(u, at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
        self.0.element_loads(u, at, loads);
    }
}

impl<T, M, P, I, F, S> Solved<T> for SolvedBy<QuasiStatic<T, M, P, I, F, S>>
where
    T: Scalar,
    M: Math<T>,
    P: Arrangement<T>,
    I: Inertia<T>,
    F: Film<T>,
    S: surface::Surface<T>,
{
    fn ball_states(&self, u: &Displacement<T>, at: &Rotation<T>) -> Vec<BallState<T>> {
        let mut states = vec![BallState::default(); self.1];
        self.0.ball_states(u, at, &mut states);
        states
    }
}

impl<T, M, P, I, F, S> Solved<T> for SolvedBy<Mirrored<QuasiStatic<T, M, P, I, F, S>>>
where
    T: Scalar,
    M: Math<T>,
    P: Arrangement<T>,
    I: Inertia<T>,
    F: Film<T>,
    S: surface::Surface<T>,
{
    fn ball_states(&self, u: &Displacement<T>, at: &Rotation<T>) -> Vec<BallState<T>> {
        let mut states = vec![BallState::default(); self.1];
        self.0.0.ball_states(&u.mirrored(), &at.reversed(), &mut states);
        // Angles count towards +Z of the scene.
        for state in &mut states {
            let turned = |[cos, sin]: [T; 2]| [cos, -sin];
            state.inner_direction = turned(state.inner_direction);
            state.outer_direction = turned(state.outer_direction);
            state.orbital_speed = -state.orbital_speed;
        }
        states
    }
}

/// The quasi-static model of one bearing.
///
/// # Errors
/// What the scene does not say for this model, or the kernel refuses.
pub fn quasi_static<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Result<AnySolved<T>> {
    let (geometry, zero) = contact_geometry(scene, "quasi-static")?;
    let built = QuasiStatic::<T, M, _>::try_new(geometry, places(scene), zero).map_err(|e| named(scene, e))?;
    let surface = Uneven::<M, _>::new(features(scene));
    let built = built.with_surface(surface);
    let usual = InertiaParams {
        centrifugal: true,
        gyroscopic: true,
        control: RaceControl::Outer,
        sharing: FrictionSharing::Outer,
        ..inertia_params(scene)
    };
    if inertia_params(scene) == usual {
        with_film(scene, built.with_outer_control(&usual).map_err(|e| named(scene, e))?)
    } else if scene.effects.centrifugal || scene.effects.gyroscopic {
        let built = built.with_inertia(&inertia_params(scene)).map_err(|e| named(scene, e))?;
        with_film(scene, built)
    } else {
        with_film(scene, built)
    }
}

fn with_film<T, M, P, I, S>(scene: &BearingScene, built: QuasiStatic<T, M, P, I, Dry, S>) -> Result<AnySolved<T>>
where
    T: Scalar,
    M: Math<T>,
    P: Arrangement<T> + 'static,
    I: Inertia<T>,
    S: surface::Surface<T> + 'static,
{
    Ok(match scene.effects.film {
        None => solved(scene, built),
        Some(super::Lubricant { viscosity, pressure_viscosity, .. }) => {
            let oil = Lubricant { viscosity, pressure_viscosity };
            solved(scene, built.with_film(oil).map_err(|e| named(scene, e))?)
        }
    })
}

fn solved<T, M, P, I, F, S>(scene: &BearingScene, built: QuasiStatic<T, M, P, I, F, S>) -> AnySolved<T>
where
    T: Scalar,
    M: Math<T>,
    P: Arrangement<T> + 'static,
    I: Inertia<T>,
    F: Film<T>,
    S: surface::Surface<T> + 'static,
{
    if scene.facing == Facing::MinusZ {
        Arc::new(SolvedBy(Mirrored(built), scene.elements))
    } else {
        Arc::new(SolvedBy(built, scene.elements))
    }
}

/// A bearing's table: what it was made for, its shape, its nodes, and what it needs besides.
pub struct MadeTable {
    /// What it was made for.
    pub domain: Domain,
    /// Whether its speed is the outer ring's.
    pub by_outer: bool,
    /// Shape.
    pub grid: Grid<f64>,
    /// Nodes; the third number is the friction, where the inner contact has one.
    pub nodes: Vec<[f64; 3]>,
    /// The rest.
    pub seat: TableSeat<f64>,
    /// Whether the third number is needed.
    pub friction: bool,
}

/// Samples the quasi-static model of one bearing.
///
/// # Errors
/// As [`quasi_static`], and a table that cannot be made.
pub fn table(scene: &Scene, of: &BearingScene) -> Result<MadeTable> {
    let (geometry, zero) = contact_geometry(of, "tabulated")?;
    let (domain, by_outer) = domain(scene, of, &geometry)?;
    let one = [Place::at(Turn::ZERO)];
    let plain = QuasiStatic::<f64, ballrace::Exact, _>::try_new(geometry, one, zero).map_err(|e| named(of, e))?;
    let seat = plain.table_seat();
    let grid = domain.grid().map_err(|e| named(of, e))?;
    let mut nodes = vec![[0.0; 3]; grid.len()];
    let oil = of.effects.film.map(|f| Lubricant { viscosity: f.viscosity, pressure_viscosity: f.pressure_viscosity });
    let massive = of.effects.centrifugal || of.effects.gyroscopic;
    let inertia = inertia_params(of);
    let open = match (massive, oil) {
        (false, None) => fill(&plain, &domain, &grid, &mut nodes, || {}),
        (false, Some(oil)) => fill(&plain.with_film(oil).map_err(|e| named(of, e))?, &domain, &grid, &mut nodes, || {}),
        (true, None) => {
            fill(&plain.with_inertia(&inertia).map_err(|e| named(of, e))?, &domain, &grid, &mut nodes, || {})
        }
        (true, Some(oil)) => {
            let full = plain.with_inertia(&inertia).and_then(|b| b.with_film(oil)).map_err(|e| named(of, e))?;
            fill(&full, &domain, &grid, &mut nodes, || {})
        }
    };
    if open > 0 {
        bail!(
            "{}: bearing {}: table: found {open} of {} states in which a ball has no equilibrium, allowed: none; a smaller approach, angle or speed range in table = {{ ... }} leaves them out",
            scene.path.display(),
            of.name,
            grid.len()
        );
    }
    let friction = of.effects.gyroscopic && of.effects.sharing != super::FrictionSharing::Outer;
    Ok(MadeTable { domain, by_outer, grid, nodes, seat, friction })
}

/// Peak pressure up to which a table goes unless the scene says otherwise, Pa: the static limit of ISO 76.
const TABLE_PRESSURE: f64 = 4.2e9;
/// Contact angles to either side of the free one, rad.
const TABLE_ANGLES: f64 = 0.4;
/// Speeds about a constant one.
const TABLE_SPEEDS: [f64; 2] = [0.8, 1.2];
/// Intervals along approach and angle, and along the speed about a constant one and over one that changes.
const TABLE_INTERVALS: ([usize; 2], usize, usize) = ([64, 32], 8, 32);

/// What the table of a bearing is made for: what the scene says, else up to the static limit, about its angle and speed.
fn domain(scene: &Scene, of: &BearingScene, geometry: &BallBearingGeometry) -> Result<(Domain, bool)> {
    let given = of.table.unwrap_or_default();
    let contact = geometry.contact(Race::Inner);
    let (_, _, pressure) = contact.ellipse(1.0);
    let load = (TABLE_PRESSURE / pressure).powi(3);
    let most = (load / geometry.stiffness()).powf(2.0 / 3.0);
    let free = if of.facing == Facing::Both { [0.0, geometry.contact_angle] } else { [geometry.contact_angle; 2] };
    let widest = if of.facing == Facing::Both { free[1] + TABLE_ANGLES } else { TABLE_ANGLES };
    let angles = [(free[0] - widest).max(-1.3), (free[1] + TABLE_ANGLES).min(1.3)];
    let (inner, outer) = (scene.shaft.speed, scene.shaft.outer_speed);
    let about = |speed: f64| TABLE_SPEEDS.map(|part| part * speed.abs());
    let by_outer = inner == Speed::Constant(0.0) && outer != 0.0;
    let speeds = match inner {
        _ if by_outer => about(outer),
        Speed::Constant(speed) => about(speed),
        Speed::Ramp { from, to, .. } => [from.abs().min(to.abs()), from.abs().max(to.abs())],
        Speed::Fluctuating { mean, fluctuation, .. } => [1.0 - fluctuation, 1.0 + fluctuation].map(|p| p * mean.abs()),
    };
    let turning = if by_outer { [0.0, 1.0] } else { [1.0, outer_ratio(scene)?] };
    let speed = given.speed.unwrap_or(speeds);
    let ([approach, angle], about_one, over_many) = TABLE_INTERVALS;
    // Without inertia and film the speed does not matter.
    let still = of.effects == super::Effects::default();
    let narrow = matches!(inner, Speed::Constant(_)) && given.speed.is_none();
    let layers = if still {
        1
    } else if narrow {
        about_one
    } else {
        over_many
    };
    let intervals = given.intervals.unwrap_or([approach, angle, layers]);
    let approach = given.approach.unwrap_or([-0.5 * most, most]);
    Ok((Domain { approach, angle: given.angle.unwrap_or(angles), speed, turning, intervals }, by_outer))
}

fn tabulated<T: Scalar, M: Math<T>>(scene: &Scene, of: &BearingScene) -> Result<AnyBearing<T>> {
    let made = table(scene, of)?;
    if made.friction { looked_up::<T, M, 3>(of, &made) } else { looked_up::<T, M, 2>(of, &made) }
}

fn looked_up<T: Scalar, M: Math<T>, const F: usize>(of: &BearingScene, made: &MadeTable) -> Result<AnyBearing<T>> {
    let round = |node: &[f64; 3]| std::array::from_fn(|i| T::from_f64(node[i]));
    let nodes: Vec<[T; F]> = made.nodes.iter().map(round).collect();
    let table = Table::new(made.grid.rounded::<T>(), nodes);
    let bearing = Tabulated::<T, M, _, _, F>::new(places(of), made.seat.rounded(), table, made.by_outer);
    Ok(match uneven::<T, M>(of) {
        None => facing(of, bearing),
        Some(surface) => facing(of, bearing.with_surface(surface)),
    })
}

/// Holds a solved bearing as any other.
struct Unsolved<T>(AnySolved<T>);

impl<T: Scalar> Bearing<T> for Unsolved<T> {
    fn reaction(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
        self.0.reaction(u, at)
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &Rotation<T>) -> (Reaction<T>, Stiffness<T>) {
        self.0.reaction_and_stiffness(u, at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
        self.0.element_loads(u, at, loads);
    }
}

/// A bearing that stands displaced by its preload before anything moves.
struct Preloaded<T> {
    bearing: AnyBearing<T>,
    offset: Displacement<T>,
}

impl<T: Scalar> Preloaded<T> {
    fn with(&self, u: &Displacement<T>) -> Displacement<T> {
        u.plus(self.offset)
    }
}

impl<T: Scalar> Bearing<T> for Preloaded<T> {
    fn reaction(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
        self.bearing.reaction(&self.with(u), at)
    }
    fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &Rotation<T>) -> (Reaction<T>, Stiffness<T>) {
        self.bearing.reaction_and_stiffness(&self.with(u), at)
    }
    fn element_loads(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
        self.bearing.element_loads(&self.with(u), at, loads);
    }
}

/// What a bearing sees at `time` of the scene, from angle 0 at time 0.
///
/// # Errors
/// As [`kinematics`].
pub fn rotation_at(scene: &Scene, bearing: &BearingScene, time: f64) -> Result<Rotation<f64>> {
    let (inner_speed, outer_speed) = (scene.shaft.speed.at(time), scene.shaft.outer_speed);
    let inner = scene.shaft.speed.revolutions(time);
    let outer = outer_speed * time / std::f64::consts::TAU;
    let (cage_ratio, spin) = match geometry(bearing)? {
        Some(g) => {
            let orders = orders(bearing.elements, g.gamma(), g.ball_diameter / g.pitch_diameter);
            (bearing.cage_ratio.unwrap_or(orders.cage), orders.ball_spin)
        }
        None => (bearing.cage_ratio.unwrap_or(0.0), 0.0),
    };
    // The outer ring takes the cage along as far as the inner one does not; a cage ratio that is given is for a
    // resting outer ring.
    let carried = if cage_ratio > 0.0 { 1.0 - cage_ratio } else { 0.0 };
    Ok(Rotation {
        cage: Turn::from_revolutions(cage_ratio * inner + carried * outer),
        inner: Turn::from_revolutions(inner),
        outer: Turn::from_revolutions(outer),
        ball: Turn::from_revolutions(-spin * (inner - outer)),
        inner_speed,
        outer_speed,
    })
}

/// Displacement of the inner ring by the scene's preload; the bearing's thrust direction is that of `facing`.
///
/// # Errors
/// A preload that the bearing cannot take, or a bearing that carries no thrust.
pub fn preload_offset(
    scene: &Scene,
    bearing: &BearingScene,
    built: &AnyBearing<f64>,
) -> Result<Option<Displacement<f64>>> {
    let Some(preload) = bearing.preload else { return Ok(None) };
    let sign = if bearing.facing == Facing::MinusZ { -1.0 } else { 1.0 };
    match preload {
        Preload::Displacement(w) => Ok(Some(Displacement { w: sign * w, ..Displacement::default() })),
        Preload::Force(force) => {
            let at = rotation_at(scene, bearing, 0.0)?;
            let at = Rotation { inner_speed: scene.shaft.speed.nominal(), ..at };
            let rest = loaded(built, [0.0, 0.0, sign * force, 0.0, 0.0], &at)?;
            if rest.residual > 1e-6 {
                bail!(
                    "{}: bearing {}: preload: found {force} N, which the bearing does not carry along its axis, allowed: a force that it can carry",
                    scene.path.display(),
                    bearing.name
                );
            }
            Ok(Some(rest.q))
        }
    }
}

/// Where the inner ring settles under `load` (N, N m), the outer ring held.
///
/// # Errors
/// None that a finite load can cause.
pub fn loaded(bearing: &AnyBearing<f64>, load: [f64; 5], at: &Rotation<f64>) -> Result<Equilibrium<f64>> {
    let params = RotorParams {
        mass: 1.0,
        diametral_inertia: 1.0,
        polar_inertia: 0.0,
        damping: [[0.0; 5]; 5],
        stiffness: [0.0; 5],
        gravity: [0.0; 3],
        load,
    };
    let rotor = RigidRotor::<f64, ballrace::Exact>::try_new(&params, &[])?;
    let seat = Mounted { bearing: bearing.clone(), station: 0.0, gear: Gear::new(0.0) };
    let machine = Machine { rotor, bearings: [seat] };
    // From where the bearing just carries thrust Newton's method needs a few steps; where that does not lead to rest, the
    // damped fall from zero displacement does.
    let start = thrust_start(bearing, load, at);
    let settled = (0..NEWTON_STEPS).try_fold(start, |u, _| newton_step(bearing, load, at, u));
    let start = settled.unwrap_or_default();
    let found = equilibrium(&machine, &[*at], start);
    Ok(if found.residual > 1e-6 { equilibrium(&machine, &[*at], Displacement::default()) } else { found })
}

/// Newton steps tried first.
const NEWTON_STEPS: usize = 12;
/// Axial displacements tried for a start, m.
const THRUST_STARTS: [f64; 6] = [3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3];

/// The first axial displacement at which the bearing carries the axial load, if there is one.
fn thrust_start(bearing: &AnyBearing<f64>, load: [f64; 5], at: &Rotation<f64>) -> Displacement<f64> {
    let along = |w: f64| Displacement { w: w * load[2].signum(), ..Displacement::default() };
    let carries = |u: &Displacement<f64>| bearing.reaction(u, at).wrench.fz.abs() >= load[2].abs();
    THRUST_STARTS.map(along).into_iter().find(carries).unwrap_or_default()
}

/// One step of Newton's method; nothing where it leads nowhere.
fn newton_step(
    bearing: &AnyBearing<f64>,
    load: [f64; 5],
    at: &Rotation<f64>,
    u: Displacement<f64>,
) -> Option<Displacement<f64>> {
    let (reaction, k) = bearing.reaction_and_stiffness(&u, at);
    let mut residual = reaction.wrench.to_array();
    for (r, f) in residual.iter_mut().zip(load) {
        *r += f;
    }
    let next = u.plus(Displacement::from_array(solve(k, residual)));
    next.is_finite().then_some(next)
}

/// `bearing` displaced by `offset` before anything moves.
pub fn preloaded<T: Scalar>(bearing: AnyBearing<T>, offset: Displacement<T>) -> AnyBearing<T> {
    AnyBearing(Arc::new(Preloaded { bearing, offset }))
}

/// Stiffness, exponent and radial play of the lumped law: as the scene gives them, else from geometry.
fn lumped_law(scene: &BearingScene) -> Result<(f64, f64, f64)> {
    let geometry = geometry(scene)?;
    let law = scene.law;
    let Some(stiffness) = law.and_then(|l| l.stiffness).or_else(|| geometry.map(|g| g.stiffness())) else {
        bail!(
            "bearing {}: model lumped: found no stiffness, allowed: stiffness, or the geometry it follows from",
            scene.name
        );
    };
    let from_clearance = scene.geometry.and_then(|g| match g.fit {
        Fit::DiametralClearance(s) => Some(0.5 * s),
        Fit::ContactAngle(_) => None,
    });
    let Some(play) = law.and_then(|l| l.radial_play).or(from_clearance) else {
        bail!(
            "bearing {}: model lumped: found no radial_play, allowed: radial_play or diametral_clearance",
            scene.name
        );
    };
    Ok((stiffness, law.map_or(1.5, |l| l.exponent), play))
}

fn lumped<T: Scalar, M: Math<T>>(scene: &BearingScene) -> Result<AnyBearing<T>> {
    let (stiffness, exponent, play) = lumped_law(scene)?;
    let stiffness = T::from_f64(stiffness);
    match exponent_kind(exponent) {
        Exponent::Point => lumped_radial::<T, M, _>(scene, Point { stiffness }, play),
        Exponent::Line => lumped_radial::<T, M, _>(scene, Line { stiffness }, play),
        Exponent::Other => lumped_radial::<T, M, _>(scene, Power { stiffness, exponent: T::from_f64(exponent) }, play),
    }
}

enum Exponent {
    Point,
    Line,
    Other,
}

/// 3/2 and 10/9 (also as a decimal of four digits or more) have laws without a power function.
fn exponent_kind(exponent: f64) -> Exponent {
    if exponent == 1.5 {
        Exponent::Point
    } else if (exponent - 10.0 / 9.0).abs() < 1.2e-4 {
        Exponent::Line
    } else {
        Exponent::Other
    }
}

fn lumped_radial<T, M, L>(scene: &BearingScene, law: L, play: f64) -> Result<AnyBearing<T>>
where
    T: Scalar,
    M: Math<T>,
    L: Law<T, M>,
{
    let radial = lumped::Radial::<T, M, L, _>::try_new(places(scene), law, play).map_err(|e| named(scene, e))?;
    match uneven::<T, M>(scene) {
        None => lumped_axial::<T, M, _>(scene, radial),
        Some(surface) => lumped_axial::<T, M, _>(scene, radial.with_surface(surface)),
    }
}

fn lumped_axial<T, M, R>(scene: &BearingScene, radial: R) -> Result<AnyBearing<T>>
where
    T: Scalar,
    M: Math<T>,
    R: FlexibleRing<T> + InCage<T> + Bearing<T> + 'static,
{
    let Some(axial) = scene.axial else { return Ok(on_housing(scene, radial)) };
    let stiffness = T::from_f64(axial.stiffness);
    match exponent_kind(axial.exponent) {
        Exponent::Point => combined::<T, M, _, _>(scene, radial, axial, Point { stiffness }),
        Exponent::Line => combined::<T, M, _, _>(scene, radial, axial, Line { stiffness }),
        Exponent::Other => {
            let exponent = T::from_f64(axial.exponent);
            combined::<T, M, _, _>(scene, radial, axial, Power { stiffness, exponent })
        }
    }
}

fn combined<T, M, R, L>(scene: &BearingScene, radial: R, axial: Axial, law: L) -> Result<AnyBearing<T>>
where
    T: Scalar,
    M: Math<T>,
    R: FlexibleRing<T> + InCage<T> + Bearing<T> + 'static,
    L: Law<T, M>,
{
    let axial = lumped::Axial::<T, M, L, _>::try_new(places(scene), law, axial.play, axial.radius)
        .map_err(|e| named(scene, e))?;
    Ok(on_housing(scene, Combined(radial, axial)))
}

fn on_housing<T: Scalar>(scene: &BearingScene, bearing: impl FlexibleRing<T> + Bearing<T> + 'static) -> AnyBearing<T> {
    if scene.housing_displacement.is_empty() {
        return facing(scene, bearing);
    }
    let mirror = scene.facing == Facing::MinusZ;
    let point = |&[x, y, z]: &[f64; 3]| if mirror { [x, -y, -z] } else { [x, y, z] };
    let displaced = |p| HousingPoint { displacement: point(p).map(T::from_f64), reaction: [T::ZERO; 3] };
    let points = scene.housing_displacement.iter().map(displaced).collect();
    facing(scene, OnHousing { bearing, points })
}

/// A bearing on a housing that stands displaced: Hajzman's flexible outer ring with given `q_S`.
struct OnHousing<T, B> {
    bearing: B,
    points: Vec<HousingPoint<T>>,
}

impl<T: Scalar, B: FlexibleRing<T> + Bearing<T>> Bearing<T> for OnHousing<T, B> {
    fn reaction(&self, u: &Displacement<T>, at: &Rotation<T>) -> Reaction<T> {
        self.bearing.reaction_flexible(u, at, &mut self.points.clone())
    }

    fn reaction_and_stiffness(&self, u: &Displacement<T>, at: &Rotation<T>) -> (Reaction<T>, Stiffness<T>) {
        self.bearing.reaction_and_stiffness_flexible(u, at, &mut self.points.clone())
    }

    fn element_loads(&self, u: &Displacement<T>, at: &Rotation<T>, loads: &mut [T]) {
        // Load of an element = size of the reaction on its housing point.
        let mut points = self.points.clone();
        self.bearing.reaction_flexible(u, at, &mut points);
        for (load, point) in loads.iter_mut().zip(&points) {
            let square = point.reaction.iter().map(|r| r.to_f64() * r.to_f64()).sum::<f64>();
            *load = T::from_f64(square.sqrt());
        }
    }
}

fn linear<T: Scalar>(scene: &BearingScene) -> Result<AnyBearing<T>> {
    match &scene.linear {
        Some(Linear::Matrix(rows)) => {
            let k = Stiffness::from_fn(|i, j| T::from_f64(rows[i][j]));
            Ok(AnyBearing(Arc::new(LinearBearing::new(k))))
        }
        Some(Linear::TwoSpring { static_load }) => {
            let Some(g) = geometry(scene)? else {
                bail!(
                    "bearing {}: two_spring: found no geometry, allowed: with ball_diameter and the others",
                    scene.name
                );
            };
            let springs = two_spring_ball(scene.elements, g.ball_diameter, *static_load, g.contact_angle)
                .map_err(|e| named(scene, e))?;
            // Along the static load: gravity acts along Y.
            Ok(AnyBearing(Arc::new(LinearBearing::new(springs.stiffness(std::f64::consts::FRAC_PI_2)))))
        }
        Some(Linear::Of(_)) => bail!(
            "bearing {}: linearise: found a bearing taken alone, allowed: in a scene with a [rotor], whose rest position it is linearised at",
            scene.name
        ),
        None => bail!(
            "bearing {}: model linear: found no stiffness, allowed: stiffness_matrix, two_spring or linearise",
            scene.name
        ),
    }
}

/// Springs with the mean force and tangent of a bearing at the states given.
pub fn linearised(states: &[(Displacement<f64>, Wrench<f64>, Stiffness<f64>)]) -> AnyBearing<f64> {
    let weight = 1.0 / states.len().max(1) as f64;
    let (mut u, mut f, mut k) = ([0.0; 5], [0.0; 5], Stiffness::from_element(0.0));
    for (displacement, wrench, tangent) in states {
        for (sum, x) in u.iter_mut().zip(displacement.to_array()) {
            *sum += weight * x;
        }
        for (sum, x) in f.iter_mut().zip(wrench.to_array()) {
            *sum += weight * x;
        }
        k += tangent * weight;
    }
    AnyBearing(Arc::new(LinearBearing::about(k, Displacement::from_array(u), Wrench::from_array(f))))
}

/// A spring bearing in another precision: its tangent and its force at zero displacement say all.
pub fn spring_of<T: Scalar>(spring: &AnyBearing<f64>) -> AnyBearing<T> {
    let zero = Displacement::default();
    let (reaction, k) = spring.reaction_and_stiffness(&zero, &Turn::ZERO.into());
    let force = Wrench::from_array(reaction.wrench.to_array().map(T::from_f64));
    AnyBearing(Arc::new(LinearBearing::about(k.map(T::from_f64), Displacement::default(), force)))
}

/// Parameters of the rotor with the damping matrix `extra` besides its own diagonal one.
#[must_use]
pub fn rotor_params(rotor: &Rotor, extra: &Stiffness<f64>) -> RotorParams {
    let mut damping = [[0.0; 5]; 5];
    for (i, row) in damping.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = extra[(i, j)] + if i == j { rotor.damping[i] } else { 0.0 };
        }
    }
    RotorParams {
        mass: rotor.mass,
        diametral_inertia: rotor.diametral_inertia,
        polar_inertia: rotor.polar_inertia,
        damping,
        stiffness: rotor.stiffness,
        gravity: rotor.gravity,
        load: rotor.load,
    }
}

/// The rotor's unbalances as the kernel takes them.
#[must_use]
pub fn unbalances(rotor: &Rotor) -> Vec<Unbalance> {
    let one = |u: &super::Unbalance| Unbalance { moment: u.moment, angle: u.angle, station: u.station };
    rotor.unbalance.iter().map(one).collect()
}

/// `bearing` by name, or the only one.
///
/// # Errors
/// No such name, or a choice to make.
pub fn pick<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a BearingScene> {
    let names = || scene.bearings.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", ");
    match name {
        Some(name) => scene
            .bearings
            .iter()
            .find(|b| b.name == name)
            .with_context(|| format!("--bearing: found {name:?}, allowed in {}: {}", scene.path.display(), names())),
        None if scene.bearings.len() == 1 => scene.bearings.first().context("a scene has a bearing"),
        None => bail!("--bearing: found none, allowed: one of {} ({} has several)", names(), scene.path.display()),
    }
}
