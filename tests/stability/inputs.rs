//! Every exponent, every special number, random bits; monotone forces; single against double precision.

use super::models::{self, Named, turning};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::quasi_static::{BallState, QuasiStatic};
use ballrace::bearing::{Bearing, ElementPositions, LastValidWrench, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::{BearingKinematicState, Displacement, Exact, Fast, Phase, Scalar, Status, Wrench};
use ballrace_tests::bearings::{STEEL_BALLS, acbb_s_geometry};
use ballrace_tests::states::Random;

/// Finite, or flagged and held; what was no number is said to be none.
fn judge(name: &str, bearing: &dyn Bearing<f32>, u: &Displacement<f32>, at: &BearingKinematicState<f32>) -> Status {
    let mut held = LastValidWrench::new();
    let (before, _) = bearing.sample(&mut held, &Displacement::default(), &turning(Phase::ZERO));
    let (wrench, status) = bearing.sample(&mut held, u, at);
    let fresh = bearing.reaction(u, at).wrench;
    assert!(wrench.is_finite(), "{name}: {wrench:?} at {u:?}");
    assert_eq!(status.contains(Status::INPUT_NOT_FINITE), !u.is_finite(), "{name}: {status:?} at {u:?}");
    if u.is_finite() {
        assert_eq!(status.contains(Status::RESULT_NOT_FINITE), !fresh.is_finite(), "{name}: {status:?} at {u:?}");
    }
    assert_eq!(wrench, if status.is_held() { before } else { fresh }, "{name} at {u:?}");
    status
}

fn along(component: usize, x: f32) -> Displacement<f32> {
    let mut u = [1e-6, -2e-6, 3e-6, 1e-5, 1e-5];
    u[component] = x;
    Displacement::from_array(u)
}

/// Every exponent from subnormal numbers to the largest, with three mantissas and both signs, on each displacement.
#[test]
fn every_exponent_on_every_displacement() {
    let mut held = 0;
    let mut count = 0;
    for (name, bearing) in &models::all::<f32, Exact>() {
        for exponent in 0..=254_u32 {
            for mantissa in [0, 0x2a_aaaa, 0x7f_ffff] {
                for sign in [0, 1 << 31] {
                    let x = f32::from_bits(sign | exponent << 23 | mantissa);
                    for component in 0..5 {
                        let status = judge(name, bearing.as_ref(), &along(component, x), &turning(Phase(1 << 60)));
                        held += u32::from(status.is_held());
                        count += 1;
                    }
                }
            }
        }
    }
    println!("{count} displacements over all exponents: all finite or flagged, {held} held for overflow");
}

#[test]
fn samples_that_are_no_number_are_held() {
    for (name, bearing) in &models::all::<f32, Exact>() {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::from_bits(0xff80_0001)] {
            for component in 0..5 {
                let status = judge(name, bearing.as_ref(), &along(component, x), &turning(Phase::ZERO));
                assert!(status.is_held(), "{name}");
            }
        }
    }
}

fn random_bits(models: &[Named<f32>], count: u64, seed: u64) {
    let mut random = Random(seed);
    let mut bits = move || (random.unit() * 4_294_967_296.0) as u32;
    let mut held = 0;
    for i in 0..count {
        let (name, bearing) = &models[(i % models.len() as u64) as usize];
        let u = Displacement::from_array(std::array::from_fn(|_| f32::from_bits(bits())));
        let at = BearingKinematicState {
            inner_speed: f32::from_bits(bits()),
            outer_speed: f32::from_bits(bits()),
            ..BearingKinematicState::from(Phase(u64::from(bits()) << 32 | u64::from(bits())))
        };
        let (wrench, status) = bearing.sample(&mut LastValidWrench::new(), &u, &at);
        assert!(wrench.is_finite(), "{name}: {wrench:?} at {u:?} {at:?}");
        assert!(u.is_finite() || status.contains(Status::INPUT_NOT_FINITE), "{name}: {status:?} at {u:?}");
        held += u64::from(status.is_held());
    }
    println!("{count} random bit patterns: all finite or flagged, {held} held");
}

#[test]
fn random_bits_as_input() {
    random_bits(&models::direct::<f32, Exact>(), 600_000, 0x9e37_79b9_7f4a_7c15);
    random_bits(&models::direct::<f32, Fast>(), 600_000, 0x1234_5678_9abc_def1);
    random_bits(&models::balanced::<f32, Exact>(), 40_000, 0xdead_beef_0bad_cafe);
}

/// A hundred million of them.
#[test]
#[ignore = "slow: half a minute; tests/run --all runs it"]
fn a_hundred_million_random_bits() {
    random_bits(&models::direct::<f32, Exact>(), 97_000_000, 0x2545_f491_4f6c_dd1d);
    random_bits(&models::balanced::<f32, Exact>(), 3_000_000, 0x0bad_cafe_dead_beef);
}

/// The further the ring is pushed, the more it pushes back: along every coordinate, from nothing to 50 um or 2 mrad.
fn monotone<T: Scalar>(models: &[Named<T>]) {
    for (name, bearing) in models {
        // Balls thrown outward and balls of a table are as smooth as their tolerance.
        let slack = T::EQUILIBRIUM_TOLERANCE.to_f64().max(1e-6);
        for component in 0..5 {
            let most = if component < 3 { 50e-6 } else { 2e-3 };
            let mut last = f64::MIN;
            let mut largest: f64 = 0.0;
            for i in 0..=400 {
                let mut u = [0.0, 0.0, 4e-6, 0.0, 0.0];
                u[component] = most * f64::from(i) / 400.0;
                let u = Displacement::from_array(u.map(T::from_f64));
                let force = -bearing.reaction(&u, &turning(Phase::ZERO)).wrench.to_array()[component].to_f64();
                largest = largest.max(force.abs());
                assert!(
                    force >= last - slack * largest,
                    "{name}: coordinate {component} step {i}: {force} after {last}"
                );
                last = force;
            }
        }
    }
}

#[test]
fn forces_grow_with_the_displacement() {
    monotone(&models::direct::<f64, Exact>());
    monotone(&models::direct::<f32, Exact>());
    let solved =
        |models: Vec<Named<f64>>| models.into_iter().filter(|(name, _)| *name != "tabulated").collect::<Vec<_>>();
    monotone(&solved(models::balanced::<f64, Exact>()));
}

/// Units in the last place of the largest component that single precision is off double precision.
fn ulps(single: &Wrench<f32>, double: &Wrench<f64>) -> f64 {
    let largest = double.to_array().into_iter().take(3).fold(0.0_f64, |m, f| m.max(f.abs()));
    if largest < 1e-30 {
        return 0.0;
    }
    let ulp = f64::from(f32::EPSILON) * largest;
    let apart = single.to_array().into_iter().zip(double.to_array()).take(3);
    apart.map(|(s, d)| (f64::from(s) - d).abs() / ulp).fold(0.0, f64::max)
}

/// Single against double precision over the whole range of displacements, decade by decade: where it peaks is where the
/// play is all but used up, since only the difference is left there.
#[test]
fn single_against_double_precision() {
    let (single, double) = (models::direct::<f32, Exact>(), models::direct::<f64, Exact>());
    let mut random = Random(0x5eed_5eed_5eed_5eed);
    for ((name, s), (_, d)) in single.iter().zip(&double) {
        let mut worst = [0.0_f64; 12];
        for (decade, worst) in worst.iter_mut().enumerate() {
            let size = 10_f64.powi(decade as i32 - 9);
            for _ in 0..2000 {
                let mut unit = || random.between(-1.0, 1.0) * size;
                let u = Displacement { u: unit(), v: unit(), w: unit(), thu: 0.0, thv: 0.0 };
                let single_u = Displacement::from_array(u.to_array().map(|x| x as f32));
                // The same numbers in both: what rounding the input does is not the kernel's.
                let double_u = Displacement::from_array(single_u.to_array().map(f64::from));
                let at = Phase::from_revolutions(random.unit());
                let found = s.reaction(&single_u, &turning(at)).wrench;
                if found.is_finite() {
                    *worst = worst.max(ulps(&found, &d.reaction(&double_u, &turning(at)).wrench));
                }
            }
        }
        let row: Vec<String> = worst.iter().map(|ulps| format!("{ulps:.0}")).collect();
        println!("{name}: ulps from 1 nm to 100 m by decades: {}", row.join(" "));
        // Far from the edge of contact a handful; where the deflection is a small rest of displacement less play, or of
        // radial less axial displacement, as much more as that rest is smaller.
        let near_play = 3000.0;
        for (decade, ulps) in worst.iter().enumerate() {
            let most = if decade <= 6 { near_play } else { 64.0 };
            assert!(*ulps <= most, "{name}: {ulps} ulps at 1e{} m", decade as i32 - 9);
        }
    }
}

/// Displacements at the play itself, one representable number after the other: no force up to it, the least one beyond.
#[test]
fn a_play_that_equals_the_deflection() {
    let places: ElementPositions<f32, 9> = evenly_spaced(Phase::ZERO);
    let point = PointContactLaw { stiffness: 8e9_f32 };
    let bearing = Radial::<f32, Exact, _, _>::try_new(places, point, 5e-6).unwrap();
    let force =
        |u: f32| -bearing.reaction(&Displacement { u, ..Displacement::default() }, &Phase::ZERO.into()).wrench.fx;
    let play = 5e-6_f32;
    let mut u = play;
    for _ in 0..50 {
        assert_eq!(force(u), 0.0, "at {u:e}, play {play:e}");
        u = u.next_down();
    }
    let mut last = 0.0;
    u = play;
    for _ in 0..50 {
        u = u.next_up();
        let deflection = f64::from(u) - f64::from(play);
        let right = 8e9 * deflection.powf(1.5);
        let found = force(u);
        assert!(found > last && (f64::from(found) / right - 1.0).abs() < 1e-6, "{found:e} for {right:e}");
        last = found;
    }
}

/// A tiny deflection between groove centres that stand millimetres apart: the approach is computed from the displacement,
/// not as a difference of lengths, so that nothing cancels.
#[test]
fn a_tiny_deflection_on_a_large_radius() {
    let single: ElementPositions<f32, 9> = evenly_spaced(Phase::ZERO);
    let double: ElementPositions<f64, 9> = evenly_spaced(Phase::ZERO);
    let s = Angular::<f32, Exact, _>::try_new(acbb_s_geometry(), single, DisplacementDatum::Touching).unwrap();
    let d = Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), double, DisplacementDatum::Touching).unwrap();
    let mut worst: f64 = 0.0;
    for decade in 3..=14 {
        let w = 10_f32.powi(-decade);
        let found = s.reaction(&Displacement { w, ..Displacement::default() }, &Phase::ZERO.into()).wrench.fz;
        let u = Displacement { w: f64::from(w), ..Displacement::default() };
        let right = d.reaction(&u, &Phase::ZERO.into()).wrench.fz;
        worst = worst.max((f64::from(found) / right - 1.0).abs());
    }
    println!("thrust from 1 mm down to 1e-14 m: single precision off by at most {worst:.1e}");
    assert!(worst < 1e-6, "{worst:e}");
}

/// Both rings far from where they were and a micrometre apart: the rotor's couplings take the difference of coordinates
/// first. Balls in equilibrium do not notice; in single precision they notice what the subtraction left.
#[test]
fn a_large_common_displacement_of_both_rings() {
    use ballrace::rotor::{AttachedBearing, Attachment, ForceElement, SpeedRatios};
    let places: ElementPositions<f64, 9> = evenly_spaced(Phase::ZERO);
    let bearing =
        QuasiStatic::<f64, Exact, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
    let bearing = bearing.with_outer_control(&STEEL_BALLS).unwrap();
    let attached = AttachedBearing {
        bearing,
        attachment: Attachment::<f64, 7>::on_rigid_rotor(0.05, Some(5)),
        speed_ratios: SpeedRatios::new(0.4),
    };
    let push = |common: f64| {
        let q = [3e-6 + common, 1e-6 - common, 8e-6, 0.0, 0.0, common, -common];
        let mut f = [0.0; 7];
        attached.add_force(&q, &turning(Phase::ZERO), &mut f);
        f
    };
    let near = push(0.0);
    for common in [1e-6, 1e-3, 1.0] {
        let far = push(common);
        let apart = near.iter().zip(far).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let size = near.iter().fold(0.0_f64, |m, f| m.max(f.abs()));
        // Rounding of the coordinates over the deflection, times the exponent.
        let bound = 4.0 * 1.5 * f64::EPSILON * common / 3e-6 + 1e-9;
        assert!(apart <= bound * size, "{common}: {apart:e} of {size}, allowed {bound:e}");
    }
}

/// A ball without convergence is flagged, a ball with convergence has positive loads.
#[test]
fn balls_without_convergence_are_flagged() {
    let places: ElementPositions<f64, 9> = evenly_spaced(Phase::ZERO);
    let bearing =
        QuasiStatic::<f64, Exact, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
    let bearing = bearing.with_outer_control(&STEEL_BALLS).unwrap();
    let mut random = Random(77);
    let (mut open, mut count) = (0, 0);
    for _ in 0..4000 {
        let size = random.over_decades(1e-9, 1e-3);
        let u = Displacement::from_array(std::array::from_fn(|i| {
            random.between(-1.0, 1.0) * size * if i < 3 { 1.0 } else { 20.0 }
        }));
        let at =
            BearingKinematicState { inner_speed: random.over_decades(1.0, 1e4), ..BearingKinematicState::default() };
        let mut states = [BallState::default(); 9];
        bearing.ball_states(&u, &at, &mut states);
        let flagged = bearing.reaction(&u, &at).status.contains(Status::NOT_CONVERGED);
        assert_eq!(flagged, states.iter().any(|s| !s.converged));
        for s in states.iter().filter(|s| s.converged) {
            assert!(s.inner_load >= 0.0 && s.outer_load >= 0.0 && s.inner_load.is_finite(), "{s:?}");
        }
        open += u32::from(flagged);
        count += 1;
    }
    println!("{open} of {count} wild states flagged as not settled");
}
