//! Readings that the probes and the keyphasor of a scene would record of a simulated motion, with noise and quantisation.

use super::ResponseSample;
use crate::Plant;
use ballrace_recording::write::WrittenColumn;
use ballrace_scene::{Clock, KeyphasorSignal, PulseDetection, Recording, RotationSource, Scene, Slope, units};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Largest part of a revolution that a pulse of a keyphasor takes.
const PULSE: f64 = 0.05;
/// Levels of a keyphasor in volts about its threshold, where the scene gives one.
const SWING: f64 = 4.0;

/// Error returned for a scene whose recording cannot be simulated.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum InstrumentError {
    /// The scene has no recording.
    #[error("{}: missing table [recording], expected the probes to simulate", .file.display())]
    NoRecording {
        /// File of the scene.
        file: PathBuf,
    },
    /// The files of the scene state rate or shaft angle in a form that simulated files do not have.
    #[error("{}: rate or keyphasor from the header of a file, expected rate = \"... Hz\" or time, and a keyphasor or speed column", .file.display())]
    FromHeader {
        /// File of the scene.
        file: PathBuf,
    },
    /// The keyphasor of the scene is a vector of instants.
    #[error("{}: recording.keyphasor.kind: \"instants\", expected \"pulses\" or \"count\", which have a value for each sample", .file.display())]
    Instants {
        /// File of the scene.
        file: PathBuf,
    },
    /// The scene has a vibration sensor, but a scene has no model of the housing.
    #[error("{}: vibration sensor {sensor}, expected displacement probes only: a scene has no model of the housing", .file.display())]
    Sensor {
        /// File of the scene.
        file: PathBuf,
        /// Column of the sensor.
        sensor: String,
    },
}

/// Instruments of a scene, with the state of their noise.
pub struct Instruments {
    columns: Vec<WrittenColumn>,
    /// Seconds for one unit of the column of time, where there is one.
    seconds: Option<f64>,
    probes: Vec<Instrument>,
    rotation: RotationSource,
    noise: fastrand::Rng,
    /// Revolutions at the last sample.
    turned: Option<f64>,
}

/// One probe.
struct Instrument {
    /// Reading in m per unit of each coordinate.
    row: Vec<f64>,
    metres_per_unit: f64,
    /// Offset of the reading, m.
    offset: f64,
    /// Standard deviation of the noise, m.
    noise: f64,
    /// Step of the converter, m; 0 for none.
    resolution: f64,
}

impl Instruments {
    /// Creates the instruments of a scene. `resolution` is the step to which displacements are rounded, m; `seed` selects the noise.
    ///
    /// # Errors
    /// Returns an error if the scene has no recording, has vibration sensors, or reads the rate or the keyphasor from a file header.
    pub fn try_new(scene: &Scene, plant: &Plant, resolution: Option<f64>, seed: u64) -> Result<Self, InstrumentError> {
        let Some(recording) = &scene.recording else {
            return Err(InstrumentError::NoRecording { file: scene.path.clone() });
        };
        let is_stated = matches!(recording.clock, Clock::Stated | Clock::Number { .. });
        if is_stated || recording.rotation == RotationSource::Synchronous {
            return Err(InstrumentError::FromHeader { file: scene.path.clone() });
        }
        if matches!(recording.rotation, RotationSource::Keyphasor { signal: KeyphasorSignal::Instants { .. }, .. }) {
            return Err(InstrumentError::Instants { file: scene.path.clone() });
        }
        if let Some(sensor) = recording.sensors.first() {
            let sensor = sensor.column.clone();
            return Err(InstrumentError::Sensor { file: scene.path.clone(), sensor });
        }
        let probes = recording.probes.iter().map(|probe| Instrument {
            row: plant.layout.probe_row(probe),
            metres_per_unit: probe.metres_per_unit,
            offset: probe.offset,
            noise: probe.noise.unwrap_or(0.0),
            resolution: resolution.unwrap_or(0.0),
        });
        Ok(Self {
            columns: columns(recording),
            seconds: match recording.clock {
                Clock::Column { seconds, .. } => Some(seconds.unwrap_or(1.0)),
                Clock::Rate(_) | Clock::Stated | Clock::Number { .. } => None,
            },
            probes: probes.collect(),
            rotation: recording.rotation.clone(),
            noise: fastrand::Rng::with_seed(seed),
            turned: None,
        })
    }

    /// Returns the names of the columns: time where the scene names it, probes, keyphasor or speed.
    #[must_use]
    pub fn columns(&self) -> &[WrittenColumn] {
        &self.columns
    }

    /// Writes the readings of a sample, in the units of the columns.
    pub fn read(&mut self, sample: &ResponseSample<'_>, into: &mut Vec<f64>) {
        into.clear();
        if let Some(seconds) = self.seconds {
            into.push(sample.time / seconds);
        }
        let coordinates = sample.twin.coordinates();
        for probe in &self.probes {
            let motion: f64 = probe.row.iter().zip(coordinates).map(|(per_unit, q)| per_unit * q).sum();
            let noisy = motion + probe.offset + probe.noise * normal(&mut self.noise);
            let reading =
                if probe.resolution > 0.0 { (noisy / probe.resolution).round() * probe.resolution } else { noisy };
            into.push(reading / probe.metres_per_unit);
        }
        // No tooth begins at the first sample: what passed before is not known.
        let before = self.turned.unwrap_or(sample.turned);
        match &self.rotation {
            RotationSource::Keyphasor { pulses_per_turn, missing, signal, .. } => {
                let wheel = Wheel { teeth: f64::from(*pulses_per_turn), present: pulses_per_turn - missing };
                into.push(match signal {
                    KeyphasorSignal::Count => wheel.count(sample.turned),
                    // No instruments are created for instants.
                    KeyphasorSignal::Instants { .. } => f64::NAN,
                    KeyphasorSignal::Pulses(detection) => level(detection, wheel.is_pulse(before, sample.turned)),
                });
            }
            RotationSource::SpeedColumn { radians_per_second, .. } => {
                into.push(sample.drive.speed / radians_per_second);
            }
            RotationSource::Synchronous | RotationSource::Scene => {}
        }
        self.turned = Some(sample.turned);
    }
}

fn columns(recording: &Recording) -> Vec<WrittenColumn> {
    let time = match &recording.clock {
        Clock::Column { name, seconds } => {
            Some(WrittenColumn { name: name.clone(), unit: units::time_name(seconds.unwrap_or(1.0)) })
        }
        Clock::Rate(_) | Clock::Stated | Clock::Number { .. } => None,
    };
    let rotation = match &recording.rotation {
        RotationSource::Keyphasor { column, .. } | RotationSource::SpeedColumn { column, .. } => {
            Some(WrittenColumn { name: column.clone(), unit: recording.rotation.unit() })
        }
        RotationSource::Synchronous | RotationSource::Scene => None,
    };
    time.into_iter()
        .chain(recording.probes.iter().map(|probe| WrittenColumn { name: probe.column.clone(), unit: probe.unit() }))
        .chain(rotation)
        .collect()
}

/// A keyphasor wheel: tooth 0 is at angle 0, and the last teeth of a turn may be absent.
struct Wheel {
    /// Teeth and gaps per revolution.
    teeth: f64,
    /// Number of teeth that are present.
    present: u32,
}

impl Wheel {
    /// Returns true where a tooth is at the keyphasor, or began since the last sample.
    fn is_pulse(&self, before: f64, turned: f64) -> bool {
        let at = turned * self.teeth;
        let begins = at.floor() > (before * self.teeth).floor();
        let width = (PULSE * self.teeth).min(0.5);
        let tooth = at.floor().rem_euclid(self.teeth);
        (begins || at - at.floor() < width) && tooth < f64::from(self.present)
    }

    /// Returns the number of teeth that have begun.
    fn count(&self, turned: f64) -> f64 {
        let whole = turned.floor();
        let of_turn = ((turned - whole) * self.teeth).floor() + 1.0;
        whole * f64::from(self.present) + of_turn.min(f64::from(self.present))
    }
}

/// Returns the level of a keyphasor in the unit of its column.
fn level(detection: &PulseDetection, is_pulse: bool) -> f64 {
    let is_high = is_pulse != (detection.slope == Some(Slope::Falling));
    match detection.threshold {
        Some(threshold) => {
            let swing = SWING.max(detection.hysteresis.unwrap_or(0.0));
            let level = threshold + if is_high { swing } else { -swing };
            level / detection.volts_per_unit.unwrap_or(1.0)
        }
        None => f64::from(u8::from(is_high)),
    }
}

/// Returns a normally distributed number with mean 0 and variance 1, by the method of Box and Muller.
fn normal(random: &mut fastrand::Rng) -> f64 {
    // Above 0, so that the logarithm is finite.
    let uniform = 1.0 - random.f64();
    (-2.0 * uniform.ln()).sqrt() * (TAU * random.f64()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_normal() {
        let mut random = fastrand::Rng::with_seed(7);
        let numbers: Vec<f64> = (0..100_000).map(|_| normal(&mut random)).collect();
        let mean = numbers.iter().sum::<f64>() / 1e5;
        let square = numbers.iter().map(|x| x * x).sum::<f64>() / 1e5;
        let beyond_two = numbers.iter().filter(|x| x.abs() > 2.0).count() as f64 / 1e5;
        assert!(mean.abs() < 0.015 && (square - 1.0).abs() < 0.02 && (beyond_two - 0.0455).abs() < 0.003);
    }

    #[test]
    fn teeth_with_a_gap() {
        let wheel = Wheel { teeth: 4.0, present: 3 };
        let step = 1.0 / 64.0;
        let begins: Vec<usize> = (1..128)
            .filter(|i| {
                let (before, now) = ((*i - 1) as f64 * step, *i as f64 * step);
                wheel.is_pulse(before, now) && !wheel.is_pulse(before - step, before)
            })
            .collect();
        assert_eq!(begins, [16, 32, 64, 80, 96]);
        // A first sample is a pulse only where it lies on a tooth.
        assert_eq!([0.0, 19.67, 20.0, 20.25].map(|turned| wheel.is_pulse(turned, turned)), [true, false, true, true]);
        assert_eq!([0.0, 0.3, 0.6, 0.9, 1.0].map(|turned| wheel.count(turned)), [1.0, 2.0, 3.0, 3.0, 4.0]);
    }
}
