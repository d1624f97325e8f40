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

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_str!(concat!("../../scenes/", $name, ".toml")))),*]
    };
}

/// Names and texts of the scenes.
pub const SCENES: [(&str, &str); 12] = shipped![
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
    "two-spring-rotor",
    "wang-angular-pair",
];

/// Returns the first sentence of a scene's opening comment, which describes the scene.
fn shows(text: &str) -> String {
    let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix("# ")).collect();
    let comment = comment.join(" ");
    let end = [". ", ": "].iter().filter_map(|stop| comment.find(stop)).min();
    comment.get(..end.unwrap_or(comment.len())).unwrap_or(&comment).to_owned()
}

#[derive(Serialize)]
struct Shipped {
    name: &'static str,
    shows: String,
}

/// Runs the command.
///
/// # Errors
/// Returns an error if no scene has that name.
pub fn run(args: &Args, format: Format) -> Result<()> {
    let mut out = std::io::stdout().lock();
    if let Some(wanted) = &args.name {
        let Some((_, text)) = SCENES.iter().find(|(name, _)| name == wanted) else {
            let names: Vec<&str> = SCENES.iter().map(|(name, _)| *name).collect();
            bail!(UsageError(format!("scenes: found {wanted:?}, allowed: {}", names.join(", "))));
        };
        write!(out, "{text}")?;
        return Ok(out.flush()?);
    }
    let all = SCENES.map(|(name, text)| Shipped { name, shows: shows(text) });
    match format {
        Format::Json => writeln!(out, "{}", serde_json::to_string_pretty(&all)?)?,
        Format::Csv => {
            writeln!(out, "name,shows")?;
            for one in &all {
                writeln!(out, "{},\"{}\"", one.name, one.shows.replace('"', "\"\""))?;
            }
        }
        Format::Text => {
            writeln!(out, "Scenes that come with the program; `ballrace scenes NAME > NAME.toml` writes one down.\n")?;
            for one in &all {
                writeln!(out, "{:24}{}", one.name, one.shows)?;
            }
        }
    }
    Ok(out.flush()?)
}
