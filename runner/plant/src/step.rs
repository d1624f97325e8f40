//! Step of the integrator: its default, its limit of stability, its number in a sample period.

use crate::plant_error::{PlantError, Result};
use crate::static_equilibrium::largest_real;
use crate::twin::Step;
use crate::{MAX_SUBSTEPS, Plant};
use ballrace_scene::{Integration, Method};

impl Plant {
    /// Returns the largest stable integration step with the stiffness of the equilibrium, s; none where it has no limit.
    ///
    /// # Errors
    /// Mass or stiffness out of the range of numbers.
    pub(crate) fn stable_step(&self) -> Result<Option<f64>> {
        let most = match self.integration.method {
            Method::RungeKutta => 2.5865,
            Method::Verlet => 2.0,
            Method::Newmark { .. } => return Ok(None),
        };
        let highest = largest_real(&self.frequency_squares()?).sqrt();
        Ok((highest > 0.0).then(|| most / highest))
    }

    /// Returns the plant with another integrator and `part` of its default step.
    #[must_use]
    pub fn with_step(&self, method: Method, part: f64) -> Self {
        let mut plant = Self { integration: Integration { method, step: None }, ..self.clone() };
        plant.integration.step = Some(part * plant.own_step());
        plant
    }

    /// Returns the plant for a simulation, which has no noise of probes that would hide the error of the default step.
    #[must_use]
    pub fn for_simulation(&self) -> Self {
        match self.integration {
            Integration { method: method @ Method::RungeKutta, step: None } => self.with_step(method, 0.5),
            _ => self.clone(),
        }
    }

    /// Returns the default step of the integrator, s.
    #[must_use]
    fn own_step(&self) -> f64 {
        largest_phase(self.integration.method) / self.highest_frequency().max(1e-9)
    }

    /// Returns the number of integration steps in one sample period.
    ///
    /// # Errors
    /// More than 10 000: longer steps would not be stable.
    pub fn substeps(&self, sample_period: f64) -> Result<u32> {
        let step = self.integration.step.unwrap_or_else(|| self.own_step());
        let steps = (sample_period / step * (1.0 - 1e-9)).ceil().max(1.0);
        if steps > f64::from(MAX_SUBSTEPS) {
            return Err(PlantError::Substeps { found: steps, step, is_given: self.integration.step.is_some() });
        }
        Ok(steps as u32)
    }

    /// Returns the integrator and its number of steps in a sample period.
    ///
    /// # Errors
    /// As [`Plant::substeps`].
    pub fn step(&self, sample_period: f64) -> Result<(Step, u32)> {
        let substeps = self.substeps(sample_period)?;
        Ok((Step { method: self.integration.method, length: sample_period / f64::from(substeps) }, substeps))
    }

    /// Returns the time in which a transient decays to 1e-5, s: from the weakest damping of the rotor, at least 0.2 s, at most
    /// 10 s.
    #[must_use]
    pub fn settling_time(&self) -> f64 {
        let Ok(scales) = self.scales() else { return 0.2 };
        let coordinates = if self.layout.is_given() { self.layout.order } else { self.layout.rotor_order() };
        let rate =
            (0..coordinates).map(|i| 0.5 * scales.damping[(i, i)] / scales.mass[(i, i)]).fold(f64::INFINITY, f64::min);
        (1e5_f64.ln() / rate).clamp(0.2, 10.0)
    }
}

/// Returns the product `x` of step and highest natural frequency. The relative frequency error at `x` is `x^4 / 320` = 6e-4 for
/// Runge-Kutta, which also adds a damping ratio of `x^5 / 576` = 2e-4, `x^2 / 12` = 3e-3 for Newmark and `x^2 / 24` = 2e-3 for Verlet;
/// it is far smaller at the rotor's low frequencies.
const fn largest_phase(method: Method) -> f64 {
    match method {
        Method::RungeKutta => 2.0 / 3.0,
        Method::Newmark { .. } | Method::Verlet => 0.2,
    }
}
