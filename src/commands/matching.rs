//! `sketchmatch match`: two files matched without a server.

use std::io::{Write, stderr};
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{anyhow, bail};
use clap::Args;
use serde_json::{Value, json};

use super::output::Output;
use super::{printed, read};
use sketchmatch::export::picture::{self, Form};
use sketchmatch::intake::mesh::MeshMeasures;
use sketchmatch::intake::{self, Untaken, json, svg_reader};
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::numerics::Cancelled;
use sketchmatch::pipeline::outcome::{MatchResult, Rating};
use sketchmatch::pipeline::request::MatchRequest;
use sketchmatch::pipeline::{self, Computing, Settings, Stage, Surroundings, Watcher};
use sketchmatch::sketch;

#[derive(Debug, Args)]
pub struct MatchOptions {
    /// JSON outline, SVG, PNG or JPEG.
    sketch: PathBuf,
    /// OBJ, OFF, PLY, STL, GLB or glTF.
    mesh: PathBuf,
    /// A match request as JSON; `mesh` and `sketch` may be left out.
    #[arg(long, env = "SKETCHMATCH_REQUEST")]
    request: Option<PathBuf>,
    /// Where the result goes [default: standard output].
    #[arg(short, long, env = "SKETCHMATCH_OUTPUT")]
    output: Option<PathBuf>,
    /// Where a picture of the match goes, by the file's ending: .png, .svg, or .glb for the coloured mesh.
    #[arg(long, env = "SKETCHMATCH_PICTURE", value_name = "FILE", value_parser = picture_file)]
    picture: Option<PictureFile>,
}

/// A file for a picture, in the form its name says.
#[derive(Clone, Debug)]
pub struct PictureFile {
    pub path: PathBuf,
    pub form: Form,
}

pub(super) fn picture_file(path: &str) -> Result<PictureFile, String> {
    let path = PathBuf::from(path);
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    let form = match ending.as_str() {
        "png" => Form::Png,
        "svg" => Form::Svg,
        "glb" => Form::Glb,
        _ => return Err("a picture is a file that ends in .png, .svg or .glb".to_owned()),
    };
    Ok(PictureFile { path, form })
}

/// Matches two files, writes the result, and says in a line on standard error what came of it.
///
/// # Errors
/// A file that cannot be read, written or matched, with every reason.
pub fn run(options: &MatchOptions) -> anyhow::Result<()> {
    let (drawing, solid) = (read(&options.sketch)?, read(&options.mesh)?);
    check_order(options, &drawing, &solid)?;
    let [output, picture] = outputs(options)?;
    let (limits, reader) = (sketch::Config::default(), svg_reader::this_program()?);
    let sketch = intake::sketch::kind(&drawing, sketch_type(&options.sketch))
        .and_then(|kind| intake::sketch::taken(&drawing, kind, (None, 0), &limits, Some(&reader)))
        .map_err(|untaken| reasons(&options.sketch, &untaken))?;
    let mesh_name = options.mesh.file_name().and_then(|name| name.to_str());
    let (mesh, up) = intake::mesh::format(&solid, None, None, mesh_name)
        .and_then(|format| {
            let mesh = intake::mesh::taken(&solid, format, &Limits::default())?;
            let up = MeshMeasures::of(&mesh, format).up;
            Ok((mesh, up))
        })
        .map_err(|untaken| reasons(&options.mesh, &untaken))?;
    let settings = settings(options, sketch.sketch.mesh().positions().len(), mesh.mesh.positions().len())?.standing(up);
    let started = Instant::now();
    let clock = || started.elapsed().as_secs_f64() * 1e3;
    let surroundings =
        Surroundings { spectra: &Computing, preparations: &Computing, watcher: &Logged, clock: &clock, preview: None };
    let result = pipeline::run(&sketch.sketch, &mesh.mesh, &settings, &surroundings)?;
    let text = serde_json::to_string(&result)?;
    match output {
        Some(output) => output.write(text.as_bytes())?,
        None => printed(&text)?,
    }
    if let Some((PictureFile { form, .. }, output)) = options.picture.as_ref().zip(picture) {
        output.write(&picture::file((*form).into(), text.as_bytes(), &sketch.sketch, &mesh.mesh)?)?;
    }
    let of_sketch = sketch.warnings.iter().map(|warning| format!("{}: {}", options.sketch.display(), warning.detail));
    let of_mesh = mesh.warnings.iter().map(|warning| format!("{}: {}", options.mesh.display(), warning.detail));
    let warnings = of_sketch.chain(of_mesh).chain(result.warnings.iter().cloned());
    let report: String = warnings.map(|warning| format!("warning: {warning}\n")).collect();
    // The result is written: that nobody reads this line changes nothing.
    let _ = writeln!(stderr(), "{report}{}", summary(options, &result));
    Ok(())
}

/// Refuses a mesh in the place of the sketch and a drawing in that of the mesh.
fn check_order(options: &MatchOptions, drawing: &[u8], solid: &[u8]) -> anyhow::Result<()> {
    const ORDER: &str = "the sketch comes first and then the mesh: sketchmatch match SKETCH MESH";
    if is_mesh(&options.sketch, drawing) {
        bail!("{} is a mesh; {ORDER}", options.sketch.display());
    }
    if is_drawing(&options.mesh, solid) {
        bail!("{} is a drawing; {ORDER}", options.mesh.display());
    }
    if !is_mesh(&options.mesh, solid) {
        bail!("neither name nor content of {} tell of a mesh: OBJ, OFF, PLY, STL, GLB or glTF", options.mesh.display());
    }
    Ok(())
}

fn is_mesh(path: &Path, bytes: &[u8]) -> bool {
    !is_drawing(path, bytes) && (mesh_format(path).is_some() || Format::sniff(bytes).is_some())
}

fn mesh_format(path: &Path) -> Option<Format> {
    Format::from_name(path.extension()?.to_str()?)
}

fn is_drawing(path: &Path, bytes: &[u8]) -> bool {
    let by_content =
        matches!(bytes.trim_ascii_start(), [b'<', ..] | [0x89, b'P', b'N', b'G', ..] | [0xff, 0xd8, 0xff, ..]);
    mesh_format(path).is_none() && (sketch_type(path).is_some() || by_content)
}

/// The media type of a sketch by its file's name; nothing where the bytes have to tell.
pub(super) fn sketch_type(path: &Path) -> Option<&'static str> {
    match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "json" => Some("application/json"),
        "svg" => Some("image/svg+xml"),
        "png" => Some("image/png"),
        "jpg" | "jpeg" => Some("image/jpeg"),
        _ => None,
    }
}

/// The files of the result and of the picture, where they are wanted: different ones, and none that is read.
fn outputs(options: &MatchOptions) -> anyhow::Result<[Option<Output>; 2]> {
    let mut taken: Vec<&Path> = vec![&options.sketch, &options.mesh];
    taken.extend(options.request.as_deref());
    let output = options.output.as_deref().map(|path| Output::open(path, &taken)).transpose()?;
    taken.extend(options.output.as_deref());
    let picture = options.picture.as_ref().map(|picture| Output::open(&picture.path, &taken)).transpose()?;
    Ok([output, picture])
}

/// The settings of the request file, or of the empty request, for shapes of these many vertices.
fn settings(options: &MatchOptions, sketch_vertices: usize, mesh_vertices: usize) -> anyhow::Result<Settings> {
    let path = options.request.as_deref().unwrap_or(Path::new("request"));
    let refused = |untaken: Untaken| reasons(path, &untaken);
    let text = options.request.as_deref().map_or_else(|| Ok(b"{}".to_vec()), read)?;
    let mut request: Value = json::parsed(&text).map_err(refused)?;
    for (field, file) in [("sketch", &options.sketch), ("mesh", &options.mesh)] {
        if let Some(request) = request.as_object_mut() {
            request.entry(field).or_insert_with(|| json!(file.to_string_lossy()));
        }
    }
    let request: MatchRequest = json::parsed(request.to_string().as_bytes()).map_err(refused)?;
    let faults = match Settings::resolve(&request) {
        Ok(settings) => {
            let faults = pipeline::check(&settings, sketch_vertices, mesh_vertices);
            if faults.is_empty() {
                return Ok(settings);
            }
            faults
        }
        Err(faults) => faults,
    };
    let faults = faults.into_iter().map(Into::into).collect();
    Err(refused(Untaken::unacceptable("the match cannot be carried out as asked", faults)))
}

/// A refusal as people read it: a line per reason.
pub(super) fn reasons(path: &Path, untaken: &Untaken) -> anyhow::Error {
    let reasons = untaken.faults.iter().map(|fault| {
        let place = fault.pointer.as_deref().or(fault.place.as_deref()).unwrap_or_default();
        let place = if place.is_empty() { String::new() } else { format!("{place}: ") };
        format!("\n  {place}{}", fault.detail)
    });
    anyhow!("{}: {}{}", path.display(), untaken.detail, reasons.collect::<String>())
}

/// What came of a match, in a line.
fn summary(options: &MatchOptions, result: &MatchResult) -> String {
    let rating = match result.rating {
        Some(Rating::High) => "rated high",
        Some(Rating::Medium) => "rated medium",
        Some(Rating::Low) => "rated low",
        None => "not rated",
    };
    let seconds = result.timings_ms.get("total").map_or(0.0, |total| total / 1e3);
    let mut line = format!(
        "{} matched to {}: {rating}, confidence {:.3}, {} points in {seconds:.1} s",
        options.sketch.display(),
        options.mesh.display(),
        result.confidence,
        result.correspondences.len()
    );
    let picture = options.picture.as_ref().map(|picture| &picture.path);
    for (what, path) in [("result", options.output.as_ref()), ("picture", picture)] {
        if let Some(path) = path {
            line += &format!("; {what} written to {}", path.display());
        }
    }
    line
}

/// Logs the stages and never cancels.
struct Logged;

impl Watcher for Logged {
    fn proceed(&self, stage: Stage, fraction: f64) -> Result<(), Cancelled> {
        tracing::debug!(?stage, fraction);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_in_the_form_its_name_says() {
        let form = |file: &str| picture_file(file).map(|picture| picture.form);
        assert_eq!((form("a/b.png"), form("b.SVG"), form("b.c.glb")), (Ok(Form::Png), Ok(Form::Svg), Ok(Form::Glb)));
        for file in ["b.jpg", "png", ".png", "b.", ""] {
            assert!(form(file).unwrap_err().contains(".png, .svg or .glb"), "{file}");
        }
    }

    #[test]
    fn drawings_and_meshes_are_told_apart_by_name_or_content() {
        let (obj, svg) = (b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".as_slice(), b"<svg/>".as_slice());
        for (path, bytes, mesh, drawing) in [
            ("a.obj", obj, true, false),
            ("a", obj, true, false),
            ("a.svg", svg, false, true),
            ("a", svg, false, true),
            ("a.json", b"{}", false, true),
            ("a.txt", b"Dear Sir", false, false),
        ] {
            assert_eq!(
                (is_mesh(Path::new(path), bytes), is_drawing(Path::new(path), bytes)),
                (mesh, drawing),
                "{path}"
            );
        }
    }
}
