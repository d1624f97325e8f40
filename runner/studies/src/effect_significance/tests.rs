#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use ballrace_plant::MountedBearing;
use ballrace_scene::read::read_str;
use std::path::Path;

/// Scenes of the grid.
const SCENES: u64 = 500;
/// Changes below this are not compared.
const LEAST: f64 = 1e-3;

/// Numbers that look random and are the same everywhere: the fractional parts of multiples of irrational numbers.
fn unit(i: u64, stride: f64) -> f64 {
    (i as f64 * stride).fract()
}

/// Bearings from spindles to gearboxes: preload by force or displacement or radial load alone, any speed up to a dmN of 1.5e6.
fn scene(i: u64) -> String {
    let sizes = [(16, 22.23, 125.26, 0.5232), (14, 7.0, 38.5, 0.52), (20, 9.525, 75.0, 0.53), (9, 7.94, 39.04, 0.52)];
    let (elements, ball, pitch, conformity) = sizes[(i % 4) as usize];
    let angle = [15.0, 25.0, 40.0, 30.0][((i / 4) % 4) as usize];
    // Up to where a twentieth of the static limit is reached, and down to a hundredth of that.
    let heavy = 0.6 * elements as f64 * ball * ball;
    let force = heavy * 0.01_f64.powf(unit(i, 0.618_034));
    let (pushed, clearance) = (2.0 + 12.0 * unit(i, 0.302_776), 4.0 + 20.0 * unit(i, 0.302_776));
    // About what a ball carries, N; 1e10 N/m^1.5 is a usual contact.
    let about = match (i / 16) % 3 {
        0 => force / elements as f64 / f64::to_radians(angle).sin(),
        1 => 1e10 * (pushed * 1e-6 * f64::to_radians(angle).sin()).powf(1.5),
        _ => 1e10 * ((20.0 - 0.5 * clearance) * 1e-6).powf(1.5),
    };
    // Balls thrown outward by a five-hundredth to a third of that.
    let thrown = about * 0.002 * 150_f64.powf(unit(i, 0.414_214));
    let mass = 7800.0 * PI / 6.0 * (ball * 1e-3_f64).powi(3);
    let speed = 2.2 * (2.0 * thrown / mass / (pitch * 1e-3)).sqrt();
    let mounted = match (i / 16) % 3 {
        0 => format!("facing = \"+z\"\ncontact_angle = \"{angle} deg\"\npreload = {{ force = \"{force} N\" }}"),
        1 => format!(
            "facing = \"-z\"\ncontact_angle = \"{angle} deg\"\npreload = {{ displacement = \"{} um\" }}",
            2.0 + 12.0 * unit(i, 0.302_776)
        ),
        _ => format!("facing = \"both\"\ndiametral_clearance = \"{} um\"", 4.0 + 20.0 * unit(i, 0.302_776)),
    };
    format!(
        "[shaft]\nspeed = \"{} rpm\"\n[[bearing]]\nname = \"A\"\nstation = 0\nmodel = \"quasi-static\"\nelements = {elements}\n\
         ball_diameter = \"{ball} mm\"\npitch_diameter = \"{pitch} mm\"\ninner_conformity = {conformity}\nouter_conformity = {conformity}\n\
         lubricant = {{ viscosity = \"{} Pa s\", pressure_viscosity = \"2e-8 1/Pa\" }}\neffects = [\"centrifugal\", \"gyroscopic\", \"film\"]\n{mounted}\n",
        speed * 60.0 / (2.0 * PI),
        0.005 * 20_f64.powf(unit(i, 0.236_068)),
    )
}

/// Further displacement of the bearing by the rotor.
fn pushed(i: u64, of: &BearingScene) -> Displacement<f64> {
    let part = |stride: f64| 2.0 * unit(i, stride) - 1.0;
    let radial = 3e-6 * unit(i, 0.732_051);
    match of.facing {
        // Loaded along the radius and a little along the axis, through the clearance.
        Facing::Both => Displacement {
            u: 20e-6 + radial,
            v: 5e-6 * part(0.645_751),
            w: 5e-6 * part(0.162_278),
            ..Displacement::default()
        },
        _ => Displacement {
            u: 0.5 * radial * part(0.316_625),
            v: 0.5 * radial,
            thu: 1e-5 * part(0.872_983),
            ..Displacement::default()
        },
    }
}

fn force(mounted: &MountedBearing, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> [f64; 3] {
    let f = mounted.bearing.reaction(u, at).wrench;
    [f.fx, f.fy, f.fz]
}

fn apart(f: [f64; 3], g: [f64; 3]) -> f64 {
    size([f[0] - g[0], f[1] - g[1], f[2] - g[2]])
}

#[test]
fn predictions_are_within_a_factor_of_two() {
    let effects = ["centrifugal", "gyroscopic", "film", "contact-angle", "moving-balls"];
    let mut ratios = vec![Vec::new(); effects.len()];
    for i in 0..SCENES {
        let scene = read_str(&scene(i), Path::new("grid.toml")).unwrap();
        let of = &scene.bearings[0];
        let u = pushed(i, of);
        let oil = of.effects.film;
        let at = BearingKinematicState {
            inner_speed: scene.shaft.speed.nominal(),
            ..BearingKinematicState::from(Phase::ZERO)
        };
        let with = |centrifugal: bool, gyroscopic: bool, film: bool| {
            let effects = Effects { centrifugal, gyroscopic, film: oil.filter(|_| film), ..of.effects };
            MountedBearing::new(&scene, &BearingScene { effects, ..of.clone() }).unwrap()
        };
        let still = with(false, false, false);
        let base = force(&still, &u, &at);
        let thrown = force(&with(true, false, false), &u, &at);
        let spun = force(&with(true, true, false), &u, &at);
        let wet = force(&with(false, false, true), &u, &at);
        let pitch = |part: f64| {
            let cage = Phase::from_revolutions(part / of.elements as f64);
            force(&still, &u, &BearingKinematicState { cage, ..at })
        };
        let around: Vec<[f64; 3]> = (0..64).map(|k| pitch(f64::from(k) / 64.0)).collect();
        let swing = |k: usize| {
            let along = || around.iter().map(|f| f[k]);
            0.5 * (along().fold(f64::MIN, f64::max) - along().fold(f64::MAX, f64::min))
        };
        let whole = size(base);
        let found = [
            apart(thrown, base) / whole,
            apart(spun, thrown) / whole,
            apart(wet, base) / whole,
            apart(held(of, &(u + still.offset)), base) / whole,
            size([swing(0), swing(1), swing(2)]) / whole,
        ];
        let significance = of_bearing(&scene, of, &u, &at).unwrap();
        for ((ratios, effect), found) in ratios.iter_mut().zip(effects).zip(found) {
            let predicted = significance.iter().find(|one| one.effect == effect).unwrap().change;
            if found > LEAST || predicted > LEAST {
                ratios.push((predicted / found, found, i));
            }
        }
    }
    for (ratios, effect) in ratios.iter_mut().zip(effects) {
        ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
        let within = ratios.iter().filter(|r| (0.5..=2.0).contains(&r.0)).count();
        let part = |p: f64| ratios[((ratios.len() - 1) as f64 * p) as usize].0;
        println!(
            "{effect}: {} of {} within a factor of two; predicted over found from {:.3} by {:.3}, {:.3}, {:.3} to {:.3}",
            within,
            ratios.len(),
            part(0.0),
            part(0.05),
            part(0.5),
            part(0.95),
            part(1.0)
        );
        assert!(ratios.len() > 150, "{effect}: a grid on which it matters");
        assert_eq!(within, ratios.len(), "{effect}: {:?}", ratios.iter().find(|r| !(0.5..=2.0).contains(&r.0)));
    }
}

/// Force with every ball's contact angle held where it was before anything moved, from the path of the groove centres alone.
fn held(of: &BearingScene, u: &Displacement<f64>) -> [f64; 3] {
    let g = build::geometry(of).unwrap().unwrap();
    let sign = if of.facing == Facing::MinusZ { -1.0 } else { 1.0 };
    let free = if of.facing == Facing::Both { 0.0 } else { sign * g.contact_angle };
    // A deep-groove bearing is held at its mean angle under load, from the force of the angles that turn.
    let fixed = if of.facing == Facing::Both { mean_angle(of, &g, u) } else { free };
    let rest = g.groove_distance() * if of.facing == Facing::Both { g.contact_angle.cos() } else { 1.0 };
    let mut sum = [0.0; 3];
    for j in 0..of.elements {
        let azimuth = build::place::<f64>(of, j).azimuth().radians();
        let (sin, cos) = azimuth.sin_cos();
        let arm = g.inner_groove_radius();
        let (radial, axial) = (u.u * cos + u.v * sin, u.w + arm * (u.thu * sin - u.thv * cos));
        let (radial, axial) = (rest * free.cos() + radial, rest * free.sin() + axial);
        let approach = radial * fixed.cos() + axial * fixed.sin() - g.groove_distance();
        let load = g.stiffness() * approach.max(0.0).powf(1.5);
        sum = [sum[0] - load * fixed.cos() * cos, sum[1] - load * fixed.cos() * sin, sum[2] - load * fixed.sin()];
    }
    sum
}

/// Angle of the sum of the balls' forces in their planes, rad, of a deep-groove bearing.
fn mean_angle(of: &BearingScene, g: &BallBearingGeometry, u: &Displacement<f64>) -> f64 {
    let (mut radial, mut axial) = (0.0, 0.0);
    for j in 0..of.elements {
        let (sin, cos) = build::place::<f64>(of, j).azimuth().radians().sin_cos();
        let x = g.groove_distance() * g.contact_angle.cos() + u.u * cos + u.v * sin;
        let z = u.w + g.inner_groove_radius() * (u.thu * sin - u.thv * cos);
        let load = g.stiffness() * (x.hypot(z) - g.groove_distance()).max(0.0).powf(1.5);
        radial += load * x / x.hypot(z);
        axial += load * z / x.hypot(z);
    }
    axial.atan2(radial)
}
