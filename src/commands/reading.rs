//! `sketchmatch read`: what is seen in a drawing, as a picture, without a server.

use std::path::PathBuf;

use anyhow::bail;
use clap::Args;

use super::matching::{PictureFile, picture_file, reasons, sketch_type};
use super::output::Output;
use super::{printed, read};
use sketchmatch::export::picture::Form;
use sketchmatch::intake::sketch::{canvas, kind, taken};
use sketchmatch::intake::{Untaken, svg_reader};
use sketchmatch::picture::WIDTH;
use sketchmatch::picture::reading::{self, Read};
use sketchmatch::sketch::{self, Imported};

#[derive(Debug, Args)]
pub struct ReadOptions {
    /// JSON outline, SVG, PNG or JPEG.
    sketch: PathBuf,
    /// Where the picture of what was seen goes, by the file's ending: .png or .svg.
    #[arg(short, long, env = "SKETCHMATCH_OUTPUT", value_name = "PICTURE", value_parser = picture_file)]
    output: PictureFile,
    /// Which figure of the drawing is taken, the largest being number 0.
    #[arg(long, env = "SKETCHMATCH_FIGURE", default_value_t = 0)]
    figure: usize,
}

/// Draws what is seen over the drawing, and prints it: a line for the figure and one for whatever was mended or left out.
///
/// # Errors
/// A file that cannot be read or written, or shows no figure, with every reason.
pub fn run(options: &ReadOptions) -> anyhow::Result<()> {
    let PictureFile { path, form } = &options.output;
    if *form == Form::Glb {
        bail!("what was read of a drawing is flat: {} has to end in .png or .svg", path.display());
    }
    let bytes = read(&options.sketch)?;
    let output = Output::open(path, &[&options.sketch])?;
    let (limits, reader) = (sketch::Config::default(), svg_reader::this_program()?);
    let refused = |untaken: Untaken| reasons(&options.sketch, &untaken);
    let kind = kind(&bytes, sketch_type(&options.sketch)).map_err(refused)?;
    let seen = taken(&bytes, kind, (None, options.figure), &limits, Some(&reader)).map_err(refused)?;
    let canvas = canvas(&bytes, kind, &limits);
    let shown = Read { canvas: canvas.as_ref(), sketch: &seen.sketch, warnings: &seen.warnings };
    output.write(&match form {
        Form::Svg => reading::svg(&shown, WIDTH)?.into_bytes(),
        _ => reading::png(&shown, WIDTH)?,
    })?;
    let warnings = seen.warnings.iter().map(|warning| format!("\nwarning: {}", warning.detail));
    printed(&format!("{}{}", summary(options, &seen), warnings.collect::<String>()))
}

/// What was seen, in a line.
fn summary(options: &ReadOptions, seen: &Imported) -> String {
    let [low, high] = seen.figures[options.figure].bounds;
    format!(
        "{}: figure {} of {}, {:.1} × {:.1} at ({:.1}, {:.1}), area {:.1}; picture written to {}",
        options.sketch.display(),
        options.figure,
        seen.figures.len(),
        high[0] - low[0],
        high[1] - low[1],
        low[0],
        low[1],
        seen.sketch.mesh().area(),
        options.output.path.display()
    )
}
