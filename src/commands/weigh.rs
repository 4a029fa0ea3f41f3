//! `sketchmatch weigh`: the answers to cases whose truth is known beside the best of the attempts that were weighed, and
//! the weights that would choose better.

use std::path::PathBuf;

use clap::Args;

use super::printed;
use sketchmatch::alignment::{DOUBT_NAMES, Terms, WEIGHTS};
use sketchmatch::fitting::cases::of_folder;
use sketchmatch::fitting::confidence::{self, confidence};
use sketchmatch::fitting::weights::{chosen, fitted};
use sketchmatch::fitting::{Judged, judged};
use sketchmatch::pipeline::outcome::Rating;

#[derive(Debug, Args)]
pub struct WeighOptions {
    /// Folders of cases: of silhouettes with `truth.json`, or with `cases.json` and `meshes.json`.
    #[arg(required = true)]
    folders: Vec<PathBuf>,
    /// Fits weights to the half of the cases that is not held back, and what is trusted to all.
    #[arg(long, env = "SKETCHMATCH_FIT")]
    fit: bool,
    /// Also prints the means where each term in turn says nothing.
    #[arg(long, env = "SKETCHMATCH_WITHOUT")]
    without: bool,
}

/// Prints a line per case and the means, of what is held back by themselves.
///
/// # Errors
/// A case that cannot be read or laid.
pub fn run(options: &WeighOptions) -> anyhow::Result<()> {
    let folders: Result<Vec<_>, _> = options.folders.iter().map(|folder| of_folder(folder)).collect();
    let cases: Vec<_> = folders?.into_iter().flatten().collect();
    let judged = judged(&cases)?;
    for case in &judged {
        let answer = case.attempts.first().map_or(f64::NAN, |answer| answer.error);
        printed(&format!("{:58} {answer:.3}, best of {} {:.3}", case.name, case.attempts.len(), case.best()))?;
    }
    means(&judged, "as it is", &WEIGHTS)?;
    if options.without {
        for (i, name) in Terms::NAMES.iter().enumerate() {
            let mut weights = WEIGHTS;
            weights[i] = 0.0;
            means(&judged, &format!("without {name}"), &weights)?;
        }
    }
    if options.fit {
        let weights = fitted(judged.iter().filter(|case| !case.held_back));
        for (name, weight) in Terms::NAMES.iter().zip(&weights) {
            printed(&format!("{name:12} {weight:.3}"))?;
        }
        means(&judged, "fitted", &weights)?;
        trusted(&judged)?;
    }
    Ok(())
}

/// Prints how far answers are to be trusted, fitted to all cases, and how cases were rated by what was fitted to the other
/// half.
fn trusted(judged: &[Judged]) -> anyhow::Result<()> {
    let of_half = |held_back: bool| judged.iter().filter(move |case| case.held_back == held_back);
    let (Some(all), Some(first), Some(second)) =
        (confidence::fitted(judged.iter()), confidence::fitted(of_half(false)), confidence::fitted(of_half(true)))
    else {
        return Ok(());
    };
    printed(&format!("{:?}\n{all:#?}", DOUBT_NAMES))?;
    let rated = of_half(true).map(|case| (case, &first)).chain(of_half(false).map(|case| (case, &second)));
    let rated: Vec<_> = rated.map(|(case, fitted)| (case, Rating::of(confidence(case, fitted)))).collect();
    for rating in [Rating::High, Rating::Medium, Rating::Low] {
        let errors: Vec<f64> = rated
            .iter()
            .filter(|(_, of)| *of == rating)
            .filter_map(|(case, _)| Some(case.attempts.first()?.error))
            .collect();
        let above = |limit: f64| errors.iter().filter(|&&error| error > limit).count();
        printed(&format!(
            "rated {rating:?} by the other half: {}, mean error {:.3}, {} above 0.15, {} above 0.3",
            errors.len(),
            errors.iter().sum::<f64>() / errors.len().max(1) as f64,
            above(0.15),
            above(0.3)
        ))?;
    }
    Ok(())
}

/// Mean errors by folder: of the attempts that the weights choose, and of the best ones.
fn means(judged: &[Judged], title: &str, weights: &[f64]) -> anyhow::Result<()> {
    let mut sets: Vec<&str> = judged.iter().map(|case| case.set.as_str()).collect();
    sets.dedup();
    for set in sets {
        for held_back in [false, true] {
            let cases: Vec<&Judged> =
                judged.iter().filter(|case| case.set == set && case.held_back == held_back).collect();
            let mean =
                |of: &dyn Fn(&Judged) -> f64| cases.iter().map(|case| of(case)).sum::<f64>() / cases.len() as f64;
            let (answer, best) = (mean(&|case| chosen(case, weights)), mean(&Judged::best));
            let half = if held_back { "held back" } else { "fitted to" };
            printed(&format!("{title}: {set}, {half}, {} cases: {answer:.3}, best {best:.3}", cases.len()))?;
        }
    }
    Ok(())
}
