//! Displacements and speeds of a bearing's checksum.

use super::accuracy::BakedModel;
use crate::trade::poses::{Extent, about_offset, radius, speeds, three_digits};
use ballrace::bearing::LastValidWrench;
use ballrace::bearing::checksum::{CHECKSUM_SAMPLES, ChecksumRange};
use ballrace::{Displacement, Status};
use ballrace_models::handle::ForceModel;
use ballrace_scene::{Bearing, Scene};
use std::cmp::Reverse;

/// Factors of the amplitude that are tried, the preferred one first.
const FACTORS: [f64; 6] = [1.0, 1.5, 2.0, 3.0, 5.0, 0.5];
/// Share of the samples that have contact, and share that have none, in a good range.
const WANTED: u32 = CHECKSUM_SAMPLES as u32 / 32;
/// Largest number of samples outside the table in a good range.
const MAX_OUTSIDE: u32 = CHECKSUM_SAMPLES as u32 / 8;

/// Number of samples of a checksum with a property.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Coverage {
    /// Samples without contact.
    pub contact_lost: u32,
    /// Samples with an element outside the table.
    pub out_of_table: u32,
}

/// Returns the range of a bearing's checksum and its coverage.
///
/// The range surrounds the total displacements `totals` of the poses. It is large enough that contact is made and lost, if the model
/// can lose it.
#[must_use]
pub fn range(
    (scene, of): (&Scene, &Bearing),
    baked: &BakedModel,
    totals: Option<&[Displacement<f64>]>,
) -> (ChecksumRange, Coverage) {
    let without_poses = about_offset(of, &baked.offset);
    let preferred = totals.map_or(without_poses, |totals| hull(of, totals));
    let with = |((centre, amplitude), factor): (Extent, f64)| ChecksumRange {
        centre: Displacement::from_array(centre.map(three_digits)),
        amplitude: Displacement::from_array(amplitude.map(|x| three_digits(factor * x))),
        inner_speed: speeds(scene.shaft.speed.range()),
        outer_speed: [three_digits(scene.shaft.outer_speed), 0.0],
    };
    let extents = FACTORS.map(|factor| (preferred, factor)).into_iter();
    let candidates = extents.chain(FACTORS.map(|factor| (without_poses, factor)));
    let covered = |extent| {
        let range = with(extent);
        (range, coverage(baked, &range))
    };
    // Springs never lose contact.
    if !baked.model.has_elements() {
        return covered((preferred, 1.0));
    }
    let candidates: Vec<_> = candidates.map(covered).collect();
    let good = candidates.iter().find(|(_, coverage)| coverage.is_in_table() && coverage.least() >= WANTED);
    // Elements under preload never lose contact. `max_by_key` returns the last of equal candidates, hence `rev` below.
    let quality = |(_, coverage): &&(ChecksumRange, Coverage)| {
        (coverage.is_in_table(), coverage.least(), Reverse(coverage.out_of_table))
    };
    let best = good.or_else(|| candidates.iter().rev().max_by_key(quality));
    best.copied().unwrap_or_else(|| covered((preferred, 1.0)))
}

impl Coverage {
    /// Returns the number of samples with contact or without, whichever is less.
    fn least(&self) -> u32 {
        self.contact_lost.min(u32::from(CHECKSUM_SAMPLES) - self.contact_lost)
    }

    /// Returns true if few samples are outside the table.
    fn is_in_table(&self) -> bool {
        self.out_of_table <= MAX_OUTSIDE
    }
}

/// Returns centre and half the extent of the poses and of the displacement 0, with a margin.
fn hull(of: &Bearing, totals: &[Displacement<f64>]) -> Extent {
    let (mut low, mut high) = ([0.0_f64; 5], [0.0_f64; 5]);
    for u in totals.iter().filter(|u| u.is_finite()) {
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(u.to_array()) {
            *low = low.min(x);
            *high = high.max(x);
        }
    }
    let pairs = || low.iter().zip(&high);
    let centre: Vec<f64> = pairs().map(|(low, high)| 0.5 * (low + high)).collect();
    let mut amplitude: Vec<f64> = pairs().map(|(low, high)| 0.55 * (high - low)).collect();
    let along = amplitude.iter().take(3).copied().fold(0.0, f64::max).max(1e-9);
    let tilt = along / radius(of);
    for (x, least) in amplitude.iter_mut().zip([along, along, along, tilt, tilt]) {
        *x = x.max(0.1 * least);
    }
    let array = |v: &[f64]| std::array::from_fn(|i| v.get(i).copied().unwrap_or_default());
    (array(&centre), array(&amplitude))
}

/// Counts the samples of a range without contact and outside the table.
fn coverage(baked: &BakedModel, range: &ChecksumRange) -> Coverage {
    let mut coverage = Coverage::default();
    let mut last_valid = LastValidWrench::new();
    for (u, at) in range.samples() {
        let (_, status) = baked.force.sample(&mut last_valid, &u, &at);
        coverage.contact_lost += u32::from(status.contains(Status::CONTACT_LOST));
        coverage.out_of_table += u32::from(status.contains(Status::OUT_OF_TABLE));
    }
    coverage
}
