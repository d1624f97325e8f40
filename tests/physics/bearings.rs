//! Conservation laws, symmetries and published numbers of the bearings.

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::flexible::{FlexibleRing, HousingPoint};
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::surface::{BearingComponent, Spall, SpallShape};
use ballrace::bearing::{Bearing, ElementPositions, Mirrored, evenly_spaced};
use ballrace::contact::hertz::Race;
use ballrace::contact::law::PointContactLaw;
use ballrace::{Displacement, Exact, Phase, Wrench};
use ballrace_tests::bearings::{acbb_s_geometry, angular_contact, deep_groove};
use ballrace_tests::compare::{relative, relative_to_largest};
use proptest::prelude::*;

fn displacement() -> impl Strategy<Value = Displacement<f64>> {
    let (length, tilt) = (-40e-6..40e-6, -5e-4..5e-4);
    (length.clone(), length, -60e-6..60e-6, tilt.clone(), tilt).prop_map(|(u, v, w, thu, thv)| Displacement {
        u,
        v,
        w,
        thu,
        thv,
    })
}

fn wrench_of(bearing: &dyn Bearing<f64>, u: Displacement<f64>, cage: Phase) -> [f64; 5] {
    bearing.reaction(&u, &cage.into()).wrench.to_array()
}

/// The bearing of 14 balls, confirmed by a second program; forces to the printed digits.
#[test]
fn angular_contact_bearing_of_the_reference() {
    let geometry = acbb_s_geometry();
    for (found, printed) in [
        (geometry.contact(Race::Inner).stiffness, 2.393_295_7e10),
        (geometry.contact(Race::Outer).stiffness, 2.507_974_4e10),
        (geometry.stiffness(), 8.660_350_3e9),
        (geometry.contact(Race::Inner).ellipticity, 9.077_383),
        (geometry.contact(Race::Outer).ellipticity, 7.412_023),
        (geometry.groove_distance(), 0.28e-3),
        (geometry.inner_groove_radius(), 19.376_883e-3),
    ] {
        assert!(relative(found, printed) < 5e-8, "{found} {printed}");
    }
    let (a, b, pressure) = geometry.contact(Race::Inner).ellipse(100.0);
    assert!(
        relative(pressure, 1_264.771e6) < 1e-6
            && relative(a, 0.585_389_7e-3) < 1e-6
            && relative(b, 0.064_488_82e-3) < 1e-6
    );
    let u = Displacement { u: 2e-6, v: 1e-6, w: 10e-6, thu: 1e-4, thv: -5e-5 };
    let printed = [-371.623_234, -294.353_050, -541.887_840, -2.942_087, 3.641_872];
    let found = wrench_of(&angular_contact(), u, Phase::ZERO);
    for (found, printed) in found.into_iter().zip(printed) {
        assert!((found - printed).abs() < 1e-6, "{found} {printed}");
    }
    let axial = Displacement { w: 10e-6, ..Displacement::default() };
    let (reaction, k) = angular_contact().reaction_and_stiffness(&axial, &Phase::ZERO.into());
    assert!((reaction.wrench.fz + 499.9601).abs() < 1e-4);
    for (i, j, printed) in [
        (0, 0, 1.517_860e8),
        (1, 1, 1.517_860e8),
        (2, 2, 8.053_702e7),
        (3, 3, 1.511_936e4),
        (0, 4, -1.468_288e6),
        (1, 3, 1.468_288e6),
    ] {
        assert!(relative(k[(i, j)], printed) < 1e-6, "{i}{j}: {} {printed}", k[(i, j)]);
    }
}

/// The zero of `facing = "both"` is the centred ring, that of one-sided bearings the touching one (INTERFACE).
#[test]
fn both_displacement_datums_describe_one_bearing() {
    let geometry = acbb_s_geometry();
    let places: ElementPositions<f64, 14> = evenly_spaced(Phase::ZERO);
    let centred = Angular::<f64, Exact, _>::try_new(geometry, places, DisplacementDatum::Centred).unwrap();
    let touching = Angular::<f64, Exact, _>::try_new(geometry, places, DisplacementDatum::Touching).unwrap();
    let shift = geometry.groove_distance() * geometry.contact_angle.sin();
    let u = Displacement { u: 3e-6, v: -1e-6, w: 12e-6, thu: 2e-5, thv: -3e-5 };
    let moved = Displacement { w: u.w + shift, ..u };
    assert!(
        relative_to_largest(&wrench_of(&centred, moved, Phase::ZERO), &wrench_of(&touching, u, Phase::ZERO)) < 1e-11
    );
}

proptest! {
    /// The set of elements is the same after one pitch.
    #[test]
    fn turning_the_cage_by_one_pitch_changes_nothing(u in displacement(), angle in 0.0..1.0_f64) {
        let bearing = deep_groove::<9>(10e-6);
        let cage = Phase::from_revolutions(angle);
        let next = cage.wrapping_add(Phase::from_revolutions(1.0 / 9.0));
        let (a, b) = (wrench_of(&bearing, u, cage), wrench_of(&bearing, u, next));
        prop_assert!(relative_to_largest(&a, &b) < 1e-10 || a.iter().all(|x| x.abs() < 1e-9));
    }

    /// A bearing facing -Z is the same one turned by pi about X (`docs/src/models.md#displacement-datum`).
    #[test]
    fn mirrored_is_turned_about_x(u in displacement(), angle in 0.0..1.0_f64) {
        let places: ElementPositions<f64, 14> = evenly_spaced(Phase::from_revolutions(0.013));
        let plain = Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
        let seen = places.map(|p| p.mirrored());
        let mirrored = Mirrored(Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), seen, DisplacementDatum::Touching).unwrap());
        let cage = Phase::from_revolutions(angle);
        // The same pose in both frames, the same cage: the places in the mirror stand where the plain ones stand,
        // reflected in the X-Z plane, so the mirrored bearing at (u, -v, -w, thu, -thv) and -cage is the plain one.
        let there = wrench_of(&mirrored, u.mirrored(), cage.reversed());
        let seen_places = Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), seen, DisplacementDatum::Touching).unwrap();
        let here = Wrench::from_array(wrench_of(&seen_places, u, cage)).mirrored().to_array();
        prop_assert_eq!(there, here);
        // A mirrored thrust bearing carries thrust in the opposite direction.
        let push = Displacement { w: 10e-6, ..Displacement::default() };
        prop_assert!(wrench_of(&plain, push, cage)[2] < -400.0);
        prop_assert!(wrench_of(&mirrored, push, cage)[2] > -1.0);
    }

    /// The force has a potential at rest: no work around a closed path in displacement.
    #[test]
    fn no_work_around_a_closed_loop(centre in displacement(), a in displacement(), b in displacement()) {
        let bearing = deep_groove::<9>(10e-6);
        let steps = 4000;
        let at = |i: usize| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / steps as f64).sin_cos();
            let mix = |x: f64, p: f64, q: f64| x + 0.1 * (c * p + s * q);
            let mut u = centre.to_array();
            for ((x, p), q) in u.iter_mut().zip(a.to_array()).zip(b.to_array()) {
                *x = mix(*x, p, q);
            }
            u
        };
        let (mut work, mut moved) = (0.0, 0.0);
        for i in 0..steps {
            let (from, to) = (at(i), at(i + 1));
            let mut half = from;
            for (x, y) in half.iter_mut().zip(to) {
                *x = 0.5 * (*x + y);
            }
            let f = wrench_of(&bearing, Displacement::from_array(half), Phase::ZERO);
            for k in 0..5 {
                work += f[k] * (to[k] - from[k]);
                moved += (f[k] * (to[k] - from[k])).abs();
            }
        }
        prop_assert!(work.abs() <= 2e-6 * moved + 1e-12, "{} of {}", work, moved);
    }

    /// More displacement along itself never gives less force against it.
    #[test]
    fn force_is_monotone(u in displacement(), more in 1.0..1.5_f64) {
        let bearing = Radial::<f64, Exact, _, ElementPositions<f64, 9>>::try_new(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness: 8e9 }, 5e-6).unwrap();
        let against = |scale: f64| {
            let f = bearing.reaction(&Displacement { u: scale * u.u, v: scale * u.v, ..u }, &Phase::ZERO.into()).wrench;
            -(f.fx * u.u + f.fy * u.v)
        };
        prop_assert!(against(more) >= against(1.0));
    }

    /// A rigid displacement of the whole housing is the opposite displacement of the inner ring (Hajzman, eq. 2).
    #[test]
    fn moving_the_housing_is_moving_the_ring_back(u in displacement(), x in -5e-6..5e-6_f64, y in -5e-6..5e-6_f64, angle in 0.0..1.0_f64) {
        let bearing = Radial::<f64, Exact, _, ElementPositions<f64, 9>>::try_new(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness: 8e9 }, 2e-6).unwrap();
        let cage = Phase::from_revolutions(angle);
        let mut housing = [HousingPoint { displacement: [x, y, 0.0], ..HousingPoint::default() }; 9];
        let flexible = bearing.reaction_flexible(&u, &cage.into(), &mut housing).wrench.to_array();
        let rigid = wrench_of(&bearing, Displacement { u: u.u - x, v: u.v - y, ..u }, cage);
        prop_assert!(relative_to_largest(&flexible, &rigid) < 1e-9 || rigid.iter().all(|f| f.abs() < 1e-6));
    }
}

/// The first paper's six entries in its axes: X axial, Y and Z radial, the torsion entry always zero.
#[test]
fn conversion_from_the_axes_of_hajzman() {
    let q = Displacement::from_hajzman([3e-6, 1e-6, 2e-6, 9.0, 4e-5, 5e-5]);
    assert_eq!(q, Displacement { u: 1e-6, v: 2e-6, w: 3e-6, thu: 4e-5, thv: 5e-5 });
    let wrench = Wrench { fx: 1.0, fy: 2.0, fz: 3.0, mx: 4.0, my: 5.0 };
    assert_eq!(wrench.to_hajzman(), [3.0, 1.0, 2.0, 0.0, 4.0, 5.0]);
}

#[test]
fn spall_reduces_the_deflection_within_its_width() {
    let centre = Phase::from_revolutions(0.75);
    let half_sine = Spall::new(BearingComponent::Outer, centre, 0.05_f64, 3e-6, SpallShape::HalfSine);
    let at = |rad: f64| half_sine.depth_at(centre.wrapping_add(Phase::from_radians(rad)));
    assert!((at(0.0) - 3e-6).abs() < 1e-20);
    for s in [-0.9, -0.3, 0.5, 0.99] {
        let expected = 3e-6 * (std::f64::consts::FRAC_PI_2 * s).cos();
        assert!((at(0.05 * s) - expected).abs() < 1e-18, "{s}");
    }
    assert_eq!(at(0.0501), 0.0);
    assert_eq!(at(-0.0501), 0.0);
    let step = Spall::new(BearingComponent::Outer, centre, 0.05_f64, 3e-6, SpallShape::Rectangular);
    assert_eq!(step.depth_at(centre.wrapping_add(Phase::from_radians(0.049))), 3e-6);
}

/// In f32 the deflection of a micrometre on a groove distance of 0.3 mm keeps its digits.
#[test]
fn single_precision_keeps_small_deflections() {
    let geometry = acbb_s_geometry();
    let single = Angular::<f32, Exact, ElementPositions<f32, 14>>::try_new(
        geometry,
        evenly_spaced(Phase::ZERO),
        DisplacementDatum::Touching,
    )
    .unwrap();
    for scale in [1.0, 0.1, 0.01] {
        let u =
            Displacement { u: 2e-6 * scale, v: 1e-6 * scale, w: 10e-6 * scale, thu: 1e-4 * scale, thv: -5e-5 * scale };
        let exact = wrench_of(&angular_contact(), u, Phase::ZERO);
        let u32 = Displacement::from_array(u.to_array().map(|x| x as f32));
        let found = single.reaction(&u32, &Phase::ZERO.into()).wrench.to_array().map(f64::from);
        let error = relative_to_largest(&found, &exact);
        assert!(error < 3e-6, "at {scale}: {error:e}");
    }
}
