//! `ballrace man`: manual pages in roff.

use super::Cli;
use crate::error::UsageError;
use anyhow::{Result, bail};
use clap::CommandFactory;
use std::io::Write;

/// Arguments of `man`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Subcommand to describe [default: the program].
    #[arg(value_name = "COMMAND")]
    pub subcommand: Option<String>,
}

/// Prints a manual page to standard output.
///
/// # Errors
/// Returns an error if the subcommand does not exist or standard output cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let mut program = Cli::command();
    program.build();
    let page = match &args.subcommand {
        None => program,
        Some(name) => {
            let names: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
            let names = names.join(", ");
            let Some(subcommand) = program.find_subcommand(name) else {
                bail!(UsageError(format!("man: unknown command: {name:?}, expected one of {names}")));
            };
            subcommand.clone()
        }
    };
    let mut roff = Vec::new();
    clap_mangen::Man::new(page).render(&mut roff)?;
    let mut out = std::io::stdout().lock();
    out.write_all(&roff)?;
    Ok(out.flush()?)
}
