//! The program: the service, and what it does without a server.

mod commands;
mod config;
mod telemetry;

use std::io::{Write, stderr};
use std::process::ExitCode;

use clap::Parser;

use commands::Cli;

fn main() -> ExitCode {
    match commands::run(Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // Whoever closed standard error does not read why; the status tells.
            let _ = writeln!(stderr(), "sketchmatch: {error:#}");
            ExitCode::FAILURE
        }
    }
}
