//! Steady flow of heat from the rings of a bearing.

use ballrace_scene::Cooling;
use nalgebra::{Matrix2, Vector2};
use serde::Serialize;

/// Temperatures of one bearing and the heat that flows through its parts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BearingTemperatures {
    /// Inner ring and shaft, K.
    pub inner: f64,
    /// Outer ring, K.
    pub outer: f64,
    /// Housing, K.
    pub housing: f64,
    /// Heat through the shaft, W.
    pub through_shaft: f64,
    /// Heat through the housing, W.
    pub through_housing: f64,
    /// Heat with the oil, W.
    pub with_oil: f64,
}

impl BearingTemperatures {
    /// Solves the network of the rings; half of the heat arises at each. With the conductance `G_o = 1/(1/G_seat + 1/G_h)` from the outer ring to
    /// the surroundings:
    ///
    /// `G_s (T_i - T_a) + G_b (T_i - T_o) + W/2 (T_i - T_in) = H/2`, `G_o (T_o - T_a) + G_b (T_o - T_i) + W/2 (T_o - T_in) = H/2`
    ///
    /// `None` where no heat leaves.
    pub(crate) fn steady(cooling: &Cooling, heat: f64) -> Option<Self> {
        let Cooling { ambient, shaft, housing, seat, elements, oil } = *cooling;
        let (carried, inlet) = oil.map_or((0.0, ambient), |oil| (oil.conductance(), oil.inlet));
        let outside = seat.map_or(housing, |seat| seat * housing / (seat + housing));
        let each = 0.5 * carried;
        let network = Matrix2::new(shaft + elements + each, -elements, -elements, outside + elements + each);
        let source = |conductance: f64| conductance * ambient + each * inlet + 0.5 * heat;
        let found = network.lu().solve(&Vector2::new(source(shaft), source(outside)))?;
        let (inner, outer) = (found[0], found[1]);
        let through_housing = outside * (outer - ambient);
        let kept = Self {
            inner,
            outer,
            housing: outer - seat.map_or(0.0, |seat| through_housing / seat),
            through_shaft: shaft * (inner - ambient),
            through_housing,
            with_oil: carried * (0.5 * (inner + outer) - inlet),
        };
        (inner.is_finite() && outer.is_finite()).then_some(kept)
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use ballrace_scene::OilFlow;

    /// What the friction heats leaves by shaft, housing and oil; a seat without resistance is the limit of a conducting one.
    #[test]
    fn heat_is_conserved() {
        let oil = Some(OilFlow { flow: 1e-5, inlet: 313.15 });
        let with = |seat, oil| Cooling { ambient: 293.15, shaft: 1.5, housing: 3.0, seat, elements: 0.7, oil };
        for cooling in [with(None, None), with(Some(20.0), None), with(None, oil), with(Some(5.0), oil)] {
            let found = BearingTemperatures::steady(&cooling, 120.0).unwrap();
            let gone = found.through_shaft + found.through_housing + found.with_oil;
            assert!((gone - 120.0).abs() < 1e-9, "{cooling:?}: {gone}");
            assert!(found.housing <= found.outer + 1e-9);
        }
        let [free, conducting] =
            [None, Some(1e9)].map(|seat| BearingTemperatures::steady(&with(seat, None), 50.0).unwrap());
        assert!((free.outer - conducting.outer).abs() < 1e-6 && (free.inner - conducting.inner).abs() < 1e-6);
        // By hand: without elements each ring carries its half alone.
        let alone = Cooling { elements: 0.0, ..with(None, None) };
        let found = BearingTemperatures::steady(&alone, 60.0).unwrap();
        assert!((found.inner - (293.15 + 20.0)).abs() < 1e-9 && (found.outer - (293.15 + 10.0)).abs() < 1e-9);
    }
}
