//! Direction of the unexplained force of one pass of an element over the damage, from the measured motion alone.
//!
//! In the frame in which the damaged component is stationary, the force of local damage repeats with each pass of an element and
//! points at the damage: the element loses load there and pushes the shaft away less. The mean over all passes keeps the
//! harmonics of the passing and averages all else.

use super::motion::C;
use super::surface::Component;
use ballrace::twin::{ForceLine, ForceOrderTracker};
use ballrace::{BearingKinematicState, Exact};
use std::f64::consts::TAU;

/// Sectors of a rose.
pub(crate) const SECTORS: usize = 72;
/// Instants of the mean pass.
pub const STEPS: usize = 1440;
/// Harmonics of the passing that are followed.
pub const HARMONICS: usize = 32;
/// Revolutions of a block: its lines are a third of an order apart.
const BLOCK_TURNS: u32 = 6;

/// Force along X and Y of the housing, N, with the angles of the components of its bearing.
pub struct Instant {
    /// `F_X + i F_Y`.
    pub force: C,
    /// Angles of the components; that of the cage is the azimuth of its first element.
    pub at: BearingKinematicState<f64>,
}

/// Returns the mean force of one pass in the frame of `component`: the harmonics 1 to `harmonics` (at most [`HARMONICS`]) of the passing,
/// forward and backward, by the kernel's [`ForceOrderTracker`]; `None` without two blocks of [`BLOCK_TURNS`] revolutions.
///
/// Each harmonic is the mean of its amplitudes in all blocks, weighted by its signal-to-noise ratio (Wiener filter); the noise is their
/// scatter.
pub fn mean_pass(
    instants: impl Iterator<Item = Instant>,
    elements: usize,
    component: Component,
    harmonics: usize,
) -> Option<Vec<C>> {
    let mut instants = instants.peekable();
    let first = instants.peek()?.at;
    let mut tracker = ForceOrderTracker::<f64, HARMONICS>::new(elements as u32, BLOCK_TURNS, &first);
    let mut blocks: Vec<[ForceLine<f64>; HARMONICS]> = vec![];
    for Instant { force, at } in instants {
        if tracker.add::<Exact>([force.re, force.im], &at) {
            let all = tracker.close();
            blocks.push(match component {
                Component::Outer => all.outer,
                Component::Inner => all.inner,
                Component::Ball => all.element,
            });
        }
    }
    if blocks.len() < 2 {
        return None;
    }
    let filtered = |of: &dyn Fn(&ForceLine<f64>) -> [f64; 2], k: usize| {
        let complex = |block: &[ForceLine<f64>; HARMONICS]| {
            let [re, im] = of(&block[k]);
            C::new(re, im)
        };
        let count = blocks.len() as f64;
        let mean = blocks.iter().map(complex).sum::<C>() / count;
        let scatter: f64 = blocks.iter().map(|block| (complex(block) - mean).norm_sqr()).sum();
        let noise = scatter / (count * (count - 1.0));
        mean * (1.0 - noise / mean.norm_sqr().max(f64::MIN_POSITIVE)).max(0.0)
    };
    let lines: Vec<[C; 2]> = (0..harmonics.min(HARMONICS))
        .map(|k| [filtered(&|line| line.forward, k), filtered(&|line| line.backward, k)])
        .collect();
    let at = |step: usize| {
        let angle = TAU * step as f64 / STEPS as f64;
        // Elements pass a ring that turns, and its contacts an element, against the sense of the shaft.
        let sense = if component == Component::Outer { 1.0 } else { -1.0 };
        let part = |(k, [forward, backward]): (usize, &[C; 2])| {
            let turned = C::from_polar(1.0, sense * (k + 1) as f64 * angle);
            forward * turned + backward * turned.conj()
        };
        lines.iter().enumerate().map(part).sum()
    };
    Some(from_median((0..STEPS).map(at).collect()))
}

/// Returns the pass less its median: between two passes the damage causes no force.
fn from_median(pass: Vec<C>) -> Vec<C> {
    let median = |of: fn(&C) -> f64| {
        let mut values: Vec<f64> = pass.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    let middle = C::new(median(|f| f.re), median(|f| f.im));
    pass.into_iter().map(|f| f - middle).collect()
}

/// Returns the share of the energy of `pass` in each of [`SECTORS`] directions; the first sector is centred at angle 0.
pub fn energy(pass: &[C]) -> Vec<f64> {
    let total: f64 = pass.iter().map(C::norm_sqr).sum();
    let mut sectors = vec![0.0; SECTORS];
    for force in pass {
        let sector = (force.arg() / TAU * SECTORS as f64).round().rem_euclid(SECTORS as f64) as usize;
        sectors[sector % SECTORS] += force.norm_sqr() / total.max(f64::MIN_POSITIVE);
    }
    sectors
}

/// Returns the mean direction of the energy of `pass`, 0 to 360 deg.
pub fn direction_deg(pass: &[C]) -> f64 {
    pass.iter().map(|f| f * f.norm()).sum::<C>().arg().to_degrees().rem_euclid(360.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::Normal;
    use ballrace::Phase;

    const SAMPLES: usize = 80 * 128;
    const SHOWN: usize = 12;

    /// Mean pass of nine elements, with a cage at 0.4 of the shaft speed: in each pass a pulse of 1 N as long as the damage, besides
    /// it 10 N at 1X and noise (N rms) along X and Y.
    fn made_up(azimuth: f64, half_width: f64, noise: f64) -> Vec<C> {
        let mut normal = Normal::new();
        let instants = (0..SAMPLES).map(|t| {
            let turns = t as f64 / 128.0;
            let cage = 0.4 * turns + 0.02;
            // Angle of the nearest element from the damage.
            let distance = ((9.0 * cage - 0.5).rem_euclid(1.0) - 0.5) * TAU / 9.0;
            let pulse = if distance.abs() < half_width { (0.25 * TAU * distance / half_width).cos() } else { 0.0 };
            let force = C::from_polar(pulse, azimuth + distance) + C::from_polar(10.0, TAU * turns);
            let [inner, cage] = [turns, cage].map(Phase::from_revolutions);
            let at = BearingKinematicState { inner, cage, ..BearingKinematicState::default() };
            Instant { force: force + C::new(normal.next(), normal.next()) * noise, at }
        });
        mean_pass(instants, 9, Component::Outer, SHOWN).unwrap_or_default()
    }

    fn peak(pass: &[C]) -> f64 {
        pass.iter().map(|f| f.norm()).fold(0.0, f64::max)
    }

    /// Standard deviation of the mean pass by noise of 1 N, without the Wiener filter.
    fn noise_of_pass() -> f64 {
        // Sum of the squares of a Hann window over the square of its sum: 1.5 / n.
        (2.0 * SHOWN as f64 * 2.0 * 1.5 / SAMPLES as f64).sqrt()
    }

    #[test]
    fn the_rose_points_at_the_pulse() {
        let azimuth = -70.0_f64;
        let of = |noise: f64| made_up(azimuth.to_radians(), 0.06, noise);
        let error = |pass: &[C]| (direction_deg(pass) - (azimuth + 360.0)).abs();
        let pure = of(0.0);
        assert!(error(&pure) < 0.1 && (peak(&pure) - 1.0).abs() < 0.02, "{} {}", error(&pure), peak(&pure));
        // The direction has a standard deviation of 3.4 deg for noise of 1 N (24 sets of noise).
        let pass = of(0.3);
        assert!(error(&pass) < 3.0 * 0.3 * 3.4, "{}", error(&pass));
        let energy = energy(&pass);
        assert!((energy.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Sectors of 5 deg about -70 deg.
        let near: f64 = energy[58 - 3..=58 + 3].iter().sum();
        assert!(near > 0.9, "{near}: {energy:?}");
    }

    #[test]
    fn noise_alone_has_no_force() {
        let peak = peak(&made_up(0.0, 0.0, 1.0));
        assert!(peak < 4.0 * noise_of_pass(), "{peak}");
    }
}
