//! The detector of the kernel on the same recordings, as on a microcontroller: `f32`, sample by sample, first sensor.

use crate::labels::Recording;
use crate::methods::{signals, transformed};
use ballrace::bearing::kinematics::orders;
use ballrace::twin::{DamageDetector, DamageVerdict, DamagedComponent};
use ballrace::{Exact, Phase};
use rustfft::FftPlanner;
use std::error::Error;
use std::path::Path;

/// Greatest rate of the microcontroller, Hz. Faster recordings are decimated.
const FASTEST: f64 = 12_800.0;

/// Returns the verdict after the last whole block, at the speed of the name plate.
pub fn verdict(data: &Path, recording: &Recording) -> Result<DamageVerdict<f32>, Box<dyn Error>> {
    let sensors = signals(data, recording)?;
    let factor = (recording.rate_hz / FASTEST).ceil();
    let signal = decimated(sensors.first().ok_or("no sensor")?, factor);
    let ratio = recording.diameter_mm / recording.pitch_mm;
    let along = ratio * recording.angle_deg.to_radians().cos();
    let orders = orders(recording.elements, along, ratio);
    let mut detector = DamageDetector::<f32>::new();
    let per_sample = recording.rpm / 60.0 * factor / recording.rate_hz;
    let mut verdict = DamageVerdict::default();
    for (i, x) in signal.iter().enumerate() {
        if detector.add(*x as f32, Phase::from_revolutions(per_sample * i as f64)) {
            verdict = detector.close::<Exact>(&orders);
        }
    }
    Ok(verdict)
}

/// Returns the kind of the diagnosis that the desktop makes of a component.
pub fn kind(component: DamagedComponent) -> &'static str {
    match component {
        DamagedComponent::OuterRace => "outer-race",
        DamagedComponent::InnerRace => "inner-race",
        DamagedComponent::Element => "element",
        DamagedComponent::Cage => "cage",
    }
}

/// Returns every `factor`th sample of a signal without its frequencies above half the new rate.
fn decimated(signal: &[f64], factor: f64) -> Vec<f64> {
    let mut planner = FftPlanner::new();
    let count = (signal.len() as f64 / factor) as usize;
    let mut bins = transformed(signal, &mut planner);
    bins.truncate(count / 2);
    bins.resize(count, Default::default());
    planner.plan_fft_inverse(count).process(&mut bins);
    bins.iter().map(|x| 2.0 * x.re / signal.len() as f64).collect()
}
