//! What the program can be told to do, a file for each command.

mod eigenvalues;
mod example;
mod health;
mod matching;
mod output;
mod reading;
mod serve;
mod weigh;

use std::fs;
use std::io::{Write, stdin, stdout};
use std::path::Path;

use anyhow::Context;

use crate::config::{Cli, Command};
use crate::telemetry;
use sketchmatch::http::{openapi, svg_reader};

pub use eigenvalues::EigenvaluesOptions;
pub use example::ExampleOptions;
pub use health::HealthOptions;
pub use matching::MatchOptions;
pub use reading::ReadOptions;
pub use weigh::WeighOptions;

/// Does what the command line says.
///
/// # Errors
/// Whatever kept it from being done.
pub fn run(Cli { command, log, log_format }: Cli) -> anyhow::Result<()> {
    let log = telemetry::log(&log, log_format)?;
    match command {
        Command::Serve(options) => serve::run(&options, &log),
        Command::Match(options) => matching::run(&options),
        Command::Read(options) => reading::run(&options),
        Command::Example(options) => example::run(&options),
        Command::Eigenvalues(options) => eigenvalues::run(&options),
        Command::Weigh(options) => weigh::run(&options),
        Command::Health(options) => health::run(&options),
        Command::ReadSvg => svg_reader::serve(stdin().lock(), stdout().lock()).context("reading an SVG"),
        Command::Openapi => printed(&format!("{:#}", openapi::document())),
    }
}

/// Writes a line to standard output.
fn printed(text: &str) -> anyhow::Result<()> {
    writeln!(stdout(), "{text}").context("writing to standard output")
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("reading {}", path.display()))
}
