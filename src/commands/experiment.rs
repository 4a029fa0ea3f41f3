//! `sketchmatch experiment`: the experiments of the thesis again.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::{Args, ValueEnum};

use super::evaluate_all::progress;
use super::printed;
use sketchmatch::example;
use sketchmatch::experiments::chapter4::{files, parts};
use sketchmatch::experiments::figures::{eigenfunctions, pairs, rebuilding};
use sketchmatch::experiments::run::{Case, Record, run as carried_out};
use sketchmatch::experiments::tables::{summaries, summary_text};

#[derive(Debug, Args)]
pub struct ExperimentOptions {
    /// Which one.
    experiment: Experiment,
    /// The folder for records, tables and figures; what is there already is not done again.
    dir: PathBuf,
    /// A folder of cases as `evaluate-all` takes it [default: the example creatures].
    #[arg(long, env = "SKETCHMATCH_CASES", value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Vertices of each creature's mesh, about: 2000 to 100000.
    #[arg(long, env = "SKETCHMATCH_VERTICES", default_value_t = example::VERTICES, value_parser = super::example::vertices)]
    vertices: usize,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Experiment {
    /// Figures 4.1 to 4.5 of the thesis, all methods there are, and its figures of eigenfunctions and pairs.
    Chapter4,
}

/// Carries out what is not there yet, writes tables and figures, and prints the means.
///
/// # Errors
/// A case that cannot be read, a file that cannot be written.
pub fn run(options: &ExperimentOptions) -> anyhow::Result<()> {
    let Experiment::Chapter4 = options.experiment;
    let own = options.dir.join("cases");
    if options.cases.is_none() {
        super::example::write(&own, options.vertices)?;
    }
    let cases = Case::of_folder(options.cases.as_deref().unwrap_or(&own))?;
    let parts = parts()?;
    let bar = progress(parts.iter().map(|part| part.combinations.len()).sum::<usize>() * cases.len());
    let told = |record: &Record| {
        bar.set_message(format!("{} {}", record.names.join(" "), record.case));
        bar.inc(1);
    };
    let mut texts = Vec::new();
    for part in parts {
        let records = carried_out(&part.combinations, &cases, &options.dir.join("records").join(part.name), &told)?;
        for (name, bytes) in files(part.name, &records)? {
            write(&options.dir.join(name), &bytes)?;
        }
        texts.push(format!("{}\n{}", part.name, summary_text(&summaries(&records, |_| true))));
    }
    bar.finish_and_clear();
    let mut figures = eigenfunctions()?;
    figures.extend(cases.first().map(|case| rebuilding(&case.mesh)).transpose()?);
    figures.extend(pairs(&cases)?);
    figures.iter().try_for_each(|(name, bytes)| write(&options.dir.join(name), bytes))?;
    printed(texts.join("\n").trim_end())
}

fn write(path: &Path, bytes: &[u8]) -> anyhow::Result<()> {
    fs::write(path, bytes).with_context(|| format!("writing {}", path.display()))
}
