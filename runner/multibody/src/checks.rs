//! Checks of the model against closed forms, conservation laws and balls in equilibrium. `--nocapture` prints each as a row of a table.

use crate::state::{BODY, Body};
use crate::{Integrator, Motion, MultibodyBearing, Params, RingMotion, TractionCurve};
use ballrace::bearing::kinematics::orders;
use ballrace::bearing::quasi_static::BallState;
use ballrace::contact::hertz::Race;
use ballrace::{BearingKinematicState, Displacement, Phase};
use ballrace_models::build;
use ballrace_scene::Scene;
use ballrace_scene::read::read_str;
use nalgebra::Vector3;
use std::path::Path;

/// Prints a row of the table of checks.
fn row(check: &str, error: f64, limit: f64) {
    println!("| {check} | {error:.1e} | {limit:.0e} |");
    assert!(error <= limit, "{check}: {error:e}, expected at most {limit:e}");
}

/// A bearing between two rings that do not vibrate.
struct Rig {
    bearing: MultibodyBearing,
    rings: [RingMotion; 2],
    /// Angle of the balls in equilibrium about their own axes.
    spin: Phase,
}

impl Motion for Rig {
    fn rates(&mut self, time: f64, state: &[f64], rates: &mut [f64], approaches: &mut [f64]) {
        let rings = self
            .rings
            .map(|ring| RingMotion { angle: ring.angle.wrapping_add(Phase::from_radians(ring.speed * time)), ..ring });
        self.bearing.rates(state, &rings, rates, approaches);
    }
    fn normalise(&self, state: &mut [f64]) {
        self.bearing.normalise(state);
    }
}

impl Rig {
    fn new(scene: &Scene, inner: [f64; 5], speed: f64) -> Self {
        let ring = RingMotion { displacement: inner, speed, ..RingMotion::default() };
        let bearing = MultibodyBearing::new(Params::of(scene, &scene.bearings[0]).unwrap());
        Self { bearing, rings: [ring, RingMotion::default()], spin: Phase::ZERO }
    }

    /// Returns the state of balls in equilibrium.
    fn start(&self, scene: &Scene) -> Vec<f64> {
        let balls = self.equilibrium(scene, Phase::ZERO);
        let stiffness = self.bearing.params().geometry.contact(Race::Outer).stiffness;
        let outer = |j: usize| {
            let [cos, sin] = balls[j].outer_direction;
            [sin.atan2(cos), build::point_contact_approach(stiffness, balls[j].outer_load)]
        };
        let mut state = vec![0.0; self.bearing.order()];
        self.bearing.start(&self.rings, 0.0, outer, &mut state);
        state
    }

    fn equilibrium(&self, scene: &Scene, cage: Phase) -> Vec<BallState<f64>> {
        let mut balls = vec![BallState::default(); self.bearing.elements()];
        let RingMotion { angle: inner, speed: inner_speed, .. } = self.rings[0];
        let at =
            BearingKinematicState { cage, inner, ball: self.spin, inner_speed, ..BearingKinematicState::default() };
        let u = Displacement::from_array(self.rings[0].displacement);
        build::quasi_static(&scene.bearings[0]).unwrap().ball_states(&u, &at, &mut balls);
        balls
    }

    fn integrator(&self) -> Integrator {
        let mut tolerances = vec![0.0; self.bearing.order()];
        self.bearing.tolerances(&mut tolerances);
        Integrator::new(tolerances, self.bearing.contacts())
    }

    /// Advances the state by `duration`, s.
    fn run(&mut self, state: &mut [f64], duration: f64) {
        let mut integrator = self.integrator();
        assert!(integrator.advance(self, state, duration));
    }
}

fn scene(facing: &str, angle: &str, more: &str) -> Scene {
    let text = format!(
        "[shaft]\nspeed = 0\n[[bearing]]\nname = \"B\"\nmodel = \"multibody\"\nelements = 9\nball_diameter = \"7.94 mm\"\n\
         pitch_diameter = \"39.04 mm\"\ninner_conformity = 0.52\nouter_conformity = 0.52\ndensity = 7800\n\
         facing = \"{facing}\"\n{angle}\n{more}\n"
    );
    read_str(&text, Path::new("scene.toml")).unwrap()
}

const FIFTEEN: &str = "contact_angle = \"15 deg\"";
const WITHOUT_FRICTION: &str = "traction_peak = 0\ncontact_damping = 0\ncage_damping = 0\ncage_friction = 0\n";

fn ball(state: &mut [f64], j: usize) -> &mut [f64] {
    &mut state[BODY * (1 + j)..BODY * (2 + j)]
}

#[test]
fn traction_has_its_peak_its_limit_and_no_slope_at_the_peak() {
    let curve = TractionCurve::with_peak(0.06, 0.2, 0.045);
    row("traction at its peak", (curve.coefficient(0.2) - 0.06).abs(), 1e-12);
    row("traction at 100 m/s", (curve.coefficient(100.0) - 0.045).abs(), 1e-12);
    let slope = (curve.coefficient(0.2 + 1e-6) - curve.coefficient(0.2 - 1e-6)) / 2e-6;
    row("slope of the traction at its peak, s/m", slope.abs(), 1e-6);
    row("traction without slip", curve.coefficient(0.0), 0.0);
    let mu = |s: f64| curve.coefficient(s);
    // A ratio without digits of the difference would jump where its series ends.
    row("jump of the ratio at small slip", (mu(1.247e-5) / 1.247e-5 / (mu(1.248e-5) / 1.248e-5) - 1.0).abs(), 1e-7);
    assert_eq!(TractionCurve::with_peak(0.0, 0.2, 0.045).coefficient(1.0), 0.0);
}

/// A ball between rings with play falls as a stone.
#[test]
fn free_flight() {
    let mut scene = scene("both", "diametral_clearance = \"300 um\"", "pocket_clearance = \"2 mm\"");
    scene.bearings[0].own.push(("step_error", 1e-10));
    let mut rig = Rig::new(&scene, [0.0; 5], 0.0);
    let mut params = rig.bearing.params().clone();
    params.gravity = [0.0, -9.81, 0.0];
    rig.bearing = MultibodyBearing::new(params);
    let mut state = rig.start(&scene);
    for j in 0..9 {
        let mut body = Body::read(ball(&mut state, j));
        body.position *= 19.52e-3 / body.position.norm();
        (body.velocity, body.spin) = (Vector3::new(0.01, 0.02, 0.005), Vector3::new(100.0, 0.0, 50.0));
        body.write(ball(&mut state, j));
    }
    let start = state.clone();
    let time = 2e-3;
    rig.run(&mut state, time);
    let error = (0..9).map(|j| {
        let (from, to) = (Body::read(&start[BODY * (1 + j)..]), Body::read(ball(&mut state, j)));
        let fallen = from.position + from.velocity * time + Vector3::new(0.0, -9.81, 0.0) * (0.5 * time * time);
        (to.position - fallen).norm() + (to.spin - from.spin).norm()
    });
    row("free flight: position, m", error.fold(0.0, f64::max), 1e-15);
}

/// A ball thrown at the outer race: time of contact `2.9432 delta/v` and greatest approach `(5 m v^2/(4 K))^(2/5)` of Hertz's impact, restitution
/// `1 - alpha v` of Hunt and Crossley.
#[test]
fn impact() {
    let geometry = "diametral_clearance = \"300 um\"";
    for (damping, speed, limit) in [(0.0, 0.1, 1e-4), (0.2, 0.01, 1e-4)] {
        let more = format!("traction_peak = 0\npocket_clearance = \"2 mm\"\ncontact_damping = {damping}");
        let mut scene = scene("both", geometry, &more);
        scene.bearings[0].own.push(("step_error", 1e-14));
        let mut rig = Rig::new(&scene, [0.0; 5], 0.0);
        let mut state = rig.start(&scene);
        let mut body = Body::read(ball(&mut state, 0));
        let [radius, _, distance] =
            crate::race::RaceContact::new(&rig.bearing.params().geometry, Race::Outer, 0.0, 0.0, TractionCurve::NONE)
                .groove();
        body.position = Vector3::new(radius + distance, 0.0, 0.0);
        body.velocity = Vector3::new(speed, 0.0, 0.0);
        body.write(ball(&mut state, 0));
        let stiffness = rig.bearing.params().geometry.contact(Race::Outer).stiffness;
        let mass = rig.bearing.params().ball_mass();
        let deepest = (1.25 * mass * speed * speed / stiffness).powf(0.4);
        let duration = 2.943_274 * deepest / speed;
        if damping == 0.0 {
            let mut half = state.clone();
            rig.run(&mut half, 0.5 * duration);
            let approach = Body::read(ball(&mut half, 0)).position.x - radius - distance;
            row("impact: greatest approach", (approach / deepest - 1.0).abs(), limit);
        }
        let mut before = state.clone();
        rig.run(&mut before, 0.999 * duration);
        assert!(Body::read(ball(&mut before, 0)).position.x > radius + distance, "still in contact");
        rig.run(&mut state, 1.01 * duration);
        let after = Body::read(ball(&mut state, 0));
        assert!(after.position.x < radius + distance, "out of contact");
        let restitution = -after.velocity.x / speed;
        let name = if damping == 0.0 { "impact: rebound without damping" } else { "impact: rebound 1 - alpha v" };
        row(name, (restitution - (1.0 - damping * speed)).abs(), limit);
    }
}

#[test]
fn conservation() {
    conserves("10^5", 100_000);
}

#[test]
#[ignore = "slow: a million steps; tests/run --all runs it"]
fn conservation_over_a_million_steps() {
    conserves("10^6", 1_000_000);
}

/// Three loaded balls that vibrate between the rings of a shaft at 10 000 rpm and in their pockets, without friction.
fn conserves(name: &str, steps: u64) {
    let mut scene = scene("+z", FIFTEEN, &format!("{WITHOUT_FRICTION}step_error = 1e-12"));
    scene.bearings[0].elements = 3;
    let mut rig = Rig::new(&scene, [0.0, -2e-6, 34e-6, 20e-6, 0.0], 10_000.0 * std::f64::consts::TAU / 60.0);
    let mut state = rig.start(&scene);
    for j in 0..3 {
        let mut body = Body::read(ball(&mut state, j));
        body.velocity += Vector3::new(0.02 * j as f64, 0.03, 0.01);
        body.write(ball(&mut state, j));
    }
    let start = state.clone();
    let mut integrator = rig.integrator();
    while integrator.steps().taken < steps {
        assert!(integrator.advance(&mut rig, &mut state, 0.01));
    }
    let balance = rig.bearing.balance((&start, &rig.rings), (&state, &rig.rings));
    for (of, error, limit) in [
        ("energy", balance.energy.unwrap(), 1e-3),
        ("momentum", balance.momentum, 1e-11),
        ("angular momentum", balance.angular_momentum, 1e-9),
    ] {
        row(&format!("{name} steps without friction: {of}"), error, limit);
    }
}

/// At moderate load: loads and contact angles of balls in equilibrium, cage and spin of pure rolling.
#[test]
fn steady_state() {
    let oil = "lubricant = { viscosity = \"0.02 Pa s\", pressure_viscosity = \"2e-8 1/Pa\" }";
    let scene = scene("+z", FIFTEEN, &format!("outer_land_clearance = \"0.4 mm\"\n{oil}"));
    // A film changes the loads of balls in equilibrium a little, and its thickness hardly.
    let mut wet = scene.clone();
    wet.bearings[0].effects.film = wet.bearings[0].lubricant;
    let speed = 10_000.0 * std::f64::consts::TAU / 60.0;
    // 1 kN of thrust and 300 N across.
    let mut rig = Rig::new(&scene, [0.0, -2e-6, 34e-6, 20e-6, 0.0], speed);
    let mut state = rig.start(&scene);
    let start = state.clone();
    let first = rig.rings;
    rig.run(&mut state, 0.03);
    let motion = rig.bearing.motion(&state, &rig.rings);
    let (mut load, mut angle, mut film) = (0.0_f64, 0.0_f64, 0.0_f64);
    for (j, ball) in motion.balls.iter().enumerate() {
        let azimuth = rig.bearing.params().azimuths[j];
        let cage = Phase::from_radians(ball.azimuth).wrapping_add(azimuth.reversed());
        let still = rig.equilibrium(&scene, cage)[j];
        let angles = [still.inner_direction, still.outer_direction].map(|[cos, sin]| sin.atan2(cos));
        for race in 0..2 {
            load = load.max((ball.load[race] / [still.inner_load, still.outer_load][race] - 1.0).abs());
            angle = angle.max((ball.contact_angle[race] / angles[race] - 1.0).abs());
        }
        let wet = rig.equilibrium(&wet, cage)[j];
        for (found, expected) in ball.film.iter().zip([wet.inner_film, wet.outer_film]) {
            film = film.max((found / expected - 1.0).abs());
        }
    }
    row("steady state: load of a ball against quasi-static", load, 1e-2);
    row("steady state: contact angle against quasi-static", angle, 1e-2);
    row("steady state: film against quasi-static", film, 2e-2);
    let mean = motion.balls.iter().map(|ball| ball.orbital_speed).sum::<f64>() / 9.0;
    row("steady state: orbital speed against pure rolling", (mean / motion.rolling_speed - 1.0).abs(), 5e-3);
    let balance = rig.bearing.balance((&start, &first), (&state, &rig.rings));
    row("steady state: balance of energy", balance.energy.unwrap(), 1e-3);
    row("steady state: balance of angular momentum", balance.angular_momentum, 1e-3);
    // Neither race controls the spin: both share it.
    let share = |ball: &crate::BallMotion| {
        let [inner, outer] = ball.contact_spin.map(f64::abs);
        outer / (inner + outer)
    };
    let shares: Vec<f64> = motion.balls.iter().map(share).collect();
    assert!(
        shares.iter().all(|share| (0.4..0.5).contains(share)),
        "spin on the outer race over that on both: {shares:?}"
    );
}

/// A slow bearing with wavy and damaged races and balls: loads of balls in equilibrium on the same surfaces, over a turn of a ball.
#[test]
fn surfaces() {
    let wavy = "waviness = [{ surface = \"inner\", order = 5, amplitude = \"1 um\", phase = \"40 deg\" }, \
                { surface = \"outer\", direction = \"axial\", order = 3, amplitude = \"1 um\" }, \
                { surface = \"ball\", order = 2, amplitude = \"1 um\", phase = \"70 deg\" }]\n";
    let damaged = "defect = [{ surface = \"outer\", azimuth = \"0 deg\", half_width = \"12 deg\", depth = \"2 um\", shape = \"half-sine\" }, \
                   { surface = \"ball\", element = 4, azimuth = \"90 deg\", half_width = \"40 deg\", depth = \"2 um\", shape = \"half-sine\" }]";
    let scene = scene("+z", FIFTEEN, &format!("{wavy}{damaged}"));
    let speed = 300.0 * std::f64::consts::TAU / 60.0;
    let mut rig = Rig::new(&scene, [0.0, 0.0, 20e-6, 0.0, 0.0], speed);
    let mut state = rig.start(&scene);
    let smooth = self::scene("+z", FIFTEEN, "");
    let ratio = 7.94 / 39.04;
    let (time, mut error, mut largest) = (0.008, 0.0_f64, 0.0_f64);
    for part in 1..=12 {
        rig.run(&mut state, time);
        let turned = speed * time * f64::from(part);
        rig.rings[0].angle = Phase::from_radians(turned);
        let motion = rig.bearing.motion(&state, &rig.rings);
        for (j, ball) in motion.balls.iter().enumerate() {
            let azimuth = rig.bearing.params().azimuths[j];
            let cage = Phase::from_radians(ball.azimuth).wrapping_add(azimuth.reversed());
            // The balls turn against the inner ring.
            rig.spin = Phase::from_radians(-orders(9, ratio * ball.contact_angle[0].cos(), ratio).ball_spin * turned);
            let [still, even] = [&scene, &smooth].map(|scene| rig.equilibrium(scene, cage)[j]);
            for (found, expected) in ball.load.iter().zip([still.inner_load, still.outer_load]) {
                error = error.max((found / expected - 1.0).abs());
            }
            largest = largest.max((even.inner_load / still.inner_load - 1.0).abs());
        }
    }
    assert!(largest > 0.3, "the surfaces change the loads by {largest}");
    row("wavy and damaged races and balls: load against quasi-static", error, 4e-2);
    assert_eq!(rig.bearing.balance((&state, &rig.rings), (&state, &rig.rings)).energy, None);
}

/// A slow bearing under pure thrust: speeds of cage and balls in pure rolling at the contact angle.
#[test]
fn pure_rolling() {
    let scene = scene("+z", FIFTEEN, "");
    let speed = 500.0 * std::f64::consts::TAU / 60.0;
    let mut rig = Rig::new(&scene, [0.0, 0.0, 20e-6, 0.0, 0.0], speed);
    let mut state = rig.start(&scene);
    rig.run(&mut state, 0.02);
    let motion = rig.bearing.motion(&state, &rig.rings);
    let geometry = &rig.bearing.params().geometry;
    let one = motion.balls[0];
    let ratio = geometry.ball_diameter / geometry.pitch_diameter;
    let expected = orders(9, ratio * one.contact_angle[0].cos(), ratio);
    row("pure rolling: speed of the cage", (motion.cage.speed / speed / expected.cage - 1.0).abs(), 3e-3);
    let [outward, _, axial] = one.spin;
    let against_cage = outward.hypot(axial - motion.cage.speed);
    row("pure rolling: spin of a ball", (against_cage / speed / expected.ball_spin - 1.0).abs(), 2e-2);
}
