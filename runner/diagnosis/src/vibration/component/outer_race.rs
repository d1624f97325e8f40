//! Damage of the outer race: an impact at every passing element, of equal strength where the load stands still.

use super::{FaultKind, Pattern, Suspect};

/// Returns the pattern. Unbalance turns the load with the shaft, and elements of unequal size repeat with the cage:
/// both may modulate. A lightly loaded cage lags, by 2.5 % at most, and a contact angle under axial load makes it
/// faster.
pub(super) fn pattern(suspect: &Suspect) -> Pattern {
    let cage = suspect.orders.cage;
    Pattern {
        kind: FaultKind::OuterRace,
        name: "Outer race",
        order: suspect.orders.outer_race,
        slip: [-0.025, 0.015],
        side_bands: vec![1.0, 2.0, cage, 2.0 * cage],
    }
}
