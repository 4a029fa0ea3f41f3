//! `sketchmatch evaluate`: a result judged by what is known.

use std::io::{Write, stderr};
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use clap::Args;

use super::matching::reasons;
use super::output::Output;
use super::{printed, read};
use sketchmatch::evaluation::truth::Truth;
use sketchmatch::evaluation::{Evaluation, Known};
use sketchmatch::export::evaluation::{csv, plot_of};
use sketchmatch::intake::{self, Fault, Untaken, json};
use sketchmatch::mesh::formats::Limits;
use sketchmatch::picture::plot;
use sketchmatch::pipeline::outcome::MatchResult;

#[derive(Debug, Args)]
pub struct EvaluateOptions {
    /// The result of a match as JSON.
    result: PathBuf,
    /// What is known, as JSON: a truth as the examples have it, or `{"pairs": …}` or `{"labels": …}` as the service takes it.
    truth: PathBuf,
    /// The mesh that was matched [default: that which the result names].
    #[arg(long, env = "SKETCHMATCH_MESH")]
    mesh: Option<PathBuf>,
    /// Where the evaluation goes, by the file's ending: .json, .csv, or of pairs .svg or .png for the curves [default: JSON on
    /// standard output].
    #[arg(short, long, env = "SKETCHMATCH_OUTPUT", value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Judges a result, writes the evaluation, and says in a line on standard error what it is worth.
///
/// # Errors
/// A file that cannot be read or written, and what does not fit, with every reason.
pub fn run(options: &EvaluateOptions) -> anyhow::Result<()> {
    let result: MatchResult =
        json::parsed(&read(&options.result)?).map_err(|untaken| reasons(&options.result, &untaken))?;
    let known = known(&options.truth)?;
    let path = options.mesh.clone().unwrap_or_else(|| PathBuf::from(&result.mesh));
    let solid = read(&path).context("the mesh that was matched is told by --mesh")?;
    let name = path.file_name().and_then(|name| name.to_str());
    let mesh = intake::mesh::format(&solid, None, None, name)
        .and_then(|format| intake::mesh::taken(&solid, format, &Limits::default()))
        .map_err(|untaken| reasons(&path, &untaken))?
        .mesh;
    let (at, to): (Vec<[f64; 2]>, Vec<u32>) = result.correspondences.iter().map(|c| (c.point, c.mesh_vertex)).unzip();
    let vertices = mesh.positions().len();
    if let Some(vertex) = to.iter().find(|vertex| **vertex as usize >= vertices) {
        bail!("{} names vertex {vertex}, and {} has {vertices}", options.result.display(), path.display());
    }
    let faults = known.faults(&at, vertices);
    if !faults.is_empty() {
        let faults = faults.into_iter().map(|fault| Fault::at_pointer(fault.pointer, fault.detail)).collect();
        return Err(reasons(&options.truth, &Untaken::unacceptable("the result cannot be judged by that", faults)));
    }
    let taken = [&options.result, &options.truth, &path].map(PathBuf::as_path);
    let output = options.output.as_deref().map(|path| Output::open(path, &taken)).transpose()?;
    let found = known.evaluation(&mesh, &at, &to);
    match (output, options.output.as_deref()) {
        (Some(output), Some(path)) => output.write(&written(&found, path)?)?,
        _ => printed(&serde_json::to_string(&found)?)?,
    }
    // The evaluation is written: that nobody reads this line changes nothing.
    let _ = writeln!(stderr(), "{}: {}", options.result.display(), summary(&found));
    Ok(())
}

/// What a file says is known.
fn known(path: &Path) -> anyhow::Result<Known> {
    let bytes = read(path)?;
    let refused = |untaken: Untaken| reasons(path, &untaken);
    let value: serde_json::Value = json::parsed(&bytes).map_err(refused)?;
    if value.get("points").is_some() {
        return Ok(Known::Pairs(json::parsed::<Truth>(&bytes).map_err(refused)?));
    }
    json::parsed(&bytes).map_err(refused)
}

/// The file of an evaluation in the form its name says.
fn written(found: &Evaluation, path: &Path) -> anyhow::Result<Vec<u8>> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    Ok(match (ending.as_str(), found) {
        ("json", _) => serde_json::to_vec(found)?,
        ("csv", _) => csv(found).to_vec(),
        ("svg", Evaluation::Pairs(pairs)) => plot::svg(&[plot_of(pairs)], 1).into_bytes(),
        ("png", Evaluation::Pairs(pairs)) => plot::png(&[plot_of(pairs)], 1)?,
        _ => bail!("an evaluation is a file that ends in .json or .csv, or of pairs in .svg or .png"),
    })
}

/// What an answer is worth, in a line.
fn summary(found: &Evaluation) -> String {
    match found {
        Evaluation::Pairs(pairs) => format!(
            "mean error {:.3} held to {}, {:.3} held to the nearest variant, AUC {:.3}, {} points",
            pairs.coherent.mean,
            pairs.best,
            pairs.pointwise.mean,
            pairs.coherent.auc,
            pairs.points.len()
        ),
        Evaluation::Labels(labels) => {
            format!("{} of {} points in the right region", labels.right, labels.points)
        }
    }
}
