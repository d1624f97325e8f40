//! Damage of the inner race: an impact at every passed element, strong while the damage is in the load zone.

use super::{FaultKind, Pattern, Suspect};

/// Returns the pattern: the damage passes the load zone once in a revolution of the shaft.
pub(super) fn pattern(suspect: &Suspect) -> Pattern {
    Pattern {
        kind: FaultKind::InnerRace,
        name: "Inner race",
        order: suspect.orders.inner_race,
        slip: [-0.015, 0.015],
        side_bands: vec![1.0, 2.0],
    }
}
