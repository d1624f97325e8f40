//! Orders of a bearing under pure rolling (`docs/src/models.md#orders`; Harris).

/// Orders of one bearing: multiples of the rotational frequency of the inner ring, with the outer ring fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orders {
    /// Cage: `(1 - gamma)/2`.
    pub cage: f64,
    /// Ball-pass order of the outer race: `N cage`.
    pub outer_race: f64,
    /// Ball-pass order of the inner race: `N (1 - cage)`.
    pub inner_race: f64,
    /// Ball spin order: `(1 - gamma^2)/(2 gamma')` with `gamma' = D/d_m`; a defect on a ball has twice this order.
    pub ball_spin: f64,
}

/// Computes the orders from `gamma = D cos(alpha)/d_m` and `gamma_prime = D/d_m`.
///
/// ```
/// use ballrace::bearing::kinematics::orders;
///
/// // 6205 with 9 balls of 7.94 mm on 39.04 mm: the Bearing Data Center of Case Western Reserve University prints 3.5848
/// // and 5.4152.
/// let gamma = 7.94 / 39.04;
/// let orders = orders(9, gamma, gamma);
/// assert!((orders.outer_race - 3.5848).abs() < 5e-5);
/// assert!((orders.inner_race - 5.4152).abs() < 5e-5);
/// ```
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
