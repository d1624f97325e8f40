//! `ballrace new`: writes the draft of a scene.

use super::{Format, standard_output};
use crate::error::UsageError;
use anyhow::{Context, Result, bail};
use ballrace_report::catalogue;
use ballrace_twin::catalogue::find;
use ballrace_twin::check::unknown_values;
use ballrace_twin::draft::{Draft, draft};
use ballrace_twin::output::AtomicFile;
use ballrace_twin::recording::preview::preview;
use ballrace_twin::scene::edit::{dimension_of, with_values};
use ballrace_twin::scene::units::{Dimension, parse};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `new`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file to write [default: standard output].
    #[arg(short, long, value_name = "F.toml")]
    output: Option<PathBuf>,
    /// Bearing by its designation, such as 6309 or "NU205 C3", once for each bearing of the shaft.
    #[arg(long, value_name = "DESIGNATION")]
    bearing: Vec<String>,
    /// Recording whose columns the scene describes.
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// Shaft speed, such as "3000 rpm".
    #[arg(long, value_name = "S", allow_hyphen_values = true)]
    speed: Option<String>,
    /// Value of a key of the scene, such as rotor.mass="6 kg" or bearing.DE.station="-100 mm".
    #[arg(long, value_name = "KEY=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
    /// Print the bearings of the catalogue.
    #[arg(long, conflicts_with_all = ["output", "bearing", "recording", "speed", "set"])]
    list: bool,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if a bearing is not in the catalogue, the recording cannot be read, or the file exists.
pub fn run(args: &Args, format: Format) -> Result<()> {
    if args.list {
        return list(format);
    }
    let bearings = args.bearing.iter().map(|designation| find(designation));
    let bearings: Vec<_> =
        bearings.collect::<Result<_, _>>().map_err(|unknown| UsageError(format!("--bearing: {unknown}")))?;
    if bearings.is_empty() {
        bail!(UsageError("missing option --bearing, expected a designation such as --bearing 6309".to_owned()));
    }
    if let Some(speed) = &args.speed {
        parse(speed, Dimension::Speed).map_err(|e| UsageError(format!("--speed: {e}")))?;
    }
    if let Some(output) = args.output.as_deref().filter(|output| output.exists()) {
        bail!(UsageError(format!("--output: this file exists: {}, expected a new file", output.display())));
    }
    let folder = args.output.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
    let found = args.recording.as_ref().map(|path| Ok::<_, anyhow::Error>((path, preview(path)?))).transpose()?;
    let recording = match &found {
        Some((path, preview)) => Some((path_from(folder, path)?, preview)),
        None => None,
    };
    let name = args.output.as_deref().and_then(Path::file_stem);
    let name = name.map_or_else(|| "machine".to_owned(), |stem| stem.to_string_lossy().into_owned());
    let values = args.set.iter().map(|option| entry(option)).collect::<Result<Vec<_>, _>>()?;
    let text = draft(&Draft { name, speed: args.speed.clone(), bearings, recording });
    let text = with_values(&text, &values).map_err(|e| UsageError(format!("--set: {e}")))?;
    check_units(&text, args.output.as_deref().unwrap_or(Path::new("machine.toml")), &values)?;
    match &args.output {
        Some(output) => {
            AtomicFile::write(output, &text)?;
            let open = unknown_values(&text).len();
            let mut out = standard_output(Format::Text);
            writeln!(out, "Written: {}", output.display())?;
            if open > 0 {
                writeln!(out, "Values to replace, marked \"?\": {open}")?;
            }
            writeln!(out, "Next: ballrace check {}", output.display())?;
            Ok(out.flush()?)
        }
        None => Ok(write!(std::io::stdout().lock(), "{text}")?),
    }
}

fn list(format: Format) -> Result<()> {
    let mut out = standard_output(format);
    match format {
        Format::Text => out.write_all(catalogue::text().as_bytes())?,
        Format::Csv => out.write_all(catalogue::csv().as_bytes())?,
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&catalogue::rows())?)?,
    }
    Ok(out.flush()?)
}

/// Returns a path relative to `folder`, or an absolute path without a common folder.
///
/// # Errors
/// Returns an error if a path does not exist or is not UTF-8 text.
fn path_from(folder: &Path, path: &Path) -> Result<String> {
    let real = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        path.canonicalize().with_context(|| path.display().to_string())
    };
    let (folder, file) = (real(folder)?, real(path)?);
    // The root folder does not count as common.
    let common = folder.ancestors().find(|common| common.parent().is_some() && file.starts_with(common));
    let relative = common.map_or_else(
        || file.clone(),
        |common| {
            let steps = folder.components().count() - common.components().count();
            let below = file.strip_prefix(common).unwrap_or(&file);
            std::iter::repeat_n(Path::new(".."), steps).chain([below]).collect()
        },
    );
    let text = relative.to_str().with_context(|| format!("{}: a name that is not UTF-8 text", path.display()))?;
    Ok(text.to_owned())
}

/// Checks that no value is a number without a unit where the usual unit is not that of SI.
fn check_units(text: &str, file: &Path, values: &[(&str, &str)]) -> Result<(), UsageError> {
    for (key, value) in values {
        let Ok(number) = value.trim().parse::<f64>() else { continue };
        let likely = dimension_of(text, file, key).and_then(|dimension| dimension.likely_units(number));
        if let Some([first, second]) = likely {
            let value = value.trim();
            return Err(UsageError(format!(
                "--set: no unit: \"{key}={value}\", expected \"{key}={value} {first}\" or \"{key}={value} {second}\""
            )));
        }
    }
    Ok(())
}

/// Returns key and value of an option `--set`.
fn entry(option: &str) -> Result<(&str, &str), UsageError> {
    option.split_once('=').ok_or_else(|| {
        UsageError(format!("--set: no value: {option:?}, expected KEY=VALUE, such as rotor.mass=\"6 kg\""))
    })
}
