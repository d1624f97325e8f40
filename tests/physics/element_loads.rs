//! Loads of the elements: those of a force, of the loads alone, and of bearings with one element each.

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::quasi_static::QuasiStatic;
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, InertiaParams, RaceControl};
use ballrace::bearing::surface::{BearingComponent, Feature, Spall, SpallShape, SurfaceDeviation};
use ballrace::bearing::tabulated::{Node, Table, TableDomain, Tabulated, fill_table};
use ballrace::bearing::{Bearing, BlockedPositions, ElementPosition, ElementPositions, Mirrored, evenly_spaced};
use ballrace::contact::law::{LineContactLaw, PointContactLaw};
use ballrace::{BearingKinematicState, Displacement, Exact, Phase};
use ballrace_tests::bearings::acbb_s_geometry;

const SPEED: f64 = 600.0;
/// More than are evaluated together, and no multiple of a block.
const MOST: usize = 18;

fn pose(i: u32) -> (Displacement<f64>, BearingKinematicState<f64>) {
    let [u, v, w, thu, thv, cage] =
        [0.618, 0.414, 0.732, 0.236, 0.303, 0.577].map(|stride| 2.0 * (f64::from(i) * stride).fract() - 1.0);
    let u = Displacement { u: 12e-6 * u, v: 12e-6 * v, w: 15e-6 * w, thu: 3e-4 * thu, thv: 3e-4 * thv };
    (u, BearingKinematicState { inner_speed: SPEED, ..Phase::from_revolutions(cage).into() })
}

/// The loads of a bearing with all these elements are those of bearings with one element, which the kernel evaluates without blocks.
fn check<B: Bearing<f64>>(name: &str, of: impl Fn(Vec<ElementPosition<f64>>) -> B) {
    let all: ElementPositions<f64, MOST> = evenly_spaced(Phase::from_revolutions(0.01));
    for count in 1..=MOST {
        let positions = all[..count].to_vec();
        let whole = of(positions.clone());
        let alone: Vec<B> = positions.into_iter().map(|one| of(vec![one])).collect();
        let mut unloaded = 0;
        for i in 0..40 {
            let (u, at) = pose(i);
            let expected: Vec<f64> = alone.iter().map(|one| one.reaction(&u, &at).load).collect();
            let (mut loads, mut together) = (vec![f64::NAN; count], vec![f64::NAN; count]);
            whole.element_loads(&u, &at, &mut loads);
            let reaction = whole.reaction_and_loads(&u, &at, &mut together);
            assert_eq!(reaction, whole.reaction(&u, &at), "{name}, {count} elements, pose {i}");
            let bits = |loads: &[f64]| loads.iter().map(|load| load.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&loads), bits(&together), "{name}, {count} elements, pose {i}");
            for (load, expected) in loads.iter().zip(&expected) {
                assert!((load - expected).abs() <= 1e-9 * expected.abs(), "{name}, {count}: {load} and {expected} N");
            }
            // Fewer loads than elements are the first of them.
            let mut first = vec![f64::NAN; count / 2];
            whole.reaction_and_loads(&u, &at, &mut first);
            assert_eq!(bits(&first), bits(&loads[..count / 2]), "{name}, {count} elements, pose {i}");
            unloaded += expected.iter().filter(|load| **load == 0.0).count();
        }
        assert!(unloaded < 40 * count, "{name}: no element is loaded");
        // The centrifugal force keeps balls with mass in contact.
        assert!(unloaded > 0 || name.ends_with("with mass"), "{name}: every element is loaded");
    }
}

fn spall() -> SurfaceDeviation<Exact, [Feature<f64>; 1]> {
    let centre = Phase::from_revolutions(0.3);
    let spall = Spall::new(BearingComponent::Outer, centre, 0.4, 3e-6, SpallShape::HalfSine);
    SurfaceDeviation::new([Feature::Spall(spall)])
}

#[test]
fn of_lumped_bearings() {
    let (point, line) = (PointContactLaw { stiffness: 8e9 }, LineContactLaw { stiffness: 3e8 });
    check("point contact", |all| Radial::<f64, Exact, _, _>::try_new(all, point, 3e-6).unwrap());
    check("in blocks", |all| {
        let blocked = BlockedPositions::<_, Vec<_>>::new(all);
        Radial::<f64, Exact, _, _>::try_new(blocked, point, 3e-6).unwrap()
    });
    check("line contact with damage", |all| {
        Radial::<f64, Exact, _, _>::try_new(all, line, 2e-6).unwrap().with_surface(spall())
    });
    check("axial", |all| Axial::<f64, Exact, _, _>::try_new(all, point, 1e-6, 0.02).unwrap());
    // The loads of a combined bearing are those of its first one.
    let (u, at) = pose(3);
    let places: ElementPositions<f64, 9> = evenly_spaced(Phase::ZERO);
    let radial = Radial::<f64, Exact, _, _>::try_new(places, point, 3e-6).unwrap();
    let axial = Axial::<f64, Exact, _, _>::try_new(places, point, 1e-6, 0.02).unwrap();
    let (mut of_first, mut of_both) = ([0.0; 9], [0.0; 9]);
    radial.element_loads(&u, &at, &mut of_first);
    let both = Combined(radial, axial);
    assert_eq!(both.reaction_and_loads(&u, &at, &mut of_both), both.reaction(&u, &at));
    assert_eq!(of_first, of_both);
}

#[test]
fn of_angular_bearings() {
    let geometry = acbb_s_geometry();
    let bearing = |all| Angular::<f64, Exact, _>::try_new(geometry, all, DisplacementDatum::Touching).unwrap();
    check("angular", bearing);
    check("angular with damage", |all| bearing(all).with_surface(spall()));
    check("mirrored", |all| Mirrored(bearing(all)));
}

#[test]
fn of_solved_and_tabulated_bearings() {
    let inertia = InertiaParams {
        density: 7800.0,
        centrifugal: true,
        gyroscopic: true,
        race_control: RaceControl::Outer,
        friction_sharing: FrictionSharing::Outer,
    };
    let solved = |all| {
        let datum = DisplacementDatum::Touching;
        QuasiStatic::<f64, Exact, _>::try_new(acbb_s_geometry(), all, datum)
            .unwrap()
            .with_outer_control(&inertia)
            .unwrap()
    };
    check("quasi-static, with mass", solved);
    let of_one = solved(evenly_spaced::<f64, 1>(Phase::ZERO).to_vec());
    let domain = TableDomain {
        approach: [-60e-6, 60e-6],
        scale: 20e-6,
        speed_scale: 10.0 * SPEED,
        angle: [-0.2, 1.2],
        speed: [0.5 * SPEED, 2.0 * SPEED],
        speed_ratios: [1.0, 0.0],
        intervals: [16, 16, 4],
    };
    let grid = domain.grid(of_one.table_constants().distance).unwrap();
    let mut nodes: Vec<Node<f64, 4>> = vec![[0.0; 4]; grid.len()];
    fill_table(&of_one, &domain, &grid, &mut nodes);
    check("tabulated, with mass", |all| {
        let table = Table::new(grid, nodes.clone());
        Tabulated::<f64, Exact, _, _, 4>::new(all, of_one.table_constants(), table, false)
    });
}
