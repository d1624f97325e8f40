//! Equations of motion of one bearing between two rings.

use crate::cage::CageContact;
use crate::parameters::Params;
use crate::race::{Contact, Deviation, RaceContact};
use crate::ring::{Ring, RingMotion};
use crate::state::{BODY, BallMotion, Body, CageMotion, ElementMotion};
use ballrace::bearing::quasi_static::film::central_film;
use ballrace::bearing::surface::Surface;
use ballrace::contact::hertz::Race;
use ballrace::{BearingKinematicState, Phase};
use nalgebra::{UnitQuaternion, Vector3};

/// Numbers of the ledger behind the bodies: work of rings, gravity and drag; losses; linear and angular impulse.
const LEDGER: usize = 8;

/// Contacts of a ball: inner race, outer race, pocket.
const PER_BALL: usize = 3;

/// A bearing with its balls and cage as bodies. Its state is a slice of [`MultibodyBearing::order`] numbers: the cage, the balls, the ledger.
#[derive(Debug, Clone)]
pub struct MultibodyBearing {
    params: Params,
    races: [RaceContact; 2],
    ball_mass: f64,
    ball_inertia: f64,
    /// Directions of the pockets in the cage.
    pockets: Vec<Vector3<f64>>,
    is_smooth: bool,
}

/// Errors of the balances of a bearing since its start, each over what went through it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Balance {
    /// Energy of bodies and contacts, less work, plus losses, over the losses or the largest kinetic energy; none with waviness or damage, whose
    /// moving surfaces do work that is not counted.
    pub energy: Option<f64>,
    /// Momentum less impulse over the momentum of the fastest ball.
    pub momentum: f64,
    /// Angular momentum about the centre less its impulse, over that of all balls and cage.
    pub angular_momentum: f64,
}

/// All contacts at one time.
struct Contacts {
    cage: Body,
    balls: Vec<BallContacts>,
    /// Edges of the cage at the lands of the inner and the outer ring.
    lands: [CageContact; 4],
}

struct BallContacts {
    body: Body,
    races: [Contact; 2],
    pocket: CageContact,
}

/// Mechanical content of a state: energy, momentum, angular momentum about the origin.
struct Content {
    energy: f64,
    kinetic: f64,
    momentum: Vector3<f64>,
    angular: Vector3<f64>,
    /// Sum of the sizes of the momenta of all bodies.
    size: f64,
    angular_size: f64,
}

impl MultibodyBearing {
    /// Creates the bearing.
    #[must_use]
    pub fn new(params: Params) -> Self {
        let race =
            |race| RaceContact::new(&params.geometry, race, params.facing, params.contact_damping, params.traction);
        Self {
            races: [race(Race::Inner), race(Race::Outer)],
            ball_mass: params.ball_mass(),
            ball_inertia: params.ball_inertia(),
            pockets: params.azimuths.iter().map(|azimuth| about(radians(*azimuth)) * Vector3::x()).collect(),
            is_smooth: params.surfaces.iter().all(Surface::<f64>::is_smooth),
            params,
        }
    }

    /// Returns the parameters.
    #[must_use]
    pub const fn params(&self) -> &Params {
        &self.params
    }

    /// Returns the number of balls.
    #[must_use]
    pub fn elements(&self) -> usize {
        self.pockets.len()
    }

    /// Returns the number of numbers in a state.
    #[must_use]
    pub fn order(&self) -> usize {
        BODY * (1 + self.elements()) + LEDGER
    }

    /// Returns the number of contacts, whose approaches [`MultibodyBearing::rates`] returns.
    #[must_use]
    pub fn contacts(&self) -> usize {
        PER_BALL * self.elements() + 4
    }

    /// Writes the errors that a step may have in each number of a state; infinite for the ledger.
    ///
    /// That of a position is `step_error`; that of a velocity follows from the frequency of a ball between its races.
    pub fn tolerances(&self, tolerances: &mut [f64]) {
        let position = self.params.step_error;
        let [inner, outer] = self.races.map(|race| race.stiffness());
        let velocity = position * (1.5 * (inner + outer) * REFERENCE_APPROACH.sqrt() / self.ball_mass).sqrt();
        let spin = velocity / self.params.geometry.ball_diameter;
        let angle = 10.0 * position / self.params.geometry.ball_diameter;
        tolerances.fill(f64::INFINITY);
        for body in tolerances.chunks_exact_mut(BODY).take(1 + self.elements()) {
            for (i, tolerance) in body.iter_mut().enumerate() {
                *tolerance = match i {
                    0..3 => position,
                    3..6 => velocity,
                    6..10 => angle,
                    _ => spin,
                };
            }
        }
    }

    /// Writes the state of balls that roll between rings at these poses with the cage at angle `cage`, each at its distance
    /// from the groove of the outer race by `outer`: contact angle (rad) and approach (m).
    pub fn start(&self, rings: &[RingMotion; 2], cage: f64, outer: impl Fn(usize) -> [f64; 2], state: &mut [f64]) {
        let centre = Ring::new(&rings[1]).centre;
        state.fill(0.0);
        let (first, rest) = state.split_at_mut(BODY.min(state.len()));
        let mut speeds = 0.0;
        for (j, numbers) in rest.chunks_exact_mut(BODY).take(self.elements()).enumerate() {
            let azimuth = cage + self.params.azimuths.get(j).copied().map_or(0.0, radians);
            let [angle, approach] = outer(j);
            let [radius, axial, distance] = self.races[1].groove();
            let (sin, cos) = angle.sin_cos();
            let along = distance + approach;
            let local = about(azimuth) * Vector3::new(radius + along * cos, 0.0, axial + along * sin);
            let ring = Ring::new(&rings[1]);
            let position = ring.centre + ring.to_fixed(&local);
            let body = self.rolling(&rings.map(|r| Ring::new(&r)), position, angle);
            speeds += orbital_speed(&body);
            body.write(numbers);
        }
        let speed = speeds / self.elements() as f64;
        let cage = Body {
            position: centre,
            velocity: Vector3::zeros(),
            orientation: about(cage),
            spin: Vector3::new(0.0, 0.0, speed),
        };
        cage.write(first);
    }

    /// Returns a ball that rolls on both rings at `position` without spin on the outer race, at the contact angle `angle`.
    fn rolling(&self, rings: &[Ring; 2], position: Vector3<f64>, angle: f64) -> Body {
        let azimuth = position.y.atan2(position.x);
        let about_z = about(azimuth);
        // Directions across the contact, along the orbit, and from the outer contact inward.
        let (sin, cos) = angle.sin_cos();
        let normal = about_z * Vector3::new(-cos, 0.0, -sin);
        let across = about_z * Vector3::new(-sin, 0.0, cos);
        let orbit = about_z * Vector3::new(0.0, 1.0, 0.0);
        let radius = 0.5 * self.params.geometry.ball_diameter;
        let rho = position.x.hypot(position.y);
        let at = |orbital: f64| {
            let velocity = orbit * (orbital * rho);
            // No spin on the outer race and no slip at either contact: outer contact at -normal, inner at +normal.
            let [inner, outer] = rings;
            let slip = |ring: &Ring, side: f64| {
                let point = position + normal * (side * radius);
                (velocity - ring.velocity_at(&(point - ring.centre))).dot(&orbit)
            };
            let about_normal = outer.spin.dot(&normal);
            // (w x r) . orbit with r = -radius normal is -radius (w . across) by the sign of (normal x orbit) . across.
            let handed = normal.cross(&orbit).dot(&across);
            let outer_slip = slip(outer, -1.0);
            let about_across = outer_slip / (radius * -handed);
            let spin = normal * about_normal - across * about_across;
            let slip_of =
                |ring: &Ring, side: f64| slip(ring, side) + spin.cross(&(normal * (side * radius))).dot(&orbit);
            (velocity, spin, slip_of(inner, 1.0))
        };
        // The slip at the inner race is linear in the orbital speed.
        let (a, b) = (at(0.0).2, at(1.0).2);
        let (velocity, spin, _) = at(if a == b { 0.0 } else { a / (a - b) });
        // Axis 1 through the outer contact, axis 3 across it: the axis of rolling.
        let orientation = about_z * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -angle);
        Body { position, velocity, orientation, spin }
    }

    /// Writes the rates of a state, and the approach of each contact (m; negative with a gap). Returns force and moment on the inner and on
    /// the outer ring about their centres, N and N m.
    pub fn rates(
        &self,
        state: &[f64],
        rings: &[RingMotion; 2],
        rates: &mut [f64],
        approaches: &mut [f64],
    ) -> [[f64; 5]; 2] {
        let moved = rings.map(|ring| Ring::new(&ring));
        let contacts = self.evaluate(state, rings, &moved);
        let gravity = Vector3::from(self.params.gravity);
        let (mut force, mut moment) = ([Vector3::zeros(); 2], [Vector3::zeros(); 2]);
        let (mut on_cage, mut about_cage) = (gravity * self.params.cage.mass, Vector3::zeros());
        let mut ledger = Ledger::default();
        ledger.add(&on_cage, &contacts.cage.position, &contacts.cage.velocity);
        let (first, rest) = rates.split_at_mut(BODY);
        for (ball, numbers) in contacts.balls.iter().zip(rest.chunks_exact_mut(BODY)) {
            let body = &ball.body;
            let drag = body.velocity * (-self.params.drag * body.velocity.norm());
            let outside = gravity * self.ball_mass + drag;
            ledger.add(&outside, &body.position, &body.velocity);
            let (mut on_ball, mut about_ball) = (outside, Vector3::zeros());
            for (i, (contact, ring)) in ball.races.iter().zip(&moved).enumerate() {
                on_ball += contact.force;
                about_ball += contact.moment;
                let arm = body.position - ring.centre;
                force[i] -= contact.force;
                moment[i] -= arm.cross(&contact.force) + contact.moment;
                ledger.loss += contact.traction_loss + contact.damping_loss;
            }
            let pocket = &ball.pocket;
            on_ball += pocket.force;
            about_ball += (pocket.point - body.position).cross(&pocket.force);
            on_cage -= pocket.force;
            about_cage -= (pocket.point - contacts.cage.position).cross(&pocket.force);
            ledger.loss += pocket.loss;
            body.write_rates(numbers, &(on_ball / self.ball_mass), &(about_ball / self.ball_inertia));
        }
        for (i, land) in contacts.lands.iter().enumerate() {
            let (which, ring) = (i / 2, &moved[i / 2]);
            force[which] += land.force;
            moment[which] += (land.point - ring.centre).cross(&land.force);
            on_cage -= land.force;
            about_cage -= (land.point - contacts.cage.position).cross(&land.force);
            ledger.loss += land.loss;
        }
        for (i, ring) in moved.iter().enumerate() {
            ledger.add_reaction(&force[i], &moment[i], ring);
        }
        let cage = &contacts.cage;
        let angular = self.cage_acceleration(cage, &about_cage);
        cage.write_rates(first, &(on_cage / self.params.cage.mass), &angular);
        if let Some(numbers) = rest.get_mut(BODY * self.elements()..) {
            numbers.iter_mut().zip(ledger.numbers()).for_each(|(rate, value)| *rate = value);
        }
        contacts.write_approaches(approaches);
        std::array::from_fn(|i| [force[i].x, force[i].y, force[i].z, moment[i].x, moment[i].y])
    }

    /// Returns motion and contacts of balls and cage.
    #[must_use]
    pub fn motion(&self, state: &[f64], rings: &[RingMotion; 2]) -> ElementMotion {
        let moved = rings.map(|ring| Ring::new(&ring));
        let contacts = self.evaluate(state, rings, &moved);
        let mut loss = [0.0; 4];
        let balls = contacts.balls.iter().map(|ball| {
            let body = &ball.body;
            let azimuth = body.position.y.atan2(body.position.x);
            let orbit = Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0);
            let outward = Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
            for contact in &ball.races {
                loss[0] += contact.traction_loss;
                loss[1] += contact.damping_loss;
            }
            loss[2] += ball.pocket.loss;
            loss[3] += self.params.drag * body.velocity.norm().powi(3);
            let [inner, outer] = ball.races;
            BallMotion {
                azimuth,
                orbital_speed: orbital_speed(body),
                spin: [body.spin.dot(&outward), body.spin.dot(&orbit), body.spin.z],
                load: [inner.load, outer.load],
                contact_angle: [inner.angle(), outer.angle()],
                slip: [inner.slip, outer.slip],
                contact_spin: [inner.spin, outer.spin],
                film: self.film(&ball.races, orbital_speed(body), [rings[0].speed, rings[1].speed]),
                pocket_force: ball.pocket.force.dot(&orbit),
            }
        });
        let balls: Vec<BallMotion> = balls.collect();
        loss[2] += contacts.lands.iter().map(|land| land.loss).sum::<f64>();
        let axis = contacts.cage.orientation * Vector3::z();
        let cage = CageMotion {
            speed: contacts.cage.spin.z,
            centre: (contacts.cage.position - moved[self.params.cage.guide().unwrap_or(1)].centre).into(),
            tilt: axis.x.hypot(axis.y).atan2(axis.z),
            land_force: contacts.lands.iter().map(|land| land.load).sum(),
        };
        let rolling_speed = self.rolling_speed(&balls, [rings[0].speed, rings[1].speed]);
        ElementMotion { balls, cage, loss, rolling_speed }
    }

    /// Returns the central film thickness of Hamrock and Dowson at both contacts of a ball, isothermal and without slip, m.
    fn film(&self, contacts: &[Contact; 2], orbital: f64, rings: [f64; 2]) -> [f64; 2] {
        let Some(oil) = self.params.oil else { return [0.0; 2] };
        let geometry = &self.params.geometry;
        let ratio = geometry.ball_diameter / geometry.pitch_diameter;
        [(Race::Inner, -1.0), (Race::Outer, 1.0)].map(|(race, side)| {
            let i = usize::from(side > 0.0);
            let Contact { load, direction: [cos, _], .. } = contacts[i];
            if load <= 0.0 {
                return 0.0;
            }
            let arm = 0.5 * geometry.pitch_diameter * (1.0 + side * ratio * cos);
            let contact = geometry.contact(race);
            let along = 0.5 * geometry.ball_diameter * (1.0 + side * geometry.gamma());
            central_film(
                oil,
                contact.effective_modulus,
                along,
                contact.ellipticity,
                (rings[i] - orbital).abs() * arm,
                load,
            )
        })
    }

    /// Returns the orbital speed of balls that roll at their mean contact angles without spin on the outer race, rad/s (Harris and Kotzalas):
    /// `w_o + (w_i - w_o)(1 - D/d_m cos(a_i))/(1 + cos(a_i - a_o))`.
    fn rolling_speed(&self, balls: &[BallMotion], [inner, outer]: [f64; 2]) -> f64 {
        let geometry = &self.params.geometry;
        let mean = |race: usize| {
            let weighted = |(sum, all): (f64, f64), ball: &BallMotion| {
                (sum + ball.load[race] * ball.contact_angle[race], all + ball.load[race])
            };
            let (sum, all) = balls.iter().fold((0.0, 0.0), weighted);
            if all > 0.0 { sum / all } else { geometry.contact_angle }
        };
        let [at_inner, at_outer] = [mean(0), mean(1)];
        let ratio = geometry.ball_diameter / geometry.pitch_diameter;
        outer + (inner - outer) * (1.0 - ratio * at_inner.cos()) / (1.0 + (at_inner - at_outer).cos())
    }

    /// Turns balls and cage about the axis, rad.
    pub fn turn(&self, state: &mut [f64], by: f64) {
        let by = about(by);
        for numbers in state.chunks_exact_mut(BODY).take(1 + self.elements()) {
            Body::read(numbers).turned(&by).write(numbers);
        }
    }

    /// Gives each orientation of a state the length 1.
    pub fn normalise(&self, state: &mut [f64]) {
        for numbers in state.chunks_exact_mut(BODY).take(1 + self.elements()) {
            Body::read(numbers).write(numbers);
        }
    }

    /// Returns the errors of the balances between two states with their rings.
    #[must_use]
    pub fn balance(&self, from: (&[f64], &[RingMotion; 2]), to: (&[f64], &[RingMotion; 2])) -> Balance {
        let [a, b] = [from, to].map(|(state, rings)| self.content(state, rings));
        let ledger = |state: &[f64], i: usize| state.get(BODY * (1 + self.elements()) + i).copied().unwrap_or(0.0);
        let grown = |i: usize| ledger(to.0, i) - ledger(from.0, i);
        let impulse = |first: usize| Vector3::new(grown(first), grown(first + 1), grown(first + 2));
        let over = |error: f64, size: f64| if error == 0.0 { 0.0 } else { error.abs() / size };
        let (work, loss) = (grown(0), grown(1));
        Balance {
            energy: self.is_smooth.then(|| over(b.energy - a.energy - work + loss, loss.max(a.kinetic).max(b.kinetic))),
            momentum: over((b.momentum - a.momentum - impulse(2)).norm(), a.size.max(b.size)),
            angular_momentum: over((b.angular - a.angular - impulse(5)).norm(), a.angular_size.max(b.angular_size)),
        }
    }

    fn content(&self, state: &[f64], rings: &[RingMotion; 2]) -> Content {
        let contacts = self.evaluate(state, rings, &rings.map(|ring| Ring::new(&ring)));
        let mut content = Content {
            energy: 0.0,
            kinetic: 0.0,
            momentum: Vector3::zeros(),
            angular: Vector3::zeros(),
            size: 0.0,
            angular_size: 0.0,
        };
        let cage = &contacts.cage;
        content.add(cage, self.params.cage.mass, &self.cage_momentum(cage));
        for ball in &contacts.balls {
            content.add(&ball.body, self.ball_mass, &(ball.body.spin * self.ball_inertia));
            content.energy += ball.races.iter().map(|contact| contact.energy).sum::<f64>() + ball.pocket.energy;
        }
        content.energy += contacts.lands.iter().map(|land| land.energy).sum::<f64>() + content.kinetic;
        content
    }

    /// Returns the angular momentum of the cage, kg m^2/s.
    fn cage_momentum(&self, cage: &Body) -> Vector3<f64> {
        let [across, along] = self.params.cage.inertia;
        let own = cage.orientation.inverse_transform_vector(&cage.spin);
        cage.orientation * Vector3::new(across * own.x, across * own.y, along * own.z)
    }

    /// Returns the angular acceleration of the cage by Euler's equation, rad/s^2.
    fn cage_acceleration(&self, cage: &Body, moment: &Vector3<f64>) -> Vector3<f64> {
        let [across, along] = self.params.cage.inertia;
        let left = moment - cage.spin.cross(&self.cage_momentum(cage));
        let own = cage.orientation.inverse_transform_vector(&left);
        cage.orientation * Vector3::new(own.x / across, own.y / across, own.z / along)
    }

    fn evaluate(&self, state: &[f64], rings: &[RingMotion; 2], moved: &[Ring; 2]) -> Contacts {
        let mut bodies = state.chunks_exact(BODY).map(Body::read);
        let none = Body::read(&[]);
        let cage = bodies.next().unwrap_or(none);
        let params = &self.params.cage;
        let radius = 0.5 * self.params.geometry.ball_diameter;
        let balls = self.pockets.iter().zip(bodies).enumerate().map(|(j, (pocket, body))| {
            let deviation =
                if self.is_smooth { <[Deviation; 2]>::default() } else { self.deviation(j, &body, rings, moved) };
            let races = std::array::from_fn(|i| self.races[i].evaluate(&body, &moved[i], &deviation[i]));
            let pocket = params.pocket(&cage, &body, &(cage.orientation * pocket), radius);
            BallContacts { body, races, pocket }
        });
        let land = |i: usize| params.land(&cage, &moved[i / 2], i / 2, if i.is_multiple_of(2) { 1.0 } else { -1.0 });
        Contacts { cage, balls: balls.collect(), lands: std::array::from_fn(land) }
    }

    /// Returns the deviations of the surfaces at both contacts of ball `j`.
    fn deviation(&self, j: usize, ball: &Body, rings: &[RingMotion; 2], moved: &[Ring; 2]) -> [Deviation; 2] {
        let azimuth = Phase::from_radians(ball.position.y.atan2(ball.position.x));
        let [inner, outer, balls] = &self.params.surfaces;
        let at = BearingKinematicState::<f64> { inner: rings[0].angle, outer: rings[1].angle, ..Default::default() };
        let (on_inner, on_outer) = (inner.deviation(azimuth, &at), outer.deviation(azimuth, &at));
        // Surfaces of a ball turn about its axis 3; the inner race was on the negative side of its axis 1 at the start.
        let height = |race: usize| {
            let direction = self.races[race].direction(ball, &moved[race]);
            let local = ball.orientation.inverse_transform_vector(&direction);
            let place = self.params.azimuths.get(j).copied().unwrap_or_default();
            let angle = Phase::from_radians(local.y.atan2(-local.x));
            balls.deviation(place, &BearingKinematicState { ball: angle, ..Default::default() }).inner
        };
        [
            Deviation { radial: on_inner.radial, axial: on_inner.axial, approach: on_inner.inner + height(0) },
            Deviation { radial: -on_outer.radial, axial: -on_outer.axial, approach: on_outer.outer + height(1) },
        ]
    }
}

/// Approach at which the frequency of a ball sets the tolerance of its velocity, m.
const REFERENCE_APPROACH: f64 = 5e-6;

/// Returns the rotation about Z, rad.
fn about(angle: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle)
}

fn radians(phase: Phase) -> f64 {
    phase.since(Phase::ZERO).radians()
}

/// Returns the angular velocity of a body's centre about Z, rad/s.
fn orbital_speed(body: &Body) -> f64 {
    let (r, v) = (&body.position, &body.velocity);
    (r.x * v.y - r.y * v.x) / (r.x * r.x + r.y * r.y)
}

impl Contacts {
    fn write_approaches(&self, approaches: &mut [f64]) {
        let of_balls = self.balls.iter().flat_map(|ball| {
            let [inner, outer] = ball.races;
            [inner.approach, outer.approach, ball.pocket.approach]
        });
        let all = of_balls.chain(self.lands.iter().map(|land| land.approach));
        approaches.iter_mut().zip(all).for_each(|(entry, approach)| *entry = approach);
    }
}

impl Content {
    fn add(&mut self, body: &Body, mass: f64, spin: &Vector3<f64>) {
        let momentum = body.velocity * mass;
        let angular = body.position.cross(&momentum) + spin;
        self.kinetic += 0.5 * (momentum.dot(&body.velocity) + spin.dot(&body.spin));
        self.momentum += momentum;
        self.angular += angular;
        self.size += momentum.norm();
        self.angular_size += angular.norm();
    }
}

/// Power and rates of impulse from outside the balls and cage.
#[derive(Default)]
struct Ledger {
    power: f64,
    loss: f64,
    force: Vector3<f64>,
    moment: Vector3<f64>,
}

impl Ledger {
    /// Adds a force at the centre of a body.
    fn add(&mut self, force: &Vector3<f64>, at: &Vector3<f64>, velocity: &Vector3<f64>) {
        self.power += force.dot(velocity);
        self.force += force;
        self.moment += at.cross(force);
    }

    /// Adds the reaction to force and moment on a ring about its centre.
    fn add_reaction(&mut self, force: &Vector3<f64>, moment: &Vector3<f64>, ring: &Ring) {
        self.add(&-force, &ring.centre, &ring.velocity);
        self.power -= moment.dot(&ring.spin);
        self.moment -= moment;
    }

    fn numbers(&self) -> [f64; LEDGER] {
        let Self { power, loss, force: f, moment: m } = self;
        [*power, *loss, f.x, f.y, f.z, m.x, m.y, m.z]
    }
}
