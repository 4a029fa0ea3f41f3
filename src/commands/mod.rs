//! What the program can be told to do, a file for each command.

mod eigenvalues;
mod evaluate;
mod evaluate_all;
mod example;
mod experiment;
mod health;
mod keys;
mod matching;
mod output;
mod reading;
mod serve;
mod signals;
mod sweep;
mod weigh;
mod work;

use std::fs;
use std::future::Future;
use std::io::{Write, stdin, stdout};
use std::path::Path;
use std::time::Duration;

use anyhow::Context;
use clap::{Parser, Subcommand};
use tokio::runtime::Runtime;

use crate::config::ServeOptions;
use crate::telemetry::{self, LogFormat};
use eigenvalues::EigenvaluesOptions;
use evaluate::EvaluateOptions;
use evaluate_all::EvaluateAllOptions;
use example::ExampleOptions;
use experiment::ExperimentOptions;
use health::HealthOptions;
use keys::KeysOptions;
use matching::MatchOptions;
use reading::ReadOptions;
use sketchmatch::http::openapi;
use sketchmatch::intake::svg_reader;
use sweep::SweepOptions;
use weigh::WeighOptions;
use work::WorkOptions;

/// Matches 2D sketches to 3D meshes by functional maps.
#[derive(Debug, Parser)]
#[command(version, about)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
    /// What is logged: a level, or levels by module.
    #[arg(long, env = "SKETCHMATCH_LOG", default_value = "info", global = true)]
    pub log: String,
    #[arg(long, env = "SKETCHMATCH_LOG_FORMAT", default_value = "text", global = true)]
    pub log_format: LogFormat,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Serves the REST interface, with its workers in the process.
    Serve(Box<ServeOptions>),
    /// Makes and ends the keys of those who may use a server.
    Keys(KeysOptions),
    /// Computes what servers with the same store are asked for.
    Work(WorkOptions),
    /// Sets aside the blobs that nothing names.
    Sweep(SweepOptions),
    /// Matches a sketch to a mesh without a server.
    Match(MatchOptions),
    /// Draws what is seen in a sketch over it, without a server.
    Read(ReadOptions),
    /// Writes the example creatures, their sketches and the true correspondences.
    Example(ExampleOptions),
    /// Prints the first eigenvalues of a mesh and how exact they are.
    Eigenvalues(EigenvaluesOptions),
    /// Judges the attempts at cases whose truth is known, and fits what chooses between them.
    Weigh(WeighOptions),
    /// Judges the result of a match by what is known.
    Evaluate(EvaluateOptions),
    /// Judges a matrix of requests over cases whose truth is known.
    EvaluateAll(EvaluateAllOptions),
    /// Makes the figures of the thesis's experiments again.
    Experiment(ExperimentOptions),
    /// Tells by its exit status whether a running server takes requests.
    Health(HealthOptions),
    /// Prints the OpenAPI document.
    Openapi,
    /// Reads an SVG as another process of this program asks.
    #[command(hide = true, name = svg_reader::COMMAND)]
    ReadSvg,
}

/// Does what the command line says.
///
/// # Errors
/// Whatever kept it from being done.
pub fn run(Cli { command, log, log_format }: Cli) -> anyhow::Result<()> {
    let log = telemetry::log(&log, log_format)?;
    match command {
        Command::Serve(options) => to_its_end(serve::run(&options, &log)),
        Command::Keys(options) => keys::run(options),
        Command::Work(options) => to_its_end(work::run(&options, &log)),
        Command::Sweep(options) => sweep::run(&options),
        Command::Match(options) => matching::run(&options),
        Command::Read(options) => reading::run(&options),
        Command::Example(options) => example::run(&options),
        Command::Eigenvalues(options) => eigenvalues::run(&options),
        Command::Weigh(options) => weigh::run(&options),
        Command::Evaluate(options) => evaluate::run(&options),
        Command::EvaluateAll(options) => evaluate_all::run(&options),
        Command::Experiment(options) => experiment::run(&options),
        Command::Health(options) => health::run(&options),
        Command::ReadSvg => svg_reader::serve(stdin().lock(), stdout().lock()).context("reading an SVG"),
        Command::Openapi => printed(&format!("{:#}", openapi::document())),
    }
}

/// How long a process that ends waits for threads that still compute what was asked for by those who were not waited for.
const LEAVE: Duration = Duration::from_secs(1);

/// Does work that waits for others, to its end, and leaves what nobody waits for any more: a process that was told to stop does
/// not go on for as long as the longest request computes.
fn to_its_end(work: impl Future<Output = anyhow::Result<()>>) -> anyhow::Result<()> {
    let runtime = Runtime::new().context("starting the threads")?;
    let ended = runtime.block_on(work);
    runtime.shutdown_timeout(LEAVE);
    ended
}

/// Writes a line to standard output.
fn printed(text: &str) -> anyhow::Result<()> {
    writeln!(stdout(), "{text}").context("writing to standard output")
}

fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("reading {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn what_nobody_waits_for_is_left() {
        let (end, ended) = std::sync::mpsc::channel::<()>();
        let work = async move {
            tokio::task::spawn_blocking(move || ended.recv());
            Ok(())
        };
        to_its_end(work).unwrap();
        // It would never have ended before.
        drop(end);
    }

    #[test]
    fn every_option_has_its_variable() {
        let mut commands: Vec<clap::Command> = Cli::command().get_subcommands().cloned().collect();
        while let Some(command) = commands.pop() {
            let options =
                command.get_arguments().filter(|argument| argument.get_long().is_some_and(|long| long != "help"));
            for option in options {
                let variable = option.get_env().and_then(|name| name.to_str()).unwrap_or_default();
                assert!(variable.starts_with("SKETCHMATCH_"), "{} of {}", option.get_id(), command.get_name());
            }
            commands.extend(command.get_subcommands().cloned());
        }
    }
}
