//! One evaluation of each model: the force, and the force with its tangent.

use super::{INPUTS, RADIAL_PLAY, ROLLER_LENGTH, Subject, geometry, poses};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{Bearing, ElementPositions, evenly_spaced, evenly_spaced_pairs};
use ballrace::contact::law::{LineContactLaw, PointContactLaw};
use ballrace::contact::line::roller_stiffness;
use ballrace::{Displacement, Exact, Math, Phase, Scalar};
use std::hint::black_box;

/// The model without elements and math backend.
pub fn linear<T: Scalar>(column: &'static str) -> Result<Vec<Subject>, InvalidParameter>
where
    Exact: Math<T>,
{
    let places: ElementPositions<T, 8> = evenly_spaced(Phase::ZERO);
    let other = Angular::<T, Exact, _>::try_new(geometry()?, places, DisplacementDatum::Centred)?;
    let pressed = Displacement { u: T::from_f64(10e-6), w: T::from_f64(20e-6), ..Displacement::default() };
    let (_, stiffness) = other.reaction_and_stiffness(&pressed, &Phase::ZERO.into());
    Ok(force_and_tangent("linear", column, Linear::new(stiffness)).into())
}

/// The models with elements, for 8 and 16 of them.
pub fn moving<T: Scalar, M: Math<T>>(column: &'static str) -> Result<Vec<Subject>, InvalidParameter> {
    let mut subjects = of_elements::<T, M, 8>(column)?;
    subjects.extend(of_pairs::<T, M, 4>(column)?);
    subjects.extend(of_elements::<T, M, 16>(column)?);
    Ok(subjects)
}

/// Opposite pairs, `2 H` elements.
fn of_pairs<T: Scalar, M: Math<T>, const H: usize>(column: &'static str) -> Result<Vec<Subject>, InvalidParameter> {
    let point = PointContactLaw { stiffness: T::from_f64(geometry()?.stiffness()) };
    let balls = Radial::<T, M, _, _>::try_new(evenly_spaced_pairs::<T, H>(Phase::ZERO), point, RADIAL_PLAY)?;
    let angular =
        Angular::<T, M, _>::try_new(geometry()?, evenly_spaced_pairs::<T, H>(Phase::ZERO), DisplacementDatum::Centred)?;
    let n = 2 * H;
    let subjects = [
        force_and_tangent(&format!("lumped, point contact, pairs, N = {n}"), column, balls),
        force_and_tangent(&format!("angular, pairs, N = {n}"), column, angular),
    ];
    Ok(subjects.into_iter().flatten().collect())
}

fn of_elements<T: Scalar, M: Math<T>, const N: usize>(column: &'static str) -> Result<Vec<Subject>, InvalidParameter> {
    let places: ElementPositions<T, N> = evenly_spaced(Phase::ZERO);
    let point = PointContactLaw { stiffness: T::from_f64(geometry()?.stiffness()) };
    let line = LineContactLaw { stiffness: T::from_f64(roller_stiffness(ROLLER_LENGTH)) };
    let balls = Radial::<T, M, _, _>::try_new(places, point, RADIAL_PLAY)?;
    let rollers = Radial::<T, M, _, _>::try_new(places, line, RADIAL_PLAY)?;
    let thrust = Axial::<T, M, _, _>::try_new(places, point, 0.0, 0.5 * geometry()?.pitch_diameter)?;
    let angular = Angular::<T, M, _>::try_new(geometry()?, places, DisplacementDatum::Centred)?;
    let subjects = [
        force_and_tangent(&format!("lumped, point contact, N = {N}"), column, balls),
        force_and_tangent(&format!("lumped, line contact, N = {N}"), column, rollers),
        force_and_tangent(&format!("lumped, radial and axial, N = {N}"), column, Combined(balls, thrust)),
        force_and_tangent(&format!("angular, N = {N}"), column, angular),
    ];
    Ok(subjects.into_iter().flatten().collect())
}

fn force_and_tangent<T, B>(name: &str, column: &'static str, bearing: B) -> [Subject; 2]
where
    T: Scalar,
    B: Bearing<T> + Copy + 'static,
{
    let force = each_pose(move |u: &Displacement<T>, cage| {
        black_box(black_box(&bearing).reaction(u, &cage.into()));
    });
    let tangent = each_pose(move |u: &Displacement<T>, cage| {
        black_box(black_box(&bearing).reaction_and_stiffness(u, &cage.into()));
    });
    [
        Subject::new(format!("{name}: force"), column, INPUTS, force),
        Subject::new(format!("{name}: force and tangent"), column, INPUTS, tangent),
    ]
}

fn each_pose<T: Scalar>(evaluate: impl Fn(&Displacement<T>, Phase) + 'static) -> Box<dyn FnMut()> {
    let poses = poses::<T>();
    Box::new(move || {
        for (u, cage) in &poses {
            evaluate(black_box(u), black_box(*cage));
        }
    })
}
