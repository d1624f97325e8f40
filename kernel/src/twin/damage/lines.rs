//! Lines of a spectrum of orders, and the evidence of a family of them.

use super::spectrum::{BINS, BINS_PER_ORDER, Block, Power};
use crate::choice::Choice;
use crate::math::{Math, ln};
use crate::scalar::{LatticeIndex, Scalar};

/// Weights of the harmonics of a carrier: an impact has many, the first are the most certain.
const HARMONICS: [f64; 5] = [1.5, 1.0, 0.8, 0.6, 0.5];
/// Number of harmonics whose side bands count, and the weight of one side band against its harmonic.
const WITH_SIDE_BANDS: usize = 3;
const SIDE_BAND: f64 = 0.3;
/// What an absent harmonic and an absent side band cost.
const ABSENT: f64 = 0.5;
const ABSENT_SIDE_BAND: f64 = 0.15;
/// Logarithm of the ratio by which a side band may exceed its carrier: a full modulation has side bands as strong as the
/// carrier.
const ABOVE_CARRIER: f64 = 0.7;
/// Distance from a multiple of the shaft speed within which a line may be the shaft's, bins.
const SHAFT_BINS: f64 = 1.6;
/// Half the width of a line under the Hann window, bins.
const LOBE_BINS: f64 = 2.0;
/// Least power of a line over the mean of the noise, and the logarithm of the greatest ratio beyond it that counts.
const LEAST_RATIO: f64 = 3.0;
const GREATEST: f64 = 9.0;
/// Error of the order of a line: bins, and a share by the jitter of a slipping cage.
const ERROR_BINS: f64 = 0.4;
const ERROR_SHARE: f64 = 3e-4;
/// Bins on either side of a line that are its surroundings.
const SURROUNDINGS: usize = 48;
/// Power of the modulation below that of rounding errors.
const ROUNDING: f64 = 1e-12;
/// Least order of a ball pass.
const LOWEST_PASS: f64 = 1.5;
/// Orders of the families that are tried, bins of each range whose strongest line may be a harmonic of a carrier (two
/// orders), which harmonic, and the side bands.
const FAMILY_ORDERS: [f64; 2] = [0.85, 9.0];
const FAMILY_RANGE: usize = 128;
const FAMILY_HARMONICS: [f64; 3] = [1.0, 1.0 / 2.0, 1.0 / 3.0];
const FAMILY_SIDE_BANDS: [f64; 2] = [1.0, 2.0];

/// Lines of a spectrum.
pub(super) struct Lines<'a, T> {
    power: &'a Power<T>,
    /// Logarithm of the ratio to the noise beyond the least one, and order of the line, bins; 0 where there is no line.
    figures: &'a [[T; 2]; BINS],
    /// Strength that an order anywhere has by chance.
    chance: T,
}

/// The integer nearest to a number from 0 to `BINS`.
#[inline]
fn nearest<T: Scalar>(x: T) -> LatticeIndex<T> {
    (x + T::HALF).clamped_floor(LatticeIndex::new(BINS as u32))
}

/// Returns the index of a bin; of the last one, which is no line, beyond the ends.
#[inline]
fn inside(i: u32) -> usize {
    (i as usize).min(BINS - 1)
}

/// Returns true near a multiple of the shaft speed.
#[inline]
fn is_of_shaft<T: Scalar>(order: T, bins: f64) -> bool {
    (order - nearest(order).number).abs() < T::from_f64(bins / BINS_PER_ORDER)
}

impl<'a, T: Scalar> Lines<'a, T> {
    /// Finds the lines of the mean of `blocks` spectra. A bin is one where it exceeds two neighbours on either side: the flank
    /// of a strong line is no line.
    pub fn new<M: Math<T>>(power: &'a Power<T>, blocks: u32, Block(figures): &'a mut Block<T>) -> Self {
        for (figures, power) in figures.iter_mut().zip(power) {
            *figures = [ln(*power + T::from_f64(ROUNDING)), T::ZERO];
        }
        // Mean logarithm of the surroundings.
        let (mut sum, mut count) = (T::ZERO, 0);
        for i in 0..BINS + SURROUNDINGS {
            if let Some([entering, _]) = figures.get(i) {
                sum += *entering;
                count += 1;
            }
            if let Some([leaving, _]) = i.checked_sub(2 * SURROUNDINGS + 1).and_then(|i| figures.get(i)) {
                sum -= *leaving;
                count -= 1;
            }
            if let Some([_, mean]) = i.checked_sub(SURROUNDINGS).and_then(|i| figures.get_mut(i)) {
                *mean = sum / T::from_u32(count);
            }
        }
        let mut all = T::ZERO;
        // By so much the mean logarithm of the power of noise is below the logarithm of its mean: ln n - psi(n).
        let part = T::ONE / T::from_u32(blocks.max(1));
        let bias = part * (T::HALF + part * T::from_f64(1.0 / 12.0));
        let above_noise = bias + T::from_f64(libm::log(LEAST_RATIO));
        for (i, figures) in (0_u32..).zip(figures.iter_mut()) {
            let at = |offset: u32| power[inside((i + offset).wrapping_sub(2))];
            let [a, b, c, d, e] = [at(0), at(1), at(2), at(3), at(4)];
            let strength = figures[0] - figures[1] - above_noise;
            let is_inside = (i >= 2) & ((i as usize) < BINS - 2);
            let is_line = Choice::new(is_inside & (strength > T::ZERO) & (c > a) & (c > b) & (c >= d) & (c > e));
            // A line between two bins under the Hann window.
            let is_above = Choice::new(d > b);
            let quotient = M::sqrt(is_above.select(d, b) / is_line.select(c, T::ONE));
            let shift = (quotient + quotient - T::ONE) / (quotient + T::ONE);
            let strength = is_line.select(strength.smaller(T::from_f64(GREATEST)), T::ZERO);
            let place = T::from_u32(i) + is_above.select(shift, -shift);
            *figures = [strength, is_line.select(place, T::ZERO)];
            all += strength;
        }
        // A line covers the range of its error.
        let width = ERROR_BINS * libm::sqrt(core::f64::consts::TAU);
        Self { power, figures, chance: all * T::from_f64(width / BINS as f64) }
    }

    /// Returns the strength at an order of which lines have the inverse squared error `precision`, bins; 0 above the highest.
    #[inline]
    fn at(&self, order: T, precision: T) -> T {
        let bin = order * T::from_f64(BINS_PER_ORDER);
        let near = nearest(bin).count;
        // One of three neighbours is a line at most.
        let [a, b, c] = [near.wrapping_sub(1), near, near + 1].map(|i| self.figures[inside(i)]);
        let [strength, place] = [a[0] + b[0] + c[0], a[1] + b[1] + c[1]];
        let off = bin - place;
        // The normal distribution, within 2 %, and 0 beyond 2.8 errors.
        let twice_share = (T::ONE - T::from_f64(0.125) * off * off * precision).twice_positive_part();
        let squared = twice_share * twice_share;
        strength * T::from_f64(1.0 / 16.0) * squared * squared
    }

    /// Returns the evidence for harmonics of the order `carrier` with side bands at distances of `side_bands`: a sum of
    /// logarithms of line over noise, less what lines anywhere find by chance. Lines at multiples of the shaft speed and
    /// above the highest order are neither for nor against.
    pub fn evidence(&self, carrier: T, side_bands: &[T]) -> T {
        let highest = T::from_f64((BINS - 1) as f64 / BINS_PER_ORDER);
        let mut sum = T::ZERO;
        let mut harmonic = T::ZERO;
        for (k, weight) in HARMONICS.into_iter().enumerate() {
            harmonic += carrier;
            let by_jitter = harmonic * T::from_f64(ERROR_SHARE * BINS_PER_ORDER);
            let precision = T::ONE / (by_jitter * by_jitter + T::from_f64(ERROR_BINS * ERROR_BINS));
            let counts = |order: T| Choice::new(!is_of_shaft(order, SHAFT_BINS) & (order < highest));
            // Also at a multiple of the shaft speed the carrier limits its side bands.
            let strength = self.at(harmonic, precision);
            let evidence = T::from_f64(weight) * (strength - self.chance - T::from_f64(ABSENT));
            sum += counts(harmonic).select(evidence, T::ZERO);
            if k >= WITH_SIDE_BANDS {
                continue;
            }
            let most = strength + T::from_f64(ABOVE_CARRIER);
            for distance in side_bands.iter().flat_map(|distance| [-*distance, *distance]) {
                let order = (harmonic + distance).abs();
                let found = self.at(order, precision);
                // What exceeds the carrier is no side band of it and speaks against it.
                let counted = most - (found - most).abs();
                let evidence =
                    T::from_f64(SIDE_BAND * weight) * (counted - self.chance - T::from_f64(ABSENT_SIDE_BAND));
                sum += counts(order).select(evidence, T::ZERO);
            }
        }
        sum
    }

    /// Returns the power of the lines at the harmonics of a carrier: of all together and of the strongest.
    pub fn harmonics(&self, carrier: T) -> [T; 2] {
        let (mut sum, mut strongest, mut harmonic) = (T::ZERO, T::ZERO, T::ZERO);
        for _ in HARMONICS {
            harmonic += carrier;
            let near = nearest(harmonic * T::from_f64(BINS_PER_ORDER)).count;
            let of = |i: u32| self.line_power(near.wrapping_add(i).wrapping_sub(2), true);
            let greatest = (0..5).map(of).fold(T::ZERO, T::larger);
            sum += greatest;
            strongest = strongest.larger(greatest);
        }
        [sum, strongest]
    }

    /// Returns the power of a bin that is a line and `counts`, else 0.
    fn line_power(&self, i: u32, counts: bool) -> T {
        let i = inside(i);
        Choice::new((self.figures[i][0] > T::ZERO) & counts).select(self.power[i], T::ZERO)
    }

    /// Returns the power of the strongest line at an order of ball passes that is no multiple of the shaft speed.
    pub fn strongest_pass(&self) -> T {
        let first = (LOWEST_PASS * BINS_PER_ORDER) as u32;
        let power = |i: u32| {
            let order = T::from_u32(i) * T::from_f64(1.0 / BINS_PER_ORDER);
            self.line_power(i, !is_of_shaft(order, LOBE_BINS))
        };
        (first..BINS as u32).map(power).fold(T::ZERO, T::larger)
    }

    /// Returns the evidence of the strongest family of lines, whatever its order, at least 0.
    pub fn strongest_family(&self) -> T {
        let [least, greatest] = FAMILY_ORDERS.map(T::from_f64);
        let mut best = T::ZERO;
        for range in self.figures.chunks_exact(FAMILY_RANGE) {
            let (mut strongest, mut place) = (T::ZERO, T::ZERO);
            for [strength, at] in range {
                let is_free = !is_of_shaft(*at * T::from_f64(1.0 / BINS_PER_ORDER), SHAFT_BINS);
                let is_stronger = Choice::new(is_free & (*strength > strongest));
                strongest = is_stronger.select(*strength, strongest);
                place = is_stronger.select(*at, place);
            }
            for harmonic in FAMILY_HARMONICS {
                let order = place * T::from_f64(harmonic / BINS_PER_ORDER);
                let evidence = self.evidence(order, &FAMILY_SIDE_BANDS.map(T::from_f64));
                let counts = Choice::new((order > least) & (order < greatest));
                best = best.larger(counts.select(evidence, T::ZERO));
            }
        }
        best
    }
}
