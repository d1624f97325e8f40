//! `ballrace simulate`: time response of the scene's rotor from its static equilibrium.

mod multibody;

use self::multibody::Bodies;
use super::progress::ProgressLines;
use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report::{self as report, number::counted};
use ballrace_twin::effect_significance::{self, EffectSignificance};
use ballrace_twin::motion::instruments::Instruments;
use ballrace_twin::motion::{self, ResponseSample, Span};
use ballrace_twin::outcome::RotorOutcome;
use ballrace_twin::output::{AtomicFile, quoted};
use ballrace_twin::plant::Plant;
use ballrace_twin::recording::write::Writer;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::units::{Dimension, parse};
use ballrace_twin::scene::{Clock, Scene};
use indicatif::ProgressBar;
use serde::Serialize;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// Arguments of `simulate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Duration to simulate, e.g. "2 s".
    #[arg(long, value_name = "D")]
    duration: String,
    /// Sampling rate of the output, e.g. "12.8 kHz"; with --as-recording, by default that of the scene's recording.
    #[arg(long, value_name = "R")]
    rate: Option<String>,
    /// Transient at the start that is simulated but not written, e.g. "1 s".
    #[arg(long, value_name = "T")]
    settle: Option<String>,
    /// CSV file to write: time, displacements, velocities, forces of each bearing (SI).
    #[arg(short, long, value_name = "F")]
    output: PathBuf,
    /// Write the readings of the scene's probes and keyphasor with their noise, in the units of their columns, to F (.csv, .npy or
    /// .parquet); motion and forces go to a CSV file beside it, whose name ends in -truth.
    #[arg(long)]
    as_recording: bool,
    /// Step to which the readings of the probes are rounded, e.g. "5 nm".
    #[arg(long, value_name = "STEP", requires = "as_recording")]
    resolution: Option<String>,
    /// Selects the noise.
    #[arg(long, value_name = "N", default_value_t = 1, requires = "as_recording")]
    seed: u64,
    /// Motion and contacts of balls and cage of each bearing with model = "multibody", one row a sample, to F (.csv, .npy or .parquet).
    #[arg(long, value_name = "F")]
    elements: Option<PathBuf>,
    /// HTML page with slip, orbit of the cage, loads and losses of these bearings.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

#[derive(Serialize)]
struct Summary {
    scene: String,
    samples: u64,
    rate_hz: f64,
    /// None where the integrator chooses its steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    steps_per_sample: Option<u32>,
    peak_to_peak_um: [f64; 3],
    mean_um: [f64; 3],
    computing_seconds: f64,
    times_real_time: f64,
    output: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    recording: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rotor: Option<RotorOutcome>,
    #[serde(skip_serializing_if = "Option::is_none")]
    multibody: Option<multibody::Summary>,
    #[serde(rename = "effect_significance")]
    significance: Vec<EffectSignificance>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if scene, duration, rate or output is invalid.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    let duration = parse_option("--duration", &args.duration, Dimension::Time, false)?;
    let rate = rate(args, &scene)?;
    let settle = args.settle.as_ref().map(|text| parse_option("--settle", text, Dimension::Time, true)).transpose()?;
    let options = if settle.is_some() { "--duration, --settle, --rate" } else { "--duration, --rate" };
    let span = Span::try_new(duration, rate, settle.unwrap_or(0.0));
    let span = span.map_err(|invalid| UsageError(format!("{options}: {invalid}")))?;
    let truth = if args.as_recording { truth_path(&args.output) } else { args.output.clone() };
    let mut outputs = vec![("--output", args.output.as_path())];
    if args.as_recording {
        outputs.push(("the truth beside --output", &truth));
    }
    outputs.extend(args.elements.as_deref().map(|path| ("--elements", path)));
    outputs.extend(args.report.as_deref().map(|path| ("--report", path)));
    check_distinct_paths(&outputs, &[&args.scene])?;
    let plant = Plant::try_new(&scene).map_err(UsageError::new)?;
    let measured = args.as_recording.then(|| Measured::try_new(args, &scene, &plant, span)).transpose()?;
    let bodies = Bodies::try_new(&scene, &plant, span, (args.elements.as_deref(), args.report.as_deref()))?;
    let mut summary = simulate(&scene, &plant, span, &truth, (measured, bodies))?;
    if args.as_recording {
        summary.recording = Some(args.output.display().to_string());
    }
    print(&summary, &plant.simulation_notes(&scene, 1.0 / span.rate)?, format, error)
}

/// Parses the value of the option `name`: a quantity above 0, or 0 where that is allowed, with a unit, or a number in SI units where
/// that is the usual unit.
fn parse_option(name: &str, text: &str, dimension: Dimension, allows_zero: bool) -> Result<f64> {
    let invalid = |reason: String| UsageError(format!("{name}: {reason}"));
    let value = match text.parse::<f64>() {
        Ok(si) => si,
        Err(_) => parse(text, dimension).map_err(|e| invalid(e.to_string()))?,
    };
    let is_in_range = value > 0.0 || (allows_zero && value == 0.0);
    if !(is_in_range && value.is_finite()) {
        let range = if allows_zero { "of 0 or more" } else { "above 0" };
        bail!(invalid(format!("value out of range: {text:?}, expected {}", dimension.expected(range))));
    }
    if let (Ok(number), Some([first, second])) = (text.parse::<f64>(), dimension.likely_units(value)) {
        bail!(invalid(format!("no unit: {text:?}, expected \"{number} {first}\" or \"{number} {second}\"")));
    }
    Ok(value)
}

/// Returns the sampling rate, Hz. With `--as-recording` it is the rate in the scene, which a replay expects.
fn rate(args: &Args, scene: &Scene) -> Result<f64> {
    let given = args.rate.as_ref().map(|text| parse_option("--rate", text, Dimension::Frequency, false)).transpose()?;
    let of_scene = match scene.recording.as_ref().map(|recording| &recording.clock) {
        Some(Clock::Rate(rate)) if args.as_recording => Some(*rate),
        _ => None,
    };
    match (given, of_scene) {
        (Some(given), Some(rate)) if given != rate => {
            bail!(UsageError(format!("--rate: {given} Hz, expected {rate} Hz as in [recording], or no --rate")))
        }
        (Some(rate), _) | (None, Some(rate)) => Ok(rate),
        (None, None) => bail!(missing_rate()),
    }
}

fn missing_rate() -> UsageError {
    UsageError("--rate: missing, expected the sampling rate, such as \"12.8 kHz\"".to_owned())
}

/// Returns the sampling rate of the option `--rate`, else that of the scene's recording, Hz.
///
/// # Errors
/// An invalid rate, or none.
pub(super) fn sampling_rate(given: Option<&str>, scene: &Scene) -> Result<f64> {
    match (given, scene.recording.as_ref().map(|recording| &recording.clock)) {
        (Some(text), _) => parse_option("--rate", text, Dimension::Frequency, false),
        (None, Some(Clock::Rate(rate))) => Ok(*rate),
        (None, _) => bail!(missing_rate()),
    }
}

/// Returns the name of the file with motion and forces beside a recording.
fn truth_path(recording: &Path) -> PathBuf {
    let stem = recording.file_stem().unwrap_or_default().to_string_lossy();
    recording.with_file_name(format!("{stem}-truth.csv"))
}

/// A recording of simulated readings.
struct Measured {
    instruments: Instruments,
    writer: Writer,
    row: Vec<f64>,
}

impl Measured {
    fn try_new(args: &Args, scene: &Scene, plant: &Plant, span: Span) -> Result<Self> {
        let step = args.resolution.as_ref().map(|text| parse_option("--resolution", text, Dimension::Length, false));
        let instruments = Instruments::try_new(scene, plant, step.transpose()?, args.seed).map_err(UsageError::new)?;
        let writer = Writer::create(&args.output, instruments.columns(), span.samples)?;
        Ok(Self { instruments, writer, row: Vec::new() })
    }

    fn add(&mut self, sample: &ResponseSample<'_>) -> Result<()> {
        self.instruments.read(sample, &mut self.row);
        Ok(self.writer.add(&self.row)?)
    }
}

fn simulate(
    scene: &Scene,
    plant: &Plant,
    span: Span,
    path: &Path,
    (mut measured, mut bodies): (Option<Measured>, Option<Bodies>),
) -> Result<Summary> {
    let own_steps = bodies.is_none().then(|| plant.for_simulation().substeps(1.0 / span.rate));
    let steps_per_sample = own_steps.transpose()?;
    let mut file = AtomicFile::create(path)?;
    let cannot_write = || format!("{}: this file cannot be written", path.display());
    writeln!(file, "{}", header(plant)).with_context(cannot_write)?;
    let total = span.settle + span.samples;
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(total) } else { ProgressBar::hidden() };
    let (has_bodies, lines) = (bodies.is_some(), ProgressLines::new());
    let (mut low, mut high, mut sum) = ([f64::MAX; 3], [f64::MIN; 3], [0.0; 3]);
    let mut position = span.settle;
    let start = Instant::now();
    let (file, waiting_time, twin) = std::thread::scope(|scope| {
        let mut rows = RowWriter::new(scope, file);
        let run = motion::run(
            scene,
            plant,
            span,
            |_| {},
            |now| {
                for (i, x) in now.plant.pose(now.twin.coordinates()).to_array().into_iter().take(3).enumerate() {
                    (low[i], high[i], sum[i]) = (low[i].min(x), high[i].max(x), sum[i] + x);
                }
                position += 1;
                if position.is_multiple_of(if has_bodies { 1 } else { 4096 }) {
                    bar.set_position(position);
                    lines.now_and_then(|| format!("Simulated {:.3} of {:.3} s", now.time, total as f64 / span.rate));
                }
                if let Some(measured) = &mut measured {
                    measured.add(now)?;
                }
                if let Some(bodies) = &mut bodies {
                    bodies.add(now)?;
                }
                rows.add(now.row())
            },
        );
        let (file, waiting_time) = rows.finish().with_context(cannot_write)?;
        Ok::<_, anyhow::Error>((file, waiting_time, run?))
    })?;
    let seconds = (start.elapsed() - waiting_time).as_secs_f64();
    bar.finish_and_clear();
    file.finish()?;
    if let Some(measured) = measured {
        measured.writer.finish()?;
    }
    Ok(Summary {
        scene: scene.name.clone(),
        samples: span.samples,
        rate_hz: span.rate,
        steps_per_sample,
        peak_to_peak_um: std::array::from_fn(|i| (high[i] - low[i]) * 1e6),
        mean_um: sum.map(|s| s / span.samples as f64 * 1e6),
        computing_seconds: seconds,
        times_real_time: total as f64 / span.rate / seconds,
        output: path.display().to_string(),
        recording: None,
        rotor: plant.rotor_outcome(scene),
        multibody: bodies.map(|bodies| bodies.finish(&scene.name, twin.as_ref())).transpose()?,
        significance: effect_significance::at_rest(scene, plant)?,
    })
}

/// Writer of rows on a thread of its own, because formatting numbers takes longer than computing them.
struct RowWriter<'s> {
    block: RowBlock,
    /// `None` after an error of the writer thread.
    sender: Option<SyncSender<RowBlock>>,
    thread: ScopedJoinHandle<'s, std::io::Result<AtomicFile>>,
    /// Time for which the computation has waited for the writer thread.
    waiting_time: Duration,
}

/// Consecutive rows of `width` numbers each.
#[derive(Default)]
struct RowBlock {
    numbers: Vec<f64>,
    width: usize,
}

/// Numbers in a full block.
const BLOCK_NUMBERS: usize = 1 << 15;
/// Maximum number of blocks that wait for the writer thread.
const QUEUE_CAPACITY: usize = 8;

impl<'s> RowWriter<'s> {
    fn new(scope: &'s Scope<'s, '_>, mut file: AtomicFile) -> Self {
        let (sender, receiver) = sync_channel::<RowBlock>(QUEUE_CAPACITY);
        let thread = scope.spawn(move || {
            for block in receiver {
                for row in block.numbers.chunks(block.width.max(1)) {
                    write_row(&mut file, row)?;
                }
            }
            Ok(file)
        });
        Self { block: RowBlock::default(), sender: Some(sender), thread, waiting_time: Duration::ZERO }
    }

    fn add(&mut self, row: impl Iterator<Item = f64>) -> Result<()> {
        let before = self.block.numbers.len();
        self.block.numbers.extend(row);
        self.block.width = self.block.numbers.len() - before;
        if self.block.numbers.len() >= BLOCK_NUMBERS {
            self.send();
        }
        if self.sender.is_none() { bail!("the writer thread has stopped") } else { Ok(()) }
    }

    fn send(&mut self) {
        let empty = RowBlock { numbers: Vec::with_capacity(BLOCK_NUMBERS + self.block.width), width: 0 };
        let block = std::mem::replace(&mut self.block, empty);
        let start = Instant::now();
        self.sender = self.sender.take().filter(|sender| sender.send(block).is_ok());
        self.waiting_time += start.elapsed();
    }

    /// Returns the file with all rows, and the time for which the computation has waited for the writer thread.
    fn finish(mut self) -> std::io::Result<(AtomicFile, Duration)> {
        self.send();
        self.sender = None;
        let start = Instant::now();
        let file = self.thread.join().map_err(|_| std::io::Error::other("the writer thread panicked"))??;
        Ok((file, self.waiting_time + start.elapsed()))
    }
}

fn header(plant: &Plant) -> String {
    motion::columns(plant).iter().map(|name| quoted(name)).collect::<Vec<_>>().join(",")
}

fn write_row(file: &mut AtomicFile, row: &[f64]) -> std::io::Result<()> {
    let Some((time, numbers)) = row.split_first() else { return Ok(()) };
    write!(file, "{time:.9e}")?;
    for x in numbers {
        write!(file, ",{x:.16e}")?;
    }
    writeln!(file)
}

fn print(summary: &Summary, notes: &[String], format: Format, error: Option<f64>) -> Result<()> {
    let mut out = super::standard_output(format);
    let ([x, y, z], [mean_x, mean_y, mean_z]) = (summary.peak_to_peak_um, summary.mean_um);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(summary)?)?,
        Format::Csv => {
            writeln!(out, "samples,rate_hz,steps_per_sample,u_um_pp,v_um_pp,w_um_pp,u_um_mean,v_um_mean,w_um_mean")?;
            let Summary { samples, rate_hz, steps_per_sample, .. } = summary;
            let steps_per_sample = steps_per_sample.map_or_else(String::new, |steps| steps.to_string());
            writeln!(out, "{samples},{rate_hz},{steps_per_sample},{x},{y},{z},{mean_x},{mean_y},{mean_z}")?;
        }
        Format::Text => {
            writeln!(
                out,
                "{}: {} at {} Hz{}",
                summary.scene,
                counted(summary.samples, "sample"),
                summary.rate_hz,
                summary.steps_per_sample.map_or_else(String::new, |steps| {
                    format!(", {} per sample", counted(u64::from(steps), "integration step"))
                })
            )?;
            writeln!(out, "Centre of mass, um peak to peak: X {x:.4}, Y {y:.4}, Z {z:.4}")?;
            writeln!(out, "                um mean:         X {mean_x:.4}, Y {mean_y:.4}, Z {mean_z:.4}")?;
            writeln!(
                out,
                "Computed in {:.2} s, {:.*} times real time.",
                summary.computing_seconds,
                if summary.times_real_time < 1.0 { 3 } else { 1 },
                summary.times_real_time
            )?;
            if let Some(rotor) = &summary.rotor {
                writeln!(out, "{}", report::reduced_rotor(rotor))?;
            }
            if let Some(multibody) = &summary.multibody {
                write!(out, "{}", multibody.text)?;
            }
            for note in notes {
                writeln!(out, "{note}")?;
            }
            print_effects(&mut out, &summary.significance, error)?;
            if let Some(recording) = &summary.recording {
                writeln!(out, "Recording: {recording}")?;
            }
            writeln!(out, "Written: {}", summary.output)?;
        }
    }
    Ok(out.flush()?)
}
