//! Notes for the user: estimated values, clearances and preloads in operation, pressures beyond the static limit, an unstable step.

use crate::Plant;
use crate::plant_error::Result;
use ballrace::Phase;
use ballrace::bearing::Bearing as _;
use ballrace::contact::hertz::Race;
use ballrace_models::build::{self, ElementContact};
use ballrace_outcome::ClearanceOutcome;
use ballrace_scene::{Bearing, Clock, FromCatalogue, PreloadAmount, PreloadState, Scene};

impl Plant {
    /// Adds notes on contact pressures above the static limit and on an unstable integration step.
    pub(crate) fn warn(&mut self, scene: &Scene) -> Result<()> {
        for (i, (of, mounted)) in scene.bearings.iter().zip(&self.bearings).enumerate() {
            let Ok(Some(contact)) = ElementContact::of(of) else { continue };
            let mut loads = vec![0.0; mounted.elements];
            let (u, at) = (self.displacement(i, &self.rest), self.resting(mounted, Phase::ZERO));
            mounted.bearing.element_loads(&u, &at, &mut loads);
            let pressure = contact.pressure(Race::Inner, loads.iter().copied().fold(0.0, f64::max));
            if pressure > contact.limit() {
                self.notes.push(format!(
                    "Bearing {}: the contact pressure in static equilibrium is {:.2} GPa, beyond {:.1} GPa, the static limit of ISO 76.",
                    mounted.name,
                    pressure / 1e9,
                    contact.limit() / 1e9
                ));
            }
        }
        self.notes.extend(self.rotor_outcome(scene).and_then(|rotor| rotor.excess_error()));
        self.notes.extend(self.unstable_in_replay(scene)?);
        Ok(())
    }

    /// Returns the warning about the step as a replay of the scene's recording takes it. A scene without a rate has no steps before it is
    /// simulated.
    fn unstable_in_replay(&self, scene: &Scene) -> Result<Option<String>> {
        let Some(recording) = &scene.recording else { return Ok(None) };
        let Clock::Rate(rate) = recording.clock else { return Ok(None) };
        self.unstable_step(f64::from(recording.average) / rate)
    }

    /// Returns the notes for a simulation with this sample period.
    ///
    /// # Errors
    /// If the stability of a step cannot be determined.
    pub fn simulation_notes(&self, scene: &Scene, sample_period: f64) -> Result<Vec<String>> {
        let of_replay = self.unstable_in_replay(scene)?;
        let others = self.notes.iter().filter(|note| of_replay.as_ref() != Some(note));
        Ok(others.cloned().chain(self.unstable_step(sample_period)?).collect())
    }

    /// Returns the warning about a given step that is not stable at rest, as it is taken in the sample period; `None` for a stable one.
    ///
    /// # Errors
    /// As [`Plant::substeps`] and [`Plant::stable_step`].
    pub(crate) fn unstable_step(&self, sample_period: f64) -> Result<Option<String>> {
        if self.integration.step.is_none() {
            return Ok(None);
        }
        let taken = self.step(sample_period)?.0.length;
        let limit = self.stable_step()?.filter(|limit| taken > *limit);
        Ok(limit.map(|limit| {
            format!(
                "The step of {:.3} us is beyond {:.3} us, up to which the integrator is stable at rest: the motion may overflow.",
                taken * 1e6,
                limit * 1e6
            )
        }))
    }
}

/// Returns the note on the estimated values of a bearing of the catalogue.
fn estimates(of: &Bearing) -> Option<String> {
    let FromCatalogue { listed, estimated } = of.catalogue.as_ref()?;
    (!estimated.is_empty()).then(|| {
        format!(
            "Bearing {}: {} of the catalogue, with the estimated values {}. Give those in the scene that are known.",
            of.name,
            listed.entry.designation,
            estimated.join(", ")
        )
    })
}

/// Returns the notes on the bearings of a scene: estimated values, operating clearances and preloads.
pub(crate) fn bearing_notes(scene: &Scene) -> Result<Vec<String>> {
    let estimates = scene.bearings.iter().filter_map(estimates);
    Ok(estimates.chain(mounting_notes(scene)?).collect())
}

/// Returns the notes on operating clearance and preload of bearings with fits or temperatures.
///
/// # Errors
/// A preload that a bearing does not carry.
pub fn mounting_notes(scene: &Scene) -> Result<Vec<String>> {
    let mut notes = vec![];
    for bearing in &scene.bearings {
        notes.extend(operating_clearance(bearing));
        notes.extend(operating_preload(scene, bearing)?);
    }
    Ok(notes)
}

/// Returns a note on the preload of a bearing that its fits and temperatures change.
fn operating_preload(scene: &Scene, of: &Bearing) -> Result<Option<String>> {
    let Some(preload) = of.preload.filter(|_| of.mounting.is_some() && !of.has_constant_preload_force()) else {
        return Ok(None);
    };
    let Some(force) = build::preload_force(scene, of)? else { return Ok(None) };
    let amount = match preload.amount {
        PreloadAmount::Force(force) => format!("{force:.0} N"),
        PreloadAmount::Displacement(w) => format!("{:.2} um", w * 1e6),
    };
    let set = match preload.set {
        PreloadState::Unmounted => "before mounting",
        PreloadState::Fitted => "after fitting, at the temperature of assembly",
        PreloadState::Operating => "in operation",
    };
    Ok(Some(format!(
        "Bearing {}: a preload of {amount} {set} is {force:.0} N in operation; the rings are locked axially.",
        of.name
    )))
}

/// Returns a note on the operating clearance of a bearing with fits or temperatures.
fn operating_clearance(of: &Bearing) -> Option<String> {
    let clearance = ClearanceOutcome::from(of.mounting?.operating());
    Some(format!("Bearing {}: operating clearance {clearance}.", of.name))
}
