//! Failure modes of a bearing in the classes of ISO 15243:2017.

use crate::fault::{FaultForm, FaultKind};
use serde::{Deserialize, Serialize};

/// Class of failure of ISO 15243:2017 by its clause. The submodes, such as subsurface (5.1.2) and surface initiated fatigue (5.1.3), differ in
/// appearance alone: no measurement of motion or vibration distinguishes them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum FailureMode {
    /// Spalling.
    #[serde(rename = "5.1 rolling contact fatigue")]
    RollingContactFatigue,
    /// Abrasive and adhesive wear.
    #[serde(rename = "5.2 wear")]
    Wear,
    /// Corrosion by moisture; fretting corrosion and false brinelling.
    #[serde(rename = "5.3 corrosion")]
    Corrosion,
    /// Craters of an excessive current, fluting by a leakage current.
    #[serde(rename = "5.4 electrical erosion")]
    ElectricalErosion,
    /// Overload, indentations.
    #[serde(rename = "5.5 plastic deformation")]
    PlasticDeformation,
    /// Forced fracture, fatigue fracture, thermal cracking.
    #[serde(rename = "5.6 cracking and fracture")]
    Fracture,
}

/// A local damage: that of a spall first; corrosion, craters and indentations leave lines of the same frequencies.
const LOCAL: &[FailureMode] = &[
    FailureMode::RollingContactFatigue,
    FailureMode::Corrosion,
    FailureMode::ElectricalErosion,
    FailureMode::PlasticDeformation,
];
/// A wave around a race that has grown in service: fluting, or false brinelling at the distance of the elements.
const WAVE: &[FailureMode] = &[FailureMode::ElectricalErosion, FailureMode::Corrosion];
/// A damaged cage: worn pockets, or a fracture.
const CAGE: &[FailureMode] = &[FailureMode::Wear, FailureMode::Fracture];

impl FailureMode {
    /// Returns the classes that leave a fault of this kind and form, that of a spall or of fluting first; empty for a fault that is no failure of a bearing, and for
    /// waves of the elements, which are their form when new.
    #[must_use]
    pub const fn of(kind: FaultKind, form: Option<FaultForm>) -> &'static [Self] {
        match (kind, form) {
            (FaultKind::OuterRace | FaultKind::InnerRace, Some(FaultForm::Waviness)) => WAVE,
            (FaultKind::OuterRace | FaultKind::InnerRace, _) | (FaultKind::Element, Some(FaultForm::Spall) | None) => {
                LOCAL
            }
            (FaultKind::Cage, _) => CAGE,
            _ => &[],
        }
    }

    /// Returns clause and name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::RollingContactFatigue => "5.1 rolling contact fatigue",
            Self::Wear => "5.2 wear",
            Self::Corrosion => "5.3 corrosion",
            Self::ElectricalErosion => "5.4 electrical erosion",
            Self::PlasticDeformation => "5.5 plastic deformation",
            Self::Fracture => "5.6 cracking and fracture",
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;

    #[test]
    fn the_name_is_that_of_the_files() {
        let all = [LOCAL, WAVE, CAGE].concat();
        assert!(all.len() == 8 && all.iter().all(|mode| serde_json::to_value(mode).unwrap() == mode.name()));
    }

    #[test]
    fn a_fault_that_is_no_failure_of_a_bearing_has_no_mode() {
        use FaultKind::{Clearance, Coupling, Element, InnerRace, Load, Looseness, Other, RunOut, Support, Unbalance};
        for kind in [Unbalance, Clearance, Load, Looseness, Support, Coupling, RunOut, Other] {
            assert_eq!(FailureMode::of(kind, None), []);
        }
        assert_eq!(FailureMode::of(Element, Some(FaultForm::Waviness)), []);
        assert_eq!(FailureMode::of(InnerRace, None)[0], FailureMode::RollingContactFatigue);
        assert_eq!(FailureMode::of(InnerRace, Some(FaultForm::Waviness))[0], FailureMode::ElectricalErosion);
    }
}
