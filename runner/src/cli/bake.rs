//! `ballrace bake`: writes the bearings of a scene as Rust constants for firmware.

use super::{Format, check_distinct_paths, print_effects};
use crate::error::UsageError;
use anyhow::Result;
use ballrace_twin::bake::{Baked, bake};
use ballrace_twin::effect_significance;
use ballrace_twin::output::AtomicFile;
use ballrace_twin::scene::read::read_file;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `bake`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Rust source to write.
    #[arg(short, long, value_name = "F.rs")]
    output: PathBuf,
    /// Write this bearing only.
    #[arg(long, value_name = "NAME")]
    bearing: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if the scene is invalid or the output cannot be written.
pub fn run(args: &Args, format: Format, error: Option<f64>) -> Result<()> {
    let scene = read_file(&args.scene)?;
    check_distinct_paths(&[("--output", &args.output)], &[&args.scene])?;
    let (source, baked) = bake(&scene, args.bearing.as_deref()).map_err(UsageError::with_bearing_option)?;
    AtomicFile::write(&args.output, &source)?;
    let significance = effect_significance::of_scene(&scene)?;
    print(&baked, args, format)?;
    if format == Format::Text {
        print_effects(&mut super::standard_output(format), &significance, error)
    } else {
        Ok(())
    }
}

fn print(baked: &[Baked], args: &Args, format: Format) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(baked)?)?,
        Format::Csv => {
            writeln!(out, "bearing,module,nodes,bytes")?;
            for Baked { bearing, module, nodes, bytes } in baked {
                writeln!(out, "{bearing},{module},{nodes},{bytes}")?;
            }
        }
        Format::Text => {
            for Baked { bearing, module, nodes, bytes } in baked {
                writeln!(out, "Bearing {bearing}: module {module}, table of {nodes} nodes, {bytes} bytes of flash")?;
            }
            writeln!(out, "Written: {}", args.output.display())?;
        }
    }
    Ok(out.flush()?)
}
