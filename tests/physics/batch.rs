//! The batch over samples is the evaluation of each sample, whichever of its ways it takes.

use ballrace::bearing::batch::radial_batch;
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{Bearing, ElementPosition};
use ballrace::contact::law::{LineContactLaw, LoadDeflectionLaw, PointContactLaw};
use ballrace::{Displacement, Exact, Fast, Math, Phase, Scalar};

const REACH: f64 = 30e-6;
const STIFFNESS: f64 = 8e9;

/// Samples all around and from the centre to [`REACH`], the centre itself among them.
fn samples<T: Scalar>(count: usize) -> (Vec<T>, Vec<T>) {
    let sample = |i: usize| {
        let (sin, cos) = (2.399_963 * i as f64).sin_cos();
        let r = REACH * (0.37 * i as f64).fract();
        (T::from_f64(r * cos), T::from_f64(r * sin))
    };
    (0..count).map(sample).unzip()
}

fn even<T: Scalar>(count: usize) -> Vec<ElementPosition<T>> {
    (0..count).map(|j| ElementPosition::evenly_spaced(Phase::from_revolutions(0.013), j, count)).collect()
}

/// Largest difference of the batch from single evaluations, over the load of one element at full reach.
fn difference<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>>(
    places: Vec<ElementPosition<T>>,
    law: L,
    play: f64,
    count: usize,
) -> f64 {
    let bearing = Radial::<T, M, L, _>::try_new(places, law, play).unwrap();
    let cage = Phase::from_revolutions(0.29);
    let (u, v) = samples::<T>(count);
    let (mut fx, mut fy) = (vec![T::ONE; count], vec![T::ONE; count]);
    radial_batch(&bearing, cage, (&u, &v), (&mut fx, &mut fy));
    let mut largest = 0.0_f64;
    for (i, (&u, &v)) in u.iter().zip(&v).enumerate() {
        let single = bearing.reaction(&Displacement { u, v, ..Displacement::default() }, &cage.into()).wrench;
        for (one, other) in [(fx[i], single.fx), (fy[i], single.fy)] {
            assert!(one.is_finite());
            largest = largest.max((one.to_f64() - other.to_f64()).abs());
        }
    }
    largest / law.load(T::from_f64(REACH + play.abs())).to_f64()
}

/// All plays and lengths: around a whole vector, around a whole block, none.
fn largest<T: Scalar, M: Math<T>, L: LoadDeflectionLaw<T, M>>(places: &[ElementPosition<T>], law: L) -> f64 {
    let plays = [8e-6, 0.0, -0.0, -5e-6];
    let cases = plays.into_iter().flat_map(|play| [0, 1, 3, 4, 9, 255, 256, 257, 600].map(|count| (play, count)));
    cases.map(|(play, count)| difference::<T, M, L>(places.to_vec(), law, play, count)).fold(0.0, f64::max)
}

fn largest_of_laws<T: Scalar, M: Math<T>>(places: &[ElementPosition<T>]) -> f64 {
    let stiffness = T::from_f64(STIFFNESS);
    largest::<T, M, _>(places, PointContactLaw { stiffness })
        .max(largest::<T, M, _>(places, LineContactLaw { stiffness }))
}

#[test]
fn any_number_of_elements() {
    for count in 1..=24 {
        let double = largest_of_laws::<f64, Exact>(&even(count));
        let single = largest_of_laws::<f32, Exact>(&even(count));
        let fast = largest_of_laws::<f32, Fast>(&even(count));
        println!("{count} elements: f64 {double:.1e}, f32 {single:.1e}, fast {fast:.1e}");
        assert!(double < 6e-15, "{count}: {double:e}");
        assert!(single < 3e-6, "{count}: {single:e}");
        assert!(fast < 3e-6, "{count}: {fast:e}");
    }
}

/// Places that are not in opposite pairs, or in pairs but not in the order of the ring.
#[test]
fn any_element_positions() {
    let at = |revolutions: &[f64]| {
        revolutions.iter().map(|&r| ElementPosition::from_azimuth(Phase::from_revolutions(r))).collect::<Vec<_>>()
    };
    for places in [
        at(&[0.0, 0.25, 0.5, 0.8]),
        at(&[0.0, 0.5, 0.25, 0.75]),
        at(&[0.0, 0.1, 0.5, 0.6]),
        at(&[0.3, 0.3]),
        at(&[0.1, 0.1, 0.6, 0.6, 0.1, 0.6]),
        even(8).into_iter().map(ElementPosition::mirrored).collect(),
        Vec::new(),
    ] {
        let double = largest_of_laws::<f64, Exact>(&places);
        assert!(double < 6e-15, "{places:?}: {double:e}");
    }
}

#[test]
fn stops_at_the_shortest_slice() {
    let bearing = Radial::<f64, Exact, _, _>::try_new(even(8), PointContactLaw { stiffness: STIFFNESS }, 5e-6).unwrap();
    let (u, v) = samples::<f64>(300);
    let run = |[nu, nv, nx, ny]: [usize; 4]| {
        let (mut fx, mut fy) = (vec![f64::MAX; 300], vec![f64::MAX; 300]);
        radial_batch(&bearing, Phase::ZERO, (&u[..nu], &v[..nv]), (&mut fx[..nx], &mut fy[..ny]));
        (fx, fy)
    };
    let (all_x, all_y) = run([300; 4]);
    for short in [0, 7, 256, 299] {
        for which in 0..4 {
            let mut lengths = [300; 4];
            lengths[which] = short;
            let (fx, fy) = run(lengths);
            assert_eq!((&fx[..short], &fy[..short]), (&all_x[..short], &all_y[..short]));
            assert!(fx[short..].iter().chain(&fy[short..]).all(|&f| f == f64::MAX), "{lengths:?}");
        }
    }
}

/// A bad sample affects its own result only.
#[test]
fn not_a_number_stays_where_it_is() {
    for play in [5e-6, -5e-6] {
        let bearing =
            Radial::<f64, Exact, _, _>::try_new(even(8), PointContactLaw { stiffness: STIFFNESS }, play).unwrap();
        let (mut u, v) = samples::<f64>(9);
        u[4] = f64::NAN;
        let (mut fx, mut fy) = ([0.0; 9], [0.0; 9]);
        radial_batch(&bearing, Phase::ZERO, (&u, &v), (&mut fx, &mut fy));
        for i in 0..9 {
            assert_eq!((fx[i].is_nan(), fy[i].is_nan()), (i == 4, i == 4));
        }
    }
}
