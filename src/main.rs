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
            let _ = writeln!(stderr(), "sketchmatch: {}", told(&error));
            ExitCode::FAILURE
        }
    }
}

/// What went wrong and what caused it, each said once: errors of libraries often repeat their causes.
fn told(error: &anyhow::Error) -> String {
    let causes = error.chain().map(ToString::to_string);
    causes
        .reduce(|told, cause| if told.contains(&cause) { told } else { format!("{told}: {cause}") })
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use anyhow::Context;

    use super::*;

    #[test]
    fn a_cause_is_told_once() {
        let cause = Err::<(), _>(anyhow::anyhow!("no such bucket")).context("404: no such bucket");
        let error = cause.context("blobs cannot be read").unwrap_err();
        assert_eq!(told(&error), "blobs cannot be read: 404: no such bucket");
    }
}
