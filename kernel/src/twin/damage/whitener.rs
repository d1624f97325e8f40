//! Pre-whitening of a signal by linear prediction.

use crate::choice::Choice;
use crate::scalar::Scalar;

/// Number of samples that predict the next one: one resonance takes two.
const PREDICTORS: usize = 16;
/// White noise that is added before the prediction, share of the power. What lies 40 dB below the signal is noise of its
/// converter and is not raised.
const FLOOR: f64 = 1e-4;

/// Removes what the past of a signal predicts: resonances and slow motion weigh as much as any other frequency, and what
/// remains is the timing of impacts over the full band.
///
/// The predictor is that of the last block, by the autocorrelation and the recursion of Levinson and Durbin. It acts on the
/// difference of two samples, which has no mean.
///
/// Source: Sawalhi, Randall and Endo 2007, The enhancement of fault detection and diagnosis in rolling element bearings
/// using minimum entropy deconvolution combined with spectral kurtosis, Mechanical Systems and Signal Processing 21;
/// Makhoul 1975, Linear prediction: a tutorial review, Proceedings of the IEEE 63.
#[derive(Debug, Clone, Copy)]
pub(super) struct Whitener<T> {
    last: T,
    /// Number of samples in this block, at most one more than a prediction needs.
    heard: u32,
    /// Differences, the latest first.
    past: [T; PREDICTORS],
    weights: [T; PREDICTORS],
    power: T,
    correlations: [T; PREDICTORS],
}

impl<T: Scalar> Whitener<T> {
    /// Creates the state, with a predictor of 0.
    pub const fn new() -> Self {
        let zeros = [T::ZERO; PREDICTORS];
        Self { last: T::ZERO, heard: 0, past: zeros, weights: zeros, power: T::ZERO, correlations: zeros }
    }

    /// Adds a sample; returns the error of its prediction, and true where that knows all the past that it needs: samples may
    /// be missing before a block.
    #[inline]
    pub fn add(&mut self, x: T) -> (T, bool) {
        let difference = x - Choice::new(self.heard > 0).select(self.last, x);
        let is_settled = self.heard > PREDICTORS as u32;
        self.heard += u32::from(!is_settled);
        self.last = x;
        self.power += difference * difference;
        let (mut error, mut later) = (difference, difference);
        for ((past, weight), correlation) in self.past.iter_mut().zip(&self.weights).zip(&mut self.correlations) {
            let one = *past;
            error += *weight * one;
            *correlation += difference * one;
            *past = later;
            later = one;
        }
        (error, is_settled)
    }

    /// Ends the block: takes the predictor from it, 0 without a signal. A sample that is no number keeps the last one.
    pub fn close(&mut self) {
        let mut weights = [T::ZERO; PREDICTORS];
        let mut error = self.power * T::from_f64(1.0 + FLOOR);
        for (known, next) in self.correlations.iter().enumerate() {
            let before = weights;
            let earlier = || self.correlations.iter().take(known).rev();
            let unexplained = before.iter().zip(earlier()).fold(*next, |sum, (weight, r)| sum + *weight * *r);
            let acts = Choice::new(error > T::ZERO);
            let reflection = acts.select(-unexplained / acts.select(error, T::ONE), T::ZERO);
            for (weight, mirrored) in weights.iter_mut().zip(before.iter().take(known).rev()) {
                *weight += reflection * *mirrored;
            }
            if let Some(weight) = weights.get_mut(known) {
                *weight = reflection;
            }
            error *= T::ONE - reflection * reflection;
        }
        let is_valid = Choice::new(error.is_finite());
        for (held, weight) in self.weights.iter_mut().zip(weights) {
            *held = is_valid.select(weight, *held);
        }
        (self.heard, self.power) = (0, T::ZERO);
        self.past = [T::ZERO; PREDICTORS];
        self.correlations = [T::ZERO; PREDICTORS];
    }
}
