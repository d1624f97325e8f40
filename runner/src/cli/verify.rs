//! `ballrace verify`: bakes the scene of a baked file again and compares.

use super::Format;
use anyhow::{Result, bail};
use ballrace_twin::bake::verify::{Difference, Verification, verify};
use ballrace_twin::output::cell_text;
use ballrace_twin::printable;
use std::io::Write;
use std::path::PathBuf;

/// Arguments of `verify`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// File that `bake` has written.
    file: PathBuf,
    /// Compare with this scene instead of the text in the file; files that the scene names are relative to its folder.
    #[arg(long, value_name = "SCENE.toml")]
    scene: Option<PathBuf>,
}

/// Largest number of differences in text format.
const MAX_LINES: usize = 20;

/// Runs the command.
///
/// # Errors
/// Returns an error if the file cannot be read, or if it differs from its scene.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let found = verify(&args.file, args.scene.as_deref())?;
    print(&found, args, format)?;
    match found.differences.len() {
        0 => Ok(()),
        count => bail!("{}: constants differ from the scene: {count} differences, expected none", args.file.display()),
    }
}

fn print(found: &Verification, args: &Args, format: Format) -> Result<()> {
    let mut out = super::standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(found)?)?,
        Format::Csv => print_csv(&mut out, &found.differences)?,
        Format::Text => print_text(&mut out, found, args)?,
    }
    Ok(out.flush()?)
}

fn print_csv(out: &mut impl Write, differences: &[Difference]) -> Result<()> {
    let mut writer = ::csv::Writer::from_writer(out);
    writer.write_record(["file", "part", "name", "line", "found", "expected"])?;
    for Difference { file, part, name, line, found, expected } in differences {
        let line = line.map_or(String::new(), |line| line.to_string());
        let [found, expected] = [found, expected].map(|text| text.as_deref().unwrap_or_default());
        let cells = [&file.display().to_string(), part.name(), name, &line, found, expected];
        writer.write_record(cells.map(|text| cell_text(text).into_owned()))?;
    }
    Ok(writer.flush()?)
}

fn print_text(out: &mut impl Write, found: &Verification, args: &Args) -> Result<()> {
    let Verification { program, this_program, scene, scene_hash, crc32, fields, constants, checksums, differences } =
        found;
    let file = args.file.display();
    if program != this_program {
        writeln!(out, "{file}: written by {program}, compared by {this_program}: bake the scene again")?;
    }
    for Difference { file, part, name, line, found, expected } in differences.iter().take(MAX_LINES) {
        let line = line.map_or(String::new(), |line| format!(":{line}"));
        let [found, expected] = [found, expected].map(|text| text.as_deref().unwrap_or("nothing"));
        writeln!(out, "{}{line}: {} {name}: {found}, expected {expected}", file.display(), part.name())?;
    }
    if differences.len() > MAX_LINES {
        writeln!(out, "and {} more", differences.len() - MAX_LINES)?;
    }
    if differences.is_empty() {
        writeln!(out, "{file}: equal to its scene: {fields} fields of the certificate, {constants} constants")?;
        writeln!(out, "Scene {}: SHA-256 {scene_hash}", printable::name(scene))?;
        if let Some(crc32) = crc32 {
            writeln!(out, "Blob: CRC-32 {crc32}")?;
        }
        for checksum in checksums {
            writeln!(out, "Bearing {}: checksum {}", checksum.bearing, checksum.checksum)?;
        }
    }
    Ok(())
}
