//! Damage of a rolling element: it strikes both races in one revolution of the element, strong while it is in the load
//! zone.

use super::{FaultKind, Pattern, Suspect};

/// Returns the pattern: the element passes the load zone once in a revolution of the cage.
pub(super) fn pattern(suspect: &Suspect) -> Pattern {
    let cage = suspect.orders.cage;
    Pattern {
        kind: FaultKind::Element,
        name: "A rolling element",
        order: 2.0 * suspect.orders.ball_spin,
        slip: [-0.015, 0.015],
        side_bands: vec![cage, 2.0 * cage],
    }
}
