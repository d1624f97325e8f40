//! `ballrace schema`: the JSON schema of scenes, for editors.

use anyhow::Result;
use std::io::Write;

/// Arguments of `schema`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Prints the schema to standard output.
///
/// # Errors
/// Returns an error if standard output cannot be written.
pub fn run(_: &Args) -> Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{:#}", ballrace_twin::scene::json_schema())?;
    Ok(out.flush()?)
}
