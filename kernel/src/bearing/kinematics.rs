//! Speeds and orders of pure rolling, per turn of the inner ring with the outer one at rest (`docs/src/models.md#orders`; Harris).

/// The orders of one bearing: multiples of the shaft's rotational frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// Cage: `(1 - gamma)/2`.
    pub cage: f64,
    /// Outer race's ball-pass order: `N` times the cage's.
    pub outer_race: f64,
    /// Inner race's ball-pass order: `N (1 - cage)`.
    pub inner_race: f64,
    /// Ball spin: `(1 - gamma^2)/(2 gamma')` with `gamma' = D/d_m`; a ball's defect strikes twice a spin.
    pub ball_spin: f64,
}

/// Orders from geometry: `gamma = D cos(alpha)/d_m`, `gamma_prime = D/d_m`.
#[must_use]
pub fn orders(elements: usize, gamma: f64, gamma_prime: f64) -> Orders {
    let n = elements as f64;
    let cage = 0.5 * (1.0 - gamma);
    Orders {
        cage,
        outer_race: n * cage,
        inner_race: n * (1.0 - cage),
        ball_spin: (1.0 - gamma * gamma) / (2.0 * gamma_prime),
    }
}
