//! Endless demonstration: the built-in machine with a spall on an outer race, simulated in real time.

use anyhow::{Context, Result};
use ballrace_twin::motion::instruments::Instruments;
use ballrace_twin::motion::{self, Span};
use ballrace_twin::plant::Plant;
use ballrace_twin::scene::read::read_str;
use ballrace_twin::scene::{Clock, Scene};
use std::fmt::Write as _;
use std::io::{BufWriter, PipeReader, PipeWriter, Write};
use std::path::Path;

/// Scene of the demonstration: a healthy machine.
pub const SCENE: &str = include_str!("../../demo/healthy.toml");
/// Key of a bearing in this scene, and the same with a spall.
const SOUND: &str = "diametral_clearance = \"10 um\"\n";
const SPALLED: &str = "diametral_clearance = \"10 um\"\n\
    defect = [{ surface = \"outer\", azimuth = \"-90 deg\", half_width = \"0.05 rad\", depth = \"3 um\", shape = \"half-sine\" }]\n";
/// Transient before the first sample, s.
const TRANSIENT: f64 = 0.5;

/// Starts the simulation on a thread of its own; returns its readings as CSV lines. It ends when the reader is dropped.
///
/// # Errors
/// Returns an error if no pipe or thread can be created.
pub fn start() -> Result<PipeReader> {
    let (reader, writer) = std::io::pipe().context("the demonstration cannot be started")?;
    let scene = read_str(&SCENE.replacen(SOUND, SPALLED, 1), Path::new("demonstration"))?;
    std::thread::Builder::new().name("simulation".to_owned()).spawn(move || {
        // The pipe is closed when the monitor ends.
        let _ = simulate(&scene, writer);
    })?;
    Ok(reader)
}

fn simulate(scene: &Scene, writer: PipeWriter) -> Result<()> {
    let plant = Plant::try_new(scene)?;
    let mut instruments = Instruments::try_new(scene, &plant, None, 1)?;
    let Some(Clock::Rate(rate)) = scene.recording.as_ref().map(|recording| &recording.clock) else { return Ok(()) };
    let settle = (TRANSIENT * rate) as u64;
    let span = Span { rate: *rate, settle, samples: u64::MAX - settle };
    let mut writer = BufWriter::new(writer);
    let names: Vec<&str> = instruments.columns().iter().map(|column| column.name.as_str()).collect();
    writeln!(writer, "{}", names.join(","))?;
    let (mut readings, mut line) = (vec![], String::new());
    let run = motion::run(
        scene,
        &plant,
        span,
        |_| {},
        |sample| {
            instruments.read(sample, &mut readings);
            line.clear();
            for (i, reading) in readings.iter().enumerate() {
                write!(line, "{}{reading:.4}", if i > 0 { "," } else { "" })?;
            }
            Ok::<_, anyhow::Error>(writeln!(writer, "{line}")?)
        },
    );
    run.map(drop)
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test fails by panicking")]
mod tests {
    use super::*;
    use std::io::{BufRead, BufReader};

    #[test]
    fn the_demonstration_has_a_spall_and_no_end() {
        assert_ne!(SCENE.replacen(SOUND, SPALLED, 1), SCENE);
        let mut lines = BufReader::new(start().unwrap()).lines();
        let columns = lines.next().unwrap().unwrap();
        assert_eq!(columns, "DE_X_um,DE_Y_um,NDE_X_um,NDE_Y_um,axial_um,keyphasor");
        // Longer than the recording that is built in.
        for line in lines.take(30_000) {
            let line = line.unwrap();
            assert!(line.split(',').all(|reading| reading.parse::<f64>().is_ok_and(f64::is_finite)), "{line}");
        }
    }
}
