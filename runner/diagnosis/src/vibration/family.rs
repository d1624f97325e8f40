//! Evidence for a family of lines: harmonics of a carrier with side bands.

use super::spectrum::LineField;

/// Weights of the harmonics of a carrier: an impact has many, the first are the most certain.
const HARMONICS: [f64; 5] = [1.5, 1.0, 0.8, 0.6, 0.5];
/// Number of harmonics whose side bands count, and the weight of one side band against its harmonic.
const WITH_SIDE_BANDS: usize = 3;
const SIDE_BAND: f64 = 0.3;
/// What an absent harmonic and an absent side band cost.
const ABSENT: f64 = 0.5;
const ABSENT_SIDE_BAND: f64 = 0.15;
/// Logarithm of the ratio by which a side band may exceed its carrier: a modulation of 100 % has side bands as strong
/// as the carrier.
const ABOVE_CARRIER: f64 = 0.7;
/// Distance from a multiple of the shaft speed within which a line may be the shaft's, bins.
const SHAFT_BINS: f64 = 1.6;
/// Greatest such distance, orders: short snapshots have bins of a third of an order.
const SHAFT_ORDERS: f64 = 0.15;

/// Number of harmonics of a family.
pub(crate) const HARMONIC_COUNT: usize = HARMONICS.len();

/// Lines of the envelope of the sensors of a bearing, or of a machine.
#[derive(Debug, Clone)]
pub(crate) struct Lines {
    pub field: LineField,
    /// Resolution of the spectra, Hz.
    pub bin_hz: f64,
}

impl Lines {
    /// Returns the evidence for harmonics of `carrier_hz` with side bands at distances of `side_bands` orders, at a
    /// shaft speed of `turn_hz`: a sum of logarithms of line over noise, less what lines anywhere find by chance.
    /// Lines at multiples of the shaft speed are neither for nor against.
    pub fn evidence(&self, carrier_hz: f64, side_bands: &[f64], turn_hz: f64) -> f64 {
        let chance = self.field.mean;
        let shaft = (SHAFT_BINS * self.bin_hz / turn_hz).min(SHAFT_ORDERS);
        let line = |hz: f64| {
            let order = hz.abs() / turn_hz;
            let is_of_shaft = (order - order.round()).abs() < shaft;
            self.field.at(hz).filter(|_| !is_of_shaft)
        };
        let mut sum = 0.0;
        for (k, weight) in HARMONICS.iter().enumerate() {
            let harmonic = (k + 1) as f64 * carrier_hz;
            // Also at a multiple of the shaft speed the carrier limits its side bands.
            let carrier = self.field.at(harmonic).unwrap_or(0.0);
            sum += line(harmonic).map_or(0.0, |strength| weight * (strength - chance - ABSENT));
            if k >= WITH_SIDE_BANDS {
                continue;
            }
            for distance in side_bands.iter().flat_map(|order| [-order * turn_hz, order * turn_hz]) {
                let Some(strength) = line(harmonic + distance) else { continue };
                // What exceeds the carrier is no side band of it and speaks against it.
                let counted = 2.0 * strength.min(carrier + ABOVE_CARRIER) - strength;
                sum += SIDE_BAND * weight * (counted - chance - ABSENT_SIDE_BAND);
            }
        }
        sum
    }
}
