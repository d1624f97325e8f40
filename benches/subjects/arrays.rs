//! Batches over samples, and as many square roots over arrays as a bearing has elements: what the machine allows.

use super::{BATCH, BATCH_PRELOADED, ROOTS, Subject, geometry, scattered};
use ballrace::bearing::batch::radial_batch;
use ballrace::bearing::geometry::InvalidParameter;
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{ElementPositions, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::{Exact, Math, Phase, Scalar};
use std::hint::black_box;

/// Enough that the start of a batch does not count, few enough for the first-level cache.
const SAMPLES: u32 = 512;
const ELEMENTS: usize = 8;
const RADIAL_PLAY: f64 = 5e-6;

/// All of them; `root` is the square root of the standard library.
pub fn batches_and_limit<T: Scalar>(
    column: &'static str,
    root: impl Fn(T) -> T + 'static,
) -> Result<[Subject; 3], InvalidParameter>
where
    Exact: Math<T>,
{
    let subject = |row: &str, run| Subject::new(row, column, SAMPLES, run);
    Ok([
        subject(BATCH, batch::<T>(RADIAL_PLAY)?),
        subject(BATCH_PRELOADED, batch::<T>(-RADIAL_PLAY)?),
        subject(ROOTS, roots(root)),
    ])
}

/// `offset` and around it, `reach` to both sides.
fn array<T: Scalar>(offset: f64, reach: f64, stride: f64) -> Vec<T> {
    (0..SAMPLES).map(|i| T::from_f64(offset + reach * scattered(i, stride))).collect()
}

fn batch<T: Scalar>(play: f64) -> Result<Box<dyn FnMut()>, InvalidParameter>
where
    Exact: Math<T>,
{
    let places: ElementPositions<T, ELEMENTS> = evenly_spaced(Phase::ZERO);
    let law = PointContactLaw { stiffness: T::from_f64(geometry()?.stiffness()) };
    let bearing = Radial::<T, Exact, _, _>::try_new(places, law, play)?;
    let (u, v) = (array(0.0, 20e-6, 0.618), array(0.0, 20e-6, 0.414));
    let (mut fx, mut fy) = (array(0.0, 0.0, 0.0), array(0.0, 0.0, 0.0));
    let mut cage = Phase::ZERO;
    Ok(Box::new(move || {
        cage = cage.wrapping_add(Phase(0x0123_4567_89ab_cdef));
        radial_batch(black_box(&bearing), cage, (black_box(&u), black_box(&v)), (&mut fx, &mut fy));
        black_box((&mut fx, &mut fy));
    }))
}

/// One pass over the array for each element, of numbers as large as deflections are.
fn roots<T: Scalar>(root: impl Fn(T) -> T + 'static) -> Box<dyn FnMut()> {
    let deflections = array::<T>(15e-6, 10e-6, 0.618);
    let mut roots = array::<T>(0.0, 0.0, 0.0);
    Box::new(move || {
        for _ in 0..ELEMENTS {
            for (y, &x) in roots.iter_mut().zip(black_box(&deflections)) {
                *y = root(x);
            }
            black_box(&mut roots);
        }
    })
}
