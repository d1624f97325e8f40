//! Identities of the quasi-static model, the limits in which it equals a cheaper one, and tables confirmed by other programs.

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::quasi_static::film::{InletHeating, Lubricant, central_film, thermal_reduction};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, Massless, RaceControl};
use ballrace::bearing::quasi_static::{BallPosition, BallState, QuasiStatic};
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape, SurfaceDeviation, Wave};
use ballrace::bearing::{Bearing, ElementPosition, ElementPositions, Mirrored, evenly_spaced};
use ballrace::contact::hertz::{PointContact, Race};
use ballrace::{BearingKinematicState, Displacement, Exact, Phase, Stiffness, Wrench};
use ballrace_tests::bearings::{STEEL_BALLS, acbb_s_geometry, harris_218_geometry};
use ballrace_tests::compare::{relative, relative_to_largest};
use std::f64::consts::TAU;

type Static = QuasiStatic<f64, Exact, ElementPositions<f64, 14>>;

const OIL: Lubricant = Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 };
/// The displacement of the confirmed table.
const U: Displacement<f64> = Displacement { u: 2e-6, v: 1e-6, w: 10e-6, thu: 1e-4, thv: -5e-5 };

fn plain(first: Phase) -> Static {
    QuasiStatic::try_new(acbb_s_geometry(), evenly_spaced(first), DisplacementDatum::Touching).unwrap()
}

/// With everything: inertia and film.
fn full(params: InertiaParams) -> impl Bearing<f64> {
    plain(Phase::ZERO).with_inertia(&params).unwrap().with_film(OIL).unwrap()
}

fn inner_at(rpm: f64) -> BearingKinematicState<f64> {
    BearingKinematicState { inner_speed: rpm * TAU / 60.0, ..BearingKinematicState::default() }
}

fn force(bearing: &impl Bearing<f64>, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> [f64; 5] {
    bearing.reaction(u, at).wrench.to_array()
}

#[test]
fn without_rotation_it_equals_the_angular_model() {
    let angular = Angular::<f64, Exact, _>::try_new(
        acbb_s_geometry(),
        evenly_spaced::<f64, 14>(Phase::ZERO),
        DisplacementDatum::Touching,
    );
    let (angular, at) = (angular.unwrap(), BearingKinematicState::default());
    let massive = plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap();
    for w in [-5e-6, 0.0, 1e-6, 10e-6, 40e-6] {
        let u = Displacement { w, ..U };
        let expected = force(&angular, &u, &at);
        assert!(relative_to_largest(&force(&plain(Phase::ZERO), &u, &at), &expected) < 1e-9);
        assert!(relative_to_largest(&force(&massive, &u, &at), &expected) < 1e-9, "inertia without motion");
    }
}

#[test]
fn each_effect_vanishes_with_its_cause() {
    let at = inner_at(12_000.0);
    let reference = force(&plain(Phase::ZERO), &U, &at);
    let light = InertiaParams { density: 1e-6, ..STEEL_BALLS };
    let light = plain(Phase::ZERO).with_inertia(&light).unwrap();
    assert!(relative_to_largest(&force(&light, &U, &at), &reference) < 1e-8, "massless balls");
    let thin = plain(Phase::ZERO).with_film(Lubricant { viscosity: 1e-18, ..OIL }).unwrap();
    assert!(relative_to_largest(&force(&thin, &U, &at), &reference) < 1e-8, "no viscosity");
    let centrifugal = plain(Phase::ZERO).with_centrifugal(&STEEL_BALLS).unwrap();
    let none = InertiaParams { gyroscopic: false, ..STEEL_BALLS };
    let without_moment = plain(Phase::ZERO).with_inertia(&none).unwrap();
    let difference = relative_to_largest(&force(&without_moment, &U, &at), &force(&centrifugal, &U, &at));
    assert!(difference < 1e-12, "a value of 0 is as good as a type: {difference:e}");
}

#[test]
fn the_usual_choice_as_a_type_is_the_same_as_by_value() {
    let (general, usual) =
        (plain(Phase::ZERO).with_inertia(&STEEL_BALLS), plain(Phase::ZERO).with_outer_control(&STEEL_BALLS));
    let (general, usual) = (general.unwrap(), usual.unwrap());
    let at = inner_at(12_000.0);
    let (a, ka) = general.reaction_and_stiffness(&U, &at);
    let (b, kb) = usual.reaction_and_stiffness(&U, &at);
    assert!(relative_to_largest(&a.wrench.to_array(), &b.wrench.to_array()) < 1e-12);
    assert!(apart(&ka, &kb) < 1e-9);
}

#[test]
fn forces_of_the_reference_with_inertia() {
    let golden = [-371.623234, -294.353050, -541.887840, -2.942087, 3.641872];
    let found = force(&plain(Phase::ZERO), &U, &BearingKinematicState::default());
    assert!(relative_to_largest(&found, &golden) < 2e-9, "{found:?}");
    let golden = [-341.004578, -270.341895, -582.467316, -2.722291, 3.356094];
    let found = force(&plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap(), &U, &inner_at(12_000.0));
    assert!(relative_to_largest(&found, &golden) < 2e-9, "{found:?}");
}

#[test]
fn films_of_the_reference() {
    let geometry = acbb_s_geometry();
    let contact = geometry.contact(Race::Inner);
    let along = 0.5 * geometry.ball_diameter * (1.0 - geometry.gamma());
    for (load, expected) in [(10.0, 0.474771e-6), (50.0, 0.426239e-6), (100.0, 0.406897e-6)] {
        let film = central_film(OIL, contact.effective_modulus, along, contact.ellipticity, 2.9416766, load);
        assert!(relative(film, expected) < 2e-6, "{film}");
    }
}

/// Isothermal, and with a heated inlet; at 30 000 rpm less than half of the film is left.
#[test]
fn a_film_is_that_of_its_own_load_and_speed() {
    let heating = InletHeating { temperature_coefficient: 0.04, conductivity: 0.14 };
    for (speed, heating) in [(6_000.0, None), (6_000.0, Some(heating)), (30_000.0, Some(heating))] {
        film_of_its_own_load_and_speed(speed, heating);
    }
}

fn film_of_its_own_load_and_speed(speed: f64, heating: Option<InletHeating>) {
    let bearing = plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap();
    let bearing = bearing.with_selected_film(Some((OIL, heating))).unwrap().with_newton_steps(20);
    let (geometry, at) = (acbb_s_geometry(), inner_at(speed));
    let left = |contact: &PointContact, speed: f64, load: f64| {
        let pressure = contact.ellipse(load).2 / contact.effective_modulus;
        heating.map_or(1.0, |heating| thermal_reduction(OIL.viscosity, heating, speed, pressure))
    };
    let mut heated = 1.0_f64;
    let mut balls = [BallState::default(); 14];
    bearing.ball_states(&U, &at, &mut balls);
    let (gamma, ratio) = (geometry.gamma(), geometry.ball_diameter / geometry.pitch_diameter);
    let (inner, outer) = (geometry.contact(Race::Inner), geometry.contact(Race::Outer));
    for ball in balls.iter().filter(|ball| ball.inner_load > 0.0) {
        let half = 0.5 * geometry.pitch_diameter;
        let near = (at.inner_speed - ball.orbital_speed) * half * (1.0 - ratio * ball.inner_direction[0]);
        let far = ball.orbital_speed * half * (1.0 + ratio * ball.outer_direction[0]);
        let at_inner = 0.5 * geometry.ball_diameter * (1.0 - gamma);
        let at_outer = 0.5 * geometry.ball_diameter * (1.0 + gamma);
        let film = central_film(OIL, inner.effective_modulus, at_inner, inner.ellipticity, near, ball.inner_load);
        let film = film * left(&inner, near, ball.inner_load);
        assert!(relative(ball.inner_film, film) < 1e-9, "{} {film}", ball.inner_film);
        let film = central_film(OIL, outer.effective_modulus, at_outer, outer.ellipticity, far, ball.outer_load);
        let film = film * left(&outer, far, ball.outer_load);
        assert!(relative(ball.outer_film, film) < 1e-9, "{} {film}", ball.outer_film);
        heated = heated.min(left(&outer, far, ball.outer_load));
    }
    assert_eq!(heated < 0.7, speed > 10_000.0, "{heated} of the film is left at {speed} rpm");
}

#[test]
fn force_of_waviness_follows_its_rule() {
    let w0 = Displacement { w: 10e-6, ..Displacement::default() };
    let with = |order| {
        let wave = Wave {
            component: BearingComponent::Inner,
            direction: Direction::Radial,
            order,
            amplitude: 0.1e-6,
            phase: Phase::ZERO,
        };
        let bearing = plain(Phase::ZERO).with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Wave(wave)]));
        bearing.reaction(&w0, &BearingKinematicState::default()).wrench
    };
    let smooth = plain(Phase::ZERO).reaction(&w0, &BearingKinematicState::default()).wrench;
    for order in [13, 15, 27, 29] {
        // The largest over a turn of the wave against the balls; at angle 0 the force is along X.
        let Wrench { fx, fy, fz, mx, my } = with(order);
        assert!(relative(fx.hypot(fy), 15.17842) < 2e-3, "order {order}: {fx} {fy}");
        assert!(relative(mx.hypot(my), 0.1468268) < 2e-3, "order {order}: {mx} {my}");
        assert!((fz - smooth.fz).abs() < 0.1);
    }
    for order in [14, 28] {
        assert!(((with(order).fz - smooth.fz).abs() - 15.19).abs() < 0.05, "order {order}");
    }
    for order in [2, 12, 16] {
        let Wrench { fx, fy, .. } = with(order);
        assert!(fx.hypot(fy) < 1e-6, "order {order}: silent");
    }
}

#[test]
fn waves_turn_with_their_own_surface() {
    let bearing = |part, order| {
        let wave = Wave {
            component: part,
            direction: Direction::Axial,
            order,
            amplitude: 1e-6,
            phase: Phase::from_revolutions(0.1),
        };
        plain(Phase::ZERO).with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Wave(wave)]))
    };
    let still = BearingKinematicState::default();
    let quarter = Phase::from_revolutions(0.25);
    let turned = |at: BearingKinematicState<f64>, part, order| force(&bearing(part, order), &U, &at);
    // Twelve waves on a ring look alike after a quarter of a turn of it, and of nothing else.
    let rings = [
        (BearingComponent::Inner, BearingKinematicState { inner: quarter, ..still }),
        (BearingComponent::Outer, BearingKinematicState { outer: quarter, ..still }),
    ];
    for (part, at) in rings {
        assert!(relative_to_largest(&turned(at, part, 12), &turned(still, part, 12)) < 1e-12);
        assert!(relative_to_largest(&turned(at, part, 13), &turned(still, part, 13)) > 1e-4);
    }
    let spun = BearingKinematicState { ball: quarter, ..still };
    assert!(
        relative_to_largest(
            &turned(spun, BearingComponent::Ball(Phase::ZERO), 4),
            &turned(still, BearingComponent::Ball(Phase::ZERO), 4)
        ) < 1e-12
    );
    assert!(
        relative_to_largest(
            &turned(spun, BearingComponent::Ball(Phase::ZERO), 2),
            &turned(still, BearingComponent::Ball(Phase::ZERO), 2)
        ) > 1e-4
    );
}

#[test]
fn damage_rotates_with_its_own_surface() {
    let with = |part| {
        let spall = Spall::new(part, Phase::ZERO, 0.05, 3e-6, SpallShape::Rectangular);
        plain(Phase::ZERO).with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Spall(spall)]))
    };
    let at = BearingKinematicState::default();
    let sound = force(&plain(Phase::ZERO), &U, &at)[0];
    for part in [BearingComponent::Inner, BearingComponent::Outer, BearingComponent::Ball(Phase::ZERO)] {
        assert!((force(&with(part), &U, &at)[0] - sound).abs() > 1.0, "{part:?}");
    }
    // Turned away from every ball, the inner race's damage is not met; the ball meets its own twice a turn.
    let between = BearingKinematicState { inner: Phase::from_revolutions(0.5 / 14.0), ..at };
    assert_eq!(force(&with(BearingComponent::Inner), &U, &between)[0], sound);
    let opposite = BearingKinematicState { ball: Phase::from_revolutions(0.5), ..at };
    let sideways = BearingKinematicState { ball: Phase::from_revolutions(0.25), ..at };
    assert!((force(&with(BearingComponent::Ball(Phase::ZERO)), &U, &opposite)[0] - sound).abs() > 1.0);
    assert_eq!(force(&with(BearingComponent::Ball(Phase::ZERO)), &U, &sideways)[0], sound);
}

#[test]
fn forces_on_both_rings_add_up_to_the_centrifugal_forces() {
    let bearing = plain(Phase::ZERO)
        .with_inertia(&InertiaParams { friction_sharing: FrictionSharing::Equal, ..STEEL_BALLS })
        .unwrap();
    for rpm in [0.0, 12_000.0] {
        let at = BearingKinematicState { cage: Phase::from_revolutions(0.3), ..inner_at(rpm) };
        let both = bearing.ring_reactions(&U, &Displacement::default(), &at);
        assert_eq!(both.inner.wrench, bearing.reaction(&U, &at).wrench);
        let mut balls = [BallState::default(); 14];
        bearing.ball_states(&U, &at, &mut balls);
        let mut expected = [0.0; 2];
        for (j, ball) in balls.iter().enumerate() {
            let azimuth = TAU * (0.3 + j as f64 / 14.0);
            expected[0] += ball.centrifugal * azimuth.cos();
            expected[1] += ball.centrifugal * azimuth.sin();
        }
        let (f_in, f_out) = (both.inner.wrench, both.outer);
        assert!((f_in.fx + f_out.fx - expected[0]).abs() < 1e-6, "{rpm} rpm");
        assert!((f_in.fy + f_out.fy - expected[1]).abs() < 1e-6, "{rpm} rpm");
        assert!((f_in.fz + f_out.fz).abs() < 1e-6, "{rpm} rpm");
        if rpm == 0.0 {
            // Moments about one point: the groove planes stand A sin(alpha_0) + w apart; lever arms of undeformed surfaces
            // are off by 0.15 %.
            let apart = acbb_s_geometry().groove_distance() * acbb_s_geometry().contact_angle.sin() + U.w;
            assert!((f_in.mx - apart * f_in.fy + f_out.mx).abs() < 3e-3 * f_in.mx.abs());
            assert!((f_in.my + apart * f_in.fx + f_out.my).abs() < 3e-3 * f_in.my.abs());
        }
    }
}

#[test]
fn only_the_relative_displacement_of_the_rings_counts() {
    let bearing = plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap();
    let at = inner_at(9_000.0);
    let common = Displacement { u: 1e-4, v: -2e-4, w: 5e-5, thu: 0.0, thv: 0.0 };
    let apart = bearing.ring_reactions(&U, &Displacement::default(), &at);
    let moved = bearing.ring_reactions(&(U + common), &common, &at);
    assert!(relative_to_largest(&moved.inner.wrench.to_array(), &apart.inner.wrench.to_array()) < 1e-9);
}

#[test]
fn turning_by_a_pitch_changes_nothing() {
    let bearing = full(STEEL_BALLS);
    let at = inner_at(15_000.0);
    let turned = BearingKinematicState { cage: Phase::from_revolutions(1.0 / 14.0), ..at };
    assert!(relative_to_largest(&force(&bearing, &U, &turned), &force(&bearing, &U, &at)) < 1e-9);
}

#[test]
fn reversing_the_rotation_changes_nothing() {
    let bearing = full(InertiaParams { friction_sharing: FrictionSharing::Proportional, ..STEEL_BALLS });
    let at = inner_at(15_000.0);
    assert!(relative_to_largest(&force(&bearing, &U, &at.reversed()), &force(&bearing, &U, &at)) < 1e-9);
}

#[test]
fn equal_relative_speed_with_the_outer_ring_turning_shares_the_spin_but_not_the_orbit() {
    let bearing = plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap();
    let speed = 12_000.0 * TAU / 60.0;
    let state = |at: BearingKinematicState<f64>| {
        let mut balls = [BallState::default(); 14];
        bearing.ball_states(&Displacement { w: 10e-6, ..Displacement::default() }, &at, &mut balls);
        balls[0]
    };
    let inner = state(inner_at(12_000.0));
    let outer = state(BearingKinematicState { outer_speed: -speed, ..BearingKinematicState::default() });
    assert!((inner.orbital_speed - (speed + outer.orbital_speed)).abs() < 0.02 * speed, "the frames differ by w");
    assert!(outer.centrifugal > 1.5 * inner.centrifugal, "the outer ring carries the balls along faster");
}

#[test]
fn mirrored_bearing_has_mirrored_forces() {
    let wave = Wave {
        component: BearingComponent::Outer,
        direction: Direction::Axial,
        order: 5,
        amplitude: 1e-6,
        phase: Phase(77),
    };
    let forward = plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap();
    let forward = forward.with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Wave(wave)]));
    let places = evenly_spaced::<f64, 14>(Phase::ZERO).map(ElementPosition::mirrored);
    let backward =
        QuasiStatic::<f64, Exact, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
    let backward = backward.with_inertia(&STEEL_BALLS).unwrap();
    let seen = Wave { amplitude: -wave.amplitude, ..wave };
    let backward = Mirrored(backward.with_surface(SurfaceDeviation::<Exact, _>::new([Feature::Wave(seen).mirrored()])));
    let at = BearingKinematicState { cage: Phase::from_revolutions(0.21), outer: Phase(5), ..inner_at(12_000.0) };
    // Reflected in its plane a bearing has the opposite facing; rotation about Z looks the same in that mirror.
    let reflected = Displacement { w: -U.w, thu: -U.thu, thv: -U.thv, ..U };
    let Wrench { fx, fy, fz, mx, my } = forward.reaction(&U, &at).wrench;
    let found = backward.reaction(&reflected, &at).wrench.to_array();
    let apart = relative_to_largest(&found, &[fx, fy, -fz, -mx, -my]);
    assert!(apart < 1e-9, "{apart:e}");
}

#[test]
fn no_work_around_a_closed_path_without_rotation() {
    let bearing = plain(Phase::ZERO).with_film(OIL).unwrap();
    let at = BearingKinematicState::default();
    let steps = 400;
    let path = |t: f64| Displacement {
        u: 4e-6 * (TAU * t).cos(),
        v: 3e-6 * (TAU * t).sin(),
        w: 10e-6 + 3e-6 * (2.0 * TAU * t).sin(),
        thu: 1e-4 * (TAU * t).sin(),
        thv: 1e-4 * (TAU * t).cos(),
    };
    let (mut work, mut size) = (0.0, 0.0);
    for i in 0..steps {
        let (a, b) = (path(f64::from(i) / f64::from(steps)), path(f64::from(i + 1) / f64::from(steps)));
        let middle = path((f64::from(i) + 0.5) / f64::from(steps));
        let part: f64 = force(&bearing, &middle, &at)
            .iter()
            .zip(b.to_array().iter().zip(a.to_array()))
            .map(|(f, (b, a))| f * (b - a))
            .sum();
        work += part;
        size += part.abs();
    }
    assert!(work.abs() < 1e-6 * size, "{work:e} of {size:e}");
}

/// Central differences with the balls converged to rounding.
fn differences(bearing: &impl Bearing<f64>, u: &Displacement<f64>, at: &BearingKinematicState<f64>) -> Stiffness<f64> {
    let mut k = Stiffness::zeros();
    for j in 0..5 {
        let h = if j < 3 { 1e-9 } else { 1e-7 };
        let moved = |sign: f64| {
            let mut q = u.to_array();
            q[j] += sign * h;
            force(bearing, &Displacement::from_array(q), at)
        };
        let (up, down) = (moved(1.0), moved(-1.0));
        for i in 0..5 {
            k[(i, j)] = -(up[i] - down[i]) / (2.0 * h);
        }
    }
    k
}

/// Largest difference, each entry over the geometric mean of its diagonals.
fn apart(a: &Stiffness<f64>, b: &Stiffness<f64>) -> f64 {
    let scale = |i: usize, j: usize| (b[(i, i)] * b[(j, j)]).abs().sqrt();
    (0..5)
        .flat_map(|i| (0..5).map(move |j| (i, j)))
        .map(|(i, j)| (a[(i, j)] - b[(i, j)]).abs() / scale(i, j))
        .fold(0.0, f64::max)
}

#[test]
fn tangents_against_differences() {
    println!("speed, friction sharing: implicit, condensed against differences; asymmetry");
    for (rpm, allowed) in [(0.0, 1e-6), (6_000.0, 1e-6), (12_000.0, 1e-6), (24_000.0, 1e-6)] {
        for (race_control, friction_sharing) in [
            (RaceControl::Outer, FrictionSharing::Outer),
            (RaceControl::Outer, FrictionSharing::Proportional),
            (RaceControl::Inner, FrictionSharing::Equal),
        ] {
            let params = InertiaParams { race_control, friction_sharing, ..STEEL_BALLS };
            let bearing = plain(Phase::ZERO).with_inertia(&params).unwrap().with_newton_steps(20);
            let at = BearingKinematicState { cage: Phase::from_revolutions(0.13), ..inner_at(rpm) };
            let (_, implicit) = bearing.reaction_and_stiffness(&U, &at);
            let condensed = bearing.condensed_stiffness(&U, &at);
            let numeric = differences(&bearing, &U, &at);
            let (by_implicit, by_condensed) = (apart(&implicit, &numeric), apart(&condensed, &numeric));
            let skew = apart(&implicit, &implicit.transpose());
            println!(
                "{rpm} rpm, {race_control:?} {friction_sharing:?}: {by_implicit:.1e}, {by_condensed:.1e}; {skew:.1e}"
            );
            assert!(by_implicit < allowed, "{by_implicit:e}");
            assert!(by_condensed < 1e-6_f64.max(0.05 * (rpm / 12_000.0).powi(2)), "{by_condensed:e}");
        }
    }
}

#[test]
fn tangent_of_the_reference() {
    let (reaction, k) = plain(Phase::ZERO).reaction_and_stiffness(
        &Displacement { w: 10e-6, ..Displacement::default() },
        &BearingKinematicState::default(),
    );
    assert!(relative(reaction.wrench.fz, -499.9601) < 1e-6);
    for (i, j, expected) in [
        (0, 0, 1.517860e8),
        (1, 1, 1.517860e8),
        (2, 2, 8.053702e7),
        (3, 3, 1.511936e4),
        (0, 4, -1.468288e6),
        (1, 3, 1.468288e6),
    ] {
        assert!(relative(k[(i, j)], expected) < 1e-6, "{i} {j}: {}", k[(i, j)]);
    }
}

#[test]
fn few_steps_from_the_last_positions_suffice() {
    let bearing = plain(Phase::ZERO).with_inertia(&STEEL_BALLS).unwrap();
    let exact = bearing.with_newton_steps(30);
    let mut balls = [BallPosition::default(); 14];
    let path = |i: u32| {
        let t = f64::from(i) / 100.0;
        let u = Displacement { u: 3e-6 * (TAU * t).cos(), v: 3e-6 * (TAU * t).sin(), ..U };
        (u, BearingKinematicState { cage: Phase::from_revolutions(0.4 * t), ..inner_at(12_000.0) })
    };
    for steps in [2, 3, 4] {
        let (u, at) = path(0);
        bearing.initial_ball_positions(&u, &at, &mut balls);
        let warm = bearing.with_newton_steps(steps);
        let mut worst = 0.0_f64;
        for i in 1..200 {
            let (u, at) = path(i);
            let found = warm.warm_started_reaction(&u, &at, &mut balls).wrench.to_array();
            worst = worst.max(relative_to_largest(&found, &force(&exact, &u, &at)));
        }
        println!("warm, {steps} steps: {worst:.1e}");
        assert!(worst < [1e-6, 1e-9, 1e-9][usize::from(steps) - 2]);
    }
}

#[test]
fn harris_218_of_the_reference() {
    let geometry = harris_218_geometry();
    let bearing = |params: &InertiaParams| {
        let bearing = QuasiStatic::<f64, Exact, _>::try_new(
            geometry,
            evenly_spaced::<f64, 16>(Phase::ZERO),
            DisplacementDatum::Touching,
        );
        bearing.unwrap().with_inertia(params).unwrap()
    };
    // rpm, axial load N, displacement um, inner and outer load N, angles deg, F_c N, M_g N m, orbit over shaft.
    let rows = [
        (3000.0, 8900.0, 22.196, 822.496, 861.778, 42.5548, 39.3110, 52.473, -0.14780, 0.434983),
        (6000.0, 8900.0, 12.331, 759.645, 922.342, 47.0753, 33.9771, 220.029, -0.54670, 0.445361),
        (6000.0, 17800.0, 32.982, 1581.092, 1738.303, 44.7188, 38.0376, 213.239, -0.58417, 0.438436),
        (10000.0, 17800.0, 14.852, 1453.232, 1921.601, 49.9546, 31.3329, 637.408, -1.47367, 0.454813),
        (15000.0, 17800.0, -47.835, 1329.730, 2714.293, 56.7866, 19.2263, 1758.267, -2.57423, 0.503588),
    ];
    for (rpm, load, um, q_i, q_o, a_i, a_o, f_c, m_g, orbit) in rows {
        let at = inner_at(rpm);
        let u = Displacement { w: um * 1e-6, ..Displacement::default() };
        let found = bearing(&STEEL_BALLS).reaction(&u, &at).wrench.fz;
        assert!(relative(found, -load) < 2e-4, "{rpm}: {found}");
        let mut balls = [BallState::default(); 16];
        bearing(&STEEL_BALLS).ball_states(&u, &at, &mut balls);
        let ball = balls[3];
        let angle = |[c, s]: [f64; 2]| s.atan2(c).to_degrees();
        let pairs = [
            (ball.inner_load, q_i),
            (ball.outer_load, q_o),
            (angle(ball.inner_direction), a_i),
            (angle(ball.outer_direction), a_o),
            (ball.centrifugal, f_c),
            (ball.gyroscopic_moment, m_g),
            (ball.orbital_speed / at.inner_speed, orbit),
        ];
        for (found, expected) in pairs {
            assert!(relative(found, expected) < 2e-4, "{rpm} rpm: {found} {expected}");
        }
    }
    // Inner race control and equal friction sharing, 10 000 rpm.
    let inner =
        InertiaParams { race_control: RaceControl::Inner, friction_sharing: FrictionSharing::Equal, ..STEEL_BALLS };
    let u = Displacement { w: 24.884e-6, ..Displacement::default() };
    let mut balls = [BallState::default(); 16];
    bearing(&inner).ball_states(&u, &inner_at(10_000.0), &mut balls);
    assert!(relative(balls[0].inner_load, 1408.773) < 1e-4 && relative(balls[0].gyroscopic_moment, -2.45803) < 1e-4);
}

#[test]
fn effect_that_is_not_named_is_absent() {
    assert_eq!(size_of::<Massless>(), 0);
}

/// Effects chosen at run time give the bits of the fixed choices.
#[test]
fn selected_effects_give_the_bits_of_fixed_ones() {
    let inertia =
        |centrifugal, gyroscopic, race_control| InertiaParams { centrifugal, gyroscopic, race_control, ..STEEL_BALLS };
    let at = inner_at(20_000.0);
    let bits = |bearing: &dyn Bearing<f64>| {
        let (reaction, stiffness) = bearing.reaction_and_stiffness(&U, &at);
        let numbers = reaction.wrench.to_array().into_iter().chain(stiffness.iter().copied());
        (numbers.map(f64::to_bits).collect::<Vec<_>>(), reaction.status)
    };
    let bearing = || plain(Phase::ZERO);
    for oil in [None, Some(OIL)] {
        let selected = |params: &InertiaParams| {
            bits(
                &bearing()
                    .with_selected_inertia(params)
                    .unwrap()
                    .with_selected_film(oil.map(|oil| (oil, None)))
                    .unwrap(),
            )
        };
        let massless = inertia(false, false, RaceControl::Outer);
        let usual = inertia(true, true, RaceControl::Outer);
        let general = inertia(true, true, RaceControl::Inner);
        let fixed: [Box<dyn Bearing<f64>>; 3] = match oil {
            None => [
                Box::new(bearing()),
                Box::new(bearing().with_outer_control(&usual).unwrap()),
                Box::new(bearing().with_inertia(&general).unwrap()),
            ],
            Some(oil) => [
                Box::new(bearing().with_film(oil).unwrap()),
                Box::new(bearing().with_outer_control(&usual).unwrap().with_film(oil).unwrap()),
                Box::new(bearing().with_inertia(&general).unwrap().with_film(oil).unwrap()),
            ],
        };
        for (params, fixed) in [massless, usual, general].iter().zip(&fixed) {
            assert_eq!(selected(params), bits(fixed.as_ref()), "{params:?}, {oil:?}");
        }
        assert_ne!(selected(&massless), selected(&usual));
        assert_ne!(selected(&usual), selected(&general));
    }
}
