//! Test whether the scene determines the motion of its twin.
//!
//! Where elements lose contact, the motion may depend on its start for ever: it may be chaotic, or have a period of several turns and begin
//! in any of them. Such a twin has the phase of its own start, not that of the machine, and its residual has no meaning. Two twins of the scene
//! that start a turn apart show it: they end in the same motion, or they do not.

use super::statistics::Running;
use ballrace_plant::error::ObserverError;
use ballrace_plant::probes::reading;
use ballrace_plant::{Plant, RunIn, Twin};
use ballrace_recording::Sample;
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicBool, Ordering};

/// Least difference of two twins, over the rms motion of one about its mean. A run-in leaves 1e-5 of a transient.
const LEAST_SHARE: f64 = 0.01;
/// Largest number of samples over which two twins are compared.
const MAX_COMPARED: u64 = 1 << 16;

/// Difference of two twins where the scene does not determine their motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Probe at which they differ most over its noise.
    pub probe: usize,
    /// Their rms difference there, m.
    pub difference: f64,
    /// Time that they ran, s.
    pub time: f64,
}

/// Runs two twins in up to a sample, one from a turn earlier; returns the later one and their largest difference over the last turn, over the
/// noise of a probe; none where no difference is larger than the noise and than [`LEAST_SHARE`].
///
/// `rows` are the readings of the probes per unit of each coordinate, `noise` is that of the probes (m), `period` that of the samples (s).
///
/// # Errors
/// A machine that cannot be started; `cancelled` was set.
pub(crate) fn run_in_twice(
    plant: &Plant,
    rows: &[Vec<f64>],
    noise: &[f64],
    period: f64,
    sample: &Sample,
    cancelled: &AtomicBool,
) -> ballrace_plant::error::Result<(Box<dyn Twin>, Option<Spread>)> {
    let (revolutions, drive) = (sample.total_revolutions(), sample.shaft_motion());
    let mut later = RunIn::try_new(plant, period, revolutions, &drive)?;
    let turn = ((TAU / drive.speed.abs() / period).ceil() as u64).min(later.left());
    let mut earlier = RunIn::longer(plant, period, revolutions, &drive, turn)?;
    let compared = turn.min(MAX_COMPARED);
    let time = earlier.left() as f64 * period;
    let (mut differences, mut motions) = (vec![Running::default(); rows.len()], vec![Running::default(); rows.len()]);
    loop {
        if cancelled.load(Ordering::Relaxed) {
            return Err(ObserverError::Cancelled.into());
        }
        if earlier.left() > later.left() {
            earlier.advance();
            continue;
        }
        if later.left() < compared {
            for (p, row) in rows.iter().enumerate() {
                let [one, other] = [&later, &earlier].map(|twin| reading(row, twin.coordinates()));
                differences[p].add(one - other);
                motions[p].add(one);
            }
        }
        if !(later.advance() && earlier.advance()) {
            break;
        }
    }
    let spreads =
        differences.iter().zip(&motions).zip(noise).enumerate().filter_map(|(probe, ((between, motion), noise))| {
            let motion = (motion.rms().powi(2) - motion.mean().powi(2)).max(0.0).sqrt();
            let difference = between.rms();
            let differs = difference > noise.max(LEAST_SHARE * motion);
            differs.then_some((Spread { probe, difference, time }, difference / noise))
        });
    let largest = spreads.max_by(|(_, a), (_, b)| a.total_cmp(b));
    Ok((later.into_twin(), largest.map(|(spread, _)| spread)))
}
