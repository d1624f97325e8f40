//! Figures of a flexible rotor. Stations are those of its drawing.

use serde::Serialize;

/// Largest relative errors of a reduced rotor: natural frequencies, static deflection and response.
pub const ALLOWED_REDUCTION_ERRORS: [f64; 3] = [5e-3, 1e-2, 1e-2];

/// Mass and inertia of a flexible rotor, and the error of its reduced model.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RotorOutcome {
    /// Mass.
    pub mass_kg: f64,
    /// Station of the centre of mass as drawn.
    pub centre_of_mass_mm: f64,
    /// Diametral inertia about the centre of mass.
    pub diametral_inertia_kg_m2: f64,
    /// Polar inertia.
    pub polar_inertia_kg_m2: f64,
    /// Coordinates of the reduced model.
    pub coordinates: usize,
    /// Coordinates of the finite-element model.
    pub finite_element_coordinates: usize,
    /// Highest line of interest.
    pub highest_line_hz: f64,
    /// Largest error of the natural frequencies up to the highest line, by the reduction.
    pub frequency_error_percent: f64,
    /// Frequency below which all natural frequencies are within the allowed error.
    pub accurate_to_hz: f64,
    /// Error of the static displacement of bearings and probes over the largest one.
    pub deflection_error_percent: f64,
    /// The same of the 1X response at the nominal speed.
    pub response_error_percent: f64,
}

impl RotorOutcome {
    /// Returns the errors of the reduced model.
    const fn errors(&self) -> [f64; 3] {
        [self.frequency_error_percent, self.deflection_error_percent, self.response_error_percent]
    }

    /// Returns the warning about a reduced model with larger errors than allowed; `None` for one within them.
    #[must_use]
    pub fn excess_error(&self) -> Option<String> {
        let errors = self.errors();
        let [frequency, deflection, response] = ALLOWED_REDUCTION_ERRORS.map(|share| 100.0 * share);
        if errors.iter().zip([frequency, deflection, response]).all(|(error, allowed)| *error <= allowed) {
            return None;
        }
        Some(format!(
            "The reduced rotor of {} coordinates differs from its finite-element model by more than allowed: natural frequencies up to \
             {:.0} Hz {:.2} % (allowed {frequency} %, as all below {:.0} Hz), static deflection {:.2} % ({deflection} %), 1X response \
             {:.2} % ({response} %).",
            self.coordinates, self.highest_line_hz, errors[0], self.accurate_to_hz, errors[1], errors[2]
        ))
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use crate::rotor_drawing::tests::SCENE;
    use crate::{BearingOutcome, Diagnosis, Estimate, FaultKind, FaultParameters, Outcome, ProbeOutcome};
    use ballrace_scene::read::read_str;
    use std::path::Path;

    #[test]
    fn an_outcome_has_the_stations_of_the_scene() {
        let scene = read_str(SCENE, Path::new("scene.toml")).unwrap();
        let estimate = |value: f64| Estimate { value, low: value - 1.0, high: value + 1.0 };
        let unbalance = Diagnosis {
            kind: FaultKind::Unbalance,
            bearing: None,
            failure_modes: vec![],
            line_hz: 0.0,
            order: 1.0,
            level_db: 0.0,
            confidence: 1.0,
            evidence: vec![],
            vibration: None,
            parameters: FaultParameters { station_mm: Some(estimate(-10.0)), ..FaultParameters::default() },
            lines: vec![],
            sentence: String::new(),
            figures: crate::FaultFigures::default(),
        };
        let probe = |angle_deg| ProbeOutcome { station_mm: -10.0, angle_deg, ..ProbeOutcome::default() };
        let outcome = Outcome {
            probes: vec![probe(Some(45.0)), probe(None)],
            bearings: vec![BearingOutcome { station_mm: -10.0, ..BearingOutcome::default() }],
            diagnoses: vec![unbalance],
            ..Outcome::default()
        }
        .with_stations_as_drawn(&scene);
        let expected = scene.rotor.unwrap().centre_of_mass * 1e3 - 10.0;
        let found = outcome.diagnoses[0].parameters.station_mm.unwrap();
        for station in [outcome.probes[0].station_mm, outcome.bearings[0].station_mm, found.value, found.low + 1.0] {
            assert!((station - expected).abs() < 1e-9, "{station} {expected}");
        }
        assert!((outcome.probes[1].station_mm + 10.0).abs() < 1e-12, "an axial probe keeps its station");
    }
}
