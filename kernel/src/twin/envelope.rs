//! Envelope of a frequency band.

use crate::math::Math;
use crate::phase::Phase;
use crate::scalar::Scalar;

/// Envelope of a frequency band by demodulation: shift of the band to 0 Hz, `x e^{-i w t}`, and a Butterworth low-pass of
/// order 4 on both parts.
///
/// An [`OrderTracker`](super::OrderTracker) computes the lines of the envelope. The filters are stable recursive filters
/// without drift. Cost per sample: a sine and cosine, four second-order sections, one square root.
#[derive(Debug, Clone, Copy)]
pub struct Envelope<T> {
    stride: Phase,
    angle: Phase,
    sections: [Section<T>; 2],
    state: [[[T; 2]; 2]; 2],
}

/// `H(z) = b (1 + z^-1)^2 / (1 + a1 z^-1 + a2 z^-2)`.
#[derive(Debug, Clone, Copy)]
struct Section<T> {
    b: T,
    a1: T,
    a2: T,
}

impl<T: Scalar> Envelope<T> {
    /// Creates the envelope of the band `centre` plus and minus `half_width` at the sampling rate `rate`, all in Hz; the
    /// band must be below half the rate. For set-up.
    #[must_use]
    pub fn new(centre: f64, half_width: f64, rate: f64) -> Self {
        // Bilinear transformation with frequency prewarping.
        let corner = libm::tan(core::f64::consts::PI * half_width / rate);
        let section = |damping: f64| {
            let a0 = 1.0 + damping * corner + corner * corner;
            Section {
                b: T::from_f64(corner * corner / a0),
                a1: T::from_f64(2.0 * (corner * corner - 1.0) / a0),
                a2: T::from_f64((1.0 - damping * corner + corner * corner) / a0),
            }
        };
        // 2 cos of the pole angles pi/8 and 3 pi/8.
        let sections = [section(1.847_759_065_022_573_5), section(0.765_366_864_730_179_6)];
        let stride = Phase::from_revolutions(centre / rate);
        Self { stride, angle: Phase::ZERO, sections, state: [[[T::ZERO; 2]; 2]; 2] }
    }

    /// Adds a sample and returns the envelope: for a sine in the band, its amplitude.
    pub fn add<M: Math<T>>(&mut self, x: T) -> T {
        let (sin, cos) = M::sin_cos(self.angle);
        self.angle = self.angle.wrapping_add(self.stride);
        let mut square = T::ZERO;
        for (part, state) in [x * cos, x * sin].into_iter().zip(&mut self.state) {
            let mut y = part;
            for (section, [z1, z2]) in self.sections.iter().zip(state) {
                let v = section.b * y;
                let out = v + *z1;
                *z1 = v + v - section.a1 * out + *z2;
                *z2 = v - section.a2 * out;
                y = out;
            }
            square += y * y;
        }
        T::from_f64(2.0) * M::sqrt(square)
    }
}
