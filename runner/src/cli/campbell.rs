//! `ballrace campbell`: natural frequencies, damping ratios and whirl directions over the shaft speed.

use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::Result;
use ballrace_report as report;
use ballrace_twin::campbell::{AtSpeed, campbell, nominal_mode_shapes};
use ballrace_twin::effect_significance;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::replay::outcome::RotorDrawing;
use ballrace_twin::scene::read::read_file;
use ballrace_twin::scene::units::Dimension;
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
    #[command(flatten)]
    pub(super) limit: super::ErrorLimit,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if scene or speeds are invalid.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    if let Some(path) = &args.report {
        check_distinct_paths(&[("--report", path)], &[&args.scene])?;
    }
    let speeds = parse_speeds(&args.speeds)?;
    let diagram = campbell(&scene, &speeds).map_err(UsageError::new)?;
    if let Some(path) = &args.report {
        let drawing = RotorDrawing::new(&scene);
        let shapes = nominal_mode_shapes(&scene).map_err(UsageError::new)?;
        AtomicFile::write(path, &report::campbell::html(&scene.name, &diagram, drawing.as_ref(), &shapes)?)?;
    }
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&diagram)?)?,
        Format::Csv => csv(&mut out, &diagram)?,
        Format::Text => {
            out.write_all(report::campbell::text(&scene.name, &diagram).as_bytes())?;
            if let Some(path) = &args.report {
                writeln!(out, "Written: {}", path.display())?;
            }
            print_effects(&mut out, &effect_significance::over_speeds(&scene, &speeds)?, error)?;
        }
    }
    Ok(out.flush()?)
}

/// Parses shaft speeds, rad/s.
fn parse_speeds(text: &str) -> Result<Vec<f64>> {
    let axis =
        Axis::parse(&format!("speed={text}")).map_err(|e| UsageError(e.to_string().replace("--over", "--speeds")))?;
    Ok(axis.in_si(Dimension::Speed).map_err(|e| UsageError(format!("--speeds: {e}")))?)
}

/// Writes one row for each mode.
fn csv(out: &mut impl Write, diagram: &[AtSpeed]) -> Result<()> {
    writeln!(out, "speed_rpm,mode,frequency_hz,damping_ratio,whirl")?;
    for at_speed in diagram {
        for (i, mode) in at_speed.modes.iter().enumerate() {
            let whirl = mode.whirl.name();
            let (number, speed) = (i + 1, at_speed.speed_rpm);
            writeln!(out, "{speed:.16e},{number},{:.16e},{:.16e},{whirl}", mode.frequency_hz, mode.damping_ratio)?;
        }
    }
    Ok(())
}
