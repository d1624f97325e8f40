//! Direction of the unexplained force of one pass of an element over the damage, from the measured motion alone.
//!
//! In the frame in which the damaged component is at rest, the force of local damage repeats with each pass of an element and
//! points at the damage: the element loses load there and pushes the shaft away less. The mean over all passes keeps the
//! harmonics of the passing and averages all else.

use super::motion::C;
use std::f64::consts::TAU;

/// Sectors of a rose.
pub const SECTORS: usize = 72;
/// Instants of the mean pass.
pub const STEPS: usize = 1440;
/// Distances from a harmonic at which the noise is estimated, in periods of the passing.
const BESIDE: [f64; 6] = [-0.42, -0.31, -0.21, 0.19, 0.29, 0.44];
/// Mean of the squares of noise over their median (exponential distribution).
const MEAN_OVER_MEDIAN: f64 = 1.0 / std::f64::consts::LN_2;

/// Returns the mean force of one pass: the harmonics 1 to `harmonics` of `passing`, forward and backward.
///
/// `force` is `F_X + i F_Y` in the frame of the component, `passing` the angle of the passing (rad, one turn a pass), `weight` the
/// sum of the window that `force` contains. Each harmonic is weighted by its signal-to-noise ratio (Wiener filter); the noise is
/// the median power beside it.
pub fn mean_pass(force: &[C], passing: &[f64], weight: f64, harmonics: usize) -> Vec<C> {
    let steps: Vec<C> = passing.iter().map(|angle| C::from_polar(1.0, -angle)).collect();
    // Amplitude at `k + offset` periods, for k from -harmonics to harmonics.
    let amplitudes = |offset: f64| -> Vec<C> {
        let start = |angle: &f64| C::from_polar(1.0, (harmonics as f64 - offset) * angle);
        let mut turned: Vec<C> = force.iter().zip(passing).map(|(f, angle)| f * start(angle)).collect();
        let mut all = Vec::with_capacity(2 * harmonics + 1);
        for _ in 0..=2 * harmonics {
            all.push(turned.iter().sum::<C>() / weight);
            turned.iter_mut().zip(&steps).for_each(|(f, step)| *f *= step);
        }
        all
    };
    let on = amplitudes(0.0);
    let beside = BESIDE.map(amplitudes);
    let filtered: Vec<C> = (0..on.len())
        .map(|i| {
            let mut powers = beside.each_ref().map(|one| one[i].norm_sqr());
            powers.sort_by(f64::total_cmp);
            let noise = 0.5 * (powers[2] + powers[3]) * MEAN_OVER_MEDIAN;
            on[i] * (1.0 - noise / on[i].norm_sqr().max(f64::MIN_POSITIVE)).max(0.0)
        })
        .collect();
    let at = |step: usize| {
        let angle = TAU * step as f64 / STEPS as f64;
        let part = |(i, a): (usize, &C)| a * C::from_polar(1.0, (i as f64 - harmonics as f64) * angle);
        filtered.iter().enumerate().filter(|(i, _)| *i != harmonics).map(part).sum()
    };
    from_median((0..STEPS).map(at).collect())
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
    use crate::diagnosis::residual::Normal;

    const SAMPLES: usize = 80 * 128;
    const HARMONICS: usize = 12;

    /// Mean pass of nine elements, with a cage at 0.4 of the shaft speed: in each pass a pulse of 1 N as long as the damage, besides
    /// it 10 N at 1X and noise (N rms) along X and Y, all under a Hann window.
    fn made_up(azimuth: f64, half_width: f64, noise: f64) -> Vec<C> {
        let mut normal = Normal::new();
        let mut window = 0.0;
        let (force, passing): (Vec<C>, Vec<f64>) = (0..SAMPLES)
            .map(|t| {
                let turns = t as f64 / 128.0;
                let passing = 9.0 * TAU * 0.4 * turns + 1.0;
                // Angle of the nearest element from the damage.
                let distance = ((passing / TAU - 0.5).rem_euclid(1.0) - 0.5) * TAU / 9.0;
                let pulse = if distance.abs() < half_width { (0.25 * TAU * distance / half_width).cos() } else { 0.0 };
                let force = C::from_polar(pulse, azimuth + distance) + C::from_polar(10.0, TAU * turns);
                let hann = 1.0 - (TAU * t as f64 / SAMPLES as f64).cos();
                window += hann;
                ((force + C::new(normal.next(), normal.next()) * noise) * hann, passing)
            })
            .unzip();
        mean_pass(&force, &passing, window, HARMONICS)
    }

    fn peak(pass: &[C]) -> f64 {
        pass.iter().map(|f| f.norm()).fold(0.0, f64::max)
    }

    /// Standard deviation of the mean pass by noise of 1 N, without the Wiener filter.
    fn noise_of_pass() -> f64 {
        // Sum of the squares of a Hann window over the square of its sum: 1.5 / n.
        (2.0 * HARMONICS as f64 * 2.0 * 1.5 / SAMPLES as f64).sqrt()
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
