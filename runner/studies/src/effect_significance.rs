//! Effect significance: predicted change of the bearing's force by each effect, from the static load of every ball
//! (`docs/src/models.md#effect-significance`), and whether the scene's model contains the effect.
//!
//! With fixed groove centres a small force `F` displaces a ball by `x` with `K x = F` and
//! `K = (k_i + k_o) e e^T + Q (1/l_i + 1/l_o) t t^T`: along the contact normal `e` the stiffness of both contacts resists,
//! across it, along `t`, the load itself. The displacement across is large and stretches the contacts: `Q' = K_n (delta +
//! x_t^2 (1/l_i + 1/l_o)/2)^1.5`, solved together with `x_t Q' (1/l_i + 1/l_o) = F_t`. The change of force on the inner
//! ring follows without the equilibrium of the balls.

mod bending;
mod film;

use ballrace::bearing::angular::{Angular, GrooveCentres};
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::{Bearing, ElementPosition};
use ballrace::contact::hertz::Race;
use ballrace::{BearingKinematicState, Displacement, Exact, Phase};
use ballrace_models::build::{self, point_contact_approach, point_contact_load, rolling_speed};
use ballrace_plant::{Plant, Result};
use ballrace_scene::{Bearing as BearingScene, Effects, Facing, FreeAngle, Model, Scene};
use bending::{BENDING, Bending};
use film::{INLET_HEATING, film_alone, heating_sentence};
use serde::Serialize;
use std::f64::consts::PI;

/// One effect on one bearing.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EffectSignificance {
    /// The scene's name of the bearing.
    pub bearing: String,
    /// Name of the effect: `centrifugal`, `gyroscopic`, `film`, `inlet-heating`, `contact-angle`, `moving-balls` or `bending`.
    pub effect: &'static str,
    /// Change of force without the effect, over the force.
    pub change: f64,
    /// True where the scene's model contains the effect.
    pub modelled: bool,
    /// Cause of the change.
    pub because: String,
    /// Speed of a ramp or a diagram, or point of a sweep, at which the change is largest, such as `shaft.speed = 6000 rpm`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at: Option<String>,
}

/// Default of the tolerated relative error of the force.
pub const DEFAULT_FORCE_ERROR: f64 = 0.01;
/// Number of cage angles over a ball pitch.
const PITCH_SAMPLES: u32 = 16;
/// Number of bisections of the equation for `x_t`.
const ROUNDS: usize = 60;
/// Largest number of secant steps.
const SECANTS: usize = 12;

/// Force of a bearing over the sum of the loads on its balls below which they balance each other.
const BALANCED: f64 = 1e-6;
/// Shares beyond this are written as multiples, with the force as their reason.
const MANY: f64 = 10.0;
/// Largest multiple that is written.
const TOO_MANY: f64 = 1000.0;
/// Number of speeds over the range of a ramp or a diagram.
const SPEEDS: usize = 9;
/// Relative difference below which a change is the same at two speeds.
const SAME_CHANGE: f64 = 1e-3;

/// Returns the significance of each effect on every bearing at the rotor's static equilibrium, at the speed of the scene at which it is
/// largest.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn at_rest(scene: &Scene, plant: &Plant) -> Result<Vec<EffectSignificance>> {
    over(&speeds_between(scene.shaft.speed.range()), |speed| of_plant(scene, plant, speed))
}

/// Returns the significance of each effect on every bearing: at the rotor's equilibrium, or without a rotor under the preload, at the
/// speed of the scene at which it is largest.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn of_scene(scene: &Scene) -> Result<Vec<EffectSignificance>> {
    if scene.rotor.is_some() || scene.system.is_some() {
        return at_rest(scene, &Plant::try_new(scene)?);
    }
    over(&speeds_between(scene.shaft.speed.range()), |speed| {
        let mut all = Vec::new();
        for of in &scene.bearings {
            let at = BearingKinematicState { inner_speed: speed, ..build::rotation_at(scene, of, 0.0)? };
            all.extend(of_bearing(scene, of, &Displacement::default(), &at)?);
        }
        Ok(all)
    })
}

/// Returns the significance of each effect on every bearing of a rotor, at the one of these speeds (rad/s) at which it is largest.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn over_speeds(scene: &Scene, speeds: &[f64]) -> Result<Vec<EffectSignificance>> {
    let ends = speeds.iter().fold((f64::MAX, f64::MIN), |(low, high), &speed| (low.min(speed), high.max(speed)));
    let plant = Plant::try_new(scene)?;
    over(&speeds_between(ends), |speed| of_plant(scene, &plant, speed))
}

/// Returns speeds from the lowest to the highest, rad/s.
fn speeds_between((low, high): (f64, f64)) -> Vec<f64> {
    if low >= high {
        return vec![low];
    }
    let last = (SPEEDS - 1) as f64;
    (0..SPEEDS).map(|i| low + (high - low) * (i as f64 / last)).collect()
}

/// Returns, for each bearing and effect, the entry at the speed with the largest change. An effect whose change depends on the speed
/// names it.
fn over(
    speeds: &[f64],
    mut at_speed: impl FnMut(f64) -> Result<Vec<EffectSignificance>>,
) -> Result<Vec<EffectSignificance>> {
    let mut all = Vec::new();
    for &speed in speeds {
        let at = Some(format!("shaft.speed = {} rpm", rpm(speed))).filter(|_| speeds.len() > 1);
        all.extend(at_speed(speed)?.into_iter().map(|entry| EffectSignificance { at: at.clone(), ..entry }));
    }
    let mut worst = largest(all.iter().cloned());
    for entry in &mut worst {
        let same = |other: &&EffectSignificance| other.bearing == entry.bearing && other.effect == entry.effect;
        let least = all.iter().filter(same).map(|other| other.change).fold(f64::INFINITY, f64::min);
        if entry.change - least <= SAME_CHANGE * entry.change {
            entry.at = None;
        }
    }
    Ok(worst)
}

/// Returns the speed in revolutions per minute with at most six digits.
fn rpm(speed: f64) -> String {
    let rpm = speed * 30.0 / PI;
    let rounded = (rpm * 1e3).round() / 1e3;
    if rounded.abs() >= 100.0 { format!("{rounded:.0}") } else { format!("{rounded}") }
}

fn of_plant(scene: &Scene, plant: &Plant, speed: f64) -> Result<Vec<EffectSignificance>> {
    let moved = if speed == plant.speed() { None } else { Some(plant.at_speed(speed)?) };
    let plant = moved.as_ref().unwrap_or(plant);
    let mut all = Vec::new();
    let bending = Bending::new(scene, plant)?;
    for (i, (of, mounted)) in scene.bearings.iter().zip(&plant.bearings).enumerate() {
        let u = plant.displacement(i, &plant.rest);
        all.extend(of_bearing(scene, of, &u, &plant.resting(mounted, Phase::ZERO))?);
        all.extend(bending.of(&of.name));
    }
    Ok(all)
}

/// Returns the significance of each effect on one bearing displaced by `u` besides its preload; empty without load.
///
/// # Errors
/// Returns an error if the kernel rejects a parameter.
pub fn of_bearing(
    scene: &Scene,
    of: &BearingScene,
    u: &Displacement<f64>,
    at: &BearingKinematicState<f64>,
) -> Result<Vec<EffectSignificance>> {
    if of.geometry.is_none() {
        return Ok(vec![]);
    }
    let (still, interference) = with_own_play(of);
    let Some(geometry) = build::geometry(&still)? else { return Ok(vec![]) };
    let built = build::bearing(scene, &still, Model::Angular)?;
    let offset = build::mounted_offset(scene, &still, &built)?.unwrap_or_default();
    let (_, datum) = build::contact_geometry(&still, "angular")?;
    let angular = Angular::<f64, Exact, _>::try_new(geometry, build::places(&still), datum);
    let angular = angular.map_err(|e| build::named(&still, e))?;
    let balls_at = |u: &Displacement<f64>| Balls::new(&still, &geometry, (&angular, interference), at, u);
    let loaded = balls_at(&(*u + offset));
    let right = loaded.sum(Ball::push);
    let on_balls = loaded.0.iter().map(|ball| ball.load).sum::<f64>();
    if on_balls <= 0.0 {
        return Ok(film_alone(of, &loaded, &geometry, at));
    }
    // The loads of opposite balls under preload balance each other but for rounding: the change is then that of their loads.
    let is_balanced = size(right) < BALANCED * on_balls;
    let force = if is_balanced { on_balls } else { size(right) };
    let change_of_loads = |change: &dyn Fn(&Ball) -> [f64; 2]| {
        loaded.0.iter().map(change).map(|[radial, axial]| radial.hypot(axial)).sum::<f64>() / on_balls
    };
    // With a preload by force, the axial displacement follows so that the bearing carries the same force.
    let by_force = of.has_constant_preload_force();
    let pushed = |change: &dyn Fn(&Ball) -> [f64; 2]| {
        let whole = |ball: &Ball| plus(ball.push(), change(ball));
        if !by_force {
            return loaded.sum(whole);
        }
        let along = |more: f64| Displacement { w: offset.w + more, ..offset };
        let carried = balls_at(&offset).sum(Ball::push)[2];
        let lacking = |more: f64| carried - balls_at(&along(more)).sum(whole)[2];
        let more = root(lacking, 1e-3 * offset.w);
        balls_at(&(*u + along(more))).sum(whole)
    };
    let change = |with: [f64; 3], without: [f64; 3]| size(minus(with, without)) / force;
    let fitted = of.effects;
    // Without a lubricant there is no film to predict.
    let oil = of.lubricant;
    let inertia = Inertia::new(of, &geometry, at);
    let [centrifugal, gyroscopic] = if is_balanced {
        let by_moment = |ball: &Ball| {
            let ([a, b], [c, d]) = (inertia.change(ball, true), inertia.change(ball, false));
            [a - c, b - d]
        };
        [change_of_loads(&|ball| inertia.change(ball, false)), change_of_loads(&by_moment)]
    } else {
        let [thrown, spun] = [false, true].map(|spin| pushed(&|ball| inertia.change(ball, spin)));
        [change(thrown, right), change(spun, thrown)]
    };
    let solved = of.model.properties().effects || of.model.properties().bodies;
    let named = of.name.clone();
    let entry = |effect, change, modelled, because: String| EffectSignificance {
        bearing: named.clone(),
        effect,
        change,
        modelled,
        because: if change > MANY { format!("{because}; the bearing carries only {force:.1e} N") } else { because },
        at: None,
    };
    let worst = |ratio: &dyn Fn(&Ball) -> f64| loaded.0.iter().filter(|b| b.load > 0.0).map(ratio).fold(0.0, f64::max);
    let throw = worst(&|b| inertia.centrifugal(b) / b.load);
    let spin = worst(&|b| 2.0 * inertia.moment(b) / inertia.diameter / b.load);
    let film = oil.map(|oil| {
        let film = |ball: &Ball| ball.film(&geometry, oil, at);
        let wet = if is_balanced { change_of_loads(&film) } else { change(pushed(&film), right) };
        let thick = worst(&|b| b.films(&geometry, oil, at, b.load) / b.approach);
        let because = format!("film {} of the approach", share(thick));
        entry("film", wet, solved && fitted.film.is_some(), because)
    });
    // Only a film that is modelled is too thick.
    let heated = oil.filter(|_| solved && fitted.film.is_some()).map(|oil| {
        let cold = |ball: &Ball| ball.film(&geometry, oil, at);
        let warm = |ball: &Ball| ball.heated_film(&geometry, oil, at);
        let less = |ball: &Ball| {
            let ([a, b], [c, d]) = (cold(ball), warm(ball));
            [a - c, b - d]
        };
        let wet = if is_balanced { change_of_loads(&less) } else { change(pushed(&cold), pushed(&warm)) };
        entry(INLET_HEATING, wet, oil.inlet_heating.is_some(), heating_sentence(&loaded, &geometry, oil, at))
    });
    let fixed = loaded.fixed_angle(of.facing);
    let turned = worst(&|b| (b.angle - fixed).abs().to_degrees());
    // Interference is beyond the angular model.
    let pass = if interference > 0.0 {
        pass(&build::bearing(scene, of, of.model)?, u, at, of.elements, force)
    } else {
        pass(&built, &(*u + offset), at, of.elements, force)
    };
    let inertial = [
        entry(
            "centrifugal",
            centrifugal,
            solved && fitted.centrifugal,
            format!("centrifugal force {}", share_of(throw, "the load of a ball")),
        ),
        entry(
            "gyroscopic",
            gyroscopic,
            solved && fitted.gyroscopic,
            format!("friction against the gyroscopic moment {}", share_of(spin, "the load of a ball")),
        ),
    ];
    let geometric = [
        entry(
            "contact-angle",
            loaded.held_angle(fixed, force),
            of.model.has_contact_angle(),
            format!("contact angles up to {turned:.2} degrees from a fixed one of {:.2}", fixed.abs().to_degrees()),
        ),
        entry("moving-balls", pass, of.model.has_elements(), "force at rest over a ball pitch".to_owned()),
    ];
    // A change that is not finite has no meaning.
    Ok(inertial
        .into_iter()
        .chain(film)
        .chain(heated)
        .chain(geometric)
        .filter(|entry| entry.change.is_finite())
        .collect())
}

/// Returns the bearing without inertia as the angular model takes it, with the radial play of the scene's own law, and the interference
/// of the balls with both races, m: an angular model has none.
fn with_own_play(of: &BearingScene) -> (BearingScene, f64) {
    let mut still = BearingScene { model: Model::Angular, effects: Effects::default(), ..of.clone() };
    let own = of.law.and_then(|law| law.radial_play).filter(|_| of.facing == Facing::Both);
    let play = match (own, still.geometry.map(|geometry| geometry.fit)) {
        (Some(play), _) => play,
        (None, Some(FreeAngle::DiametralClearance(clearance))) => 0.5 * clearance,
        (None, _) => return (still, 0.0),
    };
    if let Some(geometry) = &mut still.geometry {
        geometry.fit = FreeAngle::DiametralClearance(2.0 * play.max(0.0));
    }
    (still, (-play).max(0.0))
}

/// Returns half the variation of the force over one ball pass, over the force.
fn pass(
    bearing: &build::AnyBearing<f64>,
    u: &Displacement<f64>,
    at: &BearingKinematicState<f64>,
    elements: usize,
    force: f64,
) -> f64 {
    let at_part = |i: u32| {
        let part = f64::from(i) / f64::from(PITCH_SAMPLES) / elements as f64;
        let at = BearingKinematicState { cage: at.cage.wrapping_add(Phase::from_revolutions(part)), ..*at };
        let wrench = bearing.reaction(u, &at).wrench.to_array();
        [wrench[0], wrench[1], wrench[2]]
    };
    let all: Vec<[f64; 3]> = (0..PITCH_SAMPLES).map(at_part).collect();
    let swing = |i: usize| {
        let (low, high) = all.iter().fold((f64::MAX, f64::MIN), |(low, high), f| (low.min(f[i]), high.max(f[i])));
        0.5 * (high - low)
    };
    size([swing(0), swing(1), swing(2)]) / force
}

fn size([x, y, z]: [f64; 3]) -> f64 {
    x.hypot(y).hypot(z)
}

fn plus([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b + d]
}

fn minus([a, b, c]: [f64; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    [a - x, b - y, c - z]
}

/// Returns the root of `f` by the secant method from 0 and `first`.
fn root(f: impl Fn(f64) -> f64, first: f64) -> f64 {
    let (mut a, mut b) = (0.0, first);
    let mut fa = f(a);
    for _ in 0..SECANTS {
        let fb = f(b);
        let next = b - fb * (b - a) / (fb - fa);
        if !next.is_finite() || (next - b).abs() <= 1e-6 * next.abs() {
            break;
        }
        (a, fa, b) = (b, fb, next);
    }
    b
}

/// Returns a share in percent, beyond [`MANY`] as a multiple.
fn share(x: f64) -> String {
    match x * 100.0 {
        0.0 => "0 %".to_owned(),
        percent if percent < 0.01 => "below 0.01 %".to_owned(),
        _ if x > TOO_MANY => format!("over {TOO_MANY:.0} times"),
        _ if x > MANY => format!("{x:.0} times"),
        percent => format!("{percent:.2} %"),
    }
}

/// Returns a share of `whole` in words.
fn share_of(x: f64, whole: &str) -> String {
    let of = if x > MANY { "" } else { "of " };
    format!("{} {of}{whole}", share(x))
}

/// One ball under its static load, in its plane: radial outward and axial.
struct Ball {
    azimuth: f64,
    /// Static load, N.
    load: f64,
    /// Contact angle, and free contact angle, rad.
    angle: f64,
    free_angle: f64,
    /// Approach of both contacts together, m.
    approach: f64,
    /// Distances of the ball's centre from the groove centres, m.
    lengths: [f64; 2],
    /// Point contacts' constants, N/m^1.5: inner, outer, in series.
    constants: [f64; 3],
    /// Distance of the groove centres, m.
    apart: f64,
}

struct Balls(Vec<Ball>);

impl Balls {
    /// Computes the balls of `angular`, the bearing without inertia and surface deviations, for the ring displacement `u`; the races
    /// are closer by `interference`.
    fn new(
        of: &BearingScene,
        g: &BallBearingGeometry,
        (angular, interference): (&Angular<f64, Exact, Vec<ElementPosition<f64>>>, f64),
        at: &BearingKinematicState<f64>,
        u: &Displacement<f64>,
    ) -> Self {
        let constants = [g.contact(Race::Inner).stiffness, g.contact(Race::Outer).stiffness, g.stiffness()];
        let (free_angle, sense) = match of.facing {
            Facing::PlusZ => (g.contact_angle, 1.0),
            Facing::MinusZ => (-g.contact_angle, -1.0),
            Facing::Both => (0.0, 1.0),
        };
        let half = 0.5 * g.ball_diameter;
        let lengths = [g.inner_conformity, g.outer_conformity].map(|f| f * g.ball_diameter - half);
        let mut centres = vec![GrooveCentres::default(); of.elements];
        if of.facing == Facing::MinusZ {
            angular.groove_centres(&u.mirrored(), &at.reversed(), &mut centres);
        } else {
            angular.groove_centres(u, at, &mut centres);
        }
        let ball = |(j, centres): (usize, &GrooveCentres<f64>)| {
            let [free, axial] = centres.distance;
            let radial = free + interference;
            let approach = centres.deflection + (radial.hypot(axial) - free.hypot(axial));
            let load = point_contact_load(constants[2], approach);
            let part = |k: f64| point_contact_approach(k, load);
            Ball {
                azimuth: build::place::<f64>(of, j).azimuth().wrapping_add(at.cage).radians(),
                load,
                angle: (sense * axial).atan2(radial),
                free_angle,
                approach,
                lengths: [lengths[0] + part(constants[0]), lengths[1] + part(constants[1])],
                constants,
                apart: radial.hypot(axial),
            }
        };
        Self(centres.iter().enumerate().map(ball).collect())
    }

    /// Returns the sum of forces in the balls' planes.
    fn sum(&self, of: impl Fn(&Ball) -> [f64; 2]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for ball in &self.0 {
            let [radial, axial] = of(ball);
            let (sin, cos) = ball.azimuth.sin_cos();
            sum = [sum[0] + radial * cos, sum[1] + radial * sin, sum[2] + axial];
        }
        sum
    }

    /// Returns the contact angle of a model with a fixed one, rad: the free angle of an angular-contact bearing; for a deep-groove
    /// bearing, which has none without load, the mean angle under this load, weighted by the loads.
    fn fixed_angle(&self, facing: Facing) -> f64 {
        match facing {
            Facing::PlusZ | Facing::MinusZ => self.0.first().map_or(0.0, |ball| ball.free_angle),
            Facing::Both => {
                let [radial, axial] = self.0.iter().map(Ball::push).fold([0.0; 2], plus);
                axial.atan2(radial)
            }
        }
    }

    /// Returns the change of force with all contact angles fixed at `fixed`, over the force.
    fn held_angle(&self, fixed: f64, force: f64) -> f64 {
        size(self.sum(|ball| {
            let off = ball.angle - fixed;
            let (sin, cos) = off.sin_cos();
            // Only the component along the fixed line deflects the contacts.
            let held = point_contact_load(ball.constants[2], ball.approach - ball.apart * (1.0 - cos));
            let (fixed_sin, fixed_cos) = fixed.sin_cos();
            let along = held - ball.load * cos;
            let across = -ball.load * sin;
            [along * fixed_cos - across * fixed_sin, along * fixed_sin + across * fixed_cos]
        })) / force
    }
}

impl Ball {
    fn push(&self) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        [self.load * cos, self.load * sin]
    }

    /// Returns the change of the force on the inner ring by a force on the ball along and across the contact.
    fn pushed(&self, along: f64, across: f64) -> [f64; 2] {
        let [inner, outer] = [self.constants[0], self.constants[1]].map(|k| k.powf(2.0 / 3.0));
        let pull = self.lengths.iter().map(|l| 1.0 / l).sum::<f64>();
        // x Q'(x) pull = F_t, whose left side grows with x.
        let load = |x: f64| point_contact_load(self.constants[2], self.approach + 0.5 * x * x * pull);
        let (mut low, mut high) = (0.0, self.apart);
        for _ in 0..ROUNDS {
            let middle = 0.5 * (low + high);
            if middle * load(middle) * pull < across.abs() { low = middle } else { high = middle }
        }
        let x = across.signum() * 0.5 * (low + high);
        let carried = (load(x) - inner / (inner + outer) * along).max(0.0);
        let (turn_sin, turn_cos) = (x / self.lengths[0]).atan().sin_cos();
        let (e, t) = (carried * turn_cos - self.load, -carried * turn_sin);
        let (sin, cos) = self.angle.sin_cos();
        [e * cos - t * sin, e * sin + t * cos]
    }
}

/// Inertia forces of the balls.
struct Inertia {
    mass: f64,
    diameter: f64,
    pitch: f64,
    inner_speed: f64,
    outer_speed: f64,
}

impl Inertia {
    fn new(of: &BearingScene, g: &BallBearingGeometry, at: &BearingKinematicState<f64>) -> Self {
        let density = of.geometry.map_or(0.0, |g| g.density);
        Self {
            mass: density * PI / 6.0 * g.ball_diameter.powi(3),
            diameter: g.ball_diameter,
            pitch: g.pitch_diameter,
            inner_speed: at.inner_speed,
            outer_speed: at.outer_speed,
        }
    }

    fn gamma(&self, ball: &Ball) -> f64 {
        self.diameter / self.pitch * ball.angle.cos()
    }

    /// Returns the orbital speed of a ball, rad/s.
    fn orbit(&self, ball: &Ball) -> f64 {
        rolling_speed(self.gamma(ball), self.inner_speed, self.outer_speed)
    }

    /// Returns the centrifugal force of a ball, N.
    fn centrifugal(&self, ball: &Ball) -> f64 {
        0.5 * self.mass * self.pitch * self.orbit(ball).powi(2)
    }

    /// Returns the magnitude of the gyroscopic moment of a ball, N m, for rolling without spin on the outer race.
    fn moment(&self, ball: &Ball) -> f64 {
        let ratio = self.diameter / self.pitch;
        let spin = (self.inner_speed - self.outer_speed) * (1.0 - self.gamma(ball).powi(2)) / (2.0 * ratio);
        let (sin, cos) = ball.angle.sin_cos();
        let pitch_angle = sin.atan2(cos + ratio);
        (0.1 * self.mass * self.diameter.powi(2) * self.orbit(ball) * spin * pitch_angle.sin()).abs()
    }

    /// Returns the change of the force on the inner ring by the centrifugal force, with or without the gyroscopic moment.
    fn change(&self, ball: &Ball, gyroscopic: bool) -> [f64; 2] {
        let (sin, cos) = ball.angle.sin_cos();
        let throw = self.centrifugal(ball);
        let moment = if gyroscopic { 2.0 * self.moment(ball) / self.diameter } else { 0.0 };
        // Both rotate the inner contact in the same sense.
        ball.pushed(throw * cos, -throw * sin - moment * sin.signum())
    }
}

/// Returns, for each bearing and effect, the entry with the largest change, in the order in which they first occur.
#[must_use]
pub fn largest(all: impl IntoIterator<Item = EffectSignificance>) -> Vec<EffectSignificance> {
    let mut largest: Vec<EffectSignificance> = Vec::new();
    for entry in all {
        match largest.iter_mut().find(|other| other.bearing == entry.bearing && other.effect == entry.effect) {
            Some(other) if entry.change > other.change => *other = entry,
            Some(_) => {}
            None => largest.push(entry),
        }
    }
    // Some points may have an effect that the first one lacks.
    let mut bearings: Vec<String> = Vec::new();
    for entry in &largest {
        if !bearings.contains(&entry.bearing) {
            bearings.push(entry.bearing.clone());
        }
    }
    largest.sort_by_key(|entry| bearings.iter().position(|name| *name == entry.bearing));
    largest
}

/// Returns lines that list, for each bearing, modelled and neglected effects with their predicted change of force, the bending of a
/// flexible rotor, and a warning for each neglected effect above `error`.
#[must_use]
pub fn describe(effects: &[EffectSignificance], error: f64) -> Vec<String> {
    let mut names: Vec<&str> = effects.iter().map(|entry| entry.bearing.as_str()).collect();
    names.dedup();
    let line = |name: &&str| {
        let of = || effects.iter().filter(|entry| entry.bearing == **name);
        let list = |modelled: bool| {
            let listed = of().filter(|entry| entry.modelled == modelled);
            let listed: Vec<String> =
                listed.map(|entry| format!("{} {}{}", entry.effect, share(entry.change), place(entry))).collect();
            if listed.is_empty() { "none".to_owned() } else { listed.join(", ") }
        };
        format!(
            "{name}: effects of this scene, as change of force if omitted: {}; omitted: {}",
            list(true),
            list(false)
        )
    };
    let warning = |entry: &EffectSignificance| {
        format!(
            "{}: WARNING: {} is omitted and predicted to change the force by {} ({}){}, more than {}",
            entry.bearing,
            entry.effect,
            share(entry.change),
            entry.because,
            place(entry),
            share(error)
        )
    };
    let lacking = effects.iter().filter(|entry| !entry.modelled && entry.change > error);
    let bends = effects.iter().find(|entry| entry.effect == BENDING);
    let bends = bends.map(|entry| {
        let at = entry.at.as_ref().map_or_else(String::new, |at| format!(" ({at})"));
        format!("bending: {}{at}", entry.because)
    });
    // Bending is an effect of the rotor, the others are of a bearing with balls.
    let is_dry = |name: &str| {
        let mut of_balls = effects.iter().filter(|entry| entry.bearing == name && entry.effect != BENDING).peekable();
        of_balls.peek().is_some() && of_balls.all(|entry| entry.effect != "film")
    };
    let dry: Vec<&str> = names.iter().copied().filter(|name| is_dry(name)).collect();
    let dry =
        (!dry.is_empty()).then(|| format!("{}: film is not considered: the scene has no lubricant", dry.join(", ")));
    names.iter().map(line).chain(bends).chain(dry).chain(lacking.map(warning)).collect()
}

/// Returns where the change is largest, as the end of a sentence.
fn place(entry: &EffectSignificance) -> String {
    entry.at.as_ref().map_or_else(String::new, |at| format!(" at {at}"))
}

#[cfg(test)]
mod tests;
