//! Components of a bearing whose damage has a pattern of lines in the envelope.

use crate::bearing::kinematics::Orders;
use crate::scalar::Scalar;

/// Component of a bearing that may be damaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DamagedComponent {
    /// An impact at every passing element, of equal strength where the load stands still.
    OuterRace,
    /// An impact at every passing element, strong while the damage is in the load zone.
    InnerRace,
    /// A rolling element: two impacts in its revolution, strong while it is in the load zone.
    Element,
    /// One event in a revolution of the cage.
    Cage,
}

impl DamagedComponent {
    /// All, in the order of the hypotheses.
    pub const ALL: [Self; 4] = [Self::OuterRace, Self::InnerRace, Self::Element, Self::Cage];
}

/// Step of the search for the slip: the fifth harmonic moves by less than its error.
const SLIP_STEP: f64 = 4e-4;
/// Least deviation of an order from pure rolling, and steps to the greatest, 1.5 %: slip, and the contact angle under load. A
/// lightly loaded cage lags, by 2.5 % at most.
const SLIP_OF_CAGE: (f64, u32) = (-0.025, 100);
const SLIP: (f64, u32) = (-0.015, 75);

/// Lines that damage of a component causes: harmonics of a carrier, with side bands where the impacts swell and fade.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pattern<T> {
    /// Order of the carrier in pure rolling, per revolution of the shaft.
    pub order: T,
    slip: (f64, u32),
    side_bands: [T; 4],
    count: usize,
}

impl<T: Scalar> Pattern<T> {
    fn new<const N: usize>(order: f64, slip: (f64, u32), side_bands: [f64; N]) -> Self {
        let mut all = [T::ZERO; 4];
        all.iter_mut().zip(side_bands).for_each(|(to, order)| *to = T::from_f64(order));
        Self { order: T::from_f64(order), slip, side_bands: all, count: N }
    }

    /// Returns the patterns of the components.
    pub fn all(orders: &Orders) -> [Self; DamagedComponent::ALL.len()] {
        let cage = orders.cage;
        [
            // Unbalance turns the load with the shaft, and elements of unequal size repeat with the cage.
            Self::new(orders.outer_race, SLIP_OF_CAGE, [1.0, 2.0, cage, 2.0 * cage]),
            Self::new(orders.inner_race, SLIP, [1.0, 2.0]),
            Self::new(2.0 * orders.ball_spin, SLIP, [cage, 2.0 * cage]),
            Self::new(cage, SLIP_OF_CAGE, []),
        ]
    }

    /// Returns the distances of the side bands from each harmonic, orders.
    pub fn side_bands(&self) -> &[T] {
        self.side_bands.get(..self.count).unwrap_or_default()
    }

    /// Returns the deviations that are tried.
    pub fn slips(&self) -> impl Iterator<Item = T> + use<T> {
        let (least, steps) = self.slip;
        (0..=steps).map(move |i| T::from_f64(least) + T::from_f64(SLIP_STEP) * T::from_u32(i))
    }
}
