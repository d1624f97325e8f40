//! `ballrace simulate`: the time response of the scene's rotor from its rest position.

use super::{Format, keep_apart};
use crate::fault::{SceneFault, scene_fault};
use crate::output::AtomicFile;
use crate::plant::{Plant, Twin};
use crate::recording::Row;
use crate::recording::rotation::Tracker;
use crate::scene::read::read_file;
use crate::scene::units::{Dimension, parse};
use crate::scene::{Rotation, Scene};
use anyhow::{Context, Result, bail};
use ballrace::rotor::Drive;
use indicatif::ProgressBar;
use serde::Serialize;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Most samples of one simulation.
const MOST_SAMPLES: f64 = 1e9;

/// What `simulate` takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// How long, e.g. "2 s".
    #[arg(long, value_name = "D")]
    duration: String,
    /// Samples per second, e.g. "12.8 kHz".
    #[arg(long, value_name = "R")]
    rate: String,
    /// CSV file to write: t, displacement, velocity, the force of each bearing (SI).
    #[arg(short, long, value_name = "F")]
    output: PathBuf,
}

#[derive(Serialize)]
struct Summary {
    scene: String,
    samples: u64,
    rate_hz: f64,
    steps_per_sample: u32,
    held_samples: u64,
    peak_to_peak_um: [f64; 3],
    output: String,
}

/// Runs the command.
///
/// # Errors
/// What is wrong with scene, duration, rate or output.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let scene = read_file(&args.scene)?;
    let duration = option("--duration", &args.duration, Dimension::Time)?;
    let rate = option("--rate", &args.rate, Dimension::Frequency)?;
    let samples = (duration * rate).round();
    if !(1.0..=MOST_SAMPLES).contains(&samples) {
        bail!(SceneFault(format!("--duration, --rate: found {samples} samples, allowed: 1 to {MOST_SAMPLES:e}")));
    }
    keep_apart(&[("--output", &args.output)], &[&args.scene])?;
    let plant = Plant::try_new(&scene).map_err(|e| scene_fault(&e))?;
    let summary = simulate(&scene, &plant, samples as u64, rate, &args.output)?;
    print(&summary, &plant.notes, format)
}

fn option(name: &str, text: &str, dimension: Dimension) -> Result<f64> {
    let fault = |why: String| SceneFault(format!("{name}: {why}"));
    let value = match text.parse::<f64>() {
        Ok(si) => si,
        Err(_) => parse(text, dimension).map_err(|e| fault(e.to_string()))?,
    };
    if !(value > 0.0 && value.is_finite()) {
        bail!(fault(format!("found {text:?}, allowed: {}", dimension.allowed("above 0"))));
    }
    Ok(value)
}

fn simulate(scene: &Scene, plant: &Plant, samples: u64, rate: f64, path: &Path) -> Result<Summary> {
    let period = 1.0 / rate;
    let mut file = AtomicFile::create(path)?;
    let failed = || format!("{}: this file cannot be written", path.display());
    writeln!(file, "{}", header(plant)).with_context(failed)?;
    let mut twin = plant.start(period, 0.0).map_err(|e| scene_fault(&e))?;
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(samples) } else { ProgressBar::hidden() };
    let (mut low, mut high, mut held) = ([f64::MAX; 3], [f64::MIN; 3], 0);
    // The scene's speed profile as a recording without columns would follow it.
    let mut shaft = Tracker::new(&Rotation::Scene, rate, scene.shaft.speed);
    for i in 0..samples {
        let time = i as f64 * period;
        shaft.push(Row { index: i, time, ..Row::default() })?;
        let Some(sample) = shaft.pop() else { break };
        let turned = sample.revolution as f64 + sample.angle.revolutions();
        let q = twin.pose();
        let drive = Drive { angle: sample.angle, speed: sample.speed, acceleration: sample.acceleration };
        write_row(&mut file, time, plant, twin.as_ref(), (turned, &drive)).with_context(failed)?;
        for ((low, high), x) in low.iter_mut().zip(&mut high).zip(q.to_array()) {
            (*low, *high) = (low.min(x), high.max(x));
        }
        held += u64::from(twin.step(&drive).is_held());
        if i % 4096 == 0 {
            bar.set_position(i);
        }
    }
    bar.finish_and_clear();
    file.finish()?;
    Ok(Summary {
        scene: scene.name.clone(),
        samples,
        rate_hz: rate,
        steps_per_sample: plant.substeps(period),
        held_samples: held,
        peak_to_peak_um: std::array::from_fn(|i| (high[i] - low[i]) * 1e6),
        output: path.display().to_string(),
    })
}

fn header(plant: &Plant) -> String {
    let mut head = "t".to_owned();
    for rate in ["", "_dot"] {
        for name in plant.layout.names(&plant.seats) {
            head += &format!(",{name}{rate}");
        }
    }
    for seat in &plant.seats {
        for entry in ["FX", "FY", "FZ", "MX", "MY"] {
            head += &format!(",{}_{entry}", seat.name);
        }
    }
    head
}

fn write_row(
    file: &mut AtomicFile,
    time: f64,
    plant: &Plant,
    twin: &dyn Twin,
    (turned, drive): (f64, &Drive<f64>),
) -> std::io::Result<()> {
    write!(file, "{time:.9e}")?;
    for x in twin.coordinates().iter().chain(twin.rates()) {
        write!(file, ",{x:.16e}")?;
    }
    for (i, seat) in plant.seats.iter().enumerate() {
        let at = seat.rotation(seat.kinematics.parts_at(turned), drive);
        for f in twin.wrench(i, &at).to_array() {
            write!(file, ",{f:.16e}")?;
        }
    }
    writeln!(file)
}

fn print(summary: &Summary, notes: &[String], format: Format) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let [x, y, z] = summary.peak_to_peak_um;
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(summary)?)?,
        Format::Csv => {
            writeln!(out, "samples,rate_hz,steps_per_sample,held_samples,u_um_pp,v_um_pp,w_um_pp")?;
            let Summary { samples, rate_hz, steps_per_sample, held_samples, .. } = summary;
            writeln!(out, "{samples},{rate_hz},{steps_per_sample},{held_samples},{x},{y},{z}")?;
        }
        Format::Text => {
            writeln!(
                out,
                "{}: {} samples at {} Hz, {} steps a sample",
                summary.scene, summary.samples, summary.rate_hz, summary.steps_per_sample
            )?;
            writeln!(out, "Centre of mass, um pp: X {x:.3}, Y {y:.3}, Z {z:.3}")?;
            if summary.held_samples > 0 {
                writeln!(out, "The motion overflowed and was held for {} samples.", summary.held_samples)?;
            }
            for note in notes {
                writeln!(out, "{note}")?;
            }
            writeln!(out, "Written: {}", summary.output)?;
        }
    }
    Ok(out.flush()?)
}
