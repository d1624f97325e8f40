//! Opposite pairs, and the cage's frame: the same bearing by another evaluation.

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::surface::{BearingComponent, Feature, Spall, SpallShape, SurfaceDeviation};
use ballrace::bearing::{Bearing, CageFrame, ElementPositions, OpposedPairs, evenly_spaced, evenly_spaced_pairs};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::{Displacement, Exact, Phase};
use ballrace_tests::bearings::acbb_s_geometry;
use proptest::prelude::*;

const FIRST: Phase = Phase(0x0123_4567_89ab_cdef);

/// Ten elements, so that a group of four pairs and a rest are met.
fn pairs() -> OpposedPairs<f64, 5> {
    evenly_spaced_pairs(FIRST)
}

fn places() -> ElementPositions<f64, 10> {
    evenly_spaced(FIRST)
}

fn spall() -> SurfaceDeviation<Exact, [Feature<f64>; 1]> {
    let centre = Phase::from_revolutions(0.3);
    SurfaceDeviation::new([Feature::Spall(Spall::new(
        BearingComponent::Outer,
        centre,
        0.2,
        3e-6,
        SpallShape::HalfSine,
    ))])
}

fn displacement() -> impl Strategy<Value = Displacement<f64>> {
    prop::array::uniform5(-1.0..1.0_f64).prop_map(|[u, v, w, thu, thv]| Displacement {
        u: u * 30e-6,
        v: v * 30e-6,
        w: w * 50e-6,
        thu: thu * 5e-4,
        thv: thv * 5e-4,
    })
}

/// Equal but for rounding, against the largest entry or a millionth of a newton.
fn close(x: &[f64], y: &[f64]) -> bool {
    let largest = y.iter().fold(1e-6, |m: f64, y| m.max(y.abs()));
    x.iter().zip(y).all(|(x, y)| (x - y).abs() <= 1e-9 * largest)
}

fn assert_same(paired: &impl Bearing<f64>, single: &impl Bearing<f64>, u: &Displacement<f64>, cage: Phase) {
    let (a, ka) = paired.reaction_and_stiffness(u, &cage.into());
    let (b, kb) = single.reaction_and_stiffness(u, &cage.into());
    let force = paired.reaction(u, &cage.into());
    assert!(close(&force.wrench.to_array(), &b.wrench.to_array()), "{force:?} {b:?}");
    assert!(close(&a.wrench.to_array(), &b.wrench.to_array()), "{a:?} {b:?}");
    assert!(close(&[force.load, a.load], &[b.load; 2]), "{} {} {}", force.load, a.load, b.load);
    assert!(close(ka.as_slice(), kb.as_slice()), "{ka} {kb}");
    let (mut loads, mut expected) = ([0.0; 10], [0.0; 10]);
    paired.element_loads(u, &cage.into(), &mut loads);
    single.element_loads(u, &cage.into(), &mut expected);
    assert!(close(&loads, &expected), "{loads:?} {expected:?}");
}

proptest! {
    /// Two opposite elements share one power, and nothing changes: all laws, damage on the race, axial elements.
    #[test]
    fn lumped_pairs_are_the_same_bearing(u in displacement(), cage in any::<u64>(), play in 0.0..20e-6) {
        let cage = Phase(cage);
        macro_rules! check {
            ($law:expr) => {{
                let paired = Radial::<f64, Exact, _, _>::try_new(pairs(), $law, play).unwrap();
                let single = Radial::<f64, Exact, _, _>::try_new(places(), $law, play).unwrap();
                assert_same(&paired, &single, &u, cage);
                assert_same(&paired.with_surface(spall()), &single.with_surface(spall()), &u, cage);
                let axial_pairs = Axial::<f64, Exact, _, _>::try_new(pairs(), $law, play - 10e-6, 0.02).unwrap();
                let axial = Axial::<f64, Exact, _, _>::try_new(places(), $law, play - 10e-6, 0.02).unwrap();
                assert_same(&Combined(paired, axial_pairs), &Combined(single, axial), &u, cage);
            }};
        }
        check!(PointContactLaw { stiffness: 8e9 });
        check!(LineContactLaw { stiffness: 3e8 });
        check!(PowerLaw { stiffness: 2e9, exponent: 1.37 });
    }

    #[test]
    fn angular_pairs_are_the_same_bearing(u in displacement(), cage in any::<u64>()) {
        for zero in [DisplacementDatum::Touching, DisplacementDatum::Centred] {
            let paired = Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), pairs(), zero).unwrap();
            let single = Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), places(), zero).unwrap();
            assert_same(&paired, &single, &u, Phase(cage));
            assert_same(&paired.with_surface(spall()), &single.with_surface(spall()), &u, Phase(cage));
        }
    }

    /// Evaluated in the cage's frame: displacement turned into it, wrench turned out of it, by this test's own rotation.
    #[test]
    fn the_cage_frame_is_the_fixed_one_turned(u in displacement(), cage in any::<u64>()) {
        let cage = Phase(cage);
        let bearing = Angular::<f64, Exact, _>::try_new(acbb_s_geometry(), places(), DisplacementDatum::Touching).unwrap();
        let (sin, cos) = cage.radians().sin_cos();
        let into = |x: f64, y: f64| (cos * x + sin * y, cos * y - sin * x);
        let ((tu, tv), (tthu, tthv)) = (into(u.u, u.v), into(u.thu, u.thv));
        let local = bearing.reaction_in_cage_frame(&Displacement { u: tu, v: tv, w: u.w, thu: tthu, thv: tthv }, &cage.into()).wrench;
        let fixed = bearing.reaction(&u, &cage.into()).wrench;
        let (fx, fy) = into(fixed.fx, fixed.fy);
        let (mx, my) = into(fixed.mx, fixed.my);
        prop_assert!(close(&local.to_array(), &[fx, fy, fixed.fz, mx, my]));
    }
}

/// Two preloaded opposite elements are loaded at once: one power cannot be shared.
#[test]
fn radial_pairs_refuse_preload() {
    let error = Radial::<f64, Exact, _, _>::try_new(pairs(), PointContactLaw { stiffness: 8e9 }, -1e-6).unwrap_err();
    assert_eq!(
        error.to_string(),
        "radial_play: value out of range: -0.000001, expected 0 m or more with opposite pairs"
    );
}
