//! `ballrace check`: draws the machine, reads the recording and lists everything that is not plausible.

use super::{Format, ReplayStatus, check_distinct_paths, standard_output};
use crate::error::UsageError;
use anyhow::{Result, bail};
use ballrace_report as report;
use ballrace_twin::check::{Checked, Implausibility, check, unknown_values};
use ballrace_twin::output::{AtomicFile, quoted};
use ballrace_twin::replay::open;
use ballrace_twin::scene::Recording;
use ballrace_twin::scene::read::{load, read_str};
use indicatif::ProgressBar;
use std::io::{IsTerminal, Write};
use std::path::PathBuf;

/// Arguments of `check`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene file.
    scene: PathBuf,
    /// Check this recording, a file or a folder, instead of the scene's own. For snapshots, the first readable file is checked.
    #[arg(long, value_name = "FILE")]
    recording: Option<PathBuf>,
    /// Drawing of the rotor with bearings, probes and unbalances.
    #[arg(long, value_name = "F.svg")]
    svg: Option<PathBuf>,
}

/// Runs the command and returns the status for the exit code.
///
/// # Errors
/// Returns an error if values of the scene are unknown or invalid, or if the recording cannot be read.
pub fn run(args: &Args, format: Format) -> Result<ReplayStatus> {
    let text = load(&args.scene)?;
    let unknown = unknown_values(&text);
    if !unknown.is_empty() {
        let list = report::check::unknown(&args.scene.display().to_string(), &unknown);
        let mut out = standard_output(Format::Text);
        out.write_all(list.as_bytes())?;
        out.flush()?;
        let (count, path) = (unknown.len(), args.scene.display());
        bail!(UsageError(format!("{path}: unknown values, marked \"?\": {count}, expected those of the machine")));
    }
    let scene = read_str(&text, &args.scene)?;
    let is_absent = |recording: &Recording| args.recording.is_none() && !recording.file.exists();
    let (reader, path) = match &scene.recording {
        None if args.recording.is_none() => (None, None),
        // The machine is drawn all the same.
        Some(recording) if is_absent(recording) => (None, None),
        _ => {
            let (reader, path) = open(&scene, args.recording.as_deref())?;
            (Some(reader), Some(path))
        }
    };
    if let Some(svg) = &args.svg {
        let inputs = [Some(args.scene.as_path()), path].into_iter().flatten().collect::<Vec<_>>();
        check_distinct_paths(&[("--svg", svg)], &inputs)?;
    }
    let file = path.and_then(|path| path.file_name()).map(|name| name.to_string_lossy().into_owned());
    let bar = if std::io::stderr().is_terminal() { ProgressBar::new(0) } else { ProgressBar::hidden() };
    let checked = check(&scene, reader, &file.unwrap_or_default(), &|read, total| {
        bar.set_length(total.unwrap_or(read));
        bar.set_position(read);
    });
    bar.finish_and_clear();
    let mut checked = checked?;
    if let Some(recording) = scene.recording.as_ref().filter(|recording| is_absent(recording)) {
        checked.implausible.push(Implausibility {
            subject: "recording.file".to_owned(),
            found: format!("{}: no such file", recording.file.display()),
            cause: "another name or folder".to_owned(),
            remedy: "the path of the recording from the folder of the scene, or --recording".to_owned(),
        });
    }
    if let Some(path) = &args.svg {
        let Some(svg) = report::check::svg(&checked) else {
            bail!(UsageError(format!("{}: no [rotor] to draw", args.scene.display())));
        };
        AtomicFile::write(path, &svg)?;
    }
    print(&checked, format)?;
    if scene.recording.as_ref().is_some_and(is_absent) {
        // States that the file does not exist.
        open(&scene, None)?;
    }
    Ok(if checked.implausible.is_empty() { ReplayStatus::Completed } else { ReplayStatus::Implausible })
}

fn print(checked: &Checked, format: Format) -> Result<()> {
    let mut out = standard_output(format);
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(checked)?)?,
        Format::Csv => {
            writeln!(out, "subject,found,cause,remedy")?;
            for one in &checked.implausible {
                let cells = [&one.subject, &one.found, &one.cause, &one.remedy].map(|cell| quoted(cell));
                writeln!(out, "{}", cells.join(","))?;
            }
        }
        Format::Text => out.write_all(report::check::text(checked).as_bytes())?,
    }
    Ok(out.flush()?)
}
