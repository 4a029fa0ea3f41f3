//! `sketchmatch evaluate-all`: a matrix of requests over folders of cases whose truth is known.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::matching::reasons;
use super::{printed, read};
use sketchmatch::experiments::matrix::{Matrix, combinations};
use sketchmatch::experiments::run::{Case, Record, run as carried_out};
use sketchmatch::experiments::tables;
use sketchmatch::intake::json;
use sketchmatch::picture::plot;

/// Plots beside each other.
const COLUMNS: usize = 3;

#[derive(Debug, Args)]
pub struct EvaluateAllOptions {
    /// A folder with one for each case, with `truth.json`, a mesh (`mesh.off`, `.obj`, …) and a sketch (`sketch.json`, `.svg`, …).
    dir: PathBuf,
    /// The requests as JSON: a list of axes, each an object of named parts of a match request, of which every combination is
    /// carried out. `"regions": {"method": "truth", "count": 7}` gives regions made of the truth [default: the empty request].
    #[arg(long, env = "SKETCHMATCH_MATRIX", value_name = "FILE")]
    matrix: Option<PathBuf>,
    /// The folder for records, tables and plots; what is there already is not done again.
    #[arg(short, long, env = "SKETCHMATCH_OUTPUT", value_name = "DIR")]
    output: PathBuf,
}

/// Carries out what is not there yet, writes tables and plots, and prints the means.
///
/// # Errors
/// A case that cannot be read, a request that is none, a file that cannot be written.
pub fn run(options: &EvaluateAllOptions) -> anyhow::Result<()> {
    let matrix = match &options.matrix {
        Some(path) => json::parsed::<Matrix>(&read(path)?).map_err(|untaken| reasons(path, &untaken))?,
        None => Matrix::from([[("default".to_owned(), serde_json::Map::new())].into()]),
    };
    let combinations = combinations(&matrix)?;
    let cases = Case::of_folder(&options.dir)?;
    let bar = progress(combinations.len() * cases.len());
    let told = |record: &Record| {
        bar.set_message(format!("{} {}", record.names.join(" "), record.case));
        bar.inc(1);
    };
    let records = carried_out(&combinations, &cases, &options.output.join("records"), &told)?;
    bar.finish_and_clear();

    let all = tables::summaries(&records, |_| true);
    let mut files = vec![
        ("records.csv", tables::csv(&records).into_bytes()),
        ("summary.csv", tables::summary_csv(&all).into_bytes()),
    ];
    let of = |title: &str, side: bool| tables::plots(title, &tables::summaries(&records, |record| record.side == side));
    let plots: Vec<_> = of("side", true).into_iter().chain(of("whole", false)).collect();
    files.push(("curves.svg", plot::svg(&plots, COLUMNS).into_bytes()));
    files.push(("curves.png", plot::png(&plots, COLUMNS)?));
    for (name, bytes) in files {
        let path = options.output.join(name);
        fs::write(&path, bytes).with_context(|| format!("writing {}", path.display()))?;
    }
    printed(tables::summary_text(&all).trim_end())
}

/// A bar on standard error, where that is a terminal.
pub(super) fn progress(tasks: usize) -> ProgressBar {
    let bar = ProgressBar::new(tasks as u64);
    let style = ProgressStyle::with_template("{bar:40} {pos} of {len}, {eta} left  {wide_msg}");
    style.map_or(bar.clone(), |style| bar.with_style(style))
}
