//! Spectrum of a signal over the angle of the shaft.

use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Binary digits of the numbers of revolutions in a block and of values in a revolution.
pub(super) const TURN_BITS: u32 = 6;
const VALUE_BITS: u32 = 6;
/// Lines of the spectrum, from order 0 to half the values of a revolution; pairs of values in a block.
const BIN_BITS: u32 = TURN_BITS + VALUE_BITS - 1;
pub(super) const BINS: usize = 1 << BIN_BITS;
/// Lines in one order.
pub(super) const BINS_PER_ORDER: f64 = (1 << TURN_BITS) as f64;

/// Power, amplitude squared, of each line.
pub(super) type Power<T> = [T; BINS];

/// Values at equal steps of the angle, two at a time; in place of them, later, complex bins, and two figures of each line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block<T>(pub [[T; 2]; BINS]);

impl<T: Scalar> Block<T> {
    pub const fn new() -> Self {
        Self([[T::ZERO; 2]; BINS])
    }

    /// Returns the number of the value at a share of the block.
    #[inline]
    pub const fn number(share: Phase) -> usize {
        (share.0 >> (u64::BITS - 1 - BIN_BITS)) as usize
    }

    /// Sets the value of a number.
    #[inline]
    pub fn set(&mut self, number: usize, value: T) {
        if let Some(place) = self.0.get_mut(number / 2).and_then(|pair| pair.get_mut(number % 2)) {
            *place = value;
        }
    }

    /// Returns the mean of the values.
    pub fn mean(&self) -> T {
        let sum = self.0.iter().fold(T::ZERO, |sum, [even, odd]| sum + (*even + *odd));
        sum * T::from_f64(0.5 / BINS as f64)
    }

    /// Transforms the values times `scale` less 1, under a Hann window.
    pub fn transform<M: Math<T>>(&mut self, scale: T) {
        let mut share = Phase::ZERO;
        for pair in &mut self.0 {
            for value in pair {
                let window = T::HALF * (T::ONE - M::sin_cos(share).1);
                *value = window * (scale * *value - T::ONE);
                share = share.wrapping_add(Phase(1 << (u64::BITS - 1 - BIN_BITS)));
            }
        }
        // Decimation in frequency: bins come in the order of their reversed bits.
        for stage in 0..BIN_BITS {
            let half = BINS >> (stage + 1);
            let (sin, cos) = M::sin_cos(Phase(1 << (u64::BITS - BIN_BITS + stage)));
            for part in self.0.chunks_exact_mut((2 * half).max(2)) {
                let Some((low, high)) = part.split_at_mut_checked(half) else { continue };
                let mut turn = [T::ONE, T::ZERO];
                for (a, b) in low.iter_mut().zip(high) {
                    let ([ar, ai], [br, bi], [re, im]) = (*a, *b, turn);
                    *a = [ar + br, ai + bi];
                    let (dr, di) = (ar - br, ai - bi);
                    *b = [dr * re - di * im, dr * im + di * re];
                    turn = [re * cos + im * sin, im * cos - re * sin];
                }
            }
        }
    }

    /// Adds `weight` times the difference to the spectrum of the transformed block to `power`.
    pub fn average<M: Math<T>>(&self, power: &mut Power<T>, weight: T) {
        // The window has half the weight of the values.
        let scale = T::from_f64(4.0 / (BINS * BINS) as f64);
        let bin = |k: u32| {
            let reversed = k.reverse_bits() >> (u32::BITS - BIN_BITS);
            self.0.get(reversed as usize).copied().unwrap_or([T::ZERO; 2])
        };
        for (k, power) in (0..).zip(power) {
            let ([ar, ai], [br, bi]) = (bin(k), bin((BINS as u32 - k) % BINS as u32));
            // The transforms of the even and of the odd values.
            let (er, ei, or, oi) = (ar + br, ai - bi, ai + bi, br - ar);
            let (sin, cos) = M::sin_cos(Phase(u64::from(k) << (u64::BITS - 1 - BIN_BITS)));
            let (re, im) = (T::HALF * (er + or * cos + oi * sin), T::HALF * (ei + oi * cos - or * sin));
            *power += weight * (scale * (re * re + im * im) - *power);
        }
    }
}
