//! The same force with no, half and all elements loaded: the time of a call must not depend on the state.

use crate::subjects::{COLUMNS, INPUTS, RADIAL_PLAY, ROLLER_LENGTH, Subject, balls, geometry, scattered};
use ballrace::bearing::angular::{Angular, DisplacementDatum};
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::lumped::{Axial, Combined, Radial};
use ballrace::bearing::{Bearing, ElementPositions, evenly_spaced};
use ballrace::contact::law::{LineContactLaw, PointContactLaw};
use ballrace::contact::line::roller_stiffness;
use ballrace::{BearingKinematicState, Displacement, Exact, Math, Phase, Scalar};
use std::hint::black_box;

/// Share of the elements that carry load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Load {
    /// None.
    None,
    /// About half.
    Half,
    /// All.
    All,
}

/// The force of a model in one state.
pub struct LoadState {
    /// Name of the model.
    pub model: &'static str,
    pub load: Load,
    pub subject: Subject,
}

/// Names of the models.
pub const MODELS: [&str; 6] = [
    "lumped, point contact, N = 8",
    "lumped, line contact, N = 8",
    "lumped, radial and axial, N = 8",
    "angular, N = 8",
    "quasi-static, inertia, N = 16",
    "tabulated, N = 16",
];

/// All models in all states.
pub fn all() -> Result<Vec<LoadState>, InvalidParameter> {
    let [double, _, single, _] = COLUMNS;
    let mut states = of_precision::<f64>(double)?;
    states.extend(of_precision::<f32>(single)?);
    // The rings touch the balls at displacement 0.
    let places = [(Load::None, [0.0, -40e-6]), (Load::Half, [10e-6, 0.0]), (Load::All, [0.0, 40e-6])];
    for (load, place) in places {
        let state = (load, place, 1e-6);
        states.push(in_state(MODELS[4], double, state, balls::SPEED, balls::solved::<Exact>()?));
        let positions: ElementPositions<f64, 16> = evenly_spaced(Phase::ZERO);
        let table = balls::looked_up(&balls::solved()?, positions)?;
        states.push(in_state(MODELS[5], double, state, balls::SPEED, table));
    }
    Ok(states)
}

fn of_precision<T: Scalar>(column: &'static str) -> Result<Vec<LoadState>, InvalidParameter>
where
    Exact: Math<T>,
{
    let places: ElementPositions<T, 8> = evenly_spaced(Phase::ZERO);
    let point = PointContactLaw { stiffness: T::from_f64(geometry()?.stiffness()) };
    let line = LineContactLaw { stiffness: T::from_f64(roller_stiffness(ROLLER_LENGTH)) };
    // Preload replaces the axial displacement of a bearing that takes none.
    let radial = |play: f64| Radial::<T, Exact, _, _>::try_new(places, point, play);
    let rollers = |play: f64| Radial::<T, Exact, _, _>::try_new(places, line, play);
    let mut states = vec![];
    for (load, play, offset) in [(Load::None, RADIAL_PLAY, 0.0), (Load::Half, 0.0, 20e-6), (Load::All, -30e-6, 0.0)] {
        let place = [offset, 0.0];
        states.push(in_state(MODELS[0], column, (load, place, 2e-6), 0.0, radial(play)?));
        states.push(in_state(MODELS[1], column, (load, place, 2e-6), 0.0, rollers(play)?));
        let thrust = Axial::<T, Exact, _, _>::try_new(places, point, play, 0.5 * geometry()?.pitch_diameter)?;
        states.push(in_state(MODELS[2], column, (load, place, 2e-6), 0.0, Combined(radial(play)?, thrust)));
    }
    let angular = Angular::<T, Exact, _>::try_new(geometry()?, places, DisplacementDatum::Centred)?;
    for (load, place) in [(Load::None, [0.0; 2]), (Load::Half, [20e-6, 0.0]), (Load::All, [0.0, 120e-6])] {
        states.push(in_state(MODELS[3], column, (load, place, 2e-6), 0.0, angular));
    }
    Ok(states)
}

/// One bearing about the displacement `[u, w]`, within `spread`.
fn in_state<T: Scalar, B: Bearing<T> + 'static>(
    model: &'static str,
    column: &'static str,
    (load, [u, w], spread): (Load, [f64; 2], f64),
    speed: f64,
    bearing: B,
) -> LoadState {
    let pose = |i: u32| {
        let [du, dv] = [0.618, 0.414].map(|stride| spread * scattered(i, stride));
        let u =
            Displacement { u: T::from_f64(u + du), v: T::from_f64(dv), w: T::from_f64(w), ..Displacement::default() };
        let cage = Phase::from_revolutions(scattered(i, 0.577));
        (u, BearingKinematicState { cage, inner_speed: T::from_f64(speed), ..BearingKinematicState::default() })
    };
    let poses: Vec<_> = (0..INPUTS).map(pose).collect();
    let run = Box::new(move || {
        for (u, at) in &poses {
            black_box(black_box(&bearing).reaction(black_box(u), black_box(at)));
        }
    });
    LoadState { model, load, subject: Subject::new(format!("{model}: {load:?}"), column, INPUTS, run) }
}
