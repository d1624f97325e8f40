//! Constants of the scene's observer, and of its rotor if that is rigid and its bearings are fixed.

use ballrace::rotor::{RotorParams, Unbalance};
use ballrace_models::build;
use ballrace_plant::error::{BakeError, Error, Result};
use ballrace_plant::observer::{Gains, Uncertainty, gate, memory, weight};
use ballrace_plant::{Plant, only_observable, only_rotor};
use ballrace_scene::{Clock, Method, Scene};
use nalgebra::DMatrix;
use std::fmt::Write;

/// Constants of the observer.
pub(crate) struct ObserverConstants {
    plant: Plant,
    /// Names of the probes.
    pub names: Vec<String>,
    /// Reading of each probe per unit of each coordinate.
    pub rows: Vec<Vec<f64>>,
    /// Sampling period, s.
    pub period: f64,
    /// Number of integration steps per sampling period.
    pub substeps: u32,
    /// Decay factor of the unknown load over one period.
    pub memory: f32,
    /// Largest normalised innovation squared that still corrects the state.
    pub gate: f32,
    /// Speed of the first gain, rad/s, and number of gains per rad/s.
    pub speeds: [f32; 2],
    gains: Gains,
}

/// Names and columns of the matrices of one gain; the last entry has the rows of the whitening matrix.
pub(crate) type GainColumns = [(&'static str, Vec<Vec<f64>>); 5];

impl ObserverConstants {
    /// Returns the constants; `None` if the scene has no `[observer]`.
    ///
    /// # Errors
    /// Returns an error if the scene does not determine the gains.
    pub fn try_new(scene: &Scene) -> Result<Option<Self>> {
        let Some(process_noise) = scene.observer.process_noise else { return Ok(None) };
        let undetermined =
            |found, expected| Error::from(BakeError::Observer { file: scene.path.clone(), found, expected });
        let Some(recording) = &scene.recording else { return Err(undetermined("no [recording]", "probes and a rate")) };
        if recording.probes.is_empty() {
            return Err(undetermined("no probes", "probes with their noise"));
        }
        let Clock::Rate(rate) = recording.clock else {
            return Err(undetermined("a rate of the recording", "rate = \"12.8 kHz\""));
        };
        let rate = rate / f64::from(recording.average);
        let noise: Option<Vec<f64>> = recording.probes.iter().map(|p| p.noise).collect();
        let Some(noise) = noise else {
            return Err(undetermined("a probe without noise", "noise = \"0.03 um\" for each probe"));
        };
        only_rotor(scene, "bake")?;
        only_observable(scene, "bake")?;
        let plant = Plant::try_new(scene)?;
        if plant.rotor().is_none() {
            return Err(undetermined("no [rotor]", "a rotor"));
        }
        let linear = plant.linearised(&vec![true; plant.bearings.len()])?;
        let rows: Vec<Vec<f64>> = recording.probes.iter().map(|probe| plant.layout.probe_row(probe)).collect();
        let of = Uncertainty::new(&noise, process_noise, weight(&plant)?);
        let period = 1.0 / rate;
        let gains = Gains::try_new(&linear, &rows, scene.shaft.speed, period, &of)?;
        Ok(Some(Self {
            names: recording.probes.iter().map(|p| p.column.clone()).collect(),
            period,
            substeps: plant.substeps(period)?,
            memory: memory(period) as f32,
            gate: gate(rows.len()) as f32,
            speeds: gains.speeds.map(|x| x as f32),
            rows,
            gains,
            plant,
        }))
    }

    /// Returns the number of Verlet steps per sampling period.
    ///
    /// # Errors
    /// Returns an error if the number of steps is too large.
    pub(crate) fn verlet_substeps(&self) -> Result<u32> {
        Ok(self.plant.with_step(Method::Verlet, 1.0).substeps(self.period)?)
    }

    /// Returns the gains by speed.
    pub fn gains(&self) -> impl ExactSizeIterator<Item = GainColumns> + '_ {
        self.gains.all.iter().map(|gain| {
            [
                ("position", columns(&gain.position)),
                ("rate", columns(&gain.rate)),
                ("load", columns(&gain.load)),
                ("rotating_load", columns(&gain.rotating_load)),
                ("whitening", columns(&gain.whitening.transpose())),
            ]
        })
    }

    /// Returns the rotor and its unbalances; `None` unless the rotor is rigid and its bearings are fixed.
    pub(crate) fn rigid_rotor(&self) -> Option<(RotorParams, Vec<Unbalance>)> {
        let rotor = self.plant.rotor().filter(|_| self.plant.layout.is_rigid())?;
        Some((build::rotor_params(rotor), build::unbalances(rotor)))
    }
}

/// Writes the module `observer` if the scene has an `[observer]`.
///
/// # Errors
/// Returns an error if the scene does not determine the gains.
pub fn module(out: &mut String, scene: &Scene) -> Result<()> {
    let Some(constants) = ObserverConstants::try_new(scene)? else { return Ok(()) };
    let rigid = constants.rigid_rotor();
    let (n, p) = (constants.plant.layout.order, constants.rows.len());
    if rigid.is_some() {
        writeln!(
            out,
            "\n/// The observer behind the scene's probes, and the rotor that it moves.\npub mod observer {{"
        )?;
        writeln!(out, "    use ballrace::rotor::{{RotorParams, Unbalance}};\n    use ballrace::twin::SpeedGain;\n")?;
    } else {
        writeln!(out, "\n/// The observer of the module `rotor` by the scene's probes.\npub mod observer {{")?;
        writeln!(out, "    use ballrace::twin::SpeedGain;\n")?;
    }
    let ObserverConstants { names, rows, period, substeps, memory, gate, speeds: [first, density], .. } = &constants;
    writeln!(out, "    /// From sample to sample, s.\n    pub const PERIOD: f32 = {:?};", *period as f32)?;
    writeln!(out, "    /// Steps of the integrator in it.\n    pub const SUBSTEPS: u32 = {substeps};")?;
    writeln!(
        out,
        "    /// Decay factor of the unknown load over one period.\n    pub const MEMORY: f32 = {memory:?};"
    )?;
    writeln!(out, "    /// Largest normalised innovation squared that still corrects the state.")?;
    writeln!(out, "    pub const GATE: f32 = {gate:?};")?;
    writeln!(out, "    /// Speed of the first gain, rad/s, gains per rad/s.")?;
    writeln!(out, "    pub const SPEEDS: [f32; 2] = [{first:?}, {density:?}];")?;
    writeln!(out, "    /// Reading of each probe per unit of each coordinate: {}.", names.join(", "))?;
    writeln!(out, "    pub const PROBES: [[f32; {n}]; {p}] = {};", table(rows))?;
    let gains = constants.gains();
    writeln!(out, "    /// By speed.\n    pub static GAINS: [SpeedGain<f32, {n}, {p}>; {}] = [", gains.len())?;
    for gain in gains {
        writeln!(out, "        SpeedGain {{")?;
        for (name, columns) in gain {
            writeln!(out, "            {name}: {},", table(&columns))?;
        }
        writeln!(out, "        }},")?;
    }
    writeln!(out, "    ];")?;
    if let Some((rotor, unbalances)) = rigid {
        writeln!(out, "    /// The rotor.\n    pub const ROTOR: RotorParams = {rotor:?};")?;
        writeln!(out, "    /// Its unbalances.")?;
        writeln!(out, "    pub const UNBALANCES: [Unbalance; {}] = {unbalances:?};", unbalances.len())?;
    }
    writeln!(out, "}}")?;
    Ok(())
}

/// Returns the columns of a matrix.
fn columns(of: &DMatrix<f64>) -> Vec<Vec<f64>> {
    of.column_iter().map(|column| column.iter().copied().collect()).collect()
}

fn table<R: AsRef<[f64]>>(rows: &[R]) -> String {
    let row = |row: &R| {
        let entries: Vec<String> = row.as_ref().iter().map(|x| format!("{:?}", *x as f32)).collect();
        format!("[{}]", entries.join(", "))
    };
    format!("[{}]", rows.iter().map(row).collect::<Vec<_>>().join(", "))
}
