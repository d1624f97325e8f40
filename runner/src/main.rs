//! Entry point of the program `ballrace`; the commands are in [`ballrace_runner::cli`].
#![forbid(unsafe_code)]

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    ballrace_runner::cli::run(&ballrace_runner::cli::Cli::parse())
}
