//! The table against the balls it was made from: at most 1e-4 of the largest load over the declared domain, edge of contact
//! and a factor of ten in speed included, and of the largest load in service where that is far below.

use ballrace::bearing::angular::DisplacementDatum;
use ballrace::bearing::geometry::BallBearingGeometry;
use ballrace::bearing::quasi_static::QuasiStatic;
use ballrace::bearing::quasi_static::film::{Dry, Film, Lubricant};
use ballrace::bearing::quasi_static::inertia::{FrictionSharing, Gyroscopic, InertiaParams};
use ballrace::bearing::surface::{BearingComponent, Direction, Feature, Spall, SpallShape, SurfaceDeviation, Wave};
use ballrace::bearing::tabulated::{Node, Table, TableDomain, Tabulated, fill_table};
use ballrace::bearing::{Bearing, BlockedPositions, ElementPosition, ElementPositions, Reaction, evenly_spaced};
use ballrace::{BearingKinematicState, Displacement, Exact, Phase, Scalar, Status};
use ballrace_tests::bearings::{STEEL_BALLS, acbb_s_geometry, harris_218_geometry};
use ballrace_tests::states::Random;
use std::f64::consts::TAU;

const RPM: f64 = TAU / 60.0;

type Solved<F> = QuasiStatic<f64, Exact, [ElementPosition<f64>; 1], Gyroscopic<f64>, F>;
type LookedUp<T, const F: usize> = Tabulated<T, Exact, [ElementPosition<T>; 1], Vec<Node<T, F>>, F>;

fn solved(geometry: BallBearingGeometry, params: &InertiaParams) -> Solved<Dry> {
    let one = [ElementPosition::from_azimuth(Phase::ZERO)];
    QuasiStatic::try_new(geometry, one, DisplacementDatum::Touching).unwrap().with_inertia(params).unwrap()
}

/// 1000 to 10 000 rpm, 20 to 60 degrees, from 60 um of room to 100 um of approach.
fn domain(intervals: [usize; 3]) -> TableDomain {
    TableDomain {
        approach: [-60e-6, 100e-6],
        scale: 300e-6,
        angle: [20_f64.to_radians(), 60_f64.to_radians()],
        speed: [1_000.0 * RPM, 10_000.0 * RPM],
        speed_scale: 1e5 * RPM,
        speed_ratios: [1.0, 0.0],
        intervals,
    }
}

fn looked_up<T: Scalar, L: Film<f64>, const F: usize>(bearing: &Solved<L>, domain: &TableDomain) -> LookedUp<T, F>
where
    Exact: ballrace::Math<T>,
{
    let grid = domain.grid(bearing.table_constants().distance).unwrap();
    let mut nodes = vec![[0.0; F]; grid.len()];
    assert_eq!(fill_table(bearing, domain, &grid, &mut nodes), 0, "every ball of the domain settles");
    let nodes = nodes.into_iter().map(|node| node.map(T::from_f64)).collect();
    Tabulated::new(
        [ElementPosition::from_azimuth(Phase::ZERO)],
        bearing.table_constants().rounded(),
        Table::new(grid.rounded(), nodes),
        false,
    )
}

/// A displacement of the one ball's inner groove centre by approach and angle, and a speed, all within the domain.
fn state(
    random: &mut Random,
    geometry: &BallBearingGeometry,
    domain: &TableDomain,
) -> (Displacement<f64>, BearingKinematicState<f64>) {
    let [s0, s1] = domain.approach;
    // Half of them about the edge of contact.
    let s = if random.unit() < 0.5 { random.between(s0, s1) } else { random.between(0.1 * s0, 0.1 * s1) };
    let (angle, speed) =
        (random.between(domain.angle[0], domain.angle[1]), random.between(domain.speed[0], domain.speed[1]));
    let (a, free) = (geometry.groove_distance(), geometry.contact_angle);
    let u = (a + s) * angle.cos() - a * free.cos();
    let w = (a + s) * angle.sin() - a * free.sin();
    (
        Displacement { u, w, ..Displacement::default() },
        BearingKinematicState { inner_speed: speed, ..BearingKinematicState::default() },
    )
}

/// Median, 99 % and largest error over the largest load met.
fn errors<T: Scalar, L: Film<f64>, const F: usize>(
    bearing: &Solved<L>,
    table: &LookedUp<T, F>,
    domain: &TableDomain,
    geometry: &BallBearingGeometry,
) -> [f64; 3]
where
    Exact: ballrace::Math<T>,
{
    let truth = bearing.with_newton_steps(40);
    let mut random = Random(0x5eed);
    let (mut largest, mut errors) = (0.0_f64, Vec::new());
    for _ in 0..20_000 {
        let (u, at) = state(&mut random, geometry, domain);
        let expected = truth.reaction(&u, &at);
        assert!(!expected.status.contains(Status::NOT_CONVERGED));
        let rounded = Displacement::from_array(u.to_array().map(T::from_f64));
        let speed =
            BearingKinematicState { inner_speed: T::from_f64(at.inner_speed), ..BearingKinematicState::default() };
        let found = table.reaction(&rounded, &speed);
        assert_eq!(found.status, Status::OK, "{u:?} {at:?}");
        let difference = |i: usize| expected.wrench.to_array()[i] - found.wrench.to_array()[i].to_f64();
        let arm = geometry.inner_groove_radius();
        errors.push(difference(0).hypot(difference(2)).max(difference(4).abs() / arm));
        largest = largest.max(expected.load);
    }
    errors.sort_by(f64::total_cmp);
    [errors[10_000], errors[19_800], errors[19_999]].map(|e| e / largest)
}

fn shown(errors: [f64; 3]) -> String {
    errors.map(|e| format!("{e:.1e}")).join(", ")
}

#[test]
fn forces_within_a_ten_thousandth_of_the_largest_load() {
    println!("sharing | error in f64: median, 99 %, largest | in f32");
    for friction_sharing in [FrictionSharing::Outer, FrictionSharing::Proportional] {
        let bearing = solved(harris_218_geometry(), &InertiaParams { friction_sharing, ..STEEL_BALLS });
        let domain = domain([32, 16, 32]);
        let double = errors(&bearing, &looked_up::<f64, _, 3>(&bearing, &domain), &domain, &harris_218_geometry());
        let single = errors(&bearing, &looked_up::<f32, _, 3>(&bearing, &domain), &domain, &harris_218_geometry());
        println!("{friction_sharing:?} | {} | {}", shown(double), shown(single));
        assert!(double[2] < 1e-4 && single[2] < 1e-4, "{} {}", shown(double), shown(single));
    }
}

/// The ends of the speeds are inside in `f32` too, where their squares are rounded; a thousandth beyond them is not.
#[test]
fn ends_of_the_range_are_inside_the_table() {
    let bearing = solved(harris_218_geometry(), &STEEL_BALLS);
    for step in 0..50 {
        let speed = [1_000.0, 10_000.0 + 13.7 * f64::from(step)].map(|rpm| rpm * RPM);
        let domain = TableDomain { speed, speed_scale: 0.0, ..domain([8, 8, 2]) };
        let table = looked_up::<f32, _, 2>(&bearing, &domain);
        let status = |speed: f64| {
            let at = BearingKinematicState { inner_speed: speed as f32, ..BearingKinematicState::default() };
            table.reaction(&Displacement { w: 10e-6, ..Displacement::default() }, &at).status
        };
        let [low, high] = speed;
        assert_eq!([status(low), status(high)], [Status::OK; 2], "{speed:?} rad/s");
        assert_eq!([status(0.999 * low), status(1.001 * high)], [Status::OUT_OF_TABLE; 2], "{speed:?} rad/s");
    }
}

/// The domain reaches 20 times the approach in service, 90 times the load; the table has 61 kB in `f32`.
#[test]
fn forces_within_a_ten_thousandth_of_a_light_load() {
    let bearing = solved(harris_218_geometry(), &STEEL_BALLS);
    let speed = [0.64_f64, 1.36].map(|squared| squared.sqrt() * 5_000.0 * RPM);
    let graded = TableDomain { scale: 8e-6, speed, speed_scale: 0.0, ..domain([72, 28, 2]) };
    let in_service = |domain: TableDomain| TableDomain { approach: [-1e-6, 5e-6], speed: [5_000.0 * RPM; 2], ..domain };
    let error = |domain: TableDomain| {
        let table = looked_up::<f32, _, 2>(&bearing, &domain);
        assert!(4 * 2 * table.table().nodes().len() <= 64 << 10);
        errors(&bearing, &table, &in_service(domain), &harris_218_geometry())
    };
    let [found, uniform] = [error(graded), error(TableDomain { scale: 300e-6, ..graded })];
    println!("light load, graded and uniform: {}; {}", shown(found), shown(uniform));
    assert!(found[2] < 1e-4 && uniform[2] > 3.0 * found[2]);
}

#[test]
fn equilibrium_with_an_oil_film() {
    let oil = Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 };
    let bearing = solved(harris_218_geometry(), &STEEL_BALLS).with_film(oil).unwrap();
    let domain = domain([32, 16, 32]);
    let found = errors(&bearing, &looked_up::<f64, _, 2>(&bearing, &domain), &domain, &harris_218_geometry());
    println!("with a film: {}", shown(found));
    assert!(found[2] < 2e-4 && found[1] < 1e-4, "{}", shown(found));
}

#[test]
fn size_against_error() {
    let bearing = solved(harris_218_geometry(), &STEEL_BALLS);
    println!("intervals | nodes | kB in f32 | error: median, 99 %, largest");
    let mut last = f64::INFINITY;
    for intervals in [[8, 4, 8], [16, 8, 16], [32, 16, 32], [64, 32, 64]] {
        let domain = domain(intervals);
        let table = looked_up::<f64, _, 2>(&bearing, &domain);
        let nodes = table.table().nodes().len();
        let found = errors(&bearing, &table, &domain, &harris_218_geometry());
        println!("{intervals:?} | {nodes} | {:.0} | {}", nodes as f64 * 8e-3, shown(found));
        assert!(found[2] < last, "a larger table is truer");
        last = found[2];
    }
}

#[test]
fn states_outside_the_table_are_flagged() {
    let bearing = solved(harris_218_geometry(), &STEEL_BALLS);
    let domain = domain([16, 8, 8]);
    let table = looked_up::<f64, _, 2>(&bearing, &domain);
    let at = BearingKinematicState { inner_speed: 5_000.0 * RPM, ..BearingKinematicState::default() };
    let inside = Displacement { w: 20e-6, ..Displacement::default() };
    assert_eq!(table.reaction(&inside, &at).status, Status::OK);
    let outside = [
        (Displacement { w: 400e-6, ..inside }, at),
        (Displacement { w: -300e-6, u: -300e-6, ..inside }, at),
        (Displacement { u: 900e-6, w: -700e-6, ..inside }, at),
        (inside, BearingKinematicState { inner_speed: 900.0 * RPM, ..at }),
        (inside, BearingKinematicState { inner_speed: 10_100.0 * RPM, ..at }),
        (inside, BearingKinematicState::default()),
    ];
    for (u, at) in outside {
        assert_eq!(table.reaction(&u, &at).status, Status::OUT_OF_TABLE, "{u:?} {at:?}");
    }
    let backwards = BearingKinematicState { inner_speed: -at.inner_speed, ..at };
    assert_eq!(table.reaction(&inside, &backwards), table.reaction(&inside, &at), "either way round");
    let odd = Displacement { u: f64::NAN, ..inside };
    assert!(!table.reaction(&odd, &at).wrench.is_finite());
}

#[test]
fn loads_continue_above_the_largest_approach() {
    let bearing = solved(harris_218_geometry(), &STEEL_BALLS);
    let domain = TableDomain { scale: 30e-6, ..domain([32, 16, 8]) };
    let table = looked_up::<f64, _, 2>(&bearing, &domain);
    let above = TableDomain { approach: [100e-6, 300e-6], ..domain };
    let (mut random, mut above_count) = (Random(0x0a), 0);
    for _ in 0..1_000 {
        let (u, at) = state(&mut random, &harris_218_geometry(), &above);
        let (found, expected) = (table.reaction(&u, &at), bearing.with_newton_steps(40).reaction(&u, &at));
        // Half of the states are inside.
        if found.status == Status::OK {
            continue;
        }
        above_count += 1;
        assert!((found.load / expected.load - 1.0).abs() < 0.1, "{} {} {u:?}", found.load, expected.load);
    }
    assert!(above_count > 400, "{above_count}");
}

#[test]
fn tangents_against_differences() {
    let bearing = solved(acbb_s_geometry(), &InertiaParams { friction_sharing: FrictionSharing::Equal, ..STEEL_BALLS });
    let domain = TableDomain { approach: [-10e-6, 30e-6], scale: 60e-6, angle: [0.1, 0.8], ..domain([32, 16, 16]) };
    let table = looked_up::<f64, _, 3>(&bearing, &domain);
    let mut random = Random(0xabc);
    for _ in 0..200 {
        let (u, at) = state(&mut random, &acbb_s_geometry(), &domain);
        let (reaction, k) = table.reaction_and_stiffness(&u, &at);
        assert_eq!(reaction, table.reaction(&u, &at));
        if reaction.load < 1.0 {
            continue;
        }
        for j in 0..5 {
            let h = if j < 3 { 1e-10 } else { 1e-8 };
            let force = |sign: f64| {
                let mut q = u.to_array();
                q[j] += sign * h;
                table.reaction(&Displacement::from_array(q), &at).wrench.to_array()
            };
            let (up, down) = (force(1.0), force(-1.0));
            for i in 0..5 {
                let numeric = -(up[i] - down[i]) / (2.0 * h);
                let scale = (k[(0, 0)].abs() + k[(2, 2)].abs())
                    * [1.0, 0.02][usize::from(i > 2)]
                    * [1.0, 0.02][usize::from(j > 2)];
                assert!((k[(i, j)] - numeric).abs() < 2e-4 * scale, "{i} {j}: {} {numeric}", k[(i, j)]);
            }
        }
    }
}

#[test]
fn waviness_and_damage_enter_as_shifts() {
    let places: ElementPositions<f64, 9> = evenly_spaced(Phase::ZERO);
    let wave = Wave {
        component: BearingComponent::Inner,
        direction: Direction::Radial,
        order: 10,
        amplitude: 0.5e-6,
        phase: Phase::ZERO,
    };
    let ball = Wave { component: BearingComponent::Ball(Phase::ZERO), order: 2, ..wave };
    let spall = Spall::new(BearingComponent::Outer, Phase::from_revolutions(0.9), 0.1, 2e-6, SpallShape::HalfSine);
    let features = [Feature::Wave(wave), Feature::Wave(ball), Feature::Spall(spall)];
    let uneven = || SurfaceDeviation::<Exact, _>::new(features);
    let one = solved(acbb_s_geometry(), &STEEL_BALLS);
    let domain = TableDomain { approach: [-10e-6, 30e-6], scale: 60e-6, angle: [0.1, 0.8], ..domain([32, 16, 16]) };
    let LookedUpParts { table, seat } = parts(&one, &domain);
    let table = Tabulated::<f64, Exact, _, _, 2>::new(places, seat, table, false).with_surface(uneven());
    let truth = QuasiStatic::<f64, Exact, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
    let truth = truth.with_inertia(&STEEL_BALLS).unwrap().with_surface(uneven());
    for i in 0..50 {
        let turn = Phase::from_revolutions(f64::from(i) / 50.0);
        let at = BearingKinematicState {
            cage: turn,
            inner: turn.wrapping_mul(3),
            ball: turn.wrapping_mul(7),
            inner_speed: 800.0,
            ..BearingKinematicState::default()
        };
        let u = Displacement { u: 2e-6, v: -1e-6, w: 10e-6, thu: 1e-4, thv: 0.0 };
        let (a, b) = (table.reaction(&u, &at), truth.reaction(&u, &at));
        assert_eq!(a.status, Status::OK);
        for (x, y) in a.wrench.to_array().into_iter().zip(b.wrench.to_array()) {
            assert!((x - y).abs() < 2e-3 * b.load / 9.0 * 9.0_f64.sqrt(), "{x} {y}");
        }
    }
}

struct LookedUpParts {
    table: Table<f64, Vec<Node<f64, 2>>, 2>,
    seat: ballrace::bearing::quasi_static::TableConstants<f64>,
}

fn parts(bearing: &Solved<Dry>, domain: &TableDomain) -> LookedUpParts {
    let made = looked_up::<f64, _, 2>(bearing, domain);
    let table = Table::new(*made.table().grid(), made.table().nodes().to_vec());
    LookedUpParts { table, seat: *made.constants() }
}

#[test]
fn impossible_table_domain_is_rejected() {
    let good = domain([8, 8, 8]);
    for bad in [
        TableDomain { approach: [1e-6, 1e-6], ..good },
        TableDomain { approach: [-1e-3, 1e-6], ..good },
        TableDomain { scale: 0.0, ..good },
        TableDomain { angle: [0.5, 0.4], ..good },
        TableDomain { angle: [0.0, 1.6], ..good },
        TableDomain { speed_scale: -1.0, ..good },
        TableDomain { speed: [-1.0, 5.0], ..good },
        TableDomain { intervals: [3, 8, 8], ..good },
        TableDomain { speed: [f64::NAN, 5.0], ..good },
    ] {
        assert!(bad.grid(1e-3).is_err(), "{bad:?}");
    }
}

/// However many balls are looked up side by side, each enters the sum once: as bearings of one ball each.
#[test]
fn many_balls_are_the_sum_of_their_balls() {
    fn check<const F: usize>(layers: usize) {
        let ball = solved(
            acbb_s_geometry(),
            &InertiaParams { friction_sharing: FrictionSharing::Proportional, ..STEEL_BALLS },
        );
        let table = looked_up::<f64, _, F>(&ball, &domain([32, 16, layers]));
        let bearing = |places: Vec<ElementPosition<f64>>| {
            let table = Table::new(*table.table().grid(), table.table().nodes());
            Tabulated::<f64, Exact, _, _, F>::new(places, ball.table_constants(), table, false)
        };
        let mut random = Random(0x5eed + F as u64);
        for balls in 1..=36 {
            let places: Vec<ElementPosition<f64>> =
                (0..balls).map(|j| ElementPosition::evenly_spaced(Phase(1), j, balls)).collect();
            let singles: Vec<_> = places.iter().map(|&place| bearing(vec![place])).collect();
            let side_by_side = BlockedPositions::<_, Vec<_>>::new(places.clone());
            let all = bearing(places);
            let kept = Table::new(*table.table().grid(), table.table().nodes());
            let kept = Tabulated::<f64, Exact, _, _, F>::new(side_by_side, ball.table_constants(), kept, false);
            for _ in 0..20 {
                let mut entry = |size: f64| random.between(-size, size);
                let [u, v, thu, thv] = [entry(2e-5), entry(2e-5), entry(4e-4), entry(4e-4)];
                let u = Displacement { u, v, w: entry(5e-5), thu, thv };
                let cage = Phase::from_revolutions(random.unit());
                let at = BearingKinematicState { cage, inner_speed: 5_000.0 * RPM, ..BearingKinematicState::default() };
                let found = all.reaction(&u, &at);
                assert_eq!(found, kept.reaction(&u, &at), "{balls} balls kept side by side");
                let answers = singles.iter().map(|single| single.reaction(&u, &at));
                let sum = answers.reduce(|sum, one| sum + one).unwrap();
                assert_eq!(found.status, sum.status, "{balls} balls");
                let numbers = |r: &Reaction<f64>| r.wrench.to_array().into_iter().chain([r.load]);
                for (i, (x, y)) in numbers(&found).zip(numbers(&sum)).enumerate() {
                    assert!((x - y).abs() <= 1e-12 * (1.0 + found.load), "{balls} balls, entry {i}: {x:e} for {y:e}");
                }
            }
        }
    }
    for layers in [0, 4] {
        check::<2>(layers);
        check::<3>(layers);
        check::<4>(layers);
    }
}
