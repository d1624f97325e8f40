//! The checksum of a bearing: its sequence, its hash, and what changes it.

use ballrace::bearing::Bearing;
use ballrace::bearing::checksum::{CHECKSUM_SAMPLES, ChecksumRange};
use ballrace::bearing::linear::Linear;
use ballrace::bearing::lumped::Radial;
use ballrace::bearing::{ElementPosition, LastValidWrench, evenly_spaced};
use ballrace::contact::law::PointContactLaw;
use ballrace::{Displacement, Exact, Phase, Status, Stiffness, Wrench};

const RANGE: ChecksumRange = ChecksumRange {
    centre: Displacement { u: 1e-6, v: -2e-6, w: 0.0, thu: 0.0, thv: 0.0 },
    amplitude: Displacement { u: 8e-6, v: 4e-6, w: 0.0, thu: 1e-4, thv: 2e-4 },
    inner_speed: [100.0, 0.5],
    outer_speed: [0.0, 0.0],
};

type Ball = Radial<f32, Exact, PointContactLaw<f32>, [ElementPosition<f32>; 9]>;

fn ball(stiffness: f32) -> Ball {
    Radial::from_constants(evenly_spaced(Phase::ZERO), PointContactLaw { stiffness }, 2e-6)
}

#[test]
fn the_samples_stay_in_the_range_and_reach_its_ends() {
    let samples: Vec<_> = RANGE.samples().collect();
    assert_eq!(samples.len(), usize::from(CHECKSUM_SAMPLES));
    let (centre, amplitude) = (RANGE.centre.to_array(), RANGE.amplitude.to_array());
    for (i, (&centre, &amplitude)) in centre.iter().zip(&amplitude).enumerate() {
        let entries = || samples.iter().map(|(u, _)| (u.to_array()[i] - centre) / amplitude.max(f32::MIN_POSITIVE));
        assert!(entries().all(|x| (-1.000_001..=1.000_001).contains(&x)));
        let largest = entries().fold(0.0, f32::max);
        assert!(amplitude == 0.0 || (largest > 0.99 && entries().fold(0.0, f32::min) < -0.99), "{i}: {largest}");
    }
    assert_eq!(samples[0].1.inner_speed, 100.0);
    assert_eq!(samples[1023].1.inner_speed, 100.0 + 0.5 * 1023.0);
    // Angles fill the revolution.
    let quarters = (0..4).map(|q| samples.iter().filter(|(_, at)| at.cage.0 >> 62 == q).count());
    assert!(quarters.into_iter().all(|count| (250..=262).contains(&count)));
}

/// The hash as it is defined, from the samples.
fn by_definition(bearing: &impl Bearing<f32>) -> u64 {
    let mut last_valid = LastValidWrench::new();
    let mut bytes = Vec::new();
    for (u, at) in RANGE.samples() {
        let (wrench, status) = bearing.sample(&mut last_valid, &u, &at);
        for x in wrench.to_array() {
            bytes.extend((x + 0.0).to_le_bytes());
        }
        bytes.push(status.bits());
    }
    assert_eq!(bytes.len(), 1024 * 21);
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

#[test]
fn the_checksum_is_fnv_1a_over_force_and_status() {
    let bearing = ball(8e9);
    assert_eq!(RANGE.checksum(&bearing), by_definition(&bearing));
    let lost = RANGE.samples().filter(|(u, at)| bearing.reaction(u, at).load == 0.0).count();
    assert!((64..960).contains(&lost), "{lost} samples without contact");
}

#[test]
fn the_last_digit_of_a_constant_changes_the_checksum() {
    assert_ne!(RANGE.checksum(&ball(8e9)), RANGE.checksum(&ball(f32::from_bits(8e9_f32.to_bits() + 1))));
}

/// The value is the same with every compiler and on every machine.
#[test]
fn the_checksum_of_springs_is_a_constant() {
    let springs = Linear::new(Stiffness::from_diagonal_element(1e8_f32));
    assert_eq!(format!("{:#018x}", RANGE.checksum(&springs)), SPRINGS);
}

#[test]
fn signs_of_zero_and_of_nan_do_not_count() {
    let of = |x: f32| RANGE.checksum_of(|_, _| (Wrench { fx: x, ..Wrench::default() }, Status::OK));
    assert_eq!(of(0.0), of(-0.0));
    assert_eq!(of(f32::NAN), of(-f32::NAN));
    assert_ne!(of(0.0), of(f32::NAN));
}

const SPRINGS: &str = "0xc45b663bff8d1520";
