//! Every model, in any precision.

use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::quasi_static::QuasiStatic;
use ballrace::bearing::quasi_static::film::Lubricant;
use ballrace::bearing::tabulated::{Table, TableDomain, Tabulated, fill_table};
use ballrace::bearing::{Bearing, ElementPositions, evenly_spaced};
use ballrace::contact::law::{LineContactLaw, PointContactLaw, PowerLaw};
use ballrace::{BearingKinematicState, Exact, Math, Phase, Scalar, Stiffness};
use ballrace_tests::bearings::{STEEL_BALLS, acbb_s_geometry};

/// Speed of the shaft, rad/s.
pub const SPEED: f64 = 1256.0;
const PLAY: f64 = 5e-6;

/// A model and its name.
pub type Named<T> = (&'static str, Box<dyn Bearing<T>>);

/// Turning at [`SPEED`], the cage anywhere.
pub fn turning<T: Scalar>(cage: Phase) -> BearingKinematicState<T> {
    BearingKinematicState { inner_speed: T::from_f64(SPEED), ..BearingKinematicState::from(cage) }
}

/// Models whose balls are where the rings put them.
pub fn direct<T: Scalar, M: Math<T> + 'static>() -> Vec<Named<T>> {
    let places: ElementPositions<T, 9> = evenly_spaced(Phase::ZERO);
    let (point, line) =
        (PointContactLaw { stiffness: T::from_f64(8e9) }, LineContactLaw { stiffness: T::from_f64(3e8) });
    let power = PowerLaw { stiffness: T::from_f64(2e9), exponent: T::from_f64(1.4) };
    let radial = || Radial::<T, M, _, _>::try_new(places, point, PLAY).unwrap();
    let axial = Axial::<T, M, _, _>::try_new(places, point, PLAY, 0.02).unwrap();
    let angular = Angular::<T, M, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
    vec![
        ("linear", Box::new(Linear::new(Stiffness::from_fn(|i, j| T::from_f64(if i == j { 1e8 } else { 0.0 }))))),
        ("radial 3/2", Box::new(radial())),
        ("radial 10/9", Box::new(Radial::<T, M, _, _>::try_new(places, line, PLAY).unwrap())),
        ("radial, any power", Box::new(Radial::<T, M, _, _>::try_new(places, power, PLAY).unwrap())),
        ("radial and axial 3/2", Box::new(Combined(radial(), axial))),
        ("angular", Box::new(angular)),
    ]
}

/// Models whose balls are in equilibrium, solved and looked up.
pub fn balanced<T: Scalar, M: Math<T> + 'static>() -> Vec<Named<T>> {
    let places: ElementPositions<T, 9> = evenly_spaced(Phase::ZERO);
    let plain = QuasiStatic::<T, M, _>::try_new(acbb_s_geometry(), places, DisplacementDatum::Touching).unwrap();
    let massive = plain.with_outer_control(&STEEL_BALLS).unwrap();
    let wet = massive.with_film(Lubricant { viscosity: 0.04, pressure_viscosity: 2.2e-8 }).unwrap();
    vec![
        ("quasi-static", Box::new(plain)),
        ("quasi-static, inertia", Box::new(massive)),
        ("quasi-static, inertia, film", Box::new(wet)),
        ("tabulated", Box::new(tabulated::<T, M>(places))),
    ]
}

fn tabulated<T: Scalar, M: Math<T>>(
    places: ElementPositions<T, 9>,
) -> Tabulated<T, M, ElementPositions<T, 9>, Vec<[T; 2]>, 2> {
    let one: ElementPositions<f64, 1> = evenly_spaced(Phase::ZERO);
    let solved = QuasiStatic::<f64, Exact, _>::try_new(acbb_s_geometry(), one, DisplacementDatum::Touching).unwrap();
    let massive = solved.with_outer_control(&STEEL_BALLS).unwrap();
    let domain = TableDomain {
        approach: [-30e-6, 40e-6],
        scale: 40e-6,
        angle: [0.1, 0.8],
        speed: [0.8 * SPEED, 1.36_f64.sqrt() * SPEED],
        speed_scale: 0.0,
        speed_ratios: [1.0, 0.0],
        intervals: [64, 12, 4],
    };
    let grid = domain.grid(solved.table_constants().distance).unwrap();
    let mut nodes = vec![[0.0; 2]; grid.len()];
    assert_eq!(fill_table(&massive, &domain, &grid, &mut nodes), 0);
    let nodes = nodes.iter().map(|node| node.map(T::from_f64)).collect();
    Tabulated::new(places, solved.table_constants().rounded(), Table::new(grid.rounded(), nodes), false)
}

/// All of them.
pub fn all<T: Scalar, M: Math<T> + 'static>() -> Vec<Named<T>> {
    let mut all = direct::<T, M>();
    all.extend(balanced::<T, M>());
    all
}
