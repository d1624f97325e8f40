//! `ballrace scenes`: the scenes that come with the program.

use super::Format;
use crate::error::UsageError;
use anyhow::{Result, bail};
use serde::Serialize;
use std::io::Write;

/// Arguments of `scenes`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Scene to print, such as tiwari-balanced [default: list all scenes].
    name: Option<String>,
}

macro_rules! built_in {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../scenes/", $name, ".toml")))),*]
    };
}

/// Name and text of each scene.
pub const SCENES: [(&str, &str); 17] = built_in![
    "jones-1960",
    "tiwari-balanced",
    "tiwari-unbalanced",
    "harsha-clearance",
    "harsha-waviness",
    "harsha-cage-runout",
    "harsha-number-of-balls",
    "tomovic-unloaded",
    "lioulios-fluctuation",
    "hajzman-flexible-ring",
    "hajzman-bending-ring",
    "two-spring-rotor",
    "wang-angular-pair",
    "spindle-thermal",
    "skidding-spindle",
    "tapered-32008-pair",
    "spherical-22210-fan",
];

/// Returns the description of a scene: the first sentence of its opening comment.
fn description(text: &str) -> String {
    let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("# ")).collect();
    let comment = comment.join(" ");
    let end = [". ", ": "].iter().filter_map(|stop| comment.find(stop)).min();
    comment.get(..end.unwrap_or(comment.len())).unwrap_or(&comment).to_owned()
}

#[derive(Serialize)]
struct SceneEntry {
    name: &'static str,
    #[serde(rename = "shows")]
    description: String,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if no scene has that name.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let mut out = std::io::stdout().lock();
    if let Some(requested) = &args.name {
        let Some((_, text)) = SCENES.iter().find(|(name, _)| name == requested) else {
            let names: Vec<&str> = SCENES.iter().map(|(name, _)| *name).collect();
            bail!(UsageError(format!("scenes: unknown scene: {requested:?}, expected one of {}", names.join(", "))));
        };
        write!(out, "{text}")?;
        return Ok(out.flush()?);
    }
    let entries = SCENES.map(|(name, text)| SceneEntry { name, description: description(text) });
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&entries)?)?,
        Format::Csv => {
            writeln!(out, "name,shows")?;
            for entry in &entries {
                writeln!(out, "{},\"{}\"", entry.name, entry.description.replace('"', "\"\""))?;
            }
        }
        Format::Text => {
            writeln!(out, "Scenes that come with the program; `ballrace scenes NAME > NAME.toml` copies a scene.\n")?;
            for entry in &entries {
                writeln!(out, "{:24}{}", entry.name, entry.description)?;
            }
        }
    }
    Ok(out.flush()?)
}
