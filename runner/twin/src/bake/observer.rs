//! The scene's observer as constants, with its rotor where that is rigid and on fixed bearings.

use crate::error::{BakeError, Error, Result};
use crate::observer::{Gains, Uncertainty, gate, memory, weight};
use crate::plant::{Plant, only_observable, only_rotor};
use crate::scene::{Clock, Scene, build};
use nalgebra::DMatrix;
use std::fmt::Write;

/// Writes the module `observer`, where the scene has an `[observer]`.
///
/// # Errors
/// A scene that does not determine the gains.
pub fn module(out: &mut String, scene: &Scene) -> Result<()> {
    let Some(process_noise) = scene.observer.process_noise else { return Ok(()) };
    let undetermined = |found, expected| Error::from(BakeError::Observer { file: scene.path.clone(), found, expected });
    let Some(recording) = &scene.recording else { return Err(undetermined("no [recording]", "probes and a rate")) };
    if recording.probes.is_empty() {
        return Err(undetermined("no probes", "probes with their noise"));
    }
    let Clock::Rate(rate) = recording.clock else {
        return Err(undetermined("a column of times", "rate = \"12.8 kHz\""));
    };
    let rate = rate / f64::from(recording.average);
    let noise: Option<Vec<f64>> = recording.probes.iter().map(|p| p.noise).collect();
    let Some(noise) = noise else {
        return Err(undetermined("a probe without noise", "noise = \"0.03 um\" for each probe"));
    };
    only_rotor(scene, "bake")?;
    only_observable(scene, "bake")?;
    let plant = Plant::try_new(scene)?;
    let Some(rotor) = plant.rotor() else { return Err(undetermined("no [rotor]", "a rotor")) };
    let linear = plant.linearised(&vec![true; plant.bearings.len()])?;
    let rows: Vec<Vec<f64>> = recording.probes.iter().map(|probe| plant.layout.probe_row(probe)).collect();
    let of = Uncertainty::new(&noise, process_noise, weight(&plant)?);
    let gains = Gains::try_new(&linear, &rows, scene.shaft.speed, 1.0 / rate, &of)?;
    let p = rows.len();
    let n = plant.layout.order;
    if plant.layout.is_rigid() {
        writeln!(
            out,
            "\n/// The observer behind the scene's probes, and the rotor that it moves.\npub mod observer {{"
        )?;
        writeln!(out, "    use ballrace::rotor::{{RotorParams, Unbalance}};\n    use ballrace::twin::SpeedGain;\n")?;
    } else {
        writeln!(out, "\n/// The observer of the module `rotor` by the scene's probes.\npub mod observer {{")?;
        writeln!(out, "    use ballrace::twin::SpeedGain;\n")?;
    }
    writeln!(out, "    /// From sample to sample, s.\n    pub const PERIOD: f32 = {:?};", (1.0 / rate) as f32)?;
    let substeps = plant.substeps(1.0 / rate)?;
    writeln!(out, "    /// Steps of the integrator in it.\n    pub const SUBSTEPS: u32 = {substeps};")?;
    let memory = memory(1.0 / rate) as f32;
    writeln!(
        out,
        "    /// Decay factor of the unknown load over one period.\n    pub const MEMORY: f32 = {memory:?};"
    )?;
    let gate = gate(p) as f32;
    writeln!(out, "    /// Largest normalised innovation squared that still corrects the state.")?;
    writeln!(out, "    pub const GATE: f32 = {gate:?};")?;
    let [first, density] = gains.speeds.map(|x| x as f32);
    writeln!(out, "    /// Speed of the first gain, rad/s, gains per rad/s.")?;
    writeln!(out, "    pub const SPEEDS: [f32; 2] = [{first:?}, {density:?}];")?;
    let names: Vec<&str> = recording.probes.iter().map(|p| p.column.as_str()).collect();
    writeln!(out, "    /// Reading of each probe per unit of each coordinate: {}.", names.join(", "))?;
    writeln!(out, "    pub const PROBES: [[f32; {n}]; {p}] = {};", table(&rows))?;
    writeln!(out, "    /// By speed.\n    pub static GAINS: [SpeedGain<f32, {n}, {p}>; {}] = [", gains.all.len())?;
    for gain in &gains.all {
        writeln!(out, "        SpeedGain {{")?;
        let parts = [
            ("position", &gain.position),
            ("rate", &gain.rate),
            ("load", &gain.load),
            ("rotating_load", &gain.rotating_load),
        ];
        for (name, entries) in parts {
            writeln!(out, "            {name}: {},", table(&columns(entries)))?;
        }
        let white = columns(&gain.whitening.transpose());
        writeln!(out, "            whitening: {},\n        }},", table(&white))?;
    }
    writeln!(out, "    ];")?;
    if plant.layout.is_rigid() {
        let unbalances = build::unbalances(rotor);
        writeln!(out, "    /// The rotor.\n    pub const ROTOR: RotorParams = {:?};", build::rotor_params(rotor))?;
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
