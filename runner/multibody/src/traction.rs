//! Traction of a lubricated contact.

/// Traction coefficient over the slip speed `s` (m/s): `mu = (A + B s) exp(-C s) + D` (Gupta 1984), with `A = -D`, so that a contact without
/// slip has no traction: a slope, a peak and a fall to the limit `D`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TractionCurve {
    /// B, s/m.
    slope: f64,
    /// C, s/m.
    decay: f64,
    /// D, traction coefficient at high slip.
    limit: f64,
}

impl TractionCurve {
    /// A contact without friction.
    pub const NONE: Self = Self { slope: 0.0, decay: 1.0, limit: 0.0 };

    /// Creates the curve with the traction coefficient `peak` at the slip speed `peak_slip` (m/s) and `limit` far beyond it, at most `peak`.
    ///
    /// The slope vanishes at the peak: `B s_p = D z/(z - 1)` with `z = C s_p`, and `mu(s_p) = D (1 + exp(-z)/(z - 1))`, which bisection solves
    /// for `z`.
    #[must_use]
    pub fn with_peak(peak: f64, peak_slip: f64, limit: f64) -> Self {
        if peak <= 0.0 {
            return Self::NONE;
        }
        let excess = peak / limit - 1.0;
        let (mut low, mut high) = (1.0_f64, 50.0_f64);
        for _ in 0..100 {
            let z = 0.5 * (low + high);
            if (-z).exp() / (z - 1.0) > excess { low = z } else { high = z }
        }
        let z = 0.5 * (low + high);
        Self { slope: limit * z / (z - 1.0) / peak_slip, decay: z / peak_slip, limit }
    }

    /// Returns the traction coefficient over the slip speed, s/m: finite without slip.
    #[must_use]
    pub fn ratio(&self, slip: f64) -> f64 {
        let Self { slope, decay, limit } = *self;
        let fallen = (-decay * slip).exp();
        // (1 - exp(-C s)) / s, by its series where the difference has no digits.
        let x = decay * slip;
        let rise = if x < 1e-4 { decay * (1.0 - 0.5 * x) } else { (1.0 - fallen) / slip };
        slope * fallen + limit * rise
    }

    /// Returns the traction coefficient at a slip speed, m/s.
    #[must_use]
    pub fn coefficient(&self, slip: f64) -> f64 {
        self.ratio(slip) * slip
    }
}
