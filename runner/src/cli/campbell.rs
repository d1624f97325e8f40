//! `ballrace campbell`: natural frequencies over the shaft's speed.

use super::{Format, keep_apart, print_effects};
use crate::error::UsageError;
use anyhow::{Result, bail};
use ballrace_report as report;
use ballrace_twin::campbell::{AtSpeed, Whirl, campbell};
use ballrace_twin::effect_significance;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::units::{Dimension, parse};
use ballrace_twin::sweep::Axis;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `campbell`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Shaft speeds: a range with a count, e.g. 0rpm..30000rpm:31, or with a step, e.g. 0rpm..30000rpm:1000rpm, or a list.
    #[arg(long, value_name = "SPEEDS", default_value = "0rpm..30000rpm:31")]
    speeds: String,
    /// HTML page with the diagram.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if scene or speeds are invalid.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    if let Some(path) = &args.report {
        keep_apart(&[("--report", path)], &[&args.scene])?;
    }
    let speeds = speeds(&args.speeds)?;
    let all = campbell(&scene, &speeds).map_err(UsageError::new)?;
    if let Some(path) = &args.report {
        AtomicFile::write(path, &report::campbell::html(&scene.name, &all)?)?;
    }
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&all)?)?,
        Format::Csv => csv(&mut out, &all)?,
        Format::Text => {
            out.write_all(report::campbell::text(&scene.name, &all).as_bytes())?;
            if let Some(path) = &args.report {
                writeln!(out, "Written: {}", path.display())?;
            }
            print_effects(&mut out, &effect_significance::of_scene(&scene)?, error)?;
        }
    }
    Ok(out.flush()?)
}

fn speeds(text: &str) -> Result<Vec<f64>> {
    let axis =
        Axis::parse(&format!("speed={text}")).map_err(|e| UsageError(e.to_string().replace("--over", "--speeds")))?;
    let one = |value: &f64| {
        if axis.unit.is_empty() {
            return Ok(*value);
        }
        parse(&format!("{value} {}", axis.unit), Dimension::Speed)
    };
    match axis.values.iter().map(one).collect() {
        Ok(speeds) => Ok(speeds),
        Err(e) => bail!(UsageError(format!("--speeds: {e}"))),
    }
}

/// Writes one row for each mode.
fn csv(out: &mut impl Write, all: &[AtSpeed]) -> Result<()> {
    writeln!(out, "speed_rpm,mode,frequency_hz,damping_ratio,whirl")?;
    for at in all {
        for (i, mode) in at.modes.iter().enumerate() {
            let whirl = match mode.whirl {
                Whirl::Forward => "forward",
                Whirl::Backward => "backward",
                Whirl::Straight => "straight",
            };
            let (f, d) = (mode.frequency_hz, mode.damping_ratio);
            writeln!(out, "{:.16e},{},{f:.16e},{d:.16e},{whirl}", at.speed_rpm, i + 1)?;
        }
    }
    Ok(())
}
