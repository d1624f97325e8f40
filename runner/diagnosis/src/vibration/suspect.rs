//! A bearing whose damage is looked for.

use ballrace::bearing::kinematics::Orders;
use ballrace_outcome::{BearingOrders, BearingOutcome, FaultKind};

/// A bearing that may be damaged.
pub struct Suspect {
    /// Name of the bearing.
    pub name: String,
    /// Station, m.
    pub station: f64,
    /// Orders, per revolution of the shaft.
    pub orders: Orders,
    /// Number of rolling elements.
    pub elements: usize,
}

impl Suspect {
    /// Returns the order of the line of a component, per revolution of the shaft.
    pub fn order(&self, component: FaultKind) -> f64 {
        match component {
            FaultKind::OuterRace => self.orders.outer_race,
            FaultKind::InnerRace => self.orders.inner_race,
            // A defect of a ball strikes both races in one revolution of the ball.
            FaultKind::Element => 2.0 * self.orders.ball_spin,
            _ => self.orders.cage,
        }
    }

    /// Returns the outcome of the bearing: its orders.
    pub fn outcome(&self) -> BearingOutcome {
        let o = self.orders;
        BearingOutcome {
            name: self.name.clone(),
            model: format!("kinematics, {} elements", self.elements),
            station_mm: self.station * 1e3,
            orders: BearingOrders {
                cage: o.cage,
                outer_race: o.outer_race,
                inner_race: o.inner_race,
                ball_spin: Some(o.ball_spin),
            },
            ..BearingOutcome::default()
        }
    }
}
